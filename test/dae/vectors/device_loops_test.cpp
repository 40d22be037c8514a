// Passes over vectors on a device against plain loops on the host, with lengths around those of its blocks.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include <mfs/error.hpp>

#include "dae/vectors/loops.hpp"
#include "kernels/cuda/runtime/faults.hpp"
#include "test/reference/random.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::dae {
namespace {

constexpr std::size_t kLengths[] = {0, 1, 31, 32, 33, 255, 256, 257, 65535, 65536, 65537, 200000};

class DeviceLoops : public mfs::test::OnDevice {
 protected:
  void SetUp() override {
    OnDevice::SetUp();
    if (!IsSkipped()) device_ = std::make_unique<Executor>(Executor::Place::device, 2);
  }
  std::unique_ptr<Executor> device_;
};

struct AddIndex {
  int* visits;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { visits[i] += static_cast<int>(i); }
};

struct AddIndices {
  int* visits;
  MFS_HOST_DEVICE void operator()(std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) visits[i] += static_cast<int>(i);
  }
};

TEST_F(DeviceLoops, VisitEveryIndexOnce) {
  for (const std::size_t length : kLengths) {
    std::vector<int> expected(length, 7);
    Array<int> visits = make_array(*device_, expected);
    for_each(*device_, length, AddIndex{visits.data()});
    for_parts(*device_, length, AddIndices{visits.data()});
    for (std::size_t i = 0; i < length; ++i) expected[i] += 2 * static_cast<int>(i);
    EXPECT_EQ(visits.on_host(*device_), expected) << length;
  }
}

struct Entry {
  const double* x;
  MFS_HOST_DEVICE double operator()(std::size_t i) const { return x[i]; }
};

struct Larger {
  MFS_HOST_DEVICE double operator()(double a, double b) const { return a > b ? a : b; }
};

TEST_F(DeviceLoops, FoldEveryValueOnce) {
  for (const std::size_t length : kLengths) {
    std::vector<double> values(length);
    for (std::size_t i = 0; i < length; ++i) values[i] = static_cast<double>(i + 1);
    const Array<double> x = make_array(*device_, values);
    const double count = static_cast<double>(length);
    EXPECT_EQ(fold(*device_, length, 0.0, Entry{x.data()}, Sum{}), 0.5 * count * (count + 1.0)) << length;
    EXPECT_EQ(fold(*device_, length, 0.0, Entry{x.data()}, Larger{}), count) << length;
  }
}

TEST_F(DeviceLoops, FoldEachOfManyFunctions) {
  std::vector<double> values(std::end(kLengths)[-1] + 40);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i % 1000);
  const Array<double> x = make_array(*device_, values);
  for (const std::size_t length : kLengths) {
    for (const std::size_t count : {0, 1, 16, 17, 40}) {
      std::vector<Entry> functions;
      std::vector<double> expected;
      for (std::size_t k = 0; k < count; ++k) {
        functions.push_back({x.data() + k});
        expected.push_back(std::accumulate(values.begin() + k, values.begin() + k + length, 0.0));
      }
      EXPECT_EQ(folds(*device_, length, 0.0, functions, Sum{}), expected) << length << ", " << count;
    }
  }
}

struct TwoErrors {
  const double* e;
  MFS_HOST_DEVICE Numbers<2> operator()(std::size_t i) const { return {{2.0 * e[i], e[i]}}; }
};

TEST_F(DeviceLoops, TheErrorNormIsThatOfTheHostAndRepeats) {
  mfs::test::Random random(11);
  const Executor host(Executor::Place::host, 2);
  for (const std::size_t length : kLengths) {
    const std::vector<double> errors = random.vector(static_cast<int>(length));
    std::vector<double> weights(length);
    for (std::size_t i = 0; i < length; ++i) weights[i] = 0.5 + 0.25 * static_cast<double>(i % 7);
    const auto norms = [&](const Executor& executor) {
      const Array<double> e = make_array(executor, errors);
      return weighted_rms<2>(executor, TwoErrors{e.data()}, make_array(executor, weights));
    };
    const Numbers<2> expected = norms(host), actual = norms(*device_), again = norms(*device_);
    for (int k = 0; k < 2; ++k) {
      EXPECT_NEAR(actual.of[k], expected.of[k], 1e-14 * expected.of[k]) << length;
      EXPECT_EQ(actual.of[k], again.of[k]) << length;
    }
  }
}

TEST_F(DeviceLoops, ComeBehindCopiesAndBeforeMarks) {
  EXPECT_TRUE(device_->on_device());
  EXPECT_NE(device_->stream(), nullptr);
  const std::size_t length = 50000, bytes = length * sizeof(int);
  const auto from = device_->allocate_staging(bytes), to = device_->allocate_staging(bytes);
  Array<int> numbers;
  numbers.resize(*device_, length);
  for (int round = 1; round <= 3; ++round) {
    for (std::size_t i = 0; i < length; ++i) static_cast<int*>(from.get())[i] = round;
    device_->begin_from_host(numbers.data(), from.get(), bytes);
    for_each(*device_, length, AddIndex{numbers.data()});
    device_->begin_to_host(to.get(), numbers.data(), bytes);
    device_->mark();
    device_->wait_for_mark();
    const int* const arrived = static_cast<const int*>(to.get());
    for (std::size_t i = 0; i < length; ++i) ASSERT_EQ(arrived[i], round + static_cast<int>(i));
  }
}

TEST_F(DeviceLoops, ArraysKeepTheirMemoryWhereTheSizeStays) {
  const std::vector<int> values{3, 1, 4, 1, 5};
  Array<int> array = make_array(*device_, values);
  EXPECT_EQ(array.on_host(*device_), values);
  const int* const before = array.data();
  array.resize(*device_, 5);
  EXPECT_EQ(array.data(), before);
  EXPECT_EQ(array.on_host(*device_), values);
  array.resize(*device_, 0);
  EXPECT_TRUE(array.on_host(*device_).empty());
}

TEST_F(DeviceLoops, FaultsAreThrownAndLeaveTheRest) {
  Array<double> x = make_array<double>(*device_, {1.0, 2.0, 3.0});
  const auto with_fault = [&](auto&& work) {
    for (long after = 0;; ++after) {
      cuda::Fault fault{after};
      cuda::planned_fault = &fault;
      try {
        work();
        cuda::planned_fault = nullptr;
      } catch (const Error&) {
        cuda::planned_fault = nullptr;
      } catch (const std::bad_alloc&) {
        cuda::planned_fault = nullptr;
      }
      if (!fault.met) return after;
      EXPECT_EQ(fold(*device_, 3, 0.0, Entry{x.data()}, Sum{}), 6.0) << after;
    }
  };
  EXPECT_EQ(with_fault([&] { fold(*device_, 3, 0.0, Entry{x.data()}, Sum{}); }), 2);
  EXPECT_EQ(with_fault([&] { x.on_host(*device_); }), 2);
  EXPECT_GE(with_fault([&] { Executor another(Executor::Place::device, 1); }), 3);
  EXPECT_EQ(with_fault([&] { device_->allocate(8); }), 1);
  EXPECT_EQ(with_fault([&] { device_->allocate_staging(8); }), 1);
}

}  // namespace
}  // namespace mfs::dae
