"""Reflection and refraction of arrays of directions, for user-written ray tracers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.records import ignore_fp_errors
from ..._util.validation import DOMAIN, is_outside_domain, real_array, refuse_columns, zero_negligible

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


@ignore_fp_errors
def reflect(directions: npt.ArrayLike, normals: npt.ArrayLike) -> FloatArray:
    """Return mirrored directions d - 2 (d·n) n, as long as d.

    A vector with a NaN, such as the normal of a miss, gives NaN.

    Parameters
    ----------
    directions : array_like (..., 3)
        Directions in which the light travels (-L of the ray tracing notes, whose formula is R = 2 (N·L) N - L).
    normals : array_like (..., 3)
        Any length, facing either way. Shapes broadcast, but not a column (n, 1, 3) with n vectors.

    Returns
    -------
    ndarray (..., 3)

    Raises
    ------
    ValueError
        For a wrong shape, and for zero or infinite vectors, with the index of the first.
    """
    d, n = _broadcast("reflect", _vectors("reflect", "directions", directions), _normals("reflect", normals))
    size = _size(d)
    unit = d / size
    return zero_negligible(np.asarray((unit - 2 * dot_columns(unit, n) * n) * size))


@ignore_fp_errors
def refract(directions: npt.ArrayLike, normals: npt.ArrayLike, eta: npt.ArrayLike) -> tuple[FloatArray, BoolArray]:
    """Return the directions behind the surface by Snell's law, and the mask of total reflection.

    t = eta (d - (d·n) n) - cos θ₂ n for unit d and n facing it, cos² θ₂ = (1 - eta²) + (eta cos θ)².
    A vector with a NaN, such as the normal of a miss, gives NaN, and a mask that is False.

    Parameters
    ----------
    directions, normals : array_like (..., 3)
        As for `reflect`.
    eta : array_like (...)
        Index before the surface / index behind it. A column for a row of rays, (n, 1) for (n,), is refused.

    Returns
    -------
    directions : ndarray (..., 3)
        As long as d; the mirrored direction for total reflection.
    total : ndarray (...) of bool
        True for total reflection.

    Raises
    ------
    ValueError
        As `reflect`, and for an eta that is not finite and > 0.
    """
    ratio = _ratio(eta)
    d, n = _vectors("refract", "directions", directions), _normals("refract", normals)
    d, n = _broadcast("refract", d, n)
    _no_column(d.shape[:-1], ratio)
    try:
        d, n, ratio = np.broadcast_arrays(d, n, ratio[..., None])
    except ValueError:
        expected = f"a number or broadcast to the rays' shape {d.shape[:-1]}"
        raise ValueError(f"refract: eta must be {expected}, got shape {ratio.shape}") from None
    size = _size(d)
    length = size * np.sqrt(dot_columns(d / size, d / size))
    unit = d / size / (length / size)
    along = dot_columns(unit, n)
    # 1 - eta² as a product keeps its digits for eta near 1.
    square = (1 - ratio) * (1 + ratio) + (ratio * along) ** 2
    # copysign turns the normal to the far side of the ray, as normals may face either way.
    beyond = ratio * (unit - along * n) + np.copysign(np.sqrt(np.maximum(square, 0)), along) * n
    # No real angle of refraction: the root above was replaced by 0, and the mirrored direction is taken.
    total = square < 0
    return zero_negligible(np.where(total, unit - 2 * along * n, beyond) * length), total[..., 0][()]


def dot_columns(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return dot products, (..., 1)."""
    return np.asarray((a * b).sum(axis=-1, keepdims=True))


def _unit(v: FloatArray) -> FloatArray:
    """Return vectors at unit length; scaled first, so that no square overflows."""
    scaled = v / np.abs(v).max(axis=-1, keepdims=True, initial=0.0)
    return np.asarray(scaled / np.sqrt(dot_columns(scaled, scaled)))


def _broadcast(owner: str, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Broadcast directions and normals together. Raise ValueError with their shapes if they do not fit.

    A column, (n, 1, 3), with n vectors, (n, 3), would be n² pairs, most likely by a mistaken axis: it is refused, as a
    column of etas is. All pairs are (n, 1, 3) with (1, n, 3).
    """
    shapes = " and ".join(str(array.shape) for array in arrays)
    few, many = sorted((array.shape for array in arrays), key=len)
    if (
        len(few) < len(many)
        and few[-2:-1] not in ((), (1,))
        and many[-2:] == (1, 3)
        and many[:-2][-len(few) + 1 :] == few[:-1]
    ):
        raise ValueError(
            f"{owner}: directions and normals must have one shape, got {shapes}; all pairs are {many} with {(1, *few)}"
        )
    try:
        return np.broadcast_arrays(*arrays)
    except ValueError:
        raise ValueError(f"{owner}: directions and normals must broadcast together, got {shapes}") from None


def _no_column(rays: tuple[int, ...], ratio: FloatArray) -> None:
    """Raise ValueError for a column of etas beside a row of rays: each ray would be paired with all of them."""
    if rays and ratio.size > 1 and ratio.shape in ((*rays, 1), (*rays, 3)):
        raise ValueError(f"refract: eta must be a number or have the rays' shape {rays}, got shape {ratio.shape}")


def _vectors(owner: str, name: str, value: Any) -> FloatArray:
    """Return an array (..., 3) of finite nonzero vectors (NaN is allowed). Raise ValueError otherwise."""
    array = real_array(owner, name, value, "an array of numbers (..., 3)")
    refuse_columns(owner, name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{owner}: {name} must have shape (..., 3), got {array.shape}")
    _refuse(owner, name, array, np.isinf(array).any(axis=-1) | (array == 0).all(axis=-1), "finite and not zero")
    return array


def _size(d: FloatArray) -> FloatArray:
    """Return the power of two next below the largest component: dividing by it rounds nothing and overflows nowhere."""
    return np.ldexp(1.0, np.frexp(np.abs(d).max(axis=-1, keepdims=True, initial=0.0))[1] - 1)


def _normals(owner: str, value: Any) -> FloatArray:
    """Return normals at unit length."""
    return _unit(_vectors(owner, "normals", value))


def _refuse(owner: str, name: str, array: FloatArray, bad: BoolArray, expected: str) -> None:
    """Raise ValueError for the first bad vector."""
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(f"{owner}: {name}{list(index) if index else ''} must be {expected}, got {array[index]}")


def _ratio(eta: Any) -> FloatArray:
    """Return eta as an array. Raise ValueError if it is not finite and > 0."""
    array = real_array("refract", "eta", eta)
    for bad, expected in ((~(np.isfinite(array) & (array > 0)), "finite and > 0"), (is_outside_domain(array), DOMAIN)):
        if bad.any():
            raise ValueError(f"refract: eta must be {expected}, got {array[bad].flat[0]}")
    return array
