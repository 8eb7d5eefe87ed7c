"""A flange with a dome and nuts, from OpenSCAD: round parts stay round; where its wall is thinnest, exactly."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

FLANGE = Path(__file__).with_name("openscad") / "flange.csg"


def thinnest_wall(count: int = 2_000) -> tuple[float, float]:
    """(mm of the thinnest place of the neck that rays across the axis meet, its height)."""
    scene = co.Scene([co.load(FLANGE).bodies[0]])
    heights = np.linspace(12.5, 59.5, count)
    origins = np.stack([np.zeros(count), np.zeros(count), heights], axis=-1)
    outside, inside = (scene.first_hit(origins + (x, 0, 0), (way, 0, 0)).point[:, 0] for x, way in ((90, -1), (0, 1)))
    least = int((outside - inside).argmin())
    return float(outside[least] - inside[least]), float(heights[least])


def scene() -> co.Scene:
    """As it would lie on a table, a quarter of the dome and of the neck cut away."""
    cut = co.HalfSpace((-1, 0, 0), 0) & co.HalfSpace((0, 1, 0), 0) & co.HalfSpace((0, 0, -1), -12.001)
    bodies = []
    for number, body in enumerate(co.load(FLANGE).bodies):
        shape = (body.shape - cut if number < 2 else body.shape).rotate("z", -35).scale(0.05)
        bodies.append(co.Body(shape, co.blinn_phong(body.material.color, specular=0.3, shininess=50)))
    camera = co.Camera((3.4, -9.2, 6.2), (0, 0, 1.75), field_of_view=36)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(640 * scale), round(520 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    thickness, height = thinnest_wall()
    print(f"the neck is {thickness:.6g} mm thick at z = {height:.4g} mm")
    picture().save("flange.png")
