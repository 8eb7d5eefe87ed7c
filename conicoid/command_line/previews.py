"""Pictures that are shown while they become better."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .terminal import Bar
from .working import STDOUT


def previews(bar: Bar, path: Path | None, developed: Callable[[Any], Any]) -> Callable[[Any], None]:
    """What is done with a picture as it becomes better: its noise is told, and it is written, whole, at `path`.

    path: STDOUT for a picture above the line of progress, in the terminal.
    """

    def shown(image: Any) -> None:
        if image.noise < float("inf"):
            bar.note = f", noise {image.noise:.2g}"
        if path == STDOUT:
            if bar.console.is_terminal:
                from ..formats.blocks import half_blocks

                bar.picture = half_blocks(developed(image)._shown, bar.console.width, max(1, bar.console.height - 3))
        elif path is not None:
            developed(image).save(path)

    return shown
