"""Contacts of a MuJoCo simulation (PyPI's `mujoco`, 3.1 or later).

    mujoco.mj_step(model, data)
    step = lcpbench.mujoco.capture(model, data)
    answer = lcpbench.solve(step.problem)

MuJoCo softens contacts on purpose. The problem is that of hard contacts, in which none of them gives way, or with
`soft=True` the one that MuJoCo itself solves. Its coordinates are MuJoCo's velocities `qvel`. Equality constraints, limits
and dry friction of joints and tendons are its bounded rows.
"""

from __future__ import annotations

import contextlib
import copy
import ctypes
import itertools
import pathlib
import sys
import warnings
import weakref
from typing import Any, Iterable, Iterator

import numpy as np
from scipy.sparse import csr_matrix

from . import _files, _native
from ._audit import of_mujoco as audit
from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem

__all__ = ["Recorder", "audit", "capture", "shapes"]


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


def _step_inertia(model: Any, data: Any, notes: _Notes) -> np.ndarray:
    """G of G dv = h times forces: inertia, and the damping that the step takes implicitly."""
    import mujoco

    kind, h = model.opt.integrator, model.opt.timestep
    M = _full_inertia(model, data)
    disabled = model.opt.disableflags
    damped = not disabled & getattr(mujoco.mjtDisableBit, "mjDSBL_DAMPER", mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    if kind == mujoco.mjtIntegrator.mjINT_EULER:
        if damped and not disabled & mujoco.mjtDisableBit.mjDSBL_EULERDAMP:
            for each in ("dof_dampingpoly", "actuator_dampingpoly"):
                notes.add("damping that is not linear in the velocity, as if no contact changed it",
                          np.count_nonzero(np.any(getattr(model, each, np.zeros((0, 1))), axis=1)))
            of_joints = np.zeros(model.njnt)
            if hasattr(model, "actuator_damping"):  # from 4.0 on; that of tendons is explicit
                on = np.asarray(model.actuator_trntype) <= int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
                np.add.at(of_joints, model.actuator_trnid[on, 0],
                          model.actuator_gear[on, 0] ** 2 * model.actuator_damping[on])
            M.flat[:: model.nv + 1] += h * (model.dof_damping + of_joints[model.dof_jntid])
    elif kind != mujoco.mjtIntegrator.mjINT_RK4:
        layout = model if hasattr(model, "D_rownnz") else data  # of data before 3.3
        counts = np.asarray(layout.D_rownnz)
        rows = np.repeat(np.arange(model.nv), counts)
        derivative = np.zeros_like(M)
        derivative[rows, np.asarray(layout.D_colind)] = np.asarray(data.qDeriv)
        M -= h * 0.5 * (derivative + derivative.T)
        uneven = np.abs(derivative - derivative.T) > 1e-12 * np.abs(derivative).max(initial=0.0)
        notes.add("coordinates whose forces' derivative is not symmetric: that part as if no contact changed it",
                  np.count_nonzero(uneven.any(axis=0)))
    return M


class _Fixed:
    """What a model keeps from step to step, found once: `ends` of its kinematic trees' coordinates, the first coordinate
    of each body that has some (`starts`), the names of its geometries and of its bounded rows (`rows`). A geometry
    without a name has that of its body, with its index where the body has others; the last entry is that of a flex, which
    has the index -1."""

    def __init__(self, model: Any) -> None:
        self.starts = np.flatnonzero(np.diff(model.dof_bodyid, prepend=-1))
        self.ends = [0, *(np.flatnonzero(np.diff(model.dof_treeid)) + 1).tolist(), model.nv]
        self.names = [self._name(model, i) for i in range(model.ngeom)] + ["flex"]
        self.rows = _native.mujoco_row_names(model.names, (
            model.name_jntadr, model.name_tendonadr, model.name_eqadr, model.jnt_type, model.jnt_dofadr, model.dof_jntid,
            model.tendon_adr, model.tendon_num, model.wrap_type, model.wrap_objid, model.eq_type, model.eq_obj1id))

    @staticmethod
    def _name(model: Any, index: int) -> str:
        import mujoco

        if name := mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, index):
            return name
        body = int(model.geom_bodyid[index])
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) if body else ""
        return name if name and model.body_geomnum[body] == 1 else f"{name} (geom {index})" if name else f"geom {index}"


_FIXED: weakref.WeakKeyDictionary[Any, _Fixed] = weakref.WeakKeyDictionary()


def _fixed(model: Any) -> _Fixed:
    if model not in _FIXED:
        _FIXED[model] = _Fixed(model)
    return _FIXED[model]


def _blocks(model: Any, G: np.ndarray) -> list[np.ndarray]:
    """G by kinematic trees, where nothing couples two of them."""
    ends = _fixed(model).ends
    blocks = [G[a:b, a:b] for a, b in zip(ends, ends[1:])]
    return blocks if sum(np.count_nonzero(each) for each in blocks) == np.count_nonzero(G) else [G]


def _solve(blocks: list[np.ndarray], forces: np.ndarray) -> np.ndarray:
    if len(blocks) == 1:
        return np.linalg.solve(blocks[0], forces)
    ends = np.cumsum([0, *map(len, blocks)])
    return np.concatenate([np.linalg.solve(G, forces[a:b]) for G, a, b in zip(blocks, ends, ends[1:])])


def _columns(rows: np.ndarray) -> Any:
    """The transpose, a sparse matrix if it has more than 2^14 entries."""
    return csr_matrix(rows).T.tocsc() if rows.size > 1 << 14 else rows.T


def _row_ids(model: Any, data: Any, rows: Iterable[int]) -> list[str]:
    """The two geometries of a contact's row, "foot on floor"."""
    names, geoms = _fixed(model).names, np.asarray(data.contact.geom).reshape(-1, 2).tolist()
    ids = data.efc_id.tolist()
    return numbered(f"{names[geoms[ids[row]][1]]} on {names[geoms[ids[row]][0]]}" for row in rows)


def _bounded(data: Any) -> tuple[Any, ...]:
    """Of the rows beside contacts: how many equality constraints, frictions and limits have, and what they are."""
    return (data.ne, data.nf, data.nl), (data.efc_type, data.efc_id, data.efc_force, data.efc_pos, data.efc_frictionloss,
                                         data.efc_R)


_warned: set[tuple[str, str, int]] = set()  # Python's own memory is lost when anybody changes the filters


def _warn(text: str) -> None:
    """At the line of the caller's that called this package, once for each line."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    said = text, frame.f_code.co_filename, frame.f_lineno
    if said not in _warned:
        warnings.warn(text, stacklevel=level)
        _warned.add(said)


class _Notes:
    """How a problem differs from MuJoCo's step: what, and how many of it."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def add(self, what: str, count: int, warn: bool = False) -> None:
        if count == 0:
            return
        self.texts.append(f"{what}: {int(count)}")
        if warn:
            _warn(f"lcpbench.mujoco.capture: {what}")


def _note(model: Any, data: Any, soft: bool, notes: _Notes) -> None:
    """What both kinds of problems leave out or change, and what is of hard or of soft contacts alone."""
    import mujoco

    contact, full = data.contact, (mujoco.mjtWarning.mjWARN_CONTACTFULL, mujoco.mjtWarning.mjWARN_CNSTRFULL)
    solved = np.asarray(contact.efc_address).ravel() >= 0
    dims, elliptic = np.asarray(contact.dim).ravel()[solved], model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    friction = np.asarray(contact.friction).reshape(-1, 5)[solved]
    notes.add("steps whose contacts or rows MuJoCo dropped, now or before: its memory was full",
              any(data.warning[int(each)].number > 0 for each in full), warn=True)
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        notes.add("steps of the integrator RK4: the stage that MuJoCo solved last, stepped by Euler's rule", 1, True)
    if not soft or elliptic:  # a pyramid has edges for them
        how = "as the force that MuJoCo found"
        notes.add(f"contacts with torsional friction (condim 4 or 6), {how}", np.count_nonzero(dims > 3), not soft)
        notes.add(f"contacts with rolling friction (condim 6), {how}", np.count_nonzero(dims > 5), not soft)
        notes.add("contacts with two coefficients of sliding friction: the second tangent is scaled",
                  np.count_nonzero((dims > 1) & (friction[:, 0] != friction[:, 1])))
    if not soft and hasattr(contact, "surfacevel"):
        moving = np.asarray(contact.surfacevel).reshape(-1, 3)[solved].any(axis=1)
        notes.add("contacts whose surface has a velocity of its own, left out", np.count_nonzero(moving), warn=True)
    notes.add("contacts that MuJoCo found and did not solve, left out",
              np.count_nonzero(~solved & (np.asarray(contact.exclude).ravel() < 3)))  # 3: of no coordinates, 4: a spring
    if hasattr(data, "tree_asleep"):
        notes.add("kinematic trees asleep, whose contacts MuJoCo does not solve, left out",
                  np.count_nonzero(np.asarray(data.tree_asleep) >= 0))


@contextlib.contextmanager
def _changed(option: Any, **values: int) -> Iterator[None]:
    """A model's options with other values for a while: a copy of a model takes longer than a step."""
    before = {name: getattr(option, name) for name in values}
    try:
        for name, value in values.items():
            setattr(option, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(option, name, value)


def _stepped_on(model: Any, data: Any) -> Any:
    """A copy of the data after the step: with its velocity, and qDeriv."""
    import mujoco

    after = copy.copy(data)
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER:
        step = mujoco.mj_Euler
    else:
        step = mujoco.mj_implicit
    sleep = int(getattr(mujoco.mjtEnableBit, "mjENBL_SLEEP", 0))  # what falls asleep behind the step is not of it
    with _changed(model.opt, enableflags=model.opt.enableflags & ~sleep):
        step(model, after)
    return after


def _before_noslip(model: Any, data: Any) -> Any:
    """A copy of the data with the forces that MuJoCo's solver finds without noslip_iterations."""
    import mujoco

    again = copy.copy(data)
    with _changed(model.opt, noslip_iterations=0):
        mujoco.mj_fwdConstraint(model, again)
    return again


def _check_pair(model: Any, data: Any) -> None:
    import mujoco

    if not (isinstance(model, mujoco.MjModel) and isinstance(data, mujoco.MjData)):
        raise TypeError("capture: expected (model, data), an MjModel and its MjData, got "
                        f"({type(model).__name__}, {type(data).__name__})")
    if (len(data.qpos), len(data.qvel), len(data.xquat)) != (model.nq, model.nv, model.nbody):
        raise InputError("capture: the data are of another model")


def _frames(data: Any, rows: np.ndarray) -> np.ndarray:
    """Point, normal and tangent of the contact of each row."""
    of = data.efc_id[rows]
    return np.hstack([data.contact.pos[of], data.contact.frame[of, :6]])


def _seen(data: Any) -> dict[str, Any]:
    return dict(time=float(data.time), poses=np.hstack([data.geom_xpos, data.geom_xmat]))


def _sphere(count: int = 64) -> np.ndarray:
    """Unit vectors that are spread evenly."""
    i = np.arange(count)
    z, turn = 1 - (2 * i + 1) / count, np.pi * (3 - np.sqrt(5)) * i
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def _farthest(points: np.ndarray) -> np.ndarray:
    """Of many points those that lie farthest in the directions of _sphere(), in units of the box around them."""
    directions = _sphere()
    if len(points) <= len(directions):
        return points
    extent = np.ptp(points, axis=0)
    directions /= np.maximum(extent, 1e-9 * extent.max())
    found = points[np.unique(np.argmax(points @ directions.T, axis=0))]
    return np.resize(found, (max(4, len(found)), 3))  # of flat ones some stand twice


def _corners(model: Any, geom: int) -> np.ndarray:
    """Of the convex hull that a geometry is drawn as."""
    import mujoco

    kind, index = model.geom_type[geom], model.geom_dataid[geom]
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return model.geom_size[geom] * _sphere()
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        first = model.mesh_vertadr[index]
        return _farthest(model.mesh_vert[first : first + model.mesh_vertnum[index]].astype(float))
    return model.geom_aabb[geom, :3] + model.geom_aabb[geom, 3:] * list(itertools.product((-1, 1), repeat=3))


def shapes(model: Any) -> list[tuple[int, str, tuple[float, ...]]]:
    """For pictures: (body, type, size) of each geometry, as `lcpbench.Recorder` takes them. Meshes and ellipsoids are convex
    hulls of at most 64 corners, height fields the box around them. Of a body that has geometries which can touch others,
    these alone are drawn.

    Args:
        model: an MjModel.
    """
    kinds = {0: ("plane", lambda size: (0.0, 0.0, 1.0, 0.0)), 2: ("sphere", lambda size: size[:1]),
             3: ("capsule", lambda size: size[:2]), 5: ("cylinder", lambda size: size[:2]), 6: ("box", lambda size: size)}
    touches = (model.geom_contype | model.geom_conaffinity) != 0
    drawn = touches | ~np.isin(model.geom_bodyid, model.geom_bodyid[touches])
    result = []
    for i in np.flatnonzero(drawn):
        name, of = kinds.get(int(model.geom_type[i]), ("hull", None))
        size = of(model.geom_size[i]) if of else [f"{each:.4g}" for each in _corners(model, i).ravel()]  # a small file
        result.append((int(i), name, tuple(map(float, size))))
    return result


def _velocity_before(model: Any, data: Any) -> np.ndarray:
    """qvel as the step began, from the bodies' velocities cvel of that time."""
    relative, before = data.cvel - data.cvel[model.body_parentid], np.zeros(model.nv)
    for body in np.unique(model.dof_bodyid):
        dofs = model.dof_bodyid == body
        before[dofs] = np.linalg.lstsq(data.cdof[dofs].T, relative[body], rcond=None)[0]
    return before


def _acceleration(model: Any, data: Any, J: np.ndarray) -> np.ndarray:
    """That of the step; of RK4's stage that MuJoCo solved last, whose qacc is the one of all stages."""
    import mujoco

    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        return np.asarray(data.qacc)
    return _solve(_blocks(model, _full_inertia(model, data)), data.qfrc_smooth + J.T @ data.efc_force)


def _soft_step(model: Any, data: Any, J: np.ndarray, stepped: bool, name: str, notes: list[str]) -> Step:
    """The convex problem of MuJoCo [Todorov 2014], as `lcpbench capture --soft` writes it: with the acceleration a, the
    force f of each edge of a pyramid asks that J a - efc_aref + R f >= 0. An elliptic cone is one contact with friction,
    of which this vector is in the dual cone. Of a bounded row it is zero between the bounds of its force."""
    import mujoco

    types = np.asarray(data.efc_type)
    h, M = model.opt.timestep, _full_inertia(model, data)
    force, R = np.asarray(data.efc_force), np.asarray(data.efc_R)
    before = _velocity_before(model, data) if stepped else np.array(data.qvel)
    target = J @ before + h * np.asarray(data.efc_aref)
    momentum = M @ before + h * np.asarray(data.qfrc_smooth)
    blocks = _blocks(model, M)
    friction = np.asarray(data.contact.friction).reshape(-1, 5)
    first = data.ne + data.nf + data.nl  # of contacts
    rows = np.arange(first, data.nefc)
    elliptic = np.flatnonzero(types[rows] == mujoco.mjtConstraint.mjCNSTR_CONTACT_ELLIPTIC) + first
    of = np.asarray(data.efc_id)[elliptic]
    place = elliptic - np.asarray(data.contact.efc_address).ravel()[of]  # 0: the normal, then the tangents
    rows = np.setdiff1d(rows, elliptic[place > 0], assume_unique=True)
    fixed = elliptic[place > 2]  # as the force that MuJoCo found
    if len(fixed):
        momentum += h * (J[fixed].T @ force[fixed])
    normals = elliptic[place == 0]
    at, mu, compliance_t = np.searchsorted(rows, normals), np.zeros(len(rows)), np.zeros(len(rows))
    T, offset, impulses = np.zeros((len(rows), 2, model.nv)), np.zeros((len(rows), 2)), np.zeros((len(rows), 3))
    along_first, along_second = friction[of[place == 0], :2].T
    mu[at], compliance_t[at], impulses[:, 0] = along_first, R[normals + 1], h * force[rows]
    # The second tangent is scaled, as mu is one number.
    for k, ratio in enumerate((np.ones(len(at)), along_second / along_first)):
        along = normals + 1 + k
        T[at, k], offset[at, k] = ratio[:, None] * J[along], -ratio * target[along]
        impulses[at, 1 + k] = h * force[along] / ratio
    b = -target[rows]
    if len(fixed):
        # Of the cone |(f_i / mu_i)| <= f_0 they leave |(f_1, f_2)| <= mu sqrt(1 - share) f_0. A contact that slides in it has
        # u_0 = |(mu_i u_i)| in the whole cone, and (1 - share) of that in what is left.
        starts, along = np.flatnonzero(place == 0), place > 0
        u = J @ np.asarray(data.qacc) - np.asarray(data.efc_aref) + R * force
        of_each, slip = np.zeros(len(elliptic)), np.zeros(len(elliptic))
        of_each[place > 2] = force[fixed] / friction[of, place - 1][place > 2]
        slip[along] = (friction[of, place - 1] * u[elliptic])[along]
        squares, slip = np.add.reduceat(of_each**2, starts), np.sqrt(np.add.reduceat(slip**2, starts))
        share = np.minimum(1, squares / np.maximum(force[normals] ** 2, np.finfo(float).tiny))
        mu[at] *= np.sqrt(1 - share)
        b[at] -= h * share * slip
    bounded, row_impulses = _native.mujoco_soft_rows(J, *_bounded(data), target, h, model.nv, _fixed(model).rows)
    problem = Problem(G=blocks, N=_columns(J[rows]), tangents=_columns(T.reshape(-1, model.nv)), mu=mu,
                      v=_solve(blocks, momentum), b=b, compliance_n=R[rows], compliance_t=compliance_t,
                      offset_t=offset, rows=bounded, name=name, validate=False)
    if len(elliptic):
        problem._engine_model = "convex"
    return Step(problem, gap=np.array(data.efc_pos)[rows], contact_ids=_row_ids(model, data, rows), impulses=impulses,
                row_impulses=row_impulses, velocity=before + h * _acceleration(model, data, J),
                contact_frames=_frames(data, rows), notes=notes, **_seen(data))


def capture(model: Any, data: Any, *, soft: bool = False, stepped: bool | None = None, name: str = "mujoco") -> Step:
    """The contacts and joints of the step that MuJoCo has just taken, or that it will take next.

    Bounded rows of the problem are equality constraints, limits of joints and tendons, and their dry friction
    (frictionloss); each is named with its kind, "hinge friction knee". Rows of hinges and balls, and the turning ones of
    welds and free joints, are about angles ("rad"), others about lengths ("m"). So are tendons, but those that only hinges
    make: their length is a sum of angles, times numbers whose unit MuJoCo does not know.

    Whatever the problem leaves out or has otherwise than MuJoCo's step is a line of the step's `notes`, with how many there
    are: torsional and rolling friction (condim 4 and 6), which act as the forces that MuJoCo found, a velocity of a
    surface, trees that sleep, and others; what MuJoCo's answer to hard contacts is not to be blamed for is a warning, too.
    Of hard equality constraints, rows that repeat others up to 1 % are left out, as a loop in a plane has them: it comes
    apart a little in MuJoCo, and would be locked. What MuJoCo pushes along them counts as the others', and what these
    cannot take as a force. Actuators act as MuJoCo takes them, by forces at the old state. Of the integrator RK4 it is the
    stage that MuJoCo solved last, and after `mj_forward` the first one. Of implicit and implicitfast the inertia has the
    symmetric part of the forces' derivative; the other part, gyroscopic torques, acts as if no contact changed it.

    Args:
        model, data: an MjModel and its MjData, after `mj_step`, or after `mj_forward`.
        soft: the convex problem that MuJoCo itself solves: each edge of a pyramid is a contact without friction that has
            the compliance efc_R, as each bounded row has; an elliptic cone is one with friction. Of torsional and
            rolling friction (condim 4 and 6) the forces that MuJoCo found act, and the cone is what they leave of it.
            `check` then says how well MuJoCo solved its own model.
            Its velocity is that of MuJoCo's acceleration, before an integrator takes damping implicitly. What
            noslip_iterations change is not judged: its solver is run once more without them.
        stepped: True: after `mj_step`. None: found from the velocities.
        name: of the problem.

    Returns:
        A `Step`, with MuJoCo's own impulses, and its velocity after `mj_step`, with soft=True always. Unless soft=True,
        an open gap may close within the step, penetration is not pushed out, and equality constraints hold exactly in the
        velocity, without MuJoCo's correction of their error.

    Raises:
        InputError: the data hold no step.
    """
    import mujoco

    _check_pair(model, data)
    if data.xquat[0, 0] == 0:
        raise InputError("capture: the data hold no step yet; call mj_step or mj_forward before")
    h, J = model.opt.timestep, _dense_rows(model, data)
    if stepped is None:  # the bodies' velocities cvel are those before the step
        found, starts = data.cvel[model.body_parentid], _fixed(model).starts
        found[model.dof_bodyid[starts]] += np.add.reduceat(data.cdof * data.qvel[:, None], starts, axis=0) if len(starts) else 0
        stepped = not bool((np.abs(found - data.cvel) <= 1e-12 + 1e-9 * np.abs(data.cvel)).all())
    notes = _Notes()
    _note(model, data, soft, notes)
    if soft:
        if model.opt.noslip_iterations > 0:
            notes.add("steps with noslip_iterations, which solve no convex problem: the forces are those without them",
                      1, warn=True)
            data = _before_noslip(model, data)
        return _soft_step(model, data, J, stepped, name, notes.texts)
    contact = data.contact
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        after, qvel = data, (_velocity_before(model, data) if stepped else data.qvel) + h * _acceleration(model, data, J)
    else:
        after = data if stepped else _stepped_on(model, data)  # qDeriv, too, is of the step
        qvel = after.qvel
    problem, impulses, frames, gap, rows, row_impulses, repeated = _native.mujoco_step(
        J, *_bounded(data), (contact.efc_address, contact.dim, contact.friction, contact.dist, contact.pos, contact.frame),
        bool(model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL), _blocks(model, _step_inertia(model, after, notes)), qvel, h,
        _fixed(model).rows, name)
    notes.add("rows of equality constraints that repeat others, left out", repeated)
    return Step(Problem._of(problem), gap=gap, contact_ids=_row_ids(model, data, rows),
                impulses=impulses.reshape(-1, 3), row_impulses=row_impulses, velocity=np.array(qvel) if stepped else None,
                contact_frames=frames.reshape(-1, 9), notes=notes.texts, **_seen(data))


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

        _check_pair(model, data)
        super().__init__(path, scene, engine="MuJoCo", engine_version=mujoco.mj_versionString(),
                         step_length=model.opt.timestep, gravity=model.opt.gravity, shapes=shapes(model), every=every)
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
        if not states:
            _warn("lcpbench.mujoco.Recorder: no step was recorded: call before_step() before each mj_step()")
        if len(states) > 1000:
            print(f"lcpbench.mujoco.Recorder: writing {len(states)} steps", file=sys.stderr)
        for i, state in enumerate(states):
            mujoco.mj_setState(self._model, data, state, self._state)
            # Of RK4 the first stage: behind mj_step the data are those of the last one.
            rk4 = self._model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
            (mujoco.mj_forward if rk4 else mujoco.mj_step)(self._model, data)
            self.add(capture(self._model, data, soft=self._soft, stepped=True), i * self._every)
        super().close()
