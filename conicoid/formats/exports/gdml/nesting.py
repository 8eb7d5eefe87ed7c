"""Which bodies lie in which: daughters displace their mother, so a mother is a difference from which they are cut."""

from __future__ import annotations

from dataclasses import dataclass, field

from ....shapes.base import Solid
from ....shapes.region import Difference
from ..bodies import Item


@dataclass
class Nest:
    """A body with those that are placed in it; `outer` is its solid before these are cut from it."""

    number: int
    item: Item
    outer: Solid
    inner: list[Nest] = field(default_factory=list)


def numbers_in(nests: list[Nest]) -> list[int]:
    """The bodies of some nests in the order in which readers find them."""
    found: list[int] = []
    pending = list(reversed(nests))
    while pending:
        nest = pending.pop()
        found.append(nest.number)
        pending += reversed(nest.inner)
    return found


def nests_of(items: list[Item]) -> list[Nest]:
    """All bodies, those within others there; in the order of the scene.

    What importers make of volumes in volumes, ``mother - daughter - daughter``, is taken apart again where each
    daughter is a body that is listed after the mother.
    """
    free: dict[Solid, list[Nest]] = {}
    for number in range(len(items) - 1, -1, -1):
        item = items[number]
        nest = Nest(number, item, item.solid)
        left: list[Solid] = []
        if isinstance(item.solid, Difference) and item.solid.motion.is_identity:
            first, *cut = item.solid.operands
            for solid in cut:
                found = free.get(solid)
                if found:
                    nest.inner.append(found.pop())
                else:
                    left.append(solid)
            if nest.inner:
                nest.outer = Difference((first, *left)) if left else first
        nest.inner.sort(key=lambda inner: inner.number)
        free.setdefault(nest.outer, []).append(nest)
    return sorted((nest for nests in free.values() for nest in nests), key=lambda nest: nest.number)
