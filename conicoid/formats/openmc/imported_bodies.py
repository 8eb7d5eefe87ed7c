"""The bodies of an imported geometry: pieces, each at all its places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Generic

import numpy as np
import numpy.typing as npt

from ...shapes.base import Solid
from ...shapes.motion import STILL, Motion
from ...shapes.repeated import Repeated, Shift
from .block import Block, CellPiece, Flat, P
from .context import Context
from .narrowing import Part, Side, moved
from .placement import ORIGIN, Placement
from .solids import SolidMaker
from .surfaces import FlatSurface, RoundSurface

RIGID = Fraction(1, 1 << 30)
"""The least thickness of what rounding cannot turn inside out, as a share of its distance from the origin."""


class PlacedBodies(Repeated, Generic[P]):
    """The bodies of a block, which are made from fractions when they are asked for, every number rounded once."""

    def __init__(self, whole: Block[P], pieces: list[P], flat: Flat) -> None:
        super().__init__(flat.pieces, flat.shifts, [piece.material for piece in pieces])
        self._whole, self._pieces = whole, pieces

    def name(self, number: int) -> str:
        """What the piece is called, and the way to it."""
        piece, path = self._whole.at(number)
        return self._whole.called(piece.title, path)

    def number(self, name: str) -> int | None:
        """The body of a name."""
        return self._whole.find(name)

    def outermost(self) -> Iterator[int]:
        """Of each piece the first body, and those that are moved the farthest along the axes."""
        ranks = [_ranks(values) for values in self.shifts.values]
        for numbers in self.members:
            found = {0}
            if len(numbers) > 1:
                for axis, order in enumerate(ranks):
                    here = order[self.shifts.index[axis, numbers]]
                    found |= {int(here.argmin()), int(here.argmax())}
            yield from sorted(int(numbers[at]) for at in found)

    @cached_property
    def farthest(self) -> Fraction:
        """The largest shift along an axis."""
        return max((abs(value) for values in self.shifts.values for value in values), default=Fraction(0))


def _ranks(values: Sequence[Fraction]) -> npt.NDArray[np.int64]:
    """The place of each of some values in their order."""
    found = np.empty(len(values), np.int64)
    found[sorted(range(len(values)), key=values.__getitem__)] = np.arange(len(values))
    return found


class ImportedBodies(PlacedBodies[CellPiece]):
    """Cells in their surroundings."""

    def __init__(self, whole: Block[CellPiece], pieces: list[CellPiece], flat: Flat) -> None:
        super().__init__(whole, pieces, flat)
        self._maker = SolidMaker()

    def made(self, kind: int, shift: Shift) -> Solid:
        """A piece moved by a shift."""
        return self._solid(self._pieces[kind].context, shift)

    def motion(self, kind: int) -> Motion:
        """What all parts of a piece are before; none where they are before several."""
        groups = self._pieces[kind].context.groups
        return groups[0][0] if len(groups) == 1 else STILL

    def before(self, kind: int, shift: Shift) -> Solid:
        """`Repeated.before`"""
        context = self._pieces[kind].context
        if len(context.groups) == 1:
            context = Context(((STILL, context.groups[0][1]),))
        return self._solid(context, shift)

    def _solid(self, context: Context, shift: Shift) -> Solid:
        """A context moved by a shift."""
        groups, maker = [(motion, group.parts) for motion, group in context.groups], self._maker
        if shift != ORIGIN:
            place, maker = Placement(shift=shift), SolidMaker()
            groups = [(motion, tuple(moved(part, place) for part in parts)) for motion, parts in groups]
        return maker.solid(groups)

    def is_rigid(self, kind: int) -> bool:
        """Is no part of a piece so thin that rounding may close it, at any of its places?

        And are normals of planes that slant floats, so that equal distances along them are equal planes?
        """
        context = self._pieces[kind].context
        if len(context.groups) > 1:
            return False
        far = self.farthest
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
        return min(least, default=Fraction(1)) > RIGID * far


def _sides(parts: tuple[Part, ...]) -> Iterator[Side]:
    """All sides of some parts."""
    for part in parts:
        if isinstance(part, Side):
            yield part
        else:
            yield from _sides(part.parts)
