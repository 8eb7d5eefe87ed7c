"""A fuel assembly from OpenMC's XML, sliced and coloured by material, with exact outlines."""

from __future__ import annotations

from pathlib import Path

import conicoid as co

ASSEMBLY = Path(__file__).with_name("openmc") / "assembly" / "geometry.xml"


def cut(pixels: int = 640) -> co.section.Slice:
    """A corner of the assembly at half of its height: an instrument tube in the middle, control tubes, fuel rods."""
    return co.load_openmc(ASSEMBLY).slice(origin=(-0.7, -0.7, 183), u=(8.4, 0, 0), v=(0, 8.4, 0), pixels=pixels)


if __name__ == "__main__":
    for name in ("assembly_slice.png", "assembly_slice.svg"):
        cut().save(name, by="material")
