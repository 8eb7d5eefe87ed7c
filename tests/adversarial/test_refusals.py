"""Rays that cannot be traced are refused with the index of the first; ten million that can be are traced."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

SCENE = co.Scene([co.Sphere(), co.Box((2, 2, 2), (3, 3, 3))])
QUERIES = ("first_hit", "occluded", "spans", "crossings")


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize(
    ("field", "value", "word"),
    [
        ("direction", (0, 0, 0), "zero"), ("direction", (0, np.nan, 1), "finite"), ("direction", (np.inf, 0, 1), "finite"),
        ("origin", (np.nan, 0, 0), "finite"), ("origin", (0, -np.inf, 0), "finite"), ("direction", (-0.0, 0.0, 0.0), "zero"),
    ],
)  # fmt: skip
def test_bad_rays_are_refused_with_the_index_of_the_first(query, field, value, word):
    origins, directions = np.zeros((50, 3)), np.tile([0.0, 0.0, 1.0], (50, 1))
    array = directions if field == "direction" else origins
    array[37] = array[41] = value
    with pytest.raises(ValueError, match=rf"{field}.*{word}.*37"):
        getattr(SCENE, query)(origins, directions)
    with pytest.raises(ValueError, match=rf"{field}.*{word}.*3, 7"):
        getattr(SCENE, query)(origins.reshape(5, 10, 3), directions.reshape(5, 10, 3))
    with pytest.raises(ValueError, match=rf"{field}.*{word}"):
        getattr(SCENE, query)(origins[37], directions[37])


@pytest.mark.parametrize("query", QUERIES)
def test_bad_shapes_and_limits(query):
    ask = getattr(SCENE, query)
    for origins, directions in (
        (np.zeros((5, 2)), np.ones((5, 3))),
        (np.zeros((5, 3)), np.ones((4, 3))),
        (0, (0, 0, 1)),
        ("a", (0, 0, 1)),
    ):
        with pytest.raises(ValueError, match=r"origins|directions"):
            ask(origins, directions)
    with pytest.raises(ValueError, match="t_min"):
        ask((0, 0, 0), (0, 0, 1), t_min=np.nan)
    with pytest.raises(ValueError, match="t_max"):
        ask(np.zeros((5, 3)), np.ones((5, 3)), t_max=np.ones(4))
    with pytest.raises(TypeError):
        ask((0, 0, 0))


@pytest.mark.parametrize("query", QUERIES)
def test_an_empty_interval_finds_nothing(query):
    found = getattr(SCENE, query)((0, 0, 0), (0, 0, 1), t_min=5, t_max=2)
    if query == "first_hit":
        assert np.isinf(found.t)
    elif query == "occluded":
        assert not found
    else:
        assert found.offsets.tolist() == [0, 0]


@pytest.mark.parametrize("scene", [co.Scene([]), co.Scene([co.Sphere() - co.Sphere()])], ids=["no bodies", "A - A"])
def test_empty_scenes_are_legal(scene):
    o, d = np.zeros((4, 3)), np.tile([0.0, 0.0, 1.0], (4, 1))
    assert np.isinf(scene.first_hit(o, d).t).all()
    assert not scene.occluded(o, d).any()
    assert scene.spans(o, d).offsets.tolist() == [0] * 5
    assert scene.crossings(o, d).offsets.tolist() == [0] * 5
    assert not scene.contains(o).any()
    assert (scene.body_at(o) == -1).all()


def test_extreme_but_legal_directions_and_distances():
    """Directions of 1e±100 and origins 1e100 away are numbers too."""
    for length in (1e-100, 1e-20, 1e20, 1e100):
        hit = SCENE.first_hit((0, 0, -5), (0, 0, length))
        assert hit.t * length == pytest.approx(4, rel=1e-15)
    assert np.isinf(SCENE.first_hit((0, 2, -1e100), (0, 0, 1)).t)


@pytest.mark.deep
def test_ten_million_rays_at_once():
    """Hit or miss of a unit sphere by the impact parameter, in one call."""
    n = 10_000_000
    random = np.random.default_rng(9)
    origins = np.zeros((n, 3))
    origins[:, :2] = random.uniform(-1.5, 1.5, (n, 2))
    origins[:, 2] = 5
    scene = co.Scene([co.Sphere()])
    hits = scene.first_hit(origins, (0.0, 0.0, -1.0))
    impact = np.hypot(*origins[:, :2].T)
    clear = np.abs(impact - 1) > 1e-15
    assert np.array_equal(np.isfinite(hits.t)[clear], (impact < 1)[clear])
    inside = impact < 0.999
    assert np.abs(hits.t[inside] - (5 - np.sqrt(1 - impact[inside] ** 2))).max() < 1e-13
    assert np.array_equal(scene.occluded(origins, (0.0, 0.0, -1.0)), np.isfinite(hits.t))
