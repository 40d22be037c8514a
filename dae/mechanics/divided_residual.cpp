#include "dae/mechanics/divided_residual.hpp"

#include <algorithm>

#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

/// q, v and a of some coordinates, then all multipliers.
struct Gather {
  const int* coordinate;
  const double *q, *v, *a, *lambda;
  double* gathered;
  std::size_t count;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    if (i < count) {
      gathered[i] = q[coordinate[i]];
      gathered[count + i] = v[coordinate[i]];
      gathered[2 * count + i] = a[coordinate[i]];
    } else {
      gathered[2 * count + i] = lambda[i - count];
    }
  }
};

/// Adds forces of some coordinates to F, then writes all constraints behind it.
struct Scatter {
  const int* coordinate;
  const double* scattered;
  double* h;
  std::size_t count, n;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    if (i < count)
      h[coordinate[i]] += scattered[i];
    else
      h[n + i - count] = scattered[i];
  }
};

}  // namespace

DividedResidual::DividedResidual(const Multibody& system, const Executor& executor)
    : system_(system),
      executor_(executor),
      n_(static_cast<std::size_t>(system.coordinates())),
      m_(static_cast<std::size_t>(system.constraints())),
      coordinates_(system.host_coordinates()),
      residuals_(system.host_residuals(coordinates_)) {
  seen_.assign(executor, coordinates_);
  gathered_.resize(executor, 3 * seen() + m_);
  scattered_.resize(executor, seen() + 3 * m_);
  gathered_on_host_ = executor.allocate_staging(gathered_.size() * sizeof(double));
  scattered_on_host_ = executor.allocate_staging(scattered_.size() * sizeof(double));
  for (auto* part : {&q_, &v_, &a_}) part->resize(n_);
}

void DividedResidual::evaluate(const StateView& state, int levels, double* h) {
  fill(executor_, n_, 0.0, h);
  begin_gather(state);
  system_.write_device_forces(executor_, state, h);
  executor_.wait_for_mark();
  // Here, while the device evaluates forces. It has copied what was scattered before: what has been gathered
  // since came behind that.
  double* const force = scattered();
  double* const position = force + seen();
  std::fill(force, position, 0.0);
  residuals_.add({state.t, gathered(), gathered() + seen(), gathered() + 2 * seen(), gathered() + 3 * seen()},
                 {force, position, position + m_, position + 2 * m_});
  begin_scatter(levels, h);
}

StateView DividedResidual::bring(const StateView& state) {
  begin_gather(state);
  executor_.wait_for_mark();
  for (std::size_t k = 0; k < seen(); ++k) {
    const int i = coordinates_[k];
    q_[i] = gathered()[k];
    v_[i] = gathered()[seen() + k];
    a_[i] = gathered()[2 * seen() + k];
  }
  return {state.t, q_.data(), v_.data(), a_.data(), gathered() + 3 * seen()};
}

void DividedResidual::begin_gather(const StateView& state) {
  for_each(executor_, seen() + m_,
           Gather{seen_.data(), state.q, state.v, state.a, state.lambda, gathered_.data(), seen()});
  executor_.begin_to_host(gathered(), gathered_.data(), gathered_.size() * sizeof(double));
  executor_.mark();
}

void DividedResidual::begin_scatter(int levels, double* h) {
  const std::size_t count = seen() + static_cast<std::size_t>(levels) * m_;
  executor_.begin_from_host(scattered_.data(), scattered(), count * sizeof(double));
  for_each(executor_, count, Scatter{seen_.data(), scattered_.data(), h, seen(), n_});
}

}  // namespace mfs::dae
