"""A reactor core for OpenMC: assemblies of 17 x 17 pins within a vessel, as many as wanted.

Radii and pitches are those of the BEAVRS benchmark (MIT CRPG, "Benchmark for Evaluation and Validation of Reactor
Simulations", rev. 2.0.2): pellet, cladding, guide tube, pin and assembly pitch, in cm.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..engine.answers.rays import Rays
from ..render.camera import Camera

PINS, PIN_PITCH, BETWEEN_ASSEMBLIES, HALF_HEIGHT = 17, 1.26, 0.08, 182.88
PELLET, CLAD_INSIDE, CLAD, TUBE_INSIDE, TUBE = 0.39218, 0.40005, 0.45720, 0.56134, 0.60198
_TUBES = {
    (2, 5), (2, 8), (2, 11), (3, 3), (3, 13), (5, 2), (5, 5), (5, 8), (5, 11), (5, 14), (8, 2), (8, 5), (8, 8), (8, 11),
    (8, 14), (11, 2), (11, 5), (11, 8), (11, 11), (11, 14), (13, 3), (13, 13), (14, 5), (14, 8), (14, 11),
}  # fmt: skip
"""Rows and columns of guide tubes."""


def pitch_of_assemblies(pins: int = PINS) -> float:
    """From one assembly to the next, in cm."""
    return pins * PIN_PITCH + BETWEEN_ASSEMBLIES


VIEWS = {
    "from above": ((0.02, 0.03, 1.0), (0.0, 1.0, 0.0)),
    "at 45 degrees": ((0.6, 0.45, 0.75), (0.0, 0.0, 1.0)),
    "at 20 degrees": ((0.8, 0.5, 0.34), (0.0, 0.0, 1.0)),
}
"""Cameras: where they stand, from the middle of the top, and what is up."""


def core_xml(across: int, vessel: float | None = None, pins: int = PINS, turned: str = "") -> str:
    """The geometry.xml of across x across assemblies, pins x pins each, within a cylinder of radius `vessel`.

    The radius is such that nothing is cut, if none is given. turned: three angles in degrees by which the core is
    turned in its vessel.
    """
    pitch = pitch_of_assemblies(pins)
    cylinders = (PELLET, CLAD_INSIDE, CLAD, TUBE_INSIDE, TUBE)
    lines = [f'<surface id="{i}" type="z-cylinder" coeffs="0 0 {r}"/>' for i, r in enumerate(cylinders, start=1)]
    lines += [
        f'<surface id="6" type="z-cylinder" coeffs="0 0 {vessel or across * pitch}" boundary="vacuum"/>',
        f'<surface id="7" type="z-plane" coeffs="{-HALF_HEIGHT}" boundary="vacuum"/>',
        f'<surface id="8" type="z-plane" coeffs="{HALF_HEIGHT}" boundary="vacuum"/>',
        '<cell id="1" name="fuel" universe="1" material="1" region="-1"/>',
        '<cell id="2" name="gap" universe="1" material="void" region="1 -2"/>',
        '<cell id="3" name="cladding" universe="1" material="2" region="2 -3"/>',
        '<cell id="4" name="water" universe="1" material="3" region="3"/>',
        '<cell id="5" name="water in a tube" universe="2" material="3" region="-4"/>',
        '<cell id="6" name="tube" universe="2" material="2" region="4 -5"/>',
        '<cell id="7" name="water around a tube" universe="2" material="3" region="5"/>',
        '<cell id="8" name="water" universe="5" material="3"/>',
        '<cell id="9" name="assembly" universe="3" fill="10"/>',
    ]
    whole = 'region="-6 7 -8"'
    if turned:
        lines.append(f'<cell id="20" name="turned" fill="20" {whole} rotation="{turned}"/>')
        whole = 'universe="20"'
    lines.append(f'<cell id="10" name="core" fill="11" {whole}/>')
    tubes = {tube for tube in _TUBES if max(tube) < pins} or {(pins // 2, pins // 2)}
    universes = " ".join("2" if (i, j) in tubes else "1" for i in range(pins) for j in range(pins))
    lines.append(_lattice(10, PIN_PITCH, pins, universes))
    lines.append(_lattice(11, pitch, across, " ".join(["3"] * across**2)))
    return "\n".join(["<geometry>", *lines, "</geometry>"])


def write_core(path: Path, across: int, pins: int = PINS, vessel: float | None = None, turned: str = "") -> None:
    """The same as a file."""
    path.write_text(core_xml(across, vessel, pins, turned), encoding="utf-8")


def rays_of_view(view: str, across: int, width: int) -> Rays:
    """A camera's rays, width x width, that see the top of a core, from twice its width away.

    As much is hit whatever `across` is: they are the same but for the scale.
    """
    toward, up = VIEWS[view]
    away = 2 * across * pitch_of_assemblies() * np.array(toward) / np.linalg.norm(toward)
    position = tuple(float(part) for part in away + (0.0, 0.0, HALF_HEIGHT))
    return Camera(position, (0.0, 0.0, HALF_HEIGHT), up=up, field_of_view=20).rays(width, width)


def _lattice(number: int, pitch: float, across: int, universes: str) -> str:
    """A square one about the origin, with water around it."""
    low = -across * pitch / 2
    return (
        f'<lattice id="{number}" outer="5" pitch="{pitch} {pitch}" dimension="{across} {across}" '
        f'lower_left="{low} {low}" universes="{universes}"/>'
    )
