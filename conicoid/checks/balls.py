"""Digits of balls, by a formula and all at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.motion import Motion
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres
from ..shapes.vector import FloatArray
from .changes import HALF_ULP
from .local import Fields, Frame, fields_of
from .movement import Movement, moved
from .verdict import ALL_DIGITS, Conditioning, verdict

_STEPS = 4


def ball_verdict(leaf: Sphere, motion: Motion, body: int) -> Conditioning:
    """The worst place of one ball."""
    balls = Balls.of(Spheres([leaf.center], [leaf.radius], motion=motion), body)
    return balls.told(0, leaf, ("center[0]", "center[1]", "center[2]", "radius"))


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls with consecutive ids, all at once: how far they move, and the direction (N, 3) in which that is."""

    shape: Spheres
    first: int
    fields: Fields
    relative: FloatArray
    where: FloatArray

    @classmethod
    def of(cls, shape: Spheres, first: int) -> Balls:
        fields = fields_of(shape.motion, Frame(ex.exact_row((0.0, 0.0, 0.0)), ex.IDENTITY))
        return cls(shape, first, fields, *ball_movements(shape.centers, shape.radii, fields))

    @property
    def digits(self) -> FloatArray:
        """(N,), as `digits_of` for each."""
        with np.errstate(divide="ignore"):
            result: FloatArray = np.clip(-np.log10(self.relative), 0.0, ALL_DIGITS)
        return result

    def below(self, limit: float, most: int | None) -> Iterator[Conditioning]:
        """Those with fewer digits, in order; if there are more than `most`, the worst of them."""
        digits = self.digits
        few = np.flatnonzero(digits < limit)
        if most is not None and len(few) > most:
            few = np.sort(few[np.argsort(digits[few], kind="stable")[:most]])
        for i in few.tolist():
            names = (*(f"centers[{i}][{k}]" for k in range(3)), f"radii[{i}]")
            yield self.told(i, self.shape, names)

    def told(self, i: int, leaf: Any, names: tuple[str, ...]) -> Conditioning:
        center, radius, n = self.shape.centers[i], float(self.shape.radii[i]), self.where[i]
        shares = ball_shares(center, radius, n, self.fields)
        number = (*names, *self.fields.numbers)[int(shares.argmax())]
        worst = Movement(float(self.relative[i]), number, radius * n, n, 2 * radius)
        return verdict(
            leaf, self.shape.motion, self.first + i, worst, Frame(ex.exact_row(center.tolist()), ex.IDENTITY)
        )


def ball_movements(centers: FloatArray, radii: FloatArray, fields: Fields) -> tuple[FloatArray, FloatArray]:
    """((N,), (N, 3)) for balls: the worst movement and the direction from the center in which it is.

    `fields` are those of the balls' own coordinates. Along the unit vector n the surface goes by
    Σ |n_k c_k| + r for the ball's own numbers, and by n·field(c + r n) for each number of a motion. From the worst
    axis, n turns to the sum of all changes with their signs, which makes the sum of their sizes grow.
    """
    worst, where = np.zeros(len(radii)), np.zeros((len(radii), 3))
    own = np.eye(3) * centers[:, None, :]

    def look(n: FloatArray) -> FloatArray:
        """Note where a direction (N, 3) is worse; the sum of all changes, each with the sign that it has there."""
        points = centers + radii[:, None] * n
        goes = [*own.transpose(1, 0, 2) * HALF_ULP, *(points @ field[:, :3].T + field[:, 3] for field in fields.fields)]
        along = [(vector * n).sum(axis=1) for vector in goes]
        change = HALF_ULP * radii + sum(np.abs(one) for one in along)
        relative = moved(change / (2 * radii), 1.0, 1.0)
        better = relative > worst
        worst[better], where[better] = relative[better], n[better]
        total: FloatArray = np.sum(
            [np.copysign(1.0, one)[:, None] * one_ for one, one_ in zip(along, goes, strict=True)], axis=0
        )
        return total

    for start in np.eye(3):
        look(np.broadcast_to(start, centers.shape))
    n = where.copy()
    for _ in range(_STEPS):
        total = look(n)
        lengths = np.linalg.norm(total, axis=1)
        n = np.where(lengths[:, None] > 0, total / np.where(lengths > 0, lengths, 1.0)[:, None], n)
    look(n)
    return worst, where


def ball_shares(center: FloatArray, radius: float, n: FloatArray, fields: Fields) -> FloatArray:
    """What each number gives to that sum for one ball: center, radius, motion."""
    own = HALF_ULP * np.append(np.abs(n * center), radius)
    return np.append(own, np.abs(fields.fields @ np.append(center + radius * n, 1.0) @ n))
