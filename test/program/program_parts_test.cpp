// What the program is made of: its own backward error, exit codes, JSON lines, units, bench cases.
#include <cmath>
#include <complex>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <mfs/error.hpp>

#include "parts/exit_code.hpp"
#include "parts/report_text.hpp"
#include "solver/program/backward_error.hpp"
#include "solver/program/bench_case.hpp"
#include "solver/program/json_report.hpp"
#include "solver/program/summary.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::program;
using mfs::io::bench_case_name;
using mfs::io::check_bench_case;
using mfs::io::CsrMatrix;
using mfs::io::DenseMatrix;
using mfs::io::load_bench_case;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// [ 2 -1 ]
// [ 0  4 ]
const CsrMatrix<double> kMatrix{2, 2, {0, 2, 3}, {0, 1, 1}, {2, -1, 4}};

DenseMatrix<double> column(const std::vector<double>& values) {
  return {static_cast<std::int64_t>(values.size()), 1, values};
}

double error_of(const std::vector<double>& x, const std::vector<double>& b, bool transpose = false) {
  return backward_error(kMatrix, transpose, column(x), column(b));
}

TEST(BackwardError, ByHand) {
  EXPECT_EQ(error_of({1, 1}, {1, 4}), 0);
  EXPECT_EQ(error_of({1, 1}, {1, 5}), static_cast<double>(1.0L / 9));  // residual 1 of |4| + |5|
  EXPECT_EQ(error_of({-1, 1}, {1, 4}), 1);                             // residual 4 of |-2| + |-1| + |1|
  EXPECT_EQ(error_of({1, 1}, {2, 3}, true), 0);
  EXPECT_EQ(error_of({1, 1}, {1, 3}, true), static_cast<double>(1.0L / 3));
}

TEST(BackwardError, ZeroOfZeroIsNoError) {
  EXPECT_EQ(error_of({0, 0}, {0, 0}), 0);
}

TEST(BackwardError, SomeLeastNumbersAreFree) {
  const double step = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(error_of({0, 3 * step}, {-3 * step, 13 * step}), 0);
  EXPECT_NEAR(error_of({0, 1000 * step}, {-1000 * step, 5000 * step}), (1000 - 34) / 9000.0, 1e-9);
  EXPECT_NEAR(error_of({0, 1e-310}, {0, 0}), 1, 1e-9);
}

TEST(BackwardError, NotFiniteIsInfinitelyWrong) {
  EXPECT_EQ(error_of({NAN, 1}, {1, 4}), kInfinity);
  EXPECT_EQ(error_of({1, kInfinity}, {1, 4}), kInfinity);
}

TEST(BackwardError, LargeNumbersDoNotOverflow) {
  const double large = 1e308;
  EXPECT_EQ(error_of({large, large}, {large, 4}), static_cast<double>(4e308L / (4e308L + 4)));
}

TEST(BackwardError, TheWorstColumnCounts) {
  const DenseMatrix<double> x{2, 3, {1, 1, 1, 1, 1, 1}}, b{2, 3, {1, 4, 1, 5, 1, 4}};
  EXPECT_EQ(backward_error(kMatrix, false, x, b), static_cast<double>(1.0L / 9));
}

TEST(BackwardError, OfComplexNumbersByHand) {
  using Complex = std::complex<double>;
  // [ 3i 0 ]
  // [ 4  1 ]
  const CsrMatrix<Complex> a{2, 2, {0, 1, 3}, {0, 0, 1}, {{0, 3}, 4, 1}};
  const auto error = [&](std::vector<Complex> x, std::vector<Complex> b, bool transpose) {
    return backward_error(a, transpose, DenseMatrix<Complex>{2, 1, std::move(x)},
                          DenseMatrix<Complex>{2, 1, std::move(b)});
  };
  const Complex i(0, 1);
  EXPECT_EQ(error({1, i}, {3.0 * i, 4.0 + i}, false), 0);
  EXPECT_EQ(error({1, i}, {3.0 * i + 4.0, 4.0 + i}, false), 0.5);  // residual 4 of |3i| + |4 + 3i|
  EXPECT_EQ(error({1, i}, {7.0 * i, i}, true), 0);
  EXPECT_EQ(error({{1, INFINITY}, 0}, {0, 0}, false), kInfinity);
}

template <class Exception>
Failure failure_of(const Exception& exception) {
  try {
    throw exception;
  } catch (...) {
    return describe_current_exception();
  }
}

TEST(ExitCodes, EachKindOfErrorHasItsOwn) {
  using Kind = mfs::SingularMatrix::Kind;
  EXPECT_EQ(failure_of(mfs::InvalidInput("a", "b")).code, ExitCode::invalid_input);
  EXPECT_EQ(failure_of(mfs::PatternChanged("a", 3)).code, ExitCode::invalid_input);
  EXPECT_EQ(failure_of(mfs::SingularMatrix(Kind::numerical, 1, 2, 1, "a")).code, ExitCode::singular);
  EXPECT_EQ(failure_of(mfs::OutOfMemory(mfs::MemorySpace::host, 1, 0)).code, ExitCode::out_of_memory);
  EXPECT_EQ(failure_of(std::bad_alloc()).code, ExitCode::out_of_memory);
  EXPECT_EQ(failure_of(std::length_error("vector")).code, ExitCode::out_of_memory);
  EXPECT_EQ(failure_of(mfs::AccuracyNotReached(1, 0)).code, ExitCode::accuracy_not_reached);
  EXPECT_EQ(failure_of(mfs::BackendError("a", 1, "b")).code, ExitCode::backend);
  EXPECT_EQ(failure_of(mfs::StateError("a")).code, ExitCode::backend);
  EXPECT_EQ(failure_of(std::runtime_error("a")).code, ExitCode::backend);
  EXPECT_EQ(failure_of(mfs::Error("a")).code, ExitCode::backend);
}

TEST(ExitCodes, AMethodThatFailsHasAStatusOfItsOwn) {
  EXPECT_STREQ(failure_of(mfs::Error("a")).status, "failed");
  EXPECT_STREQ(failure_of(mfs::BackendError("a", 1, "b")).status, "backend");
  EXPECT_STREQ(failure_of(mfs::InvalidInput("a", "b")).status, "invalid_input");
}

TEST(ExitCodes, MessagesAreOneLineAndSayHowPlacesCount) {
  EXPECT_EQ(failure_of(std::runtime_error("a\nb")).message, "a b");
  EXPECT_EQ(failure_of(mfs::InvalidInput("file", "line 3: bad")).message, "file: line 3: bad");
  EXPECT_EQ(failure_of(mfs::InvalidInput("values", "not finite", 3, 5)).message,
            "values: not finite (row 3, column 5); rows and columns count from 0");
}

TEST(Json, AFailureThatCameBeforeTheSolver) {
  CaseResult result;
  result.name = "a\xff";  // no UTF-8
  result.code = ExitCode::invalid_input;
  result.message = "\"quoted\"\t";
  const auto json = nlohmann::json::parse(json_line(result));
  EXPECT_EQ(json["name"], "a\xEF\xBF\xBD");
  EXPECT_EQ(json["status"], "invalid_input");
  EXPECT_EQ(json["message"], "\"quoted\"\t");
  EXPECT_EQ(json["diagonal_blocks"], 0);
  EXPECT_EQ(json["nnz_factor"], 0);
  EXPECT_TRUE(json["backward_error"].is_null());
  EXPECT_EQ(json_line(result).find('\n'), std::string::npos);
}

TEST(Json, FiguresOfTheReport) {
  CaseResult result;
  result.report.emplace();
  result.report->nnz = 5;
  result.report->threads = 3;
  result.report->flops = {1, 2, 4};
  result.report->time_refactor = 9;
  result.entries = 6;
  result.time_refactor = 8;
  result.report->time_solve = 7;
  result.backward_error = 0.5;
  EXPECT_EQ(nlohmann::json::parse(json_line(result))["time_solve"], 7);
  result.time_solve = 6;
  const auto json = nlohmann::json::parse(json_line(result));
  EXPECT_EQ(json["nnz"], 5);
  EXPECT_EQ(json["threads"], 3);
  EXPECT_EQ(json["flops"], 7);
  EXPECT_EQ(json["flops_gemm"], 4);
  EXPECT_EQ(json["time_refactor"], 8);
  EXPECT_EQ(json["time_solve"], 6);
  EXPECT_EQ(json["backward_error"], 0.5);
  result.backward_error = kInfinity;
  EXPECT_TRUE(nlohmann::json::parse(json_line(result))["backward_error"].is_null());
}

TEST(Summary, Units) {
  EXPECT_EQ(with_unit(0, "B"), "0 B");
  EXPECT_EQ(with_unit(999, "B"), "999 B");
  EXPECT_EQ(with_unit(1000, "B"), "1.00 kB");
  EXPECT_EQ(with_unit(9994, "B"), "9.99 kB");
  EXPECT_EQ(with_unit(9996, "B"), "10.0 kB");
  EXPECT_EQ(with_unit(99960, "B"), "100 kB");
  EXPECT_EQ(with_unit(999600, "B"), "1.00 MB");
  EXPECT_EQ(with_unit(1.5e12, "flop/s"), "1.50 Tflop/s");
  EXPECT_EQ(with_unit(2e21, "flop"), "2000 Eflop");
}

TEST(Summary, DevicesSayWhatIsUsedAndWhy) {
  mfs::DeviceInfo device{"NVIDIA A40",           86, 80, 84, 48000000000, 99 * 1024, false, 32,
                         mfs::Precision::single, 64, 96};
  EXPECT_EQ(device_summary(device),
            "device          NVIDIA A40, compute capability 8.6, 84 multiprocessors, 48.0 GB\n"
            "                code for 8.0; products of double precision by multiply-adds\n"
            "                99 KiB of shared memory for a block: 64 pivots at once, fronts of up to 96 rows "
            "as a whole\n"
            "                single precision factors by default: double precision is 32 times as slow as "
            "single\n");
  device.tensor_cores = true;
  device.precision = mfs::Precision::full;
  EXPECT_THAT(device_summary(device), testing::AllOf(testing::HasSubstr("by tensor cores\n"),
                                                     testing::HasSubstr(" double precision factors by")));
}

TEST(BenchCases, FamiliesAndFiles) {
  const TemporaryFolder folder;
  const std::string a =
      folder.write("a.b.mtx", "%%MatrixMarket matrix coordinate real general\n1 1 2\n1 1 3\n1 1 2\n");
  EXPECT_EQ(bench_case_name("kkt:24"), "kkt:24");
  EXPECT_EQ(bench_case_name(a), "a.b");
  EXPECT_EQ(bench_case_name("x/west0479.mtx.gz"), "west0479");
  EXPECT_EQ(bench_case_name("-"), "stdin");
  EXPECT_EQ(std::get<mfs::io::CsrMatrix<double>>(load_bench_case("poisson2d:5", 1)).rows, 25);
  EXPECT_EQ(std::get<mfs::io::CsrMatrix<double>>(load_bench_case(a, 1)).entries(), 2);
  check_bench_case(a);
  check_bench_case("kkt:24");
  for (const char* text : {"", "kkt", "kkt:", ":3", "kkt:0", "kkt:-1", "kkt:3x", "kkt:3:4", "elas2d:3",
                           "none.mtx", "kkt:99999999999999999999"})
    EXPECT_THROW(check_bench_case(text), mfs::InvalidInput) << text;
}

}  // namespace
