"""Layers of a picture beside its light: their names, checked, and their mapping."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from ..._util.hints import closest_name
from ..._util.validation import format_value
from .options import LAYERS

SUM_LAYERS = ("samples", "error")


class Layers(dict[str, Any]):
    """The layers of a picture by name. A missing one raises an error that names the argument of `render` for it."""

    def __missing__(self, name: object) -> NoReturn:
        if name not in LAYERS:
            raise KeyError(f"no layer is called {format_value(name)}: those are {', '.join(LAYERS)}")
        raise KeyError(
            f"the picture was rendered without {format_value(name)}: scene.render(layers=[{format_value(name)}]) has it"
        )

    if not TYPE_CHECKING:  # type checkers would accept any attribute otherwise

        def __getattr__(self, name: str) -> Any:
            hint = f": image.layers[{name!r}] is that" if name in LAYERS else ""
            raise AttributeError(f"'Layers' object has no attribute {name[:80]!r}{hint}", name=name, obj=self)


def check_layers(value: Any) -> tuple[str, ...]:
    """Return the names of layers in their order, all of them for True, none for None or False.

    Raise TypeError or ValueError for anything else.
    """
    if value is True:
        return tuple(LAYERS)
    if value is None or value is False:
        return ()
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple | set | frozenset):
        raise TypeError(f"render: layers must be names of layers, or True for all, got {format_value(value)}")
    for name in names:
        if not isinstance(name, str) or name not in LAYERS:
            close = closest_name(name, LAYERS) if isinstance(name, str) else ""
            meant = f" (did you mean {close!r}?)" if close else ""
            raise ValueError(f"render: layers must be of {', '.join(LAYERS)}, got {format_value(name)}{meant}")
    return tuple(name for name in LAYERS if name in names)
