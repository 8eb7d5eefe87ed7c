"""Whether a quadric solid between planes ends: the directions in which it may go to infinity.

A sequence of its points that leaves every ball does so along a v != 0 with n_i·v <= 0 and vᵀA v <= 0. Where A has no
negative eigenvalue the solid is convex and v satisfies more: A v = 0 and l·v <= 0. The same holds where planes
across them bound the axes of all negative eigenvalues, since the terms along those are then bounded.
"""

from __future__ import annotations

import numpy as np

from .row_vectors import cross_rows, lengths, unit_rows
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
    across = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    # 4 is above the other eigenvalues: the normal comes last
    forms = across @ (squares[:, None] * across) + 4 * (np.eye(3) - across)
    in_planes = np.linalg.eigh(forms)[1][:, :, :2].transpose(0, 2, 1).reshape(-1, 3)
    first, second = np.triu_indices(count, 1)
    edges = cross_rows(normals[first], normals[second])
    sine = lengths(edges)
    real = sine > _PARALLEL
    edges = edges[real] / sine[real, None]
    candidates = np.concatenate([np.eye(3), in_planes, edges])
    slack = np.concatenate([np.full(3 + 2 * count, _MARGIN), _MARGIN + _SLACK / sine[real]])
    flat = (candidates * candidates) @ squares <= 2 * slack
    rates = candidates @ normals.T
    free = (rates <= slack[:, None]).all(axis=1) | (rates >= -slack[:, None]).all(axis=1)
    return not (flat & free).any()
