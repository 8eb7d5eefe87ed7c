"""The layers that a picture may have beside its light."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from ..._util.hints import closest_name
from ..._util.validation import format_value
from .options import LAYERS

SUM_LAYERS = ("samples", "error")


class Layers(dict[str, Any]):
    """What a picture has beside its light, by name. One that it lacks is told of."""

    def __missing__(self, name: object) -> NoReturn:
        if name not in LAYERS:
            raise KeyError(f"no layer is called {format_value(name)}: those are {', '.join(LAYERS)}")
        raise KeyError(
            f"the picture was rendered without {format_value(name)}: scene.render(layers=[{format_value(name)}]) has it"
        )

    if not TYPE_CHECKING:  # else checkers would let any name be asked for

        def __getattr__(self, name: str) -> Any:
            hint = f": image.layers[{name!r}] is that" if name in LAYERS else ""
            raise AttributeError(f"'Layers' object has no attribute {name[:80]!r}{hint}", name=name, obj=self)


def check_layers(value: Any) -> tuple[str, ...]:
    """Names of layers; all of them for True."""
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
