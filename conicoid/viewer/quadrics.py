"""A scene to play with: the nine quadrics, each as its ten coefficients in a box."""

from __future__ import annotations

import conicoid as co

from ..scene import Scene

ZERO = dict.fromkeys(("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant"), 0.0)

# name, coefficients of f <= 0, colour
NINE: tuple[tuple[str, dict[str, float], str], ...] = (
    ("ellipsoid", {"xx": 1.4, "yy": 2.2, "zz": 1.8, "constant": -1}, "#a62b2b"),
    ("elliptic paraboloid", {"xx": 1.5, "yy": 2.2, "z": -1, "constant": -0.8}, "#c2622d"),
    ("hyperbolic paraboloid", {"xx": 0.9, "yy": -0.9, "z": 1}, "#d29a35"),
    ("hyperboloid of one sheet", {"xx": 3.5, "yy": 5, "zz": -2.6, "constant": -1}, "#6b8f3e"),
    ("hyperboloid of two sheets", {"xx": 9, "yy": 13, "zz": -14, "constant": 1}, "#2f7d5b"),
    ("elliptic cone", {"xx": 1, "yy": 1.5, "zz": -1}, "#2a7f8c"),
    ("elliptic cylinder", {"xx": 1.5, "yy": 3, "constant": -1}, "#2b5f93"),
    ("hyperbolic cylinder", {"xx": 6, "yy": -3, "constant": -1}, "#59468f"),
    ("parabolic cylinder", {"xx": 1, "y": -0.6, "constant": -0.5}, "#8d3c78"),
)
_GAP = 2.6


def quadrics_scene() -> Scene:
    """Nine bodies, three by three, first row in front."""
    room = co.Box((-1, -1, -1), (1, 1, 1))
    bodies = []
    for k, (name, coefficients, color) in enumerate(NINE):
        solid = co.Quadric(coefficients=ZERO | coefficients) & room
        place = (_GAP * (k % 3 - 1), _GAP * (k // 3 - 1), 1.0)
        bodies.append(co.Body(solid.translate(place), material=co.lacquer(color), name=name))
    squares = co.Checker("#e6e2d9", "#d3cec3", scale=1.3, space=True)
    floor = co.Body(co.Disc((0, 0, -0.02), (0, 0, 1), 14), material=co.matte(squares), name="floor")
    lights = [co.AmbientLight(0.28), co.DirectionalLight((-0.5, 0.8, -1.1), 0.75)]
    camera = co.Camera((0.8, -11, 8.2), (0, -0.2, 0.7), field_of_view=36)
    return Scene([*bodies, floor], lights, camera, co.Sky((0.35, 0.47, 0.62), (0.82, 0.84, 0.86)))
