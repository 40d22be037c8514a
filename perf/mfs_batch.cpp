#include <algorithm>
#include <cstdio>

#include <mfs/mfs.hpp>

#include "perf/batch_entrant.hpp"
#ifdef MFS_CUDA
#include "perf/device_array.hpp"
#endif

namespace mfs::perf {

namespace {

Options options_of(const std::string& backend, const MfsBatchOptions& asked) {
  Options options;
  options.threads = asked.threads;
  if (asked.leaf_size > 0) options.analysis.leaf_size = asked.leaf_size;
  if (asked.details) {
    options.verbosity = 2;
    options.log = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  }
  for (const Backend one : {Backend::serial, Backend::openmp, Backend::cuda, Backend::kokkos}) {
    if (backend == backend_name(one)) options.backend = one;
  }
  if (backend != backend_name(options.backend)) throw InvalidInput("backend", "there is no " + backend);
  return options;
}

class MfsBatch : public BatchEntrant {
 public:
  MfsBatch(const BatchCase& batch, const Options& options)
      : batch_(batch), solver_(options), x_(batch.b.size()) {
    const CsrView<double> a{batch.a.n, batch.a.n, batch.a.offsets.data(), batch.a.column_indices.data(),
                            batch.a.values.data()};
    analyze([&] { solver_.analyze(a); });
  }
  std::int64_t solve() override {
    solver_.solve({batch_.count, batch_.values.data(), 0, batch_.b.data(), x_.data()});
    return solver_.failed();
  }
  void read(double* x) override { std::copy(x_.begin(), x_.end(), x); }

 protected:
  const BatchCase& batch_;
  BatchSolver solver_;
  std::vector<double> x_;
};

#ifdef MFS_CUDA
class MfsDeviceBatch final : public MfsBatch {
 public:
  MfsDeviceBatch(const BatchCase& batch, const Options& options)
      : MfsBatch(batch, options), values_(batch.values), b_(batch.b), there_(batch.b.size()) {}
  std::int64_t solve() override {
    solver_.solve_device({batch_.count, values_.get(), 0, b_.get(), there_.get()});
    return solver_.failed();
  }
  void read(double* x) override {
    check(cudaMemcpy(x, there_.get(), x_.size() * sizeof(double), cudaMemcpyDeviceToHost), "cudaMemcpy");
  }

 private:
  DeviceArray<double> values_, b_, there_;
};
#endif

}  // namespace

std::unique_ptr<BatchEntrant> make_mfs_batch(const BatchCase& batch, const std::string& backend,
                                             const MfsBatchOptions& asked) {
  const std::string copies = " with copies";  // arrays on the host, whatever the backend
  const bool on_host = backend.size() > copies.size() &&
                       backend.compare(backend.size() - copies.size(), copies.size(), copies) == 0;
  const Options options =
      options_of(on_host ? backend.substr(0, backend.size() - copies.size()) : backend, asked);
#ifdef MFS_CUDA
  if (!on_host && backend_info(options.backend).memory == MemorySpace::device)
    return std::make_unique<MfsDeviceBatch>(batch, options);
#endif
  return std::make_unique<MfsBatch>(batch, options);
}

}  // namespace mfs::perf
