"""Contacts that an engine left out, and what their absence does to the motion."""

from __future__ import annotations

import copy
import ctypes
import dataclasses
from typing import Any

import numpy as np

from ._files import Step
from ._native import InputError
from ._problem import Problem
from ._solve import Answer, _problem, solve

_RUNS_INTO = 1e-3  # [m/s] at which a motion goes through a contact that has no impulse
_NO_IMPULSE = "no impulse"


@dataclasses.dataclass(frozen=True)
class Audit:
    """Which contacts of a step were solved, and which would act and were not. Causes: "limit", too little memory or too
    few rows for them; "margin", they were too far apart to be found and close within the step; "excluded", their pair is
    taken out of the collisions, although both collide; "no impulse", the engine's answer has none there and its motion
    runs into them: it dropped them, or its solver had not come to them yet, as after few sweeps."""

    found: int  #: contacts
    solved: int  #: those of them that the engine solved
    missing: dict[str, list[str]]  #: by cause the names of contacts, and of bounded rows, that would act
    #: by cause the largest change at any contact or bounded row if these were solved [m/s, rad/s]
    velocity_error: dict[str, float]

    def __str__(self) -> str:
        lines = [f"{self.solved} of {self.found} contacts solved"]
        for cause, names in self.missing.items():
            more = f" and {len(names) - 5} more" if len(names) > 5 else ""
            what = "that the motion runs into" if cause == _NO_IMPULSE else "missing"
            lines.append(f"{cause}: {len(names)} {what}, {self.velocity_error[cause]:.3g} m/s: "
                         f"{', '.join(names[:5])}{more}")
        return "\n".join(lines)


def _matrix(J: Any) -> np.ndarray:
    return np.asarray(J.toarray() if hasattr(J, "toarray") else J)


def _rows_part(rows: Any, kept: np.ndarray) -> Any:
    """These bounded rows alone, none of which bounds another."""
    if rows is None or kept.all():
        return rows
    part = {key: [each for each, stays in zip(rows[key], kept) if stays]
            for key in ("lower", "upper", "b", "compliance", "unit", "names")}
    return {"R": _matrix(rows["R"])[:, kept], **part}


def _part(problem: Problem, kept: np.ndarray, kept_rows: np.ndarray) -> Problem:
    """The same bodies with these contacts and bounded rows alone."""
    edges = np.asarray(problem.edges, dtype=int)
    columns, twice = np.repeat(kept, edges), np.repeat(kept, 2)
    inertia = {"Ginv": problem.Ginv} if problem.G is None else {"G": problem.G}
    return Problem(**inertia, N=problem.N[:, kept], D=problem.D[:, columns], edges=edges[kept], mu=problem.mu[kept],
                   v=problem.v, b=problem.b[kept], compliance_n=problem.compliance_n[kept],
                   compliance_t=problem.compliance_t[kept], offset_t=problem.offset_t[twice], rows=_rows_part(problem.rows, kept_rows),
                   name=problem.name)


def _change(problem: Problem, dv: np.ndarray) -> float:
    """The largest change along a normal, a direction of friction or a bounded row; dv of the problem's coordinates."""
    J = [problem.N, problem.D] + ([] if problem.rows is None else [problem.rows["R"]])
    return float(np.abs(np.concatenate([each.T @ dv for each in J])).max(initial=0.0))


def _solved(problems: list[Problem | Step], solver: str = "auto") -> list[Answer]:
    answers = solve(problems, solver)
    for each in answers:
        if each.claim != "solved":
            raise InputError(f"problem: auto says {each.claim}")
    return answers


def audit(problem: Problem | Step, solved: Any = None) -> Audit:
    """Says what the contacts that an engine did not solve would have changed, from arrays of any engine.

    MJWarp and Newton keep contacts beyond `nconmax`, and rows beyond `njmax`, out of their solver. Build the problem of
    all contacts that they found, with `Problem.from_scene` from points, normals and distances (b = distance / step
    length), and say which of them were solved. Two solves by `auto`; contacts that have no impulse in its answer, because
    they separate, are not missing.

    Args:
        problem: a Problem of contacts, or a Step.
        solved: (nc,) booleans: which contacts the engine's solver got. None: all but those without an impulse in the
            step's own answer that its motion runs into at more than 1 mm/s.

    Returns:
        An `Audit`: its cause is "limit", and without `solved` it is "no impulse".

    Raises:
        InputError: solved has another shape, or is None and the problem has no impulses of an engine; or `auto` does not
            solve the problem.
    """
    whole = _problem(problem)
    names = whole._contact_names or [f"contact {i}" for i in range(whole.nc)]
    cause = _NO_IMPULSE if solved is None else "limit"
    if solved is None:
        if whole.engine_impulses is None:
            raise InputError("solved: is None, and the problem has no impulses of an engine")
        from . import _native

        z = np.asarray(_native.complete_answer(whole._data, whole.engine_impulses, "pyramid",
                                                whole.engine_row_impulses))
        own = problem.velocity if isinstance(problem, Step) else None
        own = whole._data.velocity(z) if own is None else np.asarray(own)
        solved = (z[: whole.nc] != 0) | ~(whole.N.T @ own + whole.b < -_RUNS_INTO)
    solved = np.asarray(solved)
    if solved.shape != (whole.nc,) or solved.dtype != bool:
        raise InputError(f"solved has shape {solved.shape} of {solved.dtype}, expected ({whole.nc},) of bool")
    return _missing(whole, names, cause, solved, np.full(0 if whole.rows is None else len(whole.rows["unit"]), True))


def _missing(whole: Problem, names: list[str], cause: str, solved: np.ndarray, solved_rows: np.ndarray) -> Audit:
    if solved.all() and solved_rows.all():
        return Audit(whole.nc, whole.nc, {}, {})
    with_all, without = _solved([whole, _part(whole, solved, solved_rows)], "auto{impulses=even}")
    left = [names[i] for i in np.flatnonzero(~solved & (with_all.normal_impulses > 0))]
    left += [whole.rows["names"][i] for i in np.flatnonzero(~solved_rows & (with_all.row_impulses != 0))]
    if not left:
        return Audit(whole.nc, int(solved.sum()), {}, {})
    return Audit(whole.nc, int(solved.sum()), {cause: left},
                 {cause: _change(whole, with_all.velocity - without.velocity)})


def _arena_place() -> int:
    """Where a model keeps the size of its arena, which no call sets: in units of 8 bytes."""
    import mujoco

    sizes = 1234567, 7654321
    tiny = [mujoco.MjModel.from_xml_string(f'<mujoco><size memory="{size}"/></mujoco>') for size in sizes]
    first, second = (np.frombuffer(ctypes.string_at(each._address, 2048), np.uint64) for each in tiny)
    at = np.flatnonzero((first == sizes[0]) & (second == sizes[1]))
    if len(at) != 1:
        raise InputError("audit: this MuJoCo keeps the size of its memory at another place")
    return int(at[0])


def _forward(model: Any, state: np.ndarray) -> tuple[Any, bool]:
    """The step's data, and whether contacts or rows were dropped."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, int(mujoco.mjtState.mjSTATE_INTEGRATION))
    mujoco.mj_forward(model, data)
    full = mujoco.mjtWarning.mjWARN_CONTACTFULL, mujoco.mjtWarning.mjWARN_CNSTRFULL
    return data, any(data.warning[int(each)].number > 0 for each in full)


def _roomy(model: Any, state: np.ndarray) -> tuple[Any, Any]:
    """A copy of the model whose memory holds all contacts of the state, and its data."""
    roomy, place = copy.copy(model), _arena_place()
    size = ctypes.c_uint64.from_address(roomy._address + 8 * place)
    while True:
        data, dropped = _forward(roomy, state)
        if not dropped:
            return roomy, data
        size.value = max(8 * size.value, 1 << 25)


def _reach(model: Any, data: Any) -> float:
    """How far two geometries may come closer within the step [m]."""
    import mujoco

    fastest, velocity = 0.0, np.zeros(6)
    for geom in range(model.ngeom):
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_GEOM, geom, velocity, 0)
        fastest = max(fastest, np.linalg.norm(velocity[3:]) + np.linalg.norm(velocity[:3]) * model.geom_rbound[geom])
    h = float(model.opt.timestep)
    return 2 * h * float(fastest + h * np.linalg.norm(model.opt.gravity))


def of_mujoco(model: Any, data: Any, *, njmax: int | None = None, nconmax: int | None = None) -> Audit:
    """Which contacts of the next step MuJoCo solves, which are missing, and what these would change.

    Takes copies of the step from the state of the data: as it is; with memory for all contacts; with margins that reach
    as far as anything moves within the step; and with the pairs that bit masks, `<exclude>` and the flag `contact` take
    out, but not parents with their children, nor geometries that collide with nothing. Contacts of the last two are
    missing where they would get an impulse. Up to four problems, as `capture` has them, are solved by `auto`.

    Args:
        model, data: an MjModel and its MjData.
        njmax, nconmax: limits on rows and contacts, as MJWarp has them: the first ones are solved. MuJoCo itself has
            the memory of `<size memory=""/>` alone, and where that does not suffice it drops every constraint.

    Returns:
        An `Audit`.

    Raises:
        InputError: as those of `capture`; or `auto` does not solve a problem.
    """
    import mujoco

    from .mujoco import _check_pair, capture

    _check_pair(model, data)
    kind = int(mujoco.mjtState.mjSTATE_INTEGRATION)
    state = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    roomy, found = _roomy(model, state)
    whole = capture(roomy, found, stepped=False)
    names = whole.contact_ids or []
    own, dropped = _forward(model, state)
    row_names = [] if whole.problem.rows is None else whole.problem.rows["names"]
    kept, kept_rows = np.full(len(names), True), np.full(len(row_names), True)
    if dropped:
        step = capture(model, own, stepped=False)
        kept = np.isin(names, step.contact_ids)
        kept_rows = np.isin(row_names, [] if step.problem.rows is None else step.problem.rows["names"])
    contacts = np.flatnonzero(found.contact.efc_address >= 0)
    ends = np.append(found.contact.efc_address[contacts], found.nefc)[1:]
    if njmax is not None:  # bounded rows come first; of equality constraints those that repeat others are no rows
        kept &= ends <= njmax
        kept_rows &= np.arange(len(row_names)) + found.ne + found.nf + found.nl - len(row_names) < njmax
    if nconmax is not None:
        kept &= contacts < nconmax
    result, before = _missing(whole.problem, names, "limit", kept, kept_rows), None
    for cause in ("margin", "excluded"):
        other = copy.copy(roomy)
        if cause == "margin":
            other.geom_gap[:], other.pair_gap[:] = 0, 0
            for margin in (other.geom_margin, other.pair_margin, other.body_margin):  # of bodies: its broad phase asks
                np.maximum(margin, _reach(roomy, found), out=margin)
        else:
            collides = (other.geom_contype | other.geom_conaffinity) != 0
            other.geom_contype[collides] = other.geom_conaffinity[collides] = 1
            other.exclude_signature[:] = 0
            other.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        step = capture(other, _roomy(other, state)[1], stepped=False)
        answer = _solved([step], "auto{impulses=even}")[0]
        acting = [each for each, f in zip(step.contact_ids or [], answer.normal_impulses) if f > 0 and each not in names]
        if acting:
            before = _solved([whole])[0] if before is None else before
            result.missing[cause] = acting
            result.velocity_error[cause] = _change(step.problem, answer.velocity - before.velocity)
    return result
