// Assembly: patterns, sums and their independence of threads, against plain loops over dense matrices.
#include "dae/mechanics/multibody.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "test/dae/mechanics/artificial_group.hpp"
#include "test/dae/mechanics/expect_refused.hpp"
#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

using test::ArtificialGroup;
using test::expect_refused;
using test::Random;
using Kind = LocalStructure::Kind;
using Entries = std::map<std::pair<int, int>, double>;

/// Elements whose coordinates come in threes, as nodes of a mesh do, in any order, with some single ones.
std::vector<int> random_coordinates(Random& random, int elements, int nodes_each, bool with_single, int n) {
  std::vector<int> all;
  for (int e = 0; e < elements; ++e) {
    const std::vector<int> order = random.permutation(n / 3);
    for (int k = 0; k < nodes_each; ++k)
      for (int c = 0; c < 3; ++c) all.push_back(3 * order[k] + c);
    if (with_single) all.push_back(3 * order[nodes_each] + static_cast<int>(random.integer(0, 3)));
  }
  return all;
}

struct Parts {
  MultibodyBuilder builder;
  std::vector<std::shared_ptr<ArtificialGroup>> groups;
  std::vector<double> q, v, a, lambda;
  StateView state() const { return {0.7, q.data(), v.data(), a.data(), lambda.data()}; }
};

/// `kinds`: structure of the blocks of F of each group; every third group has constraints.
Parts random_parts(std::uint64_t seed, int n) {
  Random random(seed);
  Parts parts;
  parts.q = random.vector(n);
  parts.v = random.vector(n);
  parts.a = random.vector(n);
  parts.lambda = random.vector(n);
  parts.builder.add_coordinates("front", std::vector<double>(6), std::vector<double>(6));
  parts.builder.add_coordinates("rest", std::vector<double>(n - 6), std::vector<double>(n - 6),
                                {"x", "y", "z"});
  for (int g = 0; g < 6; ++g) {
    const bool single = random.chance(0.5);
    const int nodes = static_cast<int>(random.integer(1, 5)),
              elements = static_cast<int>(random.integer(1, 8));
    LocalStructure structure;
    const Kind kinds[] = {Kind::zero, Kind::diagonal, Kind::dense};
    structure.force_q = kinds[random.integer(0, 3)];
    structure.force_v = kinds[random.integer(0, 3)];
    structure.force_a = kinds[random.integer(0, 3)];
    if (random.chance(0.3)) structure.coupled_from = static_cast<int>(random.integer(1, 3 * nodes + 1));
    parts.groups.push_back(std::make_shared<ArtificialGroup>(
        "group " + std::to_string(g), 3 * nodes + single, g % 3 == 2 ? 2 : 0,
        random_coordinates(random, elements, nodes, single, n), structure));
    parts.builder.add(parts.groups.back());
  }
  return parts;
}

/// The plain sum of what the groups give.
struct PlainSum {
  Entries block[kBlocks];
  std::vector<double> force, position, velocity, acceleration;

  PlainSum(const Parts& parts, int n) : force(n) {
    for (const auto& group : parts.groups)
      for (int e = 0; e < group->size(); ++e) add(*group, e, parts);
  }
  void add(const ArtificialGroup& group, int e, const Parts& parts) {
    const int nq = group.local_coordinates(), nc = group.local_constraints();
    const int* c = group.coordinates(e);
    const int row = static_cast<int>(position.size());
    std::vector<double> q, v, a;
    for (int k = 0; k < nq; ++k) {
      q.push_back(parts.q[c[k]]);
      v.push_back(parts.v[c[k]]);
      a.push_back(parts.a[c[k]]);
    }
    const LocalState state{0.7, q.data(), v.data(), a.data(), parts.lambda.data() + row};
    std::vector<double> f(nq), c0(nc), c1(nc), c2(nc);
    LocalResidual residual{f.data(), c0.data(), c1.data(), c2.data()};
    group.residual(e, state, residual);
    for (int k = 0; k < nq; ++k) force[c[k]] += f[k];
    position.insert(position.end(), c0.begin(), c0.end());
    velocity.insert(velocity.end(), c1.begin(), c1.end());
    acceleration.insert(acceleration.end(), c2.begin(), c2.end());

    const LocalStructure s = group.structure();
    const Kind kinds[] = {s.force_q, s.force_v, s.force_a};
    std::vector<std::vector<double>> m(kBlocks);
    double* at[kBlocks];
    for (int b = 0; b < kBlocks; ++b) {
      m[b].resize(nq * (b < 3 ? nq : nc));
      at[b] = b < 3 && kinds[b] == Kind::zero ? nullptr : m[b].data();
    }
    LocalTangent tangent{at[0], at[1], at[2], at[3], at[4], at[5], at[6]};
    group.tangent(e, state, tangent);
    for (int b = 0; b < kBlocks; ++b)
      for (int i = 0; i < (b < 3 ? nq : nc); ++i)
        for (int j = 0; j < nq; ++j)
          if (b >= 3 || group.has_entry(kinds[b], i, j))
            block[b][{b < 3 ? c[i] : row + i, c[j]}] += m[b][i * nq + j];
  }
};

Entries entries_of(const Pattern& pattern, const std::vector<double>& values) {
  Entries entries;
  for (int i = 0; i < pattern.rows; ++i)
    for (int k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
      entries[{i, pattern.column[k]}] = values[k];
  return entries;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-13) << i;
}

TEST(Multibody, SumsWhatTheElementsGive) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    constexpr int kCoordinates = 45;
    const Parts parts = random_parts(seed, kCoordinates);
    const PlainSum plain(parts, kCoordinates);
    const auto system = parts.builder.build(2);
    ASSERT_EQ(system->coordinates(), kCoordinates);
    ASSERT_EQ(system->constraints(), static_cast<int>(plain.position.size()));
    Residual residual = make_residual(*system);
    Tangent tangent = make_tangent(*system);
    for (int twice = 0; twice < 2; ++twice) {  // values are overwritten, not added to
      system->evaluate(parts.state(), residual);
      system->evaluate(parts.state(), tangent, BlockSet::all());
    }
    expect_near(residual.force, plain.force);
    expect_near(residual.position, plain.position);
    expect_near(residual.velocity, plain.velocity);
    expect_near(residual.acceleration, plain.acceleration);
    for (int b = 0; b < kBlocks; ++b) {
      const Pattern& pattern = system->tangent_pattern().block[b];
      for (int i = 0; i < pattern.rows; ++i)
        for (int k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k)
          ASSERT_LT(pattern.column[k - 1], pattern.column[k]);
      const Entries found = entries_of(pattern, tangent.values[b]);
      ASSERT_EQ(found.size(), plain.block[b].size()) << "block " << b;
      for (const auto& [place, value] : plain.block[b]) {
        ASSERT_EQ(found.count(place), 1U) << "block " << b << ": " << place.first << ", " << place.second;
        EXPECT_NEAR(found.at(place), value, 1e-13)
            << "block " << b << ": " << place.first << ", " << place.second;
      }
    }
  }
}

TEST(Multibody, OverwritesTheBlocksThatAreAskedForAndNoOthers) {
  const Parts parts = random_parts(7, 45);
  const auto system = parts.builder.build(2);
  Tangent all = make_tangent(*system);
  system->evaluate(parts.state(), all, BlockSet::all());
  for (unsigned subset = 0; subset < 1U << kBlocks; ++subset) {
    BlockSet blocks;
    for (int b = 0; b < kBlocks; ++b)
      if ((subset >> b & 1U) != 0) blocks.insert(static_cast<Block>(b));
    Tangent some = make_tangent(*system);
    for (auto& values : some.values) std::fill(values.begin(), values.end(), 7.0);
    const Tangent before = some;
    system->evaluate(parts.state(), some, blocks);
    for (int b = 0; b < kBlocks; ++b) {
      const bool asked = blocks.has(static_cast<Block>(b));
      EXPECT_EQ(some.values[b], (asked ? all : before).values[b]) << "block " << b << " of subset " << subset;
    }
  }
}

TEST(Multibody, GivesRowsOfTheGradientAlone) {
  const Parts parts = random_parts(7, 45);
  const auto system = parts.builder.build(2);
  const Pattern& pattern = system->tangent_pattern()[Block::position_q];
  Tangent all = make_tangent(*system);
  system->evaluate(parts.state(), all, BlockSet::all());
  for (int row = 0; row < system->constraints(); ++row) {
    Tangent some = make_tangent(*system);
    for (auto& values : some.values) std::fill(values.begin(), values.end(), 7.0);
    const Tangent before = some;
    system->evaluate_gradient(parts.state(), {row, system->constraints() - 1 - row}, some);
    for (const int asked : {row, system->constraints() - 1 - row})
      for (int k = pattern.row_start[asked]; k < pattern.row_start[asked + 1]; ++k)
        EXPECT_EQ(some[Block::position_q][k], all[Block::position_q][k]) << "row " << asked;
    for (int b = 0; b < kBlocks; ++b) {
      if (static_cast<Block>(b) == Block::position_q) continue;
      EXPECT_EQ(some.values[b], before.values[b]) << "block " << b;
    }
  }
}

/// A chain of elements that share coordinates, and many that share one coordinate.
constexpr int kNodes = 700;
MultibodyBuilder chain_and_star() {
  MultibodyBuilder builder;
  builder.add_coordinates("all", std::vector<double>(3 * kNodes), std::vector<double>(3 * kNodes));
  std::vector<int> chain, star;
  for (int k = 0; k + 1 < kNodes; ++k)
    for (int c = 0; c < 6; ++c) chain.push_back(3 * k + c);
  for (int k = 1; k < kNodes; ++k) star.insert(star.end(), {3 * k, 3 * k + 1, 0});
  LocalStructure dense;
  dense.force_v = dense.force_a = Kind::dense;
  builder.add(std::make_shared<ArtificialGroup>("chain", 6, 1, chain, dense));
  builder.add(std::make_shared<ArtificialGroup>("star", 3, 0, star, dense));
  return builder;
}

TEST(Multibody, ResultsDoNotDependOnTheNumberOfThreads) {
  const MultibodyBuilder builder = chain_and_star();
  Random random(5);
  constexpr int n = 3 * kNodes;
  const std::vector<double> q = random.vector(n), v = random.vector(n), a = random.vector(n),
                            lambda = random.vector(n);
  const StateView state{0.3, q.data(), v.data(), a.data(), lambda.data()};
  Residual first_residual;
  Tangent first_tangent;
  for (const int threads : {1, 2, 3}) {
    const auto system = builder.build(threads);
    Residual residual = make_residual(*system);
    Tangent tangent = make_tangent(*system);
    system->evaluate(state, residual);
    system->evaluate(state, tangent, BlockSet::all());
    if (threads == 1) {
      first_residual = residual;
      first_tangent = tangent;
    }
    EXPECT_EQ(residual.force, first_residual.force);
    EXPECT_EQ(residual.acceleration, first_residual.acceleration);
    EXPECT_EQ(tangent.values, first_tangent.values);
  }
}

TEST(Multibody, LeavesForcesToADeviceThatIsAskedFor) {
  const int n = 45;
  const Parts parts = random_parts(4, n);
  const auto host = parts.builder.build(2);
  Residual expected = make_residual(*host), residual = expected;
  host->evaluate(parts.state(), expected);

  const auto device = std::make_shared<ArtificialGroup::Device>();
  for (const int g : {0, 4}) parts.groups[g]->device = device;  // those without constraints
  const auto system = parts.builder.build(2, Backend::cuda);
  for (int evaluation = 1; evaluation <= 2; ++evaluation) {
    system->evaluate(parts.state(), residual);
    EXPECT_EQ(device->begun, 2 * evaluation);
    EXPECT_EQ(device->taken, 2 * evaluation);
    for (int i = 0; i < n; ++i) EXPECT_NEAR(residual.force[i], expected.force[i], 1e-13);
    EXPECT_EQ(residual.position, expected.position);
    EXPECT_EQ(residual.acceleration, expected.acceleration);
  }
  parts.builder.build(2)->evaluate(parts.state(), residual);
  EXPECT_EQ(residual.force, expected.force);
  EXPECT_EQ(device->begun, 4);
}

TEST(Multibody, EvaluatesStatesOfADeviceTogetherWithIt) {
  const int n = 45;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Parts parts = random_parts(seed, n);
    const auto host = parts.builder.build(2);
    const auto m = static_cast<std::size_t>(host->constraints());
    Residual expected = make_residual(*host);
    host->evaluate(parts.state(), expected);

    const auto device = std::make_shared<ArtificialGroup::Device>();
    for (const int g : {0, 4}) parts.groups[g]->device = device;
    const auto system = parts.builder.build(2, Backend::cuda);
    const Executor executor(Executor::Place::host, 2);  // plays the device
    const auto remote = system->remote_residual(executor);
    ASSERT_NE(remote, nullptr);
    for (const int levels : {3, 1, 3}) {
      std::vector<double> h(n + 3 * m, std::nan(""));
      remote->evaluate(parts.state(), levels, h.data());
      for (int i = 0; i < n; ++i) EXPECT_NEAR(h[i], expected.force[i], 1e-13);
      const std::vector<double>* const of_levels[] = {&expected.position, &expected.velocity,
                                                      &expected.acceleration};
      for (int level = 0; level < 3; ++level)
        for (std::size_t row = 0; row < m; ++row) {
          const double value = h[n + level * m + row];
          EXPECT_TRUE(level < levels ? value == (*of_levels[level])[row] : std::isnan(value)) << value;
        }
    }
    const StateView brought = remote->bring(parts.state());
    EXPECT_EQ(brought.t, parts.state().t);
    for (const int g : {1, 2, 3, 5})
      for (int e = 0; e < parts.groups[g]->size(); ++e)
        for (int k = 0; k < parts.groups[g]->local_coordinates(); ++k) {
          const int i = parts.groups[g]->coordinates(e)[k];
          EXPECT_EQ(brought.q[i], parts.q[i]);
          EXPECT_EQ(brought.v[i], parts.v[i]);
          EXPECT_EQ(brought.a[i], parts.a[i]);
        }
    for (std::size_t row = 0; row < m; ++row) EXPECT_EQ(brought.lambda[row], parts.lambda[row]);
  }
  const Parts parts = random_parts(1, n);
  const Executor executor(Executor::Place::host, 1);
  EXPECT_EQ(parts.builder.build(1, Backend::cuda)->remote_residual(executor), nullptr);  // nothing is there
}

TEST(Multibody, HasNoBlocksOfGroupsOnADevice) {
  const int n = 45;
  int shares = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Parts parts = random_parts(seed, n);
    MultibodyBuilder others;
    others.add_coordinates("all", std::vector<double>(n), std::vector<double>(n));
    for (const int g : {1, 2, 3, 5}) others.add(parts.groups[g]);
    const auto rest = others.build(2);
    Tangent expected = make_tangent(*rest);
    rest->evaluate(parts.state(), expected, BlockSet::all());
    EXPECT_TRUE(rest->remote_tangents().empty());

    for (const int g : {0, 4})  // those without constraints
      parts.groups[g]->device = std::make_shared<ArtificialGroup::Device>();
    const auto system = parts.builder.build(2, Backend::cuda);
    EXPECT_EQ(system->remote_tangents().size(), 2U);
    Tangent tangent = make_tangent(*system);
    system->evaluate(parts.state(), tangent, BlockSet::all());
    for (int b = 0; b < kBlocks; ++b) {
      EXPECT_EQ(system->tangent_pattern().block[b].column, rest->tangent_pattern().block[b].column);
      EXPECT_EQ(tangent.values[b], expected.values[b]) << "block " << b;
    }
    shares += parts.groups[0]->structure().force_q != Kind::zero;
  }
  EXPECT_GE(shares, 2);
}

TEST(Multibody, ABlockIsConstantWhenAllItsGroupsAre) {
  for (const bool second_constant : {true, false}) {
    MultibodyBuilder builder;
    builder.add_coordinates("body", std::vector<double>(6), std::vector<double>(6));
    LocalStructure first{Kind::dense, Kind::zero, Kind::dense, true, false};
    LocalStructure second{Kind::zero, Kind::dense, Kind::diagonal, second_constant, second_constant};
    builder.add(std::make_shared<ArtificialGroup>("first", 3, 0, std::vector<int>{0, 1, 2}, first));
    builder.add(std::make_shared<ArtificialGroup>("second", 3, 0, std::vector<int>{3, 4, 5}, second));
    const auto system = builder.build(1);
    const auto& constant = system->tangent_pattern().constant;
    EXPECT_FALSE(constant[static_cast<int>(Block::force_q)]);
    EXPECT_EQ(constant[static_cast<int>(Block::force_v)], second_constant);
    EXPECT_EQ(constant[static_cast<int>(Block::force_a)], second_constant);
    EXPECT_EQ(system->tangent_pattern()[Block::force_a].entries(), 12U);
  }
}

/// Elements whose mass is the same in every state; counts how often it is asked for.
class ConstantMass final : public ElementGroup {
 public:
  int size() const override { return 2; }
  int local_coordinates() const override { return 2; }
  const int* coordinates(int e) const override { return coordinates_ + e; }
  LocalStructure structure() const override { return {Kind::zero, Kind::zero, Kind::dense, true, false}; }
  std::string name(int) const override { return "mass"; }
  void residual(int, const LocalState&, LocalResidual&) const override {}
  void tangent(int e, const LocalState&, LocalTangent& tangent) const override {
    ++asked;
    for (int k = 0; k < 4; ++k) tangent.force_a[k] = 10.0 * (e + 1) + k;
  }
  mutable int asked = 0;

 private:
  const int coordinates_[3] = {0, 1, 2};
};

TEST(Multibody, WhatIsConstantInABlockThatIsNotIsEvaluatedOnce) {
  MultibodyBuilder builder;
  builder.add_coordinates("body", std::vector<double>(4), std::vector<double>(4));
  const auto constant = std::make_shared<ConstantMass>();
  builder.add(constant);
  builder.add(std::make_shared<ArtificialGroup>("other", 2, 0, std::vector<int>{2, 3},
                                                LocalStructure{Kind::zero, Kind::zero, Kind::dense}));
  const auto system = builder.build(1);
  Tangent tangent = make_tangent(*system), first;
  const std::vector<double> zero(4, 0.0);
  for (const double q : {1.0, -3.0, 1.0}) {
    const std::vector<double> all(4, q);
    const StateView state{0.0, all.data(), zero.data(), zero.data(), nullptr};
    system->evaluate(state, tangent, {Block::force_q});
    system->evaluate(state, tangent, {Block::force_a});
    const Entries entries = entries_of(system->tangent_pattern()[Block::force_a], tangent[Block::force_a]);
    EXPECT_EQ(entries.at({0, 0}), 10.0);
    EXPECT_EQ(entries.at({1, 1}), 13.0 + 20.0);
    EXPECT_EQ(entries.at({2, 1}), 22.0);
    if (q == 1.0 && first[Block::force_a].empty()) first = tangent;
    if (q != 1.0) {
      EXPECT_NE(tangent[Block::force_a], first[Block::force_a]);
    }
  }
  EXPECT_EQ(tangent[Block::force_a], first[Block::force_a]);
  EXPECT_EQ(constant->asked, 2);
}

TEST(Multibody, PassesOnTheFirstFailureOfAnElement) {
  const Parts parts = random_parts(3, 45);
  for (const auto& group : parts.groups) group->throws_at = 0;
  const auto system = parts.builder.build(3);
  Residual residual = make_residual(*system);
  for (int repeat = 0; repeat < 5; ++repeat) try {
      system->evaluate(parts.state(), residual);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "group 0, element 0");
    }
}

TEST(Multibody, NamesCoordinatesAndConstraints) {
  MultibodyBuilder builder;
  builder.add_coordinates("rod", {1}, {0});
  builder.add_coordinates("knuckle", {1, 2, 3}, {0, 0, 0}, {"x", "y", "z"});
  builder.add_coordinates("arm", std::vector<double>(6), std::vector<double>(6), {"x", "y", "z"});
  builder.add(std::make_shared<ArtificialGroup>("pin", 1, 1, std::vector<int>{4}, LocalStructure{}));
  builder.add(
      std::make_shared<ArtificialGroup>("ball", 2, 2, std::vector<int>{2, 1, 0, 5}, LocalStructure{}));
  const auto system = builder.build();
  EXPECT_EQ(system->coordinate_name(0), "rod[0]");
  EXPECT_EQ(system->coordinate_name(2), "knuckle.y");
  EXPECT_EQ(system->coordinate_name(9), "arm[1].z");
  EXPECT_EQ(system->constraint_name(0), "pin, element 0, equation 1 of 1");
  EXPECT_EQ(system->constraint_name(4), "ball, element 1, equation 2 of 2");
}

TEST(Multibody, MeasuresLengthsInAUnitOfTheirOwnWhereTheyAreNoOrdinaryNumbers) {
  const auto scales = [](double length) {
    MultibodyBuilder builder;
    builder.add_coordinates("body", std::vector<double>(4), std::vector<double>(4), {"x", "e0"}, 1);
    builder.note_length(0, length);
    builder.note_length(0, 0.5 * length);  // the largest of a body is its size
    builder.note_length(2, 8.0 * length);
    const auto system = builder.build();
    return std::vector<double>{system->coordinate_scale(2), system->coordinate_scale(3)};
  };
  for (const double ordinary : {0.0, 0.02, 1.0, 60.0})
    EXPECT_EQ(scales(ordinary), (std::vector<double>{1, 1})) << ordinary;
  EXPECT_EQ(scales(1e6), (std::vector<double>{1048576, 1}));
  EXPECT_EQ(scales(1e-3), (std::vector<double>{1.0 / 128, 1}));
  MultibodyBuilder mesh;
  mesh.add_coordinates("arm", {0, 5, 5, 1000, 7, 8}, std::vector<double>(6), {"x", "y", "z"}, 3);
  EXPECT_EQ(mesh.length_unit(), 1024.0);
}

TEST(Multibody, TellsHowFarLengthsMayGoByTheExtentOfTheWhole) {
  MultibodyBuilder builder;
  builder.add_coordinates("rod", {5, 1, 0, 1}, std::vector<double>(4), {"x", "y", "z", "e0"}, 3);
  builder.add_coordinates("mesh", {1, 2, 3, 1, -18, 3}, std::vector<double>(6), {"x", "y", "z"}, 3);
  builder.add_measure_coordinate("angle", 100, 0, false);
  builder.add_measure_coordinate("travel", 100, 0, true);
  const auto system = builder.build();
  EXPECT_EQ(system->ranges(builder.initial_q().data()),
            (std::vector<double>{20, 20, 20, 1, 20, 20, 20, 20, 20, 20, 1, 20}));
  const std::vector<double> together(12, 0.5);
  EXPECT_EQ(system->ranges(together.data()), std::vector<double>(12, 1.0));
}

TEST(Multibody, MayHaveMoreConstraintsThanCoordinates) {
  MultibodyBuilder builder;
  builder.add_coordinates("arm", {1, 2}, {0, 0});
  builder.add(std::make_shared<ArtificialGroup>("pin", 2, 2, std::vector<int>{0, 1, 1, 0}, LocalStructure{}));
  EXPECT_EQ(builder.build()->constraints(), 4);
}

TEST(Multibody, RefusesBadParts) {
  const std::vector<double> one(1), two(2);
  MultibodyBuilder empty;
  expect_refused("body arm", "no coordinates", [&] { empty.add_coordinates("arm", {}, {}); });
  expect_refused("body arm", "initial velocities", [&] { empty.add_coordinates("arm", two, one); });
  const std::vector<std::string> three{"x", "y", "z"};
  expect_refused("body arm", "multiple", [&] { empty.add_coordinates("arm", two, two, three); });
  expect_refused("body arm", "not finite", [&] { empty.add_coordinates("arm", {NAN}, one); });
  expect_refused("body arm", "not finite", [&] { empty.add_coordinates("arm", one, {INFINITY}); });
  expect_refused("group", "null", [&] { empty.add(nullptr); });
  expect_refused("bodies", "no coordinates", [&] { (void)empty.build(); });
  expect_refused("threads", "negative", [&] { (void)empty.build(-1); });

  const auto with = [&](int constraints, std::vector<int> coordinates) {
    MultibodyBuilder builder;
    builder.add_coordinates("arm", two, two);
    builder.add(
        std::make_shared<ArtificialGroup>("pin", 2, constraints, std::move(coordinates), LocalStructure{}));
    (void)builder.build();
  };
  expect_refused("pin, element 1", "coordinate 2 is not one of the 2", [&] { with(0, {0, 1, 1, 2}); });
  expect_refused("pin, element 0", "coordinate -1", [&] { with(0, {0, -1}); });
  expect_refused("pin, element 0", "named twice", [&] { with(0, {1, 1}); });
}

}  // namespace
}  // namespace mfs::dae
