"""Tuples whose items have names, such as the materials of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, SupportsIndex

from .hints import describe_names
from .validation import format_value


class NameTuple(tuple[Any, ...]):
    """A tuple whose items are found by name as well as by index: `materials["steel"]`, `materials.index("steel")`.

    Parameters
    ----------
    items : iterable
        The items.
    owner : str
        The tuple in messages, such as "scene.materials".
    names : iterable of str or None, optional
        The name of each item; by default its attribute `name`, if it has one.
    """

    owner: str
    names: tuple[str | None, ...]

    def __new__(cls, items: Iterable[Any], owner: str, names: Iterable[str | None] | None = None) -> NameTuple:
        parts = super().__new__(cls, items)
        parts.owner = owner
        parts.names = tuple(getattr(item, "name", None) for item in parts) if names is None else tuple(names)
        return parts

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (tuple(self), self.owner, self.names)

    def __getitem__(self, index: Any) -> Any:
        """Return the item of a name or an index.

        Raises
        ------
        KeyError
            For a name of no item, or of more than one.
        """
        return super().__getitem__(self._place(index) if isinstance(index, str) else index)

    def index(self, item: Any, start: SupportsIndex = 0, stop: SupportsIndex = 2**62) -> int:
        """Return the index of an item, or of a name: that of its column in lengths by material."""
        return self._place(item) if isinstance(item, str) else super().index(item, start, stop)

    def _place(self, name: str) -> int:
        """Return the index of a name; raise KeyError for an unknown or repeated one."""
        places = [place for place, one in enumerate(self.names) if one == name]
        if len(places) == 1:
            return places[0]
        if places:
            raise KeyError(f"{self.owner}: {len(places)} have the name {format_value(name)}, at {places}: use an index")
        known = [one for one in self.names if one]
        raise KeyError(f"{self.owner}: none has the name {format_value(name)}; {describe_names(name, 'names', known)}")
