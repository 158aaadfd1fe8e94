"""Captures of PyBullet, Drake and Pinocchio, with the real packages."""
import importlib
import json
import os
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np

import lcpbench
import lcpbench.drake
import lcpbench.pinocchio
import lcpbench.pybullet


def package(name):
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return None


pybullet, drake, pinocchio = package("pybullet"), package("pydrake.all"), package("pinocchio")
coal = package("coal")


def same_pose(test, step, k, position, quaternion):
    """The k-th shape stands there. @param quaternion  w first"""
    pose = lcpbench._files.pose_rows(step.poses)[k]
    np.testing.assert_allclose(pose[:3], position, atol=1e-6)
    test.assertAlmostEqual(abs(np.dot(pose[3:], quaternion)), 1, delta=1e-6)


def draws(test, step, shapes):
    """`lcpbench view` has the contacts, and every shape at its pose."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "r.scenes")
        with lcpbench.Recorder(file, shapes=shapes) as recorder:
            recorder.add(step, 7)
        shown = subprocess.run([lcpbench.find_program(), "view", file + "#7", "--solver", "auto", "--format", "json"],
                               capture_output=True, check=True).stdout
    scene, = json.loads(shown)["scenes"]
    test.assertEqual([each["type"] for each in scene["shapes"]][: len(shapes)], [each[1] for each in shapes])
    test.assertEqual(len(scene["poses"]), len(shapes))
    test.assertNotIn(None, scene["contacts"]["points"])
    test.assertEqual(scene["contacts"]["ids"], step.contact_ids)


def moves_as_captured(test, step, tolerance):
    """The engine's impulses take the velocity without contacts to the engine's velocity."""
    problem = step.problem
    z = lcpbench._native.complete_answer(problem._data, step.impulses, "pyramid", step.row_impulses)
    np.testing.assert_allclose(problem._data.velocity(z), step.velocity, atol=tolerance)


def rows_of(step):
    """By their names, of each bounded row its direction, bounds, offset, compliance and unit."""
    rows = step.problem.rows
    fields = ("lower", "upper", "b", "compliance", "unit")
    return {name: (rows["R"][:, i], *(rows[field][i] for field in fields)) for i, name in enumerate(rows["names"])}


def moves_to(test, step, velocity, tolerance=1e-9, **impulses):
    """The solution of the captured problem. @param impulses  of rows, by names with _ for spaces"""
    answer = lcpbench.solve(step.problem)
    test.assertEqual(answer.verdict, "solved")
    np.testing.assert_allclose(answer.velocity, velocity, atol=tolerance)
    names = [] if step.problem.rows is None else step.problem.rows["names"]
    for name, value in impulses.items():
        test.assertAlmostEqual(answer.row_impulses[names.index(name.replace("_", " "))], value, delta=tolerance, msg=name)


@unittest.skipIf(pybullet is None, "PyPI's pybullet is not installed")
class PyBullet(unittest.TestCase):
    def setUp(self):
        pybullet.connect(pybullet.DIRECT)
        self.addCleanup(pybullet.disconnect)
        self.build()

    def build(self):
        pybullet.resetSimulation()
        pybullet.setGravity(0, 0, -9.8)
        pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
        box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.1, 0.15])
        self.bodies = [pybullet.createMultiBody(1.5, box, basePosition=[0.01 * k, 0, 0.15 + 0.3 * k]) for k in range(3)]
        for body in self.bodies:
            pybullet.changeDynamics(body, -1, linearDamping=0, angularDamping=0, lateralFriction=0.6)
        pybullet.resetBaseVelocity(self.bodies[2], [0.5, 0.2, 0], [0.1, 0.3, 0.5])

    def test_the_velocity_without_contacts_is_that_of_gravity(self):
        for _ in range(30):
            before = np.concatenate([np.concatenate(pybullet.getBaseVelocity(body)) for body in self.bodies])
            poses = [pybullet.getBasePositionAndOrientation(body) for body in self.bodies]
            pybullet.stepSimulation()
        step = lcpbench.pybullet.capture(pybullet)
        self.assertGreaterEqual(step.problem.nc, 8)
        h = pybullet.getPhysicsEngineParameters()["fixedTimeStep"]
        linear = (step.problem.v - before).reshape(-1, 6)[:, :3]
        np.testing.assert_allclose(linear, np.tile([0, 0, -9.8 * h], (3, 1)), atol=1e-6)
        moves_as_captured(self, step, 1e-12)
        for body, (_, turned), G in zip(self.bodies, poses, step.problem.G[1::2]):  # of the positions before the step
            R = np.array(pybullet.getMatrixFromQuaternion(turned)).reshape(3, 3)
            inertia = R @ np.diag(pybullet.getDynamicsInfo(body, -1)[2]) @ R.T
            np.testing.assert_allclose(G, inertia, atol=1e-9)
        self.assertEqual(lcpbench.solve(step.problem).verdict, "solved")
        self.assertIn(lcpbench.check(step.problem, step.impulses).verdict, ("solved", "wrong"))
        self.assertEqual(len(set(step.contact_ids)), step.problem.nc)
        for k, (position, (x, y, z, w)) in enumerate(poses):  # shape 0 is the plane
            same_pose(self, step, 1 + k, position, (w, x, y, z))
        shapes = lcpbench.pybullet.shapes()
        self.assertEqual(shapes[0], (0, "plane", (0, 0, 1, 0)))
        np.testing.assert_allclose(shapes[1][2], [0.2, 0.1, 0.15])
        draws(self, step, shapes)

    def test_meshes_are_drawn_as_the_box_around_them(self):
        corners = [[x, y, z] for x in (0, 0.1) for y in (0, 0.2) for z in (0, 0.4)]
        mesh = pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=corners)
        turned = pybullet.getQuaternionFromEuler([0, 0, np.pi / 2])
        pybullet.createMultiBody(1, mesh, basePosition=[5, 0, 3], baseOrientation=turned)
        pybullet.stepSimulation()
        body, kind, half = lcpbench.pybullet.shapes()[-1]
        self.assertEqual(kind, "box")
        np.testing.assert_allclose(half, [0.05, 0.1, 0.2], atol=1e-6)
        pose = lcpbench.pybullet.capture().poses[body]
        np.testing.assert_allclose(pose[:3], [4.9, 0.05, 3.2], atol=1e-6)

    def test_the_last_substep_is_captured(self):
        steps = []
        for length, substeps, count in ((1 / 240, 0, 40), (1 / 60, 4, 10)):
            self.build()
            pybullet.setPhysicsEngineParameter(fixedTimeStep=length, numSubSteps=substeps)
            for _ in range(count):
                pybullet.stepSimulation()
            steps.append(lcpbench.pybullet.capture())
        short, last = steps
        self.assertGreater(max(short.problem.b), 0)
        for name in ("gap", "impulses", "velocity"):
            np.testing.assert_allclose(getattr(last, name), getattr(short, name), atol=1e-12, err_msg=name)
        for name in ("v", "b"):
            one, other = getattr(short.problem, name), getattr(last.problem, name)
            np.testing.assert_allclose(other, one, atol=1e-12, err_msg=name)
        moves_as_captured(self, last, 1e-12)

    def test_a_body_is_pushed_at_its_own_end_of_a_contact(self):
        for first in (0, 1):  # Bullet's contacts are from the first body to the second one
            pybullet.resetSimulation()
            pybullet.setGravity(0, 0, -9.8)
            floor = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[2, 2, 1])
            shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.1, 0.15])
            both = [lambda: pybullet.createMultiBody(0, floor, basePosition=[0, 0, -1]),
                    lambda: pybullet.createMultiBody(1.5, shape, basePosition=[0, 0, 0.14])]  # 1 cm too deep
            both = [both[k]() for k in (first, 1 - first)]
            box = both[1 - first]
            pybullet.changeDynamics(box, -1, linearDamping=0, angularDamping=0, lateralFriction=1)
            pybullet.resetBaseVelocity(box, [1, 0.5, 0], [0, 0, 2])
            pybullet.stepSimulation()
            step = lcpbench.pybullet.capture()
            self.assertGreater(np.abs(step.impulses[:, 1:]).max(), 1e-3)
            np.testing.assert_allclose(step.problem.v, [1, 0.5, -9.8 / 240, 0, 0, 2], atol=1e-9)

    def two_links(self, base_mass, joint):
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
        pybullet.createMultiBody(base_mass, sphere, linkMasses=[1], linkCollisionShapeIndices=[sphere],
                                 linkVisualShapeIndices=[-1],
                                 linkPositions=[[0, 0, 1]], linkOrientations=[[0, 0, 0, 1]],
                                 linkInertialFramePositions=[[0] * 3],
                                 linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0],
                                 linkJointTypes=[joint], linkJointAxis=[[0, 0, 1]])

    def empty(self, gravity=0.0):
        pybullet.resetSimulation()
        pybullet.setGravity(0, 0, gravity)

    def ball(self, x, velocity=(0, 0, 0), maximal=False):
        """A free ball of 2 kg and, unless it has maximal coordinates, 0.5 kg m^2, without damping."""
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
        body = pybullet.createMultiBody(2, sphere, basePosition=[x, 0, 0], useMaximalCoordinates=maximal)
        inertia = {} if maximal else dict(localInertiaDiagonal=[0.5, 0.5, 0.5])
        pybullet.changeDynamics(body, -1, linearDamping=0, angularDamping=0, **inertia)
        pybullet.resetBaseVelocity(body, velocity)
        pybullet.setCollisionFilterGroupMask(body, -1, 0, 0)
        return body

    def arms(self, count, motors_off=True):
        """One body: arms of 2 kg m^2 on hinges about z of an immovable base."""
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
        body = pybullet.createMultiBody(
            0, -1, linkMasses=[1] * count, linkCollisionShapeIndices=[sphere] * count, linkVisualShapeIndices=[-1] * count,
            linkPositions=[[k, 0, 0] for k in range(count)], linkOrientations=[[0, 0, 0, 1]] * count,
            linkInertialFramePositions=[[0] * 3] * count, linkInertialFrameOrientations=[[0, 0, 0, 1]] * count,
            linkParentIndices=[0] * count, linkJointTypes=[pybullet.JOINT_REVOLUTE] * count, linkJointAxis=[[0, 0, 1]] * count)
        for k in range(-1, count):
            pybullet.changeDynamics(body, k, linearDamping=0, angularDamping=0, jointDamping=0)
        for k in range(count):
            pybullet.changeDynamics(body, k, localInertiaDiagonal=[2, 2, 2])
            if motors_off:
                pybullet.setJointMotorControl2(body, k, pybullet.VELOCITY_CONTROL, force=0)
        return body

    def captured(self, **more):
        pybullet.stepSimulation()
        step = lcpbench.pybullet.capture(**more)
        moves_as_captured(self, step, 1e-12)
        return step

    def test_coordinates_of_bodies_with_joints_are_bullets(self):
        for base_mass, kinds in ((0, "RRR"), (1, "RPF"), (1, "PRR"), (0, "SRR")):
            self.empty()
            named = dict(R=pybullet.JOINT_REVOLUTE, P=pybullet.JOINT_PRISMATIC, F=pybullet.JOINT_FIXED,
                         S=pybullet.JOINT_SPHERICAL)
            box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.05, 0.1])
            body = pybullet.createMultiBody(
                base_mass, box, basePosition=[0, 0, 1], baseOrientation=[0, 0.6, 0, 0.8], linkMasses=[1, 2, 3],
                linkCollisionShapeIndices=[box] * 3, linkVisualShapeIndices=[-1] * 3, linkPositions=[[0.2, 0.1, 0]] * 3,
                linkOrientations=[[0, 0.28, 0, 0.96]] * 3, linkInertialFramePositions=[[0.2, 0.1, 0]] * 3,
                linkInertialFrameOrientations=[[0, 0, 0.6, 0.8]] * 3, linkParentIndices=[0, 1, 2],
                linkJointTypes=[named[kind] for kind in kinds], linkJointAxis=[[0, 1, 0], [0.6, 0.8, 0], [0, 0, 1]])
            rng = np.random.default_rng(0)
            pybullet.resetBaseVelocity(body, rng.standard_normal(3) * base_mass, rng.standard_normal(3) * base_mass)
            for k, kind in enumerate(kinds):
                pybullet.changeDynamics(body, k, linearDamping=0, angularDamping=0, jointDamping=0)
                if kind == "S":
                    pybullet.resetJointStateMultiDof(body, k, [0, 0.6, 0, 0.8], rng.standard_normal(3))
                elif kind != "F":
                    pybullet.resetJointState(body, k, *rng.standard_normal(2))
                    pybullet.setJointMotorControl2(body, k, pybullet.VELOCITY_CONTROL, force=0)
            links = [pybullet.getLinkState(body, k, computeLinkVelocity=1, computeForwardKinematics=1) for k in range(3)]
            now = lcpbench.pybullet._World(pybullet, {}, 0.0)  # the last step had no length: before it is now
            for k, (place, _, _, _, _, _, linear, angular) in enumerate(links):
                moves = now.jacobian(body, k, np.array(place)) @ now.bodies[body].velocity
                np.testing.assert_allclose(moves, [*angular, *linear], atol=1e-6)  # axes are known in single precision
            if "S" not in kinds:
                at = [pybullet.getJointState(body, k)[0] for k in range(3) if kinds[k] != "F"]
                M = np.array(pybullet.calculateMassMatrix(body, at))[-len(at) :, -len(at) :]
                np.testing.assert_allclose(now.bodies[body].inertia[-len(at) :, -len(at) :], M, atol=1e-6)
            pybullet.stepSimulation()
            before = lcpbench.pybullet._World(pybullet, {}, 1 / 240).poses()
            for k, link in enumerate(links):
                np.testing.assert_allclose(before[body, k][0], link[0], atol=1e-6)
            if base_mass:
                self.assertEqual(lcpbench.pybullet.capture().problem.kind, "contact")

    def test_motors_are_rows(self):
        h, speed = 1 / 240, dict(controlMode=pybullet.VELOCITY_CONTROL, targetVelocity=0.6)
        told = ((dict(speed, force=100), 0.6), (dict(speed, force=2), 0.5 + h), (dict(speed, velocityGain=0.5, force=100), 0.55),
                (dict(controlMode=pybullet.POSITION_CONTROL, targetPosition=0.02, positionGain=0.25, force=500), 0.25 * 0.02 / h),
                (dict(controlMode=pybullet.POSITION_CONTROL, targetPosition=0.02, maxVelocity=0.3, force=500), 0.3))
        for motor, moves in told:
            for is_told in (True, False):
                self.empty()
                body = self.arms(1)
                pybullet.resetJointState(body, 0, 0.0, 0.5)
                pybullet.setJointMotorControl2(body, 0, **motor)
                step = self.captured(motors={(body, 0): motor} if is_told else None)
                np.testing.assert_allclose(step.velocity, [moves], atol=1e-9)
                if is_told:
                    moves_to(self, step, [moves], motor_joint1=2 * (moves - 0.5))
                    np.testing.assert_allclose(step.row_impulses, [2 * (moves - 0.5)], atol=1e-9)  # Bullet's own
                    np.testing.assert_allclose(step.problem.v, [0.5], atol=1e-9)
                    limit = motor["force"] * h
                    np.testing.assert_allclose(rows_of(step)["motor joint1"][1:3], [-limit, limit])
                    self.assertEqual((step.problem.rows["unit"], step.notes), (["rad"], []))
                else:
                    self.assertEqual(step.notes, ["motors that were not told, as the forces that Bullet found: 1"])
                    np.testing.assert_allclose(step.problem.v, [moves], atol=1e-9)
        self.empty()
        body = self.arms(1, motors_off=False)  # as PyBullet makes it: a motor that brakes with 1 N m s in a step
        pybullet.resetJointState(body, 0, 0.0, 1.0)
        step = self.captured(motors={(body, 0): dict(controlMode=pybullet.VELOCITY_CONTROL, force=1 / h)})
        np.testing.assert_allclose(step.velocity, [0.5], atol=1e-9)
        moves_to(self, step, [0.5], motor_joint1=-1)
        for motors, said in (({(body, 3): motor}, "is no joint that moves"), ({(body, 0): {}}, "controlMode is None")):
            with self.assertRaisesRegex(lcpbench.InputError, f"^motors: .*{said}"):
                lcpbench.pybullet.capture(motors=motors)

    def test_a_limit_of_a_joint_is_a_row(self):
        h = 1 / 240
        for q, v, moves in ((0.4, 3, 3), (0.5 - h, 3, 1), (0.5 - h, -2, -2)):
            self.empty()
            with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
                link = '<inertial><mass value="1"/><inertia ixx="2" iyy="2" izz="2" ixy="0" ixz="0" iyz="0"/></inertial>'
                file.write(f'''<robot name="arm"><link name="base">{link}</link><link name="arm">{link}</link>
                    <joint name="joint1" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
                    <limit lower="-0.5" upper="0.5" effort="9" velocity="9"/></joint></robot>''')
                file.flush()
                body = pybullet.loadURDF(file.name, useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
            pybullet.changeDynamics(body, 0, linearDamping=0, angularDamping=0, jointDamping=0)
            pybullet.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
            pybullet.resetJointState(body, 0, q, v)
            step = self.captured()
            self.assertEqual(list(rows_of(step)), ["joint limit joint1 lower", "joint limit joint1 upper"])
            np.testing.assert_allclose(step.problem.v, [v], atol=1e-9)
            moves_to(self, step, [moves], 1e-9, joint_limit_joint1_upper=2 * (v - moves))
            self.assertEqual(step.notes, [])
        pybullet.resetJointState(body, 0, 0.51, 1)
        step = self.captured()
        self.assertLess(step.velocity[0], 1)
        self.assertEqual(step.notes, ["limits of joints that are reached, whose impulses PyBullet does not tell: they act as "
                                      "Bullet found them beside the rows: 1"])

    def test_a_gear_is_a_row(self):
        self.empty()
        body = self.arms(2)
        gear = pybullet.createConstraint(body, 0, body, 1, pybullet.JOINT_GEAR, [0, 0, 1], [0, 0, 0], [0, 0, 0])
        pybullet.changeConstraint(gear, gearRatio=-2, maxForce=10000)
        pybullet.resetJointState(body, 0, 0.0, 5.0)
        step = self.captured()
        # v_0 = 2 v_1: one coordinate s with v = (2 s, s), 2 (4 + 1) s = 2 (2 5).
        name, = step.problem.rows["names"]
        moves_to(self, step, [4, 2], **{name: -2})
        np.testing.assert_allclose(step.velocity, [4, 2], atol=1e-6)
        np.testing.assert_allclose(step.problem.v, [5, 0], atol=1e-9)
        np.testing.assert_allclose(rows_of(step)[name][1:3], [-10000 / 240, 10000 / 240])
        pybullet.changeConstraint(gear, gearRatio=-2, maxForce=24)
        pybullet.resetJointState(body, 0, 0.0, 5.0)
        pybullet.resetJointState(body, 1, 0.0, 0.0)
        moves_to(self, self.captured(), [4.95, 0.1], **{name: -0.1})  # slips

    def test_constraints_between_bodies_are_rows(self):
        # The balls of 2 kg and 0.5 kg m^2 at 0 and 2 m, of which one moves; tied at a point of the first one.
        f = 3 / (0.5 + 4 / 0.5 + 0.5)
        w = -(2 * 1.5 * 1 * 1 + 2 * 1.5 * 1) / (0.5 + 0.5 + 2 + 2)
        expected = {
            pybullet.JOINT_POINT2POINT: [0.5, 3 - f / 2, 0, 0, 0, -2 * f / 0.5, 0.5, f / 2, 0, 0, 0, 0],
            pybullet.JOINT_FIXED: [0.5, 1.5 - w, 0, 0, 0, w, 0.5, 1.5 + w, 0, 0, 0, w],
            pybullet.JOINT_PRISMATIC: [1, 1.5 - w, 0, 0, 0, w, 0, 1.5 + w, 0, 0, 0, w]}
        for maximal in (False, True):
            for kind, velocity in expected.items():
                if maximal and kind == pybullet.JOINT_PRISMATIC:
                    continue  # PyBullet has none
                self.empty()
                bodies = [self.ball(x, v, maximal) for x, v in ((0, [1, 3, 0]), (2, [0, 0, 0]))]
                pybullet.createConstraint(bodies[0], -1, bodies[1], -1, kind, [1, 0, 0], [2, 0, 0], [0, 0, 0])
                step = self.captured()
                self.assertEqual(step.problem.rows["unit"], ["m"] * 3 if kind == pybullet.JOINT_POINT2POINT else
                                 ["m", "m", "m", "rad", "rad", "rad"] if kind == pybullet.JOINT_FIXED else ["m"] * 2 + ["rad"] * 3)
                moves_to(self, step, velocity if not maximal else step.velocity, 1e-4 if maximal else 1e-9)
                if maximal:
                    self.assertEqual([each.split(",")[0] for each in step.notes],
                                     ["constraints whose impulses PyBullet does not tell"])
                else:
                    np.testing.assert_allclose(step.velocity, velocity, atol=1e-3)
                    np.testing.assert_allclose(step.problem.v, [1, 3] + [0] * 10, atol=1e-9)
                    self.assertEqual((step.notes, rows_of(step)[step.problem.rows["names"][0]][1]), ([], -500))

    def test_a_link_that_touches_has_a_contact_in_its_coordinates(self):
        for base_mass in (0, 1):
            self.empty(-9.8)
            pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
            sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
            tip = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, collisionFramePosition=[1, 0, 0])
            body = pybullet.createMultiBody(
                base_mass, sphere, basePosition=[0, 0, 0.1], linkMasses=[1], linkCollisionShapeIndices=[tip],
                linkVisualShapeIndices=[-1], linkPositions=[[0, 0, 0]], linkOrientations=[[0, 0, 0, 1]],
                linkInertialFramePositions=[[1, 0, 0]], linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0],
                linkJointTypes=[pybullet.JOINT_REVOLUTE], linkJointAxis=[[0, 1, 0]])
            pybullet.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
            for k in (-1, 0):
                pybullet.changeDynamics(body, k, linearDamping=0, angularDamping=0, jointDamping=0, localInertiaDiagonal=[0.1] * 3,
                                        lateralFriction=0)
            step = self.captured()
            fall, turn = 9.8 / 240, 9.8 / 240 / (1 + 0.1)  # free, the base falls as fast as the link
            np.testing.assert_allclose(step.problem.v, [turn] if base_mass == 0 else [0, 0, -fall, 0, 0, 0, 0], atol=1e-7)
            self.assertEqual(sorted(step.contact_ids), ["1 link1 on 0", "1 on 0"][: 1 + base_mass])
            np.testing.assert_allclose(np.abs(np.array(step.contact_frames)[:, 5]), 1)
            moves_to(self, step, 0 * step.velocity, 1e-7)
            np.testing.assert_allclose(step.impulses[:, 0].sum(), (1 + base_mass) * fall, rtol=0.1)  # Bullet's own
            draws(self, step, lcpbench.pybullet.shapes())

    def test_what_contacts_have_beside_friction_is_noted(self):
        for body in (0, 1):
            pybullet.changeDynamics(body, -1, restitution=0.5, contactStiffness=1e4, contactDamping=1e2)
        pybullet.changeDynamics(1, -1, spinningFriction=0.1)
        for _ in range(30):
            pybullet.stepSimulation()
        step = lcpbench.pybullet.capture()
        pairs = [each.split(" #")[0].split(" on ") for each in step.contact_ids]
        on_floor, of_first = sum("0" in pair for pair in pairs), sum("1" in pair for pair in pairs)
        self.assertGreater(of_first, on_floor)
        self.assertGreater(on_floor, 2)
        self.assertEqual(step.notes, [
            f"contacts with rolling or spinning friction, as the torques that Bullet found: {of_first}",
            f"contacts with restitution, left out: {on_floor}",
            f"contacts with a stiffness and damping of their own, which are hard: {of_first}"])

    def test_a_contact_has_the_friction_of_its_link(self):
        pybullet.resetSimulation()
        self.two_links(0, pybullet.JOINT_FIXED)
        pybullet.changeDynamics(0, 0, lateralFriction=0.1)  # the upper ball, on which another one slides
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
        ball = pybullet.createMultiBody(1, sphere, basePosition=[0, 0, 1.199])
        pybullet.changeDynamics(ball, -1, lateralFriction=0.5)
        pybullet.resetBaseVelocity(ball, [1, 0, -1])
        pybullet.stepSimulation()
        step = lcpbench.pybullet.capture()
        np.testing.assert_allclose(step.problem.mu, 0.05)
        (normal, *along), = step.impulses
        self.assertAlmostEqual(np.abs(along).sum(), 0.05 * normal)


@unittest.skipIf(drake is None, "PyPI's drake is not installed")
class Drake(unittest.TestCase):
    def plant(self, hydroelastic=False, sampled=False, approximation="kLagged"):
        builder = drake.DiagramBuilder()
        plant, scene_graph = drake.AddMultibodyPlantSceneGraph(builder, 0.005)
        model = drake.ContactModel.kHydroelasticWithFallback if hydroelastic else drake.ContactModel.kPoint
        plant.set_contact_model(model)
        plant.SetUseSampledOutputPorts(sampled)
        plant.set_discrete_contact_approximation(getattr(drake.DiscreteContactApproximation, approximation))

        def properties(compliant):
            result = drake.ProximityProperties()
            drake.AddContactMaterial(dissipation=1.0, point_stiffness=1e6, friction=drake.CoulombFriction(0.5, 0.5),
                                     properties=result)
            if hydroelastic and compliant:
                drake.AddCompliantHydroelasticProperties(0.1, 1e6, result)
            elif hydroelastic:
                drake.AddRigidHydroelasticProperties(result)
            return result

        here = drake.RigidTransform()
        plant.RegisterCollisionGeometry(plant.world_body(), here, drake.HalfSpace(), "floor", properties(False))
        for k in range(2):
            inertia = drake.SpatialInertia.SolidBoxWithMass(1.2, 0.2, 0.2, 0.2)
            body = plant.AddRigidBody(f"box{k}", inertia)
            if hydroelastic:
                plant.RegisterCollisionGeometry(body, here, drake.Box(0.2, 0.2, 0.2), f"g{k}", properties(True))
            else:
                for i, at in enumerate(np.ndindex(2, 2, 2)):
                    corner = drake.RigidTransform(0.19 * np.array(at) - 0.095)
                    plant.RegisterCollisionGeometry(body, corner, drake.Sphere(0.005), f"g{k}-{i}", properties(True))
        arm = plant.AddRigidBody("arm", drake.SpatialInertia.SolidBoxWithMass(0.5, 0.4, 0.05, 0.05))
        plant.AddJoint(drake.RevoluteJoint("hinge", plant.world_frame(), arm.body_frame(), [0, 1, 0], damping=0.2))
        plant.Finalize()
        diagram = builder.Build()
        simulator = drake.Simulator(diagram)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        for k in range(2):
            body = plant.GetBodyByName(f"box{k}")
            plant.SetFreeBodyPose(context, body, drake.RigidTransform([0.5 * k + 1, 0, 0.0999]))
            plant.SetFreeBodySpatialVelocity(context, body, drake.SpatialVelocity([0, 0, 0.2], [0.4 * k, 0.1, 0]))
        simulator.AdvanceTo(0.05)
        return plant, context, simulator

    def test_points(self):
        plant, context, simulator = self.plant()
        step = lcpbench.drake.capture(plant, context)
        self.assertGreaterEqual(step.problem.nc, 4)
        moves_as_captured(self, step, 1e-9)  # through Drake's generalized forces: the Jacobians agree
        shapes = lcpbench.drake.shapes(plant, context)
        self.assertEqual(sorted({each[1] for each in shapes}), ["plane", "sphere"])
        self.assertIn("g0-", step.contact_ids[0])
        draws(self, step, shapes)
        # Each point is on a ball: poses and frames are those of one world.
        balls = step.poses[[each[0] for each in shapes if each[1] == "sphere"], :3]
        for frame in step.contact_frames:
            self.assertLess(np.linalg.norm(balls - frame[:3], axis=1).min(), 0.006)
        simulator.AdvanceTo(0.055)
        np.testing.assert_allclose(plant.GetVelocities(context), step.velocity, atol=1e-9)
        self.assertEqual(lcpbench.solve(step.problem).verdict, "solved")
        self.assertLess(lcpbench.check(step.problem, step.impulses).errors["violation_m_per_s"], 0.05)

    def test_the_velocity_without_contacts_has_the_damping_of_joints_as_drake_does(self):
        for approximation in ("kSap", "kTamsi", "kLagged", "kSimilar"):
            plant, context, simulator = self.plant(approximation=approximation)
            step = lcpbench.drake.capture(plant, context)
            hinge, h = plant.GetJointByName("hinge"), plant.time_step()
            k, v, M = hinge.velocity_start(), plant.GetVelocities(context), plant.CalcMassMatrix(context)
            forces = plant.CalcGravityGeneralizedForces(context) - plant.CalcBiasTerm(context)
            moves = M @ (step.problem.v - v) / h - forces
            damped = v if approximation == "kTamsi" else step.problem.v
            self.assertAlmostEqual(moves[k], -0.2 * damped[k], delta=1e-9)
            self.assertEqual(step.problem.G[k, k] > M[k, k], approximation != "kTamsi")
            self.assertEqual(len(set(step.contact_ids)), step.problem.nc)

    def test_faces_of_hydroelastic_contacts_are_points(self):
        plant, context, _ = self.plant(hydroelastic=True)
        step = lcpbench.drake.capture(plant, context)
        self.assertGreaterEqual(step.problem.nc, 8)
        self.assertIsNone(step.impulses)
        self.assertEqual(np.shape(step.contact_frames), (step.problem.nc, 9))
        np.testing.assert_allclose(np.abs(np.array(step.contact_frames)[:, 5]), 1, atol=1e-9)  # upright normals
        self.assertIn(" on ", step.contact_ids[0])
        # Normals point from the floor into the boxes: a box that rises separates at each of its points.
        for k in range(2):
            box = plant.GetBodyByName(f"box{k}")
            plant.SetFreeBodySpatialVelocity(context, box, drake.SpatialVelocity([0] * 3, [0, 0, 1]))
        np.testing.assert_allclose(step.problem.N.T @ plant.GetVelocities(context), 1, atol=1e-2)
        self.assertEqual(lcpbench.solve(step.problem).verdict, "solved")

    def mechanism(self, add, approximation="kSap"):
        """A plant of 10 ms without gravity. @param add  adds to it  @returns it, its context, and what keeps them alive"""
        builder = drake.DiagramBuilder()
        plant, _ = drake.AddMultibodyPlantSceneGraph(builder, 0.01)
        plant.SetUseSampledOutputPorts(False)
        plant.set_discrete_contact_approximation(getattr(drake.DiscreteContactApproximation, approximation))
        plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        add(plant)
        plant.Finalize()
        diagram = builder.Build()
        root = diagram.CreateDefaultContext()
        return plant, plant.GetMyMutableContextFromRoot(root), (diagram, root)

    def arms(self, count, **options):
        """Arms of 2 kg m^2 on hinges of the world."""
        def add(plant):
            inertia = drake.SpatialInertia(1.0, np.zeros(3), drake.UnitInertia(2, 2, 2))
            for k in range(count):
                arm = plant.AddRigidBody(f"arm{k}", inertia)
                plant.AddJoint(drake.RevoluteJoint(f"hinge{k}", plant.world_frame(), arm.body_frame(), [0, 1, 0], **options))
        return add

    def test_a_limit_of_a_joint_is_a_row(self):
        for approximation in ("kSap", "kTamsi"):
            plant, context, kept = self.mechanism(self.arms(1, pos_lower_limit=-1, pos_upper_limit=0.5), approximation)
            for q, v, torque, moves, impulse in ((0.5, 3, 0, 0, 6), (0.5, 0, 4, 0, 0.04), (0.48, 3, 0, 2, 2), (0.4, 3, 0, 3, 0),
                                                 (0.6, -1, 0, -1, 0), (0.6, 1, 0, 0, 2)):
                plant.SetPositions(context, [q])
                plant.SetVelocities(context, [v])
                plant.get_applied_generalized_force_input_port().FixValue(context, [torque])
                step = lcpbench.drake.capture(plant, context)
                self.assertEqual((list(rows_of(step)), step.notes),
                                 (["joint limit hinge0 lower", "joint limit hinge0 upper"], []))
                np.testing.assert_allclose(step.problem.v, [v + 0.01 * torque / 2], atol=1e-12)
                moves_as_captured(self, step, 1e-12)
                moves_to(self, step, [moves], joint_limit_hinge0_upper=impulse, joint_limit_hinge0_lower=0)
        self.assertEqual(step.problem.rows["unit"], ["rad", "rad"])

    def test_a_coupler_is_a_gear(self):
        def add(plant):
            self.arms(2)(plant)
            plant.AddCouplerConstraint(plant.GetJointByName("hinge0"), plant.GetJointByName("hinge1"), 2.0)
        plant, context, kept = self.mechanism(add)
        plant.SetVelocities(context, [5, 0])
        step = lcpbench.drake.capture(plant, context)
        # One coordinate s with v = (2 s, s): 2 (4 + 1) s = 2 (2 5).
        moves_to(self, step, [4, 2], coupler_hinge0_and_hinge1=-2)
        moves_as_captured(self, step, 1e-9)
        np.testing.assert_allclose(step.velocity, [4, 2], rtol=1e-3)  # nearly rigid in Drake
        np.testing.assert_allclose(step.row_impulses, [-2], rtol=1e-3)
        identifier, = plant.GetConstraintIds()
        plant.SetConstraintActiveStatus(context, identifier, False)
        self.assertIsNone(lcpbench.drake.capture(plant, context).problem.rows)

    def test_a_controller_with_an_effort_limit_is_a_row(self):
        p, d, h = 30.0, 4.0, 0.01
        def add(plant):
            self.arms(1)(plant)
            motor = plant.AddJointActuator("motor", plant.GetJointByName("hinge0"), 5.0)
            motor.set_controller_gains(drake.PdControllerGains(p=p, d=d))
        plant, context, kept = self.mechanism(add)
        instance = plant.GetBodyByName("arm0").model_instance()
        desired, forward = plant.get_desired_state_input_port(instance), plant.get_actuation_input_port(instance)
        self.assertIsNone(lcpbench.drake.capture(plant, context).problem.rows)  # disarmed
        plant.SetPositions(context, [0.1])
        plant.SetVelocities(context, [0.2])
        forward.FixValue(context, [0.5])
        for target in (0.15, 4.0, -4.0):
            desired.FixValue(context, [target, 0.3])
            step = lcpbench.drake.capture(plant, context)
            # 2 (v+ - v) = h u, u = -p (q + h v+ - target) - d (v+ - 0.3) + 0.5, between -5 and 5.
            v = (2 * 0.2 + h * (p * (target - 0.1) + d * 0.3 + 0.5)) / (2 + h * (d + h * p))
            impulse = np.clip(2 * (v - 0.2), -5 * h, 5 * h)
            moves_to(self, step, [0.2 + impulse / 2], motor_motor=impulse)
            np.testing.assert_allclose(step.row_impulses, [impulse], atol=1e-9)  # Drake's own
            self.assertEqual(rows_of(step)["motor motor"][1:3] + rows_of(step)["motor motor"][5:], (-0.05, 0.05, "rad"))
            moves_as_captured(self, step, 1e-9)
            self.assertEqual(lcpbench.check(step).verdict, "solved")

    def test_bodies_that_are_tied(self):
        ball = drake.SpatialInertia(2.0, np.zeros(3), drake.UnitInertia(0.5, 0.5, 0.5))
        def tied(tie):
            def add(plant):
                a, b = (plant.AddRigidBody(name, ball) for name in "ab")
                tie(plant, a, b)
            plant, context, kept = self.mechanism(add)
            plant.SetFreeBodyPose(context, plant.GetBodyByName("b"), drake.RigidTransform([2, 0, 0]))
            plant.SetFreeBodySpatialVelocity(context, plant.GetBodyByName("a"), drake.SpatialVelocity([0, 0, 0], [1, 3, 0]))
            step = lcpbench.drake.capture(plant, context)
            moves_as_captured(self, step, 1e-9)
            self.assertEqual(step.notes, [])
            return step, kept

        here, there = np.zeros(3), np.array([2.0, 0, 0])
        step, kept = tied(lambda plant, a, b: plant.AddDistanceConstraint(a, here, b, here, 2.0))
        moves_to(self, step, [0, 0, 0, 0.5, 3, 0, 0, 0, 0, 0.5, 0, 0], distance_a_and_b=1.0)
        # A spring of 200 N/m and 5 N s/m, 0.5 m too long. It pulls with f = h (200 (0.5 + h w) + 5 w), and both balls then
        # part with w = -1 - f.
        step, kept = tied(lambda plant, a, b: plant.AddDistanceConstraint(a, here, b, here, 1.5, 200.0, 5.0))
        f = (200 * (0.5 - 0.01) - 5) * 0.01 / (1 + 0.01 * (200 * 0.01 + 5))
        moves_to(self, step, [0, 0, 0, 1 + f / 2, 3, 0, 0, 0, 0, -f / 2, 0, 0], distance_a_and_b=-f)
        np.testing.assert_allclose(step.velocity, lcpbench.solve(step.problem).velocity, atol=1e-6)
        step, kept = tied(lambda plant, a, b: plant.AddBallConstraint(a, there, b, here))
        self.assertEqual(list(rows_of(step)), [f"ball a and b {axis}" for axis in "xyz"])
        # b is a point of a at 2 m: the impulse f along y moves a by f / 2 and turns it by 2 f; b moves by f / 2.
        f = 3 / (0.5 + 4 + 0.5)
        moves_to(self, step, [0, 0, -2 * f, 0.5, 3 - f / 2, 0, 0, 0, 0, 0.5, f / 2, 0])
        np.testing.assert_allclose(step.velocity, lcpbench.solve(step.problem).velocity, atol=2e-3)
        step, kept = tied(lambda plant, a, b: plant.AddWeldConstraint(a, drake.RigidTransform(there), b,
                                                                      drake.RigidTransform()))
        self.assertEqual(step.problem.rows["unit"], ["m"] * 3 + ["rad"] * 3)
        # One body of 4 kg, of inertia 1 + 1 + 2 + 2 about its middle, with the angular momentum -2 3 1.
        moves_to(self, step, [0, 0, -1, 0.5, 0.5, 0, 0, 0, -1, 0.5, 2.5 - 3, 0][:3] + [0.5, 2.5, 0, 0, 0, -1, 0.5, 0.5, 0])
        np.testing.assert_allclose(step.velocity, lcpbench.solve(step.problem).velocity, atol=2e-3)

    def test_a_weld_that_has_come_apart_holds_in_its_middle(self):
        def add(plant):
            inertia = drake.SpatialInertia(2.0, np.zeros(3), drake.UnitInertia(0.5, 0.5, 0.5))
            a, b = (plant.AddRigidBody(name, inertia) for name in "ab")
            plant.AddWeldConstraint(a, drake.RigidTransform([2.0, 0, 0]), b, drake.RigidTransform())
        plant, context, kept = self.mechanism(add)
        plant.SetFreeBodyPose(context, plant.GetBodyByName("b"), drake.RigidTransform([2.2, 0, 0]))
        direction = rows_of(lcpbench.drake.capture(plant, context))["weld a and b y"][0]  # of turns, then velocities
        np.testing.assert_allclose(direction, [0, 0, -2.1, 0, -1, 0, 0, 0, -0.1, 0, 1, 0], atol=1e-12)

    def test_an_actuator_without_a_controller_is_a_force(self):
        def add(plant):
            self.arms(1)(plant)
            motor = plant.AddJointActuator("motor", plant.GetJointByName("hinge0"), 50.0)
            motor.set_default_rotor_inertia(0.01)
            motor.set_default_gear_ratio(10.0)
        plant, context, kept = self.mechanism(add)
        plant.get_actuation_input_port(plant.GetBodyByName("arm0").model_instance()).FixValue(context, [7])
        step = lcpbench.drake.capture(plant, context)
        self.assertEqual((step.problem.rows, step.notes), (None, []))
        moves_to(self, step, [0.01 * 7 / (2 + 0.01 * 10**2)], 1e-12)

    def test_a_locked_joint_does_not_move(self):
        plant, context, kept = self.mechanism(self.arms(2))
        plant.GetJointByName("hinge1").Lock(context)
        plant.get_applied_generalized_force_input_port().FixValue(context, [3, 4])
        step = lcpbench.drake.capture(plant, context)
        moves_to(self, step, [0.015, 0], lock_hinge1=-0.04)
        moves_as_captured(self, step, 1e-12)

    def test_forces_on_bodies_and_forces_that_are_not_known(self):
        plant, context, kept = self.mechanism(self.arms(1, damping=0.3))
        plant.SetVelocities(context, [2])
        force = drake.ExternallyAppliedSpatialForce()
        force.body_index, force.p_BoBq_B = plant.GetBodyByName("arm0").index(), np.array([0.5, 0, 0])
        force.F_Bq_W = drake.SpatialForce([0, 1, 0], [0, 0, -4])  # turns by 0.5 4 more about y
        plant.get_applied_spatial_force_input_port().FixValue(context, [force])
        step = lcpbench.drake.capture(plant, context)
        self.assertEqual(step.notes, [])
        moves_to(self, step, [(2 * 2 + 0.01 * 3) / (2 + 0.01 * 0.3)], 1e-12)
        with unittest.mock.patch("lcpbench.drake._forces", return_value=np.zeros(1)):
            step = lcpbench.drake.capture(plant, context)
        self.assertEqual(step.notes, ["coordinates on which other forces act as Drake found them: 1"])
        moves_as_captured(self, step, 1e-12)

    def test_sampled_and_continuous_plants_are_outside(self):
        plant, context, _ = self.plant(sampled=True)
        with self.assertRaisesRegex(lcpbench.InputError, "SetUseSampledOutputPorts"):
            lcpbench.drake.capture(plant, context)
        plant = drake.MultibodyPlant(0.0)
        plant.Finalize()
        with self.assertRaisesRegex(lcpbench.InputError, "continuous"):
            lcpbench.drake.capture(plant, plant.CreateDefaultContext())


@unittest.skipIf(pinocchio is None, "PyPI's pin is not installed")
class Pinocchio(unittest.TestCase):
    def test_the_delassus_matrix_is_the_engines(self):
        model = pinocchio.buildSampleModelManipulator()
        data = model.createData()
        rng = np.random.default_rng(2)
        q, v, tau = pinocchio.randomConfiguration(model), rng.standard_normal(model.nv), rng.standard_normal(model.nv)
        models, datas = pinocchio.StdVec_ConstraintModel(), pinocchio.StdVec_ConstraintData()
        for joint, mu in ((4, 0.5), (6, 0.8)):
            pinocchio.forwardKinematics(model, data, q)
            placement = pinocchio.SE3.Random()
            contact = pinocchio.PointContactConstraintModel(model, joint, placement, 0, data.oMi[joint] * placement)
            contact.setFriction(mu)
            models.append(pinocchio.ConstraintModel(contact))
            datas.append(models[-1].createData())
        h = 0.01
        step = lcpbench.pinocchio.capture(model, data, q, v, tau, models, datas, h)
        problem = step.problem
        self.assertEqual((problem.nc, list(problem.mu)), (2, [0.5, 0.8]))
        np.testing.assert_allclose(problem.v, v + h * pinocchio.aba(model, data, q, v, tau), atol=1e-12)
        pinocchio.crba(model, data, q, pinocchio.Convention.WORLD)
        for each, its_data in zip(models, datas):
            each.calc(model, data, its_data)
        cholesky = pinocchio.ConstraintCholeskyDecomposition(model, data, models, datas)
        cholesky.compute(model, data, models, datas, 0.0)
        engine = np.array(cholesky.getInverseOperationalSpaceInertiaMatrix())
        ours = problem.delassus()
        rows = [2, 3, 0, 6, 7, 1]  # x, y, z of both contacts: D's first two directions, N
        np.testing.assert_allclose(ours[np.ix_(rows, rows)], engine, atol=1e-10)
        self.assertEqual(lcpbench.solve(problem).verdict, "solved")

    def test_wrong_arguments_are_named(self):
        model = pinocchio.buildSampleModelManipulator()
        contact = pinocchio.PointContactConstraintModel(model, 1)
        good = dict(model=model, data=model.createData(), q=pinocchio.neutral(model), v=np.zeros(model.nv),
                    tau=np.zeros(model.nv), constraint_models=[contact], constraint_datas=[contact.createData()],
                    h=0.01)
        self.assertEqual(lcpbench.pinocchio.capture(**good).problem.nc, 1)
        for name, wrong in (("q", "x"), ("q", np.zeros(3)), ("v", None), ("tau", np.zeros(2)), ("gap", [0, 0]),
                            ("gap", "x"), ("constraint_datas", []), ("h", 0)):
            with self.assertRaisesRegex((lcpbench.InputError, TypeError), f"^{name}[: ].*$"):
                lcpbench.pinocchio.capture(**{**good, name: wrong})

    def test_normals_point_into_the_second_joints_body(self):
        model = pinocchio.Model()
        joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "free")
        model.appendBodyToJoint(joint, pinocchio.Inertia(2, np.zeros(3), np.eye(3)), pinocchio.SE3.Identity())
        floor = pinocchio.SE3.Identity()
        contact = pinocchio.PointContactConstraintModel(model, 0, floor, joint, floor)
        v = np.array([0, 0, -1.0, 0, 0, 0])
        step = lcpbench.pinocchio.capture(model, model.createData(), pinocchio.neutral(model), v, np.zeros(6),
                                          [contact], [contact.createData()], 0.01)
        np.testing.assert_allclose(lcpbench.solve(step.problem).normal_impulses, [2 * (1 + 9.81 * 0.01)])

    def test_contacts_have_names_and_places_and_geometries_poses(self):
        model, geometry = pinocchio.Model(), pinocchio.GeometryModel()
        joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root")
        model.appendBodyToJoint(joint, pinocchio.Inertia(2, np.zeros(3), np.eye(3)), pinocchio.SE3.Identity())
        foot = pinocchio.SE3(np.eye(3), np.array([0.1, 0, -0.2]))
        model.addFrame(pinocchio.Frame("FL_foot", joint, foot, pinocchio.FrameType.OP_FRAME))
        for name, parent, shape, at in (("sole", joint, coal.Box(0.1, 0.2, 0.04), foot),
                                        ("ball", joint, coal.Sphere(0.3), pinocchio.SE3.Identity()),
                                        ("floor", 0, coal.Halfspace(np.array([0, 0, 1.0]), 0.5), pinocchio.SE3.Identity())):
            geometry.addGeometryObject(pinocchio.GeometryObject(name, parent, at, shape))
        tilted = pinocchio.SE3(pinocchio.utils.rotate("x", 0.3), np.zeros(3))
        contacts = [pinocchio.PointContactConstraintModel(model, 0, tilted, joint, foot) for _ in range(3)]
        contacts[1].geom1_id, contacts[1].geom2_id = 2, 0
        contacts[2].name = "mine"
        q = np.array([0, 0, 0.7, 0, 0, np.sqrt(0.5), np.sqrt(0.5)])  # a quarter turn
        step = lcpbench.pinocchio.capture(model, model.createData(), q, np.zeros(6), np.zeros(6), contacts,
                                          [each.createData() for each in contacts], 0.01, geometry=geometry)
        self.assertEqual(step.contact_ids, ["FL_foot on universe", "sole on floor", "mine"])
        self.assertRegex(lcpbench.check(step, np.zeros((3, 3))).worst, "FL_foot on universe|sole on floor|mine")
        np.testing.assert_allclose(step.contact_frames[0], [0, 0.1, 0.5, 0, -np.sin(0.3), np.cos(0.3), 1, 0, 0], atol=1e-12)
        half = np.sqrt(0.5)
        for k, position in enumerate(([0, 0.1, 0.5], [0, 0, 0.7])):
            same_pose(self, step, k, position, (half, 0, 0, half))
        same_pose(self, step, 2, (0, 0, 0), (1, 0, 0, 0))
        shapes = lcpbench.pinocchio.shapes(geometry)
        self.assertEqual([each[:2] for each in shapes], [(0, "box"), (1, "sphere"), (2, "plane")])
        np.testing.assert_allclose(shapes[0][2], [0.05, 0.1, 0.02])
        draws(self, step, shapes)

    def test_other_constraints_are_outside(self):
        model = pinocchio.buildSampleModelManipulator()
        with self.assertRaisesRegex(lcpbench.InputError, r"constraint_models\[0\]: float is outside"):
            lcpbench.pinocchio.capture(model, model.createData(), pinocchio.neutral(model), np.zeros(model.nv),
                                       np.zeros(model.nv), [1.0], [None], 0.01)

    def arm(self, *joints):
        """A chain of links of 2 kg m^2 or 2 kg, each on a joint at the place of the last."""
        model = pinocchio.Model()
        model.gravity.linear = np.zeros(3)
        last = 0
        for k, joint in enumerate(joints):
            last = model.addJoint(last, joint, pinocchio.SE3.Identity(), f"joint{k}")
            model.appendBodyToJoint(last, pinocchio.Inertia(2, np.zeros(3), 2 * np.eye(3)), pinocchio.SE3.Identity())
        model.lowerPositionLimit, model.upperPositionLimit = np.full(model.nq, -0.5), np.full(model.nq, 0.5)
        model.lowerDryFrictionLimit, model.upperDryFrictionLimit = np.full(model.nv, -3.0), np.full(model.nv, 3.0)
        return model

    def captured(self, model, q, v, tau, *constraints, **more):
        return lcpbench.pinocchio.capture(model, model.createData(), np.array(q), np.array(v, float), np.array(tau, float),
                                          constraints, [each.createData() for each in constraints], 0.01, **more)

    def test_a_limit_of_a_joint_is_a_row(self):
        for joint, unit in ((pinocchio.JointModelRY(), "rad"), (pinocchio.JointModelPX(), "m")):
            model = self.arm(joint)
            for q, v, moves, impulse in ((0.5, 3, 0, 6), (0.48, 3, 2, 2), (0.4, 3, 3, 0), (0.6, -1, -1, 0)):
                step = self.captured(model, [q], [v], [0], pinocchio.JointLimitConstraintModel(model))
                self.assertEqual(step.problem.rows["names"], ["limit joint0 lower", "limit joint0 upper"])
                moves_to(self, step, [moves], limit_joint0_upper=impulse)
            self.assertEqual(step.problem.rows["unit"], [unit, unit])
            near = pinocchio.JointLimitConstraintModel(model, [1], np.array([-0.5]), np.array([0.5]), np.array([0.1]))
            near.makeSelectionFilteredByLimitProximity(np.array([0.45]))
            self.assertEqual(list(rows_of(self.captured(model, [0.45], [0], [0], near))), ["limit joint0 upper"])

    def test_friction_of_a_joint_is_a_row(self):
        model = self.arm(pinocchio.JointModelRY(), pinocchio.JointModelPX())
        friction = pinocchio.JointFrictionConstraintModel(model, [1])
        for v, moves, impulse in ((1, 1 - 0.015, -0.03), (0.01, 0, -0.02), (-1, -1 + 0.015, 0.03)):
            step = self.captured(self.arm(pinocchio.JointModelRY()), [0], [v], [0],
                                 pinocchio.JointFrictionConstraintModel(self.arm(pinocchio.JointModelRY())))
            moves_to(self, step, [moves], friction_joint0=impulse)
        step = self.captured(model, [0, 0], [0, 0], [2, 1], friction)
        self.assertEqual(list(rows_of(step)), ["friction joint0"])
        friction.setCompliance(np.array([0.1]))
        self.assertEqual(self.captured(model, [0, 0], [0, 0], [2, 1], friction).notes,
                         ["constraints with a compliance, left out: 1"])

    def test_anchors_and_rigid_constraints_close_loops(self):
        model = self.arm(pinocchio.JointModelPX(), pinocchio.JointModelPY(), pinocchio.JointModelRZ())
        tip = pinocchio.SE3(np.eye(3), np.array([0, 2.0, 0]))
        kinds = pinocchio.ContactType
        for anchor in (pinocchio.PointAnchorConstraintModel(model, 0, tip, 3, tip),
                       pinocchio.RigidConstraintModel(kinds.CONTACT_3D, model, 0, tip, 3, tip)):
            anchor.name = "tip"
            step = self.captured(model, [0, 0, 0], [3, 0, 0], [0, 0, 0], anchor)
            # 6 kg along x and 4 along y turn about the tip: x' = 2 w, so that 6 (x' - 3) = f and 2 w = -2 f.
            w = 2 * 6 * 3 / (2 + 4 * 6)
            moves_to(self, step, [2 * w, 0, w])
            self.assertEqual(list(rows_of(step)), ["anchor tip x", "anchor tip y"])  # along z nothing moves
        for anchor in (pinocchio.FrameAnchorConstraintModel(model, 0, tip, 3, tip),
                       pinocchio.RigidConstraintModel(kinds.CONTACT_6D, model, 0, tip, 3, tip)):
            step = self.captured(model, [0, 0, 0], [3, 1, 0], [0, 0, 5], anchor)
            moves_to(self, step, [0, 0, 0])
            self.assertEqual(step.problem.rows["unit"], ["m", "m", "rad"])

    def test_a_joint_that_a_constraint_does_not_move_has_zeros(self):
        script = """if True:
            import numpy as np, pinocchio, lcpbench.pinocchio
            model = pinocchio.buildSampleModelHumanoid()
            place = pinocchio.SE3(np.eye(3), np.array([0.1, 0.2, 0.3]))
            data, q = model.createData(), pinocchio.neutral(model)
            for kind in ("CONTACT_3D", "CONTACT_6D"):
                tie = pinocchio.RigidConstraintModel(getattr(pinocchio.ContactType, kind), model, 2, place, 4, place)
                step = lcpbench.pinocchio.capture(model, data, q, np.zeros(model.nv), np.zeros(model.nv), [tie],
                                                  [tie.createData()], 0.01)
                print(np.count_nonzero(step.problem.rows["R"].any(axis=1)))"""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                              env={**os.environ, "MALLOC_PERTURB_": "85"})  # memory is not zero before it is written
        self.assertLess(max(map(int, done.stdout.split())), 4)

    def test_a_planar_loop_beside_a_contact(self):
        # A door of 2 kg m^2 with friction in its hinge turns against a stop at 1 m: the contact takes what friction leaves.
        model = self.arm(pinocchio.JointModelRZ())
        stop = pinocchio.SE3(np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]]), np.array([0, 1.0, 0]))  # its normal is x
        contact = pinocchio.PointContactConstraintModel(model, 0, stop, 1, stop)
        contact.setFriction(0.0)
        friction = pinocchio.JointFrictionConstraintModel(model)
        step = self.captured(model, [0], [0.7], [0], friction, contact)
        moves_to(self, step, [0], friction_joint0=-0.03)
        np.testing.assert_allclose(lcpbench.solve(step.problem).normal_impulses, [2 * 0.7 - 0.03])


@unittest.skipIf(None in (pybullet, drake, package("mujoco")), "PyPI's pybullet, drake and mujoco are not all installed")
class Linkage(unittest.TestCase):
    """A planar four-bar linkage at rest under gravity, with its pins A and D at the ground, its bars' inertia, and the
    velocity of their centres of mass and their spin after a step: as three bodies and four pins, in the three angles of a
    chain that is closed at D, and in those of two chains that are closed at C."""

    STEP, GRAVITY = 0.005, [0, 0, -9.8]
    PINS = np.array([[0, 0, 0], [0.3, 0, 0.8], [1.4, 0, 1.0], [1.6, 0, 0.1]])
    MASSES, SPINS = (1.0, 1.5, 0.8), (0.07, 0.2, 0.05)

    def pinned(self):
        pybullet.connect(pybullet.DIRECT)
        self.addCleanup(pybullet.disconnect)
        pybullet.setGravity(*self.GRAVITY)
        pybullet.setTimeStep(self.STEP)
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.01)
        middles = 0.5 * (self.PINS[1:] + self.PINS[:-1])
        for k, place in enumerate(middles):
            pybullet.createMultiBody(self.MASSES[k], sphere, basePosition=place)
            pybullet.changeDynamics(k, -1, linearDamping=0, angularDamping=0, localInertiaDiagonal=[self.SPINS[k]] * 3)
        for k, (a, b) in enumerate(((0, -1), (0, 1), (1, 2), (2, -1))):
            ends = [self.PINS[k] - (middles[body] if body >= 0 else 0) for body in (a, b)]
            pybullet.createConstraint(a, -1, b, -1, pybullet.JOINT_POINT2POINT, [0, 0, 0], *ends)
        pybullet.stepSimulation()
        step = lcpbench.pybullet.capture()
        self.assertEqual((len(rows_of(step)), step.notes), (12, []))
        np.testing.assert_allclose(step.problem.v, np.tile([*self.STEP * np.array(self.GRAVITY), 0, 0, 0], 3), atol=1e-12)
        return self.solved(step).reshape(3, 6)

    def chained(self):
        import lcpbench.mujoco
        import mujoco

        model = ""
        for k in (2, 1, 0):
            place, bar = self.PINS[k] - (self.PINS[k - 1] if k else 0), self.PINS[k + 1] - self.PINS[k]
            text = lambda vector: " ".join(map(repr, map(float, vector)))
            model = f'''<body name="bar{k}" pos="{text(place)}"><joint type="hinge" axis="0 1 0"/><inertial pos="{text(bar / 2)}"
                mass="{self.MASSES[k]}" diaginertia="{text([self.SPINS[k]] * 3)}"/>{model}
                {f'<site name="end" pos="{text(bar)}"/>' if k == 2 else ""}</body>'''
        model = mujoco.MjModel.from_xml_string(f'''<mujoco><option timestep="{self.STEP}" gravity="{text(self.GRAVITY)}"/>
            <worldbody><site name="ground" pos="{text(self.PINS[3])}"/>{model}</worldbody>
            <equality><connect site1="end" site2="ground"/></equality></mujoco>''')
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        velocity, found = self.solved(lcpbench.mujoco.capture(model, data)), []
        for k in range(3):
            J = np.zeros((2, 3, model.nv))
            mujoco.mj_jacBodyCom(model, data, *J, model.body(f"bar{k}").id)
            found.append((J @ velocity).ravel())
        return np.array(found)

    def two_chains(self):
        builder = drake.DiagramBuilder()
        plant, _ = drake.AddMultibodyPlantSceneGraph(builder, self.STEP)
        plant.SetUseSampledOutputPorts(False)
        plant.mutable_gravity_field().set_gravity_vector(self.GRAVITY)
        plant.set_discrete_contact_approximation(drake.DiscreteContactApproximation.kSap)
        bars, roots = [], [0, 1, 3]  # the pins that they hang from
        for k, root in enumerate(roots):
            middle = 0.5 * (self.PINS[k] + self.PINS[k + 1]) - self.PINS[root]
            spin = drake.RotationalInertia(*[self.SPINS[k]] * 3)
            bars.append(plant.AddRigidBody(f"bar{k}", drake.SpatialInertia.MakeFromCentralInertia(self.MASSES[k], middle, spin)))
            parent, place = (bars[0].body_frame(), self.PINS[1]) if k == 1 else (plant.world_frame(), self.PINS[root])
            frame = plant.AddFrame(drake.FixedOffsetFrame(f"pin{k}", parent, drake.RigidTransform(place)))
            plant.AddJoint(drake.RevoluteJoint(f"hinge{k}", frame, bars[k].body_frame(), [0, 1, 0]))
        plant.AddBallConstraint(bars[1], self.PINS[2] - self.PINS[1], bars[2], self.PINS[2] - self.PINS[3])
        plant.Finalize()
        diagram = builder.Build()
        root = diagram.CreateDefaultContext()
        context = plant.GetMyMutableContextFromRoot(root)
        plant.SetVelocities(context, self.solved(lcpbench.drake.capture(plant, context)))
        found = []
        for k, bar in enumerate(bars):
            middle = 0.5 * (self.PINS[k] + self.PINS[k + 1]) - self.PINS[roots[k]]
            velocity = bar.EvalSpatialVelocityInWorld(context).Shift(middle)
            found.append([*velocity.translational(), *velocity.rotational()])
        return np.array(found)

    def solved(self, step):
        answer = lcpbench.solve(step.problem, "auto")
        self.assertEqual(answer.verdict, "solved")
        if step.velocity is not None:
            np.testing.assert_allclose(answer.velocity, step.velocity, atol=1e-3)  # softer in the engines
        return answer.velocity

    def test_engines_and_coordinates_agree(self):
        pinned, chained, two_chains = self.pinned(), self.chained(), self.two_chains()
        self.assertGreater(np.abs(chained).max(), 5e-3)
        np.testing.assert_allclose(pinned, chained, rtol=0, atol=1e-9)
        np.testing.assert_allclose(two_chains, chained, rtol=0, atol=1e-9)


if __name__ == "__main__":
    unittest.main()
