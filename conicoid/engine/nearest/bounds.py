"""Certified bounds: signed distances never farther from zero than the truth, so that a ball of that size is clear.

Of a plane and a sphere the distance itself, less rounding. Of another quadric the nearest point of all, by its secular
equation for a value that rounding cannot have raised. Of an intersection the largest signed bound of its parts, of a
union the least, of a complement the negative (Hart: Sphere tracing, The Visual Computer 12, 1996, section 2.3): within
a ball that meets none of the walls that were left out nothing else changes.
"""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..tables import CELL, PLANE, REGION, SHEET, SPHERE, Floats, Geometry, integer, real
from .axes import principal_axes
from .form import Form, form_at, length_of, rounding_within
from .secular import NONE, Secular, least_bend, nearest_root, place_above, turned_over

_LESS = 1.0 - 2.0**-44
"""For the roundings of a bound itself."""
_CENTER = 1e-150
"""s at which all s + a_i that are not zero are a_i."""


@inline
def equation_of(form: Form) -> tuple[Secular, float, float, float, float, float, float, float, float, float]:
    """The secular equation of a quadric about a point, of terms of about 1, and the axes that its v are along."""
    axes = principal_axes(form.xx, form.yy, form.zz, form.xy, form.xz, form.yz)
    a0, a1, a2, x0, y0, z0, x1, y1, z1, x2, y2, z2 = axes
    scale = 1.0 / form.size if form.size > 0.0 else 1.0
    equation = Secular(
        form.value * scale, dot(x0, y0, z0, form.gx, form.gy, form.gz) * scale,
        dot(x1, y1, z1, form.gx, form.gy, form.gz) * scale, dot(x2, y2, z2, form.gx, form.gy, form.gz) * scale,
        a0 * scale, a1 * scale, a2 * scale,
    )  # fmt: skip
    return equation, x0, y0, z0, x1, y1, z1, x2, y2, z2


@inline
def plain_bound(form: Form) -> float:
    """A lower bound of the distance to f = 0: |f| cannot change faster than 2 |g| d + |A| d²."""
    value = abs(form.value) - form.off
    if not value > 0.0:
        return 0.0
    g = length_of(form.gx, form.gy, form.gz)
    return value / (g + math.sqrt(g * g + form.size * value)) * _LESS


@helper
def _solved_bound(form: Form, plain: float) -> float:
    """The distance to the nearest point of a quadric, less what rounding may have added; inf where there is none."""
    equation, _, _, _, _, _, _, _, _, _ = equation_of(form)
    if form.value < 0.0:
        equation = turned_over(equation)
    equation = least_bend(equation, plain)
    first = _root_length(equation)
    if not first < math.inf:  # all of f is positive, or nearly zero at the center
        x, y, z = place_above(equation, _CENTER)
        first = length_of(x, y, z)
    scale = 1.0 / form.size if form.size > 0.0 else 1.0
    value = equation.value - 4.0 * rounding_within(form, first) * scale
    if not value > 0.0:
        return plain
    less = Secular(value, equation.g0, equation.g1, equation.g2, equation.a0, equation.a1, equation.a2)
    return max(plain, _root_length(less) * _LESS)


@inline
def _root_length(equation: Secular) -> float:
    """|v| of the nearest root; inf for none."""
    w = nearest_root(equation)
    if w == NONE:
        return math.inf
    x, y, z = place_above(equation, w)
    return length_of(x, y, z)


@helper
def surface_bound(geometry: Geometry, surface: int, x: float, y: float, z: float, enough: float) -> float:
    """A signed bound of the distance to a surface, positive where its value is.

    From `enough` on it may be any that is proved, however far from the truth.
    """
    kind = integer(geometry, table.SURFACE_KIND, surface)
    form = form_at(geometry, surface, x, y, z)
    if kind == PLANE:
        return math.copysign(max(0.0, (abs(form.value) - form.off) * _LESS), form.value)
    if kind == SPHERE:
        length = length_of(form.gx, form.gy, form.gz)
        radius = real(geometry, table.SPHERES, 4 * integer(geometry, table.SURFACE_ROW, surface) + 3)
        off = form.off / (length + radius) if length + radius > 0.0 else 0.0
        return math.copysign(max(0.0, (abs(length - radius) - off) * _LESS), length - radius)
    bound = plain_bound(form)
    if 0.0 < bound < enough:
        bound = _solved_bound(form, bound)
    return math.copysign(bound, form.value)


@inline
def cell_bound(geometry: Geometry, cell: int, x: float, y: float, z: float, enough: float) -> float:
    """A signed bound of the distance to the walls of a cell, negative inside."""
    quadric, bound = integer(geometry, table.CELL_QUADRIC, cell), -math.inf
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface, side = integer(geometry, table.PLANE_SURFACE, slot), integer(geometry, table.PLANE_SIDE, slot)
        bound = max(bound, side * surface_bound(geometry, surface, x, y, z, enough))
    if quadric >= 0 and bound < enough:
        side = integer(geometry, table.CELL_SIDE, cell)
        bound = max(bound, side * surface_bound(geometry, quadric, x, y, z, enough))
    return bound


@inline
def outside_box(low: float, high: float, x: float) -> float:
    """How far x is outside of [low, high], a little less than that."""
    beyond = max(low - x, x - high)
    return beyond * _LESS if beyond > 0.0 else 0.0


@inline
def leaf_box(geometry: Geometry, leaf: int, x: float, y: float, z: float) -> float:
    """A lower bound of the distance to the box of a leaf of a program."""
    at = 6 * leaf
    dx = outside_box(real(geometry, table.LEAF_BOUNDS, at), real(geometry, table.LEAF_BOUNDS, at + 3), x)
    dy = outside_box(real(geometry, table.LEAF_BOUNDS, at + 1), real(geometry, table.LEAF_BOUNDS, at + 4), y)
    dz = outside_box(real(geometry, table.LEAF_BOUNDS, at + 2), real(geometry, table.LEAF_BOUNDS, at + 5), z)
    return box_length(dx, dy, dz)


@inline
def box_length(dx: float, dy: float, dz: float) -> float:
    """The length of what three coordinates are outside of a box; infinite where the box is empty."""
    if max(dx, max(dy, dz)) == math.inf:
        return math.inf
    return length_of(dx, dy, dz) * _LESS


@helper
def program_bound(
    geometry: Geometry, gates: Floats, program: int, x: float, y: float, z: float, enough: float
) -> float:
    """A signed bound of the distance to the walls of a region: its gates take the least or largest of their inputs."""
    first, last = integer(geometry, table.PROGRAM_GATE, program), integer(geometry, table.PROGRAM_GATE, program + 1)
    for gate in range(first, last):
        gates[gate - first] = math.inf if integer(geometry, table.GATE_NEED, gate) == 1 else -math.inf
    for leaf in range(
        integer(geometry, table.PROGRAM_LEAF, program), integer(geometry, table.PROGRAM_LEAF, program + 1)
    ):
        bound = leaf_box(geometry, leaf, x, y, z)
        if bound < enough:
            cell = integer(geometry, table.LEAF_CELL, leaf)
            inner = cell_bound(geometry, cell, x, y, z, enough)
            bound = max(bound, inner) if bound > 0.0 else inner
        negated = integer(geometry, table.LEAF_NEGATED, leaf) == 1
        _feed(geometry, gates, first, integer(geometry, table.LEAF_GATE, leaf), -bound if negated else bound)
    for gate in range(last - 1, first, -1):
        bound = gates[gate - first]
        negated = integer(geometry, table.GATE_NEGATED, gate) == 1
        _feed(geometry, gates, first, integer(geometry, table.GATE_PARENT, gate), -bound if negated else bound)
    return -gates[0] if integer(geometry, table.GATE_NEGATED, first) == 1 else gates[0]


@inline
def _feed(geometry: Geometry, gates: Floats, first: int, gate: int, bound: float) -> None:
    """An input of a gate: unions keep the least, intersections the largest."""
    before = gates[gate - first]
    one = integer(geometry, table.GATE_NEED, gate) == 1
    gates[gate - first] = min(before, bound) if one else max(before, bound)


@helper
def entry_bound(geometry: Geometry, gates: Floats, entry: int, x: float, y: float, z: float, enough: float) -> float:
    """A lower bound of the distance to the walls of an entry but a polygon; from `enough` on any that is proved."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == CELL:
        return abs(cell_bound(geometry, index, x, y, z, enough))
    if kind == REGION:
        return abs(program_bound(geometry, gates, index, x, y, z, enough))
    if kind == SHEET:
        program = integer(geometry, table.SHEET_PROGRAM, index)
        bound = abs(surface_bound(geometry, integer(geometry, table.SHEET_SURFACE, index), x, y, z, enough))
        if program >= 0 and bound < enough:
            bound = max(bound, program_bound(geometry, gates, program, x, y, z, enough))
        return bound
    return abs(surface_bound(geometry, index, x, y, z, enough))  # a ball
