"""Solvers of other projects through the external protocol, each on a case of its own library and on contacts."""
import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import lcpbench
from lcpbench import Problem

ROOT, PROGRAM = pathlib.Path(os.environ["LCPBENCH_SOURCE"]), os.environ["LCPBENCH_PROGRAM"]
JOLT = pathlib.Path(sys.prefix, "node_modules", "jolt-physics")


def peer(command, form="contact", more=""):
    script, *arguments = command.split()
    words = " ".join([sys.executable, str(ROOT / "python" / "peers" / script), *arguments])
    return f"external{{command={words},form={form}{more}}}"


def asked(problem, solver):
    with tempfile.TemporaryDirectory() as folder:
        lcpbench.save(problem, folder + "/p.json")
        command = [PROGRAM, "solve", folder + "/p.json", "--solver", solver, "--format", "json", "--time-limit", "60"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.stdout, done.stderr
        return json.loads(done.stdout)[0]


def needs(*names):
    def is_there(name):
        try:
            return importlib.import_module(name) is not None
        except ModuleNotFoundError:
            return False
    return unittest.skipUnless(all(map(is_there, names)), f"PyPI's {', '.join(names)} not installed")


def box(force):
    """Pinocchio's own test: a cube of 1 m and 10 kg on its four corners, mu 0.4, pushed along x for 1 ms."""
    mass, h = 10.0, 1e-3
    corners = [[x, y, -0.5] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    body = dict(mass=mass, inertia=mass / 6 * np.eye(3), linear_velocity=[h * force / mass, 0, -9.81 * h])
    contacts = [dict(body_a=0, point=at, normal=[0, 0, 1], tangent=[1, 0, 0], mu=0.4) for at in corners]
    return Problem.from_scene([body], contacts), (force - 0.4 * mass * 9.81) / mass * h


@needs("pydrake")
class Drake(unittest.TestCase):
    def test_a_published_problem_of_its_tests(self):
        # Floudas and others, Handbook of Test Problems in Local and Global Optimization, 10.2.1: z = (0, ..., 0, 1).
        n = 16
        problem = Problem(M=np.eye(n) + 2 * np.triu(np.ones((n, n)), 1), q=-np.ones(n))
        for method in ("moby", "unrevised"):
            row = asked(problem, peer(f"drake_lcp.py {method}", "lcp"))
            self.assertEqual((row["claim"], row["verdict"]), ("solved", "solved"), row)
            np.testing.assert_allclose(row["z"], np.eye(n)[-1], atol=1e-9)

    def test_contacts(self):
        for force in (0.5, 1.5):
            problem, _ = box(force * 0.4 * 98.1)
            self.assertEqual(asked(problem, peer("drake_lcp.py moby", "lcp"))["verdict"], "solved")


@needs("pinocchio")
class Pinocchio(unittest.TestCase):
    def test_the_box_of_its_tests(self):
        for method in ("admm", "pgs"):
            for scale, moves in ((0.9, False), (1.1, True)):
                problem, speed = box(scale * 0.4 * 98.1)
                row = asked(problem, peer(f"pinocchio_cone.py {method}", more=",cone=true"))
                self.assertEqual((row["claim"], row["verdict"], row["model"]), ("solved", "solved", "cone"), row)
                np.testing.assert_allclose(row["velocity"][:3], [speed if moves else 0, 0, 0], atol=1e-8)

    def test_a_slip_along_a_diagonal_obeys_the_cone(self):
        problem = Problem(G=np.eye(3), N=[[0], [0], [1.0]], tangents=[[1.0, 0], [0, 1], [0, 0]], mu=0.5, v=[1, 1, -1.0])
        row = asked(problem, peer("pinocchio_cone.py admm", more=",cone=true"))
        self.assertEqual((row["verdict"], row["model"]), ("solved", "cone"), row)
        row = asked(problem, peer("pinocchio_cone.py admm"))  # judged by the pyramid, which it does not solve
        self.assertEqual((row["verdict"], row["model"]), ("wrong", "pyramid"), row)

    def test_limits_are_claims(self):
        row = asked(box(10.0)[0], peer("pinocchio_cone.py pgs 1e-12 1", more=",cone=true"))
        self.assertEqual(row["claim"], "iteration_limit")


class Convex(unittest.TestCase):
    def solves(self, library):
        rng = np.random.default_rng(4)
        root = rng.standard_normal((8, 8))
        flat = Problem(G=root @ root.T + np.eye(8), N=rng.standard_normal((8, 6)), v=rng.standard_normal(8),
                       b=0.1 * np.ones(6))
        row = asked(flat, peer(f"convex.py {library}"))
        self.assertEqual((row["claim"], row["verdict"]), ("solved", "solved"), row)
        np.testing.assert_allclose(row["velocity"], lcpbench.solve(flat).velocity, atol=1e-6)
        sticks, slides = box(0.5 * 0.4 * 98.1)[0], box(2 * 0.4 * 98.1)[0]
        self.assertEqual(asked(sticks, peer(f"convex.py {library}"))["claim"], "unsupported")
        self.assertEqual(asked(sticks, peer(f"convex.py {library} relaxed"))["verdict"], "solved")
        row = asked(slides, peer(f"convex.py {library} relaxed"))  # what slides lifts off in the relaxed model
        self.assertEqual(row["verdict"], "wrong", row)
        self.assertGreater(row["velocity"][2], 1e-4)

    @needs("proxsuite")
    def test_proxqp(self):
        self.solves("proxqp")

    @needs("clarabel", "scipy")
    def test_clarabel(self):
        self.solves("clarabel")

    @needs("scs", "scipy")
    def test_scs(self):
        self.solves("scs")


def pizza(torque):
    """Drake's own test of SAP, the pizza saver: 3 kg on three points of a circle of 1.5 m, mu 1, turned for 5 ms. Its
    inertia is that of its points. Returns the problem, and the angular velocity where friction is Coulomb's, and where
    it is the convex model's: what slips at u rises at mu u."""
    m, R, g, h = 3.0, 1.5, 10.0, 5e-3
    centre = np.array([0.3, -0.2, 0.5])
    corners = centre + [[-(3**0.5) / 2 * R, -R / 2, 0], [3**0.5 / 2 * R, -R / 2, 0], [0, R, 0]]
    body = dict(mass=m, position=centre, inertia=m * R * R * np.diag([0.5, 0.5, 1]), linear_velocity=[0, 0, -g * h],
                angular_velocity=[0, 0, torque * h / (m * R * R)])
    contacts = [dict(body_a=0, point=at, normal=[0, 0, 1], tangent=[1, 0, 0], mu=1.0) for at in corners]
    excess = max(0.0, torque - m * g * R) * h / (m * R * R)
    return Problem.from_scene([body], contacts), excess, excess / 2


class Steps(unittest.TestCase):
    """A step of an engine. MuJoCo's solvers and SAP share a model, so that they share its answers."""

    def turns(self, command, model, accuracy):
        for torque in (20, 60):  # slips from 45 N m on
            problem, *expected = pizza(torque)
            row = asked(problem, peer(command, "scene", ",cone=true"))
            self.assertEqual(row["claim"], "solved", row)
            np.testing.assert_allclose(row["velocity"][:2], 0, atol=1e-6)
            rises = expected[model] * 1.5 if model == 1 else 0
            np.testing.assert_allclose(row["velocity"][2], rises, atol=accuracy)
            np.testing.assert_allclose(row["velocity"][3:], [0, 0, expected[model]], atol=accuracy)

    def refuses(self, command, offset):
        body = dict(mass=1.0, inertia=np.eye(3), linear_velocity=[0, 0, -1], angular_velocity=[0, 0, 0])
        problem = Problem.from_scene([body], [dict(body_a=0, point=[0, 0, -1], normal=[0, 0, 1], b=offset)])
        return asked(problem, peer(command, "scene", ",cone=true"))

    @needs("pydrake")
    def test_drakes_sap(self):
        self.turns("drake_sap.py", 1, 2e-5)
        self.assertEqual(self.refuses("drake_sap.py", 0.5)["claim"], "unsupported")

    @needs("mujoco")
    def test_mujocos_solvers(self):
        for method in ("newton", "cg", "pgs"):
            self.turns(f"mujoco_step.py {method}", 1, 2e-5)
        self.assertEqual(self.refuses("mujoco_step.py newton", 0.5)["claim"], "unsupported")
        row = self.refuses("mujoco_step.py newton", -0.5)
        np.testing.assert_allclose(row["velocity"][2], 0.5, atol=1e-3)

    @needs("mujoco")
    def test_mujocos_step_is_that_of_its_own_box(self):
        import mujoco
        for push in (0.9, 1.1):
            problem, _ = box(push * 0.4 * 98.1)
            model = mujoco.MjModel.from_xml_string("""<mujoco><option timestep="0.001" gravity="0 0 0" cone="elliptic"/>
              <default><geom friction=".4 0 0" condim="3" solref="-1e6 -1e3" solimp="0.9999 0.9999 1 .5 2"/></default>
              <worldbody><geom type="plane" size="3 3 .1" pos="0 0 -.5"/><body><freejoint/>
              <geom type="box" size=".5 .5 .5" mass="10"/></body></worldbody></mujoco>""")
            data = mujoco.MjData(model)
            data.qpos[2], data.qvel[:] = -1e-9, problem.v
            mujoco.mj_step(model, data)
            row = asked(problem, peer("mujoco_step.py newton", "scene", ",cone=true"))
            np.testing.assert_allclose(row["velocity"], data.qvel, atol=1e-8)

    @needs("rapier3d", "scipy")
    def test_rapier(self):
        self.turns("rapier_step.py 1000", 0, 1e-6)
        self.assertEqual(self.refuses("rapier_step.py", 0.5)["claim"], "unsupported")

    @unittest.skipUnless(JOLT.exists(), "npm's jolt-physics not installed beside this Python")
    def test_jolt(self):
        for push in (0.9, 1.1):
            problem, speed = box(push * 0.4 * 98.1)
            row = asked(problem, peer("jolt_step.py 1000", "scene", ",cone=true"))
            self.assertEqual((row["claim"], row["verdict"]), ("solved", "solved"), row)
            np.testing.assert_allclose(row["velocity"][:3], [max(speed, 0), 0, 0], atol=1e-7)
        self.assertEqual(self.refuses("jolt_step.py", -0.5)["claim"], "unsupported")
        np.testing.assert_allclose(self.refuses("jolt_step.py", 0.25)["velocity"][2], -0.25, atol=1e-5)

    @needs("newton", "warp")
    def test_newtons_steel(self):
        script = str(ROOT / "python" / "peers" / "newton_step.py")
        subprocess.run([sys.executable, script], input=b'{"sequence": 1, "verb": "problem", "problem": {}}\n',
                       check=True, capture_output=True)  # compiles its kernels
        self.turns("newton_step.py", 0, 1e-6)
        row = self.refuses("newton_step.py", 0.25)
        self.assertEqual(row["verdict"], "solved", row)
        np.testing.assert_allclose(row["velocity"][2], -0.25, atol=2e-5)


class Starts(unittest.TestCase):
    """From its own answer a program has less to do, and ends at the same one."""

    def gains(self, command, form="contact"):
        problem, _ = box(0.9 * 0.4 * 98.1)
        if form == "contact":
            problem = Problem(**{name: getattr(problem, name) for name in ("G", "N", "D", "mu", "v", "edges")})
        with tempfile.TemporaryDirectory() as folder:
            lcpbench.save(problem, folder + "/p.json")
            text = json.loads(pathlib.Path(folder, "p.json").read_text())
        script, *arguments = command.split()
        words = [sys.executable, str(ROOT / "python" / "peers" / script), *arguments]
        with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
            answers = [{}]
            for _ in range(2):
                start = {"start": answers[-1]["z"]} if answers[-1] else {}
                for question in ({"verb": "problem", "problem": text}, {"verb": "setup"}, {"verb": "solve", **start}):
                    print(json.dumps({"sequence": 1, **question}), file=program.stdin, flush=True)
                    answer = json.loads(program.stdout.readline())
                answers.append(answer)
            program.stdin.close()
        cold, warm = answers[1:]
        self.assertEqual((cold["claim"], warm["claim"]), ("solved", "solved"))
        self.assertLess(warm["iterations"], cold["iterations"])
        velocities = [problem._data.velocity(np.array(answer["z"])) for answer in (cold, warm)]
        np.testing.assert_allclose(*velocities, atol=1e-7)

    @needs("pinocchio")
    def test_pinocchio(self):
        self.gains("pinocchio_cone.py admm")
        self.gains("pinocchio_cone.py pgs")

    @needs("proxsuite")
    def test_proxqp(self):
        self.gains("convex.py proxqp relaxed")

    @needs("scs", "scipy")
    def test_scs(self):
        self.gains("convex.py scs relaxed")

    @needs("mujoco")
    def test_mujoco(self):
        for method in ("newton", "cg"):
            self.gains(f"mujoco_step.py {method}", "scene")


if __name__ == "__main__":
    unittest.main()
