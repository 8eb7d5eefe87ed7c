"""Derivatives of `co.reflect` and `co.refract` by directions, normals and the ratio of indices.

With the unit vectors u = d / |d| and n, the reflected direction is u - 2 (u·n) n. The refracted direction is
eta (u - c n) + s n with c = u·n and s = ±sqrt(1 - eta² + eta² c²), where s has the sign of c. Both results have the
length of d. Total reflection is differentiated as reflection. At the critical angle s = 0, and no derivative exists.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.records import FloatArray, ignore_fp_errors
from ..._util.validation import real_array
from ..optics.refraction import dot_columns, reflect, refract


@ignore_fp_errors
def reflect_jvp(
    directions: npt.ArrayLike,
    normals: npt.ArrayLike,
    d_directions: npt.ArrayLike | None = None,
    d_normals: npt.ArrayLike | None = None,
) -> FloatArray:
    """Return the tangent of `co.reflect(directions, normals)` (forward mode).

    Parameters
    ----------
    directions, normals : array_like (..., 3)
        The arguments of `co.reflect`.
    d_directions, d_normals : array_like (..., 3), optional
        Their tangents; None for no change. A change of the length of a normal has no effect.

    Returns
    -------
    ndarray (..., 3)

    Raises
    ------
    ValueError
        If a tangent does not broadcast to the shape of the vectors, and for the reasons of `co.reflect`.
    """
    reflect(directions, normals)  # it checks the arguments
    d, n, _ = _parts(directions, normals)
    dd, dn = (
        _like("reflect_jvp", "d_directions", d_directions, d),
        _across(n, _like("reflect_jvp", "d_normals", d_normals, d), normals),
    )
    # The product rule for d - 2 (d·n) n.
    return dd - 2 * (dot_columns(dd, n) + dot_columns(d, dn)) * n - 2 * dot_columns(d, n) * dn


@ignore_fp_errors
def reflect_vjp(
    directions: npt.ArrayLike, normals: npt.ArrayLike, cotangents: npt.ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the gradient of Σ cotangent · co.reflect(directions, normals) by its arguments (reverse mode).

    Parameters
    ----------
    directions, normals : array_like (..., 3)
        The arguments of `co.reflect`.
    cotangents : array_like (..., 3)
        The cotangents of the reflected directions.

    Returns
    -------
    tuple of ndarray (..., 3)
        The cotangents of directions and of normals, both of the shape that the two have together.

    Raises
    ------
    ValueError
        If the cotangents do not broadcast to that shape, and for the reasons of `co.reflect`.
    """
    reflect(directions, normals)  # it checks the arguments
    d, n, _ = _parts(directions, normals)
    w = _like("reflect_vjp", "cotangents", cotangents, d)
    of_n = -2 * (dot_columns(w, n) * d + dot_columns(d, n) * w)
    return w - 2 * dot_columns(w, n) * n, _across(n, of_n, normals)


@ignore_fp_errors
def refract_jvp(
    directions: npt.ArrayLike,
    normals: npt.ArrayLike,
    eta: npt.ArrayLike,
    d_directions: npt.ArrayLike | None = None,
    d_normals: npt.ArrayLike | None = None,
    d_eta: npt.ArrayLike | None = None,
) -> FloatArray:
    """Return the tangent of the directions of `co.refract(directions, normals, eta)` (forward mode).

    Parameters
    ----------
    directions, normals, eta : array_like
        The arguments of `co.refract`.
    d_directions, d_normals, d_eta : array_like, optional
        Their tangents, of their shapes; None for no change.

    Returns
    -------
    ndarray (..., 3)
        NaN at the critical angle.

    Raises
    ------
    ValueError
        If a tangent does not broadcast to the shape of the vectors, and for the reasons of `co.refract`.
    """
    ratio, total, d, n, size = _refraction(directions, normals, eta)
    dd, dn = (
        _like("refract_jvp", "d_directions", d_directions, d),
        _across(n, _like("refract_jvp", "d_normals", d_normals, d), normals),
    )
    de = np.zeros_like(ratio) if d_eta is None else ratio * 0 + real_array("refract_jvp", "d_eta", d_eta)[..., None]
    u = d / size
    # The change of u is across it; that of the length of d is added at the end.
    du = (dd - u * dot_columns(u, dd)) / size
    c = dot_columns(u, n)
    dc = dot_columns(du, n) + dot_columns(u, dn)
    with np.errstate(all="ignore"):
        s, ds = _transmitted_cosine(ratio, c, dc, de)
        bent = de * (u - c * n) + ratio * (du - dc * n - c * dn) + ds * n + s * dn
    mirrored = du - 2 * (dc * n + c * dn)
    whole = np.where(total, u - 2 * c * n, ratio * (u - c * n) + s * n)
    return np.where(total, mirrored, bent) * size + whole * dot_columns(u, dd)


@ignore_fp_errors
def refract_vjp(
    directions: npt.ArrayLike, normals: npt.ArrayLike, eta: npt.ArrayLike, cotangents: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the gradient of Σ cotangent · refracted directions by the arguments of `co.refract` (reverse mode).

    Parameters
    ----------
    directions, normals, eta : array_like
        The arguments of `co.refract`.
    cotangents : array_like (..., 3)
        The cotangents of the directions that `co.refract` returns.

    Returns
    -------
    tuple of ndarray
        The cotangents of directions (..., 3), of normals (..., 3) and of eta (...), all of the shape that the arguments
        have together. NaN at the critical angle.

    Raises
    ------
    ValueError
        If the cotangents do not broadcast to that shape, and for the reasons of `co.refract`.
    """
    ratio, total, d, n, size = _refraction(directions, normals, eta)
    w, u = _like("refract_vjp", "cotangents", cotangents, d), d / size
    c = dot_columns(u, n)
    with np.errstate(all="ignore"):
        s, of_c = _transmitted_cosine(ratio, c, np.ones_like(c), np.zeros_like(c))
        _, of_eta = _transmitted_cosine(ratio, c, np.zeros_like(c), np.ones_like(c))
        along = dot_columns(w, n)
        bent_c = along * (of_c - ratio)
        bent_eta = dot_columns(w, u - c * n) + along * of_eta
    bent_u, bent_n = ratio * w + bent_c * n, (s - ratio * c) * w + bent_c * u
    mirrored_u, mirrored_n = w - 2 * along * n, -2 * (along * u + c * w)
    of_u, of_n = np.where(total, mirrored_u, bent_u), np.where(total, mirrored_n, bent_n)
    whole = np.where(total, u - 2 * c * n, ratio * (u - c * n) + s * n)
    # The transpose of du, plus the part along u, by which the length of the result follows that of d.
    of_d = of_u - u * dot_columns(u, of_u) + u * dot_columns(w, whole)
    return of_d, _across(n, of_n * size, normals), np.where(total, 0.0, bent_eta * size)[..., 0][()]


def _transmitted_cosine(
    ratio: FloatArray, c: FloatArray, dc: FloatArray, de: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return s and its tangent, from s² = (1 - eta²) + eta² c²; s has the sign of c."""
    # Differences of squares are factored, so that they do not cancel.
    square = (1 - ratio) * (1 + ratio) + (ratio * c) ** 2
    s = np.copysign(np.sqrt(np.maximum(square, 0.0)), c)
    ds = (ratio * ratio * c * dc - ratio * (1 - c) * (1 + c) * de) / s
    return s, np.where(s == 0, np.nan, ds)


def _refraction(directions: Any, normals: Any, eta: Any) -> tuple[FloatArray, Any, FloatArray, FloatArray, FloatArray]:
    """Return (eta, whether reflection is total, d, unit n, |d|), of one leading shape, with one or three columns."""
    _, total = refract(directions, normals, eta)
    ratio = real_array("refract", "eta", eta)
    d, n, size = _parts(directions, normals)
    shape = np.broadcast_shapes(d.shape[:-1], ratio.shape)
    d, n = np.broadcast_to(d, (*shape, 3)), np.broadcast_to(n, (*shape, 3))
    ratio, size = np.broadcast_to(ratio, shape)[..., None], np.broadcast_to(size, (*shape, 1))
    return ratio, np.asarray(total)[..., None], d, n, size


def _parts(directions: Any, normals: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (d, unit n, |d|), broadcast to one shape."""
    d, n = np.broadcast_arrays(real_array("", "directions", directions), real_array("", "normals", normals))
    return d, n / np.sqrt(dot_columns(n, n)), np.sqrt(dot_columns(d, d))


def _like(owner: str, name: str, values: Any, d: FloatArray) -> FloatArray:
    """Broadcast a tangent to the shape of d; None gives zeros."""
    if values is None:
        return np.zeros_like(d)
    array = real_array(owner, name, values)
    try:
        return np.broadcast_to(array, d.shape)
    except ValueError:
        raise ValueError(f"{owner}: {name} must broadcast to {d.shape}, got {array.shape}") from None


def _across(n: FloatArray, change: FloatArray, normals: Any) -> FloatArray:
    """Map a tangent of normals to one of unit normals, or a cotangent of unit normals to one of normals.

    The map is (I - n nᵀ) / |normal|, which is its own transpose.
    """
    vectors = np.broadcast_to(real_array("", "normals", normals), n.shape)
    return (change - n * dot_columns(n, change)) / np.sqrt(dot_columns(vectors, vectors))
