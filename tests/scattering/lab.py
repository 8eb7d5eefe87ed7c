"""A bench for surfaces: thousands of directions from a material, and its BSDF at many directions, as arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from conicoid.render.bsdf.bsdf_sample import LobeSurface
from conicoid.render.bsdf.registry import evaluate_lobes, lower_albedos, lower_materials, sample_lobes

OUTSIDE, INSIDE = True, False


@numba.njit(error_model="numpy")
def _drawn(materials, albedos, at, o, numbers, out):
    for k in range(len(numbers)):
        found = sample_lobes(materials, albedos, at, (o[0], o[1], o[2]), numbers[k, 0], numbers[k, 1], numbers[k, 2])
        out[k, 0] = found.how
        out[k, 1], out[k, 2], out[k, 3] = found.i
        out[k, 4], out[k, 5], out[k, 6], out[k, 7] = found.r, found.g, found.b, found.density


@numba.njit(error_model="numpy")
def _evaluated(materials, albedos, at, o, directions, out):
    for k in range(len(directions)):
        i = (directions[k, 0], directions[k, 1], directions[k, 2])
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = evaluate_lobes(materials, albedos, at, (o[0], o[1], o[2]), i)


class Draws(NamedTuple):
    """Directions, the fate of light, its weights, and densities."""

    how: Any
    i: Any
    weight: Any
    density: Any


class Bench:
    """One material, from one side."""

    def __init__(self, material: Any, side: bool = OUTSIDE, sheet: bool = False) -> None:
        self.materials = lower_materials([material], [sheet], np.zeros(1, np.int32), {})
        self.albedos = lower_albedos(self.materials)
        row = self.materials.rows[0]
        refracts = bool(row["transparent"]) and not sheet
        self.eta = 1.0 if not refracts else float(1 / row["index"] if side else row["index"])
        color = [float(min(1.0, c * row["diffuse"])) for c in row["color"]]
        self.at = LobeSurface(np.int64(0), *color, refracts, side, self.eta)

    def draw(self, o: Any, count: int, seed: int = 0) -> Draws:
        numbers, out = np.random.default_rng(seed).random((count, 3)), np.empty((count, 8))
        _drawn(self.materials, self.albedos, self.at, np.asarray(o, float), numbers, out)
        return Draws(out[:, 0].astype(int), out[:, 1:4], out[:, 4:7], out[:, 7])

    def evaluate(self, o: Any, directions: Any) -> tuple[Any, Any]:
        """Return (f cos (n, 3), densities)."""
        out = np.empty((len(directions), 4))
        _evaluated(self.materials, self.albedos, self.at, np.asarray(o, float), np.asarray(directions, float), out)
        return out[:, :3], out[:, 3]

    def energy(self, o: Any, count: int, seed: int = 0) -> tuple[Any, Any]:
        """Return (the share of light that is sent on, rgb, its standard error), without the square of the index."""
        draws = self.draw(o, count, seed)
        weights = draws.weight / np.where(draws.i[:, 2:] < 0, self.eta**2, 1.0)
        return weights.mean(axis=0), weights.std(axis=0) / np.sqrt(count)


def towards(cosine: float, turn: float = 0.1) -> Any:
    """Return a unit direction."""
    sine = np.sqrt(1 - cosine**2)
    return np.array([sine * np.cos(2 * np.pi * turn), sine * np.sin(2 * np.pi * turn), cosine])


def sphere(count: int, seed: int = 0) -> Any:
    """Return even directions of both hemispheres."""
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.sqrt((d * d).sum(axis=1, keepdims=True))
