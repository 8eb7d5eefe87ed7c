"""Textures to records and texels."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from ..shapes.color import linear_rgb
from ..shapes.image_file import Pixels
from ..shapes.pattern_means import mean_color
from ..shapes.texture import (
    Along,
    Brick,
    Gradient,
    ImageTexture,
    Mapping,
    Noise,
    Wood,
    Wrap,
    pair,
)
from .texels import pyramid

PLAIN, IMAGE, GRADIENT, NOISE, WOOD, BRICK = range(6)
UV, LATITUDE, BOX = range(3)
NONE = -1

RECORD = np.dtype(
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
        ("inner", "i8"),  # of bricks: the texture of `a`, or NONE
        ("outer", "i8"),  # and that of `b`
    ],
    align=True,
)


class Table:
    """The textures of a scene: one row for each, the texels of each picture once."""

    def __init__(self) -> None:
        self._rows: dict[Any, int] = {}
        self._records: list[Any] = []
        self._pictures: dict[tuple[str, bool], tuple[int, int]] = {}
        self._texels: list[Any] = []
        self._count = 0

    def row(self, texture: Any) -> int:
        """The row of a texture, or NONE for a colour."""
        if not isinstance(texture, ImageTexture | Gradient | Noise | Wood | Brick):
            return NONE
        if texture not in self._rows:
            record = np.zeros((), RECORD)
            record["inner"] = record["outer"] = NONE
            self._fill(record, texture)
            self._rows[texture] = len(self._records)
            self._records.append(record)
        return self._rows[texture]

    def arrays(self) -> tuple[npt.NDArray[np.void], npt.NDArray[np.float32]]:
        """(records, texels)"""
        texels = np.concatenate(self._texels) if self._texels else np.zeros((0, 3), np.float32)
        return np.array(self._records, RECORD), np.ascontiguousarray(texels)

    def _fill(self, record: Any, texture: Any) -> None:
        if isinstance(texture, ImageTexture):
            record["kind"], record["mapping"] = IMAGE, get_args(Mapping).index(texture.mapping)
            record["scale"], record["offset"] = pair(texture.scale), texture.offset
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
            record["mapping"] = get_args(Mapping).index(texture.mapping)

    def _picture(self, pixels: Pixels, is_data: bool) -> tuple[int, int]:
        """(the first texel, the number of levels) of a picture."""
        key = pixels.digest, is_data
        if key not in self._pictures:
            kept = vars(pixels).setdefault("_pyramids", {})
            if is_data not in kept:
                kept[is_data] = pyramid(pixels.linear(is_data))
            texels, levels = kept[is_data]
            self._pictures[key] = self._count, levels
            self._texels.append(texels)
            self._count += len(texels)
        return self._pictures[key]
