"""The layers that a picture may have beside its light."""

from __future__ import annotations

from typing import Any

from ..shapes.suggestion import close_to
from ..shapes.validate import shown
from .names import LAYERS

OF_SUMS = ("samples", "error")


def checked_layers(value: Any) -> tuple[str, ...]:
    """Names of layers; all of them for True."""
    if value is True:
        return tuple(LAYERS)
    if value is None or value is False:
        return ()
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple | set | frozenset):
        raise TypeError(f"render: layers must be names of layers, or True for all, got {shown(value)}")
    for name in names:
        if not isinstance(name, str) or name not in LAYERS:
            close = close_to(name, LAYERS) if isinstance(name, str) else ""
            meant = f" (did you mean {close!r}?)" if close else ""
            raise ValueError(f"render: layers must be of {', '.join(LAYERS)}, got {shown(name)}{meant}")
    return tuple(name for name in LAYERS if name in names)
