"""Set algebra holds on every ray, to the bit; flush cuts leave nothing and lose nothing, at any scale."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.random_items import tree
from ..reference.random_shapes import generator
from ..samples import deep

# --- Rays at random and along a grid through faces, edges and corners; spans as arrays


def random_rays(r: np.random.Generator, count: int, reach: float = 2.5) -> tuple[Any, Any]:
    targets = r.uniform(-reach, reach, (count, 3))
    directions = r.normal(size=(count, 3)) * 10 ** r.uniform(-1, 1, (count, 1))
    origins = targets - r.uniform(0, 5, (count, 1)) * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return origins, directions


def grid_rays(r: np.random.Generator, count: int, reach: int = 4) -> tuple[Any, Any]:
    """Return rays between points with whole and half coordinates, which pass exactly through faces, edges and corners."""
    targets = r.integers(-2 * reach, 2 * reach + 1, (count, 3)) / 2
    directions = r.integers(-2, 3, (count, 3)).astype(float)
    directions[(directions == 0).all(axis=1)] = (1, 1, 1)
    return targets - 8 * directions, directions


def mixed_rays(r: np.random.Generator, count: int) -> tuple[Any, Any]:
    """Return random rays and grid rays, half of each, and rays from corner to corner with a small random turn."""
    one, other, third = random_rays(r, count // 3), grid_rays(r, count // 3), grid_rays(r, count - 2 * (count // 3))
    near = third[1] + r.normal(size=third[1].shape) * 10 ** r.uniform(-16, -1, (len(third[1]), 1))
    return np.concatenate([one[0], other[0], third[0]]), np.concatenate([one[1], other[1], near])


def table(spans: Any, body: int) -> tuple[Any, Any]:
    """Return arrays (enter, exit) of one body, each (rays, most), with inf behind the last span."""
    rays = len(spans.offsets) - 1
    ray = np.repeat(np.arange(rays), np.diff(spans.offsets))
    mine = spans.body == body
    ray, enter, leave = ray[mine], spans.t_enter[mine], spans.t_exit[mine]
    counts = np.bincount(ray, minlength=rays)
    place = np.arange(len(ray)) - np.repeat(np.cumsum(counts) - counts, counts)
    result = np.full((2, rays, max(1, counts.max(initial=0))), math.inf)
    result[0, ray, place], result[1, ray, place] = enter, leave
    return result[0], result[1]


def same(one: tuple[Any, Any], other: tuple[Any, Any]) -> Any:
    """Return, as (rays,) bool, whether spans are equal to the bit."""
    most = max(one[0].shape[1], other[0].shape[1])
    padded = [
        np.pad(end, ((0, 0), (0, most - end.shape[1])), constant_values=math.inf)
        for pair in (one, other)
        for end in pair
    ]
    return ((padded[0] == padded[2]) & (padded[1] == padded[3])).all(axis=1)


# --- Set algebra holds on every ray, to the bit


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
    """Return two solids and rays."""
    r = generator("set algebra", request.param)
    a, b = (tree(r, 2).shape(co) for _ in range(2))
    return a, b, mixed_rays(r, 200)


@pytest.mark.parametrize("law", EQUAL)
def test_solids_that_are_equal_on_paper_have_equal_spans(law: str, solids: Any) -> None:
    """Equal solids have equal spans to the bit in one scene.

    In scenes of their own they have as many spans, equal up to the choice of a surface's record.
    """
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


# --- Flush cuts: nothing is left and nothing is lost where faces coincide, at any scale


SCALES = [1e-9, 1.0, 1e9]


def assert_same_spans(one: Any, other: Any, rays: Any) -> None:
    spans = co.Scene([one, other]).spans(*rays, t_min=-math.inf)
    agree = same(table(spans, 0), table(spans, 1))
    wrong = np.flatnonzero(~agree)
    assert agree.all(), (
        f"{len(wrong)} rays, the first from {rays[0][wrong[0]].tolist()} along {rays[1][wrong[0]].tolist()}"
    )


def unit_cells(scale: float, *, moved: bool, across: int = 10) -> tuple[Any, Any]:
    """Return a cube and the union of its across³ cells."""
    places = itertools.product(range(across), repeat=3)
    if moved:
        cells = [co.Box((0, 0, 0), (1, 1, 1)).translate(place).scale(scale) for place in places]
        return co.Box((0, 0, 0), (across,) * 3).scale(scale), co.Union(tuple(cells))
    cells = [co.Box(tuple(scale * c for c in place), tuple(scale * (c + 1) for c in place)) for place in places]
    return co.Box((0, 0, 0), (across * scale,) * 3), co.Union(tuple(cells))


def cube_rays(seed: int, count: int, scale: float, across: int = 10) -> Any:
    """Return rays along the grid, rays nearly along it, and random rays through the cube, a third of each."""
    r = np.random.default_rng(seed)
    one = grid_rays(r, count // 3, across)
    two = grid_rays(r, count // 3, across)
    two = two[0], two[1] + r.normal(size=two[1].shape) * 10 ** r.uniform(-16, -1, (len(two[1]), 1))
    targets, directions = (
        r.uniform(0, across, (count - 2 * (count // 3), 3)),
        r.normal(size=(count - 2 * (count // 3), 3)),
    )
    three = targets - 30 * directions, directions
    origins, directions = (np.concatenate(rows) for rows in zip(one, two, three, strict=True))
    return origins * scale, directions


@pytest.mark.parametrize("across", [5, deep(10)])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("moved", [False, True], ids=["by parameters", "by translate and scale"])
def test_a_cube_of_many_cells(moved: bool, scale: float, across: int):
    cube, cells = unit_cells(scale, moved=moved, across=across)
    assert_same_spans(cells, cube, cube_rays(6, 6000, scale, across))


@pytest.mark.parametrize("across", [5, deep(10)])
@pytest.mark.parametrize("moved", [False, True], ids=["by parameters", "by translate and scale"])
def test_a_cube_taken_apart(moved: bool, across: int):
    """A cube less its cells is empty, and every point of a ray in the cube is in exactly one cell."""
    cube, cells = unit_cells(1.0, moved=moved, across=across)
    rays = cube_rays(7, 3000, 1.0, across)
    assert len(co.Scene([cube - cells]).crossings(*rays, t_min=-math.inf).t) == 0
    apart = co.Scene([*cells.operands, cube])
    spans = apart.spans(*rays, t_min=-math.inf)
    ray = np.repeat(np.arange(len(rays[0])), np.diff(spans.offsets))
    whole = spans.body == across**3
    follows = np.diff(ray[~whole]) == 0
    assert np.array_equal(spans.t_enter[~whole][1:][follows], spans.t_exit[~whole][:-1][follows])
    first = np.flatnonzero(np.concatenate([[True], ~follows]))
    last = np.concatenate([first[1:] - 1, [len(ray[~whole]) - 1]])
    assert np.array_equal(spans.t_enter[~whole][first], spans.t_enter[whole])
    assert np.array_equal(spans.t_exit[~whole][last], spans.t_exit[whole])
