"""Numbers by which surfaces that may be one lie side by side, for `surfaces`: one surface after the other.

A plane has four features, its unit normal and its offset about the middle of the scene; what is curved has the ten
coefficients about that, the largest of the second order being 1. Lengths are in a unit that fits the scene. The sign
is that by which the leading three, or six, lie before a direction. Where a surface lies in a direction through the
space of these features is its place there.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from ...compiler.jit import inline, kernel
from ..tables import SPHERE, Floats, Ints, Longs, Signs

Point: TypeAlias = tuple[float, float, float]
_Ten: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float]


@inline
def _turned(before: float, place: float) -> float:
    """A place of features whose sign is that of what leads."""
    return -place if before < 0.0 else place


@kernel(planes="p 7", rows="n", along="4", leading="3", places="out n")
def put_places_of_planes(
    planes: Floats, rows: Ints, middle: Point, unit: float, along: Floats, leading: Floats, places: Floats
) -> float:
    """Where planes lie in a direction; returns the largest offset, in the unit."""
    most = 0.0
    for i in range(len(rows)):
        row = rows[i]
        if not 0 <= row < len(planes):
            continue
        x, y, z = planes[row, 0], planes[row, 1], planes[row, 2]
        size = math.sqrt(x * x + y * y + z * z)
        p, q, r = planes[row, 4] - middle[0], planes[row, 5] - middle[1], planes[row, 6] - middle[2]
        offset = (p * x + q * y + r * z - planes[row, 3]) / size / unit
        x, y, z = x / size, y / size, z / size
        most = abs(offset) if abs(offset) > most else most
        place = x * along[0] + y * along[1] + z * along[2] + offset * along[3]
        places[i] = _turned(x * leading[0] + y * leading[1] + z * leading[2], place)
    return most


@inline
def _of_second_order(quadrics: Floats, row: int, i: int, j: int) -> float:
    """A coefficient of second order: the sum of s w w over the rows w of a quadric."""
    found = 0.0
    for k in range(3):
        found += quadrics[row, 12 + k] * quadrics[row, 3 + 3 * k + i] * quadrics[row, 3 + 3 * k + j]
    return found


@inline
def _of_quadric(quadrics: Floats, row: int, middle: Point) -> _Ten:
    """Coefficients of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point."""
    p, q, r = quadrics[row, 0] - middle[0], quadrics[row, 1] - middle[1], quadrics[row, 2] - middle[2]
    x = y = z = constant = 0.0
    for k in range(3):
        u, v, w = quadrics[row, 3 + 3 * k], quadrics[row, 4 + 3 * k], quadrics[row, 5 + 3 * k]
        square, linear, shift = quadrics[row, 12 + k], quadrics[row, 15 + k], -(u * p + v * q + w * r)
        slope = square * shift + linear
        x, y, z = x + u * slope, y + v * slope, z + w * slope
        constant += square * (shift * shift) + 2.0 * linear * shift
    return (
        _of_second_order(quadrics, row, 0, 0), _of_second_order(quadrics, row, 1, 1),
        _of_second_order(quadrics, row, 2, 2), _of_second_order(quadrics, row, 0, 1),
        _of_second_order(quadrics, row, 0, 2), _of_second_order(quadrics, row, 1, 2), x, y, z,
        constant - quadrics[row, 18],
    )  # fmt: skip


@inline
def _of_ball(spheres: Floats, row: int, middle: Point) -> _Ten:
    """`_of_quadric`"""
    p, q, r = spheres[row, 0] - middle[0], spheres[row, 1] - middle[1], spheres[row, 2] - middle[2]
    return 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -p, -q, -r, p * p + q * q + r * r - spheres[row, 3] * spheres[row, 3]


@inline
def _put_coefficients(
    kind: int, row: int, spheres: Floats, quadrics: Floats, middle: Point, found: Floats, at: int
) -> None:
    """The coefficients of what is curved, the largest of the second order 1; zeros where there is no such record."""
    numbers = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if kind == SPHERE:
        if 0 <= row < len(spheres):
            numbers = _of_ball(spheres, row, middle)
    elif 0 <= row < len(quadrics):
        numbers = _of_quadric(quadrics, row, middle)
    size = 0.0
    for k in range(10):
        found[at, k] = numbers[k]
        size = abs(numbers[k]) if k < 6 and abs(numbers[k]) > size else size
    size = size if size > 0.0 else 1.0
    for k in range(10):
        found[at, k] /= size


@kernel(kind="n", row="n", spheres="b 4", quadrics="q 19", found="out n 10")
def put_coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, found: Floats) -> None:
    """(n, 10) of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point, the largest of the first six 1."""
    for i in range(len(kind)):
        _put_coefficients(kind[i], row[i], spheres, quadrics, middle, found, i)


@kernel(
    kind="n", row="n", spheres="b 4", quadrics="q 19", along="10", leading="6", room="out 1 10", places="out n",
)  # fmt: skip
def put_places_of_curved(
    kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, unit: float, along: Floats,
    leading: Floats, room: Floats, places: Floats,
) -> float:  # fmt: skip
    """Where what is curved lies in a direction; returns the largest coefficient but those of second order, in lengths.

    room: for the coefficients of one.
    """
    most = 0.0
    for i in range(len(kind)):
        _put_coefficients(kind[i], row[i], spheres, quadrics, middle, room, 0)
        before = place = 0.0
        for k in range(6):
            before += room[0, k] * leading[k]
            place += room[0, k] * along[k]
        for k in range(6, 9):
            part = room[0, k] / unit
            most = abs(part) if abs(part) > most else most
            place += part * along[k]
        constant = room[0, 9] / unit / unit  # unit² may be beyond the floats
        length = math.sqrt(abs(constant))
        most = length if length > most else most
        places[i] = _turned(before, place + constant * along[9])
    return most


@kernel(planes="p 7", rows="n", axes="out n", places="out n")
def put_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats) -> None:
    """The axis that planes lie across, whose anchors lie on them, and where; -1 for others."""
    for i in range(len(rows)):
        axes[i], row = -1, rows[i]
        if not (0 <= row < len(planes) and planes[row, 3] == 0.0):
            continue
        for k in range(3):
            if planes[row, k] != 0.0 and planes[row, (k + 1) % 3] == 0.0 and planes[row, (k + 2) % 3] == 0.0:
                axes[i], places[i] = k, planes[row, 4 + k]


@inline
def _comes_before(planes: Floats, row: int, other: int) -> bool:
    """Does one record come before another, by the first number in which they differ?"""
    for k in range(7):
        if planes[row, k] != planes[other, k]:
            return planes[row, k] < planes[other, k]
    return False


@kernel(planes="p 7", rows="n", axes="n", places="n", order="n", first="out n")
def put_first_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats, order: Longs, first: Longs) -> None:
    """For each plane the one across the same axis at the same place whose record comes first: by their positions.

    order: of the places, rising. Of equal records the one with the least position comes first.
    """
    for i in range(len(rows)):
        first[i] = i
        if not (0 <= order[i] < len(rows) and 0 <= rows[i] < len(planes)):
            return
    begin = 0
    while begin < len(order):
        end = begin + 1
        while end < len(order) and places[order[end]] == places[order[begin]]:
            end += 1
        for axis in range(3 if end > begin + 1 else 0):
            best = -1
            for k in range(begin, end):
                i = order[k]
                if axes[i] == axis and (
                    best < 0 or _comes_before(planes, rows[i], rows[best])
                    or (i < best and not _comes_before(planes, rows[best], rows[i]))
                ):  # fmt: skip
                    best = i
            for k in range(begin, end):
                if axes[order[k]] == axis:
                    first[order[k]] = best
        begin = end
