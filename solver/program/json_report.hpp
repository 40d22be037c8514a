// The report for other programs: one JSON object per matrix, each on its own line, the same keys always.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "solver/program/case_result.hpp"

namespace mfs::program {

/// name, n, nnz, backend, threads, nnz_factor, flops, flops_getrf, flops_trsm, flops_gemm, bytes_factor,
/// bytes_peak, fronts, depths, max_front, time_order, time_symbolic, time_factor, time_refactor, time_solve,
/// refinement_steps, perturbed_pivots, backward_error, status, message. Figures of a phase that was not
/// reached are 0; backward_error is null where no x was returned, and where x is not finite.
std::string json_line(const CaseResult& result);

/// A file of such lines, "-" for standard output. Opened at once, so that a wrong path is known before any
/// work.
class JsonFile {
 public:
  /// Throws InvalidInput.
  explicit JsonFile(const std::string& path);
  /// Writes and flushes one line. Throws InvalidInput.
  void write(const CaseResult& result);

 private:
  struct Closer {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace mfs::program
