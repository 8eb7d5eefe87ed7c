"""A globe of a world that is not, before a wall of bricks, on a table of wood."""

from __future__ import annotations

import numpy as np

import conicoid as co
from studio import Progress

ROWS, COLUMNS = 512, 1024
TILT = 23.4


def world() -> co.materials.ImageTexture:
    """A map in longitude and latitude: sums of waves in space, cut at sea level, so that it has no seam."""
    latitude = np.pi / 2 - (np.arange(ROWS) + 0.5)[:, None] / ROWS * np.pi
    longitude = (np.arange(COLUMNS) + 0.5) / COLUMNS * 2 * np.pi
    point = np.stack(np.broadcast_arrays(np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
                                         np.sin(latitude)), axis=-1)  # fmt: skip
    rng, height = np.random.default_rng(12), np.zeros((ROWS, COLUMNS))
    for octave in range(7):
        for direction in rng.normal(size=(6, 3)):
            wave = direction / np.linalg.norm(direction) * 2.3 * 1.8**octave
            height += np.sin(point @ wave + rng.uniform(0, 2 * np.pi)) / 1.7**octave
    land, ice = height > 0.6, np.abs(np.sin(latitude)) + 0.03 * height > 0.93
    color = np.where(land[..., None], (0.16, 0.24, 0.07), (0.02, 0.08, 0.2))
    color = np.where((land & (height > 3.0))[..., None], (0.35, 0.26, 0.14), color)
    color = np.where(ice[..., None], (0.8, 0.84, 0.88), color)
    line = (np.abs(np.mod(np.degrees(latitude) + 15, 30) - 15) < 0.35) | (
        np.abs(np.mod(np.degrees(longitude) + 15, 30) - 15) < 0.35
    )
    return co.materials.ImageTexture(np.where(line[..., None], 0.5 * color + 0.2, color), mapping="latitude")


def scene() -> co.Scene:
    """The globe in its stand."""
    up = (0.0, 0.0, 2.2)
    brass = co.metal("#c8a24a")
    ball = co.Sphere(1.2).rotate("z", -55).rotate((0, 1, 0), TILT).translate(up)
    axis = co.Cylinder((0, 0, -1.5), (0, 0, 1.5), 0.035).rotate((0, 1, 0), TILT).translate(up)
    ring = (co.Cylinder((0, -0.05, 0), (0, 0.05, 0), 1.5) - co.Cylinder((0, -1, 0), (0, 1, 0), 1.42)).translate(up)
    half = ring - co.HalfSpace((1, 0, 0), 0).rotate((0, 1, 0), TILT).translate(up)
    foot = co.Cone((0, 0, 0.1), (0, 0, 0.75), 0.55, 0.06) | co.Cylinder((0, 0, 0.0), (0, 0, 0.1), 0.75)
    stand = co.lacquer(co.materials.Wood("#7a4a24", "#3a1d0c", ring=0.06, offset=(0.4, 0.3)))
    table = co.Box((-4, -3, -0.25), (4, 2.2, 0))
    wood = co.lacquer(co.materials.Wood("#9a6a3a", "#5e3818", ring=0.22, offset=(1.5, -7.0)), reflectivity=0.03)
    bricks = co.materials.Brick(
        co.materials.Noise("#8a4a34", "#6e3524", scale=0.2), "#b3aca0", (0.8, 0.27), 0.035, 0.25
    )
    camera = co.Camera((0.7, -8.0, 3.0), (0.1, 0, 1.75), field_of_view=30, aperture=0.12, focus_distance=6.9)
    return co.Scene(
        [
            co.Body(ball, co.lacquer(world(), specular=0.4)), co.Body(axis, brass), co.Body(half, brass),
            co.Body(foot, stand), co.Body(table, wood),
            co.Body(co.Box((-9, 3.0, -3), (9, 3.5, 9)), co.matte(bricks)),
        ],
        lights=[co.AmbientLight((0.2, 0.21, 0.24)), co.PointLight((-5, -6, 7), (0.85, 0.8, 0.72))],
        camera=camera,
        background="#20242a",
    )  # fmt: skip


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    image = scene().render(round(600 * scale), round(440 * scale), samples=25, filter="tent", progress=progress)
    return image.developed(exposure=0.5)


if __name__ == "__main__":
    picture().save("globe.png")
