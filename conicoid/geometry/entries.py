"""The entries of a scene: checks of a user's items, access by number and name, edits."""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, SupportsIndex, TypeAlias

import numpy as np

from .._util.arrays import FloatArray
from .._util.text import check_choice, describe_names
from .._util.validation import describe_kind, format_value
from .body import Body, bodies_table
from .bulk import Bulk, Spheres
from .instance_edits import EditedInstances, InstanceOrigins, collect_instances
from .instances import InstanceList
from .shape import Boolean, Shape, Solid

_MOST_SUGGESTIONS = 1000
"""For suggestions, the names of so many bodies of a large scene are compared."""


class Entries(tuple[Body, ...]):
    """The entries of a scene, a tuple that refuses body numbers of results where they differ from indices.

    -1 is a miss and not the last entry, as in `scene[-1]`; slices are those of any tuple. NumPy integers are usually
    body numbers such as `hits.body`: after a `Spheres` bodies have other numbers than their entries, so these raise an
    IndexError with the right call.
    """

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        return bodies_table(self)

    def __getitem__(self, index: Any) -> Any:
        # Loops use plain integers, so these must be quick
        if isinstance(index, slice) or (type(index) is int and index >= 0):
            return super().__getitem__(index)
        number = as_index(index)
        if number is None:
            raise TypeError(f"Scene: bodies[...] takes an integer or a slice, got {format_value(index)}")
        # Without bulk entries before it, the number of a body is the index of its entry
        if number >= 0 and not any(isinstance(body.shape, Bulk) for body in self[:number]):
            return super().__getitem__(index)
        if number < 0:
            raise IndexError(f"Scene: bodies[...] takes an integer >= 0 (-1 is a miss), got {number}")
        hint = "scene.body(number) is the body of a number, bodies[int(index)] an entry"
        raise IndexError(f"Scene: bodies[{number}]: bodies and entries are counted differently; {hint}")

    def index(self, item: Any, start: SupportsIndex = 0, stop: SupportsIndex = 2**62) -> int:
        """Return the index of an entry, which is a `Body`, or of the entry with a name.

        Parameters
        ----------
        item : Body or str
            The entry or its name.
        start, stop : int
            For a `Body`, the range of indices to search, as in `tuple.index`.

        Raises
        ------
        ValueError
            For an unknown body.
        KeyError
            For an unknown name.
        """
        return find_entry(self, item) if isinstance(item, str) else super().index(item, start, stop)

    def __reduce__(self) -> tuple[Any, ...]:
        return Entries, (tuple(self),)


Bodies: TypeAlias = Entries | InstanceList


def as_bodies(items: Any, owner: str = "Scene") -> Bodies:
    """Return shapes and bodies as bodies; one alone stands for a list of it.

    Raise TypeError for anything else, with its index and the `owner` of the message.
    """
    if isinstance(items, Entries | InstanceList):
        return items
    if isinstance(items, (Shape, Body)):
        items = (items,)
    if isinstance(items, (str, bytes, Mapping)) or not isinstance(items, Iterable) or hasattr(items, "bodies"):
        raise TypeError(
            f"{owner}: items must be a list of shapes and Bodies, or one of them, got {describe_kind(items)}"
        )
    bodies = Entries(_as_body(i, item, owner) for i, item in enumerate(items))
    # Many bodies that are one shape moved are kept as one shape and its places
    return collect_instances(bodies) or bodies


def refuse_same_names(bodies: Sequence[Body]) -> None:
    """Raise ValueError if two bodies have the same name."""
    if isinstance(bodies, InstanceList):
        repeated = bodies.repeated_name() if isinstance(bodies, EditedInstances) else None
        if repeated is not None:
            name, first, second = repeated
            raise ValueError(f"Scene: bodies[{first}] and bodies[{second}] are both named {format_value(name)}")
        return
    # A set is quick; only a repeated name needs its places
    listed_names = [body.name for body in bodies if body.name is not None]
    if len(set(listed_names)) == len(listed_names):
        return
    names: dict[str, int] = {}
    for i, body in enumerate(bodies):
        if body.name is not None and names.setdefault(body.name, i) != i:
            raise ValueError(
                f"Scene: bodies[{names[body.name]}] and bodies[{i}] are both named {format_value(body.name)}"
            )


def refuse_unknown_tracks(bodies: Bodies, animation: tuple[Any, ...]) -> None:
    """Raise KeyError for a track of an unknown body."""
    if not animation:
        return
    from .tracks import BodyTrack

    for i, track in enumerate(animation):
        if isinstance(track, BodyTrack):
            try:
                find_entry(bodies, track.body)
            except KeyError as error:
                raise KeyError(f"Scene: animation[{i}]: {error.args[0]}") from None


_MANY_KINDS = 1024
"""From half as many kinds on, each of few bodies, a scene is prepared for its boxes: that is faster."""


def boxes_of(bodies: Bodies, prepared: Callable[[], FloatArray], is_prepared: bool) -> FloatArray:
    """Return boxes around bodies, (n, 6) low and high: one for each body, or some of groups of moved copies.

    Groups without a box reach as far as the others at most.

    They do not depend on whether the scene is prepared: its boxes are those of the shapes to the bit, except those of
    Boolean solids, which always come from it, and those of bulk balls, which never do.

    Parameters
    ----------
    bodies : Bodies
        The bodies.
    prepared : callable
        Prepares the scene, and returns its boxes. It is called only if they are used.
    is_prepared : bool
        Whether the scene is prepared.
    """
    if isinstance(bodies, InstanceList):
        many = is_prepared or len(bodies) < 2 * len(bodies.members) > _MANY_KINDS
        return np.array(bodies.deciding_boxes(prepared()) if many else bodies.boxes, np.float64).reshape(-1, 6)
    if not is_prepared and not any(isinstance(body.shape, Boolean) for body in bodies):
        return np.array([body.shape.bounds for body in bodies], np.float64).reshape(-1, 6)
    boxes = np.array(prepared(), np.float64).reshape(-1, 6)
    if not any(isinstance(body.shape, Spheres) for body in bodies):
        return boxes
    parts, done = [np.zeros((0, 6))], 0
    for body in bodies:
        first, done = done, done + (len(body.shape) if isinstance(body.shape, Bulk) else 1)
        own = np.concatenate(body.shape.bounds)[None] if isinstance(body.shape, Spheres) else boxes[first:done]
        parts.append(own)
    return np.concatenate(parts)


def _as_body(index: int, item: Any, owner: str) -> Body:
    if isinstance(item, Body):
        return item
    if isinstance(item, Shape):
        return Body(item)
    raise TypeError(f"{owner}: items[{index}] must be a shape or a Body, got {describe_kind(item)}")


def find_entry(bodies: Sequence[Body], name: str) -> int:
    """Return the index of the entry with a name. Raise a KeyError with similar names if there is none."""
    if isinstance(bodies, InstanceList):
        number = bodies.number(name)
        if number is not None:
            return number
        bodies = bodies[:_MOST_SUGGESTIONS]
    for entry, body in enumerate(bodies):
        if body.name == name:
            return entry
    names = [body.name for body in bodies if body.name]
    raise KeyError(f"no body named {format_value(name)}; {describe_names(name, 'named bodies', names)}")


def as_index(number: Any) -> int | None:
    """Return a Python or NumPy integer as an int; None for anything else."""
    try:
        # True is an integer in Python, and never meant as a number of a body
        return None if isinstance(number, bool) else operator.index(number)
    except TypeError:
        return None


def find_body(firsts: Any, number: Any, called: str = "body: number") -> tuple[int, int]:
    """Return (entry, index of the body in it) of a body number.

    Parameters
    ----------
    firsts : array (entries + 1,)
        See `first_numbers`.
    number : int
        The body number.
    called : str
        Its name in messages.

    Raises
    ------
    TypeError
        For anything but one integer.
    IndexError
        For a number without a body.
    """
    index = as_index(number)
    if index is None:
        raise TypeError(f"{called} must be one integer, got {format_value(number)}")
    if not 0 <= index < firsts[-1]:
        raise IndexError(f"{called} must be at least 0 and below {firsts[-1]}, got {format_value(index)}")
    entry = int(np.searchsorted(firsts, index, side="right")) - 1
    return entry, index - int(firsts[entry])


def one_entry(bodies: Bodies, firsts: Callable[[], Any], which: Any, owner: str, field: str = "which") -> int:
    """Return the index of an entry by its name or by the number of its body.

    Parameters
    ----------
    bodies : Bodies
        The entries.
    firsts : function
        Returns the `first_numbers` of the bodies.
    which : str or int
        The name or number.
    owner, field : str
        The function and its argument, for messages.

    Raises
    ------
    KeyError, IndexError
        For an unknown name or number.
    TypeError
        For anything else.
    ValueError
        For one of many bodies in an entry.
    """
    if isinstance(which, str):
        return find_entry(bodies, which)
    if as_index(which) is None:
        raise TypeError(
            f"{owner}: {field} must be the name of an entry or the number of its body, got {format_value(which)}"
        )
    entry = find_body(firsts(), which, f"{owner}: {field} number" if field == "which" else f"{owner}: {field}")[0]
    shape = bodies[entry].shape
    if isinstance(shape, Bulk):
        one = "ball" if isinstance(shape, Spheres) else "body"
        raise ValueError(f"{owner}: body {which} is one {one} of an entry of {len(shape):,}; name the entry instead")
    return entry


def exchange_entry(
    bodies: Bodies, firsts: Callable[[], Any], which: Any, item: Any, labels: Mapping[str, Any]
) -> tuple[int, Body, Body]:
    """Return (index of an entry, the entry, its replacement), for `Scene.replace`.

    Parameters
    ----------
    bodies, firsts, which
        As for `one_entry`.
    item : Shape, Body or None
        The replacement; None keeps the shape.
    labels : mapping
        A new material, a new name, or both.
    """
    entry = one_entry(bodies, firsts, which, "replace")
    if not isinstance(item, (Shape, Body)) and not (item is None and labels):
        raise TypeError(f"replace: item must be a shape or a Body, got {describe_kind(item)}")
    old = bodies[entry]
    new = old if item is None else item if isinstance(item, Body) else dataclasses.replace(old, shape=item)
    changes = {"name": new.name or old.name, **labels}
    return entry, old, dataclasses.replace(new, **changes)


def replace_entry(bodies: Bodies, entry: int, old: Body, body: Body) -> Bodies:
    """Return the entries with `body` in place of `old`, which is at index `entry`."""
    if isinstance(bodies, InstanceList):
        edited = InstanceOrigins.of(bodies).with_body(entry, old, body).bodies()
        if edited is not None:
            return edited
    return Entries((*bodies[:entry], body, *bodies[entry + 1 :]))


def insert_entries(bodies: Bodies, place: int, items: Sequence[Body]) -> Bodies:
    """Return the entries with `items` inserted before index `place`."""
    if isinstance(bodies, InstanceList):
        edited = InstanceOrigins.of(bodies).with_more(place, items).bodies()
        if edited is not None:
            return edited
    return Entries((*bodies[:place], *items, *bodies[place:]))


def remove_entries(bodies: Bodies, indices: set[int]) -> Bodies:
    """Return the entries without those at some `indices`."""
    if isinstance(bodies, InstanceList):
        edited = InstanceOrigins.of(bodies).without(sorted(indices)).bodies()
        if edited is not None:
            return edited
    return Entries(body for number, body in enumerate(bodies) if number not in indices)


def share_equal_bodies(old: Bodies, new: Bodies) -> Bodies:
    """Return the `new` bodies with equal `old` ones in their place, so that both scenes share objects.

    Bodies are compared in equal places, from the front and from the back.
    """
    if isinstance(old, InstanceList) or isinstance(new, InstanceList):
        return new
    least = min(len(old), len(new))
    front = next((k for k in range(least) if old[k] != new[k]), least)
    ends = old[::-1], new[::-1]
    back = next((k for k in range(least - front) if ends[0][k] != ends[1][k]), least - front)
    middle = new[front : len(new) - back]
    if len(old) == len(new):
        old_middle = old[front : len(old) - back]
        middle = tuple(before if before == after else after for before, after in zip(old_middle, middle, strict=True))
    return Entries((*old[:front], *middle, *old[len(old) - back :]))


def apply_motion(shape: Shape, motion: Any) -> Shape:
    """Return a shape moved by a `motion` of `Scene.moved`. Raise TypeError for anything that is no motion."""
    if callable(motion):
        result = motion(shape)
        if not isinstance(result, Shape):
            raise TypeError(f"moved: motion must return a shape, got {describe_kind(result)}")
        return result
    if np.shape(motion) == (4, 4):
        return shape.transform(motion)
    if np.shape(motion) != (3,):
        raise TypeError(f"moved: motion must be 3 numbers, a matrix (4, 4) or a function, got {format_value(motion)}")
    return shape.translate(motion)


LENGTH_UNITS = {
    "angstrom": Fraction(1, 10**7), "nm": Fraction(1, 10**6), "um": Fraction(1, 1000), "mm": Fraction(1),
    "cm": Fraction(10), "m": Fraction(1000), "km": Fraction(10**6), "in": Fraction(254, 10),
}  # fmt: skip
"""The unit of a scene's lengths -> its size in mm."""


def as_unit(unit: Any) -> str | None:
    """Return the name of a unit of length, or None, unchanged; raise an error for anything else."""
    return None if unit is None else check_choice("Scene", "unit", unit, LENGTH_UNITS)


def common_unit(unit: str | None, other: str | None) -> str | None:
    """Return the unit of a scene to which bodies of another are added. Raise ValueError for two units."""
    if unit is not None and other is not None and unit != other:
        factor = LENGTH_UNITS[other] / LENGTH_UNITS[unit]
        size = factor if factor.denominator == 1 else float(factor)
        raise ValueError(
            f"added: a scene in {other} does not go into one in {unit}: "
            f"add [dataclasses.replace(body, shape=body.shape.scale({size})) for body in other.bodies]"
        )
    return unit or other


def as_domain(domain: Any) -> Solid | None:
    """Return a solid or None unchanged. Raise TypeError for anything else."""
    if domain is not None and not isinstance(domain, Solid):
        raise TypeError(f"Scene: domain must be a solid or None, got {describe_kind(domain)}")
    return domain
