"""Set algebra holds on every ray, to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.random_shapes import generator
from ..reference.whole_items import tree
from ..samples import deep
from .intervals import same, table
from .rays import mixed_rays


def moved(shape: Any) -> Any:
    return shape.rotate((1, 2, 3), 40).scale((1, -2, 0.5)).translate((0.1, 0.2, 0.3))


EQUAL = {
    "a difference is an intersection with the complement": lambda a, b, c: [
        (a - b, a & ~b), (a - b - c, a - (b | c)), (a - b - c, a - c - b),
    ],
    "De Morgan": lambda a, b, c: [(~(a | b), ~a & ~b), (~(a & b), ~a | ~b), (~~a, a)],
    "what was cut off fits back": lambda a, b, c: [
        ((a - b) | (a & b), a), ((a | b) - b, a - b), (a & (a | b), a), (a | (a & b), a), (a & a, a), (a | a, a),
    ],
    "order does not matter": lambda a, b, c: [
        *((one(order), one((a, b, c))) for one in (co.Union, co.Intersection) for order in ((b, a, c), (b, c, a))),
        ((a | b) | c, a | (b | c)), (a & (b | c), (a & b) | (a & c)),
    ],
    "moved together is moved apart": lambda a, b, c: [
        (moved(a - b), moved(a) - moved(b)), (moved(~a | b), ~moved(a) | moved(b)),
    ],
}  # fmt: skip


@pytest.fixture(params=[0, *map(deep, range(1, 12))])
def solids(request: Any) -> tuple[Any, Any, Any]:
    """Two solids and rays."""
    r = generator("set algebra", request.param)
    a, b = (tree(r, 2).shape(co) for _ in range(2))
    return a, b, mixed_rays(r, 200)


@pytest.mark.parametrize("law", EQUAL)
def test_solids_that_are_equal_on_paper_have_equal_spans(law: str, solids: Any) -> None:
    """To the bit in one scene; in scenes of their own as many spans, equal up to the choice of a surface's record."""
    a, b, rays = solids
    for pair in EQUAL[law](a, b, b.translate((0, 1, 0))):
        spans = co.Scene(pair).spans(*rays, t_min=-math.inf)
        assert same(table(spans, 0), table(spans, 1)).all()
        one, other = (co.Scene([shape]).spans(*rays, t_min=-math.inf) for shape in pair)
        for field in ("offsets", "t_enter", "t_exit"):
            assert np.allclose(getattr(one, field), getattr(other, field), rtol=1e-12, atol=1e-12)


def test_nothing_and_everything(solids: Any) -> None:
    a, _, rays = solids
    for empty in (a - a, a & ~a, ~(a | ~a)):
        scene = co.Scene([empty])
        assert len(scene.crossings(*rays, t_min=-math.inf).t) == 0
        assert len(scene.spans(*rays, t_min=-math.inf).t_enter) == 0
        assert not scene.contains(rays[0]).any()
    everything = co.Scene([a | ~a]).spans(*rays, t_min=-math.inf)
    assert len(everything.t_enter) == len(rays[0])
    assert everything.enter_clipped.all()
    assert everything.exit_clipped.all()
