"""The end of a ray: the wall that it meets, and the point of that wall as an eye sees it."""

from __future__ import annotations

from typing import Any, NamedTuple

from .._jit.decorators import inline
from ..kernels.numbers.vectors import dot
from .bsdf.material_table import MaterialTable


class SurfaceInteraction(NamedTuple):
    """The first visible wall along a ray; body -1 if there is none."""

    t: float
    body: Any  # int64, as those that follow
    surface: Any
    face: Any
    side: Any
    before: Any  # the medium in front of it
    after: Any  # and behind it
    x: float
    y: float
    z: float
    nx: float  # outward
    ny: float
    nz: float


class ShadingPoint(NamedTuple):
    """A point of a surface as an eye sees it; both vectors are of unit length."""

    x: float
    y: float
    z: float
    nx: float  # the normal on the eye's side
    ny: float
    nz: float
    ex: float  # to the eye
    ey: float
    ez: float


@inline
def face_viewer(sight: SurfaceInteraction, dx: float, dy: float, dz: float) -> tuple[ShadingPoint, float, bool]:
    """Return (the point seen along unit d, the cosine of its normal and -d, whether the body is seen from inside)."""
    x, y, z, nx, ny, nz = sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz
    cosine = -dot(nx, ny, nz, dx, dy, dz)
    if cosine < 0.0:
        return ShadingPoint(x, y, z, -nx, -ny, -nz, -dx, -dy, -dz), -cosine, True
    return ShadingPoint(x, y, z, nx, ny, nz, -dx, -dy, -dz), cosine, False


@inline
def shows_light(materials: MaterialTable, sight: SurfaceInteraction, from_inside: bool) -> bool:
    """Return whether a surface shows the light of lights. The inner side of glass does not."""
    return not (from_inside and materials.medium[sight.body] == 1)
