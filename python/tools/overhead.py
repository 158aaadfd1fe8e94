#!/usr/bin/env python3
"""Measures what Python adds to a solve: python3 python/tools/overhead.py

The contacts are solved again and again from a new velocity, as in a simulator's loop. A problem without contacts costs
the C++ library next to nothing, so that its times are what the way from Python and back takes.
"""
import statistics
import timeit

import numpy as np

import lcpbench

ROUNDS, CALLS = 30, 2000
rng = np.random.default_rng(1)
for nc in (0, 10):
    root = rng.standard_normal((24, 24))
    problem = lcpbench.Problem(G=root @ root.T + np.eye(24), N=rng.standard_normal((24, nc)), mu=0.5,
                               tangents=rng.standard_normal((24, 2 * nc)), v=rng.standard_normal(24))
    solver, v = lcpbench.ContactSolver("auto"), problem.v
    solver.update(problem)
    ids = list(range(nc))
    calls = {"solve": solver.solve, "set_velocity": lambda: solver.set_velocity(v), "velocity": lambda: solver.velocity,
             "update": lambda: solver.update(problem, ids)}
    for name, call in calls.items():
        seconds = statistics.median(timeit.repeat(call, number=CALLS, repeat=ROUNDS)) / CALLS
        print(f"{nc} contacts: {name} {seconds * 1e6:.2f} us")
