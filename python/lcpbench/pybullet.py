"""Contacts and joints of a PyBullet simulation (PyPI's `pybullet`).

    pybullet.stepSimulation()
    step = lcpbench.pybullet.capture()
    answer = lcpbench.solve(step.problem)
"""

from __future__ import annotations

from typing import Any, Mapping

import numpy as np

from . import _native
from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _any_tangent
from ._rows import Rows

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
            try:
                found = client.getCollisionShapeData(body, link, **more)
            except client.error:  # of a body with useMaximalCoordinates PyBullet tells none
                found = ()
            for shape in found:
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


def _poses(client: Any, more: dict[str, int], before: dict[tuple[int, int], tuple[np.ndarray, Any]]) -> np.ndarray:
    """Of the shapes. before: where what moves stood before the step."""
    from scipy.spatial.transform import Rotation

    poses = []
    for body, link, (*_, offset, turn), corners in _parts(client, more):
        if link >= 0:
            position, q = client.getLinkState(body, link, **more)[:2]
        else:
            position, q = client.getBasePositionAndOrientation(body, **more)
        at, R = before.get((body, link), (np.array(position), Rotation.from_quat(q)))
        turned = R * Rotation.from_quat(turn)
        poses.append([*(at + R.apply(offset) + turned.apply(corners.mean(axis=0))), *turned.as_matrix().ravel()])
    return np.reshape(poses, (-1, 12))


class _Body:
    """The kinematics of a body that moves, at the positions before the step. Its coordinates are the velocity and angular
    velocity of its base, if that moves, and the velocities of its joints.

    Attributes:
        first, size: its coordinates.
        velocity: (size,), after the step.
        poses: of the base, -1, and each link centre of mass and rotation.
        inertia: (size, size).
        joints: of each that moves its data of getJointInfo, first coordinate, and position before the step.
    """

    def __init__(self, client: Any, more: dict[str, int], body: int, first: int, h: float) -> None:
        from scipy.spatial.transform import Rotation

        self.first, self.poses, self.joints = first, {}, []
        self._columns: dict[int, list[tuple[int, bool, np.ndarray, np.ndarray]]] = {-1: []}  # dof, turns, axis, origin
        dynamics = {k: client.getDynamicsInfo(body, k, **more) for k in range(-1, client.getNumJoints(body, **more))}
        position, turned = client.getBasePositionAndOrientation(body, **more)
        self.floats = dynamics[-1][0] > 0
        linear, angular = map(np.array, client.getBaseVelocity(body, **more))
        velocity = [linear, angular] if self.floats else []
        after = {-1: (np.array(position), Rotation.from_quat(turned))}
        moved = h * (1.0 if self.floats else 0.0)
        self.poses[-1] = after[-1][0] - moved * linear, Rotation.from_rotvec(-moved * angular) * after[-1][1]
        self.size = 6 if self.floats else 0
        counts = {client.JOINT_REVOLUTE: 1, client.JOINT_PRISMATIC: 1, client.JOINT_SPHERICAL: 3, client.JOINT_FIXED: 0}
        for k in range(client.getNumJoints(body, **more)):
            info = client.getJointInfo(body, k, **more)
            kind, parent = info[2], info[16]
            if kind not in counts:
                raise InputError(f"capture: joint {k} of body {body} is planar, which is outside")
            state = client.getLinkState(body, k, computeForwardKinematics=True, **more)
            place, turn, local, local_turn, link, link_turn = (
                np.array(each) if i % 2 == 0 else Rotation.from_quat(each) for i, each in enumerate(state[:6]))
            after[k] = place, turn
            axes = np.eye(3) if kind == client.JOINT_SPHERICAL else np.array([info[13]])
            axes = local_turn.apply(axes)  # of the link's frame, which is the joint's
            q, rate = 0.0, np.zeros(counts[kind])
            if counts[kind] == 1:
                q, rate = client.getJointState(body, k, **more)[0], np.array([client.getJointState(body, k, **more)[1]])
            elif counts[kind]:
                rate = np.array(client.getJointStateMultiDof(body, k, **more)[1])
            back = -h * (rate @ axes[: len(rate)]) if len(rate) else np.zeros(3)
            turns = kind in (client.JOINT_REVOLUTE, client.JOINT_SPHERICAL)
            # From the parent, which has to be where it was, too.
            (p, R), (p_before, R_before) = after[parent], self.poses[parent]
            now = R.inv() * link_turn
            origin = R_before.apply(R.inv().apply(link - p) + (np.zeros(3) if turns else now.apply(back)))
            link_before = R_before * now * (Rotation.from_rotvec(back) if turns else Rotation.identity())
            self.poses[k] = p_before + origin + link_before.apply(local), link_before * local_turn
            self._columns[k] = self._columns[parent] + [
                (self.size + i, turns, link_before.apply(axes[i]), p_before + origin) for i in range(len(rate))]
            if len(rate):
                self.joints.append((k, info, self.size, q - h * float(rate[0])))
            velocity.append(rate)
            self.size += len(rate)
        self.velocity = np.concatenate(velocity or [[]])
        self.inertia = np.zeros((self.size, self.size))
        for k, (mass, _, moments, *_) in dynamics.items():
            turn, v = self.jacobian(k, self.poses[k][0])
            R = self.poses[k][1].as_matrix()
            self.inertia += mass * v.T @ v + turn.T @ (R @ np.diag(moments) @ R.T) @ turn

    def jacobian(self, link: int, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the angular velocity of a link, and the velocity of its point."""
        turn, v = np.zeros((2, 3, self.size))
        if self.floats:
            turn[:, 3:6] = v[:, :3] = np.eye(3)
            v[:, 3:6] = np.cross(np.eye(3), point - self.poses[-1][0]).T
        for dof, turns, axis, origin in self._columns[link]:
            v[:, dof] = np.cross(axis, point - origin) if turns else axis
            turn[:, dof] = axis if turns else 0.0
        return turn, v


class _World:
    """All bodies that move, by their numbers."""

    def __init__(self, client: Any, more: dict[str, int], h: float) -> None:
        self.bodies: dict[int, _Body] = {}
        self.size = 0
        for k in range(client.getNumBodies(**more)):
            body = client.getBodyUniqueId(k, **more)
            joints = [client.getJointInfo(body, j, **more)[2] for j in range(client.getNumJoints(body, **more))]
            if client.getDynamicsInfo(body, -1, **more)[0] == 0 and all(kind == client.JOINT_FIXED for kind in joints):
                continue
            self.bodies[body] = _Body(client, more, body, self.size, h)
            self.size += self.bodies[body].size

    def jacobian(self, body: int, link: int, point: np.ndarray) -> np.ndarray:
        """(6, size), of the angular velocity of a link and the velocity of its point in the world; zeros where none moves."""
        J = np.zeros((6, self.size))
        if body in self.bodies:
            of = self.bodies[body]
            J[:, of.first : of.first + of.size] = np.vstack(of.jacobian(link, point))
        return J

    def coordinate(self, body: int, joint: int) -> np.ndarray:
        """The direction of a joint with one degree of freedom."""
        of = self.bodies[body]
        return np.eye(self.size)[of.first + next(dof for k, _, dof, _ in of.joints if k == joint)]

    def poses(self) -> dict[tuple[int, int], tuple[np.ndarray, Any]]:
        """Before the step, of bases and links."""
        return {(body, link): pose for body, of in self.bodies.items() for link, pose in of.poses.items()}


def _frame(client: Any, more: dict[str, int], world: _World, body: int, link: int) -> tuple[np.ndarray, Any]:
    """The centre of mass and rotation before the step; of the world itself its origin."""
    from scipy.spatial.transform import Rotation

    if body in world.bodies:
        return world.bodies[body].poses[link]
    if body < 0:
        return np.zeros(3), Rotation.identity()
    place, turn = (client.getLinkState(body, link, **more)[:2] if link >= 0 else
                   client.getBasePositionAndOrientation(body, **more))
    return np.array(place), Rotation.from_quat(turn)


_DEFAULT_LIMIT = 500.0  # what createConstraint sets, and takes for an impulse


def _add_constraints(client: Any, more: dict[str, int], world: _World, h: float, rows: Rows, impulses: list[float],
                     notes: dict[str, int]) -> None:
    """Constraints between bodies, each with the rows that Bullet gives it, and its impulses in them."""
    from scipy.spatial.transform import Rotation

    names = {client.JOINT_POINT2POINT: "point", client.JOINT_FIXED: "fixed", client.JOINT_PRISMATIC: "slider",
             client.JOINT_GEAR: "gear"}
    for i in range(client.getNumConstraints(**more)):
        number = client.getConstraintUniqueId(i, **more)
        info = client.getConstraintInfo(number, **more)
        a, link_a, b, link_b, kind, axis, pivot_a, pivot_b, turn_a, _, most, ratio, aux = info[:13]
        try:
            found = h * np.array(client.getConstraintState(number, **more))
        except client.error:
            found = None
        if kind not in names or (kind == client.JOINT_GEAR and (aux > 0 or a not in world.bodies or b not in world.bodies)):
            notes["constraints of other kinds, as the forces that Bullet found"] += 1
            continue
        name = f"{names[kind]} {number}"
        limit = np.inf if found is None else most if most == _DEFAULT_LIMIT else h * most
        added: list[tuple[str, np.ndarray, bool]] = []
        if kind == client.JOINT_GEAR:
            direction = world.coordinate(a, link_a) + (ratio or 1.0) * world.coordinate(b, link_b)
            turns = client.getJointInfo(a, link_a, **more)[2] == client.JOINT_REVOLUTE
            added.append((name, direction, turns))
        else:
            (p, R), (p_b, R_b) = (_frame(client, more, world, *each) for each in ((a, link_a), (b, link_b)))
            J = world.jacobian(a, link_a, p + R.apply(pivot_a)) - world.jacobian(b, link_b, p_b + R_b.apply(pivot_b))
            lines = np.eye(3)
            if kind == client.JOINT_POINT2POINT:
                lines = -lines
            turned = (R * Rotation.from_quat(turn_a)).as_matrix().T
            if kind == client.JOINT_PRISMATIC:
                along = R.apply(axis)
                across = next(each for each in np.cross(turned, along) if np.linalg.norm(each) > 1e-6)
                across /= np.linalg.norm(across)
                beside = np.cross(along, across)
                lines, turned = np.array([across, beside / np.linalg.norm(beside)]), turned[[2, 0, 1]]
            added += [(f"{name} {k}", line @ J[3:], False) for k, line in enumerate(lines)]
            if kind != client.JOINT_POINT2POINT:
                added += [(f"{name} about {k}", line @ J[:3], True) for k, line in enumerate(turned)]
        if found is None:
            notes["constraints whose impulses PyBullet does not tell, which act as Bullet found them beside the rows"] += 1
        for k, (text, direction, turns) in enumerate(added):
            if rows.add(text, direction, turns, lower=-limit, upper=limit):
                impulses.append(0.0 if found is None else float(found[k]))


def _add_joints(client: Any, more: dict[str, int], world: _World, motors: dict[tuple[int, int], Mapping[str, Any]], h: float,
                of_forces: float, rows: Rows, impulses: list[float], notes: dict[str, int]) -> list[tuple[int, np.ndarray, float]]:
    """Limits of joints, and the motors that were told. Returns of motors with a gain of velocity other than 1 row,
    direction and that gain less 1: Bullet takes it of the velocity without constraints."""
    gains = []
    for body, of in world.bodies.items():
        for k, info, _, q in of.joints:
            told = motors.pop((body, k), None)
            name, kind, low, high = info[1].decode(), info[2], info[8], info[9]
            if kind == client.JOINT_SPHERICAL:
                torque = client.getJointStateMultiDof(body, k, **more)[3]
                notes["motors that were not told, as the forces that Bullet found"] += bool(np.any(torque))
                continue
            direction, turns = world.coordinate(body, k), kind == client.JOINT_REVOLUTE
            for sign, limit in zip((1.0, -1.0), (low, high) if low <= high else ()):
                if rows.add_limit(f"joint limit {name}", direction, turns, sign, q, limit, h):
                    impulses.append(0.0)
                    notes["limits of joints that are reached, whose impulses PyBullet does not tell: they act as Bullet "
                          "found them beside the rows"] += sign * (q - limit) <= 0
            torque = client.getJointState(body, k, **more)[3]
            mode = None if told is None else told.get("controlMode")
            if told is None or mode == client.TORQUE_CONTROL:
                notes["motors that were not told, as the forces that Bullet found"] += told is None and torque != 0
                continue
            if mode not in (client.VELOCITY_CONTROL, client.POSITION_CONTROL):
                raise InputError(f"motors: of joint {k} of body {body} controlMode is {mode!r}, expected VELOCITY_CONTROL, "
                                 "POSITION_CONTROL or TORQUE_CONTROL")
            gain, target = told.get("velocityGain", 1.0), told.get("targetVelocity", 0.0)
            target *= gain
            if mode == client.POSITION_CONTROL:
                wanted = told.get("targetPosition", 0.0)
                wanted = min(max(wanted, low), high) if low <= high else wanted
                target += told.get("positionGain", 0.1) * (wanted - q) / h
                if told.get("maxVelocity", 0.0) > 0:
                    if gain != 1:
                        raise InputError(f"motors: joint {k} of body {body} has a maxVelocity and a velocityGain other than 1")
                    target = float(np.clip(target, -told["maxVelocity"], told["maxVelocity"]))
            limit = of_forces * told.get("force", 1e5)
            if rows.add(f"motor {name}", direction, turns, lower=-limit, upper=limit, b=-target):
                impulses.append(of_forces * torque)
                if gain != 1:
                    gains.append((len(rows) - 1, direction, gain - 1.0))
    if motors:
        raise InputError(f"motors: {next(iter(motors))} is no joint that moves; expected (body, joint)")
    return gains


def capture(client: Any = None, *, motors: Mapping[tuple[int, int], Mapping[str, Any]] | None = None,
            name: str = "pybullet", physics_client: int = 0) -> Step:
    """The contacts and joints of the step that Bullet has just taken, at the positions that the bodies had before it.

    Free bodies alone are a problem of kind "scene", in which a contact between two of them is in the middle of its ends, at
    which Bullet pushes them: friction at a gap or penetration then turns them a little less or more than in Bullet. Bodies
    with joints, and bodies that createConstraint ties, are one of kind "contact", whose coordinates are for each body the
    velocity and angular velocity of its base, if that moves, and the velocities of its joints.

    Bounded rows of that are limits of joints, point, fixed, prismatic and gear constraints with their greatest impulse, and
    the motors that `motors` tells. With `numSubSteps` the step is the last substep. Penetrations and errors of constraints
    are not pushed out, and an open limit may close within the step. Torques that were set and damping of joints act as
    forces at the old state.

    PyBullet has no words for targets, gains and forces of motors, nor for the impulses of limits and of constraints between
    bodies with useMaximalCoordinates. What acts as Bullet found it, or is left out, is a line of the step's `notes`, with how
    many there are: these, restitution, friction of rolling and spinning, and contacts' own stiffness. Of a body with links that was made with useMaximalCoordinates PyBullet shows its base alone.

    Args:
        client: the module `pybullet`, or a BulletClient. None: the module.
        motors: by (body, joint) the keyword arguments that setJointMotorControl2 was called with last, controlMode and
            others; of a joint on which it never was called, dict(controlMode=VELOCITY_CONTROL, force=1 / timestep).
        name: of the problem.
        physics_client: the number of the connection, if client is the module.

    Returns:
        A `Step` with Bullet's own impulses and velocity, and for pictures the poses of `shapes()`.

    Raises:
        InputError: a joint is planar, or motors has a key that is no joint.
    """
    import collections

    client, more = _connection(client, physics_client)
    settings = client.getPhysicsEngineParameters(**more)
    of_forces = settings["fixedTimeStep"]  # Bullet divides the impulses of a substep by it, too
    h = of_forces / max(settings["numSubSteps"], 1)
    world, notes = _World(client, more, h), collections.Counter[str]()
    rows, row_impulses = Rows(world.size), []
    _add_constraints(client, more, world, h, rows, row_impulses, notes)
    gains = _add_joints(client, more, world, dict(motors or {}), h, of_forces, rows, row_impulses, notes)
    is_scene = client.getNumConstraints(**more) == 0 and not any(of.joints or not of.floats for of in world.bodies.values())

    def named(body: int, link: int) -> str:
        of = f"{client.getBodyInfo(body, **more)[1].decode()} {body}".lstrip()
        return of if link < 0 else f"{of} {client.getJointInfo(body, link, **more)[12].decode()}"

    index = {body: i for i, body in enumerate(world.bodies)}
    contacts, gap, ids, normal, along, jacobians, frames = [], [], [], [], [], [], []
    for point in client.getContactPoints(**more):
        _, a, b, link_a, link_b, on_a, on_b, n, distance, force, force_1, tangent_1, force_2, tangent_2, *_ = point
        if a not in index and b not in index:
            continue
        dynamics = [client.getDynamicsInfo(*each, **more) for each in ((a, link_a), (b, link_b))]
        mu = min(dynamics[0][1] * dynamics[1][1], 10.0)
        notes["contacts with rolling or spinning friction, as the torques that Bullet found"] += any(
            each[6] or each[7] for each in dynamics)
        notes["contacts with restitution, left out"] += all(each[5] for each in dynamics)
        notes["contacts with a stiffness and damping of their own, which are hard"] += any(each[9] > 0 for each in dynamics)
        ends = [at for body, at in ((a, on_a), (b, on_b)) if body in index]  # Bullet pushes each body at its own end
        n, sign = np.array(n), 1.0
        J = world.jacobian(a, link_a, np.array(on_a))[3:] - world.jacobian(b, link_b, np.array(on_b))[3:]
        if a not in index:  # the immovable world has to be body_b
            a, b, link_a, link_b, n, sign, J = b, a, link_b, link_a, -n, -1.0, -J
        n /= np.linalg.norm(n)
        t1, t2 = sign * np.array(tangent_1), sign * np.array(tangent_2)
        tangent = t1 - n * (n @ t1)
        length = np.linalg.norm(tangent)
        tangent = tangent / length if length > 0.5 else _any_tangent(n, "contact")
        second = np.cross(n, tangent)
        pushed = of_forces * (force_1 * t1 + force_2 * t2)
        contacts.append(dict(body_a=index[a], body_b=index.get(b, -1), point=np.mean(ends, axis=0), normal=n,
                             tangent=tangent, mu=mu, b=max(distance, 0.0) / h))
        jacobians.append(np.array([n, tangent, second]) @ J)
        frames.append([*contacts[-1]["point"], *n, *tangent])
        gap.append(distance)
        ids.append(f"{named(a, link_a)} on {named(b, link_b)}")
        normal.append(of_forces * force)
        along.append([pushed @ tangent, pushed @ second] if mu > 0 else [0.0, 0.0])
    impulses = np.column_stack([normal, np.reshape(along, (-1, 2))])
    after = np.concatenate([of.velocity for of in world.bodies.values()] or [[]])

    def problem(velocity: np.ndarray, title: str) -> Problem:
        """With this velocity without contacts and rows."""
        if is_scene:
            bodies = []
            for of in world.bodies.values():
                v = velocity[of.first : of.first + 6]
                bodies.append(dict(mass=of.inertia[0, 0], inertia=of.inertia[3:, 3:], position=of.poses[-1][0],
                                   linear_velocity=v[:3], angular_velocity=v[3:]))
            return Problem.from_scene(bodies, contacts, title)
        fields = rows.fields()
        for row, direction, gain in gains:
            fields["b"][row] += gain * float(direction @ velocity)
        T = np.reshape(jacobians, (len(contacts), 3, world.size))
        return Problem(G=[of.inertia for of in world.bodies.values()], N=T[:, 0].T,
                       tangents=np.reshape(T[:, 1:], (2 * len(contacts), world.size)).T, mu=np.array([each["mu"] for each in contacts]),
                       v=velocity, b=np.array([each["b"] for each in contacts]), rows=fields, name=title)

    moved = problem(after, "")
    f = _native.complete_answer(moved._data, impulses, "pyramid", np.array(row_impulses) if len(rows) else None)
    free = 2 * after - moved._data.velocity(f)
    step = dict(gap=np.array(gap), contact_ids=numbered(ids), impulses=impulses, velocity=after,
                poses=_poses(client, more, world.poses()))
    if not is_scene:
        step.update(row_impulses=np.array(row_impulses) if len(rows) else None, contact_frames=frames)
    return Step(problem(free, name), notes=[f"{what}: {count}" for what, count in notes.items() if count], **step)
