"""Bounds of what balls have in common with one another and with boxes along the axes, by a formula.

Within a box, the part of a ball that reaches farthest along an axis is over the point nearest to its center across that
axis: at sqrt(r² - d²), d being the distance across the axis from the center to the box. Each ball narrows the box that
is common to all, one after the other. What is not known to the last bit is rounded outward by far more than it may be
off. The same few operations serve one body and arrays of them, so both get the same floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .base import PrimitiveSolid, Solid
from .box import Box as BoxSolid
from .cells import Cell
from .ellipsoid import Ellipsoid
from .motion import Motion
from .sphere import Sphere
from .vector import FloatArray

Mask: TypeAlias = npt.NDArray[np.bool_]
ROUND = (Sphere, Ellipsoid)
"""Kinds whose outside no box bounds, if nothing cuts them."""
_SIMILAR = 2.0**-45
"""Rows of a motion that are orthogonal and of one length by this share are those of a similarity, or nearly."""
_OFF = 2.0**-42
"""What centers and radii that are read off boxes may be off by, as a share of places and sizes: much less in truth."""
_CLEAR = 2.0**-20
"""Balls that are reached by less than this share of their radius, squared, are left to other formulas."""


def bounds_nothing_outside(shape: Solid) -> bool:
    """Is the outside of a solid without a plane or a quadric that would bound it?"""
    if not isinstance(shape, PrimitiveSolid) or type(shape).outside_bounds_under is not Solid.outside_bounds_under:
        return False
    if isinstance(shape, (BoxSolid, *ROUND)):
        return True
    tree = shape.tree()
    return isinstance(tree, Cell) and len(tree.faces) > 1


def simple(kind: type, back: FloatArray) -> Mask:
    """Are solids of one kind still balls, or boxes along the axes?

    back: the linear parts (n, 3, 3) of the ways back to their own frames.
    """
    if issubclass(kind, BoxSolid):
        return np.asarray(((back != 0).sum(axis=2) == 1).all(axis=1))
    if not issubclass(kind, Sphere):
        return np.zeros(len(back), bool)
    x, y, z = back[:, 0], back[:, 1], back[:, 2]
    xx, yy, zz, xy, xz, yz = (_dot(a, b) for a, b in ((x, x), (y, y), (z, z), (x, y), (x, z), (y, z)))
    off = np.abs(np.stack([xx - yy, xx - zz, xy, xz, yz])).max(axis=0)
    return np.asarray(off <= _SIMILAR * xx)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]) + a[:, 2] * b[:, 2]
    return result


def within_balls(boxes: Sequence[FloatArray], balls: Sequence[bool]) -> tuple[FloatArray, Mask]:
    """(boxes (n, 6) around what parts have in common, for which bodies these are good), from boxes of the parts.

    balls: which of the parts are balls; the others are boxes.
    """
    low = np.max([box[:, :3] for box in boxes], axis=0)
    high = np.min([box[:, 3:] for box in boxes], axis=0)
    good = np.asarray(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1) & (low < high).all(axis=1))
    with np.errstate(all="ignore"):
        for box, is_ball in zip(boxes, balls, strict=True):
            if not is_ball:
                continue
            middle, half = (box[:, :3] + box[:, 3:]) / 2, ((box[:, 3:] - box[:, :3]) / 2).max(axis=1)
            off = _OFF * (half + np.abs(middle).max(axis=1))
            away = np.maximum(np.maximum(low - middle, middle - high), 0.0) ** 2
            square = half * half
            for axis in range(3):
                left = square - (away[:, axis - 1] + away[:, axis - 2])
                good &= np.asarray(left > _CLEAR * square)
                reach = np.sqrt(left + 8 * off * half) + off
                low[:, axis] = np.maximum(low[:, axis], middle[:, axis] - reach)
                high[:, axis] = np.minimum(high[:, axis], middle[:, axis] + reach)
        good &= np.asarray((low < high).all(axis=1))
    return np.concatenate([low, high], axis=1), good


def in_common(
    parts: Sequence[tuple[Solid, Motion, bool]], boxes: Sequence[tuple[FloatArray, FloatArray]]
) -> FloatArray | None:
    """The six ends of the box around what some parts have in common, from their boxes; None where that needs more.

    parts: each with its motion, and whether it is its inside that counts.
    """
    inside = [(solid, motion, box) for (solid, motion, inner), box in zip(parts, boxes, strict=True) if inner]
    if len(inside) < 2 or not all(inner or bounds_nothing_outside(solid) for solid, _, inner in parts):
        return None
    for solid, motion, _ in inside:
        if not isinstance(solid, (Sphere, BoxSolid)):
            return None
        back = np.array(solid.under(motion).inverse_rows)[None, :, :3]
        if not simple(type(solid), back)[0]:
            return None
    found, good = within_balls(
        [np.concatenate(box)[None] for *_, box in inside], [isinstance(solid, Sphere) for solid, *_ in inside]
    )
    return found[0] if good[0] else None
