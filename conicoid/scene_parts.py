"""What a scene is made of, as a user hands it over: bodies and a camera."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .shapes.base import Shape, Solid
from .shapes.body import Body
from .shapes.validate import what


def as_bodies(items: Any) -> tuple[Body, ...]:
    """Shapes and bodies as bodies; one alone stands for a list of it.

    Raises TypeError for anything else, with its index.
    """
    if isinstance(items, (Shape, Body)):
        items = (items,)
    if isinstance(items, (str, bytes, Mapping)) or not isinstance(items, Iterable):
        raise TypeError(f"Scene: items must be a list of shapes and Bodies, or one of them, got {what(items)}")
    return tuple(_as_body(i, item) for i, item in enumerate(items))


def _as_body(index: int, item: Any) -> Body:
    if isinstance(item, Body):
        return item
    if isinstance(item, Shape):
        return Body(item)
    raise TypeError(f"Scene: items[{index}] must be a shape or a Body, got {what(item)}")


def as_camera(camera: Any) -> Any:
    """A Camera, an OrthographicCamera, or None for one that fits; a TypeError otherwise."""
    if camera is None:
        return None
    from .render.camera import Camera, OrthographicCamera

    if not isinstance(camera, Camera | OrthographicCamera):
        raise TypeError(f"Scene: camera must be a Camera, an OrthographicCamera or None, got {what(camera)}")
    return camera


def as_domain(domain: Any) -> Solid | None:
    """A solid, or None; a TypeError otherwise."""
    if domain is not None and not isinstance(domain, Solid):
        raise TypeError(f"Scene: domain must be a solid or None, got {what(domain)}")
    return domain
