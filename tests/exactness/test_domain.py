"""The documented domain: 0 and magnitudes from 1e-100 to 1e100. What lies outside is refused, by object, field and value."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.items import Item
from ..reference.random_shapes import MAKERS, WholeDraw, generator, random_shape

OUTSIDE = (1.5e100, -3e250, 9e-101, -4e-300, 5e-324)
LIMITS = (1e100, 1e-100)


def replaced(value: Any, new: float) -> Iterator[Any]:
    """The value with each of its numbers in turn replaced."""
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
