#include "dae/integrator/sparse_lu.hpp"

#include <umfpack.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include <mfs/error.hpp>

namespace mfs::dae {
namespace {

[[noreturn]] void fail(const char* library, bool no_memory, int status, const char* what) {
  if (no_memory) throw OutOfMemory(MemorySpace::host, 0, 0);
  throw BackendError(library, status, std::string("coordinate partitioning: ") + what);
}

}  // namespace

Pivots find_pivots(int rows, const std::vector<int>& starts, const RawVector<int>& index,
                   const std::vector<double>& values) {
  double controls[UMFPACK_CONTROL];
  umfpack_di_defaults(controls);
  controls[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_UNSYMMETRIC;  // pivots by size
  controls[UMFPACK_SCALE] = UMFPACK_SCALE_NONE;               // coordinates have scales of their own
  controls[UMFPACK_SINGLETONS] = 0;  // a coordinate of one constraint would be its pivot whatever its size
  controls[UMFPACK_PIVOT_TOLERANCE] = 0.5;
  const auto check = [](int status, const char* what) {
    if (status != UMFPACK_OK && status != UMFPACK_WARNING_singular_matrix)
      fail("UMFPACK", status == UMFPACK_ERROR_out_of_memory, status, what);
  };
  const auto free_symbolic = [](void* p) { umfpack_di_free_symbolic(&p); };
  const auto free_numeric = [](void* p) { umfpack_di_free_numeric(&p); };
  const int columns = static_cast<int>(starts.size()) - 1;
  void* made = nullptr;
  // With values, the analysis sees which entries are zero.
  check(umfpack_di_symbolic(rows, columns, starts.data(), index.data(), values.data(), &made, controls,
                            nullptr),
        "symbolic factorization");
  const std::unique_ptr<void, decltype(free_symbolic)> symbolic(made, free_symbolic);
  check(umfpack_di_numeric(starts.data(), index.data(), values.data(), symbolic.get(), &made, controls,
                           nullptr),
        "factorization");
  const std::unique_ptr<void, decltype(free_numeric)> numeric(made, free_numeric);
  const auto count = static_cast<std::size_t>(std::min(rows, columns));
  Pivots p{std::vector<int>(static_cast<std::size_t>(rows)),
           std::vector<int>(static_cast<std::size_t>(columns)), std::vector<double>(count)};
  check(umfpack_di_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, p.row.data(),
                               p.column.data(), p.value.data(), nullptr, nullptr, numeric.get()),
        "pivots");
  p.row.resize(count);
  p.column.resize(count);
  return p;
}

BlockLu::BlockLu(std::vector<int> starts, std::vector<int> index)
    : starts_(std::move(starts)), index_(std::move(index)) {
  klu_defaults(&common_);
  common_.scale = 0;  // none: the entries are scaled
  symbolic_ = klu_analyze(static_cast<int>(starts_.size()) - 1, starts_.data(), index_.data(), &common_);
  check(symbolic_ != nullptr, "analysis");
}

BlockLu::~BlockLu() {
  klu_free_numeric(&numeric_, &common_);
  klu_free_symbolic(&symbolic_, &common_);
}

bool BlockLu::factor(std::vector<double> values, PivotOrder order) {
  if (order == PivotOrder::kept && numeric_ != nullptr)
    return klu_refactor(starts_.data(), index_.data(), values.data(), symbolic_, numeric_, &common_) != 0 &&
           common_.status == KLU_OK;
  klu_free_numeric(&numeric_, &common_);
  numeric_ = klu_factor(starts_.data(), index_.data(), values.data(), symbolic_, &common_);
  if (common_.status == KLU_SINGULAR) return false;
  check(numeric_ != nullptr, "factorization");
  return true;
}

std::vector<double> BlockLu::solve(std::vector<double> b) {
  check(klu_solve(symbolic_, numeric_, symbolic_->n, 1, b.data(), &common_) != 0, "solution");
  return b;
}

std::vector<double> BlockLu::solve_transpose(std::vector<double> b) {
  check(klu_tsolve(symbolic_, numeric_, symbolic_->n, 1, b.data(), &common_) != 0, "solution");
  return b;
}

void BlockLu::check(bool good, const char* what) const {
  if (!good) fail("KLU", common_.status == KLU_OUT_OF_MEMORY, common_.status, what);
}

}  // namespace mfs::dae
