"""From a scene to a picture: cameras, samples, tiles, film."""

from __future__ import annotations

from .camera import Camera, OrthographicCamera
from .picture import render

__all__ = ["Camera", "OrthographicCamera", "render"]
