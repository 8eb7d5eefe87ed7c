"""Fresnel's formulas for arrays: reflected and transmitted power and amplitudes at a wall, by polarisation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.errstate import ignore_fp_errors
from .._util.validation import real_array

FloatArray = npt.NDArray[np.float64]
_SLACK = 1e-9  # rounding may move the product of two unit vectors beyond 1 by this much


@dataclass(frozen=True, eq=False)
class Fresnel:
    """Light at a wall: shares of its power, and amplitudes; arrays of one shape, or numbers.

    reflectance, transmittance, absorptance   of unpolarised light, the means of s and p; together they are 1
    reflectance_s, reflectance_p, transmittance_s, transmittance_p   of light polarised across and in the plane of
        incidence
    r_s, r_p, t_s, t_p   complex amplitudes, in the signs of Born and Wolf: at normal incidence r_p = -r_s

    Light that enters an absorbing medium beyond the wall counts as transmitted; absorptance is that of coats.
    """

    r_s: Any
    r_p: Any
    t_s: Any
    t_p: Any
    reflectance_s: Any
    reflectance_p: Any
    transmittance_s: Any
    transmittance_p: Any

    @property
    def reflectance(self) -> Any:
        """Reflected share of unpolarised light."""
        return (self.reflectance_s + self.reflectance_p) / 2

    @property
    def transmittance(self) -> Any:
        """Transmitted share of unpolarised light."""
        return (self.transmittance_s + self.transmittance_p) / 2

    @property
    def absorptance(self) -> Any:
        """Share of unpolarised light that coats absorb."""
        return 1 - self.reflectance - self.transmittance


@ignore_fp_errors
def fresnel(cos: npt.ArrayLike, n1: npt.ArrayLike, n2: npt.ArrayLike, k: npt.ArrayLike = 0.0) -> Fresnel:
    """Apply Fresnel's formulas at the wall from a medium of index n1 to one of index n2 + ik.

    r_s = (n1 cos θ1 - n2 cos θ2) / (n1 cos θ1 + n2 cos θ2), r_p = (n2 cos θ1 - n1 cos θ2) / (n2 cos θ1 + n1 cos θ2), by
    Snell's law with complex cos θ2 (Born and Wolf, Principles of Optics, sections 1.5 and 14.2). Total reflection has
    reflectance 1, exactly. A NaN, such as that of a miss, gives NaN.

    Parameters
    ----------
    cos : array_like
        Cosine of the angle of incidence, as `(hits.normal * directions).sum(-1)` of unit vectors. Its sign does not
        matter.
    n1 : array_like
        Index before the wall, real, > 0.
    n2 : array_like
        Index beyond the wall: real, > 0, or complex, n + ik.
    k : array_like
        Extinction beyond the wall, >= 0; added to that of n2. All arguments broadcast together.

    Returns
    -------
    Fresnel
        Shares and amplitudes, of the common shape of the arguments.

    Raises
    ------
    ValueError
        For a cosine beyond ±1, and for a number that is no index.
    """
    c, first, second = np.broadcast_arrays(*check_interface("fresnel", cos, n1, n2, k))
    sine = first * first * ((1 - c) * (1 + c))
    # 1 - c² as a product of two factors keeps the digits of c near 1.
    square = second * second
    q = np.sqrt(square - sine)  # n2 cos θ2
    near = first * c
    below_s, below_p = near + q, square * c + first * q
    same = (below_s == 0) | (below_p == 0)  # along a wall between equal media: as without the wall
    below_s, below_p = np.where(same, 1, below_s), np.where(same, 1, below_p)
    r_s, r_p = np.where(same, 0, (near - q) / below_s), np.where(same, 0, (square * c - first * q) / below_p)
    t_s, t_p = np.where(same, 1, 2 * near / below_s), np.where(same, 1, 2 * near * second / below_p)
    total = (q.real == 0) & (second.imag == 0) & ~same
    power_s = np.where(same, 1, 4 * near * q.real / abs(below_s) ** 2)
    power_p = np.where(same, 1, 4 * near * (square * q.conj()).real / abs(below_p) ** 2)
    shares = (np.where(total, 1.0, abs(r_s) ** 2), np.where(total, 1.0, abs(r_p) ** 2))
    passed = (np.where(total, 0.0, power_s), np.where(total, 0.0, power_p))
    return Fresnel(*(np.asarray(part)[()] for part in (r_s, r_p, t_s, t_p, *shares, *passed)))


def check_interface(owner: str, cos: Any, n1: Any, n2: Any, k: Any) -> tuple[FloatArray, FloatArray, Any]:
    """Return (|cos|, n1, n2 + ik) as arrays. Raise ValueError with the owner and the field."""
    c = abs(real_array(owner, "cos", cos))
    if (c > 1 + _SLACK).any():
        raise ValueError(f"{owner}: cos must be in [-1, 1], of unit vectors, got {np.max(c[c > 1 + _SLACK])}")
    first, extinction = real_array(owner, "n1", n1), real_array(owner, "k", k)
    second = np.asarray(n2) if np.iscomplexobj(n2) else real_array(owner, "n2", n2)
    second = second + 1j * extinction
    for field, bad, least in (
        ("k", extinction[~(extinction >= 0)], ">= 0"),
        ("n1", first[~(first > 0)], "> 0"),
        ("n2", second.real[~(second.real > 0)], "> 0"),
        ("n2", second.imag[~(second.imag >= 0)], "n + ik with k >= 0"),
    ):
        if bad.size:
            raise ValueError(f"{owner}: {field} must be {least}, got {bad.flat[0]}")
    try:
        np.broadcast_shapes(c.shape, first.shape, second.shape)
    except ValueError:
        shapes = f"{c.shape}, {first.shape} and {second.shape}"
        raise ValueError(f"{owner}: cos, n1 and n2 must broadcast together, got {shapes}") from None
    return np.minimum(c, 1.0), first, second
