"""Divided solids: the slices of a mother's solid along an axis, as Geant4 divides each kind (geometry/divisions)."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from ..._util.records import dataclass
from ..importers import OmittedPart
from ..openmc.placement import ORIGIN, Point
from ..xml_tree import XmlElement
from .expressions import PI
from .values import GdmlReader, GdmlValues, local_tag

ROUNDING = Fraction(1, 10**9)
DIVISIBLE_KINDS = ("box", "tube", "cone", "trd", "para", "polycone", "polyhedra")

SolidChanges = dict[str, Fraction]
"""New values of attributes of a solid, in mm and radians."""


@dataclass(frozen=True)
class DivisionSlice:
    """One slice: changes of the mother's solid, its shift, its new zplane sections and its new kind, if any."""

    changes: SolidChanges
    shift: Point = ORIGIN
    sections: tuple[Point, ...] | None = None
    kind: str | None = None


def axis_shift(axis: str, amount: Fraction) -> Point:
    """Return a shift of `amount` mm along the axis x, y or z."""
    zero = Fraction(0)
    return (amount if axis == "x" else zero, amount if axis == "y" else zero, amount if axis == "z" else zero)


class DividedSolid:
    """The mother's solid, which divisions cut into slices; `sections` holds its zplane elements in rising z."""

    def __init__(self, reading: GdmlReader, source: XmlElement) -> None:
        self.values, self.kind = GdmlValues(reading, source), local_tag(source)
        self.sections: list[Point] = []
        for child in source.all("zplane"):
            part = GdmlValues(reading, child, source)
            self.sections.append((part.length("z"), part.radius("rmin"), part.radius("rmax")))
        # Sections may be listed from above; slices are counted from the lowest
        self.sections.sort(key=lambda section: section[0])
        if self.kind in ("polycone", "polyhedra") and len(self.sections) < 2:
            raise OmittedPart("divides a solid without sections")

    @property
    def reach(self) -> Fraction:
        """A length that all points are well within, from the z axis."""
        names = [name for name in ("x", "y", "z", "rmax1", "rmax2") if self.values.has(name)]
        return 1000 * sum((*map(self.values.length, names), *(outer for _, _, outer in self.sections)), Fraction(0))

    def leans(self, axis: str, by_number: bool) -> bool:
        """Return True if slices across an axis have corners of their own in walls of the mother that lean."""
        values = self.values
        if self.kind == "para":
            return axis != "x" and values.angle("theta" if axis == "z" else "alpha", 0) != 0
        if self.kind == "cone":
            ends = ((values.length(f"{name}1", 0), values.length(f"{name}2", 0)) for name in ("rmin", "rmax"))
            return axis == "z" and any(low != high for low, high in ends)
        return axis == "z" and bool(self.sections) and not by_number

    def extent(self, axis: str) -> Fraction:
        """Return the extent along an axis, in mm or radians. Raise OmittedPart if the kind has no such axis."""
        values, kind = self.values, self.kind
        if axis == "phi" and kind in ("tube", "cone", "polycone", "polyhedra"):
            return values.angle("deltaphi", 360) * PI / 180
        if axis == "rho" and kind == "tube":
            return values.length("rmax") - values.length("rmin", 0)
        if axis == "rho" and kind == "cone":
            return values.length("rmax1") - values.length("rmin1", 0)
        if self.sections and axis == "rho":
            # G4ParameterisationPolycone takes the radii of the first section for the width of a slice
            return self.sections[0][2] - self.sections[0][1]
        if self.sections and axis == "z":
            return self.sections[-1][0] - self.sections[0][0]
        if axis in ("x", "y") and kind == "trd":
            # G4ParameterisationTrd measures a leaning solid at half its height
            return (values.length(f"{axis}1") + values.length(f"{axis}2")) / 2
        if axis in ("x", "y", "z") and (kind in ("box", "para") or (axis == "z" and not self.sections)):
            return values.length(axis)
        raise OmittedPart(f"divides a {kind} along {axis}, which Geant4 does not either")

    def slices(
        self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool
    ) -> Iterator[DivisionSlice]:
        """Yield `count` slices of a width, from `offset` on, in mm or radians.

        `by_number`: the file states the number of slices only, and not their width.
        """
        if self.sections:
            yield from self._of_sections(axis, width, offset, count, by_number)
        else:
            for k in range(count):
                yield self._slice(axis, offset + k * width, offset + (k + 1) * width, k, count, offset)

    def wedge(self, width: Fraction) -> SolidChanges:
        """Return the changes for the first slice about z. Raise OmittedPart for a polyhedra cut within its sides."""
        start = self.values.angle("startphi", 0) * PI / 180
        changes = {"startphi": start, "deltaphi": width}
        if self.kind == "polyhedra":
            sides = self.values.integer("numsides", most=10_000)
            each = width / (self.extent("phi") / sides)
            if abs(each - round(each)) > ROUNDING or round(each) < 1:
                raise OmittedPart("divides a polyhedra across its sides, which Geant4 does not either")
            changes["numsides"] = Fraction(round(each))
        return changes

    def _slice(self, axis: str, low: Fraction, high: Fraction, k: int, count: int, offset: Fraction) -> DivisionSlice:
        """Return slice number k of a solid without sections, from `low` to `high` along an axis."""
        values, middle = self.values, (low + high) / 2
        if self.kind == "tube" and axis == "rho":
            inner = values.length("rmin", 0)
            return DivisionSlice({"rmin": inner + low, "rmax": inner + high})
        if self.kind == "cone" and axis == "rho":
            first, second = values.length("rmin1", 0), values.length("rmin2", 0)
            # The width is that of the lower end; at the upper end Geant4 divides by the number of slices
            wide = (values.length("rmax2") - second - offset) / count
            begin = second + offset + k * wide
            return DivisionSlice({"rmin1": first + low, "rmax1": first + high, "rmin2": begin, "rmax2": begin + wide})
        whole = self.extent(axis)
        shift = axis_shift(axis, middle - whole / 2)
        # Slices of a parallelepiped move along its leaning edges, not along the axis
        if self.kind == "para":
            return DivisionSlice({axis: high - low}, self._leaning(axis, middle - whole / 2))
        if axis == "z" and self.kind in ("cone", "trd"):
            return DivisionSlice(self._between(low / whole, high / whole) | {"z": high - low}, shift)
        if self.kind == "trd":
            return self._of_trd(axis, low, high, shift)
        return DivisionSlice({axis: high - low}, shift)

    def _leaning(self, axis: str, amount: Fraction) -> Point:
        """Return the shift by `amount` mm along an axis of a parallelepiped, whose y and z axes lean."""
        from .flat_solids import exact_tangent, read_lean

        if axis == "y":
            return amount * exact_tangent(self.values.angle("alpha", 0)), amount, Fraction(0)
        if axis == "z":
            x, y = read_lean(self.values)
            return x * amount, y * amount, amount
        return axis_shift(axis, amount)

    def _between(self, low: Fraction, high: Fraction) -> SolidChanges:
        """Return the sizes of both ends of a slice of a solid that is linear in z, from shares of its height."""
        changes: SolidChanges = {}
        for name in ("rmin", "rmax") if self.kind == "cone" else ("x", "y"):
            ends = [self.values.length(f"{name}{end}", 0) for end in (1, 2)]
            for end, share in ((1, low), (2, high)):
                changes[f"{name}{end}"] = ends[0] + (ends[1] - ends[0]) * share
        return changes

    def _of_trd(self, axis: str, low: Fraction, high: Fraction, shift: Point) -> DivisionSlice:
        """Return a slice of a <trd>; if its sides lean, both ends are divided in the same ratio (an <arb8>)."""
        a, b = self.values.length(f"{axis}1"), self.values.length(f"{axis}2")
        if a == b:
            return DivisionSlice({f"{axis}1": high - low, f"{axis}2": high - low}, shift)
        other = "y" if axis == "x" else "x"
        corners: SolidChanges = {"dz": self.values.length("z") / 2}
        number = 1
        for size, end in ((a, 1), (b, 2)):
            ends = [size * (2 * each / (a + b) - Fraction(1, 2)) for each in (low, high)]
            wide = self.values.length(f"{other}{end}") / 2
            for first, second in ((ends[0], -wide), (ends[0], wide), (ends[1], wide), (ends[1], -wide)):
                x, y = (first, second) if axis == "x" else (second, first)
                corners |= {f"v{number}x": x, f"v{number}y": y}
                number += 1
        return DivisionSlice(corners, kind="arb8")

    def _of_sections(
        self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool
    ) -> Iterator[DivisionSlice]:
        """Yield slices of a polycone or polyhedra along z or rho, with their zplane sections."""
        sections = self.sections
        if axis == "z":
            begin, kinks = sections[0][0], [z for z, _, _ in sections]
            ends = [begin + offset + k * width for k in range(count + 1)]
            if by_number:  # Geant4 then makes one slice of each section
                if count != len(sections) - 1:
                    raise OmittedPart(
                        f"has {count} slices of {len(sections) - 1} sections, which Geant4 does not divide either"
                    )
                ends = kinks
            for low, high in pairwise(ends):
                # A slice bends where the whole does
                inside = [z for z in kinks if low < z < high]
                yield DivisionSlice({}, sections=tuple(self._at(z) for z in (low, *inside, high)))
            return
        for k in range(count):
            sliced = []
            for number, (z, inner, outer) in enumerate(sections):
                wide = width if number == 0 else (outer - inner - offset) / count
                sliced.append((z, inner + offset + k * wide, inner + offset + (k + 1) * wide))
            yield DivisionSlice({}, sections=tuple(sliced))

    def _at(self, z: Fraction) -> Point:
        """Return the section (z, rmin, rmax) at a height, interpolated linearly."""
        for (z0, a, b), (z1, c, d) in pairwise(self.sections):
            if z0 <= z <= z1 and z0 < z1:
                share = (z - z0) / (z1 - z0)
                return z, a + (c - a) * share, b + (d - b) * share
        return self.sections[-1]
