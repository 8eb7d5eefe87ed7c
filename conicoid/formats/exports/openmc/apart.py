"""Whether two regions surely have nothing in common: sides exclude each other, or importers would see it."""

from __future__ import annotations

from typing import TypeAlias

from ...openmc.narrowing import AnyOf, Conjunction, Part, bound
from ...openmc.region import Region
from .regions import conjuncts, negated
from .surfaces import Table

_SPLITS, _BRANCHES = 3, 8
"""How many unions are looked at, and of how many parts."""
Sides: TypeAlias = tuple[frozenset[Region], list[frozenset[Region]]]


def sides_of(region: Region | None) -> Sides:
    """What a region is within, and, for each of these parts, what the outside of it is within."""
    parts = () if region is None else conjuncts(region)
    return frozenset(parts), [frozenset(conjuncts(negated(part))) for part in parts]


def surely_apart(one: Sides, other: Sides) -> bool:
    """Surely? If one is within something and the other outside of it."""
    return any(out <= other[0] for out in one[1]) or any(out <= one[0] for out in other[1])


def nothing_in_common(first: Region, later: Region, table: Table) -> bool:
    """Surely? Balls, cylinders and planes are compared with one another, as importers do it."""
    return _is_empty([bound(first, table.surfaces), bound(later, table.surfaces)], _SPLITS)


def is_nothing(region: Region, table: Table) -> bool:
    """Has a region surely no volume?"""
    return _is_empty([bound(region, table.surfaces)], _SPLITS)


def _is_empty(parts: list[Part], splits: int) -> bool:
    """Surely? Unions are looked at part by part, so many of them one after the other."""
    found = Conjunction().and_(parts)
    if found is None:
        return True
    unions = sorted((part for part in found.parts if isinstance(part, AnyOf)), key=lambda union: len(union.parts))
    if not unions or splits == 0 or len(unions[0].parts) > _BRANCHES:
        return False
    others = [part for part in found.parts if part is not unions[0]]
    return all(_is_empty([*others, piece], splits - 1) for piece in unions[0].parts)
