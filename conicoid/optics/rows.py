"""The rows of a prescription: one surface each, and what follows it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from ..shapes.conic_wall import radius_of
from ..shapes.suggestion import one_of
from ..shapes.validate import flag, nonnegative, number, positive, shown, what
from .row_media import MIRROR, Medium, medium

MOST_ROWS = 1000
PLACES = ("radius", "thickness", "medium", "diameter", "conic")
"""What the numbers of a row mean that is written as a list."""


@dataclass(frozen=True)
class Row:
    """One surface of a prescription.

    radius: of curvature, over 0 where the centre lies at +z; infinity for a plane.
    thickness: along z to the next vertex, below 0 after an odd number of mirrors; of the last row to the image, None
    for where paraxial rays meet.
    medium: behind the surface: None for air, a refractive index, (index at d, Abbe number), a function of the
    wavelength in μm, the name of a glass; "mirror" for a surface that reflects.
    diameter: of the surface; None: as large as the beams are. conic: the conic constant.
    stop: whether it is the aperture stop. hole: the diameter of a hole, of a mirror. name: what it is called.
    """

    radius: float = math.inf
    thickness: float | None = 0.0
    medium: Any = None
    diameter: float | None = None
    conic: float = 0.0
    stop: bool = False
    hole: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "radius", radius_of("Row", "radius", self.radius))
        if self.thickness is not None:
            put(self, "thickness", number("Row", "thickness", self.thickness))
        put(self, "conic", number("Row", "conic", self.conic))
        put(self, "stop", flag("Row", "stop", self.stop))
        put(self, "hole", nonnegative("Row", "hole", self.hole))
        if self.diameter is not None:
            put(self, "diameter", positive("Row", "diameter", self.diameter))
        if not self.reflects:
            put(self, "medium", medium("Row", "medium", self.medium))
        if not isinstance(self.name, str):
            raise TypeError(f"Row: name must be a text, got {what(self.name)}")

    @property
    def reflects(self) -> bool:
        """Whether it is a mirror."""
        return isinstance(self.medium, str) and self.medium.lower() == MIRROR

    @property
    def behind(self) -> Medium | None:
        """The medium behind it; None of a mirror, which leaves light in the one before."""
        return self.medium if isinstance(self.medium, Medium) else None


def rows_of(owner: str, given: Any) -> tuple[Row, ...]:
    """Rows from `Row`s, mappings of their fields, and lists (radius, thickness, medium, diameter, conic)."""
    if isinstance(given, str | bytes | Mapping) or not isinstance(given, Iterable):
        raise TypeError(f"{owner}: rows must be a list of rows, got {what(given)}")
    made: list[Row] = []
    for i, one in enumerate(given):
        if i >= MOST_ROWS:
            raise ValueError(f"{owner}: rows must be {MOST_ROWS} at most, got more")
        made.append(_row(owner, i, one))
    if not made:
        raise ValueError(f"{owner}: rows must hold at least one surface, got none")
    stops = [i for i, row in enumerate(made) if row.stop]
    if len(stops) > 1:
        raise ValueError(f"{owner}: rows must have one stop at most, got {len(stops)}: {stops}")
    unknown = [i for i, row in enumerate(made[:-1]) if row.thickness is None]
    if unknown:
        raise ValueError(f"{owner}: rows[{unknown[0]}]: thickness may be None in the last row alone, as to the image")
    return tuple(made)


def _row(owner: str, i: int, given: Any) -> Row:
    if isinstance(given, Row):
        return given
    names = [field.name for field in fields(Row)]
    if isinstance(given, Mapping):
        said = {one_of(owner, f"rows[{i}]: a key", key, names): value for key, value in given.items()}
    elif isinstance(given, list | tuple) and 0 < len(given) <= len(PLACES):
        said = dict(zip(PLACES, given, strict=False))
    else:
        expected = f"a Row, a mapping of its fields, or a list ({', '.join(PLACES)})"
        raise TypeError(f"{owner}: rows[{i}] must be {expected}, got {shown(given)}")
    try:
        return Row(**said)
    except (TypeError, ValueError) as error:
        raise type(error)(f"{owner}: rows[{i}]: {error}") from None
