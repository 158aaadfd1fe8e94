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
from peer import Contacts, serve

STEP, RADIUS, DEPTH = 1e-3, 0.01, 1e-9
problem = model = data = None


def load(text):
    global problem, model, data
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
        moments, axes = np.linalg.eigh(each["inertia"])
        axes[:, 0] *= np.linalg.det(axes)
        turn = np.zeros(4)
        mujoco.mju_mat2Quat(turn, axes.ravel())
        bodies.append(spec.worldbody.add_body(pos=each["position"], mass=each["mass"], inertia=moments, ipos=[0, 0, 0],
                                              iquat=turn, explicitinertial=True))
        bodies[-1].add_freejoint()
    for i, contact in enumerate(text["contacts"]):
        names = []
        depth = DEPTH - problem.b[i] * STEP
        for k, sign in ((contact["body_a"], 1), (contact["body_b"], -1)):
            at = np.array(contact["point"]) + sign * (RADIUS - depth / 2) * problem.frames[i, 0]
            body = bodies[k] if k >= 0 else spec.worldbody
            names.append(f"{i} {sign}")
            body.add_geom(name=names[-1], type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], mass=0,
                          contype=0, conaffinity=0, pos=at - (text["bodies"][k]["position"] if k >= 0 else 0))
        mu = max(problem.mu[i], 1e-5)  # mjMINMU
        spec.add_pair(geomname1=names[0], geomname2=names[1], condim=3 if problem.edges[i] else 1,
                      friction=[mu, mu, 0, 0, 0], solref=[-1 / STEP**2, -1 / STEP], solimp=[0.9999, 0.9999, 1, 0.5, 2])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = problem.v  # bodies are not turned: their axes are the world's


def solve(_):
    mujoco.mj_forward(model, data)
    impulses, force = np.zeros((problem.nc, 3)), np.zeros(6)
    for k in range(data.ncon):
        contact = data.contact[k]
        i, side = map(int, model.geom(contact.geom[0]).name.split())
        mujoco.mj_contactForce(model, data, k, force)
        impulses[i] = -side * STEP * problem.frames[i] @ (contact.frame.reshape(3, 3).T @ force[:3])  # on the second
    if not np.all(np.isfinite(impulses)):
        return {"claim": "numerical_failure"}
    return {"claim": "solved", "z": problem.answer(np.maximum(impulses[:, 0], 0), impulses[:, 1:]),
            "iterations": int(np.sum(data.solver_niter))}


serve(load, solve)
