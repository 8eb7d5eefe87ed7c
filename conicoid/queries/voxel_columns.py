"""Volume fractions of bodies in voxels, from the chords of rays along columns, each with a bound on its error.

A column of voxels is cut into n x n narrower columns with a ray through the middle of each;
kernels/body/volume_fraction.py bounds the share of a body in a voxel of such a column.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import allocator, helper, inline, kernel, record_shapes
from .._util.records import FloatArray
from ..kernels import tables as table
from ..kernels.body.boolean import read_crossing, region_crossings
from ..kernels.body.scratch import LEAF_COUNT, Scratch, new_scratch
from ..kernels.body.volume_fraction import VoxelPrism, VoxelShares, ball_shares, cell_shares, overlap_length
from ..kernels.bvh.walk import put_box, scene_tree, walk_box, walk_leaves_box
from ..kernels.programs import cell_of_leaf, hold_program, root_value, turn_leaf
from ..kernels.ray import Ray
from ..kernels.surface.exact_crossing import RoundingRest
from ..kernels.tables import BALL, CELL, REGION, Floats, Geometry, Ints, integer, is_halted, whole
from ..kernels.threads import KernelRange, Progress, chunk_size, run_on
from ..prepare.prepared_scene import PreparedScene

_ROUNDING = 2.0**-46
"""A bound on the rounding error of a sum of some thousands of shares."""


@record_shapes(frame="8", axis="0..2", samples="1..1024")
class ColumnGrid(NamedTuple):
    """A grid of voxels in columns: a and b are the axes across the columns, c the axis along them."""

    frame: Floats  # low corner a, b, c; steps a, b, c; number of columns along a and along b
    axis: int  # c: 0, 1 or 2; a and b are the next axes in cyclic order
    samples: int  # rays along each side of a column


class ColumnScratch(NamedTuple):
    """Memory of one thread."""

    ends: Floats  # t of the crossings of a column's ray with a body
    state: Ints  # number of crossings, or -1 before they are computed; 1 if the ray starts inside; number of leaves
    turned: Ints  # leaves that contain a whole voxel


@allocator
def _new_column_scratch(scratch: Scratch) -> ColumnScratch:
    """Allocate memory for one thread."""
    return ColumnScratch(
        np.empty(len(scratch.time)), np.empty(3, np.int32), np.empty(len(scratch.found_leaves), np.int32)
    )


@helper
def _chord_of_region(
    geometry: Geometry, scratch: Scratch, room: ColumnScratch, program: int, ray: Ray, begin: float, end: float
) -> float:
    """Return the share of [begin, end] of a ray inside a Boolean body, whose crossings are computed once per column.

    Invariant: scratch.found_leaves holds room.state[2] leaves, before and after.
    """
    if room.state[0] < 0:
        scratch.found_leaves[LEAF_COUNT] = room.state[2]  # the ray is within the column, so it meets no other leaves
        count, inside, _ = region_crossings(geometry, scratch, program, ray, len(room.ends))
        scratch.found_leaves[LEAF_COUNT] = -1
        for k in range(count):
            room.ends[k] = read_crossing(scratch, k)[0]
        room.state[0], room.state[1] = count, 1 if inside else 0
    within, total, t = room.state[1] == 1, 0.0, ray.t_min
    for k in range(room.state[0]):
        if within:
            total += overlap_length(t, room.ends[k], begin, end)
        within, t = not within, room.ends[k]
    if within:
        total += overlap_length(t, math.inf, begin, end)
    return min(1.0, total / (end - begin))


@helper
def _region_shares(
    geometry: Geometry,
    rest: RoundingRest,
    scratch: Scratch,
    room: ColumnScratch,
    program: int,
    prism: VoxelPrism,
    ray: Ray,
    begin: float,
    end: float,
) -> VoxelShares:
    """Return the bounds on the share of a Boolean body in a voxel, and the share by its chord.

    If several leaves cross the voxel, the error bound is the sum of the widths of their bounds. If only one does, the
    share of the body is that of this leaf, or its complement. Invariant: scratch.found_leaves holds room.state[2]
    leaves.
    """
    turned, parts, off, only, of_only = 0, 0, 0.0, whole(-1), VoxelShares(0.0, 0.0, 0.0)
    hold_program(geometry, scratch.counts, program)
    for k in range(room.state[2]):
        leaf = whole(scratch.found_leaves[k])
        found = cell_shares(geometry, rest, cell_of_leaf(geometry, leaf), prism)
        if found.least >= 1.0:
            turn_leaf(geometry, scratch.counts, program, leaf, True)
            room.turned[turned] = leaf
            turned += 1
        elif found.most > 0.0:
            parts += 1
            off += found.most - found.least
            only, of_only = leaf, found
    without = root_value(geometry, scratch.counts, program)
    with_it = without
    if parts == 1:
        turn_leaf(geometry, scratch.counts, program, only, True)
        with_it = root_value(geometry, scratch.counts, program)
        turn_leaf(geometry, scratch.counts, program, only, False)
    for k in range(turned):
        turn_leaf(geometry, scratch.counts, program, whole(room.turned[k]), False)
    if parts > 1:
        chord = _chord_of_region(geometry, scratch, room, program, ray, begin, end)
        return VoxelShares(max(0.0, chord - off), chord, min(1.0, chord + off))
    if with_it == without:
        share = 1.0 if without else 0.0
        return VoxelShares(share, share, share)
    if with_it:
        return of_only
    return VoxelShares(1.0 - of_only.most, 1.0 - of_only.chord, 1.0 - of_only.least)


@inline
def _in_world_order(axis: int, a: float, b: float, c: float) -> tuple[float, float, float]:
    """Return components a, b, c (across and along the columns) in the order x, y, z."""
    if axis == 0:
        return c, a, b
    return (b, c, a) if axis == 1 else (a, b, c)


@helper
def _entry_into(
    geometry: Geometry,
    rest: RoundingRest,
    scratch: Scratch,
    room: ColumnScratch,
    grid: ColumnGrid,
    boxes: Floats,
    entry: int,
    a: float,
    b: float,
    shares: Floats,
    bounds: Floats,
    i: int,
    at: int,
    count: int,
) -> None:
    """Add an entry's shares of the voxels of a narrow column about (a, b) to shares[i, at:], and bounds likewise."""
    f, axis = grid.frame, whole(grid.axis)
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    low, step = f[2], f[5]
    ha, hb = 0.5 * f[3] / grid.samples, 0.5 * f[4] / grid.samples
    hx, hy, hz = _in_world_order(axis, ha, hb, 0.5 * step)
    dx, dy, dz = _in_world_order(axis, 0.0, 0.0, 1.0)
    ox, oy, oz = _in_world_order(axis, a, b, low)
    ray = Ray(ox, oy, oz, dx, dy, dz, 0.0, count * step, whole(-1))
    # The range of voxels that the entry's box reaches, with one more on either side
    begin, end = (boxes[entry, axis] - low) / step - 1.0, (boxes[entry, axis + 3] - low) / step + 1.0
    first = whole(min(max(begin, 0.0), float(count)))
    last = whole(min(max(end + 1.0, 0.0), float(count)))
    room.state[0] = -1
    if kind == REGION:
        room.state[2] = walk_leaves_box(geometry, scratch.inner_way, index, scratch.found_leaves, len(room.turned))
    for k in range(first, last):
        x, y, z = _in_world_order(axis, a, b, low + (k + 0.5) * step)
        prism = VoxelPrism(x, y, z, hx, hy, hz, axis)
        if kind == BALL:
            found = ball_shares(geometry, rest, index, prism)
        elif kind == CELL:
            found = cell_shares(geometry, rest, index, prism)
        else:
            found = _region_shares(geometry, rest, scratch, room, index, prism, ray, k * step, (k + 1) * step)
        shares[i, at + k] += found.chord
        bounds[i, at + k] += max(found.most - found.chord, found.chord - found.least)


@kernel(boxes="* 6", groups="body_face", voxels="1..m", begin="0..end", end="0..n", shares="out n m", bounds="out n m")
def fill_columns(
    geometry: Geometry,
    rest: RoundingRest,
    grid: ColumnGrid,
    boxes: Floats,
    groups: Ints,
    voxels: int,
    offset: int,
    begin: int,
    end: int,
    shares: Floats,
    bounds: Floats,
) -> None:
    """Write shares[i] and bounds[i], `voxels` numbers for each group, of column offset + i for i from begin to end.

    Values are sums over the n x n narrow columns.
    """
    scratch = new_scratch(geometry)
    room, f, axis, n = _new_column_scratch(scratch), grid.frame, whole(grid.axis), whole(grid.samples)
    ha, hb, across = 0.5 * f[3] / n, 0.5 * f[4] / n, max(1, whole(f[7]))
    for i in range(begin, end):
        column = offset + i
        low_a, low_b = f[0] + (column // across) * f[3], f[1] + (column % across) * f[4]
        for k in range(shares.shape[1]):
            shares[i, k], bounds[i, k] = 0.0, 0.0
        for sub in range(n * n):
            if is_halted(geometry):
                return
            a, b = low_a + (2 * (sub // n) + 1) * ha, low_b + (2 * (sub % n) + 1) * hb
            low = _in_world_order(axis, a - ha, b - hb, f[2])
            high = _in_world_order(axis, a + ha, b + hb, f[2] + voxels * f[5])
            put_box(scratch.way, low, high)
            put_box(scratch.inner_way, low, high)
            count = walk_box(geometry, scratch.way, scene_tree(geometry), scratch.found, len(scratch.found))
            for k in range(count):
                entry: Any = whole(scratch.found[k])
                if integer(geometry, table.ENTRY_KIND, entry) > REGION:
                    continue
                at = whole(groups[whole(entry)]) * voxels
                if 0 <= at <= shares.shape[1] - voxels:
                    _entry_into(
                        geometry, rest, scratch, room, grid, boxes, entry, a, b, shares, bounds, i, at, voxels
                    )  # fmt: skip


_CHUNK = 256  # columns that a thread takes at a time, at most


def voxel_shares(
    scene: PreparedScene, grid: ColumnGrid, groups: Any, count: int, voxels: int, begin: int, end: int,
    progress: Progress | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the shares and bounds on their errors, (columns, groups, voxels) each, of columns begin to end.

    groups: the group of each body, from 0 to `count` (exclusive). The bound of a share other than 0 and 1 includes
    rounding.
    """
    shares, bounds = np.empty((2, end - begin, count * voxels))
    before = scene.rest, grid, scene.lowered.boxes, groups, voxels, begin
    work = KernelRange(fill_columns, before, (shares, bounds))
    rays = (end - begin) * grid.samples**2
    run_on(scene.geometry, work, end - begin, chunk_size(end - begin, _CHUNK), rays, progress)
    shares /= grid.samples**2
    bounds /= grid.samples**2
    bounds += np.where((bounds > 0) | ((shares > 0) & (shares < 1)), _ROUNDING, 0.0)
    return shares.reshape(-1, count, voxels), bounds.reshape(-1, count, voxels)
