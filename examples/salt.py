"""Molecules: the unit cell of rock salt, benzene as balls and sticks, and water as its atoms fill space."""

from __future__ import annotations

import itertools
import math

import numpy as np

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

SALT = {"Na": 0.7, "Cl": 1.1}
COLORS = {"Na": co.lacquer("#7d5fb8"), "Cl": co.lacquer("#5fae6b")}


def salt(edge: float = 5.64) -> co.scene.Molecule:
    """Sodium and chlorine in turn, on the corners of cubes of half the edge, in Å."""
    places = np.array(list(itertools.product(range(3), repeat=3)))
    elements = np.where(places.sum(axis=1) % 2, "Na", "Cl")
    return co.molecule(places * edge / 2, elements, bonds=[], cell=np.eye(3) * edge)


def benzene() -> co.scene.Molecule:
    """C6H6: bonds of 1.39 Å in a ring, single and double in turn, and of 1.09 Å to hydrogen."""
    angles = np.radians(np.arange(6) * 60)
    ring = np.column_stack([np.cos(angles), np.zeros(6), np.sin(angles)])
    bonds = [(k, (k + 1) % 6, 1 + k % 2) for k in range(6)] + [(k, k + 6, 1) for k in range(6)]
    return co.molecule(np.concatenate([1.39 * ring, 2.48 * ring]), ["C"] * 6 + ["H"] * 6, bonds=bonds)


def water(bond: float = 0.9572, angle: float = 104.52) -> co.scene.Molecule:
    """H2O by its measured bond, in Å, and angle."""
    half = math.radians(angle / 2)
    return co.molecule(
        [(0, 0, 0), *((side * bond * math.sin(half), 0, bond * math.cos(half)) for side in (-1, 1))], ["O", "H", "H"]
    )


def scene() -> co.Scene:
    """The three beside one another."""
    bodies = [
        body.rotate("z", 24).translate((-7.4, 1, 1.2)) for body in salt().bodies(radii=SALT, colors=COLORS, name="salt")
    ]
    bodies += [body.translate((1.9, 0, 3.2)) for body in benzene().bodies(name="benzene")]
    bodies += [body.scale(1.2).translate((7.4, 0, 2.4)) for body in water().bodies("space filling", name="water")]
    camera = co.Camera((0, -27, 9), (0.1, 0, 3.6), field_of_view=24)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(800 * scale), round(360 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("salt.png")
