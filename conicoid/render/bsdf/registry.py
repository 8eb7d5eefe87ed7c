"""The registry of kinds of surface, the dispatch to them, and the lowering of materials to the tables of kernels.

Each entry of `SurfaceKind` becomes one compiled function. A material's row names its kind by its place here. These
functions compare that number with one place after the other, so compilers see an `if` for each kind and merge the
kinds' code into one function: no pointers, no tables.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import Vector
from ...kernels.tables import Ints
from ...materials.color import amount_rgb, linear_rgb
from ...materials.dispersion import render_cauchy_b, render_index
from ...materials.material import Material
from ...materials.texture import TEXTURES, Checker, mean_color, mean_grey
from ..sampling import Direction
from ..textures import TextureTable
from .albedo_tables import CHANNELS, MEANS, SMOOTH, STEPS, AlbedoTables, mean_of_table
from .bsdf_sample import (
    BsdfSample,
    DiffuseCosine,
    Evaluate,
    HasExtent,
    Highlight,
    LobeSurface,
    MirrorShare,
    Sample,
    SurfaceKind,
)
from .conductor import CONDUCTOR
from .diffuse import DIFFUSE, lambert_cosine
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


# Dispatch. `_composed` makes the functions of all kinds into one that asks them from the first to the last. It starts
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
