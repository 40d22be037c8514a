#include <mfs/solver.hpp>

#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "solver/backend.hpp"
#include "solver/block_solve.hpp"
#include "solver/depth_table.hpp"
#include "solver/failing_system.hpp"
#include "solver/matrix_factors.hpp"
#include "solver/memory_limit.hpp"
#include "solver/option_checks.hpp"
#include "solver/solve_rules.hpp"

namespace mfs {

namespace {

Options checked(Options options) {
  check_options(options);
  return options;
}

}  // namespace

template <class Scalar>
struct BasicSolver<Scalar>::Impl {
  explicit Impl(Options asked) : options(checked(std::move(asked))) {}

  double condition_estimate() {
    double condition = 0;
    const SolveControls controls = controls_of<Scalar>(options.solve);
    const Verdict verdict = judge("condition_estimate", [&](Factorization<Scalar>& numeric) {
      condition = numeric.condition_estimate(factors.transposed_pattern(), controls);
      if (std::isnan(condition)) return Verdict::unknown;
      return std::isinf(condition) ? Verdict::singular : Verdict::known;
    });
    if (verdict == Verdict::unknown) refuse("the condition number");
    return verdict == Verdict::singular ? std::numeric_limits<double>::infinity() : condition;
  }

  Determinant<Scalar> determinant() {
    FoundDeterminant<Scalar> found;
    const Verdict verdict = judge("determinant", [&](Factorization<Scalar>& numeric) {
      found = numeric.determinant();
      if (found.digits != Digits::all) return Verdict::unknown;
      return found.phase == Scalar(0) ? Verdict::singular : Verdict::known;
    });
    if (verdict == Verdict::singular) return {Scalar(0), -std::numeric_limits<double>::infinity()};
    if (found.digits == Digits::none) refuse("the determinant");
    return {found.phase, found.log_abs};
  }

  // What work(factors) says of the first factors by which the number is known, or of the last that there are.
  // That A is singular is said of no factors where others are to be tried, as a solve has it.
  enum class Verdict { known, singular, unknown };
  template <class Work>
  Verdict judge(const char* call, const Work& work) {
    factors.numeric(call);
    factors.drop_rescaling();
    Verdict verdict = Verdict::unknown;
    try {
      do {
        phases.run("solve", [&] { verdict = work(factors.numeric(call)); });
      } while (verdict != Verdict::known && factors.climb(verdict == Verdict::singular));
    } catch (const SingularMatrix&) {  // by the numbers that are not zero
      verdict = Verdict::singular;
    }
    return verdict;
  }

  [[noreturn]] void refuse(const char* what) const {
    AccuracyNotReached error(std::numeric_limits<double>::infinity(), tolerance_of<Scalar>(options.solve));
    error.append(std::string("; the factors leave no digit of ") + what);
    throw error;
  }

  const Options options;
  Report report;
  Phases phases{options, threads_of(options), analysis_threads_of(options),
                rules_of(options.backend).uses_kokkos()};
  MatrixFactors<Scalar> factors{options, phases, report};
  BlockSolve<Scalar> solves{options, phases, factors, report};
};

template <class Scalar>
BasicSolver<Scalar>::BasicSolver(Options options)
    : impl_(told_as_out_of_memory([&] { return std::make_unique<Impl>(std::move(options)); })) {}
template <class Scalar>
BasicSolver<Scalar>::~BasicSolver() = default;
template <class Scalar>
BasicSolver<Scalar>::BasicSolver(BasicSolver&&) noexcept = default;
template <class Scalar>
BasicSolver<Scalar>& BasicSolver<Scalar>::operator=(BasicSolver&&) noexcept = default;

// The implementation, unless the object was moved from.
template <class Scalar>
typename BasicSolver<Scalar>::Impl& BasicSolver<Scalar>::impl() const {
  if (!impl_) throw StateError("the solver was moved from");
  return *impl_;
}
template <class Scalar>
void BasicSolver<Scalar>::analyze(const CsrView<Scalar>& a) {
  told_as_out_of_memory([&] {
    run_phase(
        impl().options.dump_prefix, [&] { impl().factors.analyze(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::factor(const CsrView<Scalar>& a) {
  told_as_out_of_memory([&] {
    run_phase(
        impl().options.dump_prefix, [&] { impl().factors.factor(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor(const CsrView<Scalar>& a) {
  told_as_out_of_memory([&] {
    run_phase(
        impl().options.dump_prefix, [&] { impl().factors.refactor(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor(const Scalar* values) {
  told_as_out_of_memory([&] {
    run_phase(
        impl().options.dump_prefix, [&] { impl().factors.refactor(values); },
        [&] { return System<Scalar>{impl().factors.analysis().caller_view(values)}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor_device(const Scalar* values, void* stream) {
  told_as_out_of_memory([&] { impl().factors.refactor_device(values, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_device(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                       std::int64_t ldx, void* stream) {
  told_as_out_of_memory([&] { impl().solves.solve_device({b, x, nrhs, ldb, ldx, false}, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_transpose_device(const Scalar* b, Scalar* x, std::int64_t nrhs,
                                                 std::int64_t ldb, std::int64_t ldx, void* stream) {
  told_as_out_of_memory([&] { impl().solves.solve_device({b, x, nrhs, ldb, ldx, true}, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                std::int64_t ldx) {
  told_as_out_of_memory([&] { impl().solves.solve({b, x, nrhs, ldb, ldx, false}); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_transpose(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                          std::int64_t ldx) {
  told_as_out_of_memory([&] { impl().solves.solve({b, x, nrhs, ldb, ldx, true}); });
}
template <class Scalar>
double BasicSolver<Scalar>::condition_estimate() {
  return told_as_out_of_memory([&] { return impl().condition_estimate(); });
}
template <class Scalar>
Determinant<Scalar> BasicSolver<Scalar>::determinant() {
  return told_as_out_of_memory([&] { return impl().determinant(); });
}
template <class Scalar>
bool BasicSolver<Scalar>::analyzed() const {
  return impl_ && impl_->factors.analyzed();
}
template <class Scalar>
bool BasicSolver<Scalar>::factored() const {
  return impl_ && impl_->factors.factored();
}
template <class Scalar>
const Report& BasicSolver<Scalar>::report() const {
  return impl().report;
}
template <class Scalar>
const Options& BasicSolver<Scalar>::options() const {
  return impl().options;
}
template <class Scalar>
std::vector<DepthSummary> BasicSolver<Scalar>::depths() const {
  if (!impl().factors.analyzed()) return {};
  return depth_table(*impl().factors.analysis().plan, impl().factors.step_flops(),
                     impl().factors.movement().segments);
}

template class BasicSolver<float>;
template class BasicSolver<double>;
template class BasicSolver<std::complex<float>>;
template class BasicSolver<std::complex<double>>;

}  // namespace mfs
