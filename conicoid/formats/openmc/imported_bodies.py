"""The bodies of an imported geometry: pieces, each at all its places."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

import numpy as np

from ...shapes.base import Solid
from ...shapes.repeated import Repeated, Shift
from .block import Block, Flat, Piece, placed_name
from .narrowing import Part, Side
from .placement import ORIGIN
from .solids import SolidMaker
from .surfaces import FlatSurface, RoundSurface

_RIGID = Fraction(1, 1 << 30)
"""The least thickness of what rounding cannot turn inside out, as a share of its distance from the origin."""


class ImportedBodies(Repeated):
    """Made from fractions when they are asked for, so that every number is rounded once."""

    def __init__(self, whole: Block, pieces: list[Piece], flat: Flat) -> None:
        super().__init__(flat.pieces, flat.shifts, [piece.material for piece in pieces])
        self._whole, self._pieces, self._maker = whole, pieces, SolidMaker()

    def made(self, kind: int, shift: Shift) -> Solid:
        """A piece moved by a shift."""
        context, maker = self._pieces[kind].context, self._maker
        if shift != ORIGIN:
            context, maker = context.moved(shift), SolidMaker()
        return maker.solid((motion, group.parts) for motion, group in context.groups)

    def name(self, number: int) -> str:
        """The cell and the way to it."""
        piece, path = self._whole.at(number)
        return placed_name(piece.title, path)

    def number(self, name: str) -> int | None:
        """The body of a name."""
        return self._whole.find(name)

    def outermost(self) -> Iterator[int]:
        """Of each piece the first body, and those that are moved the farthest along the axes."""
        for numbers in self.members:
            index = self.shifts.index[:, numbers]
            found = {0}
            for axis, values in enumerate(self.shifts.values):
                order = np.argsort(np.argsort(np.array(values, object))) if len(values) > 1 else np.zeros(1, int)
                ranks = order[index[axis]]
                found |= {int(ranks.argmin()), int(ranks.argmax())}
            yield from sorted(int(numbers[at]) for at in found)

    def is_rigid(self, kind: int) -> bool:
        """Is no part of a piece so thin that rounding may close it, at any of its places?

        And are normals of planes that slant floats, so that equal distances along them are equal planes?
        """
        context = self._pieces[kind].context
        if not context.is_unmoved:
            return False
        far = max((abs(value) for values in self.shifts.values for value in values), default=Fraction(0))
        planes: dict[tuple[Fraction, ...], set[Fraction]] = {}
        least: list[Fraction] = []
        for _, group in context.groups:
            for side in _sides(group.parts):
                surface = side.surface
                if isinstance(surface, FlatSurface):
                    if surface.axis is None and any(Fraction(float(n)) != n for n in surface.normal):
                        return False
                    size = max(map(abs, surface.normal))
                    x, y, z = (n / size for n in surface.normal)
                    sign = 1 if (x, y, z) > ORIGIN else -1
                    planes.setdefault((sign * x, sign * y, sign * z), set()).add(sign * surface.offset / size)
                    far = max(far, abs(surface.offset / size))
                elif isinstance(surface, RoundSurface):
                    least.append(surface.radius)
                    far = max(far, *map(abs, surface.center))
        for offsets in planes.values():
            least += [high - low for low, high in pairwise(sorted(offsets))]
        return min(least, default=Fraction(1)) > _RIGID * far


def _sides(parts: tuple[Part, ...]) -> Iterator[Side]:
    """All sides of some parts."""
    for part in parts:
        if isinstance(part, Side):
            yield part
        else:
            yield from _sides(part.parts)
