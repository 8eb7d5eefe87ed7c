"""Voxels that are written block by block: the same as in memory, complete or absent."""

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.section import voxels, voxels as voxel_blocks

from ..interruptions import Interruption

SCENE = co.Scene([
    co.Body(co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5), co.matte("red", name="red"), "ring"),
    co.Body(co.Box((0.5, -1, -1), (1.5, 1, 0.5)), co.matte("blue", name="blue")),
])  # fmt: skip
WINDOW = (-1.25, -1.3, -1.2), (1.2, 1.25, 1.35)
SHAPE = 11, 13, 9


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Make blocks small, as if there were many voxels."""
    monkeypatch.setattr(voxel_blocks, "SIDE", 4)
    monkeypatch.setattr(voxels, "SIDE", 4)
    monkeypatch.setattr(voxels, "_POINTS", 130)
    monkeypatch.setattr(voxels, "_BYTES", 16 * 2 * 9 * 30)


@pytest.fixture(params=[".npy", ".zarr"])
def path(request, tmp_path):
    if request.param == ".zarr":
        pytest.importorskip("zarr")
    return tmp_path / f"voxels{request.param}"


def same_voxels(stored, in_memory):
    return np.array_equal(np.asarray(stored[...]), in_memory)


@pytest.mark.parametrize(
    "counts", [SHAPE, (1, 1, 1), (40, 1, 3), (3, 50, 2), (2, 3, 130), (9, 13, 10), (5, 65, 2), (3, 2, 200)]
)
@pytest.mark.parametrize("side", [4, 1])
def test_boxes_hold_each_voxel_once(side, counts):
    visits = np.zeros(counts, int)
    for box in voxel_blocks.block_boxes(counts, 130, side):
        assert visits[box].size <= 130
        assert all(part.start % side == 0 for part in box)
        assert side > 1 or visits[box].flags.c_contiguous
        visits[box] += 1
    assert (visits == 1).all()


@pytest.mark.parametrize(("first", "second", "each"), [(10, 10, 1), (10, 10, 20), (10, 300, 1), (10, 300, 100)])
def test_rows_are_whole_or_parts_of_one(first, second, each):
    rows, columns = voxel_blocks.block_rows(first, second, each, 600)
    assert rows == 1 or columns == second
    assert columns == second or columns % 4 == 0
    assert rows * columns * each <= max(600, 4 * each)


def test_ids_are_those_in_memory(path):
    calls = []
    stored = SCENE.voxels(WINDOW, SHAPE, path=path, progress=lambda done, count: calls.append((done, count)))
    in_memory = SCENE.voxels(WINDOW, SHAPE)
    x, y, z = in_memory.centers
    assert (in_memory.body == SCENE.body_at(np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1))).all()
    assert same_voxels(stored.body, in_memory.body)
    assert same_voxels(stored.material, in_memory.material)
    assert not stored.body[:1].flags.owndata or path.suffix == ".zarr"
    assert len(calls) > 5
    assert calls[-1] == (11 * 13 * 9, 11 * 13 * 9)
    assert [each.name for each in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("room", [16 * 2 * 9 * 30, 16 * 2 * 9 * 5])
def test_fractions_are_those_in_memory(path, axis, room, monkeypatch):
    monkeypatch.setattr(voxels, "_BYTES", room)
    options = dict(fractions="material", samples=2, axis=axis)
    stored, in_memory = SCENE.voxels(WINDOW, SHAPE, path=path, **options), SCENE.voxels(WINDOW, SHAPE, **options)
    assert same_voxels(stored.fractions, in_memory.fractions)
    assert same_voxels(stored.bounds, in_memory.bounds)
    (ring, box), (off, edge) = stored.volumes()
    # a ball with a bore keeps 4/3 π h³ for the half height h of its wall
    assert abs(ring - 4 / 3 * math.pi * 0.75**1.5) <= off
    assert abs(box - 0.7 * 2 * 1.5) <= edge
    monkeypatch.setattr(voxels, "_BYTES", 1 << 27)
    assert same_voxels(in_memory.fractions, SCENE.voxels(WINDOW, SHAPE, **options).fractions)


def test_files_hold_their_window(path):
    SCENE.voxels(WINDOW, SHAPE, path=path, fractions="body")
    if path.suffix == ".npy":
        shares, bounds = np.load(path, mmap_mode="r")
        assert shares.shape == bounds.shape == (2, *SHAPE)
        return
    import zarr

    group = zarr.open_group(str(path), mode="r")
    assert group.attrs["low"] == list(WINDOW[0])
    assert group.attrs["names"] == ["ring", "body 1"]
    assert group["fractions"].chunks[0] == 1


@pytest.mark.parametrize("options", [{}, dict(fractions="body")])
def test_interrupted_work_leaves_no_files(path, options):
    with pytest.raises(KeyboardInterrupt):
        SCENE.voxels(WINDOW, SHAPE, path=path, progress=Interruption(2), **options)
    assert list(path.parent.iterdir()) == []


def test_workers_write_the_same(path):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(2) as executor:
        there = SCENE.voxels(WINDOW, SHAPE, path=path, fractions="body", executor=executor)
    assert same_voxels(there.fractions, SCENE.voxels(WINDOW, SHAPE, fractions="body").fractions)


def test_paths_that_cannot_be(tmp_path, monkeypatch):
    for call, error, message in (
        (
            lambda: SCENE.voxels(WINDOW, SHAPE, path=tmp_path / "voxels.vti"),
            ValueError,
            r"path must end in \.npy or \.zarr, got '",
        ),
        (
            lambda: SCENE.voxels(WINDOW, SHAPE, path=tmp_path / "none" / "voxels.npy"),
            FileNotFoundError,
            "no such folder",
        ),
        (lambda: SCENE.voxels(WINDOW, (1 << 20, 1 << 20, 1 << 20), path=tmp_path / "voxels.npy"), OSError, "GiB"),
        (lambda: SCENE.voxels(WINDOW, (1 << 11, 1 << 10, 1 << 10)), ValueError, r"path='voxels\.zarr'"),
    ):
        with pytest.raises(error, match=message):
            call()
    assert list(tmp_path.iterdir()) == []
