"""Cemented lenses: elements of one axis that share their walls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .body import Body
from .calls import explained_methods
from .fixed import fixed
from .lens import Lens
from .looks import glass
from .material import Material
from .validate import number, positive, shown, what


@fixed
@explained_methods
@dataclass(frozen=True)
class LensGroup:
    """Elements cemented to each other: ``co.Scene([*group])`` has each of them as a body.

    radii: (n + 1,) radii of curvature, first to last, as of `Lens`; infinity is a plane.
    thicknesses: (n,) on the axis. diameter: of the edge, that of all elements.
    materials: (n,) materials, or refractive indices of glasses, or their names such as "N-BK7".
    conics: (n + 1,) conic constants, all 0 where left out. names: (n,) names of the bodies, or None.

    The wall between two elements is one surface of the scene: both say it by the same numbers, from the same vertex.
    So there is no gap and no overlap, and a ray that starts on it does not meet it again, whichever glass it goes into.
    The first vertex lies at the origin, the axis is z. Raises ValueError where an element would be none (see `Lens`).
    """

    radii: Sequence[float]
    thicknesses: Sequence[float]
    diameter: float
    materials: Sequence[Any]
    conics: Sequence[float] | None = None
    names: Sequence[str] | None = None

    def __post_init__(self) -> None:
        thicknesses = _row("thicknesses", self.thicknesses, None)
        n = len(thicknesses)
        object.__setattr__(self, "thicknesses", tuple(positive("LensGroup", "thicknesses", t) for t in thicknesses))
        radii = _row("radii", self.radii, n + 1)
        object.__setattr__(self, "radii", tuple(number("LensGroup", "radii", r, finite=False) for r in radii))
        conics = (0.0,) * (n + 1) if self.conics is None else _row("conics", self.conics, n + 1)
        object.__setattr__(self, "conics", tuple(number("LensGroup", "conics", k) for k in conics))
        object.__setattr__(self, "diameter", positive("LensGroup", "diameter", self.diameter))
        object.__setattr__(self, "materials", tuple(map(_material, _row("materials", self.materials, n))))
        if self.names is not None:
            names = _row("names", self.names, n)
            if not all(isinstance(name, str) and name for name in names):
                raise TypeError(f"LensGroup: names must be non-empty texts, got {shown(self.names)}")
            object.__setattr__(self, "names", names)
        _ = self.bodies

    def __len__(self) -> int:
        return len(self.thicknesses)

    def __iter__(self) -> Iterator[Body]:
        return iter(self.bodies)

    @property
    def lenses(self) -> tuple[Lens, ...]:
        """The elements, each where it stands."""
        return tuple(body.shape for body in self.bodies)  # type: ignore[misc]

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The elements with their materials, first to last."""
        made = []
        for i in range(len(self)):
            (front, back), (first, second) = self.radii[i : i + 2], (self.conics or ())[i : i + 2]
            try:
                lens = Lens(front, back, self.thicknesses[i], self.diameter, first, second)
            except ValueError as error:
                raise ValueError(f"LensGroup: radii, thicknesses, diameter and conics: element {i}: {error}") from None
            for thickness in self.thicknesses[:i]:
                lens = lens.translate((0.0, 0.0, thickness))
            made.append(Body(lens, self.materials[i], None if self.names is None else self.names[i]))
        return tuple(made)


def Doublet(
    radii: Sequence[float],
    thicknesses: Sequence[float],
    diameter: float,
    materials: Sequence[Any],
    conics: Sequence[float] | None = None,
    names: Sequence[str] | None = None,
) -> LensGroup:
    """A cemented doublet: a `LensGroup` of two elements.

    radii: (3,) radii of curvature. thicknesses: (2,) on the axis. diameter: of the edge.
    materials: (2,) materials, refractive indices or names of glasses. conics: (3,) conic constants. names: (2,) names.
    Raises ValueError as `LensGroup` does.
    """
    if len(_row("thicknesses", thicknesses, None)) != 2:
        raise ValueError(f"Doublet: thicknesses must be 2 numbers, got {shown(thicknesses)}")
    return LensGroup(radii, thicknesses, diameter, materials, conics, names)


def _row(field: str, value: Any, count: int | None) -> tuple[Any, ...]:
    """A sequence of so many entries, or of any number but none."""
    if not isinstance(value, list | tuple | np.ndarray) or (isinstance(value, np.ndarray) and value.ndim != 1):
        raise TypeError(f"LensGroup: {field} must be a list, got {what(value)}")
    row = tuple(value)
    if len(row) != (count or len(row)) or not row:
        wanted = "1 or more entries" if count is None else f"{count} entries to go with thicknesses"
        raise ValueError(f"LensGroup: {field} must be {wanted}, got {len(row)}")
    return row


def _material(value: Any) -> Material:
    """A material; anything else is the refractive index of a glass, by a number, a name or a formula."""
    if isinstance(value, Material):
        return value
    return glass(value if isinstance(value, str) or callable(value) else positive("LensGroup", "materials", value))
