"""Test points of a cell, on its faces, edges and corners in local coordinates, and how far each of them moves.

A test is a point with weights of the surfaces through it: one surface alone; or, at an edge or a corner, one surface
without its components along the others. The latter measures how far the edge or corner moves within the others.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray, IndexArray, cross_rows, unit_rows
from ..._util.records import dataclass
from .perturbation import LocalCell, LocalShape, MotionFields

_LINES = 48
"""Random lines that are intersected with each surface, besides the three axes."""
_MOST_PLANES = 96
"""Cells of more planes have no tests at corners: their number grows with its cube."""
_TOLERANCE = 1e-9
"""A point is inside a face if the face's function is at most this."""
_REACH = 0.5 + 1e-6
"""The tested part reaches this far along each axis, with some room for rounding."""
_SAME_CORNER = 2.0**-44
"""Corners that agree to this count once, which changes movements by less than any digit that is shown."""
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
    """Points (T, 3), the surfaces (T, 3) in each test with weights (T, 3), and the corners (V, 3) of a polyhedron.

    A test of fewer surfaces has weights of 0.
    """

    points: FloatArray
    surfaces: IndexArray
    weights: FloatArray
    corners: FloatArray


def tests_of(cell: LocalCell) -> TestPoints:
    """Return the tests of a cell; random lines have a fixed seed, so they are always the same."""
    random = np.random.default_rng(20261122)
    lines = random.random((_LINES, 2, 3)) - 0.5
    # Also the three axes of the tested part
    lines = np.concatenate([lines, np.stack([-np.eye(3), np.eye(3)], axis=1) / 2])
    none = np.zeros((0, 3))
    tests, corners = [(none, none.astype(np.intp), none)], [none]
    for through, at in (*_on_lines(cell, lines), *_corners(cell), *_rims(cell, lines), *_singular(cell)):
        mask = _inside(cell, at, through)
        through, at = through[mask], at[mask]
        # The corners of a polyhedron also give its width
        if cell.flat.all() and through.shape[1] == 3:
            corners.append(at)
        tests.append(_tests_at(cell, at, through))
    points, surfaces, weights = (np.concatenate(each) for each in zip(*tests, strict=True))
    _, first = np.unique(np.round(np.concatenate(corners) / _SAME_CORNER), axis=0, return_index=True)
    return TestPoints(points, surfaces, weights, np.concatenate(corners)[first])


WeightedPoints = tuple[IndexArray, FloatArray]
"""Numbers (n, 1, 2 or 3) of the surfaces through some points, sides of the tested part last, and the points (n, 3)."""


def _tests_at(cell: LocalCell, points: FloatArray, through: IndexArray) -> tuple[FloatArray, IndexArray, FloatArray]:
    """Return the points, surfaces and weights of all tests at some points: those of a point follow each other."""
    owners, surfaces, weights = [np.zeros(0, np.intp)], [np.zeros((0, 3), np.intp)], [np.zeros((0, 3))]
    counts = (through < len(cell.forms)).sum(axis=1)
    for count in range(1, through.shape[1] + 1):
        rows = np.flatnonzero(counts == count)
        for combination in _combinations(range(count if len(rows) else 0)):
            some = rows
            # A corner of many planes is found by each three of them, and has each plane and each two of them many times
            if len(combination) < through.shape[1] == 3:
                keys = np.column_stack([through[some[:, None], combination], np.round(points[some] / _SAME_CORNER)])
                some = some[np.sort(np.unique(keys, axis=0, return_index=True)[1])]
            chosen = through[some[:, None], combination]
            for weight in _weights(cell, points[some], chosen):
                padded = np.zeros((len(some), 3))
                padded[:, : len(combination)] = weight
                owners.append(some)
                surfaces.append(chosen[:, (0, 1, 2)[: len(combination)] + (0,) * (3 - len(combination))])
                weights.append(padded)
    order = np.argsort(np.concatenate(owners), kind="stable")
    return points[np.concatenate(owners)[order]], np.concatenate(surfaces)[order], np.concatenate(weights)[order]


def _combinations(surfaces: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield all subsets but the empty one."""
    for size in range(1, len(surfaces) + 1):
        yield from itertools.combinations(surfaces, size)


def gradients(forms: FloatArray, surfaces: IndexArray, points: FloatArray) -> FloatArray:
    """Return the gradients (T, k, 3) of k of the forms (S, 4, 4) at each of T points (T, 3), by `surfaces` (T, k)."""
    half = forms[:, :3, 3][surfaces]
    for s in np.flatnonzero(forms[:, :3, :3].any(axis=(1, 2))).tolist():
        row, place = np.nonzero(surfaces == s)
        half[row, place] += points[row] @ forms[s, :3, :3]
    return 2 * half


def _products(points: FloatArray) -> FloatArray:
    """Return all products (T, 16) of two of x, y, z and 1."""
    h = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    return (h[:, :, None] * h[:, None, :]).reshape(-1, 16)


def values(forms: FloatArray, points: FloatArray) -> FloatArray:
    """Return the values (T, S) of S forms (S, 4, 4) at T points (T, 3)."""
    # Without BLAS, whose threads wait for each other longer than such small products take
    result: FloatArray = np.einsum("ti,si->ts", _products(points), forms.reshape(-1, 16))
    return result


def _inside(cell: LocalCell, points: FloatArray, through: IndexArray) -> Any:
    """Return (T,) bool: is the point in the tested part, and inside all faces but those through it?"""
    mask: Any = (np.isfinite(points) & (np.abs(points) <= _REACH)).all(axis=1)
    some, count = np.flatnonzero(mask), len(cell.forms)
    # The last column is for the sides of the tested part
    height = np.zeros((len(some), count + 1))
    height[:, :count] = values(cell.forms, points[some]) * cell.sides
    np.put_along_axis(height, np.minimum(through[some], count), 0.0, axis=1)
    mask[some] = (height <= _TOLERANCE).all(axis=1)
    return mask


def _weights(cell: LocalCell, points: FloatArray, surfaces: IndexArray) -> Iterator[FloatArray]:
    """Yield weights (T, k) for each of k surfaces (T, k): it alone, or without its components along others' normals."""
    count = surfaces.shape[1]
    if count == 1:
        yield np.ones(surfaces.shape)
        return
    # Unit normals, so that weights of different surfaces compare; points without some normal get no test
    normals = gradients(cell.forms, surfaces, points)
    sizes = np.linalg.norm(normals, axis=2)
    usable = sizes.min(axis=1) > _SMALL
    sizes = np.where(usable[:, None], sizes, 1.0)
    units = normals / sizes[:, :, None]
    for k in range(count):
        others = [j for j in range(count) if j != k]
        # The weighted sum of gradients is the unit normal k without its projection onto the others
        result = 1 / sizes
        result[:, others] = -_along(units[:, others], units[:, k]) / sizes[:, others]
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
        points, _ = _line_crossings(cell.forms[s], lines)
        yield np.full((len(points), 1), s), points


def _line_crossings(form: FloatArray, lines: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return the points (n, 3) where lines (L, 2, 3), each through two points, cross a surface, and their lines."""
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
    line, root = np.nonzero(np.isfinite(points).all(axis=2))
    return points[line, root], line


def _rims(cell: LocalCell, lines: FloatArray) -> Iterator[WeightedPoints]:
    """Yield points of the edges between the quadric and each plane, where lines of the plane cross the quadric."""
    for q in np.flatnonzero(~cell.flat).tolist():
        for p in np.flatnonzero(cell.flat).tolist():
            points, _ = _line_crossings(cell.forms[p], lines)
            points = points[(np.abs(points) <= _REACH).all(axis=1)]
            if len(points) > 1:  # two points of a plane give a line in it
                pairs = np.stack([points, np.roll(points, 1, axis=0)], axis=1)
                points, _ = _line_crossings(cell.forms[q], pairs)
                yield np.broadcast_to((p, q), (len(points), 2)), points


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
    k, c = np.nonzero(mask)
    yield np.stack([first[k], second[k], planes[c]], axis=1), points[k, c]
    for q in np.flatnonzero(~cell.flat).tolist():
        points, k = _line_crossings(forms[q], np.stack([start, start + along], axis=1))
        through = np.stack([first[k], second[k], np.full(len(k), q)], axis=1)
        yield np.take_along_axis(through, np.argsort(through >= count, axis=1, kind="stable"), axis=1), points


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
        slope = np.abs(gradients(form[None], np.zeros((1, 1), np.intp), at)).sum()
        if abs(float(values(form[None], at)[0, 0])) <= doubt + 2.0**-50 and slope < 1e-9:
            yield np.full((1, 1), q), at


# How far a relative change of 2^-53 of each of its numbers moves a shape, in units of its own extent.
#
# The result is a lower bound on the movement, attained up to second order: docs/dev/conditioning.md derives it.

_ROUNDING = 2.0**-50
"""Widths are increased by this share of the gradients' size, as they are rounded."""
_MOST_NUMBERS = 2**20
"""About so many changes of tests by numbers are computed together."""


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
    step = max(_MOST_NUMBERS // (16 + len(cell.moves) + len(fields.fields)), 1)
    found = [_worst_of(cell, tests, fields, is_sheet, slice(k, k + step)) for k in range(0, len(tests.points), step)]
    return max(found, key=lambda one: one.relative, default=None)


def _worst_of(cell: LocalCell, tests: TestPoints, fields: MotionFields, is_sheet: bool, some: slice) -> Movement:
    """Return the worst movement of some tests of a cell."""
    points, surfaces, weights = tests.points[some], tests.surfaces[some], tests.weights[some]
    products = _products(points)
    slopes = gradients(cell.forms, surfaces, points)
    gradient = np.einsum("ts,tsi->ti", weights, slopes)
    # The change of the combined form at each test by each number: of the shape, then of the motion
    by_own = np.zeros((len(points), len(cell.moves)))
    for s in range(len(cell.forms) if len(cell.moves) else 0):
        row, place = np.nonzero((surfaces == s) & (weights != 0))
        number = np.flatnonzero(cell.moves[:, s].any(axis=(1, 2)))
        change = products[row] @ cell.moves[number, s].reshape(-1, 16).T
        by_own[row[:, None], number] += weights[row, place][:, None] * change
    by_motion = (gradient[:, :, None] * products[:, None, 12:]).reshape(-1, 12) @ fields.fields.reshape(-1, 12).T
    by_number = np.abs(np.concatenate([by_own, by_motion], axis=1))
    change = by_number.sum(axis=1) + (np.abs(weights) * cell.shifts[surfaces]).sum(axis=1)
    # The width of the tested part, or of a polyhedron's corners, along the gradient; a sheet has none of its own
    width = np.abs(gradient).sum(axis=1)
    if is_sheet:
        width = np.linalg.norm(gradient, axis=1)
    elif len(tests.corners) > 3 and not cell.cut:
        reach = gradient @ tests.corners.T
        width = np.minimum(width, reach.max(axis=1) - reach.min(axis=1))
    width = width + _ROUNDING * (np.abs(weights) * np.abs(slopes).sum(axis=2)).sum(axis=1)
    bend = (np.abs(weights) * np.abs(cell.forms[:, :3, :3]).sum(axis=(1, 2))[surfaces]).sum(axis=1)
    relative = least_displacement(change, width, bend)
    worst = int(relative.argmax())
    names = (*cell.numbers, *fields.numbers)
    return Movement(
        float(relative[worst]),
        names[int(by_number[worst].argmax())] if names else "",
        points[worst],
        gradient[worst],
        float(width[worst]),
        bool(4 * bend[worst] * change[worst] > width[worst] ** 2),
        slopes[worst][weights[worst] != 0],
    )


def least_displacement(change: Any, width: Any, bend: Any) -> Any:
    """Return the least d with width d + bend d² >= change."""
    with np.errstate(divide="ignore", invalid="ignore"):
        displacement = 2 * change / (width + np.sqrt(width * width + 4 * bend * change))
    return np.where(change > 0, displacement, 0.0)
