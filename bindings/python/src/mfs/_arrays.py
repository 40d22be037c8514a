"""Arrays of the host and of a device as the solvers take them."""

from typing import Any, NamedTuple, Optional

import numpy as np

from . import errors
from ._library import _mfs
from .errors import InvalidInput

_mfs.raise_classes_of(errors)

SOLVERS = {
    np.dtype(np.float32): _mfs.SolverFloat,
    np.dtype(np.float64): _mfs.SolverDouble,
    np.dtype(np.complex64): _mfs.SolverComplexFloat,
    np.dtype(np.complex128): _mfs.SolverComplexDouble,
}
_CUDA, _HOST = (2, 13), (1, 3)  # device types of DLPack: memory of CUDA, also managed; of the host, also page-locked
_KINDS = {0: "i", 1: "u", 2: "f", 5: "c", 6: "b"}  # kinds of DLPack


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


def is_sparse(a: Any) -> bool:
    """Whether it is a matrix of scipy.sparse or cupyx.scipy.sparse, or a sparse tensor of torch."""
    return hasattr(a, "tocsr") or str(getattr(a, "layout", "")).startswith("torch.sparse")


class _Parts(NamedTuple):
    """A matrix in compressed rows or columns as scipy.sparse names its parts."""

    format: str
    indptr: np.ndarray
    indices: np.ndarray
    data: np.ndarray
    shape: tuple

    @property
    def dtype(self) -> np.dtype:
        return self.data.dtype


def _on_host(a: Any) -> Any:
    """A copy on the host of a matrix of cupyx.scipy.sparse; the parts of a sparse tensor of torch."""
    layout = str(getattr(a, "layout", ""))
    if layout in ("torch.sparse_csr", "torch.sparse_csc"):
        parts = (a.crow_indices(), a.col_indices()) if layout.endswith("csr") else (a.ccol_indices(), a.row_indices())
        host = (part.detach().cpu().resolve_conj().numpy() for part in (*parts, a.values()))
        return _Parts(layout[-3:], *host, tuple(a.shape))
    if layout.startswith("torch.sparse"):
        raise TypeError(f"a sparse tensor is needed in the layout torch.sparse_csr or torch.sparse_csc, not {layout}")
    return a.get() if hasattr(a, "get") and is_on_device(getattr(a, "data", None)) else a


def compressed(a: Any) -> Matrix:
    """The arrays of a square sparse matrix on the host; those of csr and csc of scipy.sparse are not copied."""
    if not is_sparse(a):
        raise TypeError(f"a matrix of scipy.sparse, cupyx.scipy.sparse or torch is needed, not {type(a).__name__}")
    a = _on_host(a)
    layout = a.format
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
    writable: bool
    device: Optional[int] = None  # its number; None: not told
    owner: Any = None  # what keeps the array where it is


class DeviceArrays(NamedTuple):
    """Arrays on one device, which are ready for what is put into `stream`: a cudaStream_t, 0 the legacy default one."""

    arrays: list
    stream: int


def is_on_device(array: Any) -> bool:
    """Whether an array lies on a CUDA device. Raises InvalidInput for devices of other kinds."""
    if isinstance(array, np.ndarray):
        return False
    if is_sparse(array):
        raise InvalidInput("a sparse matrix stands where a dense array has to be")
    if _interface(array) is not None:
        return True
    if not hasattr(array, "__dlpack_device__"):
        return False
    kind = array.__dlpack_device__()[0]
    if kind not in _CUDA and kind not in _HOST:
        raise InvalidInput(f"an array lies on a device of DLPack's type {int(kind)}, not on the host or on a CUDA device")
    return kind in _CUDA


def _interface(array: Any) -> Optional[dict]:
    """The array's interface of CUDA. One that knows no streams (before version 3) does not serve beside DLPack."""
    interface = getattr(array, "__cuda_array_interface__", None)
    return None if interface is not None and "stream" not in interface and hasattr(array, "__dlpack__") else interface


def device_arrays(*arrays: Any) -> DeviceArrays:
    """Where they lie. Raises InvalidInput unless all lie on one CUDA device, and where they belong to several streams."""
    for array in arrays:
        if not is_on_device(array):
            raise InvalidInput("some arrays lie on the host, and some on a device")
    streams = {i["stream"] for i in map(_interface, arrays) if i is not None and i.get("stream") is not None}
    if 0 in streams:
        raise InvalidInput("an array's __cuda_array_interface__ has the stream 0, which is ambiguous: it is to be 1 or 2")
    if len(streams) > 1:
        raise InvalidInput(f"arrays belong to different streams ({', '.join(map(hex, sorted(streams)))}): synchronize them")
    stream = streams.pop() if streams else 1
    found = [_by_dlpack(a, stream) if _interface(a) is None else _by_interface(_interface(a)) for a in arrays]
    devices = {a.device for a in found if a.device is not None}
    if len(devices) > 1:
        raise InvalidInput(f"arrays lie on different devices: {', '.join(map(str, sorted(devices)))}")
    return DeviceArrays(found, 0 if stream == 1 else stream)


def _by_interface(interface: dict) -> DeviceArray:
    if interface.get("mask") is not None:
        raise InvalidInput("an array on the device has a mask")
    dtype, shape = np.dtype(interface["typestr"]), tuple(interface["shape"])
    strides = interface.get("strides")
    if strides is None:
        strides = [dtype.itemsize * int(np.prod(shape[k + 1 :], dtype=np.int64)) for k in range(len(shape))]
    if any(s % dtype.itemsize for s in strides):
        raise InvalidInput("an array on the device has strides that are no multiples of its entries' size")
    address, read_only = interface["data"]
    return DeviceArray(address, dtype, shape, tuple(s // dtype.itemsize for s in strides), not read_only)


def _by_dlpack(array: Any, stream: int) -> DeviceArray:
    try:
        capsule = array.__dlpack__(stream=stream, max_version=(1, 0))
    except TypeError:  # from before version 1
        capsule = array.__dlpack__(stream=stream)
    address, kind, bits, shape, strides, writable, owner = _mfs.describe(capsule)
    # Arrays of JAX must not be written to, which DLPack could not say before version 1.
    writable = writable and not type(array).__module__.startswith("jax")
    dtype = np.dtype(f"{_KINDS.get(kind, 'V')}{max(1, bits // 8)}")
    device = int(array.__dlpack_device__()[1])
    return DeviceArray(address, dtype, tuple(shape), tuple(strides), writable, device, owner)


def columns_on_device(array: DeviceArray, name: str, dtype: np.dtype, n: int) -> tuple:
    """(number of columns, leading dimension) of a vector or of a column-major matrix of n rows."""
    if array.dtype != dtype:
        raise InvalidInput(f"{name} is of type {array.dtype}, the matrix of {dtype}")
    if len(array.shape) not in (1, 2) or array.shape[0] != n:
        raise InvalidInput(f"{name} has the shape {array.shape}, and the matrix {n} rows")
    many = array.shape[1] if len(array.shape) == 2 else 1
    next_row = array.strides[0] if n > 1 else 1
    next_column = array.strides[1] if many > 1 else n
    if next_row != 1 and many == 1:
        raise InvalidInput(f"{name} has gaps between its entries")
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
