#!/usr/bin/env python3
"""An engine of balls on a level floor at height 0, for external_engine_test: balls_engine.py [FAULT].

Projected Gauss-Seidel with so many sweeps that the answer is the cone's solution. FAULT is what goes wrong in its 50th
step: one of FAULTS, or "die". "silent" ends it before its first answer, with "sign" its impulses are turned round, and
with "order" it tells the bodies of its contacts the other way round in every second step.
"""
import json
import sys

import numpy as np

FAULTS = {"pair": dict(contacts=[dict(bodies=[1])], motions=[]), "motions": dict(contacts=[], motions=[[1]]),
          "list": [], "turn": dict(contacts=[], motions=7 * [13 * [0]]),
          "time": dict(contacts=[], motions=7 * [[0, 0, 0, 1] + 9 * [0]], solve_s=-1),
          "number": dict(contacts=[], motions=[13 * ["x"]])}
fault = sys.argv[1] if len(sys.argv) > 1 else ""
count = 0


def scene(question):
    global motions, masses, inertias, radii, h, mu, restitution
    if fault == "silent":
        sys.exit(3)
    bodies = question["bodies"]
    motions = np.array([each["motion"] for each in bodies])
    masses, inertias = (np.array([each[name] for each in bodies]) for name in ("mass", "inertia"))
    radii = [each["parts"][0].get("sphere") for each in bodies]
    h, mu, restitution = question["step"], question["mu"], question["restitution"]
    return dict(engine="Balls", version="1")


def contacts():
    for a in np.flatnonzero(masses):
        gap = motions[a, 2] - radii[a]
        if gap < 0.01:
            yield [a, 0], motions[a, :3] - [0, 0, radii[a] + gap / 2], np.array([0.0, 0, 1]), gap
        for b in range(a):
            between = motions[a, :3] - motions[b, :3]
            if masses[b] and (gap := np.linalg.norm(between) - radii[a] - radii[b]) < 0.01:
                normal = between / np.linalg.norm(between)
                yield [a, b], motions[b, :3] + (radii[b] + gap / 2) * normal, normal, gap


def step(question):
    global count
    count += 1
    if fault not in ("", "sign", "order") and count == 50:
        return FAULTS[fault] if fault in FAULTS else sys.exit("the balls are lost")
    found = [(*each, np.zeros(3)) for each in contacts()]
    at = lambda k, point: motions[k, 7:10] + np.cross(motions[k, 10:], point - motions[k, :3])
    approach = [(at(a, point) - at(b, point)) @ normal for (a, b), point, normal, _, _ in found]
    for k in np.flatnonzero(masses):
        force = np.array(question["forces"][k])
        motions[k, 7:] += h * np.concatenate([force[:3] / masses[k], force[3:] / inertias[k]])

    def push(k, sign, point, impulse):
        if masses[k]:
            motions[k, 7:10] += sign * impulse / masses[k]
            motions[k, 10:] += sign * np.cross(point - motions[k, :3], impulse) / inertias[k]

    change = len(found)
    while change > 1e-15:
        change = 0
        for ((a, b), point, normal, gap, total), before in zip(found, approach):
            relative = at(a, point) - at(b, point)
            offset = gap / h if gap > 0 else restitution * before if before < -0.2 else 0
            mobility = sum(1 / masses[k] for k in (a, b) if masses[k])
            arms = {k: np.sum((point - motions[k, :3]) ** 2) for k in (a, b) if masses[k]}
            slippery = mobility + sum(arm / inertias[k, 0] for k, arm in arms.items())
            normal_part = max(0.0, total @ normal - (relative @ normal + offset) / mobility)
            along = (total - (total @ normal) * normal) - (relative - (relative @ normal) * normal) / slippery
            size = np.linalg.norm(along)
            next_total = normal_part * normal + along * min(1.0, mu * normal_part / size if size else 1.0)
            push(a, 1, point, next_total - total)
            push(b, -1, point, next_total - total)
            change = max(change, np.abs(next_total - total).max())
            total[:] = next_total
    sign = -1 if fault == "sign" else 1
    told = [dict(bodies=[int(a), int(b)], point=list(point), normal=list(normal), gap=float(gap), impulse=list(sign * total))
            for (a, b), point, normal, gap, total in found]
    for each in told if fault == "order" and count % 2 else []:
        turned = {name: [-x for x in each[name]] for name in ("normal", "impulse")}
        each.update(bodies=each["bodies"][::-1], **turned)
    motions[:, :3] += h * motions[:, 7:10]  # balls look alike however they are turned
    return dict(contacts=told, motions=motions.tolist(), solve_s=0.25)


def place(question):
    global motions
    motions = np.array(question["motions"])
    return {}


for line in sys.stdin:
    asked = json.loads(line)
    print(json.dumps(dict(scene=scene, step=step, place=place)[asked["verb"]](asked)), flush=True)
