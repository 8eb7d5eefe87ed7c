"""OpenMC's lattice elements."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

from .lattices import HexagonalLattice, RectangularLattice
from .values import Values, shown
from .words import count_words
from .xml_tree import Element


def read_rectangular(element: Element) -> RectangularLattice:
    """Raises Mistake."""
    values = Values(element, "lattice")
    number, name = values.title()
    shape = values.attempt(lambda: _shape(values), None)
    axes = len(shape) if shape else 2
    lower_left = values.attempt(lambda: values.numbers("lower_left", axes), ()) if shape else ()
    pitch = values.attempt(lambda: _pitch(values, axes), ()) if shape else ()
    outer = values.attempt(lambda: values.optional_integer("outer"), None)
    universes: Counter[int] = Counter()
    if shape:
        count = shape[0] * shape[1] * (*shape, 1)[2]
        what = f"a lattice of {' x '.join(map(str, shape))}"
        universes = values.attempt(lambda: _universes(values, count, what), universes)
    values.finish()
    listing = values.required("universes")
    return RectangularLattice(number, name, outer, universes, listing, element, shape or (), lower_left, pitch)


def read_hexagonal(element: Element) -> HexagonalLattice:
    """Raises Mistake."""
    values = Values(element, "lattice")
    number, name = values.title()
    rings, levels = values.attempt(lambda: _rings(values), (0, None))
    orientation = values.attempt(lambda: _orientation(values), "y")
    flat = levels is None
    outer = values.attempt(lambda: values.optional_integer("outer"), None)
    center: tuple[Fraction, ...] = ()
    pitch: tuple[Fraction, ...] = ()
    universes: Counter[int] = Counter()
    if rings:
        center = values.attempt(lambda: values.numbers("center", 2 if flat else 3), ())
        pitch = values.attempt(lambda: _pitch(values, 1 if flat else 2), ())
        count = (3 * rings * (rings - 1) + 1) * (levels or 1)
        what = f"a hexagonal lattice of {rings} rings" + ("" if flat else f" and {levels} levels")
        universes = values.attempt(lambda: _universes(values, count, what), universes)
    values.finish()
    x, y, z = (*center, Fraction(0))[:3]
    return HexagonalLattice(
        number, name, outer, universes, values.required("universes"), element,
        rings, orientation, (x, y, z), pitch[0], None if flat else pitch[1], levels or 1,
    )  # fmt: skip


def _shape(values: Values) -> tuple[int, ...] | None:
    shape = tuple(values.integers("dimension"))
    if len(shape) not in (2, 3) or min(shape) < 1:
        raise values.mistake(f"dimension must be two or three integers > 0, got {shown(values.required('dimension'))}")
    return shape


def _rings(values: Values) -> tuple[int, int | None]:
    rings, levels = values.integer("n_rings"), values.optional_integer("n_axial")
    if rings < 1 or (levels is not None and levels < 1):
        raise values.mistake(f"n_rings and n_axial must be > 0, got {rings if rings < 1 else levels}")
    return rings, levels


def _orientation(values: Values) -> str:
    orientation = values.text("orientation") or "y"
    if orientation not in ("x", "y"):
        raise values.mistake(f"orientation must be x or y, got {shown(orientation)}")
    return orientation


def _pitch(values: Values, count: int) -> tuple[Fraction, ...]:
    pitch = values.numbers("pitch", count)
    if min(pitch) <= 0:
        raise values.mistake(f"pitch must be > 0, got {float(min(pitch)):g}")
    return pitch


def _universes(values: Values, count: int, what: str) -> Counter[int]:
    """How often each universe is named; the places are not written out before their number is right, nor then."""
    found = count_words(values.required("universes"))
    if found != count:
        raise values.mistake(f"universes: {what} needs {count}, got {found}")
    return values.integer_tally("universes")
