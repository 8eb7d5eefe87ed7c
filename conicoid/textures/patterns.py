"""The colour of a texture at a point of a surface."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..compiler.jit import helper, inline
from ..engine.body.uv import uv_at
from ..engine.numbers.angles import acos
from ..engine.tables import Geometry
from .lower import BOX, BRICK, GRADIENT, IMAGE, LATITUDE, NOISE
from .noise import hashed, turbulence
from .texels import Texels, texel_of_size

_UNEVEN = 0.35  # how large the bumps of a trunk are, in rings, against its roughness
_AXIS_X, _AXIS_U, _AXIS_V = 2, 0, 1
_PER_WORD = 2.0**-32
_MOST_TAPS = 16.0
"""How many times as long as wide an ellipse is taken for, at most."""


class Place(NamedTuple):
    """A point of a surface; `reach` is how large a pixel is there, in the world."""

    body: Any
    face: Any
    surface: Any
    x: float
    y: float
    z: float
    nx: float
    ny: float
    nz: float
    reach: float


@inline
def latitude_of(v: float) -> float:
    """From 0 at the south pole to 1 at the north pole, for the height v of a point of a ball: 1 - acos(2 v - 1) / π."""
    return 1.0 - acos(min(1.0, max(-1.0, 2.0 * v - 1.0))) / math.pi


@inline
def across_main_axis(nx: float, ny: float, nz: float, x: float, y: float, z: float) -> tuple[float, float]:
    """Two axes of the world, across the one along which a normal is longest."""
    a, b, c = abs(nx), abs(ny), abs(nz)
    if c >= a and c >= b:
        return x, y
    return (x, z) if b >= a else (y, z)


@inline
def coordinates(geometry: Geometry, mapping: int, at: Place, x: float, y: float, z: float) -> tuple[float, float]:
    """The two coordinates that a texture is laid on, at a point on or near a place."""
    if mapping == BOX:
        return across_main_axis(at.nx, at.ny, at.nz, x, y, z)
    u, v = uv_at(geometry, at.body, at.face, at.surface, x, y, z)
    return u, latitude_of(v) if mapping == LATITUDE else v


@inline
def footprint(geometry: Geometry, texture: Any, at: Place, u: float, v: float) -> tuple[float, float, float, float]:
    """(du, dv, long, short): of a picture a pixel covers an ellipse, in texels, `long` along unit (du, dv).

    Its matrix is J Jᵗ for the texture's coordinates along two directions across the surface, one pixel long.
    """
    if not at.reach > 0.0:
        return 1.0, 0.0, 0.0, 0.0
    # The two directions (Duff and others, Building an orthonormal basis, revisited, 2017)
    sign = math.copysign(1.0, at.nz)
    a = -1.0 / (sign + at.nz)
    b = at.nx * at.ny * a
    uu, uv, vv, r = 0.0, 0.0, 0.0, at.reach
    for k in range(2):
        if k == 0:
            tx, ty, tz = 1.0 + sign * at.nx * at.nx * a, sign * b, -sign * at.nx
        else:
            tx, ty, tz = b, sign + at.ny * at.ny * a, -at.ny
        p, q = coordinates(geometry, texture.mapping, at, at.x + r * tx, at.y + r * ty, at.z + r * tz)
        du, dv = p - u, q - v
        if texture.mapping != BOX:
            du -= np.floor(du + 0.5)  # across the seam
        du, dv = du / texture.scale[0] * texture.size[0], dv / texture.scale[1] * texture.size[1]
        uu, uv, vv = uu + du * du, uv + du * dv, vv + dv * dv
    middle, half = 0.5 * (uu + vv), 0.5 * (uu - vv)
    root = math.sqrt(half * half + uv * uv)
    long, short = math.sqrt(middle + root), math.sqrt(max(0.0, middle - root))
    x, y = (half + root, uv) if half >= 0.0 else (uv, root - half)
    size = math.sqrt(x * x + y * y)
    if size == 0.0:
        return 1.0, 0.0, long, short
    return x / size, y / size, long, short


@helper
def image_color(geometry: Geometry, texels: Texels, texture: Any, at: Place) -> tuple[float, float, float]:
    """Of a picture, at the size at which it is seen: several texels along what is long of the pixel there."""
    u, v = coordinates(geometry, texture.mapping, at, at.x, at.y, at.z)
    du, dv, long, short = footprint(geometry, texture, at, u, v)
    size, wraps = (texture.size[0], texture.size[1], texture.size[2]), (texture.wraps[0], texture.wraps[1])
    u, v = (u - texture.offset[0]) / texture.scale[0], (v - texture.offset[1]) / texture.scale[1]
    taps = int(min(_MOST_TAPS, max(1.0, -np.floor(-long / max(short, 1.0)))))
    reach = max(short, long / taps)
    du, dv = du * long / texture.size[0], dv * long / texture.size[1]
    r, g, b = 0.0, 0.0, 0.0
    for k in range(taps):
        along = (k + 0.5) / taps - 0.5
        tr, tg, tb = texel_of_size(texels, texture.first, size, wraps, u + along * du, v + along * dv, reach)
        r, g, b = r + tr, g + tg, b + tb
    return r / taps, g / taps, b / taps


@inline
def mixed(texture: Any, share: float) -> tuple[float, float, float]:
    """Between the two colours of a texture."""
    s = min(1.0, max(0.0, share))
    return (
        texture.a[0] + s * (texture.b[0] - texture.a[0]),
        texture.a[1] + s * (texture.b[1] - texture.a[1]),
        texture.a[2] + s * (texture.b[2] - texture.a[2]),
    )


@helper
def gradient_share(geometry: Geometry, texture: Any, at: Place) -> float:
    """0 where a gradient begins, 1 where it ends."""
    axis = int(texture.more[0])
    if axis < _AXIS_X:
        u, v = uv_at(geometry, at.body, at.face, at.surface, at.x, at.y, at.z)
        c = u if axis == _AXIS_U else v
    else:
        c = at.x if axis == _AXIS_X else (at.y if axis == _AXIS_X + 1 else at.z)
    return (c - texture.offset[0]) / texture.scale[0]


@helper
def wood_share(texture: Any, at: Place) -> float:
    """How late in the year wood grew: rings, out of round, each slowly darker and then light at once."""
    ring, rough = texture.scale[0], texture.more[0]
    x, y, z = at.x - texture.offset[0], at.y - texture.offset[1], at.z
    size = 4.0 * ring
    r = math.sqrt(x * x + y * y) / ring + 2.0 * rough * turbulence(x / size, y / size, 0.15 * z / size, 3)
    late = r - np.floor(r)
    grain = turbulence(x / (_UNEVEN * ring), y / (_UNEVEN * ring), 0.05 * z / ring, 2)
    edge = min(1.0, (1.0 - late) * 12.0)  # softly back to light
    return late * late * late * edge + 0.12 * grain


@helper
def plain_color(geometry: Geometry, texels: Texels, texture: Any, at: Place) -> tuple[float, float, float]:
    """The colour of a texture that holds no other ones."""
    if texture.kind == IMAGE:
        return image_color(geometry, texels, texture, at)
    if texture.kind == GRADIENT:
        return mixed(texture, gradient_share(geometry, texture, at))
    if texture.kind == NOISE:
        s = texture.scale[0]
        n = turbulence(at.x / s, at.y / s, at.z / s, int(texture.more[0]))
        return mixed(texture, 0.5 + 0.5 * texture.more[1] * n)
    return mixed(texture, wood_share(texture, at))


@helper
def texture_color(
    geometry: Geometry, textures: Any, texels: Texels, number: int, at: Place
) -> tuple[float, float, float]:
    """The colour of a texture at a place."""
    texture = textures[number]
    if texture.kind != BRICK:
        return plain_color(geometry, texels, texture, at)
    u, v = coordinates(geometry, texture.mapping, at, at.x, at.y, at.z)
    length, height, joint = texture.scale[0], texture.scale[1], texture.more[0]
    if not (abs(u) < 1e9 * length and abs(v) < 1e9 * height):
        return texture.a[0], texture.a[1], texture.a[2]
    course = np.floor(v / height)
    along = u / length + 0.5 * (course - 2.0 * np.floor(0.5 * course))
    brick = np.floor(along)
    in_brick = (along - brick) * length >= joint and (v / height - course) * height >= joint
    inner = texture.inner if in_brick else texture.outer
    if inner >= 0:
        r, g, b = plain_color(geometry, texels, textures[inner], at)
    elif in_brick:
        r, g, b = texture.a[0], texture.a[1], texture.a[2]
    else:
        r, g, b = texture.b[0], texture.b[1], texture.b[2]
    if in_brick:
        part = float(hashed(int(brick), int(course), 0) >> np.uint64(32)) * _PER_WORD
        bright = 1.0 + texture.more[1] * (2.0 * part - 1.0)
        r, g, b = min(1.0, r * bright), min(1.0, g * bright), min(1.0, b * bright)
    return r, g, b
