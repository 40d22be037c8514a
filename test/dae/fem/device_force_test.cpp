// Forces of a body on the device, and their derivatives, beside those of the host, element by element summed
// plainly.
#include <gmock/gmock.h>

#include <Eigen/Sparse>
#include <cmath>
#include <limits>
#include <mfs/error.hpp>
#include <new>

#include "kernels/cuda/faults.hpp"
#include "test/dae/fem/element_fixtures.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::dae::testing {
namespace {

constexpr int kFirst = 5;  // coordinate of node 0: the body is not alone in its system
constexpr int kAfter = 4;  // coordinates behind it

// Boxes that have these numbers of elements at least, as cubic as can be: coordinates much larger than an
// element would cost digits of its strains on either side.
std::array<int, 3> divisions_for(int elements) {
  int k = 1;
  while (k * k * k < elements) ++k;
  return {k, k, k};
}

SolidGroup body_of(ElementKind kind, int elements, const Material& material, const SolidOptions& options) {
  Mesh mesh = distorted_box(kind, {1.0, 0.8, 0.6}, divisions_for(elements), 3);
  mesh.elements.resize(static_cast<std::size_t>(elements * nodes_per_element(kind)));
  return SolidGroup("body", std::make_shared<const Mesh>(std::move(mesh)), material, options, kFirst);
}

struct State {
  Eigen::VectorXd q, v, a;
  StateView view() const { return {0.0, q.data(), v.data(), a.data(), nullptr}; }
};

// A rotated body with strains of some per cent.
State random_state(const SolidGroup& body, int elements, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double amount = 0.01 / divisions_for(elements)[0];
  const Eigen::Matrix3d r = random_rotation(random);
  const Eigen::VectorXd nodes =
      map_nodes(body.mesh(), [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(r * x); });
  const Eigen::Index n = kFirst + nodes.size() + kAfter;
  State s{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    s.q(i) = amount * uniform(random);
    s.v(i) = 20 * amount * uniform(random);
    s.a(i) = uniform(random);
  }
  s.q.segment(kFirst, nodes.size()) += nodes;
  return s;
}

std::vector<double> device_force(DeviceForce& device, const State& state) {
  std::vector<double> force(static_cast<std::size_t>(state.q.size()), 1.0);  // it is added to what is there
  device.begin(state.view());
  device.add_to(force);
  for (double& f : force) f -= 1.0;
  return force;
}

// The largest sum over the elements of |F| that one coordinate gets: what rounding is relative to.
double size_of_terms(const SolidGroup& body, const State& state) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(state.q.size());
  const int n = body.local_coordinates();
  for (int e = 0; e < body.size(); ++e) {
    const Eigen::Map<const Eigen::VectorXi> where(body.coordinates(e), n);
    const Eigen::VectorXd q = state.q(where), v = state.v(where), a = state.a(where);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(n);
    LocalResidual residual{force.data(), nullptr, nullptr, nullptr};
    body.residual(e, {0, q.data(), v.data(), a.data(), nullptr}, residual);
    sum(where) += force.cwiseAbs();
  }
  return sum.maxCoeff();
}

SolidOptions options_with(double beta, MassKind mass) {
  SolidOptions options;
  options.mass = mass;
  options.damping_alpha = 3.0;
  options.damping_beta = beta;
  options.gravity = {1, -2, -9.81};
  return options;
}

using Case = std::tuple<ElementKind, MaterialLaw, double, MassKind, int>;

class DeviceForceOf : public mfs::test::OnDevice, public ::testing::WithParamInterface<Case> {
 protected:
  const Case& given_ = GetParam();
  const int elements_ = std::get<4>(given_);
  const double beta_ = std::get<2>(given_);
  const unsigned seed_ = std::random_device{}();
  const ::testing::ScopedTrace trace_{__FILE__, __LINE__, "seed " + std::to_string(seed_)};
  const SolidGroup body_ = body_of(std::get<0>(given_), elements_, {std::get<1>(given_), 200.0, 0.3, 5.0},
                                   options_with(beta_, std::get<3>(given_)));
  const State state_ = random_state(body_, elements_, seed_);
};

TEST_P(DeviceForceOf, ABodyIsThatOfTheHost) {
  const Eigen::VectorXd expected = body_force(body_, state_.q, state_.v, state_.a);
  ASSERT_TRUE(expected.allFinite());

  const auto device = body_.device_force(2);
  const std::vector<double> force = device_force(*device, state_);
  const double tolerance = 1e-13 * std::max(1.0, size_of_terms(body_, state_));
  for (std::size_t i = 0; i < force.size(); ++i)
    ASSERT_NEAR(force[i], expected(static_cast<Eigen::Index>(i)), tolerance) << "coordinate " << i;

  EXPECT_EQ(device_force(*device, state_), force);
  EXPECT_EQ(device_force(*body_.device_force(1), state_), force);
}

constexpr Block kTangentBlocks[] = {Block::force_q, Block::force_v};

// dF/dq and dF/dv by the host, in a system with further entries: first and last coordinate of each row, and
// others at random.
struct PlainTangent {
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  Matrix block[2], sizes[2];  // and sums of absolute values
  TangentPattern pattern;

  PlainTangent(const SolidGroup& body, const State& state, unsigned seed) {
    std::mt19937 random(seed);
    const int n = static_cast<int>(state.q.size()), nq = body.local_coordinates();
    std::vector<Eigen::Triplet<double>> entries[2];
    for (int i = 0; i < n; ++i)
      for (auto& some : entries)
        for (const int j : {0, n - 1, static_cast<int>(random() % static_cast<unsigned>(n))})
          some.emplace_back(i, j, 0.0);
    for (int e = 0; e < body.size(); ++e) {
      const ElementTangent tangent = element_tangent(body, e, state.q, state.v);
      for (int i = 0; i < nq; ++i)
        for (int j = 0; j < nq; ++j) {
          const int row = body.coordinates(e)[i], column = body.coordinates(e)[j];
          entries[0].emplace_back(row, column, tangent.force_q(i, j));
          entries[1].emplace_back(row, column, tangent.force_v(i, j));
        }
    }
    for (int b = 0; b < 2; ++b) {
      block[b].resize(n, n);
      sizes[b].resize(n, n);
      block[b].setFromTriplets(entries[b].begin(), entries[b].end());
      for (auto& entry : entries[b]) entry = {entry.row(), entry.col(), std::abs(entry.value())};
      sizes[b].setFromTriplets(entries[b].begin(), entries[b].end());
      const int* start = block[b].outerIndexPtr();
      const int* column = block[b].innerIndexPtr();
      pattern.block[static_cast<std::size_t>(kTangentBlocks[b])] = {
          n, n, {start, start + n + 1}, {column, column + start[n]}};
    }
  }
};

Tangent device_tangent(DeviceForce& device, const State& state, const TangentPattern& pattern,
                       BlockSet blocks) {
  Tangent tangent;
  for (std::size_t b = 0; b < kBlocks; ++b) tangent.values[b].assign(pattern.block[b].entries(), 1.0);
  device.begin(state.view(), blocks);
  device.add_to(tangent, pattern);
  for (auto& values : tangent.values)
    for (double& value : values) value -= 1.0;  // it is added to what is there
  return tangent;
}

TEST_P(DeviceForceOf, ABodyHasTheDerivativesOfTheHost) {
  const PlainTangent plain(body_, state_, seed_);

  const auto device = body_.device_force(2);
  const BlockSet blocks = device->blocks();
  EXPECT_TRUE(blocks.has(Block::force_q));
  EXPECT_EQ(blocks.has(Block::force_v), beta_ > 0);
  const Tangent tangent = device_tangent(*device, state_, plain.pattern, blocks);
  for (std::size_t b = 0; b < 2; ++b) {
    if (!blocks.has(kTangentBlocks[b])) continue;
    const std::vector<double>& values = tangent[kTangentBlocks[b]];
    const double tolerance = 1e-13 * std::max(1.0, plain.sizes[b].coeffs().maxCoeff());
    for (std::size_t k = 0; k < values.size(); ++k) {
      ASSERT_TRUE(std::isfinite(values[k]));
      ASSERT_NEAR(values[k], plain.block[b].valuePtr()[k], tolerance) << "block " << b << ", entry " << k;
    }
  }

  EXPECT_EQ(device_tangent(*device, state_, plain.pattern, blocks).values, tangent.values);
  EXPECT_EQ(device_tangent(*body_.device_force(1), state_, plain.pattern, blocks).values, tangent.values);
  const Tangent by_q = device_tangent(*device, state_, plain.pattern, {Block::force_q});
  EXPECT_EQ(by_q[Block::force_q], tangent[Block::force_q]);
  EXPECT_EQ(by_q[Block::force_v], std::vector<double>(by_q[Block::force_v].size(), 0.0));
}

INSTANTIATE_TEST_SUITE_P(All, DeviceForceOf,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::Values(MaterialLaw::st_venant_kirchhoff,
                                                              MaterialLaw::neo_hookean),
                                            ::testing::Values(0.0, 0.01),
                                            ::testing::Values(MassKind::consistent, MassKind::lumped),
                                            ::testing::Values(1, 31, 33, 257)));

class Device : public mfs::test::OnDevice {
 protected:
  void TearDown() override { cuda::planned_fault = nullptr; }

  const SolidGroup body_ = body_of(ElementKind::hex8, 8, {}, {});
};

TEST_F(Device, DropsWhatWasNotTaken) {
  const State first = random_state(body_, 8, 1), second = random_state(body_, 8, 2);
  const auto device = body_.device_force(1);
  const std::vector<double> expected = device_force(*device, second);
  device->begin(first.view());
  EXPECT_EQ(device_force(*device, second), expected);

  const PlainTangent plain(body_, second, 1);
  const Tangent by_q = device_tangent(*device, second, plain.pattern, {Block::force_q});
  device->begin(first.view(), {Block::force_q});
  EXPECT_EQ(device_force(*device, second), expected);
  device->begin(first.view());
  EXPECT_EQ(device_tangent(*device, second, plain.pattern, {Block::force_q}).values, by_q.values);
}

// On the host, too, this is no exception: the step above is rejected.
TEST_F(Device, AnElementTurnedInsideOutGivesNotANumber) {
  State state = random_state(body_, 8, 1);
  const int* coordinates = body_.coordinates(0);
  for (int k = 0; k < 3; ++k) std::swap(state.q(coordinates[k]), state.q(coordinates[18 + k]));
  const std::vector<double> force = device_force(*body_.device_force(1), state);
  for (int n = 0; n < body_.local_coordinates(); ++n)
    EXPECT_TRUE(std::isnan(force[static_cast<std::size_t>(coordinates[n])]));

  const PlainTangent plain(body_, state, 1);
  const Tangent tangent = device_tangent(*body_.device_force(1), state, plain.pattern, {Block::force_q});
  for (int k = 0; k < plain.block[0].nonZeros(); ++k)
    EXPECT_EQ(std::isnan(tangent[Block::force_q][static_cast<std::size_t>(k)]),
              std::isnan(plain.block[0].valuePtr()[k]));
}

TEST_F(Device, EveryCallThatFailsIsToldAndForgotten) {
  const State state = random_state(body_, 8, 1);
  const std::vector<double> expected = device_force(*body_.device_force(1), state);
  const PlainTangent plain(body_, state, 1);
  const auto evaluate = [&](DeviceForce& device) {
    (void)device_force(device, state);
    (void)device_tangent(device, state, plain.pattern, {Block::force_q});
  };
  bool met = true;
  for (long n = 0; met; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto sound = body_.device_force(1);
    cuda::Fault fault{n};
    const auto use = [&](bool make_one) {
      cuda::planned_fault = &fault;
      bool told = true;
      try {
        if (make_one) evaluate(*body_.device_force(1));
        if (!make_one) evaluate(*sound);
        told = false;
      } catch (const BackendError&) {
        EXPECT_EQ(fault.kind, cuda::CallKind::runtime);
      } catch (const OutOfMemory&) {
        EXPECT_EQ(fault.kind, cuda::CallKind::device_memory);
      } catch (const std::bad_alloc&) {
        EXPECT_EQ(fault.kind, cuda::CallKind::host_memory);
      }
      cuda::planned_fault = nullptr;
      EXPECT_EQ(told, fault.met);
    };
    use(false);
    EXPECT_EQ(device_force(*sound, state), expected);
    fault = {n};
    use(true);
    met = fault.met;
    ASSERT_LT(n, 100);
  }
}

}  // namespace
}  // namespace mfs::dae::testing
