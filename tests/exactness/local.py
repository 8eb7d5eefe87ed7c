"""The forms of a shape about a place of it, in units of its size, as pairs of floats for the filter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq, fmpz

from .forms import PAIRS, Affine, Form, carried
from .rational import ZERO, exactly, vector
from .traced import Shape
from .wide import Wide, constant


@dataclass(frozen=True)
class LocalForm:
    """Coefficients by index pair, those that are zero left out; mixed and linear ones halved."""

    k: dict[tuple[int, int], Wide]
    flat: bool
    side: int

    def __getitem__(self, pair: tuple[int, int]) -> Wide | None:
        return self.k.get((min(pair), max(pair)))


@dataclass(frozen=True)
class Local:
    """x = anchor + 2^exponent y"""

    anchor: np.ndarray
    exponent: int
    forms: list[LocalForm]
    loops: dict[int, list[list[Wide]]]
    """The vertices of each body that is a polygon, for each three coordinates."""


def located(shape: Shape, center: Any, size: float) -> Local:
    anchor, exponent = np.asarray(center, dtype=float), math.frexp(size)[1]
    unit = power_of_two(exponent)
    rows = tuple(tuple(unit if i == j else ZERO for j in range(3)) for i in range(3))
    frame = Affine(rows, vector(anchor))
    loops = {}
    for number, body in enumerate(shape.bodies):
        if body.sheet is not None and body.sheet.loop:
            back = frame.inverse()
            loops[number] = [[as_wide(c) for c in back.point(p)] for p in body.sheet.loop]
    return Local(anchor, exponent, [_local(f, frame) for f in shape.forms], loops)


def power_of_two(exponent: int) -> fmpq:
    return fmpq(fmpz(1) << exponent) if exponent >= 0 else fmpq(1, fmpz(1) << -exponent)


def _local(f: Form, frame: Affine) -> LocalForm:
    moved = carried(f, frame)
    halves = {pair: k if pair[0] == pair[1] else k / 2 for pair, k in zip(PAIRS, moved.k, strict=True) if k}
    if f.flat:
        halves = {pair: 2 * k if pair[0] != pair[1] else k for pair, k in halves.items()}
    factor = power_of_two(-max(magnitude(k) for k in halves.values()))
    return LocalForm({pair: as_wide(k * factor) for pair, k in halves.items()}, f.flat, f.side)


def magnitude(x: fmpq) -> int:
    """e with |x| about 2^e"""
    return int(x.p.height_bits()) - int(x.q.height_bits())


def as_float(x: fmpq) -> float:
    return int(x.p) / int(x.q)


def as_wide(x: fmpq) -> Wide:
    high = as_float(x)
    low = as_float(x - exactly(high))
    rest = x - exactly(high) - exactly(low)
    return constant(high, low, 0.0 if not rest else 2.0**-104 * abs(high) + 1e-290)
