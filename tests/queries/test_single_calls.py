"""One ray or point of plain numbers takes a call that the scene keeps: answers, errors and types are those of arrays."""

import functools
import pickle
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels import threads

from ..engine.test_routes import crowded_scene
from ..machine_code import needs_machine_code
from ..messages import outcome

RAYS = "first_hit", "occluded", "spans", "crossings"
POINTS = "contains", "body_at", "distance"


def scene_with_calls():
    """Return blocks that touch, a hole, a ball that touches a block, and a sheet, with a call for every query."""
    scene = co.Scene([
        co.Box((-1, -1, -1), (0, 1, 1)), co.Box((0, -1, -1), (1, 1, 1)) - co.Sphere(0.5, (1, 0, 0)), co.Disc((0, 0, 2), (0, 0, 1), 1),
        co.Sphere(0.25, (0, 0, -1.25)), co.Spheres([(3, 0, 0), (3, 2, 0)], 0.5),
    ])  # fmt: skip
    for query in RAYS:
        getattr(scene, query)((9, 9, 9), (1, 0, 0))
    for query in POINTS:
        getattr(scene, query)((9, 9, 9))
    return scene


def same(one, other):
    """Return whether two answers are equal and of one type, with all fields."""
    if not hasattr(one, "_fields"):
        return type(one) is type(other) and np.array_equal(one, other)
    fields = [(getattr(one, name), getattr(other, name)) for name in sorted({*one._fields(), *other._fields()})]
    return one == other and all(type(a) is type(b) and np.shape(a) == np.shape(b) for a, b in fields)


@needs_machine_code
def test_a_scene_keeps_a_call_for_every_query():
    assert scene_with_calls()._prepared.single_calls.keys() == {*RAYS, *POINTS}


def test_rays_have_the_answers_of_arrays():
    rng, single = np.random.default_rng(3), 0
    for scene, size in ((scene_with_calls(), 3.0), (crowded_scene(), 1.5)):
        for k in range(200):
            o, d = rng.uniform(-size, size, (2, 3))
            if k % 4 == 0:  # on edges and tangents
                o, d = np.round(o), np.round(d) + (0, 0, 10)
            rays, limits = co.Rays(o, d), {} if k % 3 else dict(t_min=-1, t_max=np.float64(2.5))
            ray = [(o, d), (tuple(o), d.tolist()), (o.tolist(), tuple(d))][k % 3]
            for query in RAYS:
                one, other = getattr(scene, query)(*ray, **limits), getattr(scene, query)(rays, **limits)
                single += "_single" in getattr(one, "__dict__", {})
                assert same(one, other), (query, o, d)
    assert single > 250 or not scene._prepared.single_calls


def test_a_ray_spawned_on_a_wall_has_the_answers_of_arrays():
    rng, single, scene, other = (
        np.random.default_rng(5),
        0,
        scene_with_calls(),
        scene_with_calls().added(co.Sphere(0.1, (0, 0, 3))),
    )
    for k in range(150):
        o, d = rng.uniform(-3, 3, (2, 3))
        hit = scene.first_hit(tuple(o), tuple(np.round(d) + (0, 0, 10) if k % 4 == 0 else 0.2 * d - o))
        ray = hit.spawn(tuple(rng.normal(size=3)))
        two = co.Rays.concatenate([ray, ray])
        limits = {} if k % 3 else dict(t_min=-1, t_max=np.float64(2.5))
        for one in (scene, other):
            for query in RAYS:
                found, expected = getattr(one, query)(ray, **limits), getattr(one, query)(two, **limits)[0]
                single += "_single" in getattr(found, "__dict__", {})
                if query in ("spans", "crossings"):  # one of many is a list of one
                    assert all(np.array_equal(getattr(found, name), getattr(expected, name)) for name in found._columns)
                elif query == "first_hit":
                    assert same(found, expected), (query, ray)
                    assert found.rays == ray
                else:
                    assert found == expected
    assert single > 100 or not scene._prepared.single_calls


def test_lists_of_a_single_ray_are_as_complete_as_others():
    scene = scene_with_calls()
    for query in ("spans", "crossings"):
        one = getattr(scene, query)((0.5, 0.25, -5), (0, 0, 1))
        other = getattr(scene, query)(co.Rays((0.5, 0.25, -5), (0, 0, 1)))
        assert len(one) == 1 <= int(one.offsets[-1])
        assert not any(getattr(one, name).flags.writeable for name in (*one._columns, "offsets"))
        assert repr(one) == repr(other)
        again = getattr(scene, query)((0.5, 0.25, -5), (0, 0, 1))
        copies = pickle.loads(pickle.dumps(again)), again.detached(), type(one).concatenate([again, one])[0], again[0]
        for copy in copies:
            assert all(np.array_equal(getattr(copy, name), getattr(other, name)) for name in (*one._columns, "offsets"))
            assert copy.rays.origins.ravel().tolist() == [0.5, 0.25, -5]
            assert copy.name.tolist() == other.name.tolist()
        assert same(again.detached(), other.detached())
    assert scene.spans((0.5, 0.25, -5), (0, 0, 1)).detached().lengths().shape == (6,)


def test_points_have_the_answers_of_arrays():
    rng = np.random.default_rng(4)
    for scene, size in ((scene_with_calls(), 2.0), (crowded_scene(), 1.2)):
        for k in range(200):
            point = rng.uniform(-size, size, 3) if k % 3 else np.round(rng.uniform(-size, size, 3))
            for query in POINTS:
                one, other = getattr(scene, query)(tuple(point.tolist())), getattr(scene, query)(point[None])
                other = other[0] if query == "distance" else other.reshape(())[()]
                assert same(one, other), (query, point)
    assert same(co.Scene().distance((1, 2, 3)), co.Scene().distance((1, 2, 3)))


def test_a_single_hit_is_as_complete_as_others():
    scene = scene_with_calls()
    hit, ray = scene.first_hit((0.5, 0.25, -5), (0, 0, 1)), co.Rays((0.5, 0.25, -5), (0, 0, 1))
    other = scene.first_hit(ray)
    assert hit
    assert (hit.t, hit.body, hit.hit) == (4.0, 1, True)
    assert hit.rays == ray
    for array in (hit.rays.origins, hit.point, hit._buffers.t):
        assert not array.flags.writeable or array is hit._buffers.t
    assert repr(hit) == repr(other)
    for copy in (pickle.loads(pickle.dumps(hit)), hit.detached(), co.Hits.concatenate([hit, hit])[0], hit[None][0]):
        assert same(copy, other)
    assert scene.first_hit(hit.spawn((0, 0, 1))).t == 2.0
    with pytest.raises(ValueError, match=r"^spawn: directions must be an array of numbers \(..., 3\), got None"):
        hit.spawn(None)
    bound = scene.distance((0.5, 0.25, -5))
    assert pickle.loads(pickle.dumps(bound)) == scene.distance(np.array([[0.5, 0.25, -5]]))[0]
    assert repr(bound) == repr(scene.distance(np.array([[0.5, 0.25, -5]]))[0])


@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 1000, 1024, 1025])
def test_few_rays_have_the_answers_of_many(count):
    rng, scene = np.random.default_rng(count), crowded_scene()
    for query in ("first_hit", "occluded"):
        getattr(scene, query)(np.zeros((2, 3)), (0, 0, 1))
    for coherent in (True, False):
        origins = np.array([0.1, 0.2, -4.0]) + 0.3 * coherent * rng.uniform(-1, 1, (count, 3))
        directions = rng.normal(size=(count, 3)) * (0.1, 0.1, 1.0) ** np.array(coherent)
        directions[::7] = np.round(directions[::7]) + (0, 0, 9)  # some graze walls
        for arrays in ((origins, directions), ((0.1, 0.2, -4), directions), (origins, [0, 0, 1.0])):
            for limits in ({}, dict(t_min=-1, t_max=4.5)):
                hits, hidden = scene.first_hit(*arrays, **limits), scene.occluded(*arrays, **limits)
                rays = co.Rays(*arrays)
                assert same(hits, scene.first_hit(rays, **limits))
                assert np.array_equal(hidden, scene.occluded(rays, **limits))
                assert (hidden.dtype, hidden.shape) == (bool, (count,))
        hits, before = scene.first_hit(origins, directions), co.Rays(origins, directions)
        origins[:], directions[:] = 9.0, -1.0
        assert hits.rays == before
        assert same(pickle.loads(pickle.dumps(hits)), hits.detached())
        assert same(co.Hits.concatenate([hits[:1], hits[1:]]), scene.first_hit(hits.rays))
        assert hits.spawn((0, 0, 1)) == scene.first_hit(before).spawn((0, 0, 1))


@pytest.mark.parametrize("bad", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, 1e-200), (0, 1e101, 1), (0, 0, 0)])
def test_one_wrong_ray_among_few_is_named(bad):
    scene = scene_with_calls()
    scene.first_hit(np.ones((2, 3)), (0, 0, 1))
    for part in (0, 1):
        arrays = [np.ones((50, 3)), np.ones((50, 3))]
        arrays[part][17] = bad
        if part == 0 and bad == (0, 0, 0):
            assert scene.first_hit(*arrays).size == 50
            continue
        with pytest.raises(ValueError, match=r"^Rays: (origin|direction) must .* for ray\[17\]$"):
            scene.first_hit(*arrays)
    with pytest.raises(ValueError, match="broadcast"):
        scene.first_hit(np.ones((50, 3)), np.ones((49, 3)))


VECTORS = [
    "x", None, 3, (1, 2), (1, 2, 3, 4), (1.0, float("nan"), 0), (np.inf, 0, 0), (0, 0, 0), (1e-120, 0, 1), (1e120, 0, 1),
    (2**70, 0, 1), (10**400, 0, 1), (True, False, True), ("a", 0, 1), (1j, 0, 0), [[1, 2, 3]], np.zeros(3, np.float32),
    np.array([1, 2, 3]), np.ma.masked_equal([1.0, 2.0, 3.0], 2.0), np.ones((1, 3)), np.arange(6.0)[::2], np.float64(1),
    (Fraction(1, 3), 0, 1), (np.float64(1), np.int32(2), 3.0), range(1, 4), {1, 2, 3}, np.array([1.0, 2, 3], ">f8"),
    np.array([1, 2, 3], object), np.zeros((0, 3)), np.full((2, 3), 0.5), np.ones((2, 2, 3)), np.ones((3, 2)), np.ones((6, 3))[::2],
    np.asfortranarray(np.ones((4, 3))), np.ones((4, 3), np.float32), np.ma.masked_less(np.ones((4, 3)), 0), memoryview(np.ones(3)), (0.0, -0.0, 1.0), (np.ma.masked, 0, 1),
]  # fmt: skip


def outcome_in_arrays(scene, call):
    """Return the same from the query itself."""
    calls = dict(scene._prepared.single_calls)
    scene._prepared.single_calls.clear()
    found = outcome(call)
    scene._prepared.single_calls.update(calls)
    return found


def test_odd_arguments_are_answered_or_refused_as_in_arrays():
    scene = scene_with_calls()
    for odd in VECTORS:
        cases = [(query, arguments) for query in RAYS for arguments in ((odd, (0, 0.5, 1)), ((0.5, 0.2, -9), odd))]
        for query, arguments in (*cases, *((query, (odd,)) for query in POINTS)):
            call = functools.partial(getattr(scene, query), *arguments)
            one, other = outcome(call), outcome_in_arrays(scene, call)
            assert same(one, other), (query, arguments, one, other)


@pytest.mark.parametrize("query", RAYS)
@pytest.mark.parametrize(
    "limit", [None, "1", np.nan, True, 3, np.float32(3), [3.0], [3.0, 4.0], np.array(3.0), -1, np.inf]
)
def test_limits_of_every_kind(limit, query):
    scene = scene_with_calls()
    for limits in ((0.0, limit), (limit, np.inf)):
        call = functools.partial(getattr(scene, query), (0.5, 0.2, -9), (0, 0, 1), *limits)
        assert same(outcome(call), outcome_in_arrays(scene, call)), (query, limits)


def test_edited_scenes_and_those_before_have_their_own_answers():
    scene = scene_with_calls()
    moved = scene.moved(3, (0, 0, -1))
    assert moved.first_hit((0, 0, -9), (0, 0, 1)).t == 6.5
    assert moved.first_hit((0, 0, -9), (0, 0, 1)).t == 6.5
    assert scene.first_hit((0, 0, -9), (0, 0, 1)).t == 7.5
    again = co.Scene(scene.bodies)
    again.first_hit((0, 0, -9), (0, 0, 1))
    hit = again.first_hit((0, 0, -9), (0, 0, 1))
    again = again.moved(3, (0, 0, -1))  # the hit holds the memory of the scene before
    assert again.first_hit((0, 0, -9), (0, 0, 1)).t == 6.5
    assert hit.normal.tolist() == [0, 0, -1]


def test_python_threads_query_at_once():
    scene = scene_with_calls()

    def ask(k):
        x = 0.25 + k / 1000
        return scene.first_hit((3 + x, 0, -9), (0, 0, 1)).t, scene.distance((x, 0, -3)).lower

    expected = list(map(ask, range(200)))
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, range(200))) == expected


def test_rays_of_many_steps_are_watched_for_ctrl_c(monkeypatch):
    monkeypatch.setattr(threads, "_AT_ONCE", 0)
    assert not scene_with_calls()._prepared.single_calls
