"""Thin films on a surface, and their reflectance by the transfer matrix method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.errstate import ignore_fp_errors
from .._util.validation import check_number, check_positive, format_value
from .dispersion import Index, check_index, check_wavelengths, index_at
from .fresnel import Fresnel, check_interface, fresnel


@dataclass(frozen=True)
class Layer:
    """A thin film.

    Parameters
    ----------
    index : Index
        Refractive index, as for a material.
    thickness : float
        In μm, > 0.
    """

    index: Index
    thickness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "index", check_index("Layer", self.index))
        object.__setattr__(self, "thickness", check_positive("Layer", "thickness", self.thickness))


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
        w = check_positive("Coating", "wavelength", wavelength)
        if isinstance(indices, str) or not isinstance(indices, Sequence):
            raise ValueError(f"Coating: indices must be a list of refractive indices, got {format_value(indices)}")
        return cls(tuple(Layer(n, w / (4 * float(np.real(index_at(check_index("Coating", n), w))))) for n in indices))

    @ignore_fp_errors
    def at(
        self, wavelength: npt.ArrayLike, cos: npt.ArrayLike = 1.0, n1: npt.ArrayLike = 1.0, n2: npt.ArrayLike = 1.5
    ) -> Fresnel:
        """Return what `co.optics.fresnel` returns, for light that comes from outside of the coat.

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
        w = check_wavelengths("Coating", wavelength)
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
