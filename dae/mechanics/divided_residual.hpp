// The residual of a multibody system whose state lies on a device: flexible bodies are evaluated there, all
// else by the host meanwhile. Of the state the host gets the coordinates of its own elements, which are few,
// and sends back what it has for them.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "dae/mechanics/multibody_system.hpp"
#include "dae/vectors/executor.hpp"

namespace mfs::dae {

class DividedResidual final : public RemoteResidual {
 public:
  /// Both have to live as long.
  DividedResidual(const Multibody& system, const Executor& executor);

  void evaluate(const StateView& state, int levels, double* h) override;
  StateView bring(const StateView& state) override;

 private:
  void begin_gather(const StateView& state);
  void begin_scatter(int levels, double* h);
  std::size_t seen() const { return coordinates_.size(); }
  double* gathered() const { return static_cast<double*>(gathered_on_host_.get()); }
  double* scattered() const { return static_cast<double*>(scattered_on_host_.get()); }

  const Multibody& system_;
  const Executor& executor_;
  const std::size_t n_, m_;
  const std::vector<int> coordinates_;  ///< that the host sees
  const ElementResiduals residuals_;    ///< of its elements, with vectors of these coordinates
  Array<int> seen_;                     ///< these coordinates
  Array<double> gathered_, scattered_;
  /// Of the host, for copies: q, v and a of these coordinates and the multipliers; F of these coordinates and
  /// the constraints of all levels.
  std::shared_ptr<void> gathered_on_host_, scattered_on_host_;
  std::vector<double> q_, v_, a_;  ///< of all coordinates, with numbers where the host sees them
};

}  // namespace mfs::dae
