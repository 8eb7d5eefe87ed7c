"""The scenes and rays of the benchmark: the same numbers for everyone, from one seed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..shapes.base import Shape
from ..shapes.box import Box
from ..shapes.cylinder import Cylinder
from ..shapes.ellipsoid import Ellipsoid
from ..shapes.elliptic_cone import EllipticCone
from ..shapes.one_sheet_hyperboloid import OneSheetHyperboloid
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]

SPREAD = 0.6
"""Radii are at most this, divided by the cube root of their number: a few percent of the cube is full."""


@dataclass(frozen=True)
class Balls:
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


def balls(count: int, seed: int = 0) -> Balls:
    rng = np.random.default_rng(seed)
    centers = (rng.random((count, 3)) * 2 - 1).astype(np.float32)
    return Balls(centers, ((rng.random(count) * 0.5 + 0.5) * SPREAD / count ** (1 / 3)).astype(np.float32))


def capped_quadrics(count: int, seed: int = 0) -> CappedQuadrics:
    rng = np.random.default_rng(seed)
    centers = rng.random((count, 3)) * 2 - 1
    radii = (rng.random(count) * 0.5 + 0.5) * SPREAD / count ** (1 / 3)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return CappedQuadrics(rng.integers(0, 4, count), centers, radii, axes)


def bored_blocks(each: Balls) -> list[Shape]:
    """For each ball, what is left of it in a box of 3/4 its size after three bores: five leaves."""
    block: Any = Sphere(1) & Box((-0.75, -0.75, -0.75), (0.75, 0.75, 0.75))
    for axis in np.eye(3):
        block = block - Cylinder(_vector(-axis), _vector(axis), 0.4)
    return [block.scale(r).translate(c) for r, c in zip(each.radii.tolist(), each.centers.tolist(), strict=True)]


def spheres(each: Balls) -> list[Shape]:
    """A body for each."""
    return [Sphere(r, c) for r, c in zip(each.radii.tolist(), each.centers.tolist(), strict=True)]


def cut_balls(each: Balls) -> list[Shape]:
    """Balls as quadrics between two planes just beyond them, as POV-Ray's `quadric` clipped by a box."""
    rows = zip(each.radii.tolist(), each.centers.tolist(), strict=True)
    return [Ellipsoid((r, r, r), c, z_range=(-1.01 * r, 1.01 * r)) for r, c in rows]


@dataclass(frozen=True)
class Boxes:
    """Boxes of half sizes (N, 3), turned by matrices (N, 3, 3), about centers (N, 3)."""

    halves: Floats
    turns: Floats
    centers: Floats

    def shapes(self) -> list[Shape]:
        rows = zip(self.halves.tolist(), self.turns, self.centers, strict=True)
        return [Box((-a, -b, -c), (a, b, c)).transform(_matrix(turn, at)) for (a, b, c), turn, at in rows]


def boxes(count: int, seed: int = 0) -> Boxes:
    rng = np.random.default_rng(seed)
    each, turns = balls(count, seed), np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    halves = each.radii[:, None] * rng.uniform(0.3, 1.0, (count, 3))
    return Boxes(halves, turns, each.centers.astype(float))


def growing_balls(count: int) -> Balls:
    """Radii 0.7 N^(-1/2): a line through the middle of the cube meets about 1.5 of them, however many there are."""
    rng = np.random.default_rng(0)
    radii = np.full(count, 0.7 * count**-0.5, np.float32)
    return Balls(rng.uniform(-1, 1, (count, 3)).astype(np.float32), radii)


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
