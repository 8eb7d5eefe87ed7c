"""MCNP's surfaces by their mnemonics: the negative side of each is the common part of negative sides of one or more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from ...shapes.suggestion import did_you_mean
from ..nodes import shortened
from ..openmc.placement import ORIGIN, Point
from ..openmc.surfaces import ConeSurface, FlatSurface, QuadricSurface, RoundSurface, Surface
from .vectors import UNIT, cross, dot, plus, point, scaled

Numbers = list[Fraction]
_ZERO, _ONE = Fraction(0), Fraction(1)
TORI = ("tx", "ty", "tz")


@dataclass(frozen=True)
class Form:
    """What bounds the negative side, all of it; each bound a facet of its own, or none."""

    surfaces: tuple[Surface, ...]
    has_facets: bool = False


def form(kind: str, numbers: Numbers) -> Form:
    """Raises ValueError for what is wrong and for tori, which are no quadrics."""
    from .macrobodies import MACROBODIES

    if kind in TORI:
        raise ValueError(f"is a torus ({kind}), which is no quadric: Conicoid cannot express it")
    known = KINDS | MACROBODIES
    if kind not in known:
        raise ValueError(f"{shortened(kind, 20)!r} is no kind of surface{did_you_mean(kind, known)}")
    counts, make = known[kind]
    if len(numbers) not in counts:
        expected = " or ".join(map(str, counts))
        raise ValueError(f"{kind} needs {expected} number{'' if counts == (1,) else 's'}, got {len(numbers)}")
    return make(numbers)


def positive(what: str, value: Fraction) -> Fraction:
    if value <= 0:
        raise ValueError(f"the {what} must be > 0, got {float(value):g}")
    return value


def _only(surface: Surface) -> Form:
    return Form((surface,))


def _plane(numbers: Numbers) -> Form:
    """A x + B y + C z = D, or by three points."""
    if len(numbers) == 4:
        normal, offset = point(numbers[:3]), numbers[3]
        if not any(normal):
            raise ValueError("the normal of a plane must not be zero")
        return _only(FlatSurface(normal, offset))
    a, b, c = (point(numbers[i : i + 3]) for i in (0, 3, 6))
    normal = cross(plus(b, a, -1), plus(c, a, -1))
    if not any(normal):
        raise ValueError("the three points of a plane lie on a line")
    offset = dot(normal, a)
    # The origin is on the negative side; else (0, 0, ∞) on the positive one, else (0, ∞, 0), else (∞, 0, 0)
    if next(value for value in (offset, *reversed(normal)) if value) < 0:
        normal, offset = scaled(normal, -1), -offset
    return _only(FlatSurface(normal, offset))


def _axis_plane(axis: int) -> Callable[[Numbers], Form]:
    return lambda numbers: _only(FlatSurface(UNIT[axis], numbers[0]))


def _sphere(center: Numbers, radius: Fraction) -> Form:
    return _only(RoundSurface(None, point(center), positive("radius", radius)))


def _axis_sphere(axis: int) -> Callable[[Numbers], Form]:
    return lambda numbers: _sphere(list(scaled(UNIT[axis], numbers[0])), numbers[1])


def _cylinder(axis: int) -> Callable[[Numbers], Form]:
    """Two coordinates of the axis, in the order x, y, z, or none; and the radius."""

    def make(numbers: Numbers) -> Form:
        center = [*numbers[:-1]] or [_ZERO, _ZERO]
        center.insert(axis, _ZERO)
        return _only(RoundSurface(axis, point(center), positive("radius", numbers[-1])))

    return make


def _cone(axis: int, on_axis: bool) -> Callable[[Numbers], Form]:
    """The apex, the squared slope, and 1 or -1 for one nappe."""

    def make(numbers: Numbers) -> Form:
        count = 2 if on_axis else 4
        apex = scaled(UNIT[axis], numbers[0]) if on_axis else point(numbers[:3])
        square = positive("square of the slope", numbers[count - 1])
        nappe = numbers[count] if len(numbers) > count else _ZERO
        if nappe not in (-1, 0, 1):
            raise ValueError(f"the nappe of a cone must be 1 or -1, got {float(nappe):g}")
        return one_nappe(axis, apex, square, int(nappe))

    return make


def one_nappe(axis: int, apex: Point, square: Fraction, nappe: int) -> Form:
    """A cone, or its part above (1) or below (-1) the apex."""
    cone = ConeSurface(axis, apex, square)
    if not nappe:
        return _only(cone)
    return Form((cone, FlatSurface(scaled(UNIT[axis], -nappe), -nappe * apex[axis])))


def _special(numbers: Numbers) -> Form:
    """A (x-x0)² + B (y-y0)² + C (z-z0)² + 2D (x-x0) + 2E (y-y0) + 2F (z-z0) + G"""
    a, b, c, d, e, f, g = numbers[:7]
    return _quadric([a, b, c, _ZERO, _ZERO, _ZERO, 2 * d, 2 * e, 2 * f, g], point(numbers[7:]))


def _quadric(numbers: Numbers, shift: Point = ORIGIN) -> Form:
    if any(numbers[:6]):
        return _only(QuadricSurface(tuple(numbers), shift))
    normal = point(numbers[6:9])
    if not any(normal):
        raise ValueError("must hold more than a constant")
    return _only(FlatSurface(normal, dot(normal, shift) - numbers[9]))


def _by_points(axis: int) -> Callable[[Numbers], Form]:
    """Through one to three points (coordinate along the axis, distance from it)."""

    def make(numbers: Numbers) -> Form:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
        if any(r < 0 for _, r in pairs):
            raise ValueError("distances from the axis must not be negative")
        heights = {t for t, _ in pairs}
        if len(heights) == 1:
            return _only(FlatSurface(UNIT[axis], pairs[0][0]))
        if len(heights) < len(pairs):
            raise ValueError("two of three points have one coordinate along the axis")
        if len(pairs) == 2:
            return _line(axis, pairs)
        return _conic(axis, pairs)

    return make


def _line(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> Form:
    """A cylinder, or the nappe of a cone on which both points are."""
    (s, p), (t, q) = pairs
    if p == q:
        return _only(RoundSurface(axis, ORIGIN, positive("radius", p)))
    slope = (q - p) / (t - s)
    return one_nappe(axis, scaled(UNIT[axis], s - p / slope), slope * slope, 1 if slope > 0 else -1)


def _conic(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> Form:
    """r² = a t² + b t + c through three points."""
    (s, p), (t, q), (u, r) = ((height, radius**2) for height, radius in pairs)
    first, second = (q - p) / (t - s), (r - q) / (u - t)
    a = (second - first) / (u - s)
    b = first - a * (s + t)
    c = p - s * first + a * s * t
    squares = [-a if i == axis else _ONE for i in range(3)]
    return _quadric([*squares, _ZERO, _ZERO, _ZERO, *scaled(UNIT[axis], -b), -c])


Kind = tuple[tuple[int, ...], Callable[[Numbers], Form]]
KINDS: dict[str, Kind] = {
    "p": ((4, 9), _plane),
    "so": ((1,), lambda numbers: _sphere([_ZERO] * 3, numbers[0])),
    "s": ((4,), lambda numbers: _sphere(numbers[:3], numbers[3])),
    "sph": ((4,), lambda numbers: _sphere(numbers[:3], numbers[3])),
    "sq": ((10,), _special),
    "gq": ((10,), _quadric),
}
for _axis, _letter in enumerate("xyz"):
    KINDS |= {
        f"p{_letter}": ((1,), _axis_plane(_axis)),
        f"s{_letter}": ((2,), _axis_sphere(_axis)),
        f"c{_letter}": ((1,), _cylinder(_axis)),
        f"c/{_letter}": ((3,), _cylinder(_axis)),
        f"k{_letter}": ((2, 3), _cone(_axis, True)),
        f"k/{_letter}": ((4, 5), _cone(_axis, False)),
        _letter: ((2, 4, 6), _by_points(_axis)),
    }
