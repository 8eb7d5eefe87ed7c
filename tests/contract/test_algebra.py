"""Boolean identities on rays, and motions, for every registered shape."""

import math
from functools import cache

import numpy as np
import pytest

import conicoid as co

from ..samples import in_turn, sampled
from .conftest import SHAPES
from .examples import sample_of_kinds
from .subject import Subject, rows

# --- Boolean identities on rays: complement, difference, De Morgan, for every solid


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
def test_solids_that_are_equal_on_paper(name):
    """De Morgan's laws, differences by complements, and A | A = A & A = ~~A = A."""
    base, b = subject_with(name), OTHER
    a, own = base.shape, spans_of(base.shape, base.rays)
    for same in (~~a, a | a, a & a):
        assert_same(spans_of(same, base.rays), own)
    for one, other in ((~(a | b), ~a & ~b), (~(a & b), ~a | ~b), (a - b, a & ~b)):
        assert_same(spans_of(one, base.rays), spans_of(other, base.rays))


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


# --- Moving a shape is moving the rays back


TRANSFORMS = {
    "translate": (lambda s: s.translate((1, -2, 0.5)), np.eye(3), (1, -2, 0.5)),
    "rotate": (lambda s: s.rotate((0, 3, 4), 90), None, (0, 0, 0)),
    "scale": (lambda s: s.scale((2, -0.5, 3)), np.diag([2, -0.5, 3]), (0, 0, 0)),
    "shear": (
        lambda s: s.transform([[1, 0.5, 0, 1], [0, 1, 0.25, 2], [0.5, 0, 1, 3], [0, 0, 0, 1]]),
        np.array([[1, 0.5, 0], [0, 1, 0.25], [0.5, 0, 1]]),
        (1, 2, 3),
    ),
}
# 90° about (0, 3, 4)/5 = k: k kᵀ + [k]×
K = np.array([0, 0.6, 0.8])
TRANSFORMS["rotate"] = (
    TRANSFORMS["rotate"][0],
    np.outer(K, K) + np.array([[0, -0.8, 0.6], [0.8, 0, 0], [-0.6, 0, 0]]),
    (0, 0, 0),
)

EXACT = {
    "quarter turn about z": (
        lambda s: s.rotate((0, 0, 1), 90),
        lambda v: np.stack([-v[:, 1], v[:, 0], v[:, 2]], axis=1),
    ),
    "half turn about x": (lambda s: s.rotate((2, 0, 0), 180), lambda v: v * (1, -1, -1)),
    "twice as large": (lambda s: s.scale(2), lambda v: v * 2),
    "an eighth": (lambda s: s.scale(0.125), lambda v: v * 0.125),
    "turned inside out": (lambda s: s.scale(-1), lambda v: -v),
}


PAIRS = in_turn(SHAPES, TRANSFORMS, sample_of_kinds(0))


@cache
def moved_pair(name: str, transform: str) -> tuple[Subject, co.Scene]:
    """Return a shape with its rays, and a scene of it moved."""
    return Subject(name, SHAPES[name], 150), co.Scene([TRANSFORMS[transform][0](SHAPES[name])])


@pytest.mark.parametrize(("name", "transform"), PAIRS)
def test_local_points_and_uv_do_not_move_and_normals_keep_their_side(name, transform):
    _, linear, shift = TRANSFORMS[transform]
    base, moved = moved_pair(name, transform)
    o, d = base.rays
    here = base.scene.first_hit(o, d, t_max=1e3)
    there = moved.first_hit(o @ linear.T + shift, d @ linear.T, t_max=1e3)
    hit = np.isfinite(here.t)
    slack = 1e-10 * (1 + np.abs(o).max(axis=1) + np.abs(here.local_point).max(axis=1, initial=0))[hit]
    assert (np.abs(here.local_point - there.local_point).max(axis=1)[hit] <= slack).all()
    steady = hit & (np.hypot(*here.local_point[:, :2].T) > 1e-3) & (np.abs(here.local_point).max(axis=1) < 100)
    off = np.abs(here.uv - there.uv)[steady]
    off[:, 0] = np.minimum(off[:, 0], np.abs(1 - off[:, 0]))
    assert off.max(initial=0) <= 1e-8
    # the inverse transpose carries normals, which stay on their physical side
    carried = here.normal @ np.linalg.inv(linear)
    carried /= np.linalg.norm(carried, axis=1, keepdims=True)
    near = hit & (np.abs(here.local_point).max(axis=1) < 100) & (np.linalg.norm(here.local_point, axis=1) > 1e-2)
    assert np.abs(carried - there.normal)[near].max(initial=0) <= 1e-7


@pytest.mark.parametrize(("name", "transform"), in_turn(SHAPES, EXACT, sample_of_kinds(1)))
def test_quarter_turns_and_powers_of_two_are_exact(name, transform):
    """Powers of two change no bit of any t.

    Turns and mirrors permute the terms of sums and change the signs of zeros, which may show in the last bits of t;
    their parameters are exact, so the crossings are the same ones.
    """
    move, carry = EXACT[transform]
    base = Subject(name, SHAPES[name], 150)
    o, d = base.rays
    here = base.scene.crossings(o, d, t_min=-math.inf)
    there = co.Scene([move(SHAPES[name])]).crossings(carry(o), carry(d), t_min=-math.inf)
    for field in ("offsets", "body", "face", "entering"):
        assert np.array_equal(getattr(here, field), getattr(there, field)), field
    if "turn" in transform:
        assert (np.abs(here.t - there.t) <= 1e-1 * base.slack(rows(here), here.t)).all()
    else:
        assert np.array_equal(here.t, there.t)


def test_bounds_follow_exact_motions():
    for name, shape in SHAPES.items():
        bounds, moved = np.array(shape.bounds), np.array(shape.scale(2).bounds)
        slack = 1e-14 * np.where(np.isfinite(bounds), np.abs(bounds), 1).max()
        assert np.allclose(moved, 2 * bounds, rtol=0, atol=4 * slack), name


@pytest.mark.parametrize("name", sampled(SHAPES, 4))
def test_four_quarter_turns_are_none(name):
    """The composition of exact motions is exact: four of them give the same shape to the bit."""
    turned = SHAPES[name]
    for _ in range(4):
        turned = turned.rotate((0, 1, 0), 90)
    base = Subject(name, SHAPES[name], 100)
    here, there = base.scene.crossings(*base.rays), co.Scene([turned]).crossings(*base.rays)
    assert np.array_equal(here.t, there.t)
    assert np.array_equal(here.face, there.face)
