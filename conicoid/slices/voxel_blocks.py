"""Where voxels go as they are worked out, block by block: memory, a file of NumPy's, a folder of zarr's.

Files and folders appear whole or not at all: Ctrl-C or an error leaves nothing behind.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..formats.atomic import checked_place, replacing
from ..shapes.validate import shown

SIDE = 128
"""Voxels along a side of a block of a folder, where there are so many."""
LARGEST = 4 << 30
"""Bytes of arrays in memory."""
Pair = tuple[Any, Any]
"""Ids of bodies and of materials; or shares, and bounds of what these are off by."""
ENDINGS = (".npy", ".zarr")


def refuse_large(counts: Any, columns: int, each: int, path: Any) -> None:
    """ValueError for arrays that would be absurd in memory; OSError for a file that the disk has no room for."""
    size = columns * each * int(np.prod([float(count) for count in counts]))
    times = " x ".join(map(str, counts)) + (f" x {columns}" if columns > 1 else "")
    if path is None and size > LARGEST:
        raise ValueError(
            f"voxels: {times} of them would take {size / 2**30:.0f} GiB; ask for part of the box, or fewer, or have "
            "them written as they come: path='voxels.zarr', or .npy"
        )
    if path is not None and os.path.splitext(path)[1].lower() == ".npy":
        free = shutil.disk_usage(checked_place(path).parent).free
        if size > free:
            raise OSError(28, f"{times} voxels take {size / 2**30:.0f} GiB, and {free / 2**30:.0f} are free", str(path))


def checked_ending(path: str | os.PathLike[str]) -> str:
    """.npy or .zarr; a named ValueError for another ending."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in ENDINGS:
        raise ValueError(
            f"voxels: path must end in {' or '.join(ENDINGS)}, got {shown(os.fspath(path))}; other files are written "
            "by save() of what is in memory"
        )
    return ending


@contextlib.contextmanager
def in_memory(shape: tuple[int, ...], kind: Any) -> Iterator[Pair]:
    """Two arrays."""
    yield np.empty(shape, kind), np.empty(shape, kind)


@contextlib.contextmanager
def in_file(path: Any, shape: tuple[int, ...], kind: Any) -> Iterator[Pair]:
    """The two halves of an array (2, ...) in a file, which has its name once the block has ended."""
    with replacing(path) as partial:
        whole = np.lib.format.open_memmap(partial, mode="w+", dtype=kind, shape=(2, *shape))
        yield whole[0], whole[1]
        whole.flush()
        del whole


@contextlib.contextmanager
def in_folder(
    path: Any, names: tuple[str, str], shape: tuple[int, ...], kind: Any, chunks: tuple[int, ...], more: dict[str, Any]
) -> Iterator[Pair]:
    """Two arrays of a group with these names and attributes; the folder has its name once the block has ended."""
    from ..formats.zarr_folder import zarr_module

    zarr, folder = zarr_module(), Path(path)
    if os.path.lexists(folder):
        raise FileExistsError(17, "is there already", str(path))
    if not folder.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(folder.parent))
    partial = folder.with_name(f".{folder.stem[:40]}-{secrets.token_hex(4)}.zarr")
    try:
        group = zarr.open_group(str(partial), mode="w")
        group.attrs.update(**more)
        one, other = (group.create_array(name, shape=shape, dtype=kind, chunks=chunks) for name in names)
        yield one, other
        os.rename(partial, folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def reopened(path: Any, ending: str, names: tuple[str, str]) -> Pair:
    """The two arrays of a file or folder that is written, to be read piece by piece."""
    if ending == ".npy":
        whole = np.load(path, mmap_mode="r")
        return whole[0], whole[1]
    from ..formats.zarr_folder import zarr_module

    group = zarr_module().open_group(str(path), mode="r")
    return group[names[0]], group[names[1]]


def boxes_of(counts: tuple[int, int, int], most: int) -> Iterator[tuple[slice, slice, slice]]:
    """All voxels in boxes of up to `most`, which begin at multiples of SIDE."""
    step, room = [min(SIDE, count) for count in counts], most
    for axis in (2, 1, 0):  # as long as may be along the last axis, then along that before it
        others = int(np.prod(step)) // step[axis]
        step[axis] = min(counts[axis], step[axis] * max(1, room // (others * step[axis])))
    for x in range(0, counts[0], step[0]):
        for y in range(0, counts[1], step[1]):
            for z in range(0, counts[2], step[2]):
                yield (
                    slice(x, min(counts[0], x + step[0])), slice(y, min(counts[1], y + step[1])),
                    slice(z, min(counts[2], z + step[2])),
                )  # fmt: skip


def rows_of(first: int, second: int, each: int, most: int) -> tuple[int, int]:
    """(rows, columns of a row) of a block of first x second columns of `each` bytes: whole rows, or parts of one."""
    rows = min(first, most // (second * each))
    if rows >= 1:
        return min(rows, SIDE), second
    return 1, min(second, max(SIDE, most // each // SIDE * SIDE))


def summed(array: Any) -> npt.NDArray[np.float64]:
    """Sums of (names, nx, ny, nz) for each name, of an array that need not be in memory."""
    total: npt.NDArray[np.float64]
    if type(array) is np.ndarray:
        total = array.sum(axis=(1, 2, 3))
        return total
    step = max(1, (1 << 24) // max(1, array.shape[0] * array.shape[2] * array.shape[3]))
    parts = [np.asarray(array[:, x : x + step]).sum(axis=(1, 2, 3)) for x in range(0, array.shape[1], step)]
    total = np.sum(parts, axis=0)
    return total
