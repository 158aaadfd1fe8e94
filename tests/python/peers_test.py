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


if __name__ == "__main__":
    unittest.main()
