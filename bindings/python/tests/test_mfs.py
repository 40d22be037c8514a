"""The package mfs beside scipy: right and wrong inputs of each call."""

import ctypes
import doctest
import importlib
import os
import pathlib
import signal
import sys
import tempfile
import threading
import unittest
from unittest import mock

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

import mfs
import mfs._arrays
import mfs._library
import mfs._lu

TYPES = [np.float32, np.float64, np.complex64, np.complex128]


def unsymmetric(n, dtype=np.float64, seed=1):
    """Diagonally dominant in a cyclic order, so that its diagonal is weak."""
    random = np.random.default_rng(seed)
    a = sparse.random(n, n, 4 / n, random_state=random, format="coo")
    values = a.data + (1j * random.random(a.nnz) if np.dtype(dtype).kind == "c" else 0)
    a = sparse.coo_matrix((values, (a.row, a.col)), shape=(n, n)).tocsr()
    shift = sparse.csr_matrix((np.full(n, 9.0), (np.arange(n), (np.arange(n) + 1) % n)), shape=(n, n))
    return (a + shift).astype(dtype).tocsr()


def vectors(shape, dtype=np.float64):
    random = np.random.default_rng(5)
    b = random.standard_normal(shape)
    return (b + 1j * random.standard_normal(shape) if np.dtype(dtype).kind == "c" else b).astype(dtype)


def tolerance(dtype):
    return 1e4 * np.finfo(dtype).eps


class BesideScipy(unittest.TestCase):
    def check(self, a, b, trans="N"):
        x = mfs.splu(a, threads=2).solve(b, trans)
        expected = scipy.sparse.linalg.splu(sparse.csc_matrix(a)).solve(b, trans)
        self.assertEqual(x.dtype, expected.dtype)
        self.assertEqual(x.shape, b.shape)
        self.assertLess(np.linalg.norm(x - expected), tolerance(a.dtype) * np.linalg.norm(expected))

    def test_types_formats_and_transposes(self):
        for dtype in TYPES:
            a = unsymmetric(80, dtype)
            for trans in "NTH":
                for matrix in (a, a.tocsc(), sparse.csr_array(a), sparse.csc_array(a)):
                    self.check(matrix, vectors(80, dtype), trans)
                    self.check(matrix, vectors((80, 5), dtype), trans)

    def test_index_types_unsorted_and_repeated_entries(self):
        a = unsymmetric(40)
        expected = scipy.sparse.linalg.spsolve(a.tocsc(), vectors(40))
        for kind in (np.int32, np.int64, np.int16):
            other = a.copy()
            other.indptr, other.indices = other.indptr.astype(kind), other.indices.astype(kind)
            np.testing.assert_allclose(mfs.spsolve(other, vectors(40)), expected, rtol=1e-9)
        coo = a.tocoo()
        twice = sparse.coo_array((np.tile(coo.data / 2, 2), (np.tile(coo.row, 2), np.tile(coo.col, 2))), shape=a.shape)
        np.testing.assert_allclose(mfs.spsolve(twice, vectors(40)), expected, rtol=1e-9)
        order = np.argsort(-a.indices[: a.indptr[1]])
        a.indices[: a.indptr[1]], a.data[: a.indptr[1]] = a.indices[order], a.data[order]
        np.testing.assert_allclose(mfs.spsolve(a, vectors(40)), expected, rtol=1e-9)

    def test_right_hand_sides_of_other_orders_and_types(self):
        a = unsymmetric(30)
        lu, b = mfs.splu(a), vectors((60, 4))
        for other in (b[::2], np.asfortranarray(b[:30]), b[:30].astype(np.float32), (9 * b[:30]).astype(int)):
            np.testing.assert_allclose(a @ lu.solve(other), other, atol=1e-9)
        both = b[:30] + 1j * b[30:]
        np.testing.assert_allclose(a @ lu.solve(both), both, atol=1e-9)
        self.assertEqual(lu.solve(np.empty((30, 0))).shape, (30, 0))
        x = np.array(b[:30])
        self.assertIs(lu.solve(x, out=x), x)
        np.testing.assert_allclose(a @ x, b[:30], atol=1e-9)

    def test_integers_become_floats(self):
        a = sparse.csr_array([[2, 1], [0, 4]])
        np.testing.assert_allclose(mfs.spsolve(a, np.array([4, 4])), [1.5, 1])

    def test_refactor(self):
        for layout in ("csr", "csc"):
            a, other = unsymmetric(50).asformat(layout), unsymmetric(50).asformat(layout)
            other.data = other.data * np.linspace(1, 2, other.nnz)
            lu, b = mfs.splu(a), vectors(50)
            for new in (other, other.data, list(other.data)):
                lu.refactor(a.data)
                lu.refactor(new)
                np.testing.assert_allclose(other @ lu.solve(b), b, atol=1e-10)
            self.assertGreater(lu.report["time_refactor"], 0)

    def test_figures(self):
        a = unsymmetric(60)
        lu = mfs.splu(a, threads=1, scaling=False, tolerance=1e-11)
        lu.solve(vectors(60))
        sign, logarithm = lu.logdet()
        expected = np.linalg.slogdet(a.toarray())
        self.assertEqual(sign, expected[0])
        self.assertAlmostEqual(logarithm, expected[1], 8)
        exact = np.linalg.cond(a.toarray(), 1)
        self.assertTrue(exact / 10 < lu.condition_estimate() < exact * 1.001)
        report = lu.report
        self.assertEqual((report["n"], report["threads"], report["backend"]), (60, 1, "openmp"))
        self.assertIsInstance(report["nnz"], int)
        self.assertIs(report["single_precision"], False)
        self.assertLess(report["backward_error"], 1e-11)
        self.assertEqual(lu.nnz, report["nnz_factor"])
        self.assertEqual((lu.shape, lu.dtype), ((60, 60), np.float64))

    def test_depths(self):
        a = unsymmetric(600)
        lu = mfs.splu(a)
        depths, report = lu.depths, lu.report
        self.assertEqual(list(depths["depth"]), list(range(report["depths"])))
        for name, whole in (("pivots", 600), ("fronts", report["fronts"]), ("factor_entries", lu.nnz)):
            self.assertEqual(depths[name].sum(), whole)
        self.assertEqual(depths["max_front"].max(), report["max_front"])
        self.assertAlmostEqual(depths["flops"].sum() / report["flops"], 1, 9)

    def test_progress(self):
        seen = []
        lu = mfs.splu(unsymmetric(300), progress=lambda *now: seen.append(now))
        lu.solve(vectors(300))
        self.assertEqual(seen[-1][0], "solve")
        self.assertIn("factor", [phase for phase, _ in seen])
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in seen))

        class Enough(Exception):
            pass

        def end(phase, fraction):
            if phase == "solve":
                raise Enough("so far")

        lu = mfs.splu(unsymmetric(300), progress=end)
        self.assertRaisesRegex(Enough, "so far", lu.solve, vectors(300))
        self.assertRaisesRegex(mfs.InvalidInput, "progress", mfs.splu, unsymmetric(10), progress=7)

    def test_linear_operator(self):
        a = unsymmetric(70)
        near = a + 0.1 * unsymmetric(70, seed=2)
        inverse = mfs.splu(a).linear_operator()
        b = vectors(70)
        x, info = scipy.sparse.linalg.gmres(near, b, M=inverse, rtol=1e-10, atol=0)
        self.assertEqual(info, 0)
        np.testing.assert_allclose(near @ x, b, atol=1e-8)
        np.testing.assert_allclose(a.T @ (inverse.T @ b), b, atol=1e-9)
        symmetric = sparse.diags_array([np.linspace(1, 8, 70), -np.ones(69), -np.ones(69)], offsets=[0, 1, -1]).tocsc()
        found = scipy.sparse.linalg.eigsh(
            symmetric, 3, sigma=2.0, OPinv=mfs.splu(symmetric - 2 * sparse.eye_array(70)).linear_operator()
        )[0]
        every = np.linalg.eigvalsh(symmetric.toarray())
        nearest = np.sort(every[np.argsort(abs(every - 2))[:3]])
        np.testing.assert_allclose(np.sort(found), nearest, rtol=1e-9)

    def test_factorized(self):
        a = unsymmetric(20)
        np.testing.assert_allclose(a @ mfs.factorized(a)(vectors(20)), vectors(20), atol=1e-10)


class StepByStep(unittest.TestCase):
    def test_plan_factorize_solve_reset(self):
        a, b = unsymmetric(30), vectors(30)
        with mfs.Solver(a, b, threads=1) as solver:
            self.assertRaises(mfs.StateError, solver.factorize)
            solver.plan()
            self.assertRaises(mfs.StateError, solver.solve)
            solver.factorize()
            np.testing.assert_allclose(a @ solver.solve(), b, atol=1e-10)
            solver.reset_operands(b=2 * b)
            np.testing.assert_allclose(a @ solver.solve(), 2 * b, atol=1e-10)
            solver.reset_operands(a=3 * a.data)
            self.assertRaises(mfs.StateError, solver.solve)
            solver.factorize()
            np.testing.assert_allclose(3 * a @ solver.solve(), 2 * b, atol=1e-10)
            solver.reset_operands(a=sparse.eye_array(30).tocsr())
            self.assertRaises(mfs.PatternChanged, solver.factorize)
            solver.plan()
            solver.factorize()
            np.testing.assert_allclose(solver.solve(), 2 * b, atol=1e-10)
        self.assertIsNone(solver.lu)
        self.assertRaises(mfs.StateError, solver.solve)


class Refused(unittest.TestCase):
    def raises(self, kind, part, call, *arguments, **options):
        with self.assertRaisesRegex(kind, part) as caught:
            call(*arguments, **options)
        return caught.exception

    def test_options(self):
        a = unsymmetric(10)
        error = self.raises(mfs.InvalidInput, "treads", mfs.splu, a, treads=1)
        self.assertEqual(error.argument, "treads")
        self.raises(ValueError, "not be negative", mfs.splu, a, threads=-1)
        self.raises(mfs.InvalidInput, "not yes", mfs.splu, a, scaling="maybe")
        self.raises(mfs.InvalidInput, "not an integer", mfs.splu, a, threads=1.5)

    def test_matrices(self):
        self.raises(TypeError, "scipy.sparse", mfs.splu, np.eye(3))
        self.raises(mfs.InvalidInput, "not square", mfs.splu, sparse.csr_array((3, 4)))
        self.raises(mfs.InvalidInput, "", mfs.splu, sparse.csr_array((0, 0)))
        self.raises(TypeError, "no numbers of type", mfs.splu, sparse.csr_array(np.eye(3, dtype=np.longdouble)))
        a = unsymmetric(10)
        a.data[a.indptr[4]] = np.nan
        error = self.raises(mfs.InvalidInput, "row 4", mfs.splu, a)
        self.assertEqual((error.row, error.column), (4, a.indices[a.indptr[4]]))
        a = unsymmetric(10)
        a.indices[a.indptr[6]] = 10
        self.assertEqual(self.raises(mfs.InvalidInput, "", mfs.splu, a).row, 6)
        a = unsymmetric(10)
        a.indices = a.indices[:-1]
        self.raises(mfs.InvalidInput, "fewer", mfs.splu, a)

    def test_places_are_those_of_the_matrix_in_both_formats(self):
        a = unsymmetric(10).tolil()
        a[3, :] = 0
        a[3, 2] = np.inf
        for layout in ("csr", "csc"):
            error = self.raises(mfs.InvalidInput, "", mfs.splu, a.asformat(layout))
            self.assertEqual((error.row, error.column), (3, 2))
        a[3, 2] = 0
        a = sparse.csr_array(a.toarray())
        self.assertEqual(self.raises(mfs.SingularMatrix, "", mfs.splu, a).row, 3)
        self.assertEqual(self.raises(mfs.SingularMatrix, "transposed", mfs.splu, a.tocsc()).row, 3)

    def test_singular_matrices_have_no_solution(self):
        a = sparse.csr_array(np.ones((3, 3)) + np.diag([1.0, 0, 0]))
        error = self.raises(mfs.SingularMatrix, "", mfs.spsolve, a, np.ones(3))
        self.assertEqual((error.kind, error.dependent_rows), ("numerical", 1))
        self.assertIsInstance(error, RuntimeError)

    def test_right_hand_sides(self):
        lu = mfs.splu(unsymmetric(10))
        for b in (np.ones(9), np.ones((9, 10)), np.ones((10, 1, 1)), 1.0):
            self.raises(mfs.InvalidInput, "shape", lu.solve, b)
        self.raises(mfs.InvalidInput, "trans", lu.solve, np.ones(10), "X")
        self.assertEqual(self.raises(mfs.InvalidInput, "", lu.solve, np.full(10, np.nan)).argument, "b")
        np.testing.assert_allclose(lu.solve(np.zeros(10)), 0)

    def test_new_values(self):
        a = unsymmetric(10)
        lu = mfs.splu(a)
        self.raises(mfs.InvalidInput, "not as many", lu.refactor, a.data[1:])
        self.raises(mfs.InvalidInput, "complex", lu.refactor, 1j * a.data)
        self.raises(mfs.InvalidInput, "csc", lu.refactor, a.tocsc())
        self.raises(mfs.InvalidInput, "type", lu.refactor, a.astype(np.float32))
        other = a.tolil()
        other[5, :] = 1
        self.assertEqual(self.raises(mfs.PatternChanged, "", lu.refactor, other.tocsr()).row, 5)
        np.testing.assert_allclose(a @ lu.solve(np.ones(10)), 1, atol=1e-12)


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
            (ByDLPack((10,), code=0), good, "type"),
            (good, ByDLPack((10,), code=5, bits=128), "complex128"),
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

    def test_factors_of_the_host_refuse_them(self):
        for wanted in (OnDevice, ByDLPack):
            with self.assertRaises(mfs.StateError):
                self.lu.solve(wanted((10,)), out=wanted((10,)))
            with self.assertRaises(mfs.StateError):
                self.lu.refactor(wanted((self.lu._entries,)))


class LibrariesOfCuda(unittest.TestCase):
    """The loader of a wheel with CUDA, with a module that wants what is not there."""

    ENDING = "cannot open shared object file: No such file or directory"

    def load(self, missing, there):
        """Imports a module that needs the libraries `missing`; NVIDIA's wheels have those that are `there`."""
        missing, loaded = list(missing), []

        def import_module(name):
            if missing:
                raise ImportError(f"{missing[0]}: {self.ENDING}")
            return name

        def take(path):
            loaded.append(path)
            if os.path.basename(path) in missing:
                missing.remove(os.path.basename(path))

        with tempfile.TemporaryDirectory() as folder:
            for name in there:
                path = pathlib.Path(folder) / "nvidia" / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
            with mock.patch.object(sys, "path", ["/none", folder]), mock.patch.object(ctypes, "CDLL", take):
                with mock.patch.object(importlib, "import_module", import_module):
                    self.assertEqual(mfs._library.load("mfs._mfs"), "mfs._mfs")
            return [os.path.relpath(path, folder) for path in loaded]

    def test_those_of_the_wheels_are_taken(self):
        self.assertEqual(self.load([], []), [])
        there = ["cu13/lib/libcublas.so.13", "cu13/lib/libcudart.so.13", "cusolver/lib/libcusolver.so.12", "cu13/lib/libcufft.so.12"]
        found = self.load(["libcudart.so.13", "libcublas.so.13", "libcusolver.so.12"], there)
        self.assertEqual(found, [f"nvidia/{name}" for name in (there[1], there[0], there[2])])

    def test_what_is_not_there_is_named(self):
        with self.assertRaisesRegex(ImportError, "one with CUDA, and libcublas.so.13 is not there: pip install"):
            self.load(["libcublas.so.13"], ["cu13/lib/libcublas.so.12"])
        with self.assertRaisesRegex(ImportError, "^libother.so.1: cannot"):
            self.load(["libother.so.1"], ["cu13/lib/libother.so.1"])
        # One that loads and does not help is not tried for ever.
        with mock.patch.object(mfs._library, "in_wheels", lambda name: "/none/" + name + ".other"):
            with self.assertRaisesRegex(ImportError, "libcudart"):
                self.load(["libcudart.so.13"], [])


class Threads(unittest.TestCase):
    def test_objects_of_several_threads_and_one_of_all(self):
        a, wrong = unsymmetric(300), []
        shared = mfs.splu(a, threads=1)

        def work(seed):
            b = vectors((300, 2)) * seed
            for lu in (shared, mfs.splu(a, threads=1)):
                if not np.allclose(a @ lu.solve(b), b, atol=1e-9):
                    wrong.append(seed)

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(1, 5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_a_signal_ends_a_phase(self):
        class Ended(Exception):
            pass

        def end(*_):
            raise Ended

        n = 30
        line = sparse.diags_array([2.1 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1])
        one = sparse.eye_array(n)
        cube = sparse.kron(sparse.kron(line, one), one) + sparse.kron(one, sparse.kron(line, one) + sparse.kron(one, line))
        before = signal.signal(signal.SIGALRM, end)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            try:
                mfs.splu(cube.tocsr(), threads=1)
                signal.setitimer(signal.ITIMER_REAL, 0)
            except Ended:
                pass
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)


def load_tests(loader, tests, pattern):
    tests.addTests(doctest.DocTestSuite(mfs._lu, optionflags=doctest.ELLIPSIS))
    tests.addTests(doctest.DocTestSuite(mfs))
    return tests


if __name__ == "__main__":
    unittest.main()
