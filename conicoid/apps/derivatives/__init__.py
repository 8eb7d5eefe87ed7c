"""How answers move with rays and with the numbers of shapes: by the implicit function at each wall.

`co.parameters(scene)` names the numbers; `hits.jvp` and `hits.vjp`, `spans.jvp` and `spans.vjp` are asked of answers.
Here are the derivatives of what answers do not know: of `co.reflect` and `co.refract`, and of volumes. The modules
`for_torch` and `for_jax` hand first hits to PyTorch and JAX, where these are installed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..._util.foreign_names import module_attribute_error
from ...queries.tangents import Cotangents, Curvature, SpanTangents, Tangents
from .parameters import Parameters
from .refraction import reflect_jvp, reflect_vjp, refract_jvp, refract_vjp
from .volume import VolumeGradient, volume_gradient

__all__ = [
    "Cotangents", "Curvature", "Parameters", "SpanTangents", "Tangents", "VolumeGradient", "reflect_jvp", "reflect_vjp",
    "refract_jvp", "refract_vjp", "volume_gradient",
]  # fmt: skip

if not TYPE_CHECKING:  # else checkers would let any name be asked for

    def __getattr__(name: str) -> Any:
        if name in ("for_jax", "for_torch"):
            import importlib

            return importlib.import_module(f"conicoid.apps.derivatives.{name}")
        raise module_attribute_error("conicoid.apps.derivatives", name, __all__)

    def __dir__() -> list[str]:
        return sorted([*__all__, "for_jax", "for_torch"])
