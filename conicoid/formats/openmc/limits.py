"""What refuses geometries that would not fit into memory or never be done, in the words of the user's limit."""

from __future__ import annotations

import os

from ...shapes.labels import counted, with_bytes
from ..errors import Problem, SceneFileError
from .geometry import Cell, Geometry
from .lattices import Lattice
from .xml_tree import Element

BYTES_PER_PLACE, BYTES_PER_BODY = 600, 4_000
"""Memory that a body takes while a scene is made ready to trace, if it is another one moved, and if it is not.

Measured on cores of many assemblies of pins.
"""
PLACES_FOR_A_BODY = 1
"""Places outside of lattices that are looked at, most of them in vain perhaps, for each body that is allowed."""
STEPS_FOR_A_BODY, FEWEST_STEPS = 20, 50_000
"""Comparisons of sides for each body that is allowed, and at least so many. Where it is not another one moved, a pin
takes about 20, by hexagons 150."""


def too_many(
    path: str | os.PathLike[str], count: int, max_bodies: int, element: Element, where: str = "", bound: str = ""
) -> SceneFileError:
    """Refuses what expands into `bound` (such as "up to") `count` bodies, with the place where most of them are."""
    most = f", most of them through {where}" if where else ""
    message = (
        f"expands into {bound}{_bodies(count)}, {_size(count)}{most}; the limit is {max_bodies:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def too_many_alone(path: str | os.PathLike[str], count: int, most: int, cell: Cell) -> SceneFileError:
    """Refuses bodies that are worked out one by one."""
    element, size = cell.element, with_bytes(count * BYTES_PER_BODY)
    message = (
        f"has at least {_bodies(count)} that are no others moved, {size} in memory; the limit is {most:,} "
        "(max_bodies): raise it where there is memory for them, or import a part of the geometry"
    )
    return SceneFileError(path, [Problem(element.line, element.column, "geometry", message)])


def too_long(path: str | os.PathLike[str], cell: Cell, max_bodies: int) -> SceneFileError:
    """Refuses what has too many sides at too many places."""
    element = cell.element
    message = (
        "stands in regions of so many half-spaces, at so many places, that to compare them takes over "
        f"{steps(max_bodies):,} steps: raise the limit (max_bodies), or write simpler regions"
    )
    return SceneFileError(path, [Problem(element.line, element.column, str(cell), message)])


def steps(max_bodies: int) -> int:
    """How many comparisons are allowed."""
    return max(STEPS_FOR_A_BODY * max_bodies, FEWEST_STEPS)


def check_count(path: str | os.PathLike[str], geometry: Geometry, max_bodies: int) -> None:
    """Raises SceneFileError where there are too many bodies, before any is made."""
    count = geometry.body_count
    if count <= max_bodies:
        return
    most = geometry.where_most_are(max_bodies)
    where = ""
    if isinstance(most, Lattice):
        where = f"{most} of {most.size:,} elements"
    elif most is not None:
        where = f"{most}, which is filled with {_bodies(geometry.count_in(most))}"
    raise too_many(path, count, max_bodies, geometry.element if most is None else most.element, where)


def _bodies(count: int) -> str:
    """1,234,567 bodies, or a power of ten where that would be longer than a line."""
    return counted(count, "body", "bodies") if count < 10**66 else f"about 1e{len(str(count)) - 1} bodies"


def _size(count: int) -> str:
    if count > 10**66:
        return "more than any memory holds"
    return f"at least {with_bytes(count * BYTES_PER_PLACE)} in memory"
