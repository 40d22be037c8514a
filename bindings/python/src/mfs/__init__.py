"""MFS, a multifrontal direct solver for large sparse linear systems.

>>> import numpy as np, scipy.sparse, mfs
>>> A = scipy.sparse.csr_array([[4., -1, 0], [-1, 4, -1], [0, -1, 4]])
>>> mfs.spsolve(A, np.array([3., 2, 3])).round(12)
array([1., 1., 1.])

splu, spsolve and factorized are those of scipy.sparse.linalg, the class Solver that of nvmath's DirectSolver. Every
solution has a checked backward error; what cannot be solved is an exception that names the row.
"""

from ._lu import LU, Solver, backends, factorized, option_names, set_default_threads, splu, spsolve, version
from .errors import (
    AccuracyNotReached,
    BackendError,
    Error,
    InvalidInput,
    OutOfMemory,
    PatternChanged,
    SingularMatrix,
    StateError,
)

__version__ = version()
__all__ = [
    "AccuracyNotReached", "BackendError", "Error", "InvalidInput", "LU", "OutOfMemory", "PatternChanged",
    "SingularMatrix", "Solver", "StateError", "backends", "factorized", "option_names", "set_default_threads", "splu",
    "spsolve", "version",
]
