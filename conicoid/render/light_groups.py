"""Light by groups of lights: for each a scene in which these alone give light.

Light adds up, so the pictures of all groups, each with noise of its own, add up to the picture.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from .._util.hints import describe_names
from .._util.validation import describe_kind, format_value
from ..geometry.body import Body
from ..materials.color import amount_rgb
from ..materials.light import AmbientLight, as_lights
from ..materials.material import Material

BACKGROUND = "background"
_BLACK = (0.0, 0.0, 0.0)


def scenes_by_group(scene: Any, groups: Any) -> dict[str, Any]:
    """Return, for the name of each group, the scene with its lights alone.

    groups: name -> members: names of bodies that glow, lights of the scene, and "background".
    """
    if not isinstance(groups, Mapping):
        raise TypeError(f"render: groups must be a mapping from names to lists of lights, got {describe_kind(groups)}")
    return {_check_group_name(name): _scene_of_group(scene, name, members) for name, members in groups.items()}


def _check_group_name(name: Any) -> str:
    if not isinstance(name, str) or not name or not name.isprintable():
        raise ValueError(f"render: groups must have names that are texts, got {format_value(name)}")
    return name


def _scene_of_group(scene: Any, group: str, members: Any) -> Any:
    """The scene with some of its lights."""
    items = [members] if isinstance(members, str) or not isinstance(members, list | tuple | set) else list(members)
    lamps = {body.name for body in scene.bodies if body.name is not None and _glows(body)}
    lights, bodies, sky = [], set(), False
    for item in items:
        if isinstance(item, str) and item in lamps:
            bodies.add(item)
        elif isinstance(item, str) and item == BACKGROUND:
            sky = True
        elif not isinstance(item, str) and item in scene.lights:
            lights.append(item)
        else:
            known = describe_names(item, "bodies that glow", sorted(lamps))
            expected = f'bodies that glow, lights of the scene or "{BACKGROUND}"'
            raise ValueError(
                f"render: groups[{format_value(group)}] must name {expected}, got {format_value(item)}; {known}"
            )
    made = scene
    for number, body in enumerate(scene.bodies):
        if _glows(body) and body.name not in bodies:
            made = made._with_entry(number, body, _without_emission(body))
    background = scene.background if sky else _BLACK
    return made.replace(lights=as_lights(lights) or [AmbientLight(0.0)], background=background)


def _materials(body: Body) -> tuple[Any, ...]:
    return tuple(body.materials) if body.materials is not None else (body.material,)


def _glows(body: Body) -> bool:
    """Does a body, or one of many in an entry, give light by itself?"""
    found = (each for each in _materials(body) if isinstance(each, Material))
    return any(max(amount_rgb(each.emission)) > 0 for each in found)


def _without_emission(body: Body) -> Body:
    """The same without light of its own."""
    dark = [dataclasses.replace(each, emission=0.0) if isinstance(each, Material) else each
            for each in _materials(body)]  # fmt: skip
    if body.materials is not None:
        return dataclasses.replace(body, materials=tuple(dark))
    return dataclasses.replace(body, material=dark[0])
