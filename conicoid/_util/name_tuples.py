"""Parts of a scene that are tuples: they know names, and tell of what lists have and tuples do not."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NoReturn, SupportsIndex

import numpy as np

from .hints import describe_names
from .validation import format_value

_CHANGES = ("append", "extend", "insert", "remove", "pop", "clear", "sort", "reverse")


class PartTuple(tuple[Any, ...]):
    """A tuple that is one part of something that does not change; `another` says how one with others is made."""

    called: str
    another: str

    def __new__(cls, items: Iterable[Any], called: str, another: str) -> PartTuple:
        made = super().__new__(cls, items)
        made.called, made.another = called, another
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (tuple(self), self.called, self.another)

    def __add__(self, other: Any) -> tuple[Any, ...]:
        """Joined with a list as with a tuple: what comes out makes another scene."""
        return tuple(self) + tuple(other) if isinstance(other, list) else tuple.__add__(self, other)

    if not TYPE_CHECKING:  # else checkers would let any name be asked for, and items be set

        def __getattr__(self, name: str) -> Any:
            hint = f", it does not change: {self.another}" if name in _CHANGES else self._meant(name)
            raise AttributeError(f"{self.called} has no {name[:80]!r}{hint}", name=name, obj=self)

        def __setitem__(self, index: Any, value: Any) -> NoReturn:
            raise TypeError(f"{self.called} does not change: {self.another}")

        def __delitem__(self, index: Any) -> NoReturn:
            raise TypeError(f"{self.called} does not change: {self.another}")

    def _meant(self, name: str) -> str:
        """What to tell of an attribute that there is not."""
        del name
        return ""


class NamedPartTuple(PartTuple):
    """A tuple whose items may have names: `parts["steel"]`, `parts.index("steel")`, besides numbers.

    material_of: of the materials of a scene, what a body of a number has. NumPy's int32, which `hits.body` and
    `body_at` give, are numbers of bodies, and are refused where they mean another material.
    """

    names: tuple[str | None, ...]
    material_of: Callable[[int], Any] | None

    def __new__(
        cls,
        items: Iterable[Any],
        called: str,
        another: str = "",
        names: Iterable[str | None] | None = None,
        material_of: Callable[[int], Any] | None = None,
    ) -> NamedPartTuple:
        kept = tuple(items)
        made = super().__new__(cls, kept, called, another)
        assert isinstance(made, NamedPartTuple)
        made.names = tuple(getattr(item, "name", None) for item in kept) if names is None else tuple(names)
        made.material_of = material_of
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (tuple(self), self.called, self.another, self.names)

    def __getitem__(self, index: Any) -> Any:
        """The item of a name or of a place; a KeyError for a name that none has, or more than one."""
        if isinstance(index, str):
            return tuple.__getitem__(self, self._place(index))
        if isinstance(index, np.ndarray) and index.ndim:
            told = "hits.material and spans.material are the materials of all bodies at once"
            raise TypeError(f"{self.called}[...] takes one integer or a name, got an array of {index.size}; {told}")
        if isinstance(index, np.integer):
            self._refuse_other(operator.index(index), isinstance(index, np.int32))
        return tuple.__getitem__(self, index)

    def index(self, item: Any, start: SupportsIndex = 0, stop: SupportsIndex = 2**62) -> int:
        """The place of an item, or of a name: that of its column in lengths by material."""
        return self._place(item) if isinstance(item, str) else tuple.index(self, item, start, stop)

    def _place(self, name: str) -> int:
        places = [place for place, one in enumerate(self.names) if one == name]
        if len(places) == 1:
            return places[0]
        if places:
            raise KeyError(
                f"{self.called}: {len(places)} are called {format_value(name)}, at {places}: take one by its place"
            )
        known = [one for one in self.names if one]
        raise KeyError(f"{self.called}: none is called {format_value(name)}; {describe_names(name, 'names', known)}")

    def _refuse_other(self, number: int, is_body: bool) -> None:
        """IndexError for a number of a body that has another material than the one in its place."""
        told = "hits.material, and scene.body(number).material, are those of bodies"
        if number < 0:
            raise IndexError(f"{self.called}[{number}]: -1 stands for a miss; {told}")
        if not is_body or self.material_of is None:
            return
        if number >= len(self) or tuple.__getitem__(self, number) != self.material_of(number):
            raise IndexError(f"{self.called}[{number}]: bodies and materials are counted differently; {told}")

    def _meant(self, name: str) -> str:
        return f": {self.called}[{name!r}] is the one of that name" if name in self.names else ""
