"""Planes and quadrics as OpenMC's surfaces, each once: planes, cylinders, cones and spheres where they are some."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

from ....shapes import exact as ex
from ....shapes.quadric import Quadric
from ....shapes.surface import PlaneSurface, Surface
from ...openmc.region import Half
from ...openmc.surface_kinds import surface_of
from ...openmc.surfaces import Surface as ReadSurface
from ..numbers import short, words

Numbers = tuple[Fraction, ...]
_AXES = "xyz"


@dataclass
class Table:
    """The surfaces of a file, by kind and coefficients. Rounded ones are those whose numbers are no float64."""

    numbers: dict[tuple[str, Numbers], int] = field(default_factory=dict)
    rounded: set[int] = field(default_factory=set)
    boundaries: dict[int, str] = field(default_factory=dict)
    surfaces: dict[int, ReadSurface] = field(default_factory=dict)
    """As an importer knows them."""

    def half(self, surface: Surface, inside: int) -> Half:
        """The side of a surface that is inside: f <= 0 for +1, f >= 0 for -1."""
        made = _plane(surface) if isinstance(surface, PlaneSurface) else _curved(surface.coefficients())
        return self.added(made, inside)

    def half_of_quadric(self, quadric: Quadric) -> Half:
        """The inside of a quadric that stands as it was written, by the very coefficients."""
        q = quadric.symmetric
        terms = (q[0][0], q[1][1], q[2][2], q[0][1], q[0][2], q[1][2], q[0][3], q[1][3], q[2][3], q[3][3])
        return self.added(_general([ex.exact(term) for term in terms]), 1)

    def added(self, made: _Made, inside: int) -> Half:
        """A side of a surface, which gets a number."""
        key = made.kind, made.numbers
        number = self.numbers.setdefault(key, len(self.numbers) + 1)
        if number not in self.surfaces:
            self.surfaces[number] = surface_of(made.kind, made.numbers)
        if not made.is_exact:
            self.rounded.add(number)
        return Half(number, made.sense * inside < 0)

    def elements(self) -> list[str]:
        """A line of XML for each."""
        lines = []
        for (kind, numbers), number in self.numbers.items():
            boundary = f' boundary="{self.boundaries[number]}"' if number in self.boundaries else ""
            lines.append(f'<surface id="{number}" type="{kind}" coeffs="{words(numbers)}"{boundary}/>')
        return lines


@dataclass(frozen=True)
class _Made:
    """A surface element; `sense` -1 where its inside is the outside of the surface that it was made of."""

    kind: str
    numbers: Numbers
    sense: int
    is_exact: bool


def _made(kind: str, numbers: list[ex.Exact], sense: int) -> _Made:
    said = [short(number) for number in numbers]
    return _Made(kind, tuple(value for value, _ in said), sense, all(is_exact for _, is_exact in said))


def _plane(surface: PlaneSurface) -> _Made:
    normal, offset = ex.exact_row(surface.normal), ex.exact(surface.offset)
    along = [i for i in range(3) if normal[i]]
    sense = 1 if normal[along[0]] > 0 else -1
    if len(along) == 1 and not ex.cancelling_sum((normal[along[0]] * sense, -ex.ONE)):
        return _made(f"{_AXES[along[0]]}-plane", [offset * sense], sense)
    return _made("plane", [number * sense for number in (*normal, offset)], sense)


def _curved(terms: tuple[ex.Exact, ...]) -> _Made:
    """By (xx, yy, zz, xy, xz, yz, x, y, z, 1), the mixed and linear ones halved."""
    squares, mixed, linear = terms[:3], terms[3:6], terms[6:9]
    if not any(mixed):
        for axis in (None, 2, 1, 0):
            found = _of_revolution(squares, linear, terms[9], axis)
            if found is not None:
                return found
    return _general(list(terms))


def _of_revolution(squares: ex.Row | tuple[ex.Exact, ...], linear: tuple[ex.Exact, ...], constant: ex.Exact,
                   axis: int | None) -> _Made | None:  # fmt: skip
    """A sphere (no axis), or a cylinder or cone about an axis of coordinates; None where it is none."""
    across = [i for i in range(3) if i != axis]
    lead = squares[across[0]]
    if not lead or any(_differ(squares[i], lead) for i in across):
        return None
    sense = 1 if lead > 0 else -1
    if axis is not None and bool(squares[axis]) == 0 and linear[axis]:
        return None  # a paraboloid
    used = across if axis is None or not squares[axis] else [0, 1, 2]
    center = [ex.cancelling_sum((-linear[i] / squares[i],)) if i in used else ex.ZERO for i in range(3)]
    height = ex.cancelling_sum((constant / lead, *(-center[i] * center[i] * squares[i] / lead for i in used)))
    if axis is None or not squares[axis]:  # |x - c|² + height = 0
        if not height < 0:
            return None
        radius = ex.cancelling_sum((ex.sqrt(-height),))
        kind = "sphere" if axis is None else f"{_AXES[axis]}-cylinder"
        return _made(kind, [*(center[i] for i in across), radius], sense)
    slope = ex.cancelling_sum((-squares[axis] / lead,))
    if height or not slope > 0:
        return None
    return _made(f"{_AXES[axis]}-cone", [*center, slope], sense)


def _differ(a: ex.Exact, b: ex.Exact) -> bool:
    return bool(ex.cancelling_sum((a, -b)))


def _general(terms: list[ex.Exact]) -> _Made:
    """All ten coefficients, the mixed and linear ones doubled."""
    xx, yy, zz, xy, xz, yz, x, y, z, constant = terms
    numbers = [xx, yy, zz, 2 * xy, 2 * yz, 2 * xz, 2 * x, 2 * y, 2 * z, constant]
    made = _made("quadric", numbers, 1)
    if not made.is_exact:
        lead = max(numbers[:6], key=abs)
        size = lead if lead > 0 else -lead
        made = _made("quadric", [ex.cancelling_sum((number / size,)) for number in numbers], 1)
    return made
