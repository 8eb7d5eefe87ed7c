"""Spans and insides of every solid."""

from __future__ import annotations

import math

import numpy as np

from .subject import Subject, rows


def ends(solid: Subject):
    """(ray, t, is an entry) of every true end of a span."""
    spans = solid.whole_lines
    ray = rows(spans)
    t = np.concatenate([spans.t_enter[~spans.enter_clipped], spans.t_exit[~spans.exit_clipped]])
    both = np.concatenate([ray[~spans.enter_clipped], ray[~spans.exit_clipped]])
    entry = np.concatenate([np.ones((~spans.enter_clipped).sum(), bool), np.zeros((~spans.exit_clipped).sum(), bool)])
    near = (
        np.abs(solid.at(both, t)).max(axis=1, initial=0) < 1e3
    )  # far ends of unbounded solids round too coarsely to probe
    return both[near], t[near], entry[near]


def isolated(ray, t, gap):
    """True where no other end of the same ray is nearer than `gap`."""
    order = np.lexsort((t, ray))
    close = (np.diff(ray[order]) == 0) & (np.diff(t[order]) < np.minimum(gap[order][1:], gap[order][:-1]))
    bad = np.zeros(len(t), bool)
    bad[order[1:]] |= close
    bad[order[:-1]] |= close
    return ~bad


def test_rays_find_it(solid):
    assert len(solid.whole_lines.t_enter) >= 20


def test_spans_are_sorted_and_of_positive_length(solid):
    spans = solid.whole_lines
    assert spans.offsets[0] == 0
    assert (np.diff(spans.offsets) >= 0).all()
    assert (spans.t_enter < spans.t_exit).all()
    ray = rows(spans)
    for body in np.unique(spans.body):
        of = spans.body == body
        same = np.diff(ray[of]) == 0
        assert (spans.t_exit[of][:-1][same] < spans.t_enter[of][1:][same]).all()
    same = np.diff(ray) == 0
    assert (spans.t_enter[1:][same] >= spans.t_enter[:-1][same]).all()


def test_middle_of_a_span_is_inside(solid):
    spans = solid.whole_lines
    low = np.where(np.isinf(spans.t_enter), np.minimum(spans.t_exit, 0) - 1, spans.t_enter)
    high = np.where(np.isinf(spans.t_exit), np.maximum(low, 0) + 1, spans.t_exit)
    thick = high - low > 8 * solid.slack(rows(spans), low)
    assert solid.scene.contains(solid.at(rows(spans), (low + high) / 2))[thick].all()


def test_ends_lie_on_the_surface(solid):
    """A hair before an end is on the other side than a hair after it."""
    ray, t, entry = ends(solid)
    hair = solid.slack(ray, t)
    alone = isolated(ray, t, 4 * hair)
    before, after = (solid.scene.contains(solid.at(ray, t + s * hair)) for s in (-1, 1))
    # near grazing rays need a longer hair
    steep = alone & (np.abs(cosines(solid, ray, t, hair)) > 0.01)
    assert steep.sum() >= 0.7 * len(t)
    assert (after == entry)[steep].all()
    assert (before != entry)[steep].all()


def cosines(solid, ray, t, hair):
    """normal·direction at the ends, by shooting from just before each."""
    d = solid.rays[1][ray]
    hits = solid.scene.first_hit(solid.at(ray, t - hair), d, t_max=2 * hair)
    return np.nan_to_num(np.sum(hits.normal * d, axis=1) / solid.speed[ray])


def test_ends_lie_within_the_bounds(solid):
    ray, t, _ = ends(solid)
    low, high = solid.shape.bounds
    points, slack = solid.at(ray, t), (solid.slack(ray, t) * solid.speed[ray])[:, None]
    assert (points >= low - slack).all()
    assert (points <= high + slack).all()


def test_nothing_is_inside_beyond_the_bounds(solid):
    low, high = solid.shape.bounds
    points = solid.random.uniform(solid.low - solid.size, solid.high + solid.size, (2000, 3))
    outside = ((points < low) | (points > high)).any(axis=1)
    assert not solid.scene.contains(points)[outside].any()


def test_bounds_are_tight(solid):
    """Rays reach almost all of the box of a primitive; Booleans may have a larger box."""
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
    """At random places along every ray."""
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


def test_crossings_are_the_ends_of_spans(solid):
    crossings, spans = solid.scene.crossings(*solid.rays, t_min=-math.inf), solid.whole_lines
    per_ray = np.diff(crossings.offsets)
    walls = np.bincount(rows(spans), minlength=solid.count) * 2
    clipped = np.bincount(rows(spans), spans.enter_clipped.astype(int) + spans.exit_clipped, solid.count).astype(int)
    assert (per_ray == walls - clipped).all()
    enters = np.sort(spans.t_enter[~spans.enter_clipped])
    assert np.array_equal(np.sort(crossings.t[crossings.entering]), enters)
    assert np.array_equal(np.sort(crossings.t[~crossings.entering]), np.sort(spans.t_exit[~spans.exit_clipped]))


def test_crossings_from_outside_are_even(solid):
    """And of the whole line, when the solid is bounded."""
    if not solid.bounded:
        return
    assert (np.diff(solid.scene.crossings(*solid.rays, t_min=-math.inf).offsets) % 2 == 0).all()
    outside = ~solid.scene.contains(solid.rays[0])
    assert (np.diff(solid.scene.crossings(*solid.rays).offsets)[outside] % 2 == 0).all()


def test_spans_clipped_to_an_interval(solid):
    o, d = solid.rays
    spans = solid.whole_lines
    middle = -np.einsum("ij,ij->i", o, d) / solid.speed**2
    half = solid.size * 0.4 / solid.speed
    cut = solid.scene.spans(o, d, t_min=middle - half, t_max=middle + half)
    ray, whole = rows(cut), rows(spans)
    enter, leave = np.maximum(spans.t_enter, (middle - half)[whole]), np.minimum(spans.t_exit, (middle + half)[whole])
    keep = enter < leave
    assert np.array_equal(ray, whole[keep])
    assert np.array_equal(cut.t_enter, enter[keep])
    assert np.array_equal(cut.t_exit, leave[keep])
    assert np.array_equal(cut.enter_clipped, ((spans.t_enter < (middle - half)[whole]) | spans.enter_clipped)[keep])
    assert np.array_equal(cut.exit_clipped, ((spans.t_exit > (middle + half)[whole]) | spans.exit_clipped)[keep])


def test_lengths_and_integrals(solid):
    o, d = solid.rays
    cut = solid.scene.spans(o, d, t_min=-1e3, t_max=1e3)
    expected = np.zeros((solid.count, solid.scene.body_count))
    np.add.at(expected, (rows(cut), cut.body), (cut.t_exit - cut.t_enter) * solid.speed[rows(cut)])
    assert np.allclose(cut.lengths(), expected, rtol=1e-14, atol=0)
    values = np.arange(1.0, expected.shape[1] + 1)
    assert np.allclose(cut.line_integral(values), expected @ values, rtol=1e-14, atol=0)


def test_contains_and_body_at_agree(solid):
    points = solid.random.uniform(solid.low, solid.high, (500, 3))
    bodies = solid.scene.body_at(points)
    assert np.array_equal(solid.scene.contains(points), bodies >= 0)
    assert bodies.max(initial=-1) < solid.scene.body_count
