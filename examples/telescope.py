"""A Cassegrain telescope of a paraboloid and a hyperboloid, cut open, and the light of a star in it.

Both mirrors are exact conics: all rays of the star meet in one point, to rounding.
"""

from __future__ import annotations

import numpy as np

import conicoid as co
from studio import Progress

F, MAGNIFICATION, BACK = 500.0, 3.2, 110.0  # focal length of the primary; how the secondary enlarges; focus behind it
P = (F + BACK) / (MAGNIFICATION + 1)  # from the secondary to the focus of the primary
BENT = -(((MAGNIFICATION + 1) / (MAGNIFICATION - 1)) ** 2)  # the secondary's conic constant: both foci in place
CURVED = -2 * MAGNIFICATION * P / (MAGNIFICATION - 1)


def telescope() -> co.optics.Prescription:
    """The two mirrors as a sequence of surfaces."""
    primary = dict(
        radius=-2 * F, thickness=-(F - P), medium="mirror", conic=-1, diameter=220, hole=62, stop=True, name="primary"
    )
    secondary = dict(radius=CURVED, thickness=MAGNIFICATION * P, medium="mirror", conic=BENT, diameter=74)
    return co.optics.prescription([primary, secondary], 214, fields=(0,), name="Cassegrain")


def scene() -> co.Scene:
    """The mirrors on their glass, cut open, with rays as rods."""
    system, half = telescope(), co.HalfSpace((-1, 0, 0), 0)
    primary = co.Mirror(-2 * F, -1, 220, 22, hole=62)
    secondary = co.Mirror(CURVED, BENT, 74, -12).translate((0, 0, -(F - P)))
    silvered = co.metal("#d5dbe0", reflectivity=0.6)
    bodies = [co.Body(mirror & half.painted("#7fa8c9"), silvered) for mirror in (primary, secondary)]
    pupil = np.column_stack([np.zeros(9), [-1, -0.8, -0.6, -0.4, 0, 0.4, 0.6, 0.8, 1]])
    found = co.optics.trace(system, co.optics.beam(system, pupil=pupil))
    corners = np.concatenate([found.points, found.at(system.image)[None]])
    corners[0, :, 2] = -460
    for ray in np.flatnonzero(found.arrived):
        bodies += [
            co.Body(co.Cylinder(a, b, 1.1), "#c2402f") for a, b in zip(corners[:-1, ray], corners[1:, ray], strict=True)
        ]
    bodies.append(co.Body(co.Sphere(4, (0, 0, system.image)), "#c2402f"))
    lights = [co.AmbientLight(0.5), co.PointLight((-900, 700, -300), 0.6)]
    camera = co.Camera((-1500, 420, -520), (0, 0, -168), up=(0, 1, 0), field_of_view=10.6)
    return co.Scene(bodies, lights, camera, "white")


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(640 * scale), round(300 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    system = telescope()
    print(co.optics.cardinal_points(system), co.optics.spot(system))
    co.optics.layout(system, rays=9).save("telescope.svg")
    picture().save("telescope.png")
