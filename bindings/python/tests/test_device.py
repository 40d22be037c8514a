"""Arrays in the memory of a CUDA device, without CuPy or torch: a small array by ctypes. Skips without a device."""

import ctypes
import unittest

import numpy as np
import scipy.sparse as sparse

import mfs


def cuda():
    for name in ("libcudart.so", "libcudart.so.13", "libcudart.so.12"):
        try:
            return ctypes.CDLL(name)
        except OSError:
            pass
    return None


CUDA = cuda() if "cuda" in mfs.backends() else None


class Array:
    """A copy of an array of numpy on the device."""

    def __init__(self, array):
        self.array, pointer = array, ctypes.c_void_p()
        assert CUDA.cudaMalloc(ctypes.byref(pointer), ctypes.c_size_t(array.nbytes)) == 0
        self.pointer = pointer
        self.copy(pointer, array.ctypes.data_as(ctypes.c_void_p), 1)
        self.__cuda_array_interface__ = {
            "shape": array.shape,
            "strides": array.strides,
            "typestr": array.dtype.str,
            "data": (pointer.value, False),
            "version": 3,
        }

    def copy(self, to, from_, kind):
        assert CUDA.cudaMemcpy(to, from_, ctypes.c_size_t(self.array.nbytes), ctypes.c_int(kind)) == 0

    def get(self):
        result = np.empty_like(self.array)
        self.copy(result.ctypes.data_as(ctypes.c_void_p), self.pointer, 2)
        return result

    def __del__(self):
        CUDA.cudaFree(self.pointer)


@unittest.skipUnless(CUDA, "no CUDA device")
class OnDevice(unittest.TestCase):
    def matrix(self, dtype):
        n = 400
        shift = sparse.diags_array([4 * np.ones(n), -np.ones(n - 1), 2 * np.ones(n - 20)], offsets=[0, 1, -20])
        a = sparse.csr_array(shift).astype(dtype)
        return a * (1 + 0.5j) if np.dtype(dtype).kind == "c" else a

    def test_solve_and_refactor_where_arrays_lie(self):
        for dtype in (np.float32, np.float64, np.complex64, np.complex128):
            a = self.matrix(dtype)
            b = np.asfortranarray(np.random.default_rng(1).standard_normal((400, 3)).astype(a.dtype))
            lu = mfs.splu(a, backend="cuda")
            for factor, trans in ((1, "N"), (3, "N"), (3, "T")):
                if factor != 1:
                    lu.refactor(Array(factor * a.data))
                x = Array(np.zeros_like(b, order="F"))
                self.assertIs(lu.solve(Array(b), trans, out=x), x)
                expected = factor * (a.T if trans == "T" else a) @ x.get()
                np.testing.assert_allclose(expected, b, atol=2e-4 if np.finfo(dtype).bits == 32 else 1e-10)
            one = Array(b[:, 0].copy())
            lu.solve(one, out=one)
            np.testing.assert_allclose(3 * a @ one.get(), b[:, 0], atol=2e-4 if np.finfo(dtype).bits == 32 else 1e-10)

    def test_wrong_arrays_are_refused(self):
        a = self.matrix(np.float64)
        lu = mfs.splu(a, backend="cuda")
        rows = Array(np.ones((400, 3)))
        self.assertRaisesRegex(mfs.InvalidInput, "column-major", lu.solve, rows, out=rows)
        with_nan = Array(np.full(400, np.nan))
        self.assertRaises(mfs.InvalidInput, lu.solve, with_nan, out=with_nan)
        self.assertRaises(mfs.InvalidInput, lu.refactor, Array(np.full(a.nnz, np.inf)))


if __name__ == "__main__":
    unittest.main()
