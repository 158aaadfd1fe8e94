#!/usr/bin/env python3
"""Solvers of convex problems: convex.py proxqp|clarabel|scs [TOLERANCE] [relaxed], with form=contact.

The velocity u after the step minimizes 1/2 (u - v)'G(u - v) where no contact approaches: N'u + b >= 0. Its multipliers
are the impulses. With friction this is exact only in the relaxed model of Anitescu, where a contact that slides lifts
off: (N + mu D_k)'u + b >= 0 for each direction k. It is solved with `relaxed`, and refused without. TOLERANCE is
1e-9 unless given; all other settings that bear on an answer are the library's. The claim is that of its status.
"""
import sys

import numpy as np
from peer import Contacts, serve, timed
from scipy import sparse

library, arguments = sys.argv[1], sys.argv[2:]
relaxed = "relaxed" in arguments
tolerance = float(next((each for each in arguments if each != "relaxed"), 1e-9))
infeasible = "numerical_failure" if relaxed else "unsolvable"  # a relaxed problem without solution tells of no other
# The libraries' own words for an end, as claims; any other is a numerical failure.
claims = {"PROXQP_SOLVED": "solved", "Solved": "solved", "solved": "solved", "PROXQP_PRIMAL_INFEASIBLE": infeasible,
          "PrimalInfeasible": infeasible, "infeasible": infeasible, "PROXQP_MAX_ITER_REACHED": "iteration_limit",
          "MaxIterations": "iteration_limit", "solved (inaccurate - reached max_iters)": "iteration_limit"}


# Each library minimizes 1/2 u'Gu + linear'u where rows u >= bound. `guess` is None, or u and multipliers to start from;
# Clarabel takes none. Returns the library's status in its words, the multipliers of the rows, and iterations.


def proxqp(G, linear, rows, bound, guess):
    from proxsuite import proxqp as library_

    qp = library_.dense.QP(len(linear), 0, len(rows))
    qp.settings.eps_abs, qp.settings.eps_rel = tolerance, 0
    qp.init(G, linear, None, None, rows, bound, np.full(len(rows), 1e20))
    if guess is not None:  # without the gap, impulses that are too large pass its tests together with their velocity
        qp.settings.check_duality_gap, qp.settings.eps_duality_gap_abs = True, tolerance
        qp.settings.eps_duality_gap_rel = 0
    timed(qp.solve, *([] if guess is None else [guess[0], None, -guess[1]]))
    return qp.results.info.status.name, -qp.results.z, qp.results.info.iter


def clarabel(G, linear, rows, bound, _):
    import clarabel as library_

    settings = library_.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    cones = [library_.NonnegativeConeT(len(rows))]
    solver = library_.DefaultSolver(sparse.csc_matrix(np.triu(G)), linear, sparse.csc_matrix(-rows), -bound, cones,
                                    settings)
    solution = timed(solver.solve)
    return str(solution.status), np.array(solution.z), solution.iterations


def scs(G, linear, rows, bound, guess):
    import scs as library_

    data = dict(P=sparse.csc_matrix(np.triu(G)), A=sparse.csc_matrix(-rows), b=-bound, c=linear)
    solver = library_.SCS(data, dict(l=len(rows)), eps_abs=tolerance, eps_rel=tolerance, verbose=False)
    warm = {} if guess is None else dict(x=guess[0], y=guess[1], s=rows @ guess[0] - bound)
    solution = timed(solver.solve, warm_start=guess is not None, **warm)
    return solution["info"]["status"], solution["y"], solution["info"]["iter"]


def load(text):
    """The function that solves this problem, or why it is refused, for serve()."""
    problem = Contacts(text)
    if problem.G is None:
        return "the inertia is not known, only its inverse or its factors"
    if not relaxed and np.any(problem.mu > 0):
        return "has friction: the convex model is another problem (argument relaxed)"
    # The rows of the constraints, the contact of each row, and its friction impulse's place in z (-1: no friction).
    rows, own, slides = [], [], []
    for i in range(problem.nc):
        for k in range(problem.begin[i], problem.begin[i + 1]) if problem.mu[i] > 0 else [-1]:
            rows.append(problem.N[:, i] + (problem.mu[i] * problem.D[:, k - problem.nc] if k >= 0 else 0))
            own.append(i)
            slides.append(k)
    if not rows:
        return lambda _: {"claim": "solved", "z": problem.complete(np.zeros(problem.begin[-1]))}
    rows, own, slides = map(np.array, (rows, own, slides))
    model, mu = (problem.G, -problem.G @ problem.v, rows, -problem.b[own]), problem.mu[own]

    def multipliers(z):
        """Multipliers of the rows that give the net impulses of z where the f_D of each contact add up to at most
        mu f_N; else an approximation."""
        each = np.divide(z[slides], mu, out=np.zeros(len(own)), where=slides >= 0)
        rest = (z[: problem.nc] - np.bincount(own, each, problem.nc)) / np.bincount(own, minlength=problem.nc)
        return np.maximum(each + rest[own], 0)

    def solve(start):
        guess = None if start is None else (problem.after(start), multipliers(start))
        status, values, iterations = {"proxqp": proxqp, "clarabel": clarabel, "scs": scs}[library](*model, guess)
        answer = {"claim": claims.get(status, "numerical_failure"), "iterations": int(iterations)}
        if answer["claim"] != "solved":
            answer["detail"] = status
        if not np.all(np.isfinite(values)):
            return {**answer, "claim": "numerical_failure"}
        values = np.maximum(values, 0)
        f = np.zeros(problem.begin[-1])
        f[: problem.nc] = np.bincount(own, values, problem.nc)
        f[slides[slides >= 0]] = (mu * values)[slides >= 0]
        return {**answer, "z": problem.complete(f)}

    return solve


serve(load)
