#include <cholmod.h>
#include <klu.h>
#include <umfpack.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "perf/host_peer.hpp"
#include "perf/peers.hpp"

namespace mfs::perf {

namespace {

using Long = SuiteSparse_long;

// Of a matrix with sorted rows. Sums of an element's entries may differ by rounding between the triangles.
bool is_symmetric(const FamilyMatrix& a) {
  double largest = 0;
  for (const double value : a.values) largest = std::max(largest, std::abs(value));
  for (std::int64_t row = 0; row < a.n; ++row) {
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const auto begin = a.column_indices.begin() + a.offsets[a.column_indices[k]];
      const auto end = a.column_indices.begin() + a.offsets[a.column_indices[k] + 1];
      const auto mirrored = std::lower_bound(begin, end, row);
      if (mirrored == end || *mirrored != row) return false;
      const double difference = a.values[mirrored - a.column_indices.begin()] - a.values[k];
      if (std::abs(difference) > 1e-13 * largest) return false;
    }
  }
  return true;
}

/// Supernodal, under METIS. Its factor entries are those of one triangle.
class Cholmod final : public HostPeer<Long> {
 public:
  explicit Cholmod(const System& system) : HostPeer(system) {
    if (!is_symmetric(system.a)) throw std::runtime_error("CHOLMOD: the matrix is not symmetric");
    cholmod_l_start(&common_);
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.print = 0;
    const auto rows = static_cast<std::size_t>(n());
    matrix_ = {rows,    rows, indices_.size(), offsets_.data(), indices_.data(), nullptr, values(),
               nullptr, 1,    CHOLMOD_LONG,    CHOLMOD_REAL,    CHOLMOD_DOUBLE,  1,       1};
  }
  ~Cholmod() override {
    cholmod_l_free_factor(&factor_, &common_);
    cholmod_l_finish(&common_);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  AnalysisTime analyze() override {
    factor_ = cholmod_l_analyze(&matrix_, &common_);
    check(factor_ != nullptr);
    return {};
  }
  void factor() override { refactor(); }
  void refactor() override {
    check(cholmod_l_factorize(&matrix_, factor_, &common_) != 0);
    if (factor_->minor < matrix_.nrow)
      throw std::runtime_error("CHOLMOD: the matrix is not positive definite");
  }
  void solve(int columns) override {
    const auto rows = matrix_.nrow, k = static_cast<std::size_t>(columns);
    cholmod_dense b{rows, k, rows * k, rows, right_hand_sides(), nullptr, CHOLMOD_REAL, CHOLMOD_DOUBLE};
    cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, factor_, &b, &common_);
    check(x != nullptr);
    std::copy_n(static_cast<const double*>(x->x), rows * k, x_.data());
    cholmod_l_free_dense(&x, &common_);
  }
  bool refine(int) override { return false; }
  Facts facts() override {
    Facts facts = facts_of("CHOLMOD " + std::to_string(CHOLMOD_MAIN_VERSION) + "." +
                           std::to_string(CHOLMOD_SUB_VERSION));
    facts.factor_entries = static_cast<std::int64_t>(common_.lnz);
    facts.flops = common_.fl;
    facts.device_bytes = static_cast<std::int64_t>(common_.memory_usage);
    return facts;
  }

 private:
  void check(bool done) const {
    if (!done || common_.status < CHOLMOD_OK)
      throw std::runtime_error("CHOLMOD: status " + std::to_string(common_.status));
  }

  cholmod_common common_;
  cholmod_sparse matrix_;
  cholmod_factor* factor_ = nullptr;
};

// The rows of A are the columns of A^T: UMFPACK and KLU get A^T and solve with its transpose.

/// Under METIS.
class Umfpack final : public HostPeer<Long> {
 public:
  explicit Umfpack(const System& system) : HostPeer(system) {
    umfpack_dl_defaults(control_);
    control_[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
    control_[UMFPACK_PRL] = 0;
    control_[UMFPACK_IRSTEP] = 0;
  }
  ~Umfpack() override {
    umfpack_dl_free_numeric(&numeric_);
    umfpack_dl_free_symbolic(&symbolic_);
  }
  Umfpack(const Umfpack&) = delete;
  Umfpack& operator=(const Umfpack&) = delete;

  AnalysisTime analyze() override {
    check(umfpack_dl_symbolic(n(), n(), offsets_.data(), indices_.data(), values(), &symbolic_, control_,
                              info_));
    return {};
  }
  void factor() override { refactor(); }
  void refactor() override {
    umfpack_dl_free_numeric(&numeric_);
    check(umfpack_dl_numeric(offsets_.data(), indices_.data(), values(), symbolic_, &numeric_, control_,
                             info_));
    facts_.factor_entries = static_cast<std::int64_t>(info_[UMFPACK_LNZ] + info_[UMFPACK_UNZ]) - n();
    facts_.flops = info_[UMFPACK_FLOPS];
    facts_.device_bytes = static_cast<std::int64_t>(info_[UMFPACK_PEAK_MEMORY] * info_[UMFPACK_SIZE_OF_UNIT]);
  }
  void solve(int columns) override {
    for (int j = 0; j < columns; ++j) {
      check(umfpack_dl_solve(UMFPACK_At, offsets_.data(), indices_.data(), values(), x_.data() + j * n(),
                             right_hand_sides() + j * n(), numeric_, control_, info_));
    }
  }
  bool refine(int steps) override {
    control_[UMFPACK_IRSTEP] = steps;
    return true;
  }
  Facts facts() override {
    facts_.refinement_steps = static_cast<int>(control_[UMFPACK_IRSTEP]);
    return facts_;
  }

 private:
  static void check(Long status) {
    if (status != UMFPACK_OK) throw std::runtime_error("UMFPACK: status " + std::to_string(status));
  }

  double control_[UMFPACK_CONTROL], info_[UMFPACK_INFO];
  void* symbolic_ = nullptr;
  void* numeric_ = nullptr;
  Facts facts_ = facts_of(UMFPACK_VERSION);
};

class Klu final : public HostPeer<int> {
 public:
  explicit Klu(const System& system) : HostPeer(system) { klu_defaults(&common_); }
  ~Klu() override {
    klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  Klu(const Klu&) = delete;
  Klu& operator=(const Klu&) = delete;

  AnalysisTime analyze() override {
    symbolic_ = klu_analyze(n(), offsets_.data(), indices_.data(), &common_);
    check(symbolic_ != nullptr);
    return {};
  }
  void factor() override {
    klu_free_numeric(&numeric_, &common_);
    numeric_ = klu_factor(offsets_.data(), indices_.data(), values(), symbolic_, &common_);
    check(numeric_ != nullptr);
  }
  void refactor() override {
    check(klu_refactor(offsets_.data(), indices_.data(), values(), symbolic_, numeric_, &common_) != 0);
  }
  void solve(int columns) override {
    std::copy_n(system_.b.data(), system_.a.n * columns, x_.data());
    check(klu_tsolve(symbolic_, numeric_, n(), columns, x_.data(), &common_) != 0);
  }
  bool refine(int) override { return false; }
  Facts facts() override {
    Facts facts = facts_of(std::to_string(KLU_MAIN_VERSION) + "." + std::to_string(KLU_SUB_VERSION));
    facts.factor_entries = numeric_->lnz + numeric_->unz;
    return facts;
  }

 private:
  void check(bool done) const {
    if (!done) throw std::runtime_error("KLU: status " + std::to_string(common_.status));
  }

  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
  klu_common common_;
};

}  // namespace

std::vector<std::string> linked_peers() {
  std::vector<std::string> names{"umfpack", "klu", "cholmod"};
#ifdef MFS_SUPERLU
  names.emplace_back("superlu");
#endif
#ifdef MFS_MUMPS
  names.emplace_back("mumps");
#endif
  return names;
}

MakeCandidate linked_peer(const std::string& name) {
  if (name == "umfpack") return [](const System& system) { return std::make_unique<Umfpack>(system); };
  if (name == "klu") return [](const System& system) { return std::make_unique<Klu>(system); };
  if (name == "cholmod") return [](const System& system) { return std::make_unique<Cholmod>(system); };
#ifdef MFS_SUPERLU
  if (name == "superlu") return make_superlu;
#endif
#ifdef MFS_MUMPS
  if (name == "mumps") return make_mumps;
#endif
  throw std::invalid_argument("no solver '" + name + "' here");
}

}  // namespace mfs::perf
