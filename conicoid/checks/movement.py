"""How far a relative change of 2^-53 of each of its numbers moves a shape, in units of its own extent.

docs/conditioning.md derives what is computed here: a lower bound on the movement, attained up to second order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .local import Fields, Local, LocalCell
from .places import Tests, gradients, tests_of

_ROUNDING = 2.0**-50


@dataclass(frozen=True, eq=False)
class Movement:
    """The worst place of a part.

    relative    how far it moves there, in units of the part's extent in that direction
    number      the number that most of it comes from
    local       (3,) where, in local coordinates; `gradient` (3,) of what moves, and `width` of the part along it
    normals     (k, 3) gradients of the surfaces that meet there
    singular    does the surface's gradient vanish there, as far as its numbers can tell?
    """

    relative: float
    number: str
    local: FloatArray
    gradient: FloatArray
    width: float
    singular: bool = False
    normals: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Part:
    """The cells of a shape with the places where they are looked at."""

    local: Local
    tests: tuple[Tests, ...]

    @classmethod
    def of(cls, local: Local) -> Part:
        return cls(local, tuple(tests_of(cell) for cell in local.cells))


def movement(part: Part, fields: Fields, is_sheet: bool) -> Movement | None:
    """The worst of all cells; None where nothing of the part is looked at."""
    found = [_of_cell(cell, tests, fields, is_sheet) for cell, tests in zip(part.local.cells, part.tests, strict=True)]
    return max((one for one in found if one is not None), key=lambda one: one.relative, default=None)


def _of_cell(cell: LocalCell, tests: Tests, fields: Fields, is_sheet: bool) -> Movement | None:
    if not len(tests.points):
        return None
    h = np.concatenate([tests.points, np.ones((len(tests.points), 1))], axis=1)
    slopes = gradients(cell.forms, tests.points)
    gradient = np.einsum("ts,tsi->ti", tests.weights, slopes)
    by_number = np.concatenate(
        [
            np.einsum("ts,ti,nsij,tj->tn", tests.weights, h, cell.moves, h, optimize=True),
            np.einsum("ti,mij,tj->tm", gradient, fields.fields, h, optimize=True),
        ],
        axis=1,
    )
    by_number = np.abs(by_number)
    change = by_number.sum(axis=1)
    width = np.abs(gradient).sum(axis=1)
    if is_sheet:
        width = np.linalg.norm(gradient, axis=1)
    elif len(tests.corners) > 3 and not cell.cut:
        reach = gradient @ tests.corners.T
        width = np.minimum(width, reach.max(axis=1) - reach.min(axis=1))
    width = width + _ROUNDING * np.einsum("ts,ts->t", np.abs(tests.weights), np.abs(slopes).sum(axis=2))
    bend = np.abs(tests.weights) @ np.abs(cell.forms[:, :3, :3]).sum(axis=(1, 2))
    relative = moved(change, width, bend)
    worst = int(relative.argmax())
    names = (*cell.numbers, *fields.numbers)
    return Movement(
        float(relative[worst]),
        names[int(by_number[worst].argmax())] if names else "",
        tests.points[worst],
        gradient[worst],
        float(width[worst]),
        bool(4 * bend[worst] * change[worst] > width[worst] ** 2),
        slopes[worst][tests.weights[worst] != 0],
    )


def moved(change: Any, width: Any, bend: Any) -> Any:
    """The least d with width d + bend d² >= change."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = 2 * change / (width + np.sqrt(width * width + 4 * bend * change))
    return np.where(change > 0, found, 0.0)
