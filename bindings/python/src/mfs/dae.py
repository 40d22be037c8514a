"""Mechanisms of rigid and flexible bodies: models, as docs/models.md describes them, are run by the program mfs-dae.

>>> import mfs.dae
>>> model = {
...     "name": "falling", "end": 1, "outputs": 4, "gravity": [0, 0, -10],
...     "bodies": {"block": {"type": "rigid", "mass": 2, "inertia": [1, 1, 1]}},
... }
>>> result = mfs.dae.run(model)
>>> result.t
array([0.  , 0.25, 0.5 , 0.75, 1.  ])
>>> result["bodies.block.position"][:, 2].round(4) + 0.0
array([ 0.    , -0.3125, -1.25  , -2.8125, -5.    ])

The program is the one that the environment variable MFS_DAE_PROGRAM names, else the first mfs-dae on the PATH, else one
beside Python's own. A model is a dict (numbers and arrays of numpy will do, too), the path of a file, or the name of a
model of the library (mfs.dae.models()). What goes wrong is an exception of mfs with what the program said.
"""

import ast
import contextlib
import csv
import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from typing import Any, Optional, Union

import numpy as np

from .errors import AccuracyNotReached, BackendError, Error, InvalidInput, OutOfMemory, SingularMatrix

__all__ = ["Failed", "Linearization", "Result", "check", "linearize", "model", "models", "modes", "run", "static"]

Model = Union[Mapping, str, os.PathLike]
_SECONDS_TO_END = 30.0  # that the program has to write what there is, when it is asked to end


class Failed(Error):
    """The integration failed, or a library that it uses: the program's exit code is 7."""


_BY_EXIT_CODE = {
    2: InvalidInput,
    3: InvalidInput,
    4: SingularMatrix,
    5: OutOfMemory,
    6: AccuracyNotReached,
    7: Failed,
}


class Result(Mapping):
    """What a run leaves: a time series of each recorded quantity, by its name (docs/models.md, "What is recorded").

    `result["bodies.crank.position"]` has the shape (outputs + 1, 3), a number per output (outputs + 1,). Units are SI,
    vectors lie along the ground's axes.
    """

    t: np.ndarray  #: s, (outputs + 1,)
    overview: dict  #: columns of the overview by name with unit, as "max von Mises rod [Pa]", (outputs + 1,) each
    steps: np.ndarray  #: a record per step: t, h, order, newton, factorizations, rejections, residual, wall
    report: dict  #: what the run took, as --json writes it
    folder: Optional[str]  #: of the files (result.pvd for ParaView); None: there are none

    def __init__(self, files: str, report: dict, folder: Optional[str]):
        self._records = _records(os.path.join(files, "results.npy"))
        self.t = self._records["t"]
        self.overview = self._overview(os.path.join(files, "time_series.csv"))
        steps = os.path.join(files, "steps.csv")
        self.steps = _steps(*_table(steps))
        self.report, self.folder = report, folder

    def _overview(self, path: str) -> dict:
        names, rows = _table(path)
        columns, recorded = len(names), list(self)
        if recorded and names[-1].startswith(recorded[-1]):  # else they are too many for that file
            columns -= sum(int(np.prod(self[name].shape[1:])) for name in recorded)
        return {names[k]: rows[:, k] for k in range(1, columns)}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._records.dtype.names:
            raise KeyError(f"{name} is not recorded")
        return self._records[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._records.dtype.names[1:])

    def __len__(self) -> int:
        return len(self._records.dtype.names) - 1

    def __repr__(self) -> str:
        return f"<mfs.dae.Result of {self.report.get('name')!r}: {len(self.t)} outputs of {len(self)} quantities>"


@dataclasses.dataclass(frozen=True)
class Linearization:
    """Small motions x about a state, M x'' + D x' + K x + Phi_q^T mu = f, Phi_q x = 0, with n coordinates and m constraints.

    Matrices are csr_array of scipy.sparse. Coordinates are positions and Euler parameters of frames and positions of nodes;
    all constraints are there, also those that follow from others. Where something rolls, its rows say Phi_q x' = 0.
    """

    M: Any  #: mass, (n, n)
    D: Any  #: dF/dv, (n, n)
    K: Any  #: dF/dq, (n, n), with what multipliers' forces change with q
    Phi_q: Any  #: (m, n)
    F: np.ndarray  #: (n,), what the state leaves of the equations of motion, 0 where it is true
    Phi: np.ndarray  #: (m,), the same of the constraints
    q: np.ndarray  #: (n,), coordinates of the state
    multipliers: np.ndarray  #: (m,)
    coordinates: tuple  #: their names
    constraints: tuple  #: their names

    def __repr__(self) -> str:
        return f"<mfs.dae.Linearization: {len(self.q)} coordinates, {len(self.multipliers)} constraints>"


def _linearization(folder: str) -> Linearization:
    from scipy.io import mmread
    from scipy.sparse import csr_array

    matrices = [csr_array(mmread(os.path.join(folder, name + ".mtx"))) for name in ("M", "D", "K", "Phi_q")]
    left = mmread(os.path.join(folder, "F.mtx"))[:, 0]
    with open(os.path.join(folder, "rows.csv"), encoding="utf-8", newline="") as file:
        rows = [(row["name"], float(row["value"])) for row in csv.DictReader(file)]
    n = matrices[0].shape[0]
    values = np.array([value for _, value in rows])
    names = [name for name, _ in rows]
    return Linearization(
        *matrices, left[:n], left[n:], values[:n], values[n:], tuple(names[:n]), tuple(names[n:])
    )


def _records(path: str) -> np.ndarray:
    with open(path, "rb") as file:
        version = np.lib.format.read_magic(file)
        length = int.from_bytes(file.read(4 if version[0] > 1 else 2), "little")
        header = file.read(length).decode("utf-8" if version[0] > 2 else "latin1")
        # Not numpy.load: it refuses long headers, by an option that old versions do not have.
        return np.fromfile(file, np.dtype(ast.literal_eval(header)["descr"]))


def _table(path: str) -> tuple:
    """The names of the columns, and the rows."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().rstrip("\n").split(",")
        rows = [line.split(",") for line in file]
    return names, np.array(rows, float).reshape(-1, len(names))


def _steps(names: list, rows: np.ndarray) -> np.ndarray:
    names = [name.partition(" [")[0] for name in names]
    return np.array(list(map(tuple, rows)), [(name, float) for name in names])


def _program() -> str:
    named = os.environ.get("MFS_DAE_PROGRAM")
    found = named or shutil.which("mfs-dae") or shutil.which("mfs-dae", path=os.path.dirname(sys.executable))
    if not found or not shutil.which(found):
        error = BackendError(
            f"MFS_DAE_PROGRAM is {named}, which is no program"
            if named
            else "mfs-dae is not on the PATH: install it, or name it in the environment variable MFS_DAE_PROGRAM"
        )
        error.library = "mfs-dae"
        raise error
    return found


def _end(process: "subprocess.Popen[str]") -> None:
    """Asks it to end, and then ends it."""
    try:
        process.terminate()
        process.communicate(timeout=_SECONDS_TO_END)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if process.poll() is None:
            process.kill()
        with process:  # closes its pipes
            process.wait()


def _failure(code: int, text: str) -> Error:
    """What an exit code (below 0: a signal) and the text on standard error mean."""
    lines = [line for line in text.splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    last = last[len("mfs-dae: ") :] if last.startswith("mfs-dae: ") else last
    if code < 0:
        return Error(f"mfs-dae was ended by signal {-code}" + (f": {last}" if last else ""))
    return _BY_EXIT_CODE.get(code, Error)(last or f"mfs-dae ended with exit code {code}")


@contextlib.contextmanager
def _interrupts_later() -> Iterator[None]:
    """A Ctrl-C that comes here is raised at the end, so that no process is started and forgotten."""
    before, came = signal.getsignal(signal.SIGINT), []
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    signal.signal(signal.SIGINT, lambda *arguments: came.append(arguments))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        before(*came[0])


def _call(*words: str) -> str:
    """Runs the program, and gives back its standard output. Where this thread is interrupted (Ctrl-C), it ends first."""
    process = None
    try:
        with _interrupts_later():
            process = subprocess.Popen(
                [_program(), *words],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                errors="replace",
                start_new_session=True,  # a terminal's Ctrl-C goes to Python alone
            )
        output, text = process.communicate()
    except BaseException:
        if process is not None:
            _end(process)
        raise
    if process.returncode != 0:
        raise _failure(process.returncode, text)
    return output


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as JSON has them."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"a model has no {type(value).__name__}: {value!r}")


def _with_paths(model: Mapping) -> dict:
    """Mesh files are seen from the current folder, as there is no folder of the model."""
    model = json.loads(_dumped(model))
    bodies = model.get("bodies")
    for body in bodies.values() if isinstance(bodies, dict) else ():
        mesh = body.get("mesh") if isinstance(body, dict) else None
        if isinstance(mesh, dict) and isinstance(mesh.get("gmsh"), str):
            mesh["gmsh"] = os.path.abspath(mesh["gmsh"])
    return model


def _dumped(model: Mapping) -> str:
    try:
        return json.dumps(dict(model), default=_plain, allow_nan=False)
    except ValueError as error:  # NaN, infinity, an object within itself
        raise InvalidInput(f"the model cannot be written as JSON: {error}") from None


@contextlib.contextmanager
def _place(model: Model) -> Iterator[tuple]:
    """(the model as the program takes it, a folder for what is read and thrown away)"""
    with tempfile.TemporaryDirectory(prefix="mfs-dae-") as folder:
        if isinstance(model, Mapping):
            path = os.path.join(folder, "model.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(_with_paths(model), file)
        elif isinstance(model, (str, os.PathLike)):
            path = os.fspath(model)
            path = os.path.abspath(path) if os.path.exists(path) or path.startswith("-") else path
        else:
            raise TypeError(f"a model is a dict, a path or a name, not {type(model).__name__}")
        yield path, folder


def _options(threads: int, refine: int, parameters: Optional[Mapping]) -> list:
    words = []
    if threads:
        words += ["--threads", str(threads)]
    if refine:
        words += ["--refine", str(refine)]
    for name, value in (parameters or {}).items():
        words.append(f"--set={name}={value if isinstance(value, str) else repr(float(value))}")
    return words


def _result(command: str, model: Model, folder: Any, plots: bool, options: list) -> Result:
    with _place(model) as (path, temporary):
        files = os.path.join(temporary, "out") if folder is None else os.path.abspath(os.fspath(folder))
        if folder is None or not plots:
            options = [*options, "--no-plots"]
        output = _call(command, path, "-o", files, "--json", "-", *options)
        try:
            return Result(files, json.loads(output), None if folder is None else files)
        except (OSError, ValueError, TypeError, KeyError, SyntaxError) as error:
            raise Error(f"mfs-dae has left no results: {error}") from error


def run(
    model: Model,
    *,
    folder: Union[str, os.PathLike, None] = None,
    backend: str = "openmp",
    threads: int = 0,
    refine: int = 0,
    parameters: Optional[Mapping] = None,
    plots: bool = False,
) -> Result:
    """Integrates a model, and returns time series of what is recorded.

    `folder` keeps the files of the run (with pictures where `plots` is true, which needs matplotlib); without it there are
    none. `backend` is that of the linear solver and of flexible bodies: serial, openmp, cuda or kokkos. 0 threads are
    all, 0 leaves `refine` (cells of generated meshes are divided that many times) as the model has it. `parameters` have
    other values than in the model: numbers, or texts that are expressions.

    Ctrl-C ends the run; with a folder, what there is by then is in it.

    Raises InvalidInput (the model, with its place as in "bodies.crank.mass: ..."; a folder that cannot be written),
    SingularMatrix, OutOfMemory, AccuracyNotReached, Failed (the integration), BackendError (no mfs-dae).

    >>> import mfs.dae
    >>> model = mfs.dae.model("simple_pendulum")
    >>> model["end"] = -1
    >>> mfs.dae.run(model)
    Traceback (most recent call last):
    ...
    mfs.errors.InvalidInput: end: ...
    """
    return _result("run", model, folder, plots, ["--backend", str(backend), *_options(threads, refine, parameters)])


def static(
    model: Model,
    *,
    folder: Union[str, os.PathLike, None] = None,
    threads: int = 0,
    refine: int = 0,
    parameters: Optional[Mapping] = None,
    plots: bool = False,
) -> Result:
    """The static equilibrium near where bodies are given, as a Result with one output. See run()."""
    return _result("static", model, folder, plots, _options(threads, refine, parameters))


def modes(
    model: Model,
    count: int = 10,
    *,
    at: Optional[float] = None,
    undamped: bool = False,
    shapes: bool = False,
    threads: int = 0,
    refine: int = 0,
    parameters: Optional[Mapping] = None,
) -> np.ndarray:
    """Small motions x exp(s t) about the equilibrium, or about the motion's state at the time `at` (s), nearest to s = 0 first.

    Returns a record for each: frequency |s| / 2 pi (Hz), damping_ratio -Re s / |s| and s (1/s), with `shapes` also x, a
    number for each of the coordinates of linearize(), of which the largest is 1 (this needs scipy). Of two that are conjugate
    one is given. `undamped` leaves out what depends on velocities. See run().

    >>> import numpy as np, mfs.dae
    >>> found = mfs.dae.modes("simple_pendulum")    # 1 m long
    >>> ((2 * np.pi * found["frequency"])**2).round(3)
    array([9.81])
    """
    words = ["--modes", str(count), *_options(threads, refine, parameters), *_time(at)]
    words += ["--undamped"] if undamped else []
    with _place(model) as (path, folder):
        words += ["-o", os.path.join(folder, "out"), "--no-plots"] if shapes else []
        found = json.loads(_call("modes", path, "--json", "-", *words))["modes"]
        columns = _shapes(os.path.join(folder, "out")) if shapes and found else np.empty((0, 0))
    fields = [("frequency", float), ("damping_ratio", float), ("s", complex)]
    table = np.empty(len(found), fields + ([("x", complex, columns.shape[:1])] if shapes else []))
    for row, mode in zip(table, found):
        row["frequency"], row["damping_ratio"], row["s"] = mode["frequency"], mode["damping_ratio"], complex(*mode["s"])
    if shapes:
        table["x"] = columns.T
    return table


def _time(at: Optional[float]) -> list:
    return ["--at", repr(float(at))] if at is not None else []


def _shapes(folder: str) -> np.ndarray:
    from scipy.io import mmread

    return mmread(os.path.join(folder, "shapes.mtx"))


def linearize(
    model: Model,
    *,
    at: Optional[float] = None,
    threads: int = 0,
    refine: int = 0,
    parameters: Optional[Mapping] = None,
) -> Linearization:
    """The matrices of small motions about the equilibrium, or about the motion's state at the time `at` (s). Needs scipy. See run().

    >>> import mfs.dae
    >>> block = {"type": "rigid", "mass": 2, "inertia": [1, 1, 1]}
    >>> spring = {"type": "spring_damper", "a": "ground", "b": "block", "point_a": [0, 0, 1], "point_b": [0, 0, 0],
    ...           "stiffness": 50}
    >>> model = {"name": "hanging", "end": 1, "outputs": 1, "bodies": {"block": block}, "forces": {"spring": spring}}
    >>> small = mfs.dae.linearize(model)
    >>> i = small.coordinates.index("block.z")
    >>> float(small.M[i, i]), round(float(small.K[i, i]), 9)
    (2.0, 50.0)
    """
    with _place(model) as (path, folder):
        _call("linearize", path, "-o", folder, *_options(threads, refine, parameters), *_time(at))
        return _linearization(folder)


def check(model: Model, *, refine: int = 0, parameters: Optional[Mapping] = None) -> str:
    """Reads a model, puts it together and says in a text how large it is, and what is out of line. See run()."""
    with _place(model) as (path, _):
        return _call("check", path, *_options(0, refine, parameters))


def models() -> dict:
    """The models of the library: what each is, by name.

    >>> import mfs.dae
    >>> "four_bar" in mfs.dae.models()
    True
    """
    lines = (line.partition(" ") for line in _call("models").splitlines())
    return {name: text.strip() for name, _, text in lines}


def model(name: str) -> dict:
    """A model of the library as a dict, to be changed and run. Raises KeyError."""
    with tempfile.TemporaryDirectory(prefix="mfs-dae-") as folder:
        for path in _call("models", "--write", folder).splitlines():
            if os.path.basename(path) == name + ".json":
                with open(path, encoding="utf-8") as file:
                    return json.load(file)
    raise KeyError(f"there is no model {name} in the library")
