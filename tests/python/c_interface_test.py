"""The interface for C, loaded at run time: liblcpbench_c.so, with the header as cffi reads it."""

import os
import pathlib
import re
import threading
import unittest

try:
    import cffi
except ImportError:
    cffi = None

HEADER = pathlib.Path(os.environ["LCPBENCH_SOURCE"], "native/lcpbench_c.h")


@unittest.skipIf(cffi is None, "needs cffi, which ./run-tests installs")
class CInterfaceTest(unittest.TestCase):
    def setUp(self):
        self.ffi = cffi.FFI()
        self.ffi.cdef(re.sub(r"^#.*|^extern .*|^\}$", "", HEADER.read_text(), flags=re.M))
        self.c = self.ffi.dlopen(os.environ["LCPBENCH_C"])
        self.kept = []

    def numbers(self, kind, values):
        self.kept.append(self.ffi.new(kind + "[]", values))
        return self.kept[-1]

    def ball(self, offset=0.0):
        """A ball of 2 kg that comes down with 3 m/s."""
        scene = self.ffi.new("lcpbench_scene*", {"bodies": 1, "contacts": 1})
        for name, values in {"mass": [2.0], "inertia": [1.0, 0, 0, 0, 1, 0, 0, 0, 1], "position": [0.0, 0, 1],
                             "velocity": [0.0, 0, -3, 0, 0, 0], "point": [0.0, 0, 0], "normal": [0.0, 0, 1],
                             "b": [offset]}.items():
            setattr(scene, name, self.numbers("double", values))
        scene.body_a, scene.body_b = self.numbers("int32_t", [0]), self.numbers("int32_t", [-1])
        return scene

    def solver(self, spec=b"auto"):
        place = self.ffi.new("lcpbench_solver**")
        self.assertEqual(self.c.lcpbench_create(spec, place), self.c.LCPBENCH_OK)
        return self.ffi.gc(place[0], self.c.lcpbench_destroy)

    def test_a_ball_stops_or_bounces(self):
        solver, claim = self.solver(), self.ffi.new("lcpbench_claim*")
        velocity, impulse = self.ffi.new("double[6]"), self.ffi.new("double[3]")
        for offset, after in ((0, 0), (-1.5, 1.5)):
            self.assertEqual(self.c.lcpbench_update(solver, self.ball(offset)), 0)
            self.assertEqual(self.c.lcpbench_solve(solver, float("inf"), claim), 0)
            self.assertEqual(claim[0], self.c.LCPBENCH_SOLVED)
            self.assertEqual(self.c.lcpbench_get_velocity(solver, velocity, 6), 0)
            self.assertEqual(self.c.lcpbench_get_impulses(solver, impulse, 3), 0)
            self.assertAlmostEqual(velocity[2], after, places=12)
            self.assertAlmostEqual(impulse[2], 2 * (3 + after), places=12)

    def test_errors_are_texts(self):
        self.assertEqual(self.c.lcpbench_create(b"simplex", self.ffi.new("lcpbench_solver**")), self.c.LCPBENCH_BAD_INPUT)
        self.assertIn("unknown solver 'simplex'", self.ffi.string(self.c.lcpbench_error_text()).decode())
        self.assertEqual(self.c.lcpbench_solve(self.solver(), 1, self.ffi.NULL), self.c.LCPBENCH_MISUSE)

    def test_a_second_thread_is_refused_or_waits_for_none(self):
        solver, scene, found = self.solver(), self.ball(), []
        self.assertEqual(self.c.lcpbench_update(solver, scene), 0)

        def work():
            for _ in range(2000):  # cffi lets other threads run during a call
                found.append(self.c.lcpbench_update(solver, scene))

        threads = [threading.Thread(target=work) for _ in range(2)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
        self.assertLessEqual(set(found), {self.c.LCPBENCH_OK, self.c.LCPBENCH_MISUSE})
        self.assertEqual(self.c.lcpbench_solve(solver, 1, self.ffi.NULL), 0)
