// The functions of mfs/mfs.h. Each call into the C++ class goes through attempt (last_error.hpp): no
// exception passes the frames of a caller that is C.
#include <mfs/mfs.h>

#include <memory>
#include <string>

#include "handle.hpp"
#include "last_error.hpp"

using mfs::c::attempt;

namespace {

std::unique_ptr<mfs_solver> make_solver(int scalar, int index_bits) {
  if (index_bits != 32 && index_bits != 64)
    throw mfs::InvalidInput("index_bits", std::to_string(index_bits) + " is not 32 or 64");
  const bool wide = index_bits == 64;
  switch (scalar) {
    case MFS_FLOAT:
      return std::make_unique<mfs::c::Handle<float>>(wide);
    case MFS_DOUBLE:
      return std::make_unique<mfs::c::Handle<double>>(wide);
    case MFS_COMPLEX_FLOAT:
      return std::make_unique<mfs::c::Handle<std::complex<float>>>(wide);
    case MFS_COMPLEX_DOUBLE:
      return std::make_unique<mfs::c::Handle<std::complex<double>>>(wide);
  }
  throw mfs::InvalidInput("scalar", std::to_string(scalar) + " is none of the kinds of numbers");
}

/// `argument` of the caller, which must not be null.
template <class T>
T& there(T* argument, const char* name) {
  if (argument == nullptr) throw mfs::InvalidInput(name, "is NULL");
  return *argument;
}

const char* name_of_figure(int index) {
  static const std::vector<mfs::Figure> all = mfs::figures({});
  return index >= 0 && index < static_cast<int>(all.size()) ? all[static_cast<std::size_t>(index)].name
                                                            : nullptr;
}

const char* name_of_option(int index) {
  static const std::vector<std::string> all = mfs::option_names();
  return index >= 0 && index < static_cast<int>(all.size()) ? all[static_cast<std::size_t>(index)].c_str()
                                                            : nullptr;
}

/// Where memory for the list of names is refused, there are none.
const char* name_or_null(const char* (*name)(int), int index) noexcept {
  const char* found = nullptr;
  attempt([&] { found = name(index); });
  return found;
}

}  // namespace

int mfs_create(int scalar, int index_bits, mfs_solver** solver) {
  return attempt([&] {
    there(solver, "solver") = nullptr;
    *solver = make_solver(scalar, index_bits).release();
  });
}

void mfs_destroy(mfs_solver* solver) {
  delete solver;
}

int mfs_set_option(mfs_solver* solver, const char* name, const char* value) {
  return attempt([&] { there(solver, "solver").set_option(&there(name, "name"), &there(value, "value")); });
}

const char* mfs_option_name(int index) {
  return name_or_null(name_of_option, index);
}

int mfs_last_error(const char** text, int64_t* row, int64_t* column) {
  const mfs::c::LastError& error = mfs::c::last_error();
  if (text != nullptr) *text = error.text;
  if (row != nullptr) *row = error.row;
  if (column != nullptr) *column = error.column;
  return error.status;
}

const char* mfs_last_error_argument(void) {
  return mfs::c::last_error().argument;
}

int mfs_analyze(mfs_solver* solver, int64_t n, const void* row_offsets, const void* columns,
                const void* values) {
  return attempt([&] { there(solver, "solver").analyze({n, row_offsets, columns, values}); });
}

int mfs_factor(mfs_solver* solver, int64_t n, const void* row_offsets, const void* columns,
               const void* values) {
  return attempt([&] { there(solver, "solver").factor({n, row_offsets, columns, values}); });
}

int mfs_refactor(mfs_solver* solver, const void* values) {
  return attempt([&] { there(solver, "solver").refactor(values); });
}

int mfs_solve(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb, int64_t ldx) {
  return attempt([&] { there(solver, "solver").solve({b, x, columns, ldb, ldx}, false); });
}

int mfs_solve_transpose(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb,
                        int64_t ldx) {
  return attempt([&] { there(solver, "solver").solve({b, x, columns, ldb, ldx}, true); });
}

int mfs_refactor_device(mfs_solver* solver, const void* values, void* stream) {
  return attempt([&] { there(solver, "solver").refactor_device(values, stream); });
}

int mfs_solve_device(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb, int64_t ldx,
                     void* stream) {
  return attempt([&] { there(solver, "solver").solve_device({b, x, columns, ldb, ldx}, false, stream); });
}

int mfs_solve_transpose_device(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb,
                               int64_t ldx, void* stream) {
  return attempt([&] { there(solver, "solver").solve_device({b, x, columns, ldb, ldx}, true, stream); });
}

int mfs_condition_estimate(mfs_solver* solver, double* condition) {
  return attempt([&] { there(condition, "condition") = there(solver, "solver").condition_estimate(); });
}

int mfs_determinant(mfs_solver* solver, double phase[2], double* log_abs) {
  return attempt([&] {
    there(phase, "phase");
    there(log_abs, "log_abs");
    const mfs::c::DeterminantParts parts = there(solver, "solver").determinant();
    phase[0] = parts.real;
    phase[1] = parts.imaginary;
    *log_abs = parts.log_abs;
  });
}

int mfs_report(const mfs_solver* solver, const char* name, double* value) {
  return attempt([&] {
    const std::string asked = &there(name, "name");
    there(value, "value");
    for (const mfs::Figure& figure : mfs::figures(there(solver, "solver").report())) {
      if (asked != figure.name) continue;
      *value = figure.value;
      return;
    }
    throw mfs::InvalidInput("name", "a report has no figure \"" + asked + "\"");
  });
}

const char* mfs_report_name(int index) {
  return name_or_null(name_of_figure, index);
}

const char* mfs_version(void) {
  return mfs::version();
}

int mfs_set_default_threads(int threads) {
  return attempt([&] { mfs::set_default_threads(threads); });
}
