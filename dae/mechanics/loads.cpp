#include "dae/mechanics/loads.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/compliant_element.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "dae/mechanics/rotation.hpp"

namespace mfs::dae {
namespace {

/// Elements with some coordinates of their own, on which forces act: F = -sum_k f_k B_k(q), f_k the values of
/// functions, which may depend on further coordinates.
///
///   coordinates of an element   own, own, own | of the functions
class LoadGroup : public ElementGroup {
 public:
  /// `own`: so many coordinates of each element, one after the other. One that a function depends on, too,
  /// may be among them where there is only one element.
  LoadGroup(std::string name, const std::vector<int>& own, int own_count,
            std::vector<StateFunction> functions)
      : name_(std::move(name)), own_(own_count), functions_(std::move(functions)) {
    std::vector<int> local(own.begin(), own.begin() + own_count);
    for (const StateFunction& function : functions_) {
      places_.emplace_back();
      for (const int coordinate : function.coordinates()) {
        const auto found = std::find(local.begin(), local.end(), coordinate);
        places_.back().push_back(static_cast<int>(found - local.begin()));
        if (found == local.end()) local.push_back(coordinate);
      }
    }
    count_ = static_cast<int>(local.size());
    for (std::size_t first = 0; first < own.size(); first += own_) {
      const auto begin = own.begin() + static_cast<std::ptrdiff_t>(first);
      coordinates_.insert(coordinates_.end(), begin, begin + own_);
      coordinates_.insert(coordinates_.end(), local.begin() + own_, local.end());
    }
  }

  int size() const override { return static_cast<int>(coordinates_.size()) / count_; }
  int local_coordinates() const override { return count_; }
  const int* coordinates(int e) const override { return coordinates_.data() + count_ * e; }
  std::string name(int) const override { return name_; }
  LocalStructure structure() const override {
    using Kind = LocalStructure::Kind;
    LocalStructure structure{Kind::zero};
    if (turns() || count_ > own_) structure.force_q = Kind::dense;
    for (const StateFunction& function : functions_) {
      if (!function.coordinates().empty()) structure.force_q = Kind::dense;
      if (function.has_rates()) structure.force_v = Kind::dense;
    }
    return structure;
  }

  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    for (const StateFunction& function : functions_) function.add_marks(span, marks);
  }
  void add_watched(WatchedFunctions& functions) const override {
    for (const StateFunction& function : functions_)
      functions.push_back(std::make_shared<StateFunction>(function));
  }

  void residual(int e, const LocalState& state, LocalResidual& residual) const override {
    for (std::size_t k = 0; k < functions_.size(); ++k) {
      if (!functions_[k]) continue;
      const auto [q, v] = arguments(k, state);
      add_force(e, static_cast<int>(k), functions_[k].at(state.t, q.data(), v.data()), state.q,
                residual.force);
    }
  }

  void tangent(int e, const LocalState& state, LocalTangent& tangent) const override {
    std::vector<double> by_q, by_v, direction(static_cast<std::size_t>(own_));
    for (std::size_t k = 0; k < functions_.size(); ++k) {
      if (!functions_[k]) continue;
      const auto [q, v] = arguments(k, state);
      by_q.resize(q.size());
      by_v.resize(q.size());
      const double size = functions_[k].at(state.t, q.data(), v.data(), by_q.data(), by_v.data());
      add_stiffness(static_cast<int>(k), size, state.q, tangent.force_q);
      std::fill(direction.begin(), direction.end(), 0.0);
      add_force(e, static_cast<int>(k), 1.0, state.q, direction.data());
      for (int i = 0; i < own_; ++i)
        for (std::size_t j = 0; j < q.size(); ++j) {
          const int entry = i * count_ + places_[k][j];
          tangent.force_q[entry] += direction[i] * by_q[j];
          if (tangent.force_v != nullptr) tangent.force_v[entry] += direction[i] * by_v[j];
        }
    }
  }

 protected:
  /// Whether directions depend on the own coordinates.
  virtual bool turns() const { return false; }
  /// Adds -size B_k to the forces on the own coordinates of element e.
  virtual void add_force(int e, int k, double size, const double* q, double* force) const = 0;
  /// Adds the derivative of that, at constant size, to the rows of `force_q`.
  virtual void add_stiffness(int, double, const double*, double*) const {}

  int count() const { return count_; }

 private:
  std::pair<std::vector<double>, std::vector<double>> arguments(std::size_t k,
                                                                const LocalState& state) const {
    std::vector<double> q, v;
    for (const int place : places_[k]) {
      q.push_back(state.q[place]);
      v.push_back(state.v[place]);
    }
    return {q, v};
  }

  std::string name_;
  int own_, count_;
  std::vector<StateFunction> functions_;
  std::vector<std::vector<int>> places_;  // of each function's coordinates among the element's
  std::vector<int> coordinates_;
};

/// A force or torque on a frame.
class FrameLoad final : public LoadGroup {
 public:
  FrameLoad(std::string name, const std::vector<int>& frame, std::vector<StateFunction> sizes,
            const Attachment& attachment, LoadAxes axes, bool torque)
      : LoadGroup(std::move(name), frame, 7, std::move(sizes)),
        point_(attachment.point),
        axes_(attachment.axes),
        follows_(axes == LoadAxes::attachment),
        is_torque_(torque) {}

 protected:
  bool turns() const override { return true; }
  void add_force(int, int k, double size, const double* q, double* force) const override {
    std::array<double, 7> b;
    direction(q, k, b);
    for (int i = 0; i < 7; ++i) force[i] -= size * b[i];
  }
  void add_stiffness(int k, double size, const double* q, double* force_q) const override {
    std::array<Dual<7>, 7> b;
    direction(seeded<7>(q).data(), k, b);
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < 7; ++j) force_q[i * count() + j] -= size * b[i].derivatives()[j];
  }

 private:
  /// What works along component k, per unit of it: of a force c the gradient of c . (r + A(p) s) with c held;
  /// of a torque, n' in body axes, 2 G^T n'.
  template <class T>
  void direction(const T* q, int k, std::array<T, 7>& b) const {
    const T* p = q + 3;
    Quadruple<T> by_p;
    for (int i = 0; i < 3; ++i) b[i] = T(0.0 * p[0]);
    if (is_torque_) {
      const T back[] = {p[0], T(-p[1]), T(-p[2]), T(-p[3])};
      const Eigen::Vector3d axis = axes_.col(k);
      by_p = g_transposed_times(p, follows_ ? Triple<T>{T(axis[0]), T(axis[1]), T(axis[2])}
                                            : rotate(back, Eigen::Vector3d(Eigen::Vector3d::Unit(k))));
      for (int i = 0; i < 4; ++i) b[3 + i] = 2.0 * by_p[i];
      return;
    }
    const Triple<T> c = follows_
                            ? rotate(p, Eigen::Vector3d(axes_.col(k)))
                            : Triple<T>{T(k == 0 ? 1.0 : 0.0), T(k == 1 ? 1.0 : 0.0), T(k == 2 ? 1.0 : 0.0)};
    const Eigen::Vector3d& s = point_;
    const T along = s[0] * c[0] + s[1] * c[1] + s[2] * c[2];
    const T e_c = p[1] * c[0] + p[2] * c[1] + p[3] * c[2], e_s = s[0] * p[1] + s[1] * p[2] + s[2] * p[3];
    const Triple<T> s_x_c{T(s[1] * c[2] - s[2] * c[1]), T(s[2] * c[0] - s[0] * c[2]),
                          T(s[0] * c[1] - s[1] * c[0])};
    b[3] = 2.0 * (p[0] * along + p[1] * s_x_c[0] + p[2] * s_x_c[1] + p[3] * s_x_c[2]);
    for (int i = 0; i < 3; ++i) {
      b[i] = c[i];
      b[4 + i] = 2.0 * (s[i] * e_c + e_s * c[i] + p[0] * s_x_c[i] - along * p[1 + i]);
    }
  }

  Eigen::Vector3d point_;
  Eigen::Matrix3d axes_;
  bool follows_, is_torque_;
};

/// The coordinates of one element, each with a function of its own, of which it takes a fraction.
class FractionLoad final : public LoadGroup {
 public:
  FractionLoad(std::string name, const std::vector<int>& coordinates, std::vector<double> fractions,
               const std::vector<StateFunction>& sizes)
      : LoadGroup(std::move(name), coordinates, static_cast<int>(sizes.size()), sizes),
        fractions_(std::move(fractions)) {}

 protected:
  void add_force(int e, int k, double size, const double*, double* force) const override {
    force[k] -= fractions_[e] * size;
  }

 private:
  std::vector<double> fractions_;
};

struct CoordinateSpringFormulas : SpringLaw {
  static constexpr bool kIsLength = false;
  template <class T>
  void positions(double, const T* q, T* x) const {
    x[0] = q[0];
  }
};

void check_any(const std::array<StateFunction, 3>& load, const std::string& owner) {
  if (!load[0] && !load[1] && !load[2]) throw InvalidInput(owner, "it has no function of time");
}

void add_frame_load(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                    const std::array<StateFunction, 3>& load, LoadAxes axes, bool torque) {
  const std::string owner = "force " + name;
  check_any(load, owner);
  if (attachment.frame.is_ground()) throw InvalidInput(owner, "it acts on the ground");
  if (!attachment.point.allFinite()) throw InvalidInput(owner, "its point is not finite");
  check_axes(attachment.axes, owner);
  std::vector<int> frame;
  for (int k = 0; k < 7; ++k) frame.push_back(attachment.frame.first + k);
  builder.add(std::make_shared<FrameLoad>(owner, frame, std::vector<StateFunction>(load.begin(), load.end()),
                                          attachment, axes, torque));
}

}  // namespace

void add_point_force(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                     const std::array<StateFunction, 3>& force, LoadAxes axes) {
  add_frame_load(builder, name, attachment, force, axes, false);
}

void add_torque(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                const std::array<StateFunction, 3>& torque, LoadAxes axes) {
  add_frame_load(builder, name, attachment, torque, axes, true);
}

void add_nodal_force(MultibodyBuilder& builder, const std::string& name, CoordinateRange body,
                     const std::vector<int>& nodes, const std::vector<double>& fractions,
                     const std::array<StateFunction, 3>& force) {
  const std::string owner = "force " + name;
  check_any(force, owner);
  if (nodes.empty()) throw InvalidInput(owner, "it acts on no node");
  if (fractions.size() != nodes.size())
    throw InvalidInput(owner, std::to_string(nodes.size()) + " nodes, but " +
                                  std::to_string(fractions.size()) + " fractions");
  builder.add(std::make_shared<FractionLoad>(owner, node_coordinates(body, nodes, owner), fractions,
                                             std::vector<StateFunction>(force.begin(), force.end())));
}

void add_coordinate_force(MultibodyBuilder& builder, const std::string& name, int coordinate,
                          const StateFunction& force) {
  const std::string owner = "force " + name;
  if (!force) throw InvalidInput(owner, "it has no function of time");
  builder.add(std::make_shared<FractionLoad>(owner, std::vector<int>{coordinate}, std::vector<double>{1.0},
                                             std::vector<StateFunction>{force}));
}

void add_coordinate_spring(MultibodyBuilder& builder, const CoordinateSpring& spring) {
  const std::string owner = "spring " + spring.name;
  for (const double value : {spring.stiffness, spring.damping})
    if (!(value >= 0) || !std::isfinite(value))
      throw InvalidInput(owner, "its stiffness or damping is negative");
  if (!std::isfinite(spring.free)) throw InvalidInput(owner, "where it is relaxed is not finite");
  if (spring.force && spring.stiffness > 0)
    throw InvalidInput(owner, "it has both a stiffness and a function");
  const Function force = spring.force ? spring.force : linear_function(0.0, spring.stiffness);
  builder.add(std::make_shared<CompliantElement<CoordinateSpringFormulas, 1>>(
      owner, std::array<int, 1>{spring.coordinate},
      CoordinateSpringFormulas{{spring.free, spring.damping, force}}));
}

}  // namespace mfs::dae
