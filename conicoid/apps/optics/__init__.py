"""Optics: light paths, glasses, coatings and lens systems. Lengths are the scene's, wavelengths are in μm of vacuum."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

# Public name -> module of this package that defines it. Loaded on first use, as the names of conicoid itself.
_HOMES: dict[str, str] = {
    "prescription": ".prescriptions",
    "Prescription": ".prescriptions",
    "Row": ".prescriptions",
    "load_zmx": ".zmx",
    "read_zmx": ".zmx",
    "trace": ".ray_trace",
    "Trace": ".ray_trace",
    "follow": ".ray_trace",
    "RayPaths": ".ray_trace",
    "focal_length": ".cardinal",
    "cardinal_points": ".cardinal",
    "CardinalPoints": ".cardinal",
    "spot": ".spot_diagram",
    "Spot": ".spot_diagram",
    "ray_fan": ".spot_diagram",
    "RayFan": ".spot_diagram",
    "beam": ".spot_diagram",
    "layout": ".drawing",
    "Layout": ".drawing",
    "OptilandBackend": ".optiland_backend",
    "optiland_component": ".optiland_backend",
    "Sellmeier": "...materials.dispersion",
    "Cauchy": "...materials.dispersion",
    "Schott": "...materials.dispersion",
    "Edlen": "...materials.dispersion",
    "Tabulated": "...materials.dispersion",
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
    from ...materials.coating import Coating as Coating
    from ...materials.coating import Fresnel as Fresnel
    from ...materials.coating import Layer as Layer
    from ...materials.coating import fresnel as fresnel
    from ...materials.dispersion import Cauchy as Cauchy
    from ...materials.dispersion import Dispersion as Dispersion
    from ...materials.dispersion import Edlen as Edlen
    from ...materials.dispersion import Glasses as Glasses
    from ...materials.dispersion import Schott as Schott
    from ...materials.dispersion import Sellmeier as Sellmeier
    from ...materials.dispersion import Tabulated as Tabulated
    from ...materials.dispersion import glass as glass
    from ...materials.dispersion import glasses as glasses
    from ...materials.dispersion import index_at as index_at
    from .cardinal import CardinalPoints as CardinalPoints
    from .cardinal import cardinal_points as cardinal_points
    from .cardinal import focal_length as focal_length
    from .drawing import Layout as Layout
    from .drawing import layout as layout
    from .light_paths import Balance as Balance
    from .light_paths import Paths as Paths
    from .light_paths import trace_paths as trace_paths
    from .optiland_backend import OptilandBackend as OptilandBackend
    from .optiland_backend import optiland_component as optiland_component
    from .prescriptions import Prescription as Prescription
    from .prescriptions import Row as Row
    from .prescriptions import prescription as prescription
    from .ray_trace import RayPaths as RayPaths
    from .ray_trace import Trace as Trace
    from .ray_trace import follow as follow
    from .ray_trace import trace as trace
    from .spot_diagram import RayFan as RayFan
    from .spot_diagram import Spot as Spot
    from .spot_diagram import beam as beam
    from .spot_diagram import ray_fan as ray_fan
    from .spot_diagram import spot as spot
    from .zmx import load_zmx as load_zmx
    from .zmx import read_zmx as read_zmx
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
