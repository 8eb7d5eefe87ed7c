"""All cameras by their names in scene files."""

from __future__ import annotations

from .camera import AnyCamera, Camera, OrthographicCamera
from .wide_cameras import EquirectangularCamera, FisheyeCamera

CAMERAS: dict[str, type[AnyCamera]] = {
    each.__name__: each for each in (Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera)
}
"""Scene-file name -> class."""
