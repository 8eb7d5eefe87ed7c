"""From a scene that fails to the smallest one that still does: fewer bodies, operands and motions, one ray."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from .items import Item

Fails = Callable[[Sequence[Item]], bool]


def simpler(item: Item) -> Iterator[Item]:
    """The item with a part of it left out."""
    if item.operands and item.kind != "ClippedSheet":
        for operand in item.operands:
            yield replace(operand, steps=(*operand.steps, *item.steps), paper=None if operand.paper is None and item.paper is None else (*operand.exact_steps, *item.exact_steps))
    if len(item.operands) > 2:
        for k in range(1, len(item.operands)):
            yield replace(item, operands=item.operands[:k] + item.operands[k + 1 :])
    if item.paper is not None:
        yield replace(item, steps=item.paper, paper=None)
    else:
        for k in range(len(item.steps)):
            yield replace(item, steps=item.steps[:k] + item.steps[k + 1 :])
    for k, operand in enumerate(item.operands):
        for other in simpler(operand):
            yield replace(item, operands=item.operands[:k] + (other,) + item.operands[k + 1 :])


def smaller(items: Sequence[Item]) -> Iterator[list[Item]]:
    for k in range(len(items)):
        if len(items) > 1:
            yield [*items[:k], *items[k + 1 :]]
    for k, item in enumerate(items):
        for other in simpler(item):
            yield [*items[:k], other, *items[k + 1 :]]


def shrunk(items: Sequence[Item], fails: Fails) -> list[Item]:
    """The smallest scene found that still fails."""
    found = list(items)
    while True:
        for other in smaller(found):
            if _fails(other, fails):
                found = other
                break
        else:
            return found


def _fails(items: Sequence[Item], fails: Fails) -> Any:
    try:
        return fails(items)
    except (ValueError, TypeError, AssertionError, StopIteration):
        return False
