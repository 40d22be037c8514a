// Vectors of an executor against plain loops, as NOX uses them.
#include "dae/integrator/executor_vector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <NOX_Thyra.H>
#include <Teuchos_DefaultSerialComm.hpp>
#include <Thyra_TpetraThyraWrappers.hpp>
#include <Tpetra_Map.hpp>
#include <Tpetra_Vector.hpp>

#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

using Teuchos::RCP;
using Teuchos::rcp;

constexpr int kLength = 20000;  // several threads are woken for it

const Executor& executor() {
  static const Executor host(Executor::Place::host, 3);
  return host;
}

RCP<ExecutorVector> make_vector(const std::vector<double>& values) {
  const RCP<const Teuchos::Comm<int>> comm = rcp(new Teuchos::SerialComm<int>());
  const RCP<const Tpetra::Map<>> map = rcp(new Tpetra::Map<>(values.size(), 0, comm));
  const auto vector = rcp(new ExecutorVector(Thyra::tpetraVectorSpace<double>(map), executor()));
  executor().from_host(vector->data(), values.data(), values.size() * sizeof(double));
  return vector;
}

std::vector<double> values_of(const NOX::Abstract::Vector& vector) {
  const auto& thyra = dynamic_cast<const NOX::Thyra::Vector&>(vector).getThyraVector();
  std::vector<double> values(static_cast<std::size_t>(vector.length()));
  executor().to_host(values.data(), ExecutorVector::of(thyra).data(), values.size() * sizeof(double));
  return values;
}

class ExecutorVectors : public testing::Test {
 protected:
  mfs::test::Random random_{12};
  const std::vector<double> a_ = random_.vector(kLength), b_ = random_.vector(kLength);
  const NOX::Thyra::Vector a{make_vector(a_)}, b{make_vector(b_)};
};

TEST_F(ExecutorVectors, ClonesAreVectorsOfTheExecutorToo) {
  const auto copy = a.clone(NOX::DeepCopy);
  EXPECT_EQ(values_of(*copy), a_);
  copy->init(2.0);
  EXPECT_EQ(values_of(*copy), std::vector<double>(kLength, 2.0));
  EXPECT_EQ(values_of(a), a_);
  values_of(*a.clone(NOX::ShapeCopy));
  *copy = b;
  EXPECT_EQ(values_of(*copy), b_);
}

TEST_F(ExecutorVectors, Norm) {
  long double sum = 0;
  for (const double value : a_) sum += static_cast<long double>(value) * value;
  const auto expected = static_cast<double>(std::sqrt(sum));
  EXPECT_NEAR(a.norm(), expected, 1e-14 * expected);
}

TEST_F(ExecutorVectors, SumsOfMultiples) {
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

// Others than those that NOX needs.
TEST_F(ExecutorVectors, OtherOperationsOfThyra) {
  long double sum = 0;
  for (int i = 0; i < kLength; ++i) sum += static_cast<long double>(a_[i]) * b_[i];
  EXPECT_NEAR(a.innerProduct(b), static_cast<double>(sum), 1e-12 * kLength);
  const auto x = a.clone(NOX::DeepCopy);
  x->abs(b);
  std::vector<double> expected(kLength);
  for (int i = 0; i < kLength; ++i) expected[i] = std::abs(b_[i]);
  EXPECT_EQ(values_of(*x), expected);
  EXPECT_EQ(x->norm(NOX::Abstract::Vector::MaxNorm), *std::max_element(expected.begin(), expected.end()));
  EXPECT_EQ(values_of(a), a_);
}

}  // namespace
}  // namespace mfs::dae
