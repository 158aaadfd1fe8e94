"""Contacts of a PyBullet simulation of free rigid bodies (PyPI's `pybullet`).

    pybullet.stepSimulation()
    step = lcpbench.pybullet.capture()
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native
from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _any_tangent

__all__ = ["capture", "shapes"]


def _connection(client: Any, physics_client: int) -> tuple[Any, dict[str, int]]:
    """The module or BulletClient, and what its functions take more."""
    if client is None:
        import pybullet

        client = pybullet
    return client, {"physicsClientId": physics_client} if type(client).__name__ == "module" else {}


def _parts(client: Any, more: dict[str, int]) -> list[tuple[int, int, Any, np.ndarray]]:
    """Of each shape body and link, its data, and of a mesh or an array of shapes the corners of the box around it."""
    parts = []
    for k in range(client.getNumBodies(**more)):
        body = client.getBodyUniqueId(k, **more)
        for link in range(-1, client.getNumJoints(body, **more)):
            for shape in client.getCollisionShapeData(body, link, **more):
                corners = np.zeros((2, 3))
                if shape[2] == client.GEOM_MESH:
                    points = np.array(client.getMeshData(body, link, **more)[1])
                    corners = np.array([points.min(axis=0), points.max(axis=0)])
                parts.append((body, link, shape, corners))
    return parts


def shapes(client: Any = None, *, physics_client: int = 0) -> list[tuple[int, str, tuple[float, ...]]]:
    """For pictures: (body, type, size) of each collision shape of all bodies that are there, as `lcpbench.Recorder` takes
    them. A mesh is the box around it.

    Args:
        client, physics_client: as those of `capture`.
    """
    client, more = _connection(client, physics_client)
    result: list[tuple[int, str, tuple[float, ...]]] = []
    for i, (_, _, (_, _, kind, size, *_), corners) in enumerate(_parts(client, more)):
        if kind == client.GEOM_SPHERE:
            result.append((i, "sphere", size[:1]))
        elif kind in (client.GEOM_CAPSULE, client.GEOM_CYLINDER):
            result.append((i, "capsule" if kind == client.GEOM_CAPSULE else "cylinder", (size[1], size[0] / 2)))
        elif kind == client.GEOM_PLANE:
            result.append((i, "plane", (*size, 0.0)))
        else:
            half = np.array(size) / 2 if kind == client.GEOM_BOX else (corners[1] - corners[0]) / 2
            result.append((i, "box", tuple(map(float, half))))
    return result


def _poses(client: Any, more: dict[str, int], before: dict[int, tuple[np.ndarray, Any]]) -> np.ndarray:
    """Of the shapes. before: where the free bodies stood before the step."""
    from scipy.spatial.transform import Rotation

    poses = []
    for body, link, (*_, offset, turn), corners in _parts(client, more):
        if link >= 0:
            position, q = client.getLinkState(body, link, **more)[:2]
        else:
            position, q = client.getBasePositionAndOrientation(body, **more)
        at, R = before[body] if body in before else (np.array(position), Rotation.from_quat(q))
        turned = R * Rotation.from_quat(turn)
        poses.append([*(at + R.apply(offset) + turned.apply(corners.mean(axis=0))), *turned.as_matrix().ravel()])
    return np.reshape(poses, (-1, 12))


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
        A `Step` with Bullet's own impulses and velocity, and for pictures the poses of `shapes()`. A problem of kind
        "scene".

    Raises:
        InputError: a free body has joints, or a body with a fixed base has joints that move.
    """
    from scipy.spatial.transform import Rotation

    client, more = _connection(client, physics_client)
    settings = client.getPhysicsEngineParameters(**more)
    of_forces = settings["fixedTimeStep"]  # Bullet divides the impulses of a substep by it, too
    h = of_forces / max(settings["numSubSteps"], 1)
    bodies: list[dict[str, Any]] = []
    index: dict[int, int] = {}
    before: dict[int, tuple[np.ndarray, Any]] = {}
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
        before[body] = np.array(position) - h * linear, Rotation.from_rotvec(-h * angular) * Rotation.from_quat(turned)
        R = before[body][1].as_matrix()
        index[body] = len(bodies)
        bodies.append(dict(mass=mass, inertia=R @ np.diag(inertia) @ R.T, position=before[body][0],
                           linear_velocity=linear, angular_velocity=angular))

    def named(body: int) -> str:
        return f"{client.getBodyInfo(body, **more)[1].decode()} {body}".lstrip()

    contacts, gap, ids, normal, along = [], [], [], [], []
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
        ids.append(f"{named(a)} on {named(b)}")
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
    return Step(problem, gap=np.array(gap), contact_ids=numbered(ids), impulses=impulses, velocity=after,
                poses=_poses(client, more, before))
