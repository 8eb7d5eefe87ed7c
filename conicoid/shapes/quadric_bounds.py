"""The support of a solid quadric: the dual quadric, and where it is infinite.

In coordinates along the principal axes f = Σ λ_i y_i² + 2 β·y + γ. If any λ is negative the solid
spans all of space. If none is, completing the squares leaves an ellipsoid or elliptic cylinder
(Σ λ_i y_i² <= -γ), or a paraboloid, which has linear terms along directions with λ = 0.
"""

from __future__ import annotations

import math

import numpy as np

from . import exact as ex
from .planar import rounded_up
from .surface import QuadricSurface
from .vector import Box


def quadric_bounds(surface: QuadricSurface) -> Box:
    """(low, high) of the solid in the coordinates that the surface is given in, rounded outward."""
    w = ex.exact_row(surface.rows[0]), ex.exact_row(surface.rows[1]), ex.exact_row(surface.rows[2])
    anchor = ex.exact_row(surface.anchor)
    columns = ex.inverse(w)
    low, high = np.empty(3), np.empty(3)
    for i in range(3):
        # x_i = anchor_i + row i of W⁻¹ · y
        up, down = columns[i], (-columns[i][0], -columns[i][1], -columns[i][2])
        high[i] = _shifted(own_support(surface, up), anchor[i])
        low[i] = -_shifted(own_support(surface, down), -anchor[i])
    return low + 0.0, high


def _shifted(support: ex.Exact | float, shift: ex.Exact) -> float:
    if isinstance(support, float):
        return support
    return rounded_up(ex.cancelling_sum((support, shift)))


def own_support(surface: QuadricSurface, direction: ex.Row) -> ex.Exact | float:
    """sup of e·y over f <= 0 in the surface's own coordinates y; the float inf or -inf where not finite."""
    squares, slopes = ex.exact_row(surface.squares), ex.exact_row(surface.linear)
    gamma = -ex.exact(surface.constant)
    if any(s < 0 for s in squares):
        return math.inf
    curved = [i for i in range(3) if squares[i]]
    flat = [i for i in range(3) if not squares[i]]
    # Complete the squares: y_i = z_i - β_i / λ_i
    gamma = ex.cancelling_sum([gamma, *(-slopes[i] * slopes[i] / squares[i] for i in curved)])
    center = [-direction[i] * slopes[i] / squares[i] for i in curved]
    spread = ex.cancelling_sum([ex.ZERO, *(direction[i] * direction[i] / squares[i] for i in curved)])
    if any(slopes[i] for i in flat):
        k = _multiple([direction[i] for i in flat], [slopes[i] for i in flat])
        if k is None or k < 0 or (spread and not k):
            return math.inf
        reach = (spread / k - k * gamma) / 2 if k else ex.ZERO
        return ex.cancelling_sum([reach, *center])
    if gamma > 0:
        return -math.inf
    if any(direction[i] for i in flat):
        return math.inf
    return ex.cancelling_sum([ex.sqrt(-gamma * spread), *center])


def _multiple(vector: list[ex.Exact], base: list[ex.Exact]) -> ex.Exact | None:
    """k where vector = k base, None where there is none."""
    lead = max(range(len(base)), key=lambda i: abs(base[i]))
    k = vector[lead] / base[lead]
    return k if not any(ex.cancelling_sum((v, -k * b)) for v, b in zip(vector, base, strict=True)) else None
