"""A molecule of caffeine, C8H10N4O2, from its atoms' places."""

from __future__ import annotations

import numpy as np

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

# Element and place in 1e-10 m: the rings in a plane, with the usual lengths of bonds
ATOMS = """
N 0.47 2.57 0  C -0.71 1.93 0  N -0.74 0.55 0  C 0.44 -0.19 0  C 1.63 0.49 0  C 1.67 1.90 0
N 2.89 2.36 0  C 3.61 1.25 0  N 2.90 0.09 0  O 0.41 -1.42 0  O -1.76 2.57 0
C 0.50 4.03 0  C -2.03 -0.15 0  C 3.44 -1.26 0
H 4.70 1.25 0  H -0.52 4.41 0  H 1.02 4.39 0.89  H 1.02 4.39 -0.89  H -2.85 0.57 0  H -2.10 -0.78 0.89
H -2.10 -0.78 -0.89  H 4.53 -1.22 0  H 3.09 -1.78 0.89  H 3.09 -1.78 -0.89
""".split()
COLORS = {"C": "#3a3d42", "H": "#e8e4dc", "N": "#2f62b5", "O": "#c0392b"}
RADII = {"C": 0.42, "H": 0.27, "N": 0.40, "O": 0.38}


def molecule() -> co.scene.Molecule:
    """It stands upright; bonds follow from the distances."""
    places = np.array([[float(x) for x in ATOMS[k + 1 : k + 4]] for k in range(0, len(ATOMS), 4)])
    return co.molecule((places - (0.9, 1.2, 0))[:, [0, 2, 1]] + (0, 0, 3.8), ATOMS[::4])


def scene() -> co.Scene:
    """Balls for atoms; each bond is two cylinders, which meet in its middle in the colours of its atoms."""
    colors = {symbol: co.lacquer(color) for symbol, color in COLORS.items()}
    bodies = molecule().bodies("ball and stick", radii=RADII, colors=colors)
    turned = [body.rotate("z", 28) for body in bodies]
    camera = co.Camera((0, -17, 9), (0, 0, 3.4), field_of_view=30)
    return co.Scene([*turned, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("caffeine.png")
