"""Hits in files: all fields come back, to the bit, and nothing else is read."""

from __future__ import annotations

import io
import pickle
import zipfile

import numpy as np
import pytest

import conicoid as co

FIELDS = (
    "t", "body", "face", "surface", "hit", "entering", "doubtful", "t_error", "point_error", "point", "local_point",
    "normal", "uv", "name", "material",
)  # fmt: skip
BALLS = co.Spheres([(0, 0, 3), (0, 3, 0)], 0.5)
SCENE = co.Scene([
    co.Body(co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2)), co.phong("tomato", 0.3), "bitten \x1b ü"),
    co.Body(BALLS, (0.1, 0.2, 1 / 3), "balls"), co.Disc((0, 0, -3), (0, 0, 1), 2),
    co.Body(co.Sphere(0.5, (5, 0, 0)), co.matte(co.Checker("red", "blue", 3)), "never hit"),
])  # fmt: skip
RNG = np.random.default_rng(7)
RAYS = co.Rays(RNG.normal(size=(6, 50, 3)) * 4, RNG.normal(size=(6, 50, 3)))
ANSWERS = {
    "many": SCENE.first_hit(RAYS),
    "one": SCENE.first_hit((0.1, 0.2, 9), (0, 0, -1)),
    "a miss": SCENE.first_hit((9, 9, 9), (0, 0, 1)),
    "none": SCENE.first_hit(np.zeros((0, 3)), (0, 0, 1)),
    "some": SCENE.first_hit(RAYS)[2:4, ::3],
    "spawned": SCENE.first_hit(SCENE.first_hit(RAYS).spawn((0, 0, 1))),
}


@pytest.mark.parametrize("name", ANSWERS)
@pytest.mark.parametrize("detached", [False, True])
def test_round_trip(name, detached, tmp_path):
    hits = ANSWERS[name]
    path = tmp_path / "hits.npz"
    (hits.detached() if detached else hits).save(path)
    again = co.Hits.load(path)
    for field in FIELDS:
        a, b = getattr(hits, field), getattr(again, field)
        assert np.shape(a) == np.shape(b), field
        assert getattr(a, "dtype", None) == getattr(b, "dtype", None), field
        if np.asarray(a).dtype.kind in "OU":
            assert np.all(a == b), field
        else:
            assert np.array_equal(a, b, equal_nan=True), field
    assert np.array_equal(again.rays.origins, hits.rays.origins, equal_nan=True)
    onward = SCENE.first_hit(again.spawn((0, 0, 1)))
    assert np.array_equal(onward.t, SCENE.first_hit(hits.spawn((0, 0, 1))).t)
    assert np.array_equal(SCENE.first_hit(again.rays).t, hits.t)
    assert len(pickle.dumps(again)) > 0
    assert [entry.name for entry in tmp_path.iterdir()] == ["hits.npz"]


def test_what_numpy_reads_needs_no_pickle(tmp_path):
    ANSWERS["many"].save(tmp_path / "hits.npz")
    with np.load(tmp_path / "hits.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["t"], ANSWERS["many"].t)
        assert np.array_equal(arrays["body"], ANSWERS["many"].body)
        assert all(arrays[name].dtype != object for name in arrays.files)


def test_indexing_after_loading(tmp_path):
    hits = ANSWERS["many"]
    hits.save(tmp_path / "hits.npz")
    again = co.Hits.load(tmp_path / "hits.npz")
    for index in (3, (2, slice(4, 9)), hits.hit):
        assert np.array_equal(again[index].normal, hits[index].normal, equal_nan=True)
        assert (again[index].name == hits[index].name).all()


def _with(path, **changes):
    """The bytes of a file with some arrays changed, or left out where None."""
    with np.load(path) as arrays:
        content = {name: arrays[name] for name in arrays.files} | changes
    stream = io.BytesIO()
    np.savez(stream, **{name: array for name, array in content.items() if array is not None})
    return stream.getvalue()


@pytest.mark.parametrize(("change", "message"), [
    (dict(t=None), "is not a file of hits.save: it lacks t"),
    (dict(t=np.zeros((3, 3))), r"t_error must have shape \(3, 3\), got \(6, 50\)"),
    (dict(normal=np.zeros((6, 50))), r"normal must have shape \(6, 50, 3\)"),
    (dict(body=np.full((6, 50), 0.5)), "body must hold integers from -1"),
    (dict(body=np.full((6, 50), np.nan)), "body must hold integers"),
    (dict(body=np.full((6, 50), 2**40)), "body must hold integers"),
    (dict(hit=np.full((6, 50), 7)), "hit must hold integers from 0 to 1"),
    (dict(starts=np.zeros(7)), r"starts must have shape \(1,\) or \(300,\)"),
    (dict(labels=np.frombuffer(b"bodies: 3", np.uint8)), "labels are damaged: "),
    (dict(labels=np.frombuffer(b"\xff\xfe", np.uint8)), "utf-8"),
    (dict(directions=np.zeros((6, 50, 3))), "Rays: direction must not be zero"),
    (dict(labels=np.array([1000.0])), "labels must hold integers from 0 to 255"),
    (dict(first_bodies=np.array([3, 2])), "first_bodies must be 2 rising numbers"),
    (dict(first_bodies=np.array([2, 3])), "first_bodies must not be above"),
    (dict(home=np.array([object()])), "home is not an array of numbers"),
])  # fmt: skip
def test_damaged_files(change, message, tmp_path):
    path = tmp_path / "hits.npz"
    ANSWERS["many"].save(path)
    path.write_bytes(_with(path, **change))
    with pytest.raises(ValueError, match=f"hits.npz: .*{message}") as told:
        co.Hits.load(path)
    assert len(str(told.value)) < 500


def test_what_is_no_file_of_hits(tmp_path):
    path = tmp_path / "x.npz"
    path.write_bytes(b"no archive")
    with pytest.raises(ValueError, match=r"x.npz: is not a .npz file"):
        co.Hits.load(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", b"\x93NUMPY\x01\x00 and so on")
    with pytest.raises(ValueError, match="it lacks t_error"):
        co.Hits.load(path)
    ANSWERS["many"].save(path)
    whole = path.read_bytes()
    for length in (100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"x.npz: "):
            co.Hits.load(path)
    with pytest.raises(FileNotFoundError):
        co.Hits.load(tmp_path / "none.npz")
    for wrong, kind in (("x.npy", ValueError), (3, TypeError)):
        with pytest.raises(kind, match="path"):
            co.Hits.load(wrong)
        with pytest.raises(kind, match="path"):
            ANSWERS["one"].save(wrong)
