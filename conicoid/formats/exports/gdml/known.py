"""Solids that GDML has elements of its own for, known again: what an importer makes of the element is the very solid.

A guess at the numbers, from decimals near them, is read as a file would be, and taken only where it gives the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import chain

from ....shapes.base import Solid
from ....shapes.half_space import HalfSpace
from ....shapes.motion import STILL
from ....shapes.polyhedron import Polyhedron
from ....shapes.region import Boolean, Difference, Intersection
from ....shapes.revolution import Revolution
from ....shapes.steps import Translate
from ....shapes.vector import Vector
from ...gdml.placement import Placement
from ...gdml.reading import LeftOut, Mistake, Reading
from ...gdml.solids import template_of
from ...openmc.xml_tree import Element
from ..numbers import decimal, word
from ..pieces import Leaf, Native
from .known_bowls import known_bowls

_LIKE = 1e-9
_GUESSED = (6, 9, 12, 15)
"""Digits after which numbers that came out of others are taken to end."""


def known_again(solid: Solid) -> Leaf | None:
    """A cutTube, or a polyhedra of one section, without the motion of the solid; None for any other."""
    plain = solid if solid.motion.is_identity else solid._moved(STILL)
    return _known(plain)


@lru_cache(256)
def _known(plain: Solid) -> Leaf | None:
    """The same for a solid without a motion; many bodies are one such solid moved."""
    guesses: Iterator[Native]
    if isinstance(plain, Intersection):
        guesses = chain(_cut_tubes(plain), known_bowls(plain))
    elif isinstance(plain, Difference):
        guesses = chain(_polyhedra(plain), known_bowls(plain))
    elif isinstance(plain, Polyhedron):
        guesses = _polyhedra(plain)
    else:
        return None
    for guess in guesses:
        if _read(guess) == plain:
            return Leaf(guess)
    return None


def _read(guess: Native) -> Solid | None:
    """What an importer makes of an element, at its place."""
    element = _element(guess.tag, guess.attributes)
    for child in guess.children.split("/>")[:-1]:
        tag, _, attributes = child[1:].partition(" ")
        element.children.append(_element(tag, attributes))
    try:
        return template_of(Reading(""), element, {}).at(Placement(shift=guess.shift))
    except (Mistake, LeftOut, ValueError):
        return None


def _element(tag: str, attributes: str) -> Element:
    pairs = (pair.split('="') for pair in attributes.split('" ') if pair.strip())
    return Element(tag, 0, 0, {name.strip(): value.rstrip('"') for name, value in pairs})


# ---- Tubes between slanted planes ----


def _cut_tubes(solid: Intersection) -> Iterator[Native]:
    """A tube of two radii and two half-spaces."""
    if len(solid.operands) != 3:
        return
    tube, low, high = solid.operands
    if not (isinstance(tube, Revolution) and isinstance(low, HalfSpace) and isinstance(high, HalfSpace)):
        return
    if low.motion.steps or high.motion.steps or len(tube.profile) != 4:
        return
    shift = tube.motion.steps[0].offset if tube.motion.steps else (0.0, 0.0, 0.0)  # type: ignore[union-attr]
    if tube.motion.steps and not (len(tube.motion.steps) == 1 and isinstance(tube.motion.steps[0], Translate)):
        return
    ends = []
    for side in (low, high):
        a, b, c = map(decimal, side.normal)
        if not c:
            return
        ends.append((decimal(side.offset) - a * decimal(shift[0]) - b * decimal(shift[1])) / c)
    (inner, _), (outer, _) = tube.profile[:2]
    size, middle = ends[1] - ends[0], (ends[0] + ends[1]) / 2
    width = decimal(tube.end_angle) - decimal(tube.start_angle)
    named = zip(("low", "high"), (low.normal, high.normal), strict=True)
    normals = "".join(
        f' {name}{axis}="{word(n)}"' for name, normal in named for axis, n in zip("XYZ", normal, strict=True)
    )
    text = f' rmin="{word(inner)}" rmax="{word(outer)}" z="{word(size)}" startphi="{word(tube.start_angle)}"'
    at = decimal(shift[0]), decimal(shift[1]), middle
    yield Native("cutTube", f'{text} deltaphi="{word(width)}"{normals} aunit="deg" lunit="mm"', "", at)


# ---- Sides about z ----


def _polyhedra(solid: Solid) -> Iterator[Native]:
    """A body of equal sides between two heights, with a bore or none."""
    parts = solid.operands if isinstance(solid, Boolean) else (solid,)
    if len(parts) > 2 or not all(isinstance(part, Polyhedron) for part in parts):
        return
    if len(parts) == 2 and any(part.motion.steps for part in parts):
        return
    body = parts[0]
    assert isinstance(body, Polyhedron)
    count = len(body.normals) - 2
    if count < 3 or body.normals[:2] != ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)):
        return
    if not _is_regular(body.normals[2:]):
        return
    z0, z1 = -decimal(body.offsets[0]), decimal(body.offsets[1])
    sides = []
    for part in parts:
        assert isinstance(part, Polyhedron)
        sides.append(list(zip(part.normals[2:], part.offsets[2:], strict=True)))
    shift = _axis_of(sides[0])
    step = 360.0 / count
    normal = body.normals[2]
    start = math.degrees(math.atan2(normal[1], normal[0])) - step / 2
    for digits in _GUESSED:
        axis = tuple(_near(value, digits) for value in shift)
        radii = []
        for (a, b, c), offset in (rows[0] for rows in sides):
            at = offset - a * float(axis[0]) - b * float(axis[1])
            radii.append([_near(at - c * float(z), digits) for z in (z0, z1)])
        radii.append([Fraction(0), Fraction(0)])
        middle = _near(_middle(parts[-1]), digits)
        for low, high in ((z0 - middle, z1 - middle), (_near(z0 - middle, digits), _near(z1 - middle, digits))):
            ends = "".join(
                f'<zplane z="{word(z)}" rmin="{word(radii[1][k])}" rmax="{word(radii[0][k])}"/>'
                for k, z in enumerate((low, high))
            )
            for angle in (start, start + 360.0):
                text = f' startphi="{word(_near(angle, digits))}" deltaphi="360" numsides="{count}"'
                yield Native("polyhedra", f'{text} aunit="deg" lunit="mm"', ends, (axis[0], axis[1], middle))


def _is_regular(normals: tuple[Vector, ...]) -> bool:
    """Do sides follow one another by equal angles, with equal slopes, about?"""
    c, s = math.cos(2 * math.pi / len(normals)), math.sin(2 * math.pi / len(normals))
    return all(
        max(abs(c * x - s * y - u), abs(s * x + c * y - v), abs(z - w), abs(math.hypot(x, y) - 1)) < _LIKE
        for (x, y, z), (u, v, w) in zip(normals, (*normals[1:], normals[0]), strict=True)
    )


def _middle(part: Solid) -> float:
    """Half-way between the ends: a bore goes equally far in both directions from where the element has its origin."""
    assert isinstance(part, Polyhedron)
    return float((decimal(part.offsets[1]) - decimal(part.offsets[0])) / 2)


def _axis_of(rows: list[tuple[tuple[float, float, float], float]]) -> tuple[float, float]:
    """Where the axis of equal sides is: the mean of the normals times their offsets, as these cancel around it."""
    x = 2 * sum(normal[0] * offset for normal, offset in rows) / len(rows)
    y = 2 * sum(normal[1] * offset for normal, offset in rows) / len(rows)
    return x, y


def _near(value: float | Fraction, digits: int) -> Fraction:
    """A short decimal near a float."""
    return Fraction(f"{round(float(value), digits):.{digits}f}")
