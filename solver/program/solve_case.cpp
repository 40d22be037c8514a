#include "solver/program/solve_case.hpp"

#include <algorithm>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>
#include <mfs/solver.hpp>
#include <mfs/version.hpp>

#include "ordering/stopwatch.hpp"
#include "parts/output_file.hpp"
#include "solver/program/backward_error.hpp"
#include "solver/program/summary.hpp"

namespace mfs::program {
namespace {

// Known before a large file is read.
void check_backend(Backend wanted) {
  const std::vector<Backend> usable = backends();
  if (std::find(usable.begin(), usable.end(), wanted) != usable.end()) return;
  throw std::runtime_error(
      fmt::format("backend {} cannot be used here, only {}", backend_name(wanted), usable_backends()));
}

// Uniform in [-1, 1) with 53 random bits, the same on every machine; complex: both parts.
void draw(std::mt19937_64& random, double& value) {
  value = static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}
void draw(std::mt19937_64& random, std::complex<double>& value) {
  double real = 0, imaginary = 0;
  draw(random, real);
  draw(random, imaginary);
  value = {real, imaginary};
}

// A matrix that has been read, of either field.
template <class Scalar>
class CaseRun {
 public:
  CaseRun(io::CsrMatrix<Scalar> a, CaseResult& result, const SolveRequest& request, ProgressDisplay& display)
      : result_(result), request_(request), display_(display), a_(std::move(a)) {
    result_.n = a_.rows;
    result_.entries = a_.entries();
    result_.complex = !std::is_same_v<Scalar, double>;
  }

  void run() {
    prepare_right_hand_sides();
    Options options = request_.options;
    options.solve.tolerance = request_.tolerance;
    options.progress = display_.callback();
    BasicSolver<Scalar> solver(options);
    factor(solver);
    refactor(solver);
    examine(solver);
    solve(solver);
    measure_accuracy();
    if (!request_.output.empty()) write();
  }

 private:
  void prepare_right_hand_sides() {
    if (request_.rhs != "ones" && request_.rhs != "random") {
      b_ = io::read_right_hand_sides<Scalar>(request_.rhs, a_.rows, request_.options.threads);
      if (request_.nrhs && *request_.nrhs != b_.columns)
        throw InvalidInput("--nrhs", fmt::format("{} holds {} right-hand sides", request_.rhs, b_.columns));
    } else {
      b_.rows = a_.rows;
      b_.columns = request_.nrhs.value_or(1);
      b_.values.assign(static_cast<std::size_t>(b_.rows * b_.columns), 1.0);
      std::mt19937_64 random(kRandomSeed);
      if (request_.rhs == "random")
        for (Scalar& value : b_.values) draw(random, value);
    }
    result_.right_hand_sides = b_.columns;
  }

  void factor(BasicSolver<Scalar>& solver) {
    const Keeper keep(*this, solver);
    solver.analyze(a_.view());
    solver.factor(a_.view());
  }

  void refactor(BasicSolver<Scalar>& solver) {
    const Keeper keep(*this, solver);
    for (int k = 0; k < request_.refactor; ++k) {
      solver.refactor(a_.view());
      const double time = solver.report().time_refactor;
      result_.time_refactor = k == 0 ? time : std::min(result_.time_refactor, time);
      result_.refactorizations = k + 1;
    }
  }

  // Before the solve, since they say why one fails.
  void examine(BasicSolver<Scalar>& solver) {
    const Keeper keep(*this, solver);
    const auto ask = [this](bool wanted, const char* name, const auto& answer) {
      try {
        if (wanted) answer();
      } catch (const AccuracyNotReached&) {
        result_.not_known.emplace_back(name);
      }
    };
    ask(request_.condition, "condition", [&] { result_.condition = solver.condition_estimate(); });
    ask(request_.determinant, "determinant", [&] {
      const Determinant<Scalar> determinant = solver.determinant();
      result_.determinant = {determinant.phase, determinant.log_abs};
    });
  }

  void solve(BasicSolver<Scalar>& solver) {
    const Keeper keep(*this, solver);
    x_ = {b_.rows, b_.columns, {}};
    x_.values.resize(b_.values.size());
    for (int k = 0; k <= request_.refactor; ++k) {
      if (request_.transpose)
        solver.solve_transpose(b_.values.data(), x_.values.data(), b_.columns);
      else
        solver.solve(b_.values.data(), x_.values.data(), b_.columns);
      const double time = solver.report().time_solve;
      result_.time_solve = k == 0 ? time : std::min(result_.time_solve, time);
    }
  }

  void measure_accuracy() {
    const double error = backward_error(a_, request_.transpose, x_, b_);
    result_.backward_error = error;
    if (!(error <= request_.tolerance)) throw AccuracyNotReached(error, request_.tolerance);
  }

  void write() const {
    const std::string comment = fmt::format("solution of {}x = b, backward error {:.2e}",
                                            request_.transpose ? "A^T " : "A ", *result_.backward_error);
    const auto to = [&](const auto& target) {
      write_matrix_market(target, x_.values.data(), x_.rows, x_.columns, x_.rows, comment);
    };
    if (request_.output == "-")
      to(stdout);
    else
      to(request_.output);
  }

  // Takes the solver's report when a phase ends, be it by an exception.
  class Keeper {
   public:
    Keeper(CaseRun& run, const BasicSolver<Scalar>& solver) : run_(run), solver_(solver) {}
    ~Keeper() {
      run_.display_.clear();
      if (!solver_.analyzed()) return;
      run_.result_.report = solver_.report();
      run_.result_.depths = solver_.depths();
    }
    Keeper(const Keeper&) = delete;
    Keeper& operator=(const Keeper&) = delete;

   private:
    CaseRun& run_;
    const BasicSolver<Scalar>& solver_;
  };

  CaseResult& result_;
  const SolveRequest& request_;
  ProgressDisplay& display_;
  io::CsrMatrix<Scalar> a_;
  io::DenseMatrix<Scalar> b_, x_;
};

void run_case(const std::function<io::SquareMatrix()>& load, const SolveRequest& request,
              ProgressDisplay& display, CaseResult& result) {
  check_backend(request.options.backend);
  if (!request.output.empty()) io::check_writable(request.output);
  display.show("read", 0);
  const Stopwatch watch;
  io::SquareMatrix matrix = load();
  result.time_read = watch.seconds();
  std::visit([&](auto& a) { CaseRun(std::move(a), result, request, display).run(); }, matrix);
}

}  // namespace

CaseResult solve_case(const std::string& name, const std::function<io::SquareMatrix()>& load,
                      const SolveRequest& request, ProgressDisplay& display) {
  CaseResult result;
  result.name = name;
  result.backend = request.options.backend;
  result.threads = request.options.threads;
  result.tolerance = request.tolerance;
  try {
    run_case(load, request, display, result);
  } catch (...) {
    const Failure failure = describe_current_exception();
    result.code = failure.code;
    // Faults of a file name it themselves.
    result.message = result.n > 0 ? name + ": " + failure.message : failure.message;
  }
  display.clear();
  return result;
}

}  // namespace mfs::program
