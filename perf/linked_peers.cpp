#include <algorithm>
#include <stdexcept>

#include <klu.h>
#include <umfpack.h>

#include "perf/peers.hpp"

namespace mfs::perf {

namespace {

// The rows of A are the columns of A^T: both solvers get A^T and solve with its transpose.
struct Columns {
  explicit Columns(const System& system)
      : n(static_cast<int>(system.a.n)),
        begin(system.a.offsets.begin(), system.a.offsets.end()),
        rows(system.a.column_indices.begin(), system.a.column_indices.end()) {}
  int n;
  std::vector<int> begin, rows;
};

class Umfpack final : public Candidate {
 public:
  explicit Umfpack(const System& system) : system_(system), at_(system), x_(system.b.size()) {
    umfpack_di_defaults(control_);
    control_[UMFPACK_IRSTEP] = 0;
  }
  ~Umfpack() override {
    umfpack_di_free_numeric(&numeric_);
    umfpack_di_free_symbolic(&symbolic_);
  }
  AnalysisTime analyze() override {
    check(umfpack_di_symbolic(at_.n, at_.n, at_.begin.data(), at_.rows.data(), system_.a.values.data(),
                              &symbolic_, control_, info_));
    return {};
  }
  void factor() override {
    umfpack_di_free_numeric(&numeric_);
    check(umfpack_di_numeric(at_.begin.data(), at_.rows.data(), system_.a.values.data(), symbolic_, &numeric_,
                             control_, info_));
    entries_ = static_cast<std::int64_t>(info_[UMFPACK_LNZ] + info_[UMFPACK_UNZ]);
    flops_ = info_[UMFPACK_FLOPS];
  }
  void refactor() override { factor(); }
  void solve(int columns) override {
    for (int j = 0; j < columns; ++j) {
      const std::int64_t first = j * system_.a.n;
      check(umfpack_di_solve(UMFPACK_At, at_.begin.data(), at_.rows.data(), system_.a.values.data(),
                             x_.data() + first, system_.b.data() + first, numeric_, control_, info_));
    }
  }
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  bool refine(int steps) override {
    control_[UMFPACK_IRSTEP] = steps;
    return true;
  }
  Facts facts() override {
    Facts facts;
    facts.version = UMFPACK_VERSION;
    facts.vectors = "host";
    facts.factor_entries = entries_;
    facts.flops = flops_;
    facts.refinement_steps = static_cast<int>(control_[UMFPACK_IRSTEP]);
    return facts;
  }
  std::int64_t caller_bytes(int) const override { return 0; }

 private:
  static void check(int status) {
    if (status != UMFPACK_OK) throw std::runtime_error("UMFPACK: status " + std::to_string(status));
  }
  const System& system_;
  Columns at_;
  std::vector<double> x_;
  void *symbolic_ = nullptr, *numeric_ = nullptr;
  double control_[UMFPACK_CONTROL], info_[UMFPACK_INFO] = {};
  std::int64_t entries_ = 0;
  double flops_ = 0;
};

class Klu final : public Candidate {
 public:
  explicit Klu(const System& system) : system_(system), at_(system), x_(system.b.size()) {
    klu_defaults(&common_);
  }
  ~Klu() override {
    klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  AnalysisTime analyze() override {
    symbolic_ = klu_analyze(at_.n, at_.begin.data(), at_.rows.data(), &common_);
    check(symbolic_ != nullptr);
    return {};
  }
  void factor() override {
    klu_free_numeric(&numeric_, &common_);
    numeric_ = klu_factor(at_.begin.data(), at_.rows.data(), values(), symbolic_, &common_);
    check(numeric_ != nullptr);
  }
  void refactor() override {
    check(klu_refactor(at_.begin.data(), at_.rows.data(), values(), symbolic_, numeric_, &common_) != 0);
  }
  void solve(int columns) override {
    std::copy_n(system_.b.data(), system_.a.n * columns, x_.data());
    check(klu_tsolve(symbolic_, numeric_, at_.n, columns, x_.data(), &common_) != 0);
  }
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  bool refine(int) override { return false; }
  Facts facts() override {
    Facts facts;
    facts.version = std::to_string(KLU_MAIN_VERSION) + "." + std::to_string(KLU_SUB_VERSION);
    facts.vectors = "host";
    facts.factor_entries = numeric_->lnz + numeric_->unz;
    return facts;
  }
  std::int64_t caller_bytes(int) const override { return 0; }

 private:
  void check(bool done) const {
    if (!done) throw std::runtime_error("KLU: status " + std::to_string(common_.status));
  }
  double* values() const { return const_cast<double*>(system_.a.values.data()); }  // which KLU only reads
  const System& system_;
  Columns at_;
  std::vector<double> x_;
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
  klu_common common_;
};

}  // namespace

std::vector<std::string> linked_peers() {
  return {"umfpack", "klu"};
}

MakeCandidate linked_peer(const std::string& name) {
  if (name == "umfpack") return [](const System& system) { return std::make_unique<Umfpack>(system); };
  if (name == "klu") return [](const System& system) { return std::make_unique<Klu>(system); };
  throw std::invalid_argument("no solver '" + name + "' here");
}

}  // namespace mfs::perf
