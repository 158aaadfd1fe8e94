"""Files of problems and of captured steps."""

from __future__ import annotations

import collections
import dataclasses
import os
import pickle
import subprocess
import sys
from typing import Any, Iterable

import numpy as np

from . import _native
from ._native import InputError
from ._problem import Problem, _impulse_rows, _integer, _number, _shape


_LARGEST_STEP = 2**53  # the largest number of a step in a file


def _require_readers(what: str) -> None:
    if not _native.has_readers:
        raise RuntimeError(f"{what}: this lcpbench was built without readers. Install libfmt-dev, nlohmann-json3-dev, "
                           "libxxhash-dev, libzstd-dev and pkg-config (Debian's names), and install lcpbench again")


def _path(path: Any) -> str:
    try:
        text = os.fsdecode(os.fspath(path))
    except TypeError:
        raise TypeError(f"path: expected a path, got {type(path).__name__}") from None
    if "\0" in text or text != text.encode(errors="ignore").decode():
        raise InputError(f"path is {text!r}, expected UTF-8 without NUL")
    return text


@dataclasses.dataclass(frozen=True, repr=False)
class Step:
    """One captured step. What is not known is None."""

    problem: Problem
    step: int = 0  #: its number in the simulation
    time: float | None = None  #: [s]
    gap: Any = None  #: (nc,) [m], negative: penetration
    contact_ids: list[str] | None = None  #: names that contacts keep from step to step
    impulses: Any = None  #: (nc, 3): the engine's own, as those of an Answer; or as `check` takes them [N s]
    velocity: Any = None  #: (ngc,): the engine's own velocity after the step
    poses: Any = None  #: of each body of the pictures position [m] and unit quaternion, w first, or rotation matrix
    contact_frames: Any = None  #: of each contact point [m], normal and tangent in the world: 9 numbers, or none
    notes: list[str] = dataclasses.field(default_factory=list)  #: how it differs from the engine's: "what: how many"
    row_impulses: Any = None  #: (m,): the engine's own of the bounded rows [N s, N m s]

    def __repr__(self) -> str:
        return "; ".join([f"<lcpbench.Step {self.step}: {self.problem!r}", *self.notes]) + ">"

    def __post_init__(self) -> None:
        ids, problem = self.contact_ids, self.problem
        if not isinstance(problem, Problem):
            return
        if isinstance(ids, list) and len(ids) == problem.nc and all(isinstance(each, str) for each in ids):
            problem._contact_names = list(ids)
        if self.impulses is None:
            return
        if getattr(self.impulses, "ndim", 1) == 1 and problem.kind != "lcp":
            f, edges, m = self.impulses, problem.edges, problem._data.row_count
            size = len(edges) + sum(edges)
            if m > 0 and self.row_impulses is None and _shape(f, "impulses") == (size + m,):
                object.__setattr__(self, "row_impulses", np.asarray(f)[size:])
                f = np.asarray(f)[:size]
            if (edges or m > 0) and _shape(f, "impulses") == (size,) and problem._has_tangents():
                f = _impulse_rows(edges, np.asarray(f))
            object.__setattr__(self, "impulses", f)
        problem.engine_impulses, problem.engine_row_impulses = self.impulses, self.row_impulses


class Scenes:
    """The captured steps of a file `F.scenes`, each read when asked for: `len(scenes)`, `scenes[0]`, iteration.
    Of a file that ends early, as a killed program leaves it, these are the complete steps.

    Attributes:
        scene, engine: texts of the file's header, "" where it has none; step_length [s] or None.

    Raises:
        InputError: names file, line and field.
    """

    def __init__(self, path: Any) -> None:
        _require_readers("Scenes")
        self._file = _native.ScenesFile(_path(path))
        self.scene: str = self._file.scene
        self.engine: str = self._file.engine
        self.step_length: float | None = self._file.step_length

    def __len__(self) -> int:
        return len(self._file)

    def __repr__(self) -> str:
        return f"<lcpbench.Scenes '{self.scene}': {len(self)} steps{' of ' + self.engine if self.engine else ''}>"

    def __getitem__(self, index: int) -> Step:
        """The k-th captured step, counted from 0; negative from the end."""
        k = _integer(index, "index")
        if not -len(self) <= k < len(self):
            raise IndexError(f"index is {k}, and there are {len(self)} steps")
        number, problem, fields = self._file.read(k % len(self))
        result = Step(Problem._of(problem), number, **fields)
        if self.engine == "MuJoCo" and np.any(result.problem.compliance_t):
            result.problem._engine_model = "convex"
        return result

    def step(self, number: int) -> Step:
        """The step with this number in the simulation; InputError names its neighbours where there is none."""
        return self[self._file.index_of(_integer(number, "number", _LARGEST_STEP))]


_MATRICES = ("G", "Ginv", "N", "D", "tangents", "M", "X", "rows_R")  # arguments of Problem; others are vectors or numbers
_VECTORS = ("v", "mu", "b", "edges", "compliance_n", "compliance_t", "offset_t", "q", "lower", "upper", "friction_of",
            "alpha", "rows_lower", "rows_upper", "rows_b", "rows_compliance", "rows_friction_of", "rows_mu")
_TEXTS = ("rows_unit", "rows_names")
_ONE_FOR_ALL = ("mu", "edges", "compliance_n", "compliance_t", "lower", "upper", "rows_lower", "rows_upper", "rows_b",
                "rows_compliance", "rows_mu")


_MAT_READER = """import pickle, sys
from scipy.io import loadmat
try:
    arrays = loadmat(sys.argv[1])
except Exception as error:
    sys.exit(" ".join(str(error).split()) or type(error).__name__)
pickle.dump({key: each for key, each in arrays.items() if not key.startswith("__")}, sys.stdout.buffer)
"""


def _load_mat(name: str) -> dict[str, Any]:
    """In a process of its own, because a damaged file can crash scipy. @raises OSError with scipy's words"""
    if not os.path.exists(name):
        raise OSError("there is no such file")
    done = subprocess.run([sys.executable, "-c", _MAT_READER, os.path.abspath(name)], capture_output=True, check=False,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    if done.returncode < 0:
        raise OSError("it is damaged so that scipy crashes")
    if done.returncode > 0:
        raise OSError((done.stderr.decode(errors="replace").strip().splitlines() or ["scipy does not read it"])[-1])
    return dict(pickle.loads(done.stdout))


def _load_arrays(name: str) -> Problem:
    """The arguments of a Problem from a file of numpy (.npz) or MATLAB (.mat); X and alpha are G_factors, and rows_R that of
    the bounded rows."""
    try:
        if name.endswith(".mat"):
            arrays = _load_mat(name)
        else:
            with np.load(name, allow_pickle=False) as file:
                arrays = dict(file)
    except Exception as error:  # numpy, zipfile and scipy each have their own
        raise InputError(f"{name}: cannot be read: {error}") from None
    for key, each in arrays.items():
        if key not in _MATRICES + _VECTORS + _TEXTS:
            raise InputError(f"{name}: {key}: unknown; known: {', '.join(_MATRICES + _VECTORS + _TEXTS)}")
        if key in _TEXTS:  # MATLAB's have spaces at their ends, and those of a cell array are arrays
            arrays[key] = ["".join(np.ravel(text).tolist()).rstrip() for text in np.ravel(each)]
        if key in _VECTORS:  # MATLAB's vectors and numbers are matrices
            flat = np.ravel(each.toarray() if hasattr(each, "toarray") else each)
            arrays[key] = flat[0] if len(flat) == 1 and key in _ONE_FOR_ALL else flat
        elif key in ("M", "Ginv", "X") and hasattr(each, "toarray"):
            arrays[key] = each.toarray()
    if rows := {key.removeprefix("rows_"): arrays.pop(key) for key in list(arrays) if key.startswith("rows_")}:
        arrays["rows"] = rows
    factors = [arrays.pop(key) for key in ("X", "alpha") if key in arrays]
    stem = os.path.basename(name).rsplit(".", 1)[0]
    if factors:
        arrays["G_factors"] = tuple(factors)
    try:
        return Problem(**arrays, name=stem)
    except (InputError, TypeError) as error:
        raise type(error)(f"{name}: {error}") from None


def load(path: Any) -> Any:
    """Reads a problem, or a file of captured steps.

    Args:
        path: a problem file (JSON, Siconos' dense text of an LCP or MLCP, or a Matrix Market pair), "F.scenes#120" for
            step 120 of a simulation, or "F.scenes" for all its steps. An .npz of numpy or a .mat of MATLAB (with scipy,
            up to version 7) holds arguments of Problem by name: M and q, with lower, upper, friction_of and mu, or G, N,
            v and so on, and rows_R, rows_lower and so on for those of rows. friction_of is counted from 0, and -1 stands
            for none.

    Returns:
        A Problem, of a captured step with the engine's impulses, or `Scenes` for a whole file of steps.

    Raises:
        InputError: names file, field and cause.
    """
    name = _path(path)
    if name.endswith((".npz", ".mat")):
        return _load_arrays(name)
    if name.endswith((".hdf5", ".h5")):
        raise InputError(f"{name}: HDF5 is not read here; lcpbench.fclib.load reads files of FCLIB")
    _require_readers("load")
    if (part := _native.scenes_step(name)) is not None:
        return Scenes(part[0]).step(part[1]).problem
    return Scenes(name) if _native.is_scenes_file(name) else Problem._of(_native.read_problem(name))


def save(problem: Problem, path: Any) -> None:
    """Writes a problem file (JSON), whole or not at all. What is read again has the same bits.

    Raises:
        InputError: the file cannot be written.
    """
    _require_readers("save")
    if not isinstance(problem, Problem):
        raise TypeError(f"problem: expected a Problem, got {type(problem).__name__}")
    _native.write_problem(problem._data, _path(path))


class Recorder:
    """Writes captured steps to a file `F.scenes`, in a loop of yours:

        with Recorder("walk.scenes", every=10) as recorder:
            while running:
                if recorder.wants_next():
                    recorder.add(lcpbench.mujoco.capture(model, data))
                mujoco.mj_step(model, data)

    What was added survives when the program is killed.

    Args:
        path: the file; what it held is lost.
        scene: what is simulated, a text.
        engine, engine_version: texts.
        step_length: [s], or None.
        gravity: (3,) [m/s^2], or None.
        shapes: for pictures, of each shape (body, type, size), as `lcpbench.mujoco.shapes(model)` has them; a body is an
            index of `Step.poses`, -1 the world.
        every: `wants_next` returns True at the first of every so many calls.

    Raises:
        InputError: the file cannot be written, or step_length is not finite.
    """

    def __init__(self, path: Any, scene: str = "recorded", *, engine: str = "", engine_version: str = "",
                 step_length: float | None = None, gravity: Any = None, shapes: Any = (), every: int = 1) -> None:
        _require_readers("Recorder")
        self._every = _integer(every, "every")
        if self._every < 1:
            raise InputError(f"every is {every}, expected at least 1")
        for name, value in (("scene", scene), ("engine", engine), ("engine_version", engine_version)):
            if not isinstance(value, str):
                raise TypeError(f"{name}: expected a text, got {type(value).__name__}")
        length = None if step_length is None else _number(step_length, "step_length")
        try:
            drawn = [(_integer(body, "body"), str(kind), [float(each) for each in size]) for body, kind, size in shapes]
            down = [] if gravity is None else [float(each) for each in gravity]
        except (TypeError, ValueError):
            raise InputError("shapes: expected (body, type, size) of each, and gravity three numbers") from None
        self._writer: Any = _native.ScenesWriter(_path(path), scene, engine, engine_version, length, down, drawn)
        self._seen, self._last = 0, -1
        self._notes: collections.Counter[str] = collections.Counter()
        self.count = 0  #: steps written

    @property
    def notes(self) -> list[str]:
        """Those of the steps that were written: "what: how many", summed up."""
        return [f"{what}: {count}" for what, count in self._notes.items()]

    def wants_next(self) -> bool:
        """Counts one step of the simulation, and returns whether it is one to keep."""
        self._seen += 1
        return (self._seen - 1) % self._every == 0

    def add(self, captured: Step | Problem, step: int | None = None) -> None:
        """Writes one step.

        Args:
            captured: a `Step`, as every `capture` function returns it, or a Problem with contacts.
            step: its number in the simulation, from 0 to 2^53, larger than the last; None: as `wants_next` counts, or
                one more than the last where that is larger.

        Raises:
            InputError: the step could not be read again, or cannot be written.
        """
        if self._writer is None:
            raise RuntimeError("Recorder: is closed")
        if not isinstance(captured, (Problem, Step)):
            raise TypeError(f"captured: expected a Step or a Problem, got {type(captured).__name__}")
        each = captured
        if isinstance(each, Problem):
            each = Step(each, impulses=each.engine_impulses, row_impulses=each.engine_row_impulses)
        number = max(self._seen - 1, self._last + 1) if step is None else _integer(step, "step", _LARGEST_STEP)
        fields = {name: getattr(each, name) for name in ("time", "gap", "contact_ids", "impulses", "row_impulses",
                                                        "velocity")}
        fields.update(poses=rows(pose_rows(each.poses)), contact_frames=rows(each.contact_frames))
        self._writer.add(number, each.problem._data, {**fields, "notes": each.notes})
        for what, _, count in (note.rpartition(": ") for note in each.notes):
            self._notes[what] += int(count)
        self._last = number
        self.count += 1

    def close(self) -> None:
        """Ends the file."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def numbered(names: Iterable[str]) -> list[str]:
    """Each name, from the second of its equals on with a number."""
    seen: dict[str, int] = {}
    result = []
    for name in names:
        count = seen[name] = seen.get(name, 0) + 1
        result.append(f"{name} #{count}" if count > 1 else name)
    return result


def pose_rows(poses: Any) -> Any:
    """With quaternions in place of an array's rotation matrices, row after row."""
    if getattr(poses, "shape", ())[1:] != (12,):
        return poses
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_matrix(poses[:, 3:].reshape(-1, 3, 3)).as_quat() if len(poses) else np.zeros((0, 4))
    return np.hstack([poses[:, :3], turned[:, [3, 0, 1, 2]]])


def rows(values: Any) -> list[list[float]] | None:
    """Lists of numbers; a row of an array that begins with NaN is none."""
    if values is None:
        return None
    lists = np.asarray(values).tolist() if isinstance(values, np.ndarray) else [list(each) for each in values]
    return [[] if row and row[0] != row[0] else row for row in lists]
