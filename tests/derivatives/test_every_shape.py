"""Derivatives of hits by every number of every shape, against differences in 50 digits of formulas of their own."""

from __future__ import annotations

import re
import zlib
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.bulk import Bulk

from ..contract.examples import MOTIONS, every_example
from ..samples import sampled
from . import outlines, plain
from .plain import mp
from .test_by_differences import BY_NUMBERS

EXAMPLES = {name: shape for name, shape in every_example() if name.split("-")[0] not in BY_NUMBERS}
CLOSE, STEEP = 1e-10, 0.05
STEP = mp.mpf(10) ** -18


def rays_at(shape: Any, count: int, seed: int) -> tuple[Any, Any]:
    """Rays through the part of a shape that is near its middle."""
    random = np.random.default_rng(seed)
    low, high = (np.clip(end, -4, 4) for end in shape.bounds)
    inside = random.uniform(low - 0.1, high + 0.1, (count, 3))
    directions = random.normal(size=(count, 3)) * random.uniform(0.5, 2, (count, 1))
    return inside - directions * random.uniform(2, 6, (count, 1)), directions


def told(shape: Any, names: list[str], values: Any) -> Any:
    """The shape read anew with other numbers; a body of many is told by its own."""
    read = plain.read(shape)
    for name, value in zip(names, values, strict=True):
        plain.put(read, name, value)
    return read


def of_one(shape: Bulk, body: int, name: str) -> Any:
    """The field of a single body that a number of many is, or None; motions are of all."""
    way = plain.parts(name)
    if way[0] == "motion":
        return name
    if way[1] != body:
        return None
    columns = {"starts": "start", "ends": "end", "centers": "center", "normals": "normal", "lows": "low", "highs": "high",
               "start_radii": "start_radius", "end_radii": "end_radius"}  # fmt: skip
    if way[0] == "radii":
        field = "radii" if type(shape).__name__ == "Ellipsoids" else "radius"
    else:
        field = columns.get(way[0], way[0])
    return field + "".join(f"[{part}]" for part in way[2:])


def wrong(shape: Any, count: int, seed: int) -> tuple[float, int]:
    """(the largest error of derivatives, how many hits were compared); each hit by one number and by its ray."""
    scene = co.Scene([co.Body(shape, name="it")])
    parameters = co.parameters(scene)
    o, d = rays_at(shape, 40 * count, seed)
    hits = scene.first_hit(o, d)
    random = np.random.default_rng(seed)
    do, dd = random.normal(size=(2, *o.shape))
    cosine = np.abs((hits.normal * d).sum(axis=1)) / np.sqrt((d * d).sum(axis=1))
    chosen = np.flatnonzero(hits.hit & (cosine > STEEP))[:count]
    worst, names = 0.0, parameters.names
    for which in range(len(names)):
        mine = [i for turn, i in enumerate(chosen.tolist()) if (turn + seed) % len(names) == which]
        if not mine:
            continue
        tangent = np.eye(len(names))[which]
        found = hits[mine].jvp(parameters, tangent, d_origins=do[mine], d_directions=dd[mine])
        for k, i in enumerate(mine):
            expected = differences(shape, hits[i], names[which], (o[i], d[i], do[i], dd[i]))
            own = [field[k] for field in (found.t, found.point, found.normal, found.uv)]
            worst = max(worst, largest_error(shape, hits[i], names[which], own, expected or ()))
    return worst, len(chosen)


def largest_error(shape: Any, hit: Any, name: str, found: Any, expected: Any) -> float:
    """The largest error of t, point, normal and uv, beside 1 or what is expected."""
    worst = 0.0
    for own, true in zip(found, expected, strict=False):
        if true is None or (np.isnan(own).any() and is_open(shape, hit, name, own)):
            continue
        true = np.array(true, np.float64)
        assert np.isfinite(own).all(), (name, own, true)
        worst = max(worst, float(np.max(np.abs(own - true) / (1 + np.abs(true)))))
    return worst


def is_open(shape: Any, hit: Any, name: str, own: Any) -> bool:
    """Is there no derivative, as docs/derivatives.md says: of uv by what tilts an axis along which two are least?

    And of anything by an angle of a wedge of half a turn, and of uv by numbers that are the largest together.
    """
    if isinstance(shape, Bulk):
        shape = shape.single(int(hit.body))
    if getattr(shape, "end_angle", 360) - getattr(shape, "start_angle", 0) == 180 and "angle" in name:
        return int(hit.face) == (len(shape.profile) if isinstance(shape, co.Revolution) else 3)
    if isinstance(shape, co.Revolution) and hit.face >= len(shape.profile) and "profile" in name:
        return np.shape(own) == (2,) and largest_together(shape, *map(int, re.findall(r"\d+", name)))
    if isinstance(shape, co.Revolution) and hit.face < len(shape.profile) and re.search(r"profile\[\d\]\[1\]", name):
        ends = shape.profile[int(hit.face)], shape.profile[(int(hit.face) + 1) % len(shape.profile)]
        return ends[0][1] == ends[1][1]  # a plane, which becomes a cone
    if isinstance(shape, co.Lens) and shape.thickness == shape.diameter:
        return True  # a whole ball: its two faces are one sphere, and tie
    if ends_at_an_equator(shape):
        return hit.face > 0 or np.shape(own) == (2,)  # the rim moves without bound
    if np.shape(own) != (2,):
        return False
    tilts = {co.Cylinder: ("start", "end"), co.Cone: ("start", "end"), co.Disc: ("normal",), co.HalfSpace: ("normal",),
             co.Plane: ("normal",), co.Polyhedron: ("normals", "offsets"), co.Quadric: ("coefficients",)}  # fmt: skip
    while isinstance(shape, co.Union | co.Intersection | co.Difference | co.Complement | co.Painted):
        operands = shape.operands
        place = int(name.split("operands[")[1][0]) if "operands[" in name else 0
        shape = operands[place]
    shape = getattr(shape, "base", shape)
    return any(part in name for part in tilts.get(type(shape), ())) and least_twice(shape)


def largest_together(shape: co.Revolution, corner: int, column: int) -> bool:
    """Is the distance from the axis, or the height, of a corner the largest, and another as large?"""
    sizes = [abs(numbers[column]) for numbers in shape.profile]
    return sizes[corner] == max(sizes) and sizes.count(max(sizes)) > 1


def ends_at_an_equator(shape: Any) -> bool:
    """Is the rim of a conic as wide as its ellipsoid is?"""
    walls = [getattr(shape, name) for name in ("wall", "front", "back") if hasattr(shape, name)]
    return any(wall.semi**2 * (1 + wall.conic) == wall.radius**2 for wall in walls)


def least_twice(shape: Any) -> bool:
    """Are two coordinates of its axis least? Always so where it has none that says it."""
    if isinstance(shape, co.Polyhedron | co.Quadric):
        return True
    axis = getattr(shape, "normal", None) or np.subtract(shape.end, shape.start)
    first, second, _ = np.sort(np.abs(axis))
    return bool(first == second)


def differences(shape: Any, hit: Any, name: str, ray: Any) -> Any:
    """Central differences of t, point, normal and uv, the number and the ray changing at once."""
    name = name.removeprefix("it.")
    if isinstance(shape, co.Capsules):
        return None  # unions of what is compared
    if isinstance(shape, Bulk):
        name = of_one(shape, int(hit.body), name) or ""
        shape = shape.single(int(hit.body))
    read = plain.read(shape)
    value = plain.get(read, name) if name else None
    o, d, do, dd = ([mp.mpf(x) for x in part.tolist()] for part in ray)
    ends = []
    for sign in (1, -1):
        if name:
            plain.put(read, name, value + sign * STEP)
        origin, direction = ([a + sign * STEP * b for a, b in zip(*pair, strict=True)] for pair in ((o, do), (d, dd)))
        ends.append(outlines.fields(read, int(hit.face), origin, direction, mp.mpf(float(hit.t))))
    (t, x, n, uv), (t2, x2, n2, uv2) = ends
    side = 1 if sum(float(a) * b for a, b in zip(n, hit.normal.tolist(), strict=True)) > 0 else -1
    return (
        slope(t, t2),
        [slope(a, b) for a, b in zip(x, x2, strict=True)],
        [side * slope(a, b) for a, b in zip(n, n2, strict=True)],
        None if uv is None else [around(slope(a, b)) for a, b in zip(uv, uv2, strict=True)],
    )


def slope(a: Any, b: Any) -> Any:
    return (a - b) / (2 * STEP)


def around(value: Any) -> Any:
    """Without the jump of a whole turn."""
    turn = 1 / (2 * STEP)
    return value - turn * mp.nint(value / turn)


@pytest.mark.parametrize("name", sampled(EXAMPLES, 4))
def test_by_some_numbers(name):
    seed = zlib.crc32(name.encode())
    motion = sorted(MOTIONS)[seed % len(MOTIONS)]
    worst, count = wrong(MOTIONS[motion](EXAMPLES[name]), 5, seed)
    assert count == 5
    assert worst < CLOSE


@pytest.mark.deep
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", EXAMPLES)
def test_by_every_number(name, motion):
    shape = MOTIONS[motion](EXAMPLES[name])
    worst, count = wrong(shape, 450, zlib.crc32(f"{name} {motion}".encode()))
    assert count > len(co.parameters(co.Scene([shape])))
    assert worst < CLOSE
