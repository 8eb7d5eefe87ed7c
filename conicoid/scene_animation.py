"""Scenes that move: what they are at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .scene_parts import named
from .shapes.animation import BodyTrack, CameraTrack, LightTrack
from .shapes.calls import explained_methods
from .shapes.labels import counted
from .shapes.validate import number

if TYPE_CHECKING:
    from .scene import Scene


@explained_methods
class Moving:
    """What scenes with an animation can say."""

    _animation: tuple[Any, ...]
    _bodies: Any

    @property
    def animation(self) -> tuple[Any, ...]:
        """By which tracks bodies, the camera and lights move; queries and pictures see all where the scene has it."""
        return self._animation

    def at(self, time: float) -> Scene:
        """The scene as it stands at a time, without an animation; of bodies it prepares only those that have moved.

        time: in seconds, as the keys of the tracks say.

        Raises KeyError where a track moves a body that there is not, ValueError where it moves a camera or a light
        that the scene has not.
        """
        time, made = number("at", "time", time), self._still()
        for track in self._animation:
            if isinstance(track, BodyTrack):
                shape = self._bodies[named(self._bodies, track.body)].shape
                if track.moved(shape, time) is not shape:
                    made = made.moved(track.body, lambda old, track=track: track.moved(old, time))
            elif isinstance(track, CameraTrack):
                if made.camera is None:
                    raise ValueError("at: the scene must have a camera for a CameraTrack to move")
                made = made.replace(camera=track.moved(made.camera, time))
            elif isinstance(track, LightTrack):
                made = made.replace(lights=_lights(made.lights, track, time))
        return made

    def _still(self) -> Scene:
        raise NotImplementedError


def _lights(lights: Any, track: LightTrack, time: float) -> list[Any]:
    """The lights of a scene, one of them where a track has it."""
    if track.light >= len(lights):
        there = counted(len(lights), "light", "lights")
        raise ValueError(f"at: the scene has {there}, from 0 on; a LightTrack moves light {track.light}")
    return [track.moved(light, time) if k == track.light else light for k, light in enumerate(lights)]
