"""Boxes around bodies that are one another moved: they are let go once a scene is prepared, and made when asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...shapes.repeated import Repeated
from ..tables import Floats, Ints
from .apart import empty
from .away import Away
from .moved_rows import MovedRows, moved_boxes
from .pattern import BOX_NUMBERS, Group
from .rows import blocks


@dataclass(frozen=True)
class Around:
    """Of each group of bodies the box of the first, or those of all where they were lowered one by one."""

    bodies: Repeated
    groups: Sequence[tuple[Ints, Floats]]  # numbers of bodies, and (6,) or (bodies, 6)

    @classmethod
    def of(cls, bodies: Repeated, groups: Sequence[Group], boxes: Floats) -> Around:
        """Of bodies that are in these groups, whose boxes are known."""
        parts = []
        for group in groups:
            at, rows = group.pattern.box_at, group.rows
            known = rows.base[at : at + BOX_NUMBERS] if isinstance(rows, MovedRows) else boxes[group.bodies]
            parts.append((group.bodies, known))
        around = cls(bodies, parts)
        vars(around)["boxes"] = boxes
        return around

    @cached_property
    def boxes(self) -> Floats:
        """(bodies, 6) low, high: to the bit those that they had when the scene was lowered."""
        boxes = empty((len(self.bodies), BOX_NUMBERS), np.float64)
        for numbers, known in self.groups:
            if known.ndim > 1:
                boxes[numbers] = known
                continue
            away = Away.among(self.bodies, numbers)
            for some in blocks(len(numbers)):
                boxes[numbers[some]] = moved_boxes(known, away[some])
        return boxes

    def let_go(self) -> None:
        """Keep the boxes no longer."""
        vars(self).pop("boxes", None)
