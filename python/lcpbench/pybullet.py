"""Contacts of a PyBullet simulation of free rigid bodies (PyPI's `pybullet`).

    pybullet.stepSimulation()
    step = lcpbench.pybullet.capture()
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native
from ._files import Step
from ._native import InputError
from ._problem import Problem, _any_tangent

__all__ = ["capture"]


def capture(client: Any = None, *, name: str = "pybullet", physics_client: int = 0) -> Step:
    """The contacts of the step that Bullet has just taken, at the positions that the bodies had before it.

    With `numSubSteps` it is the last substep. Restitution and the friction of spinning and rolling are left out; a
    penetration is not pushed out. Between two free bodies a contact is in the middle of its ends, at which Bullet
    pushes them: friction at a gap or penetration then turns them a little less or more than in Bullet.

    Args:
        client: the module `pybullet`, or a BulletClient. None: the module.
        name: of the problem.
        physics_client: the number of the connection, if client is the module.

    Returns:
        A `Step` with Bullet's own impulses and velocity. A problem of kind "scene".

    Raises:
        InputError: a free body has joints, or a body with a fixed base has joints that move.
    """
    from scipy.spatial.transform import Rotation

    if client is None:
        import pybullet

        client = pybullet
    more = {"physicsClientId": physics_client} if type(client).__name__ == "module" else {}
    settings = client.getPhysicsEngineParameters(**more)
    of_forces = settings["fixedTimeStep"]  # Bullet divides the impulses of a substep by it, too
    h = of_forces / max(settings["numSubSteps"], 1)
    bodies: list[dict[str, Any]] = []
    index: dict[int, int] = {}
    for k in range(client.getNumBodies(**more)):
        body = client.getBodyUniqueId(k, **more)
        mass, _, inertia, *_ = client.getDynamicsInfo(body, -1, **more)
        joints = [client.getJointInfo(body, j, **more)[2] for j in range(client.getNumJoints(body, **more))]
        if mass == 0 and all(kind == client.JOINT_FIXED for kind in joints):
            continue
        if joints:
            raise InputError(f"capture: body {body} has joints, which is outside: free rigid bodies only")
        position, turned = client.getBasePositionAndOrientation(body, **more)
        linear, angular = map(np.array, client.getBaseVelocity(body, **more))
        R = (Rotation.from_rotvec(-h * angular) * Rotation.from_quat(turned)).as_matrix()  # before the step
        index[body] = len(bodies)
        bodies.append(dict(mass=mass, inertia=R @ np.diag(inertia) @ R.T, position=np.array(position) - h * linear,
                           linear_velocity=linear, angular_velocity=angular))

    def named(body: int) -> str:
        return f"{client.getBodyInfo(body, **more)[1].decode()} {body}".lstrip()

    contacts, gap, ids, normal, along = [], [], [], [], []
    seen: dict[tuple[int, int], int] = {}
    for point in client.getContactPoints(**more):
        _, a, b, link_a, link_b, on_a, on_b, n, distance, force, force_1, tangent_1, force_2, tangent_2, *_ = point
        if a not in index and b not in index:
            continue
        mu_a, mu_b = (client.getDynamicsInfo(*each, **more)[1] for each in ((a, link_a), (b, link_b)))
        mu = min(mu_a * mu_b, 10.0)
        ends = [at for body, at in ((a, on_a), (b, on_b)) if body in index]  # Bullet pushes each body at its own end
        n, sign = np.array(n), 1.0
        if a not in index:  # the immovable world has to be body_b
            a, b, n, sign = b, a, -n, -1.0
        n /= np.linalg.norm(n)
        t1, t2 = sign * np.array(tangent_1), sign * np.array(tangent_2)
        tangent = t1 - n * (n @ t1)
        length = np.linalg.norm(tangent)
        tangent = tangent / length if length > 0.5 else _any_tangent(n, "contact")
        second = np.cross(n, tangent)
        pushed = of_forces * (force_1 * t1 + force_2 * t2)
        contacts.append(dict(body_a=index[a], body_b=index.get(b, -1), point=np.mean(ends, axis=0), normal=n,
                             tangent=tangent, mu=mu, b=max(distance, 0.0) / h))
        gap.append(distance)
        seen[a, b] = seen.get((a, b), -1) + 1
        number = f" #{seen[a, b] + 1}" if seen[a, b] else ""
        ids.append(f"{named(a)} on {named(b)}{number}")
        normal.append(of_forces * force)
        along.append([pushed @ tangent, pushed @ second] if mu > 0 else [0.0, 0.0])
    impulses = np.column_stack([normal, np.reshape(along, (-1, 2))])
    after = np.concatenate([[*each["linear_velocity"], *each["angular_velocity"]] for each in bodies] or [[]])
    moved = Problem.from_scene(bodies, contacts)
    f = _native.complete_answer(moved._data, impulses, "pyramid")
    J = moved.N @ f[: moved.nc] + moved.D @ f[moved.nc : moved.nc + sum(moved.edges)]
    for i, each in enumerate(bodies):
        each["linear_velocity"] = after[6 * i : 6 * i + 3] - J[6 * i : 6 * i + 3] / each["mass"]
        turned = np.linalg.solve(each["inertia"], J[6 * i + 3 : 6 * i + 6])
        each["angular_velocity"] = after[6 * i + 3 : 6 * i + 6] - turned
    problem = Problem.from_scene(bodies, contacts, name)
    return Step(problem, gap=np.array(gap), contact_ids=ids, impulses=impulses, velocity=after)
