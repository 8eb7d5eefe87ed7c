"""Cells after those that their regions refer to by '#n'."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise


def in_order(regions: Mapping[int, list[str]]) -> tuple[list[int], list[int]]:
    """All cells but those that refer to themselves, and these; the others in an order without forward references."""
    needs = {number: _complements(words) & regions.keys() for number, words in regions.items()}
    users: dict[int, list[int]] = {}
    for user, others in needs.items():
        for other in others:
            users.setdefault(other, []).append(user)
    waiting = {number: len(others) for number, others in needs.items()}
    ready = [number for number in reversed([*regions]) if not waiting[number]]
    order = []
    while ready:
        number = ready.pop()
        order.append(number)
        for user in users.get(number, ()):
            waiting[user] -= 1
            if not waiting[user]:
                ready.append(user)
    done = set(order)
    return order, [number for number in regions if number not in done]


def _complements(words: list[str]) -> set[int]:
    pairs = pairwise(words)
    return {int(then) for word, then in pairs if word == "#" and then.isdecimal() and len(then) < 16}
