// Sees what a step has passed over because it lasts for a moment of the motion: a force or a motion that
// depends on coordinates, as a bump on a road or a thin layer.
#pragma once

namespace mfs::dae {

class ChangeWatch {
 public:
  virtual ~ChangeWatch() = default;
  /// A motion begins, or a step has ended, in this state. `q`, `v`: of the system.
  virtual void go_on(double t, const double* q, const double* v) = 0;

  struct Verdict {
    /// How much of the step there is until something changes that its ends do not tell; 1: nothing does.
    double part = 1.0;
    /// Whether a comparison is another one at its end, so that forces there are other functions.
    bool turned = false;
  };
  /// On a step from there to this state, between which coordinates follow the cubic by their rates.
  virtual Verdict look(double t, const double* q, const double* v) = 0;
};

}  // namespace mfs::dae
