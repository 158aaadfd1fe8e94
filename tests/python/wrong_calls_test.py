"""Wrong calls: each gives one exception of one line that names the argument."""
import os
import pathlib
import unittest

import numpy as np
import scipy.sparse

from lcpbench import ContactSolver, InputError, Problem, Recorder, Scenes, Step, check, load, save, solve

BOX = pathlib.Path(os.environ["LCPBENCH_SOURCE"]) / "examples" / "box_on_slope.json"
NAN, INF = float("nan"), float("inf")
GOOD = dict(G=np.eye(3), N=np.array([[0.0], [0], [1]]), D=np.array([[1.0, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]]),
            mu=[0.5], v=[1.0, 0, -1])
BODY = dict(mass=1.0, inertia=np.eye(3))
CONTACT = dict(body_a=0, point=[0.0, 0, 0], normal=[0.0, 0, 1], mu=0.5)
NOT_NUMBERS = ["text", 1j, object(), {}, [[1.0], [2.0, 3.0]]]


def without(key):
    return {name: value for name, value in GOOD.items() if name != key}


ROWS = dict(R=[[1.0, 0, 1], [0, 1, 1], [0, 0, 0]], lower=[None, 0, None], upper=None, friction_of=[None, None, 1],
            mu=[None, None, 0.5], unit=["m", "rad", "m"], names=["hinge", "stop", "screw"])


def wrong_rows():
    for field, values in {
            "R": (None, "R", np.ones((2, 3)), np.ones(3), [[1j] * 3] * 3, [[NAN] * 3] * 3,
                  scipy.sparse.csc_matrix((2, 3))),
            "lower": ([0, 0], "l", [0.5, 0, None], [NAN, 0, None], [None, 0, -1], np.ones((3, 1))),
            "upper": ([1, 1], "u", [-0.5, None, None], [None, NAN, None], [None, None, 1], {}),
            "b": ([1, 2], "b", [NAN, 0, 0], [[1, 2, 3]], INF), "compliance": (-1, [0, -1, 0], [1], NAN, "c", [1j] * 3),
            "friction_of": ([1], [None, None, 3], [None, None, 2], [0, None, 1], [None, None, 0], [None, None, 0.5], "f", [None, None, -2]),
            "mu": ([1], None, [0, 0, -1], [0, 0, NAN], "mu"),
            "unit": ("deg", ["m"], ["m", "rad", 3], 3, ["m", "rad", "mm"]),
            "names": ("name", ["a"], ["a", "b", 3], 3, ["a", "b", "c" * 1001], ["a", "b", "c\n"]),
            "colour": (1,)}.items():
        for value in values:
            yield (f"rows.{field}", lambda field=field, value=value: Problem(**GOOD, rows={**ROWS, field: value}))
    yield "rows.friction_of", lambda: Problem(**GOOD, rows={**ROWS, "lower": [None, -1, None]})
    yield "rows.friction_of", lambda: Problem(**GOOD, rows={**ROWS, "R": np.ones((3, 2))})
    yield "rows.lower[1] (stop)", lambda: Problem(**GOOD, rows={**ROWS, "upper": [None, 0, None]})
    for field in ("R", "lower", "upper"):
        yield (f"rows.{field}", lambda field=field: Problem(**GOOD, rows={key: each for key, each in ROWS.items() if key != field}))
    yield "rows.mu", lambda: Problem(**GOOD, rows={**ROWS, "friction_of": None})
    for value in (3, "rows", [ROWS]):
        yield "rows", lambda value=value: Problem(**GOOD, rows=value)
    yield "rows", lambda: Problem(M=[[1.0]], q=[-1], rows=ROWS)
    for validate in (True, False):  # what a solver would read past an array by
        yield "rows.friction_of", lambda v=validate: Problem(**GOOD, rows={**ROWS, "friction_of": [None, None, 7]}, validate=v)
        yield "rows.R", lambda v=validate: Problem(**GOOD, rows={**ROWS, "R": np.ones((2, 3))}, validate=v)
        yield "rows.upper", lambda v=validate: Problem(**GOOD, rows={**ROWS, "upper": [1]}, validate=v)
    some = Problem(**GOOD, rows=ROWS)
    yield "row_impulses", lambda: check(some, np.zeros((1, 3)))
    yield "row_impulses", lambda: check(some, np.zeros((1, 3)), row_impulses=[1, 2])
    yield "row_impulses", lambda: check(some, np.zeros(5), row_impulses="f")
    yield "impulses", lambda: check(some, np.zeros(5))
    yield "impulses", lambda: check(some, np.zeros(9), row_impulses=np.zeros(3))


def wrong_problems():
    """(what the message names, function)"""
    def problem(names, **changes):
        return names, lambda: Problem(**{**GOOD, **changes})

    for value in NOT_NUMBERS:
        for key in ("G", "N", "D", "mu", "v", "b", "compliance_n", "compliance_t", "offset_t"):
            yield problem(key, **{key: value})
    shapes = {"G": [(2, 2), (3, 2), (3,), (4, 4), (3, 3, 1)], "N": [(2, 1), (3,), (3, 1, 1), (3, 2)],
              "D": [(3, 3), (2, 4), (4,)], "mu": [(2,), (1, 1), (0,)], "v": [(2,), (3, 1), (4,), ()],
              "b": [(2,), (1, 1), (0, 1)], "compliance_n": [(2,), (1, 1)], "compliance_t": [(0,)],
              "offset_t": [(), (1,), (4,), (2, 1)]}
    for key, wrong in shapes.items():
        for shape in wrong:
            yield problem({"N": "", "D": "", "v": ""}.get(key, key), **{key: np.ones(shape)})
    for key in ("G", "N", "D", "mu", "v"):
        for bad in (NAN, INF):
            broken = np.array(GOOD[key], dtype=float)
            broken.flat[0] = bad
            yield problem(key, **{key: broken})
    for key in ("compliance_n", "compliance_t"):
        for bad in (-1.0, NAN, [INF]):
            yield problem(key, **{key: bad})
    yield problem("offset_t", offset_t=[0, NAN])
    yield problem("compliance_t", D=None, mu=0, compliance_t=[1.0])
    yield problem("offset_t", D=None, mu=0, offset_t=[1.0, 0])
    yield "offset_t", lambda: Problem(M=[[1.0]], q=[-1], offset_t=[1.0, 0])
    yield from wrong_rows()
    for key in ("G", "N", "mu", "v"):
        yield key, lambda key=key: Problem(**without(key))
    yield problem("G", G=np.diag([1.0, 1, -1]))
    yield problem("G", G=np.diag([1.0, 1, 0]))
    yield problem("G", G=np.eye(3) + np.triu(np.ones((3, 3)), 1))
    yield problem("G", G=[np.eye(2)])
    yield problem("G[1]", G=[np.eye(2), np.ones((1, 2))])
    yield problem("G", Ginv=np.eye(3))
    yield problem("Ginv", G=None, Ginv=np.eye(2))
    yield problem("Ginv", G=None, Ginv=-np.eye(3))
    yield problem("G_factors", G=None, G_factors=np.eye(3))
    yield problem("G_factors[0]", G=None, G_factors=(np.eye(2), [1, 1]))
    yield problem("alpha", G=None, G_factors=(np.eye(3), [1, 1, -1]))
    yield problem("mu", mu=[-0.5])
    yield problem("mu", mu=None)
    yield problem("mu", mu=0.5, D=None)
    yield problem("D", D=np.abs(GOOD["D"]))
    yield problem("edges", D=scipy.sparse.csc_matrix((3, 3)))
    yield problem("D", D=scipy.sparse.csc_matrix((2, 4)))
    yield problem("N", N=scipy.sparse.csc_matrix((2, 1)))
    good = scipy.sparse.csc_matrix(GOOD["N"])
    for form, field, value in (("csc", "indices", [3]), ("csc", "indices", [-1]), ("csc", "indptr", [0, 2]),
                               ("csc", "indptr", [1, 1]), ("csc", "indptr", [0]), ("csc", "indices", [2.0]),
                               ("csr", "indptr", [0, 2, 0, 1]), ("csr", "indices", [1]), ("coo", "row", [3]),
                               ("coo", "row", [-1]), ("coo", "col", [0, 0]), ("csc", "data", [1j])):
        broken = good.asformat(form, copy=True)
        setattr(broken, field, np.array(value))
        for validate in (True, False):
            yield problem("N", N=broken, validate=validate)
            if value != [1j]:
                yield problem("tangents", D=None, tangents=broken, validate=validate)
                yield problem("G", G=broken, validate=validate)
    for edges in (3, [3], [-2], [4, 4], 2, 8, [2.5], "x", [None], True):
        yield problem("", edges=edges)
    for validate in (True, False):
        yield problem("D is missing", D=None, mu=0, edges=4, validate=validate)
        yield problem("mu", mu=[-0.5], validate=validate)
        yield problem("edges", D=np.zeros((3, 3)), validate=validate)
    yield problem("tangents", tangents=np.ones((3, 2)))
    yield problem("tangents", D=None, tangents=np.ones((3, 3)))
    yield problem("D", D=None, tangents=np.ones((2, 2)))
    yield problem("name", name=3)
    yield problem("M", M=np.eye(2))
    yield "q", lambda: Problem(M=np.eye(2))
    for M, q in ((np.eye(2), [1.0]), (np.ones((2, 3)), [1.0, 2]), (np.ones(2), [1.0, 2]), ([[NAN]], [1]),
                 ([[1]], [INF]), ("M", [1]), (np.eye(1), "q"), ([[1j]], [1])):
        yield "", lambda M=M, q=q: Problem(M=M, q=q)
    yield "nonsense", lambda: Problem(nonsense=3)


def wrong_scenes():
    def scene(names, body=None, contact=None):
        return names, lambda: Problem.from_scene([{**BODY, **(body or {})}], [{**CONTACT, **(contact or {})}])

    for field, values in {"mass": (0, -1, NAN, INF, "m", None),
                          "inertia": (-np.eye(3), np.eye(2), "I", NAN * np.eye(3)),
                          "position": ([0, 0], "p", [NAN, 0, 0]), "linear_velocity": ([1], [INF, 0, 0]),
                          "angular_velocity": (np.ones((3, 1)), None), "colour": ("red",)}.items():
        for value in values:
            yield scene(f"bodies[0].{field}", body={field: value})
    for field, values in {"body_a": (1, -1, 0.5, "a", None), "body_b": (0, 3, -2), "point": ([0, 0], "p", [NAN, 0, 0]),
                          "normal": ([0, 0, 2], [0, 0, 0], [1, 0], "n"), "tangent": ([0, 0, 1], [1, 1, 0], [1], "t"),
                          "mu": (-1, NAN, "mu", None), "edges": (3, 8, "e", 0), "b": (NAN, "b"),
                          "compliance_n": (-1, NAN, "n"), "compliance_t": (INF, None), "offset_t": (0, [0], [NAN, 0]),
                          "colour": (1,)}.items():
        for value in values:
            yield scene("contacts[0]." + ("" if value == 0 and field == "edges" else field), contact={field: value})
    yield "bodies[0]", lambda: Problem.from_scene([3], [])
    yield "name", lambda: Problem.from_scene([BODY], [CONTACT], name=3)
    yield "bodies[0].mass", lambda: Problem.from_scene([{"inertia": np.eye(3)}], [])
    yield "contacts[0].point", lambda: Problem.from_scene([BODY], [{"body_a": 0, "normal": [0, 0, 1]}])


def wrong_uses():
    box, lcp = load(BOX), Problem(M=[[1.0]], q=[-1])
    solver = ContactSolver()
    for value in (None, 3, "x", [3]):
        yield "problem", lambda value=value: solve(value)
        yield "problem", lambda value=value: check(value, np.zeros(24))
        yield "problem", lambda value=value: solver.update(value)
    for name in ("nonsense", "auto{x=1}", "auto{", "", "lemke{piv_tol=-1}"):
        yield "", lambda name=name: solve(box, name)
        yield "", lambda name=name: ContactSolver(name)
    yield "solver", lambda: solve(box, 3)
    yield "solver", lambda: ContactSolver(None)
    for limit in (0, -1, "x", NAN):
        yield "time_limit", lambda limit=limit: solve(box, time_limit=limit)
    for threads in (0, -1, 1.5, "two"):
        yield "threads", lambda threads=threads: solve([box], threads=threads)
    yield (f"threads is {2**60}, expected an integer from {-2**30} to {2**30}",
           lambda: solve([box], threads=2**60))
    for error in (0, -1, "x", NAN):
        yield "error", lambda error=error: solve(box, error=error)
    for start in (np.zeros(3), "x", np.zeros((24, 1)), [1j] * 24):
        yield "start", lambda start=start: solve(box, start=start)
    yield "start", lambda: solve([box, box], start=[None])
    yield "start", lambda: solve([box, box], start=solve(box))
    yield "error", lambda: solve(box, "contact_lemke", error=1.0)
    yield "error", lambda: solve(box, start=solve(box), error=1.0)
    for impulses in (np.zeros(23), np.zeros((4, 2)), np.zeros((5, 3)), "x", None, 1j * np.zeros(24), 3.0,
                     [[1], [1, 2]]):
        yield "impulses", lambda impulses=impulses: check(box, impulses)
    yield "impulses", lambda: check(lcp, np.zeros(2))
    yield "velocity", lambda: check(box, np.zeros(24), np.zeros(5))
    yield "velocity", lambda: check(box, np.zeros(24), "x")
    yield "", lambda: check(lcp, [1.0], [1.0])
    for model in ("disc", "", 3):
        yield "model", lambda model=model: check(box, np.zeros(24), model=model)
    twice = Problem(G=np.eye(3), N=[[0], [0], [1.0]], D=[[1.0, 1, -1, -1], [0] * 4, [0] * 4], v=[1.0, 0, -1], mu=0.5)
    for model in ("cone", "convex"):
        yield "model '" + model, lambda model=model: check(twice, solve(twice).z, model=model)
    yield "friction", lambda: check(Problem(G=np.eye(1), N=[[1.0]], v=[0]), [[1.0, 1, 0]])
    for ids in ([], [1], [1, 2, 3, -1], [1, 2, 3, 2**64], [1, 2, 3, None], [1, 2, 3, 0.5], 7):
        yield "ids", lambda ids=ids: solver.update(box, ids)
    yield "problem", lambda: solver.update(lcp)
    yield "loaded", lambda: ContactSolver().solve()
    yield "loaded", lambda: ContactSolver().check()
    solver.update(box)
    for limit in (None, "x"):
        yield "time_limit", lambda limit=limit: solver.solve(limit)
    for v in (np.zeros(5), "x", np.zeros((6, 1)), [NAN] * 6, None):
        yield "v", lambda v=v: solver.set_velocity(v)
    for path in ("missing.json", "missing.scenes", "missing.scenes#1", __file__, 3, None):
        yield "", lambda path=path: load(path)
    yield "problem", lambda: save(3, "x")
    yield "", lambda: save(box, "/nowhere/x.json")
    yield "path", lambda: save(box, 3)
    for path in ("x.json\0y", b"\xff.json", "\ud800.scenes"):  # cut at NUL it would name another file
        for call in (load, Scenes, Recorder, lambda path: save(box, path)):
            yield "path", lambda path=path, call=call: call(path)
    yield "", lambda: Recorder("/nowhere/x.scenes")
    yield "every", lambda: Recorder(os.devnull, every=0)
    yield "step_length", lambda: Recorder(os.devnull, step_length="x")
    yield "scene", lambda: Recorder(os.devnull, 3)
    for step in (dict(gap=[1]), dict(contact_ids=["a"]), dict(impulses=np.zeros(24)), dict(velocity=[1])):
        yield next(iter(step)), lambda step=step: Recorder(os.devnull).add(Step(box, **step))
    yield "captured", lambda: Recorder(os.devnull).add(3)
    yield "bare", lambda: Recorder(os.devnull).add(lcp)
    yield "figure", lambda: lcp.figure()
    yield "figure", lambda: box.figure(3)


class WrongCalls(unittest.TestCase):
    def test_each_gives_one_line_that_names_the_argument(self):
        count = 0
        for names, call in (*wrong_problems(), *wrong_scenes(), *wrong_uses()):
            count += 1
            with self.subTest(call=count, names=names):
                with self.assertRaises((InputError, TypeError, RuntimeError)) as caught:
                    call()
                message = str(caught.exception)
                self.assertIn(names, message)
                self.assertNotIn("\n", message)
                self.assertNotIn("incompatible function arguments", message)
        self.assertGreaterEqual(count, 200)

    def test_a_wrong_call_leaves_the_solver_as_it_was(self):
        box, solver = load(BOX), ContactSolver()
        solver.update(box)
        self.assertEqual(solver.solve(), "solved")
        for _, call in ((None, lambda: solver.update(box, [1])), (None, lambda: solver.set_velocity([1]))):
            self.assertRaises(InputError, call)
        self.assertEqual(solver.solve(), "solved")


if __name__ == "__main__":
    unittest.main()
