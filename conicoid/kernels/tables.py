"""The arrays that kernels read: a prepared scene, whose rows refer to each other by number.

`Tables` has the arrays by name; `Geometry` has the same numbers end to end in two arrays, as compiled code takes them.
`build_scene_trees` packs them, `unpack_tables` gives them back, and accessors at the end read elements in kernels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, load_atomic, record_shapes

# Floats in a row of each table of floats
PLANE_SIZE, SPHERE_SIZE, ANCHOR_SIZE, FORM_SIZE, NODE_SIZE, MAP_SIZE, FRAME_SIZE = 7, 4, 4, 16, 48, 4, 9
BOUNDS_SIZE, SHIFT_SIZE, PLACE_SIZE, GROUP_SIZE, LINKS = 6, 4, 4, 10, 5
QUADRIC_SIZE = 3 + FORM_SIZE
"""Floats of a whole quadric: its anchor (3) and its form (16)."""

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int32]
Signs: TypeAlias = npt.NDArray[np.int8]
Longs: TypeAlias = npt.NDArray[np.int64]
Flags: TypeAlias = npt.NDArray[np.bool_]

# Kinds of surface
PLANE, SPHERE, QUADRIC = 0, 1, 2
# Kinds of entry (a leaf of the scene's tree)
BALL, CELL, REGION, SHEET, POLYGON = 0, 1, 2, 3, 4


class Tables(NamedTuple):
    """Surfaces, cells, programs, sheets, entries and their trees, as named arrays.

    Comments give the number of rows in brackets. Where bodies are translated copies of each other, the rows that
    translation does not change are stored once, and the copies share them.
    """

    # Surfaces: one row for each distinct surface. [surfaces]
    surface_kind: Signs
    surface_row: Ints  # row in the table of its kind
    planes: Floats  # [planes, 7] normal, height of the anchor over the plane, anchor
    spheres: Floats  # [spheres, 4] center, radius
    quadrics: Floats  # [quadrics, 4] anchor; row of its form and of its rounding rest (`exact_crossing.RoundingRest`)
    quadric_forms: Floats  # [forms, 16] rows W, squares, linear terms, constant; translated copies share a row

    # Cells: at most one quadric, and planes. [cells]
    cell_quadric: Ints  # surface or -1
    cell_likes: Ints  # [cells] or empty: 2 * (row of face and limits, shared by copies) + 1 if the side is reversed
    cell_face: Ints  # 1 + face number of the quadric, 1 without one; negative: inside where it is >= 0 (faces.py)
    cell_first: Ints  # [cells + 1] first plane
    plane_surface: Ints  # [planes of cells]
    plane_face: Ints  # 1 + face number; negative: inside where n·x >= offset; if shorter, four bytes in an integer

    # Groups of the planes of cells that have many (kernels/body/cell.py), a tree for each such cell. [groups]
    cell_groups: Ints  # [cells + 1] first group; or empty
    group_bounds: Floats  # [groups, 10] middle and half widths of the box of normals, anchor, least height there
    group_planes: (
        Ints  # [groups, 5] up to four planes, numbers in the cell or -1; groups of the branch, itself included
    )

    # Programs: Boolean trees as counting gates. Programs that are translated copies of each other share all rows but
    # the cells of their leaves; `program_shifts` holds the row of each (programs.py)
    program_leaf: Ints  # [programs + 1] first leaf; with `program_shifts` the cell of the first leaf
    program_gate: Ints  # [distinct programs + 1] first gate, which is the root
    program_row: Ints  # [distinct programs + 1] or empty: row of the first leaf
    leaf_cell: Ints  # [leaves]; empty with `program_shifts`
    leaf_gate: Ints  # [leaves of distinct programs] the gate it feeds
    leaf_negated: Signs  # 1: feeds the complement
    leaf_sense: Signs  # +1, or -1 under an odd number of complements: the direction of its faces' normals
    leaf_bounds: Floats  # [leaves of distinct programs, 6] low, high, without `shifts`; infinite where unbounded
    program_shifts: Ints  # [programs, 4] or empty: rows of `shifts` for x, y, z; its row in the shared tables
    shifts: Floats  # lengths by which bounds of leaves are translated
    gate_parent: Ints  # [gates] -1 for a root
    gate_need: Ints  # the gate is true when at least this many inputs are
    gate_negated: Signs  # 1: feeds the complement of its value
    gate_start: Ints  # true inputs while every leaf is outside

    # Sheets. [sheets]
    sheet_surface: Ints
    sheet_program: Ints  # the program that clips it, or -1
    sheet_side: Signs  # +1: its normal is the gradient
    sheet_one_sided: Signs
    polygon_surface: Ints  # [polygons] its plane
    polygon_side: Signs  # +1: its normal is the plane's
    polygon_first: Ints  # [polygons + 1] first vertex
    polygon_program: Ints
    vertices: Floats  # [vertices, 3]

    # Entries: the items of the scene's tree, one for each body, with the body's number. [bodies]
    entry_kind: Signs
    entry_index: Ints  # surface, cell, program, sheet or polygon
    body_face: Ints  # first face row; -1 - k: a ball made in bulk, with frame k
    ball_frames: Floats  # [frames, 9] rotation from world directions to the axes of a bulk ball
    face_maps: Ints  # [faces, 3] rows of its map from the world; -1 - the first where it is angular, else third = first
    body_maps: Ints  # [bodies, 4] or empty: where translated copies find their maps (body/uv.py)
    map_rows: Floats  # [rows, 4] (a, b, c, d) for a x + b y + c z + d

    # Trees, 8 wide: one over the leaves of each program, empty for few leaves; last the scene's tree over its entries
    node_boxes: Floats  # [nodes, 6, 8] low xyz, high xyz; infinite for unbounded content; (inf, -inf) where empty
    node_children: Ints  # [nodes, 8] 0 empty; > 0 node; < 0 leaf -(first << 4 | count) - 1
    tree_order: Ints  # the items of all trees, in leaf order
    tree_root: Ints  # [programs + 2] first of its roots
    roots: Ints  # where a walk begins: a node, and leaves of items without a box
    tree_depth: Ints  # [1] the largest height of a walk's stack
    leaf_items: Floats  # [6 for each place of the scene's tree] the content of leaves (bvh/walk.py)
    extent: Floats  # [5] diagonal of the box of all bounded entries, one entry's share of it, its center

    # Limits within which the fast formulas are certain (prepare/error_limits.py)
    plane_limits: Floats  # [planes, 2] square of the least certain rate, least certain height of parallel rays
    quadric_limits: Floats  # [forms, 2] least certain discriminant, least certain value along rulings
    cell_limits: Floats  # [cells or rows of `cell_likes`, 2] error of t for |d| = 1; farthest certain |o| + |t d|
    program_limits: Floats  # [distinct programs, 2] the same
    sheet_limits: Floats  # [sheets, 2] the same
    polygon_limits: Floats  # [polygons, 2] the same

    @property
    def rows_of_forms(self) -> npt.NDArray[np.intp]:
        """(quadrics,) row of each quadric's form and of its rounding rest."""
        return self.quadrics[:, 3].astype(np.intp)

    def whole_quadrics(self, rows: Any = slice(None)) -> Floats:
        """Return (n, 19) anchor, rows W, squares, linear terms and constant of some rows of `quadrics`."""
        return whole_quadrics(self.quadrics[rows], self.quadric_forms)

    def bounds_of_leaves(self, program: int) -> Floats:
        """Return (n, 6) boxes, low then high, around the leaves of a program."""
        if not len(self.program_shifts):
            return self.leaf_bounds[self.program_leaf[program] : self.program_leaf[program + 1]]
        *shift_rows, shared_row = self.program_shifts[program].tolist()
        rows = slice(*self.program_row[shared_row : shared_row + 2].tolist())
        return self.leaf_bounds[rows] + np.tile(self.shifts[shift_rows], 2)


def whole_quadrics(quadrics: Floats, forms: Floats) -> Floats:
    """Return (n, 19) anchor, rows W, squares, linear terms and constant of (n, 4) rows of `Tables.quadrics`."""
    return np.concatenate([quadrics[:, :3], forms[quadrics[:, 3].astype(np.intp)]], axis=1)


# The number of each table in `Geometry.places`: kernels cannot look up a field by name
(
    SURFACE_KIND,
    SURFACE_ROW,
    PLANES,
    SPHERES,
    QUADRICS,
    QUADRIC_FORMS,
    CELL_QUADRIC,
    CELL_LIKES,
    CELL_FACE,
    CELL_FIRST,
    PLANE_SURFACE,
    PLANE_FACE,
    CELL_GROUPS,
    GROUP_BOUNDS,
    GROUP_PLANES,
    PROGRAM_LEAF,
    PROGRAM_GATE,
    PROGRAM_ROW,
    LEAF_CELL,
    LEAF_GATE,
    LEAF_NEGATED,
    LEAF_SENSE,
    LEAF_BOUNDS,
    PROGRAM_SHIFTS,
    SHIFTS,
    GATE_PARENT,
    GATE_NEED,
    GATE_NEGATED,
    GATE_START,
    SHEET_SURFACE,
    SHEET_PROGRAM,
    SHEET_SIDE,
    SHEET_ONE_SIDED,
    POLYGON_SURFACE,
    POLYGON_SIDE,
    POLYGON_FIRST,
    POLYGON_PROGRAM,
    VERTICES,
    ENTRY_KIND,
    ENTRY_INDEX,
    BODY_FACE,
    BALL_FRAMES,
    FACE_MAPS,
    BODY_MAPS,
    MAP_ROWS,
    NODE_BOXES,
    NODE_CHILDREN,
    TREE_ORDER,
    TREE_ROOT,
    ROOTS,
    TREE_DEPTH,
    LEAF_ITEMS,
    EXTENT,
    PLANE_LIMITS,
    QUADRIC_LIMITS,
    CELL_LIMITS,
    PROGRAM_LIMITS,
    SHEET_LIMITS,
    POLYGON_LIMITS,
) = range(59)
LENGTHS = len(Tables._fields)
"""In `Geometry.places`, distance from a table's begin to its length."""
HALT = 2 * LENGTHS
"""In `Geometry.places`: not 0 if kernels shall end early; callers then discard their results."""
STEPS = HALT + 1
"""In `Geometry.places`: about the most steps that one ray may take, if it meets every body."""
LEAVES, GATES = 2 * LENGTHS + 2, 2 * LENGTHS + 3
"""In `Geometry.places`: the largest numbers of leaves and of gates of a program; at least 1."""
ITEMS = 2 * LENGTHS + 4
"""In `Geometry.places`: where `leaf_items` would begin if the programs' trees, which come first, had items as well."""


@record_shapes(places="123", integers="*", floats="*")
class Geometry(NamedTuple):
    """`Tables` for kernels: end to end in one array of integers and one of floats.

    Passing three one-dimensional arrays from function to function is cheap; passing one for each table would not be.
    Kernels only read it.
    """

    places: Longs  # [2 tables + 5] where each table begins, then their lengths; HALT, STEPS, LEAVES, GATES, ITEMS
    integers: Ints
    floats: Floats


SPARE = 8  # floats after the last one: kernels read leaves eight floats at a time
LINE = 8  # floats in a cache line; every table of floats begins at one


def line_array(count: int) -> Floats:
    """Return `count` zeros that begin at a cache line."""
    room = np.zeros(count + LINE)  # the system supplies zeroed pages on first write, so unused ones cost nothing
    skip = -room.ctypes.data % (LINE * room.itemsize) // room.itemsize
    return room[skip : skip + count]


def room_for(tables: Tables) -> Geometry:
    """Return a `Geometry` for tables of these shapes, its floats 0 and its integers not initialised.

    The caller fills it, then calls `put_sizes`.
    """
    places, integers, floats = places_of(tables)
    return Geometry(places, np.empty(integers, np.int32), line_array(floats + SPARE))


def places_of(tables: Tables, order: Sequence[int] = range(LENGTHS), spare_rows: int = 0) -> tuple[Longs, int, int]:
    """Return `Geometry.places` and the numbers of integers and of floats for tables of these shapes.

    `order` is the order in which the tables lie in memory; each table of floats begins at a cache line. Behind each
    table there is room for `spare_rows` more rows.
    """
    arrays: tuple[npt.NDArray[Any], ...] = tables
    places = np.zeros(2 * LENGTHS + 5, np.int64)
    ends = [0, 0]
    for k in order:  # `ends` counts integers, then floats
        table = arrays[k]
        real = table.dtype == np.float64
        places[k], places[LENGTHS + k] = ends[real], table.size
        size = table.size + spare_rows * math.prod(table.shape[1:])
        ends[real] += -(-size // LINE) * LINE if real else size
    return places, ends[0], ends[1]


def put_sizes(geometry: Geometry, tables: Tables) -> None:
    """Write `STEPS`, `LEAVES` and `GATES` into `geometry.places`.

    `STEPS` counts every entry and every vertex once, and for each leaf of each program all of its gates.
    """
    shares, gates = len(tables.program_shifts) > 0, np.diff(tables.program_gate).astype(np.int64)
    leaves = np.diff(tables.program_row if shares else tables.program_leaf).astype(np.int64)
    times = np.bincount(tables.program_shifts[:, -1], minlength=len(gates)) if shares else np.ones(len(gates), np.int64)
    geometry.places[STEPS] = len(tables.entry_kind) + len(tables.vertices) + int(np.dot(leaves * gates, times))
    geometry.places[LEAVES], geometry.places[GATES] = (int(np.max(each, initial=1)) for each in (leaves, gates))


def unpack_tables(tables: Tables, geometry: Geometry) -> Tables:
    """Return the packed tables as views of a geometry's arrays, in the shapes of `tables`."""
    arrays: tuple[npt.NDArray[Any], ...] = tables
    return Tables(*(_room(geometry, k, table) for k, table in enumerate(arrays)))


def _room(geometry: Geometry, k: int, table: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the part of the packed arrays that belongs to table k, in the table's shape."""
    begin, size = int(geometry.places[k]), int(length(geometry, k))
    numbers: npt.NDArray[Any] = geometry.floats if table.dtype == np.float64 else geometry.integers
    return numbers[begin : begin + size].reshape(-1, *table.shape[1:]) if size else numbers[:0].reshape(table.shape)


@inline
def whole(x: float) -> Any:
    """Return a literal, or an integer that is stored as a float, as an int64."""
    return np.int64(x)


@inline
def is_halted(geometry: Geometry) -> bool:
    """True if the query was interrupted: kernels then end early, and their results are discarded."""
    return load_atomic(geometry.places, HALT) != 0


@inline
def poll_halt(geometry: Geometry, k: int) -> bool:
    """`is_halted`, tested in one of 64 rounds of a loop; k counts the rounds."""
    return (k & 63) == 0 and is_halted(geometry)


@inline
def integer(geometry: Geometry, table: int, index: int) -> Any:
    """Return an element of a table of integers as an int64; `index` counts flat."""
    # Unsigned, so that Numba emits no test for a negative index
    return np.int64(geometry.integers[np.uint64(geometry.places[table] + index)])


@inline
def real(geometry: Geometry, table: int, index: int) -> float:
    """Return an element of a table of floats; `index` counts flat."""
    return geometry.floats[np.uint64(geometry.places[table] + index)]


@inline
def node_at(geometry: Geometry, node: int) -> int:
    """Return the place in the floats where the eight boxes of a node begin."""
    return geometry.places[NODE_BOXES] + NODE_SIZE * node


@inline
def box_at(geometry: Geometry, box: int) -> int:
    """Return the place in the floats of the first of six sides of a box, 8 node + child; the sides are 8 apart."""
    return geometry.places[NODE_BOXES] + NODE_SIZE * (box >> 3) + (box & 7)


@inline
def length(geometry: Geometry, table: int) -> int:
    """Return the number of elements of a table."""
    return geometry.places[LENGTHS + table]
