"""Reflection and refraction of arrays of directions, for users who trace by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.errstate import ignore_fp_errors
from ..._util.validation import DOMAIN, is_outside_domain, real_array, refuse_columns, zero_negligible

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


@ignore_fp_errors
def reflect(directions: Any, normals: Any) -> FloatArray:
    """Mirrored directions d - 2 (d·n) n, as long as d.

    directions: (..., 3), the way the light travels (-L of the ray tracing notes, whose formula is R = 2 (N·L) N - L).
    normals: (..., 3), any length, facing either way. Shapes broadcast, but not a column (n, 1, 3) with n vectors.
    A vector with a NaN, such as the normal of a miss, gives NaN.
    Raises ValueError for a wrong shape, and for zero or infinite vectors with the index of the first.
    """
    d, n = _broadcast("reflect", _vectors("reflect", "directions", directions), _normals("reflect", normals))
    size = _size(d)
    unit = d / size
    return zero_negligible(np.asarray((unit - 2 * _dot(unit, n) * n) * size))


@ignore_fp_errors
def refract(directions: Any, normals: Any, eta: Any) -> tuple[FloatArray, BoolArray]:
    """(directions behind the surface, mask of total reflection) by Snell's law.

    directions, normals: (..., 3) as for `reflect`; the refracted directions are as long as d.
    eta: index where the ray comes from / index beyond, a number or (...); a column for a row of rays, (n, 1)
        for (n,), is refused.
    Where reflection is total the mirrored direction is returned and the mask is True. A vector with a NaN, such as the
    normal of a miss, gives NaN, and a mask that is False.
    t = eta (d - (d·n) n) - cos θ₂ n for unit d and n facing it, cos² θ₂ = (1 - eta²) + (eta cos θ)².
    Raises ValueError as `reflect` does, and for an eta that is not finite and > 0.
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
    length = size * np.sqrt(_dot(d / size, d / size))
    unit = d / size / (length / size)
    along = _dot(unit, n)
    square = (1 - ratio) * (1 + ratio) + (ratio * along) ** 2
    beyond = ratio * (unit - along * n) + np.copysign(np.sqrt(np.maximum(square, 0)), along) * n
    total = square < 0
    return zero_negligible(np.where(total, unit - 2 * along * n, beyond) * length), total[..., 0][()]


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products, (..., 1)."""
    return np.asarray((a * b).sum(axis=-1, keepdims=True))


def _unit(v: FloatArray) -> FloatArray:
    """Vectors at unit length; scaled first, so that no square overflows."""
    scaled = v / np.abs(v).max(axis=-1, keepdims=True, initial=0.0)
    return np.asarray(scaled / np.sqrt(_dot(scaled, scaled)))


def _broadcast(owner: str, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Directions and normals broadcast together, or a ValueError that names their shapes.

    A column, (n, 1, 3), with n vectors, (n, 3), would be n² pairs, as a slip of an axis is: it is refused, as a column
    of etas is. All pairs are (n, 1, 3) with (1, n, 3).
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
    """A ValueError for a column of etas, one for each of a row of rays: each ray would be paired with all of them."""
    if rays and ratio.size > 1 and ratio.shape in ((*rays, 1), (*rays, 3)):
        hint = "; eta[..., 0] is one for each ray" if ratio.shape == (*rays, 1) else ""
        raise ValueError(f"refract: eta must be a number or have the rays' shape {rays}, got shape {ratio.shape}{hint}")


def _vectors(owner: str, name: str, value: Any) -> FloatArray:
    """An array (..., 3) of finite vectors that are not zero (NaN is allowed), or a ValueError."""
    array = real_array(owner, name, value, "an array of numbers (..., 3)")
    refuse_columns(owner, name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{owner}: {name} must have shape (..., 3), got {array.shape}")
    _refuse(owner, name, array, np.isinf(array).any(axis=-1) | (array == 0).all(axis=-1), "finite and not zero")
    return array


def _size(d: FloatArray) -> FloatArray:
    """The power of two next below the largest component: dividing by it rounds nothing and overflows nowhere."""
    return np.ldexp(1.0, np.frexp(np.abs(d).max(axis=-1, keepdims=True, initial=0.0))[1] - 1)


def _normals(owner: str, value: Any) -> FloatArray:
    """Normals at unit length."""
    return _unit(_vectors(owner, "normals", value))


def _refuse(owner: str, name: str, array: FloatArray, bad: BoolArray, expected: str) -> None:
    """Raise ValueError for the first vector that is bad."""
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(f"{owner}: {name}{list(index) if index else ''} must be {expected}, got {array[index]}")


def _ratio(eta: Any) -> FloatArray:
    """eta as an array, or a ValueError."""
    array = real_array("refract", "eta", eta)
    for bad, expected in ((~(np.isfinite(array) & (array > 0)), "finite and > 0"), (is_outside_domain(array), DOMAIN)):
        if bad.any():
            raise ValueError(f"refract: eta must be {expected}, got {array[bad].flat[0]}")
    return array
