"""An explanation in words: which blocks are told, in which order."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from . import sources
from .blocks import Block, Heading, Line, Table
from .numbers import rounded, told, vector
from .steps import Crossing, Place
from .telling_bodies import body_blocks

if TYPE_CHECKING:
    from .explanation import Explanation

_MOST_ROWS, _MOST_BODIES = 60, 12
_HOW = {
    "certified": "numbers in two floats that carry their error bounds",
    "exact": "exact arithmetic, since error bounds left it open",
}


def blocks_of(found: Explanation) -> Iterator[Block]:
    """The ray, the answer, what decided it, every body, and all that is along the ray."""
    yield Heading("The ray")
    yield Line(f"p(t) = o + t d,  o = {vector(found.origin)},  d = {vector(found.direction)}")
    yield Line(f"asked for {told(found.t_min)} < t < {told(found.t_max)}, t in units of |d|{_length(found)}")
    yield Heading("The answer")
    yield from _answer(found)
    yield from _decision(found)
    whole = _told_whole(found)
    for step in found.bodies:
        if step.body in whole:
            yield from body_blocks(step, found)
    if len(whole) < len(found.bodies):
        yield Heading("Other bodies", 2)
        yield Line("in short; `body=` names one that is to be told whole")
        rows = tuple((_name(found, step.body), step.told) for step in found.bodies if step.body not in whole)
        yield Table(("body", "what happens"), rows)
    if found.missed:
        yield Heading("Left out", 2)
        yield Line(f"the tree of boxes leaves out {found.missed:,} more bodies: the ray misses the boxes around them")
    if len(found.crossings) > 1:
        yield Heading("Along the ray")
        yield _along(found)


def _told_whole(found: Explanation) -> set[int]:
    """The bodies whose working is told: all, or of many those that are met first, and then those that are not."""
    first = {one.body: one.t for one in reversed(found.crossings)}
    order = sorted(found.bodies, key=lambda step: (step.body != int(found.hit.body), first.get(step.body, math.inf)))
    return {step.body for step in order[:_MOST_BODIES]}


def _length(found: Explanation) -> str:
    from .line import Line as Ray

    square = Ray.of(found.origin, found.direction, 0.0, 1.0).square
    return "" if square == 1 else f" (d·d = {rounded(square)})"


def _answer(found: Explanation) -> Iterator[Block]:
    """The first hit, with its point and normal."""
    hit = found.hit
    if not hit.hit:
        yield Line("nothing is hit: t = ∞")
        return
    verb = "enters" if hit.entering else "leaves"
    name = _name(found, int(hit.body))
    yield Line(f"{verb} {name} at t = {told(float(hit.t))}, face {hit.face}, surface {hit.surface}")
    yield Line(f"point o + t d = {vector(hit.point.tolist())}")
    yield from _normal(found)


def _normal(found: Explanation) -> Iterator[Block]:
    hit, step = found.hit, found.surfaces.get(int(found.hit.surface))
    normal = vector(hit.normal.tolist())
    if step is None or step.flat:
        yield Line(f"outward normal {normal}")
        return
    from .line import Line as Ray

    ray = Ray.of(found.origin, found.direction, found.t_min, found.t_max)
    half = step.polynomial.half_gradient(ray.at(float(hit.t)))
    if step.kind == "sphere":
        yield Line(f"outward normal (p − S) / r = {normal}", sources.SPHERE_ALGEBRAIC)
    else:
        gradient = f"half the gradient (Ax + By + Cz + D, Bx + Ey + Fz + G, Cx + Fy + Hz + I) = {vector(half)}"
        yield Line(gradient, sources.NORMAL)
        yield Line(f"made unit and outward {normal}")


def _name(found: Explanation, number: int) -> str:
    for step in found.bodies:
        if step.body == number:
            return f"body {number} “{step.name}”"
    return f"body {number}"


def _decision(found: Explanation) -> Iterator[Block]:
    """Which formulas decided, with what bound; of a doubtful ray the order of all crossings."""
    decision = found.decision
    bound = f": |t − t*| ≤ {decision.t_error:.2e}" if decision.t_error else ": t is exact"
    bound = bound if found.hit.hit else ""
    if decision.first == "floats":
        yield Line(f"decided by the float formulas, which their error bounds leave no doubt of{bound}", sources.DOUBT)
    else:
        yield Line(f"the float formulas leave it in doubt; decided by {_HOW[decision.first]}{bound}", sources.DOUBT)
    if decision.all != decision.first:
        yield Line(f"what comes after it is in doubt; decided by {_HOW[decision.all]}", sources.DOUBT)
    if decision.places:
        rows = tuple(_place(place, found) for place in decision.places[:_MOST_ROWS])
        yield Table(("order", "surface", "certainly at", "± at most", "told as t"), rows, sources.DOUBT)


def _place(place: Place, found: Explanation) -> tuple[str, ...]:
    low = f" {'+' if place.low >= 0 else '−'} {abs(place.low):.3g}" if place.low else ""
    certain = f"{told(place.high)}{low}"
    return str(place.rank), f"surface {place.surface}", certain, f"{place.error:.1e}", told(place.t)


def _along(found: Explanation) -> Table:
    rows = tuple(_crossing(one, found) for one in found.crossings[:_MOST_ROWS])
    return Table(("t", "± at most", "body", "", "face", "surface"), rows, sources.DOUBT)


def _crossing(one: Crossing, found: Explanation) -> tuple[str, ...]:
    enters = "enters" if one.entering else "leaves"
    return told(one.t), f"{one.t_error:.1e}", _name(found, one.body), enters, str(one.face), str(one.surface)
