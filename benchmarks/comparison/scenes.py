"""The scenes and rays of the benchmark: the same numbers for everyone, from one seed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from conicoid.geometry.bulk import Spheres
from conicoid.geometry.primitives import Box, Cylinder, Sphere
from conicoid.geometry.quadrics import Ellipsoid, EllipticCone, OneSheetHyperboloid
from conicoid.geometry.shape import Shape
from conicoid.queries.rays import Rays
from conicoid.render.camera import Camera

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]

SPREAD = 0.6
"""Radii are at most this, divided by the cube root of their number: a few percent of the cube is full."""


@dataclass(frozen=True)
class BallRows:
    """Centers (N, 3) in the cube [-1, 1]³ and radii (N,), float32, so that every peer has the same."""

    centers: Singles
    radii: Singles

    def shapes(self) -> list[Shape]:
        return [Spheres(self.centers, self.radii)]


@dataclass(frozen=True)
class CappedQuadrics:
    """Quadrics about centers (N, 3), along unit axes (N, 3), between two planes at ±0.6 r.

    kinds (N,): 0 ball, 1 cylinder, both of radius r; 2 double cone of half angle 45°, 3 one-sheet hyperboloid
    ρ² - z² = r²/5.
    """

    kinds: npt.NDArray[np.int64]
    centers: Floats
    radii: Floats
    axes: Floats

    def shapes(self) -> list[Shape]:
        rows = zip(self.kinds.tolist(), self.centers, self.radii.tolist(), self.axes, strict=True)
        return [_capped_quadric(*row) for row in rows]


def _capped_quadric(kind: int, center: Floats, r: float, axis: Floats) -> Shape:
    half = 0.6 * r
    if kind == 1:
        return Cylinder(_vector(center - half * axis), _vector(center + half * axis), r)
    between = (-half, half)
    upright: Shape
    if kind == 0:
        upright = Ellipsoid.from_coefficients(r**-2, r**-2, r**-2, z_range=between)
    elif kind == 2:
        upright = EllipticCone(r**-2, r**-2, r**-2, z_range=between)
    else:
        upright = OneSheetHyperboloid(5 * r**-2, 5 * r**-2, 5 * r**-2, z_range=between)
    turned = upright.rotate(np.cross((0, 0, 1), axis), math.degrees(math.acos(axis[2])))
    return turned.translate(center)


def _vector(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z


def _matrix(turn: Floats, center: Floats) -> Floats:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turn, center
    return whole


def balls(count: int, seed: int = 0) -> BallRows:
    rng = np.random.default_rng(seed)
    centers = (rng.random((count, 3)) * 2 - 1).astype(np.float32)
    return BallRows(centers, ((rng.random(count) * 0.5 + 0.5) * SPREAD / count ** (1 / 3)).astype(np.float32))


def capped_quadrics(count: int, seed: int = 0) -> CappedQuadrics:
    rng = np.random.default_rng(seed)
    centers = rng.random((count, 3)) * 2 - 1
    radii = (rng.random(count) * 0.5 + 0.5) * SPREAD / count ** (1 / 3)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return CappedQuadrics(rng.integers(0, 4, count), centers, radii, axes)


def bored_blocks(each: BallRows) -> list[Shape]:
    """Return for each ball its part in a box of 3/4 its size after three bores: five leaves."""
    block: Any = Sphere(1) & Box((-0.75, -0.75, -0.75), (0.75, 0.75, 0.75))
    for axis in np.eye(3):
        block = block - Cylinder(_vector(-axis), _vector(axis), 0.4)
    return [block.scale(r).translate(c) for r, c in zip(each.radii.tolist(), each.centers.tolist(), strict=True)]


def spheres(each: BallRows) -> list[Shape]:
    """A body for each."""
    return [Sphere(r, c) for r, c in zip(each.radii.tolist(), each.centers.tolist(), strict=True)]


def cut_balls(each: BallRows) -> list[Shape]:
    """Balls as quadrics between two planes just beyond them, as POV-Ray's `quadric` clipped by a box."""
    rows = zip(each.radii.tolist(), each.centers.tolist(), strict=True)
    return [Ellipsoid((r, r, r), c, z_range=(-1.01 * r, 1.01 * r)) for r, c in rows]


@dataclass(frozen=True)
class BoxRows:
    """Boxes of half sizes (N, 3), turned by matrices (N, 3, 3), about centers (N, 3)."""

    halves: Floats
    turns: Floats
    centers: Floats

    def shapes(self) -> list[Shape]:
        rows = zip(self.halves.tolist(), self.turns, self.centers, strict=True)
        return [Box((-a, -b, -c), (a, b, c)).transform(_matrix(turn, at)) for (a, b, c), turn, at in rows]


def boxes(count: int, seed: int = 0) -> BoxRows:
    rng = np.random.default_rng(seed)
    each, turns = balls(count, seed), np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    halves = each.radii[:, None] * rng.uniform(0.3, 1.0, (count, 3))
    return BoxRows(halves, turns, each.centers.astype(float))


def growing_balls(count: int) -> BallRows:
    """Radii 0.7 N^(-1/2): a line through the middle of the cube meets about 1.5 of them, however many there are."""
    rng = np.random.default_rng(0)
    radii = np.full(count, 0.7 * count**-0.5, np.float32)
    return BallRows(rng.uniform(-1, 1, (count, 3)).astype(np.float32), radii)


def camera_rays(width: int) -> tuple[Singles, Singles]:
    """A square pinhole camera at (0, 0, -3) that looks along z: origins and directions (width, width, 3)."""
    y, x = np.meshgrid(*2 * [np.linspace(-0.5, 0.5, width)], indexing="ij")
    directions = np.stack([x, y, np.ones_like(x)], axis=-1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    origins = np.broadcast_to(np.array((0, 0, -3), np.float32), directions.shape)
    return np.ascontiguousarray(origins), directions.astype(np.float32)


def random_rays(count: int, seed: int = 1) -> tuple[Singles, Singles]:
    """Origins uniform in the cube [-1, 1]³, directions uniform on the sphere: (count, 3) each."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return (rng.random((count, 3)) * 2 - 1).astype(np.float32), directions.astype(np.float32)


# A reactor core for OpenMC: any number of assemblies of 17 x 17 pins within a vessel. Radii and pitches are those of
# the BEAVRS benchmark (MIT CRPG, "Benchmark for Evaluation and Validation of Reactor Simulations", rev. 2.0.2): pellet,
# cladding, guide tube, pin and assembly pitch, in cm.

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
"""Cameras: their places, from the middle of the top, and their upward directions."""


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
