#!/usr/bin/env python3
"""A step of MuJoCo: mujoco_step.py newton|cg|pgs, with form=scene,cone=true.

Bodies are free, and each contact is a pair of small balls that touch at its point and meet nothing else. MuJoCo solves
a convex model, in which what slides lifts off, and softens contacts on purpose. Here they are as hard as it allows
(solimp 0.9999), stop in one step (solref) and have elliptic cones; its solver has 1,000 iterations and a tolerance of
1e-14. A penetration counts, but MuJoCo's contacts are not there before bodies touch: those with a gap are refused.
"""
import sys

import mujoco
import numpy as np
from peer import Contacts, serve, timed

STEP, RADIUS, DEPTH = 1e-3, 0.01, 1e-9


def load(text):
    problem = Contacts.of_scene(text)
    if np.any(problem.b > 0):
        return "contacts have gaps (positive offsets): MuJoCo has no contact before bodies touch"
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = STEP, [0, 0, 0]
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.solver = getattr(mujoco.mjtSolver, "mjSOL_" + sys.argv[1].upper())
    spec.option.iterations, spec.option.tolerance = 1000, 1e-14
    bodies = []
    for each in text["bodies"]:
        bodies.append(spec.worldbody.add_body(
            pos=each["position"], mass=each["mass"], ipos=[0, 0, 0], explicitinertial=True,
            fullinertia=np.array(each["inertia"])[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]))
        bodies[-1].add_freejoint()
    for i, side, k, at in problem.balls(RADIUS, DEPTH - problem.b * STEP):
        (bodies[k] if k >= 0 else spec.worldbody).add_geom(
            name=f"{i} {side}", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], mass=0, contype=0,
            conaffinity=0, pos=at)
    for i, mu in enumerate(np.maximum(problem.mu, 1e-5)):  # mjMINMU
        spec.add_pair(geomname1=f"{i} 0", geomname2=f"{i} 1", condim=3 if problem.edges[i] else 1,
                      friction=[mu, mu, 0, 0, 0], solref=[-1 / STEP**2, -1 / STEP], solimp=[0.9999, 0.9999, 1, 0.5, 2])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = problem.v  # bodies are not turned: their axes are the world's

    def solve(start):
        if start is not None:
            data.qacc_warmstart[:] = (problem.after(start) - problem.v) / STEP
        timed(mujoco.mj_forward, model, data)
        pushes, force = [], np.zeros(6)
        for k, contact in enumerate(data.contact):
            i, side = map(int, model.geom(contact.geom[0]).name.split())
            mujoco.mj_contactForce(model, data, k, force)
            pushes.append((i, 1 - side, STEP * contact.frame.reshape(3, 3).T @ force[:3]))  # on the second ball
        return {**problem.of_engine(pushes), "iterations": int(np.sum(data.solver_niter))}

    return solve


serve(load)
