"""One ray worked out as on a blackboard: what each body does with it, and why; its figure, and the page around it.

    python examples/explained.py [FOLDER]

The scene is a bored barrel, a lens that is a Boolean of two balls, and a box that the ray misses.
"""

from __future__ import annotations

import sys
from pathlib import Path

import conicoid as co

BARREL = co.Ellipsoid((1.6, 1.6, 2.2), z_range=(-1.4, 1.4)) - co.Cylinder((0, 0, -3), (0, 0, 3), 0.5)
LENS = co.Sphere(2.2, (5.5, 0, 0)) & co.Sphere(2.2, (2.5, 0, 0))
RAY = (-4, 0.0, 0.9), (1, 0, -0.12)


def scene() -> co.Scene:
    """Three bodies beside each other."""
    return co.Scene(
        [
            co.Body(BARREL, co.lacquer("sienna"), name="barrel"),
            co.Body(LENS, co.glass(), name="lens"),
            co.Body(co.Box((-1, -1, -2.4), (1, 1, -1.9)), co.matte("slategray"), name="box"),
        ]
    )


def main(folder: Path) -> None:
    """Write why.svg and why.html, and print the text."""
    found = scene().explain(*RAY)
    found.figure(width=720).save(folder / "explained.svg")
    found.save(folder / "explained.html")
    sys.stdout.write(found.text)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
