"""Arrays of CuPy, torch and JAX on a CUDA device: taken where they lie, or refused. Skips those that are not installed."""

import importlib
import os
import unittest

import numpy as np
import scipy.sparse as sparse

import mfs

os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
TYPES = [np.float32, np.float64, np.complex64, np.complex128]


def package(name):
    """The package, if it is installed and there is a device."""
    try:
        return importlib.import_module(name) if "cuda" in mfs.backends() else None
    except ImportError:
        return None


torch, cupy, jax = package("torch"), package("cupy"), package("jax")
if jax:
    jax.config.update("jax_enable_x64", True)


def matrix(dtype=np.float64, n=600):
    """Unsymmetric, with entries of both signs far from the diagonal."""
    a = sparse.diags([4 * np.ones(n), -np.ones(n - 1), 2 * np.ones(n - 20), -np.ones(n - 90)], [0, 1, -20, 90])
    return sparse.csr_matrix(a * (1 + 0.5j) if np.dtype(dtype).kind == "c" else a).astype(dtype)


def vectors(shape, dtype=np.float64):
    random = np.random.default_rng(5)
    b = random.standard_normal(shape)
    return (b + 1j * random.standard_normal(shape) if np.dtype(dtype).kind == "c" else b).astype(dtype)


class Addresses:
    """Stands before the solver of an LU, and notes the addresses that it is called with."""

    def __init__(self, lu):
        self.solver, self.noted = lu._solver, []
        lu._solver = self

    def solve_device(self, b, x, *others):
        self.noted += [b, x]
        self.solver.solve_device(b, x, *others)

    def refactor_device(self, values, stream):
        self.noted.append(values)
        self.solver.refactor_device(values, stream)

    def __getattr__(self, name):
        return getattr(self.solver, name)


class Package:
    """What the tests ask of CuPy and of torch; below, what each calls it."""

    def check(self, a, b, x, factor=1, trans="N"):
        expected = factor * (a.T if trans == "T" else a) @ self.to_host(x)
        np.testing.assert_allclose(expected, b, atol=2e-4 if np.finfo(a.dtype).bits == 32 else 1e-11)

    def test_arrays_are_taken_where_they_lie(self):
        for dtype in TYPES:
            a, b = matrix(dtype), np.asfortranarray(vectors((600, 3), dtype))
            lu = mfs.splu(a, backend="cuda")
            addresses = Addresses(lu)
            on_device, values = self.columns(b), self.array(3 * a.data)
            x = lu.solve(on_device)
            self.assertEqual(type(x), type(on_device))
            self.check(a, b, x)
            lu.refactor(values)
            out = self.columns(np.zeros_like(b))
            for trans in "NT":
                self.assertIs(lu.solve(on_device, trans, out=out), out)
                self.check(a, b, out, 3, trans)
            self.assertEqual(addresses.noted, [*map(self.address, (on_device, x, values, on_device, out, on_device, out))])
            np.testing.assert_array_equal(self.to_host(on_device), b)
            one = self.array(b[:, 0].copy())
            self.assertIs(lu.solve(one, out=one), one)
            self.check(a, b[:, 0], one, 3)

    def test_nothing_is_allocated_for_a_solve(self):
        a, b = matrix(), vectors(600)
        lu = mfs.splu(a, backend="cuda")
        x, values = self.array(b), self.array(a.data)
        lu.solve(x, out=x)
        before = self.allocated()
        lu.refactor(values)
        lu.solve(x, out=x)
        self.assertEqual(self.allocated(), before)

    def test_a_matrix_on_the_device(self):
        for a in (matrix(), matrix(np.complex64).tocsc()):
            b = vectors(600, a.dtype)
            on_device = self.sparse(a)
            lu = mfs.splu(on_device, backend="cuda")
            self.check(a, b, lu.solve(self.array(b)))
            lu.refactor(self.sparse(2 * a))
            self.check(a, b, lu.solve(self.array(b)), 2)
            lu.refactor(self.values(on_device))
            self.check(a, b, lu.solve(self.array(b)))

    def test_work_that_is_under_way_is_waited_for(self):
        a, b = matrix(), vectors(600)
        lu = mfs.splu(a, backend="cuda")
        for _ in range(5):
            late = self.array(np.full(600, np.nan))
            with self.other_stream():
                self.work_for_a_while()
                late[:] = self.array(b)
                x = lu.solve(late)
                self.check(a, b, x)

    def test_wrong_arrays_are_refused(self):
        a, b = matrix(), vectors(600)
        lu = mfs.splu(a, backend="cuda")
        good, many = self.array(b), self.array(np.ones((600, 2)))
        for wrong, part in (
            (self.array(b.astype(np.float32)), "b is of type float32, the matrix of float64"),
            (self.array(b.astype(complex)), "b is of type complex128"),
            (self.array(np.arange(600)), "b is of type int64"),
            (self.array(np.ones(599)), r"b has the shape \(599,\), and the matrix 600 rows"),
            (self.array(np.ones(1200))[::2], "b has gaps"),
            (many, "b is not column-major"),
        ):
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                lu.solve(wrong)
        for b_, x in ((good, np.ones(600)), (b, good)):
            with self.assertRaisesRegex(mfs.InvalidInput, "some arrays lie on the host, and some on a device"):
                lu.solve(b_, out=x)
        with self.assertRaisesRegex(mfs.InvalidInput, "out has the shape"):
            lu.solve(good, out=self.array(np.ones(1200)))
        for data, part in ((a.data[1:], "without gaps"), (a.data.astype(np.float32), "data is of type float32")):
            with self.assertRaisesRegex(mfs.InvalidInput, part):
                lu.refactor(self.array(data))
        with self.assertRaises(mfs.InvalidInput):
            lu.solve(self.array(np.full(600, np.nan)))
        lu.refactor(self.array(0 * a.data))
        with self.assertRaises(mfs.SingularMatrix):
            lu.solve(good)
        with self.assertRaises(mfs.StateError):
            mfs.splu(a).solve(good)
        lu.refactor(self.array(a.data))
        self.check(a, b, lu.solve(good))


@unittest.skipUnless(cupy, "no CuPy, or no CUDA device")
class CuPy(Package, unittest.TestCase):
    def array(self, host):
        return cupy.asarray(host)

    def columns(self, host):
        return cupy.asarray(host, order="F")

    def to_host(self, array):
        return cupy.asnumpy(array)

    def address(self, array):
        return array.data.ptr

    def allocated(self):
        return cupy.get_default_memory_pool().total_bytes(), cupy.get_default_memory_pool().used_bytes()

    def sparse(self, a):
        from cupyx.scipy import sparse as on_device

        return getattr(on_device, f"{a.format}_matrix")(a)

    def values(self, a):
        return a.data

    def other_stream(self):
        return cupy.cuda.Stream(non_blocking=True)

    def work_for_a_while(self):
        square = cupy.ones((4000, 4000))
        for _ in range(10):
            square = square @ square / 4000


@unittest.skipUnless(torch, "no torch, or no CUDA device")
class Torch(Package, unittest.TestCase):
    def array(self, host):
        return torch.as_tensor(host, device="cuda")

    def columns(self, host):
        return torch.as_tensor(host.T.copy(), device="cuda").T

    def to_host(self, array):
        return array.cpu().numpy()

    def address(self, array):
        return array.data_ptr()

    def allocated(self):
        return torch.cuda.memory_allocated()

    def sparse(self, a):
        make = torch.sparse_csr_tensor if a.format == "csr" else torch.sparse_csc_tensor
        return make(*map(self.array, (a.indptr, a.indices, a.data)), size=a.shape)

    def values(self, a):
        return a.values()

    def other_stream(self):
        return torch.cuda.stream(torch.cuda.Stream())

    def work_for_a_while(self):
        square = torch.ones((4000, 4000), device="cuda", dtype=torch.float64)
        for _ in range(10):
            square = square @ square / 4000

    def test_tensors_of_a_gradient_are_refused(self):
        lu = mfs.splu(matrix(), backend="cuda")
        wanted = self.array(vectors(600)).requires_grad_()
        with self.assertRaisesRegex((BufferError, RuntimeError), "requires? grad"):
            lu.solve(wanted)
        self.check(matrix(), vectors(600), lu.solve(wanted.detach()))


@unittest.skipUnless(jax, "no JAX, or no CUDA device")
class JAX(unittest.TestCase):
    def test_arrays_are_read_where_they_lie(self):
        a, b = matrix(), vectors(600)
        lu = mfs.splu(a, backend="cuda")
        addresses = Addresses(lu)
        on_device, values = jax.numpy.asarray(b), jax.numpy.asarray(3 * a.data)
        lu.refactor(values)
        with self.assertRaisesRegex(TypeError, r"solve\(b, out=x\) needs an array"):
            lu.solve(on_device)
        with self.assertRaisesRegex(mfs.InvalidInput, "out is not writable"):
            lu.solve(on_device, out=on_device)
        with self.assertRaisesRegex(mfs.InvalidInput, "type float32"):
            lu.solve(on_device.astype(np.float32), out=on_device)
        self.assertEqual(addresses.noted, [values.unsafe_buffer_pointer()])
        if not cupy:
            return
        x = lu.solve(on_device, out=cupy.empty(600))
        self.assertEqual(addresses.noted[1:], [on_device.unsafe_buffer_pointer(), x.data.ptr])
        of_jax = jax.dlpack.from_dlpack(x)  # not copied, either
        self.assertEqual(of_jax.unsafe_buffer_pointer(), x.data.ptr)
        np.testing.assert_allclose(3 * a @ np.asarray(of_jax), b, atol=1e-11)

    def test_arrays_of_the_host_are_taken_as_those_of_numpy(self):
        a, b = matrix(), vectors(600)
        on_host = jax.device_put(b, jax.devices("cpu")[0])
        x = mfs.splu(a, backend="cuda").solve(on_host)
        self.assertIsInstance(x, np.ndarray)
        np.testing.assert_allclose(a @ x, b, atol=1e-11)


if __name__ == "__main__":
    unittest.main()
