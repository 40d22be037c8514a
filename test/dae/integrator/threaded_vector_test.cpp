// Threaded vectors of Thyra against plain loops, as NOX uses them.
#include "dae/integrator/threaded_vector.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <NOX_Thyra.H>
#include <Teuchos_DefaultSerialComm.hpp>

#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

using Teuchos::RCP;
using Teuchos::rcp;

constexpr int kLength = 20000;  // several threads are woken for it

RCP<ThreadedVector> make_vector(const std::vector<double>& values) {
  const RCP<const Teuchos::Comm<int>> comm = rcp(new Teuchos::SerialComm<int>());
  const RCP<const Tpetra::Map<>> map = rcp(new Tpetra::Map<>(values.size(), 0, comm));
  const auto vector = rcp(new ThreadedVector(Thyra::tpetraVectorSpace<double>(map), 3));
  std::copy(values.begin(), values.end(), vector->data());
  return vector;
}

std::vector<double> values_of(const NOX::Abstract::Vector& vector) {
  const auto& thyra = dynamic_cast<const NOX::Thyra::Vector&>(vector).getThyraVector();
  const double* const data = dynamic_cast<const ThreadedVector&>(thyra).data();
  return {data, data + vector.length()};
}

class ThreadedVectors : public testing::Test {
 protected:
  mfs::test::Random random_{12};
  const std::vector<double> a_ = random_.vector(kLength), b_ = random_.vector(kLength);
  const NOX::Thyra::Vector a{make_vector(a_)}, b{make_vector(b_)};
};

TEST_F(ThreadedVectors, ClonesAreThreadedToo) {
  const auto copy = a.clone(NOX::DeepCopy);
  EXPECT_EQ(values_of(*copy), a_);
  copy->init(2.0);
  EXPECT_EQ(values_of(*copy), std::vector<double>(kLength, 2.0));
  EXPECT_EQ(values_of(a), a_);
  values_of(*a.clone(NOX::ShapeCopy));
  *copy = b;
  EXPECT_EQ(values_of(*copy), b_);
}

TEST_F(ThreadedVectors, Norm) {
  long double sum = 0;
  for (const double value : a_) sum += static_cast<long double>(value) * value;
  const auto expected = static_cast<double>(std::sqrt(sum));
  EXPECT_NEAR(a.norm(), expected, 1e-14 * expected);
}

TEST_F(ThreadedVectors, SumsOfMultiples) {
  const auto x = a.clone(NOX::DeepCopy);
  x->scale(-3.0);
  x->update(0.5, b, 2.0);
  std::vector<double> expected(kLength);
  for (int i = 0; i < kLength; ++i) expected[i] = 2.0 * (-3.0 * a_[i]) + 0.5 * b_[i];
  EXPECT_EQ(values_of(*x), expected);
  // What is overwritten may be anything.
  x->init(std::numeric_limits<double>::quiet_NaN());
  x->update(1.0, a, -2.0, b, 0.0);
  for (int i = 0; i < kLength; ++i) expected[i] = a_[i] - 2.0 * b_[i];
  EXPECT_EQ(values_of(*x), expected);
}

}  // namespace
}  // namespace mfs::dae
