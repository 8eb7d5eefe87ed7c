"""OpenMC's lattice elements."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import product

from .lattices import HexagonalLattice, Index, RectangularLattice, ring_order
from .surface_kinds import titled
from .values import Values
from .xml_tree import Element


def read_rectangular(element: Element) -> RectangularLattice:
    """Universes are listed level by level from the bottom, row by row from the top. Raises Mistake."""
    values, number, name = _begun(element)
    shape = tuple(values.integers("dimension"))
    if len(shape) not in (2, 3) or min(shape) < 1:
        raise values.mistake(f"dimension must be two or three integers > 0, got {values.text('dimension')!r}")
    lower_left = values.numbers("lower_left", len(shape))
    pitch = _pitch(values, len(shape))
    columns, rows, levels = (*shape, 1)[:3]
    indices: Iterable[Index] = (
        (i, j, k)[: len(shape)] for k, j, i in product(range(levels), reversed(range(rows)), range(columns))
    )
    universes = _universes(values, columns * rows * levels, f"a lattice of {' x '.join(map(str, shape))}", indices)
    outer = values.optional_integer("outer")
    return RectangularLattice(number, name, outer, universes, element, shape, lower_left, pitch)


def read_hexagonal(element: Element) -> HexagonalLattice:
    """Universes are listed level by level from the bottom, each as in `ring_order`. Raises Mistake."""
    values, number, name = _begun(element)
    rings, levels = values.integer("n_rings"), values.optional_integer("n_axial")
    if rings < 1 or (levels is not None and levels < 1):
        raise values.mistake(f"n_rings and n_axial must be > 0, got {rings if rings < 1 else levels}")
    orientation = values.text("orientation") or "y"
    if orientation not in ("x", "y"):
        raise values.mistake(f"orientation must be x or y, got {orientation!r}")
    flat = levels is None
    center = values.numbers("center", 2 if flat else 3)
    pitch = _pitch(values, 1 if flat else 2)
    count = (3 * rings * (rings - 1) + 1) * (levels or 1)
    what = f"a hexagonal lattice of {rings} rings" + ("" if flat else f" and {levels} levels")
    words = values.required("universes").split()
    # Counted before the indices are made: the number of rings may be absurd
    if len(words) != count:
        raise values.mistake(f"universes: {what} needs {count}, got {len(words)}")
    order = ring_order(rings, orientation)
    indices: Iterable[Index] = order if flat else ((i, j, k) for k in range(levels or 1) for i, j in order)
    x, y, z = (*center, Fraction(0))[:3]
    return HexagonalLattice(
        number, name, values.optional_integer("outer"), _universes(values, count, what, indices), element,
        rings, orientation, (x, y, z), pitch[0], None if flat else pitch[1], levels or 1,
    )  # fmt: skip


def _begun(element: Element) -> tuple[Values, int, str]:
    values = Values(element, "lattice")
    number = values.integer("id")
    name = values.text("name") or ""
    values.where = titled("lattice", number, name)
    return values, number, name


def _pitch(values: Values, count: int) -> tuple[Fraction, ...]:
    pitch = values.numbers("pitch", count)
    if min(pitch) <= 0:
        raise values.mistake(f"pitch must be > 0, got {float(min(pitch)):g}")
    return pitch


def _universes(values: Values, count: int, what: str, indices: Iterable[Index]) -> dict[Index, int]:
    numbers = values.integers("universes")
    if len(numbers) != count:
        raise values.mistake(f"universes: {what} needs {count}, got {len(numbers)}")
    return dict(zip(indices, numbers, strict=True))
