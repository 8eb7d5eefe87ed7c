"""<divisionvol>: slices of the mother's solid along an axis, as Geant4 divides each kind (geometry/divisions)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from ..openmc.xml_tree import Element
from .placement import ORIGIN, STRAIGHT, Point, Rotation
from .reading import LeftOut, Mistake, local, shown_name
from .repeats import MOST, about_z, along, resized
from .structure import Daughter, Volume
from .units import PI
from .values import Values

if TYPE_CHECKING:
    from .structure import Structure

_AXES = {"kXAxis": "x", "kYAxis": "y", "kZAxis": "z", "kRho": "rho", "kPhi": "phi"}
_ROUNDED = Fraction(1, 10**9)
KINDS = ("box", "tube", "cone", "trd", "para", "polycone", "polyhedra")

Changes = dict[str, Fraction]


@dataclass(frozen=True)
class Slice:
    """What is changed of the mother's solid, in mm and radians; its sections in z, if it has such; where it stands."""

    changes: Changes
    shift: Point = ORIGIN
    rotation: Rotation = STRAIGHT
    sections: tuple[Point, ...] | None = None
    kind: str | None = None


def divisions(structure: Structure, volume: Volume, element: Element) -> None:
    """<divisionvol axis number width offset unit>: slices of the mother; they replace the solid of the volume."""
    reading, inner = structure.reading, structure.volume_in(element)
    axis = _AXES.get(element.attributes.get("axis", ""))
    if axis is None:
        raise Mistake(element, f"axis must be one of {', '.join(_AXES)}")
    source = volume.source
    if source is None or local(source) not in KINDS:
        raise LeftOut(f"divides what is no {', '.join(KINDS[:-1])} or {KINDS[-1]}")
    given = Values(reading, element)
    unit = reading.value(element.attributes.get("unit") or "mm", element, "unit")
    width, offset = given.number("width", 0) * unit, given.number("offset", 0) * unit
    count = given.integer("number", 0, MOST)
    mother = _Mother(structure, source)
    whole = mother.extent(axis)
    by_number = count > 0 and not width
    if not count:
        if width <= 0:
            raise Mistake(element, "number or width must be given")
        count = int((whole - offset) / width + _ROUNDED)
    width = width or (whole - offset) / count
    if width <= 0 or offset < 0 or not 0 < count <= MOST or offset + count * width > whole * (1 + _ROUNDED):
        raise Mistake(element, "number, width and offset must fit into the mother")
    base = shown_name(element.attributes.get("name", "") or inner.name)
    for k, part in enumerate(mother.slices(axis, width, offset, count, by_number)):
        made = resized(
            structure, element, inner, source, part.changes, kinds=KINDS, sections=part.sections, kind=part.kind
        )
        structure.add(volume, Daughter(base, made, part.shift, part.rotation, k))
    volume.is_filled = offset == 0 and count * width == whole


class _Mother:
    """The solid that is divided."""

    def __init__(self, structure: Structure, source: Element) -> None:
        self.values, self.kind = Values(structure.reading, source), local(source)
        self.sections: list[Point] = []
        for child in source.all("zplane"):
            part = Values(structure.reading, child, source)
            self.sections.append((part.length("z"), part.radius("rmin"), part.radius("rmax")))
        self.sections.sort(key=lambda section: section[0])
        if self.kind in ("polycone", "polyhedra") and len(self.sections) < 2:
            raise LeftOut("divides a solid without sections")

    def extent(self, axis: str) -> Fraction:
        """How much there is to be divided, in mm or radians. Raises LeftOut for an axis that the kind has not."""
        values, kind = self.values, self.kind
        if axis == "phi" and kind in ("tube", "cone", "polycone", "polyhedra"):
            return values.angle("deltaphi", 360) * PI / 180
        if axis == "rho" and kind == "tube":
            return values.length("rmax") - values.length("rmin", 0)
        if axis == "rho" and kind == "cone":
            return values.length("rmax1") - values.length("rmin1", 0)
        if self.sections and axis == "rho":
            return self.sections[0][2] - self.sections[0][1]
        if self.sections and axis == "z":
            return self.sections[-1][0] - self.sections[0][0]
        if axis in ("x", "y") and kind == "trd":
            return (values.length(f"{axis}1") + values.length(f"{axis}2")) / 2
        if axis in ("x", "y", "z") and (kind in ("box", "para") or (axis == "z" and not self.sections)):
            return values.length(axis)
        raise LeftOut(f"divides a {kind} along {axis}, which Geant4 does not either")

    def slices(self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool) -> Iterator[Slice]:
        """One after the other."""
        if axis == "phi":
            yield from self._about(width, offset, count)
        elif self.sections:
            yield from self._of_sections(axis, width, offset, count, by_number)
        else:
            for k in range(count):
                yield self._slice(axis, offset + k * width, offset + (k + 1) * width, k, count, offset)

    def _about(self, width: Fraction, offset: Fraction, count: int) -> Iterator[Slice]:
        start = self.values.angle("startphi", 0) * PI / 180
        changes = {"startphi": start, "deltaphi": width}
        if self.kind == "polyhedra":
            sides = self.values.integer("numsides", most=10_000)
            each = width / (self.extent("phi") / sides)
            if abs(each - round(each)) > _ROUNDED or round(each) < 1:
                raise LeftOut("divides a polyhedra across its sides, which Geant4 does not either")
            changes["numsides"] = Fraction(round(each))
        for k in range(count):
            yield Slice(changes, rotation=about_z(offset + k * width))

    def _slice(self, axis: str, low: Fraction, high: Fraction, k: int, count: int, offset: Fraction) -> Slice:
        values, middle = self.values, (low + high) / 2
        if self.kind == "tube" and axis == "rho":
            inner = values.length("rmin", 0)
            return Slice({"rmin": inner + low, "rmax": inner + high})
        if self.kind == "cone" and axis == "rho":
            first, second = values.length("rmin1", 0), values.length("rmin2", 0)
            wide = (values.length("rmax2") - second - offset) / count
            begin = second + offset + k * wide
            return Slice({"rmin1": first + low, "rmax1": first + high, "rmin2": begin, "rmax2": begin + wide})
        whole = self.extent(axis)
        shift = along(axis, middle - whole / 2)
        if self.kind == "para":
            return Slice({axis: high - low}, self._leaning(axis, middle - whole / 2))
        if axis == "z" and self.kind in ("cone", "trd"):
            return Slice(self._between(low / whole, high / whole) | {"z": high - low}, shift)
        if self.kind == "trd":
            return self._of_trd(axis, low, high, shift)
        return Slice({axis: high - low}, shift)

    def _leaning(self, axis: str, amount: Fraction) -> Point:
        """A shift along an axis of a parallelepiped."""
        from .flat_solids import lean_of, tangent

        if axis == "y":
            return amount * tangent(self.values.angle("alpha", 0)), amount, Fraction(0)
        if axis == "z":
            x, y = lean_of(self.values)
            return x * amount, y * amount, amount
        return along(axis, amount)

    def _between(self, low: Fraction, high: Fraction) -> Changes:
        """The sizes of both ends of a slice of what goes evenly with z, from shares of the height."""
        found: Changes = {}
        for name in ("rmin", "rmax") if self.kind == "cone" else ("x", "y"):
            ends = [self.values.length(f"{name}{end}", 0) for end in (1, 2)]
            for end, share in ((1, low), (2, high)):
                found[f"{name}{end}"] = ends[0] + (ends[1] - ends[0]) * share
        return found

    def _of_trd(self, axis: str, low: Fraction, high: Fraction, shift: Point) -> Slice:
        """Slices of one width; where the sides lean, they share both ends alike and lean with them."""
        a, b = self.values.length(f"{axis}1"), self.values.length(f"{axis}2")
        if a == b:
            return Slice({f"{axis}1": high - low, f"{axis}2": high - low}, shift)
        other = "y" if axis == "x" else "x"
        corners: Changes = {"dz": self.values.length("z") / 2}
        number = 1
        for size, end in ((a, 1), (b, 2)):
            ends = [size * (2 * each / (a + b) - Fraction(1, 2)) for each in (low, high)]
            wide = self.values.length(f"{other}{end}") / 2
            for first, second in ((ends[0], -wide), (ends[0], wide), (ends[1], wide), (ends[1], -wide)):
                x, y = (first, second) if axis == "x" else (second, first)
                corners |= {f"v{number}x": x, f"v{number}y": y}
                number += 1
        return Slice(corners, kind="arb8")

    def _of_sections(
        self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool
    ) -> Iterator[Slice]:
        sections = self.sections
        if axis == "z":
            begin, kinks = sections[0][0], [z for z, _, _ in sections]
            ends = [begin + offset + k * width for k in range(count + 1)]
            if by_number:  # of which there must be as many as sections, and are these
                if count != len(sections) - 1:
                    raise LeftOut(
                        f"has {count} slices of {len(sections) - 1} sections, which Geant4 does not divide either"
                    )
                ends = kinks
            for low, high in pairwise(ends):
                inside = [z for z in kinks if low < z < high]
                yield Slice({}, sections=tuple(self._at(z) for z in (low, *inside, high)))
            return
        for k in range(count):
            found = []
            for number, (z, inner, outer) in enumerate(sections):
                wide = width if number == 0 else (outer - inner - offset) / count
                found.append((z, inner + offset + k * wide, inner + offset + (k + 1) * wide))
            yield Slice({}, sections=tuple(found))

    def _at(self, z: Fraction) -> Point:
        """The section at a height."""
        for (z0, a, b), (z1, c, d) in pairwise(self.sections):
            if z0 <= z <= z1 and z0 < z1:
                share = (z - z0) / (z1 - z0)
                return z, a + (c - a) * share, b + (d - b) * share
        return self.sections[-1]
