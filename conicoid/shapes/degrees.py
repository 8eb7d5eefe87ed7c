"""Angles, which are in degrees everywhere; what is in radians beyond doubt is warned of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .validate import number
from .vector import FloatArray
from .warned import warn

_MOST = 4 * math.pi
_STEP = math.pi / 1800
"""A tenth of a degree, in radians."""
_ROUNDINGS = 3
"""Of math.radians, of π / 6, of 2 * (π / 3)."""


def degrees(owner: str, field: str, value: Any) -> float:
    """`value` as a finite float; a UserWarning where it is a plain angle in radians to the last bits."""
    angle = number(owner, field, value)
    if is_of_radians(angle) or (isinstance(value, np.float32) and _is_of_radians32(value)):
        warn(f"{owner}: {field} must be in degrees, got {angle!r}: {_meant(angle)} degrees are that in radians")
    return angle


def turn(owner: str, start_angle: Any, end_angle: Any) -> tuple[float, float]:
    """Two angles as floats, from the first counter-clockwise to the last: their difference is in (0, 360]."""
    first, last = degrees(owner, "start_angle", start_angle), degrees(owner, "end_angle", end_angle)
    if not 0 < last - first <= 360:
        raise ValueError(f"{owner}: end_angle - start_angle must be in (0, 360], got {last} - {first} = {last - first}")
    return first, last


def warn_of_radians(owner: str, field: str, values: Any) -> None:
    """A UserWarning where one of several angles, which are to be in degrees, is a plain one in radians.

    All of them must be within two turns in radians, as those of a scan in radians are.
    """
    given = np.asarray(values)
    if given.dtype.kind != "f" or not given.size or np.abs(given).max() > _MOST * (1 + 1e-6):
        return
    is_plain = (lambda angle: _is_of_radians32(np.float32(angle))) if given.dtype == np.float32 else is_of_radians
    found = next((angle for angle in given.ravel().tolist() if is_plain(angle)), None)
    if found is not None:
        warn(f"{owner}: {field} must be in degrees, got {found!r}: {_meant(found)} degrees are that in radians")


def warn_of_degrees(owner: str, field: str, angles: FloatArray) -> None:
    """A UserWarning where one of several angles, which are to be in radians, is a whole number beyond a turn."""
    found = angles[(np.abs(angles) > 2 * math.pi) & (angles == np.round(angles))]
    if len(found):
        warn(f"{owner}: {field} must be in radians, got {found[0]:g}: np.radians(angles) makes them of degrees")


def is_of_radians(angle: float) -> bool:
    """Whether a number is, but for rounding, tenths of a degree in radians: no number of degrees is by chance.

    Of all decimals up to 4π with six digits after the point or fewer none is: π has no such multiples.
    """
    size = abs(angle)
    if not _STEP / 2 < size <= _MOST * (1 + 1e-12):
        return False
    return abs(size - round(size / _STEP) * _STEP) <= _ROUNDINGS * math.ulp(size)


def _is_of_radians32(angle: np.float32) -> bool:
    """The same of float32, which holds fewer digits: only multiples of 15 degrees are told from others."""
    size, step = abs(float(angle)), math.pi / 12
    if not step / 2 < size <= _MOST * (1 + 1e-6):
        return False
    return abs(size - round(size / step) * step) <= 2 * float(np.spacing(np.float32(size)))


def _meant(angle: float) -> str:
    return f"{round(angle / _STEP) / 10:g}"
