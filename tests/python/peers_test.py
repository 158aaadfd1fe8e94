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
import scipy.linalg

import lcpbench
from lcpbench import Problem

ROOT, PROGRAM = pathlib.Path(os.environ["LCPBENCH_SOURCE"]), os.environ["LCPBENCH_PROGRAM"]
PEERS = ROOT / "python" / "peers"
JOLT = pathlib.Path(sys.prefix, "node_modules", "jolt-physics")
RAPIER_ENGINE = [sys.executable, PEERS / "rapier_engine.py", "coulomb"]
JOLT_ENGINE = ["node", "--disable-wasm-trap-handler", PEERS / "jolt.mjs", JOLT.parent]


def peer(command, form="contact", more=""):
    script, *arguments = command.split()
    words = " ".join([sys.executable, str(PEERS / script), *arguments])
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


class Loop(unittest.TestCase):
    def replies(self, functions, *verbs):
        """What a peer of these functions load and warm answers."""
        program = f"import sys; sys.path.insert(0, {str(PEERS)!r}); import peer\n{functions}\npeer.serve(load, warm)"
        lines = "".join(json.dumps(dict(verb=verb, problem={}, sequence=1)) + "\n" for verb in verbs)
        done = subprocess.run([sys.executable, "-c", program], input=lines, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_what_is_not_finite_is_a_failure(self):
        functions = "load = lambda _: lambda _: dict(claim='solved', z=[float('nan')])\nwarm = lambda: None"
        self.assertEqual(self.replies(functions, "problem", "setup", "solve")[-1]["claim"], "numerical_failure")

    def test_a_library_that_fails_to_warm_up_can_still_answer(self):
        functions = "load = lambda _: lambda _: dict(claim='solved', z=[])\ndef warm(): raise RuntimeError('cold')"
        self.assertEqual(self.replies(functions, "problem", "setup", "solve")[-1]["claim"], "solved")


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


# Quadratic programs from the tests of these libraries: P, c, A, b, x of min 1/2 x'Px + c'x where Ax <= b.
# ProxQP, test/src/cvxpy.cpp; its answer is that of Boyd and Vandenberghe, Convex Optimization, exercise 4.3.
# Clarabel, tests/basic_qp.rs. SCS, test/problems/hs21_tiny_qp.h: problem 21 of Hock and Schittkowski.
QPS = {
    "proxqp": ([[13, 12, -2], [12, 17, 6], [-2, 6, 12]], [-22, -14.5, 13], np.vstack([np.eye(3), -np.eye(3)]),
               np.ones(6), [1, 0.5, -1]),
    "clarabel": ([[4, 1], [1, 2]], [1, 1], [[-1, -1], [-1, 0], [0, -1], [1, 1], [1, 0], [0, 1]],
                 [-1, 0, 0, 1, 0.7, 0.7], [0.3, 0.7]),
    "scs": ([[0.02, 0], [0, 2]], [0, 0], [[-10, 1], [-1, 0], [1, 0], [0, -1], [0, 1]], [-10, -2, 50, 50, 50], [2, 0]),
}


class Convex(unittest.TestCase):
    def solves(self, library):
        for P, c, A, b, x in QPS.values():
            qp = Problem(G=P, N=-np.transpose(A), v=-np.linalg.solve(P, c), b=b)
            row = asked(qp, peer(f"convex.py {library}"))
            self.assertEqual((row["claim"], row["verdict"]), ("solved", "solved"), row)
            np.testing.assert_allclose(row["velocity"], x, atol=1e-6)
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

    @needs("clarabel", "scs", "scipy")
    def test_failures_are_claimed_as_the_library_names_them(self):
        fall = Problem(G=[[1.0]], N=[[1.0, -1.0]], v=[-1.0], b=[0.0, 5.0])
        squeezed = Problem(G=[[1.0]], N=[[1.0, -1.0]], v=[0.0], b=[-1.0, -1.0])
        for problem, command, claim in ((fall, "clarabel 1e-300", "numerical_failure"),
                                        (fall, "scs 1e-300", "iteration_limit"),
                                        (squeezed, "clarabel", "unsolvable"), (squeezed, "scs", "unsolvable"),
                                        (squeezed, "scs relaxed", "numerical_failure")):
            self.assertEqual(asked(problem, peer(f"convex.py {command}"))["claim"], claim, command)


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


def on_corners(mass, half, motions):
    """Cubes on their four corners, which touch the floor alone: (velocity without contacts, mu) of each."""
    corners = [[x * half, y * half, -half] for x in (-1, 1) for y in (-1, 1)]
    inertia = mass * (2 * half) ** 2 / 6 * np.eye(3)
    bodies = [dict(mass=mass, inertia=inertia, linear_velocity=v[:3], angular_velocity=v[3:]) for v, _ in motions]
    return Problem.from_scene(bodies, [dict(body_a=k, point=at, normal=[0, 0, 1], tangent=[1, 0, 0], mu=mu)
                                       for k, (_, mu) in enumerate(motions) for at in corners])


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
        # MuJoCo's own test RestPenetration (test/engine/engine_core_constraint_test.cc): a contact of stiffness k and
        # impedance d rests at the depth g (1 - d) / k. By that law one step of h takes out the depth r at r / h, where
        # k is 1 / h^2 and the damping 1 / h; a nanometre of r stands for the contact.
        for method in ("newton", "cg", "pgs"):
            row = self.refuses(f"mujoco_step.py {method}", -0.5)
            np.testing.assert_allclose(row["velocity"][2], 0.5 + 1e-9 / 1e-3, atol=1e-9)

    @needs("newton", "warp")
    def test_newtons_steel(self):
        script = str(PEERS / "newton_step.py")
        subprocess.run([sys.executable, script], input=b'{"sequence": 1, "verb": "problem", "problem": {}}\n',
                       check=True, capture_output=True)  # compiles its kernels
        self.turns("newton_step.py", 0, 1e-6)
        # Newton's own tests of sliding and of holding, newton/tests/steel/test_friction.py: a cube of 0.2 m on a slope
        # slides at g (sin a - mu cos a) to 0.5 % with 32 iterations, or holds to 1e-3 m/s.
        gravity = [9.81 * np.array([np.sin(a), 0, -np.cos(a), 0, 0, 0]) for a in (0.6, 0.3)]
        problem = on_corners(8.0, 0.1, [(each / 240, mu) for each, mu in zip(gravity, (0.3, 0.5))])
        row = asked(problem, peer("newton_step.py 32", "scene", ",cone=true"))
        slides, holds = np.reshape(row["velocity"], (2, 6))
        expected = 9.81 / 240 * (np.sin(0.6) - 0.3 * np.cos(0.6))
        np.testing.assert_allclose(slides, [expected, 0, 0, 0, 0, 0], atol=0.005 * expected)
        np.testing.assert_allclose(holds, 0, atol=1e-3 / 240)
        row = self.refuses("newton_step.py", 0.25)
        self.assertEqual(row["verdict"], "solved", row)
        np.testing.assert_allclose(row["velocity"][2], -0.25, atol=2e-5)


class Failures(unittest.TestCase):
    def test_one_is_a_failure_of_its_question_and_no_refusal(self):
        script = """
import peer
failures = [RuntimeError("once")]
def load(problem):
    if problem == "bad":
        raise ValueError("singular")
    def solve(_):
        for each in failures:
            failures.clear()
            raise each
        return {"claim": "solved", "z": []}
    return solve
peer.serve(load)
"""
        verbs = ({"verb": "problem", "problem": "good"}, {"verb": "setup"}, {"verb": "solve"}, {"verb": "solve"},
                 {"verb": "problem", "problem": "bad"}, {"verb": "setup"}, {"verb": "solve"})
        lines = "".join(json.dumps({"sequence": k, **verb}) + "\n" for k, verb in enumerate(verbs))
        done = subprocess.run([sys.executable, "-c", script], input=lines, capture_output=True, text=True, check=True,
                              env={**os.environ, "PYTHONPATH": str(PEERS)})
        claims = [json.loads(line).get("claim") for line in done.stdout.splitlines()]
        self.assertEqual(claims, [None, None, "numerical_failure", "solved", None, None, "numerical_failure"])


class Engines(unittest.TestCase):
    """Engines that step whole scenes: each on tests of its own, and as lcpbench runs it."""

    def stepped(self, engine, step, mu, bodies, count):
        """Steps cubes or balls on a floor under gravity. Returns contacts and motions of the last step."""
        floor = dict(mass=0, inertia=[1, 1, 1], motion=[0, 0, -1, 1] + 9 * [0],
                     parts=[dict(box=[100, 100, 1], offset=[0, 0, 0])])
        forces = [[0] * 6] + [[0, 0, -9.81 * each["mass"], 0, 0, 0] for each in bodies]
        lines = [dict(verb="scene", step=step, mu=mu, restitution=0, bodies=[floor, *bodies])]
        lines += count * [dict(verb="step", forces=forces)]
        lines = "\n".join(map(json.dumps, lines))
        told = subprocess.run(engine, input=lines, capture_output=True, text=True, check=True)
        last = json.loads(told.stdout.splitlines()[-1])
        return last["contacts"], np.array(last["motions"])[1:]

    def cube(self, mass, half, place, velocity=(0,) * 6):
        return dict(mass=mass, inertia=3 * [mass * (2 * half) ** 2 / 6], motion=[*place, half, 1, 0, 0, 0, *velocity],
                    parts=[dict(box=3 * [half], offset=[0, 0, 0])])

    @needs("rapier3d", "scipy")
    def test_rapiers_impulses_hold_a_weight(self):
        # Rapier's own test crates/rapier3d/tests/total_contact_impulse.rs: after 300 steps the impulses on a ball or a
        # cube of 1 m and 1 kg are its weight times the step to 1 %.
        cube = self.cube(1.0, 0.5, (0, 0))
        ball = {**cube, "parts": [dict(sphere=0.5, offset=[0, 0, 0])]}
        for body in (cube, ball):
            contacts, _ = self.stepped(RAPIER_ENGINE, 1 / 60, 0.5, [body], 300)
            total = sum(abs(each["impulse"][2]) for each in contacts)
            np.testing.assert_allclose(total, 9.81 / 60, rtol=1e-2)

    @unittest.skipUnless(JOLT.exists(), "npm's jolt-physics not installed beside this Python")
    def test_jolts_friction_is_that_of_its_tests(self):
        # Jolt's own test TestFriction (UnitTests/Physics/PhysicsTests.cpp): cubes of 2 m and 8000 kg slide at 20 m/s in
        # twelve directions. Jolt allows 2e-2 m/s and 1e-2 rad/s after 60 steps.
        mu, ways = (0.9 * 0.8) ** 0.5, [np.array([np.sin(a), np.cos(a), 0]) for a in np.radians(range(0, 360, 30))]
        cubes = [self.cube(8000.0, 1.0, 10 * way[:2], [*(20 * way), 0, 0, 0]) for way in ways]
        _, after = self.stepped(JOLT_ENGINE, 1 / 60, mu, cubes, 60)
        np.testing.assert_allclose(after[:, 7:10], [(20 - mu * 9.81) * way for way in ways], atol=2e-2)
        np.testing.assert_allclose(after[:, 10:], 0, atol=1e-2)

    @needs("rapier3d", "scipy")
    def test_rapier_is_an_engine_of_capture_and_replay(self):
        self.captures_and_replays(RAPIER_ENGINE, "uneven-table")

    @unittest.skipUnless(JOLT.exists(), "npm's jolt-physics not installed beside this Python")
    def test_jolt_is_an_engine_of_capture_and_replay(self):
        self.captures_and_replays(JOLT_ENGINE, "sphere-pile")

    @unittest.skipUnless("BOX3D_ENGINE" in os.environ, "BOX3D_ENGINE names no program of python/peers/box3d_engine.cpp")
    def test_box3d_is_an_engine_of_capture_and_replay(self):
        self.captures_and_replays([os.environ["BOX3D_ENGINE"]], "uneven-table")

    def captures_and_replays(self, command, scene):
        engine = ["--engine", f"external{{command={' '.join(map(str, command))}}}"]
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "capture", scene, *engine, "--every", "20", "--steps", "161", "--out",
                            folder + "/c.scenes"], check=True, capture_output=True)
            steps = list(lcpbench.load(folder + "/c.scenes"))
            self.assertGreater(len(steps), 4)
            for step in steps:
                # Impulses explain the velocity that the engine found, which they would not with a wrong sign, force or
                # inertia. Rapier's act a centimetre aside: it takes contacts over from the step before.
                p, nc = step.problem, step.problem.nc
                if step.impulses is not None:
                    G = scipy.linalg.block_diag(*p.G)
                    f = lcpbench._native.complete_answer(p._data, step.impulses, "pyramid")[: nc + sum(p.edges)]
                    unexplained = G @ (p.v - step.velocity) + p.N @ f[:nc] + p.D @ f[nc:]
                    np.testing.assert_allclose(unexplained, 0, atol=2e-2 * np.abs(G @ p.v).max())
                # Nothing that touches approaches any more, but for what few sweeps leave.
                closing = np.minimum(p.N.T @ step.velocity + p.b, 0)
                self.assertLess(np.abs(closing).max(), 0.2 * np.abs(p.v).max())
            # Exact solves in the loop keep three cubes where they are, which a step that is taken twice does not.
            done = subprocess.run([PROGRAM, "replay", "cubes-3", *engine, "--stepper", "exact", "--engine-solver",
                                   "--steps", "100", "--out", folder + "/r", "--format", "json"], check=True,
                                  capture_output=True)
            drift = {each["solver"]: each["drift_m"] for each in json.loads(done.stdout)[0]["replays"]}
            self.assertLess(drift["exact"], 1e-3, drift)
            self.assertLess(drift["engine"], 1e-2, drift)


if __name__ == "__main__":
    unittest.main()
