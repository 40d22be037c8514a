// The constraints of a system of which some follow from the others: which are left out, what their
// multipliers are, and whether they really follow. Which they are may change along a motion: in a singular
// position one more follows from the others than before and after it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dae/integrator/dependencies.hpp"
#include "dae/integrator/independent_constraints.hpp"
#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

class Redundancy {
 public:
  /// Nothing is left out yet. `system` has to live as long; `scale`: per coordinate.
  Redundancy(const ConstrainedSystem& system, std::vector<double> scale);

  /// The system without what is left out. Another object after leave_out().
  const ConstrainedSystem& system() const;
  /// Whether anything has been left out.
  bool filters() const { return filtered_.has_value(); }
  const std::vector<int>& redundant() const { return left_out_.redundant(); }
  std::vector<std::string> names() const;

  Dependencies find(double t, const std::vector<double>& q) const;
  /// What is redundant in `found` is left out from now on.
  void leave_out(Dependencies found);

  /// Multipliers of all constraints from those of system(); those left out have none.
  std::vector<double> all_multipliers(const std::vector<double>& kept) const;
  /// The other way: multipliers of system() for the same forces.
  std::vector<double> kept_multipliers(std::vector<double> all) const;
  /// A state of system() as one of all constraints, with multipliers of least squares.
  State whole(State state) const;

  /// What a constraint that is left out is violated by.
  struct Violation {
    int row;
    const char* level;
    double value;
  };
  /// Of one where that is more than rounding by the tolerances of `options`.
  std::optional<Violation> violation(const StateView& state, const IntegratorOptions& options) const;
  /// InvalidInput with the name of the constraint and of what it contradicts.
  [[noreturn]] void throw_contradiction(const Violation& violation, double t) const;

 private:
  const ConstrainedSystem& given_;
  std::vector<double> scale_;
  std::vector<char> normalizes_;
  Dependencies left_out_;
  std::optional<IndependentConstraints> filtered_;
};

}  // namespace mfs::dae
