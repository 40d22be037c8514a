"""Arrays of the host and of a device as the solvers take them."""

from typing import Any, NamedTuple, Optional

import numpy as np

from . import _mfs, errors
from .errors import InvalidInput

_mfs.raise_classes_of(errors)

SOLVERS = {
    np.dtype(np.float32): _mfs.SolverFloat,
    np.dtype(np.float64): _mfs.SolverDouble,
    np.dtype(np.complex64): _mfs.SolverComplexFloat,
    np.dtype(np.complex128): _mfs.SolverComplexDouble,
}
_CUDA = {2: "cuda", 13: "cuda managed"}  # device types of DLPack
_KINDS = {2: "f", 5: "c"}  # kinds of DLPack


def number_type(dtype: Any) -> np.dtype:
    """The kind of numbers that serves for entries of `dtype`: itself, or float64 for integers."""
    dtype = np.dtype(dtype)
    if dtype in SOLVERS:
        return dtype
    if dtype.kind in "biu" or dtype == np.float16:
        return np.dtype(np.float64)
    raise TypeError(f"MFS has no numbers of type {dtype}")


class Matrix(NamedTuple):
    """A sparse matrix, or its transposed one, in compressed rows."""

    offsets: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    transposed: bool  # it was in compressed columns
    n: int


def compressed(a: Any) -> Matrix:
    """The arrays of a square scipy.sparse matrix or array; those of csr and csc are not copied."""
    layout = getattr(a, "format", None)
    if layout is None or not hasattr(a, "tocsr"):
        raise TypeError(f"a matrix of scipy.sparse is needed, not {type(a).__name__}")
    if layout not in ("csr", "csc"):
        a = a.tocsr()
    if len(a.shape) != 2 or a.shape[0] != a.shape[1]:
        raise InvalidInput(f"the matrix is not square: its shape is {tuple(a.shape)}")
    wide = np.dtype(np.int64)
    index_type = a.indptr.dtype if a.indptr.dtype == a.indices.dtype == np.dtype(np.int32) else wide
    offsets, columns = (np.ascontiguousarray(part, dtype=index_type) for part in (a.indptr, a.indices))
    values = np.ascontiguousarray(a.data, dtype=number_type(a.dtype))
    return Matrix(offsets, columns, values, layout == "csc", a.shape[0])


class DeviceArray(NamedTuple):
    """Where an array on a device lies. Strides count elements."""

    address: int
    dtype: np.dtype
    shape: tuple
    strides: tuple
    stream: int
    writable: bool


def device_array(array: Any) -> Optional[DeviceArray]:
    """None for what does not lie on a CUDA device. The array must outlive the result."""
    if isinstance(array, np.ndarray):
        return None
    interface = getattr(array, "__cuda_array_interface__", None)
    if interface is not None:
        dtype, shape = np.dtype(interface["typestr"]), tuple(interface["shape"])
        strides = interface.get("strides")
        if strides is None:
            strides = [dtype.itemsize * int(np.prod(shape[k + 1 :], dtype=np.int64)) for k in range(len(shape))]
        address, read_only = interface["data"]
        stream = interface.get("stream") or 0
        # 1 is CUDA's legacy default stream, which is that of address 0, too.
        return DeviceArray(
            address, dtype, shape, tuple(s // dtype.itemsize for s in strides), 0 if stream == 1 else stream, not read_only
        )
    if hasattr(array, "__dlpack_device__") and array.__dlpack_device__()[0] in _CUDA:
        address, _, kind, bits, shape, strides = _mfs.describe(array)
        dtype = np.dtype(f"{_KINDS.get(kind, 'V')}{bits // 8}")
        return DeviceArray(address, dtype, tuple(shape), tuple(strides), 0, True)
    return None


def columns_on_device(array: DeviceArray, name: str, dtype: np.dtype, n: int) -> tuple:
    """(number of columns, leading dimension) of a vector or of a column-major matrix of n rows."""
    if array.dtype != dtype:
        raise InvalidInput(f"{name} is of type {array.dtype}, the matrix of {dtype}")
    if len(array.shape) not in (1, 2) or array.shape[0] != n:
        raise InvalidInput(f"{name} has the shape {array.shape}, and the matrix {n} rows")
    many = array.shape[1] if len(array.shape) == 2 else 1
    next_row = array.strides[0] if n > 1 else 1
    next_column = array.strides[1] if many > 1 else n
    if next_row != 1 or next_column < n:
        raise InvalidInput(f"{name} is not column-major (order='F')")
    return many, next_column


def empty_like(array: Any) -> Any:
    """A new array of the package that `array` comes from, with the same shape and order."""
    import sys

    package = sys.modules.get(type(array).__module__.partition(".")[0])
    make = getattr(package, "empty_like", None)
    if make is None or "jax" in type(array).__module__:
        raise TypeError(f"solve(b, out=x) needs an array for the solution, as none can be made like {type(array)}")
    return make(array)
