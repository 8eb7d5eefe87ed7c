"""Metals by their complex refractive index, and some by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .calls import explained
from .looks import shininess_of
from .material import Material, made_by
from .properties import NO_PROPERTIES
from .relief import typical_roughness
from .texture import Texture
from .validate import numbers
from .vector import VectorLike


@explained
def conductor(
    index: VectorLike = (0.3, 1.02, 1.15),
    extinction: VectorLike = (3.205, 2.577, 2.5),
    roughness: float | Texture = 0.0,
    *,
    name: str | None = None,
    properties: Mapping[str, Any] = NO_PROPERTIES,
) -> Material:
    """A metal by its complex refractive index n + ik.

    index, extinction: n > 0 and k >= 0 for red, green and blue; left out, those of copper.
    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("conductor", index, extinction, roughness, name, properties)


def _conductor(
    maker: str, index: Any, extinction: Any, roughness: Any, name: str | None, properties: Mapping[str, Any]
) -> Material:
    """A metal; Whitted's pictures show its reflectance at normal incidence, ((n - 1)² + k²) / ((n + 1)² + k²)."""
    n, k = numbers(maker, "index", index, 3), numbers(maker, "extinction", extinction, 3)
    share = [((a - 1) ** 2 + b * b) / max((a + 1) ** 2 + b * b, 1e-300) for a, b in zip(n, k, strict=True)]
    tint = (min(1.0, share[0]), min(1.0, share[1]), min(1.0, share[2]))
    rough = typical_roughness(maker, roughness)
    made = Material(
        tint, 0.4, 0.4, specular=tint, shininess=shininess_of(rough), reflectivity=tint, fresnel=True,
        roughness=roughness,
        metal_index=(n[0], n[1], n[2]), metal_extinction=(k[0], k[1], k[2]), name=name, properties=properties,
    )  # fmt: skip
    own = {"index": made.metal_index, "extinction": made.metal_extinction} if maker == "conductor" else {}
    return made_by(made, maker, own)


@explained
def gold(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Gold, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("gold", (0.21, 0.43, 1.31), (3.272, 2.455, 1.849), roughness, name, properties)


@explained
def silver(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Silver, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("silver", (0.06, 0.06, 0.05), (4.152, 3.586, 2.869), roughness, name, properties)


@explained
def copper(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Copper, by its complex refractive index at 617, 549 and 471 nm: Johnson and Christy, Phys. Rev. B 6, 1972.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("copper", (0.3, 1.02, 1.15), (3.205, 2.577, 2.5), roughness, name, properties)


@explained
def aluminium(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Aluminium, by its complex refractive index at 650, 550 and 450 nm: Rakić, Applied Optics 34, 1995.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("aluminium", (1.3456, 0.96521, 0.61722), (7.4746, 6.3995, 5.3031), roughness, name, properties)


@explained
def iron(
    roughness: float | Texture = 0.0, *, name: str | None = None, properties: Mapping[str, Any] = NO_PROPERTIES
) -> Material:
    """Iron, by its complex refractive index at 650, 550 and 450 nm: Johnson and Christy, Phys. Rev. B 9, 1974.

    roughness: the α of GGX in [0, 1], or a texture of it.
    name, properties: the user's own, as in `Material`.
    """
    return _conductor("iron", (2.9114, 2.9497, 2.5845), (3.0893, 2.9318, 2.767), roughness, name, properties)
