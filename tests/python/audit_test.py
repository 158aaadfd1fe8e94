"""Contacts that an engine left out: a plate lies on two rows of balls at x = -D and D. Without the second row it turns
about the first, with the impulse of gravity m g h at the arm D and the moment of inertia m (A^2 + C^2) / 3 + m (D^2 + C^2).
"""
import itertools
import json
import os
import subprocess
import tempfile
import unittest

import numpy as np

import lcpbench
import lcpbench.mujoco

try:
    import mujoco
except ModuleNotFoundError:
    mujoco = None

MASS, A, B, C, D = 8, 0.5, 0.4, 0.05, 0.3  # kg; half lengths of the plate, and the arm of a row [m]
FALL = 9.81 * 0.002  # m/s in a step
TURN = FALL * D / ((A**2 + C**2) / 3 + D**2 + C**2)  # rad/s about the first row
BALLS = list(itertools.product((-D, D), (-0.2, 0, 0.2)))


def plate():
    inertia = np.diag([B**2 + C**2, A**2 + C**2, A**2 + B**2]) * MASS / 3
    contacts = [dict(body_a=0, point=(x, y, -C), normal=(0, 0, 1), tangent=(1, 0, 0), mu=2.0) for x, y in BALLS]
    return lcpbench.Problem.from_scene([dict(mass=MASS, inertia=inertia, linear_velocity=(0, 0, -FALL))], contacts)


class Arrays(unittest.TestCase):
    def test_contacts_that_were_not_solved_make_the_error_that_is_derived(self):
        found = lcpbench.audit(plate(), np.arange(6) < 3)
        self.assertEqual((found.found, found.solved), (6, 3))
        self.assertEqual(found.missing, {"limit": ["contact 3", "contact 4", "contact 5"]})
        self.assertAlmostEqual(found.velocity_error["limit"], 2 * D * TURN, delta=1e-9)
        self.assertEqual(lcpbench.audit(plate(), np.full(6, True)).missing, {})
        with self.assertRaisesRegex(lcpbench.InputError, r"solved has shape \(2,\) of int64, expected \(6,\) of bool"):
            lcpbench.audit(plate(), np.array([0, 2]))
        with self.assertRaisesRegex(lcpbench.InputError, "no impulses of an engine"):
            lcpbench.audit(plate())

    def test_what_separates_is_not_missing(self):
        fingers = lcpbench.Problem(G=np.eye(3), N=np.eye(3), v=[-1, 3, -2])  # three bodies, the second one leaves
        found = lcpbench.audit(fingers, np.array([True, False, False]))
        self.assertEqual((found.missing, found.velocity_error), ({"limit": ["contact 2"]}, {"limit": 2.0}))
        found = lcpbench.audit(fingers, np.array([True, False, True]))
        self.assertEqual((str(found), found.missing), ("2 of 3 contacts solved", {}))

    def test_what_has_no_solution_has_no_error_either(self):
        squeezed = lcpbench.Problem(G=[[1.0]], N=[[1.0, -1.0]], v=[0.0], b=[-0.5, -0.25])
        with self.assertRaisesRegex(lcpbench.InputError, "^problem: auto says unsolvable$"):
            lcpbench.audit(squeezed, np.array([False, False]))

    def test_the_command_finds_them_in_captured_steps(self):
        whole, impulses = plate(), np.zeros((6, 3))
        impulses[:3] = [MASS / 3 * (FALL - D * TURN), MASS / 3 * C * TURN, 0]  # friction holds the row in its place
        step = lcpbench.Step(whole, contact_ids=[f"ball {i}" for i in range(6)], impulses=impulses)
        named = ["ball 3", "ball 4", "ball 5"]
        found = lcpbench.audit(step)
        self.assertEqual(found.missing, {"no impulse": named})
        self.assertRegex(str(found), "\nno impulse: 3 that the motion runs into, ")
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "plate.scenes")
            with lcpbench.Recorder(file) as recorder:
                recorder.add(step)
                recorder.add(lcpbench.Step(whole, impulses=lcpbench.solve(whole).impulses))
            run = subprocess.run([os.environ["LCPBENCH_PROGRAM"], "audit", file, "--format", "json"], check=True,
                                 capture_output=True)
        first, second = json.loads(run.stdout)
        self.assertEqual((first["found"], first["solved"], first["run_into"]), (6, 3, named))
        self.assertAlmostEqual(first["velocity_error_m_per_s"], 2 * D * TURN, delta=1e-9)
        self.assertEqual((second["run_into"], second["velocity_error_m_per_s"]), ([], 0))


@unittest.skipIf(mujoco is None, "PyPI's mujoco is not installed")
class Mujoco(unittest.TestCase):
    def audit(self, speed=0.0, size="", excluded="", z=0.15, **limits):
        balls = "".join(f'<geom name="ball{i}" type="sphere" size=".05" pos="{x} {y} .05"/>'
                        for i, (x, y) in enumerate(BALLS))
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><size {size}/><option timestep="0.002"/>
          <default><geom friction="2"/></default><worldbody>{balls}<body name="plate" pos="0 0 {z}"><freejoint/>
          <geom name="plate" type="box" size="{A} {B} {C}" mass="{MASS}"/></body></worldbody>
          <contact>{excluded}</contact></mujoco>""")
        data = mujoco.MjData(model)
        data.qvel[2] = speed
        found = lcpbench.mujoco.audit(model, data, **limits)
        self.assertEqual(data.qpos[2], z)  # the data are as they were
        return found

    def test_limits(self):
        self.assertEqual(self.audit().missing, {})
        for limits in (dict(njmax=12), dict(nconmax=3)):  # each contact has four rows
            found = self.audit(**limits)
            self.assertEqual((found.found, found.solved), (6, 3))
            self.assertEqual(found.missing, {"limit": [f"plate on ball{i}" for i in (3, 4, 5)]})
            self.assertAlmostEqual(found.velocity_error["limit"], 2 * D * TURN, delta=1e-9)
        found = self.audit(size='memory="8K"')
        self.assertEqual((found.found, found.solved, len(found.missing["limit"])), (6, 0, 6))
        self.assertAlmostEqual(found.velocity_error["limit"], FALL, delta=1e-9)
        self.assertRegex(str(found), "^0 of 6 contacts solved\nlimit: 6 missing, 0.0196 m/s: .* and 1 more$")

    def test_a_joints_limit_may_be_missing(self):
        model = mujoco.MjModel.from_xml_string("""<mujoco><option timestep="0.002"/><worldbody><body>
          <joint name="knee" axis="0 1 0" range="-1 0" limited="true" frictionloss="0.1"/>
          <geom type="sphere" size=".05" pos=".3 0 0" mass="1"/></body></worldbody></mujoco>""")
        data = mujoco.MjData(model)
        data.qpos[0] = 1e-9
        for rows, missing in ((2, []), (1, ["hinge limit knee"]), (0, ["hinge friction knee", "hinge limit knee"])):
            found = lcpbench.mujoco.audit(model, data, njmax=rows)
            self.assertEqual(found.missing.get("limit", []), missing)
            if missing:
                torque = 9.81 * 0.3 - 0.1 * rows  # friction holds against a part of it
                self.assertAlmostEqual(found.velocity_error["limit"], 0.002 * torque / (0.09 + 0.001), delta=1e-9)

    def test_margins_and_excluded_pairs(self):
        found = self.audit(excluded='<exclude body1="world" body2="plate"/>')
        self.assertEqual((found.found, len(found.missing["excluded"])), (0, 6))
        self.assertAlmostEqual(found.velocity_error["excluded"], FALL, delta=1e-9)
        found = self.audit(z=0.1502, speed=-0.5)  # 0.2 mm apart, and falling 1 mm within the step
        self.assertEqual((found.found, len(found.missing["margin"])), (0, 6))
        self.assertAlmostEqual(found.velocity_error["margin"], 0.5 + FALL - 0.2e-3 / 0.002, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
