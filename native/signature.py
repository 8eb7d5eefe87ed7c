"""Arguments and results of a kernel, from its annotations and its shapes (`conicoid._jit.decorators`).

An argument is a leaf, or a record (a tuple) of them. A signature lists leaves and brackets in the order in which both
Numba and the door flatten them.
"""

from __future__ import annotations

import re
import typing
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from conicoid.kernels.tables import Geometry, Tables

MOST_ARRAYS, MOST_SLOTS, MOST_NAMES = 64, 512, 16
"""Limits of one kernel: the door (native/door.c) has room for so many."""
TABLES = {name: number for number, name in enumerate(Tables._fields)}


@dataclass(frozen=True)
class Length:
    """A number of the form constant + sum of times * name; `other` is another length that is allowed."""

    constant: int
    names: tuple[tuple[str, int], ...] = ()
    other: Length | None = None


@dataclass(frozen=True)
class Leaf:
    """One argument, or field of a record, of a kernel; "(" and ")" stand around a record's."""

    name: str
    kind: str  # "array", "int", "float", "bool", "none", "(", ")"
    dtype: Any = None
    written: bool = False
    lengths: tuple[Length | None, ...] = ()  # of an array, None for any; of an int its limits
    divides: bool = False  # of an int: -1, 0 or a divisor of the second limit
    record: Any = None
    strided: bool = False  # of an array: its elements may lie apart


@dataclass(frozen=True)
class Signature:
    """A kernel by the name of its entry point."""

    name: str
    function: Callable[..., Any]
    leaves: list[Leaf] = field(default_factory=list)
    result: str = ""  # a letter for each number: "d", "q"; "" for nothing; "A" for an array (n, m) of floats


_TERM = re.compile(r"([+-]?)(?:(\d+)\*)?([a-z_]+)|([+-]?)(\d+)")


def _sum(text: str) -> Length:
    """Return a sum of terms."""
    constant, names, at = 0, [], 0
    while at < len(text):
        found = _TERM.match(text, at)
        if found is None:
            raise ValueError(f"no length: {text!r}")
        if found[3]:
            names.append((found[3], int(found[1] + (found[2] or "1"))))
        else:
            constant += int(found[4] + found[5])
        at = found.end()
    if len(names) > 2:
        raise ValueError(f"a length is a sum of at most two names: {text!r}")
    return Length(constant, tuple(names))


def _length(text: str) -> Length | None:
    """Return a length, or None for any."""
    if text == "*":
        return None
    first, _, second = text.partition("|")
    found = _sum(first)
    return Length(found.constant, found.names, _sum(second)) if second else found


def _array(name: str, dtype: np.dtype[Any], shape: str, written: bool) -> Leaf:
    words = shape.split()
    strided = words[:1] == ["strided"]
    if words[:1] == ["out"]:
        written = True
    if strided or words[:1] == ["out"]:
        words = words[1:]
    if not words:
        raise ValueError(f"{name}: an array needs a shape")
    return Leaf(name, "array", dtype, written, tuple(map(_length, words)), strided=strided)


def _int(name: str, limits: str) -> Leaf:
    if limits.startswith("picture "):
        return Leaf(name, "int", lengths=(None, _sum(limits.split()[1])), divides=True)
    low, _, high = limits.partition("..") if limits else ("", "", "")
    return Leaf(name, "int", lengths=(_sum(low) if low else None, _sum(high) if high else None))


def _scalar_type(array: Any) -> type[Any]:
    """Return the NumPy type in `NDArray[...]`."""
    for argument in typing.get_args(array):
        if isinstance(argument, type) and issubclass(argument, np.generic):
            return argument
        found = _scalar_type(argument)
        if found is not None:
            return found
    return typing.cast(Any, None)


def _leaves(name: str, kind: Any, shape: str, written: bool, known: Mapping[str, Any]) -> Iterator[Leaf]:
    """Return the leaves of a parameter or field. `known` are types of fields that the record itself leaves open."""
    extra: tuple[Any, ...] = ()
    if typing.get_origin(kind) is Annotated:
        kind, *rest = typing.get_args(kind)
        extra = tuple(rest)
    if kind is None or kind is type(None):
        yield Leaf(name, "none")
    elif kind is bool or kind is float:
        yield Leaf(name, kind.__name__)
    elif kind is int:
        yield _int(name, shape)
    elif typing.get_origin(kind) is np.ndarray:
        dtypes = [each for each in extra if isinstance(each, np.dtype)]
        yield _array(name, dtypes[0] if dtypes else np.dtype(_scalar_type(kind)), shape, written)
    elif typing.get_origin(kind) is tuple:
        parts = typing.get_args(kind)
        yield Leaf(name, "(", lengths=(Length(len(parts)),))
        for number, part in enumerate(parts):
            yield from _leaves(f"{name}[{number}]", part, "", written, {})
        yield Leaf(name, ")")
    elif hasattr(kind, "_fields"):
        known = next((each for each in extra if isinstance(each, dict)), {})
        hints, shapes = typing.get_type_hints(kind, include_extras=True), getattr(kind, "__shapes__", {})
        yield Leaf(name, "(", lengths=(Length(len(kind._fields)),), record=kind)
        for part in kind._fields:
            inner = known.get(part, hints[part])
            yield from _leaves(f"{name}.{part}", inner, shapes.get(part, ""), written or shape == "out", known)
        yield Leaf(name, ")", record=kind)
    else:
        raise TypeError(f"{name}: {kind} is no type of a kernel's argument")


_LETTERS = {int: "q", float: "d", type(None): ""}


def _result(kind: Any) -> str:
    if typing.get_origin(kind) is np.ndarray:
        return "A"
    if typing.get_origin(kind) is tuple:
        return "".join(_LETTERS[part] for part in typing.get_args(kind))
    return _LETTERS[kind]


def signature(function: Callable[..., Any], shapes: Mapping[str, str]) -> Signature:
    """Return the signature of a function under `kernel(**shapes)`. TypeError or ValueError if these are incomplete."""
    hints = typing.get_type_hints(function, include_extras=True)
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    unknown = shapes.keys() - set(names)
    if unknown:
        raise ValueError(f"{function.__name__}: there is no parameter {', '.join(sorted(unknown))}")
    leaves: list[Leaf] = []
    for name in names:
        leaves += _leaves(name, hints[name], shapes.get(name, ""), False, {})
    _check(function.__name__, leaves)
    return Signature(function.__name__, function, leaves, _result(hints["return"]))


def names_in(leaves: list[Leaf]) -> set[str]:
    """Return the names that lengths and limits refer to."""
    sums = [length for leaf in leaves for length in leaf.lengths if length is not None]
    sums += [length.other for length in sums if length.other is not None]
    return {name for each in sums for name, _ in each.names}


def _names_with_values(leaves: list[Leaf]) -> set[str]:
    """Return the names that get a value from an argument: whole numbers, and lengths like `n` or `8*n`."""
    arrays = [length for leaf in leaves if leaf.kind == "array" for length in leaf.lengths if length is not None]
    lone = {each.names[0][0] for each in arrays if len(each.names) == 1 and not each.constant and each.other is None}
    return lone | {leaf.name for leaf in leaves if leaf.kind == "int"}


def _check(name: str, leaves: list[Leaf]) -> None:
    """ValueError where the door could not test a call: its room is limited, and names need values."""
    names, arrays = names_in(leaves), [leaf for leaf in leaves if leaf.kind == "array"]
    numbers = sum(leaf.kind in ("int", "float", "bool", "none") for leaf in leaves)
    slots = numbers + sum(5 + 2 * len(leaf.lengths) for leaf in arrays)
    if any(len(leaf.lengths) > 3 for leaf in arrays):
        raise ValueError(f"{name}: arrays have at most 3 dimensions")
    if len(arrays) > MOST_ARRAYS or slots > MOST_SLOTS or len(names - TABLES.keys()) > MOST_NAMES:
        raise ValueError(f"{name}: at most {MOST_ARRAYS} arrays, {MOST_SLOTS} slots and {MOST_NAMES} names are tested")
    tables = names & TABLES.keys()
    missing = names - tables - _names_with_values(leaves) | (set() if any(map(is_geometry, leaves)) else tables)
    if missing:
        raise ValueError(f"{name}: no argument gives {', '.join(sorted(missing))}")


def is_geometry(leaf: Leaf) -> bool:
    """Return whether a geometry begins here."""
    return leaf.kind == "(" and leaf.record is Geometry


def modules_with_kernels() -> list[str]:
    """Return the modules of the package with entry points, by their text: some others need packages of extras."""
    import conicoid

    package = Path(conicoid.__file__).parent
    found = []
    for path in sorted(package.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "_jit.decorators import" in text and re.search(r"\bkernel\(", text):
            found.append(".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__"))
    return found


def declared() -> list[Signature]:
    """Return the signatures of all kernels, in order of their names."""
    import importlib

    from conicoid._jit.decorators import DECLARED
    from conicoid.render.integrators import INTEGRATORS
    from conicoid.render.tiles import tile_kernel

    for name in modules_with_kernels():
        importlib.import_module(name)
    for name in INTEGRATORS:
        tile_kernel(name)
    return [signature(*DECLARED[name]) for name in sorted(DECLARED)]


def on_device() -> dict[str, list[Signature]]:
    """Return the signatures of the functions of a GPU's threads, in parts that compile separately.

    Queries are functions that are no kernels of the extension, then kernels.
    """
    import importlib

    from conicoid._jit.decorators import DECLARED
    from conicoid.kernels.device import FUNCTIONS, ROWS
    from conicoid.render.device_pictures import PICTURES

    for module in ROWS.values():
        importlib.import_module(f"conicoid.queries.{module}")
    queries = [*(signature(*each) for each in FUNCTIONS.items()), *(signature(*DECLARED[name]) for name in ROWS)]
    return {"queries": queries, "pictures": [signature(*each) for each in PICTURES.items()]}
