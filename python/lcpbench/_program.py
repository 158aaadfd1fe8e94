"""Solvers: the package's own, and those of other libraries in the installed program `lcpbench`."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import shutil
import subprocess
import tempfile
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._native import InputError
from ._problem import _did_you_mean

if TYPE_CHECKING:
    from ._files import Step
    from ._problem import Problem
    from ._solve import Answer


@dataclasses.dataclass(frozen=True)
class Solver:
    """A solver that `solve` takes by name."""

    name: str
    summary: str
    friction: bool  #: False: contacts without friction only
    library: str  #: "native", or the library that the program reaches
    unavailable: str  #: why it cannot run; "" where it can
    settings: dict[str, str]  #: name -> default


def find_program() -> str | None:
    """The program `lcpbench`: the environment's LCPBENCH_PROGRAM, that of the wheel, or the one in PATH; or None."""
    inside = os.path.join(os.path.dirname(__file__), "bin", "lcpbench")
    return os.environ.get("LCPBENCH_PROGRAM") or (inside if os.path.exists(inside) else shutil.which("lcpbench"))


def is_native(spec: str) -> bool:
    """Whether a solver runs in this process. @raises InputError for names that nobody knows."""
    name, known = spec.split("{")[0], [each[0] for each in _native.solvers()]
    if name not in known and find_program() is None:
        raise InputError(f"solver: unknown '{name}'{_did_you_mean(name, known)}; known: {', '.join(known)}; the solvers "
                         "of other libraries need the program lcpbench in PATH or in LCPBENCH_PROGRAM")
    return name in known


def _run(arguments: list[str]) -> Any:
    program = find_program() or "lcpbench"
    try:
        result = subprocess.run([program, *arguments, "--format", "json"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise InputError(f"{program}: {error.strerror}") from None
    if result.returncode not in (0, 1) or not result.stdout:
        raise InputError((result.stderr.strip().splitlines() or [f"{program} ended with {result.returncode}"])[-1])
    return json.loads(result.stdout)


@functools.lru_cache(maxsize=4)
def _of_program(program: str) -> list[Solver]:
    return [Solver(each["name"], each["summary"], not each["frictionless_only"], each["library"], each["reason"],
                   {setting["name"]: setting["default"] for setting in each["settings"]})
            for each in _run(["solvers"]) if each["library"] != "native"]


def available_solvers() -> list[Solver]:
    """Every solver that `solve` knows here: the package's own, and those of other libraries in the installed program.

    Those that cannot run say why in `unavailable`.
    """
    own = [Solver(*fields) for fields in _native.solvers()]
    program = find_program()
    return own + (_of_program(program) if program is not None else [])


@dataclasses.dataclass(frozen=True)
class Certificate:
    """What exact arithmetic proves of a problem. True in an `if` where it has a solution."""

    certificate: str  #: "solution", "unsolvable" or "open"
    proof: str  #: "exact_basis", "lp", "farkas" or "every_basis"; "" where open
    z: np.ndarray | None  #: (n,): the solution that was certified, rounded
    velocity: np.ndarray | None  #: (ngc,): its velocity after the step
    velocity_unique: bool | None  #: whether every solution has this velocity; None: not known
    farkas: np.ndarray | None  #: the vector of a proof "farkas" or "lp"

    def __bool__(self) -> bool:
        return self.certificate == "solution"


def certify(problem: Problem | Step, *, time_limit: float = 10.0) -> Certificate:
    """Proves in exact arithmetic whether a problem has a solution, by the program's command `certify`.

    Args:
        problem: a Problem or a Step.
        time_limit: [s], after which it is "open".

    Returns:
        A `Certificate`.

    Raises:
        InputError: there is no program, which wheels have inside, and builds of the source; or it refuses the problem.
    """
    from ._solve import _limit, _problem

    if find_program() is None:
        raise InputError("certify: needs the program lcpbench, in PATH or named by LCPBENCH_PROGRAM; wheels have it inside")
    limit = min(_limit(time_limit), 1e7)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "problem.json")
        _native.write_problem(_problem(problem)._data, file)
        row = _run(["certify", file, "--time-limit", str(limit)])[0]
    z, velocity, farkas = (None if row[key] is None else np.array(row[key], dtype=float)
                           for key in ("z", "velocity", "farkas"))
    return Certificate(row["certificate"], row["proof"] or "", z, velocity, row["velocity_unique"], farkas)


def solve_by_program(problems: list[Problem], solver: str, time_limit: float) -> list[Answer]:
    """Solves by a solver of another library. The verdict is taken here, as that of every answer."""
    from ._files import Recorder
    from ._solve import Answer

    answers = []
    with tempfile.TemporaryDirectory() as folder:
        for problem in problems:
            file = os.path.join(folder, "problem.json")
            if problem.engine_impulses is None:
                _native.write_problem(problem._data, file)
            else:  # for the solver `engine`
                engine = "MuJoCo" if problem._engine_model else ""  # judged by its own friction
                with Recorder(os.path.join(folder, "problem.scenes"), engine=engine) as recorder:
                    recorder.add(problem, 0)
                file = os.path.join(folder, "problem.scenes#0")
            limit = min(max(time_limit, 1e-6), 1e7)  # what the program takes
            rows = _run(["solve", file, "--solver", solver, "--time-limit", str(limit)])
            if not rows:
                raise InputError(f"solver: '{solver}' did not start")
            row = rows[0]
            z = np.array(row["z"] if row["z"] is not None else [], dtype=float)
            count = row["counters"]
            work = [-1 if count[key] is None else count[key] for key in ("iterations", "pivots", "factorizations")]
            velocity = None if row["errors"]["velocity_mismatch"] is None else np.array(row["velocity"], dtype=float)
            times = (np.nan if row["time"][key] is None else row["time"][key] for key in ("setup_s", "solve_s"))
            parts = (row["claim"], z, velocity, None, *work, row["detail"], *times, row["impulses"])
            answers.append(Answer(problem, solver, parts, row["model"]))
    return answers
