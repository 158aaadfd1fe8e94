#!/usr/bin/env python3
"""Drake's solvers of LCPs: drake_lcp.py moby|unrevised, with form=lcp.

moby: MobyLcpSolver, Lemke's method, which adds multiples of the identity to M where it fails; unrevised:
UnrevisedLemkeSolver. Both have Drake's default settings. Drake's result has no number of pivots. Where it reports no
solution, the claim is numerical_failure, because it does not say whether the method ended in a ray or at a limit.
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
