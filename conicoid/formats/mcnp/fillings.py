"""What fills a cell: a universe, or the universes of a lattice, each with a transformation of its own perhaps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from .cell_cards import CellCard
from .numbers import MOST, entries, integer
from .transformations import Change, change_of

Entry = tuple[int, Change | None]


@dataclass(frozen=True)
class Filling:
    """Entries in the order of `ranges`; without ranges one that fills everything."""

    entries: tuple[Entry, ...]
    ranges: tuple[tuple[int, int], ...] = ()


def change_from(words: list[str], degrees: bool, changes: Mapping[int, Change]) -> Change:
    """A number of a TR card, or a transformation written out. Raises ValueError."""
    values = entries(words)
    if len(values) != 1:
        return change_of(values, degrees)
    key = integer("a transformation", values[0] if values[0] is not None else "j")
    if not key:
        return Change()
    if key not in changes:
        raise ValueError(f"the transformation tr{key} is not in the data block")
    return changes[key]


def trcl_of(cell: CellCard, changes: Mapping[int, Change]) -> Change | None:
    """How a cell is moved. Raises ValueError."""
    given = cell.words("trcl")
    if given is None:
        return None
    words, degrees = given
    inner = words[1:-1] if words[:1] == ["("] and words[-1:] == [")"] else words
    if not inner or "(" in inner or ")" in inner:
        raise ValueError("trcl must be a number of a TR card, or numbers in parentheses")
    return change_from(inner, degrees, changes)


def filling_of(cell: CellCard, changes: Mapping[int, Change]) -> Filling | None:
    """What fills a cell. Raises ValueError."""
    given = cell.words("fill")
    if given is None:
        return None
    words, degrees = given
    read = lambda inner: change_from(inner, degrees, changes)  # noqa: E731
    if ":" not in words:
        found = _entries(words, read)
        if len(found) != 1:
            raise ValueError(
                f"fill must be one universe, or ranges such as 0:2 0:2 0:0 with universes, got {len(found)}"
            )
        return None if not found[0][0] else Filling(tuple(found))
    ranges = []
    for axis in range(3):
        part = words[3 * axis : 3 * axis + 3]
        if len(part) < 3 or part[1] != ":":
            raise ValueError("fill: needs three ranges, such as 0:2 0:2 0:0")
        low, high = integer("fill: a range", part[0]), integer("fill: a range", part[2])
        if low > high:
            raise ValueError(f"fill: the range {low}:{high} is empty")
        ranges.append((low, high))
    count = math.prod(high - low + 1 for low, high in ranges)
    if count > MOST:
        raise ValueError(f"fill: {count:,} elements, at most {MOST:,} are read")
    found = _entries(words[9:], read)
    if len(found) != count:
        raise ValueError(f"fill: the ranges hold {count:,} universes, got {len(found):,}")
    return Filling(tuple(found), tuple(ranges))


def _entries(words: list[str], read: Callable[[list[str]], Change]) -> list[Entry]:
    """Universes, each with a transformation in parentheses after it perhaps."""
    found: list[Entry] = []
    plain: list[str] = []

    def flush() -> None:
        before = [found[-1][0]] if found else []
        values = entries([*map(str, before), *plain])[len(before) :]
        found.extend((abs(integer("fill: a universe", _value(value))), None) for value in values)
        plain.clear()

    at = 0
    while at < len(words):
        if words[at] != "(":
            plain.append(words[at])
            at += 1
            continue
        if ")" not in words[at:]:
            raise ValueError("fill: a ')' is missing")
        end = words.index(")", at)
        flush()
        if not found:
            raise ValueError("fill: a transformation needs a universe before it")
        found[-1] = found[-1][0], read(words[at + 1 : end])
        at = end + 1
    flush()
    if len(found) > MOST:
        raise ValueError(f"fill: has more than {MOST:,} universes")
    return found


def _value(value: Fraction | None) -> Fraction:
    if value is None:
        raise ValueError("fill: jumps over a universe (nJ)")
    return value
