"""The factorization that splu returns."""

import threading
from contextlib import contextmanager
from typing import Any, Optional

import numpy as np

from ._library import _mfs
from ._arrays import SOLVERS, Matrix, columns_on_device, compressed, device_arrays, empty_like, is_on_device, is_sparse, number_type
from .errors import Error, InvalidInput, StateError

_TEXT = {"backend", "rung"}
_REAL = {"backward_error", "flops", "flops_getrf", "flops_trsm", "flops_gemm", "flops_used"}
_FLAGS = {"matched", "single_precision"}


def option_text(value: Any) -> str:
    """The text of an option: True and False are yes and no."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


class LU:
    """The LU factorization of a square sparse matrix; made by :func:`splu`.

    It may be used by several threads, one after the other; the interpreter is free while it computes.

    >>> import numpy as np, scipy.sparse, mfs
    >>> A = scipy.sparse.csr_array([[4., -1, 0], [-1, 4, -1], [0, -1, 4]])
    >>> lu = mfs.splu(A)
    >>> lu.solve(np.array([3., 2, 3])).round(12)
    array([1., 1., 1.])
    >>> lu.shape
    (3, 3)
    """

    def __init__(self, a: Any, options: dict, factor: bool = True):
        matrix = compressed(a)
        self._lock = threading.Lock()
        self._transposed = matrix.transposed
        self._dtype = matrix.values.dtype
        self._n = matrix.n
        texts = {name: option_text(value) for name, value in options.items() if name != "progress"}
        progress = options.get("progress")
        if progress is not None and not callable(progress):
            raise InvalidInput(f"progress is {progress!r}, which cannot be called")
        self._solver = SOLVERS[self._dtype](texts, progress)
        self._take(self._solver.factor if factor else self._solver.analyze, matrix)

    @contextmanager
    def _computing(self):
        """One thread at a time; errors of the transposed matrix tell their place in the matrix."""
        with self._lock:
            try:
                yield
            except Error as error:
                if self._transposed and (hasattr(error, "row") or hasattr(error, "column")):
                    error.row, error.column = getattr(error, "column", None), getattr(error, "row", None)
                    error.args = (f"of the transposed matrix (csc): {error}",)
                raise

    def _take(self, phase: Any, matrix: Matrix) -> None:
        with self._computing():
            phase(matrix.offsets, matrix.columns, matrix.values)
        self._entries = int(matrix.offsets[-1])

    def factorize(self, a: Any) -> None:
        """Factors `a`, which has the analysed pattern, format and type of numbers."""
        matrix = compressed(a)
        if matrix.transposed != self._transposed:
            raise InvalidInput("the matrix is csc and the analysed one csr, or the other way round")
        if matrix.values.dtype != self._dtype:
            raise InvalidInput(f"the matrix is of type {matrix.values.dtype}, the analysed one of {self._dtype}")
        self._take(self._solver.factor, matrix)

    def refactor(self, a_or_data: Any) -> None:
        """Factors new values on the same pattern: no analysis, and no new memory.

        `a_or_data` is a sparse matrix in the format of the first one, whose pattern is compared (on the host), or its array
        `data` (`values()` of torch), of the host or of a CUDA device.

        >>> import scipy.sparse, mfs
        >>> A = scipy.sparse.eye_array(4, format="csr")
        >>> lu = mfs.splu(A)
        >>> lu.refactor(2 * A.data)
        >>> round(lu.logdet()[1], 9)
        2.772588722
        """
        if is_sparse(a_or_data):
            self.factorize(a_or_data)
            return
        if not is_on_device(a_or_data):
            values = np.ascontiguousarray(a_or_data, dtype=self._cast(a_or_data, "data"))
            with self._computing():
                self._solver.refactor(values, self._entries)
            return
        (on_device,), stream = device_arrays(a_or_data)
        if on_device.dtype != self._dtype:
            raise InvalidInput(f"data is of type {on_device.dtype}, the matrix of {self._dtype}")
        if on_device.shape != (self._entries,) or (self._entries > 1 and on_device.strides != (1,)):
            raise InvalidInput(f"data is not an array of {self._entries} numbers without gaps")
        with self._computing():
            self._solver.refactor_device(on_device.address, stream)

    def solve(self, b: Any, trans: str = "N", out: Any = None) -> Any:
        """The solution of A x = b, of A^T x = b (trans="T") or of A^H x = b (trans="H").

        `b` has the shape (n,) or (n, k). A complex b is solved with a real matrix, too. An array on a CUDA device has to
        be of the matrix' type, and column-major; its solution is an array of the same package, or `out`, which may be b.

        Raises SingularMatrix, AccuracyNotReached, InvalidInput (NaN or infinity), StateError, OutOfMemory.

        >>> import numpy as np, scipy.sparse, mfs
        >>> lu = mfs.splu(scipy.sparse.csc_array([[1., 1], [0, 2]]))
        >>> lu.solve(np.array([3., 4]), trans="T").round(12)
        array([3. , 0.5])
        """
        if trans not in ("N", "T", "H"):
            raise InvalidInput(f"trans is {trans!r}, not 'N', 'T' or 'H'")
        if is_on_device(b) or is_on_device(out):
            return self._solve_on_device(b, trans, out)
        b = np.asarray(b)
        if b.ndim not in (1, 2) or b.shape[0] != self._n:
            raise InvalidInput(f"b has the shape {b.shape}, and the matrix {self._n} rows")
        x = self._solve_columns(b.reshape(self._n, -1), trans).reshape(b.shape)
        if out is None:
            return x
        out[...] = x
        return out

    def _cast(self, array: Any, name: str) -> np.dtype:
        """The type of the matrix, which `array` can be given without loss of an imaginary part."""
        dtype = number_type(np.asarray(array).dtype)
        if dtype.kind == "c" and self._dtype.kind != "c":
            raise InvalidInput(f"{name} is complex, and the matrix is not")
        return self._dtype

    def _solve_columns(self, b: np.ndarray, trans: str) -> np.ndarray:
        if b.shape[1] == 0:
            return np.empty(b.shape, self._dtype)
        if b.dtype.kind == "c" and self._dtype.kind != "c":
            both = self._solve_columns(np.hstack([b.real, b.imag]), trans)
            half = b.shape[1]
            return both[:, :half] + 1j * both[:, half:]
        conjugated = trans == "H" and self._dtype.kind == "c"
        b = np.asfortranarray(b, dtype=self._cast(b, "b"))
        b = np.conj(b, order="F") if conjugated else b
        x = np.empty(b.shape, self._dtype, order="F")
        with self._computing():
            self._solver.solve(b, x, self._transposed == (trans == "N"))
        return np.conj(x, out=x) if conjugated else x

    def _solve_on_device(self, b: Any, trans: str, out: Any) -> Any:
        if trans == "H" and self._dtype.kind == "c":
            raise InvalidInput("trans='H' is not there for complex arrays on a device: conjugate them, and take 'T'")
        out = empty_like(b) if out is None else out
        (from_, to), stream = device_arrays(b, out)
        many, ldb = columns_on_device(from_, "b", self._dtype, self._n)
        if not to.writable:
            raise InvalidInput("out is not writable")
        if to.shape != from_.shape:
            raise InvalidInput(f"out has the shape {to.shape}, and b {from_.shape}")
        _, ldx = columns_on_device(to, "out", self._dtype, self._n)
        with self._computing():
            self._solver.solve_device(
                from_.address, to.address, many, ldb, ldx, stream, self._transposed == (trans == "N")
            )
        return out

    @property
    def shape(self) -> tuple:
        """(n, n)"""
        return self._n, self._n

    @property
    def dtype(self) -> np.dtype:
        """The type of the matrix' numbers."""
        return self._dtype

    @property
    def nnz(self) -> int:
        """Entries of L and U, those of whole fronts (dense blocks)."""
        return self.report["nnz_factor"]

    @property
    def report(self) -> dict:
        """What the last analysis, factorization and solve took: the figures of mfs/report.hpp by name; times in s."""
        figures: dict = {}
        for name, value in self._solver.figures().items():
            if name in _FLAGS:
                figures[name] = bool(value)
            elif name not in _REAL and not name.startswith("time_"):
                figures[name] = int(value)
            else:
                figures[name] = value
        figures["backend"], figures["rung"] = self._solver.backend_name(), self._solver.rung_name()
        return figures

    @property
    def depths(self) -> np.ndarray:
        """The fronts by their depth in the tree, a record for each: depth (0: the roots), fronts, pivots, max_front (rows),
        factor_entries (of L and U), contribution_entries and flops.

        >>> import scipy.sparse, mfs
        >>> lu = mfs.splu(scipy.sparse.eye_array(3, format="csr"))
        >>> int(lu.depths["pivots"].sum())
        3
        """
        whole = ("depth", "fronts", "pivots", "max_front", "factor_entries", "contribution_entries")
        return np.array(
            [tuple(row) for row in self._solver.depths()], [(name, np.int64) for name in whole] + [("flops", float)]
        )

    def logdet(self) -> tuple:
        """(sign, logarithm of the absolute value) of the determinant, as numpy.linalg.slogdet has them."""
        with self._computing():
            real, imaginary, logarithm = self._solver.determinant()
        return (complex(real, imaginary) if self._dtype.kind == "c" else real), logarithm

    def condition_estimate(self) -> float:
        """An estimate of the condition number in the 1-norm; of a csc matrix, in the infinity norm."""
        with self._computing():
            return self._solver.condition_estimate()

    def linear_operator(self) -> Any:
        """The inverse of the matrix as a scipy.sparse.linalg.LinearOperator: a preconditioner, or for eigsh's OPinv."""
        from scipy.sparse.linalg import LinearOperator

        return LinearOperator(
            self.shape,
            dtype=self._dtype,
            matvec=self.solve,
            rmatvec=lambda b: self.solve(b, "H"),
            matmat=self.solve,
            rmatmat=lambda b: self.solve(b, "H"),
        )


def splu(A: Any, **options: Any) -> LU:
    """Factors a square sparse matrix, as scipy.sparse.linalg.splu does.

    `A` is a matrix or array of scipy.sparse; csr and csc are taken as they lie, with any type of indices, others are
    converted. Matrices of cupyx.scipy.sparse, and tensors of torch in the layouts sparse_csr and sparse_csc, are copied to
    the host, where the first factorization takes its matrix from. Numbers of type float32, float64, complex64 and complex128 are kept, integers become float64.

    `options` are those of mfs/options.hpp and mfs/analysis_options.hpp by name; mfs.option_names() lists them. Besides,
    `progress` is a function that is called now and then with the name of the phase that runs ("matching", "ordering",
    "symbolic", "factor", "solve") and the fraction of it that is done; what it raises ends the phase.

    Raises InvalidInput, SingularMatrix, OutOfMemory, BackendError.

    >>> import scipy.sparse, mfs
    >>> A = scipy.sparse.csr_array([[1., 2], [2, 4]])
    >>> mfs.splu(A, threads=1).solve([1., 0])
    Traceback (most recent call last):
    ...
    mfs.errors.SingularMatrix: ...
    """
    return LU(A, options)


def spsolve(A: Any, b: Any, **options: Any) -> np.ndarray:
    """The solution of A x = b, for a dense vector or matrix b.

    >>> import scipy.sparse, mfs
    >>> mfs.spsolve(scipy.sparse.csr_array([[2., 0], [0, 4]]), [1., 1])
    array([0.5 , 0.25])
    """
    return splu(A, **options).solve(b)


def factorized(A: Any, **options: Any) -> Any:
    """A function that solves A x = b for b.

    >>> import scipy.sparse, mfs
    >>> solve = mfs.factorized(scipy.sparse.csr_array([[2., 0], [0, 4]]))
    >>> solve([1., 1])
    array([0.5 , 0.25])
    """
    return splu(A, **options).solve


class Solver:
    """The solver of one system step by step, with the calls of nvmath.sparse.advanced.DirectSolver.

    >>> import numpy as np, scipy.sparse, mfs
    >>> A = scipy.sparse.csr_array([[4., -1], [-1, 4]])
    >>> with mfs.Solver(A, np.array([3., 3])) as solver:
    ...     solver.plan()
    ...     solver.factorize()
    ...     x = solver.solve()
    ...     solver.reset_operands(a=2 * A)
    ...     solver.factorize()
    ...     y = solver.solve()
    >>> x.round(12), y.round(12)
    (array([1., 1.]), array([0.5, 0.5]))
    """

    def __init__(self, a: Any, b: Any, **options: Any):
        self._a, self._b, self._options = a, b, options
        self._lu: Optional[LU] = None
        self._planned = self._factored = False

    def plan(self) -> None:
        """Orders the pattern of the matrix. Its values decide about matching and scaling."""
        self._factored = self._planned = False
        self._lu = LU(self._a, self._options, factor=False)
        self._planned = True

    def factorize(self) -> None:
        """Factors the matrix by the plan."""
        if self._lu is None or not self._planned:
            raise StateError("plan comes before factorize")
        self._factored = False
        if is_sparse(self._a):
            self._lu.factorize(self._a)
        else:
            self._lu.refactor(self._a)
        self._factored = True

    def solve(self) -> Any:
        """The solution for the right-hand side."""
        if self._lu is None or not self._factored:
            raise StateError("plan and factorize come before solve")
        return self._lu.solve(self._b)

    def reset_operands(self, a: Any = None, b: Any = None) -> None:
        """Takes another matrix of the planned pattern, or its array data (factorize comes next), or right-hand side."""
        if a is not None:
            self._a, self._factored = a, False
        if b is not None:
            self._b = b

    @property
    def lu(self) -> Optional[LU]:
        """The factorization; None before plan."""
        return self._lu

    def free(self) -> None:
        """Gives all memory back."""
        self._lu, self._planned, self._factored = None, False, False

    def __enter__(self) -> "Solver":
        return self

    def __exit__(self, *_: Any) -> None:
        self.free()


version = _mfs.version
option_names = _mfs.option_names
backends = _mfs.backends
set_default_threads = _mfs.set_default_threads
