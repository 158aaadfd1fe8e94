"""Contacts of a robot in Pinocchio 4 (PyPI's `pin`).

    step = lcpbench.pinocchio.capture(model, data, q, v, tau, constraint_models, constraint_datas, h)
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _number

__all__ = ["capture", "shapes"]


def _vector(value: Any, name: str, size: int) -> np.ndarray:
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected an array of numbers, got {type(value).__name__}") from None
    if vector.shape != (size,):
        raise InputError(f"{name} has shape {vector.shape}, expected ({size},)")
    return vector


def shapes(geometry: Any) -> list[tuple[int, str, tuple[float, ...]]]:
    """For pictures: (body, type, size) of each geometry, as `lcpbench.Recorder` takes them. Those that are no sphere,
    capsule, cylinder or half space are the box around them.

    Args:
        geometry: a GeometryModel, that of collisions.
    """
    result: list[tuple[int, str, tuple[float, ...]]] = []
    for i, each in enumerate(geometry.geometryObjects):
        shape = each.geometry
        kind = type(shape).__name__.lower()
        if kind == "sphere":
            result.append((i, kind, (shape.radius,)))
        elif kind in ("capsule", "cylinder"):
            result.append((i, kind, (shape.radius, shape.halfLength)))
        elif kind in ("halfspace", "plane"):
            result.append((i, "plane", (*map(float, shape.n), shape.d)))
        else:
            shape.computeLocalAABB()
            result.append((i, "box", tuple(map(float, (shape.aabb_local.max_ - shape.aabb_local.min_) / 2))))
    return result


def _poses(pin: Any, model: Any, data: Any, geometry: Any) -> np.ndarray:
    """Of the geometries, at the placements of the joints that data holds."""
    placed = geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, placed)
    poses = []
    for each, pose, (_, kind, _) in zip(geometry.geometryObjects, placed.oMg, shapes(geometry)):
        at = pose.act(np.array(each.geometry.aabb_center)) if kind == "box" else pose.translation
        poses.append([*at, *pose.rotation.ravel()])
    return np.reshape(poses, (-1, 12))


def _named(model: Any, geometry: Any, contacts: list[Any]) -> list[str]:
    """Each contact's own name, or what touches: geometries, else frames, else joints."""

    def end(contact: Any, k: int) -> str:
        if geometry is not None and contact.geom1_id != contact.geom2_id:  # equal: they were not set
            return str(geometry.geometryObjects[getattr(contact, f"geom{k}_id")].name)
        joint, placement = getattr(contact, f"joint{k}_id"), getattr(contact, f"joint{k}_placement")
        for frame in model.frames if joint > 0 else ():
            if frame.parentJoint == joint and np.allclose(frame.placement.translation, placement.translation, atol=1e-9):
                return str(frame.name)
        return str(model.names[joint])

    return numbered(each.name or f"{end(each, 2)} on {end(each, 1)}" for each in contacts)


def capture(model: Any, data: Any, q: Any, v: Any, tau: Any, constraint_models: Any, constraint_datas: Any, h: float, *,
            gap: Any = None, mu: Any = None, geometry: Any = None, name: str = "pinocchio") -> Step:
    """The contacts of the next step of length h: v + h aba(q, v, tau) is the velocity without them.

    Args:
        model, data: of Pinocchio.
        q, v, tau: configuration, velocity and joint torques.
        constraint_models, constraint_datas: point contacts, whose third axis is the normal and whose first two are the
            tangents. Pinocchio measures joint 2 against joint 1, so that the normal has to point into joint 2's body.
        h: length of the step [s].
        gap: (nc,) [m], or None: all touch.
        mu: (nc,), or None: each constraint's own.
        geometry: the GeometryModel of collisions, for names and pictures, or None.
        name: of the problem.

    Returns:
        A `Step` with the contacts' places and names: the constraint's own one, or what touches, "FL_foot on universe", of
        geometries, frames at the place of the contact, or joints. Poses are those of `shapes(geometry)`.

    Raises:
        InputError: a constraint is no point contact (joints' limits, anchors), which is outside.
    """
    import pinocchio as pin

    if not _number(h, "h") > 0:
        raise InputError(f"h is {h!r}, expected seconds > 0")
    q, v, tau = _vector(q, "q", model.nq), _vector(v, "v", model.nv), _vector(tau, "tau", model.nv)
    nc = len(constraint_models)
    if len(constraint_datas) != nc:
        raise InputError(f"constraint_datas has {len(constraint_datas)} entries, expected {nc}: one for each model")
    gaps = np.zeros(nc) if gap is None else _vector(gap, "gap", nc)
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    contacts, frictions = [], []
    for i, (each, its_data) in enumerate(zip(constraint_models, constraint_datas)):
        inner = each.extract() if hasattr(each, "extract") else each
        if not isinstance(inner, pin.PointContactConstraintModel):
            raise InputError(f"constraint_models[{i}]: {type(inner).__name__} is outside: point contacts only")
        contacts.append(inner)
        frictions.append(float(np.ravel(inner.getFriction())[0]))
        models.append(pin.ConstraintModel(inner))
        datas.append(its_data if isinstance(its_data, pin.ConstraintData) else pin.ConstraintData(its_data))
    free = v + h * pin.aba(model, data, q, v, tau)
    M = np.array(pin.crba(model, data, q))
    M = np.triu(M) + np.triu(M, 1).T
    pin.forwardKinematics(model, data, q)
    pin.computeJointJacobians(model, data, q)
    for each, its_data in zip(models, datas):
        each.calc(model, data, its_data)
    J = np.array(pin.getConstraintsJacobian(model, data, models, datas)).reshape(3 * nc, model.nv)
    tangents = J.reshape(-1, 3, model.nv)[:, :2].reshape(-1, model.nv)
    problem = Problem(G=M, N=J[2::3].T, tangents=tangents.T, mu=np.array(frictions) if mu is None else mu, v=free,
                      b=np.maximum(gaps, 0) / h, name=name)
    frames = []
    for each in contacts:
        axes = (data.oMi[each.joint1_id] * each.joint1_placement).rotation
        point = (data.oMi[each.joint2_id] * each.joint2_placement).translation
        frames.append([*point, *axes[:, 2], *axes[:, 0]])
    return Step(problem, gap=gaps, contact_ids=_named(model, geometry, contacts), contact_frames=frames,
                poses=None if geometry is None else _poses(pin, model, data, geometry))
