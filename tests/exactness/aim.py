"""Where a shape is to be aimed at: points of its boundary, of its edges and corners, tangents and asymptotes.

All in floats and in bulk: what is wanted is many places that are hard, not these places exactly (`nice` has those).
"""

from __future__ import annotations

import itertools

import numpy as np

from ..oracle.cases import Case
from .oracle import Oracle
from .shapes import exact_shape

Random = np.random.Generator
Array = np.ndarray


def directions(random: Random, count: int) -> Array:
    v = random.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


class Aim:
    """A case with its oracle; places are in the local coordinates of its forms, in units of its size."""

    def __init__(self, case: Case, random: Random) -> None:
        self.case, self.random = case, random
        self.oracle = Oracle(exact_shape(case), case.world_center, case.world_size)
        forms = self.oracle.local.forms
        self.flat = np.array([f.flat for f in forms])
        self.matrices = np.zeros((len(forms), 4, 4))
        for form, matrix in zip(forms, self.matrices, strict=True):
            for (i, j), k in form.k.items():
                half = 0.5 if form.flat and i != j else 1.0
                matrix[i, j] = matrix[j, i] = half * float(k.high)
        self._look()

    def world(self, places: Array) -> Array:
        return self.oracle.local.anchor + np.ldexp(places, self.oracle.local.exponent)

    def _look(self) -> None:
        """Boundary points and points inside, from rays through a ball of the size."""
        target = directions(self.random, 2000) * 0.6 * self.random.random((2000, 1))
        d = directions(self.random, 2000)
        origins = self.world(target - 3 * d)
        found = self.oracle.answers(origins, d)
        unit = 2.0**-self.oracle.local.exponent
        t = found.high * unit
        near = (t > -100) & (t < 100)
        places = (target - 3 * d)[found.ray] + t[:, None] * d[found.ray]
        self.boundary, self.form = places[near], found.form[near]
        if not len(self.boundary):
            self.boundary, self.form = np.zeros((1, 3)), np.zeros(1, int)
        pair = np.flatnonzero((np.diff(found.ray) == 0) & found.entering[:-1] & near[:-1] & near[1:])
        self.inside = (
            (places[pair] + places[np.minimum(pair + 1, len(places) - 1)]) / 2 if len(pair) else np.zeros((1, 3))
        )
        self.edges = self._corners(2)
        self.corners = self._corners(3)

    def gradient(self, form: Array, places: Array) -> Array:
        m = self.matrices[form]
        return np.einsum("nij,nj->ni", m[:, :3, :3], places) + m[:, :3, 3]

    def value(self, form: Array, places: Array) -> Array:
        x = np.concatenate([places, np.ones((len(places), 1))], axis=1)
        return np.einsum("ni,nij,nj->n", x, self.matrices[form], x)

    def _corners(self, count: int) -> Array:
        """Points on several surfaces at once, by Newton's method with least steps from the boundary."""
        sets = list(itertools.combinations(range(len(self.matrices)), count))
        if not sets:
            return self.boundary
        picked = np.array(sets)[self.random.integers(len(sets), size=3000)]
        x = self.boundary[self.random.integers(len(self.boundary), size=3000)]
        with np.errstate(all="ignore"):
            for _ in range(12):
                rows = np.stack([2 * self.gradient(picked[:, k], x) for k in range(count)], axis=1)
                size = np.linalg.norm(rows, axis=2)
                off = np.stack([self.value(picked[:, k], x) for k in range(count)], axis=1) / size
                rows /= size[..., None]
                gram = np.nan_to_num(rows @ rows.transpose(0, 2, 1), posinf=0, neginf=0) + 1e-12 * np.eye(count)
                step = np.einsum("nki,nkj,nj->ni", rows, np.linalg.inv(gram), off)
                x = np.where(np.abs(x - step) < 1e3, x - step, 0.0)
            good = np.isfinite(x).all(axis=1) & (np.linalg.norm(x, axis=1) < 5) & (np.abs(step).max(axis=1) < 1e-12)
        return x[good] if good.any() else self.boundary

    def pick(self, places: Array, count: int) -> tuple[Array, Array]:
        """(some of the places, their indices)"""
        index = self.random.integers(len(places), size=count)
        return places[index], index

    def normals(self, index: Array) -> Array:
        """Unit normals of boundary points; some direction where the gradient vanishes."""
        g = self.gradient(self.form[index], self.boundary[index])
        size = np.linalg.norm(g, axis=1, keepdims=True)
        return np.where(size > 0, g / np.where(size > 0, size, 1), directions(self.random, len(index)))
