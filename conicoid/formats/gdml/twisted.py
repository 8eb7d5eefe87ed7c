"""GDML's solids whose sides are twisted, where these are quadrics: ruled by lines between two planes across z.

A side through the lines from a(z) to b(z), whose ends go evenly with z, is where (b - a) × ((x, y) - a) = 0: at each z
a straight line, and of degree two in x, y and z together, a hyperbolic paraboloid. The sides of a twisted tube are the
same about the axis, y = k x z; its walls are the hyperboloids that lines at both ends sweep. G4TwistedBox, G4TwistedTrd
and G4TwistedTrap turn evenly in angle, so theirs are not: x sin(c z) = y cos(c z) has no such form.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import partial

from ...shapes.base import Solid
from ...shapes.quadric import Quadric
from ...shapes.region import Difference, Intersection, Union
from ...shapes.rounded import sin_cos_degrees
from .convex import Plane, inside_of
from .placement import Point
from .reading import LeftOut, Mistake
from .round_solids import about_z, slab
from .templates import Make
from .values import Values

Flat = tuple[Fraction, Fraction]
Terms = dict[str, Fraction]
"""Of a quadric, <= 0 inside."""
_NONE, _ONE = Fraction(0), Fraction(1)


def twisted_tubs(values: Values) -> Make:
    """twistedangle, endinnerrad and endouterrad at z = ± zlen / 2, phi; or mid radii, negativeEndz and positiveEndz.

    r² from inner² to outer² times 1 + k² z², of radii at z = 0, and angles within ± phi / 2 of atan(k z), where
    k = tan(twistedangle / 2) / the height of the farther end (G4TwistedTubs::SetFields, G4TwistTubsSide::SurfacePoint).
    """
    half = values.length("zlen", 0) / 2
    s, c = (Fraction(part) for part in sin_cos_degrees(float(values.angle("twistedangle") / 2)))
    if c <= Fraction(1, 10**9):
        raise Mistake(values.element, "twistedangle must be between -180 and 180 degrees")
    if half:
        low, high = -half, half
        inner, outer = (values.radius(name) * c for name in ("endinnerrad", "endouterrad"))
    else:
        low, high = values.length("negativeEndz"), values.length("positiveEndz")
        inner, outer = values.radius("midinnerrad"), values.radius("midouterrad")
    if not low < high or not 0 <= inner < outer:
        raise Mistake(values.element, "the ends must rise in z, and the inner radius be less than the outer")
    twist = s / c / max(abs(low), abs(high))
    width = _width(values)
    bend = twist * twist
    reach = outer * (1 + abs(twist) * max(abs(low), abs(high)))
    sides = [] if width >= 360 else [_turned_side(twist, float(sense * width / 2), sense) for sense in (-1, 1)]
    ends = low, high, high - low + abs(low) + abs(high), 2 * reach
    return partial(_twisted, (inner * inner, outer * outer), bend, ends, sides, width <= 180)


def _twisted(
    squares: Flat, bend: Fraction, ends: tuple[Fraction, Fraction, Fraction, Fraction], sides: list[Terms],
    narrow: bool, shift: Point,
) -> Solid:  # fmt: skip
    """Between two radii, given by their squares, of a slab and within both of its sides; within one if it is wide."""
    parts: list[Solid] = [slab(*ends, shift), about_z(squares[1], _NONE, squares[1] * bend, shift)]
    walls = [_quadric(side, shift) for side in sides]
    parts += walls if narrow or not walls else [Union(tuple(walls))]
    whole = Intersection(tuple(parts))
    return Difference((whole, about_z(squares[0], _NONE, squares[0] * bend, shift))) if squares[0] else whole


def _width(values: Values) -> Fraction:
    """The angle of a segment in degrees."""
    count = values.integer("nseg", 0)
    width = values.angle("totphi") / count if count else values.angle("phi", 360)
    if width <= 0:
        raise Mistake(values.element, "phi must be > 0")
    return width


def _turned_side(twist: Fraction, degrees: float, sense: int) -> Terms:
    """sense (y - twist x z) <= 0 in axes that are turned."""
    s, c = (Fraction(part) for part in sin_cos_degrees(degrees))
    return {"x": -sense * s, "y": sense * c, "xz": -sense * twist * c, "yz": -sense * twist * s}


def between_sections(low: Sequence[Flat], high: Sequence[Flat], half: Fraction) -> Make:
    """Between as many corners at -half and at half, all sections convex; sides that are not flat are quadrics.

    Raises LeftOut where a section between the ends is not convex.
    """
    count = len(low)
    middle = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(low, high, strict=True)]
    if sum((_cross(a, b) for a, b in zip(middle, [*middle[1:], middle[0]], strict=True)), _NONE) < 0:
        low, high = low[::-1], high[::-1]
    kept = [k for k in range(count) if (low[k], high[k]) != (low[(k + 1) % count], high[(k + 1) % count])]
    edges = [_Edge(low[k], high[k], low[(k + 1) % count], high[(k + 1) % count]) for k in kept]
    if len(edges) < 3:
        raise ValueError("it must enclose a volume")
    for first, second in zip(edges, [*edges[1:], edges[0]], strict=True):
        if not first.turns_left(second):
            raise LeftOut("a section of it between its ends is not convex")
    ends: list[Plane] = [((_NONE, _NONE, -_ONE), half), ((_NONE, _NONE, _ONE), half)]
    sides = [plane for edge in edges if (plane := edge.plane(half)) is not None]
    flat = inside_of([*ends, *sides, *_around([*low, *high])])
    return partial(_curved, flat, [edge.terms(half) for edge in edges if edge.plane(half) is None])


def _curved(flat: Make, curved: list[Terms], shift: Point) -> Solid:
    return Intersection((flat(shift), *(_quadric(terms, shift) for terms in curved)))


def _around(corners: Sequence[Flat]) -> list[Plane]:
    """Planes a little beyond all corners, as twisted sides alone do not say how far a body reaches."""
    found: list[Plane] = []
    for axis in (0, 1):
        least, most = min(corner[axis] for corner in corners), max(corner[axis] for corner in corners)
        beyond = (most - least) / 1024
        across = (_ONE, _NONE, _NONE) if axis == 0 else (_NONE, _ONE, _NONE)
        found += [(across, most + beyond), ((-across[0], -across[1], _NONE), beyond - least)]
    return found


class _Edge:
    """A side between the ends: from a to b below, from c to d above, all else to its left."""

    def __init__(self, a: Flat, c: Flat, b: Flat, d: Flat) -> None:
        self.begin = (a[0] + c[0]) / 2, (a[1] + c[1]) / 2
        self.drift = (c[0] - a[0]) / 2, (c[1] - a[1]) / 2
        end, its = ((b[0] + d[0]) / 2, (b[1] + d[1]) / 2), ((d[0] - b[0]) / 2, (d[1] - b[1]) / 2)
        self.along = end[0] - self.begin[0], end[1] - self.begin[1]
        self.turning = its[0] - self.drift[0], its[1] - self.drift[1]
        self.low, self.high = (a, b), (c, d)

    def turns_left(self, following: _Edge) -> bool:
        """Does the outline bend to the left after this side, or go straight on, at every height?"""
        a = _cross(self.turning, following.turning)
        b = _cross(self.along, following.turning) + _cross(self.turning, following.along)
        c = _cross(self.along, following.along)
        least = min(a + b + c, a - b + c)
        if a > 0 and abs(b) < 2 * a:
            least = min(least, c - b * b / (4 * a))
        return least >= 0

    def plane(self, half: Fraction) -> Plane | None:
        """The plane of all four corners; None where there is none."""
        below, above = ((q[0] - p[0], q[1] - p[1]) for p, q in (self.low, self.high))
        if _cross(below, above):
            return None
        along = below if any(below) else above
        p, r = self.low[0], self.high[0]
        n = along[1], -along[0]
        offsets = n[0] * p[0] + n[1] * p[1], n[0] * r[0] + n[1] * r[1]
        size = max(abs(n[0]), abs(n[1]))
        slope = (offsets[1] - offsets[0]) / (2 * half) / size
        return (n[0] / size, n[1] / size, -slope), (offsets[0] + offsets[1]) / 2 / size

    def terms(self, half: Fraction) -> Terms:
        """-(b - a) × ((x, y) - a), a and b going evenly with z, divided by its largest number."""
        (ax, ay), (mx, my), (px, py), (qx, qy) = self.along, self.turning, self.begin, self.drift
        found = {
            "x": ay, "y": -ax, "xz": my / half, "yz": -mx / half,
            "constant": ax * py - ay * px,
            "z": (ax * qy + mx * py - ay * qx - my * px) / half,
            "zz": (mx * qy - my * qx) / half**2,
        }  # fmt: skip
        size = max(map(abs, found.values()))
        return {name: value / size for name, value in found.items()}


def _cross(a: Flat, b: Flat) -> Fraction:
    return a[0] * b[1] - a[1] * b[0]


def _quadric(terms: Terms, shift: Point) -> Solid:
    made = Quadric(coefficients={name: float(value) for name, value in terms.items() if value})
    x, y, z = map(float, shift)
    return made.translate((x, y, z)) if any((x, y, z)) else made
