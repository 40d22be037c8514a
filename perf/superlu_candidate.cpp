#include <slu_ddefs.h>

#include <stdexcept>
#include <string>

#include "perf/host_peer.hpp"
#include "perf/peers.hpp"

namespace mfs::perf {

namespace {

/// Sequential, under COLAMD, with partial pivoting: its defaults. It takes columns: those of A^T are A's
/// rows.
class SuperLu final : public HostPeer<int> {
 public:
  explicit SuperLu(const System& system)
      : HostPeer(system),
        column_permutation_(static_cast<std::size_t>(n())),
        row_permutation_(column_permutation_.size()),
        tree_(column_permutation_.size()),
        row_scale_(column_permutation_.size(), 1),
        column_scale_(row_scale_) {
    set_default_options(&options_);
    StatInit(&statistics_);
    dCreate_CompCol_Matrix(&transposed_, n(), n(), static_cast<int>(indices_.size()), values(),
                           indices_.data(), offsets_.data(), SLU_NC, SLU_D, SLU_GE);
  }
  ~SuperLu() override {
    forget_factors();
    if (permuted_.Store) Destroy_CompCol_Permuted(&permuted_);
    Destroy_SuperMatrix_Store(&transposed_);  // its arrays are ours
    StatFree(&statistics_);
  }
  SuperLu(const SuperLu&) = delete;
  SuperLu& operator=(const SuperLu&) = delete;

  AnalysisTime analyze() override {
    get_perm_c(options_.ColPerm, &transposed_, column_permutation_.data());
    sp_preorder(&options_, &transposed_, column_permutation_.data(), tree_.data(), &permuted_);
    return {};
  }
  void factor() override {
    options_.Fact = DOFACT;
    forget_factors();
    factor_permuted();
  }
  // Rows are interchanged as before where that is stable.
  void refactor() override {
    options_.Fact = SamePattern_SameRowPerm;
    factor_permuted();
  }
  void solve(int columns) override {
    std::copy_n(system_.b.data(), system_.a.n * columns, x_.data());
    SuperMatrix x = dense(columns, x_.data());
    int info = 0;
    dgstrs(TRANS, &lower_, &upper_, column_permutation_.data(), row_permutation_.data(), &x, &statistics_,
           &info);
    if (refines_) {
      SuperMatrix b = dense(columns, right_hand_sides());
      std::vector<double> forward(static_cast<std::size_t>(columns)), backward(forward);
      char equilibrated[] = "N";
      dgsrfs(TRANS, &transposed_, &lower_, &upper_, column_permutation_.data(), row_permutation_.data(),
             equilibrated, row_scale_.data(), column_scale_.data(), &b, &x, forward.data(), backward.data(),
             &statistics_, &info);
      Destroy_SuperMatrix_Store(&b);
    }
    Destroy_SuperMatrix_Store(&x);
    check(info);
  }
  // It decides itself how often.
  bool refine(int steps) override {
    refines_ = steps > 0;
    return true;
  }
  Facts facts() override {
    Facts facts =
        facts_of(std::to_string(SUPERLU_MAJOR_VERSION) + "." + std::to_string(SUPERLU_MINOR_VERSION));
    facts.factor_entries = static_cast<const SCformat*>(lower_.Store)->nnz +
                           static_cast<const NCformat*>(upper_.Store)->nnz - n();
    facts.flops = statistics_.ops[FACT];
    facts.refinement_steps = refines_ ? statistics_.RefineSteps : 0;
    mem_usage_t memory{};
    dQuerySpace(&lower_, &upper_, &memory);
    facts.device_bytes = static_cast<std::int64_t>(memory.total_needed);
    return facts;
  }

 private:
  void factor_permuted() {
    int info = 0;
    statistics_.ops[FACT] = 0;  // SuperLU only adds
    dgstrf(&options_, &permuted_, sp_ienv(2), sp_ienv(1), tree_.data(), nullptr, 0,
           column_permutation_.data(), row_permutation_.data(), &lower_, &upper_, &storage_, &statistics_,
           &info);
    check(info);
  }
  void forget_factors() {
    if (lower_.Store) Destroy_SuperNode_Matrix(&lower_);
    if (upper_.Store) Destroy_CompCol_Matrix(&upper_);
    lower_.Store = upper_.Store = nullptr;
  }
  SuperMatrix dense(int columns, double* entries) const {
    SuperMatrix matrix;
    dCreate_Dense_Matrix(&matrix, n(), columns, entries, n(), SLU_DN, SLU_D, SLU_GE);
    return matrix;
  }
  static void check(int info) {
    if (info != 0) throw std::runtime_error("SuperLU: info " + std::to_string(info));
  }

  superlu_options_t options_;
  SuperLUStat_t statistics_;
  GlobalLU_t storage_{};
  SuperMatrix transposed_{}, permuted_{}, lower_{}, upper_{};
  std::vector<int> column_permutation_, row_permutation_, tree_;
  std::vector<double> row_scale_, column_scale_;
  bool refines_ = false;
};

}  // namespace

std::unique_ptr<Candidate> make_superlu(const System& system) {
  return std::make_unique<SuperLu>(system);
}

}  // namespace mfs::perf
