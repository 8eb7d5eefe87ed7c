"""Answers and rays as values: read-only, compared as a whole, joined, kept in files; plain numbers, and names as objects."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

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
FIELDS = {
    co.Hits: ("t", "body", "face", "surface", "hit", "entering", "doubtful", "t_error", "point_error", "point",
              "local_point", "normal", "uv", "name", "material"),
    co.Spans: ("offsets", "t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "t_enter_error",
               "t_exit_error", "name", "material"),
    co.Crossings: ("offsets", "t", "body", "face", "surface", "entering", "point", "normal", "t_error", "name",
                   "material"),
}  # fmt: skip


def assert_same_fields(one, other):
    for field in FIELDS[type(one)]:
        a, b = getattr(one, field), getattr(other, field)
        assert np.shape(a) == np.shape(b), field
        assert getattr(a, "dtype", None) == getattr(b, "dtype", None), field
        assert np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"), field


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
    painted = co.Scene([co.Body(body.shape, "white", body.name) for body in SCENE.bodies])
    assert answer != {"hits": painted.first_hit, "spans": painted.spans, "crossings": painted.crossings}[kind](RAYS)
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


@pytest.mark.parametrize("kind", ["spans", "crossings"])
@pytest.mark.parametrize("rays", [RAYS, ONE, RAYS[:0], SCENE.first_hit(RAYS).spawn((0, 0, 1))])
def test_lists_come_back_from_files(kind, rays, tmp_path):
    answer, path = ASK[kind](rays), tmp_path / "answer.npz"
    for form in (answer, answer.detached()):
        form.save(path)
        again = type(answer).load(path)
        assert again == answer
        assert_same_fields(again, answer)
        assert len(again) == len(answer)
        assert again.offsets.flags.writeable is False
    if kind == "spans" and len(answer):
        assert again.materials == answer.materials
        assert np.array_equal(again.lengths(), answer.lengths())
        assert np.array_equal(again.lengths("material"), answer.lengths("material"))
        assert np.array_equal(again.line_integral("mu", 0), answer.line_integral("mu", 0), equal_nan=True)
        assert again[0] == answer[0]
    assert [entry.name for entry in tmp_path.iterdir()] == ["answer.npz"]
    with np.load(path, allow_pickle=False) as arrays:
        assert all(arrays[name].dtype != object for name in arrays.files)


@pytest.mark.parametrize("rays", [RAYS, ONE, RAYS[:0], SCENE.first_hit(RAYS).spawn((0, 0, 1))])
def test_rays_come_back_from_files(rays, tmp_path):
    rays.save(tmp_path / "rays.npz")
    again = co.Rays.load(tmp_path / "rays.npz")
    assert again == rays
    assert np.array_equal(SCENE.first_hit(again).t, SCENE.first_hit(rays).t)


@pytest.mark.parametrize("kind", [co.Spans, co.Crossings, co.Rays])
def test_files_of_other_kinds_are_refused(kind):
    with pytest.raises(
        ValueError, match=r"load: path of \w+ must end with .np(z|y, .npz, .csv, .parquet or .zarr), got 'x.txt'"
    ):
        kind.load("x.txt")


@pytest.mark.parametrize("state", ["with their scene", "detached", "some of both"])
def test_hits_are_joined(state):
    whole = SCENE.first_hit(RAYS)
    parts = [whole[:2], whole[2:3], whole[3:4], whole[4:4], whole[4:]]
    if state == "detached":
        parts = [part.detached() for part in parts]
    elif state == "some of both":
        parts[1] = parts[1].detached()
    joined = co.Hits.concatenate(parts)
    assert joined == whole
    assert_same_fields(joined, whole)
    assert np.array_equal(SCENE.first_hit(joined.spawn((0, 0, 1))).t, SCENE.first_hit(whole.spawn((0, 0, 1))).t)
    assert co.Hits.concatenate(list(whole.detached()[0])) == whole[0]
    assert pickle.loads(pickle.dumps(joined)) == whole


def test_hits_of_different_scenes_are_not_joined():
    hits, other = SCENE.first_hit(RAYS), co.Scene(co.Sphere(2)).first_hit(RAYS)
    with pytest.raises(ValueError, match=r"Hits: parts must be of one scene, got parts\[0\] and parts\[1\]"):
        co.Hits.concatenate([hits, other])
    painted = co.Scene([co.Body(body.shape, "white", body.name) for body in SCENE.bodies])
    for call, error, message in (
        (
            lambda: co.Hits.concatenate([hits, painted.first_hit(RAYS)]),
            ValueError,
            "parts must be of one scene, got two names or materials of body 0",
        ),
        (lambda: co.Hits.concatenate([]), ValueError, "must hold at least one"),
        (lambda: co.Hits.concatenate([hits, RAYS]), TypeError, r"Hits: parts\[1\] must be Hits, got Rays"),
        (
            lambda: co.Hits.concatenate([hits, SCENE.first_hit(ONE)]),
            ValueError,
            "^Hits: parts must have shapes that differ in the first axis alone",
        ),
    ):
        with pytest.raises(error, match=message):
            call()


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
