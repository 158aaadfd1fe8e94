"""Contacts of robots and scenes: solve them, and check anybody's answer.

    import lcpbench
    problem = lcpbench.load("walk.scenes#120")
    answer = lcpbench.solve(problem)
    print(answer.verdict, answer.velocity)
    print(lcpbench.check(problem, impulses_of_another_solver))

Units are SI: kg, m, s; velocities m/s and rad/s; impulses N s. Forces are impulses divided by the length of the step.
Every error in an argument is an `InputError` (a ValueError) or a TypeError, one line that names the argument.
"""

import importlib
from typing import Any

from ._audit import Audit, audit
from ._files import Recorder, Scenes, Step, load, save
from ._native import InputError
from ._native import __version__ as __version__
from ._problem import Problem
from ._program import Certificate, Solver, available_solvers, certify, find_program
from ._solve import Answer, ContactSolver, Verdict, check, solve

__all__ = [
    "Answer", "Audit", "Certificate", "ContactSolver", "InputError", "Problem", "Recorder", "Scenes", "Solver", "Step", "Verdict",
    "audit", "available_solvers", "certify", "check", "find_program", "load", "save", "solve",
]


def __getattr__(name: str) -> Any:
    """The modules of engines and of FCLIB, loaded when they are first used."""
    if name not in ("drake", "fclib", "mujoco", "pinocchio", "pybullet"):
        raise AttributeError(f"module 'lcpbench' has no attribute '{name}'")
    return importlib.import_module("." + name, __name__)
