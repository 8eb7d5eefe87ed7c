"""Bounds on the t of crossings: from numbers in two floats (errors.py), and exact where these say too little.

That is so of roots along asymptotes of forms that are irrational. There the bound is the distance of what is reported
from the nearest exact root (conicoid.exact).
"""

from __future__ import annotations

from math import inf, nextafter
from typing import TYPE_CHECKING, Any

import numpy as np

from ...exact.forms import line
from ...exact.roots import Root, roots
from ...shapes.vector import FloatArray
from ..threads import run_chunks
from .errors import errors_of_t
from .forms import form

if TYPE_CHECKING:
    from ..prepared import Prepared

_MUCH = 2.0**-24
"""Of |t| and of |o| / |d|: a larger bound is replaced by an exact one."""
_BITS = 128
_CHUNK = 16384


def bounds_of_t(
    scene: Prepared, lines: tuple[FloatArray, FloatArray], starts: Any, which: Any, t: FloatArray, surfaces: Any
) -> FloatArray:
    """A bound on the error of each t, of a crossing of ray which[k] (k, if empty) with surfaces[k]; 0 for none (-1)."""
    errors, arguments = np.empty(len(t)), (scene.geometry, scene.rest, *lines, which, t, surfaces)
    run_chunks(lambda a, b: errors_of_t(*arguments, a, b, errors), len(t), _CHUNK)
    large = np.flatnonzero(~(errors <= _MUCH * np.abs(t)) & (surfaces >= 0))
    ray = which[large] if len(which) else large
    origins, directions = lines[0][ray], lines[1][ray]
    with np.errstate(over="ignore"):
        size = np.abs(origins).max(axis=1, initial=0.0) / np.abs(directions).max(axis=1, initial=0.0)
    some = ~(errors[large] <= _MUCH * (np.abs(t[large]) + size))
    for k, origin, direction in zip(
        large[some].tolist(), origins[some].tolist(), directions[some].tolist(), strict=True
    ):
        found = list(roots(form(scene, int(surfaces[k])).along(line(origin, direction))))
        i = int(which[k]) if len(which) else k
        if found and starts.size and starts[i if len(starts) > 1 else 0] == surfaces[k]:
            found.remove(min(found, key=lambda root: abs(float(root))))  # the one that the ray starts on
        errors[k] = min((_distance(root, float(t[k])) for root in found), default=errors[k])
    return errors


def _distance(root: Root, t: float) -> float:
    """How far a root is from t, rounded up."""
    at, (above, below) = root.within(_BITS), t.as_integer_ratio()
    apart = max(abs(end * below - above * at.unit) for end in (at.low, at.high))
    try:
        return nextafter(apart / (at.unit * below), inf)
    except OverflowError:
        return inf
