"""Solving, and judging answers."""

from __future__ import annotations

import dataclasses
from typing import Any, Iterable, Sequence, overload

import numpy as np

from . import _native, _program
from ._files import Step
from ._native import InputError
from ._problem import Problem, _impulse_rows, _integer, _number


def _problem(value: Any, name: str = "problem") -> Problem:
    problem = value.problem if isinstance(value, Step) else value
    if not isinstance(problem, Problem):
        raise TypeError(f"{name}: expected a Problem or a Step, got {type(value).__name__}")
    return problem


def _text(value: Any, name: str) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, got {type(value).__name__}")
    return value


def _limit(value: Any) -> float:
    limit = float("inf") if value is None else _number(value, "time_limit")
    if not limit > 0:
        raise InputError(f"time_limit is {value!r}, expected seconds > 0")
    return limit


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What an answer is, by code that knows no solver. True in an `if` where the answer is solved."""

    verdict: str  #: "solved", "wrong", "unsolvable", "refused", "missed" or "open"
    residual: float  #: 1 is as bad as no impulses; solved up to 1e-4, of a bare LCP 1e-6, or up to `solved_at`
    worst: str  #: why it is not solved, in words; "" where solved
    worst_row: int  #: of the LCP, counted from 0; -1: none
    model: str  #: "pyramid", "cone" or "convex": the model of friction that it was measured by
    truth: str  #: "solvable", "unsolvable", "nearly" or "unknown": what is known of the problem
    errors: dict[str, float]  #: every measure by name, as `lcpbench solve --format json` has them; NaN: does not apply

    def __bool__(self) -> bool:
        return self.verdict == "solved"

    def __str__(self) -> str:
        return f"{self.verdict}, residual {self.residual:.3g}" + (f": {self.worst}" if self.worst else "")


def _judge(problem: Problem, claim: str, z: np.ndarray, velocity: Any, farkas: Any, model: str, detail: str,
           solved_at: float = 0) -> Verdict:
    return Verdict(*_native.judge(problem._data, claim, z, velocity, farkas, model, detail, problem._contact_names,
                                  solved_at))


def check(problem: Problem | Step, impulses: Any = None, velocity: Any = None, *, row_impulses: Any = None,
          model: str | None = None, solved_at: float | None = None) -> Verdict:
    """Judges an answer, whoever found it, against the data of the problem alone.

    Args:
        problem: a Problem or a Step.
        impulses: an Answer, or float64 or float32 [N s]; one of z of (n,); f_N of each contact and then f_D of each
            friction direction, (nc + sum(edges),), to which the least lambda is added; or (nc, 3): each contact's normal
            impulse and its impulses along both tangents, which are the directions 0 and edges / 4. None: those of the
            engine that the step was captured from. Those of bounded rows stand at the end of z, and of f_N and f_D.
        velocity: (ngc,), optional: the velocity after the step that came with the impulses. It has to be theirs.
        row_impulses: (m,): those of bounded rows [N s, N m s], where impulses does not have them.
        model: "pyramid", the problem's own friction, "cone", the round Coulomb cone around its
            tangents, or "convex", its convex relaxation. None: that of an Answer, or of the engine whose impulses are judged
            (MuJoCo's elliptic cones are convex), else the pyramid.
        solved_at: the largest residual of a solved answer, in (0, 1]; None: 1e-4 of contacts, 1e-6 of a bare LCP.

    Returns:
        A `Verdict`. The answer counts as said solved: "wrong" where it is not.

    Raises:
        InputError: the impulses have none of these shapes, or there are none, the model is unknown, or friction directions have no round
            cone around them: their number is no multiple of 4, or they are no regular polygon.
    """
    problem = _problem(problem)
    if impulses is None:
        if problem.engine_impulses is None:
            raise InputError("impulses: is None, and the problem has no impulses of an engine")
        impulses, model = problem.engine_impulses, model or problem._engine_model
        row_impulses = problem.engine_row_impulses if row_impulses is None else row_impulses
    if isinstance(impulses, Answer):
        velocity = impulses._velocity if velocity is None else velocity
        model = impulses.model if model is None else model
        impulses = impulses._vector()
    model = "pyramid" if model is None else model
    z = _native.complete_answer(problem._data, impulses, _text(model, "model"), row_impulses)
    bound = 0.0 if solved_at is None else _number(solved_at, "solved_at")
    if solved_at is not None and not 0 < bound <= 1:
        raise InputError(f"solved_at is {solved_at!r}, expected a number in (0, 1]")
    return _judge(problem, "solved", z, velocity, None, model, "", bound)


def _frozen(values: np.ndarray) -> np.ndarray:
    """Read-only: the verdict of an answer is that of its numbers."""
    values.flags.writeable = False
    return values


class Answer:
    """What a solver answers. Its verdict is computed when it is asked for. All arrays are read-only.

    Attributes:
        problem: the problem.
        solver: the solver with its settings.
        claim: the solver's own word: "solved", "unsolvable", "iteration_limit", "time_limit", "numerical_failure" or
            "unsupported"; of another library also "crashed".
        z: (n,): f_N, f_D, lambda, f_R; (0,) where the solver gave none: velocity and impulses are InputErrors then.
        detail: the solver's words.
        which_impulses: "even": those that equally stiff contacts would carry, as of "auto{impulses=even}"; "any": any
            of those that give the motion; "": the solver does not tell.
        iterations, pivots, factorizations: work; -1: not known.
        setup_s, solve_s: thread CPU time [s] of loading the problem and of solving it; NaN: not known.
    """

    def __init__(self, problem: Problem, solver: str, parts: Sequence[Any], model: str | None = None) -> None:
        self.problem = problem
        self.solver = solver
        self._model = model
        (self.claim, self.z, self._velocity, self._farkas, self.iterations, self.pivots, self.factorizations,
         self.detail, self.setup_s, self.solve_s, self.which_impulses) = parts
        _frozen(self.z)
        self._verdict: Verdict | None = None

    def _vector(self) -> np.ndarray:
        if len(self.z) != self.problem.size:
            raise InputError(f"{self.solver} gave no impulses: it says {self.claim}")
        return np.asarray(self.z)

    @property
    def model(self) -> str:
        """The model of friction that the solver obeys: "pyramid", "cone" or "convex"."""
        return self._model or _native.friction_of(self.solver)

    @property
    def time(self) -> float:
        """setup_s + solve_s."""
        return float(self.setup_s + self.solve_s)

    @property
    def velocity(self) -> np.ndarray:
        """(ngc,): the velocity after the step [m/s, rad/s]."""
        known = self._velocity
        return _frozen(np.asarray(self.problem._data.velocity(self._vector()) if known is None else known))

    @property
    def normal_impulses(self) -> np.ndarray:
        """(nc,): f_N [N s]."""
        return np.asarray(self._vector()[: self.problem.nc])

    @property
    def friction_impulses(self) -> np.ndarray:
        """(nc, 2): impulses along both tangents of each contact, which are the directions 0 and edges / 4 [N s]."""
        return self.impulses[:, 1:]

    @property
    def impulses(self) -> np.ndarray:
        """(nc, 3): normal and both tangents [N s], as `check` takes them."""
        return _frozen(_impulse_rows(self.problem.edges, self._vector()))

    @property
    def row_impulses(self) -> np.ndarray:
        """(m,): those of the bounded rows [N s, N m s]."""
        return np.asarray(self._vector()[self.problem.size - self.problem._data.row_count :])

    @property
    def check(self) -> Verdict:
        """The verdict with all its measures."""
        if self._verdict is None:
            self._verdict = _judge(self.problem, self.claim, self.z, self._velocity, self._farkas, self.model,
                                   self.detail)
        return self._verdict

    @property
    def verdict(self) -> str:
        """"solved", "wrong", "unsolvable", "refused", "missed" or "open"."""
        return self.check.verdict

    @property
    def residual(self) -> float:
        """The residual that the verdict is taken on."""
        return self.check.residual

    @property
    def worst(self) -> str:
        """The worst contact in words; "" where solved."""
        return self.check.worst

    def __repr__(self) -> str:
        return f"<lcpbench.Answer of {self.solver}: says {self.claim}, is {self.check}, {self.time * 1e6:.3g} us>"

    def _repr_html_(self) -> str:
        from ._picture import answer_html

        return answer_html(self)


@overload
def solve(problem: Problem | Step, solver: str = ..., *, error: float | None = ..., start: Any = ...,
          time_limit: float | None = ..., threads: int = ...) -> Answer: ...
@overload
def solve(problem: Iterable[Problem | Step], solver: str = ..., *, error: float | None = ..., start: Any = ...,
          time_limit: float | None = ..., threads: int = ...) -> list[Answer]: ...


def solve(problem: Problem | Step | Iterable[Problem | Step], solver: str = "auto", *, error: float | None = None,
          start: Any = None, time_limit: float | None = None, threads: int = 1) -> Answer | list[Answer]:
    """Solves one problem, or many in threads without Python's lock. Threads change no bit of an answer. Ctrl-C ends it.

    Args:
        problem: a Problem or a Step, or any number of them.
        solver: a name with settings, such as "auto" or "contact_lemke{precision=quad}": see `available_solvers`.
            Solvers of other libraries run in the installed program `lcpbench`, with one thread.
        error: [m/s], instead of a solver: the largest residual of the round Coulomb cone that is good enough. The
            pyramid is tried by `auto` first, and then the cone. An answer of a larger residual claims nothing.
        start: (n,), or an Answer: a guess at z, for native solvers that use one, and not with error. Of many problems a
            list of these or None.
        time_limit: wall clock of each solve [s]; with error a problem may take two solves.
        threads: how many.

    Returns:
        An Answer, or a list of them in the order of the problems. Numerical trouble is a claim, never an exception.

    Raises:
        InputError: the solver or its settings are unknown, start has another length, or error stands beside them, or
            beside friction directions that name no round cone.
    """
    one = isinstance(problem, (Problem, Step))
    if not one and not isinstance(problem, Iterable):
        raise TypeError(f"problem: expected a Problem or many, got {type(problem).__name__}")
    problems = [_problem(each, f"problem[{i}]") for i, each in enumerate([problem] if one else problem)]
    limit, count = _limit(time_limit), _integer(threads, "threads")
    if count < 1:
        raise InputError(f"threads is {threads!r}, expected at least 1")
    if error is not None:
        if solver != "auto" or start is not None:
            raise InputError("error: stands in place of solver and start, which have to be left out")
        answers = _solve_to(problems, _number(error, "error"), limit, count)
    elif not _program.is_native(_text(solver, "solver")):
        answers = _program.solve_by_program(problems, solver, limit)
    else:
        starts = [None] * len(problems) if start is None else [start] if one or isinstance(start, Answer) else list(start)
        if len(starts) != len(problems):
            raise InputError(f"start has {len(starts)} entries, expected {len(problems)}: one for each problem")
        starts = [each.z if isinstance(each, Answer) else each for each in starts]
        spec = _native.canonical(solver)
        parts = _native.solve([each._data for each in problems], solver, starts, limit, count)
        answers = [Answer(each, spec, part) for each, part in zip(problems, parts)]
    return answers[0] if one else answers


def _solve_to(problems: list[Problem], error: float, limit: float, threads: int) -> list[Answer]:
    if not error > 0:
        raise InputError(f"error is {error!r}, expected m/s > 0")
    for i, problem in enumerate(problems):
        if why := _native.why_no_round_cone(problem._data):
            raise InputError(f"error: problem[{i}] has no round cone to measure by: {why}")
    answers: list[Answer | None] = [None] * len(problems)
    for solver in ("auto", "cone_ipm{cone=true}"):
        left = [i for i, each in enumerate(answers) if each is None or _cone_error(each) > error]
        found = solve([problems[i] for i in left], solver, time_limit=limit, threads=threads)
        for i, answer in zip(left, found):
            best = answers[i]
            if best is None or not _cone_error(answer) > _cone_error(best):
                answers[i] = answer
    for each in answers:
        if each is not None and each.claim == "solved" and not (rest := _cone_error(each)) <= error:
            each.claim, each._verdict = "numerical_failure", None
            each.detail += f"{'; ' if each.detail else ''}the cone's conditions miss {error:g} m/s: {rest:.3g} m/s"
    return [each for each in answers if each is not None]


def _cone_error(answer: Answer) -> float:
    """The residual of the cone's conditions [m/s]; of a problem without friction that of its own."""
    errors = answer.check.errors
    for name in ("model_error_m_per_s", "velocity_residual_m_per_s", "backward_row_norm"):
        if not np.isnan(errors[name]):
            return errors[name]
    return float("inf")


class ContactSolver(_native.ContactSolver):
    """Solves the contacts of one time step after the other: for simulators.

        solver = ContactSolver("auto")
        while running:
            solver.update(problem, ids)
            if solver.solve() == "solved":
                v = solver.velocity

    Args:
        solver: a native solver with its settings.

    Attributes:
        claim, detail, velocity, z, which_impulses: of the last solve, as an `Answer` has them.

    One object per thread: a second one that uses it at the same time gets a RuntimeError. The solve runs without
    Python's lock.
    """

    def __init__(self, solver: str = "auto") -> None:
        super().__init__(_text(solver, "solver"))
        self._model = _native.friction_of(solver)

    def update(self, problem: Problem | Step, ids: Any = None) -> None:
        """The contacts of this step. The next solve starts from the impulses of the last one.

        Args:
            problem: a Problem with contacts, or a Step.
            ids: (nc,) names that contacts keep from step to step, integers from 0 to 2^64 - 1 or texts. Wrong ids cost
                time, never the truth of an answer. None: those of a Step; else the solve starts from nothing.

        Raises:
            InputError: a bare LCP, a problem that the solver does not take, another number of ids, or the same one
                twice. The object stays as it was.
        """
        ids = problem.contact_ids if ids is None and isinstance(problem, Step) else ids
        self._take(_problem(problem)._data, ids, ids is not None)

    @property
    def impulses(self) -> np.ndarray:
        """(nc, 3): normal and both tangents [N s], as `check` takes them."""
        return _impulse_rows(self._current().edges, self.z)

    @property
    def row_impulses(self) -> np.ndarray:
        """(m,): those of the bounded rows [N s, N m s]."""
        return np.asarray(self.z[self._current().size - self._current().row_count :])

    def set_velocity(self, v: Any) -> None:
        """Another velocity for the same contacts and inertia. Args: v, (ngc,) [m/s, rad/s]. Cheaper than `update`."""
        super().set_velocity(v)

    def solve(self, time_limit: float = float("inf")) -> str:
        """Solves what is loaded, in at most time_limit seconds of wall clock; returns the solver's claim."""
        return super().solve(_number(time_limit, "time_limit"))

    def check(self) -> Verdict:
        """The verdict on the last solve, computed now."""
        return _judge(Problem._of(self._current()), self.claim, self.z, self._own_velocity, self._farkas, self._model,
                      self.detail)
