"""Refractive indices that depend on the wavelength. Wavelengths are in μm, in vacuum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np

from .arrays import real_array
from .fixed import fixed
from .validate import is_complex, number, shown

LINE_D, LINE_F, LINE_C = 0.5875618, 0.4861327, 0.6562725
"""Fraunhofer's lines of helium and hydrogen, by which makers give n_d and the Abbe number."""


class Dispersion:
    """A refractive index n(λ), or n + ik, that is called with wavelengths: an array comes back, or a number for one.

    name, source: what it is called, and where its numbers were published.
    range: the wavelengths (lowest, highest) for which it holds; outside of them a call is a ValueError. None is any.
    """

    name: str | None
    source: str | None
    range: tuple[float, float] | None
    _title: ClassVar[str] = "Dispersion"

    def __call__(self, wavelength: Any) -> Any:
        """n at wavelengths in μm: float64 of their shape, complex128 (n + ik) of what absorbs.

        Raises ValueError outside of `range`, with the wavelength.
        """
        w = checked_wavelengths(self._called, wavelength)
        if self.range is not None and w.size:
            low, high = self.range
            bad = w[(w < low * (1 - 1e-12)) | (w > high * (1 + 1e-12))]
            if bad.size:
                raise ValueError(
                    f"{self._called}: wavelength must be in [{low:g}, {high:g}] μm, where its index was measured, "
                    f"got {bad.flat[0]:g}{_in_nanometres(bad.flat[0])}"
                )
        return np.asarray(self._of(w))[()]

    def _of(self, w: Any) -> Any:
        """The index at wavelengths."""
        raise NotImplementedError

    @property
    def _called(self) -> str:
        return self._title if self.name is None else f"{self._title} {self.name!r}"

    @property
    def n_d(self) -> float:
        """The index at 0.5875618 μm, the yellow line of helium: that of catalogues."""
        return float(np.real(self(LINE_D)))

    @property
    def abbe_number(self) -> float:
        """(n_d - 1) / (n_F - n_C): the greater, the less it disperses."""
        return (self.n_d - 1) / float(np.real(self(LINE_F) - self(LINE_C)))

    def _keep(self, **fields: Any) -> None:
        """Set checked fields."""
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        if "range" in vars(self) and self.range is not None:
            low, high = row(self._title, "range", self.range, 2)
            if not 0 < low < high:
                raise ValueError(f"{self._title}: range must be two rising wavelengths > 0, got {self.range}")
            object.__setattr__(self, "range", (low, high))
        for name in ("name", "source"):
            value = getattr(self, name)
            if value is not None and (not isinstance(value, str) or not value):
                raise ValueError(f"{self._title}: {name} must be a non-empty text or None, got {shown(value)}")


@fixed
@dataclass(frozen=True)
class Sellmeier(Dispersion):
    """n² = 1 + a + Σ b λ² / (λ² - c), λ in μm: the formula of most makers (Sellmeier 1871).

    b: strengths; c: squared resonances in μm², as many.
    a: what is added to n², for two-term formulas.
    range, name, source: as in `Dispersion`.
    """

    b: tuple[float, ...]
    c: tuple[float, ...]
    a: float = 0.0
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None
    _title: ClassVar[str] = "Sellmeier"

    def __post_init__(self) -> None:
        b, c = row("Sellmeier", "b", self.b), row("Sellmeier", "c", self.c)
        if len(b) != len(c):
            raise ValueError(f"Sellmeier: b and c must be as many, got {len(b)} and {len(c)}")
        self._keep(b=b, c=c, a=number("Sellmeier", "a", self.a))

    def _of(self, w: Any) -> Any:
        square = w * w
        return np.sqrt(1 + self.a + sum(b * square / (square - c) for b, c in zip(self.b, self.c, strict=True)))


@fixed
@dataclass(frozen=True)
class Cauchy(Dispersion):
    """n = A + B / λ² + C / λ⁴ + ..., λ in μm (Cauchy 1836).

    coefficients: A, B, C and so on.
    range, name, source: as in `Dispersion`.
    """

    coefficients: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None
    _title: ClassVar[str] = "Cauchy"

    def __post_init__(self) -> None:
        self._keep(coefficients=row("Cauchy", "coefficients", self.coefficients))

    def _of(self, w: Any) -> Any:
        return sum(c / w ** (2 * k) for k, c in enumerate(self.coefficients))


@fixed
@dataclass(frozen=True)
class Schott(Dispersion):
    """n² = A0 + A1 λ² + A2 λ⁻² + A3 λ⁻⁴ + A4 λ⁻⁶ + A5 λ⁻⁸, λ in μm: the series of Schott's older catalogues.

    coefficients: A0 to A5.
    range, name, source: as in `Dispersion`.
    """

    coefficients: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None
    _title: ClassVar[str] = "Schott"

    def __post_init__(self) -> None:
        self._keep(coefficients=row("Schott", "coefficients", self.coefficients, 6))

    def _of(self, w: Any) -> Any:
        first, second, *rest = self.coefficients
        return np.sqrt(first + second * w * w + sum(c / w ** (2 * k) for k, c in enumerate(rest, 1)))


@fixed
@dataclass(frozen=True)
class Edlen(Dispersion):
    """n = 1 + Σ k / (b - λ⁻²), λ in μm: gases (Edlén 1953).

    k, b: of each term, in μm⁻².
    range, name, source: as in `Dispersion`.
    """

    k: tuple[float, ...]
    b: tuple[float, ...]
    range: tuple[float, float] | None = None
    name: str | None = None
    source: str | None = None
    _title: ClassVar[str] = "Edlen"

    def __post_init__(self) -> None:
        k, b = row("Edlen", "k", self.k), row("Edlen", "b", self.b)
        if len(k) != len(b):
            raise ValueError(f"Edlen: k and b must be as many, got {len(k)} and {len(b)}")
        self._keep(k=k, b=b)

    def _of(self, w: Any) -> Any:
        return 1 + sum(k / (b - 1 / (w * w)) for k, b in zip(self.k, self.b, strict=True))


@fixed
@dataclass(frozen=True)
class Tabulated(Dispersion):
    """n, or n + ik, measured at some wavelengths and linear between them; of one wavelength it is the same for all.

    wavelengths: in μm, rising; n, k: as many, k >= 0; without k nothing is absorbed.
    name, source: as in `Dispersion`; the range is that of the table.
    """

    wavelengths: tuple[float, ...]
    n: tuple[float, ...]
    k: tuple[float, ...] | None = None
    name: str | None = None
    source: str | None = None
    _title: ClassVar[str] = "Tabulated"

    def __post_init__(self) -> None:
        w, n = row("Tabulated", "wavelengths", self.wavelengths), row("Tabulated", "n", self.n)
        k = None if self.k is None else row("Tabulated", "k", self.k)
        if any(not a < b for a, b in zip((0.0, *w), w, strict=False)):
            raise ValueError("Tabulated: wavelengths must be > 0 and rising")
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
        """The first wavelength and the last; None of a single one."""
        return (self.wavelengths[0], self.wavelengths[-1]) if len(self.wavelengths) > 1 else None

    def _of(self, w: Any) -> Any:
        n = np.interp(w, self.wavelengths, self.n)
        return n if self.k is None else n + 1j * np.interp(w, self.wavelengths, self.k)


Index: TypeAlias = float | str | Sellmeier | Cauchy | Schott | Edlen | Tabulated | Callable[[Any], Any]
"""What a material takes as its refractive index: a number, the name of a glass, a formula, a table, or a function."""
FORMULAS = (Sellmeier, Cauchy, Schott, Edlen, Tabulated)


def row(owner: str, field: str, values: Any, count: int | None = None) -> tuple[float, ...]:
    """Numbers as a tuple, of a given count or one at least; a named ValueError otherwise."""
    expected = f"a list of {count} numbers" if count else "a list of one number or more"
    if isinstance(values, str) or not hasattr(values, "__len__") or not len(values):
        raise ValueError(f"{owner}: {field} must be {expected}, got {shown(values)}")
    if count and len(values) != count:
        raise ValueError(f"{owner}: {field} must be {expected}, got {len(values)}")
    return tuple(number(owner, f"{field}[{i}]", value) for i, value in enumerate(values))


def checked_wavelengths(owner: str, wavelength: Any) -> Any:
    """Wavelengths as float64, all finite and > 0; a named ValueError otherwise."""
    w = real_array(owner, "wavelength", wavelength)
    bad = w[~(np.isfinite(w) & (w > 0))]
    if bad.size:
        raise ValueError(f"{owner}: wavelength must be in μm, finite and > 0, got {bad.flat[0]}")
    return w


def _in_nanometres(wavelength: float) -> str:
    return f"; {wavelength:g} nm are {wavelength / 1000:g}" if wavelength >= 100 else ""


def checked_index(owner: str, value: Any) -> Index:
    """What a material keeps as its refractive index: a complex number becomes a table of one; ValueError otherwise."""
    if isinstance(value, FORMULAS):
        return value
    if isinstance(value, str):
        from .glasses import glasses

        if value in glasses:
            return value
    if is_complex(value) and np.ndim(value) == 0 and complex(value).real > 0 and complex(value).imag > 0:
        whole = complex(value)
        return Tabulated((LINE_D,), (whole.real,), (whole.imag,))
    if callable(value) and not isinstance(value, type):
        try:
            index_at(value, LINE_D)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            expected = "a function of it must take wavelengths in μm and return n > 0"
            raise ValueError(f"{owner}: refractive_index: {expected}; {str(error)[:160]}") from None
        found: Index = value
        return found
    index = number(owner, "refractive_index", value)
    if not index > 0:
        raise ValueError(f"{owner}: refractive_index must be > 0, got {index}")
    return index


def index_at(value: Any, wavelength: Any) -> Any:
    """A refractive index, of any kind that a material takes, at wavelengths in μm: float64 or complex128, their shape.

    Raises ValueError outside of the range of a formula, and for what a function returns and is no index.
    """
    if isinstance(value, str):
        from .glasses import glasses

        value = glasses[value]
    if isinstance(value, Dispersion):
        return value(wavelength)
    w = checked_wavelengths("refractive_index", wavelength)
    if not callable(value):
        return np.full(w.shape, float(value))[()]
    found = np.asarray(value(w))
    if found.dtype.kind not in "iufc" or found.shape not in (w.shape, ()):
        raise ValueError(
            f"refractive_index: the function must return numbers of shape {w.shape}, as its wavelengths have, "
            f"got {shown(found)}"
        )
    found = np.broadcast_to(found, w.shape) + 0.0
    bad = found[~(np.isfinite(found) & (found.real > 0) & (found.imag >= 0))]
    if bad.size:
        raise ValueError(f"refractive_index: the function must return n > 0, or n + ik with k >= 0, got {bad.flat[0]}")
    return found[()]


def _nearest(value: Any, wavelength: float) -> float:
    """The real index at a wavelength, or at the end of its range that is nearest."""
    if isinstance(value, str):
        from .glasses import glasses

        value = glasses[value]
    if isinstance(value, Dispersion) and value.range is not None:
        wavelength = min(max(wavelength, value.range[0]), value.range[1])
    return float(np.real(index_at(value, wavelength)))


def index_in_pictures(value: Any) -> float:
    """The one number that pictures in three channels use: n_d, or the index at the end of the range nearest to it."""
    return value if isinstance(value, float) else _nearest(value, LINE_D)


def spread_in_pictures(value: Any) -> float:
    """Cauchy's B in μm² through n_F and n_C, as pictures with dispersion take it: (n_F - n_C) / (1/λ_F² - 1/λ_C²)."""
    if isinstance(value, float):
        return 0.0
    rise = _nearest(value, LINE_F) - _nearest(value, LINE_C)
    return max(0.0, rise / (LINE_F**-2 - LINE_C**-2))
