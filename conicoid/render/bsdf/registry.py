"""The kinds of surface: their registry and dispatch, the BSDF of any surface, and the tables of materials.

Each entry of `SurfaceKind` becomes one compiled function. A material's row names its kind by its place here. These
functions compare that number with one place after the other, so compilers see an `if` for each kind and merge the
kinds' code into one function: no pointers, no tables.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..._jit.decorators import helper, inline
from ...kernels.numbers.vectors import Vector, dot
from ...kernels.tables import Ints
from ...materials.color import amount_rgb, linear_rgb
from ...materials.dispersion import render_cauchy_b, render_index
from ...materials.material import Material
from ...materials.texture import TEXTURES, Checker, mean_color, mean_grey
from ..sampling import Direction
from ..textures import TextureTable
from .albedo_tables import CHANNELS, MEANS, SMOOTH, STEPS, AlbedoTables, mean_of_table
from .bsdf_sample import (
    LOST,
    SHARP,
    SPREAD,
    STRAIGHT,
    BsdfSample,
    DiffuseCosine,
    Evaluate,
    HasExtent,
    Highlight,
    LobeSurface,
    MirrorShare,
    Sample,
    SurfaceKind,
    lost_sample,
)
from .conductor import CONDUCTOR
from .dielectric import evaluate_wall, sample_wall, wall_has_extent
from .diffuse import DIFFUSE, evaluate_lambert, is_lambert, lambert_cosine, sample_lambert
from .layered import LAYERED, opaque_reflectance
from .material_table import (
    AMOUNTS,
    CHECKER_SPACE,
    CHECKER_UV,
    MATERIAL_RECORD,
    NUMBERS,
    PLAIN,
    ROUGH_STEPS,
    TEXTURED,
    MaterialTable,
)
from .phong import PHONG, material_highlight

SURFACES: tuple[SurfaceKind, ...] = (
    CONDUCTOR,
    LAYERED,
    PHONG,
    DIFFUSE,
)
"""The kinds of surface. The first that claims a material has it; the last claims all."""

DIFFUSE_KIND = len(SURFACES) - 1
"""The number of the matte kind, which kernels test before all others: its formulas are merged into their callers."""


def surface_kind(row: Any) -> int:
    """Return the number of the kind of a filled row of the table of materials."""
    return next(number for number, kind in enumerate(SURFACES) if kind.is_kind(row))


# Dispatch. `_composed` makes the functions of all kinds into one that tries them from the first to the last. It starts
# with the last: each step closes over one kind's function and over the chain of those behind it.


def _composed(entry: str, step: Callable[[int, Any, Any], Any], default: Any = None) -> Any:
    """Return one compiled function for an entry of all kinds; the default is for those that leave it None."""
    chain = default
    for number, kind in reversed(tuple(enumerate(SURFACES))):
        own = getattr(kind, entry)
        if own is not None:
            chain = own if chain is None else step(number, own, chain)
    return chain


def _evaluate_step(number: int, own: Evaluate, others: Evaluate) -> Evaluate:
    @inline
    def evaluate(
        materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
    ) -> tuple[float, float, float, float]:
        if materials.rows[at.row].kind == number:
            return own(materials, tables, at, o, i)
        return others(materials, tables, at, o, i)

    return evaluate


def _sample_step(number: int, own: Sample, others: Sample) -> Sample:
    @inline
    def sample(
        materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
    ) -> BsdfSample:
        if materials.rows[at.row].kind == number:
            return own(materials, tables, at, o, choice, u, v)
        return others(materials, tables, at, o, choice, u, v)

    return sample


def _extent_step(number: int, own: HasExtent, others: HasExtent) -> HasExtent:
    @inline
    def has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
        if materials.rows[at.row].kind == number:
            return own(materials, at)
        return others(materials, at)

    return has_extent


def _cosine_step(number: int, own: DiffuseCosine, others: DiffuseCosine) -> DiffuseCosine:
    @inline
    def diffuse_cosine(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
        if row.kind == number:
            return own(row, light, eye, normal)
        return others(row, light, eye, normal)

    return diffuse_cosine


def _highlight_step(number: int, own: Highlight, others: Highlight) -> Highlight:
    @inline
    def highlight(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
        if row.kind == number:
            return own(row, light, eye, normal)
        return others(row, light, eye, normal)

    return highlight


def _mirror_step(number: int, own: MirrorShare, others: MirrorShare) -> MirrorShare:
    @inline
    def mirror_share(row: Any, cosine: float) -> tuple[float, float, float]:
        if row.kind == number:
            return own(row, cosine)
        return others(row, cosine)

    return mirror_share


evaluate_kind: Evaluate = _composed("evaluate", _evaluate_step)
sample_kind: Sample = _composed("sample", _sample_step)
kind_has_extent: HasExtent = _composed("has_extent", _extent_step)

# Whitted's part. Few kinds have a part of their own, and the chains hold only those: without one there is no `if`.
diffuse_cosine: DiffuseCosine = _composed("diffuse_cosine", _cosine_step, lambert_cosine)
kind_highlight: Highlight = _composed("highlight", _highlight_step, material_highlight)
mirror_share: MirrorShare = _composed("mirror_share", _mirror_step, opaque_reflectance)


# --- Materials to tables: rows of materials, and albedos of rough ones


def lower_materials(
    materials: Sequence[Material], sheets: Sequence[bool], item_of: Ints, paints: Mapping[int, Material]
) -> MaterialTable:
    """Return the table of the materials of a scene.

    Parameters
    ----------
    materials, sheets
        The material of each entry of the scene, and whether the entry is a sheet: sheets are no media.
    item_of
        The entry of each body.
    paints
        The material of each row of a face that has its own.

    """
    row_of_material: dict[Material, int] = {}
    row_by_id: dict[int, int] = {}  # thousands of bodies share a material, and comparing all its fields takes long
    for material in materials:
        if id(material) not in row_by_id:
            row_by_id[id(material)] = row_of_material.setdefault(material, len(row_of_material))
    row_of = np.array([row_by_id[id(material)] for material in materials], dtype=np.int32)
    face_row = np.full(max(paints, default=-1) + 1, -1, dtype=np.int32)
    for face, material in paints.items():
        face_row[face] = row_of_material.setdefault(material, len(row_of_material))
    rows, textures = np.zeros(max(1, len(row_of_material)), dtype=MATERIAL_RECORD), TextureTable()
    for material, row in row_of_material.items():
        _fill(rows[row], material, textures)
    rows = _with_steps(rows)
    transparent = rows["transparent"][row_of] != 0
    medium = transparent & ~np.array(sheets, dtype=bool)
    return MaterialTable(
        rows,
        row_of[item_of],
        face_row,
        (~transparent[item_of]).astype(np.int8),
        medium[item_of].astype(np.int8),
        bool(transparent.any()),
        *textures.arrays(),
        np.zeros(2),
    )


def _fill(row: Any, material: Material, textures: TextureTable) -> None:
    """Fill the row of a material."""
    color = material.color
    if isinstance(color, Checker):
        row["color"], row["second_color"] = linear_rgb(color.a), linear_rgb(color.b)
        row["scale"] = color.scales
        row["pattern"] = CHECKER_SPACE if color.space else CHECKER_UV
    elif isinstance(color, TEXTURES):
        row["color"], row["pattern"], row["texture"] = mean_color(color), TEXTURED, textures.row(color)
    else:
        row["color"] = linear_rgb(color)
    for field in AMOUNTS:
        row[field] = amount_rgb(getattr(material, field))
    for field in NUMBERS:
        row[field] = getattr(material, field)
    row["half_vector"] = material.highlight == "blinn_phong"
    _fill_relief(row, material, textures)
    row["index"] = render_index(material.refractive_index)
    row["dispersion"] = material.dispersion or render_cauchy_b(material.refractive_index)
    if material.metal_index is not None and material.metal_extinction is not None:
        row["metal_index"], row["metal_extinction"] = material.metal_index, material.metal_extinction
    row["scatters"], row["kind"] = bool((row["scattering"] > 0).any()), surface_kind(row)
    row["transparent"] = bool((row["transparency"] > 0).any())
    row["even"] = _is_even(row)


def _fill_relief(row: Any, material: Material, textures: TextureTable) -> None:
    """Fill roughness, bumps and normals, which textures may give."""
    rough = material.roughness
    row["roughness"] = rough if isinstance(rough, float) else mean_grey(rough)
    patterns = dict(rough_texture=rough, bump=material.bump, normal_map=material.normal)
    for field, pattern in patterns.items():
        row[field] = textures.row(pattern)
    row["bump_height"] = material.bump_height


def _is_even(row: Any) -> bool:
    """Return whether a surface has one colour and Lambert's law alone."""
    textured = max(row["rough_texture"], row["bump"], row["normal_map"]) >= 0
    return bool(row["kind"] == DIFFUSE_KIND and row["pattern"] == PLAIN and row["roughness"] == 0 and not textured)


def _with_steps(rows: Any) -> Any:
    """Return the rows, and behind them the steps of each row whose roughness is a texture."""
    more: list[Any] = []
    for row in rows:
        if row["rough_texture"] >= 0:
            row["first_rough"] = len(rows) + (ROUGH_STEPS + 1) * len(more)
            steps = np.repeat(row[None], ROUGH_STEPS + 1)
            steps["roughness"] = (np.arange(ROUGH_STEPS + 1) / ROUGH_STEPS) ** 2
            more.append(steps)
    return np.concatenate([rows, *more]) if more else rows


def lower_albedos(materials: MaterialTable) -> AlbedoTables:
    """Return the tables of the albedos of all rows, each filled by its kind of surface."""
    rows = materials.rows
    values, means = np.ones((len(rows), CHANNELS, STEPS)), np.ones((len(rows), MEANS))
    for k, row in enumerate(rows):
        SURFACES[row["kind"]].fill_albedos(row, values[k], means[k])
        if float(row["roughness"]) > SMOOTH:
            means[k, :3] = [mean_of_table(values[k, c]) for c in range(3)]
    return AlbedoTables(values.ravel(), means.ravel())


# The BSDF of any surface: f |cos| for two directions, and directions drawn by chance.
#
# A surface is a sum of lobes. `evaluate_lobes` adds up those with an extent; `sample_lobes` chooses a lobe and draws a
# direction from it, weighed by all lobes that could have given that direction. A lobe of a single direction (a mirror,
# smooth glass) is drawn with its own weight. Each kind of surface has its formulas in a module of its own;
# the dispatch to them is here: Lambert's law first, merged into the caller, all others behind one call.
#
# All is in the frame of a point: z is the normal on the side that light is followed from, and both directions, `o` back
# along the path and `i` on along it, point away from the surface.


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
