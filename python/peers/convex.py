#!/usr/bin/env python3
"""Solvers of convex problems: convex.py proxqp|clarabel|scs [TOLERANCE] [relaxed], with form=contact.

The velocity u after the step minimizes 1/2 (u - v)'G(u - v) where no contact approaches: N'u + b >= 0. Its multipliers
are the impulses. With friction this is exact only in the relaxed model of Anitescu, where a contact that slides lifts
off: (N + mu D_k)'u + b >= 0 for each direction k. It is solved if `relaxed` is said, and refused else. TOLERANCE is
1e-9 unless given; all other settings are the library's.
"""
import sys

import numpy as np
from peer import Contacts, serve

library, arguments = sys.argv[1], sys.argv[2:]
relaxed = "relaxed" in arguments
tolerance = float(next((each for each in arguments if each != "relaxed"), 1e-9))
problem = rows = share = bound = guess = None


def load(text):
    global problem, rows, share, bound
    problem = Contacts(text)
    if problem.G is None:
        return "the inertia is not known, only its inverse or its factors"
    if not relaxed and np.any(problem.mu > 0):
        return "has friction: the convex model is another problem (argument relaxed)"
    columns, share, bound = [], [], []  # share: of which impulses a multiplier is the sum
    for i, edges in enumerate(problem.edges):
        first = problem.begin[i] - problem.nc
        for k in range(edges if problem.mu[i] > 0 else 1):
            slides = problem.mu[i] > 0
            columns.append(problem.N[:, i] + (problem.mu[i] * problem.D[:, first + k] if slides else 0))
            share.append((i, problem.nc + first + k if slides else None))
            bound.append(-problem.b[i])
    rows = np.array(columns).reshape(-1, len(problem.v))


def multipliers(z):
    """Those whose impulses are a z, as nearly as the model has it."""
    own = np.array([i for i, _ in share])
    slides = np.array([0 if direction is None else z[direction] / problem.mu[i] for i, direction in share])
    rest = (z[: problem.nc] - np.bincount(own, slides, problem.nc)) / np.bincount(own, minlength=problem.nc)
    return np.maximum(slides + rest[own], 0)


def proxqp():
    from proxsuite import proxqp as library_

    qp = library_.dense.QP(len(problem.v), 0, len(rows))
    qp.settings.eps_abs, qp.settings.eps_rel = tolerance, 0
    qp.init(problem.G, -problem.G @ problem.v, None, None, rows, np.array(bound), np.full(len(rows), 1e20))
    if guess is None:
        qp.solve()
    else:  # impulses that are too large, with their velocity, pass its other tests
        qp.settings.check_duality_gap, qp.settings.eps_duality_gap_abs = True, tolerance
        qp.settings.eps_duality_gap_rel = 0
        qp.solve(guess[0], None, -guess[1])
    return qp.results.info.status == library_.QPSolverOutput.PROXQP_SOLVED, -qp.results.z, qp.results.info.iter


def clarabel():
    import clarabel as library_
    from scipy import sparse

    settings = library_.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    cones = [library_.NonnegativeConeT(len(rows))]
    solver = library_.DefaultSolver(sparse.csc_matrix(np.triu(problem.G)), -problem.G @ problem.v,
                                    sparse.csc_matrix(-rows), -np.array(bound), cones, settings)
    solution = solver.solve()
    return solution.status == library_.SolverStatus.Solved, np.array(solution.z), solution.iterations


def scs():
    import scs as library_
    from scipy import sparse

    data = dict(P=sparse.csc_matrix(np.triu(problem.G)), A=sparse.csc_matrix(-rows), b=-np.array(bound),
                c=-problem.G @ problem.v)
    solver = library_.SCS(data, dict(l=len(rows)), eps_abs=tolerance, eps_rel=tolerance, verbose=False)
    warm = {} if guess is None else dict(x=guess[0], y=guess[1], s=rows @ guess[0] - bound)
    solution = solver.solve(warm_start=guess is not None, **warm)
    return solution["info"]["status"] == "solved", solution["y"], solution["info"]["iter"]


def solve(start):
    global guess
    if len(rows) == 0:
        return {"claim": "solved", "z": problem.complete(np.zeros(problem.begin[-1]))}
    guess = None if start is None else (problem.after(start), multipliers(start))
    solved, values, iterations = {"proxqp": proxqp, "clarabel": clarabel, "scs": scs}[library]()
    if not np.all(np.isfinite(values)):
        return {"claim": "numerical_failure", "iterations": int(iterations)}
    f = np.zeros(problem.begin[-1])
    for (i, direction), value in zip(share, np.maximum(values, 0)):
        f[i] += value
        if direction is not None:
            f[direction] = problem.mu[i] * value
    return {"claim": "solved" if solved else "iteration_limit", "z": problem.complete(f), "iterations": int(iterations)}


serve(load, solve)
