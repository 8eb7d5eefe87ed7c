"""A scene as voxels: what is at their centres, or how much of each a body or a material takes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..engine.answers.no_names import numbers_of
from ..engine.queries.columns import Grid, columns
from ..shapes.calls import explained_methods
from ..shapes.calm import calm
from ..shapes.named_parts import Named
from ..shapes.suggestion import one_of
from ..shapes.validate import callback, shown, vector, what, whole
from ..shapes.validate import path as checked_path
from ..shapes.vector import Box, FloatArray
from .colors import body_name, material_name
from .names import BY
from .window import AXES

if TYPE_CHECKING:
    from ..engine.threads import Progress
    from ..scene import Scene

LARGEST = 4 << 30
_POINTS = 1 << 21  # asked at a time
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
        return self.fractions.sum(axis=(1, 2, 3)) * each, self.bounds.sum(axis=(1, 2, 3)) * each

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
    scene: Scene, bounds: Any, shape: Any, fractions: Any, samples: Any, axis: Any, progress: Progress | None,
    executor: Any,
) -> Voxels:  # fmt: skip
    """`Scene.voxels`"""
    callback("voxels", "progress", progress)
    low, high = _checked_bounds(bounds, scene)
    counts = _checked_shape(shape, high - low)
    rays = whole(samples)
    if rays is None or not 1 <= rays <= _MOST_SAMPLES:
        raise ValueError(f"voxels: samples must be a whole number from 1 to {_MOST_SAMPLES}, got {shown(samples)}")
    along = AXES.index(one_of("voxels", "axis", axis, AXES))
    if fractions is None:
        return _ids(scene, low, high, counts, progress, executor)
    by = one_of("voxels", "fractions", fractions, BY)
    return _shares(scene, low, high, counts, by, rays, along, progress, executor)


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
    _refuse_large(counts, 1, 8)
    return counts[0], counts[1], counts[2]


def _refuse_large(counts: Any, columns: int, each: int) -> None:
    """ValueError for arrays that would be absurd."""
    size = columns * each * int(np.prod([float(count) for count in counts]))
    if size > LARGEST:
        times = " x ".join(map(str, counts)) + (f" x {columns}" if columns > 1 else "")
        raise ValueError(
            f"voxels: {times} of them would take {size / 2**30:.0f} GiB; ask for part of the box, or fewer"
        )


def _ids(
    scene: Scene, low: FloatArray, high: FloatArray, counts: tuple[int, int, int], progress: Progress | None,
    executor: Any,
) -> Voxels:  # fmt: skip
    """What is at the centres, some planes of voxels at a time."""
    prepared = scene.prepared
    materials = Named((material for material, _ in prepared.labels.distinct), "voxels.materials")
    found = Voxels(low, high, counts, body=np.empty(counts, np.int32), materials=materials)
    x, y, z = found.centers
    step, each = max(1, _POINTS // (counts[1] * counts[2])), counts[1] * counts[2]
    assert found.body is not None
    for first in range(0, counts[0], step):
        part = np.stack(np.meshgrid(x[first : first + step], y, z, indexing="ij"), axis=-1)
        found.body[first : first + step] = scene.body_at(part, executor=executor)
        if progress is not None:
            progress(min(counts[0], first + step) * each, counts[0] * each)
    numbers = np.arange(prepared.lowered.body_count)
    table = np.append(prepared.labels.columns_of(numbers, materials) if len(numbers) else numbers, -1)
    found.material = numbers_of("material", table[found.body].astype(np.int32))
    found.body = numbers_of("body", found.body)
    return found


def _shares(
    scene: Scene, low: FloatArray, high: FloatArray, counts: tuple[int, int, int], by: str, samples: int, along: int,
    progress: Progress | None, executor: Any,
) -> Voxels:  # fmt: skip
    """Fractions by chords along an axis."""
    prepared = scene.prepared
    materials = Named((material for material, _ in prepared.labels.distinct), "voxels.materials")
    bodies = prepared.lowered.body_count
    numbers = np.arange(bodies)
    if by == "body":
        groups, names = numbers.astype(np.int32), tuple(body_name(prepared, k) for k in range(bodies))
    else:
        groups = prepared.labels.columns_of(numbers, materials).astype(np.int32) if bodies else numbers.astype(np.int32)
        names = tuple(material_name(prepared, k) for k in range(len(materials)))
    _refuse_large(counts, len(names), 16)
    order = [(along + 1) % 3, (along + 2) % 3, along]
    spacing = (high - low) / counts
    frame = np.array([*low[order], *spacing[order], counts[order[0]], counts[order[1]]], float)
    grid, total, deep = Grid(frame, along, samples), counts[order[0]] * counts[order[1]], counts[along]
    if not names:
        shares = bounds = np.zeros((total, 0, deep))
    elif executor is None:
        shares, bounds = columns(prepared, grid, groups, len(names), deep, 0, total, progress)
    else:
        from ..cluster.columns import columns as elsewhere

        shares, bounds = elsewhere(scene, grid, groups, len(names), deep, total, executor, progress)
    made = [_in_world(part, [counts[k] for k in order], len(names), along) for part in (shares, bounds)]
    return Voxels(low, high, counts, materials=materials, names=names, fractions=made[0], bounds=made[1])


def _in_world(part: FloatArray, counts: list[int], groups: int, along: int) -> FloatArray:
    """(columns, groups, voxels) as (groups, nx, ny, nz)."""
    boxed = part.reshape(counts[0], counts[1], groups, counts[2])  # along the axes `along + 1`, `along + 2`, `along`
    places = {(along + 1) % 3: 0, (along + 2) % 3: 1, along: 3}
    turned: FloatArray = np.ascontiguousarray(boxed.transpose(2, places[0], places[1], places[2]))
    return turned
