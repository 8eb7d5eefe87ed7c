"""Text for people: counts with their nouns, sizes of memory, tables for notebooks, suggestions for unknown names.

`NameTuple` is a tuple of names that numbers and names select from.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache
from itertools import islice
from typing import Any, SupportsIndex, TypeVar

from .validation import format_list, format_value


def format_count(count: int, one: str, many: str = "") -> str:
    """Return a number with its noun: "1 cell", "2,000 bodies".

    `many` is the plural; left out, it is `one` with -s, or with -ies in place of -y.
    """
    many = many or (one[:-1] + "ies" if one.endswith("y") else one + "s")
    return f"{count:,} {one if count == 1 else many}"


def format_bytes(count: int) -> str:
    """Return a number of bytes with three digits and a unit: "12.3 MB"."""
    value, unit = float(count), "bytes"
    for unit in ("bytes", "kB", "MB", "GB"):
        if value < 1000 or unit == "GB":
            break
        value /= 1000
    return f"{value:.3g} {unit}"


MOST_ROWS = 20
"""Rows that a table shows of a longer list."""


def html_table(columns: Sequence[str], rows: Iterable[Sequence[Any]], count: int) -> str:
    """Return the first rows of `count` ones as an HTML table; floats have six digits, vectors stand in brackets."""
    from html import escape

    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(_cell(value))}</td>' for value in row)}</tr>" for row in islice(rows, MOST_ROWS)
    )
    more = f"<p>and {count - MOST_ROWS:,} more</p>" if count > MOST_ROWS else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _cell(value: Any) -> str:
    """Return a value as the text of a cell; None is empty."""
    plain = value.tolist() if hasattr(value, "tolist") else value
    if plain is None:
        return ""
    if isinstance(plain, float):
        return f"{plain:.6g}"
    if isinstance(plain, list | tuple):
        return f"({', '.join(map(_cell, plain))})"
    return str(plain)


# Names: suggestions in errors for an unknown one, and tuples whose items have names.
#
# A name counts as meant if it is similar, or if other programs use the unknown name for the same thing (`ALIASES`).
# docs/coming-from.md has more such pairs.

Name = TypeVar("Name", bound=str)

_MOST_COMPARED = 5000
"""The largest number of names in one comparison, which takes a fraction of a second."""

_LONGEST_NAME = 100
"""Longer names are not compared."""

ALIASES = {
    # Queries
    "intersect": "first_hit", "ray_intersect": "first_hit", "trace": "first_hit", "cast_rays": "first_hit",
    "closest_hit": "first_hit", "intersects_location": "first_hit", "any_hit": "occluded", "is_visible": "occluded",
    "ray_test": "occluded", "inside": "contains", "is_inside": "contains", "find_cell": "body_at",
    "signed_distance": "distance", "path_lengths": "lengths", "bbox": "bounds", "aabb": "bounds",
    # Results and rays
    "distance": "t t_max", "distances": "t", "points": "point", "normals": "normal", "ids": "body",
    "primitive_ids": "face", "mask": "hit", "origin": "origins", "direction": "directions",
    "center_of_mass": "centroid",
    # Shapes and materials
    "ball": "Sphere", "cuboid": "Box", "disk": "Disc", "frustum": "Cone", "halfspace": "HalfSpace", "tetrahedron":
    "Polyhedron", "paraboloid": "EllipticParaboloid", "dielectric": "glass", "lambertian": "matte",
    # Arguments
    "ior": "refractive_index", "colour": "color material", "color": "material", "rgb": "color", "fov": "field_of_view",
    "eye": "position",
    "target": "look_at", "spp": "samples", "max_depth": "depth", "r": "radius", "min": "low", "max": "high",
    "centre": "center", "origin_point": "center", "p1": "start", "p2": "end", "tmin": "t_min", "tmax": "t_max",
}  # fmt: skip
"""Name in other programs, in small letters -> the name here, or several; the first known one counts."""


def known_alias(name: str, known: Collection[str]) -> str:
    """Return the known name that other programs call `name`; "" if there is none."""
    return next((meant for meant in ALIASES.get(name.casefold(), "").split() if meant in known), "")


def closest_name(name: str, known: Collection[str], least: float = 0.6) -> str:
    """Return the known name that was probably meant, by `ALIASES` or by similarity; "" if there is none.

    Parameters
    ----------
    name : str
        The unknown name.
    known : collection of str
        The names that would be accepted.
    least : float
        The share of letters that a similar name has in common with it, as `difflib` counts them.
    """
    import difflib

    if alias := known_alias(name, known):
        return alias
    names = {item.casefold(): item for item in known if len(item) <= _LONGEST_NAME}
    close = difflib.get_close_matches(name.casefold()[:_LONGEST_NAME], names, n=1, cutoff=least)
    return names[close[0]] if close else ""


def near_name(name: object, known: Collection[str]) -> str:
    """Return the name that was probably meant in brackets, as the end of a message; "" if there is none."""
    close = closest_name(name, known) if isinstance(name, str) else ""
    return f" (did you mean {close!r}?)" if close else ""


def suggest_name(name: str, known: Collection[str]) -> str:
    """Return a suggestion in brackets, or the list of known names if that is short; else ""."""
    if near := near_name(name, known):
        return near
    names = [item for item in known if len(item) <= _LONGEST_NAME]
    return f" (known: {', '.join(sorted(names))})" if 0 < len(names) <= 16 else ""


def check_choice(owner: str, field: str, value: Any, known: Collection[Name]) -> Name:
    """Return a value that is one of the known names; otherwise raise ValueError with a list and a suggestion."""
    if isinstance(value, str):
        for name in known:
            if value == name:
                return name
    found = f"{format_value(value)}{near_name(value, known)}"
    raise ValueError(f"{owner}: {field} must be one of {', '.join(known)}, got {found}")


def describe_names(name: object, what: str, known: Sequence[str]) -> str:
    """Return a description of known names for an unknown one: those that contain it, or the first and the most similar.

    what: the noun for them, such as "materials".
    """
    if not known:
        return f"{what}: none has a name"
    folded = name.casefold() if isinstance(name, str) else ""
    if folded and (holding := [repr(item) for item in known if folded in item.casefold()]):
        return f"{what} with it in their names: {format_list(holding)}"
    return f"{what}: {format_list([repr(item) for item in known])}{near_name(name, known[:_MOST_COMPARED])}"


def unknown_attribute(thing: object, name: str) -> AttributeError:
    """Return the error for an attribute that an object does not have; for its `__getattr__`.

    Where the class has the attribute, its code raised an AttributeError, which Python hands to `__getattr__` without
    the error: the attribute is read again, so that the error itself appears.
    """
    kind: Any = type(thing)
    if any(name in vars(base) for base in kind.__mro__):
        object.__getattribute__(thing, name)
    hint = "" if name.startswith("_") else _attribute_hint(kind, name)
    return AttributeError(f"{kind.__name__!r} object has no attribute {name[:80]!r}{hint}", name=name, obj=thing)


@lru_cache(256)
def _attribute_hint(kind: type, name: str) -> str:
    """Return the hint at an attribute of a class; kept, as bounds test each part of a Boolean by `hasattr`."""
    close = closest_name(name, [field for field in dir(kind) if not field.startswith("_")], 0.75)
    return f": did you mean {close}?" if close else ""


def unknown_package_name(package: str, name: str, known: Collection[str]) -> AttributeError:
    """Return the error for a name that a package does not have; for its `__getattr__`."""
    close = "" if name.startswith("_") else closest_name(name, known, 0.7)
    hint = f" (did you mean {close}?)" if close else ""
    return AttributeError(f"module {package!r} has no attribute {name[:80]!r}{hint}", name=name)


# --- Tuples whose items have names, such as the materials of a scene


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
