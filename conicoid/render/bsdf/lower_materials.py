"""Lower the materials of a scene to the tables that kernels read: rows of materials, and albedos of rough ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...kernels.tables import Ints
from ...materials.color import amount_rgb, linear_rgb
from ...materials.dispersion import render_cauchy_b, render_index
from ...materials.material import Material
from ...materials.texture import TEXTURES, Checker, mean_color, mean_grey
from ..textures.texture_table import TextureTable
from .albedo_tables import CHANNELS, MEANS, SMOOTH, STEPS, AlbedoTables, mean_of_table
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
from .registry import DIFFUSE_KIND, SURFACES, surface_kind


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
