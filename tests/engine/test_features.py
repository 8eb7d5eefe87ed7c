"""Where surfaces lie side by side, and which planes across axes are one: kernels against formulas on whole arrays."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.tables import PLANE, QUADRIC, SPHERE
from conicoid.prepare import coincidence
from conicoid.prepare.coincidence import (
    FIRST_DIRECTION,
    SECOND_DIRECTION,
    CurvedFeatures,
    PlaneFeatures,
    QuadricTable,
    coefficients,
    put_across_axes,
    put_first_across_axes,
)
from conicoid.prepare.lowering import lower

from .test_lowered_scenes import solids_of


def planes_of(rng, count):
    """Normals of any size and sign, anchors on or beside the planes."""
    planes = rng.normal(size=(count, 7)) * 2.0 ** rng.integers(-3, 4, (count, 1))
    planes[::2, 3] = 0.0
    return planes


def place(features, leading, along):
    """The sign is that by which what leads lies before `ALONG`."""
    sign = np.where(features[:, :leading] @ FIRST_DIRECTION[:leading] < 0, -1.0, 1.0)
    return sign * (features @ along[: features.shape[1]])


def offsets_of(planes):
    """Of planes n·(x - anchor) + height = 0 from the mean of their anchors."""
    size = np.linalg.norm(planes[:, :3], axis=1)
    away = planes[:, 4:] - planes[:, 4:].mean(axis=0)
    return (np.einsum("ij,ij->i", away, planes[:, :3]) - planes[:, 3]) / size


def test_places_of_planes():
    planes = planes_of(np.random.default_rng(1), 200)
    offsets = offsets_of(planes)
    normals = planes[:, :3] / np.linalg.norm(planes[:, :3], axis=1)[:, None]
    features = np.column_stack([normals, offsets / np.abs(offsets).max()])
    flat = PlaneFeatures.of(np.arange(200, dtype=np.int32), planes)
    assert flat.unit == pytest.approx(np.abs(offsets).max(), rel=1e-13)
    for along in (FIRST_DIRECTION, SECOND_DIRECTION):
        expected = place(features, 3, along)
        assert flat.places(along, slice(None)) == pytest.approx(expected, abs=1e-13)
        assert flat.places(along, np.array([7, 3])) == pytest.approx(expected[[7, 3]], abs=1e-13)


def test_copies_of_a_far_plane_move_nothing():
    """Planes that were found equal are written down, too: places are worked out about those that are left.

    A half-space turned about its own normal (1, 2, 3), and carried along its wall, is the same one.
    """
    far = 0.1 * 10**5
    same = [
        co.HalfSpace((1, 2, 3), k * 0.1).rotate((1, 2, 3), 17 + m).translate((3 * far * m, 0, -far * m))
        for k in range(4)
        for m in range(4)
    ]
    copied = co.HalfSpace((1, 2, 3), 0.7).translate((27 * far, 0, -9 * far))
    lowered = lower([co.Body(shape) for shape in [*same, *[copied] * 1000]])
    assert len(lowered.tables.surface_kind) == 4 + 1


def test_a_plane_has_one_place_however_it_is_written():
    """Another point of it as anchor, the normal longer and turned over."""
    rng = np.random.default_rng(2)
    planes = planes_of(rng, 50)
    planes[:, 3] = 0
    others = planes.copy()
    others[:, 4:] += np.cross(planes[:, :3], rng.normal(size=(50, 3)))
    others[:, :3] *= -rng.uniform(0.5, 2, (50, 1))
    flat = PlaneFeatures.of(np.arange(100, dtype=np.int32), np.concatenate([planes, others]))
    places = flat.places(FIRST_DIRECTION, slice(None))
    assert places[:50] == pytest.approx(places[50:], abs=1e-13)
    assert np.diff(np.sort(places[:50])).min() > 1e-6


def matrices_of(kinds, rows, spheres, quadrics, middle):
    """(n, 4, 4) the symmetric forms of what is curved about a point: of s y² + 2 b y - k with y = W (x - anchor)."""
    forms = np.zeros((len(kinds), 4, 4))
    for form, kind, row in zip(forms, kinds, rows, strict=True):
        if kind == SPHERE:
            anchor, w, s, b, k = spheres[row, :3], np.eye(3), np.ones(3), np.zeros(3), spheres[row, 3] ** 2
        else:
            q = quadrics[row]
            anchor, w, s, b, k = q[:3], q[3:12].reshape(3, 3), q[12:15], q[15:18], q[18]
        to_own = np.eye(4)
        to_own[:3, :3], to_own[:3, 3] = w, w @ (middle - anchor)
        own = np.diag([*s, -k])
        own[:3, 3] = own[3, :3] = b
        form[...] = to_own.T @ own @ to_own
    return forms


def test_coefficients_and_places_of_what_is_curved():
    rng = np.random.default_rng(3)
    spheres, quadrics = rng.uniform(0.5, 2, (30, 4)), rng.normal(size=(60, 19))
    kinds = np.repeat(np.array([SPHERE, QUADRIC], np.int8), [30, 60])
    rows = np.concatenate([rng.permutation(30), rng.permutation(60)]).astype(np.int32)
    curved = CurvedFeatures.of(kinds, rows, spheres, QuadricTable.of(quadrics, quadrics[:, 3:]))
    forms = matrices_of(kinds, rows, spheres, quadrics, np.array(curved.middle))
    numbers = forms[:, (0, 1, 2, 0, 0, 1, 0, 1, 2, 3), (0, 1, 2, 1, 2, 2, 3, 3, 3, 3)]
    numbers /= np.abs(numbers[:, :6]).max(axis=1, keepdims=True)
    found = coefficients(kinds, rows, spheres, curved.quadrics, np.array(curved.middle))
    assert np.array_equal(found, coefficients(kinds, rows, spheres, quadrics, np.array(curved.middle)))
    assert found == pytest.approx(numbers, rel=1e-11, abs=1e-12)
    most = max(np.abs(numbers[:, 6:9]).max(), np.sqrt(np.abs(numbers[:, 9]).max()))
    assert curved.unit == pytest.approx(most, rel=1e-12)
    numbers[:, 6:9] /= most
    numbers[:, 9] /= most**2
    for along in (FIRST_DIRECTION, SECOND_DIRECTION):
        expected = place(numbers, 6, along)
        assert curved.places(along, slice(None)) == pytest.approx(expected, abs=1e-12)
        assert curved.places(along, np.array([40, 3])) == pytest.approx(expected[[40, 3]], abs=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_the_first_of_planes_across_an_axis(seed):
    """By sorting axis, place and record at once; records are often equal, and some planes lie across no axis."""
    rng = np.random.default_rng(seed)
    planes, count = np.zeros((400, 7)), 300
    planes[np.arange(400), rng.integers(0, 3, 400)] = rng.choice([0.5, 1.0], 400)
    planes[:, 4:] = rng.integers(-2, 3, (400, 3))
    planes[:, 4:] *= rng.choice([1.0, -1.0], (400, 3))  # zeros of both signs
    planes[::7, 3], planes[::5, 1] = 0.25, 0.25
    rows = rng.permutation(400)[:count].astype(np.int32)
    axes, places = np.empty(count, np.int8), np.empty(count)
    put_across_axes(planes, rows, axes, places)
    records = planes[rows]
    along = records[:, :3] != 0
    assert (axes >= 0).tolist() == ((along.sum(axis=1) == 1) & (records[:, 3] == 0)).tolist()
    which = np.flatnonzero(axes >= 0)
    rows, axes, places, records = rows[which], axes[which], places[which], records[which]
    assert axes.tolist() == along[which].argmax(axis=1).tolist()
    assert places.tolist() == records[np.arange(len(which)), 4 + axes].tolist()
    first = np.empty(len(which), np.int64)
    put_first_across_axes(planes, rows, axes, places, np.argsort(places), first)
    order = np.lexsort((*records.T[::-1], places, axes))
    new = np.concatenate([[True], (np.diff(places[order]) != 0) | (np.diff(axes[order]) != 0)])
    expected = np.empty(len(which), np.int64)
    expected[order] = order[np.maximum.accumulate(np.where(new, np.arange(len(order)), 0))]
    assert first.tolist() == expected.tolist()
    assert len(set(first.tolist())) < len(which) / 3


@pytest.mark.parametrize("seed", range(6))
def test_surfaces_are_one_where_their_names_are(seed):
    """Every two surfaces of a random scene are compared by their exact names, none by where they lie."""
    bricks = [co.Box((k, 0, 0), (k + 1, 1, 1)).rotate((1, 2, 3), 20) for k in range(4)]
    lowered = lower([co.Body(shape) for shape in solids_of(random.Random(seed)) + bricks])
    tables, exact = lowered.tables, lowered.exact
    names = [exact.bodies.name(int(number))[0] for number in exact.single]
    assert len(set(names)) == len(names) == len(tables.surface_kind)
    given = len(lowered.layout.kinds)
    every = {exact.bodies.name(number)[0] for number in range(given)}
    assert every == set(names)
    assert given >= len(names) + 15  # four sides and three walls between bricks are in common
    assert (tables.surface_kind == PLANE).sum() >= 9


def test_halves_of_rods_are_named_only_where_their_axes_are_one(monkeypatch):
    """Two half rods meet at a rounded middle: that they have one axis follows from fractions, or that they have not."""
    rng = np.random.default_rng(8)
    starts, ends = rng.uniform(-9, 9, (2, 60, 3)) + 32 * np.arange(60)[:, None] * (1, 0, 0)
    starts[:20], ends[:20] = np.round(8 * starts[:20]) / 8, np.round(8 * ends[:20]) / 8
    middles = (starts + ends) / 2
    one = [all(Fraction(a) + Fraction(b) == 2 * Fraction(m) for a, b, m in zip(*row, strict=True))
           for row in zip(starts, ends, middles, strict=True)]  # fmt: skip
    named = []
    name = coincidence._SurfaceMerger._name
    monkeypatch.setattr(coincidence._SurfaceMerger, "_name", lambda *given: named.append(given[1]) or name(*given))
    rods = [co.Cylinder(a, b, 0.1) for pair in ((starts, middles), (middles, ends)) for a, b in zip(*pair, strict=True)]
    scene = co.Scene(rods)
    across = np.cross(ends - starts, rng.normal(size=(60, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    quarters = [starts + (ends - starts) * share for share in (0.25, 0.75)]
    found = [scene.first_hit(quarter + across, -across).surface for quarter in quarters]
    assert (found[0] == found[1]).tolist() == one
    assert 20 <= sum(one) < 60
    assert len(named) <= 4 * sum(one)  # the sides and the caps in the middle of both halves
