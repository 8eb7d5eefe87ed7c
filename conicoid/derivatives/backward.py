"""The transpose of `forward`: what is asked of crossings, handed back to rays and walls."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .forms import FORM, MAP, PAIRS
from .forward import At, Columns, affine, dot, plain_sum, times, total, unit


@dataclass
class Asked:
    """What is asked of the walls that some crossings are on: columns, or numbers that all of them share."""

    wall: Any
    size: int
    forms: Columns = field(default_factory=list)
    maps: list[tuple[int, Any]] = field(default_factory=list)  # of numbers of maps

    def add_map(self, k: int, weight: Any, x: Columns) -> None:
        """What is asked of row k of maps: a weight times (x, 1)."""
        self.maps += [(4 * k + i, total((weight, column))) for i, column in enumerate((*x, 1.0))]

    def put(self, forms: FloatArray, maps: FloatArray) -> None:
        """Add it up into (walls, 10) and (walls, 12)."""
        for table, numbers in ((forms, enumerate(self.forms)), (maps, self.maps)):
            for k, column in numbers:
                if isinstance(self.wall, int):
                    table[self.wall, k] += np.sum(column) if np.ndim(column) else column * self.size
                else:
                    table[:, k] += np.bincount(self.wall, np.broadcast_to(column, (self.size,)), len(table))


def walls_asked(count: int) -> tuple[FloatArray, FloatArray]:
    """Nothing asked of forms (walls, 10) and maps (walls, 12)."""
    return np.zeros((count, FORM)), np.zeros((count, MAP))


def of_normals(at: At, asked: Columns, side: Any) -> tuple[Columns, Columns]:
    """(what is asked of d∇f / 2, of dx) where it is asked of normals."""
    n, size = unit(at.g)
    along, scale = dot(n, asked), side / size
    across = [(a - total((b, along))) * scale for a, b in zip(asked, n, strict=True)]
    return across, times(at.rows, across)


def of_uv(at: At, asked: Columns, angular: Any) -> tuple[Columns, Columns]:
    """(what is asked of the three rows of maps, of dx) where it is asked of uv."""
    rows: Columns
    if isinstance(angular, bool) and not angular:
        rows = [asked[0], asked[1], 0.0]
    else:
        a, b, _ = affine(at.rows[13:], at.x, True)
        turn = asked[0] / (2 * math.pi * (a * a + b * b))
        rows = [-turn * b, turn * a, asked[1]]
        if not isinstance(angular, bool):
            flat = (asked[0], asked[1], 0.0)
            rows = [np.where(angular, one, other) for one, other in zip(rows, flat, strict=True)]
    of_x = [total(*((rows[k], at.rows[13 + 4 * k + i]) for k in range(3))) for i in range(3)]
    return rows, of_x


def of_crossings(at: At, asked_t: Any, asked_x: Columns) -> tuple[Any, Columns, Columns]:
    """(what is asked of f_p, of do, of dd) where it is asked of t and of points."""
    share = -plain_sum(dot(asked_x, at.d), asked_t) / at.rate
    of_o = [plain_sum(total((share, g)), a) for a, g in zip(asked_x, at.g, strict=True)]
    return 0.5 * share, of_o, [total((at.t, component)) for component in of_o]


def form_asked(at: At, of_value: Any, of_gradient: Columns | None) -> Columns:
    """What is asked of the ten numbers of a form, by its value f = r·A r + 2 B·r + C and its half gradient A r + B."""
    r = at.r
    w = [total((of_value, component)) for component in r]
    numbers = [total((w[i], r[j])) if i == j else total((2.0, total((w[i], r[j])))) for i, j in PAIRS]
    first = [total((2.0, component)) for component in w]
    if of_gradient is not None:
        v = of_gradient
        more = [total((v[i], r[j])) if i == j else total((v[i], r[j]), (v[j], r[i])) for i, j in PAIRS]
        numbers = [plain_sum(a, b) for a, b in zip(numbers, more, strict=True)]
        first = [plain_sum(a, b) for a, b in zip(first, v, strict=True)]
    return [*numbers, *first, of_value]
