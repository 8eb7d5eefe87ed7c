"""The named coefficients of a quadric, an immutable mapping, and its symmetric matrix."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any, NoReturn, TypeAlias

from .._util.validation import check_number, format_value

COEFFICIENT_NAMES = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
_PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2)} | {
    "x": (0, 3),
    "y": (1, 3),
    "z": (2, 3),
    "constant": (3, 3),
}

Symmetric: TypeAlias = tuple[tuple[Fraction, ...], ...]


class Coefficients(dict[str, float]):
    """The nonzero coefficients in the order of `COEFFICIENT_NAMES`, a dict that is hashable and immutable."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__({name: values[name] for name in COEFFICIENT_NAMES if values.get(name, 0.0) != 0})

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))

    def __reduce__(self) -> tuple[Any, ...]:
        return Coefficients, (dict(self),)

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("Coefficients cannot be changed")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse


def check_coefficients(owner: str, value: Any) -> Coefficients:
    """Return a mapping from names to numbers as `Coefficients`. Missing ones are 0; unknown names raise ValueError."""
    if not isinstance(value, Mapping):
        raise ValueError(
            f"{owner}: coefficients must be a mapping such as {{'xx': 1, 'constant': -1}}, got {format_value(value)}"
        )
    for name in value:
        if name not in COEFFICIENT_NAMES:
            raise ValueError(
                f"{owner}: coefficients must be named {', '.join(COEFFICIENT_NAMES)}, got {format_value(name)}"
            )
    return Coefficients({name: check_number(owner, f"coefficients.{name}", value[name]) for name in value})


def matrix_of_coefficients(values: Mapping[str, float]) -> Symmetric:
    """Return the symmetric 4 × 4 matrix; half of a mixed or linear coefficient is on either side of the diagonal."""
    rows = [[Fraction(0)] * 4 for _ in range(4)]
    for name, value in values.items():
        i, j = _PLACES[name]
        rows[i][j] += Fraction(value) / 2
        rows[j][i] += Fraction(value) / 2
    return tuple(tuple(row) for row in rows)


def symmetric_part(matrix: Iterable[Iterable[float]]) -> Symmetric:
    """Return (Q + Qᵀ) / 2, exact."""
    rows = [[Fraction(value) for value in row] for row in matrix]
    return tuple(tuple((rows[i][j] + rows[j][i]) / 2 for j in range(4)) for i in range(4))
