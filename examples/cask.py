"""A cask from an MCNP deck: a slice coloured by material, and how much a gamma meets on its way out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import conicoid as co
from studio import Progress

CASK = Path(__file__).with_name("mcnp") / "cask.mcnp"


def cut(pixels: int = 640) -> co.section.Slice:
    """The plane y = 0.1 cm, through the rods and the drain."""
    return co.load(CASK).slice(origin=(-32, 0.1, -34), u=(64, 0, 0), v=(0, 0, 68), pixels=pixels)


def shielding(count: int = 3600) -> np.ndarray:
    """g/cm² from the middle of the cask outward in directions all around, at the height of the drain."""
    angles = np.radians(np.arange(count) * 360 / count)
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=-1)
    return co.load(CASK, void=False).line_integral(
        "density", co.Rays(np.broadcast_to((0, 0, 12), (count, 3)), directions)
    )


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The slice."""
    del progress
    return cut(max(round(640 * scale), 32)).image(by="material")


if __name__ == "__main__":
    found = shielding()
    print(f"least {found.min():.2f} g/cm² at {found.argmin() / 10} degrees, most {found.max():.2f}")
    picture().save("cask.png")
