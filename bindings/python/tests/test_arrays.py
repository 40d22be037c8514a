"""What the package finds out about arrays on a device and about libraries, without a device."""

import ctypes
import importlib
import os
import pathlib
import sys
import tempfile
import unittest
import warnings
from unittest import mock

import numpy as np

import mfs
import mfs._arrays
import mfs._library
from test_mfs import unsymmetric, vectors


class OnDevice:
    """An array that says it lies on a device."""

    def __init__(self, shape, strides=None, typestr="<f8", read_only=False, address=4096, **more):
        interface = {"shape": shape, "strides": strides, "typestr": typestr, "version": 3, "stream": 1}
        self.__cuda_array_interface__ = {**interface, "data": (address, read_only), **more}


class Managed(ctypes.Structure):
    """DLManagedTensor of DLPack, and DLManagedTensorVersioned with its leading and trailing members."""


class Tensor(ctypes.Structure):
    _fields_ = [
        ("data", ctypes.c_void_p), ("device_type", ctypes.c_int32), ("device", ctypes.c_int32), ("ndim", ctypes.c_int32),
        ("code", ctypes.c_uint8), ("bits", ctypes.c_uint8), ("lanes", ctypes.c_uint16),
        ("shape", ctypes.POINTER(ctypes.c_int64)), ("strides", ctypes.POINTER(ctypes.c_int64)), ("offset", ctypes.c_uint64),
    ]  # fmt: skip


DELETER = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
Managed._fields_ = [("tensor", Tensor), ("context", ctypes.c_void_p), ("deleter", DELETER)]


class Versioned(ctypes.Structure):
    _fields_ = [
        ("major", ctypes.c_uint32), ("minor", ctypes.c_uint32), ("context", ctypes.c_void_p), ("deleter", DELETER),
        ("flags", ctypes.c_uint64), ("tensor", Tensor),
    ]  # fmt: skip


class ByDLPack:
    """The same by DLPack; `given_back` once nobody uses it, `streams` are those that it was asked for."""

    def __init__(self, shape, strides=None, kind=2, device=0, code=2, bits=64, address=4096, versioned=True, read_only=False):
        self.place, self.versioned, self.streams, self.given_back = (kind, device), versioned, [], 0
        self.shape = (ctypes.c_int64 * len(shape))(*shape)
        self.strides = (ctypes.c_int64 * len(shape))(*strides) if strides else None
        self.deleter = DELETER(self.delete)
        tensor = Tensor(address, kind, device, len(shape), code, bits, 1, self.shape, self.strides, 0)
        if versioned:
            self.managed = Versioned(1, 0, None, self.deleter, 1 if read_only else 0, tensor)
        else:
            self.managed = Managed(tensor, None, self.deleter)

    def delete(self, _):
        self.given_back += 1

    def __dlpack_device__(self):
        return self.place

    def __dlpack__(self, **asked):
        if "max_version" in asked and not self.versioned:
            raise TypeError("__dlpack__() got an unexpected keyword argument 'max_version'")
        self.streams.append(asked["stream"])
        new = ctypes.pythonapi.PyCapsule_New
        new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        return new(ctypes.addressof(self.managed), b"dltensor_versioned" if self.versioned else b"dltensor", None)


class SolverOnDevice:
    """In place of the solver of an LU: notes what it is called with, and that arrays are there meanwhile."""

    def __init__(self, *arrays):
        self.arrays, self.calls = arrays, []

    def solve_device(self, *arguments):
        self.calls.append(arguments)
        assert all(array.given_back == 0 for array in self.arrays)

    refactor_device = solve_device


def find(array):
    return mfs._arrays.device_arrays(array).arrays[0]


class OfCupyx:
    """A matrix of cupyx.scipy.sparse."""

    def __init__(self, matrix):
        self.matrix, self.format, self.shape, self.data = matrix, matrix.format, matrix.shape, OnDevice(matrix.data.shape)

    def get(self):
        return self.matrix

    tocsr = None


class Layout(str):
    """A layout of torch, and sparse tensors that have it."""

    @classmethod
    def tensor(cls, layout, *parts, shape):
        tensor = mock.Mock(spec=["layout", "shape", "values", "crow_indices", "col_indices", "ccol_indices", "row_indices"])
        tensor.layout, tensor.shape = cls(layout), shape
        names = ("ccol_indices", "row_indices") if layout.endswith("csc") else ("crow_indices", "col_indices")
        for name, part in zip((*names, "values"), parts):
            host = getattr(tensor, name).return_value.detach.return_value.cpu.return_value.resolve_conj.return_value
            host.numpy.return_value = part
        return tensor


class DeviceArrays(unittest.TestCase):
    """What is found out about them without a device; test_device.py goes on with one."""

    def setUp(self):
        self.lu = mfs.splu(unsymmetric(10))

    def on_device(self, *arrays):
        self.lu._solver = SolverOnDevice(*arrays)
        return self.lu._solver.calls

    def test_arrays_are_described(self):
        found = find(OnDevice((3, 2), (8, 32)))
        self.assertEqual((found.shape, found.strides, found.address, found.writable), ((3, 2), (1, 4), 4096, True))
        self.assertEqual(find(OnDevice((3, 2))).strides, (2, 1))
        self.assertFalse(find(OnDevice((3, 2), read_only=True)).writable)
        for host in (np.ones(3), [1.0], None, ByDLPack((3,), kind=1), ByDLPack((3,), kind=3)):
            self.assertFalse(mfs._arrays.is_on_device(host))
        columns = mfs._arrays.columns_on_device
        self.assertEqual(columns(find(OnDevice((3, 2), (8, 32))), "b", np.dtype(float), 3), (2, 4))
        for wrong in (OnDevice((3, 2)), OnDevice((4, 2), (8, 32)), OnDevice((3,), typestr="<f4"), OnDevice((3,), (16,)),
                      OnDevice((3,), typestr=">f8"), OnDevice((3,), typestr="<i8")):  # fmt: skip
            with self.assertRaises(mfs.InvalidInput):
                columns(find(wrong), "b", np.dtype(float), 3)
        for wrong, part in ((OnDevice((3,), (4,)), "multiples"), (OnDevice((3,), mask=OnDevice((3,))), "mask")):
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                find(wrong)

    def test_arrays_of_dlpack_are_described(self):
        for versioned in (True, False):
            array = ByDLPack((3, 2), (1, 4), code=5, bits=64, device=1, versioned=versioned)
            found = find(array)
            self.assertEqual((found.address, found.dtype, found.shape), (4096, np.complex64, (3, 2)))
            self.assertEqual((found.strides, found.device, found.writable), ((1, 4), 1, True))
            self.assertEqual((array.given_back, array.streams), (0, [1]))
            del found
            self.assertEqual(array.given_back, 1)
        self.assertFalse(find(ByDLPack((3,), read_only=True)).writable)
        self.assertEqual(find(ByDLPack((3, 2))).strides, (2, 1))
        self.assertEqual(find(ByDLPack((3,), kind=13)).shape, (3,))
        a = np.asfortranarray(np.ones((3, 2), np.complex64))
        self.assertEqual(mfs._mfs.describe(a)[:6], (a.ctypes.data, 5, 64, [3, 2], [1, 3], True))
        a.flags.writeable = False
        self.assertFalse(mfs._mfs.describe(a)[5])

    def test_arrays_of_jax_are_not_written_to(self):
        array = ByDLPack((10,), versioned=False)
        with mock.patch.object(ByDLPack, "__module__", "jaxlib.xla_extension"):
            self.assertFalse(find(array).writable)

    def test_solutions_go_where_arrays_lie(self):
        b, x = ByDLPack((10, 2), (1, 12)), ByDLPack((10, 2), (1, 10), address=8192)
        calls = self.on_device(b, x)
        self.assertIs(self.lu.solve(b, out=x), x)
        self.assertEqual(calls.pop(), (4096, 8192, 2, 12, 10, 0, False))
        self.assertEqual((b.given_back, x.given_back), (1, 1))
        calls = self.on_device()
        self.lu.solve(OnDevice((10,)), "T", out=OnDevice((10,), address=8192))
        self.assertEqual(calls.pop(), (4096, 8192, 1, 10, 10, 0, True))
        values = ByDLPack((self.lu._entries,))
        self.on_device(values)
        self.lu.refactor(values)
        self.assertEqual(self.lu._solver.calls, [(4096, 0)])

    def test_streams(self):
        calls = self.on_device()
        for of_b, of_x, stream in ((1, 1, 0), (2, 2, 2), (77, 77, 77), (77, None, 77), (None, 77, 77), (None, None, 0)):
            self.lu.solve(OnDevice((10,), stream=of_b), out=OnDevice((10,), stream=of_x))
            self.assertEqual(calls.pop()[5], stream)
        # An array of DLPack is made ready for the stream of the other.
        x = ByDLPack((10,))
        self.lu.solve(OnDevice((10,), stream=77), out=x)
        self.assertEqual((calls.pop()[5], x.streams), (77, [77]))
        for of_b, of_x, part in ((1, 2, "different streams"), (77, 78, "0x4d, 0x4e"), (0, None, "ambiguous")):
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                self.lu.solve(OnDevice((10,), stream=of_b), out=OnDevice((10,), stream=of_x))
        # An interface that knows no streams, of an array that DLPack would make ready: as of torch.
        both = ByDLPack((10,), address=12288)
        both.__cuda_array_interface__ = {"shape": (10,), "typestr": "<f8", "data": (4096, False), "version": 2}
        self.lu.solve(both, out=both)
        self.assertEqual((calls.pop()[:2], both.streams), ((12288, 12288), [1, 1]))
        self.assertEqual(calls, [])

    def test_wrong_arrays_are_refused(self):
        calls, good = self.on_device(), ByDLPack((10,))
        for b, x, part in (
            (ByDLPack((10,), kind=10), good, "type 10, not on the host or on a CUDA device"),
            (good, ByDLPack((10,), kind=8), "type 8"),
            (good, ByDLPack((10,), device=1), "different devices: 0, 1"),
            (good, np.ones(10), "some arrays lie on the host"),
            (np.ones(10), good, "some arrays lie on the host"),
            (ByDLPack((9,)), ByDLPack((9,)), "shape"),
            (good, ByDLPack((9,)), "shape"),
            (ByDLPack((10,), bits=32), good, "float32"),
            (ByDLPack((10,), code=0), good, "b is of type int64"),
            (ByDLPack((10,), code=6, bits=8), good, "b is of type bool"),
            (ByDLPack((10,), code=4, bits=16), good, "b is of type |V2"),
            (good, ByDLPack((10,), code=5, bits=128), "complex128"),
            (ByDLPack((10,), (2,)), good, "b has gaps"),
            (ByDLPack((10, 2)), ByDLPack((10, 2), (1, 10)), "b is not column-major"),
            (ByDLPack((10, 2), (1, 10)), ByDLPack((10, 2)), "out is not column-major"),
            (good, ByDLPack((10,), read_only=True), "not writable"),
            (good, OnDevice((10,), read_only=True), "not writable"),
        ):
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                self.lu.solve(b, out=x)
        with self.assertRaisesRegex(TypeError, "out=x"):
            self.lu.solve(good)
        for data, part in (
            (ByDLPack((self.lu._entries - 1,)), "gaps"), (ByDLPack((self.lu._entries,), (2,)), "gaps"),
            (ByDLPack((self.lu._entries,), bits=32), "type"), (ByDLPack((self.lu._entries,), kind=10), "type 10"),
        ):  # fmt: skip
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                self.lu.refactor(data)
        self.assertEqual(calls, [])

    def test_matrices_on_a_device_are_copied_to_the_host(self):
        a, b = unsymmetric(20), vectors(20)
        for matrix in (a, a.tocsc()):
            of_torch = Layout.tensor(f"torch.sparse_{matrix.format}", matrix.indptr, matrix.indices, matrix.data, shape=a.shape)
            for other in (OfCupyx(matrix), of_torch):
                lu = mfs.splu(other)
                lu.refactor(other)
                np.testing.assert_allclose(a @ lu.solve(b), b, atol=1e-12)
        with self.assertRaisesRegex(TypeError, "not torch.sparse_coo"):
            mfs.splu(Layout.tensor("torch.sparse_coo", shape=(2, 2)))
        for sparse_b in (a, OfCupyx(a)):
            with self.assertRaisesRegex(mfs.InvalidInput, "a sparse matrix stands where"):
                self.lu.solve(sparse_b)

    def test_factors_of_the_host_refuse_them(self):
        for wanted in (OnDevice, ByDLPack):
            with self.assertRaises(mfs.StateError):
                self.lu.solve(wanted((10,)), out=wanted((10,)))
            with self.assertRaises(mfs.StateError):
                self.lu.refactor(wanted((self.lu._entries,)))


class Libraries(unittest.TestCase):
    """The loader of the package, as of a wheel with CUDA, with a module that wants what is not there."""

    ENDING = "cannot open shared object file: No such file or directory"

    def load(self, needed, there, loaded=(), library_path=(), broken=()):
        """What is taken by an import of a module that needs the libraries `needed`. NVIDIA's wheels have those that are
        `there`, of which the `broken` cannot be loaded, the process those `loaded`, LD_LIBRARY_PATH those of `library_path`."""
        taken = []

        def import_module(name):
            for library in needed:
                if library not in [os.path.basename(path) for path in [*taken, *loaded, *library_path]]:
                    raise ImportError(f"{library}: {self.ENDING}")
            return name

        def take(path, mode=0):
            if (mode & os.RTLD_NOLOAD and path not in loaded) or os.path.basename(path) in broken:
                raise OSError(path)
            if not mode & os.RTLD_NOLOAD:
                taken.append(path)

        with tempfile.TemporaryDirectory() as folder:
            for name in (*there, *library_path):
                path = pathlib.Path(folder) / "nvidia" / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
            with mock.patch.object(sys, "path", ["/none", folder]), mock.patch.object(ctypes, "CDLL", take), mock.patch.object(
                mfs._library, "needed", lambda: needed
            ), mock.patch.object(importlib, "import_module", import_module), mock.patch.dict(
                os.environ, LD_LIBRARY_PATH=f":/none:{folder}/nvidia"
            ):
                self.assertEqual(mfs._library.load("mfs._mfs"), "mfs._mfs")
            return [os.path.relpath(path, folder) for path in taken]

    def test_those_of_the_wheels_are_taken(self):
        self.assertEqual(self.load([], ["cu13/lib/libcublas.so.13"]), [])
        there = ["cu13/lib/libcublas.so.13", "cu13/lib/libcudart.so.13", "cusolver/lib/libcusolver.so.12", "cu13/lib/libcufft.so.12"]
        needed = ["libcudart.so.13", "libcublas.so.13", "libcusolver.so.12"]
        self.assertEqual(self.load(needed, there), [f"nvidia/{name}" for name in (there[1], there[0], there[2])])
        # A library is there once: those that torch has loaded, or that the user has chosen, are not taken again.
        self.assertEqual(self.load(needed, there, loaded=needed[:2]), [f"nvidia/{there[2]}"])
        self.assertEqual(self.load(needed, there, library_path=needed[1:]), [f"nvidia/{there[1]}"])

    def test_what_is_not_there_is_named(self):
        with self.assertRaisesRegex(ImportError, "one with CUDA, and libcublas.so.13 is not there: pip install"):
            self.load(["libcublas.so.13"], ["cu13/lib/libcublas.so.12"])
        with self.assertRaisesRegex(ImportError, "^libother.so.1: cannot"):
            self.load(["libother.so.1"], [])
        # One of the wheels that cannot be loaded is left to the system.
        with self.assertRaisesRegex(ImportError, "and libcudart.so.13 is not there"):
            self.load(["libcudart.so.13"], ["cu13/lib/libcudart.so.13"], broken=["libcudart.so.13"])

    def test_kernels_of_an_old_processor_are_warned_of(self):
        with self.assertWarnsRegex(RuntimeWarning, "OPENBLAS_CORETYPE=SkylakeX before"):
            mfs._library.warn_of_slow_blas("SkylakeX")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mfs._library.warn_of_slow_blas("")
        self.assertIsInstance(mfs._mfs.better_blas_kernels(), str)

    def test_the_build_has_told_what_is_needed(self):
        for name in mfs._library.needed():
            self.assertRegex(name, r"^lib(cu|nv)\w+\.so\.\d+$")


if __name__ == "__main__":
    unittest.main()
