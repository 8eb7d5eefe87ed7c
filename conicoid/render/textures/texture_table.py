"""The table of textures: records, and the texels of images with their halves, quarters and so on.

Williams, Pyramidal parametrics, SIGGRAPH 1983.
"""

from __future__ import annotations

from typing import Any, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline
from ...materials.color import linear_rgb
from ...materials.image_file import Pixels
from ...materials.texture import (
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
