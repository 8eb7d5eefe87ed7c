"""Whether a quadric solid between planes ends: the directions in which it may go to infinity.

A sequence of its points that leaves every ball does so along a v != 0 with n_i·v <= 0 and vᵀA v <= 0. Where A has no
negative eigenvalue the solid is convex and v satisfies more: A v = 0 and l·v <= 0. The same holds where planes
across them bound the axes of all negative eigenvalues, since the terms along those are then bounded.
"""

from __future__ import annotations

import numpy as np

from .row_vectors import cross_rows, dot_rows, lengths, product, unit_rows
from .vector import FloatArray

_MARGIN = 2.0**-16
"""A cone of directions that is only this close to empty counts as not empty."""
_PARALLEL = 2.0**-49
_SLACK = 2.0**-44


def ends(normals: FloatArray, squares: FloatArray, linear: FloatArray) -> bool:
    """True if Σ squares u² + 2 linear·u <= constant, normals·u <= offsets is certainly bounded.

    `squares` are 1, 0 or -1, `normals` (n, 3) of unit length.
    """
    falling = [k for k in range(3) if squares[k] < 0]
    if falling and _only_zero(normals, squares):
        return True
    if not all(_between(normals, k) for k in falling):
        return False
    rows = [normals]
    for k in range(3):
        if squares[k] > 0:
            rows.append(np.eye(3)[[k, k]] * ((1.0,), (-1.0,)))
    slope = np.where(squares == 0, linear, 0.0)
    if slope.any():
        rows.append(unit_rows(slope[None, :])[0])
    return _only_zero(np.concatenate(rows), np.zeros(3))


def _between(normals: FloatArray, axis: int) -> bool:
    """Whether two of the planes, exactly across a coordinate axis, bound it on both sides."""
    across = normals[(normals != 0).sum(axis=1) == 1][:, axis]
    return bool((across > 0).any() and (across < 0).any())


def _only_zero(normals: FloatArray, squares: FloatArray) -> bool:
    """Whether no v != 0 has normals·v <= 0 and Σ squares v² <= 0, by a margin.

    The least Σ squares v² over unit v lies on an axis, is stationary across one normal, or lies across two.
    """
    count = len(normals)
    in_planes = _stationary(normals, squares)
    first, second = np.triu_indices(count, 1)
    edges = cross_rows(normals[first], normals[second])
    sine = lengths(edges)
    real = sine > _PARALLEL
    edges = edges[real] / sine[real, None]
    candidates = np.concatenate([np.eye(3), in_planes, edges])
    slack = np.concatenate([np.full(3 + 2 * count, _MARGIN), _MARGIN + _SLACK / sine[real]])
    flat = dot_rows(candidates * candidates, squares) <= 2 * slack
    rates = product(candidates, normals.T)
    free = (rates <= slack[:, None]).all(axis=1) | (rates >= -slack[:, None]).all(axis=1)
    return not (flat & free).any()


def _stationary(normals: FloatArray, squares: FloatArray) -> FloatArray:
    """Two unit vectors v across each normal, at which Σ squares v² of those across it is stationary, (2 n, 3).

    In a basis of the plane the form is (p, q; q, r), and v a multiple of (q, -d ± sqrt(d² + q²)), d = (p - r) / 2.
    """
    a = unit_rows(cross_rows(normals, np.eye(3)[np.abs(normals).argmin(axis=1)]))[0]
    b = cross_rows(normals, a)
    d = (dot_rows(a * a, squares) - dot_rows(b * b, squares)) / 2
    q = dot_rows(a * b, squares)
    more = np.abs(d) + np.sqrt(d * d + q * q)
    x, y = np.where(d < 0, q, more), np.where(d < 0, more, q)  # whatever does not cancel
    x = np.where(more > 0, x, 1.0)
    first = unit_rows(x[:, None] * a + y[:, None] * b)[0]
    return np.concatenate([first, cross_rows(normals, first)])
