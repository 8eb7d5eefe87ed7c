"""A torso from GDML: how much of each tissue beams go through, and the radiograph that it gives, without sampling."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import conicoid as co
from studio import Progress

PHANTOM = Path(__file__).with_name("gdml") / "phantom.gdml"
BEAMS = {"left lung": (90, 120), "heart": (20, 85), "tumour": (-95, 150), "liver": (-80, -60)}
"""(x, z) in mm of beams from the front to the back."""


def path_lengths() -> dict[str, dict[str, float]]:
    """For each beam the mm that it goes through each material; air counts for nothing."""
    scene = co.load(PHANTOM, void=False)
    found = {}
    for name, (x, z) in BEAMS.items():
        spans = scene.spans((x, -300, z), (0, 1, 0))
        lengths = spans.t_exit - spans.t_enter
        found[name] = {each.name: float(lengths[spans.material == each].sum()) for each in set(spans.material)}
    return found


def radiograph(size: int = 560) -> np.ndarray:
    """g/cm² along parallel beams from the front, (5 size / 4, size): density times length, to rounding."""
    scene = co.load(PHANTOM, void=False)
    camera = co.OrthographicCamera((0, -300, 0), (0, 0, 0), height=625)
    return scene.line_integral("density", camera.rays(size, round(1.25 * size))) / 10  # mm to cm


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The radiograph, brighter where more is in the way."""
    del progress
    return co.Image(radiograph(round(480 * scale)), colormap="grey", vmin=0)


if __name__ == "__main__":
    for name, lengths in path_lengths().items():
        print(f"{name:<10}", ", ".join(f"{material} {length:.3f} mm" for material, length in lengths.items()))
    picture().save("phantom.png")
