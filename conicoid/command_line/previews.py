"""Pictures that are shown while they become better."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .terminal import Bar


def previews(bar: Bar, path: Path | None, developed: Callable[[Any], Any]) -> Callable[[Any], None]:
    """What is done with a picture as it becomes better: its noise is told, and it is written, whole, at `path`."""

    def shown(image: Any) -> None:
        if image.noise < float("inf"):
            bar.note = f", noise {image.noise:.2g}"
        if path is not None:
            developed(image).save(path)

    return shown
