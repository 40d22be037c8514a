// A solver of batches as perf_batch measures it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "ordering/stopwatch.hpp"
#include "perf/batch_case.hpp"

namespace mfs::perf {

class BatchEntrant {
 public:
  virtual ~BatchEntrant() = default;
  /// Factors and solves all systems, with the analysis that was made before. How many were not solved.
  virtual std::int64_t solve() = 0;
  /// The solutions, one system after the other, of which those that were not solved are whatever they are.
  virtual void read(double* x) = 0;
  /// Of what is made once for the pattern, the factorization of a first matrix included.
  double analysis_seconds() const { return analysis_seconds_; }

 protected:
  template <class Work>
  void analyze(const Work& work) {
    const Stopwatch watch;
    work();
    analysis_seconds_ = watch.seconds();
  }

 private:
  double analysis_seconds_ = 0;
};

/// The case must outlive what is made.
std::unique_ptr<BatchEntrant> make_klu_batch(const BatchCase& batch, int threads);
/// By the public class. With arrays on the device where the backend has them there. `leaf_size`: of the
/// ordering, 0 for the usual one; details of the analysis go to the error output where they are asked for.
struct MfsBatchOptions {
  int threads = 1;
  std::int32_t leaf_size = 0;
  bool details = false;
};
std::unique_ptr<BatchEntrant> make_mfs_batch(const BatchCase& batch, const std::string& backend,
                                             const MfsBatchOptions& asked);
/// The uniform batch of cuDSS, from the folder of libcudss, with arrays on the device and so many steps of
/// refinement. Throws std::runtime_error where this program was built without.
std::unique_ptr<BatchEntrant> make_cudss_batch(const BatchCase& batch, const std::string& folder,
                                               int refinements);

}  // namespace mfs::perf
