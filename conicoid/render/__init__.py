"""From a scene to a picture: cameras, samples, tiles, film."""

from __future__ import annotations
