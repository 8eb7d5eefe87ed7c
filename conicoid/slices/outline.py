"""A piece of a wall in a slice: a line, or a part of an ellipse, a parabola or a hyperbola."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..shapes.calls import explained_methods
from ..shapes.validate import shown, whole
from ..shapes.vector import FloatArray
from .central import Ellipse
from .curve import Curve, gradient, value

_DEEPEST = 12


@explained_methods
class Outline:
    """A piece of the curve in which a plane cuts a wall. Places are in lengths along u and v, as `Slice.extent`.

    kind       "line", "ellipse", "parabola" or "hyperbola"
    surfaces   the surfaces it lies in, as `hits.surface` has them: several where walls coincide
    left, right   bodies on both sides of it, looking from start to end, the first listed first
    bodies     those whose boundary it is
    start, end   its ends, where the wall meets others: equal for a whole ellipse
    curve, begin, stop, ends   what it is made from, by `Slice.outlines`
    center, radii, angle   of an ellipse: its half-axes, and the direction of the first in degrees; None for others
    """

    def __init__(
        self, curve: Curve, begin: float, stop: float, ends: tuple[FloatArray, FloatArray], surfaces: tuple[int, ...],
        left: tuple[int, ...], right: tuple[int, ...], bodies: tuple[int, ...],
    ) -> None:  # fmt: skip
        self._curve, self._begin, self._stop, self._ends = curve, begin, stop, ends
        self._origin = np.zeros(2)
        self.kind, self.surfaces = curve.kind, surfaces
        self.left, self.right, self.bodies = left, right, bodies

    @property
    def start(self) -> FloatArray:
        """Where it begins, (2,)."""
        place: FloatArray = self._ends[0] + self._origin
        return place

    @property
    def end(self) -> FloatArray:
        """Where it ends, (2,)."""
        place: FloatArray = self._ends[1] + self._origin
        return place

    @property
    def is_closed(self) -> bool:
        """Is it a whole ellipse?"""
        return self._curve.closed and self._stop - self._begin > 2 * math.pi * (1 - 1e-15)

    @property
    def center(self) -> FloatArray | None:
        """Of an ellipse, (2,)."""
        return np.array(self._curve.center) + self._origin if isinstance(self._curve, Ellipse) else None

    @property
    def radii(self) -> tuple[float, float] | None:
        """Half-axes of an ellipse."""
        return self._curve.radii if isinstance(self._curve, Ellipse) else None

    @property
    def angle(self) -> float | None:
        """Direction of the first half-axis of an ellipse, in degrees from that of u."""
        if not isinstance(self._curve, Ellipse):
            return None
        return math.degrees(math.atan2(self._curve.axis[1], self._curve.axis[0]))

    def points(self, count: int = 33) -> FloatArray:
        """Places (count, 2) along it, from end to end, each on the wall to rounding.

        count: at least 2.
        """
        number = whole(count)
        if number is None or number < 2:
            raise ValueError(f"Outline: count must be a whole number from 2 on, got {shown(count)}")
        places: FloatArray = self._about(np.linspace(self._begin, self._stop, number)) + self._origin
        return places

    def _about(self, t: Any) -> FloatArray:
        """Places about the middle of the window; the ends are where they were found to be."""
        places = self._curve.points(t)
        places[t == self._begin], places[t == self._stop] = self._ends
        return places

    def distance(self, places: Any) -> Any:
        """How far places (..., 2) are from the whole curve, to first order: for tests of places that are near to it.

        places: numbers as `extent` has them.
        """
        about = np.asarray(places, float) - self._origin
        slope = np.linalg.norm(2 * gradient(self._curve.conic, about), axis=-1)
        return np.abs(value(self._curve.conic, about)) / slope

    def _cubics(self, off: float) -> FloatArray:
        """(pieces, 4, 2): cubic Béziers about the middle of the window, at most `off` from the curve.

        Lines and parabolas are cubics. Of the others each piece is tested at sixteen places, and halved until it fits.
        """
        turn = math.pi / 4 if self.kind == "ellipse" else 1.0
        pieces = 1 if self.kind in ("line", "parabola") else max(1, math.ceil((self._stop - self._begin) / turn))
        for _ in range(_DEEPEST):
            cubics = self._with(pieces)
            if self.kind in ("line", "parabola") or self._off(cubics) <= off:
                break
            pieces *= 2
        return cubics

    def _with(self, pieces: int) -> FloatArray:
        """Béziers that touch the curve at their ends, its middle too: k = 4/3 tan(h/4) of the slope by the angle."""
        t = np.linspace(self._begin, self._stop, pieces + 1)
        places, slopes, h = self._about(t), self._curve.velocity(t), (self._stop - self._begin) / pieces
        k = {"ellipse": 4 / 3 * math.tan(h / 4), "hyperbola": 4 / 3 * math.tanh(h / 4)}.get(self.kind, h / 3)
        first, last = places[:-1] + k * slopes[:-1], places[1:] - k * slopes[1:]
        if self.kind == "line":
            first, last = (2 * places[:-1] + places[1:]) / 3, (places[:-1] + 2 * places[1:]) / 3
        cubics: FloatArray = np.stack([places[:-1], first, last, places[1:]], axis=1)
        return cubics

    def _off(self, cubics: FloatArray) -> float:
        """By how much Béziers leave the curve, at places along them."""
        t = np.linspace(0, 1, 17)[1:-1]
        basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        places = np.einsum("kt,nkx->ntx", basis, cubics)
        return float(self.distance(places + self._origin).max())

    def __repr__(self) -> str:
        (a, b), (c, d) = self.start.tolist(), self.end.tolist()
        way = "whole" if self.is_closed else f"({a:.6g}, {b:.6g}) to ({c:.6g}, {d:.6g})"
        return f"Outline({self.kind}, {way}, left={self.left}, right={self.right})"
