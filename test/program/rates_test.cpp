// Rates of the machine: what they predict, the file that keeps them, and how they are measured.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/error.hpp>
#include <mfs/version.hpp>

#include "solver/program/measure_rates.hpp"
#include "solver/program/rates.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::program;
using mfs::DepthSummary;

// `fronts` of p pivots and b border rows, added to what is there.
void add_fronts(DepthSummary& depth, std::int64_t fronts, std::int64_t p, std::int64_t b) {
  const double pivots = static_cast<double>(p), border = static_cast<double>(b),
               number = static_cast<double>(fronts);
  depth.fronts += fronts;
  depth.pivots += fronts * p;
  depth.max_front = std::max(depth.max_front, p + b);
  depth.factor_entries += fronts * (p * p + 2 * p * b);
  depth.contribution_entries += fronts * b * b;
  depth.flops.getrf += number * pivots * (pivots - 1) * (4 * pivots + 1) / 6;
  depth.flops.trsm += number * (2 * pivots * pivots * border - pivots * border);
  depth.flops.gemm += number * 2 * pivots * border * border;
}

double size_of(double p, double b) {
  return std::cbrt(p * p * p / 3 + p * p * b + p * b * b);
}

TEST(Rates, SizeOfEqualFronts) {
  for (const auto& [p, b] : std::vector<std::pair<int, int>>{{1, 0}, {300, 0}, {1, 7}, {40, 90}, {500, 20}}) {
    DepthSummary depth;
    add_fronts(depth, 17, p, b);
    EXPECT_NEAR(equivalent_size(depth), size_of(p, b), 1e-9 * p) << p << " " << b;
  }
  EXPECT_EQ(equivalent_size({}), 0);
}

// A thousand fronts of one pivot beside the one that does the work do not make it a small one.
TEST(Rates, SizeIsThatOfTheFrontsThatDoTheWork) {
  DepthSummary depth;
  add_fronts(depth, 1000, 1, 3);
  add_fronts(depth, 1, 400, 800);
  EXPECT_NEAR(equivalent_size(depth), size_of(400, 800), 0.03 * size_of(400, 800));
}

TEST(Rates, SizeOfOneLargeFrontAmongVeryManySmallOnes) {
  DepthSummary depth;
  add_fronts(depth, 100000, 1, 3);
  add_fronts(depth, 1, 400, 800);
  EXPECT_NEAR(equivalent_size(depth), size_of(400, 800), 0.25 * size_of(400, 800));
}

// Where a pivot block is divided into tiles, products are made inside it, too.
TEST(Rates, SizeOfFrontsInTiles) {
  DepthSummary depth;
  add_fronts(depth, 10, 300, 20);
  depth.flops.gemm += 10 * 2.0 * 128 * (172 * 192 + 172 * 20);
  EXPECT_NEAR(equivalent_size(depth), size_of(300, 20), 0.2 * size_of(300, 20));
}

MachineRates some_rates() {
  return {{"a processor", "a BLAS", "openmp", 2},
          "2026-11-25",
          {{10, 1e8, 1e6, {4e-5, 1e-5}, {1e-4, 2e-5}}, {1000, 1e10, 4e6, {0.3, 0.1}, {0.2, 0.05}}},
          1e-4,
          2e-4,
          3e-9,
          2e-9,
          7e-9,
          5e10};
}

TEST(Rates, PredictionByHand) {
  std::vector<DepthSummary> depths(3);
  add_fronts(depths[0], 1, 3000, 0);  // beyond the last size
  add_fronts(depths[1], 5, 30, 85);   // between
  add_fronts(depths[2], 100, 2, 1);   // below the first
  const double size = size_of(30, 85), part = std::log(size / 10) / std::log(100);
  mfs::Report report;
  report.nnz = 1000000;
  report.n = 1000;
  const Prediction found = predict(some_rates(), report, depths);
  const auto entries = [](double size) { return 5 * std::pow(size / size_of(1, 2), 2); };
  const auto between = [&](double a, double b) { return a * std::pow(b / a, part); };
  EXPECT_NEAR(found.refactor,
              0.3 + (depths[0].flops.total() / 2e9 - 1) * 0.1 + between(4e-5, 0.3) +
                  (depths[1].flops.total() / (2 * size * size * size) - 1) * between(1e-5, 0.1) + 4e-5 +
                  1e-4 + 3e-3,
              1e-9 * found.refactor);
  EXPECT_NEAR(found.solve,
              0.2 + (9e6 / entries(1000) - 1) * 0.05 + between(1e-4, 0.2) +
                  (5 * (900 + 5100) / entries(size) - 1) * between(2e-5, 0.05) + 1e-4 +
                  (100 * 8 / entries(10) - 1) * 2e-5 + 2e-4 + 2e-3 + 7e-6,
              1e-9 * found.solve);
  EXPECT_EQ(found.date, "2026-11-25");
  report.partial = true;
  report.slowdown = 1.5;
  report.bytes_out = 50e9;  // 1 s
  report.bytes_back = 400e9;
  const Prediction moving = predict(some_rates(), report, depths);
  EXPECT_NEAR(moving.refactor, 1.5 * found.refactor, 1e-9);
  EXPECT_NEAR(moving.solve, found.solve + 8, 1e-9);
  report.bytes_out = 1000e9 * found.refactor;
  EXPECT_NEAR(predict(some_rates(), report, depths).refactor, 20 * found.refactor, 1e-9)
      << "by the link alone";
}

// How long a front is solved with alone is a matter of its pivots; further ones are read beside it.
TEST(Rates, PredictionOfADeviceByHand) {
  std::vector<DepthSummary> depths(3);
  add_fronts(depths[0], 1, 3000, 0);
  add_fronts(depths[1], 5, 30, 850);
  add_fronts(depths[2], 100, 2, 1);
  mfs::Report report;
  report.backend = mfs::Backend::cuda;
  report.nnz = 1000000;
  report.n = 1000;
  const auto entries = [](double size) { return 5 * std::pow(size / size_of(1, 2), 2); };
  const double size = size_of(30, 60), part = std::log(size / 10) / std::log(100);
  const auto between = [&](double a, double b) { return a * std::pow(b / a, part); };
  EXPECT_NEAR(predict(some_rates(), report, depths).solve,
              0.2 * size_of(3000, 6000) / 1000 + between(1e-4, 0.2) +
                  4 * 30 * (30 + 2 * 850) / entries(size) * between(2e-5, 0.05) + 1e-4 +
                  99 * 8 / entries(10) * 2e-5 + 2e-4 + 2e-3 + 7e-6,
              1e-9);
}

TEST(RatesFile, KeepsOneEntryForEachKey) {
  const TemporaryFolder folder;
  const std::string path = folder.path("cache/mfs/rates.json");  // folders are made
  EXPECT_TRUE(read_rates(path).rates.empty());
  EXPECT_FALSE(read_rates(path).damaged);
  MachineRates first = some_rates(), second = some_rates();
  second.key.threads = 16;
  keep_rates(path, first);
  keep_rates(path, second);
  first.fronts = {{5, 1.0 / 3, 2, {3, 4}, {5, 6}}};
  keep_rates(path, first);
  const RatesFile found = read_rates(path);
  EXPECT_FALSE(found.damaged);
  ASSERT_EQ(found.rates.size(), 2u);
  EXPECT_TRUE(found.rates[0].key == second.key);
  EXPECT_TRUE(found.rates[1].key == first.key);
  ASSERT_EQ(found.rates[1].fronts.size(), 1u);
  EXPECT_EQ(found.rates[1].fronts[0].flops_per_second, 1.0 / 3);
  EXPECT_EQ(found.rates[1].date, "2026-11-25");
  EXPECT_EQ(found.rates[1].refactor_seconds_per_entry, 3e-9);
  EXPECT_EQ(found.rates[1].solve_seconds_per_entry, 2e-9);
  EXPECT_EQ(found.rates[1].solve_seconds_per_row, 7e-9);
  EXPECT_EQ(found.rates[1].link_bytes_per_second, 5e10);
}

TEST(RatesFile, EveryPartOfTheKeyCounts) {
  const RatesKey key = some_rates().key;
  EXPECT_TRUE((key == RatesKey{"a processor", "a BLAS", "openmp", 2}));
  EXPECT_FALSE((key == RatesKey{"another", "a BLAS", "openmp", 2}));
  EXPECT_FALSE((key == RatesKey{"a processor", "another", "openmp", 2}));
  EXPECT_FALSE((key == RatesKey{"a processor", "a BLAS", "serial", 2}));
  EXPECT_FALSE((key == RatesKey{"a processor", "a BLAS", "openmp", 1}));
}

TEST(RatesFile, WhatMakesNoSenseIsDamagedAndMadeAnew) {
  const TemporaryFolder folder;
  const std::string path = folder.path("rates.json");
  keep_rates(path, some_rates());
  const std::string good = text_of(path);
  const auto with = [&](const std::string& old, const std::string& text) {
    std::string changed = good;
    EXPECT_NE(changed.find(old), std::string::npos) << old;
    return changed.replace(changed.find(old), old.size(), text);
  };
  for (const std::string& text : std::vector<std::string>{
           "", "{}", "nonsense", good.substr(0, good.size() / 2), with("\"format\": 4", "\"format\": 3"),
           with("\"size\": 10.0", "\"size\": 1000.0"), with("\"size\": 10.0", "\"size\": -1.0"),
           with("\"refactor_call\": 0.0001", "\"refactor_call\": -1"), with("4e-05", "0"),
           with("100000000.0", "0"), with("100000000.0", "-5"), with("100000000.0", "\"fast\""),
           with("100000000.0", "1e999"), with("link_bytes_per_second", "link"), with("3e-09", "-3e-09"),
           with("7e-09", "-7e-09"), with("1000000.0", "null"), with("\"threads\": 2", "\"threads\": []")}) {
    folder.write("rates.json", text);
    const RatesFile found = read_rates(path);
    EXPECT_TRUE(found.damaged) << text;
    EXPECT_TRUE(found.rates.empty()) << text;
    keep_rates(path, some_rates());
    EXPECT_EQ(text_of(path), good) << text;
  }
}

// A disk that is full while the new file is written leaves the old one.
TEST(RatesFile, IsTheOldOneOrTheNewOne) {
  const TemporaryFolder folder;
  const std::string path = folder.path("rates.json");
  keep_rates(path, some_rates());
  const std::string old = text_of(path);
  MachineRates other = some_rates();
  other.key.threads = 3;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{100, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(keep_rates(path, other), mfs::InvalidInput);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(text_of(path), old);
}

TEST(RatesFile, SaysWhatIsNoFolder) {
  const TemporaryFolder folder;
  folder.write("file", "");
  EXPECT_THROW(keep_rates(folder.path("file/mfs/rates.json"), some_rates()), mfs::InvalidInput);
  EXPECT_THROW(keep_rates("", some_rates()), mfs::InvalidInput);
}

// Chains of fronts have the sizes that they were made for, whatever the tree is made of them.
TEST(MeasureRates, SizesAreThoseOfTheChains) {
  mfs::Options options;
  options.backend = mfs::Backend::serial;
  std::vector<double> progress;
  const MachineRates rates = measure_rates(options, 2000, [&](double done) { progress.push_back(done); });
  EXPECT_TRUE(rates.key == rates_key(mfs::Backend::serial, 1));
  ASSERT_EQ(rates.fronts.size(), 8u);
  EXPECT_EQ(progress.size(), 8u);
  EXPECT_GE(rates.refactor_call, 0);
  EXPECT_GE(rates.solve_call, 0);
  EXPECT_GE(rates.refactor_seconds_per_entry, 0);
  EXPECT_GE(rates.solve_seconds_per_entry, 0);
  double pivots = 4, last = 0;
  for (const FrontRate& rate : rates.fronts) {
    EXPECT_GT(rate.size, last);
    last = rate.size;
    EXPECT_NEAR(rate.size, size_of(pivots, 2 * pivots), 0.1 * rate.size) << pivots;
    EXPECT_GT(rate.flops_per_second, 0);
    EXPECT_GT(rate.entries_per_second, 0);
    for (const double time : {rate.refactor.alone, rate.refactor.each, rate.solve.alone, rate.solve.each})
      EXPECT_GT(time, 0);
    pivots *= 2;
  }
}

// On a device there are larger ones, and the rate of the link.
TEST(MeasureRates, OnADevice) {
  const std::vector<mfs::Backend> usable = mfs::backends();
  if (std::count(usable.begin(), usable.end(), mfs::Backend::cuda) == 0) GTEST_SKIP() << "no CUDA device";
  mfs::Options options;
  options.backend = mfs::Backend::cuda;
  options.threads = 2;
  const MachineRates rates = measure_rates(options, 20000, [](double) {});
  EXPECT_GT(rates.fronts.size(), 8u);
  EXPECT_GT(rates.fronts.back().flops_per_second, rates.fronts[3].flops_per_second);
  EXPECT_GT(rates.link_bytes_per_second, 0);
  EXPECT_GT(rates.solve_seconds_per_row, 0);
}

}  // namespace
