"""Files of Siconos' Friction Contact Library: ours are read by libfclib itself, and what is refused of others."""
import ctypes
import ctypes.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import lcpbench
import lcpbench.fclib

try:
    import h5py
except ModuleNotFoundError:
    h5py = None

M = np.array([[2, 0.5, 0], [0.5, 1, 0], [0, 0, 4.0]])  # two blocks
H = np.array([[1, 0, 0.5, 0, 0, 0.25], [0, 1, 0, 0, 0, 0], [0, 0, 0, 1, 2, 3.0]])
ROWS, COLUMNS, TRIPLETS = -2, -1, 0
INT, REALS = ctypes.POINTER(ctypes.c_int), ctypes.POINTER(ctypes.c_double)


class Matrix(ctypes.Structure):
    _fields_ = [("nzmax", ctypes.c_int), ("m", ctypes.c_int), ("n", ctypes.c_int), ("p", INT), ("i", INT), ("x", REALS),
                ("nz", ctypes.c_int), ("info", ctypes.c_void_p)]


class Global(ctypes.Structure):
    _fields_ = [(name, ctypes.POINTER(Matrix)) for name in "MHG"] + [(name, REALS) for name in ("mu", "f", "b", "w")] + [
        ("spacedim", ctypes.c_int), ("info", ctypes.c_void_p)]


class Local(ctypes.Structure):
    _fields_ = [(name, ctypes.POINTER(Matrix)) for name in "WVR"] + [(name, REALS) for name in ("mu", "q", "s")] + [
        ("spacedim", ctypes.c_int), ("info", ctypes.c_void_p)]


class Solution(ctypes.Structure):
    _fields_ = [(name, REALS) for name in "vurl"]


def dense(pointer):
    stored = pointer.contents
    result = np.zeros((stored.m, stored.n))
    for column in range(stored.n):
        for k in range(stored.p[column], stored.p[column + 1]):
            result[stored.i[k], column] = stored.x[k]
    return result


def library():
    name = ctypes.util.find_library("fclib")
    if name is None:
        raise unittest.SkipTest("libfclib is not installed")
    found = ctypes.CDLL(name)
    found.fclib_read_global.restype, found.fclib_read_local.restype = ctypes.POINTER(Global), ctypes.POINTER(Local)
    found.fclib_read_solution.restype = ctypes.POINTER(Solution)
    found.fclib_merit_local.restype = ctypes.c_double
    found.fclib_merit_local.argtypes = [ctypes.POINTER(Local), ctypes.c_int, ctypes.POINTER(Solution)]
    return found


def natural_map(r, u, mu):
    """What the impulses of a contact change by if they are moved by -(u + mu |u_t| n) and put back into the cone."""
    moved = r - u - [mu * np.hypot(*u[1:]), 0, 0]
    normal, tangent = moved[0], np.hypot(*moved[1:])
    if tangent > mu * normal:
        moved[0] = max(0, (normal + mu * tangent) / (1 + mu * mu))
        moved[1:] *= mu * moved[0] / tangent
    return r - moved


def two_balls():
    """Two balls, one on the other; the lower one slides on a belt, and its contact has an offset."""
    ball = dict(mass=2.0, inertia=0.1 * np.eye(3), linear_velocity=(0.3, 0, -1))
    return lcpbench.Problem.from_scene(
        [ball, {**ball, "position": (0, 0, 1)}],
        [dict(body_a=0, point=(0, 0, -0.5), normal=(0, 0, 1), tangent=(1, 0, 0), mu=0.5, b=0.25, offset_t=(0.5, 0)),
         dict(body_a=1, body_b=0, point=(0, 0, 0.5), normal=(0, 0, 1), tangent=(1, 0, 0), mu=0.0)])


@unittest.skipIf(h5py is None, "h5py is not installed")
class Fclib(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.file = folder.name, os.path.join(folder.name, "problem.hdf5")

    def write(self, w=np.zeros(6), dimension=3, kind=COLUMNS, turned=False, **matrices):
        """A global file, as libfclib lays it out."""
        with h5py.File(self.file, "w") as file:
            for name, matrix in {"M": M, "H": H, **matrices}.items():
                lines = matrix if kind == ROWS else matrix.T
                at, along = np.nonzero(lines)
                values, ends = lines[at, along], np.cumsum([0, *np.count_nonzero(lines, axis=1)])
                p, i = (ends, along) if kind < 0 else (along, at) if turned else (at, along)
                for key, value in (("m", [matrix.shape[0]]), ("n", [matrix.shape[1]]), ("nz", [kind or len(values)]),
                                   ("p", p), ("i", i), ("x", values)):
                    file[f"fclib_global/{name}/{key}"] = np.array(value)
            for key, value in (("f", [1, -2, 0.1]), ("w", w), ("mu", [0.5, 0.25, 0.75][: 6 // dimension])):
                file[f"fclib_global/vectors/{key}"] = np.array(value, float)
            file["fclib_global/spacedim"] = np.array([dimension])
        return self.file

    def error(self, change=lambda file: None):
        with h5py.File(self.file, "a") as file:
            change(file)
        with self.assertRaises(lcpbench.InputError) as raised:
            lcpbench.fclib.load(self.file)
        return str(raised.exception).removeprefix(self.file + ": ")

    def replace(self, path, value, **how):
        def change(file):
            del file[path]
            file.create_dataset(path, data=value, **how)
        return change

    def test_every_way_to_store_a_matrix(self):
        for kind, turned in ((ROWS, False), (COLUMNS, False), (TRIPLETS, False), (TRIPLETS, True)):
            problem = lcpbench.fclib.load(self.write(kind=kind, turned=turned, w=[0.5, 0, 0.125, 0, 1, -2]))
            self.assertEqual(problem.name, "problem.hdf5")
            self.assertEqual([each.tolist() for each in problem.G], [M[:2, :2].tolist(), [[4.0]]])
            np.testing.assert_allclose(problem.v, np.linalg.solve(M, [1, -2, 0.1]), rtol=1e-15)
            np.testing.assert_array_equal(problem.N.toarray(), H[:, ::3])
            np.testing.assert_array_equal(problem.D.toarray(), np.hstack(
                [np.hstack([H[:, k : k + 2], -H[:, k : k + 2]]) for k in (1, 4)]))
            self.assertEqual((problem.mu.tolist(), problem.b.tolist()), ([0.5, 0.25], [0.5, 0]))
            self.assertEqual(np.ravel(problem.offset_t).tolist(), [0, 0.125, 1, -2])
        plane = lcpbench.fclib.load(self.write(dimension=2))
        self.assertEqual(list(plane.edges), [2, 2, 2])
        np.testing.assert_array_equal(plane.N.toarray(), H[:, ::2])

    def test_libfclib_reads_our_files_and_agrees_on_the_answer(self):
        fclib = library()
        problem = two_balls()
        answer = lcpbench.solve(problem, "cone_ipm{cone=true}")
        lcpbench.fclib.save(problem, self.file, answer)
        read = fclib.fclib_read_global(self.file.encode())
        stored = read.contents
        G, J = dense(stored.M), dense(stored.H)
        np.testing.assert_allclose(np.linalg.inv(G), problem.Ginv, rtol=1e-14)
        np.testing.assert_array_equal(J[:, ::3], problem.N.toarray())
        np.testing.assert_array_equal(J[:, 1:3], problem.D.toarray()[:, :2])
        self.assertEqual((stored.mu[:2], stored.w[:6], stored.spacedim), ([0.5, 0], [0.25, 0.5, 0, 0, 0, 0], 3))
        np.testing.assert_allclose(np.linalg.solve(G, stored.f[:12]), problem.v, rtol=1e-12)
        solution = fclib.fclib_read_solution(self.file.encode())
        r, u = (np.array(getattr(solution.contents, name)[:6]) for name in "ru")
        np.testing.assert_allclose(r.reshape(-1, 3), answer.impulses, atol=0)
        np.testing.assert_allclose(u, J.T @ (problem.v + problem.Ginv @ J @ r) + stored.w[:6], atol=1e-12)
        again = lcpbench.fclib.load(self.file)
        self.assertTrue(lcpbench.check(again, answer.impulses, model="cone"))
        self.assertFalse(lcpbench.check(again, 1.01 * answer.impulses, model="cone"))

    def test_local_problems(self):
        for name, inertia in (("global", dict(G=M)), ("local", dict(Ginv=np.linalg.inv(M)))):
            problem = lcpbench.Problem(**inertia, N=H[:, ::3], tangents=H[:, [1, 2, 4, 5]], mu=0.5, v=[1, -2, 0.1])
            lcpbench.fclib.save(problem, self.file)
            with h5py.File(self.file) as file:
                self.assertEqual(list(file), [f"fclib_{name}"])
            again = lcpbench.fclib.load(self.file)
            np.testing.assert_allclose(again.delassus(), problem.delassus(), atol=1e-14)
            np.testing.assert_allclose(again.M, problem.M, atol=1e-14)
            np.testing.assert_allclose(again.q, problem.q, atol=1e-14)
        fclib = library()
        answer = lcpbench.solve(problem, "cone_ipm{cone=true}")
        lcpbench.fclib.save(problem, self.file, answer)
        found = fclib.fclib_read_local(self.file.encode())
        solution, read = fclib.fclib_read_solution(self.file.encode()), found.contents
        W, q = dense(read.W), np.array(read.q[:6])
        np.testing.assert_allclose(W, H.T @ np.linalg.inv(M) @ H, atol=1e-15)
        np.testing.assert_allclose(q, H.T @ [1, -2, 0.1], atol=1e-15)
        self.assertLess(fclib.fclib_merit_local(found, 0, solution), 1e-9)
        for r in np.array([[1, 0.2, -0.1, 2, 1, -1], [0.1, 0.1, 0, 0.5, 0.2, 0.1]]):  # of which neither is a solution
            solution.contents.r = (ctypes.c_double * 6)(*r)
            maps = [natural_map(r[i : i + 3], (W @ r + q)[i : i + 3], 0.5) for i in (0, 3)]
            self.assertAlmostEqual(fclib.fclib_merit_local(found, 0, solution) / np.linalg.norm(maps)
                                   * (1 + np.sqrt(np.linalg.norm(q))), 1, 12)

    def test_equality_constraints_are_rows_without_bounds(self):
        E, b = np.array([[1, 0], [0, 0.5], [-1, 2.0]]), np.array([0.25, -1])
        for local, inertia in ((False, dict(G=M)), (True, dict(Ginv=np.linalg.inv(M)))):
            problem = lcpbench.Problem(**inertia, N=H[:, ::3], tangents=H[:, [1, 2, 4, 5]], mu=0.5, v=[1, -2, 0.1],
                                       rows=dict(R=E, lower=None, upper=None, b=b))
            lcpbench.fclib.save(problem, self.file)
            again = lcpbench.fclib.load(self.file)
            np.testing.assert_allclose(again.M, problem.M, atol=1e-14)
            np.testing.assert_allclose(again.q, problem.q, atol=1e-14)
            rows = again.rows
            self.assertEqual((list(rows["lower"]), list(rows["upper"]), rows["unit"], rows["names"]),
                             ([-np.inf] * 2, [np.inf] * 2, ["m", "m"], None))
            if local:
                found = library().fclib_read_local(self.file.encode()).contents
                Ginv = np.linalg.inv(M)
                np.testing.assert_allclose(dense(found.V), H.T @ Ginv @ E, atol=1e-15)
                np.testing.assert_allclose(dense(found.R), E.T @ Ginv @ E, atol=1e-15)
                np.testing.assert_allclose(found.s[:2], E.T @ [1, -2, 0.1] + b, atol=1e-15)
            else:
                found = library().fclib_read_global(self.file.encode()).contents
                np.testing.assert_array_equal(dense(found.G), E)
                self.assertEqual(found.b[:2], list(b))
        self.write(G=E)
        with h5py.File(self.file, "a") as file:
            file["fclib_global/vectors/b"] = b
        np.testing.assert_array_equal(lcpbench.fclib.load(self.file).rows["R"].toarray(), E)

    def test_what_is_outside_is_named(self):
        with self.assertRaisesRegex(lcpbench.InputError, "a bare LCP"):
            lcpbench.fclib.save(lcpbench.Problem(M=np.eye(2), q=[1, 2]), self.file)
        with self.assertRaisesRegex(lcpbench.InputError, "FCLIB has no compliance"):
            lcpbench.fclib.save(lcpbench.Problem(G=M, N=H[:, :1], v=[0, 0, 1], compliance_n=1e-3), self.file)
        asymmetric = M + np.diag([0.002, 0], 1)
        self.write(M=asymmetric)
        self.assertRegex(self.error(), r"fclib_global/M: is not symmetric: .* differ by 0.002, its largest entry is 4;")
        self.assertEqual(lcpbench.fclib.load(self.file, symmetrize=True).G[0][0, 1], 0.501)
        self.write(M=np.ones((3, 3)))
        self.assertEqual(self.error(), "fclib_global/M: is not positive definite")
        self.write(G=np.eye(3)[:, :1])
        self.assertEqual(self.error(), "fclib_global/vectors/b: is missing")
        self.write(G=np.eye(2))
        self.assertEqual(self.error(lambda file: file.create_dataset("fclib_global/vectors/b", data=[1.0, 2.0])),
                         "fclib_global: rows.R has shape (2, 2), expected (3, 2)")
        free = dict(R=np.ones((3, 1)), lower=None, upper=None)
        for rows, said in (({**free, "lower": -1}, "of bounded rows FCLIB has equality constraints alone"),
                           ({**free, "upper": 0.5}, "of bounded rows FCLIB has equality constraints alone"),
                           ({**free, "compliance": 1}, "FCLIB has no compliance")):
            with self.assertRaisesRegex(lcpbench.InputError, said):
                lcpbench.fclib.save(lcpbench.Problem(G=M, N=H[:, :1], v=[0, 0, 1], rows=rows), self.file)
        self.write()
        self.assertEqual(self.error(lambda file: file.create_group("fclib_local_rolling")),
                         "fclib_local_rolling: rolling friction is outside of the model")
        self.write(w=[0, 0, 0, 0, np.nan, 0])
        self.assertEqual(self.error(), "fclib_global/vectors/w: [4] is not finite")
        pathlib.Path(self.file).write_text("no HDF5")
        with self.assertRaisesRegex(lcpbench.InputError, "cannot be opened as an HDF5 file"):
            lcpbench.fclib.load(self.file)

    def test_damaged_files_and_links_are_refused(self):
        large = np.array([1 << 26])
        secret = os.path.join(self.folder, "secret")
        with h5py.File(secret, "w") as other:
            other["numbers"] = [1.0, 2.0, 3.0]
        f = "fclib_global/vectors/f"
        for change, said in (
                (self.replace("fclib_global/M/p", [0, 5, 2, 2]), "is no sparse matrix"),
                (self.replace("fclib_global/M/i", [0, 9, 0, 1, 2]), "is no sparse matrix"),
                (self.replace("fclib_global/M/m", large), "67108864 x 3 is no size of a matrix"),
                (self.replace(f, [1.0]), "has 1 entries, expected 3"),
                (self.replace(f, ["text"]), "is no dataset of numbers"),
                (self.replace(f, np.zeros(1 << 20), compression="gzip"), "has 1048576 numbers, more than the file"),
                (lambda file: file.__delitem__("fclib_global/vectors/mu"), "is missing")):
            self.write()
            self.assertIn(said, self.error(change))

        def link(file):
            del file[f]
            file[f] = h5py.ExternalLink(secret, "/numbers")

        def outside(file):
            del file[f]
            file.create_dataset(f, (3,), "f8", external=[(secret, 0, 24)])

        for change in (link, outside):
            self.write()
            self.assertRegex(self.error(change), f"^{f}: .* in another file, which is not read$")

    def test_scenes_become_files_and_come_back(self):
        steps = os.path.join(self.folder, "steps.scenes")
        with lcpbench.Recorder(steps) as recorder:
            recorder.add(two_balls(), 7)
        run = lambda *words: subprocess.run([sys.executable, "-m", "lcpbench.fclib", *words], cwd=self.folder, text=True,
                                            capture_output=True)
        self.assertEqual(run(steps, "--out", "files").returncode, 0)
        self.assertEqual(run("files/steps-7.hdf5", "--out", "back.scenes").returncode, 0)
        back = lcpbench.load(os.path.join(self.folder, "back.scenes"))[0].problem
        self.assertEqual(back.name, "steps-7.hdf5")
        np.testing.assert_allclose(back.q, two_balls().q, atol=1e-14)
        with lcpbench.Recorder(steps) as recorder:  # of which FCLIB cannot hold the second
            recorder.add(two_balls(), 7)
            recorder.add(lcpbench.Problem(G=M, N=H[:, :1], v=[0, 0, 1], compliance_n=1e-3), 8)
        some = run(steps, "--out", "files")
        self.assertEqual((some.returncode, some.stderr), (0, "lcpbench: 1 of 2 steps left out: FCLIB has no compliance\n"))
        failed = run("files/steps-7.hdf5", steps, "--out", "back.scenes")
        self.assertEqual((failed.returncode, failed.stderr),
                         (2, f"lcpbench: {steps}: cannot be opened as an HDF5 file\n"))


if __name__ == "__main__":
    unittest.main()
