"""The walls near a point: certified bounds of signed distances, and a body's surfaces and leaves within a radius.

The bound of a plane or sphere is the distance itself, less rounding; of another quadric the distance of its nearest
point, by the secular equation for a value that rounding cannot have raised; of an intersection the largest signed bound
of its parts, of a union the least, of a complement the negative (Hart: Sphere tracing, The Visual Computer 12, 1996,
section 2.3): within a ball that meets none of the walls that were left out nothing else changes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from .. import tables as table
from ..body.scratch import Scratch, new_scratch
from ..faces import cell_side, plane_side
from ..programs import LeafBounds, cell_of_leaf, gates_of, leaf_bounds, leaf_high, leaf_low, leaves_of, rows_of_leaves
from ..surface.quadric import sign_everywhere
from ..surface.records import load_plane, load_quadric, load_sphere
from ..tables import CELL, PLANE, REGION, SHEET, SPHERE, Floats, Geometry, Ints, integer, length
from .form import (
    Axes,
    SurfaceForm,
    form_of_plane,
    form_of_quadric,
    form_of_sphere,
    length_of,
    parts_along,
    principal_axes,
    rounding_within,
)
from .secular import (
    NONE,
    STEPS,
    PositiveSecular,
    RootSearch,
    Secular,
    first_guess,
    least_bend,
    nearest_root,
    negate_secular,
    next_step,
    place_above,
    positive_secular,
    root_distance,
    safe_root,
    with_value,
)

LESS = 1.0 - 2.0**-44
"""Factor for the roundings of a bound itself."""
_CENTER = 1e-150
"""s so small that every s + a_i rounds to a_i, unless a_i is zero."""


class WallQuery(NamedTuple):
    """The query point, and the body and entry whose walls are searched."""

    x: float
    y: float
    z: float
    body: int
    entry: int


@inline
def secular_of(form: SurfaceForm, axes: Axes, scale: float, over: bool) -> Secular:
    """Return the secular equation of a quadric, or with `over` of -f, along its axes about a point."""
    g0, g1, g2 = parts_along(axes.along, form.gx * scale, form.gy * scale, form.gz * scale)
    value, a0, a1, a2 = form.value * scale, axes.a0 * scale, axes.a1 * scale, axes.a2 * scale
    # About the point itself
    equation = Secular(value, g0, g1, g2, a0, a1, a2, value, 0.0, 0.0, 0.0, g0, g1, g2)
    return negate_secular(equation) if over else equation


@inline
def plain_bound(form: SurfaceForm) -> float:
    """Return a lower bound of the distance to f = 0: |f| cannot change faster than 2 |g| d + |A| d²."""
    value = abs(form.value) - form.off
    if not value > 0.0:
        return 0.0
    g = length_of(form.gx, form.gy, form.gz)
    # The root of |A| d² + 2 |g| d = value, by the formula that does not cancel
    return value / (g + math.sqrt(g * g + form.size * value)) * LESS


@inline
def quadric_bound(form: SurfaceForm, plain: float) -> float:
    """Return the distance to the nearest point of a quadric, less the error bound; inf if it has no point."""
    axes = principal_axes(form.xx, form.yy, form.zz, form.xy, form.xz, form.yz)
    scale = 1.0 / form.size if form.size > 0.0 else 1.0
    e = positive_secular(form, axes, scale, plain)
    at = first_guess(e)
    for _ in range(STEPS):
        at = next_step(e, at)
        if at.done == 1.0:
            break
    # Once more for f less its error bound, which gives a valid lower bound
    value = less_rounding(form, e, at.w, scale)
    if value > 0.0 and at.done == 1.0:
        less, at = with_value(e, value), RootSearch(at.w, 0.0, math.inf, 0.0)
        for _ in range(STEPS):
            at = next_step(less, at)
            if at.done == 1.0:
                break
        w = safe_root(less, at.w)
        if at.done == 1.0 and w < math.inf:
            return max(plain, root_distance(less, w) * LESS)
    return bisection_bound(form, axes, scale, plain)


@inline
def less_rounding(form: SurfaceForm, e: PositiveSecular, w: float, scale: float) -> float:
    """Return f less its error bound up to the nearest point."""
    return e.value - 4.0 * rounding_within(form, root_distance(e, w)) * scale


@helper
def bisection_bound(form: SurfaceForm, axes: Axes, scale: float, plain: float) -> float:
    """`quadric_bound` by halving intervals, which always ends."""
    equation = least_bend(secular_of(form, axes, scale, form.value < 0.0), plain)
    first = _root_length(equation)
    if not first < math.inf:  # f is positive everywhere, or nearly zero at the center
        x, y, z = place_above(equation, _CENTER)
        first = length_of(x, y, z)
    value = equation.value - 4.0 * rounding_within(form, first) * scale
    if not value > 0.0:
        return plain
    _, g0, g1, g2, a0, a1, a2, _, x0, x1, x2, b0, b1, b2 = equation
    less = Secular(value, g0, g1, g2, a0, a1, a2, value, x0, x1, x2, b0, b1, b2)
    return max(plain, _root_length(less) * LESS)


@inline
def _root_length(equation: Secular) -> float:
    """Return |v| of the nearest root; inf for none."""
    w = nearest_root(equation)
    if w == NONE:
        return math.inf
    x, y, z = place_above(equation, w)
    return length_of(x, y, z)


@inline
def plane_bound(form: SurfaceForm) -> float:
    """Return a signed bound of the distance to a plane."""
    return math.copysign(max(0.0, (abs(form.value) - form.off) * LESS), form.value)


@inline
def sphere_bound(form: SurfaceForm, radius: float) -> float:
    """Return a signed bound of the distance to a sphere."""
    length = form.steep  # |g|
    # |x - c|² - r² = (|x - c| - r) (|x - c| + r)
    off = form.off / (length + radius)
    return math.copysign(max(0.0, (abs(length - radius) - off) * LESS), length - radius)


@helper
def surface_bound(geometry: Geometry, surface: int, x: float, y: float, z: float, enough: float) -> float:
    """Return a signed bound of the distance to a surface, positive where its value is; infinite for one without sides.

    From `enough` on it may be any valid bound, however far from the exact distance.
    """
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        return plane_bound(form_of_plane(load_plane(geometry, row), x, y, z))
    if kind == SPHERE:
        sphere = load_sphere(geometry, row)
        return sphere_bound(form_of_sphere(sphere, x, y, z), sphere.radius)
    quadric = load_quadric(geometry, row)
    one = sign_everywhere(quadric)
    if one != 0.0:
        return one * math.inf
    form = form_of_quadric(quadric, x, y, z)
    bound = plain_bound(form)
    if 0.0 < bound < enough:
        bound = quadric_bound(form, bound)
    return math.copysign(bound, form.value)


@inline
def cell_bound(geometry: Geometry, cell: int, x: float, y: float, z: float, enough: float) -> float:
    """Return a signed bound of the distance to the walls of a cell, negative inside."""
    quadric, bound = integer(geometry, table.CELL_QUADRIC, cell), -math.inf
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface, side = integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)
        bound = max(bound, side * surface_bound(geometry, surface, x, y, z, enough))
    if quadric >= 0 and bound < enough:
        side = cell_side(geometry, cell)
        bound = max(bound, side * surface_bound(geometry, quadric, x, y, z, enough))
    return bound


@inline
def distance_outside(low: float, high: float, first: float, last: float) -> float:
    """Return a lower bound of the distance of [first, last] from [low, high]."""
    return max(0.0, max(low - last, first - high)) * LESS


@inline
def leaf_box(geometry: Geometry, bounds: LeafBounds, number: int, x: float, y: float, z: float) -> float:
    """Return a lower bound of the distance to the box of a leaf of a program; numbers count from 0."""
    dx = distance_outside(leaf_low(geometry, bounds, number, 0), leaf_high(geometry, bounds, number, 0), x, x)
    dy = distance_outside(leaf_low(geometry, bounds, number, 1), leaf_high(geometry, bounds, number, 1), y, y)
    dz = distance_outside(leaf_low(geometry, bounds, number, 2), leaf_high(geometry, bounds, number, 2), z, z)
    return box_length(dx, dy, dz)


@inline
def box_length(dx: float, dy: float, dz: float) -> float:
    """Return the distance from a box, from the distances along three axes; infinite for an empty box."""
    if max(dx, max(dy, dz)) == math.inf:
        return math.inf
    return length_of(dx, dy, dz) * LESS


@helper
def program_bound(
    geometry: Geometry, gates: Floats, program: int, x: float, y: float, z: float, enough: float
) -> float:
    """Return a signed bound of the distance to the walls of a region.

    Unions take the least of their inputs, intersections the largest. `gates` is scratch memory with an element for each
    gate of the program.
    """
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        gates[gate - first] = math.inf if integer(geometry, table.GATE_NEED, gate) == 1 else -math.inf
    bounds, row = leaf_bounds(geometry, program), rows_of_leaves(geometry, program)
    begin, end = leaves_of(geometry, program)
    for leaf in range(begin, end):
        bound = leaf_box(geometry, bounds, leaf - begin, x, y, z)
        if bound < enough:
            cell = cell_of_leaf(geometry, leaf)
            inner = cell_bound(geometry, cell, x, y, z, enough)
            # Outside of its box, both bounds hold for the leaf; inside, the box says nothing of the walls
            bound = max(bound, inner) if bound > 0.0 else inner
        negated = integer(geometry, table.LEAF_NEGATED, leaf + row) == 1
        _feed(geometry, gates, first, integer(geometry, table.LEAF_GATE, leaf + row), -bound if negated else bound)
    for gate in range(last - 1, first, -1):  # children before their parents
        bound = gates[gate - first]
        negated = integer(geometry, table.GATE_NEGATED, gate) == 1
        _feed(geometry, gates, first, integer(geometry, table.GATE_PARENT, gate), -bound if negated else bound)
    return -gates[0] if integer(geometry, table.GATE_NEGATED, first) == 1 else gates[0]


@inline
def _feed(geometry: Geometry, gates: Floats, first: int, gate: int, bound: float) -> None:
    """Feed an input to a gate: unions keep the least, intersections the largest."""
    before = gates[gate - first]
    one = integer(geometry, table.GATE_NEED, gate) == 1
    gates[gate - first] = min(before, bound) if one else max(before, bound)


@helper
def entry_bound(geometry: Geometry, gates: Floats, entry: int, x: float, y: float, z: float, enough: float) -> float:
    """Return a lower bound of the distance to the walls of an entry, no polygon; from `enough` on any valid bound."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == CELL:
        return abs(cell_bound(geometry, index, x, y, z, enough))
    if kind == REGION:
        return abs(program_bound(geometry, gates, index, x, y, z, enough))
    if kind == SHEET:
        program = integer(geometry, table.SHEET_PROGRAM, index)
        # A sheet is where its surface is and its clip holds, so it is farther than either
        bound = abs(surface_bound(geometry, integer(geometry, table.SHEET_SURFACE, index), x, y, z, enough))
        if program >= 0 and bound < enough:
            bound = max(bound, program_bound(geometry, gates, program, x, y, z, enough))
        return bound
    return abs(surface_bound(geometry, index, x, y, z, enough))  # a ball


# The neighbourhood of a point: one body's surfaces and leaves within the search radius, and the best wall so far.
#
# `gather_cell` and `gather_program` collect the surfaces that come near and the leaves that they bound; these are all
# that may matter within the radius.

MOST_BOXES = 4096
"""Most boxes of space on the stack of a search."""
MOST_PAIRED = 32
"""Near surfaces with a flag for each pair in `hard`; pairs of further surfaces count as hard."""
BOX = 5
"""Numbers of a box: its middle, half of its side, a lower bound of the distance to it."""

UPPER, LOWER, AT_X, AT_Y, AT_Z, REACH, NEAREST, OF_BODY, TIP, IN_DOUBT = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
"""Elements of `Neighbourhood.best`: upper and lower bound of the nearest wall's distance; the point of the best proved
wall; the search radius; the distance of that point; the distance beyond which the current body has no walls; the error
bound of the point, as a candidate, if many surfaces pass through it, else infinity; a lower bound of the distance to
the point of `doubt`."""
MOST_IN_DOUBT = 8
"""Exact arithmetic decides which sides occur of at most so many surfaces through a point."""
BODY, ENTRY, PLACE, SENSE = 0, 1, 2, 3
"""Elements of `Neighbourhood.who`: the body, entry, place and sense of the best wall."""
SURFACES, LEAVES, LINKS, PROGRAM, SHEET_OF, WITHIN = 0, 1, 2, 3, 4, 5
"""Elements of `Neighbourhood.sizes`: numbers of near surfaces, of near leaves and of their links; the program or -1; 1
for a sheet; 1 + the polygon in which points must lie, or 0."""
LEAF, CELL_OF, FIRST_LINK, LINK_COUNT = 0, 1, 2, 3
"""Elements of `Neighbourhood.leaves`, four a leaf; the leaf is -1 if the body is a single cell."""


class Neighbourhood(NamedTuple):
    """The near surfaces and leaves of a body, against which walls.py tests candidate points; memory of one thread."""

    scratch: Scratch
    gates: Floats
    surface: Ints  # near surfaces by number, planes first; of a sheet its own surface is the first
    bound: Floats  # a lower bound of the distance to each
    sign: Ints  # at a candidate: -1, 1, or 0 where it lies on the surface or may do so
    leaves: Ints  # near leaves, see `LEAF`
    links: Ints  # (near surface, its inner side), of the leaves one after the other
    chosen: Ints  # of a candidate: the surfaces on which it lies, by their places in `surface`
    sizes: Ints  # see `SURFACES`
    hard: Ints  # (MOST_PAIRED²,) 1 where the curve of two near surfaces is in no plane
    best: Floats  # see `UPPER`
    who: Ints  # see `BODY`
    boxes: Floats  # a stack of boxes, see `BOX`
    doubt: Ints  # how many surfaces pass through the nearest point that may be a wall, and these
    known: Ints  # sets of surfaces: their number, that of sides that occur, `common_rank`, both, sides as bits; then 0


@allocator
def new_room(geometry: Geometry, known: Ints) -> Neighbourhood:
    """Return memory for one thread, sized for the largest body of the scene."""
    gates, leaves, links = geometry.places[table.GATES], 1, 8
    for program in range(length(geometry, table.PROGRAM_LEAF) - 1):
        first, last = leaves_of(geometry, program)
        leaves = max(leaves, last - first)
        here = 0
        for leaf in range(first, last):
            cell = cell_of_leaf(geometry, leaf)
            here += 2 + integer(geometry, table.CELL_FIRST, cell + 1) - integer(geometry, table.CELL_FIRST, cell)
        links = max(links, here)
    for cell in range(length(geometry, table.CELL_QUADRIC)):
        links = max(
            links, 2 + integer(geometry, table.CELL_FIRST, cell + 1) - integer(geometry, table.CELL_FIRST, cell)
        )
    return Neighbourhood(
        new_scratch(geometry),
        np.empty(gates),
        np.empty(links + 1, np.int32),
        np.empty(links + 1),
        np.empty(links + 1, np.int32),
        np.empty(4 * leaves, np.int32),
        np.empty(2 * links, np.int32),
        np.empty(links + 1, np.int32),
        np.zeros(8, np.int32),
        np.zeros(MOST_PAIRED * MOST_PAIRED, np.int32),
        np.empty(10),
        np.empty(4, np.int32),
        np.empty(BOX * MOST_BOXES),
        np.zeros(1 + MOST_IN_DOUBT, np.int32),
        known,
    )


@inline
def reset_nearest(room: Neighbourhood, reach: float) -> None:
    """Start a search for walls up to the distance `reach`."""
    room.best[UPPER], room.best[LOWER], room.best[REACH], room.best[NEAREST] = math.inf, math.inf, reach, math.inf
    room.best[OF_BODY], room.best[TIP], room.best[IN_DOUBT], room.doubt[0] = math.inf, math.inf, math.inf, 0
    room.best[AT_X], room.best[AT_Y], room.best[AT_Z] = math.nan, math.nan, math.nan
    room.who[BODY], room.who[ENTRY], room.who[PLACE], room.who[SENSE] = -1, -1, -1, 1


@inline
def limit(room: Neighbourhood) -> float:
    """Return the distance beyond which walls do not matter."""
    return min(min(room.best[UPPER], room.best[REACH]), room.best[OF_BODY])


# Gathering the surfaces of a body that come near, and the leaves that they bound


@inline
def _near(room: Neighbourhood, surface: int, bound: float) -> int:
    """Return the place of a surface among the near ones; append it if it is not there."""
    count = room.sizes[SURFACES]
    for k in range(count):
        if room.surface[k] == surface:
            return k
    room.surface[count], room.bound[count] = surface, bound
    room.sizes[SURFACES] = count + 1
    return count


@inline
def _link(geometry: Geometry, room: Neighbourhood, surface: int, inner: int, x: float, y: float, z: float) -> bool:
    """Link a leaf to one of its surfaces if that is near; False if the whole search ball is on its outer side."""
    bound = surface_bound(geometry, surface, x, y, z, limit(room)) * inner
    if abs(bound) > limit(room) or abs(bound) == math.inf:
        return bound < 0.0
    k = room.sizes[LINKS]
    room.links[2 * k], room.links[2 * k + 1] = _near(room, surface, abs(bound)), inner
    room.sizes[LINKS] = k + 1
    return True


@helper
def gather_cell(geometry: Geometry, room: Neighbourhood, leaf: int, cell: int, x: float, y: float, z: float) -> None:
    """Append a leaf to the near ones, unless the whole search ball is outside of it."""
    before, first, quadric = room.sizes[SURFACES], room.sizes[LINKS], integer(geometry, table.CELL_QUADRIC, cell)
    alive = True
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface, side = integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)
        alive = alive and _link(geometry, room, surface, side, x, y, z)
    if alive and quadric >= 0:
        alive = _link(geometry, room, quadric, cell_side(geometry, cell), x, y, z)
    if not alive:
        room.sizes[SURFACES], room.sizes[LINKS] = before, first
        return
    at = 4 * room.sizes[LEAVES]
    room.leaves[at + LEAF], room.leaves[at + CELL_OF] = leaf, cell
    room.leaves[at + FIRST_LINK], room.leaves[at + LINK_COUNT] = first, room.sizes[LINKS] - first
    room.sizes[LEAVES] += 1


@helper
def gather_program(geometry: Geometry, room: Neighbourhood, program: int, x: float, y: float, z: float) -> None:
    """Gather the near leaves of a region, or of the program that clips a sheet."""
    bounds, (first, end) = leaf_bounds(geometry, program), leaves_of(geometry, program)
    for leaf in range(first, end):
        if not leaf_box(geometry, bounds, leaf - first, x, y, z) > limit(room):
            gather_cell(geometry, room, leaf, cell_of_leaf(geometry, leaf), x, y, z)


@inline
def begin_body(room: Neighbourhood, program: int, sheet: int) -> None:
    """Start a body without near surfaces; the own surface of a sheet, if any, becomes the first."""
    room.sizes[SURFACES], room.sizes[LEAVES], room.sizes[LINKS], room.best[OF_BODY] = 0, 0, 0, math.inf
    room.sizes[PROGRAM], room.sizes[SHEET_OF], room.sizes[WITHIN] = program, (1 if sheet >= 0 else 0), 0
    if sheet >= 0:
        _near(room, sheet, 0.0)


@helper
def planes_first(geometry: Geometry, room: Neighbourhood) -> None:
    """Sort the near surfaces: the own one of a sheet, planes, others; within these groups the nearest first."""
    first = room.sizes[SHEET_OF]
    for i in range(first + 1, room.sizes[SURFACES]):
        j = i
        while j > first and _comes_before(geometry, room, j, j - 1):
            _swap(room, j, j - 1)
            j -= 1


@inline
def is_flat(geometry: Geometry, room: Neighbourhood, k: int) -> bool:
    """True if a near surface is a plane."""
    return integer(geometry, table.SURFACE_KIND, room.surface[k]) == PLANE


@inline
def _comes_before(geometry: Geometry, room: Neighbourhood, i: int, j: int) -> bool:
    flat, other = is_flat(geometry, room, i), is_flat(geometry, room, j)
    return (flat and not other) or (flat == other and room.bound[i] < room.bound[j])


@helper
def _swap(room: Neighbourhood, i: int, j: int) -> None:
    """Exchange two near surfaces, and update the links to them."""
    room.surface[i], room.surface[j] = room.surface[j], room.surface[i]
    room.bound[i], room.bound[j] = room.bound[j], room.bound[i]
    for k in range(room.sizes[LINKS]):
        if room.links[2 * k] == i:
            room.links[2 * k] = j
        elif room.links[2 * k] == j:
            room.links[2 * k] = i
