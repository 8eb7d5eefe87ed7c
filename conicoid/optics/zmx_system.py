"""What a Zemax lens file says becomes a prescription."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from . import paraxial
from .prescriptions import Prescription, prescription
from .row_media import D_LINE
from .rows import Row

if TYPE_CHECKING:
    from .zmx import Lens, Surface

_CONICS = ("STANDARD",)
_ASPHERES = ("EVENASPH", "ODDASPHE", "XASPHERE", "XOASPHER")
_ANGLE, _HEIGHT = 0, 1


def system_of(lens: Lens, medium: Callable[[Surface], Any]) -> Prescription:
    """The prescription of a file; `medium` says what stands behind a surface with glass."""
    for surface in lens.surfaces:
        _check_kind(surface)
    rows = [_row(surface, medium) for surface in lens.surfaces[1:-1]]
    distance = lens.surfaces[0].thickness
    waves = _wavelengths(lens)
    system = prescription(rows, 1.0, object_distance=_far(distance), wavelengths=waves, name=lens.name)
    aperture = _aperture(lens, system)
    fields = _fields(lens, system)
    found = prescription(
        rows, aperture, object_distance=_far(distance), wavelengths=waves, fields=fields, name=lens.name
    )
    return replace(found, left_out=tuple(lens.notes))


def _far(distance: float) -> float:
    """The distance of the object: none, or one beyond a light year, is that of a star."""
    return distance if 0 < distance < 1e10 else math.inf


def _check_kind(surface: Surface) -> None:
    """Refuse surfaces that are no conics."""
    from .zmx import Refused

    line, where = surface.kind_line or surface.line, f"surface {surface.number}: TYPE"
    terms = [(key, line) for key, (value, line) in surface.parameters.items() if value != 0]
    if surface.kind in _CONICS:
        return
    if surface.kind in _ASPHERES:
        if terms:
            told = f"has the aspheric term PARM {terms[0][0][:8]}, which makes it no conic"
            raise Refused(terms[0][1], where, f"{surface.kind} {told}")
        return
    supported = f"only conics are: {', '.join((*_CONICS, *_ASPHERES))} (these without aspheric terms)"
    raise Refused(line, where, f"{surface.kind[:40]!r} is not supported; {supported}")


def _row(surface: Surface, medium: Callable[[Surface], Any]) -> Row:
    from .zmx import Refused

    behind = medium(surface) if surface.glass else None
    thickness = surface.thickness
    if math.isinf(thickness):
        raise Refused(surface.line, f"surface {surface.number}: DISZ", "must be finite, but for the object's")
    radius = 1 / surface.curvature if surface.curvature else math.inf
    reflects = behind == "mirror"
    try:
        return Row(
            radius, thickness, behind, 2 * abs(surface.semi) or None, surface.conic, surface.stop,
            2 * surface.hole if reflects else 0.0, surface.comment,
        )  # fmt: skip
    except (TypeError, ValueError) as error:
        raise Refused(surface.line, f"surface {surface.number}", str(error)) from None


def _wavelengths(lens: Lens) -> tuple[float, ...]:
    """The wavelengths that count, the primary one first."""
    count = lens.wave_count or max(lens.waves, default=1)
    waves = [lens.waves[i] for i in sorted(lens.waves) if i <= min(count, 24) and lens.waves[i] > 0]
    primary = lens.waves.get(lens.primary, waves[0] if waves else D_LINE)
    return (primary, *(wave for wave in waves if wave != primary))


def _focal_length(system: Prescription) -> float:
    bend = paraxial.through(system.thin(system.wavelength))[2]
    return -1 / bend if bend else math.inf


def _aperture(lens: Lens, system: Prescription) -> float | None:
    """The diameter of the entrance pupil; None: that of the stop's image."""
    kind, value = lens.aperture or ("FLOA", 0.0)
    if kind == "ENPD":
        return value
    if kind == "FNUM":
        return abs(_focal_length(system)) / value
    if kind == "OBNA" and not math.isinf(system.object_distance) and value < 1:
        return 2 * (system.object_distance + system.pupil) * math.tan(math.asin(value))
    return None


def _fields(lens: Lens, system: Prescription) -> tuple[float, ...]:
    """Angles, or heights of a near object."""
    given = lens.fields[: max(1, min(lens.field_count, 24))] or [0.0]
    far = math.isinf(system.object_distance)
    if lens.field_kind == (_ANGLE if far else _HEIGHT):
        return tuple(given)
    if far and lens.field_kind > _HEIGHT:  # heights of the image
        f = _focal_length(system)
        return tuple(math.degrees(math.atan(height / f)) for height in given)
    if not far and lens.field_kind == _ANGLE:
        return tuple(-math.tan(math.radians(angle)) * (system.object_distance + system.pupil) for angle in given)
    lens.notes.append(f"fields of the type {lens.field_kind} are passed over")
    return (0.0,)
