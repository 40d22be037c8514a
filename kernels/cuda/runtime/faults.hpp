// Lets a test see what becomes of a call to CUDA, cuBLAS or cuSOLVER that fails: each is counted at its seam
// (device.cpp, device_blas.cpp, device_lapack.cpp), and the one that the test names is left out and said to
// have failed.
#pragma once

namespace mfs::cuda {

enum class CallKind { device_memory, host_memory, runtime, library };

struct Fault {
  long after;        // calls that are made before the one that fails
  long calls = 0;    // seen so far, the failing one included
  bool met = false;  // whether it has failed, and of what kind it was
  CallKind kind = CallKind::runtime;
};

/// Set by a test while no call of the library is under way; null: nothing is counted and nothing fails.
extern Fault* planned_fault;

/// Whether the call that comes next is to fail.
inline bool fails(CallKind kind) {
  if (!planned_fault || planned_fault->calls++ != planned_fault->after) return false;
  planned_fault->met = true;
  planned_fault->kind = kind;
  return true;
}

}  // namespace mfs::cuda
