"""What newcomers do first, and what they do wrong."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

from lcpbench import ContactSolver, InputError, Problem, Recorder, Step, check, load, solve

BOX = pathlib.Path(os.environ["LCPBENCH_SOURCE"]) / "examples" / "box_on_slope.json"

LONG = """
import numpy as np, lcpbench
rng = np.random.default_rng(0)
A, K = rng.standard_normal((2, {n}, {n}))
problem = lcpbench.Problem(M=1e-3 * A @ A.T / {n} + K - K.T, q=-rng.random({n}) - 1, validate=False)
print("solving", flush=True)
{call}
"""


class Interrupts(unittest.TestCase):
    def interrupted(self, n, call):
        process = subprocess.Popen([sys.executable, "-c", LONG.format(n=n, call=call)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        try:
            self.assertEqual(process.stdout.readline(), "solving\n")
            with self.assertRaises(subprocess.TimeoutExpired):
                process.wait(1.5)  # else it was too short to be interrupted
            process.send_signal(signal.SIGINT)
            return process.communicate(timeout=60)[1]  # the solves would take several times as long
        finally:
            process.kill()
            process.communicate()

    def test_ctrl_c_ends_a_long_solve(self):
        self.assertIn("KeyboardInterrupt", self.interrupted(2000, "lcpbench.solve(problem)"))

    def test_ctrl_c_ends_what_many_threads_solve(self):
        self.assertIn("KeyboardInterrupt", self.interrupted(400, "lcpbench.solve([problem] * 2000, 'lemke', threads=2)"))


class Threads(unittest.TestCase):
    def test_a_second_thread_at_one_solver_is_told_so(self):
        problem, solver, told, done = load(BOX), ContactSolver(), [], threading.Event()
        solver.update(problem)

        def use():
            for _ in range(20000):
                if done.is_set():
                    return
                try:
                    solver.update(problem, [0, 1, 2, 3])
                    solver.solve()
                    solver.velocity, solver.z, solver.check()
                except RuntimeError as error:
                    told.append(str(error))
                    done.set()

        threads = [threading.Thread(target=use) for _ in range(2)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
        self.assertEqual({*told}, {"ContactSolver: another thread uses it now; give each thread its own"})
        solver.update(problem)
        self.assertEqual(solver.solve(), "solved")


class Forms(unittest.TestCase):
    def test_steps_and_answers_are_taken_as_they_are(self):
        problem = load(BOX)
        answer = solve(problem)
        step = Step(problem, contact_ids=["a", "b", "c", "d"], impulses=answer.impulses)
        self.assertEqual(solve(step).verdict, "solved")
        self.assertEqual([each.verdict for each in solve([step, problem])], ["solved", "solved"])
        self.assertTrue(check(problem, answer))
        self.assertTrue(check(step))
        self.assertTrue(check(step, answer.z))
        self.assertIn(">a</text>", problem.figure(answer).svg)
        cone = solve(problem, "cone_ipm{cone=true}")
        self.assertEqual(check(problem, cone).model, "cone")
        solver = ContactSolver()
        solver.update(step)
        self.assertEqual(solver.solve(), "solved")
        self.assertTrue(check(problem, solver.impulses))
        with self.assertRaisesRegex(TypeError, "problem: expected a Problem or a Step, got ndarray"):
            check(answer.impulses, problem)

    def test_impulses_have_one_shape(self):
        problem = load(BOX)
        answer = solve(problem)
        f = answer.z[: problem.nc + sum(problem.edges)]
        for given in (f, answer.impulses, list(f)):
            np.testing.assert_allclose(Step(problem, impulses=given).impulses, answer.impulses, atol=1e-15)
        one_way = Problem(G=np.eye(3), N=[[0], [0], [1.0]], D=[[1.0, -1], [0, 0], [0, 0]], v=[1.0, 0, -1], mu=0.5)
        self.assertEqual(Step(one_way, impulses=[1.0, 0, 0.5]).impulses, [1.0, 0, 0.5])  # no second tangent

    def test_a_loaded_step_keeps_the_engines_impulses(self):
        problem = load(BOX)
        own = solve(problem).impulses
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "f.scenes")
            with Recorder(file, "box", engine="Mine") as recorder:
                recorder.add(Step(problem, impulses=own), 500)
            one, scenes = load(file + "#500"), load(file)
            self.assertEqual(repr(scenes), "<lcpbench.Scenes 'box': 1 steps of Mine>")
            np.testing.assert_array_equal(one.engine_impulses, own)
            np.testing.assert_array_equal(scenes[0].impulses, own)
            self.assertTrue(check(one))
            self.assertEqual(solve(one, "engine").verdict, "solved")
            with Recorder(file) as recorder:
                recorder.add(one)
            np.testing.assert_array_equal(load(file)[0].impulses, own)
        self.assertIsNone(load(BOX).engine_impulses)


class Words(unittest.TestCase):
    def test_mistakes_are_named(self):
        good = dict(G=np.eye(3), N=np.array([[0.0], [0], [1]]), v=[0.0, 0, -1])
        problem, solver = load(BOX), ContactSolver()
        for message, call in (
                ("N has shape (1, 3), expected (3, columns): this is the transpose",
                 lambda: Problem(**{**good, "N": good["N"].T})),
                ("tangents has shape (2, 3), expected (3, columns): this is the transpose",
                 lambda: Problem(**good, tangents=np.eye(3)[:2], mu=0.5)),
                ("ids[2] is that of contact 0 again", lambda: solver.update(problem, ["a", "b", "a", "c"])),
                ("contact_ids[3] is that of contact 1 again",
                 lambda: Recorder(os.devnull).add(Step(problem, contact_ids=["a", "b", "c", "b"]))),
                ("bodies[0].masse: unknown field (did you mean 'mass'?)",
                 lambda: Problem.from_scene([{"mass": 1, "inertia": np.eye(3), "masse": 1}], [])),
                ("did you mean 'contact_lemke'", lambda: solve(problem, "contact_lemk"))):
            with self.assertRaises(InputError) as caught:
                call()
            self.assertIn(message, str(caught.exception))
        with self.assertRaisesRegex(AttributeError, "a Problem has no 'edge' .did you mean 'edges'?"):
            problem.edge


if __name__ == "__main__":
    unittest.main()
