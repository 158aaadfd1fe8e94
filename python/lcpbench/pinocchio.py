"""Contacts and joints of a robot in Pinocchio 4 (PyPI's `pin`).

    step = lcpbench.pinocchio.capture(model, data, q, v, tau, constraint_models, constraint_datas, h)
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _number
from ._rows import Rows

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


def _named(model: Any, geometry: Any, constraint: Any) -> str:
    """A constraint's own name, or what it holds together: geometries, else frames, else joints."""

    def end(contact: Any, k: int) -> str:
        if geometry is not None and hasattr(contact, "geom1_id") and contact.geom1_id != contact.geom2_id:  # equal: not set
            return str(geometry.geometryObjects[getattr(contact, f"geom{k}_id")].name)
        joint, placement = getattr(contact, f"joint{k}_id"), getattr(contact, f"joint{k}_placement")
        for frame in model.frames if joint > 0 else ():
            if frame.parentJoint == joint and np.allclose(frame.placement.translation, placement.translation, atol=1e-9):
                return str(frame.name)
        return str(model.names[joint])

    return str(constraint.name) or f"{end(constraint, 2)} on {end(constraint, 1)}"


def _add_rows(pin: Any, model: Any, data: Any, geometry: Any, each: Any, h: float, rows: Rows) -> bool:
    """Bounded rows of a constraint. Returns whether it is of a kind that has some."""
    its_data = each.createData()
    each.calc(model, data, its_data)

    def jacobian() -> np.ndarray:
        if isinstance(each, pin.RigidConstraintModel):  # whose own function leaves zeros unwritten
            J = pin.getConstraintJacobian(model, data, each, its_data)
        else:
            J = each.jacobian(model, data, its_data)
        return np.reshape(J, (each.residualSize(), model.nv))  # eigenpy makes a vector of one row or column

    kinds = tuple(getattr(pin, f"{kind}ConstraintModel") for kind in ("PointAnchor", "FrameAnchor", "Rigid"))
    if isinstance(each, kinds):
        for k, direction in enumerate(jacobian()):
            name = f"anchor {_named(model, geometry, each)} {'about ' if k > 2 else ''}{'xyz'[k % 3]}"
            rows.add(name, direction, k > 2)
        return True
    is_limit = isinstance(each, pin.JointLimitConstraintModel)
    if not is_limit and not isinstance(each, pin.JointFrictionConstraintModel):
        return False
    if not each.residualSize():
        return True
    bounds = np.zeros((2, each.residualSize())) if is_limit else (each.getFrictionLowerLimit(), each.getFrictionUpperLimit())
    for k, direction in enumerate(jacobian()):
        dof = int(np.argmax(np.abs(direction)))
        joint = next(i for i in range(1, model.njoints) if model.idx_vs[i] <= dof < model.idx_vs[i] + model.nvs[i])
        is_angle = bool(np.any(np.reshape(data.J, (6, -1))[3:, dof]))  # whose motion turns
        name = f"{'limit' if is_limit else 'friction'} {model.names[joint]}"
        if is_limit:
            gap, side = float(its_data.constraint_residual[k]), "lower" if direction[dof] > 0 else "upper"
            rows.add(f"{name} {side}", direction, is_angle, lower=0.0, b=max(gap, 0.0) / h)
        else:
            rows.add(name, direction, is_angle, lower=h * float(bounds[0][k]), upper=h * float(bounds[1][k]))
    return True


def capture(model: Any, data: Any, q: Any, v: Any, tau: Any, constraint_models: Any, constraint_datas: Any, h: float, *,
            gap: Any = None, mu: Any = None, geometry: Any = None, name: str = "pinocchio") -> Step:
    """The constraints of the next step of length h: v + h aba(q, v, tau) is the velocity without them.

    Point contacts are contacts; anchors of points and frames, rigid constraints (3D, 6D), limits of joints and friction of
    joints are bounded rows. All are hard: an open limit may close within the step, anchors hold exactly in the velocity,
    and what is pushed out is left out. Limits that a JointLimitConstraintModel has not selected are no rows. The bounds of
    friction are its force limits times h. Compliances and desired velocities of constraints are left out, which is a line of
    the step's `notes`. Pinocchio's own limits and friction of a model are not in aba: they act where a constraint has them.

    Args:
        model, data: of Pinocchio.
        q, v, tau: configuration, velocity and joint torques.
        constraint_models, constraint_datas: of a point contact the third axis is the normal, and the first two are the
            tangents. Pinocchio measures joint 2 against joint 1, so that the normal has to point into joint 2's body.
        h: length of the step [s].
        gap: (nc,) [m] of the point contacts, or None: all touch.
        mu: (nc,) of the point contacts, or None: each one's own.
        geometry: the GeometryModel of collisions, for names and pictures, or None.
        name: of the problem.

    Returns:
        A `Step` with the contacts' places and names: the constraint's own one, or what touches, "FL_foot on universe", of
        geometries, frames at the place of the contact, or joints. Poses are those of `shapes(geometry)`.

    Raises:
        InputError: a constraint is of another kind.
    """
    import pinocchio as pin

    if not _number(h, "h") > 0:
        raise InputError(f"h is {h!r}, expected seconds > 0")
    q, v, tau = _vector(q, "q", model.nq), _vector(v, "v", model.nv), _vector(tau, "tau", model.nv)
    if len(constraint_datas) != len(constraint_models):
        raise InputError(f"constraint_datas has {len(constraint_datas)} entries, expected {len(constraint_models)}: one for "
                         "each model")
    free = v + h * pin.aba(model, data, q, v, tau)
    M = np.array(pin.crba(model, data, q))
    M = np.triu(M) + np.triu(M, 1).T
    pin.forwardKinematics(model, data, q)
    pin.computeJointJacobians(model, data, q)
    data.q_in = q  # which limits look at
    contacts, jacobians, rows, left_out = [], [], Rows(model.nv), [0, 0]
    for i, each in enumerate(constraint_models):
        inner = each.extract() if hasattr(each, "extract") else each
        if isinstance(inner, pin.PointContactConstraintModel):
            its_data = inner.createData()
            inner.calc(model, data, its_data)
            contacts.append(inner)
            jacobians.append(np.array(inner.jacobian(model, data, its_data)))
        elif not hasattr(inner, "createData") or not _add_rows(pin, model, data, geometry, inner, h, rows):
            raise InputError(f"constraint_models[{i}]: {type(inner).__name__} is outside: point contacts, anchors, rigid "
                             "constraints, limits and friction of joints only")
        left_out[0] += bool(np.any(inner.retrieveCompliance()))
        left_out[1] += any(np.any(np.asarray(getattr(inner, name, 0.0))) for name in (
            "desired_constraint_velocity", "desired_constraint_offset"))
    notes = [f"constraints with {what}, left out: {count}" for what, count in zip(
        ("a compliance", "a desired velocity or offset"), left_out) if count]
    nc = len(contacts)
    gaps = np.zeros(nc) if gap is None else _vector(gap, "gap", nc)
    if mu is None:
        mu = np.array([float(np.ravel(each.getFriction())[0]) for each in contacts])
    J = np.reshape(jacobians, (3 * nc, model.nv))
    tangents = J.reshape(-1, 3, model.nv)[:, :2].reshape(-1, model.nv)
    problem = Problem(G=M, N=J[2::3].T, tangents=tangents.T, mu=mu, v=free, b=np.maximum(gaps, 0) / h, rows=rows.fields(),
                      name=name)
    frames = []
    for each in contacts:
        axes = (data.oMi[each.joint1_id] * each.joint1_placement).rotation
        point = (data.oMi[each.joint2_id] * each.joint2_placement).translation
        frames.append([*point, *axes[:, 2], *axes[:, 0]])
    return Step(problem, gap=gaps, contact_ids=numbered(_named(model, geometry, each) for each in contacts),
                contact_frames=frames, poses=None if geometry is None else _poses(pin, model, data, geometry), notes=notes)
