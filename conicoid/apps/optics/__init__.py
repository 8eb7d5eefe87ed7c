"""Optics: light paths, glasses, coatings and lens systems. Lengths are the scene's, wavelengths are in μm of vacuum."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

# Public name -> module of this package that defines it. Loaded on first use, as the names of conicoid itself.
_HOMES: dict[str, str] = {
    "prescription": ".prescriptions",
    "Prescription": ".prescriptions",
    "Row": ".prescriptions",
    "load_agf": ".agf",
    "load_zmx": ".zmx",
    "read_zmx": ".zmx",
    "trace": ".ray_trace",
    "Trace": ".ray_trace",
    "follow": ".ray_trace",
    "RayPaths": ".ray_trace",
    "focal_length": ".ray_trace",
    "cardinal_points": ".ray_trace",
    "CardinalPoints": ".ray_trace",
    "spot": ".drawing",
    "Spot": ".drawing",
    "ray_fan": ".drawing",
    "RayFan": ".drawing",
    "beam": ".drawing",
    "layout": ".drawing",
    "Layout": ".drawing",
    "OptilandBackend": ".optiland_backend",
    "optiland_component": ".optiland_backend",
    "Sellmeier": "...materials.dispersion",
    "Cauchy": "...materials.dispersion",
    "Schott": "...materials.dispersion",
    "Edlen": "...materials.dispersion",
    "Tabulated": "...materials.dispersion",
    "CatalogueFormula": "...materials.dispersion",
    "Dispersion": "...materials.dispersion",
    "index_at": "...materials.dispersion",
    "glass": "...materials.dispersion",
    "glasses": "...materials.dispersion",
    "Glasses": "...materials.dispersion",
    "Coating": "...materials.coating",
    "Layer": "...materials.coating",
    "Fresnel": "...materials.coating",
    "fresnel": "...materials.coating",
    "Balance": ".light_paths",
    "Paths": ".light_paths",
    "trace_paths": ".light_paths",
}

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from ...materials.coating import Coating as Coating, Fresnel as Fresnel, Layer as Layer, fresnel as fresnel
    from ...materials.dispersion import (
        CatalogueFormula as CatalogueFormula,
        Cauchy as Cauchy,
        Dispersion as Dispersion,
        Edlen as Edlen,
        Glasses as Glasses,
        Schott as Schott,
        Sellmeier as Sellmeier,
        Tabulated as Tabulated,
        glass as glass,
        glasses as glasses,
        index_at as index_at,
    )
    from .agf import load_agf as load_agf
    from .drawing import (
        Layout as Layout,
        RayFan as RayFan,
        Spot as Spot,
        beam as beam,
        layout as layout,
        ray_fan as ray_fan,
        spot as spot,
    )
    from .light_paths import Balance as Balance, Paths as Paths, trace_paths as trace_paths
    from .optiland_backend import OptilandBackend as OptilandBackend, optiland_component as optiland_component
    from .prescriptions import Prescription as Prescription, Row as Row, prescription as prescription
    from .ray_trace import (
        CardinalPoints as CardinalPoints,
        RayPaths as RayPaths,
        Trace as Trace,
        cardinal_points as cardinal_points,
        focal_length as focal_length,
        follow as follow,
        trace as trace,
    )
    from .zmx import load_zmx as load_zmx, read_zmx as read_zmx
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
