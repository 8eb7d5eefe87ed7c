"""Scattering about a normal that a texture has bent, over a true surface of normal g in the frame of the bent one.

What a lobe sends to the wrong side of the true surface is mirrored on that (as by the second facet of Schüssler and
others, Microfacet-based normal mapping for robust Monte Carlo path tracing, 2017, if it were a mirror): so a surface
that absorbs nothing is as white in a furnace as without its bumps.
"""

from __future__ import annotations

from ..compiler.jit import helper, inline
from ..engine.numbers.vectors import dot
from ..shading.materials import Materials
from .albedo import Albedos
from .record import LOST, SHARP, SPREAD, STRAIGHT, Drawn, Touched, nothing
from .surface import draw, evaluate
from .warps import Direction

FLAT = (0.0, 0.0, 1.0)
"""Where nothing is bent."""


@inline
def _mirrored(i: Direction, g: Direction) -> Direction:
    twice = 2.0 * dot(i[0], i[1], i[2], g[0], g[1], g[2])
    return i[0] - twice * g[0], i[1] - twice * g[1], i[2] - twice * g[2]


@inline
def evaluate_over(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """`evaluate`, of what comes from i itself and of what is mirrored into it."""
    if g[2] == 1.0:
        return evaluate(materials, tables, at, o, i)
    return _evaluate_bent(materials, tables, at, o, i, g)


@helper
def _evaluate_bent(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """`evaluate_over` where something is bent."""
    above, other = dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0, _mirrored(i, g)
    r, g_, b, density = 0.0, 0.0, 0.0, 0.0
    if (i[2] > 0.0) == above:
        r, g_, b, density = evaluate(materials, tables, at, o, i)
    if (other[2] > 0.0) == above:
        sr, sg, sb, more = evaluate(materials, tables, at, o, other)
        r, g_, b, density = r + sr, g_ + sg, b + sb, density + more
    return r, g_, b, density


@inline
def draw_over(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, g: Direction, choice: float, u: float, v: float
) -> Drawn:
    """`draw`, on the right side of the true surface."""
    drawn = draw(materials, tables, at, o, choice, u, v)
    if g[2] == 1.0 or drawn.how == LOST or drawn.how == STRAIGHT:
        return drawn
    return _draw_bent(materials, tables, at, o, g, drawn)


@helper
def _draw_bent(materials: Materials, tables: Albedos, at: Touched, o: Direction, g: Direction, drawn: Drawn) -> Drawn:
    """`draw_over` where something is bent and a direction was drawn."""
    i = drawn.i
    if (i[2] > 0.0) != (dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0):
        i = _mirrored(i, g)
    if drawn.how == SHARP:
        return Drawn(SHARP, i, drawn.r, drawn.g, drawn.b, 0.0)
    r, green, b, density = evaluate_over(materials, tables, at, o, i, g)
    if not density > 0.0:
        return nothing()
    return Drawn(SPREAD, i, r / density, green / density, b / density, density)
