"""`Voxels`: the body at the centre of each voxel, or the volume fraction of each body or material in it.

They are computed block by block, in memory or straight into a .npy file or a zarr folder. `save` writes NumPy's .npz,
zarr folders, VTK image data (pyevtk) and NRRD (pynrrd).
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._util.arrays import BoxEnds, FloatArray, ignore_fp_errors
from ..._util.files import replace_file, resolve_output
from ..._util.lazy_names import import_extra
from ..._util.text import NameTuple, check_choice
from ..._util.validation import (
    as_integer,
    check_callback,
    check_path as checked_path,
    check_vector,
    describe_kind,
    format_value,
)
from ...kernels.threads import Progress, run_rows
from ...queries.points import put_grid, put_voxels
from ...queries.scene_protocol import SceneLike
from ...queries.voxel_columns import ColumnGrid, voxel_shares
from ...render.options import BY
from .drawing import body_name, material_name
from .window import AXES


def write_voxels(path: str | os.PathLike[str], voxels: Voxels) -> None:
    """Write voxels in the format of the suffix. Raise ValueError for another suffix."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix not in _WRITERS:
        raise ValueError(f"Voxels: voxels are saved as {', '.join(_WRITERS)}, got {format_value(os.fspath(path))}")
    _WRITERS[suffix](path, voxels)


def arrays_of(voxels: Voxels) -> dict[str, Any]:
    """Return the arrays of the voxels by name, without those that are None."""
    arrays = dict(body=voxels.body, material=voxels.material, fractions=voxels.fractions, bounds=voxels.bounds)
    return {name: array for name, array in arrays.items() if array is not None}


def ids_by_name(voxels: Voxels) -> dict[str, Any]:
    """Return arrays (nx, ny, nz) by name. Names without ASCII letters, and repeated ones, get a number."""
    if voxels.fractions is None or voxels.bounds is None:
        return arrays_of(voxels)
    arrays: dict[str, Any] = {}
    for k, name in enumerate(voxels.names):
        plain = "".join(letter if letter.isalnum() else "_" for letter in name if letter.isascii())
        # A repeated or empty name gets its index, so that no array is lost.
        plain = plain if plain and plain not in arrays else f"{plain}_{k}"
        arrays[plain], arrays[f"{plain}_bound"] = voxels.fractions[k], voxels.bounds[k]
    return arrays


def _write_npz(path: Any, voxels: Voxels) -> None:
    """Write a compressed archive with all arrays, low, high and names."""
    arrays: dict[str, Any] = dict(low=voxels.low, high=voxels.high, names=np.array(voxels.names, str))
    arrays |= arrays_of(voxels)
    with replace_file(path) as file, file.open("wb") as stream:
        np.savez_compressed(stream, **arrays)


def _write_zarr(path: Any, voxels: Voxels) -> None:
    """Write a group of arrays with the attributes low, high and names. The folder appears complete or not at all."""
    from ...io.array_file import new_zarr_group

    with new_zarr_group(path) as group:
        group.attrs.update(low=voxels.low.tolist(), high=voxels.high.tolist(), names=list(voxels.names))
        for name, array in arrays_of(voxels).items():
            group.create_array(name, data=array)


def _write_vti(path: Any, voxels: Voxels) -> None:
    """Write image data with the arrays as cell data; pyevtk appends the suffix itself."""
    vtk = import_extra("pyevtk.hl", ".vti files need pyevtk", "vtk")
    cells = {name: np.asfortranarray(array) for name, array in ids_by_name(voxels).items()}
    low, step = (tuple(map(float, part)) for part in (voxels.low, voxels.spacing))
    with replace_file(path) as file:
        vtk.imageToVTK(os.fspath(file.with_suffix("")), origin=low, spacing=step, cellData=cells)


def _write_nrrd(path: Any, voxels: Voxels) -> None:
    """Write one array: body numbers, or fractions with the names along the first axis."""
    nrrd = import_extra("nrrd", ".nrrd files need pynrrd", "nrrd")
    whole = voxels.body if voxels.fractions is None else voxels.fractions
    center, step = voxels.low + voxels.spacing / 2, np.diag(voxels.spacing)
    # NRRD places an array by the centre of its first voxel.
    header: dict[str, Any] = {"space dimension": 3, "space origin": center}
    if voxels.fractions is None:
        header |= {"space directions": step, "kinds": ["domain"] * 3}
    else:
        header |= {
            "space directions": np.concatenate([np.full((1, 3), np.nan), step]),
            "kinds": ["list", "domain", "domain", "domain"], "names": " ".join(voxels.names),
        }  # fmt: skip
    with replace_file(path) as file:
        nrrd.write(os.fspath(file), np.asarray(whole), header)


_WRITERS: dict[str, Callable[[Any, Voxels], None]] = {
    ".npz": _write_npz, ".zarr": _write_zarr, ".vti": _write_vti, ".nrrd": _write_nrrd,
}  # fmt: skip


# --- Stores that are filled block by block: memory, a .npy file, or a zarr folder
#
# Files and folders appear complete or not at all: Ctrl-C or an error leaves nothing behind.

SIDE = 128
"""Most voxels along a side of a block of a zarr array."""
LARGEST = 4 << 30
"""Most bytes of arrays in memory."""
Pair = tuple[Any, Any]
"""Arrays of body and material numbers; or of fractions and their error bounds."""
ENDINGS = (".npy", ".zarr")
"""Suffixes of `path` for voxels that are written as they are computed."""


def refuse_large(counts: Any, columns: int, each: int, path: Any) -> None:
    """Raise ValueError for arrays too large for memory, OSError for a .npy file larger than the free disk space."""
    size = columns * each * int(np.prod([float(count) for count in counts]))
    times = " x ".join(map(str, counts)) + (f" x {columns}" if columns > 1 else "")
    if path is None and size > LARGEST:
        raise ValueError(
            f"voxels: {times} voxels would take {size / 2**30:.0f} GiB; use smaller bounds or fewer voxels, or write "
            "them to disk: path='voxels.zarr', or .npy"
        )
    if path is not None and os.path.splitext(path)[1].lower() == ".npy":
        free = shutil.disk_usage(resolve_output(path).parent).free
        if size > free:
            raise OSError(28, f"{times} voxels take {size / 2**30:.0f} GiB, and {free / 2**30:.0f} are free", str(path))


def check_ending(path: str | os.PathLike[str]) -> str:
    """Return the suffix, .npy or .zarr. Raise ValueError for another one."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in ENDINGS:
        raise ValueError(
            f"voxels: path must end in {' or '.join(ENDINGS)}, got "
            f"{format_value(os.fspath(path))}; save() writes "
            "other formats, of voxels in memory"
        )
    return ending


@contextlib.contextmanager
def file_store(path: Any, shape: tuple[int, ...], kind: Any) -> Iterator[Pair]:
    """Yield the two halves of an array (2, ...) in a file, which gets its name when the context ends."""
    with replace_file(path) as partial:
        whole = np.lib.format.open_memmap(partial, mode="w+", dtype=kind, shape=(2, *shape))
        yield whole[0], whole[1]
        # The data are written and the map is released before the file gets its name.
        whole.flush()
        del whole


@contextlib.contextmanager
def folder_store(
    path: Any, names: tuple[str, str], shape: tuple[int, ...], kind: Any, chunks: tuple[int, ...], more: dict[str, Any]
) -> Iterator[Pair]:
    """Yield two arrays of a zarr group with names and attributes; the folder gets its name when the context ends."""
    from ...io.array_file import new_zarr_group

    with new_zarr_group(path) as group:
        group.attrs.update(**more)
        one, other = (group.create_array(name, shape=shape, dtype=kind, chunks=chunks) for name in names)
        yield one, other


def reopen(path: Any, ending: str, names: tuple[str, str]) -> Pair:
    """Return the two arrays of a complete file or folder, to be read piece by piece."""
    if ending == ".npy":
        whole = np.load(path, mmap_mode="r")
        return whole[0], whole[1]
    from ...io.array_file import zarr_module

    group = zarr_module().open_group(str(path), mode="r")
    return group[names[0]], group[names[1]]


def block_boxes(counts: tuple[int, int, int], most: int, side: int) -> Iterator[tuple[slice, slice, slice]]:
    """Yield boxes of up to `most` voxels that cover all voxels and begin at multiples of `side`.

    With a side of 1 each box is contiguous in memory.
    """
    # Blocks start as cubes, then grow along the last axes up to the limit.
    step, room = [min(side, count) for count in counts], most
    for axis in (2, 1, 0):  # extend along the last axis first, which is contiguous in memory
        others = int(np.prod(step)) // step[axis]
        step[axis] = min(counts[axis], step[axis] * max(1, room // (others * step[axis])))
    for x in range(0, counts[0], step[0]):
        for y in range(0, counts[1], step[1]):
            for z in range(0, counts[2], step[2]):
                yield (
                    slice(x, min(counts[0], x + step[0])), slice(y, min(counts[1], y + step[1])),
                    slice(z, min(counts[2], z + step[2])),
                )  # fmt: skip


def block_rows(first: int, second: int, each: int, most: int) -> tuple[int, int]:
    """Return (rows, columns of a row) of a block out of first x second columns of `each` bytes.

    A block has whole rows, or a part of one row.
    """
    rows = min(first, most // (second * each))
    if rows >= 1:
        return min(rows, SIDE), second
    return 1, min(second, max(SIDE, most // each // SIDE * SIDE))


def sum_blocks(array: Any) -> npt.NDArray[np.float64]:
    """Return the sum for each name of an array (names, nx, ny, nz), which need not be in memory."""
    total: npt.NDArray[np.float64]
    if type(array) is np.ndarray:
        total = array.sum(axis=(1, 2, 3))
        return total
    # Slabs of about 16 million numbers at a time.
    step = max(1, (1 << 24) // max(1, array.shape[0] * array.shape[2] * array.shape[3]))
    parts = [np.asarray(array[:, x : x + step]).sum(axis=(1, 2, 3)) for x in range(0, array.shape[1], step)]
    total = np.sum(parts, axis=0)
    return total


# --- Voxels of a scene

_POINTS, _ROWS = 1 << 21, 1 << 13  # points of a query; those that a thread takes at a time
_BYTES = 1 << 27  # fractions and their bounds of a block
_MOST_SAMPLES, _MOST_VOXELS = 1024, 1 << 20


class Voxels:
    """A box divided into nx x ny x nz equal voxels, with the contents of each, made by `Scene.voxels`.

    Attributes
    ----------
    low, high : float64 (3,)
        The corners of the box.
    shape : (nx, ny, nz)
    spacing : float64 (3,)
        The sides of a voxel.
    body : int32 (nx, ny, nz)
        The first listed body at each centre, -1 for none. None for voxels with fractions.
    material : int32 (nx, ny, nz)
        Its index in `materials`, -1 for none. None for voxels with fractions.
    materials : tuple
        The distinct materials of the scene, like `scene.materials`.
    names : tuple of str
        The body or material of each fraction.
    fractions : float64 (names, nx, ny, nz)
        The fraction of each voxel's volume. None unless `Scene.voxels` computed fractions.
    bounds : float64 (names, nx, ny, nz)
        The largest error of each fraction. None without fractions.
    """

    def __init__(
        self, low: FloatArray, high: FloatArray, shape: tuple[int, int, int], *, body: Any = None, material: Any = None,
        materials: tuple[Any, ...] = (), names: tuple[str, ...] = (), fractions: Any = None, bounds: Any = None,
    ) -> None:  # fmt: skip
        self.low, self.high, self.shape = low, high, shape
        self.spacing: FloatArray = (high - low) / shape
        self.body: npt.NDArray[np.int32] | None = body
        self.material: npt.NDArray[np.int32] | None = material
        self.materials, self.names = materials, names
        self.fractions: FloatArray | None = fractions
        self.bounds: FloatArray | None = bounds

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Voxels):
            return NotImplemented
        fields = ("low", "high", "shape", "body", "material", "fractions", "bounds")
        same = all(np.array_equal(getattr(self, f), getattr(other, f)) for f in fields)
        return same and (self.materials, self.names) == (other.materials, other.names)

    __hash__ = None  # type: ignore[assignment]

    @property
    def centers(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The coordinates of the voxels' centres along each axis, as `np.meshgrid` takes them."""
        x, y, z = (
            low + (np.arange(count) + 0.5) * step
            for low, count, step in zip(self.low, self.shape, self.spacing, strict=True)
        )
        return x, y, z

    def volumes(self) -> tuple[FloatArray, FloatArray]:
        """Return the volumes within the box, and their largest errors, from sums of fractions and bounds.

        Returns
        -------
        tuple of float64 (names,)
            Volumes and error bounds of the bodies or materials in `names`.

        Raises
        ------
        ValueError
            For voxels without fractions.
        """
        if self.fractions is None or self.bounds is None:
            raise ValueError("volumes: there are no fractions; scene.voxels(..., fractions='body') computes them")
        each = float(np.prod(self.spacing))
        return sum_blocks(self.fractions) * each, sum_blocks(self.bounds) * each

    @ignore_fp_errors
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all arrays to a file or folder. Fractions in .vti and .nrrd carry their names.

        Parameters
        ----------
        path : path-like
            Ends in .npz, .zarr, .vti (VTK, for ParaView) or .nrrd (for 3D Slicer).

        Raises
        ------
        ValueError
            For another suffix.
        ImportError
            If the extra `zarr`, `vtk` or `nrrd` is not installed.
        OSError
            If the file cannot be written.
        """
        write_voxels(checked_path("Voxels", path), self)

    def __repr__(self) -> str:
        kind = "ids" if self.fractions is None else f"fractions of {len(self.names)}"
        return f"<Voxels {' x '.join(map(str, self.shape))}, {kind}>"


def compute_voxels(
    scene: SceneLike, bounds: Any, shape: Any, fractions: Any, samples: Any, axis: Any, path: Any,
    progress: Progress | None, executor: Any,
) -> Voxels:  # fmt: skip
    """Implement `Scene.voxels`."""
    check_callback("voxels", "progress", progress)
    if path is not None:
        path = checked_path("voxels", path)
        check_ending(path)
    low, high = _checked_bounds(bounds, scene)
    counts = _checked_shape(shape, high - low)
    rays = as_integer(samples)
    if rays is None or not 1 <= rays <= _MOST_SAMPLES:
        raise ValueError(
            f"voxels: samples must be a whole number from 1 to {_MOST_SAMPLES}, got {format_value(samples)}"
        )
    along = AXES.index(check_choice("voxels", "axis", axis, AXES))
    request = _VoxelRequest(scene, low, high, counts, path, progress, executor)
    if fractions is None:
        return _ids(request)
    return _shares(request, check_choice("voxels", "fractions", fractions, BY), rays, along)


def _checked_bounds(bounds: Any, scene: SceneLike) -> BoxEnds:
    """Return (low, high); those of the scene if `bounds` is None."""
    if bounds is None:
        low, high = scene.bounds
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            raise ValueError("voxels: bounds must be given for a scene without bounds, or without bodies: (low, high)")
    else:
        try:
            low, high = bounds
        except (TypeError, ValueError):
            raise ValueError(f"voxels: bounds must be two corners (low, high), got {describe_kind(bounds)}") from None
        low, high = (np.array(check_vector("voxels", "bounds", corner)) for corner in (low, high))
    if not (low < high).all():
        raise ValueError(
            "voxels: bounds must have low below high along each axis, got "
            f"{format_value([low.tolist(), high.tolist()])}"
        )
    return low, high


def _checked_shape(shape: Any, size: FloatArray) -> tuple[int, int, int]:
    """Return (nx, ny, nz), from these or, for nearly cubic voxels, from the number along the longest side."""
    listed = isinstance(shape, tuple | list | np.ndarray) and np.ndim(shape) == 1
    sizes = [as_integer(size) for size in shape] if listed else [as_integer(shape)]
    valid = [size for size in sizes if size is not None and 1 <= size <= _MOST_VOXELS]
    if len(valid) != len(sizes) or len(valid) != (3 if listed else 1):
        expected = f"(nx, ny, nz) or one whole number, from 1 to {_MOST_VOXELS}"
        raise ValueError(f"voxels: shape must be {expected}, got {format_value(shape)}")
    # One number is for the longest side; the others follow so that voxels are nearly cubes.
    counts = valid if listed else [max(1, round(valid[0] * float(side / size.max()))) for side in size]
    return counts[0], counts[1], counts[2]


class _VoxelRequest(NamedTuple):
    """The arguments of a call of `Scene.voxels`; without a path, the voxels stay in memory."""

    scene: SceneLike
    low: FloatArray
    high: FloatArray
    counts: tuple[int, int, int]
    path: Any
    progress: Progress | None
    executor: Any


def _fill_voxels(
    request: _VoxelRequest, names: tuple[str, str], shape: tuple[int, ...], kind: Any, sides: Any, more: Any, fill: Any
) -> Pair:
    """Make two arrays in memory or on disk, call fill(them), and return them. `sides` are those of a zarr block."""
    if request.path is None:
        pair = np.empty(shape, kind), np.empty(shape, kind)
        fill(pair)
        return pair
    ending = check_ending(request.path)
    more = dict(low=request.low.tolist(), high=request.high.tolist(), **more)
    store = (
        file_store(request.path, shape, kind)
        if ending == ".npy"
        else folder_store(request.path, names, shape, kind, sides, more)
    )
    with store as pair:
        fill(pair)
        # The views keep the memory map of a .npy file open.
        del pair
    return reopen(request.path, ending, names)


def _ids(request: _VoxelRequest) -> Voxels:
    """Return the bodies and materials at the centres of the voxels."""
    scene, low, high, counts, path, progress, executor = request
    refuse_large(counts, 1, 8, path)
    prepared = scene._prepared
    materials = NameTuple((material for material, _ in prepared.labels.distinct), "voxels.materials")
    voxels = Voxels(low, high, counts, materials=materials)
    centers, total = voxels.centers, counts[0] * counts[1] * counts[2]

    def fill(pair: Pair) -> None:
        filled = 0
        for box in block_boxes(counts, _POINTS, 1 if path is None else SIDE):
            sides = tuple(axis[part] for axis, part in zip(centers, box, strict=True))
            shape = len(sides[0]), len(sides[1]), len(sides[2])
            count = math.prod(shape)
            points = np.empty((*shape, 3))
            run_rows(put_grid, sides, count, points.reshape(-1, 3), most=_ROWS)
            body = scene.body_at(points, executor=executor)
            # Threads write into memory at once; files take whole blocks
            ids = [each[box] if path is None else np.empty(shape, np.int32) for each in pair]
            before = body.reshape(-1), prepared.material_columns
            run_rows(put_voxels, before, count, *(each.reshape(-1) for each in ids), most=_ROWS)
            if path is not None:
                pair[0][box], pair[1][box] = ids
            filled += count
            if progress is not None:
                progress(filled, total)

    names = [material_name(prepared, k) for k in range(len(materials))]
    sides = tuple(min(SIDE, count) for count in counts)
    voxels.body, voxels.material = _fill_voxels(
        request, ("body", "material"), counts, np.int32, sides, dict(names=[], materials=names), fill
    )
    return voxels


def _shares(request: _VoxelRequest, by: str, samples: int, along: int) -> Voxels:
    """Return the fractions of bodies or materials, from chords along an axis."""
    scene, low, high, counts, path, _, _ = request
    prepared = scene._prepared
    materials = NameTuple((material for material, _ in prepared.labels.distinct), "voxels.materials")
    bodies = prepared.lowered.body_count
    if by == "body":
        groups, names = np.arange(bodies, dtype=np.int32), tuple(body_name(prepared, k) for k in range(bodies))
    else:
        groups = prepared.material_columns
        names = tuple(material_name(prepared, k) for k in range(len(materials)))
    refuse_large(counts, len(names), 16, path)
    # Columns run along the last of these axes.
    order = [(along + 1) % 3, (along + 2) % 3, along]
    spacing = (high - low) / counts
    frame = np.array([*low[order], *spacing[order], counts[order[0]], counts[order[1]]], float)
    first, second, deep = (counts[k] for k in order)
    # 16 bytes: a fraction and its bound for each name.
    step = block_rows(first, second, 16 * max(1, len(names)) * deep, _BYTES)

    def fill(pair: Pair) -> None:
        if names:
            _fill_shares(request, ColumnGrid(frame, along, samples), groups, len(names), order, step, pair)

    sides = dict(zip(order, (step[0], min(SIDE, step[1]), min(SIDE, deep)), strict=True))
    fractions, bounds = _fill_voxels(
        request, ("fractions", "bounds"), (len(names), *counts), np.float64,
        (1, sides[0], sides[1], sides[2]), dict(names=list(names)), fill,
    )  # fmt: skip
    return Voxels(low, high, counts, materials=materials, names=names, fractions=fractions, bounds=bounds)


def _fill_shares(
    request: _VoxelRequest,
    grid: ColumnGrid,
    groups: Any,
    names: int,
    order: list[int],
    step: tuple[int, int],
    pair: Pair,
) -> None:
    """Fill fractions and bounds, one block of columns after the other."""
    scene, _, _, counts, _, progress, executor = request
    first, second, deep = (counts[k] for k in order)
    total = first * second
    for row in range(0, first, step[0]):
        for place in range(0, second, step[1]):
            rows, columns = min(first, row + step[0]), min(second, place + step[1])
            # Columns are numbered row by row. A block is whole rows or a part of one, so its numbers are consecutive.
            begin, end = row * second + place, (rows - 1) * second + columns
            block_progress = _beyond(progress, begin, total)
            if executor is None:
                shares = voxel_shares(scene._prepared, grid, groups, names, deep, begin, end, block_progress)
            else:
                from ...parallel.queries import column_shares

                shares = column_shares(scene, grid, groups, names, deep, (begin, end), executor, block_progress)
            slices = dict(zip(order, (slice(row, rows), slice(place, columns), slice(0, deep)), strict=True))
            for target, part in zip(pair, shares, strict=True):
                target[:, slices[0], slices[1], slices[2]] = _in_world(
                    part, [rows - row, columns - place, deep], names, grid.axis
                )


def _beyond(progress: Progress | None, before: int, total: int) -> Progress | None:
    """Return a callback that adds the columns of earlier blocks to the count, out of all columns."""
    return None if progress is None else lambda done, _: progress(before + done, total)


def _in_world(part: FloatArray, counts: list[int], groups: int, along: int) -> FloatArray:
    """Rearrange (columns, groups, voxels) as (groups, nx, ny, nz)."""
    boxed = part.reshape(counts[0], counts[1], groups, counts[2])  # along the axes `along + 1`, `along + 2`, `along`
    places = {(along + 1) % 3: 0, (along + 2) % 3: 1, along: 3}
    return np.ascontiguousarray(boxed.transpose(2, places[0], places[1], places[2]))
