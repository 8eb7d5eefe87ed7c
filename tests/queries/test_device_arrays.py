"""Arrays on an emulated card: spans, sums and distances, arrays in any order, and rays that start on hits."""

import os
from functools import partial

import numpy as np
import pytest

import conicoid as co
from conicoid.queries import device, device_choice, device_results

from ..engine.test_routes import camera, crowded_scene
from .test_device import NumPy, OnCard, card, carved, kernels, on_cpu, same_hits, same_there

__all__ = ["card", "kernels"]
WALLS = co.Scene(
    [co.Box((0, 0, 0), (1, 1, 1)), co.Sphere(1).translate((0.5, 0.5, 0)), co.Sphere(1).translate((3, 0, 0))]
)
"""A ball touches a wall of the box from inside, so that only sorting finds the doubt."""


@pytest.fixture(autouse=True)
def few_rows(monkeypatch):
    monkeypatch.setattr(device_results, "_ROWS", 300)
    monkeypatch.setattr(device, "_PIECE", 640)


def there(card, rays):
    """Return rays in the form of queries, on the card."""
    return (rays,) if isinstance(rays, device_results.DeviceRays) else [OnCard(card, each) for each in rays]


def same_array(mine, right):
    right = np.asarray(right)
    assert (mine.shape, mine.dtype) == (right.shape, right.dtype)
    assert np.asarray(mine).tobytes() == right.tobytes()
    if right.size:
        assert on_cpu(mine).tobytes() == right.tobytes()


def same_lists(card, scene, rays, given=None, **limits):
    """Assert that spans, crossings and sums on the card have the bits of the CPU."""
    given = there(card, rays) if given is None else given
    for query in (scene.spans, scene.crossings):
        found, expected = query(*given, **limits), query(rays, **limits, device="cpu")
        own, named = found.to_host(), [name for name in expected._columns if not name.startswith("_")]
        for name in ("offsets", *named):
            same_array(getattr(found, name), getattr(expected, name))
        for name in ("offsets", *expected._columns, *(name for name in dir(expected) if name.endswith("_error"))):
            assert getattr(own, name).tobytes() == getattr(expected, name).tobytes(), name
        assert own.rays == expected.rays
        assert (len(found), found.shape) == (len(expected), rays.shape)
        assert not own.offsets.flags.writeable
    weights = np.random.default_rng(2).normal(size=(scene.body_count, 3)).round()
    for answer in (
        partial(scene.lengths, overlaps="both"),
        partial(scene.lengths, by="material", overlaps="both"),
        partial(scene.line_integral, weights[:, 0]),
        partial(scene.line_integral, weights),
    ):
        same_array(answer(*given, **limits), answer(rays, **limits, device="cpu"))


def test_spans_crossings_and_sums(card):
    scene, rays = crowded_scene(), camera(40)
    same_lists(card, scene, rays, t_max=6.0)
    assert {name for name, _ in card.launches} >= {"list_rows_few", "sum_spans_each", "put_crossing_rows_each"}
    same_lists(card, scene, rays[3, 4])
    same_lists(card, scene, rays[:0])
    same_lists(card, scene, rays[:3, :4], t_min=np.linspace(0, 5, 4), t_max=np.array(7))
    same_lists(card, co.Scene([carved(150), co.Sphere(0.5)]), rays[12:16])
    same_lists(card, co.Scene([]), rays[:2])
    assert repr(scene.spans(*there(card, rays))) == "DeviceSpans(shape=(40, 40))"


def test_doubtful_rays_and_their_rows(card):
    origins = np.array([[2.0, 0.25, 2.0], [0.5, 0.5, 3.0], [2.0, 0.0, 5.0], [0.5, 0.5, -0.5], [0.3, 0.2, 9.0]] * 60)
    directions = np.array([[-1.0, 0, -1], [0, 0, -1], [0, 0, -1], [0, 0, 1e-90], [0, 0, -1]] * 60)
    same_lists(card, WALLS, co.Rays(origins, directions))
    r = np.random.default_rng(3)
    scene = co.Scene([co.Box((0, 0, 0), (2, 2, 2)) - co.Sphere(1), co.Sphere(2).translate((1, 1, 0)), co.Sphere(1)])
    directions = r.integers(-2, 3, (300, 3)).astype(float)
    directions[(directions == 0).all(axis=1)] = 1
    same_lists(card, scene, co.Rays(r.integers(-3, 4, (300, 3)).astype(float), directions))


def test_a_ray_that_turns_out_to_be_doubtful_where_its_rows_are_sorted(card, monkeypatch):
    rays, doubts = co.Rays([[0.5, 0.5, 3.0], [0.3, 0.2, 9.0]], [0, 0, -1.0]), []
    run = device_results._RayRows._run

    def watched(rows, *arguments):
        done = run(rows, *arguments)
        doubts.append(np.asarray(rows.doubts).tolist())
        return done

    monkeypatch.setattr(device_results._RayRows, "_run", watched)
    WALLS.spans(*there(card, rays))
    assert doubts == [[0, 0], [1, 0]]
    same_lists(card, WALLS, rays)


def test_messages_on_overlaps_and_progress(card, caplog):
    iron = co.Material(name="iron")
    scene = co.Scene([co.Body(co.Sphere(1), iron), co.Body(co.Sphere(1).translate((1, 0, 0)), iron)])
    rays, done = co.Rays(np.linspace([-5, 0.3, -0.9], [-5, 0.3, 0.9], 400), [1.0, 0, 0]), []
    on_card = there(card, rays)
    for query in (partial(scene.lengths, by="material"), partial(scene.line_integral, [1, 2])):
        texts = []
        for arguments in (on_card, (rays,)):
            with pytest.raises(ValueError, match="overlap on the ray") as raised:
                query(*arguments, overlaps="error")
            texts.append(str(raised.value))
        assert texts[0] == texts[1]
    answer = partial(scene.line_integral, dict(iron=2.0))
    same_array(answer(*on_card, progress=lambda *now: done.append(now)), answer(rays))
    assert len(caplog.records) == 1
    assert len(done) > 2
    assert done[-1] == (400, 400)


@pytest.mark.parametrize("leaves", [3, 150])
def test_bounds_of_distances(card, leaves):
    scene = co.Scene([carved(leaves), co.Sphere(0.4)])
    points = np.random.default_rng(5).uniform(-1.2, 1.2, (20, 40, 3))
    points[0, :3] = [1, 1, 1], [0, 0, 0.4], [1, 0, 0]
    done = []
    for some in (points, points[3, 4], points[:0]):
        for most in (
            np.inf,
            0.1,
            np.linspace(0.1, 0.3, 40 if some.ndim == 3 else 1)[0 if some.ndim == 1 else slice(None)],
        ):
            found = scene.distance(OnCard(card, some), max_distance=most, progress=lambda *now: done.append(now))
            expected = scene.distance(some, max_distance=most)
            for name in ("distance", "lower", "error"):
                same_array(getattr(found, name), getattr(expected, name))
                assert np.array_equal(getattr(found.to_host(), name), getattr(expected, name))
            assert np.array_equal(found.to_host().points, some)
            assert np.isnan(found.to_host().point).all()
    assert done[0] == (800, 800)
    assert scene.distance(found.points).shape == (0, 40)


def test_a_body_beyond_the_memory_of_a_card(card):
    scene, rays = co.Scene([carved(150)]), camera(16)
    scene.first_hit(rays, device="cuda")
    device_choice._devices[os.getpid()]._scratch = None
    card._size, launches = sum(map(len, card._rooms.values())) + (1 << 20), len(card.launches)
    same_lists(card, scene, rays)
    points = OnCard(card, rays.origins)
    same_array(scene.distance(points, max_distance=2).lower, scene.distance(rays.origins, max_distance=2).lower)
    assert not any(name.startswith(("list_rows", "wall_bounds")) for name, _ in card.launches[launches:])


class View(OnCard):
    """A part of an array on the card, in another order."""

    def __init__(self, card, array, part):
        super().__init__(card, array)
        own = part(array)
        data = self.address + own.ctypes.data - array.ctypes.data, False
        self.face |= dict(shape=own.shape, strides=own.strides, data=data)


def test_arrays_of_float32_with_gaps_or_in_another_order(card):
    scene = crowded_scene()
    rays = camera(40)
    parts = {
        "as it is": lambda a: a,
        "gaps": lambda a: a[1::3, :-2:2],
        "backwards": lambda a: a[::-1, 3:20:-1],
        "axes exchanged": lambda a: a.transpose(1, 0, 2),
        "coordinates backwards": lambda a: a[5, :, ::-1],
        "one": lambda a: a[7, 8],
        "rows again": lambda a: np.broadcast_to(a[0], (3, 40, 3)),
        "none": lambda a: a[:0],
    }
    for kind in (np.float32, np.float64):
        arrays = [each.astype(kind) for each in rays]
        for part in parts.values():
            lines = [part(each) for each in arrays]
            found = scene.first_hit(*(View(card, each, part) for each in arrays))
            same_hits(found.to_host(), scene.first_hit(*lines, device="cpu"))
            assert np.array_equal(np.asarray(found.rays.origins), lines[0])
            points = View(card, arrays[0], part)
            assert np.array_equal(scene.body_at(points), scene.body_at(lines[0], device="cpu"))
    # By DLPack, of memory that the emulated card does not know
    view = device_results.view_of("first_hit", "origins", NumPyOnCard(rays.origins[:, ::2].astype("f4")), Everywhere())
    assert (view.kind, view.shape, view.steps) == ("f4", (40, 20, 3), (60, 3, 1))


class NumPyOnCard(NumPy):
    """An array of NumPy whose device is a card."""

    def __dlpack_device__(self):
        return 2, 0


class Everywhere:
    """A device to which all memory belongs."""

    class driver:
        card_of = staticmethod(lambda address: 0)
        number = staticmethod(lambda stream: 1)

    class Lane:
        stream = None

    lanes = (Lane(),)


def test_origins_and_directions_broadcast(card):
    scene, rays = crowded_scene(), camera(24)
    for one, other in (
        (rays.origins[0, 0], rays.directions),
        (rays.origins[:, :1], rays.directions[3]),
        (rays.origins, rays.directions[5, 6].astype("f4")),
        (rays.origins[:0], rays.directions[0, 0]),
    ):
        same_hits(
            scene.first_hit(OnCard(card, one), OnCard(card, other)).to_host(), scene.first_hit(one, other, device="cpu")
        )


def test_rays_that_start_on_hits(card):
    """As in a simulation, the rays never leave the card."""
    scene, rays = crowded_scene(), camera(40)
    found, expected = same_there(card, scene, *rays), scene.first_hit(rays, device="cpu")
    for step in range(3):
        directions = np.random.default_rng(step).normal(size=expected.normal.shape)
        directions[~expected.hit] = np.nan  # kernels do not read those of misses
        spawned, right = found.spawn(OnCard(card, directions)), expected.spawn(directions)
        assert spawned.to_host() == right
        same_array(scene.occluded(spawned, t_max=3.0), scene.occluded(right, t_max=3.0, device="cpu"))
        same_lists(card, scene, right, [spawned], t_max=5.0)
        found, expected = scene.first_hit(spawned), scene.first_hit(right, device="cpu")
        same_hits(found.to_host(), expected)
        assert expected.hit.any()


def test_many_rays_on_each_hit_and_in_other_scenes(card):
    scene, rays = crowded_scene(), camera(24)
    found, expected = scene.first_hit(*there(card, rays)), scene.first_hit(rays, device="cpu")
    r = np.random.default_rng(1)
    for shape in ((3,), (24, 3), (1, 1, 3), (5, 24, 24, 3), (2, 1, 24, 3)):
        directions = r.normal(size=shape).astype("f4")
        try:
            right = expected.spawn(directions)
        except ValueError as error:
            with pytest.raises(ValueError, match="spawn: directions must broadcast to") as raised:
                found.spawn(OnCard(card, directions))
            assert str(raised.value) == str(error)
            continue
        spawned = found.spawn(OnCard(card, directions))
        assert spawned.to_host() == right
        assert [each.shape for each in spawned] == [(*right.shape, 3)] * 2
        for other in (scene, co.Scene([co.Sphere(0.7)]), scene.added(co.Sphere(0.1))):
            same_hits(other.first_hit(spawned).to_host(), other.first_hit(right, device="cpu"))
    single = scene.first_hit(*there(card, rays[12, 12]))
    assert single.spawn(OnCard(card, rays.directions[0, 0])).to_host() == expected[12, 12].spawn(rays.directions[0, 0])
    nothing = scene.first_hit(*there(card, rays[:0])).spawn(OnCard(card, rays.directions[:0]))
    assert scene.first_hit(nothing).shape == (0, 24)


def test_refusals_of_arrays_on_the_card(card):
    scene, lines = co.Scene([co.Sphere()]), np.ones((4, 3))
    good, toward = OnCard(card, lines), OnCard(card, -lines)
    hits = scene.first_hit(good, toward)
    spawned = hits.spawn(good)
    executor = object()
    wrong = [
        (lambda: scene.crossings(good, lines), "crossings: directions must be an array on the card"),
        (lambda: scene.lengths(good, good, t_min=good), "lengths: t_min must be a number or an array of NumPy's"),
        (lambda: scene.lengths(good, good, by="atom"), "lengths: by must be one of body, material, got 'atom'"),
        (lambda: scene.line_integral(good, good, good), "line_integral: values must be .* got one on a card"),
        (lambda: scene.line_integral([1, 2], spawned), r"line_integral: values must have shape \(1,\)"),
        (lambda: scene.spans(spawned, good), "spans: directions must be left out where a DeviceRays is given"),
        (lambda: scene.spans(spawned, executor=executor), "spans: executor must be left out"),
        (lambda: scene.spans(spawned, device="cpu"), "spans: device must be 'cuda' for arrays on a card, got 'cpu'"),
        (lambda: scene.distance(good, exact=True), "distance: exact must be False for arrays on a card, got True"),
        (lambda: scene.distance(good, max_distance=-1), "distance: max_distance must be positive, got -1.0"),
        (
            lambda: scene.distance(good, max_distance=good),
            "distance: max_distance must be a positive number .* on a card",
        ),
        (lambda: scene.distance(OnCard(card, np.nan * lines)), "distance: points.* must be finite"),
        (lambda: hits.spawn(lines), "spawn: directions must be an array on the card"),
        (
            lambda: hits.spawn(OnCard(card, 0 * lines)),
            r"spawn: direction must be finite and not zero, got .* at \(0,\)",
        ),
        (lambda: hits.spawn(OnCard(card, lines * 1e-320)), r"spawn: direction must be .* in every component, got"),
        (lambda: scene.explain(spawned), "explain: .*DeviceRays"),
    ]
    for call, text in wrong:
        with pytest.raises((TypeError, ValueError), match=text):
            call()
    assert repr(spawned) == "DeviceRays(shape=(4,))"
