"""The arrays that kernels read: a scene, lowered. Everything refers to everything else by number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, load_atomic, record_shapes

# Numbers in a row of a table of floats
PLANE_SIZE, SPHERE_SIZE, ANCHOR_SIZE, FORM_SIZE, NODE_SIZE, MAP_SIZE, FRAME_SIZE = 7, 4, 4, 16, 48, 4, 9
BOUNDS_SIZE, SHIFT_SIZE, PLACE_SIZE = 6, 4, 4
QUADRIC_SIZE = 3 + FORM_SIZE
"""Numbers of a quadric: its anchor, and its form."""

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
    """Surfaces, cells, programs, sheets, entries and their tree, as named arrays. Row counts in brackets."""

    # Surfaces: each distinct one once. [surfaces]
    surface_kind: Signs
    surface_row: Ints  # row in the table of its kind
    planes: Floats  # [planes, 7] normal, height of the anchor over the plane, anchor
    spheres: Floats  # [spheres, 4] center, radius
    quadrics: (
        Floats  # [quadrics, 4] anchor; row of its form, and of what rounding took from its numbers (`decide.Rest`)
    )
    quadric_forms: Floats  # [forms, 16] rows, squares, linear, constant; those that are one another moved share one

    # Cells: at most one quadric, and planes. [cells]
    cell_quadric: Ints  # surface or -1
    cell_likes: Ints  # [cells] or none: twice the row of face and limits, alike in those moved; 1 more: other side
    cell_face: Ints  # 1 + face number of the quadric; negative: inside where that is >= 0; 1: none (faces.py)
    cell_first: Ints  # [cells + 1] first plane
    plane_surface: Ints  # [planes of cells]
    plane_face: Ints  # 1 + face number; negative: inside where n·x >= offset; four in one, if these are fewer

    # Programs: Boolean trees as counting gates. What follows of those that differ by where they are, but for the cells
    # of their leaves, is there once: in rows that `program_shifts` tell (programs.py)
    program_leaf: Ints  # [programs + 1] first leaf; with `program_shifts` its cell
    program_gate: Ints  # [programs that differ + 1] first gate, which is the root
    program_row: Ints  # [programs that differ + 1] or none: row of the first leaf
    leaf_cell: Ints  # [leaves]; none with `program_shifts`
    leaf_gate: Ints  # [leaves of programs that differ] the gate it feeds
    leaf_negated: Signs  # 1: feeds the complement
    leaf_sense: Signs  # +1, or -1 under an odd number of complements: which way its faces look
    leaf_bounds: Floats  # [the same, 6] low, high; infinite where unbounded; less `shifts`
    program_shifts: Ints  # [programs, 4] or none: rows of `shifts` for x, y, z; its own row
    shifts: Floats  # how far bounds of leaves are moved
    gate_parent: Ints  # [gates] -1 for a root
    gate_need: Ints  # true when at least so many inputs are
    gate_negated: Signs  # 1: feeds the complement of its value
    gate_start: Ints  # true inputs while every leaf is outside

    # Sheets. [sheets]
    sheet_surface: Ints
    sheet_program: Ints  # what clips it, or -1
    sheet_side: Signs  # +1: its normal is the gradient
    sheet_one_sided: Signs
    polygon_surface: Ints  # [polygons] its plane
    polygon_side: Signs  # +1: its normal is the plane's
    polygon_first: Ints  # [polygons + 1] first vertex
    polygon_program: Ints
    vertices: Floats  # [vertices, 3]

    # Entries: what the tree holds, one a body, with its number. [bodies]
    entry_kind: Signs
    entry_index: Ints  # surface, cell, program, sheet or polygon
    body_face: Ints  # first face row; -1 - k: a ball of many, with frame k
    ball_frames: Floats  # [frames, 9] world directions to those of the balls' own axes
    face_maps: Ints  # [faces, 3] rows of its map from the world; -1 - the first where it is angular, else third = first
    body_maps: (
        Ints  # [bodies, 4] or none are: where bodies that are one another moved find theirs (`kernels/body/uv.py`)
    )
    map_rows: Floats  # [rows, 4] (a, b, c, d) for a x + b y + c z + d

    # Trees, 8 wide: one over the leaves of each program, empty if these are few; last the scene's over its entries
    node_boxes: Floats  # [nodes, 6, 8] low xyz, high xyz; infinite where what they hold is; (inf, -inf) where empty
    node_children: Ints  # [nodes, 8] 0 empty; > 0 node; < 0 leaf -(first << 4 | count) - 1
    tree_order: Ints  # what the trees hold, in leaf order
    tree_root: Ints  # [programs + 2] first of its roots
    roots: Ints  # where a walk begins: a node, and leaves of what no box holds
    tree_depth: Ints  # [1] the most that a walk's stack holds
    leaf_items: Floats  # [6 a place of the scene's tree] what leaves hold: see kernels/bvh/walk.py
    extent: Floats  # [5] diagonal of the box of what is bounded, an entry's share of it, its middle

    # How far the fast formulas can be trusted (prepare/error_limits.py)
    plane_limits: Floats  # [planes, 2] square of the least certain rate, least certain height of parallel rays
    quadric_limits: Floats  # [forms, 2] least certain discriminant, least certain value along rulings
    cell_limits: Floats  # [cells, 2] what t may be off by, for |d| = 1; the farthest |o| + |t d|; see `cell_likes`
    program_limits: Floats  # [programs that differ, 2] the same
    sheet_limits: Floats  # [sheets, 2]
    polygon_limits: Floats  # [polygons, 2]

    @property
    def rows_of_forms(self) -> npt.NDArray[np.intp]:
        """(quadrics,) the row of each one's form, and of what rounding took from its numbers."""
        return self.quadrics[:, 3].astype(np.intp)

    def whole_quadrics(self, rows: Any = slice(None)) -> Floats:
        """(n, 19) of some rows: anchor, rows, squares, linear, constant."""
        return whole_quadrics(self.quadrics[rows], self.quadric_forms)

    def bounds_of_leaves(self, program: int) -> Floats:
        """(n, 6) boxes around the leaves of a program."""
        if not len(self.program_shifts):
            return self.leaf_bounds[self.program_leaf[program] : self.program_leaf[program + 1]]
        *away, like = self.program_shifts[program].tolist()
        rows = slice(*self.program_row[like : like + 2].tolist())
        return self.leaf_bounds[rows] + np.tile(self.shifts[away], 2)


def whole_quadrics(quadrics: Floats, forms: Floats) -> Floats:
    """(n, 19) anchor, rows, squares, linear, constant of rows of `Tables.quadrics`."""
    return np.concatenate([quadrics[:, :3], forms[quadrics[:, 3].astype(np.intp)]], axis=1)


# The number of each table, by which kernels find it
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
) = range(56)
LENGTHS = len(Tables._fields)
"""In `Geometry.places` a table's length is stored so many places behind its begin."""
HALT = 2 * LENGTHS
"""In `Geometry.places`: not 0 if kernels are to end early; what they return then is discarded."""
STEPS = HALT + 1
"""In `Geometry.places`: about how many steps one ray may take at most, if it meets all there is."""
LEAVES, GATES = 2 * LENGTHS + 2, 2 * LENGTHS + 3
"""In `Geometry.places`: the most leaves, and the most gates, of a program; at least 1."""
ITEMS = 2 * LENGTHS + 4
"""In `Geometry.places`: where `leaf_items` would begin if the trees of bodies, which come first, had items as well."""


@record_shapes(places="117", integers="*", floats="*")
class Geometry(NamedTuple):
    """`Tables` as kernels take them: end to end in one array of integers and one of floats.

    Passing three arrays of one dimension from function to function is cheap, forty would not be. Kernels read all of
    it and write none of it.
    """

    places: Longs  # [2 tables + 5] where each table begins, then their lengths; HALT, STEPS, LEAVES, GATES, ITEMS
    integers: Ints
    floats: Floats


SPARE = 8  # floats after the last: leaves are read eight at a time
LINE = 8  # floats in a line of memory; every table of floats begins at one


def line_array(count: int) -> Floats:
    """An array that begins at a line of memory."""
    room = np.zeros(count + LINE)  # memory that nobody writes to is never taken
    skip = -room.ctypes.data % (LINE * room.itemsize) // room.itemsize
    return room[skip : skip + count]


def pack(geometry: Geometry, columns: dict[str, npt.NDArray[Any]], later: tuple[str, ...] = ()) -> None:
    """Lay the columns of tables end to end in the `room_for` them; those called `later` the caller fills in.

    Each is taken out of `columns` as it is copied, so that a large scene is never in memory twice: the largest first,
    as each is there twice for a while.
    """
    for k in sorted(range(LENGTHS), key=lambda k: -columns[Tables._fields[k]].nbytes):
        name = Tables._fields[k]
        table = columns.pop(name)
        if name not in later:
            _room(geometry, k, table)[...] = table


def room_for(tables: Tables) -> Geometry:
    """Room for tables of these shapes end to end, which the caller fills, floats being 0; and then `put_sizes`."""
    places, integers, floats = places_of(tables)
    return Geometry(places, np.empty(integers, np.int32), line_array(floats + SPARE))


def places_of(tables: Tables, order: Sequence[int] = range(LENGTHS)) -> tuple[Longs, int, int]:
    """(`Geometry.places`, how many integers, how many floats) of tables of these shapes end to end in some order."""
    arrays: tuple[npt.NDArray[Any], ...] = tables
    places = np.zeros(2 * LENGTHS + 5, np.int64)
    ends = [0, 0]
    for k in order:
        table = arrays[k]
        real = table.dtype == np.float64
        places[k], places[LENGTHS + k] = ends[real], table.size
        ends[real] += -(-table.size // LINE) * LINE if real else table.size
    return places, ends[0], ends[1]


def put_sizes(geometry: Geometry, tables: Tables) -> None:
    """Put what is said of all programs into `geometry.places`.

    For `STEPS` every entry and corner is met; and of a body every leaf, which may turn all gates.
    """
    shares, gates = len(tables.program_shifts) > 0, np.diff(tables.program_gate).astype(np.int64)
    leaves = np.diff(tables.program_row if shares else tables.program_leaf).astype(np.int64)
    times = np.bincount(tables.program_shifts[:, -1], minlength=len(gates)) if shares else np.ones(len(gates), np.int64)
    geometry.places[STEPS] = len(tables.entry_kind) + len(tables.vertices) + int(np.dot(leaves * gates, times))
    geometry.places[LEAVES], geometry.places[GATES] = (int(np.max(each, initial=1)) for each in (leaves, gates))


def unpack_tables(tables: Tables, geometry: Geometry) -> Tables:
    """The tables that were packed, as views of what kernels take."""
    arrays: tuple[npt.NDArray[Any], ...] = tables
    return Tables(*(_room(geometry, k, table) for k, table in enumerate(arrays)))


def _room(geometry: Geometry, k: int, table: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The part of the packed arrays that belongs to table k, in its shape."""
    begin, size = int(geometry.places[k]), int(length(geometry, k))
    numbers: npt.NDArray[Any] = geometry.floats if table.dtype == np.float64 else geometry.integers
    return numbers[begin : begin + size].reshape(-1, *table.shape[1:]) if size else numbers[:0].reshape(table.shape)


@inline
def whole(x: float) -> Any:
    """A number as an int64: of a literal, or of an integer that is stored among floats."""
    return np.int64(x)


@inline
def is_halted(geometry: Geometry) -> bool:
    """Has the query been interrupted? Kernels then end early, and their results are discarded."""
    return load_atomic(geometry.places, HALT) != 0


@inline
def poll_halt(geometry: Geometry, k: int) -> bool:
    """`halted`, tested in one of 64 rounds of a loop; k counts the rounds."""
    return (k & 63) == 0 and is_halted(geometry)


@inline
def integer(geometry: Geometry, table: int, index: int) -> Any:
    """An element of a table of integers, an int64."""
    return np.int64(geometry.integers[np.uint64(geometry.places[table] + index)])


@inline
def real(geometry: Geometry, table: int, index: int) -> float:
    """An element of a table of floats, counted flat."""
    return geometry.floats[np.uint64(geometry.places[table] + index)]


@inline
def node_at(geometry: Geometry, node: int) -> int:
    """Where in the floats the eight boxes of a node begin."""
    return geometry.places[NODE_BOXES] + NODE_SIZE * node


@inline
def box_at(geometry: Geometry, box: int) -> int:
    """Where in the floats a box, 8 node + child, has the first of its six sides, which are 8 apart."""
    return geometry.places[NODE_BOXES] + NODE_SIZE * (box >> 3) + (box & 7)


@inline
def length(geometry: Geometry, table: int) -> int:
    """How many elements a table has."""
    return geometry.places[LENGTHS + table]
