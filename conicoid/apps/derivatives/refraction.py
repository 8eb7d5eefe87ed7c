"""The derivatives of `co.reflect` and `co.refract`, by directions, normals and the ratio of indices.

Both are formulas of the unit vectors u = d / |d| and n: u - 2 (u·n) n, and eta (u - c n) + s n with c = u·n and
s = ±sqrt(1 - eta² + eta² c²), the sign that of c. They are as long as d. Where refraction is total it is reflection; at
the critical angle s = 0, where there is no derivative.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.errstate import ignore_fp_errors
from ..._util.validation import real_array
from ..optics.refraction import reflect, refract


@ignore_fp_errors
def reflect_jvp(directions: Any, normals: Any, d_directions: Any = None, d_normals: Any = None) -> FloatArray:
    """How `co.reflect(directions, normals)` changes, (..., 3).

    directions, normals: as for `co.reflect`.
    d_directions, d_normals: (..., 3), how they change; None where they stay. Normals may change in length.
    """
    reflect(directions, normals)
    d, n, _ = _parts(directions, normals)
    dd, dn = (
        _like("reflect_jvp", "d_directions", d_directions, d),
        _across(n, _like("reflect_jvp", "d_normals", d_normals, d), normals),
    )
    return dd - 2 * (_dot(dd, n) + _dot(d, dn)) * n - 2 * _dot(d, n) * dn


@ignore_fp_errors
def reflect_vjp(directions: Any, normals: Any, asked: Any) -> tuple[FloatArray, FloatArray]:
    """The gradient of Σ asked · co.reflect(directions, normals) by directions and normals, both (..., 3).

    directions, normals: as for `co.reflect`.
    asked: (..., 3), what is asked of the mirrored directions.
    """
    reflect(directions, normals)
    d, n, _ = _parts(directions, normals)
    w = _like("reflect_vjp", "asked", asked, d)
    of_n = -2 * (_dot(w, n) * d + _dot(d, n) * w)
    return w - 2 * _dot(w, n) * n, _across(n, of_n, normals)


@ignore_fp_errors
def refract_jvp(
    directions: Any, normals: Any, eta: Any, d_directions: Any = None, d_normals: Any = None, d_eta: Any = None
) -> FloatArray:
    """How the directions of `co.refract(directions, normals, eta)` change, (..., 3); NaN at the critical angle.

    directions, normals, eta: as for `co.refract`.
    d_directions, d_normals, d_eta: how they change, of their shapes; None where they stay.
    """
    ratio, total, d, n, size = _refraction(directions, normals, eta)
    dd, dn = (
        _like("refract_jvp", "d_directions", d_directions, d),
        _across(n, _like("refract_jvp", "d_normals", d_normals, d), normals),
    )
    de = np.zeros_like(ratio) if d_eta is None else ratio * 0 + real_array("refract_jvp", "d_eta", d_eta)[..., None]
    u = d / size
    du = (dd - u * _dot(u, dd)) / size
    c = _dot(u, n)
    dc = _dot(du, n) + _dot(u, dn)
    with np.errstate(all="ignore"):
        s, ds = _transmitted_cosine(ratio, c, dc, de)
        bent = de * (u - c * n) + ratio * (du - dc * n - c * dn) + ds * n + s * dn
    mirrored = du - 2 * (dc * n + c * dn)
    whole = np.where(total, u - 2 * c * n, ratio * (u - c * n) + s * n)
    return np.where(total, mirrored, bent) * size + whole * _dot(u, dd)


@ignore_fp_errors
def refract_vjp(directions: Any, normals: Any, eta: Any, asked: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The gradient of Σ asked · directions beyond, by directions and normals (..., 3) and by eta (...).

    directions, normals, eta: as for `co.refract`; what comes back has the shape that they have together.
    asked: (..., 3), what is asked of the directions that `co.refract` gives.
    """
    ratio, total, d, n, size = _refraction(directions, normals, eta)
    w, u = _like("refract_vjp", "asked", asked, d), d / size
    c = _dot(u, n)
    with np.errstate(all="ignore"):
        s, of_c = _transmitted_cosine(ratio, c, np.ones_like(c), np.zeros_like(c))
        _, of_eta = _transmitted_cosine(ratio, c, np.zeros_like(c), np.ones_like(c))
        along = _dot(w, n)
        bent_c = along * (of_c - ratio)
        bent_eta = _dot(w, u - c * n) + along * of_eta
    bent_u, bent_n = ratio * w + bent_c * n, (s - ratio * c) * w + bent_c * u
    mirrored_u, mirrored_n = w - 2 * along * n, -2 * (along * u + c * w)
    of_u, of_n = np.where(total, mirrored_u, bent_u), np.where(total, mirrored_n, bent_n)
    whole = np.where(total, u - 2 * c * n, ratio * (u - c * n) + s * n)
    of_d = of_u - u * _dot(u, of_u) + u * _dot(w, whole)
    return of_d, _across(n, of_n * size, normals), np.where(total, 0.0, bent_eta * size)[..., 0][()]


def _transmitted_cosine(
    ratio: FloatArray, c: FloatArray, dc: FloatArray, de: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """s and its change: s² = (1 - eta²) + eta² c², s of the sign of c."""
    square = (1 - ratio) * (1 + ratio) + (ratio * c) ** 2
    s = np.copysign(np.sqrt(np.maximum(square, 0.0)), c)
    ds = (ratio * ratio * c * dc - ratio * (1 - c) * (1 + c) * de) / s
    return s, np.where(s == 0, np.nan, ds)


def _refraction(directions: Any, normals: Any, eta: Any) -> tuple[FloatArray, Any, FloatArray, FloatArray, FloatArray]:
    """(eta, is it total, d, unit n, |d|), all of one leading shape and with one or three columns."""
    _, total = refract(directions, normals, eta)
    ratio = real_array("refract", "eta", eta)
    d, n, size = _parts(directions, normals)
    shape = np.broadcast_shapes(d.shape[:-1], ratio.shape)
    d, n = np.broadcast_to(d, (*shape, 3)), np.broadcast_to(n, (*shape, 3))
    ratio, size = np.broadcast_to(ratio, shape)[..., None], np.broadcast_to(size, (*shape, 1))
    return ratio, np.asarray(total)[..., None], d, n, size


def _parts(directions: Any, normals: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(d, unit n, |d|)"""
    d, n = np.broadcast_arrays(real_array("", "directions", directions), real_array("", "normals", normals))
    return d, n / np.sqrt(_dot(n, n)), np.sqrt(_dot(d, d))


def _like(owner: str, name: str, values: Any, d: FloatArray) -> FloatArray:
    """Changes of directions or normals, of the shape that these have together; 0 where none were given."""
    if values is None:
        return np.zeros_like(d)
    array = real_array(owner, name, values)
    try:
        return np.broadcast_to(array, d.shape)
    except ValueError:
        raise ValueError(f"{owner}: {name} must broadcast to {d.shape}, got {array.shape}") from None


def _across(n: FloatArray, change: FloatArray, normals: Any) -> FloatArray:
    """A change of normals as one of unit normals; and what is asked of these as what is asked of the normals."""
    given = np.broadcast_to(real_array("", "normals", normals), n.shape)
    return (change - n * _dot(n, change)) / np.sqrt(_dot(given, given))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products, (..., 1)."""
    return np.asarray((a * b).sum(axis=-1, keepdims=True))
