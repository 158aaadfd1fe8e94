"""Bounded rows of captured steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._files import numbered


class Rows:
    """Collects bounded rows as `Problem` takes them. Each has a direction in coordinates of the problem, the bounds of its
    impulse, an offset and a compliance."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._columns: list[np.ndarray] = []
        self._fields: dict[str, list[Any]] = {key: [] for key in ("lower", "upper", "b", "compliance", "unit", "names")}

    def add(self, name: str, direction: Any, is_angle: bool, *, lower: float = -np.inf, upper: float = np.inf, b: float = 0.0,
            compliance: float = 0.0) -> bool:
        """Adds a row that moves a coordinate and whose impulse may differ from zero. Returns whether it is one."""
        direction = np.asarray(direction, dtype=float)
        if not direction.any() or lower == upper:
            return False
        self._columns.append(direction)
        for key, value in zip(self._fields, (lower, upper, b, compliance, "rad" if is_angle else "m", name)):
            self._fields[key].append(value)
        return True

    def add_limit(self, name: str, direction: Any, is_angle: bool, sign: float, q: float, limit: float, h: float) -> bool:
        """The lower limit of a position q, or with sign -1 the upper one, where it is finite. An open gap may close within
        the step h."""
        side, gap = "lower" if sign > 0 else "upper", sign * (q - limit)
        return bool(np.isfinite(limit)) and self.add(f"{name} {side}", sign * np.asarray(direction), is_angle, lower=0.0,
                                                     b=max(gap, 0.0) / h)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def R(self) -> np.ndarray:
        """(coordinates, rows)."""
        return np.reshape(self._columns, (len(self), self._size)).T

    def explained(self, momentum: np.ndarray, known: dict[int, float] | None = None) -> np.ndarray:
        """The rows' impulses between their bounds that make the momentum as nearly as they can. Where rows repeat each
        other they are one choice of many.

        Args:
            known: by their indices the impulses that the engine tells.
        """
        from scipy.optimize import lsq_linear

        f = np.zeros(len(self))
        f[list(known or {})] = list((known or {}).values())
        left = np.setdiff1d(np.arange(len(self)), list(known or {}))
        if len(left) and len(momentum):
            lower, upper = (np.array(self._fields[key])[left] for key in ("lower", "upper"))
            found = lsq_linear(self.R[:, left], momentum - self.R @ f, (lower, upper), method="bvls", tol=1e-15)
            f[left] = found.x
        return f

    def fields(self) -> dict[str, Any] | None:
        """The argument `rows` of a Problem; None where there are none."""
        if not self._columns:
            return None
        fields = {key: list(values) for key, values in self._fields.items()}
        return {"R": self.R, **fields, "names": numbered(fields["names"])}
