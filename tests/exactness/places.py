"""How far points lie beside the surfaces of a shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from .filtered import X, Y, Z, _filled, _inner, _relative, _sum, gradient
from .oracle import Oracle
from .wide import Array


def off_surface(oracle: Oracle, points: Array) -> tuple[Array, Array]:
    """(distance from the nearest surface to first order, which one), |f| / |grad f| in pairs of floats."""
    local = oracle.local
    p = [_relative(points[:, i], local.anchor[i], 2.0**-local.exponent) for i in range(3)]
    found = []
    with np.errstate(all="ignore"):
        for f in local.forms:
            linear = [f[i, 3] for i in (X, Y, Z)]
            if f.flat:
                value, slope = _sum([_inner(linear, p), f[3, 3]]), linear
            else:
                half = gradient(f, p, True)
                value, slope = _sum([_inner(half, p), _inner(linear, p), f[3, 3]]), half
            filled = [_filled(g, len(points)).high * (1.0 if f.flat else 2.0) for g in slope]
            size = np.sqrt(sum(g * g for g in filled))
            whole = _filled(value, len(points))
            found.append(np.maximum(np.abs(whole.high + whole.low) - whole.error, 0.0) / size)
    distances = np.stack(found, axis=1)
    nearest = distances.argmin(axis=1)
    return np.ldexp(distances[np.arange(len(points)), nearest], local.exponent) * (1 - 1e-9), nearest


def learn(forms: dict[int, int], hits: Any, nearest: np.ndarray) -> None:
    """Which of the oracle's forms each surface of the scene is: the one that most of its first points lie on."""
    for surface in set(hits.surface.tolist()):
        forms.setdefault(surface, int(np.bincount(nearest[hits.surface == surface]).argmax()))
