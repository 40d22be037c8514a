#include "dae/integrator/scaled_system.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "dae/integrator/initial_conditions.hpp"

namespace mfs::dae {
namespace {

/// x_i *= f_i^power factor; an empty x stays so.
void multiply(const std::vector<double>& f, int power, double factor, std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] *= power > 0 ? f[i] * factor : factor / f[i];
}

/// y = f^power factor x.
void multiplied(const std::vector<double>& f, int power, double factor, const double* x,
                std::vector<double>& y) {
  y.assign(x, x + f.size());
  multiply(f, power, factor, y);
}

/// In which a block grows with the unit of time.
int power_of_time(Block block) {
  switch (block) {
    case Block::force_q:
    case Block::acceleration_q:
      return 2;
    case Block::force_v:
    case Block::velocity_q:
    case Block::acceleration_v:
      return 1;
    case Block::force_a:
    case Block::position_q:
      return 0;
  }
  return 0;
}

}  // namespace

/// What devices have is of bodies whose coordinates all have one scale.
class ScaledSystem::Remote final : public RemoteTangent {
 public:
  Remote(RemoteTangent& remote, const ScaledSystem& system) : remote_(remote), system_(system) {
    const Pattern& pattern = remote.pattern();
    const double scale = pattern.entries() > 0 ? system.scale_[pattern.column[0]] : 1.0;
    square_ = scale * scale;
  }

  const Pattern& pattern() const override { return remote_.pattern(); }
  std::unique_ptr<RemoteMatrix> make_matrix(std::size_t entries, const std::vector<int>& own) override {
    return remote_.make_matrix(entries, own);
  }
  void place(const std::array<const int*, 3>& target, RemoteMatrix& matrix) override {
    remote_.place(target, matrix);
  }
  void begin_tangent(const StateView& state) override { remote_.begin_tangent(system_.given(state)); }
  /// States are on the host.
  void begin_tangent(const Executor& executor, const StateView& state) override {
    remote_.begin_tangent(executor, state);
  }
  void add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals) override {
    remote_.add_diagonals(given(factor), diagonals);
  }
  void begin_sum(const ByAVQ& factor) override { remote_.begin_sum(given(factor)); }

 private:
  ByAVQ given(const ByAVQ& factor) const {
    const double time = system_.time_;
    return {square_ * factor[0], square_ * time * factor[1], square_ * time * time * factor[2]};
  }

  RemoteTangent& remote_;
  const ScaledSystem& system_;
  double square_ = 1.0;
};

bool ScaledSystem::is_needed(const ConstrainedSystem& system) {
  for (int i = 0; i < system.coordinates(); ++i)
    if (system.coordinate_scale(i) != 1.0) return true;
  return false;
}

ScaledSystem::ScaledSystem(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                           double time)
    : system_(system), time_(time), unit_(static_cast<std::size_t>(system.constraints()), 1.0) {
  for (int i = 0; i < system.coordinates(); ++i) scale_.push_back(system.coordinate_scale(i));
  const std::vector<double> size = constraint_sizes(system, t, q, scale_);
  for (std::size_t row = 0; row < size.size(); ++row)
    if (size[row] > 0.0 && std::isfinite(size[row])) unit_[row] = std::exp2(std::round(std::log2(size[row])));
  for (RemoteTangent* const remote : system.remote_tangents())
    remotes_.push_back(std::make_unique<Remote>(*remote, *this));
}

ScaledSystem::~ScaledSystem() = default;

State ScaledSystem::scaled(State state) const {
  state.t /= time_;
  multiply(scale_, -1, 1.0, state.q);
  multiply(scale_, -1, time_, state.v);
  multiply(scale_, -1, time_ * time_, state.a);
  multiply(unit_, 1, time_ * time_, state.lambda);
  return state;
}

State ScaledSystem::unscaled(State state) const {
  state.t *= time_;
  multiply(scale_, 1, 1.0, state.q);
  multiply(scale_, 1, 1.0 / time_, state.v);
  multiply(scale_, 1, 1.0 / (time_ * time_), state.a);
  multiply(unit_, -1, 1.0 / (time_ * time_), state.lambda);
  return state;
}

IntegratorOptions ScaledSystem::scaled(IntegratorOptions options) const {
  for (double* step : {&options.initial_step, &options.max_step, &options.min_step, &options.fixed_step})
    *step /= time_;
  const IntegratorOptions defaults;
  options.atol_velocity *= time_;  // 0: the default
  if (options.constraint_velocity != defaults.constraint_velocity) options.constraint_velocity *= time_;
  if (options.constraint_acceleration != defaults.constraint_acceleration)
    options.constraint_acceleration *= time_ * time_;
  return options;
}

StateView ScaledSystem::given(const StateView& state) const {
  there_.t = time_ * state.t;
  multiplied(scale_, 1, 1.0, state.q, there_.q);
  multiplied(scale_, 1, 1.0 / time_, state.v, there_.v);
  multiplied(scale_, 1, 1.0 / (time_ * time_), state.a, there_.a);
  multiplied(unit_, -1, 1.0 / (time_ * time_), state.lambda, there_.lambda);
  return {there_.t, there_.q.data(), there_.v.data(), there_.a.data(), there_.lambda.data()};
}

void ScaledSystem::evaluate(const StateView& state, Residual& residual) const {
  system_.evaluate(given(state), residual);
  multiply(scale_, 1, time_ * time_, residual.force);
  multiply(unit_, -1, 1.0, residual.position);
  multiply(unit_, -1, time_, residual.velocity);
  multiply(unit_, -1, time_ * time_, residual.acceleration);
}

void ScaledSystem::evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const {
  system_.evaluate(given(state), tangent, blocks);
  for (int b = 0; b < kBlocks; ++b) {
    const auto block = static_cast<Block>(b);
    if (!blocks.has(block)) continue;
    const bool of_force = block == Block::force_q || block == Block::force_v || block == Block::force_a;
    const Pattern& pattern = system_.tangent_pattern()[block];
    const double of_time = std::pow(time_, power_of_time(block));
    for (int row = 0; row < pattern.rows; ++row) {
      const double factor = of_time * (of_force ? scale_[row] : 1.0 / unit_[row]);
      for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
        tangent[block][k] *= factor * scale_[pattern.column[k]];
    }
  }
}

std::vector<RemoteTangent*> ScaledSystem::remote_tangents() const {
  std::vector<RemoteTangent*> remotes;
  for (const auto& remote : remotes_) remotes.push_back(remote.get());
  return remotes;
}

std::vector<double> ScaledSystem::ranges(const double* q) const {
  std::vector<double> ranges = system_.ranges(given(q).data());
  multiply(scale_, -1, 1.0, ranges);
  return ranges;
}

std::string ScaledSystem::most_pressed(const double* q) const {
  return system_.most_pressed(given(q).data());
}

std::vector<double> ScaledSystem::given(const double* q) const {
  std::vector<double> there(q, q + coordinates());
  multiply(scale_, 1, 1.0, there);
  return there;
}

class ScaledSystem::Watch final : public ChangeWatch {
 public:
  Watch(const ScaledSystem& system, std::unique_ptr<ChangeWatch> given)
      : system_(system), given_(std::move(given)) {}
  void go_on(double t, const double* q, const double* v) override {
    const State there = unscaled(t, q, v);
    given_->go_on(there.t, there.q.data(), there.v.data());
  }
  Verdict look(double t, const double* q, const double* v) override {
    const State there = unscaled(t, q, v);
    return given_->look(there.t, there.q.data(), there.v.data());
  }

 private:
  State unscaled(double t, const double* q, const double* v) const {
    const int n = system_.coordinates();
    return system_.unscaled({t, {q, q + n}, {v, v + n}, {}, {}});
  }

  const ScaledSystem& system_;
  std::unique_ptr<ChangeWatch> given_;
};

std::unique_ptr<ChangeWatch> ScaledSystem::change_watch() const {
  auto given = system_.change_watch();
  return given ? std::make_unique<Watch>(*this, std::move(given)) : nullptr;
}

std::vector<double> ScaledSystem::marks(const TimeSpan& span) const {
  std::vector<double> marks = system_.marks({span.begin * time_, span.end * time_});
  for (double& time : marks) time /= time_;
  return marks;
}

std::vector<PointRange> ScaledSystem::turning_bodies() const {
  return turning_bodies_of(system_);
}

}  // namespace mfs::dae
