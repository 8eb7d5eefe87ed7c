"""Reflection and refraction of arrays of directions, for users who trace by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


def reflect(directions: Any, normals: Any) -> FloatArray:
    """Mirrored directions d - 2 (d·n) n, as long as d.

    directions: (..., 3), the way the light travels (-L of seed 000, whose formula is R = 2 (N·L) N - L).
    normals: (..., 3), any length, facing either way; shapes broadcast.
    A miss's NaN normal (or direction) gives NaN.
    Raises ValueError for a wrong shape, and for zero or infinite vectors with the index of the first.
    """
    d, n = np.broadcast_arrays(_vectors("directions", directions), _unit(_vectors("normals", normals)))
    return np.asarray(d - 2 * _dot(d, n) * n)


def refract(directions: Any, normals: Any, eta: Any) -> tuple[FloatArray, BoolArray]:
    """(directions behind the surface, mask of total reflection) by Snell's law.

    directions, normals: (..., 3) as for `reflect`; the refracted directions are as long as d.
    eta: index where the ray comes from / index beyond, a number or (...).
    Where reflection is total the mirrored direction is returned and the mask is True.
    t = eta (d - (d·n) n) - cos θ₂ n for unit d and n facing it, cos² θ₂ = (1 - eta²) + (eta cos θ)² (seed 000).
    Raises ValueError as `reflect` does, and for an eta that is not finite and > 0.
    """
    ratio = _ratio(eta)[..., None]
    d, n, _ = np.broadcast_arrays(_vectors("directions", directions), _unit(_vectors("normals", normals)), ratio)
    length = np.sqrt(_dot(d, d))
    unit = d / length
    along = _dot(unit, n)
    square = (1 - ratio) * (1 + ratio) + (ratio * along) ** 2
    beyond = ratio * (unit - along * n) + np.copysign(np.sqrt(np.maximum(square, 0)), along) * n
    total = square < 0
    return np.where(total, unit - 2 * along * n, beyond) * length, total[..., 0][()]


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a * b).sum(axis=-1, keepdims=True))


def _unit(v: FloatArray) -> FloatArray:
    scaled = v / np.abs(v).max(axis=-1, keepdims=True)
    return np.asarray(scaled / np.sqrt(_dot(scaled, scaled)))


def _vectors(name: str, value: Any) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), got {array.shape}")
    bad = np.isinf(array).any(axis=-1) | (array == 0).all(axis=-1)
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(f"{name}{list(index) if index else ''} must be finite and not zero, got {array[index]}")
    return array


def _ratio(eta: Any) -> FloatArray:
    array = np.asarray(eta, dtype=np.float64)
    bad = ~(np.isfinite(array) & (array > 0))
    if bad.any():
        raise ValueError(f"eta must be finite and > 0, got {array[bad].flat[0]}")
    return array
