"""The BSDF of any surface: f |cos| for two directions, and directions drawn by chance.

A surface is a sum of lobes. `evaluate_lobes` adds up those with an extent; `sample_lobes` chooses a lobe and draws a
direction from it, weighed by all lobes that could have given that direction. A lobe of a single direction (a mirror,
smooth glass) is drawn with its own weight. Each kind of surface has its formulas in a module of its own (`registry`);
the dispatch to them is here: Lambert's law first, merged into the caller, all others behind one call.

All is in the frame of a point: z is the normal on the side that light is followed from, and both directions, `o` back
along the path and `i` on along it, point away from the surface.
"""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from ...kernels.numbers.vectors import dot
from ..sampling import Direction
from .albedo_tables import AlbedoTables
from .bsdf_sample import LOST, SHARP, SPREAD, STRAIGHT, BsdfSample, LobeSurface, lost_sample
from .dielectric import evaluate_wall, sample_wall, wall_has_extent
from .diffuse import evaluate_lambert, is_lambert, sample_lambert
from .material_table import MaterialTable
from .registry import DIFFUSE_KIND, evaluate_kind, kind_has_extent, sample_kind


@inline
def _is_lambert(materials: MaterialTable, at: LobeSurface) -> bool:
    """Return whether a surface has Lambert's law alone."""
    row = materials.rows[at.row]
    return bool(row.kind == DIFFUSE_KIND and not at.refracts and is_lambert(row))


@inline
def evaluate_lobes(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """Return (r, g, b, density): f |cos| of light from i to o, and the density by which `sample_lobes` takes i.

    Lobes of a single direction count 0.
    """
    if _is_lambert(materials, at):
        return evaluate_lambert(at, o, i)
    return _evaluate_general(materials, tables, at, o, i)


@helper
def _evaluate_general(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """Return `evaluate_lobes` for all but Lambert's law."""
    if o[2] <= 0.0 or i[2] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if at.refracts:
        return evaluate_wall(materials, tables, at, o, i)
    return evaluate_kind(materials, tables, at, o, i)


@inline
def sample_lobes(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    """Return a direction for light to o; all three numbers are in [0, 1)."""
    if o[2] <= 0.0:
        return lost_sample()
    if _is_lambert(materials, at):
        return sample_lambert(at, u, v)
    return _sample_general(materials, tables, at, o, choice, u, v)


@helper
def _sample_general(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    """Return `sample_lobes` for all but Lambert's law."""
    if at.refracts:
        drawn = sample_wall(materials, tables, at, o, choice, u, v)
    else:
        drawn = sample_kind(materials, tables, at, o, choice, u, v)
    if drawn.how != SPREAD:
        return drawn
    r, g, b, density = _evaluate_general(materials, tables, at, o, drawn.i)
    if not density > 0.0:
        return lost_sample()
    return BsdfSample(SPREAD, drawn.i, r / density, g / density, b / density, density)


@inline
def has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    """Return whether a surface has lobes with an extent, which light from a lamp may fall into."""
    if at.refracts:
        return wall_has_extent(materials, at)
    return kind_has_extent(materials, at)


# Scattering about a normal that a texture has bent, over a true surface of normal g in the frame of the bent one.
#
# Light that a lobe sends to the wrong side of the true surface is mirrored on it (as by the second facet of Schüssler
# and others, Microfacet-based normal mapping for robust Monte Carlo path tracing, 2017, if it were a mirror): so a
# surface that absorbs nothing is as white in a furnace as without its bumps.

FLAT_NORMAL = (0.0, 0.0, 1.0)
"""The normal of the true surface in the frame of a point where no texture bends the normal."""


@inline
def _mirror_at_surface(i: Direction, g: Direction) -> Direction:
    """Return i mirrored on the plane across unit g."""
    twice = 2.0 * dot(i[0], i[1], i[2], g[0], g[1], g[2])
    return i[0] - twice * g[0], i[1] - twice * g[1], i[2] - twice * g[2]


@inline
def evaluate_bsdf(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """Return `evaluate_lobes` over the true surface: for light from i itself and for light mirrored into it."""
    if g[2] == 1.0:
        return evaluate_lobes(materials, tables, at, o, i)
    return _evaluate_about_normal(materials, tables, at, o, i, g)


@helper
def _evaluate_about_normal(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """Return `evaluate_bsdf` where a texture bends the normal."""
    above, other = dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0, _mirror_at_surface(i, g)
    r, g_, b, density = 0.0, 0.0, 0.0, 0.0
    if (i[2] > 0.0) == above:
        r, g_, b, density = evaluate_lobes(materials, tables, at, o, i)
    if (other[2] > 0.0) == above:
        sr, sg, sb, more = evaluate_lobes(materials, tables, at, o, other)
        r, g_, b, density = r + sr, g_ + sg, b + sb, density + more
    return r, g_, b, density


@inline
def sample_bsdf(
    materials: MaterialTable,
    tables: AlbedoTables,
    at: LobeSurface,
    o: Direction,
    g: Direction,
    choice: float,
    u: float,
    v: float,
) -> BsdfSample:
    """Return `sample_lobes` on the right side of the true surface."""
    drawn = sample_lobes(materials, tables, at, o, choice, u, v)
    if g[2] == 1.0 or drawn.how == LOST or drawn.how == STRAIGHT:
        return drawn
    return _sample_about_normal(materials, tables, at, o, g, drawn)


@helper
def _sample_about_normal(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, g: Direction, drawn: BsdfSample
) -> BsdfSample:
    """Return `sample_bsdf` of a drawn direction where a texture bends the normal."""
    i = drawn.i
    if (i[2] > 0.0) != (dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0):
        i = _mirror_at_surface(i, g)
    if drawn.how == SHARP:
        return BsdfSample(SHARP, i, drawn.r, drawn.g, drawn.b, 0.0)
    r, green, b, density = evaluate_bsdf(materials, tables, at, o, i, g)
    if not density > 0.0:
        return lost_sample()
    return BsdfSample(SPREAD, i, r / density, green / density, b / density, density)
