"""The errors of MFS, one class for each kind. Rows and columns count from 0; None means "none"."""

from typing import Optional


class Error(RuntimeError):
    """The base of all errors of MFS."""


class InvalidInput(Error, ValueError):
    """An argument or option is not acceptable: its name, and the place of the entry where it is one."""

    argument: str = ""
    row: Optional[int] = None
    column: Optional[int] = None


class StateError(Error):
    """Calls out of order, as solve before factorize."""


class PatternChanged(Error, ValueError):
    """A matrix does not have the analysed pattern: the first row (of a csc matrix, column) that differs."""

    row: Optional[int] = None
    column: Optional[int] = None


class SingularMatrix(Error):
    """The matrix is singular: a row and a column that depend on the others, and the number of such rows."""

    kind: str = ""
    row: Optional[int] = None
    column: Optional[int] = None
    dependent_rows: int = 0


class AccuracyNotReached(Error):
    """A solution missed the tolerance: the backward error that was reached, and the tolerance."""

    reached: float = float("nan")
    asked: float = float("nan")


class OutOfMemory(Error, MemoryError):
    """Memory was refused, of "host" or "device": bytes of the request, and bytes that were free (0: unknown)."""

    space: str = ""
    needed: int = 0
    available: int = 0


class BackendError(Error):
    """A library or device that MFS uses failed, or is not there: its name, and its own error code."""

    library: str = ""
    code: int = 0
