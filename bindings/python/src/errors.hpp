// Exceptions of libmfs as classes of Python.
#pragma once

#include <nanobind/nanobind.h>

namespace mfs::python {

/// Has each class of mfs/error.hpp raised as the class of that name of the Python module `errors`, with its
/// place and its figures as attributes. Called once.
void raise_classes_of(const nanobind::module_& errors);

}  // namespace mfs::python
