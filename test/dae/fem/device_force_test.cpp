// Forces of a body on the device, and their derivatives, beside those of the host, element by element summed
// plainly.
#include <gmock/gmock.h>

#include <Eigen/Sparse>
#include <cmath>
#include <limits>
#include <memory>
#include <mfs/error.hpp>
#include <new>
#include <random>

#include "kernels/cuda/runtime/faults.hpp"
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

std::unique_ptr<DeviceForce> make_device(const SolidGroup& body, const State& state, int threads) {
  return body.device_force(static_cast<int>(state.q.size()), threads);
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

  const auto device = make_device(body_, state_, 2);
  const std::vector<double> force = device_force(*device, state_);
  const double tolerance = 1e-13 * std::max(1.0, size_of_terms(body_, state_));
  for (std::size_t i = 0; i < force.size(); ++i)
    ASSERT_NEAR(force[i], expected(static_cast<Eigen::Index>(i)), tolerance) << "coordinate " << i;

  EXPECT_EQ(device_force(*device, state_), force);
  EXPECT_EQ(device_force(*make_device(body_, state_, 1), state_), force);
}

/// factor[0] dF/da + factor[1] dF/dv + factor[2] dF/dq by the host, and sums of absolute values.
struct PlainSum {
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  Matrix value, size;

  PlainSum(const SolidGroup& body, const State& state, const ByAVQ& factor) {
    const auto n = state.q.size();
    const int nq = body.local_coordinates();
    std::vector<Eigen::Triplet<double>> values, sizes;
    for (int e = 0; e < body.size(); ++e) {
      const ElementTangent tangent = element_tangent(body, e, state.q, state.v);
      for (int i = 0; i < nq; ++i)
        for (int j = 0; j < nq; ++j) {
          const int row = body.coordinates(e)[i], column = body.coordinates(e)[j];
          const double terms[] = {factor[0] * tangent.force_a(i, j), factor[1] * tangent.force_v(i, j),
                                  factor[2] * tangent.force_q(i, j)};
          values.emplace_back(row, column, terms[0] + terms[1] + terms[2]);
          sizes.emplace_back(row, column, std::abs(terms[0]) + std::abs(terms[1]) + std::abs(terms[2]));
        }
    }
    value.resize(n, n);
    size.resize(n, n);
    value.setFromTriplets(values.begin(), values.end());
    size.setFromTriplets(sizes.begin(), sizes.end());
  }
  double tolerance() const { return 1e-13 * std::max(1.0, size.coeffs().maxCoeff()); }
};

/// Places in a matrix whose rows have entries of others, too, some of them at the same places. Some columns
/// of dF/dv and dF/dq go where those of dF/da go, some have entries of their own.
struct SomePlaces {
  std::vector<int> target[3];
  std::vector<int> others;
  std::size_t count = 0;

  SomePlaces(const Pattern& pattern, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<int> apart(static_cast<std::size_t>(pattern.columns));  // bits: dF/dv, dF/dq
    for (int& bits : apart) bits = static_cast<int>(random() % 4);
    int next = 0;
    for (int row = 0; row < pattern.rows; ++row) {
      others.push_back(next++);
      if (random() % 2 == 0) others.push_back(next);  // the first of ours, if there is one, and theirs
      const auto first = pattern.column.begin() + pattern.row_start[row];
      const auto end = pattern.column.begin() + pattern.row_start[row + 1];
      for (int b = 0; b < 3; ++b)
        for (auto column = first; column != end; ++column) {
          const bool own = b == 0 || ((apart[static_cast<std::size_t>(*column)] >> (b - 1)) & 1) != 0;
          target[b].push_back(own ? next++
                                  : target[0][static_cast<std::size_t>(column - pattern.column.begin())]);
        }
    }
    count = static_cast<std::size_t>(next) + 1;
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
  std::unique_ptr<RemoteMatrix> give(DeviceForce& device) const {
    auto matrix = device.make_matrix(count, others);
    device.place({target[0].data(), target[1].data(), target[2].data()}, *matrix);
    return matrix;
  }
  double number_of_others(std::size_t k) const { return 1.0 + 0.01 * static_cast<double>(k % 7); }
  void begin(RemoteMatrix& matrix) const {
    double* const own = matrix.own();
    for (std::size_t k = 0; k < others.size(); ++k) own[k] = number_of_others(k);
    matrix.begin();
  }
  /// All entries but for what others have.
  std::vector<double> read(RemoteMatrix& matrix) const {
    std::vector<double> values(count);
    matrix.read(values.data());
    for (std::size_t k = 0; k < others.size(); ++k)
      values[static_cast<std::size_t>(others[k])] -= number_of_others(k);
    return values;
  }
  /// The sum of the entries in the three places of each entry, once where some are the same.
  std::vector<double> gather(const std::vector<double>& matrix) const {
    std::vector<double> values;
    for (std::size_t k = 0; k < target[0].size(); ++k) {
      values.push_back(matrix[static_cast<std::size_t>(target[0][k])]);
      for (int b = 1; b < 3; ++b)
        if (target[b][k] != target[0][k]) values.back() += matrix[static_cast<std::size_t>(target[b][k])];
    }
    return values;
  }
};

constexpr ByAVQ kFactor{0.7, 0.03, 0.002};

std::vector<double> device_sum(DeviceForce& device, RemoteMatrix& matrix, const State& state,
                               const SomePlaces& places, const ByAVQ& factor = kFactor) {
  device.begin_tangent(state.view());
  places.begin(matrix);
  device.begin_sum(factor);
  return places.gather(places.read(matrix));
}

TEST_P(DeviceForceOf, ABodyHasTheDerivativesOfTheHost) {
  const auto device = make_device(body_, state_, 2);
  const Pattern& pattern = device->pattern();
  const SomePlaces places(pattern, seed_);
  const auto matrix = places.give(*device);
  for (const ByAVQ& factor : {kFactor, ByAVQ{1, 0, 0}, ByAVQ{0, 1, 0}, ByAVQ{0, 0, 1}}) {
    const PlainSum plain(body_, state_, factor);
    const double tolerance = plain.tolerance();
    ASSERT_EQ(pattern.entries(), static_cast<std::size_t>(plain.value.nonZeros()));
    const std::vector<double> sum = device_sum(*device, *matrix, state_, places, factor);
    for (std::size_t k = 0; k < sum.size(); ++k) {
      ASSERT_EQ(pattern.column[k], plain.value.innerIndexPtr()[k]);
      ASSERT_TRUE(std::isfinite(sum[k]));
      ASSERT_NEAR(sum[k], plain.value.valuePtr()[k], tolerance) << "entry " << k;
    }
    for (int i = 0; i <= pattern.rows; ++i)
      ASSERT_EQ(pattern.row_start[static_cast<std::size_t>(i)], plain.value.outerIndexPtr()[i]);

    DiagonalsByAVQ diagonals;
    for (auto& diagonal : diagonals)
      diagonal.assign(static_cast<std::size_t>(pattern.rows), 1.0);  // they are added to what is there
    device->add_diagonals(factor, diagonals);
    for (int i = 0; i < pattern.rows; ++i) {
      double sum = 0.0;
      for (std::size_t b = 0; b < diagonals.size(); ++b) {
        const double added = diagonals[b][static_cast<std::size_t>(i)] - 1.0;
        if (factor[b] == 0.0) ASSERT_EQ(added, 0.0);
        sum += added;
      }
      ASSERT_NEAR(sum, plain.value.coeff(i, i), tolerance);
    }
  }
}

TEST_P(DeviceForceOf, EntriesOfOthersStayAndSumsRepeat) {
  const auto device = make_device(body_, state_, 2), other = make_device(body_, state_, 1);
  const SomePlaces first(device->pattern(), seed_), second(device->pattern(), seed_ + 1);
  const auto matrix = first.give(*device), others_matrix = first.give(*other);
  const std::vector<double> sum = device_sum(*device, *matrix, state_, first);
  EXPECT_EQ(device_sum(*other, *others_matrix, state_, first), sum);
  EXPECT_EQ(device_sum(*device, *matrix, state_, first), sum);

  const auto another = second.give(*device);
  second.begin(*another);
  device->begin_sum(kFactor);
  const std::vector<double> values = second.read(*another);
  std::vector<char> ours(second.count);
  for (const auto& target : second.target)
    for (const int entry : target) ours[static_cast<std::size_t>(entry)] = 1;
  for (std::size_t k = 0; k < second.count; ++k) EXPECT_TRUE(ours[k] != 0 || values[k] == 0.0) << k;
}

TEST_P(DeviceForceOf, TwoBodiesAddToOneMatrix) {
  const auto one = make_device(body_, state_, 2), two = make_device(body_, state_, 1);
  const SomePlaces places(one->pattern(), seed_);
  const auto alone = places.give(*one);
  const std::vector<double> sum = device_sum(*one, *alone, state_, places);

  // The second body's entries follow those of the first.
  const int n = static_cast<int>(places.count);
  SomePlaces behind = places;
  for (auto& target : behind.target)
    for (int& entry : target) entry += n;
  const auto both = one->make_matrix(2 * places.count, {});
  one->place({places.target[0].data(), places.target[1].data(), places.target[2].data()}, *both);
  two->place({behind.target[0].data(), behind.target[1].data(), behind.target[2].data()}, *both);
  for (const auto& body : {one.get(), two.get()}) body->begin_tangent(state_.view());
  both->begin();
  for (const auto& body : {one.get(), two.get()}) body->begin_sum(kFactor);
  std::vector<double> values(2 * places.count);
  both->read(values.data());
  const double tolerance = PlainSum(body_, state_, kFactor).tolerance();
  for (const SomePlaces& some : {places, behind}) {
    const std::vector<double> gathered = some.gather(values);
    for (std::size_t k = 0; k < sum.size(); ++k) ASSERT_NEAR(gathered[k], sum[k], tolerance);
  }
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
  const auto device = make_device(body_, first, 1);
  const std::vector<double> expected = device_force(*device, second);
  device->begin(first.view());
  EXPECT_EQ(device_force(*device, second), expected);

  const SomePlaces places(device->pattern(), 1);
  const auto matrix = places.give(*device);
  const std::vector<double> sum = device_sum(*device, *matrix, second, places);
  device->begin_tangent(first.view());
  EXPECT_EQ(device_force(*device, second), expected);
  device->begin(first.view());
  EXPECT_EQ(device_sum(*device, *matrix, second, places), sum);
  device->begin_sum({1, 1, 1});
  EXPECT_EQ(device_sum(*device, *matrix, second, places), sum);
}

// On the host, too, this is no exception: the step above is rejected.
TEST_F(Device, AnElementTurnedInsideOutGivesNotANumber) {
  State state = random_state(body_, 8, 1);
  const int* coordinates = body_.coordinates(0);
  for (int k = 0; k < 3; ++k) std::swap(state.q(coordinates[k]), state.q(coordinates[18 + k]));
  const auto device = make_device(body_, state, 1);
  const std::vector<double> force = device_force(*device, state);
  for (int n = 0; n < body_.local_coordinates(); ++n)
    EXPECT_TRUE(std::isnan(force[static_cast<std::size_t>(coordinates[n])]));

  const PlainSum plain(body_, state, kFactor);
  const SomePlaces places(device->pattern(), 1);
  const auto matrix = places.give(*device);
  const std::vector<double> sum = device_sum(*device, *matrix, state, places);
  for (std::size_t k = 0; k < sum.size(); ++k)
    EXPECT_EQ(std::isnan(sum[k]), std::isnan(plain.value.valuePtr()[k]));
}

TEST_F(Device, EveryCallThatFailsIsToldAndForgotten) {
  const State state = random_state(body_, 8, 1);
  const std::vector<double> expected = device_force(*make_device(body_, state, 1), state);
  const SomePlaces places(make_device(body_, state, 1)->pattern(), 1);
  const auto evaluate = [&](DeviceForce& device) {
    (void)device_force(device, state);
    const auto matrix = places.give(device);
    device.begin_tangent(state.view());
    DiagonalsByAVQ diagonals;
    for (auto& diagonal : diagonals) diagonal.resize(state.q.size());
    device.add_diagonals(kFactor, diagonals);
    places.begin(*matrix);
    device.begin_sum(kFactor);
    (void)places.read(*matrix);
  };
  bool met = true;
  for (long n = 0; met; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const auto sound = make_device(body_, state, 1);
    cuda::Fault fault{n};
    const auto use = [&](bool make_one) {
      cuda::planned_fault = &fault;
      bool told = true;
      try {
        if (make_one) evaluate(*make_device(body_, state, 1));
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
    ASSERT_LT(n, 200);
  }
}

}  // namespace
}  // namespace mfs::dae::testing
