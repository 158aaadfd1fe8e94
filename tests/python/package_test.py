"""The package: solving, judging, files, errors, threads, memory."""
import copy
import json
import math
import os
import pathlib
import pickle
import resource
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy as np
import scipy.io
import scipy.sparse

import lcpbench
from lcpbench import ContactSolver, InputError, Problem, Recorder, Step, available_solvers, check, load, save, solve

INF = float("inf")
PROGRAM = os.environ["LCPBENCH_PROGRAM"]
BOX = pathlib.Path(os.environ["LCPBENCH_SOURCE"]) / "examples" / "box_on_slope.json"
# Set, how many: bare LCPs, contacts with and without friction, bodies, robots, hard cases, problems without a solution.
SETS = [(f"paper/{kind}/{exp}", 50) for kind in ("monotone", "copositive")
        for exp in ("exp1", "exp2", "exp3", "exp4", "exp5-1e8")]
SETS += [(f"rigid/{kind}{exp}", 50) for kind in ("", "frictional/") for exp in ("exp1", "exp2", "exp5-1e8")]
SETS += [("planted/definite", 100), ("made/hand", 10), ("made/gears", 10)]
SETS += [(f"hard/{case}", 1) for case in (
    "edge/tiny-pivot", "edge/denormal", "edge/huge", "cycling/kostreva", "degenerate/beale", "exponential/murty",
    "ill-conditioned/hilbert", "ray/copositive-none", "ray/infeasible", "ray/barely-infeasible", "class/n-matrix",
    "game/cyclic", "family/geiger-kanzow", "pde/string", "contact/sticking", "contact/painleve-impulse",
    "contact/massless", "contact/near-duplicate", "contact/grasp", "contact/box-tilted", "contact/stack",
    "contact/units", "contact/ring")]
SETS += [(f"scene/{case}", 6) for case in (
    "hand/mujoco", "humanoid-pushed/mujoco", "quadruped-trotting/mujoco", "slope/bullet", "gripper/ode",
    "bouncing-balls/dart", "dominoes/mujoco", "closed-chain/mujoco", "quadruped-standing/dart", "spinning-plate/dart",
    "humanoid-falling/mujoco", "card-house/ode", "uneven-table/bullet", "wedge/bullet", "hand/dart", "stack/ode")]


def program(*arguments):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode in (0, 1), (arguments, done.stderr)
    return done.stdout


def generated(folder, sets=SETS):
    for k, (name, count) in enumerate(sets):
        program("generate", name, "--seed", "7", "--count", str(count), "--out", f"{folder}/{k:03}")
    return sorted(pathlib.Path(folder).glob("*/*.json"))


def random_contacts(nc, seed, edges=4):
    rng = np.random.default_rng(seed)
    n = max(6, nc)
    tangents = rng.standard_normal((n, 2 * nc))
    root = rng.standard_normal((n, n))
    return Problem(G=root @ root.T + np.eye(n), N=rng.standard_normal((n, nc)), v=rng.standard_normal(n), mu=0.5,
                   tangents=tangents)


class SameBits(unittest.TestCase):
    def test_1000_problems_are_answered_and_judged_as_by_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            files = generated(folder)
            self.assertGreaterEqual(len(files), 1000)
            for solver, part in (("auto", files), ("contact_lemke", files[300::4]), ("lemke", files[::16]),
                                 ("cone_ipm{cone=true}", files[350::20]), ("psor", files[::20])):
                rows = json.loads(program("solve", *map(str, part), "--solver", solver, "--format", "json",
                                          "--time-limit", "600"))  # a limit that no load of the machine makes felt
                self.assertEqual(len(rows), len(part))
                for row, file in zip(rows, part):
                    self.compare(row, solve(load(file), solver, time_limit=600), file)

    def compare(self, row, answer, file):
        where = f"{file.parent.name}/{file.name} {answer.solver}"
        self.assertEqual(row["claim"], answer.claim, where)
        expected = np.array([math.nan if each is None else each for each in row["z"] or []])
        if row["claim"] != "unsupported":
            self.assertEqual(expected.tobytes(), answer.z.tobytes(), where)
        if row["truth"] == answer.check.truth:  # the program may also settle the truth by exact arithmetic
            self.assertEqual(row["verdict"], answer.verdict, where)
        frictional = answer.problem.nc > 0 and any(answer.problem.edges)
        self.assertEqual(row["model"], answer.model if frictional else "pyramid", where)
        for name in ("velocity_residual_relative", "backward_row_norm", "model_error_m_per_s", "work_gain_j"):
            value = answer.check.errors[name]
            self.assertEqual(row["errors"][name], value if math.isfinite(value) else None, f"{where} {name}")

    def test_an_answer_without_impulses_has_no_velocity(self):
        answer = solve(random_contacts(2, 1), "velocity_ipm")
        self.assertEqual((answer.claim, answer.verdict, len(answer.z)), ("unsupported", "refused", 0))
        for name in ("velocity", "normal_impulses", "friction_impulses", "impulses"):
            with self.assertRaisesRegex(lcpbench.InputError, "velocity_ipm gave no impulses: it says unsupported"):
                getattr(answer, name)

    def test_threads_change_no_bit(self):
        problems = [random_contacts(3 + k % 9, k) for k in range(200)]
        one = solve(problems, threads=1)
        many = solve(problems, threads=4)
        for a, b in zip(one, many):
            self.assertEqual((a.claim, a.z.tobytes()), (b.claim, b.z.tobytes()))


    def test_a_batch_is_solved_without_pythons_lock(self):
        problems = [random_contacts(20, k) for k in range(200)]
        counted, ends = [0], threading.Event()

        def count():
            while not ends.is_set():
                counted[0] += 1
                time.sleep(0)

        interval = sys.getswitchinterval()
        sys.setswitchinterval(1000)  # another thread runs only where this one gives the lock away
        thread = threading.Thread(target=count)
        try:
            thread.start()
            before = counted[0]
            solve(problems)
            after = counted[0]
        finally:
            ends.set()
            sys.setswitchinterval(interval)
            thread.join()
        self.assertGreater(after, before)


class Judge(unittest.TestCase):
    def setUp(self):
        self.problem = load(BOX)
        self.answer = solve(self.problem)

    def test_every_form_of_an_answer_gets_the_same_verdict(self):
        z = self.answer.z
        for form in (z, z[:20], self.answer.impulses, list(z)):
            self.assertTrue(check(self.problem, form))
            self.assertLess(check(self.problem, form).residual, 1e-12)

    def test_the_verdict_names_the_worst_contact(self):
        impulses = self.answer.impulses.copy()
        impulses[2, 0] += 0.01
        found = check(self.problem, impulses)
        self.assertEqual(found.verdict, "wrong")
        self.assertIn("contact 2 ", found.worst)
        Step(self.problem, contact_ids=["a", "b", "foot on step", "d"])
        self.assertIn("contact 2 (foot on step) ", check(self.problem, impulses).worst)

    def test_sentences_name_what_violates_the_cone(self):
        problem = Problem(G=np.eye(3), N=[[0], [0], [1.0]], tangents=[[1.0, 0], [0, 1], [0, 0]], mu=0.5, v=[2.0, 0, -1])
        for model, friction, words in (
                ("cone", [0.5, 0], "slides at 2.5 m/s, and its friction of 0.5 N s points 180 degrees away"),
                ("cone", [0, 0.5], "slides at 2.06 m/s, and its friction of 0.5 N s points 104 degrees away"),
                ("cone", [-0.1, 0], "slides at 1.9 m/s although its friction is not used up: 0.4 N s are left"),
                ("cone", [-0.8, 0], "has more friction than its cone allows, by 0.3 N s"),
                ("convex", [-0.5, 0], "slides at 1.5 m/s and separates at 0 mm/s; the convex model asks it to separate "
                                      "at 0.75 m/s"),
                ("pyramid", [-0.1, 0], "slides at 1.9 m/s although its friction is not used up: 0.4 N s are left")):
            found = check(problem, [[1.0, *friction]], model=model)
            self.assertEqual(found.verdict, "wrong")
            self.assertIn("contact 0 " + words, found.worst)
        self.assertIn("contact 0 has a sliding speed of 7 m/s in z, and slides at 1.9 m/s",
                      check(problem, [1, 0, 0, 0.1, 0, 7.0]).worst)

    def test_cone_and_pyramid_are_two_models(self):
        # A block pushed along the diagonal slides: the pyramid of four edges allows mu there, the cone mu sqrt(2) of
        # that.
        problem = Problem(G=np.eye(3), N=[[0], [0], [1.0]], tangents=[[1.0, 0], [0, 1], [0, 0]], mu=0.5, v=[1, 1, -1.0])
        along = 0.5 / math.sqrt(2)
        cone, pyramid = [[1, -along, -along]], [[1, -0.25, -0.25]]
        self.assertTrue(check(problem, cone, model="cone"))
        self.assertFalse(check(problem, cone))
        self.assertTrue(check(problem, pyramid))
        self.assertFalse(check(problem, pyramid, model="cone"))
        self.assertEqual(solve(problem, "cone_ipm{cone=true}").model, "cone")
        self.assertEqual(solve(problem, error=1e-6).solver, "cone_ipm{cone=true}")
        self.assertEqual(solve(problem, error=1.0).solver, "auto")

    def test_a_contact_in_the_plane_has_a_cone(self):
        # Of 2 directions, alone and beside one of 4: it slides on at 0.5 m/s, braked by 0.5 N s.
        planar = Problem(G=np.eye(2), N=[[0], [1.0]], D=[[1.0, -1], [0, 0]], mu=0.5, v=[1.0, -1])
        two = Problem(G=np.eye(5), N=np.eye(5)[:, [1, 4]], D=np.array([[1.0, -1, 0, 0, 0, 0], [0] * 6, [0, 0, 1, 0, -1, 0],
                                                                        [0, 0, 0, 1, 0, -1], [0] * 6]),
                      edges=[2, 4], mu=0.5, v=[1.0, -1, 3, 4, -1])
        for problem, right, wrong in ((planar, [1, 0, 0.5], [1, 0, 0.4]),
                                      (two, [1, 1, 0, 0.5, 0, 0, 0.3, 0.4], [1, 1, 0, 0.4, 0, 0, 0.3, 0.4])):
            found = check(problem, right, model="cone")
            self.assertEqual(found.verdict, "solved", found)
            self.assertLess(found.residual, 1e-15)
            self.assertEqual(check(problem, wrong, model="cone").verdict, "wrong")

    def test_an_error_is_a_bound_or_no_claim(self):
        hexagon = np.array([[math.cos(a), math.sin(a), 0] for a in math.pi / 3 * np.arange(3)]).T
        problem = Problem(G=np.eye(3), N=[[0], [0], [1.0]], D=np.hstack([hexagon, -hexagon]), mu=0.5, v=[1, 0.5, -1.0])
        with self.assertRaisesRegex(lcpbench.InputError, r"problem\[0\] has no round cone"):
            solve(problem, error=1e-6)
        same = Problem(G=np.eye(2), N=[[0], [1.0]], tangents=[[1.0, 1.0], [0, 0]], mu=0.5, v=[2.0, -1.0])
        with self.assertRaisesRegex(lcpbench.InputError, "the same direction"):
            check(same, [[1.0, -0.35, -0.35]], model="cone")
        self.assertEqual(solve(same, "cone_ipm{cone=true}").claim, "unsupported")
        missed = solve(self.problem, error=1e-300)
        self.assertEqual(missed.claim, "numerical_failure")
        self.assertIn("miss 1e-300 m/s", missed.detail)

    def test_a_velocity_beside_the_impulses_has_to_be_theirs(self):
        self.assertTrue(check(self.problem, self.answer.z, self.answer.velocity))
        self.assertEqual(check(self.problem, self.answer.z, self.answer.velocity + 1).verdict, "wrong")

    def test_another_bound_may_be_asked_for(self):
        problem = Problem(M=[[2, 1], [1, 3]], q=[4, 5])
        dust = [2.5e-12, 1e-12]
        self.assertTrue(check(problem, dust))
        self.assertFalse(check(problem, dust, solved_at=1e-12))
        self.assertTrue(check(problem, [1e-3, 0], solved_at=1e-2))
        self.assertFalse(check(problem, [1e-3, 0]))
        for bad in (0, -1, 2, float("nan"), "x"):
            with self.assertRaises(lcpbench.InputError):
                check(problem, dust, solved_at=bad)

    def test_bare_problems(self):
        problem = Problem(M=[[2, 1], [1, 2.0]], q=[-5, -6])
        np.testing.assert_allclose(solve(problem).z, [4 / 3, 7 / 3])
        self.assertFalse(check(problem, [1, 2.0]))
        self.assertEqual(solve(Problem(M=[[-1.0]], q=[-1]), "lemke").verdict, "unsolvable")

    def test_mixed_problems(self):
        box = Problem(M=np.eye(2), q=[-1, 3], friction_of=[None, 0], mu=0.5)
        answer = solve(box)
        np.testing.assert_array_equal(answer.z, [1, -0.5])
        self.assertEqual(answer.verdict, "solved")
        wrong = check(box, [1, 0.5])
        self.assertEqual((wrong.verdict, wrong.worst_row), ("wrong", 1))
        self.assertIn("its bounds +-0.5 z[0]", wrong.worst)
        self.assertEqual((list(box.friction_of), list(box.mu), box.lower[1]), ([-1, 0], [0, 0.5], -np.inf))
        free = Problem(M=[[2, 1], [1, 2.0]], q=[-5, 6], lower=[None, -1], upper=np.inf)
        np.testing.assert_allclose(solve(free).z, [3, -1])
        self.assertEqual(pickle.loads(pickle.dumps(free)), free)
        self.assertEqual(Problem(M=[[1.0]], q=[-1], lower=0), Problem(M=[[1.0]], q=[-1]))
        for arguments in ({"lower": [0]}, {"lower": [0, math.nan]}, {"friction_of": [None, 0]}, {"lower": 2, "upper": 1}):
            with self.assertRaises(lcpbench.InputError):
                Problem(M=np.eye(2), q=[-1, 3], **arguments)

    def test_files_of_numpy_and_matlab(self):
        import scipy.io

        box = Problem(M=np.eye(2), q=[-1, 3], lower=[0, -1], upper=[np.inf, 2])
        N, v = np.array([[0.0], [0], [1]]), np.array([1, 0, -0.1])
        contacts = Problem(G=np.eye(3), N=N, tangents=np.eye(3)[:, :2], mu=0.5, v=v)
        with tempfile.TemporaryDirectory() as folder:
            bare = dict(M=box.M, q=box.q, lower=box.lower, upper=box.upper)
            np.savez(f"{folder}/box.npz", **bare)
            scipy.io.savemat(f"{folder}/box.mat", {**bare, "M": scipy.sparse.csc_matrix(box.M)})
            given = dict(G=np.eye(3), N=N, tangents=np.eye(3)[:, :2], mu=0.5, v=v)
            np.savez(f"{folder}/contacts.npz", **given)
            scipy.io.savemat(f"{folder}/contacts.mat", given)
            for end in ("npz", "mat"):
                self.assertEqual(load(f"{folder}/box.{end}"), box)
                self.assertEqual(load(f"{folder}/box.{end}").name, "box")
                self.assertEqual(load(f"{folder}/contacts.{end}"), contacts)
            np.savez(f"{folder}/bad.npz", A=box.M)
            for name, words in (("bad.npz", "A: unknown; known: G, "), ("none.npz", "cannot be read"),
                                ("none.mat", "cannot be read")):
                with self.assertRaisesRegex(lcpbench.InputError, words):
                    load(f"{folder}/{name}")


class Construction(unittest.TestCase):
    def test_dense_sparse_blocks_and_factors_are_one_problem(self):
        rng = np.random.default_rng(3)
        N, T = rng.standard_normal((6, 2)), rng.standard_normal((6, 4))
        G = np.kron(np.eye(2), np.diag([2.0, 2, 4]))
        v = rng.standard_normal(6)
        dense = Problem(G=G, N=N, tangents=T, mu=0.5, v=v)
        D = dense.D
        for other in (
                Problem(G=[G[:3, :3], G[3:, 3:]], N=scipy.sparse.csc_matrix(N), tangents=scipy.sparse.csr_matrix(T),
                        mu=0.5, v=v),
                Problem(G=scipy.sparse.csc_matrix(G), N=scipy.sparse.coo_matrix(N), D=D, mu=[0.5, 0.5], v=list(v)),
                Problem(G_factors=(np.eye(6), np.diag(G)), N=N, D=np.asfortranarray(D), edges=[4, 4], mu=0.5, v=v),
                Problem(Ginv=np.linalg.inv(G), N=N.copy(order="F"), D=D, edges=4, mu=0.5, v=v)):
            np.testing.assert_allclose(other.delassus(), dense.delassus(), atol=1e-12)
            np.testing.assert_array_equal(solve(other).velocity.round(9), solve(dense).velocity.round(9))

    def test_sparse_matrices_of_the_caller_stay_as_they_are(self):
        N = scipy.sparse.csc_matrix((np.array([0.5, 0.25, 0.5]), np.array([2, 0, 2]), np.array([0, 3])), shape=(3, 1))
        for each in (N.data, N.indices, N.indptr):
            each.flags.writeable = False
        problem = Problem(G=np.eye(3), N=N, v=np.ones(3))
        np.testing.assert_array_equal(N.indices, [2, 0, 2])
        np.testing.assert_array_equal(np.asarray(problem.delassus()), [[1.0625]])

    def test_a_scene_is_the_problem_of_its_file(self):
        text = json.loads(BOX.read_text())
        scene = Problem.from_scene(text["bodies"], text["contacts"], name="other")
        self.assertEqual(scene, load(BOX))
        self.assertEqual(scene.points.shape, (4, 3))
        free = Problem.from_scene([{"mass": 1, "inertia": np.eye(3), "linear_velocity": [0, 0, -1]}],
                                  [{"body_a": 0, "point": [0, 0, 0], "normal": [0, 0, 1]}])
        np.testing.assert_array_equal(solve(free).velocity, np.zeros(6))

    def test_soft_contacts_give_way(self):
        free = dict(G=2 * np.eye(3), N=[[0], [0], [1.0]], tangents=[[1.0, 0], [0, 1], [0, 0]], mu=0.5, v=[0.5, 0, -1.0])
        # Each impulse by hand: the speed of approach by 1/m + r_n, the slip that is left by 1/m + r_t.
        problem = Problem(**free, compliance_n=0.3, compliance_t=[0.75], offset_t=[[0.0, 0.2]])
        answer = solve(problem)
        normal = 1 / (0.5 + 0.3)
        np.testing.assert_allclose(answer.impulses, [[normal, -0.5 / 1.25, -0.2 / 1.25]], atol=1e-12)
        self.assertTrue(check(problem, answer.impulses))
        self.assertTrue(check(problem, answer.impulses, model="cone"))
        self.assertFalse(check(Problem(**free), answer.impulses))
        self.assertAlmostEqual(problem.M[0, 0], 0.5 + 0.3, delta=1e-12)
        loop = ContactSolver()
        loop.update(problem)
        self.assertEqual((loop.solve(), loop.check().verdict), ("solved", "solved"))
        scene = Problem.from_scene(
            [dict(mass=2, inertia=np.eye(3), linear_velocity=[0.5, 0, -1])],
            [dict(body_a=0, point=[0, 0, 0], normal=[0, 0, 1], tangent=[1, 0, 0], mu=0.5, compliance_n=0.3,
                  compliance_t=0.75, offset_t=[0, 0.2])])
        np.testing.assert_allclose(solve(scene).impulses, answer.impulses, atol=1e-12)
        with tempfile.TemporaryDirectory() as folder:
            for each in (problem, scene):
                save(each, f"{folder}/soft.json")
                again = load(f"{folder}/soft.json")
                self.assertEqual(again, each)
                self.assertEqual((list(again.compliance_n), list(again.compliance_t), list(again.offset_t)),
                                 ([0.3], [0.75], [0, 0.2]))
                row, = json.loads(program("solve", f"{folder}/soft.json", "--solver", "auto", "--format", "json"))
                self.assertEqual(row["verdict"], "solved")
        self.assertEqual(list(Problem(**free).offset_t), [0, 0])

    def test_answers_have_impulses_of_bounded_rows(self):
        """An arm that runs into its stop against the dry friction of its bearing."""
        arm = load(BOX.with_name("arm_at_its_stop.json"))
        answer = solve(arm)
        self.assertEqual((answer.verdict, answer.impulses.shape), ("solved", (0, 3)))
        np.testing.assert_allclose(answer.row_impulses, [1.1, 0.5], rtol=1e-12)
        np.testing.assert_allclose(answer.velocity, [-0.2], rtol=1e-12)
        solver = ContactSolver()
        solver.update(arm)
        self.assertEqual(solver.solve(), "solved")
        np.testing.assert_allclose(solver.row_impulses, [1.1, 0.5], rtol=1e-12)
        none = np.zeros((0, 3))
        for right, rows in ((True, [1.1, 0.5]), (False, [1.1, 0.4]), (False, [1.2, 0.6])):
            self.assertEqual(bool(check(arm, none, row_impulses=rows)), right)
            self.assertEqual(bool(check(arm, np.array(rows))), right)
            self.assertEqual(bool(check(Step(arm, impulses=none, row_impulses=rows))), right)
        sliding = Problem(G=np.eye(3), N=[[0], [0], [1.0]], tangents=np.eye(3)[:, :2], mu=0.5, v=[1.0, 0, -1],
                          rows=dict(R=[[1.0], [0], [0]], lower=-0.25, upper=0.25))
        answer = solve(sliding)
        np.testing.assert_allclose(answer.velocity, [0.25, 0, 0], atol=1e-12)  # 1 less 0.5 of the contact and 0.25
        self.assertTrue(check(sliding, answer.impulses, row_impulses=answer.row_impulses))
        self.assertFalse(check(sliding, answer.impulses, row_impulses=[0.0]))

    def test_bounded_rows_stand_beside_contacts(self):
        R = np.array([[1.0, 0, 0, 2], [0, 1, 0.5, 0], [-1, 0, 0, 1]])
        G, N, v = np.diag([2.0, 4, 5]), np.array([[0.0], [0], [1]]), np.array([1.0, 0, -1])
        rows = dict(R=R, lower=[None, -0.1, 0, None], upper=[np.inf, 0.2, 1e20, None], b=[0.5, 0, 0, 0],
                    compliance=[0, 1e-3, 0, 0], friction_of=[None, -1, None, 2], mu=[None, None, None, 0.3],
                    unit=["m", "rad", "m", "m"], names=["weld", "", "limit", "screw"])
        problem = Problem(G=G, N=N, v=v, rows=rows)
        self.assertEqual((problem.size, problem.nc), (5, 1))
        self.assertEqual(repr(problem),
                         "<lcpbench.Problem 'problem': 1 contacts, 0 with friction, 4 bounded rows, 3 coordinates>")
        J = np.hstack([N, R])
        M = J.T @ np.linalg.inv(G) @ J
        M[2, 2] += 1e-3
        np.testing.assert_allclose(problem.M, M, rtol=1e-15)
        np.testing.assert_allclose(problem.q, J.T @ v + [0, 0.5, 0, 0, 0], rtol=1e-15)
        found = problem.rows
        self.assertEqual({key: list(value) for key, value in found.items() if key != "R"}, dict(
            lower=[-INF, -0.1, 0, -INF], upper=[INF, 0.2, INF, INF], b=[0.5, 0, 0, 0], compliance=[0, 1e-3, 0, 0],
            friction_of=[-1, -1, -1, 2], mu=[0, 0, 0, 0.3], unit=rows["unit"], names=rows["names"]))
        np.testing.assert_array_equal(found["R"], R)
        sparse = Problem(G=G, N=N, v=v, rows={**found, "R": scipy.sparse.csr_matrix(R)})
        np.testing.assert_array_equal(sparse.rows["R"].toarray(), R)
        with tempfile.TemporaryDirectory() as folder:
            save(problem, f"{folder}/p.json")
            for again in (sparse, Problem(G=G, N=N, v=v, rows=found), load(f"{folder}/p.json"), copy.deepcopy(problem),
                          pickle.loads(pickle.dumps(problem))):
                self.assertEqual(again, problem)
                self.assertEqual(again.rows["names"], rows["names"])
            whole = dict(G=G, N=N, v=v, **{f"rows_{key}": value for key, value in found.items() if key != "unit"})
            np.savez(f"{folder}/p.npz", **whole, rows_unit=found["unit"])
            for units in (np.array(found["unit"]), np.array(found["unit"], dtype=object)):  # of one length, and cells
                scipy.io.savemat(f"{folder}/p.mat", {**whole, "rows_unit": units, "rows_R": scipy.sparse.csc_matrix(R)})
                for end in ("npz", "mat"):
                    self.assertEqual(load(f"{folder}/p.{end}"), problem)
                    self.assertEqual(load(f"{folder}/p.{end}").rows["names"], rows["names"])
            f = dict(impulses=[[0.5, 0, 0]], row_impulses=[1.0, 0, 0.25, -0.125])
            with Recorder(f"{folder}/f.scenes") as recorder:
                recorder.add(Step(problem, **f))
                recorder.add(Step(problem, impulses=np.array([0.5, 1, 0, 0.25, -0.125])))
                recorder.add(load(f"{folder}/f.scenes#0"))
            for step in load(f"{folder}/f.scenes"):
                self.assertEqual((step.impulses.tolist(), step.row_impulses.tolist()), (f["impulses"], f["row_impulses"]))
        self.assertIsNone(Problem(G=G, N=N, v=v).rows)
        self.assertIsNone(Problem(G=G, N=N, v=v, rows=dict(R=np.zeros((3, 0)), lower=[], upper=[])).rows)
        one = Problem(G=G, N=N, v=v, rows=dict(R=R[:, :2], lower=-1, upper=None, b=2, compliance=3, unit="rad")).rows
        self.assertEqual([list(one[key]) for key in ("lower", "upper", "b", "compliance", "unit")],
                         [[-1, -1], [INF, INF], [2, 2], [3, 3], ["rad", "rad"]])
        self.assertIsNone(one["names"])

    def test_contacts_without_friction_take_no_part_of_the_tangents(self):
        problem = Problem(G=np.eye(3), N=np.eye(3), tangents=np.ones((3, 6)), mu=[0, 0.5, 0], v=-np.ones(3))
        self.assertEqual(problem.edges, [0, 4, 0])
        empty = Problem(G=np.eye(3), N=np.zeros((3, 0)), v=np.ones(3))
        self.assertEqual(solve(empty).verdict, "solved")
        np.testing.assert_array_equal(solve(empty).velocity, np.ones(3))

    def test_notebooks_get_tables_and_pictures(self):
        problem = load(BOX)
        answers = solve(problem), solve(problem, "contact_lemke")
        self.assertIn("<table>", problem._repr_html_() + answers[0]._repr_html_())
        svg = problem.figure(*answers)._repr_svg_()
        self.assertIn("contact_lemke: solved", svg)
        self.assertEqual(svg.count("contact 3<"), 1)
        answers[1].z = np.full_like(answers[1].z, math.nan)
        self.assertNotIn("nan", problem.figure(*answers).svg)
        other = Problem(G=np.eye(4), N=np.eye(4), v=-np.ones(4))
        with self.assertRaisesRegex(lcpbench.InputError, "no Answer to this problem"):
            problem.figure(solve(other))


class Files(unittest.TestCase):
    def test_problems_and_steps_come_back_bit_for_bit(self):
        problems = [random_contacts(nc, nc) for nc in range(1, 5)]
        with tempfile.TemporaryDirectory() as folder:
            save(problems[0], f"{folder}/p.json")
            self.assertEqual(load(f"{folder}/p.json"), problems[0])
            with Recorder(f"{folder}/r.scenes", "test", every=10, step_length=0.01) as recorder:
                for k in range(35):
                    if recorder.wants_next():
                        i = k // 10
                        recorder.add(lcpbench.Step(problems[i], time=0.01 * k, gap=np.zeros(i + 1),
                                                   contact_ids=[str(c) for c in range(i + 1)]))
            scenes = load(f"{folder}/r.scenes")
            self.assertEqual([each.step for each in scenes], [0, 10, 20, 30])
            self.assertEqual([each.problem for each in scenes], problems)
            self.assertEqual(load(f"{folder}/r.scenes#20"), problems[2])
            self.assertEqual((scenes.step_length, scenes[3].contact_ids[-1], scenes[-1].step), (0.01, "3", 30))
            rows = json.loads(program("solve", f"{folder}/r.scenes", "--solver", "auto", "--format", "json"))
            self.assertEqual([row["verdict"] for row in rows], ["solved"] * 4)

    def test_a_recorder_counts_on_from_the_last_step(self):
        with tempfile.TemporaryDirectory() as folder:
            with Recorder(f"{folder}/r.scenes") as recorder:
                for step in (None, 5, None, 9, None, 2**40):
                    recorder.add(random_contacts(1, 1), step)
            scenes = load(f"{folder}/r.scenes")
            self.assertEqual([each.step for each in scenes], [0, 5, 6, 9, 10, 2**40])
            self.assertEqual(load(f"{folder}/r.scenes#{2**40}"), scenes[-1].problem)

    def test_problems_travel_between_processes(self):
        for problem in (random_contacts(3, 1), load(BOX), Problem(M=[[2.0]], q=[-1])):
            self.assertEqual(pickle.loads(pickle.dumps(problem)), problem)

    def test_a_matlab_file_that_crashes_scipy_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "p.mat")
            scipy.io.savemat(file, dict(M=scipy.sparse.diags([2.0, 3.0]).tocsc(), q=[-1.0, -2.0]))
            self.assertEqual(list(solve(load(file)).z), [0.5, 2 / 3])
            damaged = bytearray(file.read_bytes())
            damaged[177] ^= 0xFF  # a size: scipy 1.17 crashes
            file.write_bytes(damaged)
            with self.assertRaisesRegex(InputError, "^[^\n]*p.mat: cannot be read: [^\n]*$"):
                load(file)
            with unittest.mock.patch("lcpbench._files._MAT_READER", "import os; os.abort()"), \
                    self.assertRaisesRegex(InputError, "p.mat: cannot be read: it is damaged so that scipy crashes"):
                load(file)

    def test_hdf5_is_an_error_that_says_who_reads_it(self):
        with self.assertRaisesRegex(InputError, "a.hdf5: HDF5 is not read here; lcpbench.fclib.load reads files of FCLIB"):
            load("a.hdf5")
        with unittest.mock.patch.dict(sys.modules, h5py=None), self.assertRaisesRegex(InputError, "needs h5py"):
            lcpbench.fclib.load("a.hdf5")

    def test_no_impulses_to_judge_is_an_error_that_says_so(self):
        with self.assertRaisesRegex(InputError, "^impulses: is None, and the problem has no impulses of an engine$"):
            check(load(BOX))

    def test_answers_without_contacts_are_empty_lists(self):
        free = Problem(G=np.eye(2), N=np.zeros((2, 0)), v=[1.0, -2.0])
        with tempfile.TemporaryDirectory() as folder:
            save(free, f"{folder}/p.json")
            for command in (["solve", "--solver", "auto"], ["certify"]):
                row = json.loads(program(*command, f"{folder}/p.json", "--format", "json"))[0]
                self.assertEqual((row["z"], row["velocity"]), ([], [1.0, -2.0]))

    def test_answers_are_read_only(self):
        for solver in ("auto", "cone_ipm{cone=true}"):
            answer = solve(load(BOX), solver)
            for name in ("z", "velocity", "impulses", "normal_impulses", "friction_impulses"):
                with self.subTest(name), self.assertRaisesRegex(ValueError, "read-only"):
                    getattr(answer, name)[...] = 0
            self.assertEqual(check(answer.problem, answer.z).verdict, answer.verdict)

    def test_certificates_of_the_program(self):
        squeezed = Problem(G=[[2.0]], N=[[1.0, -1.0]], v=[0.0], b=[-1.0, -3.0])
        found = lcpbench.certify(squeezed)
        self.assertEqual((found.certificate, found.proof, found.z, bool(found)), ("unsolvable", "farkas", None, False))
        self.assertGreater(found.farkas.min(), 0)
        found = lcpbench.certify(Problem(G=[[2.0]], N=[[1.0]], v=[-0.25]))
        self.assertEqual((found.certificate, list(found.z), list(found.velocity)), ("solution", [0.5], [0.0]))
        self.assertTrue(found and found.velocity_unique)
        with unittest.mock.patch.dict(os.environ, LCPBENCH_PROGRAM="", PATH=""), \
                self.assertRaisesRegex(InputError, "^certify: needs the program lcpbench"):
            lcpbench.certify(squeezed)

    def test_modules_of_engines_come_with_the_package(self):
        words = "import lcpbench, sys; assert 'lcpbench.mujoco' not in sys.modules; lcpbench.mujoco.capture; " \
                "lcpbench.fclib.load; assert 'mujoco' not in sys.modules; lcpbench.havok"
        done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True)
        self.assertEqual(done.stderr.splitlines()[-1], "AttributeError: module 'lcpbench' has no attribute 'havok'")

    def test_the_module_starts_the_program_or_says_how_to_get_it(self):
        def run(**more):
            return subprocess.run([sys.executable, "-m", "lcpbench", "--version"], capture_output=True, text=True,
                                  env={**os.environ, **more})

        self.assertEqual(run().stdout, program("--version"))
        self.assertEqual(run(LCPBENCH_PROGRAM="", PATH=os.path.dirname(PROGRAM)).stdout, program("--version"))
        self.assertRegex(run(LCPBENCH_PROGRAM="", PATH="").stderr, "^lcpbench: .* without the program: .*LCPBENCH_PROGRAM\n$")

    def test_solvers_of_the_program_answer_too(self):
        solvers = {each.name: each for each in available_solvers()}
        self.assertIn("auto", solvers)
        foreign = [each.name for each in solvers.values() if each.library == "Bullet" and not each.unavailable]
        if not foreign:
            self.skipTest("the program was built without Bullet")
        answer = solve(load(BOX), "bullet_lemke", time_limit=float("inf"))
        self.assertEqual(len(answer.z), 24)
        self.assertIn(answer.verdict, ("solved", "wrong", "missed"))


    def external(self, folder, **answer):
        """A solver of the external protocol that gives this answer."""
        script = pathlib.Path(folder, "solver.py")
        script.write_text(f"""import json, sys
for line in sys.stdin:
    request = json.loads(line)
    answer = dict({answer!r}, detail=str(request["time_limit_s"])) if request["verb"] == "solve" else dict()
    print(json.dumps(dict(answer, sequence=request["sequence"])), flush=True)
""")
        return f"external{{command={sys.executable} '{script}',form=contact}}"

    def test_the_programs_solvers_have_the_time_limit_that_was_asked_for(self):
        problem = Problem(G=[[1.0]], N=[[1.0]], v=[-1.0])
        with tempfile.TemporaryDirectory() as folder:
            solver = self.external(folder, claim="solved", z=[1.0])
            for limit, given in ((None, 1e7), (3, 3), (1e9, 1e7)):
                answer = solve(problem, solver, time_limit=limit)
                self.assertEqual((answer.verdict, float(answer.detail)), ("solved", given))

    def test_a_velocity_of_the_programs_solvers_has_to_be_that_of_their_impulses(self):
        problem = Problem(G=[[1.0]], N=[[1.0]], v=[-1.0])
        with tempfile.TemporaryDirectory() as folder:
            for velocity, verdict in ((0.0, "solved"), (5.0, "wrong")):
                answer = solve(problem, self.external(folder, claim="solved", z=[1.0], velocity=[velocity]))
                self.assertEqual((answer.verdict, list(answer.velocity)), (verdict, [velocity]))

    def test_an_answer_says_which_impulses_it_has(self):
        legs = [[1, 1, 1], [0.5, 0, -0.5]]  # of a beam on three supports
        problem = Problem(G=[[2.0, 0.0], [0.0, 1.0]], N=legs, v=[-1.5, 0.0])
        self.assertEqual(solve(problem).which_impulses, "any")
        even = solve(problem, "auto{impulses=even}")
        self.assertEqual((even.which_impulses, even.verdict), ("even", "solved"))
        np.testing.assert_allclose(even.normal_impulses, 1.0, rtol=1e-12)
        self.assertEqual(solve(problem, "psor").which_impulses, "")

class Loop(unittest.TestCase):
    def test_steps_follow_one_another(self):
        solver = ContactSolver("auto")
        for k in range(20):
            problem = random_contacts(3 + k % 3, k)
            solver.update(problem, [f"c{i}" for i in range(problem.nc)])
            self.assertEqual(solver.solve(), "solved")
            self.assertTrue(solver.check())
            np.testing.assert_allclose(solver.velocity, problem._data.velocity(solver.z), atol=1e-9)
            solver.set_velocity(-problem.v)
            self.assertEqual(solver.solve(1.0), "solved")
            self.assertTrue(solver.check())  # of the new velocity

    def test_a_proof_that_there_is_no_solution_counts(self):
        # Two contacts squeeze a body from both sides, and both ask for 1 m/s.
        problem = Problem(G=[[1.0]], N=[[1.0, -1.0]], v=[0.0], b=[-1.0, -1.0])
        for name in ("auto", "contact_lemke"):
            solver = ContactSolver(name)
            solver.update(problem)
            self.assertEqual((solver.solve(), solver.check().verdict), ("unsolvable", "unsolvable"))
            self.assertEqual(repr(solver.check()), repr(solve(problem, name).check))

    def test_memory_is_flat_over_a_million_solves(self):
        solver, problem = ContactSolver("auto"), random_contacts(3, 1)
        v = problem.v

        def work(count):
            for k in range(count):
                solver.update(problem, (1, 2, 3)) if k % 10 == 0 else solver.set_velocity(v)
                solver.solve()
                solver.velocity
                if k % 100 == 0:
                    solve(problem).check, check(problem, solver.z)
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

        before = work(100000)
        self.assertLess(work(900000) - before, 1024)  # KiB


if __name__ == "__main__":
    unittest.main()
