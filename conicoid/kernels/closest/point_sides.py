"""The sides of surfaces around a point, and whether the body is there: combinations of sides, and points beside it."""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..programs import hold_program, root_value, sense_of, turn_leaf
from ..surface.quadric import QuadricRecord
from ..surface.records import load_quadric
from ..tables import QUADRIC, Geometry, integer, whole
from .form import form_at, length_of
from .neighbourhood import (
    FIRST_LINK,
    LEAF,
    LEAVES,
    LINK_COUNT,
    PROGRAM,
    SHEET_OF,
    SURFACES,
    Neighbourhood,
)
from .projection import TANGENT


@inline
def is_leaf_on(room: Neighbourhood, k: int) -> bool:
    """True if a near leaf is on by room.sign; leaves are closed, so they contain their walls."""
    first, count = room.leaves[4 * k + FIRST_LINK], room.leaves[4 * k + LINK_COUNT]
    on = True
    for link in range(first, first + count):
        on = on and room.sign[room.links[2 * link]] * room.links[2 * link + 1] <= 0
    return on


@helper
def holds(geometry: Geometry, room: Neighbourhood) -> bool:
    """True if the body is there, or a sheet is not clipped, by room.sign; `scratch.counts` is unchanged on return."""
    program, leaves = room.sizes[PROGRAM], room.sizes[LEAVES]
    if program < 0:
        return room.sizes[SHEET_OF] == 1 or (leaves > 0 and is_leaf_on(room, 0))
    counts = room.scratch.counts
    hold_program(geometry, counts, whole(program))
    for k in range(leaves):
        if is_leaf_on(room, k):
            turn_leaf(geometry, counts, whole(program), whole(room.leaves[4 * k + LEAF]), True)
    value = root_value(geometry, counts, whole(program))
    for k in range(leaves):
        if is_leaf_on(room, k):
            turn_leaf(geometry, counts, whole(program), whole(room.leaves[4 * k + LEAF]), False)
    return value


@helper
def is_wholly(geometry: Geometry, room: Neighbourhood, value: bool) -> bool:
    """True if the body surely has one value all around a point, by room.sign: the leaves through it may all be either.

    This is three-valued logic: each leaf at whose border the point lies takes the worse of its two values.
    """
    program = whole(room.sizes[PROGRAM])
    if program < 0:
        return not value and not is_leaf_on(room, 0)
    counts, whole_value = room.scratch.counts, value
    hold_program(geometry, counts, program)
    for sweep in range(2):  # the first turns the leaves, the second undoes it
        for k in range(room.sizes[LEAVES]):
            leaf = whole(room.leaves[4 * k + LEAF])
            # Against `value`: a leaf of positive sense is off if the body is to be there, on if it is not to be
            worst = (sense_of(geometry, program, leaf) > 0) != value
            if is_leaf_on(room, k) and (worst or not _is_at_border(room, k)):
                turn_leaf(geometry, counts, program, leaf, sweep == 0)
        if sweep == 0:
            whole_value = root_value(geometry, counts, program)
    return whole_value == value


@inline
def _is_at_border(room: Neighbourhood, k: int) -> bool:
    """True if a near leaf has a surface on which the point lies by room.sign."""
    first, count = room.leaves[4 * k + FIRST_LINK], room.leaves[4 * k + LINK_COUNT]
    found = False
    for link in range(first, first + count):
        found = found or room.sign[room.links[2 * link]] == 0
    return found


@helper
def put_signs(geometry: Geometry, room: Neighbourhood, chosen: int, x: float, y: float, z: float, off: float) -> int:
    """Find the side of each near surface for a point with error bound `off`; return on how many it may lie.

    It lies on the first `chosen` of room.chosen; surfaces on which it may lie are appended to these.
    """
    count = chosen
    for k in range(room.sizes[SURFACES]):
        known = False
        for i in range(chosen):
            known = known or room.chosen[i] == k
        if known:
            room.sign[k] = 0
            continue
        form = form_at(geometry, room.surface[k], x, y, z)
        g = length_of(form.gx, form.gy, form.gz)
        # The value may change by 2 |g| off + |A| off² within the error of the point
        may = form.off + (2.0 * g + form.size * off) * off
        room.sign[k] = 0 if abs(form.value) <= may else (1 if form.value > 0.0 else -1)
        if room.sign[k] == 0:
            room.chosen[count] = k
            count += 1
    return count


@helper
def sides_around(geometry: Geometry, room: Neighbourhood, count: int) -> int:
    """Return a mask: bit k is `holds` for combination k of the sides of the first `count` of room.chosen."""
    values = whole(0)
    for sides in range(1 << count):
        for i in range(count):
            room.sign[room.chosen[i]] = 1 if (sides >> i) & 1 else -1
        if holds(geometry, room):
            values |= whole(1) << sides
    for i in range(count):
        room.sign[room.chosen[i]] = 0
    return values


@inline
def turning_sides(values: int, count: int, i: int) -> int:
    """Return a combination of `sides_around` in which the side of chosen surface i matters, -1 for none."""
    found = -1
    for sides in range(1 << count):
        if ((values >> sides) & 1) != ((values >> (sides ^ (1 << i))) & 1):
            found = sides
    return found


@inline
def put_sides(room: Neighbourhood, count: int, i: int, sides: int) -> None:
    """Write a combination of sides of the chosen surfaces to room.sign, 0 for chosen surface i itself."""
    for k in range(count):
        room.sign[room.chosen[k]] = 0 if k == i else (1 if (sides >> k) & 1 else -1)


@helper
def straddles_wall(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, step: float) -> bool:
    """True if some points about a step away are certainly inside and others certainly outside."""
    found = _sides_on_grid(geometry, room, x, y, z, step)
    found = _sides_between_surfaces(geometry, room, x, y, z, step, found)
    return _sides_about_axes(geometry, room, x, y, z, step, found) == 3


# Sides of points about a step away: the sum of 1 for a point inside, and 2 for one outside


@inline
def _sides_on_grid(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, step: float) -> int:
    """Return the sides of the 26 neighbours in a grid, a little off it: they do not lie on planes along the axes."""
    found = 0
    for k in range(26):
        i = k if k < 13 else k + 1
        dx, dy, dz = float(i % 3 - 1) + 0.03, float(i // 3 % 3 - 1) - 0.05, float(i // 9 - 1) + 0.07
        found |= _side_beside(geometry, room, x + step * dx, y + step * dy, z + step * dz)
    return found


@inline
def _sides_between_surfaces(
    geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, step: float, found: int
) -> int:
    """Add the sides of points between the half-planes of each two surfaces, ahead and back along their line.

    Thin wedges have no points of the grid.
    """
    for i in range(room.sizes[SURFACES]):
        ax, ay, az = _normal_through(geometry, room, i, x, y, z, step)
        for j in range(i if found != 3 and (ax != 0.0 or ay != 0.0 or az != 0.0) else 0):
            bx, by, bz = _normal_through(geometry, room, j, x, y, z, step)
            lx, ly, lz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            sine = length_of(lx, ly, lz)
            if sine < TANGENT:
                continue
            lx, ly, lz = lx / sine, ly / sine, lz / sine
            ux, uy, uz = ly * az - lz * ay, lz * ax - lx * az, lx * ay - ly * ax
            vx, vy, vz = ly * bz - lz * by, lz * bx - lx * bz, lx * by - ly * bx
            for k in range(8):
                p, q, r = 1.0 if k & 1 else -1.0, 1.0 if k & 2 else -1.0, 0.5 if k & 4 else -0.5
                dx, dy, dz = p * ux + q * vx + r * lx, p * uy + q * vy + r * ly, p * uz + q * vz + r * lz
                found |= _side_beside(geometry, room, x + step * dx, y + step * dy, z + step * dz)
    return found


@inline
def _sides_about_axes(
    geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, step: float, found: int
) -> int:
    """Add the sides of points about the axes of quadrics: needles have no others."""
    for i in range(room.sizes[SURFACES] if found != 3 else 0):
        if integer(geometry, table.SURFACE_KIND, room.surface[i]) == QUADRIC:
            quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, room.surface[i]))
            for k in range(24):
                ax, ay, az, square = row_of_quadric(quadric, k % 3)
                bx, by, bz, one = row_of_quadric(quadric, (k + 1) % 3)
                cx, cy, cz, two = row_of_quadric(quadric, (k + 2) % 3)
                h, u, v = step if k < 12 else -step, _narrow(square, one), _narrow(square, two)
                u, v = u if k // 3 & 1 else -u, v if k // 6 & 1 else -v
                dx, dy, dz = ax + u * bx + v * cx, ay + u * by + v * cy, az + u * bz + v * cz
                found |= _side_beside(geometry, room, x + h * dx, y + h * dy, z + h * dz)
    return found


@inline
def row_of_quadric(quadric: QuadricRecord, i: int) -> tuple[float, float, float, float]:
    """Return a row of a quadric, and its square."""
    if i == 0:
        return quadric.w00, quadric.w01, quadric.w02, quadric.s0
    if i == 1:
        return quadric.w10, quadric.w11, quadric.w12, quadric.s1
    return quadric.w20, quadric.w21, quadric.w22, quadric.s2


@inline
def _narrow(square: float, other: float) -> float:
    """Return a share of the slope of a cone about an axis, of 0.4 at most."""
    return 0.4 * math.sqrt(min(1.0, abs(square / other))) if other != 0.0 else 0.4


@inline
def _normal_through(
    geometry: Geometry, room: Neighbourhood, k: int, x: float, y: float, z: float, step: float
) -> tuple[float, float, float]:
    """Return the unit normal of a near surface that passes within a step of a point; zeros for another."""
    form = form_at(geometry, room.surface[k], x, y, z)
    g = length_of(form.gx, form.gy, form.gz)
    if not (g > 0.0 and abs(form.value) <= 2.0 * g * step):
        return 0.0, 0.0, 0.0
    return form.gx / g, form.gy / g, form.gz / g


@inline
def _side_beside(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float) -> int:
    """Return 1 if a point is certainly inside, 2 if it is certainly outside, else 0."""
    if put_signs(geometry, room, 0, x, y, z, 0.0) != 0:
        return 0
    return 1 if holds(geometry, room) else 2


@helper
def sheet_around(geometry: Geometry, room: Neighbourhood, count: int) -> bool:
    """True if a sheet exists at a point of its own surface, the first of room.chosen, for some sides of the others."""
    for sides in range(1 << (count - 1)):
        for i in range(1, count):
            room.sign[room.chosen[i]] = 1 if (sides >> (i - 1)) & 1 else -1
        if holds(geometry, room):
            return True
    return False
