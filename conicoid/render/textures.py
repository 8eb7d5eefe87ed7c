"""Textures in kernels: the table of records and texels, and the colour of a texture at a point of a surface.

Images are smoothed by pyramids: Williams, Pyramidal parametrics, SIGGRAPH 1983.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from .._jit.decorators import helper, inline
from ..kernels.body.uv import uv_at
from ..kernels.numbers.elementary import acos
from ..kernels.tables import Geometry
from ..materials.color import linear_rgb
from ..materials.image_file import Pixels
from ..materials.texture import (
    Along,
    Brick,
    Gradient,
    ImageTexture,
    Noise,
    TextureMapping,
    Wood,
    Wrap,
    mean_color,
    pair_sides,
)

# --- The table of textures, and the texels of images with their halves, quarters and so on

Texels: TypeAlias = npt.NDArray[np.float32]
REPEAT, CLAMP, MIRROR = range(3)


def halve_image(picture: Any) -> Any:
    """Return the image at half its size, rounded up: each pixel is the mean of the area that it covers."""
    for axis in range(2):
        count = picture.shape[axis]
        if count == 1:
            continue
        half = (count + 1) // 2
        edges = np.arange(half + 1) * (count / half)
        shape = [1, 1, 1]
        shape[axis] = half + 1
        sums = np.cumsum(picture, axis=axis, dtype=np.float64)
        sums = np.concatenate([np.zeros_like(sums.take([0], axis)), sums], axis=axis)
        low = np.minimum(edges.astype(int), count - 1)
        share = (edges - low).reshape(shape)
        at = sums.take(low, axis) * (1 - share) + sums.take(low + 1, axis) * share
        picture = np.diff(at, axis=axis) / (count / half)
    return picture


def build_pyramid(picture: Any) -> tuple[Any, int]:
    """Return (the texels (n, 3) float32 of all levels one after the other, the number of levels)."""
    levels = [picture]
    while max(levels[-1].shape[:2]) > 1:
        levels.append(halve_image(levels[-1]))
    return np.concatenate([np.asarray(level, np.float32).reshape(-1, 3) for level in levels]), len(levels)


@inline
def wrap_coordinate(i: int, count: int, wrap: int) -> int:
    """Return which of `count` texels in a row stands for texel i."""
    if wrap == REPEAT:
        return i % count
    if wrap == CLAMP:
        return max(0, min(count - 1, i))
    i %= 2 * count
    return i if i < count else 2 * count - 1 - i


@inline
def texel(
    texels: Texels, first: int, width: int, height: int, wraps: tuple[int, int], u: float, v: float
) -> tuple[float, float, float]:
    """Return the colour between the four texels about (u, v), of an image from (0, 0), its lower left, to (1, 1)."""
    x, y = u * width - 0.5, (1.0 - v) * height - 0.5
    left, top = np.floor(x), np.floor(y)
    a, b = x - left, y - top
    i0, i1 = wrap_coordinate(int(left), width, wraps[0]), wrap_coordinate(int(left) + 1, width, wraps[0])
    j0, j1 = wrap_coordinate(int(top), height, wraps[1]), wrap_coordinate(int(top) + 1, height, wraps[1])
    p, q, r, s = first + j0 * width + i0, first + j0 * width + i1, first + j1 * width + i0, first + j1 * width + i1
    w0, w1, w2, w3 = (1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b
    return (
        w0 * texels[p, 0] + w1 * texels[q, 0] + w2 * texels[r, 0] + w3 * texels[s, 0],
        w0 * texels[p, 1] + w1 * texels[q, 1] + w2 * texels[r, 1] + w3 * texels[s, 1],
        w0 * texels[p, 2] + w1 * texels[q, 2] + w2 * texels[r, 2] + w3 * texels[s, 2],
    )


@inline
def texel_of_size(
    texels: Texels, first: int, size: tuple[int, int, int], wraps: tuple[int, int], u: float, v: float, reach: float
) -> tuple[float, float, float]:
    """Return the colour about (u, v) of an image (width, height, levels), smoothed so that `reach` texels become one.

    Between two levels of the pyramid it is linear in their sizes.
    """
    width, height, levels = size
    if not (abs(u) < 1e9 and abs(v) < 1e9):
        return 0.0, 0.0, 0.0
    finer, finer_width, finer_height, level = first, width, height, 0
    while reach > 1.0 and level < levels - 1:
        finer, finer_width, finer_height = first, width, height
        first, width, height = first + width * height, (width + 1) // 2, (height + 1) // 2
        reach, level = 0.5 * reach, level + 1
    r, g, b = texel(texels, first, width, height, wraps, u, v)
    if level == 0 or reach >= 1.0:
        return r, g, b
    share = 2.0 * reach - 1.0
    fr, fg, fb = texel(texels, finer, finer_width, finer_height, wraps, u, v)
    return fr + share * (r - fr), fg + share * (g - fg), fb + share * (b - fb)


# Textures to records and texels

PLAIN, IMAGE, GRADIENT, NOISE, WOOD, BRICK = range(6)
UV, LATITUDE, BOX = range(3)
NO_TEXTURE = -1

TEXTURE_RECORD = np.dtype(
    [
        ("kind", "i8"),
        ("a", "f8", (3,)),
        ("b", "f8", (3,)),
        ("scale", "f8", (2,)),
        ("offset", "f8", (2,)),
        ("more", "f8", (2,)),  # gradient: axis; noise: octaves, contrast; wood: roughness; brick: joint, variation
        ("mapping", "i8"),
        ("first", "i8"),  # of an image: the first of its texels
        ("size", "i8", (3,)),  # width, height, levels
        ("wraps", "i8", (2,)),
        ("inner", "i8"),  # of bricks: the texture of `a`, or NO_TEXTURE
        ("outer", "i8"),  # and the texture of `b`
    ],
    align=True,
)


class TextureTable:
    """The textures of a scene: a row for each, and the texels of each image once."""

    def __init__(self) -> None:
        self._rows: dict[Any, int] = {}
        self._records: list[Any] = []
        self._pictures: dict[tuple[str, bool], tuple[int, int]] = {}
        self._texels: list[Any] = []
        self._count = 0

    def row(self, texture: Any) -> int:
        """Return the row of a texture, which is added if it is new; NO_TEXTURE for a colour or None."""
        if not isinstance(texture, ImageTexture | Gradient | Noise | Wood | Brick):
            return NO_TEXTURE
        if texture not in self._rows:
            record = np.zeros((), TEXTURE_RECORD)
            record["inner"] = record["outer"] = NO_TEXTURE
            self._fill(record, texture)
            self._rows[texture] = len(self._records)
            self._records.append(record)
        return self._rows[texture]

    def arrays(self) -> tuple[npt.NDArray[np.void], npt.NDArray[np.float32]]:
        """Return (records, texels (n, 3))."""
        texels = np.concatenate(self._texels) if self._texels else np.zeros((0, 3), np.float32)
        return np.array(self._records, TEXTURE_RECORD), np.ascontiguousarray(texels)

    def _fill(self, record: Any, texture: Any) -> None:
        """Fill the record of a texture."""
        if isinstance(texture, ImageTexture):
            record["kind"], record["mapping"] = IMAGE, get_args(TextureMapping).index(texture.mapping)
            record["scale"], record["offset"] = pair_sides(texture.scale), texture.offset
            wraps = [get_args(Wrap).index(wrap) for wrap in texture.wrap]
            record["wraps"] = wraps if texture.mapping != "latitude" else (wraps[0], get_args(Wrap).index("clamp"))
            pixels = texture.pixels
            first, levels = self._picture(pixels, texture.data)
            record["first"], record["size"] = first, (*pixels.size, levels)
        elif isinstance(texture, Gradient):
            record["kind"], record["a"], record["b"] = GRADIENT, linear_rgb(texture.a), linear_rgb(texture.b)
            record["scale"], record["offset"] = texture.length, texture.offset
            record["more"] = get_args(Along).index(texture.along), 0.0
        elif isinstance(texture, Noise):
            record["kind"], record["a"], record["b"] = NOISE, linear_rgb(texture.a), linear_rgb(texture.b)
            record["scale"], record["more"] = texture.scale, (texture.octaves, texture.contrast)
        elif isinstance(texture, Wood):
            record["kind"], record["a"], record["b"] = WOOD, linear_rgb(texture.early), linear_rgb(texture.late)
            record["scale"], record["offset"], record["more"] = texture.ring, texture.offset, (texture.roughness, 0.0)
        else:
            record["inner"], record["outer"] = self.row(texture.bricks), self.row(texture.mortar)
            record["kind"], record["a"], record["b"] = BRICK, mean_color(texture.bricks), mean_color(texture.mortar)
            record["scale"], record["more"] = texture.size, (texture.joint, texture.variation)
            record["mapping"] = get_args(TextureMapping).index(texture.mapping)

    def _picture(self, pixels: Pixels, is_data: bool) -> tuple[int, int]:
        """Return (the first texel, the number of levels) of an image; its pyramid stays with it for further scenes."""
        key = pixels.digest, is_data
        if key not in self._pictures:
            pyramids = vars(pixels).setdefault("_pyramids", {})
            if is_data not in pyramids:
                pyramids[is_data] = build_pyramid(pixels.linear(is_data))
            texels, levels = pyramids[is_data]
            self._pictures[key] = self._count, levels
            self._texels.append(texels)
            self._count += len(texels)
        return self._pictures[key]


# --- The colour of a texture at a point: images, gradients, noise, wood and bricks

# Gradient noise: Ken Perlin, Improving noise, SIGGRAPH 2002, with a hash in place of his table of permutations

_FAR = 2.0**40
"""Farther out floats have too few places left for noise, and it is 0."""


@inline
def hash_cell(x: int, y: int, z: int) -> np.uint64:
    """Return 64 bits for a point of the lattice: SplitMix64's output function, thrice (Steele, Lea and Flood 2014)."""
    h = np.uint64(0)
    for k in range(3):
        part = x if k == 0 else (y if k == 1 else z)
        h = (h ^ np.uint64(part)) + np.uint64(0x9E3779B97F4A7C15)
        h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        h ^= h >> np.uint64(31)
    return h


@inline
def fade(t: float) -> float:
    """Return 6t⁵ - 15t⁴ + 10t³, whose first two derivatives are 0 at 0 and 1."""
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@inline
def noise_slope(bits: np.uint64, x: float, y: float, z: float) -> float:
    """Return the dot product with one of twelve directions to the middles of a cube's edges; four stand twice."""
    h = bits & np.uint64(15)
    u = x if h < np.uint64(8) else y
    if h < np.uint64(4):
        v = y
    else:
        v = x if (h == np.uint64(12)) | (h == np.uint64(14)) else z
    return (u if h & np.uint64(1) == np.uint64(0) else -u) + (v if h & np.uint64(2) == np.uint64(0) else -v)


@helper
def noise(x: float, y: float, z: float) -> float:
    """Return gradient noise, between about -1 and 1; 0 where x, y and z are whole numbers."""
    if not max(abs(x), max(abs(y), abs(z))) < _FAR:
        return 0.0
    fx, fy, fz = np.floor(x), np.floor(y), np.floor(z)
    ix, iy, iz = int(fx), int(fy), int(fz)
    x, y, z = x - fx, y - fy, z - fz
    u, v, w = fade(x), fade(y), fade(z)
    total = 0.0
    for corner in range(8):
        i, j, k = corner & 1, (corner >> 1) & 1, corner >> 2
        weight = (u if i == 1 else 1.0 - u) * (v if j == 1 else 1.0 - v) * (w if k == 1 else 1.0 - w)
        total += weight * noise_slope(hash_cell(ix + i, iy + j, iz + k), x - i, y - j, z - k)
    return total


@helper
def turbulence(x: float, y: float, z: float, octaves: int) -> float:
    """Return octaves of noise over the sum of their strengths.

    Each octave is half as large and half as strong as the one before, and moved, so that their zeros do not coincide.
    """
    total, weight, weights = 0.0, 1.0, 0.0
    for _ in range(octaves):
        total += weight * noise(x, y, z)
        weights += weight
        x, y, z, weight = 2.0 * x + 17.0, 2.0 * y + 31.0, 2.0 * z + 47.0, 0.5 * weight
    return total / weights


# Textures

_UNEVEN = 0.35  # the width of the grain of wood, in rings
_AXIS_X, _AXIS_U, _AXIS_V = 2, 0, 1
_PER_WORD = 2.0**-32
_MOST_TAPS = 16.0
"""The most samples along an ellipse, which is taken for at most so many times as long as wide."""


class TexturePlace(NamedTuple):
    """A point of a surface with its unit normal; `reach` is the size of a pixel there, in the world."""

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
    """Return the latitude from 0 at the south pole to 1 at the north pole, for a height v: 1 - acos(2 v - 1) / π."""
    return 1.0 - acos(min(1.0, max(-1.0, 2.0 * v - 1.0))) / math.pi


@inline
def across_main_axis(nx: float, ny: float, nz: float, x: float, y: float, z: float) -> tuple[float, float]:
    """Return the coordinates along two axes of the world, across the one along which a normal is longest."""
    a, b, c = abs(nx), abs(ny), abs(nz)
    if c >= a and c >= b:
        return x, y
    return (x, z) if b >= a else (y, z)


@inline
def coordinates(
    geometry: Geometry, mapping: int, at: TexturePlace, x: float, y: float, z: float
) -> tuple[float, float]:
    """Return the two texture coordinates of a point on or near a place."""
    if mapping == BOX:
        return across_main_axis(at.nx, at.ny, at.nz, x, y, z)
    u, v = uv_at(geometry, at.body, at.face, at.surface, x, y, z)
    return u, latitude_of(v) if mapping == LATITUDE else v


@inline
def footprint(
    geometry: Geometry, texture: Any, at: TexturePlace, u: float, v: float
) -> tuple[float, float, float, float]:
    """Return (du, dv, long, short): a pixel covers an ellipse of an image, in texels, `long` along unit (du, dv).

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
def image_color(geometry: Geometry, texels: Texels, texture: Any, at: TexturePlace) -> tuple[float, float, float]:
    """Return the colour of an image: the mean of several samples along the long axis of the pixel's ellipse."""
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
def mix_colors(texture: Any, share: float) -> tuple[float, float, float]:
    """Return a colour between the two of a texture; the share is cut to [0, 1]."""
    s = min(1.0, max(0.0, share))
    return (
        texture.a[0] + s * (texture.b[0] - texture.a[0]),
        texture.a[1] + s * (texture.b[1] - texture.a[1]),
        texture.a[2] + s * (texture.b[2] - texture.a[2]),
    )


@helper
def gradient_share(geometry: Geometry, texture: Any, at: TexturePlace) -> float:
    """Return 0 where a gradient begins, 1 where it ends."""
    axis = int(texture.more[0])
    if axis < _AXIS_X:
        u, v = uv_at(geometry, at.body, at.face, at.surface, at.x, at.y, at.z)
        c = u if axis == _AXIS_U else v
    else:
        c = at.x if axis == _AXIS_X else (at.y if axis == _AXIS_X + 1 else at.z)
    return (c - texture.offset[0]) / texture.scale[0]


@helper
def wood_share(texture: Any, at: TexturePlace) -> float:
    """Return how late in a year wood grew: uneven rings, each slowly darker and then light at once."""
    ring, rough = texture.scale[0], texture.more[0]
    x, y, z = at.x - texture.offset[0], at.y - texture.offset[1], at.z
    size = 4.0 * ring
    r = math.sqrt(x * x + y * y) / ring + 2.0 * rough * turbulence(x / size, y / size, 0.15 * z / size, 3)
    late = r - np.floor(r)
    grain = turbulence(x / (_UNEVEN * ring), y / (_UNEVEN * ring), 0.05 * z / ring, 2)
    edge = min(1.0, (1.0 - late) * 12.0)  # softly back to light
    return late * late * late * edge + 0.12 * grain


@helper
def plain_color(geometry: Geometry, texels: Texels, texture: Any, at: TexturePlace) -> tuple[float, float, float]:
    """Return the colour of a texture that contains no other texture."""
    if texture.kind == IMAGE:
        return image_color(geometry, texels, texture, at)
    if texture.kind == GRADIENT:
        return mix_colors(texture, gradient_share(geometry, texture, at))
    if texture.kind == NOISE:
        s = texture.scale[0]
        n = turbulence(at.x / s, at.y / s, at.z / s, int(texture.more[0]))
        return mix_colors(texture, 0.5 + 0.5 * texture.more[1] * n)
    return mix_colors(texture, wood_share(texture, at))


@helper
def texture_color(
    geometry: Geometry, textures: Any, texels: Texels, number: int, at: TexturePlace
) -> tuple[float, float, float]:
    """Return the colour of a texture at a place, linear rgb."""
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
        part = float(hash_cell(int(brick), int(course), 0) >> np.uint64(32)) * _PER_WORD
        bright = 1.0 + texture.more[1] * (2.0 * part - 1.0)
        r, g, b = min(1.0, r * bright), min(1.0, g * bright), min(1.0, b * bright)
    return r, g, b
