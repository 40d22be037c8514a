// Factors of backend kokkos by its code for devices, in a space of the host, of matrices that are analysed as
// for a device.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "accuracy/factorization.hpp"
#include "kernels/portable/portable_factors_def.hpp"
#include "plan/device_flops.hpp"
#include "solver/analysis.hpp"
#include "test/reference/sparse.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {

class DeviceCode {
 public:
  explicit DeviceCode(const SparseMatrix& a)
      : analysis_(
            analyze_matrix(a.view(), AnalysisOptions(), kAssemblyTurns, 1, [](const char*, double) {})) {
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
  void put_values(const SparseMatrix& a) {
    std::copy(a.values.begin(), a.values.end(), made_->factors().matrix_values());
  }
  /// Returns how often the matrix was factored.
  double factor(const PivotPolicy& policy) {
    const FactorStatus status = made_->factor(policy, {});
    return (status.getrf + status.trsm + status.gemm) / flops_;
  }
  Factorization<double>& factorization() { return *made_; }
  const Pattern& pattern() const { return *analysis_.pattern; }

 private:
  using Made = portable::PortableFactors<Kokkos::Serial, double, double, portable::OwnDense<double>,
                                         /*kResident=*/true>;
  Analysis analysis_;
  double flops_ = 0;
  std::unique_ptr<Factorization<double>> made_;
};

}  // namespace mfs::test
