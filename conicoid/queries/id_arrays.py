"""Arrays of body, surface and face numbers that raise TypeError when a program compares them with a text.

NumPy's own comparison with a text is False throughout, so `hits[hits.body == "pillar"]` would silently be empty.
Results computed from these arrays are plain NumPy arrays, and so are their pickles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .._util.validation import format_value

_TEXTS = "SUT"  # the kinds of dtypes that hold texts
# NumPy functions that compare the items of their arguments
_SETS = ("isin", "in1d", "array_equal", "array_equiv", "intersect1d", "setdiff1d", "union1d", "setxor1d")


def _text_in(other: Any) -> Any:
    """Return `other` if it is a text, or the first text in a list or array; None if there is none."""
    if isinstance(other, (str, bytes)):
        return other
    if isinstance(other, np.ndarray):
        if other.dtype.kind in _TEXTS:
            return other.flat[0].item() if other.size else None
        other = other.ravel().tolist() if other.dtype == object else ()
    if isinstance(other, list | tuple | set | frozenset):
        return next((one for one in other if isinstance(one, (str, bytes))), None)
    return None


@dataclass(frozen=True)
class NumberKind:
    """A kind of numbered things, and the hint for a comparison with a name, which replaces {} in it."""

    what: str
    instead: str

    def refuse(self, other: Any) -> None:
        """Raise TypeError for a text, or for a list or array of texts."""
        if type(other) is not int and (name := _text_in(other)) is not None:
            hint = self.instead.replace("{}", format_value(name))
            raise TypeError(f"numbers of {self.what} are no names, got {format_value(name)}: {hint}")


BODIES = NumberKind("bodies", "names are compared by hits.name == {}, and scene.body(number).name is that of a number")
SURFACES = NumberKind("surfaces", "surfaces have no names; those of bodies are compared by hits.name == {}")
FACES = NumberKind(
    "faces", "faces have no names; help(shape) and docs/shapes.md tell which of a shape has which number"
)
MATERIALS = NumberKind("materials", "scene.materials.index({}) is the number of one")


class _Number(np.int32):
    """One number.

    The class must have a single base: NumPy looks for the integer at the first one and would crash the process.
    """

    __slots__ = ()
    kind: ClassVar[NumberKind]

    def __eq__(self, other: object) -> Any:
        self.kind.refuse(other)
        return super().__eq__(other)

    def __ne__(self, other: object) -> Any:
        self.kind.refuse(other)
        return super().__ne__(other)

    __hash__ = np.int32.__hash__

    def __reduce_ex__(self, protocol: Any) -> Any:
        return np.int32(int(self)).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(np.int32(int(self)))


class _Numbers(np.ndarray[Any, Any]):
    """An array of numbers of one kind."""

    kind: ClassVar[NumberKind]
    one: ClassVar[type[_Number]]

    @property
    def _is_numbers(self) -> bool:
        """False after a conversion to texts, as by `hits.body.astype(str)`, which may be compared with texts."""
        return self.dtype.kind in "iuf"

    def __eq__(self, other: object) -> Any:
        if self._is_numbers:
            self.kind.refuse(other)
        return super().__eq__(other)

    def __ne__(self, other: object) -> Any:
        if self._is_numbers:
            self.kind.refuse(other)
        return super().__ne__(other)

    __hash__ = None

    def __reduce_ex__(self, protocol: Any) -> Any:
        return np.asarray(self).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(np.asarray(self))

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        del context
        return array[()] if return_scalar or array.ndim == 0 else np.asarray(array)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function.__name__ in _SETS and self._is_numbers:
            for argument in (*args, *kwargs.values()):
                self.kind.refuse(argument)
        return super().__array_function__(function, types, args, kwargs)

    def __getitem__(self, index: Any) -> Any:
        item = super().__getitem__(index)
        return self.one(item) if type(item) is np.int32 else item

    def __iter__(self) -> Iterator[Any]:
        if self.ndim != 1 or self.dtype != np.int32:
            return super().__iter__()
        return map(self.one, self.tolist())


class BodyNumber(_Number):
    """The number of a body."""

    __slots__ = ()
    kind = BODIES


class BodyNumbers(_Numbers):
    """Numbers of bodies."""

    kind, one = BODIES, BodyNumber


class SurfaceNumber(_Number):
    """The number of a surface."""

    __slots__ = ()
    kind = SURFACES


class SurfaceNumbers(_Numbers):
    """Numbers of surfaces."""

    kind, one = SURFACES, SurfaceNumber


class FaceNumber(_Number):
    """The number of a face."""

    __slots__ = ()
    kind = FACES


class FaceNumbers(_Numbers):
    """Numbers of faces."""

    kind, one = FACES, FaceNumber


class MaterialNumber(_Number):
    """The place of a material in `scene.materials`."""

    __slots__ = ()
    kind = MATERIALS


class MaterialNumbers(_Numbers):
    """Places of materials in `scene.materials`."""

    kind, one = MATERIALS, MaterialNumber


_KINDS: dict[str, Any] = {"body": BodyNumbers, "before": BodyNumbers, "after": BodyNumbers}
_KINDS |= {"surface": SurfaceNumbers, "face": FaceNumbers, "material": MaterialNumbers, "wall": BodyNumbers}


def as_id_array(field: str, values: Any) -> Any:
    """Return the values of a field, without a copy, as numbers that refuse texts: an int32 array, or one integer."""
    kind = _KINDS[field]
    return values.view(kind) if isinstance(values, np.ndarray) else kind.one(int(values))


def number_fields(fields: dict[str, Any]) -> dict[str, Any]:
    """Return the fields that hold numbers, as `as_id_array` returns them."""
    names = ("body", "before", "after", "surface", "face", "wall")
    return {name: as_id_array(name, fields[name]) for name in names if name in fields}
