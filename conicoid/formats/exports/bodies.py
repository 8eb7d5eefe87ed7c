"""The bodies of a scene one by one, with the names and materials that a file gives them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ...shapes.base import Solid
from ...shapes.color import amount_rgb, linear_rgb, srgb_encode
from ...shapes.labels import is_clear, numbers_of, one_body
from ...shapes.material import Material
from ..scene_file import SceneLike
from .exported import Report, Unsayable

MOST = 2_000_000
"""Bodies of one file."""


@dataclass(frozen=True)
class Item:
    """A solid body: its name, which no other has, its solid, and its material, None for none."""

    name: str
    solid: Solid
    material: Material | None


def solids_of(scene: SceneLike, report: Report) -> list[Item]:
    """All bodies; sheets are refused by name. Of many in one entry, each is one."""
    found = []
    for number, (name, body) in enumerate(_named(scene)):
        if number >= MOST:
            raise ValueError(f"export: a file has at most {MOST:,} bodies, this scene has more")
        with report.about(name):
            if body.shape.is_sheet:
                raise Unsayable(f"{type(body.shape).__name__} is a sheet, and such files have solids only")
            found.append(Item(name, body.shape, body.material))
    _told_apart(scene, report)
    return found


def _named(scene: SceneLike) -> Iterator[tuple[str, Any]]:
    taken = {body.name for body in scene.bodies}
    number = 0
    for body in scene.bodies:
        count = numbers_of(body)
        for k in range(count):
            name = body.name or f"body {number}"
            if count > 1 and body.name:
                name = f"{name}[{k}]"
            while name != body.name and name in taken:
                name += "'"
            taken.add(name)
            yield name, one_body(body, k)
            number += 1


def _told_apart(scene: SceneLike, report: Report) -> None:
    """What no such file has: said once, as pictures are not what it is for."""
    parts = [name for name in ("lights", "camera", "background", "animation") if getattr(scene, name, None)]
    if parts:
        report.narrow(f"not said: {', '.join(parts)}", "")


def is_void(material: Material | None) -> bool:
    """Is it nothing that anybody would see: what importers make of void and of gases?"""
    return (
        material is not None
        and is_clear(material)
        and min(amount_rgb(material.transparency)) == 1
        and material.refractive_index == 1.0
        and not any(amount_rgb(material.absorption))
        and not any(amount_rgb(material.scattering))
        and not any(amount_rgb(material.emission))
    )


def color_of(material: Material | None) -> tuple[str, bool]:
    """#rrggbb, and whether that is all of how the material looks: textures and mirrors are more than a colour."""
    material = material or Material()
    try:
        rgb = linear_rgb(material.color)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return "#cccccc", False
    channels = [round(255 * min(max(channel, 0.0), 1.0)) for channel in srgb_encode(rgb).tolist()]
    plain = not any(amount_rgb(material.reflectivity)) and not is_clear(material)
    return "#" + "".join(f"{channel:02x}" for channel in channels), plain


def same_look(a: Material, b: Material) -> bool:
    """Would both be said by the same colour?"""
    return color_of(a) == color_of(b)


__all__ = ["Item", "color_of", "is_void", "same_look", "solids_of"]
