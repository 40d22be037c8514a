// What is known of the pivots of a matrix, and the rules for them that follow.
#pragma once

#include "kernels/dense/pivot_rule.hpp"

namespace mfs {

struct PivotKnowledge {
  TinyPivots tiny = TinyPivots::noise;  // data: since a factorization perturbed too many to correct
  bool dominant = false;                // the diagonal of the values of the analysis
  bool definite = false;                // as A looks, where it was decided that they are data
  bool mirrors = false;                 // and solves take steps of refinement

  void forget_tiny() {
    tiny = TinyPivots::noise;
    definite = mirrors = false;
  }

  /// Of the present values; `tolerance` relative to the largest scaled entry.
  PivotPolicy policy(double tolerance) const {
    // What grows by dividing by less than a hundredth of the border is seen in the backward error. To perturb
    // such a pivot by the root of epsilon would be no better.
    PivotPolicy policy =
        tiny == TinyPivots::noise ? PivotPolicy(tolerance) : PivotPolicy(tolerance, tiny, tolerance);
    if (definite || dominant) policy.preference = kDefinitePreference;
    policy.symmetric = mirrors;
    return policy;
  }

  /// Every pivot is compared with its border, as threshold pivoting does (tolerance 1: the largest entry).
  PivotPolicy threshold_policy() const { return {1.0, tiny, kBorderThreshold}; }
  /// Those are compared that can be too small beside a border in which nothing has grown. They are few, while
  /// to compare all takes a device as long as 30 factorizations.
  PivotPolicy small_pivot_policy() const { return {kBorderThreshold, tiny, kBorderThreshold}; }
};

}  // namespace mfs
