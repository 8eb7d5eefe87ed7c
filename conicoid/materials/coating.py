"""Thin films on walls (`Coating`), by the transfer matrix method, and Fresnel's formulas for plain walls.

The formulas take arrays, and give reflected and transmitted power and amplitudes by polarisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import ignore_fp_errors
from .._util.records import dataclass
from .._util.validation import check_fields, check_number, check_positive, format_value, real_array
from .dispersion import Index, check_index, check_light, index_at

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


# --- Thin films

_THINNEST, _THICKEST = 1e-5, 20.0
"""Thin films are thicker than a tenth of an atom, and thinner, in μm: other numbers are in m or nm."""


@dataclass(frozen=True)
class Layer:
    """A thin film.

    Parameters
    ----------
    index : Index
        Refractive index, as for a material.
    thickness : float
        In μm, from 1e-5 and below 20.
    """

    index: Index
    thickness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "index", check_index("Layer", self.index))
        check_fields(self, thickness=check_positive)
        if not _THINNEST <= self.thickness < _THICKEST:
            unit, size = ("m", 1e6) if self.thickness < _THINNEST else ("nm", 1e-3)
            found = f"{self.thickness:g}; {self.thickness:g} {unit} are {self.thickness * size:g}"
            expected = f"in μm, from {_THINNEST:g} and below {_THICKEST:g}"
            raise ValueError(f"Layer: thickness must be {expected}, got {found}")


@dataclass(frozen=True)
class Coating:
    """Thin films on the walls of a body.

    Parameters
    ----------
    layers : sequence of Layer or of (index, thickness in μm)
        The outermost first. An index is a number, the name of a glass, a formula, a table of n and k, or a function of
        the wavelength in μm. A film that absorbs has a complex index.
    """

    layers: tuple[Layer, ...]

    def __post_init__(self) -> None:
        layers = self.layers
        if isinstance(layers, str) or not isinstance(layers, Sequence):
            raise ValueError(f"Coating: layers must be pairs (index, thickness in μm), got {format_value(layers)}")
        object.__setattr__(self, "layers", tuple(_layer(i, each) for i, each in enumerate(layers)))

    @classmethod
    def quarter_wave(cls, indices: Sequence[Index], wavelength: float) -> Coating:
        """Make films a quarter of a wavelength thick each, λ / (4 n).

        Parameters
        ----------
        indices : sequence of Index
            Refractive indices of the films, the outermost first.
        wavelength : float
            In μm, in vacuum.

        Returns
        -------
        Coating
        """
        w = float(check_light("Coating", check_positive("Coating", "wavelength", wavelength)))
        if isinstance(indices, str) or not isinstance(indices, Sequence):
            raise ValueError(f"Coating: indices must be a list of refractive indices, got {format_value(indices)}")
        return cls(tuple(Layer(n, w / (4 * float(np.real(index_at(check_index("Coating", n), w))))) for n in indices))

    @ignore_fp_errors
    def at(
        self, wavelength: npt.ArrayLike, cos: npt.ArrayLike = 1.0, n1: npt.ArrayLike = 1.0, n2: npt.ArrayLike = 1.5
    ) -> Fresnel:
        """Return the result of `co.optics.fresnel` for light that comes from outside of the coat.

        It is computed by the characteristic matrix of each film (Macleod, Thin-Film Optical Filters, chapter 2).

        Parameters
        ----------
        wavelength : array_like
            In μm, in vacuum.
        cos : array_like
            Cosine of the angle of incidence.
        n1 : array_like
            Index of the medium outside, real.
        n2 : array_like
            Index of the coated medium, real or complex. All arguments broadcast together.

        Returns
        -------
        Fresnel
            Shares and amplitudes, of the common shape of the arguments.

        Raises
        ------
        ValueError
            For a wavelength outside of the range of a film's index.
        """
        w = check_light("Coating", wavelength)
        # Without films Fresnel's formulas apply, which are exact in total reflection.
        if not self.layers:
            return fresnel(cos, np.broadcast_arrays(n1, w)[0], n2)
        c, first, second = check_interface("Coating", cos, n1, n2, 0.0)
        c, first, second, w = np.broadcast_arrays(c, first, second, w)
        films = [(np.asarray(index_at(layer.index, w)) + 0j, layer.thickness) for layer in self.layers]
        return _stack(films, w, c, first, second)

    def reversed(self) -> Coating:
        """Return the same films in the order for light from inside."""
        return Coating(self.layers[::-1])


def _layer(i: int, layer: Any) -> Layer:
    """Return a `Layer`, or make one from a pair."""
    if isinstance(layer, Layer):
        return layer
    if isinstance(layer, str) or not isinstance(layer, Sequence) or len(layer) != 2:
        raise ValueError(f"Coating: layers[{i}] must be a pair (index, thickness in μm), got {format_value(layer)}")
    index, thickness = layer
    try:
        return Layer(index, check_number("Layer", "thickness", thickness))
    except ValueError as error:
        raise ValueError(f"Coating: layers[{i}]: {error}") from None


def _stack(films: Sequence[tuple[Any, float]], w: Any, c: Any, first: Any, second: Any) -> Fresnel:
    """Multiply the films' matrices, times exp(iδ) each so that nothing overflows, by the field beyond, from inside out.

    With q = n cos θ a film of phase δ = 2π q d / λ has ((cos δ, -i sin δ / η), (-i η sin δ, cos δ)), with η = q for s
    and n²/q for p. The field beyond is (1, q) for s and (q, n²), which is q (1, η), for p.
    """
    # n sin θ is the same in all layers (Snell's law). Here its square.
    sine = first * first * ((1 - c) * (1 + c))
    last = np.sqrt(second * second - sine)
    b_s, c_s, b_p, c_p = np.ones_like(last), last, last, second * second
    scale = np.ones_like(last)
    # From the body outwards: each matrix multiplies the field beyond it.
    for n, thickness in reversed(films):
        square = n * n
        q = np.sqrt(square - sine)
        phase = 2 * np.pi * thickness / w
        turn = np.exp(2j * q * phase)
        cosine, rest = (1 + turn) / 2, (1 - turn) / 2  # of cos δ and -i sin δ, times exp(iδ)
        # Near q = 0 the quotient sin δ / q takes its limit, phase.
        small = abs(q * phase) < 1e-5
        per_q = np.where(small, -1j * phase, rest / np.where(small, 1, q))
        b_s, c_s = cosine * b_s + per_q * c_s, q * rest * b_s + cosine * c_s
        b_p, c_p = cosine * b_p + q * rest / square * c_p, square * per_q * b_p + cosine * c_p
        scale = scale * np.exp(1j * q * phase)
    near = first * c
    below_s, below_p = near * b_s + c_s, first * b_p + c * c_p
    r_s, r_p = (near * b_s - c_s) / below_s, -(first * b_p - c * c_p) / below_p
    t_s, t_p = 2 * near * scale / below_s, 2 * near * second * scale / below_p
    passed = 4 * near * abs(scale) ** 2
    power_s = last.real * passed / abs(below_s) ** 2
    power_p = (second**2 * last.conj()).real * passed / abs(below_p) ** 2
    shares = abs(r_s) ** 2, abs(r_p) ** 2, power_s, power_p
    return Fresnel(*(np.asarray(part)[()] for part in (r_s, r_p, t_s, t_p, *shares)))
