"""Boxes around polyhedra, moved or not: the floats that `geometry.polyhedron` finds in integers.

User: files of OpenMC, GDML and OpenSCAD, whose regions between planes are polyhedra; factor: 40 over integers.

By duality a corner of three planes is the farthest in a direction if the direction is a sum of their normals with
shares >= 0, and if the corner is beyond no plane. The dual simplex method finds the three in floats. Pairs of floats
with a bound of their error show the rest, and how to round the support. What they leave open is left to integers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._jit.decorators import helper, inline, kernel
from .._util.records import two_sum
from ..geometry.transform import Motion, Step
from ..kernels.numbers.double_double import (
    BoundedPair,
    dot3,
    minus,
    next_float_down,
    next_float_up,
    opposite,
    over,
    plus,
    product,
    sign,
    times_float,
)
from ..kernels.tables import Floats, Longs, Signs
from .region_extent import norm

if TYPE_CHECKING:
    from ..geometry.polyhedron import Polyhedron

_FAR_SIDES, _SLACK, _LEAST_RATE = 2.0**20, 2.0**-44, 2.0**-40
"""How far the first three sides are, in offsets; by which share a corner may be beyond a plane; the least pivot."""
_PIVOTS = 64
_TINY, _HUGE = 2.0**-150, 2.0**150
"""Numbers beyond these, other than 0, are left to integers: products of several might leave the range of floats."""
_DIRECTION_ROUNDING = 2.0**-52
"""As in `geometry.polyhedron`: a bound of the rounding of a direction and of sums with it."""


@helper
def _farthest_planes(work: Floats, count: int, dx: float, dy: float, dz: float, rows: Floats, basis: Longs) -> bool:
    """Write the numbers of three planes to `basis` whose corner seems farthest in a direction; False for none.

    The last three planes of `work` become sides of a large box. Where no others bound the direction, they stay.
    """
    far = 0.0
    for i in range(count):
        far = max(far, abs(work[i, 3]) / norm(work[i, 0], work[i, 1], work[i, 2]))
    for k in range(3):
        for plane in range(2):
            row = work[count + k] if plane else rows[k]
            row[0], row[1], row[2], row[3] = 0.0, 0.0, 0.0, _FAR_SIDES * (far if far > 0.0 else 1.0)
            row[k] = -1.0 if (dx if k == 0 else dy if k == 1 else dz) < 0.0 else 1.0
        basis[k] = count + k
    for _ in range(_PIVOTS):
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            rows[3 + k, 0] = rows[i, 1] * rows[j, 2] - rows[i, 2] * rows[j, 1]
            rows[3 + k, 1] = rows[i, 2] * rows[j, 0] - rows[i, 0] * rows[j, 2]
            rows[3 + k, 2] = rows[i, 0] * rows[j, 1] - rows[i, 1] * rows[j, 0]
        determinant = rows[0, 0] * rows[3, 0] + rows[0, 1] * rows[3, 1] + rows[0, 2] * rows[3, 2]
        if determinant == 0.0:
            return False
        x = (rows[0, 3] * rows[3, 0] + rows[1, 3] * rows[4, 0] + rows[2, 3] * rows[5, 0]) / determinant
        y = (rows[0, 3] * rows[3, 1] + rows[1, 3] * rows[4, 1] + rows[2, 3] * rows[5, 1]) / determinant
        z = (rows[0, 3] * rows[3, 2] + rows[1, 3] * rows[4, 2] + rows[2, 3] * rows[5, 2]) / determinant
        entering, most = -1, _SLACK * (max(abs(x), max(abs(y), abs(z))) + far)
        for i in range(count):
            nx, ny, nz = work[i, 0], work[i, 1], work[i, 2]
            beyond = (nx * x + ny * y + nz * z - work[i, 3]) / norm(nx, ny, nz)
            if beyond > most:
                entering, most = i, beyond
        if entering < 0:
            return True
        nx, ny, nz = work[entering, 0], work[entering, 1], work[entering, 2]
        size = norm(nx, ny, nz)
        leaving, least = -1, math.inf
        for k in range(3):
            cx, cy, cz = rows[3 + k, 0] / determinant, rows[3 + k, 1] / determinant, rows[3 + k, 2] / determinant
            rate = (cx * nx + cy * ny + cz * nz) / size
            if rate > _LEAST_RATE and max(cx * dx + cy * dy + cz * dz, 0.0) / rate < least:
                leaving, least = k, max(cx * dx + cy * dy + cz * dz, 0.0) / rate
        if leaving < 0:
            return False
        rows[leaving, 0], rows[leaving, 1], rows[leaving, 2] = nx / size, ny / size, nz / size
        rows[leaving, 3] = work[entering, 3] / size
        basis[leaving] = entering
    return False


@inline
def _pair(x: float) -> BoundedPair:
    """Return a float as a pair."""
    return BoundedPair(x, 0.0, 0.0)


@inline
def _cross_pairs(work: Floats, i: int, j: int) -> tuple[BoundedPair, BoundedPair, BoundedPair]:
    """Return the cross product of the normals of two planes."""
    return (
        minus(product(work[i, 1], work[j, 2]), product(work[i, 2], work[j, 1])),
        minus(product(work[i, 2], work[j, 0]), product(work[i, 0], work[j, 2])),
        minus(product(work[i, 0], work[j, 1]), product(work[i, 1], work[j, 0])),
    )


@inline
def _is_at_most(a: BoundedPair, sense: int) -> bool:
    """Return whether sense · a <= 0 for certain."""
    found = sign(a)
    return found != 2 and sense * found <= 0


@inline
def _end_of_plane(work: Floats, i: int, dx: float, dy: float, dz: float) -> tuple[BoundedPair, BoundedPair, int]:
    """Return two numbers whose ratio is the support in a direction along the normal of a plane, and the second's sign.

    Nothing is rounded, so that a support that is a float is recognised.
    """
    normal, along = work[i, 0], dx
    if dx == 0.0:
        normal, along = (work[i, 1], dy) if dy != 0.0 else (work[i, 2], dz)
    return product(work[i, 3], along), _pair(normal), -1 if normal < 0.0 else 1


@helper
def _is_endless(work: Floats, count: int, dx: float, dy: float, dz: float, basis: Longs) -> bool:
    """Return whether a point can go along the edge of the planes of `basis`, and so in a direction, for ever."""
    first, second = -1, -1
    for k in range(3):
        if basis[k] < count:
            first, second = basis[k], first
    x, y, z = _pair(dx), _pair(dy), _pair(dz)
    if second >= 0:
        x, y, z = _cross_pairs(work, first, second)
    elif first >= 0:  # the direction itself, less its part along the normal
        nx, ny, nz = work[first, 0], work[first, 1], work[first, 2]
        square, along = dot3(nx, ny, nz, _pair(nx), _pair(ny), _pair(nz)), dot3(nx, ny, nz, x, y, z)
        x = minus(times_float(square, dx), times_float(along, nx))
        y = minus(times_float(square, dy), times_float(along, ny))
        z = minus(times_float(square, dz), times_float(along, nz))
    forth = sign(dot3(dx, dy, dz, x, y, z))
    if forth != 1 and forth != -1:
        return False
    for other in range(count):
        if other != first and other != second:
            rise = dot3(work[other, 0], work[other, 1], work[other, 2], x, y, z)
            if not _is_at_most(rise, forth):
                return False
    return True


@helper
def _support(work: Floats, count: int, dx: float, dy: float, dz: float, rows: Floats, basis: Longs) -> float:
    """Return the least float not below the support of half-spaces in a direction; NaN where floats leave it open."""
    if not _farthest_planes(work, count, dx, dy, dz, rows, basis):
        return math.nan
    i, j, k = basis[0], basis[1], basis[2]
    a, b, c = _cross_pairs(work, j, k), _cross_pairs(work, k, i), _cross_pairs(work, i, j)
    p, q, r = work[i, 3], work[j, 3], work[k, 3]
    unit = dot3(work[i, 0], work[i, 1], work[i, 2], a[0], a[1], a[2])
    sense = sign(unit)
    if sense != 1 and sense != -1:
        return math.nan
    first, second, third = (
        dot3(dx, dy, dz, a[0], a[1], a[2]), dot3(dx, dy, dz, b[0], b[1], b[2]), dot3(dx, dy, dz, c[0], c[1], c[2])
    )  # fmt: skip
    if not (_is_at_most(first, -sense) and _is_at_most(second, -sense) and _is_at_most(third, -sense)):
        return math.nan
    # The corner times `unit`
    x, y, z = dot3(p, q, r, a[0], b[0], c[0]), dot3(p, q, r, a[1], b[1], c[1]), dot3(p, q, r, a[2], b[2], c[2])
    for other in range(count):
        if other != i and other != j and other != k:
            height = dot3(work[other, 0], work[other, 1], work[other, 2], x, y, z)
            if not _is_at_most(minus(height, times_float(unit, work[other, 3])), sense):
                return math.nan
    # Sides of the box count only where the direction is no sum of the other normals
    if (
        (i >= count and sign(first) != 0) or (j >= count and sign(second) != 0) or (k >= count and sign(third) != 0)
    ):  # fmt: skip
        return math.inf if _is_endless(work, count, dx, dy, dz, basis) else math.nan
    total = dot3(p, q, r, first, second, third)
    if sign(second) == 0 and sign(third) == 0:
        total, unit, sense = _end_of_plane(work, i, dx, dy, dz)
    elif sign(third) == 0 and sign(first) == 0:
        total, unit, sense = _end_of_plane(work, j, dx, dy, dz)
    elif sign(first) == 0 and sign(second) == 0:
        total, unit, sense = _end_of_plane(work, k, dx, dy, dz)
    if sign(total) == 0:
        return 0.0
    end = over(total, unit).high
    if not _is_at_most(minus(total, times_float(unit, end)), sense):
        end = next_float_up(end)
    below = minus(total, times_float(unit, next_float_down(end)))
    if _is_at_most(minus(total, times_float(unit, end)), sense) and sign(below) == sense:
        return end
    return math.nan


@inline
def _are_moderate(numbers: Floats, body: int) -> bool:
    """Return whether products of some numbers of a row stay within the range of floats."""
    for i in range(numbers.shape[1]):
        size = abs(numbers[body, i])
        if size != 0.0 and not (size > _TINY and size < _HUGE):
            return False
    return True


@inline
def _copy_planes(planes: Floats, body: int, work: Floats) -> int:
    """Copy the planes of a body to `work`; return their number."""
    count = planes.shape[1] // 4
    for i in range(count):
        for k in range(4):
            work[i, k] = planes[body, 4 * i + k]
    return count


@kernel(planes="n 4*p", boxes="out n 6", certain="out n", work="out p+3 4", rows="out 6 4", basis="out 3")
def bound_half_spaces(planes: Floats, boxes: Floats, certain: Signs, work: Floats, rows: Floats, basis: Longs) -> None:
    """Write the boxes around intersections of half-spaces, rounded outward once.

    Parameters
    ----------
    planes : array (n, 4 p)
        Normals and offsets.
    boxes : array (n, 6)
        Receives the boxes.
    certain : array (n,)
        Receives 1 where a box is certain; else 0, as for empty ones.
    work, rows, basis : arrays
        Room.
    """
    for body in range(len(planes)):
        count = _copy_planes(planes, body, work)
        certain[body] = _are_moderate(planes, body)
        for side in range(6):
            if not certain[body]:
                break
            sense, axis = 1.0 if side >= 3 else -1.0, side % 3
            x, y, z = (
                sense if axis == 0 else 0.0, sense if axis == 1 else 0.0, sense if axis == 2 else 0.0
            )  # fmt: skip
            boxes[body, side] = sense * _support(work, count, x, y, z, rows, basis) + 0.0
            certain[body] = not math.isnan(boxes[body, side])


@inline
def _quad_pair(motions: Floats, body: int, number: int) -> BoundedPair:
    """Return a number of a motion, of four floats and an error."""
    at = 5 * number
    lost = abs(motions[body, at + 2]) + abs(motions[body, at + 3])
    return BoundedPair(motions[body, at], motions[body, at + 1], 1.001 * lost + motions[body, at + 4])


@inline
def _is_rounded(a: BoundedPair) -> bool:
    """Return whether the high part is the nearest float for certain: the number is exact, or not about halfway."""
    ulp = next_float_up(abs(a.high)) - abs(a.high)
    is_exact = a.error == 0.0 and a.high + a.low == a.high
    return is_exact or (a.high != 0.0 and abs(a.low) + a.error < (0.5 - 2.0**-40) * ulp)


@helper
def _moved_end(
    own: Floats, motions: Floats, body: int, axis: int, sense: float, work: Floats, rows: Floats, basis: Longs
) -> float:
    """Return how far a moved polyhedron reaches along an axis, or against it, as `bound_by_support` does; or NaN."""
    x, y, z = motions[body, 15 * axis], motions[body, 15 * axis + 5], motions[body, 15 * axis + 10]
    shift = _quad_pair(motions, body, 9 + axis)
    if sense < 0.0:
        shift = opposite(shift)
    for k in range(3):
        if not _is_rounded(_quad_pair(motions, body, 3 * axis + k)):
            return math.nan
    several = int(x != 0.0) + int(y != 0.0) + int(z != 0.0)
    if several == 1:
        k = 0 if x != 0.0 else 1 if y != 0.0 else 2
        factor = _quad_pair(motions, body, 3 * axis + k)
        upward = (factor.high > 0.0) == (sense > 0.0)
        reach = own[body, 3 + k] if upward else -own[body, k]
        if factor.high < 0.0:
            factor = opposite(factor)
        end = plus(times_float(factor, reach), shift)
        above = sign(minus(end, BoundedPair(end.high, 0.0, 0.0)))
        return math.nan if above == 2 else next_float_up(end.high) if above == 1 else end.high
    if not _is_rounded(shift):
        return math.nan
    reach = _support(work, len(work) - 3, sense * x, sense * y, sense * z, rows, basis)
    terms = BoundedPair(0.0, 0.0, 0.0)
    for k in range(3):
        entry = x if k == 0 else y if k == 1 else z
        if entry != 0.0:
            terms = plus(terms, BoundedPair(abs(entry) * max(abs(own[body, k]), abs(own[body, 3 + k])), 0.0, 0.0))
    reach += _DIRECTION_ROUNDING * terms.high
    if terms.error > 0.0 or (reach == 0.0 and shift.high == 0.0):
        return math.nan
    return next_float_up(reach + shift.high + 4 * 2.0**-53 * (abs(reach) + abs(shift.high)))


@kernel(
    planes="n 4*p", own="n 6", motions="n 60", boxes="out n 6", certain="out n", work="out p+3 4", rows="out 6 4",
    basis="out 3",
)  # fmt: skip
def bound_moved_half_spaces(
    planes: Floats, own: Floats, motions: Floats, boxes: Floats, certain: Signs, work: Floats, rows: Floats,
    basis: Longs,
) -> None:  # fmt: skip
    """Write the boxes around moved intersections of half-spaces.

    Parameters
    ----------
    planes : array (n, 4 p)
        Normals and offsets.
    own : array (n, 6)
        Their boxes before the motion, finite and rounded outward once.
    motions : array (n, 60)
        The twelve numbers of each motion, linear part and shift, each as four floats and an error.
    boxes, certain, work, rows, basis : arrays
        As for `bound_half_spaces`.
    """
    for body in range(len(planes)):
        _copy_planes(planes, body, work)
        certain[body] = _are_moderate(planes, body) and _are_moderate(own, body)
        for side in range(6):
            if not certain[body]:
                break
            sense = 1.0 if side >= 3 else -1.0
            end = _moved_end(own, motions, body, side % 3, sense, work, rows, basis)
            boxes[body, side] = sense * end + 0.0
            certain[body] = not math.isnan(end)


# Polyhedra of equally many faces


def _room(planes: Floats) -> tuple[Floats, Floats, Longs]:
    """Return room for polyhedra of these planes."""
    return np.empty((planes.shape[1] // 4 + 3, 4)), np.empty((6, 4)), np.empty(3, np.int64)


def learn_bounds(shapes: Sequence[Polyhedron], planes: Floats) -> None:
    """Let polyhedra of equal count of faces know their boxes before any motion, where floats are certain of them."""
    fresh = [k for k, shape in enumerate(shapes) if "_own_bounds" not in vars(shape)]
    if not fresh:
        return
    boxes, certain = np.empty((len(fresh), 6)), np.empty(len(fresh), np.int8)
    bound_half_spaces(planes[fresh], boxes, certain, *_room(planes))
    for row, k in enumerate(fresh):
        if certain[row]:
            vars(shapes[k])["_own_bounds"] = boxes[row, :3].copy(), boxes[row, 3:].copy()


def polyhedron_boxes(
    shapes: Sequence[Polyhedron], steps: Sequence[tuple[Step, ...]], planes: Floats, motions: Floats | None
) -> Floats:
    """Return the boxes (n, 6) around polyhedra of equal count of faces, each moved by steps.

    Parameters
    ----------
    shapes : sequence of Polyhedron
        The polyhedra; their own motions do not count.
    steps : sequence
        The steps that move each.
    planes : array (n, 4 p)
        Their normals and offsets.
    motions : array (n, 60) or None
        The numbers of each motion, linear part and shift, as four floats and an error; None if all steps translate,
        as many for each.
    """
    own = np.array([np.concatenate(shape._own_bounds) for shape in shapes])
    boxes, certain = own.copy(), np.zeros(len(own), np.int8)
    if motions is None and not steps[0]:
        return own
    if motions is None and len(steps[0]) == 1:
        shifts = np.array([step.offset for (step,) in steps])  # type: ignore[union-attr]
        boxes, certain = _shifted_boxes(own, shifts)
    else:
        motions = _summed_shifts(steps) if motions is None else motions
        bound_moved_half_spaces(planes, own, motions, boxes, certain, *_room(planes))
    for row in np.flatnonzero(certain == 0).tolist():
        boxes[row] = np.concatenate(shapes[row]._with_motion(Motion(steps[row])).bounds)
    return boxes


def _shifted_boxes(own: Floats, shifts: Floats) -> tuple[Floats, Signs]:
    """Return boxes moved by one translation each, rounded outward once, and which are certain: the finite ones."""
    sense = np.repeat((-1.0, 1.0), 3)
    reach, shift = sense * own, sense * np.tile(shifts, 2)
    with np.errstate(all="ignore"):
        total = reach + shift
        part = total - reach
        lost = (reach - (total - part)) + (shift - part)
        ends = np.where(lost > 0, np.nextafter(total, np.inf), total)
    return sense * ends + 0.0, np.isfinite(ends).all(axis=1).astype(np.int8)


def _summed_shifts(steps: Sequence[tuple[Step, ...]]) -> Floats:
    """Return the numbers of motions that are equally many translations each, as `polyhedron_boxes` takes them."""
    found = np.zeros((len(steps), 12, 5))
    found[:, [0, 4, 8], 0], shift = 1.0, found[:, 9:]
    for rest in np.moveaxis(np.array([[step.offset for step in chain] for chain in steps]), 1, 0):  # type: ignore[union-attr]
        for part in range(4):
            shift[:, :, part], rest = two_sum(shift[:, :, part], rest)
        shift[:, :, 4] += 1.001 * np.abs(rest)
    shift[:, :, 0], shift[:, :, 1] = two_sum(shift[:, :, 0], shift[:, :, 1])
    return found.reshape(len(steps), -1)
