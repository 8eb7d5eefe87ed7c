"""What is turned about z: tubes and cones where they are some, else a genericPolycone."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from ..numbers import decimal, word
from ..pieces import Turned
from .moves import Set, joined

if TYPE_CHECKING:
    from .solids import Said, Solids


def said(solids: Solids, piece: Turned) -> Said:
    """The solid, and where its middle is."""
    from .solids import Said

    angles, rounded = _angles(piece)
    corners = [(decimal(r), decimal(z)) for r, z in piece.profile]
    if len(corners) == 4:
        (a, low), (b, second), (d, high), (c, last) = corners
        if low == second < high == last and 0 <= a < b and c <= d and (c < d or a < b):
            size, middle = word(high - low), (low + high) / 2
            if (a, b) == (c, d):
                text, tag = f' rmin="{word(a)}" rmax="{word(b)}"', "tube"
            else:
                text = f' rmin1="{word(a)}" rmax1="{word(b)}" rmin2="{word(c)}" rmax2="{word(d)}"'
                tag = "cone"
            name = solids.add(tag, f'{text} z="{size}"{angles} lunit="mm"')
            return Said(name, joined([Set(shift=(Fraction(0), Fraction(0), middle))]), rounded)
    points = "".join(f'<rzpoint r="{word(r)}" z="{word(z)}"/>' for r, z in corners)
    return Said(solids.add("genericPolycone", f'{angles} lunit="mm"', points), (), rounded)


def _angles(piece: Turned) -> tuple[str, bool]:
    """Attributes, and whether readers get another end from start and width."""
    if piece.end - piece.start == 360:
        return ' startphi="0" deltaphi="360" aunit="deg"', False
    start, end = decimal(piece.start), decimal(piece.end)
    width = end - start
    tried = [width, Fraction(piece.end) - Fraction(piece.start), Fraction(piece.end - piece.start)]
    fits = [each for each in tried if float(Fraction(piece.start) + Fraction(float(each))) == piece.end]
    return f' startphi="{word(start)}" deltaphi="{word(fits[0] if fits else width)}" aunit="deg"', not fits
