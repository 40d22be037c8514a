"""Loads the compiled module. Of a wheel with CUDA, the libraries that the system lacks are those of NVIDIA's wheels."""

import ctypes
import glob
import importlib
import os
import re
import sys
from types import ModuleType
from typing import Optional


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


def load(name: str) -> ModuleType:
    """Imports a module, with the libraries of CUDA that it needs."""
    tried: set = set()
    while True:
        try:
            return importlib.import_module(name)
        except ImportError as error:
            library = missing_library(error)
            if library is None:
                raise
            path = in_wheels(library)
            if path is None or library in tried:
                raise ImportError(
                    f"this package of MFS is one with CUDA, and {library} is not there: pip install 'mfs-solver[cuda13]', "
                    f"or put the folder of CUDA's libraries into LD_LIBRARY_PATH ({error})"
                ) from error
            tried.add(library)
            ctypes.CDLL(path)  # the loader takes it for that name from now on


_mfs = load("mfs._mfs")
