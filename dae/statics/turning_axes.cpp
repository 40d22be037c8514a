#include "dae/statics/turning_axes.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

#include "dae/mechanics/rotation.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Quaternion = Quadruple<double>;

/// What velocities may be off from those of one body, in parts of the largest, as steps leave errors in them.
constexpr double kAsOneBody = 1e-3;
/// Velocities and accelerations below it are what steps leave, in units of the system.
constexpr double kRounding = 1e-4;
/// Of the kinds of vectors_of().
constexpr double kTrust[] = {1.0, 1e-3, 1e-3, 1.0};

Vector3d vector_at(const std::vector<double>& of, int first) {
  return {of[first], of[first + 1], of[first + 2]};
}
Quaternion quaternion_at(const std::vector<double>& of, int first) {
  return {of[first], of[first + 1], of[first + 2], of[first + 3]};
}
Quaternion conjugate(const Quaternion& p) {
  return {p[0], -p[1], -p[2], -p[3]};
}
Quaternion half_of(const Vector3d& w) {
  return {0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
}
/// 2 (x y*) without its scalar part: of p' and p the angular velocity in ground axes.
Vector3d turn_of(const Quaternion& x, const Quaternion& y) {
  const Quaternion z = product(x, conjugate(y));
  return 2.0 * Vector3d(z[1], z[2], z[3]);
}
/// Of a linear map.
template <class Map>
Matrix4d matrix_of(const Map& map) {
  Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    Quaternion unit{};
    unit[i] = 1.0;
    const Quaternion image = map(unit);
    for (int k = 0; k < 4; ++k) matrix(k, i) = image[k];
  }
  return matrix;
}
Matrix4d from_left(const Quaternion& left) {
  return matrix_of([&](const Quaternion& x) { return product(left, x); });
}
Matrix4d from_right(const Quaternion& right) {
  return matrix_of([&](const Quaternion& x) { return product(x, right); });
}

/// First of their Euler parameters; the three coordinates before these are their places.
std::vector<int> frames_of(const ConstrainedSystem& system) {
  const Pattern& pattern = system.tangent_pattern()[Block::position_q];
  std::vector<int> frames;
  for (int row = 0; row < pattern.rows; ++row)
    if (system.is_normalization(row)) frames.push_back(pattern.column[pattern.row_start[row]]);
  return frames;
}

/// First coordinates of places.
std::vector<int> places_of(const ConstrainedSystem& system, const std::vector<int>& frames) {
  std::vector<int> places;
  for (const int frame : frames) places.push_back(frame - 3);
  for (const PointRange& range : turning_bodies_of(system))
    for (int i = 0; i < range.count; ++i) places.push_back(range.first + 3 * i);
  return places;
}

/// Of points of equal masses, by their angular momentum.
Vector3d turn_of_points(const std::vector<int>& places, const State& state) {
  Vector3d centre = Vector3d::Zero(), momentum = Vector3d::Zero();
  for (const int place : places) centre += vector_at(state.q, place) / static_cast<double>(places.size());
  Matrix3d inertia = Matrix3d::Zero();
  for (const int place : places) {
    const Vector3d arm = vector_at(state.q, place) - centre;
    momentum += arm.cross(vector_at(state.v, place));
    inertia -= cross_matrix(arm) * cross_matrix(arm);
  }
  const Eigen::FullPivLU<Matrix3d> lu(inertia);
  return lu.isInvertible() ? Vector3d(lu.solve(momentum)) : Vector3d(Vector3d::Zero());
}

bool does_move(const State& state) {
  return std::any_of(state.v.begin(), state.v.end(), [](double v) { return std::abs(v) > 1e-9; });
}

/// What turns as the axes do where a motion is steady: angular velocities and accelerations, accelerations of
/// places and their distances from the first one.
std::vector<Matrix3Xd> vectors_of(const std::vector<int>& frames, const std::vector<int>& places,
                                  const State& state) {
  const auto n = static_cast<Index>(frames.size()), m = static_cast<Index>(places.size());
  std::vector<Matrix3Xd> kinds{Matrix3Xd(3, n), Matrix3Xd(3, n), Matrix3Xd(3, m), Matrix3Xd(3, m)};
  for (Index i = 0; i < n; ++i) {
    const Quaternion p = quaternion_at(state.q, frames[i]);
    kinds[0].col(i) = turn_of(quaternion_at(state.v, frames[i]), p);
    kinds[1].col(i) = turn_of(quaternion_at(state.a, frames[i]), p);
  }
  for (Index i = 0; i < m; ++i) {
    kinds[2].col(i) = vector_at(state.a, places[i]);
    kinds[3].col(i) = vector_at(state.q, places[i]) - vector_at(state.q, places[0]);
  }
  return kinds;
}

/// The rotation that takes vectors nearest to others (Wahba; Kabsch). What is less than rounding of a motion
/// has no direction. Accelerations, which errors of steps and vibrations change, tell what the others leave
/// open.
Matrix3d turn_between(const std::vector<Matrix3Xd>& before, const std::vector<Matrix3Xd>& after) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t kind = 0; kind < before.size(); ++kind)
    if (const double size = before[kind].size() == 0 ? 0.0 : before[kind].colwise().norm().maxCoeff();
        size > kRounding)
      sum += kTrust[kind] / (size * size) * after[kind] * before[kind].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

}  // namespace

TurningAxes::TurningAxes(const ConstrainedSystem& system, const State& state) {
  moves_ = does_move(state);
  if (!moves_) return;
  const std::vector<int> frames = frames_of(system), places = places_of(system, frames);
  kind_ = find_common_turn(frames, places, state) ? Kind::along : Kind::of_ground;
  make_parts(frames, places, state);
}

TurningAxes TurningAxes::of_ground(const ConstrainedSystem& system, const State& state) {
  TurningAxes axes;
  axes.moves_ = does_move(state);
  const std::vector<int> frames = frames_of(system);
  axes.make_parts(frames, {}, state);
  return axes;
}

TurningAxes TurningAxes::precessing(const ConstrainedSystem& system, const State& state, const State& later) {
  TurningAxes axes;
  axes.kind_ = Kind::precessing;
  axes.moves_ = does_move(state);
  const std::vector<int> frames = frames_of(system), places = places_of(system, frames);
  const Eigen::AngleAxisd turned(
      turn_between(vectors_of(frames, places, state), vectors_of(frames, places, later)));
  axes.rate_ = turned.angle() / (later.t - state.t) * turned.axis();
  axes.make_parts(frames, places, state);
  return axes;
}

double TurningAxes::fastest(const ConstrainedSystem& system, const State& state) {
  const std::vector<int> frames = frames_of(system), places = places_of(system, frames);
  double fastest = 0.0, extent = 0.0, velocity = 0.0, acceleration = 0.0;
  const auto turns = [&fastest](double rate, double change) {
    fastest = std::max({fastest, rate, std::sqrt(change)});
  };
  for (const int frame : frames) {
    const Quaternion p = quaternion_at(state.q, frame);
    turns(turn_of(quaternion_at(state.v, frame), p).norm(), turn_of(quaternion_at(state.a, frame), p).norm());
  }
  for (const int place : places) {
    extent = std::max({extent, system.coordinate_scale(place),
                       (vector_at(state.q, place) - vector_at(state.q, places.front())).norm()});
    velocity = std::max(velocity, vector_at(state.v, place).norm());
    acceleration = std::max(acceleration, vector_at(state.a, place).norm());
  }
  if (extent > 0.0) turns(velocity / extent, acceleration / extent);
  return fastest;
}

void TurningAxes::make_parts(const std::vector<int>& frames, const std::vector<int>& places,
                             const State& state) {
  const Matrix4d rate = from_left(half_of(rate_)), change = from_left(half_of(change_));
  for (const int frame : frames) {
    const Quaternion back = conjugate(quaternion_at(state.q, frame));
    Part part{frame, 4, {}, {}};
    if (kind_ == Kind::along) {
      part.w = rate;
      part.u = change + rate * rate;
    } else if (kind_ == Kind::of_ground) {
      part.w = from_right(product(back, quaternion_at(state.v, frame)));
      part.u = from_right(product(back, quaternion_at(state.a, frame)));
    } else {
      // p' = (rate / 2) p + p (spin / 2)
      const Quaternion spin = product(back, quaternion_at(state.v, frame)),
                       along = product(product(back, half_of(rate_)), quaternion_at(state.q, frame));
      part.w = rate + from_right({0.0, spin[1] - along[1], spin[2] - along[2], spin[3] - along[3]});
      part.u = part.w * part.w;
    }
    parts_.push_back(part);
  }
  for (std::size_t i = 0; i < places.size() && kind_ != Kind::of_ground; ++i) {
    Part part{places[i], 3, Matrix4d::Zero(), Matrix4d::Zero()};
    part.w.topLeftCorner<3, 3>() = cross_matrix(rate_);
    part.u.topLeftCorner<3, 3>() = cross_matrix(change_) + cross_matrix(rate_) * cross_matrix(rate_);
    parts_.push_back(part);
  }
}

/// `frames`, `places`: first coordinates.
bool TurningAxes::find_common_turn(const std::vector<int>& frames, const std::vector<int>& places,
                                   const State& state) {
  if (places.empty()) return false;
  const auto rate_of = [&](int frame) {
    return turn_of(quaternion_at(state.v, frame), quaternion_at(state.q, frame));
  };
  // p'' p* has w' / 2 and -w^2 / 4 alone.
  const auto change_of = [&](int frame) {
    return turn_of(quaternion_at(state.a, frame), quaternion_at(state.q, frame));
  };
  rate_ = frames.empty() ? turn_of_points(places, state) : rate_of(frames.front());
  if (!frames.empty()) change_ = change_of(frames.front());
  double largest = 0.0, off = 0.0;
  for (const int place : places) {
    const Vector3d arm = vector_at(state.q, place) - vector_at(state.q, places.front()),
                   along = vector_at(state.v, place) - vector_at(state.v, places.front());
    largest = std::max(largest, arm.norm());
    off = std::max(off, (along - rate_.cross(arm)).norm());
  }
  const bool as_one = rate_.norm() > 0 && off <= kAsOneBody * rate_.norm() * largest &&
                      std::all_of(frames.begin(), frames.end(), [&](int frame) {
                        return (rate_of(frame) - rate_).norm() <= kAsOneBody * rate_.norm();
                      });
  steady_ = as_one && change_.norm() <= kAsOneBody * rate_.squaredNorm();
  return as_one;
}

TurnedSystem::TurnedSystem(const ConstrainedSystem& system, const TurningAxes& axes)
    : system_(system),
      parts_(axes.parts()),
      number_(static_cast<std::size_t>(system.coordinates()), -1),
      pattern_(system.tangent_pattern()) {
  for (std::size_t k = 0; k < parts_.size(); ++k)
    std::fill_n(number_.begin() + parts_[k].first, parts_[k].size, static_cast<int>(k));
  widen(Block::force_v, {Block::force_a});
  widen(Block::force_q, {Block::force_a, Block::force_v});
  widen(Block::velocity_q, {Block::position_q});
}

void TurnedSystem::widen(Block wide, std::initializer_list<Block> by) {
  Pattern& pattern = pattern_.block[static_cast<std::size_t>(wide)];
  const Pattern narrow = pattern;
  pattern = {narrow.rows, narrow.columns, {0}, {}};
  for (int i = 0; i < narrow.rows; ++i) {
    std::set<int> columns(narrow.column.begin() + narrow.row_start[i],
                          narrow.column.begin() + narrow.row_start[i + 1]);
    for (const Block other : by) {
      const Pattern& p = system_.tangent_pattern()[other];
      for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
        if (const TurningAxes::Part* part = part_of(p.column[k]))
          for (int c = 0; c < part->size; ++c) columns.insert(part->first + c);
    }
    for (const int column : columns) pattern.column.push_back(column);
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
}

const TurningAxes::Part* TurnedSystem::part_of(int coordinate) const {
  return number_[coordinate] < 0 ? nullptr : &parts_[number_[coordinate]];
}

void TurnedSystem::add_row(int row, Block from, const std::vector<double>& values, double factor,
                           Matrix4d TurningAxes::Part::*times, Block to, std::vector<double>& sum) const {
  const Pattern &p = system_.tangent_pattern()[from], &wide = pattern_[to];
  const auto begin = wide.column.begin() + wide.row_start[row],
             end = wide.column.begin() + wide.row_start[row + 1];
  for (int k = p.row_start[row]; k < p.row_start[row + 1]; ++k) {
    const TurningAxes::Part* part = part_of(p.column[k]);
    if (part == nullptr) continue;
    const auto place = std::lower_bound(begin, end, part->first) - wide.column.begin();
    for (int c = 0; c < part->size; ++c)
      sum[static_cast<std::size_t>(place + c)] +=
          factor * values[k] * (part->*times)(p.column[k] - part->first, c);
  }
}

void TurnedSystem::evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const {
  Tangent own = make_tangent(system_);
  system_.evaluate(state, own, blocks);
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const auto block = static_cast<Block>(b);
    if (!blocks.has(block)) continue;
    if (block != Block::force_v && block != Block::force_q && block != Block::velocity_q) {
      tangent.values[b] = own.values[b];
      continue;
    }
    const Pattern &narrow = system_.tangent_pattern()[block], &wide = pattern_[block];
    std::fill(tangent.values[b].begin(), tangent.values[b].end(), 0.0);
    for (int i = 0; i < narrow.rows; ++i) {
      auto place = wide.column.begin() + wide.row_start[i];
      for (int k = narrow.row_start[i]; k < narrow.row_start[i + 1]; ++k) {
        place = std::find(place, wide.column.end(), narrow.column[k]);
        tangent.values[b][static_cast<std::size_t>(place - wide.column.begin())] = own.values[b][k];
      }
    }
  }
  for (int row = 0; row < constraints() && blocks.has(Block::velocity_q); ++row)
    if (is_nonholonomic(row))
      add_row(row, Block::position_q, own[Block::position_q], 1.0, &TurningAxes::Part::w, Block::velocity_q,
              tangent[Block::velocity_q]);
  if (!blocks.has(Block::force_q)) return;
  const std::vector<double>&mass = own[Block::force_a], &damping = own[Block::force_v];
  std::vector<double>&by_v = tangent[Block::force_v], &by_q = tangent[Block::force_q];
  for (int i = 0; i < coordinates(); ++i) {
    add_row(i, Block::force_a, mass, 2.0, &TurningAxes::Part::w, Block::force_v, by_v);
    add_row(i, Block::force_v, damping, 1.0, &TurningAxes::Part::w, Block::force_q, by_q);
    add_row(i, Block::force_a, mass, 1.0, &TurningAxes::Part::u, Block::force_q, by_q);
  }
}

}  // namespace mfs::dae
