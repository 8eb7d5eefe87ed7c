"""Glass that bends blue more than red: a path takes one wavelength when it first meets such glass.

The index is Cauchy's, n(λ) = n + B (1 / λ² - 1 / λ_d²), λ in μm. A wavelength is drawn evenly from 0.38 to 0.73 μm, and
its light has the colour of the eye's matching functions (Wyman, Sloan and Shirley, Simple analytic approximations to
the CIE XYZ color matching functions, JCGT 2(2), 2013) in linear sRGB, scaled so that all together are white.
Saturated colours lie outside of sRGB: such light has a negative channel.
"""

from __future__ import annotations

from ..compiler.jit import helper, inline
from ..engine.numbers.exponential import exp

FIRST, LAST = 0.38, 0.73
_SODIUM = 0.5876


@inline
def wavelength(u: float) -> float:
    """Of [0, 1)."""
    return FIRST + u * (LAST - FIRST)


@inline
def index_by(index: float, dispersion: float, wave: float) -> float:
    """The refractive index at a wavelength; 0 is none in particular."""
    if wave == 0.0 or dispersion == 0.0:
        return index
    return max(1e-3, index + dispersion * (1.0 / (wave * wave) - 1.0 / (_SODIUM * _SODIUM)))


WHITE = (0.366748209, 0.290096498, 0.277329495)
"""What each channel is in the mean of all wavelengths, but for this factor."""


@inline
def _bell(wave: float, height: float, middle: float, below: float, above: float) -> float:
    t = 1000.0 * (wave - middle) / (below if wave < middle else above)
    return height * exp(-0.5 * t * t)


@helper
def color_of(wave: float) -> tuple[float, float, float]:
    """The colour of one wavelength, 1 in the mean of all."""
    x = (
        _bell(wave, 1.056, 0.5998, 37.9, 31.0) + _bell(wave, 0.362, 0.442, 16.0, 26.7)
        + _bell(wave, -0.065, 0.5011, 20.4, 26.2)
    )  # fmt: skip
    y = _bell(wave, 0.821, 0.5688, 46.9, 40.5) + _bell(wave, 0.286, 0.5309, 16.3, 31.1)
    z = _bell(wave, 1.217, 0.437, 11.8, 36.0) + _bell(wave, 0.681, 0.459, 26.0, 13.8)
    r = (3.2404542 * x - 1.5371385 * y - 0.4985314 * z) / WHITE[0]
    g = (-0.969266 * x + 1.8760108 * y + 0.041556 * z) / WHITE[1]
    b = (0.0556434 * x - 0.2040259 * y + 1.0572252 * z) / WHITE[2]
    return r, g, b
