"""A scene as voxels: what is at their centres, or how much of each a body or a material takes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..engine.answers.no_names import numbers_of
from ..engine.queries.columns import Grid
from ..engine.queries.columns import columns as columns_here
from ..shapes.calls import explained_methods
from ..shapes.calm import calm
from ..shapes.named_parts import Named
from ..shapes.suggestion import one_of
from ..shapes.validate import callback, shown, vector, what, whole
from ..shapes.validate import path as checked_path
from ..shapes.vector import Box, FloatArray
from .colors import body_name, material_name
from .names import BY
from .voxel_blocks import (
    SIDE,
    Pair,
    boxes_of,
    checked_ending,
    in_file,
    in_folder,
    in_memory,
    refuse_large,
    reopened,
    rows_of,
    summed,
)
from .window import AXES

if TYPE_CHECKING:
    from ..engine.threads import Progress
    from ..scene import Scene

_POINTS = 1 << 21  # asked at a time
_BYTES = 1 << 27  # of shares and their bounds, at a time
_MOST_SAMPLES, _MOST_VOXELS = 1024, 1 << 20


@explained_methods
class Voxels:
    """Equal boxes that fill a box, (nx, ny, nz) of them, with what is in each.

    low, high   corners of the whole, (3,)
    shape       (nx, ny, nz)
    spacing     sides of a voxel, (3,)
    body        int32 (nx, ny, nz): the first listed body at each centre, -1 for none; None of fractions
    material    int32 (nx, ny, nz): its place in `materials`, -1 for none; None of fractions
    materials   the different materials of the scene, as `scene.materials`
    names       what each of the fractions is of: bodies, or materials
    fractions   float64 (names, nx, ny, nz): the share of each voxel's volume; None where they were not asked for
    bounds      float64 (names, nx, ny, nz): each fraction is at most so far from the true one; None likewise
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
        """(volumes, by how much they may be off) of what `names` says, within the box: sums of fractions and bounds.

        Raises ValueError for voxels without fractions.
        """
        if self.fractions is None or self.bounds is None:
            raise ValueError("volumes: there are no fractions; ask scene.voxels(..., fractions='body') for them")
        each = float(np.prod(self.spacing))
        return summed(self.fractions) * each, summed(self.bounds) * each

    @calm
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all arrays at `path`: .npz, .zarr, .vti (VTK, for ParaView) or .nrrd (for 3D Slicer).

        In .vti and .nrrd fractions come with their names. Raises ValueError for another suffix, ImportError where the
        extra `zarr`, `vtk` or `nrrd` is not installed, OSError where it cannot be written.
        """
        from .voxel_files import write_voxels

        write_voxels(checked_path("Voxels", path), self)

    def __repr__(self) -> str:
        kind = "ids" if self.fractions is None else f"fractions of {len(self.names)}"
        return f"<Voxels {' x '.join(map(str, self.shape))}, {kind}>"


def voxels_of(
    scene: Scene, bounds: Any, shape: Any, fractions: Any, samples: Any, axis: Any, path: Any,
    progress: Progress | None, executor: Any,
) -> Voxels:  # fmt: skip
    """`Scene.voxels`"""
    callback("voxels", "progress", progress)
    if path is not None:
        path = checked_path("voxels", path)
        checked_ending(path)
    low, high = _checked_bounds(bounds, scene)
    counts = _checked_shape(shape, high - low)
    rays = whole(samples)
    if rays is None or not 1 <= rays <= _MOST_SAMPLES:
        raise ValueError(f"voxels: samples must be a whole number from 1 to {_MOST_SAMPLES}, got {shown(samples)}")
    along = AXES.index(one_of("voxels", "axis", axis, AXES))
    asked = _Asked(scene, low, high, counts, path, progress, executor)
    if fractions is None:
        return _ids(asked)
    return _shares(asked, one_of("voxels", "fractions", fractions, BY), rays, along)


def _checked_bounds(bounds: Any, scene: Scene) -> Box:
    """(low, high), the scene's where they are not given."""
    if bounds is None:
        low, high = scene.bounds
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            raise ValueError("voxels: bounds must be given for a scene without bounds, or without bodies: (low, high)")
    else:
        try:
            low, high = bounds
        except (TypeError, ValueError):
            raise ValueError(f"voxels: bounds must be two corners (low, high), got {what(bounds)}") from None
        low, high = (np.array(vector("voxels", "bounds", corner)) for corner in (low, high))
    if not (low < high).all():
        raise ValueError(
            f"voxels: bounds must have low below high along each axis, got {shown([low.tolist(), high.tolist()])}"
        )
    return low, high


def _checked_shape(shape: Any, size: FloatArray) -> tuple[int, int, int]:
    """(nx, ny, nz), from these or from the number along the longest side, of voxels that are about cubes."""
    listed = isinstance(shape, tuple | list | np.ndarray) and np.ndim(shape) == 1
    sizes = [whole(size) for size in shape] if listed else [whole(shape)]
    given = [size for size in sizes if size is not None and 1 <= size <= _MOST_VOXELS]
    if len(given) != len(sizes) or len(given) != (3 if listed else 1):
        expected = f"(nx, ny, nz) or one whole number, from 1 to {_MOST_VOXELS}"
        raise ValueError(f"voxels: shape must be {expected}, got {shown(shape)}")
    counts = given if listed else [max(1, round(given[0] * float(side / size.max()))) for side in size]
    return counts[0], counts[1], counts[2]


class _Asked(NamedTuple):
    """What voxels of which scene are asked for, and where they go: a path, or None for memory."""

    scene: Scene
    low: FloatArray
    high: FloatArray
    counts: tuple[int, int, int]
    path: Any
    progress: Progress | None
    executor: Any


def _made(
    asked: _Asked, names: tuple[str, str], shape: tuple[int, ...], kind: Any, sides: Any, more: Any, fill: Any
) -> Pair:
    """Two arrays, in memory or on the disk, once fill(them) has filled them block by block. `sides`: of a block."""
    if asked.path is None:
        with in_memory(shape, kind) as pair:
            fill(pair)
        return pair
    ending = checked_ending(asked.path)
    more = dict(low=asked.low.tolist(), high=asked.high.tolist(), **more)
    there = (
        in_file(asked.path, shape, kind) if ending == ".npy" else in_folder(asked.path, names, shape, kind, sides, more)
    )
    with there as pair:
        fill(pair)
        del pair
    return reopened(asked.path, ending, names)


def _ids(asked: _Asked) -> Voxels:
    """What is at the centres."""
    scene, low, high, counts, path, progress, executor = asked
    refuse_large(counts, 1, 8, path)
    prepared = scene.prepared
    materials = Named((material for material, _ in prepared.labels.distinct), "voxels.materials")
    numbers = np.arange(prepared.lowered.body_count)
    table = np.append(prepared.labels.columns_of(numbers, materials) if len(numbers) else numbers, -1).astype(np.int32)
    found = Voxels(low, high, counts, materials=materials)
    centers, total = found.centers, counts[0] * counts[1] * counts[2]

    def fill(pair: Pair) -> None:
        done = 0
        for box in boxes_of(counts, _POINTS):
            sides = (axis[part] for axis, part in zip(centers, box, strict=True))
            part = scene.body_at(np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1), executor=executor)
            pair[0][box], pair[1][box] = part, table[part]
            done += part.size
            if progress is not None:
                progress(done, total)

    names = [material_name(prepared, k) for k in range(len(materials))]
    sides = tuple(min(SIDE, count) for count in counts)
    found.body, found.material = _made(
        asked, ("body", "material"), counts, np.int32, sides, dict(names=[], materials=names), fill
    )
    if path is None:
        found.body, found.material = numbers_of("body", found.body), numbers_of("material", found.material)
    return found


def _shares(asked: _Asked, by: str, samples: int, along: int) -> Voxels:
    """Fractions by chords along an axis."""
    scene, low, high, counts, path, _, _ = asked
    prepared = scene.prepared
    materials = Named((material for material, _ in prepared.labels.distinct), "voxels.materials")
    bodies = prepared.lowered.body_count
    numbers = np.arange(bodies)
    if by == "body":
        groups, names = numbers.astype(np.int32), tuple(body_name(prepared, k) for k in range(bodies))
    else:
        groups = prepared.labels.columns_of(numbers, materials).astype(np.int32) if bodies else numbers.astype(np.int32)
        names = tuple(material_name(prepared, k) for k in range(len(materials)))
    refuse_large(counts, len(names), 16, path)
    order = [(along + 1) % 3, (along + 2) % 3, along]
    spacing = (high - low) / counts
    frame = np.array([*low[order], *spacing[order], counts[order[0]], counts[order[1]]], float)
    first, second, deep = (counts[k] for k in order)
    step = rows_of(first, second, 16 * max(1, len(names)) * deep, _BYTES)

    def fill(pair: Pair) -> None:
        if names:
            _fill_shares(asked, Grid(frame, along, samples), groups, len(names), order, step, pair)

    sides = dict(zip(order, (step[0], min(SIDE, step[1]), min(SIDE, deep)), strict=True))
    fractions, bounds = _made(
        asked, ("fractions", "bounds"), (len(names), *counts), np.float64,
        (1, sides[0], sides[1], sides[2]), dict(names=list(names)), fill,
    )  # fmt: skip
    return Voxels(low, high, counts, materials=materials, names=names, fractions=fractions, bounds=bounds)


def _fill_shares(
    asked: _Asked, grid: Grid, groups: Any, names: int, order: list[int], step: tuple[int, int], pair: Pair
) -> None:
    """Blocks of columns, one after the other."""
    scene, _, _, counts, _, progress, executor = asked
    first, second, deep = (counts[k] for k in order)
    total = first * second
    for row in range(0, first, step[0]):
        for place in range(0, second, step[1]):
            rows, columns = min(first, row + step[0]), min(second, place + step[1])
            begin, end = row * second + place, (rows - 1) * second + columns
            told = _beyond(progress, begin, total)
            if executor is None:
                found = columns_here(scene.prepared, grid, groups, names, deep, begin, end, told)
            else:
                from ..cluster.columns import columns as elsewhere

                found = elsewhere(scene, grid, groups, names, deep, (begin, end), executor, told)
            where = dict(zip(order, (slice(row, rows), slice(place, columns), slice(0, deep)), strict=True))
            for target, part in zip(pair, found, strict=True):
                target[:, where[0], where[1], where[2]] = _in_world(
                    part, [rows - row, columns - place, deep], names, grid.axis
                )


def _beyond(progress: Progress | None, before: int, total: int) -> Progress | None:
    """Told of all columns, where those of a block are counted."""
    return None if progress is None else lambda done, _: progress(before + done, total)


def _in_world(part: FloatArray, counts: list[int], groups: int, along: int) -> FloatArray:
    """(columns, groups, voxels) as (groups, nx, ny, nz)."""
    boxed = part.reshape(counts[0], counts[1], groups, counts[2])  # along the axes `along + 1`, `along + 2`, `along`
    places = {(along + 1) % 3: 0, (along + 2) % 3: 1, along: 3}
    turned: FloatArray = np.ascontiguousarray(boxed.transpose(2, places[0], places[1], places[2]))
    return turned
