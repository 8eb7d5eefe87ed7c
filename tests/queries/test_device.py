"""Queries on an emulated GPU: the same bits as on the CPU, from NumPy arrays in chunks, and clear refusals."""

import copy
import ctypes
import gc
import inspect
import pickle
import sys
import types
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import ClassVar

import llvmlite.binding as llvm
import numpy as np
import pytest

import conicoid as co
from conicoid.queries import device, device_arrays, device_choice, nvidia_driver
from native import objects, ptx

from ..emulation import Card, Kernels, device_kernels, device_module, from_store, sources_of
from ..engine.test_routes import camera, crowded_scene
from ..interruptions import Interruption
from ..reference import aimed_rays
from ..reference.quadratics import Table
from ..reference.random_items import KINDS, SCENES, extreme, ordinary
from ..reference.random_shapes import generator
from ..reference.solids import bodies
from ..reference.suite import whole_score
from ..samples import sampled

FIELDS = ("t", "body", "face", "surface", "entering", "doubtful", "point", "normal", "t_error")


@pytest.fixture(scope="module")
def kernels():
    return device_kernels()


@pytest.fixture
def card(kernels, monkeypatch):
    """Return the card of this process, and check its memory at the end."""
    emulated = Card(kernels)
    monkeypatch.setattr(nvidia_driver, "NvidiaDriver", lambda: emulated)
    monkeypatch.setattr(device_choice, "_devices", {})
    monkeypatch.setattr(device, "CHUNK", 500)
    monkeypatch.setattr(device, "_ROWS", 300)
    yield emulated
    emulated.check()


def same_hits(one, other):
    for field in FIELDS:
        assert np.array_equal(getattr(one, field), getattr(other, field), equal_nan=True), field


def same_answers(scene, rays, t_max=np.inf):
    """Assert that both devices give the same answers."""
    there, here = (dict(t_max=t_max, device=name) for name in ("cuda", "cpu"))
    same_hits(scene.first_hit(rays, **there), scene.first_hit(rays, **here))
    assert np.array_equal(scene.occluded(rays, **there), scene.occluded(rays, **here))
    for query in (scene.spans, scene.crossings):
        one, other = query(rays, **there), query(rays, **here)
        for field in ("offsets", *other._columns):
            assert getattr(one, field).tobytes() == getattr(other, field).tobytes(), field
    weights = np.random.default_rng(2).normal(size=(scene.body_count, 3)).round()
    for query in (
        partial(scene.lengths, rays, overlaps="both"),
        partial(scene.lengths, rays, by="material", overlaps="both"),
        partial(scene.line_integral, weights[:, 0], rays),
        partial(scene.line_integral, weights, rays),
    ):
        assert query(**there).tobytes() == query(**here).tobytes()


def carved(leaves):
    r = np.random.default_rng(leaves)
    balls = [co.Sphere(0.3).translate(r.uniform(-1.1, 1.1, 3)) for _ in range(leaves - 1)]
    return co.Difference([co.Box((-1, -1, -1), (1, 1, 1)), *balls])


def test_pictures_lists_and_single_rays(card):
    scene, rays = crowded_scene(), camera(48)
    same_answers(scene, rays)
    used = {"shorten_nodes_each", "first_hits_few", "any_hits_few", "list_rows_few", "sum_spans_each"}
    assert {name for name, _ in card.launches} == used
    assert max(threads for _, threads in card.launches) == 500  # in chunks
    same_answers(scene, rays[3], np.linspace(2, 5, 48))
    same_answers(scene, rays[3, 4])
    same_answers(scene, rays[:0])


def test_doubtful_rays_go_to_the_exact_route_and_come_back(card):
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Sphere(1).translate((3, 0, 0))])
    origins = np.array([[2.0, 0.25, 2.0], [0.5, 0.5, 3.0], [2.0, 0.0, 5.0]] * 400)
    directions = np.array([[-1.0, 0, -1], [0, 0, -1], [0, 0, -1]] * 400)
    hits = scene.first_hit(origins, directions, device="cuda")
    assert hits.doubtful.tolist() == [True, False, True] * 400
    same_answers(scene, co.Rays(origins, directions))


@pytest.mark.parametrize(
    ("leaves", "size"), [(3, "few"), (8, "few"), (9, "many"), (40, "many"), (64, "many"), (65, "any"), (150, "any")]
)
def test_points_in_bodies_of_all_sizes(card, leaves, size, monkeypatch):
    scene = co.Scene([carved(leaves), co.Sphere(0.4)])
    r = np.random.default_rng(5)
    points = np.concatenate([r.uniform(-1.2, 1.2, (1200, 3)), [[1, 1, 1], [0, 0, 0.4], [1, 0, 0]]])
    for query in (scene.body_at, scene.contains):
        assert np.array_equal(query(points, device="cuda"), query(points, device="cpu"))
    assert {name for name, _ in card.launches} == {f"first_bodies_{size}"}
    lists, done = [], []
    for name in ("cuda", "cpu"):
        monkeypatch.setenv("CONICOID_DEVICE", name)
        lists.append(
            [scene.distance(points, progress=lambda *k: done.append(k)), scene.distance(points, max_distance=0.1)]
        )
    for one, other in zip(*lists, strict=True):
        assert one.distance.tobytes() == other.distance.tobytes()
        assert one.lower.tobytes() == other.lower.tobytes()
    assert done[0] == done[-1] == (len(points), len(points))
    assert f"wall_bounds_{size}" in dict(card.launches)
    assert scene.contains((0, 0, 0.2), device="cuda")
    same_answers(scene, co.Rays(points, r.normal(size=points.shape)))
    assert f"list_rows_{size}" in dict(card.launches)


@pytest.mark.parametrize("sort", [ordinary, extreme])
@pytest.mark.parametrize("kind", KINDS)
def test_bodies_of_all_kinds(card, kind, sort):
    """The rays are hard for each kind, as in tests/exactness/test_random_bodies.py."""
    r = generator(f"device {kind}", 0)
    item = sort(kind, r)
    scene = co.Scene([item.shape(co)])
    rays = co.Rays(*aimed_rays.rays(aimed_rays.Aim(Table(bodies([item])), item.world_center, item.world_size, r), 120))
    same_answers(scene, rays)
    hits = scene.first_hit(rays)
    met = hits[hits.body >= 0]
    assert np.array_equal(scene.body_at(met.point, device="cuda"), scene.body_at(met.point, device="cpu"))
    spawned = met.spawn(np.array([3.0, 5.0, -6.0]) - met.point)
    same_answers(scene, spawned, np.linspace(0.1, 1.0, len(spawned.origins)))


def test_copies_that_share_their_tables(card):
    r = np.random.default_rng(6)
    places = r.uniform(-3, 3, (40, 3))
    scene = co.Scene([carved(12).scale(0.3).translate(place) for place in places])
    same_answers(scene, co.Rays(r.uniform(-4, 4, (400, 3)), r.normal(size=(400, 3))))
    assert np.array_equal(scene.body_at(places + 0.1, device="cuda"), scene.body_at(places + 0.1, device="cpu"))


@pytest.mark.deep
def test_llvm_optimises_for_a_gpu(monkeypatch):
    """The module is the last form of the code before PTX."""
    module, target = device_module(), objects.machine_for(ptx.TRIPLE, ptx.LEVEL)
    names = "shorten_nodes_each", "first_hits_few", "any_hits_few", "list_rows_few"

    def optimize() -> bytes:
        whole, names_of_kernels = llvm.parse_bitcode(module), [ptx.PREFIX + name for name in names]
        for each in (*whole.functions, *whole.global_variables):
            if not each.is_declaration:
                each.linkage = "external" if each.name in names_of_kernels else "internal"
        objects.optimize(whole, target, is_short=True)
        return whole.as_bitcode()

    emulated = Card(Kernels(from_store(f"optimised {sources_of(module)}", optimize)))
    monkeypatch.setattr(nvidia_driver, "NvidiaDriver", lambda: emulated)
    monkeypatch.setattr(device_choice, "_devices", {})
    scene, rays = crowded_scene(), camera(48)
    same_hits(scene.first_hit(rays, device="cuda"), scene.first_hit(rays, device="cpu"))
    assert np.array_equal(scene.occluded(rays, device="cuda"), scene.occluded(rays, device="cpu"))
    there, here = (scene.spans(rays, device=name) for name in ("cuda", "cpu"))
    assert there.t_enter.tobytes() == here.t_enter.tobytes()


def test_overlaps_are_reported(card, caplog):
    """As on the CPU, there is an error or a note where spans overlap that count, by material or at all."""
    iron, gold = co.Material(name="iron"), co.Material(name="gold")
    bodies = [co.Body(co.Sphere(1), iron), co.Body(co.Sphere(1).translate((1, 0, 0)), gold)]
    pins = [co.Body(co.Sphere(0.1).translate((9, y, 0)), iron) for y in range(7)]
    rays = co.Rays(np.linspace([-5, 0.3, -0.9], [-5, 0.3, 0.9], 1200), [1.0, 0, 0])
    scene = co.Scene([*bodies, *pins])
    apart = partial(scene.lengths, rays, by="material", overlaps="error")  # they overlap, but of no material
    assert apart(device="cuda").tobytes() == apart(device="cpu").tobytes()
    together = co.Scene([*bodies, co.Body(co.Sphere(0.5), gold), *pins])
    values = np.ones(together.body_count)
    for query in (
        partial(scene.lengths, rays, overlaps="error"),
        partial(together.lengths, rays, by="material", overlaps="error"),
        partial(together.line_integral, values, rays, overlaps="error"),
        partial(together.line_integral, -values, rays, overlaps="error"),
    ):
        texts = []
        for name in ("cuda", "cpu"):
            with pytest.raises(ValueError, match="overlap on the ray") as raised:
                query(device=name)
            texts.append(str(raised.value).partition("through")[2])
        assert texts[0] == texts[1]
    together.line_integral(values, rays, device="cuda")
    together.line_integral(values, rays, device="cuda")
    assert [record.message.partition(":")[0] for record in caplog.records] == ["line_integral"]
    calls = []
    result = scene.line_integral(np.zeros(len(scene)), rays, device="cuda", progress=lambda *done: calls.append(done))
    assert not result.any()
    assert calls == [(1200, 1200)]


@pytest.mark.parametrize("kind", sampled(SCENES, 4))
def test_against_exact_arithmetic(card, kind):
    """Many rays and points are doubtful, on small whole numbers as in tests/exactness/test_whole_bodies.py."""
    co.set_device("cuda")
    try:
        score = whole_score(kind, 0, 40)
    finally:
        co.set_device(None)
    assert score.rows
    score.check()
    used = {name.rpartition("_")[0] for name, _ in card.launches}
    assert used >= {"first_hits", "any_hits", "first_bodies", "list_rows"}


def test_an_empty_scene_and_pickles(card):
    empty, scene, rays = co.Scene([]), co.Scene([co.Sphere()]), camera(16)
    for each in (empty, scene):
        same_answers(each, rays)
        assert np.array_equal(each.body_at(rays.origins, device="cuda"), each.body_at(rays.origins))
    hits = scene.first_hit(rays, device="cuda")
    same_hits(pickle.loads(pickle.dumps(hits)), hits)
    same_answers(pickle.loads(pickle.dumps(scene)), rays)
    same_answers(copy.deepcopy(scene), rays)


def test_tables_are_sent_once_and_again_after_an_edit(card):
    balls = co.Spheres(np.random.default_rng(1).uniform(-1, 1, (2000, 3)), 0.02)
    scene = co.Scene([co.Body(balls, name="balls")])
    points = np.zeros((1, 3))
    scene.contains(points, device="cuda")
    before = card.sent
    scene.contains(points, device="cuda")
    assert card.sent - before < 2000
    before = card.sent
    assert not scene.replace("balls", name="dots").contains(points, device="cuda")
    assert card.sent - before < 2000  # names and materials share all tables
    edited = scene.added(co.Sphere(0.5))
    for query in (scene.contains, edited.contains):
        assert query(points, device="cuda") == query(points, device="cpu")
    assert edited.contains(points, device="cuda")


def test_a_scene_leaves_the_card_with_its_last_name(card):
    scene = co.Scene([co.Spheres(np.random.default_rng(1).uniform(-1, 1, (2000, 3)), 0.02)])
    scene.first_hit((0, 0, 5), (0, 0, -1), device="cuda")
    free = card.free_memory()
    del scene
    assert card.free_memory() > free


def test_a_body_beyond_the_memory_of_a_card_is_traced_here(kernels, card, monkeypatch):
    scene, rays = co.Scene([carved(150)]), camera(16)
    card._size = sum(map(len, card._rooms.values())) + (2 << 20)
    same_answers(scene, rays)
    assert card.launches == []


def test_a_card_without_memory_names_the_bytes(card):
    card._size = 4096
    with pytest.raises(MemoryError, match=r"bytes are needed, [\d,]+ are free on emulation"):
        crowded_scene(301).first_hit(camera(8), device="cuda")


def test_steep_rays_meet_bodies_that_have_no_end(card):
    """In an infinite box t has no limit, so that a slope of 1e-31 counts: t = (1 - 0) / 1e-31."""
    prism = co.Intersection([
        co.HalfSpace((-1, 0, 0), -1), co.HalfSpace((1, 0, 0), 2), co.HalfSpace((0, 0, -1), -3), co.HalfSpace((0, 0, 1), 6),
    ])  # fmt: skip
    scene = co.Scene([prism, *(co.Sphere(0.1, (k, k, -9)) for k in range(20))])
    directions = np.array([[1e-31, 1, 3e-31], [0, 1, 1e-40], [1e-31, 1, 0], [1, 0, 3], [0, 0, 1]])
    rays = co.Rays(np.zeros((5, 3)), directions)
    hits = scene.first_hit(rays, device="cuda")
    assert hits.t[0] == pytest.approx(1e31, rel=1e-12)
    same_answers(scene, rays)
    for limits in ({"t_min": 1e40}, {"t_min": -np.inf, "t_max": -1e40}):
        one, other = (scene.first_hit(rays, **limits, device=name) for name in ("cuda", "cpu"))
        same_hits(one, other)


def test_a_device_for_all_queries(card, monkeypatch):
    scene, rays = crowded_scene(), camera(16)
    expected = scene.first_hit(rays)
    co.set_device("cuda")
    try:
        same_hits(scene.first_hit(rays), expected)
        launched = [name for name, _ in card.launches]
        assert launched == ["shorten_nodes_each", "first_hits_few"]
        scene.first_hit(rays, device="cpu")
        assert len(card.launches) == 2
    finally:
        co.set_device(None)
    monkeypatch.setenv("CONICOID_DEVICE", "cuda")
    same_hits(scene.first_hit(rays), expected)
    assert len(card.launches) == 3
    with ThreadPoolExecutor(1) as pool:
        assert np.array_equal(scene.body_at(rays.origins, executor=pool), scene.body_at(rays.origins, device="cpu"))
    assert {name for name, _ in card.launches[3:]} == {"first_bodies_few"}
    monkeypatch.setenv("CONICOID_DEVICE", "gpu")
    with pytest.raises(ValueError, match="CONICOID_DEVICE must be 'cpu' or 'cuda', got 'gpu'"):
        scene.first_hit(rays)


def test_ctrl_c_leaves_no_chunk_behind(card, monkeypatch):
    scene, rays = crowded_scene(), camera(48)
    expected = scene.first_hit(rays)
    monkeypatch.setattr(card, "is_done", Interruption(20, card.is_done))
    with pytest.raises(KeyboardInterrupt):
        scene.first_hit(rays, device="cuda")
    same_hits(scene.first_hit(rays, device="cuda"), expected)


class OnCard:
    """An array on the emulated card, by Numba's interface, or by its DLPack alone."""

    def __init__(self, card, array, **changes):
        self.address = card.allocate(max(array.nbytes, 8))
        ctypes.memmove(self.address, array.ctypes.data, array.nbytes)
        data = self.address, False
        self.face = dict(shape=array.shape, typestr=array.dtype.str, data=data, version=3, stream=7) | changes

    @property
    def __cuda_array_interface__(self):
        return self.face


def on_cpu(array):
    """Return a copy of an array on the emulated card, by its interface."""
    face = array.__cuda_array_interface__
    kind = np.dtype(face["typestr"])
    size = int(np.prod(face["shape"])) * kind.itemsize
    return np.frombuffer(ctypes.string_at(face["data"][0], size), kind).reshape(face["shape"])


ON_CARD = ("t", "body", "face", "surface", "hit", "entering", "doubtful", "point", "normal", "uv")


def same_there(card, scene, origins, directions, **limits):
    """Assert that arrays on the card have the bits of the CPU, in all fields, and stay there."""
    there = [OnCard(card, each) for each in (origins, directions)]
    found, expected = scene.first_hit(*there, **limits), scene.first_hit(origins, directions, **limits, device="cpu")
    for field in ON_CARD:
        mine, right = getattr(found, field), getattr(expected, field)
        assert (mine.shape, mine.dtype) == (np.shape(right), np.asarray(right).dtype), field
        assert np.asarray(mine).tobytes() == on_cpu(mine).tobytes() == np.asarray(right).tobytes(), field
    same_hits(found.to_host(), expected)
    occluded = scene.occluded(*there, **limits)
    assert np.array_equal(occluded, scene.occluded(origins, directions, **limits, device="cpu"))
    for query in (scene.body_at, scene.contains):
        assert np.array_equal(query(there[0]), query(origins, device="cpu"))
        if expected.hit.all():
            assert np.array_equal(query(found.point), query(expected.point, device="cpu"))
    return found


def test_arrays_that_live_on_the_card(card, monkeypatch):
    monkeypatch.setattr(device, "_PIECE", 700)
    rays = camera(48)
    same_there(card, crowded_scene(), rays.origins, rays.directions, t_max=6.0)
    same_there(card, crowded_scene(), rays.origins[3, 4], rays.directions[3, 4])
    same_there(card, crowded_scene(), rays.origins[:0], rays.directions[:0])
    same_there(card, co.Scene([carved(150)]), rays.origins[20:30], rays.directions[20:30], t_min=np.linspace(0, 4, 48))
    assert set(card.followed) == {7}


def test_doubtful_and_far_rays_on_the_card(card):
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Sphere(1).translate((3, 0, 0)), co.Sphere(1e-7)])
    origins = np.array([[2.0, 0.25, 2.0], [0.5, 0.5, 3.0], [2.0, 0.0, 5.0], [0.0, 0.0, -1.0]] * 40)
    directions = np.array([[-1.0, 0, -1], [0, 0, -1], [0, 0, -1], [1e-9, 0, 1]] * 40)
    found = same_there(card, scene, origins, directions)
    assert 0 < np.asarray(found.doubtful).sum() < 160
    far = same_there(card, co.Scene([co.Sphere(1)]), np.array([[3e8, 0.1, 0.2]]), np.array([[-1.0, 0, 0]]))
    assert np.asarray(far.hit).all()


def test_dlpack_in_and_out(card, monkeypatch):
    """The emulated card's memory is the CPU's, so that NumPy can be the other library."""
    scene, rays = crowded_scene(), camera(24)
    hits = scene.first_hit(OnCard(card, rays.origins), OnCard(card, rays.directions))
    used = len(device_arrays._loans)
    with pytest.raises(BufferError):
        hits.t.__dlpack__(copy=True)
    monkeypatch.setattr(device_arrays, "_CUDA", 1)
    for field in ON_CARD:
        shared = np.from_dlpack(getattr(hits, field))
        assert shared.tobytes() == np.asarray(getattr(hits, field)).tobytes()
        assert shared.shape == getattr(hits, field).shape
        del shared
    capsule = hits.t.__dlpack__(stream=3)
    assert len(device_arrays._loans) == used + 1
    del capsule
    gc.collect()
    assert len(device_arrays._loans) == used
    origins = rays.origins.copy()
    address, kind, shape, steps, _ = device_arrays._by_dlpack(NumPy(origins[:, ::2]), device_choice._first_device())
    assert (address, kind, shape) == (origins.ctypes.data, "f8", (24, 12, 3))
    assert steps == (72, 6, 1)


class NumPy:
    """An array of NumPy that takes the number of a stream."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, *, stream):
        assert isinstance(stream, int)
        return self.array.__dlpack__()


def test_invalid_arrays_on_a_card_are_refused(card):
    scene, lines = co.Scene([co.Sphere()]), np.ones((4, 3))
    good = OnCard(card, lines)
    wrong = [
        (lambda: scene.first_hit(good, lines), "first_hit: directions must be an array on the card"),
        (lambda: scene.first_hit(good, OnCard(card, lines.astype("i4"))), "of float64 or float32, got one of i4"),
        (lambda: scene.first_hit(good, OnCard(card, lines[:, :2])), r"of shape \(\.\.\., 3\), got \(4, 2\)"),
        (lambda: scene.first_hit(good, OnCard(card, lines[:2])), r"origins \(4, 3\) and directions \(2, 3\) do not"),
        (lambda: scene.contains(OnCard(card, lines, strides=(28, 8))), r"got one of <f8 in steps of \(28, 8\) bytes"),
        (lambda: scene.contains(OnCard(card, lines, mask=good)), "float64 or float32, got one of <f8, or masked"),
        (lambda: scene.first_hit(good, good, device="cpu"), "device must be 'cuda' for arrays on a card, got 'cpu'"),
        (lambda: scene.first_hit(good, good, t_max=good), "t_max must be a number or an array of NumPy's"),
        (lambda: scene.bodies_at(good), "bodies_at: arrays on a card are not taken"),
        (lambda: scene.contains(good, executor=ThreadPoolExecutor(1)), "executor must be left out for arrays on a"),
        (lambda: scene.first_hit(good, OnCard(card, 0 * lines)), "direction must not be zero"),
        (lambda: scene.contains(OnCard(card, np.inf * lines)), "points.* must be finite"),
    ]
    for call, text in wrong:
        with pytest.raises((TypeError, ValueError), match=text):
            call()
    card.card_of = lambda address: 1
    with pytest.raises(ValueError, match="must be on the first card, which Conicoid uses"):
        scene.contains(good)


@pytest.mark.parametrize(
    "query", [lambda: co.Scene([]).first_hit((0, 0, 0), (0, 0, 1), device="gpu"), lambda: co.set_device("gpu")]
)
def test_another_name_is_refused(query):
    with pytest.raises(ValueError, match="device must be 'cpu' or 'cuda', got 'gpu'"):
        query()


class Driver:
    """NVIDIA's module without a card; kernels and memory are those of an emulated one.

    Parameters have the names of cuda-bindings. Functions that need a context fail without one; `failures` are results
    in place of success.
    """

    CUdevice_attribute = types.SimpleNamespace(
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR="major",
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR="minor",
        CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT="units",
        CU_DEVICE_ATTRIBUTE_MAX_THREADS_PER_MULTIPROCESSOR="threads",
    )
    CUfunction_attribute = types.SimpleNamespace(CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES=3)
    CUresult = types.SimpleNamespace(CUDA_ERROR_OUT_OF_MEMORY=2, CUDA_ERROR_NOT_INITIALIZED=3, CUDA_ERROR_NOT_READY=600)
    CUevent_flags = types.SimpleNamespace(CU_EVENT_DISABLE_TIMING=2)
    CUpointer_attribute = types.SimpleNamespace(CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL=9)
    CUstream = staticmethod(lambda number: types.SimpleNamespace(number=number))
    CUstream_flags = types.SimpleNamespace(CU_STREAM_NON_BLOCKING=1)
    TEXTS: ClassVar = {
        100: b"no CUDA-capable device is detected",
        222: b"PTX too new",
        700: b"an illegal memory access",
    }
    WITHOUT = "cuInit", "cuMemcpy", "cuLaunch", "cuStreamQuery"  # a result
    FREE = "cuInit", "cuGetErrorString", "cuDriverGetVersion"

    def __init__(self, card=None, count=1, capability=(8, 6), failures=None):
        self.card, self.count, self.failures = card, count, failures or {}
        self.attributes = dict(zip(("major", "minor"), capability, strict=True), units=2, threads=1536)
        self.contexts, self.pinned, self.is_ready = ["of another library"], {}, False

    def __getattribute__(self, name):
        """Let each function return a tuple that begins with its status."""
        found = object.__getattribute__(self, name)
        if not name.startswith("cu") or name.startswith("cuGet"):
            return found

        def called(*arguments):
            if name in self.failures:
                return (self.failures[name],) if name.startswith(self.WITHOUT) else (self.failures[name], None)
            if not (self.is_ready or name in self.FREE):
                return 3, None
            if not name.startswith(("cuDevice", "cuCtx", "cuInit", "cuDriver")):
                assert self.contexts[-1] == "context", name
            assert not any(isinstance(each, np.generic) for each in arguments)
            answer = found(*arguments)
            return answer if isinstance(answer, tuple) else (0,) if answer is None else (0, answer)

        return called

    def cuInit(self, Flags):
        assert Flags == 0
        self.is_ready = True

    def cuDriverGetVersion(self):
        return 12040

    def cuDeviceGetCount(self):
        return self.count

    def cuDeviceGet(self, ordinal):
        return ordinal

    def cuDeviceGetAttribute(self, attrib, dev):
        return self.attributes[attrib]

    def cuDeviceGetName(self, length, dev):
        return b"A card" + bytes(length - 6)

    def cuDevicePrimaryCtxRetain(self, dev):
        return "context"

    def cuCtxPushCurrent(self, ctx):
        self.contexts.append(ctx)

    def cuCtxPopCurrent(self):
        return self.contexts.pop()

    def cuGetErrorString(self, error):
        return 0, self.TEXTS.get(error, b"another error")

    def cuMemGetInfo(self):
        return 0, self.card.free_memory() if self.card else 1000, 4000

    def cuCtxSynchronize(self):
        pass

    def cuMemAlloc(self, bytesize):
        assert bytesize > 0
        return self.card.allocate(bytesize) if self.card else (2, None)

    def cuMemFree(self, dptr):
        self.card.release(dptr)

    def cuMemHostAlloc(self, bytesize, Flags):
        room = self.card.pinned(bytesize)
        self.pinned[room.ctypes.data] = room
        return room.ctypes.data

    def cuMemFreeHost(self, p):
        del self.pinned[p]

    def cuStreamCreate(self, Flags):
        return (0, self.card.stream()) if self.card else (0, None)

    def cuMemcpyHtoDAsync(self, dstDevice, srcHost, ByteCount, hStream):
        self.card.send(dstDevice, as_array(srcHost, ByteCount), hStream)

    def cuMemcpyDtoHAsync(self, dstHost, srcDevice, ByteCount, hStream):
        self.card.fetch(as_array(dstHost, ByteCount), srcDevice, hStream)

    def cuModuleLoadData(self, image):
        text = ctypes.string_at(image).decode()
        return text.partition(".entry ")[2].partition("(")[0]

    def cuModuleGetFunction(self, hmod, name):
        assert hmod == name.decode()
        return hmod

    def cuFuncGetAttribute(self, attrib, hfunc):
        assert attrib == 3
        return 17_288

    def cuOccupancyMaxActiveBlocksPerMultiprocessor(self, func, blockSize, dynamicSMemSize):
        return 1

    def cuLaunchKernel(
        self, f, gridDimX, gridDimY, gridDimZ, blockDimX, blockDimY, blockDimZ, sharedMemBytes, hStream, kernelParams,
        extra,
    ):  # fmt: skip
        assert (gridDimY, gridDimZ, blockDimY, blockDimZ, sharedMemBytes, extra) == (1, 1, 1, 1, 0, 0)
        assert 0 < gridDimX < 2**31
        assert blockDimX == device.BLOCK
        count = 1 + ptx.parameter_count(f)
        places = (ctypes.c_uint64 * count).from_address(kernelParams)
        values = [ctypes.c_int64.from_address(place).value for place in places]
        self.card.launch(f, values, gridDimX * blockDimX, hStream)

    def cuEventCreate(self, Flags):
        assert Flags == 2
        return "event"

    def cuEventRecord(self, hEvent, hStream):
        self.card.follow(None, hStream.number)

    def cuStreamWaitEvent(self, hStream, hEvent, Flags):
        assert (hEvent, Flags) == ("event", 0)

    def cuEventDestroy(self, hEvent):
        assert hEvent == "event"

    def cuPointerGetAttribute(self, attribute, ptr):
        assert attribute == 9
        return self.card.card_of(ptr)

    def cuStreamQuery(self, hStream):
        return (0 if self.card.is_done(hStream) else 600,)


def as_array(address, size):
    return np.ctypeslib.as_array((ctypes.c_uint8 * size).from_address(address))


@pytest.fixture
def nvidia(monkeypatch, tmp_path):
    """Install both packages without a card; return a function that takes the driver."""

    def install(driver):
        monkeypatch.setattr(nvidia_driver, "_kernels", lambda: tmp_path)
        bindings = types.ModuleType("cuda.bindings")
        bindings.driver = driver
        device_choice._devices.clear()
        monkeypatch.setitem(sys.modules, "cuda", types.ModuleType("cuda"))
        monkeypatch.setitem(sys.modules, "cuda.bindings", bindings)

    return install


@pytest.fixture
def ptx_files(monkeypatch, tmp_path):
    """Write kernels by their names alone, one as machine code for this card and another one, without a card so far."""
    for name in ptx.NAMES:
        (tmp_path / f"{name}.ptx").write_text(f".visible .entry {name}(\n")
    (tmp_path / "first_hits_few.ptx").rename(tmp_path / "first_hits_few.sm_80.cubin")
    (tmp_path / "any_hits_few.sm_90.cubin").write_text("of another card")
    monkeypatch.setattr(device_choice, "_devices", {})
    monkeypatch.setattr(device, "CHUNK", 300)


NO_CARD = "device='cuda' needs a card of NVIDIA's; the driver finds none"


@pytest.mark.parametrize(("driver", "error", "message"), [
    (None, RuntimeError, "device='cuda' needs NVIDIA's driver, and none was found here"),
    (dict(failures={"cuInit": 100}), RuntimeError, rf"{NO_CARD} \(no CUDA-capable device"),
    (dict(capability=(6, 1)), RuntimeError, r"needs compute capability 7\.5; A card has 6\.1"),
    (dict(count=0), RuntimeError, NO_CARD),
    (dict(failures={"cuInit": 3}), RuntimeError, "a process that was forked from one that uses a card cannot use it"),
])  # fmt: skip
def test_missing_parts_are_named(nvidia, driver, error, message, monkeypatch):
    nvidia(types.SimpleNamespace() if driver is None else Driver(**driver))
    with pytest.raises(error, match=message):
        co.set_device("cuda")
    monkeypatch.setenv("CONICOID_DEVICE", "cuda")
    with pytest.raises(error, match=message):  # also for one point, which the CPU answers
        co.Scene([]).contains((0, 0, 0))


def test_missing_bindings_and_memory_are_named(nvidia, monkeypatch):
    monkeypatch.setitem(sys.modules, "cuda", None)
    with pytest.raises(ImportError, match=r"needs NVIDIA's cuda-bindings: pip install 'conicoid\[cuda\]'"):
        co.Scene([]).contains((0, 0, 0), device="cuda")
    nvidia(Driver())
    with pytest.raises(MemoryError, match="device='cuda': 5,000 bytes are needed, 1,000 are free on A card"):
        nvidia_driver.NvidiaDriver().allocate(5000)


@pytest.mark.parametrize(
    ("name", "state", "kind", "text"),
    [
        ("cuMemAlloc", 2, MemoryError, r"[\d,]+ bytes are needed, [\d,]+ are free on A card$"),
        ("cuMemHostAlloc", 2, MemoryError, r"[\d,]+ bytes of the CPU's memory cannot be pinned$"),
        ("cuLaunchKernel", 2, MemoryError, r"53,108,736 bytes are needed, [\d,]+ are free on A card$"),
        (
            "cuModuleLoadData",
            222,
            RuntimeError,
            r"PTX too new; the driver for CUDA 12\.4 cannot load shorten_nodes_each$",
        ),
        ("cuLaunchKernel", 701, RuntimeError, "cuLaunchKernel: another error$"),
        ("cuStreamQuery", 700, RuntimeError, "cuStreamQuery: an illegal memory access; this process cannot use"),
    ],
)
def test_failing_driver_calls_are_named(nvidia, ptx_files, kernels, monkeypatch, name, state, kind, text):
    bindings, rays = Driver(Card(kernels)), camera(24)
    nvidia(bindings)
    scene = crowded_scene.__wrapped__(60)
    bindings.failures[name] = state
    with pytest.raises(kind, match=text):
        scene.first_hit(rays, device="cuda")
    bindings.failures.clear()
    same_answers(scene, rays)  # a lost card stays lost, but the remains in its lanes are not another answer
    assert bindings.contexts == ["of another library"]


def test_the_names_of_arguments_are_those_of_cuda_bindings():
    bindings = pytest.importorskip("cuda.bindings.driver")
    for name, function in vars(Driver).items():
        if name.startswith("cu"):
            mine, theirs = ([*inspect.signature(each).parameters] for each in (function, getattr(bindings, name)))
            assert mine[1:] == theirs, name


def test_the_calls_of_the_driver(nvidia, ptx_files, kernels):
    """The test covers every call but the card's own work: addresses, sizes, and the arguments of a kernel."""
    bindings = Driver(Card(kernels))
    nvidia(bindings)
    points, rays = camera(24).origins + np.linspace(0, 5, 24)[:, None], camera(24)
    for scene in (crowded_scene.__wrapped__(60), co.Scene([carved(150)])):
        same_answers(scene, camera(24))
        assert np.array_equal(scene.body_at(points, device="cuda"), scene.body_at(points))
        there = [OnCard(bindings.card, each) for each in rays]
        same_hits(scene.first_hit(*there).to_host(), scene.first_hit(rays, device="cpu"))
    assert set(bindings.card.followed) == {7}
    bindings.card.check()
    device_choice._devices.clear()
    del scene
    gc.collect()
    assert not bindings.pinned
    assert bindings.contexts == ["of another library"]


def test_memory_stays_for_the_next_array_of_its_size(nvidia, ptx_files, kernels, monkeypatch):
    bindings = Driver(Card(kernels))
    nvidia(bindings)
    driver = nvidia_driver.NvidiaDriver()
    first, free = driver.allocate(5000), driver.free_memory()
    driver.release(first)
    assert driver.free_memory() == free + 5120  # an eighth more at most
    assert driver.allocate(5100) == first
    assert driver.allocate(5100) != first
    driver.release(first)
    third, call = driver.allocate(7000), driver._call

    def call_while_an_array_ends(name, *arguments):
        if name == "cuMemFree" and third in driver._taken:
            driver.release(third)
        return call(name, *arguments)

    driver._call = call_while_an_array_ends
    driver._empty()
    driver._call = call
    assert driver._spare_bytes == 7168
    monkeypatch.setattr(bindings.card, "_size", bindings.card._size - driver.free_memory() + 7168 + 6000)
    second = driver.allocate(9000)  # free memory is reused where the driver has no more
    assert driver._spare_bytes == 0
    monkeypatch.setattr(nvidia_driver, "_MOST_SPARE", 0)
    driver.release(second)
    assert driver._spare_bytes == 0


def test_kernels_of_other_sources_are_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(nvidia_driver, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"needs the kernels in conicoid-cuda: pip install 'conicoid\[cuda\]'"):
        nvidia_driver._kernels()
    monkeypatch.undo()
    package = tmp_path / "conicoid_cuda"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "sources.stamp").write_text("0123\n/kernels/device.py")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ImportError, match="conicoid-cuda was made for another version of Conicoid"):
        nvidia_driver._kernels()
