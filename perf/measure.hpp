// How perf_device takes its figures. Times are of the wall clock around a call that returns when its work is
// done; errors are computed here, from the matrix as it was given, for every solver alike.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "perf/candidate.hpp"

namespace mfs::perf {

/// The matrix of "FAMILY:SIZE" or of a file, real, with right-hand sides uniform in [-1, 1). Throws
/// InvalidInput.
System make_system(const std::string& name, int threads);

/// Largest componentwise backward error |b - A x|_i / (|A| |x| + |b|)_i, and residual |b - A x|_inf /
/// (|A|_inf |x|_inf + |b|_inf); infinite where x is not finite.
struct Errors {
  double backward = 0, residual = 0;
};
/// Of one column, for a matrix with the pattern of `a` and values of its own.
Errors column_errors(const cases::FamilyMatrix& a, const double* values, const double* b, const double* x);
/// The largest of the first `columns` columns.
Errors errors_of(const System& system, const double* x, int columns);

using MakeCandidate = std::function<std::unique_ptr<Candidate>(const System&)>;

/// Takes a solver through all phases; refactorizations and solves are repeated `repeat` times (least and
/// median are given). A solver that does not refine by itself is told to, by as few steps as bring the
/// componentwise backward error below 1e-12. A failure becomes the fields status and message.
nlohmann::ordered_json measure(const MakeCandidate& make, const System& system, int repeat);

}  // namespace mfs::perf
