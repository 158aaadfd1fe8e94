"""Contacts of a robot in Pinocchio 4 (PyPI's `pin`).

    step = lcpbench.pinocchio.capture(model, data, q, v, tau, constraint_models, constraint_datas, h)
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._files import Step
from ._native import InputError
from ._problem import Problem, _number

__all__ = ["capture"]


def _vector(value: Any, name: str, size: int) -> np.ndarray:
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected an array of numbers, got {type(value).__name__}") from None
    if vector.shape != (size,):
        raise InputError(f"{name} has shape {vector.shape}, expected ({size},)")
    return vector


def capture(model: Any, data: Any, q: Any, v: Any, tau: Any, constraint_models: Any, constraint_datas: Any, h: float, *,
            gap: Any = None, mu: Any = None, name: str = "pinocchio") -> Step:
    """The contacts of the next step of length h: v + h aba(q, v, tau) is the velocity without them.

    Args:
        model, data: of Pinocchio.
        q, v, tau: configuration, velocity and joint torques.
        constraint_models, constraint_datas: point contacts, whose third axis is the normal and whose first two are the
            tangents. Pinocchio measures joint 2 against joint 1, so that the normal has to point into joint 2's body.
        h: length of the step [s].
        gap: (nc,) [m], or None: all touch.
        mu: (nc,), or None: each constraint's own.
        name: of the problem.

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
    frictions = []
    for i, (each, its_data) in enumerate(zip(constraint_models, constraint_datas)):
        inner = each.extract() if hasattr(each, "extract") else each
        if not isinstance(inner, pin.PointContactConstraintModel):
            raise InputError(f"constraint_models[{i}]: {type(inner).__name__} is outside: point contacts only")
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
    return Step(problem, gap=gaps)
