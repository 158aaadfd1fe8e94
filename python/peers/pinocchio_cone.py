#!/usr/bin/env python3
"""Pinocchio's solvers: pinocchio_cone.py admm|pgs [TOLERANCE [ITERATIONS [ANDERSON]]], form=contact,cone=true.

Both solve the round Coulomb cone (solve_ncp) on the Delassus matrix, which they are given dense. Their tolerances are
absolute and relative at once; TOLERANCE is 1e-9 unless given, ITERATIONS 10,000. ANDERSON, 0 unless
given, is the number of iterates that accelerate ADMM; Pinocchio's own is 0, too.
"""
import sys

import numpy as np
import pinocchio as pin
from peer import Contacts, serve, timed

method = sys.argv[1]
tolerance = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-9
iterations = int(sys.argv[3]) if len(sys.argv) > 3 else 10_000
anderson = int(sys.argv[4]) if len(sys.argv) > 4 else 0
kind = {"admm": (pin.ADMMConstraintSolver, pin.ADMMSolverSettings, pin.ADMMSolverResult),
        "pgs": (pin.PGSConstraintSolver, pin.PGSSolverSettings, pin.PGSSolverResult)}[method]
world = pin.buildSampleModelManipulator()  # constraints carry coefficients of friction here, and no robot


def load(text):
    problem = Contacts(text)
    if any(edges % 4 for edges in problem.edges):
        return "the friction directions of a contact name no round cone"
    if problem.nc == 0:
        return lambda _: {"claim": "solved", "z": []}
    models, datas, columns, offset = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData(), [], []
    for i in range(problem.nc):
        contact = pin.PointContactConstraintModel(world, 1)
        contact.setFriction(float(problem.mu[i]))
        models.append(pin.ConstraintModel(contact))
        datas.append(models[i].createData())
        columns += [*problem.tangents(i).T, problem.N[:, i]]
        offset += [0, 0, problem.b[i]]
    J = np.array(columns).reshape(-1, len(problem.v)).T
    W = np.asfortranarray(J.T @ problem.Ginv @ J)
    g = J.T @ problem.v + offset

    def solve(start):
        solver, settings, result = (each() for each in kind)
        for name in ("absolute_feasibility_tol", "relative_feasibility_tol", "absolute_complementarity_tol",
                     "relative_complementarity_tol"):
            setattr(settings, name, tolerance)
        settings.max_iterations, settings.solve_ncp = iterations, True
        if anderson > 0:
            settings.anderson_capacity = anderson
        if start is not None:
            result.setConstraintImpulseGuess(problem.along(start)[:, [1, 2, 0]].ravel())
        converged = timed(solver.solve, pin.DelassusOperatorDense(W), g, models, datas, settings, result)
        impulses = np.array(result.retrieveConstraintImpulses()).reshape(-1, 3)
        return {"claim": "solved" if converged else "iteration_limit", "iterations": int(result.iterations),
                "z": problem.answer(impulses[:, 2], impulses[:, :2])}

    return solve


serve(load)
