"""A photographer's studio for the pictures: a floor that bends up into a wall without an edge, and three lights."""

from __future__ import annotations

from collections.abc import Callable

import conicoid as co

Progress = Callable[[int, int], None]
_BEND = 6.0
ROOM = co.Sky(zenith=(0.72, 0.76, 0.82), horizon=(0.6, 0.59, 0.57))
"""The surroundings behind the camera, for shiny things to reflect."""


def backdrop(color: str = "#e9e6e1", wall: float = 9.0) -> list[co.Body]:
    """Floor z = 0, wall y = wall, and a quarter of a cylinder between them."""
    paper = co.matte(color)
    start = wall - _BEND
    floor = co.Plane((0, 0, 1), 0) & co.HalfSpace((0, 1, 0), start)
    upright = co.Plane((0, -1, 0), -wall) & co.HalfSpace((0, 0, -1), -_BEND)
    bend = co.CylinderPatch((-60, start, _BEND), (60, start, _BEND), _BEND, 0, 90, reference=(-60, start, 0))
    return [co.Body(floor, paper), co.Body(upright, paper), co.Body(bend, paper)]


def lights(camera: co.Camera) -> list[co.AmbientLight | co.PointLight]:
    """A key light from the upper left, a weak one at the lens, whose shadows are invisible, and the room's own."""
    return [
        co.AmbientLight((0.24, 0.25, 0.27)),
        co.PointLight((-7, -9, 11), (0.75, 0.73, 0.69)),
        co.PointLight(camera.position, (0.16, 0.17, 0.19)),
    ]
