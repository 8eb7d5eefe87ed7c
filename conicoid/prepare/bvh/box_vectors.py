"""A box as eight floats in one vector: -low xyz, a cost, high xyz, an item. One maximum then joins two boxes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._jit.decorators import inline, instructions
from ..._jit.machine_code import SHIPPED
from ...kernels.tables import Floats

if TYPE_CHECKING or SHIPPED is None:
    from .vector_code import clear, copy, exchange, join
else:
    clear, copy, exchange, join = map(instructions(__package__, "vector_code"), ("clear", "copy", "exchange", "join"))

SIZE = 8
NEGATED_LOW, COST, HIGH, ITEM = 0, 3, 4, 7


@inline
def half_area(boxes: Floats, at: int) -> float:
    """Return half the surface of the box at boxes[at:]."""
    x, y, z = boxes[at + 4] + boxes[at], boxes[at + 5] + boxes[at + 1], boxes[at + 6] + boxes[at + 2]
    return x * y + y * z + z * x


__all__ = ["COST", "HIGH", "ITEM", "NEGATED_LOW", "SIZE", "clear", "copy", "exchange", "half_area", "join"]
