"""The documented domain, 0 and magnitudes from 1e-100 to 1e100: refusals outside of it; bodies that are far or thin."""

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
import pytest

import conicoid as co

from ..reference.items import Item
from ..reference.random_shapes import MAKERS, WholeDraw, generator, random_shape

# --- The documented domain: 0 and magnitudes from 1e-100 to 1e100. Errors outside of it name object, field and value


OUTSIDE = (1.5e100, -3e250, 9e-101, -4e-300, 5e-324)
LIMITS = (1e100, 1e-100)


def replaced(value: Any, new: float) -> Iterator[Any]:
    """Return the value with each of its numbers in turn replaced."""
    if isinstance(value, dict):
        for key, item in value.items():
            for changed in replaced(item, new):
                yield {**value, key: changed}
    elif isinstance(value, (list, tuple)):
        for k, item in enumerate(value):
            for changed in replaced(item, new):
                yield type(value)((*value[:k], changed, *value[k + 1 :]))
    elif isinstance(value, float) and math.isfinite(value):
        yield new


def shape_with(item: Item, field: str, value: Any) -> Any:
    return dataclasses.replace(item, parameters={**item.parameters, field: value}).shape(co)


@pytest.mark.parametrize("kind", MAKERS)
def test_parameters(kind: str) -> None:
    tried = 0
    for number in range(6):
        item = random_shape(WholeDraw(generator("domain", number)), kind)
        for field, value in item.parameters.items():
            for new in OUTSIDE:
                for changed in replaced(value, new):
                    with pytest.raises(ValueError, match=rf"(?s)({kind}|Box): .*({field}|low|high)"):
                        shape_with(item, field, changed)
                    tried += 1
    assert tried >= 20


SPHERE = co.Sphere()
MOTIONS = {
    "translate: offset": lambda x: SPHERE.translate((0, x, 1)),
    "rotate: axis": lambda x: SPHERE.rotate((0, x, 1), 30),
    "rotate: degrees": lambda x: SPHERE.rotate((0, 0, 1), x),
    "scale: factors": lambda x: SPHERE.scale((1, x, 1)),
    "transform: matrix": lambda x: SPHERE.transform([[1, 0, x, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
}


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("value", OUTSIDE)
def test_motions(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        MOTIONS[name](value)
    for limit in LIMITS:
        if "degrees" not in name:
            MOTIONS[name](limit)


@pytest.mark.parametrize("value", OUTSIDE)
def test_rays(value: float) -> None:
    scene = co.Scene([SPHERE])
    good, bad = np.ones((5, 3)), np.ones((5, 3))
    bad[3, 1] = value
    for query in (scene.first_hit, scene.occluded, scene.spans, scene.crossings, co.Rays):
        with pytest.raises(ValueError, match=r"(?s)origin.*3"):
            query(bad, good)
        with pytest.raises(ValueError, match=r"(?s)direction.*3"):
            query(good, bad)
    with pytest.raises(ValueError, match=r"direction"):
        scene.first_hit(-3 * good, good).spawn(bad)


@pytest.mark.parametrize("limit", LIMITS)
def test_the_limits_themselves_are_inside(limit: float) -> None:
    ball = co.Sphere(limit, (0, 0, 0))
    hits = co.Scene([ball]).first_hit(np.array([[0.0, 0.0, -2 * limit if limit < 1 else -limit]]), (0, 0, limit))
    assert hits.t[0] == (1 if limit < 1 else 2)
    assert hits.t_error[0] < 1e-15


# --- Endless bodies far away and at walls through the origin, and bodies that are thin beside the box that cuts them


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("shape", [co.EllipticCylinder(1, 1, z_range=(2, math.inf)), co.HalfSpace((0, 0, -1), -2)])
def test_rays_within_the_wall_of_an_endless_body(shape: co.Shape, axis: int, sense: int) -> None:
    """The half-space z >= 2 is moved so that its wall goes through the origin.

    A ray within the wall counts as below z = 0 (as x, y, z < 0).
    """
    moved = shape.translate((0, 0, -2)).scale((1, 1, sense))
    moved = (moved.rotate((0, 1, 0), 90), moved.rotate((1, 0, 0), -90), moved)[axis]
    scene = co.Scene([moved])
    origin = np.roll((0.5, -3.0, 0.0), axis + 1)
    direction = np.roll((0.0, 1.0, 0.0), axis + 1)
    assert origin[axis] == direction[axis] == 0
    for beside in (-1e-90, 0.0, 1e-90):
        origin[axis] = beside
        inside = sense * beside > 0 if beside else sense < 0
        spans = scene.spans(origin, direction, t_min=-math.inf)
        assert len(spans.body) == inside
        if inside and isinstance(shape, co.EllipticCylinder):
            assert (spans.t_exit - spans.t_enter)[0] == pytest.approx(math.sqrt(3))
        assert scene.contains(origin + 3 * direction) == (sense * beside >= 0)


def test_points_far_along_a_turned_cylinder() -> None:
    """Points lie a hair inside and outside of A x² + E y² <= 1, turned, at up to 10¹² radii along it."""
    a, e, axis, degrees = 3.0e13, 2.0e13, (-0.975, -0.138, 0.17), -134.0
    scene = co.Scene([co.EllipticCylinder(a, e).rotate(axis, degrees)])
    random = np.random.default_rng(8)
    mp = mpmath.mp
    with mpmath.workdps(100):
        k = mp.matrix([mp.mpf(c) for c in axis])
        k /= mp.norm(k)
        s, c = mp.sin(mp.radians(degrees)), mp.cos(mp.radians(degrees))
        across = mp.matrix([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        turn = c * mp.eye(3) + s * across + (1 - c) * k * k.T
        for _ in range(300):
            angle, far = random.uniform(0, 2 * np.pi), 10 ** random.uniform(-6, 6)
            near = 1 + random.choice([-1, 1]) * 10 ** random.uniform(-16, -1)
            own = mp.matrix([near * math.cos(angle) / math.sqrt(a), near * math.sin(angle) / math.sqrt(e), far])
            point = [float(x) for x in turn * own]
            x, y, _ = turn.T * mp.matrix(point)
            assert scene.contains(point) == (a * x * x + e * y * y <= 1)


@pytest.mark.parametrize(("a", "e"), [(1e8, 9.4), (7e11, 0.3), (3e17, 5e3)])
@pytest.mark.parametrize("away", [0.0, 1e3, -4e7])
def test_bounds_of_a_thin_part_hold_it(away: float, a: Any, e: Any) -> None:
    """A x² - E y² <= 1 for |y| <= 1 has |x| <= sqrt((1 + E) / A), a ten-thousandth of the box and less."""
    shape = co.HyperbolicCylinder(a, e, within=co.Box((-0.7, -1, -1), (0.4, 0.6, 1))).translate((away, 0, 0))
    (low, _, _), (high, _, _) = shape.bounds
    with mpmath.workdps(50):
        most = mpmath.sqrt((1 + mpmath.mpf(e)) / mpmath.mpf(a))
        assert low <= away - most
        assert high >= away + most
        # 64 roundings of its terms widen it so far
        assert high - low <= 2 * mpmath.sqrt((1 + e + 5e-14 * a) / a) + 1e-15 * abs(away)
