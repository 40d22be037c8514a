// Whether systems of a batch are solved many at a time by a scalar program (plan/scalar_program.hpp).
#pragma once

#include <optional>

#include <mfs/options.hpp>
#include <mfs/report.hpp>

#include "accuracy/factorization.hpp"
#include "kernels/lanes/host_lanes.hpp"
#include "solver/analysis.hpp"

namespace mfs {

/// The program with the pivots of the factors at hand, which are those of the values that were analysed.
/// Nothing where these pivots are no good, where the options ask for what lanes do not do, or where fronts
/// are faster.
template <class Scalar>
std::optional<lanes::LaneProgram> plan_lanes(const Options& options, const Report& report,
                                             const Analysis& analysis, const Factorization<Scalar>& factors);

/// What lanes ask of the order, on a device with many threads for a system or on the host with one. Nothing
/// where the options ask for what lanes do not do.
std::optional<ListCost> lane_cost(const Options& options, const Report& report, bool on_device);

/// What each lane must reach.
template <class Scalar>
lanes::LaneRules lane_rules(const Options& options);

}  // namespace mfs
