"""Round surfaces to the records that kernels read, and assemble the parts of one body."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable
from dataclasses import field
from fractions import Fraction
from typing import Any, NamedTuple

from .._util.records import dataclass
from ..geometry.bounds.linear_program import are_ratios, integer_row
from ..geometry.cell import All, Any_, Cell, Not, PolygonSheet, SurfaceSheet, Tree
from ..geometry.surface import CENTER_TOLERANCE, UPRIGHT, PlaneSurface, QuadricSurface, Surface
from ..kernels.tables import PLANE, POLYGON, QUADRIC, SHEET, SPHERE
from ..numerics import bigfloat as ex
from ..numerics.bigfloat import Symbol
from ..numerics.portable_math import is_float, leading_sign, portable_max, portable_sqrt, power_of_two_scale


@dataclasses.dataclass(frozen=True, slots=True)
class SurfaceRecord:
    """A surface as kernels read it, and the remainders that rounding removed from its numbers."""

    kind: int
    numbers: tuple[float, ...]
    rests: tuple[float, ...]
    sense: float  # +1, or -1 where the record is the negated surface


def round_surface(surface: Surface) -> SurfaceRecord:
    """Round a surface to its record. The first non-zero number of a plane's normal is positive.

    So the side to which a ray within a plane counts does not depend on who wrote the plane first.
    """
    kind, numbers = surface_record(surface)
    rounded, lost = round_numbers(numbers), rounding_rests(numbers)
    if kind != PLANE:
        return SurfaceRecord(kind, rounded, lost, 1.0)
    sense = leading_sign(rounded[:3])
    # The rests follow the sign, and the anchor does not
    return SurfaceRecord(kind, _flip_plane(rounded, sense), _flip_plane(lost, sense), sense)


def _flip_plane(numbers: tuple[float, ...], sense: float) -> tuple[float, ...]:
    """Multiply a plane's normal and height by a sign, without negative zeros; its anchor stays."""
    return (*(number * sense + 0.0 for number in numbers[:4]), *numbers[4:])


def surface_record(surface: Surface) -> tuple[int, tuple[ex.Writable, ...]]:
    """Return (kind, numbers of the record before rounding)."""
    if isinstance(surface, PlaneSurface):
        anchor = round_numbers(surface.anchor)
        # A scale that is a power of two changes no bit, and keeps products of the record's numbers within range
        factor = _factor(surface.normal)
        height = _height_of_anchor(surface, anchor)
        return PLANE, (*(_times(v, factor) for v in (*surface.normal, height)), *anchor)
    ball = _as_sphere(surface)
    if ball is not None:
        return SPHERE, ball
    factor = _factor(surface.squares)
    numbers = (*surface.squares, *surface.linear, surface.constant)
    rows = [w for line in surface.rows for w in line]
    return QUADRIC, (*surface.anchor, *rows, *(_times(v, factor) for v in numbers))


def _factor(values: Iterable[Any]) -> float:
    """Return the power of two that brings the largest of some numbers near 1; scaling by it is exact."""
    return power_of_two_scale(functools.reduce(portable_max, (abs(ex.rounded(v)) for v in values)))


def _times(value: ex.Writable, factor: float) -> ex.Writable:
    """Multiply by a power of two, exactly."""
    # A constant of a traced formula
    if isinstance(factor, Symbol) and type(value) in (Fraction, ex.BigFloat):
        return ex.exact(factor) * value
    if isinstance(value, Fraction):
        return value * Fraction(factor)
    return value * factor


def _height_of_anchor(surface: PlaneSurface, anchor: tuple[float, ...]) -> ex.Writable:
    """Return the exact height of an anchor over a plane."""
    # Without a turn all is exact, but for the anchor: the remainder of dividing it by a count of corners, or by n·n
    if surface.over is None or surface.is_offset_better or all(map(is_float, surface.normal)):
        if not any(anchor):
            return -surface.offset
        if are_ratios((*surface.normal, surface.offset)):
            x, y, z, end, size = integer_row((*surface.normal, surface.offset, 1.0))
            a, b, c, unit = integer_row((*anchor, 1.0))
            return Fraction(x * a + y * b + z * c - end * unit, size * unit)
        return ex.dot(ex.exact_row(surface.normal), ex.exact_row(anchor), -ex.exact(surface.offset))
    aside = ex.minus(ex.exact_row(anchor), ex.exact_row(surface.anchor))
    return ex.dot(ex.exact_row(surface.normal), aside, surface.height)


def _as_sphere(surface: QuadricSurface) -> tuple[ex.Writable, ...] | None:
    """Return (center, radius) where the quadric is a sphere with its inside inside; else None."""
    a, b, c = surface.squares
    if not (a == b == c and a > 0 and not any(surface.linear) and surface.constant > 0):
        return None
    if surface.rows is UPRIGHT:
        square = ex.rounded(surface.constant if a == 1 else ex.exact(surface.constant) / ex.exact(a))
        radius = portable_sqrt(square) if 1e-290 < square < 1e290 else 0.0
        # A radius that is a float needs no root: the usual ball is exact, and costs no arithmetic of 3000 bits
        if radius and a == 1 and ex.rational(radius) ** 2 == surface.constant:
            return _center_sphere(surface, radius)
    rows = tuple(ex.exact_row(row) for row in surface.rows)
    # W Wᵀ a multiple of 1: the motion turned and scaled the sphere, but did not stretch it
    gram = ex.multiply((rows[0], rows[1], rows[2]), ex.transpose((rows[0], rows[1], rows[2])))
    quotient = ex.cancelling_sum((ex.exact(surface.constant) / (ex.exact(a) * gram[0][0]),))
    sphere = _center_sphere(surface, ex.cancelling_sum((ex.sqrt(quotient),)))
    # The center is tested first: no number of a recording shows that squares are equal
    if sphere is None or ex.cancelling_sum((gram[0][0], -gram[1][1])) or ex.cancelling_sum((gram[0][0], -gram[2][2])):
        return None
    # Settled sums: zero on paper is zero here, or the sphere was sheared
    return None if gram[0][1] or gram[0][2] or gram[1][2] else sphere


def _center_sphere(surface: QuadricSurface, radius: ex.Writable) -> tuple[ex.Writable, ...] | None:
    """Return (center, radius), or None where rounding the center moves the sphere too far (`CENTER_TOLERANCE`)."""
    if any(abs(rest) > CENTER_TOLERANCE * ex.rounded(radius) for rest in rounding_rests(surface.anchor)):
        return None
    return (*surface.anchor, radius)


def round_numbers(values: Iterable[Any]) -> tuple[float, ...]:
    """Round each number to float64."""
    return tuple(ex.rounded(v) for v in values)


def rounding_rests(values: Iterable[Any]) -> tuple[float, ...]:
    """Return what rounding to float64 removes from each number."""
    return tuple(0.0 if is_float(v) else _rest(v) for v in values)


def _rest(value: Any) -> float:
    """Return what rounding to float64 removes from a number."""
    if isinstance(value, Fraction):
        return float(value - Fraction(float(value)))
    rest = ex.cancelling_sum((value, -ex.exact(ex.rounded(value))))  # the last of many bits are noise
    return ex.rounded(rest)


# The assembly of one body: surfaces, cells, programs and sheets, numbered from 0

UNBOUNDED: tuple[float, ...] = (-math.inf,) * 3 + (math.inf,) * 3
LeafBounds = dict[int, Any]


class SurfaceSlot(NamedTuple):
    """A placeholder for a surface of a part of a body: which part, and which of its surfaces."""

    kind: int
    part: int
    number: int


@dataclass
class Assembly:
    """The lists that a body is assembled in, one per column of `Tables`."""

    surfaces: list[SurfaceRecord | SurfaceSlot] = field(default_factory=list)
    exact: list[Any] = field(default_factory=list)
    """The surfaces before rounding."""
    # (quadric or -1, side, face); the number of planes of each cell; the planes: (surface, side, face).
    cells: list[tuple[int, int, int]] = field(default_factory=list)
    cell_planes: list[int] = field(default_factory=list)
    planes: list[tuple[int, int, int]] = field(default_factory=list)
    programs: list[tuple[int, int]] = field(default_factory=list)  # leaves, gates
    leaves: list[tuple[int, int, int, int]] = field(default_factory=list)
    leaf_bounds: list[Any] = field(default_factory=list)
    gates: list[tuple[int, int, int, int]] = field(default_factory=list)
    sheets: list[tuple[int, int, int, int]] = field(default_factory=list)
    polygons: list[tuple[int, int]] = field(default_factory=list)
    outlines: list[tuple[ex.Row, ...]] = field(default_factory=list)

    def surface(self, surface: Any) -> int:
        """Add a surface; return its number."""
        # Each face has a surface of its own here; equal ones are merged once for the whole scene
        self.surfaces.append(surface if isinstance(surface, SurfaceSlot) else round_surface(surface))
        self.exact.append(surface)
        return len(self.surfaces) - 1

    def cell(self, cell: Cell) -> int:
        """Add a cell; return its number. Raise ValueError for a second quadric."""
        quadric, side, number, first = -1, 1, -1, len(self.planes)
        for face in cell.faces:
            surface = self.surface(face.surface)
            if self.surfaces[surface].kind == PLANE:
                self.planes.append((surface, face.inside, face.number))
            elif quadric < 0:
                quadric, side, number = surface, face.inside, face.number
            else:
                raise ValueError("a cell holds at most one quadric: combine two cells instead")
        self.cells.append((quadric, side, number))
        self.cell_planes.append(len(self.planes) - first)
        return len(self.cells) - 1

    def program(self, tree: Tree, bounds: LeafBounds) -> int:
        """Add gates and leaves for a Boolean tree, parents before children; return the number of the program.

        `bounds` maps the id of a cell to its box, as `BodyFaces.bounds` does.
        """
        first, first_leaf = len(self.gates), len(self.leaves)
        pending: list[tuple[Tree, int, int]] = [(tree, -1, 1)]  # (part, the gate it feeds, sense)
        while pending:
            part, gate, sense = pending.pop()
            negated = isinstance(part, Not)
            inner = part.part if isinstance(part, Not) else part
            sense = -sense if negated else sense
            if isinstance(inner, Cell):
                if gate < 0:
                    # A leaf needs a gate that it feeds, also where it is the whole program
                    gate = self._gate(-1, 1, negated)
                    negated = False
                self.leaves.append((self.cell(inner), gate, int(negated), sense))
                self.leaf_bounds.append(bounds.get(id(inner), UNBOUNDED))
                continue
            assert isinstance(inner, (All, Any_)), "negation() leaves no complement of a complement"
            parts = inner.parts
            its_gate = self._gate(gate, len(parts) if isinstance(inner, All) else 1, negated)
            # Reversed, so that the stack yields leaves in the order of the operands: at a shared wall the face of the
            # first is reported
            pending.extend((child, its_gate, sense) for child in reversed(parts))
        self._count_at_start(first, first_leaf)
        self.programs.append((len(self.leaves) - first_leaf, len(self.gates) - first))
        return len(self.programs) - 1

    def _gate(self, parent: int, need: int, negated: bool) -> int:
        """Add a gate; return its number."""
        self.gates.append((parent, need, int(negated), 0))
        return len(self.gates) - 1

    def _count_at_start(self, first_gate: int, first_leaf: int) -> None:
        """Count for each gate its true inputs while every leaf is outside; children come after parents."""
        true = [0] * (len(self.gates) - first_gate)
        for _, gate, negated, _ in self.leaves[first_leaf:]:
            true[gate - first_gate] += negated
        # Backwards, so that the children of a gate are counted before it
        for gate in range(len(self.gates) - 1, first_gate - 1, -1):
            parent, need, negated, _ = self.gates[gate]
            count = true[gate - first_gate]
            self.gates[gate] = (parent, need, negated, count)
            if parent >= 0:
                true[parent - first_gate] += (count >= need) != bool(negated)

    def sheet(self, sheet: SurfaceSheet | PolygonSheet, program: int) -> tuple[int, int]:
        """Add a sheet; return (kind of entry, index)."""
        if isinstance(sheet, SurfaceSheet):
            self.sheets.append((self.surface(sheet.surface), program, sheet.side, int(sheet.one_sided)))
            return SHEET, len(self.sheets) - 1
        self.polygons.append((self.surface(sheet.plane), program))
        self.outlines.append(sheet.vertices)
        return POLYGON, len(self.polygons) - 1
