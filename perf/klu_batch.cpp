#include <klu.h>
#include <omp.h>

#include <algorithm>
#include <stdexcept>

#include "perf/batch_entrant.hpp"

namespace mfs::perf {

namespace {

// The rows of A are the columns of A^T: KLU gets A^T and solves with its transpose.
class KluThread {
 public:
  KluThread(std::vector<int>& offsets, std::vector<int>& columns, double* values)
      : offsets_(offsets), columns_(columns) {
    klu_defaults(&common_);
    symbolic_ = klu_analyze(n(), offsets_.data(), columns_.data(), &common_);
    numeric_ =
        symbolic_ ? klu_factor(offsets_.data(), columns_.data(), values, symbolic_, &common_) : nullptr;
    if (!numeric_) throw std::runtime_error("KLU: status " + std::to_string(common_.status));
  }
  ~KluThread() {
    klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  KluThread(const KluThread&) = delete;
  KluThread& operator=(const KluThread&) = delete;

  bool solve(double* values, const double* b, double* x) {
    if (!klu_refactor(offsets_.data(), columns_.data(), values, symbolic_, numeric_, &common_)) return false;
    std::copy_n(b, n(), x);
    return klu_tsolve(symbolic_, numeric_, n(), 1, x, &common_) != 0;
  }

 private:
  int n() const { return static_cast<int>(offsets_.size()) - 1; }

  std::vector<int>&offsets_, &columns_;
  klu_common common_;
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

class KluBatch final : public BatchEntrant {
 public:
  KluBatch(const BatchCase& batch, int threads)
      : batch_(batch),
        x_(batch.b.size()),
        offsets_(batch.a.offsets.begin(), batch.a.offsets.end()),
        columns_(batch.a.column_indices.begin(), batch.a.column_indices.end()),
        values_(batch.a.values) {
    const auto add_thread = [&] {
      threads_.push_back(std::make_unique<KluThread>(offsets_, columns_, values_.data()));
    };
    analyze(add_thread);  // each thread has its own, which a user would do without
    while (threads_.size() < static_cast<std::size_t>(threads)) add_thread();
  }
  std::int64_t solve() override {
    const std::int64_t n = batch_.a.n, entries = offsets_.back();
    double* const values = const_cast<double*>(batch_.values.data());  // which are only read
    std::int64_t failed = 0;
#pragma omp parallel for num_threads(static_cast<int>(threads_.size())) schedule(dynamic, 8) reduction(+ : failed)
    for (std::int64_t k = 0; k < batch_.count; ++k) {
      KluThread& thread = *threads_[static_cast<std::size_t>(omp_get_thread_num())];
      failed += !thread.solve(values + k * entries, batch_.b.data() + k * n, x_.data() + k * n);
    }
    return failed;
  }
  void read(double* x) override {
    std::copy(x_.begin(), x_.end(), x);
  }

 private:
  const BatchCase& batch_;
  std::vector<double> x_;
  std::vector<int> offsets_, columns_;
  std::vector<double> values_;
  std::vector<std::unique_ptr<KluThread>> threads_;
};

}  // namespace

std::unique_ptr<BatchEntrant> make_klu_batch(const BatchCase& batch, int threads) {
  return std::make_unique<KluBatch>(batch, threads);
}

}  // namespace mfs::perf
