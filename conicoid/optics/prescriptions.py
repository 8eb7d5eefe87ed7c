"""A sequence of surfaces becomes a scene of lenses, mirrors and a stop."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ..scene import Scene
from ..shapes.body import Body
from ..shapes.calls import explained, explained_methods
from ..shapes.fixed import fixed
from ..shapes.validate import number, positive, shown
from . import paraxial
from .elements import Elements, elements_of
from .paraxial import Thin
from .row_media import AIR, D_LINE, Medium, check_wavelength
from .rows import Row, rows_of

_ROOM = 1.05
"""How much wider than its beams a surface is made that nobody gave a diameter."""
_REACH = 0.98


@fixed
@explained_methods
@dataclass(frozen=True)
class Prescription:
    """A sequence of surfaces on the z axis, the first vertex at the origin, and the scene that it is.

    rows: the surfaces, as `Row`s. aperture: the diameter of the entrance pupil. object_distance: from the object to
    the first vertex, infinite as a rule. wavelengths: in μm, the first is the primary one. fields: angles in degrees
    off the axis, towards +y; of a near object its heights. name: what it is called.

    `scene`: the lenses, cemented where they touch, with their glasses; mirrors as thin sheets; a black stop.
    `vertices`: the z of each row. `image`: the z of the image plane. `pupil`: the z of the entrance pupil.
    """

    rows: tuple[Row, ...]
    aperture: float
    object_distance: float = math.inf
    wavelengths: tuple[float, ...] = (D_LINE,)
    fields: tuple[float, ...] = (0.0,)
    name: str = ""
    left_out: tuple[str, ...] = field(default=(), repr=False)

    @property
    def wavelength(self) -> float:
        """The primary wavelength, in μm."""
        return self.wavelengths[0]

    @cached_property
    def vertices(self) -> tuple[float, ...]:
        """The z of each vertex."""
        return tuple(math.fsum(row.thickness or 0.0 for row in self.rows[:i]) for i in range(len(self.rows)))

    @cached_property
    def media(self) -> tuple[Medium, ...]:
        """The medium before the first surface, and behind each of them."""
        found = [AIR]
        for row in self.rows:
            found.append(row.behind or found[-1])
        return tuple(found)

    @cached_property
    def image(self) -> float:
        """The z of the image plane: where the last row says, else where paraxial rays of the primary colour meet."""
        last = self.rows[-1].thickness
        if last is None:
            last = paraxial.focus(self.thin(self.wavelength), self.object_distance)
        return self.vertices[-1] + last

    @property
    def stop(self) -> int:
        """The number of the row that is the stop; the first row, where none is said to be."""
        return next((i for i, row in enumerate(self.rows) if row.stop), 0)

    @cached_property
    def pupil(self) -> float:
        """The z of the entrance pupil, the image of the stop by what stands before it; the first vertex is 0."""
        return paraxial.entrance_pupil(self.thin(self.wavelength), self.stop)[0]

    def thin(self, wavelength: float) -> list[Thin]:
        """The surfaces as paraxial rays see them, at a `wavelength` in μm."""
        surfaces, side, before = [], 1.0, self.media[0].index(wavelength)
        for row, medium in zip(self.rows, self.media[1:], strict=True):
            side = -side if row.reflects else side
            behind = side * medium.index(wavelength)
            surfaces.append(Thin(1 / row.radius, before, behind, row.thickness or 0.0))
            before = behind
        return surfaces

    @cached_property
    def diameters(self) -> tuple[float, ...]:
        """The diameter of each surface: as given, or what the paraxial beams of all fields need."""
        return tuple(row.diameter or self._needed[i] for i, row in enumerate(self.rows))

    @cached_property
    def _needed(self) -> tuple[float, ...]:
        thin = self.thin(self.wavelength)
        far = math.isinf(self.object_distance)
        half, distance = self.aperture / 2, self.object_distance + self.pupil
        tilt = math.tan(math.radians(max(map(abs, self.fields)))) if far else -max(map(abs, self.fields)) / distance
        slope = 0.0 if far else half / distance
        beam = paraxial.heights(thin, half - slope * self.pupil, slope)
        chief = paraxial.heights(thin, -tilt * self.pupil, tilt)
        wide = [2 * _ROOM * (abs(a) + abs(b)) or self.aperture for a, b in zip(beam, chief, strict=True)]
        return tuple(min(one, _widest(row)) for one, row in zip(wide, self.rows, strict=True))

    @cached_property
    def elements(self) -> Elements:
        """The bodies, and which of their faces light meets at which row."""
        return elements_of(self)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Lenses, mirrors and the stop, in the order in which light meets them."""
        return self.elements.bodies

    @cached_property
    def scene(self) -> Scene:
        """The bodies as a scene."""
        return Scene(self.bodies)

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        return f"Prescription({name}{len(self.rows)} surfaces, {len(self.bodies)} bodies, aperture {self.aperture:g})"


def _widest(row: Row) -> float:
    """The diameter up to which the conic of a row is used where none is given."""
    return (
        math.inf
        if math.isinf(row.radius) or row.conic <= -1
        else 2 * _REACH * abs(row.radius) / math.sqrt(1 + row.conic)
    )


@explained
def prescription(
    rows: Any,
    aperture: Any = None,
    *,
    object_distance: Any = math.inf,
    wavelengths: Any = (D_LINE,),
    fields: Any = (0.0,),
    name: str = "",
) -> Prescription:
    """A sequence of surfaces as a `Prescription`, whose `scene` holds the lenses.

    rows: one for each surface: a `Row`, a mapping of its fields, or a list (radius, thickness, medium, diameter,
    conic), of which the last ones may be left out.
    aperture: the diameter of the entrance pupil; left out, that of the stop's image, for a stop of known diameter.
    object_distance: from the object to the first vertex. wavelengths: in μm, the primary one first.
    fields: degrees off the axis; of a near object its heights. name: what it is called.
    Raises ValueError or TypeError, by row and field, for what is no lens.
    """
    owner = "prescription"
    made = rows_of(owner, rows)
    waves = tuple(check_wavelength(owner, one) for one in _several(owner, "wavelengths", wavelengths))
    angles = tuple(number(owner, "fields", one) for one in _several(owner, "fields", fields))
    distance = number(owner, "object_distance", object_distance, finite=False)
    if not distance > 0:
        raise ValueError(f"{owner}: object_distance must be > 0, got {distance}")
    if math.isinf(distance) and max(map(abs, angles)) >= 90:
        raise ValueError(f"{owner}: fields must be below 90 degrees, got {shown(fields)}")
    if aperture is not None:
        aperture = positive(owner, "aperture", aperture)
    found = Prescription(made, aperture or 1.0, distance, waves, angles, name)
    if aperture is None:
        stop = made[found.stop]
        if stop.diameter is None:
            raise ValueError(f"{owner}: aperture must be given where rows have no stop of known diameter")
        wider = paraxial.entrance_pupil(found.thin(found.wavelength), found.stop)[1]
        found = Prescription(made, stop.diameter / wider, distance, waves, angles, name)
    if math.isinf(found.image):
        raise ValueError(f"{owner}: rows: the last thickness must be given: paraxial rays meet nowhere")
    _ = found.elements
    return found


def _several(owner: str, name: str, value: Any) -> tuple[Any, ...]:
    """One number, or some of them."""
    if isinstance(value, str | bytes | dict | set):
        raise TypeError(f"{owner}: {name} must be numbers, got {shown(value)}")
    try:
        found = tuple(value)
    except TypeError:
        found = (value,)
    if not found or len(found) > 100:
        raise ValueError(f"{owner}: {name} must be 1 to 100 numbers, got {len(found)}")
    return found
