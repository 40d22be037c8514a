// Copies of states that lend their memory to later ones.
#include "dae/program/state_copies.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <thread>

namespace mfs::dae {
namespace {

State state_of(double t, std::size_t n) {
  return {t,
          std::vector<double>(n, t + 1),
          std::vector<double>(n, t + 2),
          std::vector<double>(n + 1, t + 3),
          {t}};
}

void expect_equal(const State& a, const State& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.a, b.a);
  EXPECT_EQ(a.lambda, b.lambda);
}

TEST(StateCopies, AreEachTheirOwnWhileTheyAreHeld) {
  StateCopies copies;
  const auto first = copies.copy_of(state_of(1, 10)), second = copies.copy_of(state_of(2, 20));
  expect_equal(*first, state_of(1, 10));
  expect_equal(*second, state_of(2, 20));
}

TEST(StateCopies, TakeTheMemoryOfThoseThatAreDone) {
  StateCopies copies;
  auto copy = copies.copy_of(state_of(1, 1000));
  const double* const memory = copy->q.data();
  std::thread([&] { copy.reset(); }).join();
  const auto shorter = copies.copy_of(state_of(2, 10));
  EXPECT_EQ(shorter->q.data(), memory);
  expect_equal(*shorter, state_of(2, 10));
  const auto another = copies.copy_of(state_of(3, 10));
  EXPECT_NE(another->q.data(), memory);
}

TEST(StateCopies, MayEndLater) {
  std::optional<StateCopies> copies(std::in_place);
  const auto copy = copies->copy_of(state_of(1, 10));
  copies.reset();
  expect_equal(*copy, state_of(1, 10));
}

}  // namespace
}  // namespace mfs::dae
