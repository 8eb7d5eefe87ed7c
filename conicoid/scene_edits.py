"""Scenes made from scenes: by replacing, moving, adding and removing entries, or with other lights and cameras."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .scene_parts import (
    Bodies,
    as_bodies,
    exchanged,
    moved_by,
    one_entry,
    refuse_same_names,
    shared_bodies,
    with_entry,
    with_fewer,
    with_more,
)
from .shapes.base import Shape
from .shapes.body import Body
from .shapes.calls import explained_methods
from .shapes.labels import numbers_of

if TYPE_CHECKING:
    from .scene import Scene

_SAME: Any = object()


@explained_methods
class Edits:
    """What gives new scenes; each takes what is prepared of the old one, and prepares only what is new."""

    _bodies: Bodies
    _firsts: Any

    @property
    def _parts(self) -> tuple[Any, ...]:
        raise NotImplementedError

    def _edited(self, bodies: Bodies, *parts: Any, before: Scene | None = None) -> Scene:
        raise NotImplementedError

    def replace(
        self, which: str | int | None = None, item: Shape | Body | None = None, *,
        material: Any = _SAME, name: Any = _SAME,
        lights: Any = _SAME, camera: Any = _SAME, background: Any = _SAME, domain: Any = _SAME, animation: Any = _SAME,
    ) -> Scene:  # fmt: skip
        """A scene with one entry changed, or other lights, camera, background, domain or animation.

        It prepares only that.

        which: the name of the entry, or the number of its body.
        item: a shape takes the place of the entry's shape, which keeps its material and name, and a `Body` that of the
            whole entry, whose name stays if the `Body` has none.
        material, name: change these alone, or besides; None takes them away.
        lights, camera, background, domain, animation: as for a `Scene`; None takes them away.

        Raises KeyError and IndexError for an entry that there is not.
        """
        labels = {key: new for key, new in dict(material=material, name=name).items() if new is not _SAME}
        keeps = which is None and item is None and not labels
        asked = lights, camera, background, domain, animation
        given = (old if new is _SAME else new for new, old in zip(asked, self._parts[1:], strict=True))
        if keeps:
            return self._edited(self._bodies, *given)
        return self._with_entry(*exchanged(self._bodies, self._first_numbers, which, item, labels), *given)

    def moved(self, which: str | int, motion: Any) -> Scene:
        """A scene with one entry moved; it prepares only that.

        which: the name of the entry, or the number of its body.
        motion: three numbers, by which it is translated; or a `matrix` (4, 4), as for `shape.transform`; or a function
            that is handed the shape and returns what takes its place: lambda shape: shape.rotate("z", 30).

        Raises KeyError and IndexError for an entry that there is not.
        """
        entry = one_entry(self._bodies, self._first_numbers, which, "moved")
        old = self._bodies[entry]
        return self._with_entry(entry, old, dataclasses.replace(old, shape=moved_by(old.shape, motion)))

    def added(self, items: Shape | Body | Iterable[Shape | Body], before: str | int | None = None) -> Scene:
        """A scene with more entries; it prepares only these.

        items: shapes or `Body`s, or one of them.
        before: the name of the entry that they come before, or the number of its body; None puts them at the end.

        Raises KeyError and IndexError for an entry that there is not, ValueError for a name that is taken.
        """
        place = len(self._bodies)
        if before is not None:
            place = one_entry(self._bodies, self._first_numbers, before, "added", "before")
        bodies = with_more(self._bodies, place, as_bodies(items, "added"))
        refuse_same_names(bodies)
        return self._edited(bodies)

    def without(self, which: str | int | Iterable[str | int]) -> Scene:
        """A scene without some entries; it prepares nothing anew.

        which: the name of the entry, or the number of its body; or a list of these.

        Raises KeyError and IndexError for an entry that there is not.
        """
        each = which if isinstance(which, Iterable) and not isinstance(which, str) else [which]
        gone = {one_entry(self._bodies, self._first_numbers, one, "without") for one in each}
        return self._edited(with_fewer(self._bodies, gone))

    def _with_entry(self, entry: int, old: Body, body: Body, *parts: Any) -> Scene:
        """The scene with another body for an entry of the list, which is `old`; parts as for `_edited`."""
        bodies = with_entry(self._bodies, entry, old, body)
        if body.name is not None and body.name != old.name:
            refuse_same_names(bodies)
        made = self._edited(bodies, *parts)
        if "_firsts" in vars(self) and numbers_of(old) == numbers_of(body):
            made._firsts = self._firsts
        return made

    def _taking_from(self, before: Scene) -> Scene:
        """The same scene, with what is equal in one that is prepared taken from there."""
        return self._edited(shared_bodies(before.bodies, self._bodies), *self._parts[1:], before=before)

    def _first_numbers(self) -> Any:
        return self._firsts
