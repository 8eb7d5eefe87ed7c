"""A picture in a notebook, or in a terminal, that becomes better while it is made."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any


def in_notebook() -> Callable[[Any], None]:
    """What shows pictures in one place of a notebook's cell, each in place of the one before.

    Raises ImportError where IPython, and so a notebook, is not there.
    """
    try:
        shows: Any = importlib.import_module("IPython.display")
    except ImportError:
        raise ImportError(
            'render: preview=True shows pictures in notebooks; elsewhere it is "terminal" or a function'
        ) from None
    handle: list[Any] = []

    def preview(image: Any) -> None:
        if handle:
            handle[0].update(image)
        else:
            handle.append(shows.display(image, display_id=True))

    return preview


def in_terminal() -> Callable[[Any], None]:
    """What draws pictures in the terminal that stderr is, each over the one before; nothing where it is none."""
    from rich.console import Console
    from rich.control import Control
    from rich.segment import ControlType

    from .blocks import half_blocks

    console, above = Console(stderr=True), [0]

    def preview(image: Any) -> None:
        if not console.is_terminal:
            return
        drawn = half_blocks(image, console.width, max(1, console.height - 2))
        if above[0]:
            console.control(Control((ControlType.CURSOR_UP, above[0])))
        console.print(drawn, end="\n")
        above[0] = drawn.plain.count("\n") + 1

    return preview
