"""Optics: light along paths, glasses, coats and lenses. Lengths are the scene's, wavelengths are in μm of vacuum."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

# Public name -> module of this package that defines it. Loaded on first use, as the names of conicoid itself.
_HOMES: dict[str, str] = {
    "prescription": ".prescriptions", "Prescription": ".prescriptions", "Row": ".rows",
    "load_zmx": ".zmx", "read_zmx": ".zmx", "trace": ".sequence", "Trace": ".sequence",
    "follow": ".following", "Followed": ".following", "focal_length": ".cardinal",
    "cardinal_points": ".cardinal", "CardinalPoints": ".cardinal", "spot": ".spots", "Spot": ".spots",
    "ray_fan": ".spots", "RayFan": ".spots", "beam": ".spots", "layout": ".drawing", "Layout": ".drawing",
    "OptilandBackend": ".with_optiland", "optiland_component": ".with_optiland",
    "Sellmeier": "..shapes.dispersion", "Cauchy": "..shapes.dispersion", "Schott": "..shapes.dispersion",
    "Edlen": "..shapes.dispersion", "Tabulated": "..shapes.dispersion", "Dispersion": "..shapes.dispersion",
    "index_at": "..shapes.dispersion", "glass": "..shapes.glasses",
    "glasses": "..shapes.glasses", "Glasses": "..shapes.glasses",
    "Coating": "..shapes.coating", "Layer": "..shapes.coating", "Fresnel": "..shapes.fresnel",
    "Balance": ".paths", "Paths": ".paths",
}  # fmt: skip

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from ..shapes.coating import Coating as Coating
    from ..shapes.coating import Layer as Layer
    from ..shapes.dispersion import Cauchy as Cauchy
    from ..shapes.dispersion import Dispersion as Dispersion
    from ..shapes.dispersion import Edlen as Edlen
    from ..shapes.dispersion import Schott as Schott
    from ..shapes.dispersion import Sellmeier as Sellmeier
    from ..shapes.dispersion import Tabulated as Tabulated
    from ..shapes.dispersion import index_at as index_at
    from ..shapes.fresnel import Fresnel as Fresnel
    from ..shapes.glasses import Glasses as Glasses
    from ..shapes.glasses import glass as glass
    from ..shapes.glasses import glasses as glasses
    from .cardinal import CardinalPoints as CardinalPoints
    from .cardinal import cardinal_points as cardinal_points
    from .cardinal import focal_length as focal_length
    from .drawing import Layout as Layout
    from .drawing import layout as layout
    from .following import Followed as Followed
    from .following import follow as follow
    from .paths import Balance as Balance
    from .paths import Paths as Paths
    from .prescriptions import Prescription as Prescription
    from .prescriptions import prescription as prescription
    from .rows import Row as Row
    from .sequence import Trace as Trace
    from .sequence import trace as trace
    from .spots import RayFan as RayFan
    from .spots import Spot as Spot
    from .spots import beam as beam
    from .spots import ray_fan as ray_fan
    from .spots import spot as spot
    from .with_optiland import OptilandBackend as OptilandBackend
    from .with_optiland import optiland_component as optiland_component
    from .zmx import load_zmx as load_zmx
    from .zmx import read_zmx as read_zmx
else:  # else checkers would let any name be asked for

    def __getattr__(name: str) -> Any:
        home = _HOMES.get(name)
        if home is None:
            from ..shapes.elsewhere import no_attribute_of_module

            raise no_attribute_of_module("conicoid.optics", name, __all__)
        value = getattr(importlib.import_module(home, __name__), name)
        if isinstance(value, type):
            from ..shapes.calls import explain

            explain(value)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted(__all__)
