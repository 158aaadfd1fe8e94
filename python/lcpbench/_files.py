"""Files of problems and of captured steps."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np

from . import _native
from ._native import InputError
from ._problem import Problem, _integer, _number


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


@dataclasses.dataclass(frozen=True)
class Step:
    """One captured step. What is not known is None."""

    problem: Problem
    step: int = 0  #: its number in the simulation
    time: float | None = None  #: [s]
    gap: Any = None  #: (nc,) [m], negative: penetration
    contact_ids: list[str] | None = None  #: names that contacts keep from step to step
    impulses: Any = None  #: the engine's own, f_N of each contact and f_D of each friction direction [N s]
    velocity: Any = None  #: (ngc,): the engine's own velocity after the step

    def __post_init__(self) -> None:
        ids = self.contact_ids
        named = isinstance(self.problem, Problem) and isinstance(ids, list) and len(ids) == self.problem.nc
        if named and all(isinstance(each, str) for each in ids or []):
            self.problem._contact_names = list(ids or [])


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

    def __getitem__(self, index: int) -> Step:
        """The k-th captured step, counted from 0; negative from the end."""
        k = _integer(index, "index")
        if not -len(self) <= k < len(self):
            raise IndexError(f"index is {k}, and there are {len(self)} steps")
        number, problem, fields = self._file.read(k % len(self))
        return Step(Problem._of(problem), number, **fields)

    def step(self, number: int) -> Step:
        """The step with this number in the simulation; InputError names its neighbours where there is none."""
        return self[self._file.index_of(_integer(number, "number", _LARGEST_STEP))]


def load(path: Any) -> Any:
    """Reads a problem, or a file of captured steps.

    Args:
        path: a problem file (JSON, Siconos' dense text or a Matrix Market pair), "F.scenes#120" for step 120 of a
            simulation, or "F.scenes" for all its steps.

    Returns:
        A Problem, or `Scenes` for a whole file of steps.

    Raises:
        InputError: names file, field and cause.
    """
    _require_readers("load")
    name = _path(path)
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
        every: `wants_next` returns True at the first of every so many calls.

    Raises:
        InputError: the file cannot be written, or step_length is not finite.
    """

    def __init__(self, path: Any, scene: str = "recorded", *, engine: str = "", engine_version: str = "",
                 step_length: float | None = None, every: int = 1) -> None:
        _require_readers("Recorder")
        self._every = _integer(every, "every")
        if self._every < 1:
            raise InputError(f"every is {every}, expected at least 1")
        for name, value in (("scene", scene), ("engine", engine), ("engine_version", engine_version)):
            if not isinstance(value, str):
                raise TypeError(f"{name}: expected a text, got {type(value).__name__}")
        length = None if step_length is None else _number(step_length, "step_length")
        self._writer: Any = _native.ScenesWriter(_path(path), scene, engine, engine_version, length)
        self._seen, self._last = 0, -1
        self.count = 0  #: steps written

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
        each = Step(captured) if isinstance(captured, Problem) else captured
        number = max(self._seen - 1, self._last + 1) if step is None else _integer(step, "step", _LARGEST_STEP)
        fields = {name: getattr(each, name) for name in ("time", "gap", "contact_ids", "impulses", "velocity")}
        self._writer.add(number, each.problem._data, fields)
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


def _pairs(tangent_impulses: np.ndarray) -> np.ndarray:
    """(nc, 2) impulses along both tangents as the four of a pyramid's directions, one contact after the other."""
    return np.hstack([np.maximum(tangent_impulses, 0), np.maximum(-tangent_impulses, 0)]).ravel()
