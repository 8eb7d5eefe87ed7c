"""What a slice is coloured by: a colour for each body or material, and the legend."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..formats.srgb import srgb_bytes
from ..render.section import material_color
from ..shapes.labels import counted

if TYPE_CHECKING:
    from ..engine.prepared import Prepared

Bytes = npt.NDArray[np.uint8]
NOTHING = (255, 255, 255)
OVERLAPPING, UNDEFINED = (255, 0, 0), (255, 0, 255)
_MOST = 40
_LONGEST = 32
_GOLDEN = 0.6180339887498949
_NEAR = 12  # steps of a byte by which colours of materials must differ, in all channels together


@dataclass(frozen=True)
class Painted:
    """A colour for each pixel, and what the colours mean: (text, colour) from top to bottom."""

    pixels: Bytes
    legend: tuple[tuple[str, tuple[int, int, int]], ...]


def different(number: int) -> tuple[int, int, int]:
    """A colour for each number: hues far from those before, in three shades."""
    hue = (0.58 + number * _GOLDEN) % 1.0
    light, strong = ((0.62, 0.55), (0.75, 0.65), (0.5, 0.5))[number // 3 % 3]
    red, green, blue = (round(255 * c) for c in colorsys.hls_to_rgb(hue, light, strong))
    return red, green, blue


def painted(scene: Prepared, body: Any, column: Any, by: str) -> Painted:
    """The pixels of bodies, -1 for none, or of the columns of their materials."""
    ids = body if by == "body" else column
    shown = np.unique(ids[ids >= 0])
    colors = [different(int(k)) for k in shown] if by == "body" else _of_materials(scene, shown)
    table = np.array([*colors, NOTHING], np.uint8)
    pixels = table[np.where(ids < 0, len(shown), np.searchsorted(shown, ids))]
    named = body_name if by == "body" else material_name
    rows = [(named(scene, int(k)), color) for k, color in zip(shown[:_MOST], colors[:_MOST], strict=True)]
    if len(shown) > _MOST:
        rows.append((f"and {counted(len(shown) - _MOST, 'other', 'others')}", NOTHING))
    return Painted(pixels, tuple(rows))


def _of_materials(scene: Prepared, shown: Any) -> list[tuple[int, int, int]]:
    """Their own colours, as in sections; others where two of them would look the same."""
    materials = [material for material, _ in scene.labels.distinct]
    light = np.array([material_color(materials[int(k)]) for k in shown]).reshape(-1, 1, 3)
    own = srgb_bytes(light).reshape(-1, 3).astype(int)
    away = np.abs(own[:, None] - own[None]).sum(axis=2) + 1000 * np.eye(len(own), dtype=int)
    if len(own) and away.min() < _NEAR:
        return [different(int(k)) for k in shown]
    return [(int(r), int(g), int(b)) for r, g, b in own]


def _short(text: str) -> str:
    """A text in one line of the legend."""
    plain = " ".join(text.split())
    return plain if len(plain) <= _LONGEST else plain[: _LONGEST - 3] + "..."


def body_name(scene: Prepared, number: int) -> str:
    """What a body is called in a legend."""
    name = scene.labels.names_of(np.array([number]))[0]
    return f"body {number}" if name is None else _short(str(name))


def material_name(scene: Prepared, column: int) -> str:
    """What a material is called in a legend."""
    material = scene.labels.distinct[column][0]
    if material is None:
        return "no material"
    return f"material {column}" if material.name is None else _short(material.name)
