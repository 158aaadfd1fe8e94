#!/usr/bin/env python3
"""Drake's solvers of LCPs: drake_lcp.py moby|unrevised, with form=lcp.

moby: MobyLcpSolver, Lemke's method with Drake's regularization; unrevised: UnrevisedLemkeSolver. All settings are
Drake's. Drake's answer has no counts. Where Drake reports no solution, the claim is numerical_failure: it tells no ray
from a limit.
"""
import sys

import numpy as np
from peer import serve, timed
from pydrake.solvers import MathematicalProgram, MobyLcpSolver, UnrevisedLemkeSolver

solver = {"moby": MobyLcpSolver, "unrevised": UnrevisedLemkeSolver}[sys.argv[1]]()


def load(problem):
    program = MathematicalProgram()
    q = np.array(problem["q"], dtype=float)
    z = program.NewContinuousVariables(len(q))
    if len(q) == 0:
        return lambda _: {"claim": "solved", "z": []}
    program.AddLinearComplementarityConstraint(np.array(problem["M"], dtype=float).reshape(len(q), -1), q, z)

    def solve(_):
        result = timed(solver.Solve, program, None, None)
        if not result.is_success():
            return {"claim": "numerical_failure", "detail": result.get_solution_result().name}
        return {"claim": "solved", "z": [float(each) for each in result.GetSolution(z)]}

    return solve


serve(load)
