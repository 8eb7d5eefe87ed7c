"""Spans and insides of every solid."""

import math

import numpy as np

from .subject import Subject, rows


def ends(solid: Subject):
    """Return (ray, t) of every true end of a span."""
    spans = solid.whole_lines
    ray = rows(spans)
    t = np.concatenate([spans.t_enter[~spans.enter_clipped], spans.t_exit[~spans.exit_clipped]])
    both = np.concatenate([ray[~spans.enter_clipped], ray[~spans.exit_clipped]])
    near = np.abs(solid.at(both, t)).max(axis=1, initial=0) < 1e3  # far ends of unbounded solids round too coarsely
    return both[near], t[near]


def test_rays_find_it(solid):
    assert len(solid.whole_lines.t_enter) >= 20


def test_ends_lie_within_the_bounds(solid):
    ray, t = ends(solid)
    low, high = solid.shape.bounds
    points, slack = solid.at(ray, t), (solid.slack(ray, t) * solid.speed[ray])[:, None]
    assert (points >= low - slack).all()
    assert (points <= high + slack).all()


def test_no_point_beyond_the_bounds_is_inside(solid):
    low, high = solid.shape.bounds
    points = solid.random.uniform(solid.low - solid.size, solid.high + solid.size, (2000, 3))
    outside = ((points < low) | (points > high)).any(axis=1)
    assert not solid.scene.contains(points)[outside].any()


def test_bounds_are_tight(solid):
    """Rays reach almost all of the box of a primitive. Booleans may have a larger box."""
    if not solid.bounded or hasattr(solid.shape, "operands"):
        return
    n = 4000
    r = solid.random
    targets, directions = r.uniform(solid.low, solid.high, (n, 3)), r.normal(size=(n, 3))
    spans = solid.scene.spans(targets, directions, t_min=-math.inf)
    ray = np.concatenate([rows(spans), rows(spans)])
    points = targets[ray] + np.concatenate([spans.t_enter, spans.t_exit])[:, None] * directions[ray]
    extent = solid.high - solid.low
    assert (points.min(axis=0) - solid.low <= 0.1 * extent).all()
    assert (solid.high - points.max(axis=0) <= 0.1 * extent).all()


def test_spans_agree_with_contains(solid):
    """Spans and `contains` agree at random places along every ray."""
    ray = np.repeat(np.arange(solid.count), 8)
    middle = -np.einsum("ij,ij->i", *solid.rays) / solid.speed**2
    t = middle[ray] + solid.random.normal(size=len(ray)) * solid.size / solid.speed[ray]
    spans = solid.whole_lines
    inside, near = np.zeros(len(t), bool), np.zeros(len(t), bool)
    hair = solid.slack(ray, t)
    for i in range(len(t)):
        of = slice(spans.offsets[ray[i]], spans.offsets[ray[i] + 1])
        inside[i] = ((spans.t_enter[of] <= t[i]) & (t[i] <= spans.t_exit[of])).any()
        near[i] = (np.abs(np.concatenate([spans.t_enter[of], spans.t_exit[of]]) - t[i]) < hair[i]).any()
    assert (solid.scene.contains(solid.at(ray, t)) == inside)[~near].all()


def test_lengths_and_integrals(solid):
    o, d = solid.rays
    cut = solid.scene.spans(o, d, t_min=-1e3, t_max=1e3)
    expected = np.zeros((solid.count, solid.scene.body_count))
    np.add.at(expected, (rows(cut), cut.body), (cut.t_exit - cut.t_enter) * solid.speed[rows(cut)])
    assert np.allclose(cut.lengths(), expected, rtol=1e-14, atol=0)
    values = np.arange(1.0, expected.shape[1] + 1)
    assert np.allclose(cut.line_integral(values), expected @ values, rtol=1e-14, atol=0)
