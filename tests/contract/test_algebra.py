"""Boolean identities on rays: complement, difference, De Morgan, for every solid."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled
from .conftest import SHAPES
from .subject import Subject, rows

SOLIDS = sampled([name for name, shape in SHAPES.items() if not shape.is_sheet and getattr(shape, "combines", True)], 5)
OTHER = co.Sphere(1.25, (0.5, 0.25, 0.75))


def subject_with(name: str) -> Subject:
    return Subject(name, SHAPES[name], 150)


def spans_of(shape, rays):
    found = co.Scene([shape]).spans(*rays, t_min=-math.inf)
    return found.offsets, found.t_enter, found.t_exit


def assert_same(a, b):
    for x, y in zip(a, b, strict=True):
        assert np.array_equal(x, y)


@pytest.mark.parametrize("name", SOLIDS)
def test_complement_fills_the_gaps(name):
    base = subject_with(name)
    spans = base.whole_lines
    outside = co.Scene([~base.shape]).spans(*base.rays, t_min=-math.inf)
    for i in range(base.count):
        inside = slice(spans.offsets[i], spans.offsets[i + 1])
        gaps = slice(outside.offsets[i], outside.offsets[i + 1])
        ends = [-math.inf, *np.stack([spans.t_enter[inside], spans.t_exit[inside]], axis=1).ravel(), math.inf]
        expected = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]
        assert list(zip(outside.t_enter[gaps], outside.t_exit[gaps], strict=True)) == expected


@pytest.mark.parametrize("name", SOLIDS)
def test_complement_contains_what_the_shape_does_not(name):
    base = subject_with(name)
    hits = base.scene.first_hit(*base.rays)
    points = np.concatenate([base.random.uniform(base.low, base.high, (500, 3)), hits.point[np.isfinite(hits.t)]])
    assert np.array_equal(co.Scene([~base.shape]).contains(points), ~base.scene.contains(points))


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_that_are_equal_on_paper(name):
    """De Morgan's laws, differences by complements, and A | A = A & A = ~~A = A."""
    base, b = subject_with(name), OTHER
    a, own = base.shape, spans_of(base.shape, base.rays)
    for same in (~~a, a | a, a & a):
        assert_same(spans_of(same, base.rays), own)
    for one, other in ((~(a | b), ~a & ~b), (~(a & b), ~a | ~b), (a - b, a & ~b)):
        assert_same(spans_of(one, base.rays), spans_of(other, base.rays))


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_less_itself_is_never_hit(name):
    base = subject_with(name)
    empty = co.Scene([base.shape - base.shape])
    assert np.isinf(empty.first_hit(*base.rays, t_min=-math.inf).t).all()
    assert not empty.occluded(*base.rays, t_min=-math.inf).any()
    assert not empty.contains(base.random.uniform(base.low, base.high, (300, 3))).any()


@pytest.mark.parametrize("name", SOLIDS)
def test_pieces_add_up(name):
    """(A - B) and (A & B) tile A: their lengths add up along every ray, and their common wall is one number."""
    base = subject_with(name)
    parts = co.Scene([base.shape - OTHER, base.shape & OTHER])
    lengths = parts.spans(*base.rays, t_min=-1e3, t_max=1e3).lengths().sum(axis=1)
    whole = base.scene.spans(*base.rays, t_min=-1e3, t_max=1e3).lengths()[:, 0]
    assert np.allclose(lengths, whole, rtol=1e-12, atol=1e-12)
    spans = parts.spans(*base.rays, t_min=-math.inf)
    ray = rows(spans)
    same = np.diff(ray) == 0
    # neighbouring pieces share their wall or are apart by a true gap of A
    gap = spans.t_enter[1:][same] - spans.t_exit[:-1][same]
    assert (gap >= 0).all()


@pytest.mark.parametrize("name", [n for n, s in SHAPES.items() if s.is_sheet and getattr(s, "combines", True)])
def test_clipped_sheets_tile_the_sheet(name):
    base = subject_with(name)
    whole = base.scene.crossings(*base.rays, t_min=-math.inf)
    pieces = co.Scene([base.shape & OTHER, base.shape - OTHER]).crossings(*base.rays, t_min=-math.inf)
    assert np.array_equal(whole.offsets, pieces.offsets)
    assert np.array_equal(whole.t, pieces.t)
    points = np.repeat(base.rays[0], np.diff(whole.offsets), axis=0) + whole.t[:, None] * np.repeat(
        base.rays[1], np.diff(whole.offsets), axis=0
    )
    near = np.abs(np.linalg.norm(points - OTHER.center, axis=1) - OTHER.radius) < 1e-9
    assert ((pieces.body == 0) == co.Scene([OTHER]).contains(points))[~near].all()


@pytest.mark.parametrize("name", [n for n, s in SHAPES.items() if s.is_sheet])
def test_sheets_refuse_other_booleans(name):
    shape = SHAPES[name]
    for combine in (
        lambda: shape | OTHER,
        lambda: OTHER | shape,
        lambda: OTHER - shape,
        lambda: ~shape,
        lambda: shape & shape,
        lambda: shape - shape,
    ):
        with pytest.raises(TypeError):
            combine()
