"""Cameras that see more than a plane film can hold: all around, or a hemisphere and more in a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..shapes.calls import explained_methods
from ..shapes.degrees import degrees
from ..shapes.other_names import hinted
from ..shapes.rounded import sin_cos_degrees, tan_degrees
from ..shapes.row_vectors import dot_rows, lengths
from ..shapes.suggestion import one_of
from ..shapes.vector import FloatArray, VectorLike
from .camera import EQUIRECTANGULAR, FISHEYE, UP, AnyCamera, _check, basis

Projection: TypeAlias = Literal["equidistant", "equisolid", "stereographic"]
EQUIDISTANT, EQUISOLID, STEREOGRAPHIC = range(3)


class _Around(AnyCamera):
    """A camera whose rays come together in its position, in any direction."""

    @property
    def lens(self) -> FloatArray:
        """(6, 3): the position, zeros, and the unit vectors forward, to the right and upwards."""
        right, up, forward = basis(self.position, self.look_at, self.up)
        zero = np.zeros(3)
        return np.array([self.position, zero, zero, forward, right, up])

    def pixel(self, width: int, height: int) -> tuple[float, float]:
        """How large a pixel of a picture of `width` x `height` is at the camera, and how much more each unit away."""
        kind, numbers = self.optics
        return 0.0, (4 * math.pi * numbers[1] if kind == FISHEYE else math.pi) / height

    def _directions(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """How far points lie to the right, upwards and forward; NaN for the position itself."""
        lens = self.lens
        away = points - lens[0]
        away = np.where((away == 0).all(axis=-1, keepdims=True), np.nan, away)
        return dot_rows(away, lens[4]), dot_rows(away, lens[5]), dot_rows(away, lens[3])


@hinted
@explained_methods
@dataclass(frozen=True)
class EquirectangularCamera(_Around):
    """All around `position`, as a map: 360 degrees of longitude across the picture, 180 of latitude from top to bottom.

    The middle looks at `look_at`; longitudes grow to the right, about `up` as far as it is across the view. A picture
    twice as wide as high has square pixels at its equator, and is what programs take for a panorama or environment.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP

    def __post_init__(self) -> None:
        _check(self)

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """It has no numbers."""
        return EQUIRECTANGULAR, (0.0, 0.0, 0.0, 0.0)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        right, up, forward = self._directions(points)
        longitude, latitude = np.arctan2(right, forward), np.arctan2(up, np.hypot(right, forward))
        return np.stack([longitude * (width / height / math.pi), latitude * (2 / math.pi)], axis=-1)


@hinted
@explained_methods
@dataclass(frozen=True)
class FisheyeCamera(_Around):
    """A circle as high as the picture, of all that is within `field_of_view`, in degrees; around it all is black.

    projection: how the angle θ from the middle grows with the distance r from it, 1 at the rim:
        "equidistant": θ in proportion to r;
        "equisolid": sin(θ/2) in proportion to r, equal areas for equal solid angles, as most lenses do;
        "stereographic": tan(θ/2) in proportion to r: small circles stay circles.
    position, look_at: where the camera is, and what is in the middle; `up` is upwards in the picture.
    `field_of_view` is in (0, 360], of a stereographic one below 360.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    field_of_view: float = 180.0
    projection: Projection = "equidistant"

    def __post_init__(self) -> None:
        _check(self)
        angle = degrees("FisheyeCamera", "field_of_view", self.field_of_view)
        one_of("FisheyeCamera", "projection", self.projection, get_args(Projection))
        if not 0 < angle <= 360 or (angle == 360 and self.projection == "stereographic"):
            limits = "(0, 360)" if self.projection == "stereographic" else "(0, 360]"
            raise ValueError(f"FisheyeCamera: field_of_view must be in {limits} degrees, got {angle}")
        object.__setattr__(self, "field_of_view", angle)

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """(projection, θ at the rim in turns, sin(θ/2) there, tan(θ/2) there)."""
        number = get_args(Projection).index(self.projection)
        quarter = self.field_of_view / 4
        tangent = tan_degrees(quarter) if number == STEREOGRAPHIC else 0.0
        return FISHEYE, (float(number), self.field_of_view / 720, sin_cos_degrees(quarter)[0], tangent)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        right, up, forward = self._directions(points)
        across = np.hypot(right, up)
        angle = np.arctan2(across, forward)
        number, rim, sine, tangent = self.optics[1]
        if number == EQUIDISTANT:
            r = angle / (2 * math.pi * rim)
        else:
            r = np.sin(angle / 2) / sine if number == EQUISOLID else np.tan(angle / 2) / tangent
        away = np.where(across > 0, across, 1.0)
        film = np.stack([right, up], axis=-1) * np.where(across > 0, r / away, 0.0)[..., None]
        return np.where(np.isnan(lengths(film))[..., None], np.nan, film)
