// Factors of backend kokkos by its code for devices, in a space of the host, of matrices that are analysed as
// for a device.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "accuracy/factorization.hpp"
#include "kernels/portable/portable_factors_def.hpp"
#include "plan/delay_pivots.hpp"
#include "plan/device_flops.hpp"
#include "solver/analysis.hpp"
#include "test/reference/sparse.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {

class DeviceCode {
 public:
  explicit DeviceCode(const SparseMatrix& a)
      : analysis_(analyze_matrix(a.view(), AnalysisOptions(), kDeviceNeeds, 1, [](const char*, double) {})) {
    make(a);
  }
  /// Makes the plan anew with the pivots that the last factorization perturbed some levels up the tree.
  void delay_failed_pivots(const SparseMatrix& a, Vertex levels) {
    std::vector<FailedPivot> failed;
    for (const Vertex position : made_->failed_pivots())
      failed.push_back({position, made_->pivot_row(position)});
    DelayedTree delayed = delay_pivots(*analysis_.plan, failed, levels, 1);
    analysis_.plan = std::make_shared<SymbolicPlan>(
        make_symbolic_plan(*analysis_.pattern, delayed.row_order, delayed.tree,
                           AnalysisOptions().max_block_size, 1, kAssemblyTurns));
    analysis_.matched.row_order = std::move(delayed.row_order);
    make(a);
  }
  void put_values(const SparseMatrix& a) {
    std::copy(a.values.begin(), a.values.end(), made_->factors().matrix_values());
  }
  /// Returns how often the matrix was factored.
  double factor(const PivotPolicy& policy) {
    const FactorStatus status = made_->factor(policy, {});
    perturbed_ = status.perturbed;
    return (status.getrf + status.trsm + status.gemm) / flops_;
  }
  /// Pivots that the last factorization perturbed.
  unsigned long long perturbed() const { return perturbed_; }
  Factorization<double>& factorization() { return *made_; }
  const Pattern& pattern() const { return *analysis_.pattern; }

 private:
  using Made = portable::PortableFactors<Kokkos::Serial, double, double, portable::OwnDense<double>,
                                         /*kResident=*/true>;
  void make(const SparseMatrix& a) {
    portable::Lists lists = Made::lists_for(*analysis_.plan, 1);
    flops_ = count_flops(*analysis_.plan, lists.device, false).done.total();
    auto factors = std::make_unique<Made>(analysis_.plan, analysis_.pattern, 1, std::move(lists));
    const MatchedScaling& matched = analysis_.matched;
    std::copy(matched.row_scale.begin(), matched.row_scale.end(), factors->row_scale());
    std::copy(matched.column_scale.begin(), matched.column_scale.end(), factors->column_scale());
    made_ =
        make_factorization<double>(HostSpace::serial, std::move(factors), analysis_.plan, analysis_.pattern);
    put_values(a);
  }

  Analysis analysis_;
  double flops_ = 0;
  unsigned long long perturbed_ = 0;
  std::unique_ptr<Factorization<double>> made_;
};

}  // namespace mfs::test
