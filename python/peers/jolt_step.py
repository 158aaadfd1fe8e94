#!/usr/bin/env python3
"""A step of Jolt by npm's jolt-physics: jolt_step.py [ITERATIONS], with form=scene,cone=true.

Bodies are free, and each contact is a pair of small balls that touch at its point and meet nothing else. ITERATIONS of
the velocities are 10 in Jolt; all other settings are Jolt's, but for damping, of which there is none. It is single
precision. Positive offsets of contacts are gaps; negative ones are refused, because Jolt corrects penetrations of
positions after the velocities. jolt_step.mjs runs in node; npm's package is where the virtual environment is.
"""
import json
import pathlib
import subprocess
import sys

import numpy as np
from peer import Contacts, serve, timed

iterations = int(sys.argv[1]) if len(sys.argv) > 1 else 10
STEP, RADIUS = 1 / 60, 1e-3
package = pathlib.Path(sys.prefix, "node_modules", "jolt-physics", "dist", "jolt-physics.wasm-compat.js")
node = subprocess.Popen(["node", "--disable-wasm-trap-handler", pathlib.Path(__file__).with_suffix(".mjs"), package],
                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)  # the handler reserves much memory


def ask(question):
    print(json.dumps(question), file=node.stdin, flush=True)
    return json.loads(node.stdout.readline())


def load(text):
    problem = Contacts.of_scene(text)
    if np.any(problem.b < 0):
        return "contacts have negative offsets: Jolt corrects positions after velocities"
    ask(dict(bodies=text["bodies"], mu=problem.mu.tolist(),
             places=[dict(ball=2 * i + 2 + side, body=k, centre=at.tolist(), radius=RADIUS)
                     for i, side, k, at in problem.balls(RADIUS, -problem.b * STEP)]))

    def solve(_):
        pushes = []
        for ball, x, y, z, a, b, push in timed(ask, dict(step=STEP, iterations=iterations)):
            tangent = np.array([z, 0.0, -x] if abs(x) > abs(y) else [0.0, z, -y])  # Vec3::GetNormalizedPerpendicular()
            tangent /= np.linalg.norm(tangent)
            total = push * np.array([x, y, z]) + a * tangent + b * np.cross([x, y, z], tangent)  # on the second ball
            pushes.append((ball // 2 - 1, 1 - ball % 2, total))
        return problem.of_engine(pushes)

    return solve


serve(load)
