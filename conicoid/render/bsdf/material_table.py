"""The table of materials that kernels read: a row for each distinct material, the row of each body, and colours.

`lower_materials` fills it.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline, record_shapes
from ...kernels import tables as table
from ...kernels.tables import Floats, Geometry, Ints, Signs, integer
from ..textures import TEXTURE_RECORD as TEXTURE, Texels

PLAIN, CHECKER_UV, CHECKER_SPACE, TEXTURED = 0, 1, 2, 3
"""Patterns of the diffuse colour."""
_DEPTH = 2.0**-20  # of a cube's side: how far under the surface a pattern in space is read

ROUGH_STEPS = 16
"""A material whose roughness is a texture has rows for the roughness 0, 1 / 256, 4 / 256, ... 1; light is shared
between two of them."""

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
"""kind: of surface, by its place in `registry.SURFACES`. even: 1 for one colour and Lambert's law alone. The others are
fields of `Material`, textures by their row or -1."""
AMOUNTS = "specular", "reflectivity", "transparency", "absorption", "emission", "scattering"
"""Columns that are fields of `Material`, one number or a colour, as linear rgb."""
NUMBERS = "ambient", "diffuse", "shininess", "fresnel", "coat", "anisotropy"
"""Columns that are fields of `Material`, one number or a flag."""


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
    """Row of each painted face, -1 for the other faces; empty if no face is painted."""
    opaque: Signs
    """For each body: 1 if it blocks light."""
    medium: Signs
    """For each body: 1 if it is a transparent solid, a medium that light may be inside of."""
    any_transparent: bool
    textures: Annotated[npt.NDArray[np.void], TEXTURE]
    texels: Texels
    """The texels of all pictures on surfaces."""
    pixel: Floats
    """The size of a pixel: at the camera, and its growth for each unit of length from there."""


@inline
def material_row(geometry: Geometry, materials: MaterialTable, body: int, face: int) -> int:
    """Return the row of a face's material: its own, or its body's."""
    if len(materials.face_row) > 0:
        row = integer(geometry, table.BODY_FACE, body) + face
        if 0 <= row < len(materials.face_row) and materials.face_row[row] >= 0:
            return materials.face_row[row]
    return materials.row_of[body]


# The checker pattern


@inline
def is_even(a: float, b: float, c: float) -> bool:
    """Return whether floor(a) + floor(b) + floor(c) is even."""
    return _is_even_cell(a) == (_is_even_cell(b) == _is_even_cell(c))


@inline
def _is_even_cell(x: float) -> bool:
    """Return whether floor(x) is even, computed on floats so that no size overflows."""
    half = 0.5 * np.floor(x)
    return half == np.floor(half)


@inline
def checker_color(material: Any, first: bool) -> tuple[float, float, float]:
    """Return one of the two colours of a material."""
    if first:
        return material.color[0], material.color[1], material.color[2]
    return material.second_color[0], material.second_color[1], material.second_color[2]


@inline
def color_on_uv(material: Any, u: float, v: float) -> tuple[float, float, float]:
    """Return the colour of a uv checker."""
    return checker_color(material, is_even(u / material.scale[0], v / material.scale[1], 0.0))


@inline
def color_in_space(
    material: Any, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> tuple[float, float, float]:
    """Return the colour of a checker in space just under the point of a surface with outward unit normal n.

    Just under it, so that rounding does not speckle a wall that lies on the border of two cubes.
    """
    a = x / material.scale[0] - _DEPTH * nx
    b = y / material.scale[1] - _DEPTH * ny
    c = z / material.scale[2] - _DEPTH * nz
    return checker_color(material, is_even(a, b, c))
