"""From a scene to a picture: cameras, samples, tiles, film."""

from __future__ import annotations

from .._util.lazy_names import refuse_calls

refuse_calls(__name__, "a scene has it, scene.render(width, height)")
