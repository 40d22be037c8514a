// What an mfs_solver is: options until the first phase, then a solver of one kind of numbers.
#pragma once

#include <complex>
#include <cstdint>
#include <optional>

#include <mfs/mfs.hpp>

namespace mfs::c {

/// n x columns numbers that are column-major, as mfs_solve has them.
struct Columns {
  const void* b;
  void* x;
  std::int64_t columns, ldb, ldx;
};
struct Rows {
  std::int64_t n;
  const void *offsets, *columns, *values;
};
struct DeterminantParts {
  double real, imaginary, log_abs;
};

}  // namespace mfs::c

/// Its members throw what those of mfs::BasicSolver throw.
struct mfs_solver {
  virtual ~mfs_solver() = default;
  virtual void set_option(const char* name, const char* value) = 0;
  virtual void analyze(const mfs::c::Rows& rows) = 0;
  virtual void factor(const mfs::c::Rows& rows) = 0;
  virtual void refactor(const void* values) = 0;
  virtual void refactor_device(const void* values, void* stream) = 0;
  virtual void solve(const mfs::c::Columns& c, bool transposed) = 0;
  virtual void solve_device(const mfs::c::Columns& c, bool transposed, void* stream) = 0;
  virtual double condition_estimate() = 0;
  virtual mfs::c::DeterminantParts determinant() = 0;
  virtual mfs::Report report() const = 0;
};

namespace mfs::c {

template <class Scalar>
class Handle final : public ::mfs_solver {
 public:
  explicit Handle(bool wide) : wide_(wide) {}

  void set_option(const char* name, const char* value) override {
    if (solver_) throw StateError("options are set before the first analysis");
    Options alone, all = options_;
    mfs::set_option(alone, name, value);
    BasicSolver<Scalar>{alone};  // refuses what makes no sense
    mfs::set_option(all, name, value);
    options_ = std::move(all);
  }

  void analyze(const Rows& rows) override { made().analyze(view(rows)); }
  void factor(const Rows& rows) override {
    if (rows.values == nullptr) throw InvalidInput("values", "are NULL");
    made().factor(view(rows));
  }
  void refactor(const void* values) override { ready().refactor(numbers(values, "values")); }
  void refactor_device(const void* values, void* stream) override {
    ready().refactor_device(numbers(values, "values"), stream);
  }
  void solve(const Columns& c, bool transposed) override {
    BasicSolver<Scalar>& solver = ready();
    const auto call = transposed ? &BasicSolver<Scalar>::solve_transpose : &BasicSolver<Scalar>::solve;
    (solver.*call)(numbers(c.b, "b"), numbers(c.x, "x"), c.columns, c.ldb, c.ldx);
  }
  void solve_device(const Columns& c, bool transposed, void* stream) override {
    BasicSolver<Scalar>& solver = ready();
    const auto call =
        transposed ? &BasicSolver<Scalar>::solve_transpose_device : &BasicSolver<Scalar>::solve_device;
    (solver.*call)(numbers(c.b, "b"), numbers(c.x, "x"), c.columns, c.ldb, c.ldx, stream);
  }
  double condition_estimate() override { return ready().condition_estimate(); }
  DeterminantParts determinant() override {
    const Determinant<Scalar> d = ready().determinant();
    return {static_cast<double>(std::real(d.phase)), static_cast<double>(std::imag(d.phase)), d.log_abs};
  }
  Report report() const override { return solver_ ? solver_->report() : Report(); }

 private:
  CsrView<Scalar> view(const Rows& rows) const {
    if (rows.offsets == nullptr) throw InvalidInput("row_offsets", "are NULL");
    if (rows.columns == nullptr) throw InvalidInput("column_indices", "are NULL");
    const auto span = [this](const void* data) {
      return wide_ ? IndexSpan(static_cast<const std::int64_t*>(data))
                   : IndexSpan(static_cast<const std::int32_t*>(data));
    };
    return {rows.n, rows.n, span(rows.offsets), span(rows.columns), static_cast<const Scalar*>(rows.values)};
  }
  static const Scalar* numbers(const void* data, const char* name) {
    if (data == nullptr) throw InvalidInput(name, "is NULL");
    return static_cast<const Scalar*>(data);
  }
  static Scalar* numbers(void* data, const char* name) {
    return const_cast<Scalar*>(numbers(static_cast<const void*>(data), name));
  }
  BasicSolver<Scalar>& made() {
    if (!solver_) solver_.emplace(options_);
    return *solver_;
  }
  BasicSolver<Scalar>& ready() {
    if (!solver_) throw StateError("nothing has been factored");
    return *solver_;
  }

  const bool wide_;
  Options options_;
  std::optional<BasicSolver<Scalar>> solver_;
};

}  // namespace mfs::c
