"""What textures say of a surface beside its colour: how rough it is, bumps, normals."""

from __future__ import annotations

from typing import Any

from .pattern_means import mean_grey
from .texture import TEXTURES, ImageTexture
from .validate import number, shown

_MEANT = "an ImageTexture, Gradient, Noise, Wood or Brick"


def checked_roughness(owner: str, value: Any) -> Any:
    """A number in [0, 1], or a texture of such."""
    if isinstance(value, TEXTURES):
        return value
    rough = number(owner, "roughness", value)
    if not 0 <= rough <= 1:
        raise ValueError(f"{owner}: roughness must be in [0, 1], got {rough}")
    return rough


def typical_roughness(owner: str, value: Any) -> float:
    """One number, of a texture its mean."""
    rough = checked_roughness(owner, value)
    return rough if isinstance(rough, float) else mean_grey(rough)


def checked_relief(material: Any) -> dict[str, Any]:
    """Bumps and normals of a material."""
    bump, normal = material.bump, material.normal
    if bump is not None and not isinstance(bump, TEXTURES):
        raise TypeError(f"Material: bump must be a texture ({_MEANT}) or None, got {shown(bump)}")
    if normal is not None and not isinstance(normal, ImageTexture):
        raise TypeError(f"Material: normal must be an ImageTexture of normals or None, got {shown(normal)}")
    if normal is not None and not normal.data:
        hint = "its numbers are no colours: ImageTexture(..., data=True)"
        raise ValueError(f"Material: normal must be a texture of plain data; {hint}")
    return dict(bump_height=number("Material", "bump_height", material.bump_height))
