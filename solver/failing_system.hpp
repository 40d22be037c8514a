// The system that a phase failed on, left in Matrix Market files for whoever asked for that
// (Options::dump_prefix). Whatever becomes of the files, the caller gets the error of the phase.
#pragma once

#include <exception>
#include <string>

#include <mfs/csr_view.hpp>
#include <mfs/error.hpp>

namespace mfs {

/// The matrix, and of a solve its right-hand sides (null: none).
template <class Scalar>
struct System {
  CsrView<Scalar> a;
  const Scalar* b = nullptr;
  std::int64_t nrhs = 0, ldb = 0;
  bool transposed = false;
};

/// Writes PREFIX_A.mtx and, where there are right-hand sides, PREFIX_b.mtx; gives back their names.
/// Throws InvalidInput.
template <class Scalar>
std::string write_system(const System<Scalar>& system, const std::string& prefix);

/// Does that with what `make_system` gives, and adds to the error's text what was written, or why nothing
/// was.
template <class MakeSystem>
void leave_behind(const MakeSystem& make_system, const std::string& prefix, Error& error) noexcept {
  try {
    try {
      error.append("; the system was written to " + write_system(make_system(), prefix));
    } catch (const Error& fault) {
      error.append("; the system was not written: " + std::string(fault.what()));
    }
  } catch (const std::exception&) {  // no memory for the note: the error itself says enough
  }
}

/// Runs `phase`. If it fails on the system that `system()` gives, this is left in files.
template <class Phase, class MakeSystem>
void run_phase(const std::string& dump_prefix, const Phase& phase, const MakeSystem& system) {
  if (dump_prefix.empty()) return phase();
  try {
    phase();
  } catch (const StateError&) {  // no fault of the system
    throw;
  } catch (Error& error) {
    leave_behind(system, dump_prefix, error);
    throw;
  }
}

}  // namespace mfs
