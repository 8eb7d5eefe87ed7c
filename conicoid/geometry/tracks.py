"""Motion by keyframes: tracks that place a body, the camera or a light at given times and in between.

Between two keys all numbers are interpolated linearly ("linear"), or with ease in and out ("smooth": 3s² - 2s³ of the
share s of the time). Before the first key and after the last nothing moves.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np

from .._util.arrays import Vector
from .._util.records import dataclass
from .._util.text import check_choice, format_count
from .._util.validation import (
    as_integer,
    check_fields,
    check_list,
    check_number,
    check_numbers,
    check_vector,
    describe_kind,
    format_value,
    real_array,
)
from .shape import Shape

Ease: TypeAlias = Literal["linear", "smooth"]


def _check_ease(owner: str, field: str, value: Any) -> Any:
    return check_choice(owner, field, value, get_args(Ease))


def _times(owner: str, value: Any) -> tuple[float, ...]:
    """Return the times as floats. Raise ValueError unless there is one or more, ascending."""
    given = real_array(owner, "times", value, "a list of times in seconds")
    if given.ndim != 1 or not given.size:
        raise ValueError(f"{owner}: times must be a list of one time or more, got {format_value(value)}")
    times = tuple(check_number(owner, f"times[{i}]", time) for i, time in enumerate(given.tolist()))
    for i in range(len(times) - 1):
        if not times[i] < times[i + 1]:
            raise ValueError(f"{owner}: times must grow, got {times[i]:g} before {times[i + 1]:g} (times[{i + 1}])")
    return times


def _keys(owner: str, field: str, value: Any, count: int, size: int) -> Any:
    """Return one key for each time, checked: numbers, or vectors of `size`."""
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != count:
        found = f"{len(value)}" if isinstance(value, list | tuple | np.ndarray) else describe_kind(value)
        raise ValueError(f"{owner}: {field} must be a list of {count}, one for each of times, got {found}")
    if size == 1:
        return tuple(check_number(owner, f"{field}[{i}]", item) for i, item in enumerate(value))
    return tuple(check_numbers(owner, f"{field}[{i}]", item, size) for i, item in enumerate(value))


def _key_share(times: tuple[float, ...], time: float, ease: Ease) -> tuple[int, float]:
    """Return (index of the key before `time`, share of the way to the next key)."""
    if time <= times[0] or len(times) == 1:
        return 0, 0.0
    # The last key itself, so that the end of a film is the key to the bit
    if time >= times[-1]:
        return len(times) - 2, 1.0
    k = max(i for i in range(len(times) - 1) if times[i] <= time)
    s = (time - times[k]) / (times[k + 1] - times[k])
    return k, s if ease == "linear" else s * s * (3.0 - 2.0 * s)


def _interpolate_keys(keys: Any, k: int, s: float) -> Any:
    """Return the number or vector between two keys. At a key it is that key to the bit."""
    # a + 1 (b - a) would be rounded
    if s == 0.0 or s == 1.0:
        return keys[k + (s == 1.0)]
    a, b = keys[k], keys[k + 1]
    if isinstance(a, float):
        return a + s * (b - a)
    return tuple(p + s * (q - p) for p, q in zip(a, b, strict=True))


@dataclass(frozen=True)
class BodyTrack:
    """The motion of a body: turned about a fixed axis and then translated, from its place in the scene.

    Parameters
    ----------
    body : str
        The name of the body.
    times : list of float
        The times of the keys in seconds, ascending.
    translate : list of three numbers each, optional
        The translation at each key.
    degrees : list of float, optional
        The angle about `axis` at each key, right-handed; several turns are several times 360.
    axis : three numbers, or "x", "y", "z", "-x", "-y", "-z"
        The direction of the axis.
    about : three numbers
        A point of the axis.
    ease : "linear" or "smooth"
        "smooth" is slow at each key.
    """

    body: str
    times: tuple[float, ...]
    translate: tuple[Vector, ...] | None = None
    degrees: tuple[float, ...] | None = None
    axis: str | Vector = "z"
    about: Vector = (0.0, 0.0, 0.0)
    ease: Ease = "linear"

    def __post_init__(self) -> None:
        owner = "BodyTrack"
        if not isinstance(self.body, str) or not self.body:
            raise ValueError(f"{owner}: body must be the name of a body, got {format_value(self.body)}")
        object.__setattr__(self, "times", _times(owner, self.times))
        if self.translate is None and self.degrees is None:
            raise ValueError(f"{owner}: translate or degrees must say how {self.body!r} moves")
        for field, size in (("translate", 3), ("degrees", 1)):
            value = getattr(self, field)
            if value is not None:
                object.__setattr__(self, field, _keys(owner, field, value, len(self.times), size))
        axis = self.axis if isinstance(self.axis, str) else check_vector(owner, "axis", self.axis, nonzero=True)
        if isinstance(axis, str) and axis not in ("x", "y", "z", "-x", "-y", "-z"):
            raise ValueError(
                f"{owner}: axis must be three numbers or one of x, y, z, -x, -y, -z, got {format_value(axis)}"
            )
        object.__setattr__(self, "axis", axis)
        check_fields(self, about=check_vector, ease=_check_ease)

    def moved(self, shape: Shape, time: float) -> Shape:
        """Return a `shape` at a `time` in seconds: turned and translated, which is rounded once."""
        k, s = _key_share(self.times, time, self.ease)
        angle = 0.0 if self.degrees is None else _interpolate_keys(self.degrees, k, s)
        offset = (0.0, 0.0, 0.0) if self.translate is None else _interpolate_keys(self.translate, k, s)
        # A scene at rest keeps its shapes, and with them its prepared tables
        if angle:
            shape = shape.rotate(self.axis, angle, about=self.about)
        return shape.translate(offset) if any(offset) else shape


class _FieldTrack:
    """A track that moves fields of a camera or a light."""

    FIELDS: ClassVar[tuple[str, ...]]
    times: tuple[float, ...]
    ease: Ease

    def _check_keys(self) -> None:
        """Check the keys of the fields that move; raise ValueError if none does."""
        owner = type(self).__name__
        object.__setattr__(self, "times", _times(owner, self.times))
        for field in self._moving:
            size = 3 if field in ("position", "direction", "look_at") else 1
            object.__setattr__(self, field, _keys(owner, field, getattr(self, field), len(self.times), size))
        if not self._moving:
            raise ValueError(f"{owner}: {', '.join(self.FIELDS[:-1])} or {self.FIELDS[-1]} must say how it moves")
        check_fields(self, ease=_check_ease)

    @property
    def _moving(self) -> list[str]:
        return [field for field in self.FIELDS if getattr(self, field) is not None]

    def _move(self, thing: Any, time: float) -> Any:
        """Return a camera or light with the fields that move as they are at a time."""
        k, s = _key_share(self.times, time, self.ease)
        for field in self._moving:
            if not hasattr(thing, field):
                raise ValueError(f"{type(self).__name__}: {field} is nothing that a {type(thing).__name__} has")
        return dataclasses.replace(
            thing, **{field: _interpolate_keys(getattr(self, field), k, s) for field in self._moving}
        )


@dataclass(frozen=True)
class CameraTrack(_FieldTrack):
    """The motion of the scene's camera.

    Parameters
    ----------
    times : list of float
        The times of the keys in seconds, ascending.
    position, look_at : list of three numbers each, optional
        The position and the viewed point at each key.
    field_of_view, focus_distance : list of float, optional
        These fields of a `Camera` at each key.
    ease : "linear" or "smooth"
        "smooth" is slow at each key.
    """

    times: tuple[float, ...]
    position: tuple[Vector, ...] | None = None
    look_at: tuple[Vector, ...] | None = None
    field_of_view: tuple[float, ...] | None = None
    focus_distance: tuple[float, ...] | None = None
    ease: Ease = "linear"

    FIELDS = "position", "look_at", "field_of_view", "focus_distance"

    def __post_init__(self) -> None:
        self._check_keys()

    def moved(self, camera: Any, time: float) -> Any:
        """Return a `camera` at a `time` in seconds. Raise ValueError for a field that the camera does not have."""
        return self._move(camera, time)


@dataclass(frozen=True)
class LightTrack(_FieldTrack):
    """The motion or brightness of one of the scene's lights. Lamps are bodies and move by a `BodyTrack`.

    Parameters
    ----------
    light : int
        The index of the light in the scene, from 0.
    times : list of float
        The times of the keys in seconds, ascending.
    position, direction : list of three numbers each, optional
        The position or direction at each key.
    intensity : list of float, optional
        The intensity at each key.
    ease : "linear" or "smooth"
        "smooth" is slow at each key.
    """

    light: int
    times: tuple[float, ...]
    position: tuple[Vector, ...] | None = None
    direction: tuple[Vector, ...] | None = None
    intensity: tuple[float, ...] | None = None
    ease: Ease = "linear"

    FIELDS = "position", "direction", "intensity"

    def __post_init__(self) -> None:
        light = as_integer(self.light)
        if light is None or not 0 <= light <= _MOST_LIGHTS:
            raise ValueError(f"LightTrack: light must be the number of a light, from 0, got {format_value(self.light)}")
        object.__setattr__(self, "light", light)
        self._check_keys()

    def moved(self, light: Any, time: float) -> Any:
        """Return a `light` at a `time` in seconds. Raise ValueError for a field that the light does not have."""
        return self._move(light, time)


_MOST_LIGHTS = 1_000_000
Track: TypeAlias = BodyTrack | CameraTrack | LightTrack
TRACKS: dict[str, type[Track]] = {kind.__name__: kind for kind in get_args(Track)}
"""Scene-file name -> class."""


def as_tracks(tracks: Any) -> tuple[Track, ...]:
    """Return tracks as a tuple; one alone stands for a list of it, None for none. Raise TypeError for anything else."""
    return () if tracks is None else check_list("Scene", "animation", tracks, TRACKS)


def last_time(tracks: tuple[Track, ...]) -> float:
    """Return the time of the last key of all tracks, 0 without tracks."""
    return max((track.times[-1] for track in tracks), default=0.0)


def follow_tracks(scene: Any, time: float) -> Any:
    """Return a scene with everything where its tracks have it at a time, without tracks: see `Scene.at`."""
    # Without tracks, since the result is a scene at rest
    moved = scene.replace(animation=None) if scene.animation else scene
    for track in scene.animation:
        if isinstance(track, BodyTrack):
            shape = scene[track.body].shape
            if track.moved(shape, time) is not shape:  # a body at rest needs no preparation
                moved = moved.moved(track.body, lambda old, track=track: track.moved(old, time))
        elif isinstance(track, CameraTrack):
            if moved.camera is None:
                raise ValueError("at: the scene must have a camera for a CameraTrack to move")
            moved = moved.replace(camera=track.moved(moved.camera, time))
        else:
            moved = moved.replace(lights=_move_light(moved.lights, track, time))
    return moved


def _move_light(lights: tuple[Any, ...], track: LightTrack, time: float) -> list[Any]:
    """Return the lights of a scene, with one of them where its track has it."""
    if track.light >= len(lights):
        there = format_count(len(lights), "light", "lights")
        raise ValueError(f"at: the scene has {there}, from 0 on; a LightTrack moves light {track.light}")
    return [track.moved(light, time) if k == track.light else light for k, light in enumerate(lights)]
