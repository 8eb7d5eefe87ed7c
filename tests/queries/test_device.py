"""Queries on a GPU that is emulated: the same bits as on the CPU, from NumPy arrays in chunks, and kind refusals."""

from __future__ import annotations

import copy
import ctypes
import gc
import pickle
import sys
import types
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import conicoid as co
from conicoid.queries import device
from native import ptx

from ..emulation import Card, device_kernels
from ..engine.test_routes import camera, crowded_scene
from ..reference.suite import whole_score
from ..reference.whole_items import SCENES
from ..samples import sampled

FIELDS = ("t", "body", "face", "surface", "entering", "doubtful", "point", "normal", "t_error")


@pytest.fixture(scope="module")
def kernels():
    return device_kernels()


@pytest.fixture
def card(kernels, monkeypatch):
    """The card of this process, whose memory is checked at the end."""
    emulated = Card(kernels)
    monkeypatch.setattr(device, "NvidiaDriver", lambda: emulated)
    monkeypatch.setattr(device, "_devices", {})
    monkeypatch.setattr(device, "CHUNK", 500)
    yield emulated
    emulated.check()


def same_hits(one, other):
    for field in FIELDS:
        assert np.array_equal(getattr(one, field), getattr(other, field), equal_nan=True), field


def same_answers(scene, rays, t_max=np.inf):
    """Assert that both devices answer alike, and that a card did."""
    same_hits(scene.first_hit(rays, t_max=t_max, device="cuda"), scene.first_hit(rays, t_max=t_max, device="cpu"))
    there, here = (scene.occluded(rays, t_max=t_max, device=name) for name in ("cuda", "cpu"))
    assert np.array_equal(there, here)


def carved(leaves):
    r = np.random.default_rng(leaves)
    balls = [co.Sphere(0.3).translate(r.uniform(-1.1, 1.1, 3)) for _ in range(leaves - 1)]
    return co.Difference([co.Box((-1, -1, -1), (1, 1, 1)), *balls])


def test_pictures_lists_and_single_rays(card):
    scene, rays = crowded_scene(), camera(48)
    same_answers(scene, rays)
    assert {name for name, _ in card.launches} == {"first_hits_few", "any_hits_few"}
    assert max(threads for _, threads in card.launches) == 500  # in chunks
    same_answers(scene, rays[3], np.linspace(2, 5, 48))
    same_answers(scene, rays[3, 4])
    same_answers(scene, rays[:0])


def test_rays_that_start_on_surfaces(card):
    scene = crowded_scene()
    hits = scene.first_hit(camera(48))
    shadow = hits.spawn(np.where(hits.hit[..., None], np.array([3.0, 5.0, -6.0]) - hits.point, 1.0))
    same_answers(scene, shadow, 1.0)


def test_doubtful_rays_go_to_the_exact_route_and_come_back(card):
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Sphere(1).translate((3, 0, 0))])
    origins = np.array([[2.0, 0.25, 2.0], [0.5, 0.5, 3.0], [2.0, 0.0, 5.0]] * 400)
    directions = np.array([[-1.0, 0, -1], [0, 0, -1], [0, 0, -1]] * 400)
    hits = scene.first_hit(origins, directions, device="cuda")
    assert hits.doubtful.tolist() == [True, False, True] * 400
    same_answers(scene, co.Rays(origins, directions))


@pytest.mark.parametrize("leaves", [3, 40, 150])
def test_points_in_bodies_of_all_sizes(card, leaves):
    scene = co.Scene([carved(leaves), co.Sphere(0.4)])
    r = np.random.default_rng(5)
    points = np.concatenate([r.uniform(-1.2, 1.2, (1200, 3)), [[1, 1, 1], [0, 0, 0.4], [1, 0, 0]]])
    for query in (scene.body_at, scene.contains):
        assert np.array_equal(query(points, device="cuda"), query(points, device="cpu"))
    assert {name for name, _ in card.launches} == {f"first_bodies_{({3: 'few', 40: 'many', 150: 'any'})[leaves]}"}
    assert scene.contains((0, 0, 0.2), device="cuda")
    same_answers(scene, co.Rays(points, r.normal(size=points.shape)))


@pytest.mark.parametrize("kind", sampled(SCENES, 4))
def test_against_exact_arithmetic(card, kind):
    """On small whole numbers, as tests/exactness/test_whole_bodies.py: many rays and points are doubtful."""
    co.set_device("cuda")
    try:
        score = whole_score(kind, 0, 40)
    finally:
        co.set_device(None)
    assert score.rows
    score.check(doubts=False)
    assert {name.rpartition("_")[0] for name, _ in card.launches} == {"first_hits", "any_hits", "first_bodies"}


def test_a_scene_without_bodies_and_what_is_pickled(card):
    empty, scene, rays = co.Scene([]), co.Scene([co.Sphere()]), camera(16)
    for each in (empty, scene):
        same_answers(each, rays)
        assert np.array_equal(each.body_at(rays.origins, device="cuda"), each.body_at(rays.origins))
    hits = scene.first_hit(rays, device="cuda")
    same_hits(pickle.loads(pickle.dumps(hits)), hits)
    same_answers(pickle.loads(pickle.dumps(scene)), rays)
    same_answers(copy.deepcopy(scene), rays)


def test_queries_of_several_threads_take_turns(card):
    scenes = [crowded_scene(), co.Scene([carved(40)]), co.Scene([carved(150)])]
    expected = [scene.first_hit(camera(32)) for scene in scenes]
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda scene: scene.first_hit(camera(32), device="cuda"), scenes))
    for one, other in zip(found, expected, strict=True):
        same_hits(one, other)


def test_tables_are_sent_once_and_again_after_an_edit(card):
    scene = co.Scene([co.Spheres(np.random.default_rng(1).uniform(-1, 1, (2000, 3)), 0.02)])
    points = np.zeros((1, 3))
    scene.contains(points, device="cuda")
    before = card.sent
    scene.contains(points, device="cuda")
    assert card.sent - before < 2000
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


def test_a_card_without_memory_says_how_many_bytes(card):
    card._size = 4096
    with pytest.raises(MemoryError, match=r"bytes are needed, [\d,]+ are free on emulation"):
        crowded_scene(301).first_hit(camera(8), device="cuda")


def test_a_device_for_all_queries(card, monkeypatch):
    scene, rays = crowded_scene(), camera(16)
    expected = scene.first_hit(rays)
    co.set_device("cuda")
    try:
        same_hits(scene.first_hit(rays), expected)
        assert len(card.launches) == 1
        scene.first_hit(rays, device="cpu")
        assert len(card.launches) == 1
    finally:
        co.set_device(None)
    monkeypatch.setenv("CONICOID_DEVICE", "cuda")
    same_hits(scene.first_hit(rays), expected)
    assert len(card.launches) == 2
    monkeypatch.setenv("CONICOID_DEVICE", "gpu")
    with pytest.raises(ValueError, match="CONICOID_DEVICE must be 'cpu' or 'cuda', got 'gpu'"):
        scene.first_hit(rays)


def test_ctrl_c_leaves_no_chunk_behind(card, monkeypatch):
    scene, rays = crowded_scene(), camera(48)
    expected = scene.first_hit(rays)
    usual, calls = card.is_done, []

    def interrupted(stream):
        calls.append(1)
        if len(calls) == 20:
            raise KeyboardInterrupt
        return usual(stream)

    monkeypatch.setattr(card, "is_done", interrupted)
    with pytest.raises(KeyboardInterrupt):
        scene.first_hit(rays, device="cuda")
    same_hits(scene.first_hit(rays, device="cuda"), expected)


def test_another_name_is_refused():
    for query in (lambda: co.Scene([]).first_hit((0, 0, 0), (0, 0, 1), device="gpu"), lambda: co.set_device("gpu")):
        with pytest.raises(ValueError, match="device must be 'cpu' or 'cuda', got 'gpu'"):
            query()


class Driver:
    """NVIDIA's module, as far as it goes without a card; kernels and memory are those of an emulated one."""

    CUdevice_attribute = types.SimpleNamespace(
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR="major",
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR="minor",
        CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT="units",
    )
    CUresult = types.SimpleNamespace(CUDA_ERROR_OUT_OF_MEMORY=2, CUDA_ERROR_NOT_READY=600)
    CUstream_flags = types.SimpleNamespace(CU_STREAM_NON_BLOCKING=1)

    def __init__(self, card=None, count=1, error=0, capability=(8, 6)):
        self.card, self.count, self.error, self.free = card, count, error, 1000
        self.attributes = dict(zip(("major", "minor"), capability, strict=True), units=2)
        self.current, self.pinned = None, {}

    def cuInit(self, flags):
        return (self.error,)

    def cuDeviceGetCount(self):
        return self.error, self.count

    def cuDeviceGet(self, number):
        return 0, number

    def cuDeviceGetAttribute(self, kind, number):
        return 0, self.attributes[kind]

    def cuDeviceGetName(self, size, number):
        return 0, b"A card" + bytes(size - 6)

    def cuDevicePrimaryCtxRetain(self, number):
        return 0, "context"

    def cuCtxSetCurrent(self, context):
        self.current = context
        return (0,)

    def cuGetErrorString(self, number):
        return 0, b"no CUDA-capable device is detected"

    def cuMemGetInfo(self):
        return 0, self.card.free_memory() if self.card else self.free, 4000

    def cuMemAlloc(self, size):
        assert self.current == "context"
        return (0, self.card.allocate(size)) if self.card else (2, 0)

    def cuMemFree(self, address):
        self.card.release(address)
        return (0,)

    def cuMemHostAlloc(self, size, flags):
        room = self.card.pinned(size)
        self.pinned[room.ctypes.data] = room
        return 0, room.ctypes.data

    def cuMemFreeHost(self, address):
        del self.pinned[address]
        return (0,)

    def cuStreamCreate(self, flags):
        return 0, self.card.stream()

    def cuMemcpyHtoDAsync(self, target, source, size, stream):
        self.card.send(target, as_array(source, size), stream)
        return (0,)

    def cuMemcpyDtoHAsync(self, target, source, size, stream):
        self.card.fetch(as_array(target, size), source, stream)
        return (0,)

    def cuModuleLoadData(self, image):
        text = ctypes.string_at(image).decode()
        return 0, text.partition(".entry ")[2].partition("(")[0]

    def cuModuleGetFunction(self, module, name):
        assert module == name.decode()
        return 0, module

    def cuOccupancyMaxActiveBlocksPerMultiprocessor(self, function, block, shared):
        return 0, 1

    def cuLaunchKernel(self, function, gx, gy, gz, bx, by, bz, shared, stream, parameters, extra):
        assert (gy, gz, by, bz, shared, extra) == (1, 1, 1, 1, 0, 0)
        assert bx == device.BLOCK
        count = 1 + ptx.parameter_count(function)
        places = (ctypes.c_uint64 * count).from_address(parameters)
        self.card.launch(function, [ctypes.c_int64.from_address(place).value for place in places], gx * bx, stream)
        return (0,)

    def cuStreamQuery(self, stream):
        return (0 if self.card.is_done(stream) else 600,)


def as_array(address, size):
    return np.ctypeslib.as_array((ctypes.c_uint8 * size).from_address(address))


@pytest.fixture
def nvidia(monkeypatch, tmp_path):
    """Both packages, as far as they go without a card; a function that takes the driver."""

    def install(made):
        monkeypatch.setattr(device, "_kernels", lambda: tmp_path)
        bindings = types.ModuleType("cuda.bindings")
        bindings.driver = made
        monkeypatch.setitem(sys.modules, "cuda", types.ModuleType("cuda"))
        monkeypatch.setitem(sys.modules, "cuda.bindings", bindings)

    return install


def test_what_is_missing_is_named(nvidia, monkeypatch):
    monkeypatch.setitem(sys.modules, "cuda", None)
    with pytest.raises(
        ImportError, match=r"device='cuda' needs NVIDIA's cuda-bindings: pip install 'conicoid\[cuda\]'"
    ):
        co.Scene([]).contains((0, 0, 0), device="cuda")
    nvidia(types.SimpleNamespace())
    with pytest.raises(RuntimeError, match="device='cuda' needs NVIDIA's driver, and none was found here"):
        co.set_device("cuda")
    nvidia(Driver(count=0, error=100))
    with pytest.raises(RuntimeError, match="needs a card of NVIDIA's; the driver finds none \\(no CUDA-capable device"):
        co.set_device("cuda")
    nvidia(Driver(capability=(6, 1)))
    with pytest.raises(RuntimeError, match=r"needs compute capability 7\.5; A card has 6\.1"):
        co.set_device("cuda")
    nvidia(Driver())
    with pytest.raises(MemoryError, match="device='cuda': 5,000 bytes are needed, 1,000 are free on A card"):
        device.NvidiaDriver().allocate(5000)


def test_the_calls_of_the_driver(nvidia, kernels, monkeypatch, tmp_path):
    """Every call but the card's own work: addresses, sizes, how a kernel gets its arguments."""
    for name in ptx.NAMES:
        (tmp_path / f"{name}.ptx").write_text(f".visible .entry {name}(\n")
    made = Driver(Card(kernels))
    nvidia(made)
    monkeypatch.setattr(device, "_devices", {})
    monkeypatch.setattr(device, "CHUNK", 300)
    points = camera(24).origins + np.linspace(0, 5, 24)[:, None]
    for scene in (crowded_scene.__wrapped__(60), co.Scene([carved(150)])):
        same_answers(scene, camera(24))
        assert np.array_equal(scene.body_at(points, device="cuda"), scene.body_at(points))
    made.card.check()
    device._devices.clear()
    del scene
    gc.collect()
    assert not made.pinned


def test_kernels_of_other_sources_are_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(device, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"needs the kernels in conicoid-cuda: pip install 'conicoid\[cuda\]'"):
        device._kernels()
    monkeypatch.undo()
    package = tmp_path / "conicoid_cuda"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "sources.stamp").write_text("0123\n/kernels/device.py")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ImportError, match="conicoid-cuda was made for another version of Conicoid"):
        device._kernels()
