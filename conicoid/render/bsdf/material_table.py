"""The checker pattern."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline, record_shapes
from ...kernels import tables as table
from ...kernels.tables import Floats, Geometry, Ints, Signs, integer
from ...materials.color import amount_rgb, linear_rgb
from ...materials.dispersion import render_cauchy_b, render_index
from ...materials.material import Material
from ...materials.texture import TEXTURES, Checker, mean_color, mean_grey
from ..textures.texture_table import TEXTURE_RECORD as TEXTURE
from ..textures.texture_table import Texels, TextureTable


@inline
def is_even(a: float, b: float, c: float) -> bool:
    """True where floor(a) + floor(b) + floor(c) is even."""
    return _is_even_cell(a) == (_is_even_cell(b) == _is_even_cell(c))


@inline
def _is_even_cell(x: float) -> bool:
    """Whether floor(x), as a float whatever its size, is even."""
    half = 0.5 * np.floor(x)
    return half == np.floor(half)


# Materials as records: one row per distinct material, and which row each body has.

PLAIN, CHECKER_UV, CHECKER_SPACE, TEXTURED = 0, 1, 2, 3
MATTE, GLOSSY, METAL, LAYERED = 0, 1, 2, 3
"""What surfaces do in light transport (`scattering`); solids that are transparent refract."""
_DEPTH = 2.0**-20  # of a cube's side: how far under the surface a pattern in space is read

ROUGH_STEPS = 16
"""Roughness by a texture has rows of its own for 0, 1 / 256, 4 / 256, ... 1: between two of them light is shared."""

MATERIAL_RECORD = np.dtype(
    [
        ("color", "f8", (3,)),
        ("second_color", "f8", (3,)),
        ("scale", "f8", (3,)),
        ("pattern", "i8"),
        ("texture", "i8"),
        ("ambient", "f8"),
        ("diffuse", "f8"),
        ("specular", "f8", (3,)),
        ("shininess", "f8"),
        ("half_vector", "i8"),
        ("reflectivity", "f8", (3,)),
        ("fresnel", "i8"),
        ("transparent", "i8"),
        ("transparency", "f8", (3,)),
        ("index", "f8"),
        ("absorption", "f8", (3,)),
        ("kind", "i8"),
        ("even", "i8"),
        ("emission", "f8", (3,)),
        ("roughness", "f8"),
        ("coat", "f8"),
        ("metal_index", "f8", (3,)),
        ("metal_extinction", "f8", (3,)),
        ("scattering", "f8", (3,)),
        ("scatters", "i8"),
        ("anisotropy", "f8"),
        ("dispersion", "f8"),
        ("rough_texture", "i8"),
        ("first_rough", "i8"),
        ("bump", "i8"),
        ("bump_height", "f8"),
        ("normal_map", "i8"),
    ],
    align=True,
)


@record_shapes(
    rows="*", row_of="body_face", face_row="*", opaque="body_face", medium="body_face", textures="*", texels="* 3",
    pixel="2",
)  # fmt: skip
class MaterialTable(NamedTuple):
    """Materials as kernels read them."""

    rows: Annotated[npt.NDArray[np.void], MATERIAL_RECORD]
    row_of: Ints
    """Row of each body."""
    face_row: Ints
    """Row of each face that is painted, -1 for the others; empty where none is."""
    opaque: Signs
    """For each body: 1 if it blocks light."""
    medium: Signs
    """For each body: 1 if it is a transparent solid, which light is inside of."""
    any_transparent: bool
    textures: Annotated[npt.NDArray[np.void], TEXTURE]
    texels: Texels
    """Of all pictures on surfaces."""
    pixel: Floats
    """How large a pixel is: at the camera, and how much more for each unit of the way from there."""


def lower_materials(
    materials: Sequence[Material], sheets: Sequence[bool], item_of: Ints, paints: Mapping[int, Material]
) -> MaterialTable:
    """Records for one material and one flag per entry of a scene.

    `item_of` is the entry of each body, `paints` the material of each row of a face that has its own.
    """
    known: dict[Material, int] = {}
    row_by_id: dict[int, int] = {}  # thousands of bodies have one material, and to compare all its fields takes long
    for material in materials:
        if id(material) not in row_by_id:
            row_by_id[id(material)] = known.setdefault(material, len(known))
    row_of = np.array([row_by_id[id(material)] for material in materials], dtype=np.int32)
    face_row = np.full(max(paints, default=-1) + 1, -1, dtype=np.int32)
    for face, material in paints.items():
        face_row[face] = known.setdefault(material, len(known))
    rows, textures = np.zeros(max(1, len(known)), dtype=MATERIAL_RECORD), TextureTable()
    for material, row in known.items():
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


def _with_steps(rows: Any) -> Any:
    """The rows, and behind them those of each step of the ones whose roughness is a texture's."""
    more: list[Any] = []
    for row in rows:
        if row["rough_texture"] >= 0:
            row["first_rough"] = len(rows) + (ROUGH_STEPS + 1) * len(more)
            steps = np.repeat(row[None], ROUGH_STEPS + 1)
            steps["roughness"] = (np.arange(ROUGH_STEPS + 1) / ROUGH_STEPS) ** 2
            more.append(steps)
    return np.concatenate([rows, *more]) if more else rows


def _relief(row: Any, material: Material, textures: TextureTable) -> None:
    """Roughness, bumps and normals by textures."""
    rough = material.roughness
    row["roughness"] = rough if isinstance(rough, float) else mean_grey(rough)
    patterns = dict(rough_texture=rough, bump=material.bump, normal_map=material.normal)
    for field, pattern in patterns.items():
        row[field] = textures.row(pattern)
    row["bump_height"] = material.bump_height


def _fill(row: Any, material: Material, textures: TextureTable) -> None:
    """The record of a material."""
    color = material.color
    if isinstance(color, Checker):
        row["color"], row["second_color"] = linear_rgb(color.a), linear_rgb(color.b)
        row["scale"] = color.scales
        row["pattern"] = CHECKER_SPACE if color.space else CHECKER_UV
    elif isinstance(color, TEXTURES):
        row["color"], row["pattern"], row["texture"] = mean_color(color), TEXTURED, textures.row(color)
    else:
        row["color"] = linear_rgb(color)
    for field in ("specular", "reflectivity", "transparency", "absorption"):
        row[field] = amount_rgb(getattr(material, field))
    row["ambient"], row["diffuse"], row["shininess"] = material.ambient, material.diffuse, material.shininess
    row["half_vector"], row["fresnel"] = material.highlight == "blinn_phong", material.fresnel
    for field in ("emission", "scattering"):
        row[field] = amount_rgb(getattr(material, field))
    _relief(row, material, textures)
    for field in ("coat", "anisotropy"):
        row[field] = getattr(material, field)
    row["index"] = render_index(material.refractive_index)
    row["dispersion"] = material.dispersion or render_cauchy_b(material.refractive_index)
    if material.metal_index is not None and material.metal_extinction is not None:
        row["metal_index"], row["metal_extinction"] = material.metal_index, material.metal_extinction
    row["scatters"], row["kind"] = bool((row["scattering"] > 0).any()), _kind(row)
    row["transparent"] = bool((row["transparency"] > 0).any())
    row["even"] = _has_even_roughness(row)


def _kind(row: Any) -> int:
    """What a surface does in light transport."""
    if (row["metal_index"] > 0).any():
        return METAL
    if (row["reflectivity"] > 0).any() or (row["transparency"] > 0).any() or row["coat"] > 1:
        return LAYERED
    return GLOSSY if (row["specular"] > 0).any() else MATTE


def _has_even_roughness(row: Any) -> bool:
    """Has a surface one colour and Lambert's law alone?"""
    textured = max(row["rough_texture"], row["bump"], row["normal_map"]) >= 0
    return bool(row["kind"] == MATTE and row["pattern"] == PLAIN and row["roughness"] == 0 and not textured)


@inline
def material_row(geometry: Geometry, materials: MaterialTable, body: int, face: int) -> int:
    """The row of a face's material: its own, or its body's."""
    if len(materials.face_row) > 0:
        row = integer(geometry, table.BODY_FACE, body) + face
        if 0 <= row < len(materials.face_row) and materials.face_row[row] >= 0:
            return materials.face_row[row]
    return materials.row_of[body]


@inline
def checker_color(material: Any, first: bool) -> tuple[float, float, float]:
    """One of the two colours of a material."""
    if first:
        return material.color[0], material.color[1], material.color[2]
    return material.second_color[0], material.second_color[1], material.second_color[2]


@inline
def color_on_uv(material: Any, u: float, v: float) -> tuple[float, float, float]:
    """Colour of a uv checker."""
    return checker_color(material, is_even(u / material.scale[0], v / material.scale[1], 0.0))


@inline
def color_in_space(
    material: Any, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> tuple[float, float, float]:
    """Colour of a checker in space just under the point of a surface with outward unit normal n."""
    a = x / material.scale[0] - _DEPTH * nx
    b = y / material.scale[1] - _DEPTH * ny
    c = z / material.scale[2] - _DEPTH * nz
    return checker_color(material, is_even(a, b, c))
