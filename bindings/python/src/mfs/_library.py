"""Loads the compiled module. Of a wheel with CUDA, it takes the libraries of NVIDIA's wheels before those of the system, as
torch and CuPy do: a process has one library of a name, which has to be as new as the newest of them wants it."""

import contextlib
import ctypes
import glob
import importlib
import os
import pathlib
import re
import sys
import warnings
from types import ModuleType
from typing import Optional


def needed() -> list:
    """The libraries of CUDA that libmfs was linked with, as the build has found them."""
    return pathlib.Path(__file__).with_name("_needed.txt").read_text().split()


def missing_library(error: ImportError) -> Optional[str]:
    """The library of CUDA that an import did not find."""
    found = re.match(r"(lib(?:cu|nv)[\w.+-]+\.so[\w.]*): cannot open shared object file", str(error))
    return found[1] if found else None


def in_wheels(name: str) -> Optional[str]:
    """Where NVIDIA's wheels (nvidia-cublas, nvidia-cublas-cu12, ...) have put it."""
    for folder in sys.path:
        for path in glob.glob(os.path.join(glob.escape(folder), "nvidia", "*", "lib", name)):
            return path
    return None


def is_chosen(name: str) -> bool:
    """Whether the process has it already, or LD_LIBRARY_PATH says where it is."""
    folders = os.environ.get("LD_LIBRARY_PATH", "").split(":")
    if any(folder and os.path.exists(os.path.join(folder, name)) for folder in folders):
        return True
    try:
        ctypes.CDLL(name, os.RTLD_NOLOAD | os.RTLD_NOW)
        return True
    except OSError:
        return False


def load(name: str) -> ModuleType:
    """Imports a module, with the libraries of CUDA that it needs."""
    for library in needed():
        path = in_wheels(library)
        if path is not None and not is_chosen(library):
            with contextlib.suppress(OSError):  # it needs one that is not there: the system's may do
                ctypes.CDLL(path)  # the loader takes it for that name from now on
    try:
        return importlib.import_module(name)
    except ImportError as error:
        library = missing_library(error)
        if library is None:
            raise
        raise ImportError(
            f"this package of MFS is one with CUDA, and {library} is not there: pip install 'mfs-solver[cuda13]', "
            f"or put the folder of CUDA's libraries into LD_LIBRARY_PATH ({error})"
        ) from error


def warn_of_slow_blas(kernels: str) -> None:
    """A warning, where OpenBLAS uses kernels of an old processor; `kernels` are those it should use, or nothing."""
    if kernels:
        warnings.warn(
            f"OpenBLAS does not know this processor, and MFS takes up to three times as long as it could: set the environment "
            f"variable OPENBLAS_CORETYPE={kernels} before Python is started",
            RuntimeWarning,
            stacklevel=2,
        )


_mfs = load("mfs._mfs")
warn_of_slow_blas(_mfs.better_blas_kernels())
