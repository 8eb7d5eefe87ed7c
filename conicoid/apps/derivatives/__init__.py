"""Derivatives of query results by rays and by shape parameters, from the implicit function theorem at each wall.

`co.parameters(scene)` names the parameters. Hits and spans differentiate themselves: `hits.jvp`, `hits.vjp`,
`spans.jvp`, `spans.vjp`. This package adds the derivatives of `co.reflect`, of `co.refract` and of volumes. Its modules
`for_torch` and `for_jax` pass first hits and line integrals to PyTorch and JAX; they need these libraries.
"""

from __future__ import annotations

from ...queries.derivatives import Cotangents, Curvature, SpanTangents, Tangents
from .autodiff import VolumeGradient, volume_gradient
from .parameters import Parameters
from .refraction import reflect_jvp, reflect_vjp, refract_jvp, refract_vjp

__all__ = [
    "Cotangents", "Curvature", "Parameters", "SpanTangents", "Tangents", "VolumeGradient", "reflect_jvp", "reflect_vjp",
    "refract_jvp", "refract_vjp", "volume_gradient",
]  # fmt: skip
