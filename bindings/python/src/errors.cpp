#include "errors.hpp"

#include <exception>

#include <mfs/error.hpp>

namespace mfs::python {
namespace {

namespace nb = nanobind;

/// Row or column; None for "none".
nb::object place(std::int64_t index) {
  return index < 0 ? nb::none() : nb::object(nb::int_(index));
}

nb::object describe(nb::handle classes, const std::exception_ptr& thrown) {
  const auto make = [&](const char* name, const Error& e) { return classes.attr(name)(e.what()); };
  nb::object error;
  try {
    std::rethrow_exception(thrown);
  } catch (const InvalidInput& e) {
    error = make("InvalidInput", e);
    error.attr("argument") = e.argument().c_str();
    error.attr("row") = place(e.row());
    error.attr("column") = place(e.column());
  } catch (const SingularMatrix& e) {
    error = make("SingularMatrix", e);
    error.attr("kind") = e.kind() == SingularMatrix::Kind::structural ? "structural" : "numerical";
    error.attr("row") = place(e.row());
    error.attr("column") = place(e.column());
    error.attr("dependent_rows") = e.dependent_rows();
  } catch (const PatternChanged& e) {
    error = make("PatternChanged", e);
    error.attr("row") = place(e.row());
  } catch (const AccuracyNotReached& e) {
    error = make("AccuracyNotReached", e);
    error.attr("reached") = e.reached();
    error.attr("asked") = e.asked();
  } catch (const OutOfMemory& e) {
    error = make("OutOfMemory", e);
    error.attr("space") = e.space() == MemorySpace::host ? "host" : "device";
    error.attr("needed") = e.needed();
    error.attr("available") = e.available();
  } catch (const BackendError& e) {
    error = make("BackendError", e);
    error.attr("library") = e.library().c_str();
    error.attr("code") = e.code();
  } catch (const StateError& e) {
    error = make("StateError", e);
  } catch (const Error& e) {
    error = make("Error", e);
  }
  return error;  // what is none of ours goes on to the next translator
}

}  // namespace

void raise_classes_of(const nb::module_& errors) {
  nb::register_exception_translator(
      [](const std::exception_ptr& thrown, void* classes) {
        const nb::object error = describe(static_cast<PyObject*>(classes), thrown);
        PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
      },
      errors.inc_ref().ptr());
}

}  // namespace mfs::python
