"""Refractive indices that depend on the wavelength, and a catalogue of them. Wavelengths are in μm, in vacuum."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from .._util.records import dataclass
from .._util.text import near_name
from .._util.validation import check_number, format_value, is_complex, real_array

LINE_D, LINE_F, LINE_C = 0.5875618, 0.4861327, 0.6562725
"""Fraunhofer's lines of helium and hydrogen, which define n_d and the Abbe number."""


class Dispersion:
    """A refractive index n(λ), or n + ik, as a function of wavelengths: an array gives an array, a number a number.

    name, source: its name, and the publication of its numbers.
    range: the wavelengths (lowest, highest) for which it holds; a call outside of them is a ValueError. None is any.
    """

    name: str | None
    source: str | None
    range: tuple[float, float] | None

    def __call__(self, wavelength: Any) -> Any:
        """Return the index at wavelengths in μm.

        Parameters
        ----------
        wavelength : array_like
            In μm, in vacuum.

        Returns
        -------
        float64 or complex128
            n, or n + ik of an absorbing medium, of the shape of the wavelengths.

        Raises
        ------
        ValueError
            Outside of `range`, with the wavelength; where the formula has no index, such as the root of a number < 0.
        """
        w = (check_light if self.range is None else check_wavelengths)(self._label, wavelength)
        if self.range is not None and w.size:
            low, high = self.range
            # Rounding must not exclude the ends of the range.
            bad = w[(w < low * (1 - 1e-12)) | (w > high * (1 + 1e-12))]
            if bad.size:
                raise ValueError(
                    f"{self._label}: wavelength must be in [{low:g}, {high:g}] μm, where its index was measured, "
                    f"got {bad.flat[0]:g}"
                )
        with np.errstate(all="ignore"):
            return _check_values(self._label, "index must be", np.asarray(self._index_at(w)))[()]

    def _index_at(self, w: Any) -> Any:
        """Return the index at checked wavelengths."""
        raise NotImplementedError

    @property
    def _label(self) -> str:
        """Name for messages."""
        return type(self).__name__ + ("" if self.name is None else f" {self.name!r}")

    @property
    def n_d(self) -> float:
        """The index at 0.5875618 μm, the yellow line of helium, as in catalogues."""
        return float(np.real(self(LINE_D)))

    @property
    def abbe_number(self) -> float:
        """(n_d - 1) / (n_F - n_C): the greater, the lower the dispersion."""
        return (self.n_d - 1) / float(np.real(self(LINE_F) - self(LINE_C)))

    def _keep(self, **fields: Any) -> None:
        """Set checked fields; check range, name and source."""
        vars(self).update(fields)
        owner = type(self).__name__
        if "range" in vars(self) and self.range is not None:
            low, high = check_row(owner, "range", self.range, 2)
            if not 0 < low < high:
                raise ValueError(f"{owner}: range must be two rising wavelengths > 0, got {self.range}")
            check_light(owner, low)
            object.__setattr__(self, "range", (low, high))
        for name in ("name", "source"):
            value = getattr(self, name)
            if value is not None and (not isinstance(value, str) or not value):
                raise ValueError(f"{owner}: {name} must be a non-empty text or None, got {format_value(value)}")


# Formulas and tables.


@dataclass(frozen=True)
class Sellmeier(Dispersion):
    """n² = 1 + a + Σ b λ² / (λ² - c), λ in μm: the formula of most makers (Sellmeier 1871).

    Parameters
    ----------
    b : sequence of float
        Strengths.
    c : sequence of float
        Squared resonances in μm², as many.
    a : float
        Added to n², for two-term formulas.
    range, name, source
        As in `Dispersion`.
    """

    b: tuple[float, ...]
    c: tuple[float, ...]
    a: float = 0.0
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        b, c = check_row("Sellmeier", "b", self.b), check_row("Sellmeier", "c", self.c)
        if len(b) != len(c):
            raise ValueError(f"Sellmeier: b and c must be as many, got {len(b)} and {len(c)}")
        self._keep(b=b, c=c, a=check_number("Sellmeier", "a", self.a))

    def _index_at(self, w: Any) -> Any:
        square = w * w
        return np.sqrt(1 + self.a + sum(b * square / (square - c) for b, c in zip(self.b, self.c, strict=True)))


@dataclass(frozen=True)
class Cauchy(Dispersion):
    """n = A + B / λ² + C / λ⁴ + ..., λ in μm (Cauchy 1836).

    Parameters
    ----------
    coefficients : sequence of float
        A, B, C and so on.
    range, name, source
        As in `Dispersion`.
    """

    coefficients: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        self._keep(coefficients=check_row("Cauchy", "coefficients", self.coefficients))

    def _index_at(self, w: Any) -> Any:
        return sum(c / w ** (2 * k) for k, c in enumerate(self.coefficients))


@dataclass(frozen=True)
class Schott(Dispersion):
    """n² = A0 + A1 λ² + A2 λ⁻² + A3 λ⁻⁴ + A4 λ⁻⁶ + A5 λ⁻⁸, λ in μm: the series of Schott's older catalogues.

    Parameters
    ----------
    coefficients : sequence of 6 floats
        A0 to A5.
    range, name, source
        As in `Dispersion`.
    """

    coefficients: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        self._keep(coefficients=check_row("Schott", "coefficients", self.coefficients, 6))

    def _index_at(self, w: Any) -> Any:
        first, second, *rest = self.coefficients
        return np.sqrt(first + second * w * w + sum(c / w ** (2 * k) for k, c in enumerate(rest, 1)))


@dataclass(frozen=True)
class Edlen(Dispersion):
    """n = 1 + Σ k / (b - λ⁻²), λ in μm: gases (Edlén 1953).

    Parameters
    ----------
    k, b : sequence of float
        Of each term, in μm⁻².
    range, name, source
        As in `Dispersion`.
    """

    k: tuple[float, ...]
    b: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        k, b = check_row("Edlen", "k", self.k), check_row("Edlen", "b", self.b)
        if len(k) != len(b):
            raise ValueError(f"Edlen: k and b must be as many, got {len(k)} and {len(b)}")
        self._keep(k=k, b=b)

    def _index_at(self, w: Any) -> Any:
        return 1 + sum(k / (b - 1 / (w * w)) for k, b in zip(self.k, self.b, strict=True))


@dataclass(frozen=True)
class Tabulated(Dispersion):
    """n, or n + ik, measured at some wavelengths and linear between them; one wavelength alone is constant for all.

    Parameters
    ----------
    wavelengths : sequence of float
        In μm, rising.
    n : sequence of float
        As many, > 0.
    k : sequence of float, optional
        As many, >= 0; without it nothing is absorbed.
    name, source
        As in `Dispersion`; the range is that of the table.
    """

    wavelengths: tuple[float, ...]
    n: tuple[float, ...]
    k: tuple[float, ...] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        w, n = check_row("Tabulated", "wavelengths", self.wavelengths), check_row("Tabulated", "n", self.n)
        k = None if self.k is None else check_row("Tabulated", "k", self.k)
        if any(not a < b for a, b in zip((0.0, *w), w, strict=False)):
            raise ValueError("Tabulated: wavelengths must be > 0 and rising")
        check_light("Tabulated", w[0])
        for name, values, least in (("n", n, "> 0"), ("k", k, ">= 0")):
            if values is None:
                continue
            if len(values) != len(w):
                raise ValueError(f"Tabulated: {name} must be as many as wavelengths, {len(w)}, got {len(values)}")
            bad = [v for v in values if not (v > 0 if name == "n" else v >= 0)]
            if bad:
                raise ValueError(f"Tabulated: {name} must be {least}, got {bad[0]}")
        self._keep(wavelengths=w, n=n, k=k)

    @property
    def range(self) -> tuple[float, float] | None:  # type: ignore[override]
        """The first wavelength and the last; None for a single one."""
        return (self.wavelengths[0], self.wavelengths[-1]) if len(self.wavelengths) > 1 else None

    def _index_at(self, w: Any) -> Any:
        n = np.interp(w, self.wavelengths, self.n)
        return n if self.k is None else n + 1j * np.interp(w, self.wavelengths, self.k)


@dataclass(frozen=True)
class CatalogueFormula(Dispersion):
    """A refractive index by one of Zemax's formulas for which conicoid has no class of its own.

    Parameters
    ----------
    number : int
        Of the formula in the format: 3 Herzberger, 4 Sellmeier 2, 5 Conrady, 7 and 8 the Handbook of Optics, 10, 12 and
        13 series of powers.
    coefficients : sequence of float
        In the order of the file; missing ones are 0.
    range, name, source
        As in `Dispersion`.
    """

    number: int
    coefficients: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None

    def __post_init__(self) -> None:
        if self.number not in CATALOGUE_FORMULAS:
            raise ValueError(f"CatalogueFormula: number must be one of {', '.join(map(str, CATALOGUE_FORMULAS))}")
        self._keep(coefficients=check_row("CatalogueFormula", "coefficients", self.coefficients))

    def _index_at(self, w: Any) -> Any:
        return CATALOGUE_FORMULAS[self.number](w, (*self.coefficients, *[0.0] * 10))


def _herzberger(w: Any, c: Sequence[float]) -> Any:
    far = 1 / (w * w - 0.028)
    return c[0] + c[1] * far + c[2] * far**2 + c[3] * w**2 + c[4] * w**4 + c[5] * w**6


def _powers(*exponents: float) -> Callable[[Any, Sequence[float]], Any]:
    """Return the formula n² = c0 + Σ c λ^exponent."""
    return lambda w, c: np.sqrt(c[0] + sum(factor * w**power for factor, power in zip(c[1:], exponents, strict=False)))


CATALOGUE_FORMULAS: Mapping[int, Callable[[Any, Sequence[float]], Any]] = {
    3: _herzberger,
    4: lambda w, c: np.sqrt(1 + c[0] + c[1] * w * w / (w * w - c[2] * c[2]) + c[3] / (w * w - c[4] * c[4])),
    5: lambda w, c: c[0] + c[1] / w + c[2] / w**3.5,
    7: lambda w, c: np.sqrt(c[0] + c[1] / (w * w - c[2]) - c[3] * w * w),
    8: lambda w, c: np.sqrt(c[0] + c[1] * w * w / (w * w - c[2]) - c[3] * w * w),
    10: _powers(2.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0),
    12: _powers(2.0, -2.0, -4.0, -6.0, -8.0, 4.0, 6.0),
    13: _powers(2.0, 4.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0),
}
"""Number in the format -> n of (λ in μm, coefficients); OpticStudio's manual, "Using glass catalogs"."""


# Indices of any kind: checks, values at wavelengths, and the one number of pictures.

Index: TypeAlias = (
    float | str | Sellmeier | Cauchy | Schott | Edlen | Tabulated | CatalogueFormula | Callable[[Any], Any]
)
"""The refractive index of a material: a number, the name of a glass, a formula, a table, or a function."""
FORMULAS = (Sellmeier, Cauchy, Schott, Edlen, Tabulated, CatalogueFormula)
"""The classes of formulas and tables."""


def check_row(owner: str, field: str, values: Any, count: int | None = None) -> tuple[float, ...]:
    """Return numbers as a tuple, `count` of them or at least one. Raise ValueError with the owner and the field."""
    expected = f"a list of {count} numbers" if count else "a list of one number or more"
    if isinstance(values, str) or not hasattr(values, "__len__") or not len(values):
        raise ValueError(f"{owner}: {field} must be {expected}, got {format_value(values)}")
    if count and len(values) != count:
        raise ValueError(f"{owner}: {field} must be {expected}, got {len(values)}")
    return tuple(check_number(owner, f"{field}[{i}]", value) for i, value in enumerate(values))


def check_wavelengths(owner: str, wavelength: Any) -> Any:
    """Return wavelengths as float64, all finite and > 0. Raise ValueError with the owner."""
    w = real_array(owner, "wavelength", wavelength)
    bad = w[~(np.isfinite(w) & (w > 0))]
    if bad.size:
        raise ValueError(f"{owner}: wavelength must be in μm, finite and > 0, got {bad.flat[0]}")
    return w


def check_light(owner: str, wavelength: Any) -> Any:
    """Return wavelengths of light or X-rays, from 1e-5 to 100 μm. Raise ValueError for others: they are in nm or m."""
    w = check_wavelengths(owner, wavelength)
    strange = w[(w < 1e-5) | (w >= 100)]
    if strange.size:
        wanted = "wavelength must be in μm, 0.5876 for the line d"
        raise ValueError(f"{owner}: {wanted}, got {strange.flat[0]:g}")
    return w


def check_index(owner: str, value: Any) -> Index:
    """Return the refractive index in the form that a material stores. Raise ValueError if it is none.

    A complex number becomes a table of one wavelength.
    """
    if isinstance(value, FORMULAS):
        return value
    if isinstance(value, str):
        if value not in glasses:
            found = f"{format_value(value)}{_near_glass(value)}"
            raise ValueError(
                f"{owner}: refractive_index must be a number, a formula or the name of a glass, got {found}"
            )
        return value
    # A constant n + ik: a table of one wavelength is constant.
    if is_complex(value) and np.ndim(value) == 0 and complex(value).real > 0 and complex(value).imag > 0:
        whole = complex(value)
        return Tabulated((LINE_D,), (whole.real,), (whole.imag,))
    if callable(value) and not isinstance(value, type):
        try:
            # One trial call: an error in the user's function should not wait for the first ray.
            index_at(value, LINE_D)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            expected = "a function of it must take wavelengths in μm and return n > 0"
            raise ValueError(f"{owner}: refractive_index: {expected}; {str(error)[:160]}") from None
        return value
    index = check_number(owner, "refractive_index", value)
    if not index > 0:
        raise ValueError(f"{owner}: refractive_index must be > 0, got {index}")
    return index


def index_at(value: Any, wavelength: Any) -> Any:
    """Return a refractive index, of any kind that a material takes, at wavelengths in μm: float64 or complex128.

    The result has the shape of the wavelengths. Raise ValueError outside of the range of a formula, and if a function
    returns no index.
    """
    if isinstance(value, str):
        value = glasses[value]
    if isinstance(value, Dispersion):
        return value(wavelength)
    w = check_light("refractive_index", wavelength)
    if not callable(value):
        return np.full(w.shape, float(value))[()]
    index = np.asarray(value(w))
    if index.dtype.kind not in "iufc" or index.shape not in (w.shape, ()):
        raise ValueError(
            f"refractive_index: the function must return numbers of shape {w.shape}, as its wavelengths have, "
            f"got {format_value(index)}"
        )
    # A function may return one number; + 0.0 makes a float64 copy of integers.
    return _check_values("refractive_index", "the function must return", np.broadcast_to(index, w.shape) + 0.0)[()]


def _check_values(owner: str, expected: str, index: Any) -> Any:
    """Return indices. Raise ValueError for the first that is none."""
    bad = index[~(np.isfinite(index) & (index.real > 0) & (index.imag >= 0))]
    if bad.size:
        raise ValueError(f"{owner}: {expected} n > 0, or n + ik with k >= 0, got {bad.flat[0]}")
    return index


def _index_in_range(value: Any, wavelength: float) -> float:
    """Return the real index at a wavelength, or at the nearest end of its range."""
    if isinstance(value, str):
        value = glasses[value]
    if isinstance(value, Dispersion) and value.range is not None:
        # Pictures need a number even of a medium that was measured in the infrared only.
        wavelength = min(max(wavelength, value.range[0]), value.range[1])
    return float(np.real(index_at(value, wavelength)))


def render_index(value: Any) -> float:
    """Return the one number for pictures in three channels: n_d, or the index at the end of the range nearest to it."""
    return value if isinstance(value, float) else _index_in_range(value, LINE_D)


def render_cauchy_b(value: Any) -> float:
    """Return Cauchy's B in μm² through n_F and n_C, for pictures with dispersion: (n_F - n_C) / (1/λ_F² - 1/λ_C²)."""
    if isinstance(value, float):
        return 0.0
    rise = _index_in_range(value, LINE_F) - _index_in_range(value, LINE_C)
    # Pictures have no anomalous dispersion.
    return max(0.0, rise / (LINE_F**-2 - LINE_C**-2))


# The catalogue of published refractive indices: glasses of four makers, crystals, liquids, plastics, metals.

DispersionFactory = Callable[[], Dispersion]

_CRYSTALS: tuple[tuple[str, str, tuple[float, float], float, tuple[float, ...], str], ...] = (
    ("fused silica", "SiO2", (0.21, 6.7), 0.0, (0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161),
     "I. H. Malitson, J. Opt. Soc. Am. 55 (1965), 1205; to 6.7 μm by C. Z. Tan, J. Non-Cryst. Solids 223 (1998), 158"),
    ("calcium fluoride", "CaF2", (0.23, 9.7), 0.0,
     (0.5675888, 0.050263605, 0.4710914, 0.1003909, 3.8484723, 34.649040), "I. H. Malitson, Appl. Opt. 2 (1963), 1103"),
    ("magnesium fluoride", "MgF2", (0.2, 7.0), 0.0,
     (0.48755108, 0.04338408, 0.39875031, 0.09461442, 2.3120353, 23.793604),
     "M. J. Dodge, Appl. Opt. 23 (1984), 1980; the ordinary ray"),
    ("barium fluoride", "BaF2", (0.2652, 10.346), 0.0, (0.643356, 0.057789, 0.506762, 0.10968, 3.8261, 46.3864),
     "I. H. Malitson, J. Opt. Soc. Am. 54 (1964), 628"),
    ("lithium fluoride", "LiF", (0.1, 11.0), 0.0, (0.92549, 0.07376, 6.96747, 32.79),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("sodium chloride", "NaCl", (0.2, 30.0), 0.00055,
     (0.198, 0.05, 0.48398, 0.1, 0.38696, 0.128, 0.25998, 0.158, 0.08796, 40.5, 3.17064, 60.98, 0.30038, 120.34),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("potassium bromide", "KBr", (0.2, 42.0), 0.39408,
     (0.79221, 0.146, 0.01981, 0.173, 0.15587, 0.187, 0.17673, 60.61, 2.06217, 87.72),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("sapphire", "Al2O3", (0.2, 5.0), 0.0, (1.4313493, 0.0726631, 0.65054713, 0.1193242, 5.3414021, 18.028251),
     "I. H. Malitson and M. J. Dodge 1972, in Handbook of Laser Science and Technology IV 2 (1986); the ordinary ray"),
    ("diamond", "C", (0.226, 0.76), 0.0, (0.3306, 0.175, 4.3356, 0.106), "F. Peter, Z. Phys. 15 (1923), 358"),
    ("silicon", "Si", (1.357, 11.04), 0.0, (10.6684293, 0.301516485, 0.0030434748, 1.13475115, 1.54133408, 1104.0),
     "C. D. Salzberg and J. J. Villa, J. Opt. Soc. Am. 47 (1957), 244; B. Tatian, Appl. Opt. 23 (1984), 4477"),
    ("zinc selenide", "ZnSe", (0.54, 18.2), 0.0,
     (4.45813734, 0.200859853, 0.467216334, 0.391371166, 2.89566290, 47.1362108),
     "J. Connolly and others, Proc. SPIE 181 (1979), 141; B. Tatian, Appl. Opt. 23 (1984), 4477"),
    ("gallium arsenide", "GaAs", (0.97, 17.0), 4.372514,
     (5.466742, 0.4431307, 0.0242996, 0.8746453, 1.957522, 36.9166),
     "T. Skauli and others, J. Appl. Phys. 94 (2003), 6447"),
)  # fmt: skip
"""Name, formula, range, a, (b, resonance in μm) of each term, source."""

_POLYMERS = "N. Sultanova and others, Acta Physica Polonica A 116 (2009), 585; 20 °C"
_OTHER_MEDIA: tuple[tuple[str, str | None, DispersionFactory], ...] = (
    ("water", "H2O", lambda: Sellmeier(
        (0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688),
        (0.005101829712, 0.01821153936, 0.02620722293, 10.69792721), 0.0, (0.182, 1.129), "water",
        "M. Daimon and A. Masumura, Appl. Opt. 46 (2007), 3811; distilled, 20 °C")),
    ("air", None, lambda: Edlen(
        (0.05792105, 0.00167917), (238.0185, 57.362), (0.23, 1.69), "air",
        "P. E. Ciddor, Appl. Opt. 35 (1996), 1566; dry, 15 °C, 101.325 kPa, 450 ppm CO2")),
    ("germanium", "Ge", lambda: Sellmeier(
        (0.4886331, 14.5142535, 0.0091224), (1.393959, 0.1626427, 752.19), 0.0, (2.0, 14.0), "germanium",
        "J. H. Burnett and others, Proc. SPIE 9974 (2016), 99740X; 22 °C")),
    ("PMMA", None, lambda: Sellmeier((1.1819,), (0.011313,), 0.0, (0.4368, 1.052), "PMMA", _POLYMERS)),
    ("polycarbonate", None,
     lambda: Sellmeier((1.4182,), (0.021304,), 0.0, (0.4368, 1.052), "polycarbonate", _POLYMERS)),
    ("polystyrene", None, lambda: Sellmeier((1.4435,), (0.020216,), 0.0, (0.4368, 1.052), "polystyrene", _POLYMERS)),
    ("gold", "Au", lambda: _metal_table("gold")),
    ("silver", "Ag", lambda: _metal_table("silver")),
    ("copper", "Cu", lambda: _metal_table("copper")),
    ("aluminium", "Al", lambda: _metal_table("aluminium")),
)  # fmt: skip
"""Name, formula, constructor."""


def _metal_table(name: str) -> Dispersion:
    """Return a metal's table of n and k."""
    from . import glass_tables

    rows = [
        tuple(map(float, item.split())) for item in getattr(glass_tables, name.upper()).replace("\n", ";").split(";")
    ]
    w, n, k = zip(*(row for row in rows if row), strict=True)
    source = (
        "A. D. Rakić, Appl. Opt. 34 (1995), 4755"
        if name == "aluminium"
        else ("P. B. Johnson and R. W. Christy, Phys. Rev. B 6 (1972), 4370")
    )
    return Tabulated(w, n, k, name, source)


def _crystal_formula(
    name: str, span: tuple[float, float], a: float, terms: tuple[float, ...], source: str
) -> DispersionFactory:
    """Return the constructor of a crystal's Sellmeier formula."""
    return lambda: Sellmeier(terms[::2], tuple(w * w for w in terms[1::2]), a, span, name, source)


def _glass_formula(line: str, source: str) -> tuple[str, DispersionFactory]:
    """Parse a line of a maker's table: name and constructor."""
    name, formula, low, high, *rest = line.split()
    span, values = (float(low), float(high)), tuple(map(float, rest))
    if formula == "S":
        return name, lambda: Sellmeier(values[::2], values[1::2], 0.0, span, name, source)
    return name, lambda: Schott(values, span, name, source)


class Glasses(Mapping[str, Dispersion]):
    """Published refractive indices by name: `glasses["N-BK7"]`; crystals and metals by their formulas as well.

    Each has `name`, `source`, `range` and, within the visible, `n_d` and `abbe_number`. An unknown name raises
    KeyError, with the closest name.
    """

    # The tables are parsed on first use, and a formula is built when its name is first used.

    @cached_property
    def _factories(self) -> dict[str, DispersionFactory]:
        """Name -> constructor."""
        from . import glass_tables

        tables = (
            (glass_tables.SCHOTT, "Schott, catalogue of 2017-01-20"),
            (glass_tables.OHARA, "Ohara, catalogue of 2017-11-30"),
            (glass_tables.CDGM, "CDGM, catalogue of 2022-06"),
            (glass_tables.HOYA, "Hoya, catalogue of 2017-04-01"),
        )
        found = dict(_glass_formula(line, source) for text, source in tables for line in text.strip().split("\n"))
        for name, formula, span, a, terms, source in _CRYSTALS:
            found[name] = found[formula] = _crystal_formula(name, span, a, terms, source)
        for name, other, make in _OTHER_MEDIA:
            found |= {name: make} if other is None else {name: make, other: make}
        return found

    @cached_property
    def _by_name(self) -> dict[str, Dispersion]:
        """Name -> index, of the ones used so far."""
        return {}

    def __getitem__(self, name: str) -> Dispersion:
        if name not in self._by_name:
            if not isinstance(name, str) or name not in self._factories:
                raise KeyError(f"unknown name {format_value(name)}{_near_glass(name)}")
            self._by_name[name] = self._factories[name]()
        return self._by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._factories)

    def __len__(self) -> int:
        return len(self._factories)

    def __contains__(self, name: object) -> bool:
        return name in self._factories

    def __repr__(self) -> str:
        return f"Glasses({len(self)} by name)"

    def __reduce__(self) -> Any:
        return "glasses"


glasses = Glasses()
"""The one catalogue."""


def glass(name: str) -> Dispersion:
    """Return the published index of a glass, crystal, liquid, plastic or metal: `glasses[name]`.

    Parameters
    ----------
    name : str
        As makers write it, such as "N-BK7" or "S-FPL53", or "water"; list(co.optics.glasses) has all names.

    Returns
    -------
    Dispersion

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    if isinstance(name, str) and name in glasses:
        return glasses[name]
    found = f"{format_value(name)}{_near_glass(name)}"
    raise ValueError(f"glass: name must be one of co.optics.glasses, got {found}")


def _near_glass(name: object) -> str:
    """Return the glass most like an unknown name in brackets; the newer version of one begins with N-."""
    return near_name(f"N-{name}" if f"N-{name}" in glasses else name, glasses)
