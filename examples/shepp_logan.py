"""The Shepp-Logan head: its X-ray projection, exact to rounding, and a picture of it cut open."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

FIGURES = Path(__file__).with_name("shepp_logan.csv")


def head() -> tuple[list[co.Solid], np.ndarray]:
    """The ten ellipsoids, and the density that each adds."""
    lines = [line for line in FIGURES.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]
    solids = [
        co.Ellipsoid((row["a"], row["b"], row["c"]))
        .rotate((0, 0, 1), row["psi"])
        .rotate((1, 0, 0), row["theta"])
        .rotate((0, 0, 1), row["phi"])
        .translate((row["x0"], row["y0"], row["z0"]))
        for row in rows
    ]
    return solids, np.array([row["density"] for row in rows])


def projection(size: int = 512) -> np.ndarray:
    """Density times length, summed along parallel rays in +y from 3 units out: (size, size), seen from the front."""
    solids, density = head()
    camera = co.OrthographicCamera((0, -3, 0), (0, 0, 0), height=2)
    return co.Scene(solids).spans(camera.rays(size, size)).line_integral(density)


def scene() -> co.Scene:
    """The head without the front and left of its upper half; the cuts show each part in its own colour."""
    solids, density = head()
    tissue = {1.0: "#efe7d3", 0.2: "#b5746a", 0.0: "#2c3c55", 0.3: "#e3b45c"}
    rest = co.HalfSpace((0, 0, 1), 0) | (co.HalfSpace((-1, 0, 0), 0) & co.HalfSpace((0, -1, 0), 0))
    bodies = []
    # The inner parts first: on the cuts, where all of them coincide, the one listed first is seen
    for i in (9, 8, 7, 6, 5, 4, 3, 2, 1, 0):
        total = density[0] if i == 0 else density[:2].sum() + (density[i] if i > 1 else 0)
        part = (solids[i] & rest).translate((0, 0, 0.86)).scale(1.6)
        bodies.append(co.Body(part, co.blinn_phong(tissue[round(float(total), 1)], specular=0.25, shininess=60)))
    camera = co.Camera((-3.4, -8.6, 6.2), (0.1, 0, 1.15), field_of_view=18.5)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def x_ray(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The projection as a picture, 512 × 512 at full size."""
    del progress
    return co.Image(projection(round(512 * scale)), colormap="grey", vmin=0)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(720 * scale), round(560 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    x_ray().save("shepp_logan_x_ray.png")
    picture().save("shepp_logan_cut.png")
