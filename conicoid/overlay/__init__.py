"""Axes, names and normals, drawn over a picture. Pixels that nothing is drawn on stay as they are, to the bit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..image import Image
from ..shapes.calm import calm
from .axes import draw_axes
from .labels import draw_labels
from .normals import draw_normals
from .sheet import Sheet

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene


@calm
def drawn_over(image: Image, scene: Scene, camera: AnyCamera, *, axes: bool, labels: bool, normals: bool) -> Image:
    """The picture of a scene by a camera with what is asked for drawn over it."""
    sheet = Sheet(image.width, image.height)
    for wanted, draw in ((normals, draw_normals), (axes, draw_axes), (labels, draw_labels)):
        if wanted:
            draw(sheet, scene, camera)
    return Image._of_light(sheet.over(image.pixels), image.layers)


__all__ = ["drawn_over"]
