"""Pictures and tables for notebooks: plain HTML and SVG."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from ._native import InputError

if TYPE_CHECKING:
    from ._problem import Problem
    from ._solve import Answer

COLOURS = ("#1b6ca8", "#d1731c", "#3a8f4d", "#8a4fa3")
ROW_HEIGHT, WIDTH, LEFT = 14, 640, 90
MOST_CONTACTS = 200


def _table(rows: Sequence[tuple[str, str]]) -> str:
    cells = "".join(f"<tr><th style='text-align:left'>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in rows)
    return f"<table>{cells}</table>"


def problem_html(problem: Problem) -> str:
    if problem.kind == "lcp":
        return _table([("LCP", problem.name), ("unknowns", str(problem.size))])
    mu = problem.mu
    range_of_mu = f"{mu.min():.3g} to {mu.max():.3g}" if len(mu) else "-"
    return _table([("contacts", problem.name), ("number", str(problem.nc)), ("mu", range_of_mu),
                   ("friction directions", ", ".join(map(str, sorted(set(problem.edges)))) or "-"),
                   ("coordinates", str(len(problem.v))), ("unknowns", str(problem.size))])


def answer_html(answer: Answer) -> str:
    rows = [("solver", answer.solver), ("says", answer.claim), ("verdict", answer.verdict),
            ("residual", f"{answer.residual:.3g}"), ("time", f"{answer.time * 1e6:.3g} us")]
    return _table(rows + ([("worst", answer.worst)] if answer.worst else []))


class Figure:
    """An SVG picture; notebooks show it, and `svg` is its text.

    One group of bars for each contact: the normal impulse of each answer, and in a lighter colour the length of its
    friction impulse, against the mark of mu times the normal impulse.
    """

    def __init__(self, problem: Problem, answers: Sequence[Any]) -> None:
        if problem.kind == "lcp":
            raise InputError("figure: a bare LCP has no contacts")
        if len(answers) > len(COLOURS):
            raise InputError(f"figure: {len(answers)} answers, expected at most {len(COLOURS)}")
        for i, answer in enumerate(answers):
            if not hasattr(answer, "impulses") or answer.problem != problem:
                raise InputError(f"figure: answers[{i}] is no Answer to this problem")
        self.svg = _svg(problem, answers)

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: Any) -> None:
        """Writes the SVG file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.svg)


def _svg(problem: Problem, answers: Sequence[Any]) -> str:
    shown = min(problem.nc, MOST_CONTACTS)
    impulses = [np.where(np.isfinite(each.impulses), each.impulses, 0)[:shown] for each in answers]
    largest = max((float(np.abs(each).max(initial=0.0)) for each in impulses), default=0.0) or 1.0
    scale = (WIDTH - LEFT - 10) / largest
    group, top = ROW_HEIGHT * max(len(answers), 1) + 6, 20 + 16 * len(answers)
    parts = []
    for k, answer in enumerate(answers):
        parts.append(f"<rect x='{LEFT}' y='{4 + 16 * k}' width='10' height='10' fill='{COLOURS[k]}'/>"
                     f"<text x='{LEFT + 16}' y='{13 + 16 * k}'>{escape(answer.solver)}: {answer.verdict}</text>")
    for i in range(shown):
        y = top + i * group
        parts.append(f"<text x='4' y='{y + 11}'>contact {i}</text>")
        for k, rows in enumerate(impulses):
            at, normal, friction = y + ROW_HEIGHT * k, rows[i, 0], float(np.hypot(rows[i, 1], rows[i, 2]))
            limit = LEFT + scale * max(problem.mu[i] * normal, 0)
            parts.append(
                f"<rect x='{LEFT}' y='{at}' width='{scale * max(normal, 0):.2f}' height='7' fill='{COLOURS[k]}'/>"
                f"<rect x='{LEFT}' y='{at + 7}' width='{scale * friction:.2f}' height='5' fill='{COLOURS[k]}' "
                f"opacity='0.5'/><path d='M{limit:.2f} {at + 6}v7' stroke='black'/>")
    bottom = top + shown * group + 14
    more = f"; {problem.nc - shown} more contacts not shown" if problem.nc > shown else ""
    parts.append(f"<text x='{LEFT}' y='{bottom}'>largest: {largest:.3g} N s; upper bars: normal, lower bars: friction, "
                 f"marks: mu times normal{more}</text>")
    return (f"<svg xmlns='http://www.w3.org/2000/svg' width='{WIDTH}' height='{bottom + 8}' font-family='sans-serif' "
            f"font-size='11'>{''.join(parts)}</svg>")
