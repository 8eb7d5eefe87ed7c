"""Media of a prescription: an index, a function of the wavelength, a name, or index and Abbe number."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from ..._util.records import dataclass
from ..._util.validation import check_number, check_positive, describe_kind, format_value
from ...materials.dispersion import LINE_C, LINE_D, LINE_F, Dispersion, check_light
from ...materials.material import Material
from ...materials.presets import glass as clear_glass

MIRROR = "mirror"


@dataclass(frozen=True)
class Medium:
    """An optical medium: its name, and its refractive index by wavelength."""

    name: str
    refractive_index: Callable[[float], float]

    def index(self, wavelength: float) -> float:
        """Return the refractive index at a wavelength in μm. Raise ValueError if the function returns none."""
        return check_positive("medium", self.name, self.refractive_index(wavelength))

    @property
    def is_air(self) -> bool:
        """Whether it is air."""
        return self.name == "air"

    def material(self) -> Material:
        """Return the medium as glass of a scene: by its own formula, or with the dispersion between lines F and C."""
        if isinstance(self.refractive_index, Dispersion):
            return clear_glass(self.refractive_index, name=self.name)
        # Pictures need n_d and Cauchy's B, which n_F and n_C define.
        f, d, c = (self.index(line) for line in (LINE_F, LINE_D, LINE_C))
        return clear_glass(d, dispersion=max(0.0, (f - c) / _SPREAD), name=self.name)


@dataclass(frozen=True)
class _CauchyIndex:
    """n = index + slope (1/λ² - 1/λ_d²), a constant if the slope is 0. Its numbers define equality and pickles."""

    index: float
    slope: float = 0.0

    def __call__(self, wavelength: float) -> float:
        return self.index + self.slope * (1 / wavelength**2 - 1 / LINE_D**2) if self.slope else self.index


_SPREAD = 1 / LINE_F**2 - 1 / LINE_C**2
AIR = Medium("air", _CauchyIndex(1.0))


# From a user's value to a medium.


def parse_medium(owner: str, field: str, value: Any) -> Medium:
    """Return the medium of a value.

    A value is None or "air"; a number; (index at d, Abbe number), by Cauchy's formula of two terms; a function of the
    wavelength in μm; an object with a `refractive_index`; or a name that `co.optics.glass` knows.
    Raise ValueError or TypeError, by object and field, for anything else.
    """
    if value is None or (isinstance(value, str) and value == "air"):
        return AIR
    if isinstance(value, str):
        return glass_by_name(owner, field, value)
    if isinstance(value, Medium):
        return value
    if isinstance(value, tuple | list):
        return _by_abbe_number(owner, field, value)
    index = getattr(value, "refractive_index", value)
    if isinstance(index, str):
        return glass_by_name(owner, field, index)
    # A class would be called as a function of the wavelength, so it is refused below.
    if callable(index) and not isinstance(index, type):
        return Medium(str(getattr(value, "name", None) or "glass"), index)
    if isinstance(value, type) or callable(value):
        raise TypeError(
            f"{owner}: {field} must be a refractive index, a function or a name, got {describe_kind(value)}"
        )
    constant = check_positive(owner, field, index)
    # Index 1 is air, which makes no lens.
    if constant == 1:
        return AIR
    slope = float(getattr(value, "dispersion", 0.0))
    return Medium(str(getattr(value, "name", None) or f"index {constant:g}"), _CauchyIndex(constant, slope))


def medium_by_abbe(name: str, index: float, abbe: float) -> Medium:
    """Return the medium n = index + B (1/λ² - 1/λ_d²) with n_F - n_C = (index - 1) / abbe."""
    slope = (index - 1) / abbe / _SPREAD if abbe else 0.0
    return Medium(name, _CauchyIndex(index, slope))


def _by_abbe_number(owner: str, field: str, value: Any) -> Medium:
    """Return the medium of a pair (index at d, Abbe number)."""
    if len(value) != 2:
        raise ValueError(f"{owner}: {field} must be (index at d, Abbe number), got {format_value(value)}")
    index, abbe = check_positive(owner, f"{field}[0]", value[0]), check_number(owner, f"{field}[1]", value[1])
    return medium_by_abbe(f"glass {index:g}/{abbe:g}", index, abbe)


def glass_by_name(owner: str, field: str, name: str) -> Medium:
    """Return a glass of the catalogue. Raise ValueError for an unknown name."""
    medium = find_glass(name)
    if medium is None:
        expected = "a glass that co.optics.glass knows, a refractive index, (index, Abbe number) or a function of it"
        raise ValueError(f"{owner}: {field} must be {expected}, got {format_value(name)}")
    return medium


def find_glass(name: str) -> Medium | None:
    """Return a glass of the catalogue, or None for an unknown name."""
    try:
        glass = getattr(importlib.import_module("conicoid.apps.optics"), "glass", None)
        value = None if glass is None else glass(name)
    except (AttributeError, LookupError, ValueError):
        return None
    index = getattr(value, "refractive_index", value)
    if callable(index):
        return Medium(name, index)
    return None if index is None else Medium(name, _CauchyIndex(float(index)))


def check_wavelength(owner: str, value: Any) -> float:
    """Return a wavelength in μm; refuse nanometres."""
    return float(check_light(owner, check_positive(owner, "wavelength", value)))
