"""How many bodies universes and lattices have, counted from the innermost outward before anything is expanded."""

from __future__ import annotations

from collections import Counter

from .geometry import Cell, Node, fillings
from .lattices import Lattice

Inside = dict[Node, Counter[Node]]


def links(universes: dict[int, list[Cell]], lattices: dict[int, Lattice]) -> Inside:
    """What fills each universe and lattice, and how often; what does not exist is passed over."""
    inside: Inside = {}
    for number, cells in universes.items():
        counts: Counter[Node] = Counter()
        inside["universe", number] = counts
        for cell in cells:
            if cell.fill is not None:
                node = ("universe" if cell.fill in universes else "lattice", cell.fill)
                counts[node] += node[0] == "universe" or cell.fill in lattices
    for number, lattice in lattices.items():
        filled = fillings(lattice)
        inside["lattice", number] = Counter({("universe", u): times for u, times in filled.items() if u in universes})
    return {node: +counts for node, counts in inside.items()}


def in_order(inside: Inside) -> list[Node]:
    """The nodes, each after those that fill it, without recursion; those in circles, and around them, are missing."""
    users: dict[Node, list[Node]] = {}
    for node, fills in inside.items():
        for fill in fills:
            users.setdefault(fill, []).append(node)
    waiting = {node: len(fills) for node, fills in inside.items()}
    ready = [node for node, count in waiting.items() if not count]
    order = []
    while ready:
        node = ready.pop()
        order.append(node)
        for user in users.get(node, ()):
            waiting[user] -= 1
            if not waiting[user]:
                ready.append(user)
    return order


def bodies(universes: dict[int, list[Cell]], inside: Inside, order: list[Node]) -> dict[Node, int]:
    """How many bodies each node has, if all are filled as the file says."""
    counts: dict[Node, int] = {}
    for node in order:
        own = sum(cell.fill is None for cell in universes[node[1]]) if node[0] == "universe" else 0
        counts[node] = own + sum(times * counts[fill] for fill, times in inside[node].items())
    return counts


def depth(inside: Inside, order: list[Node]) -> int:
    """Levels of universes within universes."""
    depths: dict[Node, int] = {}
    for node in order:
        below = max((depths[fill] for fill in inside[node]), default=0)
        depths[node] = below + (node[0] == "universe")
    return max(depths.values(), default=0)


def circle(inside: Inside, order: list[Node]) -> str:
    """One way round: universe 1 → universe 2 → universe 1; empty if there is none."""
    left = set(inside) - set(order)
    if not left:
        return ""
    node = min(left, key=lambda item: (item[0] != "universe", item[1]))
    way: dict[Node, None] = {}
    while node not in way:
        way[node] = None
        node = min(fill for fill in inside[node] if fill in left)
    ring = [*list(way)[list(way).index(node) :], node]
    shown = ring if len(ring) <= 20 else ring[:20]
    return " → ".join(f"{kind} {number}" for kind, number in shown) + ("" if shown is ring else " → ...")
