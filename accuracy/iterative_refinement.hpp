// Iterative refinement, one loop wherever the vectors of a solve lie: x += A^-1 (b - A x), as long as each
// step halves the componentwise backward error.
//
// The loop sees *parts* of a block of right-hand sides. Each part is measured, kept and ended by itself. On
// the host every column is a part. On a device all columns are one, because the host waits there for one
// number a step. `Vectors` does what depends on the memory:
//
//   Vertex parts() const                           how many there are, at most kSolveColumns
//   void measure(double* errors)                   the backward errors of all parts as they are
//   void correct(const Vertex* parts, Vertex count)    finds the corrections of these parts; the k-th of them
//                                                  has place k
//   double add_correction(Vertex part, Vertex place)   adds it to the solution; returns the error after that
//   double drop_remainders(Vertex part, Vertex place, double error)   where a step has stalled: the error
//                                                  without entries that corrections only make smaller
//   void take_back(Vertex part)                    undoes the last step
//
// Sources: Skeel 1979, 1980; Arioli, Demmel, Duff 1989 (refinement and its stopping).
#pragma once

#include <algorithm>
#include <array>

#include "accuracy/solve_controls.hpp"
#include "kernels/factors.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs {

template <class Vectors>
class IterativeRefinement {
 public:
  IterativeRefinement(Vectors& vectors, const SolveControls& controls)
      : vectors_(vectors), controls_(controls) {}

  /// Measures the solutions as they are. Time counts from its end.
  void measure() {
    vectors_.measure(error_.data());
    for (Vertex part = 0; part < vectors_.parts(); ++part) open_[part] = error_[part] > controls_.tolerance;
    watch_ = Stopwatch();
  }

  /// Refines all open parts together. A part is closed when it is good enough or no longer halves its error.
  void run() {
    for (int step = 0; step < controls_.max_steps; ++step) {
      std::array<Vertex, kSolveColumns> open;
      Vertex count = 0;
      for (Vertex part = 0; part < vectors_.parts(); ++part) {
        if (open_[part]) open[count++] = part;
      }
      if (count == 0) return;
      ++steps_;
      vectors_.correct(open.data(), count);
      for (Vertex place = 0; place < count; ++place) improve(open[place], place);
    }
  }

  /// Adds the correction at `place` to a part, and keeps it only if the solution is better.
  void improve(Vertex part, Vertex place) {
    const double before = error_[part];
    double after = vectors_.add_correction(part, place);
    if (stalls(before, after)) after = vectors_.drop_remainders(part, place, after);
    if (after < before) {
      error_[part] = after;
    } else {
      vectors_.take_back(part);
    }
    open_[part] = after > controls_.tolerance && !stalls(before, after);
  }

  /// Of a part, as it is known; others than this loop may change it.
  double& error(Vertex part) { return error_[part]; }
  /// Of the worst part.
  double worst_error() const { return *std::max_element(error_.begin(), error_.begin() + vectors_.parts()); }
  int steps() const { return steps_; }
  double seconds() const { return watch_.seconds(); }

 private:
  bool stalls(double before, double after) const {
    return after > controls_.tolerance && !(after < 0.5 * before);
  }

  Vectors& vectors_;
  SolveControls controls_;
  std::array<double, kSolveColumns> error_{};
  std::array<bool, kSolveColumns> open_{};
  int steps_ = 0;
  Stopwatch watch_;
};

}  // namespace mfs
