"""Prescriptions: the rows of a lens system, its bodies as a scene, and its paraxial rays, by matrices.

The state of a ray is (y, n u), with n below 0 where light travels along -z, so that mirrors are surfaces like others.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, fields
from functools import cached_property
from typing import Any, TypeAlias

from ..._util.records import dataclass
from ..._util.text import check_choice, html_table
from ..._util.validation import (
    check_fields,
    check_flag,
    check_nonnegative,
    check_number,
    check_positive,
    describe_kind,
    format_value,
    optional,
)
from ...geometry.body import Body
from ...geometry.conic import ConicSheet, Stop, check_radius
from ...geometry.optical_elements import Lens, coat_faces
from ...geometry.shape import Shape
from ...materials.coating import Coating
from ...materials.dispersion import LINE_D
from ...materials.presets import matte, mirror
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike
from .medium import AIR, MIRROR, Medium, check_wavelength, parse_medium

Matrix: TypeAlias = tuple[float, float, float, float]
"""A, B, C, D of y' = A y + B nu, nu' = C y + D nu."""

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ParaxialSurface:
    """A surface for paraxial rays: curvature, the signed indices before and behind it, the thickness that follows."""

    curvature: float
    before: float
    behind: float
    thickness: float

    @property
    def bend(self) -> Matrix:
        """The refraction: nu' = nu - (n' - n) c y."""
        return 1.0, 0.0, -(self.behind - self.before) * self.curvature, 1.0

    @property
    def gap(self) -> Matrix:
        """The way to the next surface: y' = y + (t / n') nu'."""
        return 1.0, self.thickness / self.behind, 0.0, 1.0


def multiply(second: Matrix, first: Matrix) -> Matrix:
    """Return the matrix of `first`, then `second`."""
    a, b, c, d = second  # row by row
    e, f, g, h = first
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


def matrix_to_vertex(surfaces: Sequence[ParaxialSurface], last: int) -> Matrix:
    """Return the matrix from before the first surface to the vertex of surface `last`, before its refraction."""
    matrix = IDENTITY
    for surface in surfaces[:last]:
        matrix = multiply(surface.gap, multiply(surface.bend, matrix))
    return matrix


def system_matrix(surfaces: Sequence[ParaxialSurface]) -> Matrix:
    """Return the matrix from before the first surface to behind the last one."""
    return multiply(surfaces[-1].bend, matrix_to_vertex(surfaces, len(surfaces) - 1))


def focus(surfaces: Sequence[ParaxialSurface], object_distance: float) -> float:
    """Return the distance along z from the last vertex to the image of an object on the axis; infinite for none."""
    a, b, c, d = system_matrix(surfaces)
    # A ray parallel to the axis, or one from the object's point on the axis.
    y, nu = (1.0, 0.0) if math.isinf(object_distance) else (object_distance / surfaces[0].before, 1.0)
    height, slope = a * y + b * nu, c * y + d * nu
    return -height * surfaces[-1].behind / slope if slope else math.inf


def entrance_pupil(surfaces: Sequence[ParaxialSurface], stop: int) -> tuple[float, float]:
    """Return (z of the stop's image in front, from the first vertex; diameter of the stop over that of this image)."""
    a, b, _, _ = matrix_to_vertex(surfaces, stop)
    # The stop lies in the focal plane of the surfaces before it.
    if a == 0:
        raise ValueError("prescription: the entrance pupil lies at infinity: rows must have another stop")
    return b * surfaces[0].before / a, abs(a)


def heights(surfaces: Sequence[ParaxialSurface], y: float, nu: float) -> list[float]:
    """Return the heights of a ray at all vertices, from its state at the first one."""
    heights_at_vertices = []
    for last in range(len(surfaces)):
        a, b, _, _ = matrix_to_vertex(surfaces, last)
        heights_at_vertices.append(a * y + b * nu)
    return heights_at_vertices


# Prescriptions: the rows of a lens system, one surface each, and its bodies as a scene.

MOST_ROWS = 1000
PLACES = ("radius", "thickness", "medium", "diameter", "conic")
"""The fields of a row that is written as a list, in order."""


@dataclass(frozen=True)
class Row:
    """One surface of a prescription.

    Parameters
    ----------
    radius : float
        Of curvature, over 0 if the centre lies at +z; infinity for a plane.
    thickness : float, optional
        Along z to the next vertex, below 0 after an odd number of mirrors. Of the last row to the image; None is the
        paraxial focus.
    medium : optional
        Behind the surface: None for air, a refractive index, (index at d, Abbe number), a function of the wavelength in
        μm, or the name of a glass; "mirror" for a surface that reflects.
    diameter : float, optional
        Of the surface; the default is the width of the beams.
    conic : float
        The conic constant.
    stop : bool
        Whether it is the aperture stop.
    hole : float
        Diameter of the hole of a mirror.
    name : str
        Name of the surface.
    coating : Coating, optional
        Of a surface of glass, its outermost film first; on a cemented one, as seen from behind.
    """

    radius: float = math.inf
    thickness: float | None = 0.0
    medium: Any = None
    diameter: float | None = None
    conic: float = 0.0
    stop: bool = False
    hole: float = 0.0
    name: str = ""
    coating: Coating | None = None

    def __post_init__(self) -> None:
        check_fields(
            self,
            radius=check_radius,
            thickness=optional(check_number),
            conic=check_number,
            stop=check_flag,
            hole=check_nonnegative,
            diameter=optional(check_positive),
        )
        if not self.reflects:
            check_fields(self, medium=parse_medium)
        if not isinstance(self.name, str):
            raise TypeError(f"Row: name must be a text, got {describe_kind(self.name)}")
        if self.coating is not None and (self.reflects or not isinstance(self.coating, Coating)):
            expected = "None for a mirror" if self.reflects else "a co.optics.Coating or None"
            raise ValueError(f"Row: coating must be {expected}, got {format_value(self.coating)}")

    @property
    def reflects(self) -> bool:
        """Whether it is a mirror."""
        return isinstance(self.medium, str) and self.medium.lower() == MIRROR

    @property
    def behind(self) -> Medium | None:
        """The medium behind it; None for a mirror, which leaves light in the medium before it."""
        return self.medium if isinstance(self.medium, Medium) else None


def parse_rows(owner: str, values: Any) -> tuple[Row, ...]:
    """Return rows from `Row`s, mappings of their fields, and lists (radius, thickness, medium, diameter, conic)."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise TypeError(f"{owner}: rows must be a list of rows, got {describe_kind(values)}")
    rows: list[Row] = []
    for i, one in enumerate(values):
        if i >= MOST_ROWS:
            raise ValueError(f"{owner}: rows must be {MOST_ROWS} at most, got more")
        rows.append(_parse_row(owner, i, one))
    if not rows:
        raise ValueError(f"{owner}: rows must hold at least one surface, got none")
    stops = [i for i, row in enumerate(rows) if row.stop]
    if len(stops) > 1:
        raise ValueError(f"{owner}: rows must have one stop at most, got {len(stops)}: {stops}")
    unknown = [i for i, row in enumerate(rows[:-1]) if row.thickness is None]
    if unknown:
        raise ValueError(f"{owner}: rows[{unknown[0]}]: thickness may be None in the last row alone, as to the image")
    return tuple(rows)


def _parse_row(owner: str, i: int, item: Any) -> Row:
    """Return a row from any of its forms."""
    if isinstance(item, Row):
        return item
    names = [field.name for field in fields(Row)]
    if isinstance(item, Mapping):
        arguments = {check_choice(owner, f"rows[{i}]: a key", key, names): value for key, value in item.items()}
    elif isinstance(item, list | tuple) and 0 < len(item) <= len(PLACES):
        arguments = dict(zip(PLACES, item, strict=False))
    else:
        expected = f"a Row, a mapping of its fields, or a list ({', '.join(PLACES)})"
        raise TypeError(f"{owner}: rows[{i}] must be {expected}, got {format_value(item)}")
    try:
        return Row(**arguments)
    except (TypeError, ValueError) as error:
        raise type(error)(f"{owner}: rows[{i}]: {error}") from None


# The bodies of a prescription, and the faces of each row.

FRONT, BACK = 0, 1
_SCREEN = 1.5
"""Diameter of the screen of a stop, over that of the widest surface or of its opening."""


@dataclass(frozen=True)
class Elements:
    """`bodies`, and for each row its (body, face) pairs; none for a mere plane in air."""

    bodies: tuple[Body, ...]
    faces: tuple[tuple[tuple[int, int], ...], ...]


def build_elements(system: Prescription) -> Elements:
    """Build lenses between neighbouring rows with glass between them, mirrors, and a screen around a stop in air."""
    bodies: list[Body] = []
    faces: list[list[tuple[int, int]]] = [[] for _ in system.rows]
    lenses, mirrors = itertools.count(1), itertools.count(1)
    for i, row in enumerate(system.rows):
        if row.reflects:
            if not system.media[i].is_air:
                raise ValueError(f"prescription: rows[{i}]: a mirror in glass (a Mangin mirror) is not supported")
            faces[i].append((len(bodies), 0))
            bodies.append(Body(row_sheet(system, i), mirror(), f"mirror {next(mirrors)}"))
        elif not system.media[i + 1].is_air:
            _check_element(system, i)
            # Behind a mirror, light travels along -z and enters by the back.
            first, second = (FRONT, BACK) if (row.thickness or 0.0) > 0 else (BACK, FRONT)
            faces[i].append((len(bodies), first))
            faces[i + 1].append((len(bodies), second))
            coats = {first: row.coating, second: system.rows[i + 1].coating}
            material = system.media[i + 1].material()
            bodies.append(Body(coat_faces(_lens(system, i), material, coats), material, f"lens {next(lenses)}"))
        # A stop on glass needs no screen: `trace` tests its diameter.
        elif row.stop and system.media[i].is_air:
            opening = system.diameters[i]
            screen = Stop(opening, _SCREEN * max(opening, *system.diameters))
            bodies.append(Body(_translate_row(screen, system, i), matte("black"), "stop"))
    bare = [i for i, row in enumerate(system.rows) if row.coating is not None and not faces[i]]
    if bare:
        raise ValueError(f"prescription: rows[{bare[0]}]: coating must be None where there is no glass")
    return Elements(tuple(bodies), tuple(map(tuple, faces)))


def row_sheet(system: Prescription, i: int, *, whole: bool = False) -> ConicSheet:
    """Return the surface of a row as an open sheet; `whole` without its hole."""
    row = system.rows[i]
    sheet = ConicSheet(row.radius, row.conic, system.diameters[i], 0.0 if whole else row.hole)
    return _translate_row(sheet, system, i)


def _check_element(system: Prescription, i: int) -> None:
    """Refuse glass without a second surface, and without a thickness."""
    if i + 1 == len(system.rows):
        raise ValueError(f"prescription: rows[{i}]: the last medium must be air, got {system.media[i + 1].name}")
    if not system.rows[i].thickness:
        raise ValueError(f"prescription: rows[{i}]: thickness must not be 0 in {system.media[i + 1].name}")


def _group(system: Prescription, i: int) -> tuple[int, int]:
    """Return (first row, last row) of the cemented group with the glass behind row i."""
    first, last = i, i + 1
    while first and not system.media[first].is_air and not system.rows[first].reflects:
        first -= 1
    while last < len(system.rows) - 1 and not system.media[last + 1].is_air and not system.rows[last].reflects:
        last += 1
    return first, last


def _lens(system: Prescription, i: int) -> Any:
    """Return the element behind row i, as wide as the widest surface of its group; narrower ones get flat rings."""
    first, last = _group(system, i)
    edge = max(system.diameters[first : last + 1])
    thickness = system.rows[i].thickness or 0.0
    low, high = (i, i + 1) if thickness > 0 else (i + 1, i)
    front, back = system.rows[low], system.rows[high]
    # Surfaces narrower than the group get a flat ring up to its edge.
    apertures = [None if system.diameters[k] == edge else system.diameters[k] for k in (low, high)]
    try:
        lens = Lens(front.radius, back.radius, abs(thickness), edge, front.conic, back.conic, *apertures)
    except ValueError as error:
        raise ValueError(f"prescription: rows[{i}] and rows[{i + 1}]: {error}") from None
    if thickness < 0:
        lens = lens.translate((0.0, 0.0, thickness))
    return _translate_row(lens, system, i, first)


def _translate_row(shape: Shape, system: Prescription, i: int, first: int | None = None) -> Any:
    """Move a shape to the vertex of row i, by one thickness after the other, so that nothing is rounded."""
    start = i if first is None else first
    for row in system.rows[start:i]:
        shape = shape.translate((0.0, 0.0, row.thickness or 0.0))
    return shape.translate((0.0, 0.0, system.vertices[start])) if system.vertices[start] else shape


# The prescription: a sequence of surfaces, and its scene of lenses, mirrors and a stop.

_ROOM = 1.05
"""Width of a surface without a diameter, over that of its beams."""
_REACH = 0.98
"""Share of the reach of a conic that such a surface may use."""


@dataclass(frozen=True)
class Prescription:
    """A sequence of surfaces on the z axis, the first vertex at the origin, and its scene.

    `scene`: the lenses, cemented if they touch, with their glasses; mirrors as thin sheets; a black stop.
    `vertices`: the z of each row. `image`: the z of the image plane. `pupil`: the z of the entrance pupil.

    Parameters
    ----------
    rows : tuple of Row
        The surfaces.
    aperture : float
        Diameter of the entrance pupil.
    object_distance : float
        From the object to the first vertex, infinite as a rule.
    wavelengths : tuple of float
        In μm, the primary one first.
    fields : tuple of float
        Degrees off the axis, towards +y; of a near object its heights.
    name : str
        Name of the system.
    omissions : tuple of str
        Notes on parts of a lens file that were skipped.
    unit : str, optional
        Of lengths, as for `Scene`; lens files state it.
    """

    rows: tuple[Row, ...]
    aperture: float
    object_distance: float = math.inf
    wavelengths: tuple[float, ...] = (LINE_D,)
    fields: tuple[float, ...] = (0.0,)
    name: str = ""
    omissions: tuple[str, ...] = field(default=(), repr=False)
    unit: str | None = None

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows: a row for each surface."""
        columns = [name.name for name in fields(Row)]
        rows = ([getattr(row, column) for column in columns] for row in self.rows)
        return html_table(columns, rows, len(self.rows))

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
        media = [AIR]
        for row in self.rows:
            media.append(row.behind or media[-1])
        return tuple(media)

    @cached_property
    def image(self) -> float:
        """The z of the image plane: by the last thickness, else at the paraxial focus of the primary wavelength."""
        last = self.rows[-1].thickness
        if last is None:
            last = focus(self.thin(self.wavelength), self.object_distance)
        return self.vertices[-1] + last

    @property
    def stop(self) -> int:
        """The number of the row with the stop; the first row by default."""
        return next((i for i, row in enumerate(self.rows) if row.stop), 0)

    @cached_property
    def pupil(self) -> float:
        """The z of the entrance pupil, the image of the stop by the surfaces before it; the first vertex is 0."""
        return entrance_pupil(self.thin(self.wavelength), self.stop)[0]

    def thin(self, wavelength: float) -> list[ParaxialSurface]:
        """Return the surfaces for paraxial rays.

        Parameters
        ----------
        wavelength : float
            In μm.

        Returns
        -------
        list of ParaxialSurface
        """
        wavelength = check_wavelength("Prescription", wavelength)
        surfaces, side, before = [], 1.0, self.media[0].index(wavelength)
        for row, medium in zip(self.rows, self.media[1:], strict=True):
            # Behind a mirror light travels the other way, and indices change their sign.
            side = -side if row.reflects else side
            index_behind = side * medium.index(wavelength)
            surfaces.append(ParaxialSurface(1 / row.radius, before, index_behind, row.thickness or 0.0))
            before = index_behind
        return surfaces

    @cached_property
    def diameters(self) -> tuple[float, ...]:
        """The diameter of each surface: its own, or the width of the paraxial beams of all fields."""
        return tuple(row.diameter or self._beam_diameters[i] for i, row in enumerate(self.rows))

    @cached_property
    def _beam_diameters(self) -> tuple[float, ...]:
        """The diameters that the paraxial beams of all fields need."""
        thin = self.thin(self.wavelength)
        far = math.isinf(self.object_distance)
        half, distance = self.aperture / 2, self.object_distance + self.pupil
        # Slope of the chief ray: by the angle, or from the height of a near object.
        tilt = math.tan(math.radians(max(map(abs, self.fields)))) if far else -max(map(abs, self.fields)) / distance
        slope = 0.0 if far else half / distance
        beam = heights(thin, half - slope * self.pupil, slope)
        chief = heights(thin, -tilt * self.pupil, tilt)
        # The marginal and the chief ray add up to the half width of all beams.
        wide = [2 * _ROOM * (abs(a) + abs(b)) or self.aperture for a, b in zip(beam, chief, strict=True)]
        return tuple(min(one, _widest(row)) for one, row in zip(wide, self.rows, strict=True))

    @cached_property
    def elements(self) -> Elements:
        """The bodies, and the faces of each row."""
        return build_elements(self)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Lenses, mirrors and the stop, in the order of the light."""
        return self.elements.bodies

    @cached_property
    def scene(self) -> SceneLike:
        """The bodies as a scene."""
        return extension("Scene")(self.bodies, unit=self.unit)

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        return f"Prescription({name}{len(self.rows)} surfaces, {len(self.bodies)} bodies, aperture {self.aperture:g})"


def _widest(row: Row) -> float:
    """Return the diameter up to which the conic of a row without a diameter is used."""
    # Planes, paraboloids and hyperboloids have points at every height.
    return (
        math.inf
        if math.isinf(row.radius) or row.conic <= -1
        else 2 * _REACH * abs(row.radius) / math.sqrt(1 + row.conic)
    )


def prescription(
    rows: Iterable[Row | Mapping[str, Any] | Sequence[Any]],
    aperture: float | None = None,
    *,
    object_distance: float = math.inf,
    wavelengths: float | Sequence[float] = (LINE_D,),
    fields: float | Sequence[float] = (0.0,),
    name: str = "",
) -> Prescription:
    """Make a `Prescription`, whose `scene` holds the lenses, from a sequence of surfaces.

    Parameters
    ----------
    rows : sequence
        One item for each surface: a `Row`, a mapping of its fields, or a list (radius, thickness, medium, diameter,
        conic), which may end early.
    aperture : float, optional
        Diameter of the entrance pupil; the default is that of the stop's image, for a stop of known diameter.
    object_distance : float
        From the object to the first vertex.
    wavelengths : float or sequence of float
        In μm, the primary one first.
    fields : float or sequence of float
        Degrees off the axis; of a near object its heights.
    name : str
        Name of the system.

    Returns
    -------
    Prescription

    Raises
    ------
    ValueError, TypeError
        By row and field, for rows that make no lens.
    """
    owner = "prescription"
    surfaces = parse_rows(owner, rows)
    waves = tuple(check_wavelength(owner, one) for one in _several(owner, "wavelengths", wavelengths))
    angles = tuple(check_number(owner, "fields", one) for one in _several(owner, "fields", fields))
    distance = check_number(owner, "object_distance", object_distance, finite=False)
    if not distance > 0:
        raise ValueError(f"{owner}: object_distance must be > 0, got {distance}")
    if math.isinf(distance) and max(map(abs, angles)) >= 90:
        raise ValueError(f"{owner}: fields must be below 90 degrees, got {format_value(fields)}")
    if aperture is not None:
        aperture = check_positive(owner, "aperture", aperture)
    # The pupil of the stop needs a system: build one with any aperture first.
    system = Prescription(surfaces, aperture or 1.0, distance, waves, angles, name)
    if aperture is None:
        stop = surfaces[system.stop]
        if stop.diameter is None:
            raise ValueError(f"{owner}: aperture must be given where rows have no stop of known diameter")
        wider = entrance_pupil(system.thin(system.wavelength), system.stop)[1]
        system = Prescription(surfaces, stop.diameter / wider, distance, waves, angles, name)
    if math.isinf(system.image):
        raise ValueError(f"{owner}: rows: the last thickness must be given: paraxial rays meet nowhere")
    _ = system.elements  # build the lenses now, so that their errors come here
    return system


def _several(owner: str, name: str, value: Any) -> tuple[Any, ...]:
    """Return one number or some numbers as a tuple."""
    if isinstance(value, str | bytes | dict | set):
        raise TypeError(f"{owner}: {name} must be numbers, got {format_value(value)}")
    try:
        numbers = tuple(value)
    except TypeError:
        numbers = (value,)
    if not numbers or len(numbers) > 100:
        raise ValueError(f"{owner}: {name} must be 1 to 100 numbers, got {len(numbers)}")
    return numbers
