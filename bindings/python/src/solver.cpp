// The module mfs._mfs: one class for each kind of numbers, on arrays whose kinds and sizes are checked here,
// and which lie where the caller has them. The package around it (mfs/__init__.py) is what users see.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <complex>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <mfs/mfs.hpp>

#include "errors.hpp"

namespace mfs::python {
namespace {

namespace nb = nanobind;

template <class T>
using Array = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using Columns = nb::ndarray<T, nb::ndim<2>, nb::f_contig, nb::device::cpu>;

/// `progress` is called with the name of the phase and the fraction of it that is done, unless it is None.
/// What it raises ends a phase, and so does Ctrl-C.
template <class Scalar>
BasicSolver<Scalar> make_solver(const std::map<std::string, std::string>& texts, const nb::object& progress) {
  Options options;
  for (const auto& [name, text] : texts) set_option(options, name, text);
  options.progress = [progress](const Progress& at) {
    const nb::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(at.phase, at.fraction);
  };
  return BasicSolver<Scalar>(std::move(options));
}

/// The arrays of a square matrix in compressed rows; their lengths are checked, the rest by libmfs.
template <class Scalar, class Index>
CsrView<Scalar> view(const Array<Index>& offsets, const Array<Index>& columns, const Array<Scalar>* values) {
  if (offsets.size() == 0) throw InvalidInput("row_offsets", "has no entry");
  const auto nnz = static_cast<std::int64_t>(offsets.data()[offsets.size() - 1]);
  if (nnz < 0 || static_cast<std::uint64_t>(nnz) > columns.size())
    throw InvalidInput("column_indices", "fewer than the last of the row offsets says");
  if (values != nullptr && static_cast<std::uint64_t>(nnz) > values->size())
    throw InvalidInput("values", "fewer than the last of the row offsets says");
  const auto n = static_cast<std::int64_t>(offsets.size()) - 1;
  return {n, n, offsets.data(), columns.data(), values != nullptr ? values->data() : nullptr};
}

/// As one function of Python: analyze or factor, which want a matrix.
template <class Scalar, class Index>
auto taking_matrix(void (BasicSolver<Scalar>::*phase)(const CsrView<Scalar>&)) {
  return [phase](BasicSolver<Scalar>& s, Array<Index> offsets, Array<Index> columns, Array<Scalar> values) {
    const CsrView<Scalar> a = view<Scalar>(offsets, columns, &values);
    const nb::gil_scoped_release released;
    (s.*phase)(a);
  };
}

template <class Scalar, class Index>
void bind_matrix(nb::class_<BasicSolver<Scalar>>& solver) {
  using Solver = BasicSolver<Scalar>;
  solver
      .def("analyze", taking_matrix<Scalar, Index>(&Solver::analyze), nb::arg("row_offsets"),
           nb::arg("columns"), nb::arg("values"))
      .def("factor", taking_matrix<Scalar, Index>(&Solver::factor), nb::arg("row_offsets"),
           nb::arg("columns"), nb::arg("values"));
}

template <class Scalar>
void solve(BasicSolver<Scalar>& s, const Columns<const Scalar>& b, const Columns<Scalar>& x,
           bool transposed) {
  const auto rows = static_cast<std::int64_t>(b.shape(0)), columns = static_cast<std::int64_t>(b.shape(1));
  if (rows != s.report().n) throw InvalidInput("b", "has another number of rows than the matrix");
  if (x.shape(0) != b.shape(0) || x.shape(1) != b.shape(1))
    throw InvalidInput("x", "has another shape than b");
  const nb::gil_scoped_release released;
  if (transposed)
    s.solve_transpose(b.data(), x.data(), columns);
  else
    s.solve(b.data(), x.data(), columns);
}

template <class T>
T* at(std::uintptr_t address) {
  return reinterpret_cast<T*>(address);
}

template <class Scalar>
void solve_device(BasicSolver<Scalar>& s, std::uintptr_t b, std::uintptr_t x, std::int64_t columns,
                  std::int64_t ldb, std::int64_t ldx, std::uintptr_t stream, bool transposed) {
  const nb::gil_scoped_release released;
  const auto call =
      transposed ? &BasicSolver<Scalar>::solve_transpose_device : &BasicSolver<Scalar>::solve_device;
  (s.*call)(at<const Scalar>(b), at<Scalar>(x), columns, ldb, ldx, at<void>(stream));
}

template <class Scalar>
void bind_solver(nb::module_& m, const char* name) {
  using Solver = BasicSolver<Scalar>;
  nb::class_<Solver> solver(m, name);
  solver
      .def(
          "__init__",
          [](Solver* s, const std::map<std::string, std::string>& options, const nb::object& progress) {
            new (s) Solver(make_solver<Scalar>(options, progress));
          },
          nb::arg("options"), nb::arg("progress").none())
      .def(
          "refactor",
          [](Solver& s, Array<Scalar> values, std::uint64_t entries) {
            if (values.size() != entries)
              throw InvalidInput("values", "not as many as the matrix has entries");
            const nb::gil_scoped_release released;
            s.refactor(values.data());
          },
          nb::arg("values"), nb::arg("entries"))
      .def("solve", solve<Scalar>, nb::arg("b"), nb::arg("x"), nb::arg("transposed"))
      .def(
          "refactor_device",
          [](Solver& s, std::uintptr_t values, std::uintptr_t stream) {
            const nb::gil_scoped_release released;
            s.refactor_device(at<const Scalar>(values), at<void>(stream));
          },
          nb::arg("values"), nb::arg("stream"), "Addresses of an array on the device and of a stream.")
      .def("solve_device", solve_device<Scalar>, nb::arg("b"), nb::arg("x"), nb::arg("columns"),
           nb::arg("ldb"), nb::arg("ldx"), nb::arg("stream"), nb::arg("transposed"))
      .def("condition_estimate",
           [](Solver& s) {
             const nb::gil_scoped_release released;
             return s.condition_estimate();
           })
      .def("determinant",
           [](Solver& s) {
             const Determinant<Scalar> d = s.determinant();
             return std::tuple(static_cast<double>(std::real(d.phase)),
                               static_cast<double>(std::imag(d.phase)), d.log_abs);
           })
      .def("factored", &Solver::factored)
      .def("figures",
           [](const Solver& s) {
             std::map<std::string, double> by_name;
             for (const Figure& figure : figures(s.report())) by_name[figure.name] = figure.value;
             return by_name;
           })
      .def("depths",
           [](const Solver& s) {
             std::vector<std::vector<double>> rows;
             for (const DepthSummary& d : s.depths())
               rows.push_back({double(d.depth), double(d.fronts), double(d.pivots), double(d.max_front),
                               double(d.factor_entries), double(d.contribution_entries), d.flops.total()});
             return rows;
           })
      .def("backend_name", [](const Solver& s) { return backend_name(s.report().backend); })
      .def("rung_name", [](const Solver& s) { return rung_name(s.report().rung); });
  bind_matrix<Scalar, std::int32_t>(solver);
  bind_matrix<Scalar, std::int64_t>(solver);
}

/// Where an array of DLPack lies, and what it is: (address, kind, bits, shape, strides in elements, writable,
/// owner). It stays there as long as the owner lives.
template <class Array, bool writable>
nb::tuple describe(const Array& array) {
  std::vector<std::int64_t> shape, strides;
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    shape.push_back(static_cast<std::int64_t>(array.shape(i)));
    strides.push_back(array.stride(i));
  }
  const nb::capsule owner(new Array(array), [](void* p) noexcept { delete static_cast<Array*>(p); });
  return nb::make_tuple(reinterpret_cast<std::uintptr_t>(array.data()), int{array.dtype().code},
                        int{array.dtype().bits}, shape, strides, writable, owner);
}

}  // namespace
}  // namespace mfs::python

NB_MODULE(_mfs, m) {
  namespace py = mfs::python;
  m.doc() = "What the package mfs is made of: solvers for each kind of numbers, on checked arrays.";
  m.def("raise_classes_of", py::raise_classes_of, nanobind::arg("errors"),
        "Has errors of MFS raised as the classes of that module; called once.");
  py::bind_solver<float>(m, "SolverFloat");
  py::bind_solver<double>(m, "SolverDouble");
  py::bind_solver<std::complex<float>>(m, "SolverComplexFloat");
  py::bind_solver<std::complex<double>>(m, "SolverComplexDouble");
  const char* described = "Where an array of DLPack (or its capsule) lies, and what it is.";
  m.def("describe", py::describe<nanobind::ndarray<>, true>, nanobind::arg("array"), described);
  m.def("describe", py::describe<nanobind::ndarray<nanobind::ro>, false>, nanobind::arg("array"), described);
  m.def("option_names", mfs::option_names);
  m.def("version", mfs::version);
  m.def("better_blas_kernels", mfs::better_blas_kernels);
  m.def("set_default_threads", mfs::set_default_threads, nanobind::arg("threads"));
  m.def("backends", [] {
    std::vector<std::string> names;
    for (const mfs::Backend backend : mfs::backends()) names.emplace_back(mfs::backend_name(backend));
    return names;
  });
}
