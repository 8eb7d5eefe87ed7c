"""Test points of a cell, on its faces, edges and corners in local coordinates, and how far each of them moves.

A test is a point with weights of the surfaces through it: one surface alone; or, at an edge or a corner, one surface
without its components along the others. The latter measures how far the edge or corner moves within the others.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..._util.records import FloatArray, cross_rows, dataclass, unit_rows
from .perturbation import LocalCell, LocalShape, MotionFields

_LINES = 48
"""Random lines that are intersected with each surface, besides the three axes."""
_MOST_PLANES = 96
"""Cells of more planes have no tests at corners: their number grows with its cube."""
_TOLERANCE = 1e-9
"""A point is inside a face if the face's function is at most this."""
_REACH = 0.5 + 1e-6
"""The tested part reaches this far along each axis, with some room for rounding."""
_SMALL = 1e-300
"""Shorter gradients have no direction."""

# The six sides of the tested part, as forms of planes
_CUBE = np.zeros((6, 4, 4))
for _k in range(3):
    for _end in (0, 1):
        _CUBE[2 * _k + _end, _k, 3] = _CUBE[2 * _k + _end, 3, _k] = 0.5
        _CUBE[2 * _k + _end, 3, 3] = _end - 0.5


@dataclass(frozen=True, eq=False)
class TestPoints:
    """Points (T, 3), weights (T, S) of the surfaces in each test, and the corners (V, 3) of a polyhedron."""

    points: FloatArray
    weights: FloatArray
    corners: FloatArray


def tests_of(cell: LocalCell) -> TestPoints:
    """Return the tests of a cell; random lines have a fixed seed, so they are always the same."""
    random = np.random.default_rng(20261122)
    lines = random.random((_LINES, 2, 3)) - 0.5
    # Also the three axes of the tested part
    lines = np.concatenate([lines, np.stack([-np.eye(3), np.eye(3)], axis=1) / 2])
    sources = [*_on_lines(cell, lines), *_corners(cell), *_rims(cell, lines), *_singular(cell)]
    count = len(cell.forms)
    points: list[FloatArray] = []
    weights: list[FloatArray] = []
    corners: list[FloatArray] = []
    for through, at in sources:
        mask = _inside(cell, at, through)
        if not mask.any():
            continue
        at = at[mask]
        # The corners of a polyhedron also give its width
        if cell.flat.all() and len(through) == 3:
            corners.append(at)
        for combination in _combinations([s for s in through if s < count]):
            for weight in _weights(cell, at, combination):
                points.append(at)
                weights.append(weight)
    none = np.zeros((0, 3))
    return TestPoints(
        np.concatenate([none, *points]),
        np.concatenate([np.zeros((0, count)), *weights]),
        np.concatenate([none, *corners]),
    )


WeightedPoints = tuple[tuple[int, ...], FloatArray]
"""Numbers of the surfaces through some points, and the points (n, 3)."""


def _combinations(surfaces: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield all subsets but the empty one."""
    for size in range(1, len(surfaces) + 1):
        yield from itertools.combinations(surfaces, size)


def gradients(forms: FloatArray, points: FloatArray) -> FloatArray:
    """Return the gradients (T, S, 3) of S forms (S, 4, 4) at T points (T, 3)."""
    return 2 * (np.einsum("sij,tj->tsi", forms[:, :3, :3], points) + forms[None, :, :3, 3])


def values(forms: FloatArray, points: FloatArray) -> FloatArray:
    """Return the values (T, S) of S forms (S, 4, 4) at T points (T, 3)."""
    h = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    return np.einsum("ti,sij,tj->ts", h, forms, h)


def _inside(cell: LocalCell, points: FloatArray, through: Sequence[int]) -> Any:
    """Return (T,) bool: is the point in the tested part, and inside all faces but those through it?"""
    mask: Any = (np.isfinite(points) & (np.abs(points) <= _REACH)).all(axis=1)
    others = [s for s in range(len(cell.forms)) if s not in through and cell.sides[s]]
    if others and mask.any():
        height = values(cell.forms[others], np.where(mask[:, None], points, 0.0)) * cell.sides[others]
        mask &= (height <= _TOLERANCE).all(axis=1)
    return mask


def _weights(cell: LocalCell, points: FloatArray, combination: tuple[int, ...]) -> Iterator[FloatArray]:
    """Yield weights (T, S) for each chosen surface: it alone, or without its components along the others' normals."""
    weights = np.zeros((len(points), len(cell.forms)))
    if len(combination) == 1:
        weights[:, combination[0]] = 1.0
        yield weights
        return
    # Unit normals, so that weights of different surfaces compare; points without some normal get no test
    normals = gradients(cell.forms[list(combination)], points)
    sizes = np.linalg.norm(normals, axis=2)
    usable = sizes.min(axis=1) > _SMALL
    units = normals / np.where(usable, sizes.T, 1.0).T[:, :, None]
    for k in range(len(combination)):
        others = [j for j in range(len(combination)) if j != k]
        # The weighted sum of gradients is the unit normal k without its projection onto the others
        parts = _along(units[:, others], units[:, k])
        result = weights.copy()
        result[:, combination[k]] = 1 / np.where(usable, sizes[:, k], 1.0)
        for column, j in enumerate(others):
            result[:, combination[j]] = -parts[:, column] / np.where(usable, sizes[:, j], 1.0)
        result[~usable | ~np.isfinite(result).all(axis=1)] = 0.0
        yield result


def _along(units: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the coefficients (T, 1 or 2) of the combination of one or two unit vectors nearest to a vector."""
    first: FloatArray = (units[:, 0] * vector).sum(axis=1)
    if units.shape[1] == 1:
        return first[:, None]
    second = (units[:, 1] * vector).sum(axis=1)
    both = (units[:, 0] * units[:, 1]).sum(axis=1)
    # Determinant of the normal equations, by |u × v|² without the cancellation of 1 - (u·v)²
    square = (cross_rows(units[:, 0], units[:, 1]) ** 2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        parts: FloatArray = np.stack([(first - both * second) / square, (second - both * first) / square], axis=1)
    return parts


def _on_lines(cell: LocalCell, lines: FloatArray) -> Iterator[WeightedPoints]:
    """Yield where lines (L, 2, 3), each through two points, cross each surface.

    A cell of planes alone is tested at its corners instead, which show more, unless it has very many.
    """
    if cell.flat.all() and len(cell.forms) <= _MOST_PLANES:
        return
    for s in range(len(cell.forms)):
        yield (s,), _line_crossings(cell.forms[s], lines)


def _line_crossings(form: FloatArray, lines: FloatArray) -> FloatArray:
    """Return the points (n, 3) where lines (L, 2, 3), each through two points, cross a surface."""
    start, along = lines[:, 0], lines[:, 1] - lines[:, 0]
    second, first = form[:3, :3], form[:3, 3]
    a = np.einsum("ti,ij,tj->t", along, second, along)
    b = np.einsum("ti,ij,tj->t", along, second, start) + along @ first
    c = np.einsum("ti,ij,tj->t", start, second, start) + 2 * start @ first + form[3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Both roots without cancellation: q / a and c / q
        root = np.sqrt(b * b - a * c)
        q = -(b + np.copysign(root, b))
        t = np.stack([np.where(a == 0, np.nan, q / a), np.where(a == 0, -c / (2 * b), c / q)], axis=1)
        points = start[:, None] + t[:, :, None] * along[:, None]
    points = points.reshape(-1, 3)
    return points[np.isfinite(points).all(axis=1)]


def _rims(cell: LocalCell, lines: FloatArray) -> Iterator[WeightedPoints]:
    """Yield points of the edges between the quadric and each plane, where lines of the plane cross the quadric."""
    for q in np.flatnonzero(~cell.flat).tolist():
        for p in np.flatnonzero(cell.flat).tolist():
            points = _line_crossings(cell.forms[p], lines)
            points = points[(np.abs(points) <= _REACH).all(axis=1)]
            if len(points) > 1:  # two points of a plane give a line in it
                pairs = np.stack([points, np.roll(points, 1, axis=0)], axis=1)
                yield (p, q), _line_crossings(cell.forms[q], pairs)


def _corners(cell: LocalCell) -> Iterator[WeightedPoints]:
    """Yield the corners of three planes, or of two planes and the quadric.

    If the cell is cut, the sides of the tested part count as planes too; every corner has at least one face.
    """
    count = len(cell.forms)
    planes = np.flatnonzero(cell.flat)
    if len(planes) > _MOST_PLANES:
        return
    forms = cell.forms
    if cell.cut:
        forms, planes = np.concatenate([forms, _CUBE]), np.append(planes, np.arange(count, count + 6))
    normals, offsets = forms[:, :3, 3], forms[:, 3, 3] / 2
    first, second, start, along = _common_lines(normals, offsets, planes)
    # One plane of each line must be a face of the cell
    real = first < count
    first, second, start, along = first[real], second[real], start[real], along[real]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Every plane crosses every line; a corner is taken once, by its planes in rising order
        t = -(start @ normals[planes].T + offsets[planes]) / (along @ normals[planes].T)
        points = start[:, None] + t[:, :, None] * along[:, None]
        mask = (np.abs(points) <= _REACH).all(axis=2) & (planes > second[:, None])
    for k, c in np.argwhere(mask).tolist():
        yield (int(first[k]), int(second[k]), int(planes[c])), points[k, c][None, :]
    for q in np.flatnonzero(~cell.flat).tolist():
        for k in range(len(first)):
            line = np.stack([start[k], start[k] + along[k]])[None]
            yield (int(first[k]), int(second[k]), q), _line_crossings(cell.forms[q], line)


def _common_lines(normals: FloatArray, offsets: FloatArray, planes: Any) -> tuple[Any, Any, FloatArray, FloatArray]:
    """Return the lines that two planes normal·x + offset = 0 share: (first plane, second plane, point, direction)."""
    i, j = np.triu_indices(len(planes), 1)
    first, second = planes[i], planes[j]
    along = cross_rows(normals[first], normals[second])
    crossing = along.any(axis=1)
    first, second, along = first[crossing], second[crossing], along[crossing]
    # The point of the line that is nearest to the origin
    start = offsets[first, None] * cross_rows(along, normals[second])
    start += offsets[second, None] * cross_rows(normals[first], along)
    return first, second, start / (along * along).sum(axis=1)[:, None], unit_rows(along)[0]


def _singular(cell: LocalCell) -> Iterator[WeightedPoints]:
    """Yield the double point of each quadric: the gradient vanishes, and the value does as far as its numbers show."""
    for q in np.flatnonzero(~cell.flat).tolist():
        form = cell.forms[q]
        point = -np.linalg.pinv(form[:3, :3], rcond=1e-12) @ form[:3, 3]
        # The pseudoinverse gives the center, or the nearest of many centers
        at = point[None, :]
        doubt = 4 * (np.abs(values(cell.moves[:, q], at)).sum() + cell.shifts[q])
        slope = np.abs(gradients(form[None], at)).sum()
        if abs(float(values(form[None], at)[0, 0])) <= doubt + 2.0**-50 and slope < 1e-9:
            yield (q,), at


# How far a relative change of 2^-53 of each of its numbers moves a shape, in units of its own extent.
#
# The result is a lower bound on the movement, attained up to second order: docs/dev/conditioning.md derives it.

_ROUNDING = 2.0**-50
"""Widths are increased by this share of the gradients' size, as they are rounded."""


@dataclass(frozen=True, eq=False)
class Movement:
    """The worst place of a part.

    relative    how far the surface moves, in units of the part's extent in that direction
    number      the number that contributes most
    local       (3,) the place in local coordinates
    gradient    (3,) of the combination of surfaces that moves
    width       of the part along the gradient
    singular    whether the gradient vanishes there, as far as the numbers show
    normals     (k, 3) gradients of the surfaces that meet there
    """

    relative: float
    number: str
    local: FloatArray
    gradient: FloatArray
    width: float
    singular: bool = False
    normals: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class TestedPart:
    """The cells of a shape with the tests of each."""

    local: LocalShape
    tests: tuple[TestPoints, ...]

    @classmethod
    def of(cls, local: LocalShape) -> TestedPart:
        """Find the tests of all cells."""
        return cls(local, tuple(tests_of(cell) for cell in local.cells))


def movement(part: TestedPart, fields: MotionFields, is_sheet: bool) -> Movement | None:
    """Return the worst movement of all cells; None if no cell has a test."""
    movements = [
        _cell_movement(cell, tests, fields, is_sheet) for cell, tests in zip(part.local.cells, part.tests, strict=True)
    ]
    return max((one for one in movements if one is not None), key=lambda one: one.relative, default=None)


def _cell_movement(cell: LocalCell, tests: TestPoints, fields: MotionFields, is_sheet: bool) -> Movement | None:
    """Return the worst movement of a cell; None if it has no test."""
    if not len(tests.points):
        return None
    h = np.concatenate([tests.points, np.ones((len(tests.points), 1))], axis=1)
    slopes = gradients(cell.forms, tests.points)
    gradient = np.einsum("ts,tsi->ti", tests.weights, slopes)
    # The change of the combined form at each test by each number: of the shape, then of the motion
    by_number = np.concatenate(
        [
            np.einsum("ts,ti,nsij,tj->tn", tests.weights, h, cell.moves, h, optimize=True),
            np.einsum("ti,mij,tj->tm", gradient, fields.fields, h, optimize=True),
        ],
        axis=1,
    )
    by_number = np.abs(by_number)
    change = by_number.sum(axis=1) + np.abs(tests.weights) @ cell.shifts
    # The width of the tested part, or of a polyhedron's corners, along the gradient; a sheet has none of its own
    width = np.abs(gradient).sum(axis=1)
    if is_sheet:
        width = np.linalg.norm(gradient, axis=1)
    elif len(tests.corners) > 3 and not cell.cut:
        reach = gradient @ tests.corners.T
        width = np.minimum(width, reach.max(axis=1) - reach.min(axis=1))
    width = width + _ROUNDING * np.einsum("ts,ts->t", np.abs(tests.weights), np.abs(slopes).sum(axis=2))
    bend = np.abs(tests.weights) @ np.abs(cell.forms[:, :3, :3]).sum(axis=(1, 2))
    relative = least_displacement(change, width, bend)
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


def least_displacement(change: Any, width: Any, bend: Any) -> Any:
    """Return the least d with width d + bend d² >= change."""
    with np.errstate(divide="ignore", invalid="ignore"):
        displacement = 2 * change / (width + np.sqrt(width * width + 4 * bend * change))
    return np.where(change > 0, displacement, 0.0)
