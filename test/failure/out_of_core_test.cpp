// Factors that memory has no room for: the solutions of those in memory, bit for bit, within the limit; and
// each fault of the file told as what it is, with an object that works after it.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <complex>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "test/failure/file_faults.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/failure/new_process.hpp"
#include "test/failure/refused_threads.hpp"
#include "test/program/temporary_folder.hpp"
#include "test/solver/answers.hpp"

namespace mfs::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

constexpr std::int64_t kMany = 21;

template <class Scalar>
struct MoreAnswers {
  Answers<Scalar> one;
  std::vector<Scalar> many;  // columns
  double condition = 0;
};

template <class Scalar>
MoreAnswers<Scalar> more_answers_of(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a) {
  const std::vector<Scalar> block = right_hand_sides(a, kMany, a.n, 6);
  MoreAnswers<Scalar> answers{answers_of(solver, a), block};
  solver.solve(block.data(), answers.many.data(), kMany);
  answers.condition = solver.condition_estimate();
  return answers;
}

template <class Scalar>
void expect_same(const MoreAnswers<Scalar>& actual, const MoreAnswers<Scalar>& expected) {
  expect_same(actual.one, expected.one);
  EXPECT_EQ(actual.condition, expected.condition);
}

/// MoreAnswers::many as that many columns at a time give it; BLAS rounds them differently.
template <class Scalar>
std::vector<std::vector<Scalar>> in_blocks(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a) {
  const std::vector<Scalar> b = right_hand_sides(a, kMany, a.n, 6);
  std::vector<std::vector<Scalar>> all;
  for (const std::int64_t columns : {16, 4, 1}) {
    std::vector<Scalar> x = b;
    for (std::int64_t first = 0; first < kMany; first += columns)
      solver.solve(b.data() + first * a.n, x.data() + first * a.n, std::min(columns, kMany - first));
    all.push_back(std::move(x));
  }
  return all;
}

class OutOfCore : public testing::Test {
 protected:
  ~OutOfCore() override { end_fault(); }

  Options within(Options options, std::int64_t limit) const {
    options.memory_limit = limit;
    options.out_of_core_dir = folder_.path("");
    return options;
  }
  /// The least limit that does, as OutOfMemory tells where one does not.
  template <class Scalar>
  std::int64_t least_limit(const Options& options, const BasicSparseMatrix<Scalar>& a) const {
    BasicSolver<Scalar> solver(within(options, 1));
    const auto error = failure_of<OutOfMemory>([&] { solver.analyze(a.view()); });
    if (!error) return 1;
    EXPECT_EQ(error->space(), MemorySpace::host);
    EXPECT_EQ(error->available(), 1u);
    return static_cast<std::int64_t>(error->needed());
  }
  bool folder_is_empty() const { return std::filesystem::is_empty(folder_.path("")); }

  /// Through all phases with limits from the least one to what is enough for memory alone.
  template <class Scalar>
  void check(const Options& options, const BasicSparseMatrix<Scalar>& a,
             const BasicSparseMatrix<Scalar>& next) {
    MoreAnswers<Scalar> expected, expected_next;
    BasicSolver<Scalar> in_memory(within(options, 0));
    in_memory.factor(a.view());
    EXPECT_FALSE(in_memory.report().partial);
    const std::int64_t enough = in_memory.report().bytes_peak;
    expected = more_answers_of(in_memory, a);
    const std::vector<std::vector<Scalar>> blocks = in_blocks(in_memory, a);
    EXPECT_EQ(blocks.front(), expected.many);
    in_memory.refactor(next.view());
    expected_next = more_answers_of(in_memory, next);
    const std::int64_t least = least_limit(options, a);
    ASSERT_LT(least, enough);
    int partial = 0;
    for (std::int64_t limit = least;; limit += std::max<std::int64_t>((enough - least) / 5, 1)) {
      SCOPED_TRACE("limit " + std::to_string(limit) + " of " + std::to_string(enough));
      BasicSolver<Scalar> solver(within(options, limit));
      solver.factor(a.view());
      const MoreAnswers<Scalar> answers = more_answers_of(solver, a);
      expect_same(answers, expected);
      EXPECT_THAT(blocks, Contains(answers.many)) << "as of no number of columns that are solved for at once";
      EXPECT_LE(solver.report().bytes_used, limit);
      solver.refactor(next.view());
      expect_same(more_answers_of(solver, next), expected_next);
      EXPECT_TRUE(folder_is_empty());
      if (!solver.report().partial) break;
      ++partial;
      if (HasFailure()) return;
    }
    EXPECT_GE(partial, 4);
  }
  template <class Scalar>
  void check(const Options& options, const SparseMatrix& real) {
    const BasicSparseMatrix<Scalar> a = in_scalar<Scalar>(real);
    BasicSparseMatrix<Scalar> next = a;
    for (std::size_t k = 0; k < next.values.size(); k += 3) next.values[k] *= Scalar(1.25);
    check(options, a, next);
  }

  TemporaryFolder folder_;
};

TEST_F(OutOfCore, SolutionsAreThoseOfFactorsInMemory) {
  for (const int threads : {1, 2}) {
    SCOPED_TRACE("threads " + std::to_string(threads));
    check<double>(with_threads(threads), grid_3d(17));
    check<std::complex<float>>(with_threads(threads), grid_3d(11));
  }
  Options serial = with_threads(1);
  serial.backend = Backend::serial;
  check<float>(serial, grid_3d(12));
  check<std::complex<double>>(with_threads(2), grid_2d(60, 61));
}

TEST_F(OutOfCore, BlocksAreDividedAsInMemory) {
  Options options = with_threads(2);
  options.analysis.max_block_size = 48;
  options.analysis.leaf_size = 20;
  check<double>(options, grid_3d(14));
}

TEST_F(OutOfCore, FactorsOfSinglePrecisionAreRefined) {
  Options options = with_threads(2);
  options.factor.precision = Precision::single;
  check<double>(options, grid_3d(14));
}

/// The same rungs of the ladder, and what they give.
void expect_same_rungs(Options options, const SparseMatrix& a, const std::string& folder) {
  Solver in_memory(options);
  in_memory.factor(a.view());
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 8);
  std::vector<double> expected(b.size()), x(b.size());
  in_memory.solve(b.data(), expected.data());
  options.out_of_core_dir = folder;
  options.memory_limit = in_memory.report().bytes_peak * 6 / 10;
  Solver solver(options);
  solver.factor(a.view());
  solver.solve(b.data(), x.data());
  EXPECT_TRUE(solver.report().partial);
  EXPECT_EQ(solver.report().rung, in_memory.report().rung) << rung_name(in_memory.report().rung);
  EXPECT_EQ(solver.report().reanalyses, in_memory.report().reanalyses);
  EXPECT_EQ(solver.report().perturbed_pivots, in_memory.report().perturbed_pivots);
  EXPECT_EQ(x, expected);
}

TEST_F(OutOfCore, LadderHasTheSameRungs) {
  SparseMatrix weak = grid_3d(13);
  for (std::int64_t row = 0; row < weak.n; ++row) {
    for (std::int64_t k = weak.offsets[row]; k < weak.offsets[row + 1]; ++k) {
      if (weak.columns[k] == row && row % 3 == 0) weak.values[k] = row % 2 == 0 ? 1e-2 : 0;
    }
  }
  Options options = with_threads(2);
  options.analysis.matching = Matching::never;
  expect_same_rungs(options, weak, folder_.path(""));  // pivots are delayed
  options.factor.max_reanalyses = 0;
  expect_same_rungs(options, weak, folder_.path(""));  // pivots are corrected, or divided by
  options = with_threads(1);
  options.factor.precision = Precision::single;
  options.solve.max_refinement_steps = 0;
  expect_same_rungs(options, grid_3d(13), folder_.path(""));  // full precision
}

TEST_F(OutOfCore, IsToldBeforeAnyNumberIsComputed) {
  const SparseMatrix a = grid_3d(16);
  Solver in_memory(with_threads(2));
  in_memory.analyze(a.view());
  EXPECT_EQ(in_memory.report().bytes_out, 0);
  const std::int64_t enough = in_memory.report().bytes_peak, least = least_limit(with_threads(2), a);
  Solver solver(within(with_threads(2), (least + enough) / 2));
  solver.analyze(a.view());
  const Report& report = solver.report();
  EXPECT_TRUE(report.partial);
  EXPECT_LE(report.bytes_peak, (least + enough) / 2);
  EXPECT_GT(report.bytes_out, 0);
  EXPECT_LT(report.bytes_out, report.bytes_factor);
  EXPECT_GE(report.bytes_back, report.bytes_out);
  EXPECT_LE(report.bytes_back, 2 * report.bytes_out);
  std::int64_t segments = 0;
  for (const DepthSummary& depth : solver.depths()) segments += depth.segments;
  EXPECT_EQ(segments, report.segments);
  EXPECT_GT(segments, 1);
  Solver with_enough(within(with_threads(2), enough));
  with_enough.analyze(a.view());
  EXPECT_FALSE(with_enough.report().partial);
  Solver below(within(with_threads(2), least * 9 / 10));
  failure_of<OutOfMemory>([&] { below.analyze(a.view()); });
  expect_usable(below);
}

TEST_F(OutOfCore, WithoutAFolderALimitIsRefused) {
  const SparseMatrix a = grid_3d(12);
  Solver in_memory(with_threads(1));
  in_memory.analyze(a.view());
  Options options = with_threads(1);
  options.memory_limit = in_memory.report().bytes_peak - 1;
  for (const Backend backend : {Backend::serial, Backend::openmp}) {
    options.backend = backend;
    Solver solver(options);
    if (const auto error = failure_of<OutOfMemory>([&] { solver.analyze(a.view()); })) {
      EXPECT_EQ(error->needed(), static_cast<std::size_t>(in_memory.report().bytes_peak));
      EXPECT_THAT(error->what(), HasSubstr("out_of_core_dir"));
    }
    expect_usable(solver);
  }
  ++options.memory_limit;
  Solver solver(options);
  solver.factor(a.view());
  expect_solves(solver, a);
}

/// A system whose factors go to a file in several blocks.
class Faults : public OutOfCore {
 protected:
  Faults() : a_(grid_3d(15)), b_(right_hand_sides(a_, 1, a_.n, 9)), expected_(b_.size()) {
    Solver in_memory(with_threads(2));
    in_memory.factor(a_.view());
    in_memory.solve(b_.data(), expected_.data());
    options_ = within(with_threads(2), in_memory.report().bytes_peak * 6 / 10);
  }

  void expect_solution(Solver& solver) {
    std::vector<double> x(b_.size());
    solver.solve(b_.data(), x.data());
    EXPECT_TRUE(solver.report().partial);
    EXPECT_EQ(x, expected_);
  }
  /// The error that a file gives, with an object that is usable after it.
  template <class Call>
  void expect_file_error(Solver& solver, int code, const std::string& text, const Call& call) {
    const auto error = failure_of<BackendError>(call);
    end_fault();
    if (error) {
      EXPECT_EQ(error->library(), "file");
      EXPECT_EQ(error->code(), code) << error->what();
      EXPECT_THAT(error->what(), AllOf(HasSubstr(folder_.path("")), HasSubstr(text)));
    }
    solver.factor(a_.view());
    expect_solution(solver);
  }
  void solve(Solver& solver) {
    std::vector<double> x(b_.size(), 12345);
    try {
      solver.solve(b_.data(), x.data());
    } catch (...) {
      EXPECT_EQ(x, std::vector<double>(b_.size(), 12345)) << "a solve that fails writes nothing";
      throw;
    }
  }

  SparseMatrix a_;
  std::vector<double> b_, expected_;
  Options options_;
};

TEST_F(Faults, EachCallOfTheFileFailsOnce) {
  for (const auto& [call, error] :
       {std::pair{FileCall::write, ENOSPC}, {FileCall::write, EIO}, {FileCall::read, EIO}}) {
    const bool writes = call == FileCall::write;
    Solver solver(options_);
    solver.factor(a_.view());
    plan_fault({call, -1, 0});
    solver.refactor(a_.view());
    solve(solver);
    const long calls = file_calls(call);
    EXPECT_GT(calls, 4);
    for (long at = 0; at < calls; ++at) {
      SCOPED_TRACE((writes ? "write " : "read ") + std::to_string(at));
      plan_fault({call, at, error, at % 2 == 1});
      expect_file_error(solver, error, "block ",
                        [&] { writes ? solver.refactor(a_.view()) : solve(solver); });
    }
  }
}

TEST_F(Faults, AFailedFirstFactorizationMayBeTriedAgain) {
  Solver solver(options_);
  plan_fault({FileCall::write, 1, EIO});
  failure_of<BackendError>([&] { solver.factor(a_.view()); });
  end_fault();
  failure_of<StateError>([&] { solve(solver); });
  solver.refactor(a_.view());
  expect_solution(solver);
  expect_usable(solver);
}

// What one process writes would be wrong for the other.
TEST_F(Faults, AForkedProcessHasNoFile) {
  Solver solver(options_);
  solver.factor(a_.view());
  check_in_new_process([&] {
    failure_of<StateError>([&] { solve(solver); });
    failure_of<StateError>([&] { solver.refactor(a_.view()); });
    Solver made_here(options_);
    made_here.factor(a_.view());
    expect_solution(made_here);
  });
  expect_solution(solver);
}

TEST_F(Faults, AFailedSolveMayBeTriedAgain) {
  Solver solver(options_);
  solver.factor(a_.view());
  plan_fault({FileCall::read, 2, EIO});
  failure_of<BackendError>([&] { solve(solver); });
  end_fault();
  expect_solution(solver);
}

TEST_F(Faults, InterruptedAndShortCallsGoOn) {
  for (const FileCall call : {FileCall::open, FileCall::reserve, FileCall::write, FileCall::read}) {
    for (const int error : {EINTR, 0}) {
      if (error == 0 && (call == FileCall::open || call == FileCall::reserve)) continue;
      for (long at = 0; at < 3; ++at) {
        Solver solver(options_);
        plan_fault({call, at, error});
        solver.factor(a_.view());
        expect_solution(solver);
        EXPECT_EQ(end_fault(), at == 0 || call == FileCall::write || call == FileCall::read);
      }
    }
  }
}

TEST_F(Faults, NoRoomOnTheDiskIsKnownBeforeAnyWork) {
  Solver solver(options_);
  plan_fault({FileCall::reserve, 0, ENOSPC});
  expect_file_error(solver, ENOSPC, "bytes", [&] { solver.factor(a_.view()); });
}

// Where room cannot be reserved, files have names at first.
TEST_F(Faults, FileSystemsThatCanDoLess) {
  for (const FileFault& fault :
       {FileFault{FileCall::reserve, 0, EOPNOTSUPP}, FileFault{FileCall::open, 0, EOPNOTSUPP},
        FileFault{FileCall::open, 0, EISDIR}}) {
    Solver solver(options_);
    plan_fault(fault);
    solver.factor(a_.view());
    EXPECT_TRUE(end_fault());
    EXPECT_TRUE(folder_is_empty());
    expect_solution(solver);
  }
}

TEST_F(Faults, FoldersThatCannotBeUsed) {
  const std::string file = folder_.write("file", "");
  for (const auto& [folder, code] :
       {std::pair{folder_.path("no/such"), ENOENT}, {file, ENOTDIR}, {file + "/below", ENOTDIR}}) {
    Options options = options_;
    options.out_of_core_dir = folder;
    Solver solver(options);
    const auto error = failure_of<BackendError>([&] { solver.factor(a_.view()); });
    if (error) {
      EXPECT_EQ(error->code(), code);
      EXPECT_THAT(error->what(), HasSubstr(folder));
    }
    expect_usable(solver);
  }
  if (geteuid() == 0) return;  // who may write everywhere
  chmod(folder_.path("").c_str(), 0500);
  Solver solver(options_);
  EXPECT_EQ(failure_of<BackendError>([&] { solver.factor(a_.view()); })->code(), EACCES);
  chmod(folder_.path("").c_str(), 0700);
}

/// What others can do to the file, by its descriptor.
class Damage : public Faults {
 protected:
  std::string link() const { return "/proc/self/fd/" + std::to_string(factor_file()); }
  std::int64_t size() const {
    struct stat file {};
    EXPECT_EQ(stat(link().c_str(), &file), 0);
    return file.st_size;
  }
  void change_byte(std::int64_t at) const {
    const int file = ::open(link().c_str(), O_RDWR);
    char byte = 0;
    EXPECT_EQ(::pread(file, &byte, 1, at), 1);
    byte = static_cast<char>(byte ^ 0x40);
    EXPECT_EQ(::pwrite(file, &byte, 1, at), 1);
    close(file);
  }
};

TEST_F(Damage, ATruncatedFileIsToldAsSuch) {
  Solver solver(options_);
  solver.factor(a_.view());
  const std::int64_t all = size();
  EXPECT_GE(all, solver.report().bytes_out);
  EXPECT_NE(fcntl(factor_file(), F_GETFD) & FD_CLOEXEC, 0);
  for (const std::int64_t left : {std::int64_t{0}, all / 2}) {
    ASSERT_EQ(truncate(link().c_str(), left), 0);
    expect_file_error(solver, EBADMSG, "is not there any more", [&] { solve(solver); });
  }
}

TEST_F(Damage, AnAlteredFileIsToldAsSuch) {
  Solver solver(options_);
  solver.factor(a_.view());
  for (const double part : {0.0, 0.3, 0.5, 0.7}) {
    const auto at = static_cast<std::int64_t>(part * static_cast<double>(solver.report().bytes_out));
    change_byte(at);
    failure_of<BackendError>([&] { solve(solver); });
    change_byte(at);
    expect_solution(solver);
    change_byte(at);
    expect_file_error(solver, EBADMSG, "is not what was written", [&] { solve(solver); });
  }
}

// The signal of a file's limit would end the process.
TEST_F(Faults, ALimitOfTheFilesSizeIsAnError) {
  rlimit usual{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
  const auto set = [&](rlim_t bytes) {
    const rlimit limit{bytes, usual.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  };
  Solver solver(options_);
  set(4096);
  EXPECT_EQ(failure_of<BackendError>([&] { solver.factor(a_.view()); })->code(), EFBIG);
  set(usual.rlim_cur);
  solver.factor(a_.view());
  set(4096);
  EXPECT_EQ(failure_of<BackendError>([&] { solver.refactor(a_.view()); })->code(), EFBIG);
  set(usual.rlim_cur);
  solver.refactor(a_.view());
  expect_solution(solver);
}

TEST_F(Faults, AThreadThatIsRefusedIsAnError) {
  Options options = options_;
  options.threads = 1;
  Solver solver(options);
  solver.factor(a_.view());
  {
    const RefusedThreads refused;
    const auto error = failure_of<BackendError>([&] { solve(solver); });
    EXPECT_EQ(error->library(), "threads");
  }
  std::vector<double> x(b_.size());
  solver.solve(b_.data(), x.data());
  EXPECT_LE(backward_error(a_, b_, x), kPromised);
}

#ifndef __SANITIZE_ADDRESS__  // which keeps what was freed
/// The most that the process has held since the last call, and what it holds now; bytes.
std::int64_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(key, 0) == 0) return std::stoll(line.substr(key.size())) * 1024;
  }
  return -1;
}
std::int64_t held() {
  std::ofstream("/proc/self/clear_refs") << "5";
  return status_bytes("VmRSS:");
}

// As the kernel sees it, from after the analysis on.
TEST_F(OutOfCore, MemoryIsWithinTheLimit) {
  constexpr std::int64_t kSlack = std::int64_t{8} << 20;  // stacks, and what BLAS has for a thread
  const SparseMatrix a = grid_3d(32);
  Solver in_memory(with_threads(2));
  in_memory.analyze(a.view());
  const std::int64_t enough = in_memory.report().bytes_peak;
  const std::vector<double> b = right_hand_sides(a, 16, a.n, 9);
  std::vector<double> x(b.size());
  {
    Solver warm(with_threads(2));
    warm.factor(grid_3d(14).view());
  }
  for (const std::int64_t limit : {enough, enough / 2, enough * 2 / 5}) {
    Solver solver(within(with_threads(2), limit));
    solver.analyze(a.view());
    EXPECT_EQ(solver.report().partial, limit < enough);
    const std::int64_t before = held();
    solver.factor(a.view());
    solver.solve(b.data(), x.data());
    solver.refactor(a.view());
    solver.solve(b.data(), x.data());
    const std::int64_t most = status_bytes("VmHWM:") - before;
    EXPECT_LE(most, limit + kSlack) << "of " << enough;
    EXPECT_GE(most, limit / 2);
    if (limit < enough) {
      solver.solve(b.data(), x.data(), 16);
      EXPECT_LE(status_bytes("VmHWM:") - before, limit + kSlack) << "16 columns";
    }
  }
}

#endif  // __SANITIZE_ADDRESS__

}  // namespace
}  // namespace mfs::test
