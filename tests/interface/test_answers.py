"""Answers and rays as values: read-only, compared as a whole, joined, kept in files; plain numbers, and names as objects."""

import copy
import pickle
from collections.abc import Callable
from itertools import pairwise
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..answers import assert_same_fields

# --- Answers and rays as values: read-only, compared as a whole, joined, and kept in files


LEAD = co.metal("gray", name="lead", properties={"mu": [5.55, 1.64]})
SCENE = co.Scene([
    co.Body(co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2)), LEAD, "bitten \x1b ü"),
    co.Body(co.Spheres([(0, 0, 3), (0, 3, 0)], 0.5), (0.1, 0.2, 1 / 3), "balls"),
    co.Disc((0, 0, -3), (0, 0, 1), 2), co.Body(co.Sphere(0.5, (50, 0, 0)), "red", "never hit"),
    co.Body(co.HalfSpace((0, 0, 1), -9), "blue"),
])  # fmt: skip
RANDOM = np.random.default_rng(7)
RAYS = co.Rays(RANDOM.normal(size=(6, 50, 3)) * 4, RANDOM.normal(size=(6, 50, 3)))
ONE = co.Rays((0, 0, 9), (0.01, 0.02, -1))
ASK = {"hits": SCENE.first_hit, "spans": SCENE.spans, "crossings": SCENE.crossings}


@pytest.mark.parametrize("kind", ASK)
@pytest.mark.parametrize("where", ["with its scene", "detached"])
def test_answers_cannot_be_overwritten(kind, where):
    answer = ASK[kind](RAYS) if where == "with its scene" else ASK[kind](RAYS).detached()
    for name in ("body", "t", "offsets", "energy", "_scene"):
        with pytest.raises(AttributeError, match=f"^{type(answer).__name__} are read-only: {name} cannot be set$"):
            setattr(answer, name, 5)
    with pytest.raises(AttributeError, match="body cannot be deleted"):
        del answer.body
    with pytest.raises(ValueError, match="read-only"):
        answer.body[...] = 5
    assert answer == ASK[kind](RAYS)


@pytest.mark.parametrize("kind", ASK)
def test_answers_are_equal_where_all_fields_are(kind):
    answer = ASK[kind](RAYS)
    assert answer == answer.detached() == pickle.loads(pickle.dumps(answer)) == ASK[kind](RAYS)
    assert (answer == ASK[kind](RAYS)) is True
    assert answer != ASK[kind](co.Rays(RAYS.origins, -RAYS.directions))
    assert answer != ASK[kind](co.Rays(RAYS.origins.reshape(300, 3), RAYS.directions.reshape(300, 3)))
    assert answer != ASK[kind](ONE)
    assert answer != 5
    assert answer != getattr(PAINTED, ASK[kind].__name__)(RAYS)
    with pytest.raises(TypeError, match="unhashable"):
        hash(answer)


def test_rays_are_equal_where_they_start_alike():
    again = co.Rays(RAYS.origins, RAYS.directions)
    assert (again == RAYS) is True
    assert RAYS[2:4] == again[2:4]
    assert RAYS[2:4] != RAYS[3:5]
    hits = SCENE.first_hit(RAYS)
    spawned = hits.spawn((0, 0, 1))
    assert spawned == hits.spawn((0, 0, 1)) == pickle.loads(pickle.dumps(spawned))
    assert spawned[hits.hit] != co.Rays(hits.point[hits.hit], (0, 0, 1))  # these know no surface
    assert ((RAYS.origins, RAYS.directions) == RAYS) is False
    with pytest.raises(AttributeError, match="origins cannot be deleted"):
        del RAYS.origins


@pytest.mark.parametrize("other", [dict(origin=(-2, -2, 1)), dict(u=(3, 0, 0)), dict(v=(0, 3, 0)), dict(pixels=(8, 9))])
def test_slices_are_equal_where_their_windows_are(other):
    """One ball is around all of the pixels, so their numbers do not tell the windows apart."""
    scene, window = co.Scene([co.Sphere(9)]), dict(origin=(-2, -2, 0), u=(4, 0, 0), v=(0, 4, 0), pixels=(8, 8))
    assert scene.slice(**window) == scene.slice(**window)
    assert scene.slice(**window) != scene.slice(**window | other)


@pytest.mark.parametrize("kind", [co.Spans, co.Crossings, co.Rays])
def test_files_of_other_kinds_are_refused(kind):
    with pytest.raises(
        ValueError, match=r"load: path of \w+ must end with .np(z|y, .npz, .csv, .parquet or .zarr), got 'x.txt'"
    ):
        kind.load("x.txt")


@pytest.mark.parametrize("kind", ASK)
@pytest.mark.parametrize("detached", [(), (1,), (0, 1, 2, 3, 4)], ids=["with their scene", "some of both", "detached"])
def test_answers_are_joined(kind, detached):
    whole, ends = ASK[kind](RAYS), (0, 2, 3, 4, 4, 6)
    parts = [ASK[kind](RAYS[begin:end]) for begin, end in pairwise(ends)]
    joined = type(whole).concatenate([part.detached() if k in detached else part for k, part in enumerate(parts)])
    assert joined == whole == pickle.loads(pickle.dumps(joined))
    assert_same_fields(joined, whole)
    flat = co.Rays(RAYS.origins.reshape(-1, 3), RAYS.directions.reshape(-1, 3))
    assert type(whole).concatenate(iter(ASK[kind](flat))) == ASK[kind](flat)
    if kind == "hits":
        assert np.array_equal(SCENE.first_hit(joined.spawn((0, 0, 1))).t, SCENE.first_hit(whole.spawn((0, 0, 1))).t)


PAINTED = co.Scene([co.Body(body.shape, "white", body.name) for body in SCENE.bodies])


@pytest.mark.parametrize("kind", ASK)
@pytest.mark.parametrize(("parts", "error", "message"), [
    (lambda ask, part: [part, RAYS], TypeError, r"parts\[1\] must be {}, got Rays"),
    (lambda ask, part: part, TypeError, "parts must be a list of {0}, got {0}"),
    (lambda ask, part: [], ValueError, "parts must hold at least one"),
    (lambda ask, part: [part, ask(SCENE)(ONE)], ValueError, "parts must have shapes that differ in the first axis"),
    (lambda ask, part: [part, ask(co.Scene(co.Sphere(2)))(RAYS)], ValueError, r"parts must be of one scene, got parts\[0\]"),
    (lambda ask, part: [part, ask(PAINTED)(RAYS)], ValueError, "parts must be of one scene, got (two names or materials|parts)"),
])  # fmt: skip
def test_other_parts_are_not_joined(kind, parts, error, message):
    answer = ASK[kind](RAYS)
    with pytest.raises(error, match=f"^{type(answer).__name__}: {message.format(type(answer).__name__)}"):
        type(answer).concatenate(parts(attrgetter(ASK[kind].__name__), answer))


# --- Numbers of bodies, surfaces, faces and materials are plain integers of NumPy; names are arrays of objects


SOLIDS = co.Scene([
    co.Body(co.Sphere(1), co.metal("gray", name="iron"), name="zebra"),
    co.Body(co.Box((2, -1, -1), (4, 1, 1)), co.glass(name="pane"), name="ant"),
    co.Sphere(1, center=(0, 9, 0)),
])  # fmt: skip
FOUR = co.Rays([(-5, 0, 0), (-5, 0, 9), (3, -5, 0), (0, 15, 0)], [(1, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0)])
HITS = SOLIDS.first_hit(FOUR)
HIT = SOLIDS.first_hit((-5, 0, 0), (1, 0, 0))
SPANS, CROSSINGS = SOLIDS.spans(FOUR), SOLIDS.crossings(FOUR)
NEAR = SOLIDS.distance([(3, 3, 3), (0, 0, 0)], exact=True)
SLICE, VOXELS = SOLIDS.slice("z", pixels=12), SOLIDS.voxels(shape=3)
PATHS = co.optics.trace_paths(SOLIDS, FOUR, depth=2)

NUMBERS: dict[str, Callable[[], Any]] = {
    "hits.body": lambda: HITS.body,
    "hits.before": lambda: HITS.before,
    "hits.after": lambda: HITS.after,
    "hits.surface": lambda: HITS.surface,
    "hits.face": lambda: HITS.face,
    "hit.body": lambda: HIT.body,
    "hit.after": lambda: HIT.after,
    "hit.face": lambda: HIT.face,
    "hits[0].body": lambda: HITS[0].body,
    "hits.body[0]": lambda: HITS.body[0],
    "one of hits.body": lambda: next(iter(HITS.body)),
    "hits[:2].body": lambda: HITS[:2].body,
    "detached": lambda: HITS.detached().before,
    "copied": lambda: copy.deepcopy(HITS).body,
    "from a pickle": lambda: pickle.loads(pickle.dumps(HITS)).surface,
    "joined": lambda: co.Hits.concatenate([HITS, HITS.detached()]).after,
    "spans.body": lambda: SPANS.body,
    "spans[0].body": lambda: SPANS[0].body,
    "spans from a pickle": lambda: pickle.loads(pickle.dumps(SPANS)).body,
    "joined spans": lambda: co.Spans.concatenate([SPANS, SPANS]).body,
    "crossings.body": lambda: CROSSINGS.body,
    "crossings.before": lambda: CROSSINGS.before,
    "crossings.face": lambda: CROSSINGS.face,
    "crossings[2].surface": lambda: CROSSINGS[2].surface,
    "distances.body": lambda: NEAR.body,
    "distances[0].surface": lambda: NEAR[0].surface,
    "body_at a point": lambda: SOLIDS.body_at((0, 0, 0)),
    "body_at points": lambda: SOLIDS.body_at([(0, 0, 0), (3, 0, 0)]),
    "bodies_at": lambda: SOLIDS.bodies_at((0, 0, 0)).body,
    "bodies_at one": lambda: SOLIDS.bodies_at((0, 0, 0))[0],
    "slice.body": lambda: SLICE.body,
    "slice.material": lambda: SLICE.material,
    "voxels.body": lambda: VOXELS.body,
    "voxels.material": lambda: VOXELS.material,
    "paths.wall": lambda: PATHS.wall,
    "in columns": lambda: HITS.body.reshape(2, 2)[1],
}  # fmt: skip


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_are_plain(name):
    values = NUMBERS[name]()
    assert type(values) is (np.ndarray if np.ndim(values) else np.int32)
    assert values.dtype == np.int32


def test_names_are_arrays_of_objects():
    assert repr(HITS.name) == "array(['zebra', None, 'ant', None], dtype=object)"
    with pytest.raises(ValueError, match="read-only"):
        HITS.name[0] = "x"
