"""The code for GPUs: what its PTX holds, and, run here, that it gives the bits of the kernels of the CPU."""

from __future__ import annotations

import functools
import re
import shutil
import subprocess

import llvmlite.binding as llvm
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.body.hit import is_doubtful
from conicoid.kernels.bvh.culling_constants import SHORT_NODE
from conicoid.kernels.crossings import trace_rows_alone
from conicoid.kernels.device import BY_KIND, EACH, ROW_COLUMNS, SHARED, SIZES, ScratchSize, size_name, sizes_of
from conicoid.kernels.first_hits import HitBuffers, trace_first_alone
from conicoid.kernels.ray import RayArrays
from conicoid.kernels.tables import BALL, CELL, NODE_CHILDREN, length
from conicoid.queries.exact.membership import locate_packets
from native import objects, ptx

from ..emulation import Kernels, device_kernels, device_module, sources_of, stored
from ..engine.test_routes import camera, crowded_scene
from ..reference import aimed_rays
from ..reference.quadratics import Table
from ..reference.random_items import KINDS, extreme, ordinary
from ..reference.random_shapes import generator
from ..reference.solids import bodies
from ..samples import marked

THREADS = 7
"""Fewer than there are rays: each takes several, with the same scratch memory."""
NO_START, ALL_OF_IT = np.full(1, -1, np.int32), (np.zeros(1), np.full(1, np.inf))


@pytest.fixture(scope="module")
def module():
    return device_module()


@pytest.fixture(scope="module")
def kernels():
    return device_kernels()


def addresses(*given):
    """Arrays and numbers as an entry takes them: an array by its address and its length."""
    return [n for each in given for n in ((each,) if isinstance(each, int) else (each.ctypes.data, len(each)))]


def launch(kernels, scene, name, size, *arrays):
    """Run a kernel with scratch memory of a size, which holds garbage at first."""
    geometry = scene._prepared.geometry
    tables = [geometry.places.ctypes.data, *addresses(geometry.integers, geometry.floats)]
    nodes = np.full((int(length(geometry, NODE_CHILDREN)) // 8, SHORT_NODE), 77)
    if name in BY_KIND:
        kernels.run(f"shorten_nodes_{EACH}", [*tables, *addresses(nodes)], THREADS)
        arrays = nodes, *arrays
    arguments = [*tables, *addresses(*arrays)]
    lengths = ScratchSize.needed(geometry).lengths
    kinds = dict(time=np.float64, way=np.float64, inner_way=np.float64, nothing=np.int8)
    room = [np.full(THREADS * size_of_part, 77, kinds.get(part, np.int32)) for part, size_of_part in lengths.items()]
    for part, size_of_part in zip(room, lengths.values(), strict=True):
        if size == SHARED:
            arguments += [part.ctypes.data, size_of_part]
    kernels.run(f"{name}_{size}", arguments, THREADS)


def sizes(scene, function="first_hits"):
    """All sizes of scratch memory that are enough."""
    needed = ScratchSize.needed(scene._prepared.geometry)
    return [name for name in sizes_of(function) if name == SHARED or SIZES[name].holds(needed)]


def same_rays(kernels, scene, rays, names=(), width=0):
    """Assert that both queries of rays give the bits of the CPU; return the hits."""
    n = len(rays.origins)
    expected, found = HitBuffers.new(n), HitBuffers.new(n)
    trace_first_alone(scene._prepared.geometry, rays, 0, n, expected)
    for size in names or sizes(scene):
        for part in found:
            part[:] = 77
        launch(kernels, scene, "first_hits", size, width, *rays, *found)
        # Short boxes are a little wider than boxes, so that a few more rays are left to exact methods
        more = is_doubtful(found.turn) & ~is_doubtful(expected.turn)
        assert more.sum() <= 2 + n // 50
        for name, one, other in zip(found._fields, found, expected, strict=True):
            assert one[~more].tobytes() == other[~more].tobytes(), (size, name)
        result = np.full(n, 77, np.int8)
        launch(kernels, scene, "any_hits", size, width, *rays, result)
        sure = ~is_doubtful(expected.turn) & ~is_doubtful(result)
        assert np.array_equal(result[sure] & 1, (expected.body >= 0)[sure])
        assert not np.any(is_doubtful(result) & ~is_doubtful(expected.turn) & (expected.body < 0) & ~more)
    same_lists(kernels, scene, rays, names or sizes(scene))
    return expected


def same_lists(kernels, scene, rays, names):
    """Assert that certain rays have the rows of the CPU, of spans and of crossings."""
    n = len(rays.origins)
    for columns, spans in ((7, 0), (9, 1)):
        counts, doubts = np.zeros(n, np.int32), np.zeros(n, np.int8)
        rows = trace_rows_alone(scene._prepared.geometry, rays, spans == 1, 0, n, counts, doubts)
        for size in names:
            many, doubtful, offsets = np.full(n, 77, np.int32), np.full(n, 77, np.int8), np.zeros(n + 1, np.int64)
            launch(kernels, scene, "list_rows", size, 0, *rays, spans, offsets, np.empty((0, 1)), many, doubtful)
            np.cumsum(many, out=offsets[1:])
            table = np.empty((offsets[-1], ROW_COLUMNS))
            if len(table):
                launch(kernels, scene, "list_rows", size, 0, *rays, spans, offsets, table, many, doubtful)
            more = (doubtful > doubts).sum()  # as in `same_rays`
            assert more <= 2 + n // 50
            sure = (doubts == 0) & (doubtful == 0)
            mine, its = table[np.repeat(sure, many), :columns], rows[np.repeat(sure, counts)]
            assert mine.tobytes() == its.tobytes(), (size, spans)


def same_points(kernels, scene, points):
    """Assert that the first body around each point is that of the CPU."""
    prepared, n = scene._prepared, len(points)
    for after in (np.full(1, -1, np.int32), np.arange(n, dtype=np.int32) % 5 - 1):
        expected = np.empty(n, np.int32), np.empty(n, np.int8)
        for i in range(n):  # each by itself
            one = expected[0][i : i + 1], expected[1][i : i + 1]
            mine = after[i : i + 1] if len(after) > 1 else after
            locate_packets(prepared.geometry, prepared.rest, points[i : i + 1], mine, 0, 0, 1, *one)
        for size in sizes(scene, "first_bodies"):
            found = np.full(n, 77, np.int32), np.full(n, 77, np.int8)
            launch(kernels, scene, "first_bodies", size, *prepared.rest, points, after, *found)
            assert found[0].tobytes() == expected[0].tobytes(), size
            assert found[1].tobytes() == expected[1].tobytes(), size
    return expected[0]


def carved(leaves):
    """A box without many small balls."""
    r = np.random.default_rng(leaves)
    box = co.Box((-1, -1, -1), (1, 1, 1))
    return co.Difference([box, *(co.Sphere(0.3).translate(r.uniform(-1.1, 1.1, 3)) for _ in range(leaves - 1))])


def arrays_of(origins, directions):
    return RayArrays(np.ascontiguousarray(origins), np.ascontiguousarray(directions), *ALL_OF_IT, NO_START)


def strewn(count, reach=1.5):
    r = np.random.default_rng(3)
    return arrays_of(r.uniform(-reach, reach, (count, 3)), r.normal(size=(count, 3)))


def test_rays_of_a_camera_and_rays_that_start_on_surfaces(kernels):
    scene, rays = crowded_scene(), camera(48)
    hits = scene.first_hit(rays)
    found = same_rays(kernels, scene, arrays_of(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3)))
    assert np.array_equal(found.t, hits.t.ravel())
    spawned = hits[hits.body >= 0].spawn(np.array([3.0, 5.0, -6.0]) - hits.point[hits.body >= 0])
    starts = spawned._starts_in(scene._prepared)
    n = len(starts)
    limits = np.zeros(n), np.linspace(0.1, 1.0, n)
    same_rays(kernels, scene, RayArrays(spawned.origins, spawned.directions, *limits, starts))


@pytest.mark.parametrize("leaves", [3, 8, 9, 40, 64, 65, 150])
def test_booleans_of_every_size(kernels, leaves):
    copies = [carved(leaves).rotate((1, 2, 3), 7.0 * k).translate((3.0 * k, 0, 0)) for k in range(2)]
    scene = co.Scene([*copies, co.Sphere(0.5).translate((0, 0, 2))])
    same_rays(kernels, scene, strewn(300, 4.0))
    r = np.random.default_rng(4)
    inside = same_points(kernels, scene, r.uniform(-1.2, 1.2, (200, 3)))
    assert 0 < np.mean(inside >= 0) < 1


def test_copies_that_share_their_tables(kernels):
    places = np.random.default_rng(6).uniform(-3, 3, (40, 3))
    scene = co.Scene([carved(12).scale(0.3).translate(place) for place in places])
    same_rays(kernels, scene, strewn(400, 4.0))
    same_points(kernels, scene, places + 0.1)


def test_points_within_many_bodies(kernels):
    scene = crowded_scene()
    r = np.random.default_rng(8)
    same_points(kernels, scene, np.concatenate([r.uniform(-1.3, 1.3, (300, 3)), [[np.nan, 0, 0], [0, 0, np.inf]]]))


@pytest.mark.parametrize("sort", [ordinary, extreme])
@pytest.mark.parametrize("kind", KINDS)
def test_bodies_of_all_kinds(kernels, kind, sort):
    """On the rays that are hard for each, as in tests/exactness/test_random_bodies.py."""
    r = generator(f"device {kind}", 0)
    item = sort(kind, r)
    scene = co.Scene([item.shape(co)])
    aim = aimed_rays.Aim(Table(bodies([item])), item.world_center, item.world_size, r)
    rays = arrays_of(*aimed_rays.rays(aim, 120))
    found = same_rays(kernels, scene, rays)
    hit = np.isfinite(found.t)
    same_points(kernels, scene, rays.origins[hit] + found.t[hit, None] * rays.directions[hit])


def test_what_llvm_optimises_for_a_gpu(module):
    """The last form of the code before PTX."""
    target = objects.machine_for(ptx.TRIPLE, ptx.LEVEL)
    names = f"shorten_nodes_{EACH}", "first_hits_few", "any_hits_few", "list_rows_few"

    def optimize() -> bytes:
        whole, kept = llvm.parse_bitcode(module), [ptx.PREFIX + name for name in names]
        for each in (*whole.functions, *whole.global_variables):
            if not each.is_declaration:
                each.linkage = "external" if each.name in kept else "internal"
        objects.optimize(whole, target, is_short=True)
        return whole.as_bitcode()

    scene, rays = crowded_scene(), camera(48)
    arrays = arrays_of(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))
    optimised = stored(f"optimised {sources_of(module)}", optimize)
    same_rays(Kernels(optimised), scene, arrays, ["few"])


@functools.cache
def ptx_of(name):
    """The PTX of a kernel, which takes seconds. `ptx.ptx` refuses what is wrong; the CUDA wheel has all."""
    return ptx.ptx(device_module(), name)


MOST_USED = ["any_hits_few", "list_rows_few"]
"""Kernels that most scenes need."""
SMALL = [name for name in ptx.PARTS["queries"] if name.endswith(f"_{EACH}")]


@pytest.mark.parametrize("name", marked((name, name in (*MOST_USED, *SMALL[::5])) for name in ptx.PARTS["queries"]))
def test_ptx_rounds_as_the_cpu_does(name):
    """Some of what `ptx.ptx` looks at is there."""
    text = ptx_of(name)
    assert f".entry {name}(" in text
    assert ".target sm_75" in text
    assert f".maxnreg {ptx.REGISTERS.get(name.rpartition('_')[2], ptx.MOST_REGISTERS)}" in text
    assert len(re.findall(r"\bmul\.rn\.f64\b", text)) > 100 or name.endswith(f"_{EACH}")
    assert "_ZN" not in text


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("mul.f64 %rd1, %rd2, %rd3;", "rounds by mul.f64"),
        ("add.rm.f32 %r1, %r2, %r3;", "rounds by add.rm.f32"),
        ("cvt.ftz.f64.f32 %rd1, %r2;", "has .ftz"),
        ("@%p1 ex2.approx.f32 %r1, %r2;", "rounds by ex2.approx.f32; has .approx"),
        ("fma.rn.f64 %rd1, %rd2, %rd3, %rd4;", "fuses what the code does not"),
        ("call.uni (retval0), malloc, (param0);", "calls malloc"),
        ('.b8 name[3] = "/home";', "names a place"),
    ],
)
def test_ptx_that_rounds_otherwise_is_refused(line, wrong):
    assert "; ".join(ptx.wrong_with_ptx(f"\t{line}\n", 0)) == wrong


@pytest.mark.skipif(shutil.which("ptxas") is None, reason="NVIDIA's assembler is not here")
@pytest.mark.parametrize("name", MOST_USED)
def test_registers_and_spills_are_within_bounds(tmp_path, name):
    """Few spills in the loop over nodes, none that local memory would be large for."""
    source = tmp_path / "kernel.ptx"
    source.write_text(ptx_of(name))
    command = ["ptxas", "-v", "-arch=sm_75", "-o", str(tmp_path / "kernel.cubin"), str(source)]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    entry = said[said.index(f"for {name}") :]
    frame, stores, loads = map(
        int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+)", entry).groups()
    )
    assert int(re.search(r"Used (\d+) registers", said)[1]) <= ptx.MOST_REGISTERS
    assert frame < 8192
    assert max(stores, loads) < 512


def test_a_scene_has_the_smallest_size_that_is_enough():
    for needed, name in (
        (ScratchSize(1, 1, 40, BALL), "balls"), (ScratchSize(1, 1, 40, CELL), "cells"), (ScratchSize(1, 1, 40), "few"),
        (ScratchSize(8, 3, 40), "few"), (ScratchSize(3, 9, 40), "many"), (ScratchSize(65, 9, 40), SHARED),
        (ScratchSize(1, 1, 97, BALL), SHARED),
    ):  # fmt: skip
        assert size_name("first_hits", needed) == name
    assert size_name("first_bodies", ScratchSize(1, 1, 40, BALL)) == "few"
