"""Which body holds a point: the filter over many points, exact arithmetic for the rest."""

from __future__ import annotations

import numpy as np

from .filtered import X, Y, Z, _filled, _inner, _relative, _sum, gradient
from .oracle import Oracle
from .wide import Array


def body_at(oracle: Oracle, points: Array) -> Array:
    """The first body that holds each point, or -1."""
    shape, local = oracle.shape, oracle.local
    with np.errstate(all="ignore"):
        p = [_relative(points[:, i], local.anchor[i], 2.0**-local.exponent) for i in range(3)]
        certain = np.ones(len(points), bool)
        below = []
        for f in local.forms:
            linear = [f[i, 3] for i in (X, Y, Z)]
            second = None if f.flat else _inner(gradient(f, p, False), p)
            twice = [_inner(linear, p)] * (1 if f.flat else 2)
            value = _filled(_sum([second, *twice, f[3, 3]]), len(points))
            certain &= value.negative | value.positive | value.zero
            below.append(value.negative | value.zero)
    found = np.full(len(points), -1)
    for number, body in reversed(list(enumerate(shape.bodies))):
        if body.sheet is None and body.formula is not None:
            found[np.broadcast_to(shape.truth(body.formula, below.__getitem__), len(points))] = number
    for i in np.flatnonzero(~certain).tolist():
        found[i] = shape.body_at(points[i])
    return found
