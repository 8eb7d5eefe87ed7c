"""The box around a shape or a scene, as users get it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from .same import same
from .vector import FloatArray

_HINTS = {
    **dict.fromkeys(("min", "lower", "minimum", "lo", "mins"), "it is called low"),
    **dict.fromkeys(("max", "upper", "maximum", "hi", "maxs"), "it is called high"),
    **dict.fromkeys(
        ("size", "sizes", "extent", "extents", "diagonal", "dimensions"), "bounds.high - bounds.low is that"
    ),
    **dict.fromkeys(("center", "centre", "mid", "middle"), "(bounds.low + bounds.high) / 2 is that"),
    **dict.fromkeys(("contains", "volume", "corners"), "they are two arrays (3,), bounds.low and bounds.high"),
}


class _Ends(NamedTuple):
    low: FloatArray
    high: FloatArray


class Bounds(_Ends):
    """(low, high), which it unpacks to: the two ends along x, y and z, ±inf where there is none.

    low, high   (3,)
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, tuple) and same(tuple(self), other if type(other) is tuple else tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    if not TYPE_CHECKING:  # else checkers would let any name be asked for

        def __getattr__(self, name: str) -> Any:
            hint = f": {_HINTS[name]}" if name in _HINTS else ""
            raise AttributeError(f"'Bounds' object has no attribute {name[:80]!r}{hint}", name=name, obj=self)

    def __repr__(self) -> str:
        return repr(tuple(self))
