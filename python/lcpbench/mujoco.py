"""Contacts of a MuJoCo simulation (PyPI's `mujoco`, 3.1 or later).

    mujoco.mj_step(model, data)
    step = lcpbench.mujoco.capture(model, data)
    answer = lcpbench.solve(step.problem)

MuJoCo softens contacts on purpose. The problem is that of hard contacts, in which none of them gives way, or with
`soft=True` the one that MuJoCo itself solves. Its coordinates are MuJoCo's velocities `qvel`; those of hard contacts
leave out what equality constraints take away.
"""

from __future__ import annotations

import copy
import ctypes
import pathlib
import warnings
from typing import Any, Iterable

import numpy as np
from scipy.sparse import csr_matrix

from . import _files, _native
from ._files import Step, _pairs
from ._native import InputError
from ._problem import Problem

__all__ = ["Recorder", "capture"]


def _dense_rows(model: Any, data: Any) -> np.ndarray:
    """efc_J as (nefc, nv)."""
    import mujoco

    nv, nefc = model.nv, data.nefc
    if not mujoco.mj_isSparse(model):
        return np.array(data.efc_J).ravel()[: nefc * nv].reshape(nefc, nv)  # room for rows of zeros is left behind them
    ends = np.concatenate([[0], np.cumsum(data.efc_J_rownnz)])  # rows follow each other without gaps
    values, columns = (np.asarray(each).ravel()[: ends[-1]] for each in (data.efc_J, data.efc_J_colind))
    return csr_matrix((values, columns, ends), shape=(nefc, nv)).toarray()


def _full_inertia(model: Any, data: Any) -> np.ndarray:
    import mujoco

    M = np.zeros((model.nv, model.nv))
    try:
        mujoco.mj_fullM(model, M, data.qM)
    except (AttributeError, TypeError):  # from 4.0 on
        mujoco.mj_fullM(model, data, M)
    return M


def _step_inertia(model: Any, data: Any) -> np.ndarray:
    """G of G dv = h times forces: inertia, and the damping that the step takes implicitly."""
    import mujoco

    kind, h = model.opt.integrator, model.opt.timestep
    M = _full_inertia(model, data)
    disabled = model.opt.disableflags
    damped = not disabled & getattr(mujoco.mjtDisableBit, "mjDSBL_DAMPER", mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    if kind == mujoco.mjtIntegrator.mjINT_EULER:
        if damped and not disabled & mujoco.mjtDisableBit.mjDSBL_EULERDAMP:
            if np.any(getattr(model, "dof_dampingpoly", 0)) or np.any(getattr(model, "actuator_dampingpoly", 0)):
                raise InputError("capture: damping that is not linear in the velocity (dampingpoly) is outside")
            of_joints = np.zeros(model.njnt)
            if hasattr(model, "actuator_damping"):  # from 4.0 on; that of tendons is explicit
                on = np.asarray(model.actuator_trntype) <= int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
                np.add.at(of_joints, model.actuator_trnid[on, 0],
                          model.actuator_gear[on, 0] ** 2 * model.actuator_damping[on])
            M[np.diag_indices_from(M)] += h * (model.dof_damping + of_joints[model.dof_jntid])
    elif kind == mujoco.mjtIntegrator.mjINT_IMPLICITFAST:
        layout = model if hasattr(model, "D_rownnz") else data  # of data before 3.3
        counts = np.asarray(layout.D_rownnz)
        rows = np.repeat(np.arange(model.nv), counts)
        derivative = np.zeros_like(M)
        derivative[rows, np.asarray(layout.D_colind)] = np.asarray(data.qDeriv)
        M -= h * 0.5 * (derivative + derivative.T)
    else:
        name = mujoco.mjtIntegrator(kind).name
        raise InputError(f"capture: the integrator {name} is outside; use Euler or implicitfast")
    return M


def _blocks(model: Any, G: np.ndarray) -> list[np.ndarray]:
    """G by kinematic trees, where nothing couples two of them."""
    ends = [0, *np.flatnonzero(np.diff(model.dof_treeid)) + 1, model.nv]
    blocks = [G[a:b, a:b] for a, b in zip(ends, ends[1:])]
    return blocks if sum(np.count_nonzero(each) for each in blocks) == np.count_nonzero(G) else [G]


def _solve(blocks: list[np.ndarray], forces: np.ndarray) -> np.ndarray:
    ends = np.cumsum([0, *map(len, blocks)])
    return np.concatenate([np.linalg.solve(G, forces[a:b]) for G, a, b in zip(blocks, ends, ends[1:])])


def _columns(rows: np.ndarray) -> Any:
    """The transpose, a sparse matrix if it has more than 2^14 entries."""
    return csr_matrix(rows).T.tocsc() if rows.size > 1 << 14 else rows.T


def _numbered(names: Iterable[str]) -> list[str]:
    """Each name with its number among its equals."""
    seen: dict[str, int] = {}
    result = []
    for name in names:
        seen[name] = seen.get(name, -1) + 1
        result.append(f"{name}-{seen[name]}")
    return result


def _row_ids(model: Any, data: Any, rows: Iterable[int]) -> list[str]:
    """The two geometries of a contact's row, or the joint or tendon at its limit, by name or else by index, with their
    number."""
    import mujoco

    constraint = mujoco.mjtConstraint
    limits = {int(constraint.mjCNSTR_LIMIT_JOINT): "joint", int(constraint.mjCNSTR_LIMIT_TENDON): "tendon"}

    def of(kind: str, index: int) -> str:
        return mujoco.mj_id2name(model, getattr(mujoco.mjtObj, "mjOBJ_" + kind.upper()), int(index)) or str(index)

    geoms = np.asarray(data.contact.geom).reshape(-1, 2)

    def name(row: int) -> str:
        kind, index = limits.get(int(data.efc_type[row])), data.efc_id[row]
        return f"{kind}-{of(kind, index)}" if kind else "-".join(of("geom", each) for each in geoms[index][::-1])

    return _numbered(map(name, rows))


def _contact_rows(model: Any, data: Any, J: np.ndarray) -> tuple[Any, ...]:
    """Contacts, and limits of joints and tendons, as rows over qvel: N, two tangents for each row of N (zero without
    friction), mu, gap, normal and tangential forces, ids. Warns of what is left out."""
    import mujoco

    constraint = mujoco.mjtConstraint
    force, types = np.asarray(data.efc_force), np.asarray(data.efc_type)
    contact = data.contact
    address, dims = np.asarray(contact.efc_address).ravel(), np.asarray(contact.dim).ravel()
    kept = np.flatnonzero(address >= 0)
    at, dim = address[kept], dims[kept]
    friction = np.asarray(contact.friction).reshape(-1, 5)[kept]
    count, nv = len(kept), model.nv
    N, T = np.zeros((count, nv)), np.zeros((2 * count, nv))
    fn, ft = np.zeros(count), np.zeros((count, 2))
    mu = np.where(dim >= 3, friction[:, 0], 0.0)
    flat, pyramid = dim == 1, (dim > 1) & (types[at] == constraint.mjCNSTR_CONTACT_PYRAMIDAL)
    elliptic = (dim > 1) & ~pyramid
    ratio = np.divide(friction[:, 1], friction[:, 0], out=np.ones(count), where=friction[:, 0] > 0)
    for rows in (flat, elliptic):
        N[rows], fn[rows] = J[at[rows]], force[at[rows]]
    N[pyramid] = 0.5 * (J[at[pyramid]] + J[at[pyramid] + 1])
    for d in sorted(set(dim[pyramid])):
        of_dim = pyramid & (dim == d)
        fn[of_dim] = force[at[of_dim][:, None] + np.arange(2 * (d - 1))].sum(axis=1)
    for k in range(2):  # the second tangent is scaled, so that one mu is the friction along both
        scale = np.ones(count) if k == 0 else ratio
        for rows in (np.flatnonzero(elliptic), np.flatnonzero(pyramid)):
            if len(rows) == 0:
                continue
            first = at[rows] + (1 + k if elliptic[rows[0]] else 2 * k)
            m = friction[rows, k]
            if elliptic[rows[0]]:
                row, along = J[first], force[first]
            else:
                row, along = (J[first] - J[first + 1]) / (2 * m[:, None]), m * (force[first] - force[first + 1])
            T[2 * rows + k] = scale[rows, None] * row
            ft[rows, k] = np.divide(along, scale[rows], out=np.zeros(len(rows)), where=scale[rows] > 0)
    outside = [f"{what}, which is left out" for what, there in (
        ("contacts have torsional friction (condim 4 or 6)", np.any(dim >= 4)),
        ("contacts have rolling friction (condim 6)", np.any(dim >= 6)),
        ("contacts have a velocity of their surface", np.any(getattr(contact, "surfacevel", 0)))) if there]
    for each in outside:
        warnings.warn(f"lcpbench.mujoco.capture: {each}", stacklevel=3)
    limits = np.flatnonzero((types == constraint.mjCNSTR_LIMIT_JOINT) | (types == constraint.mjCNSTR_LIMIT_TENDON))
    ids = _row_ids(model, data, [*at, *limits])
    none = np.zeros((len(limits), 2))
    gap = np.concatenate([np.asarray(contact.dist).ravel()[kept], np.asarray(data.efc_pos)[limits]])
    return (np.vstack([N, J[limits]]), np.vstack([T, np.zeros((2 * len(limits), nv))]),
            np.concatenate([mu, none[:, 0]]), gap, np.concatenate([fn, force[limits]]), np.vstack([ft, none]), ids)


def _velocity_before(model: Any, data: Any) -> np.ndarray:
    """qvel as the step began, from the bodies' velocities cvel of that time."""
    relative, before = data.cvel - data.cvel[model.body_parentid], np.zeros(model.nv)
    for body in np.unique(model.dof_bodyid):
        dofs = model.dof_bodyid == body
        before[dofs] = np.linalg.lstsq(data.cdof[dofs].T, relative[body], rcond=None)[0]
    return before


def _soft_step(model: Any, data: Any, J: np.ndarray, stepped: bool, name: str) -> Step:
    """The convex problem of MuJoCo [Todorov 2014], as `lcpbench capture --soft` writes it: with the acceleration a, the
    force f of each edge of a pyramid and of each limit asks that J a - efc_aref + R f >= 0."""
    import mujoco

    types = np.asarray(data.efc_type)
    if model.opt.noslip_iterations > 0:
        raise InputError("capture: soft=True takes models without noslip_iterations: they change the answer of "
                         "MuJoCo's solver to one of no convex problem; set them to 0")
    if np.any(types == mujoco.mjtConstraint.mjCNSTR_CONTACT_ELLIPTIC):
        raise InputError("capture: soft=True takes MuJoCo's pyramidal friction cones; this model has elliptic ones")
    h, M = model.opt.timestep, _full_inertia(model, data)
    force, R, equal = np.asarray(data.efc_force), np.asarray(data.efc_R), slice(data.ne)
    lost = slice(data.ne, data.ne + data.nf)  # friction of joints and tendons, as the force that MuJoCo found
    before = _velocity_before(model, data) if stepped else np.array(data.qvel)
    target = J @ before + h * np.asarray(data.efc_aref)
    momentum = M @ before + h * (np.asarray(data.qfrc_smooth) + J[lost].T @ force[lost])
    momentum += J[equal].T @ (target[equal] / R[equal])
    blocks = _blocks(model, M + (J[equal].T / R[equal]) @ J[equal])
    rows = range(data.ne + data.nf, data.nefc)
    ids = _row_ids(model, data, rows)
    kept = slice(rows.start, None)
    problem = Problem(G=blocks, N=_columns(J[kept]), v=_solve(blocks, momentum), b=-target[kept], compliance_n=R[kept],
                      name=name, validate=False)
    return Step(problem, time=float(data.time), gap=np.array(data.efc_pos)[kept], contact_ids=ids,
                impulses=h * force[kept], velocity=before + h * np.asarray(data.qacc))


def capture(model: Any, data: Any, *, soft: bool = False, stepped: bool | None = None, name: str = "mujoco") -> Step:
    """The contacts of the step that MuJoCo has just taken, or that it will take next.

    Contacts keep condim 1 (no friction) and 3; of condim 4 and 6 torsional and rolling friction are left out, and a
    warning says so. Two different coefficients along a contact's tangents are kept: the second direction is scaled.
    Limits of joints and tendons are contacts without friction. Friction of joints (frictionloss) acts as the force that
    MuJoCo found. Gyroscopic torques, which MuJoCo 4's implicitfast takes implicitly, act as if no contact changed them.

    Args:
        model, data: an MjModel and its MjData, after `mj_step`, or after `mj_forward`.
        soft: the convex problem that MuJoCo itself solves, for pyramidal cones: each edge of a pyramid, and each limit,
            is a contact without friction that has the compliance efc_R, and soft equality constraints are part of the
            inertia. `check` then says how well MuJoCo solved its own model. Its velocity is that of MuJoCo's
            acceleration, before an integrator takes damping implicitly.
        stepped: True: after `mj_step`. None: found from the velocities.
        name: of the problem.

    Returns:
        A `Step`, with MuJoCo's own impulses, and its velocity after `mj_step`, with soft=True always. Unless soft=True,
        an open gap may close within the step, penetration is not pushed out, and equality constraints hold exactly,
        without MuJoCo's correction.

    Raises:
        InputError: the integrator is not Euler or implicitfast, damping is not linear, or soft=True and cones are
            elliptic or the model has noslip_iterations.
    """
    import mujoco

    h, J = model.opt.timestep, _dense_rows(model, data)
    if stepped is None:  # the bodies' velocities cvel are those before the step
        found = data.cvel[model.body_parentid]
        np.add.at(found, model.dof_bodyid, data.cdof * np.asarray(data.qvel)[:, None])
        stepped = not np.allclose(found, data.cvel, rtol=1e-9, atol=1e-12)
    after = data
    if not stepped:  # qDeriv, too, is of the step
        after = copy.copy(data)
        implicit = model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        (mujoco.mj_implicit if implicit else mujoco.mj_Euler)(model, after)
    G, qvel = _step_inertia(model, after), np.array(after.qvel)
    if soft:
        return _soft_step(model, data, J, stepped, name)
    N, T, mu, gap, fn, ft, ids = _contact_rows(model, data, J)
    own = N.T @ fn + T.T @ ft.ravel()
    blocks = _blocks(model, G)
    v = qvel - h * _solve(blocks, own)  # the velocity without the contacts' forces
    columns = [_columns(N), _columns(T)]
    if data.ne:  # coordinates in which the equality constraints hold
        # MuJoCo lets a chain come apart a little: rows that say the same then differ a little.
        # Each constraint in units of its longest row: one of small coefficients is no copy of another.
        lengths, equality = np.linalg.norm(J[: data.ne], axis=1), np.asarray(data.efc_id)[: data.ne]
        longest = np.array([lengths[equality == each].max() for each in equality])[:, None]
        least = max(1e-8 * lengths.max(), np.finfo(float).tiny)  # the rows of one that holds anyway are rounding
        _, s, V = np.linalg.svd(J[: data.ne] / np.maximum(longest, least))
        Z = V[int(np.count_nonzero(s > 1e-2 * s[0])) :].T
        reduced = Z.T @ G @ Z
        v, qvel = (np.linalg.solve(reduced, Z.T @ (G @ each)) for each in (v, qvel))
        blocks, columns = [reduced], [(N @ Z).T, (T @ Z).T]
    problem = Problem(G=blocks, N=columns[0], tangents=columns[1], mu=mu, v=v, b=np.maximum(gap, 0) / h, name=name,
                      validate=False)
    impulses = np.concatenate([h * fn, _pairs(h * ft[mu > 0])])
    return Step(problem, time=float(data.time), gap=gap, contact_ids=ids, impulses=impulses,
                velocity=qvel if stepped else None)


class Recorder(_files.Recorder):
    """Records steps at the price of a copy of MuJoCo's state in each. It takes them once more, and writes their
    contacts, when it is closed:

        with lcpbench.mujoco.Recorder("walk.scenes", model, data, every=10) as recorder:
            while running:
                recorder.before_step()
                mujoco.mj_step(model, data)

    Until then it holds `mj_stateSize` numbers of each step that it keeps, and a program that is killed loses them.
    Callbacks that move the simulation on, and a model that changes meanwhile, are outside: `lcpbench.Recorder` with
    `capture` takes them.

    Args:
        path, scene, every: as those of `lcpbench.Recorder`.
        model, data: an MjModel and its MjData.
        soft: as that of `capture`.

    Raises:
        InputError: the file cannot be written, or, when it is closed, as those of `capture`.
    """

    def __init__(self, path: Any, model: Any, data: Any, scene: str = "recorded", *, every: int = 1,
                 soft: bool = False) -> None:
        import mujoco

        super().__init__(path, scene, engine="MuJoCo", engine_version=mujoco.mj_versionString(),
                         step_length=model.opt.timestep, every=every)
        self._model, self._of, self._soft = model, data, soft
        self._state = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        # mj_getState of the library that is loaded: a step may take 20 us, and a call of Python's takes one of them.
        library = ctypes.CDLL(str(next(pathlib.Path(mujoco.__file__).parent.glob("libmujoco.*"))))
        get = ctypes.cast(library.mj_getState, ctypes.c_void_p).value
        self._states = _native.States(get, model._address, data._address, self._state,
                                      mujoco.mj_stateSize(model, self._state), self._every)

    def before_step(self) -> None:
        """Counts a step that `mj_step` takes next, and keeps its state if it is one to keep."""
        if self._writer is None:
            raise RuntimeError("Recorder: is closed")
        self._states.before_step()

    def close(self) -> None:
        """Takes the steps that were kept, writes them, and ends the file."""
        import mujoco

        states = self._states.take()
        data = mujoco.MjData(self._model) if states else None
        for i, state in enumerate(states):
            mujoco.mj_setState(self._model, data, state, self._state)
            mujoco.mj_step(self._model, data)
            self.add(capture(self._model, data, soft=self._soft, stepped=True), i * self._every)
        super().close()
