"""A picture in a notebook that becomes better while it is made."""

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
