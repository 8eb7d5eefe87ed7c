"""Numbers of bodies, surfaces, faces and materials are plain integers of NumPy; names are arrays of objects."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

SCENE = co.Scene([
    co.Body(co.Sphere(1), co.metal("gray", name="iron"), name="zebra"),
    co.Body(co.Box((2, -1, -1), (4, 1, 1)), co.glass(name="pane"), name="ant"),
    co.Sphere(1, center=(0, 9, 0)),
])  # fmt: skip
RAYS = co.Rays([(-5, 0, 0), (-5, 0, 9), (3, -5, 0), (0, 15, 0)], [(1, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0)])
HITS = SCENE.first_hit(RAYS)
HIT = SCENE.first_hit((-5, 0, 0), (1, 0, 0))
SPANS, CROSSINGS = SCENE.spans(RAYS), SCENE.crossings(RAYS)
NEAR = SCENE.distance([(3, 3, 3), (0, 0, 0)], exact=True)
SLICE, VOXELS = SCENE.slice("z", pixels=12), SCENE.voxels(shape=3)
PATHS = co.optics.trace_paths(SCENE, RAYS, depth=2)

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
    "body_at a point": lambda: SCENE.body_at((0, 0, 0)),
    "body_at points": lambda: SCENE.body_at([(0, 0, 0), (3, 0, 0)]),
    "bodies_at": lambda: SCENE.bodies_at((0, 0, 0)).body,
    "bodies_at one": lambda: SCENE.bodies_at((0, 0, 0))[0],
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
    plain = np.array(values.tolist(), np.int32)[()]
    kind = type(plain)
    for result in (values == 0, values != 1, values > 0):
        assert type(result) in (np.ndarray, np.bool_)
    assert np.array_equal(values == 0, plain == 0)
    assert np.array_equal(values != 1, plain != 1)
    for result in (values + 1, values * 2.5, -values, np.asarray(values)[()], np.where(values < 0, 7, values)[()]):
        assert type(result) in (np.ndarray, np.int32, np.int64, np.float64)
    assert type(pickle.loads(pickle.dumps(values))) is kind
    assert (repr(values), str(values), values.dtype) == (repr(plain), str(plain), np.int32)
    assert np.array_equal(np.arange(9.0)[values], np.arange(9.0)[plain])
    assert isinstance(values, kind)
    assert np.array_equal(pickle.loads(pickle.dumps(values)), plain)


def test_single_numbers_are_integers():
    number = SCENE.body_at((3, 0, 0))
    assert number == 1 == int(number) == {1: 1}[number] == number.item()
    assert (f"{number:03d}", number in (0, 1), hash(number), [5, 6, 7][number]) == ("001", True, hash(1), 6)
    assert type(number + 1) is np.int32
    assert np.array([number, number]).dtype == np.int32
    assert type(number)(type(number)(number)) == number  # a second base class was the end of the process here


def test_comparison_with_none_and_numbers():
    assert not (HITS.body == None).any()  # noqa: E711
    assert (HITS.body == HITS[:].body).all()
    assert (HITS.body == [0, -1, 1, 2]).all()
    assert np.isin(HITS.body, [0, 2]).tolist() == [True, False, False, True]


def test_names_are_arrays_of_objects():
    assert (HITS.name == "ant").tolist() == [False, False, True, False]
    assert type(HITS.name == "ant") is np.ndarray is type(pickle.loads(pickle.dumps(HITS.name)))
    assert repr(HITS.name) == "array(['zebra', None, 'ant', None], dtype=object)"
    assert np.isin(HITS.name, ["ant"]).tolist() == [False, False, True, False]
    with pytest.raises(ValueError, match="read-only"):
        HITS.name[0] = "x"
