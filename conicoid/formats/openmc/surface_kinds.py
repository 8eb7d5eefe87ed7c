"""OpenMC's surface elements, by their type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from .placement import ORIGIN
from .surfaces import ConeSurface, FlatSurface, QuadricSurface, RoundSurface, Surface
from .values import Values, shown, titled
from .xml_tree import Element

Coefficients = tuple[Fraction, ...]
TORI = ("x-torus", "y-torus", "z-torus")
BOUNDARIES = {
    "": "transmission", "transmit": "transmission", "reflect": "reflective", "reflecting": "reflective",
} | {name: name for name in ("transmission", "vacuum", "reflective", "white", "periodic")}  # fmt: skip
_ZERO, _ONE = Fraction(0), Fraction(1)


@dataclass(frozen=True, slots=True)
class NamedSurface:
    """A surface as the file has it, with its boundary condition."""

    id: int
    name: str
    surface: Surface
    boundary: str

    def __str__(self) -> str:
        return titled("surface", self.id, self.name)


def read_surface(element: Element) -> NamedSurface:
    """Raises Mistake for what is wrong and for tori, which are no quadrics."""
    values = Values(element, "surface")
    number, name = values.title()
    boundary = values.attempt(lambda: _boundary(values), "")
    surface = values.attempt(lambda: _surface(values), None)
    values.finish()
    assert surface is not None
    return NamedSurface(number, name, surface, boundary)


def _boundary(values: Values) -> str:
    boundary = (values.text("boundary") or "").lower()
    if boundary not in BOUNDARIES:
        known = ", ".join(sorted(set(BOUNDARIES.values())))
        raise values.mistake(f"boundary must be one of {known}, got {shown(boundary)}")
    return BOUNDARIES[boundary]


def _surface(values: Values) -> Surface | None:
    kind = values.required("type").lower()
    if kind in TORI:
        raise values.mistake(f"is a torus ({kind}), which is no quadric: Conicoid cannot express it")
    if kind not in _KINDS:
        raise values.mistake(f"type must be one of {', '.join(_KINDS)}, got {shown(kind)}")
    count, make = _KINDS[kind]
    try:
        return make(values.numbers("coeffs", count))
    except ValueError as error:
        raise values.mistake(str(error)) from None


def surface_of(kind: str, numbers: Coefficients) -> Surface:
    """A surface by its type and coefficients. Raises ValueError where there is none of them."""
    return _KINDS[kind][1](numbers)


def _plane(numbers: Coefficients) -> Surface:
    """A x + B y + C z = D"""
    a, b, c, d = numbers
    if not (a or b or c):
        raise ValueError("coeffs must have a normal (A, B, C) that is not zero")
    return FlatSurface((a, b, c), d)


def _axis_plane(axis: int) -> Callable[[Coefficients], Surface]:
    def make(numbers: Coefficients) -> Surface:
        x, y, z = (_ONE if i == axis else _ZERO for i in range(3))
        return FlatSurface((x, y, z), numbers[0])

    return make


def _cylinder(axis: int) -> Callable[[Coefficients], Surface]:
    """Two coordinates of the axis, in the order x, y, z, and the radius."""

    def make(numbers: Coefficients) -> Surface:
        coordinates = list(numbers[:2])
        coordinates.insert(axis, _ZERO)
        x, y, z = coordinates
        return RoundSurface(axis, (x, y, z), _positive("radius", numbers[2]))

    return make


def _sphere(numbers: Coefficients) -> Surface:
    x, y, z, radius = numbers
    return RoundSurface(None, (x, y, z), _positive("radius", radius))


def _cone(axis: int) -> Callable[[Coefficients], Surface]:
    """The apex and the squared slope."""

    def make(numbers: Coefficients) -> Surface:
        x, y, z, square = numbers
        return ConeSurface(axis, (x, y, z), _positive("R²", square))

    return make


def _quadric(numbers: Coefficients) -> Surface:
    """A x² + B y² + C z² + D xy + E yz + F xz + G x + H y + J z + K = 0"""
    if not any(numbers[:9]):
        raise ValueError("coeffs must hold more than the constant K")
    if any(numbers[:6]):
        return QuadricSurface(numbers, ORIGIN)
    x, y, z = numbers[6:9]
    return FlatSurface((x, y, z), -numbers[9])


def _positive(what: str, value: Fraction) -> Fraction:
    if value <= 0:
        raise ValueError(f"coeffs: the {what} must be > 0, got {float(value):g}")
    return value


_KINDS: dict[str, tuple[int, Callable[[Coefficients], Surface]]] = {
    "x-plane": (1, _axis_plane(0)), "y-plane": (1, _axis_plane(1)), "z-plane": (1, _axis_plane(2)),
    "plane": (4, _plane),
    "x-cylinder": (3, _cylinder(0)), "y-cylinder": (3, _cylinder(1)), "z-cylinder": (3, _cylinder(2)),
    "sphere": (4, _sphere),
    "x-cone": (4, _cone(0)), "y-cone": (4, _cone(1)), "z-cone": (4, _cone(2)),
    "quadric": (10, _quadric),
}  # fmt: skip
