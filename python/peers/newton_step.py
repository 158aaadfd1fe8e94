#!/usr/bin/env python3
"""A step of Newton on the CPU: newton_step.py [ITERATIONS], with form=scene,cone=true.

SolverSteel, projected Gauss-Seidel in single precision, takes the contacts as they are and tells its forces. ITERATIONS
is 12 in Newton, 10,000 unless given. Its softening cfm is 0. Offsets of contacts become gaps and penetrations that
count in full (baumgarte 1), to 1e-5 m/s, because positions are of single precision. Its other modes of friction need
CUDA. Warp compiles its kernels at the first start, into files that lcpbench does not let a solver write: start the
program by hand once, as study.sh does.
"""
import sys

from peer import Contacts, serve, timed  # first, because Warp prints
import newton
import numpy as np
import warp as wp

iterations = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
STEP = 5e-3
wp.config.quiet = True
wp.set_device("cpu")


def load(text):
    problem = Contacts.of_scene(text)
    if problem.nc == 0:
        return lambda _: problem.of_engine([])
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    for each in text["bodies"]:
        builder.add_body(xform=wp.transform(wp.vec3(*each["position"]), wp.quat_identity()), mass=each["mass"],
                         inertia=wp.mat33(*np.ravel(each["inertia"])), lock_inertia=True)
    contacts = newton.Contacts(problem.nc, 0)
    points, shapes = np.zeros((2, problem.nc, 3)), np.zeros((2, problem.nc), dtype=np.int32)
    offsets = bool(np.any(problem.b != 0))
    gaps = problem.b * STEP if offsets else np.full(problem.nc, -1e-6)  # overlaps, so that no rounding is a gap
    for i, contact in enumerate(text["contacts"]):
        for side, k in enumerate((contact["body_a"], contact["body_b"])):
            config = newton.ModelBuilder.ShapeConfig(density=0.0, mu=float(problem.mu[i]), has_shape_collision=False,
                                                     mu_torsional=0.0, mu_rolling=0.0)
            shapes[side, i] = builder.add_shape_sphere(k, radius=1e-3, cfg=config)
            gap = gaps[i] * problem.frames[i, 0] if side == 0 else np.zeros(3)
            points[side, i] = gap + contact["point"] - np.array(text["bodies"][k]["position"] if k >= 0 else [0, 0, 0])
    model = builder.finalize()
    for name, value in (("shape0", shapes[0]), ("shape1", shapes[1]), ("point0", points[0]), ("point1", points[1]),
                        ("normal", -problem.frames[:, 0]), ("count", [problem.nc])):
        getattr(contacts, "rigid_contact_" + name).assign(value)
    solver = newton.solvers.SolverSteel(model, iterations=iterations, cfm=0.0, baumgarte=float(offsets),
                                        enable_restitution=False, free_body_constraint_max=3 * problem.nc + 1)
    found = solver.observables({solver.ObservableKind.CONTACT_F}, contacts=contacts)
    states = model.state(), model.state()
    states[0].joint_qd.assign(problem.v)
    newton.eval_fk(model, states[0].joint_q, states[0].joint_qd, states[0])

    def solve(_):
        timed(solver.step, *states, model.control(), contacts, STEP, observables=found)
        forces = found.contact_f.numpy()[: problem.nc, :3].astype(float)
        return problem.of_engine((i, 0, STEP * force) for i, force in enumerate(forces))

    return solve


def warm():
    ball = dict(mass=1, inertia=np.eye(3).tolist(), position=[0, 0, 1], linear_velocity=[1, 0, -1],
                angular_velocity=[0, 0, 0])
    touch = dict(body_a=0, body_b=-1, point=[0, 0, 0], normal=[0, 0, 1], tangent=[1, 0, 0], mu=1, edges=4)
    load(dict(bodies=[ball], contacts=[touch]))(None)


serve(load, warm)
