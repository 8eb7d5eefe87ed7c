"""From a scene to a picture: cameras, samples, tiles, film."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any, NoReturn


class _NoFunction(ModuleType):
    """A module that is named as a function might be, and tells so."""

    def __call__(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("conicoid.render is a module, not a function: a scene has it, scene.render(width, height)")


sys.modules[__name__].__class__ = _NoFunction
