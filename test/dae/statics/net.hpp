// Masses in a plane on springs whose free lengths do not fit, and the energy of that by plain loops.
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {

/// side x side masses of 0.1 kg, 0.2 m apart in x and y, on springs of 400 N/m to their neighbours along both
/// directions and one diagonal, or to held points around them. Free lengths are 0.8 to 1.25 of the distances;
/// gravity along -z.
class Net {
 public:
  Net(int side, std::uint64_t seed) : side_(side) {
    Random random(seed);
    const int steps[3][2] = {{1, 0}, {0, 1}, {1, 1}};
    for (int i = 0; i < side + 2; ++i)
      for (int j = 0; j < side + 2; ++j)
        for (const auto& step : steps) {
          const int a = point(i, j), b = point(i + step[0], j + step[1]);
          if (i + step[0] > side + 1 || j + step[1] > side + 1 || (body(a) < 0 && body(b) < 0)) continue;
          const double distance = kStep * std::hypot(step[0], step[1]);
          springs_.push_back({a, b, distance * (0.8 + 0.45 * random.unit())});
        }
  }

  int bodies() const { return side_ * side_; }

  dae::Json model() const {
    dae::Json json = {{"name", "net"}, {"end", 1}, {"outputs", 1}, {"gravity", {0, 0, -kGravity}}};
    json["joints"] = dae::Json::object();
    const double inertia = 0.1 * kMass * kStep * kStep;
    for (int p = 0; p < (side_ + 2) * (side_ + 2); ++p)
      if (body(p) >= 0)
        json["bodies"][name(p)] = {{"type", "rigid"},
                                   {"mass", kMass},
                                   {"inertia", {inertia, inertia, inertia}},
                                   {"position", place(p)}};
    for (std::size_t k = 0; k < springs_.size(); ++k)
      json["forces"]["spring" + std::to_string(k)] = {
          {"type", "spring_damper"},         {"a", name(springs_[k].a)},        {"b", name(springs_[k].b)},
          {"point_a", place(springs_[k].a)}, {"point_b", place(springs_[k].b)}, {"stiffness", kStiffness},
          {"free_length", springs_[k].free}};
    return json;
  }

  /// Of the energy, N, where the masses are at `x` (3 for each).
  std::vector<double> gradient(const std::vector<double>& x) const {
    std::vector<double> gradient(x.size(), 0.0);
    for (int b = 0; b < bodies(); ++b) gradient[3 * b + 2] = kMass * kGravity;
    for (const Spring& spring : springs_) {
      const std::vector<double> from = where(spring.a, x), to = where(spring.b, x);
      const double length = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
      for (int c = 0; c < 3; ++c) {
        const double pull = kStiffness * (length - spring.free) * (to[c] - from[c]) / length;
        if (body(spring.a) >= 0) gradient[3 * body(spring.a) + c] -= pull;
        if (body(spring.b) >= 0) gradient[3 * body(spring.b) + c] += pull;
      }
    }
    return gradient;
  }

  /// The least eigenvalue of the energy's second derivatives, N/m.
  double least_stiffness(std::vector<double> x) const {
    constexpr double kDifference = 1e-6;
    const auto n = static_cast<Eigen::Index>(x.size());
    Eigen::MatrixXd second(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double at = x[i];
      x[i] = at + kDifference;
      const std::vector<double> after = gradient(x);
      x[i] = at - kDifference;
      const std::vector<double> before = gradient(x);
      x[i] = at;
      for (Eigen::Index j = 0; j < n; ++j) second(j, i) = (after[j] - before[j]) / (2 * kDifference);
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (second + second.transpose()),
                                                          Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  }

 private:
  static constexpr double kStep = 0.2, kStiffness = 400.0, kMass = 0.1, kGravity = 9.81;
  struct Spring {
    int a, b;  // points
    double free;
  };
  int point(int i, int j) const { return i * (side_ + 2) + j; }
  /// -1: held.
  int body(int point) const {
    const int i = point / (side_ + 2), j = point % (side_ + 2);
    return i < 1 || j < 1 || i > side_ || j > side_ ? -1 : (i - 1) * side_ + j - 1;
  }
  std::string name(int point) const {
    return body(point) < 0 ? "ground" : "mass" + std::to_string(body(point));
  }
  std::vector<double> place(int point) const {
    return {kStep * (point / (side_ + 2)), kStep * (point % (side_ + 2)), 0.0};
  }
  std::vector<double> where(int point, const std::vector<double>& x) const {
    const int b = body(point);
    return b < 0 ? place(point) : std::vector<double>(x.begin() + 3 * b, x.begin() + 3 * b + 3);
  }

  int side_;
  std::vector<Spring> springs_;
};

}  // namespace mfs::test
