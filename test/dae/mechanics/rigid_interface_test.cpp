// Residuals of rigid interfaces, which are evaluated for all links together, beside plain loops over the
// links with products of quaternions.
#include "dae/mechanics/rigid_interface.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "dae/mechanics/multibody.hpp"
#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

using test::Random;
using Quaternion = std::array<double, 4>;
using Vector = std::array<double, 3>;

Quaternion multiplied(const Quaternion& p, const Quaternion& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
          p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

/// The vector of (p s u* + u s p*) / 2, which is A(p) s where u = p.
Vector turned(const Quaternion& p, const Vector& s, const Quaternion& u) {
  const auto half = [&](const Quaternion& a, const Quaternion& b) {
    return multiplied(multiplied(a, {0, s[0], s[1], s[2]}), {b[0], -b[1], -b[2], -b[3]});
  };
  const Quaternion one = half(p, u), other = half(u, p);
  return {(one[1] + other[1]) / 2, (one[2] + other[2]) / 2, (one[3] + other[3]) / 2};
}

struct Interface {
  MultibodyBuilder builder;
  std::vector<int> nodes;
  std::vector<Vector> arms;
  int frame = 0;
};

/// Holds every second node of a body, in a shuffled order.
Interface interface_of(Random& random, int links) {
  Interface made;
  const std::vector<double> places = random.vector(6 * links);
  const CoordinateRange body =
      made.builder.add_coordinates("body", places, std::vector<double>(places.size()), {"x", "y", "z"});
  for (const int k : random.permutation(links)) made.nodes.push_back(2 * k);
  const Eigen::Vector3d origin(0.1, -0.2, 0.3);
  made.frame = add_rigid_interface(made.builder, "eye", body, made.nodes, origin).first;
  for (const int node : made.nodes)
    made.arms.push_back(
        {places[3 * node] - origin[0], places[3 * node + 1] - origin[1], places[3 * node + 2] - origin[2]});
  return made;
}

Quaternion parameters(const std::vector<double>& x, int frame) {
  return {x[frame + 3], x[frame + 4], x[frame + 5], x[frame + 6]};
}

/// What the links add to `plain`, whose constraints are theirs from row 0 on.
void add_links(const Interface& eye, const std::vector<double>& q, const std::vector<double>& v,
               const std::vector<double>& a, const std::vector<double>& lambda, Residual& plain) {
  const Quaternion p = parameters(q, eye.frame), rate = parameters(v, eye.frame),
                   second = parameters(a, eye.frame);
  for (std::size_t e = 0; e < eye.nodes.size(); ++e) {
    const Vector &s = eye.arms[e], at = turned(p, s, p), turning = turned(p, s, rate),
                 squares = turned(rate, s, rate), accelerating = turned(p, s, second);
    for (int i = 0; i < 3; ++i) {
      const int node = 3 * eye.nodes[e] + i, origin = eye.frame + i, row = 3 * static_cast<int>(e) + i;
      plain.position[row] += q[node] - q[origin] - at[i];
      plain.velocity[row] += v[node] - v[origin] - 2 * turning[i];
      plain.acceleration[row] += a[node] - a[origin] - 2 * (squares[i] + accelerating[i]);
      plain.force[node] += lambda[row];
      plain.force[origin] -= lambda[row];
      for (int k = 0; k < 4; ++k) {
        Quaternion unit{};
        unit[k] = 1;
        plain.force[eye.frame + 3 + k] -= 2 * turned(unit, s, p)[i] * lambda[row];
      }
    }
  }
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected, double size) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-14 * size) << i;
}

TEST(RigidInterface, AllLinksAtOnceGiveWhatEachDoes) {
  for (const int links : {3, 31, 32, 33, 65, 257})
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(std::to_string(links) + " links, " + std::to_string(threads) + " threads");
      Random random(static_cast<std::uint64_t>(links));
      const Interface eye = interface_of(random, links);
      const auto system = eye.builder.build(threads);
      const int n = system->coordinates(), m = system->constraints();
      ASSERT_EQ(m, 3 * links + 1);  // and the Euler parameters, behind the links or before them
      const std::vector<double> q = random.vector(n), v = random.vector(n), a = random.vector(n);
      std::vector<double> lambda = random.vector(m);
      const int first = system->is_normalization(0) ? 1 : 0;  // of the links
      lambda[first == 0 ? m - 1 : 0] = 0;

      Residual plain = make_residual(*system), found = make_residual(*system);
      add_links(eye, q, v, a, {lambda.begin() + first, lambda.begin() + first + 3 * links}, plain);
      system->evaluate({0.0, q.data(), v.data(), a.data(), lambda.data()}, found);
      const auto links_of = [&](const std::vector<double>& rows) {
        return std::vector<double>(rows.begin() + first, rows.begin() + first + 3 * links);
      };
      const auto leading = [&](std::vector<double> rows) {
        rows.resize(static_cast<std::size_t>(3 * links));
        return rows;
      };
      expect_near(links_of(found.position), leading(plain.position), 10);
      expect_near(links_of(found.velocity), leading(plain.velocity), 20);
      expect_near(links_of(found.acceleration), leading(plain.acceleration), 40);
      expect_near(found.force, plain.force, 10 * links);
    }
}

}  // namespace
}  // namespace mfs::dae
