"""Every use of a surface, by a cell, a sheet or a polygon in the box of an entry, weighed for `limits`: one by one.

The kernels read each number once and keep nothing, where arrays of all uses would be larger than the scene.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiler.jit import inline, kernel
from ...compiler.shapes import shaped
from ..surface.doubt import FAR, KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES, RELATIVE
from ..tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Signs, Tables, whole
from .surfaces import Remainders

_LEAST = 1e-100
"""Times the square of a direction's least component that is still a number."""
_WIDE, _WIDEST = 2.0**10, 2.0**20
"""Bodies without an end are taken to be so many times as large as the scene; those of exact planes, so many times."""


@shaped(
    kind="s", row="s", planes="p 7", spheres="b 4", quadrics="q 4", forms="f 16", lost_of_planes="p 7",
    lost_of_quadrics="l 19",
)  # fmt: skip
class Records(NamedTuple):
    """The surfaces of a scene, and what rounding took from planes and quadrics."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: Floats
    forms: Floats
    lost_of_planes: Floats
    lost_of_quadrics: Floats

    @classmethod
    def of(cls, tables: Tables, rest: Remainders) -> Records:
        """Those of a scene. In finished tables all integers are of one type."""
        t, kind = tables, tables.surface_kind.astype(np.int8, copy=False)
        return cls(kind, t.surface_row, t.planes, t.spheres, t.quadrics, t.quadric_forms, rest.planes, rest.quadrics)


@inline
def _is_row(records: Records, surface: int) -> bool:
    """Is there a surface of this number, with a record?"""
    if not 0 <= surface < len(records.kind):
        return False
    kind, row = records.kind[surface], records.row[surface]
    if kind == PLANE:
        return 0 <= row < len(records.planes)
    if kind == SPHERE:
        return 0 <= row < len(records.spheres)
    if not 0 <= row < len(records.quadrics):
        return False
    form = _form(records, row)
    return 0 <= form < len(records.forms) and form < len(records.lost_of_quadrics)


@inline
def _form(records: Records, row: int) -> int:
    """The row of a quadric's form, and of what rounding took from its numbers."""
    return whole(records.quadrics[row, 3])


@inline
def _anchor(records: Records, surface: int, axis: int) -> float:
    kind, row = records.kind[surface], records.row[surface]
    if kind == PLANE:
        return records.planes[row, 4 + axis]
    return records.spheres[row, axis] if kind == SPHERE else records.quadrics[row, axis]


@inline
def _is_inexact(lost: Floats, row: int) -> bool:
    """Was anything rounded in a record?"""
    found = 0
    for k in range(lost.shape[1]):
        found += 1 if lost[row, k] != 0.0 else 0
    return found > 0


@inline
def _is_bounded(boxes: Floats, entry: int) -> bool:
    ends = 0
    for k in range(6):
        ends += 1 if abs(boxes[entry, k]) < math.inf else 0
    return ends == 6


@inline
def _reach(records: Records, boxes: Floats, surface: int, entry: int, bounded: bool, size: float) -> float:
    """How far from its anchor a surface is used."""
    if records.kind[surface] == SPHERE:
        return records.spheres[records.row[surface], 3]
    if not bounded:
        return _WIDE * size
    square = 0.0
    for k in range(3):
        anchor = _anchor(records, surface, k)
        below, above = abs(boxes[entry, k] - anchor), abs(boxes[entry, k + 3] - anchor)
        away = below if below > above else above
        square += away * away
    return math.sqrt(square) * (1 + 1e-12) + 1e-300


@inline
def _kappa(records: Records, surface: int, reach: float) -> float:
    """The share of a value's terms by which rounding may change it."""
    kind, row = records.kind[surface], records.row[surface]
    if kind == SPHERE:
        return KAPPA_OF_BALLS
    if kind == PLANE:
        return KAPPA_OF_PLANES if _is_inexact(records.lost_of_planes, row) else 0.0
    lost, square = _form(records, row), 0.0
    for k in range(3):
        square += records.lost_of_quadrics[lost, k] * records.lost_of_quadrics[lost, k]
    return KAPPA + 8.0 * math.sqrt(square) / reach


@inline
def _larger(known: float, x: float) -> float:
    """The larger one of two; no number, if one is."""
    return known if known >= x or known != known else x


@kernel(
    boxes="e 6", surface="n", place="n", owner="n", entry="n", begin="0..end", end="0..n", limits="out o 2",
    most="out 3 m",
)  # fmt: skip
def weigh(
    records: Records, boxes: Floats, size: float, surface: Ints, place: Ints, owner: Ints, entry: Ints, begin: int,
    end: int, limits: Floats, most: Floats,
) -> int:  # fmt: skip
    """Take some uses into the limits of their owners, and into the most of their surfaces, which have places in it.

    most: the largest reach, the largest kappa, 1 if some use has no end. size: that of the scene. Returns how many uses
    name what is not there.
    """
    strange = 0
    for use in range(begin, end):
        s, p, o, e = surface[use], place[use], owner[use], entry[use]
        if not (_is_row(records, s) and 0 <= p < most.shape[1] and 0 <= o < len(limits) and 0 <= e < len(boxes)):
            strange += 1
            continue
        bounded = _is_bounded(boxes, e)
        reach = _reach(records, boxes, s, e, bounded, size)
        kappa = _kappa(records, s, reach)
        around, far = _WIDE * size, FAR * reach
        if bounded:
            around = 0.0
            for k in range(6):
                around += abs(boxes[e, k])
        elif records.kind[s] == PLANE and kappa == 0.0:
            around = far = _WIDEST * size
        else:
            far = _WIDE * size
        off = 0.5 * math.sqrt(kappa) * reach + RELATIVE * around
        limits[o, 0], limits[o, 1] = _larger(limits[o, 0], off), -_larger(-limits[o, 1], -far)
        most[0, p], most[1, p] = _larger(most[0, p], reach), _larger(most[1, p], kappa)
        most[2, p] = most[2, p] if bounded else 1.0
    return strange


@kernel(surface="n", most="3 n", limits="out p 2")
def put_limits_of_planes(records: Records, surface: Ints, most: Floats, limits: Floats) -> None:
    """Those of some surfaces that are planes: square of the least certain rate, for |d| = 1; the least height."""
    for i in range(len(surface)):
        if not _is_row(records, surface[i]) or records.kind[surface[i]] != PLANE:
            continue
        row, planes, reach, kappa = records.row[surface[i]], records.planes, most[0, i], most[1, i]
        square, along = 0.0, 0
        for k in range(3):
            square += planes[row, k] * planes[row, k]
            along += 1 if planes[row, k] != 0.0 else 0
        length, height, least = math.sqrt(square), planes[row, 3], 2.0 * math.sqrt(kappa)
        rate = (least if least > 2.0**-40 else 2.0**-40) * length
        plain = along == 1 and height == 0.0 and not _is_inexact(records.lost_of_planes, row)
        limits[row, 0] = rate * rate
        limits[row, 1] = 0.0 if plain else 2.0**-40 * (length * reach + abs(height))


@inline
def _row_size(forms: Floats, form: int, line: int) -> float:
    """The length of one of the rows of a quadric."""
    square = 0.0
    for k in range(3):
        square += forms[form, 3 * line + k] * forms[form, 3 * line + k]
    return math.sqrt(square)


@inline
def _sizes(forms: Floats, form: int) -> tuple[float, float, float]:
    """Bounds on the second-order, linear and constant terms at distance 1 from the anchor."""
    squares = linear = 0.0
    for line in range(3):
        length = _row_size(forms, form, line)
        squares += abs(forms[form, 9 + line]) * (length * length)
        linear += abs(forms[form, 12 + line]) * length
    return squares, linear, abs(forms[form, 15])


@inline
def _is_plain(forms: Floats, form: int) -> bool:
    """Is each axis along which a quadric bends one of the world's, and its coefficient no number that underflows?"""
    for line in range(3):
        square, linear = abs(forms[form, 9 + line]), abs(forms[form, 12 + line])
        if square == 0.0 and linear == 0.0:
            continue
        along, size = 0, 0.0
        for k in range(3):
            part = abs(forms[form, 3 * line + k])
            along += 1 if part != 0.0 else 0
            size = part if part > size else size
        bends = square == 0.0 or square * (size * size) > _LEAST
        if not (along <= 1 and bends and (linear == 0.0 or linear * size > _LEAST)):
            return False
    return True


@kernel(surface="n", most="3 n", limits="out f 2")
def put_limits_of_quadrics(records: Records, surface: Ints, most: Floats, limits: Floats) -> None:
    """Those of the forms of some quadrics: the least certain discriminant, for |d| = 1; least value along rulings.

    The latter is infinite where a body has no end and a direction's part along an axis that bends is a sum: rounding
    may have made that 0, where the ray comes to a wall, however far away.
    """
    for i in range(len(surface)):
        if not _is_row(records, surface[i]) or records.kind[surface[i]] != QUADRIC:
            continue
        form, reach, share = _form(records, records.row[surface[i]]), most[0, i], most[1, i]
        a, b, k = _sizes(records.forms, form)
        terms = 10.0 * a * reach * reach + 6.0 * b * reach + k
        rate = terms / reach
        limits[form, 0] = 4.0 * share * (rate * rate) if reach > 0.0 else math.inf
        limits[form, 1] = math.inf if most[2, i] > 0.0 and not _is_plain(records.forms, form) else share * terms


@inline
def _larger_finite(size: float, x: float) -> float:
    """The larger one of two, where the second is finite; else the first."""
    return x if size < x < math.inf else size


@kernel(planes="p 7", quadrics="q 4", forms="f 16", boxes="e 6")
def size_of_records(planes: Floats, quadrics: Floats, forms: Floats, boxes: Floats) -> float:
    """Of what is finite in a scene: coordinates, radii, the own sizes of quadrics; 0 where there is nothing."""
    size = 0.0
    for row in range(len(planes)):
        for k in range(4, 7):
            size = _larger_finite(size, abs(planes[row, k]))
    for row in range(len(boxes)):
        for k in range(6):
            size = _larger_finite(size, abs(boxes[row, k]))
    for row in range(len(quadrics)):
        for k in range(3):
            size = _larger_finite(size, abs(quadrics[row, k]))
    for form in range(len(forms)):
        a, b, c = _sizes(forms, form)
        size = _larger_finite(_larger_finite(_larger_finite(size, math.sqrt(c / a)), b / a), c / b)
    return size
