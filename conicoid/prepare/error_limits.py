"""Limits of the fast formulas: how far they can be trusted, and from where on a ray is marked as doubtful.

Every bound of docs/dev/exactness.md depends on a scene only through a few numbers of each surface and cell. They are
computed here, once, from the constants of `kernels/surface/doubt.py`. R is how far the bodies that a surface bounds
reach from its anchor; kappa is the share of a value's terms by which rounding may change it; the bounds hold for rays
within `far` of the scene.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, kernel, record_shapes
from .._util.records import dataclass
from ..kernels.programs import MODEL_ROW, rows_of_programs
from ..kernels.surface.doubt import FAR, KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES, RELATIVE
from ..kernels.tables import (
    BALL,
    CELL,
    PLANE,
    POLYGON,
    QUADRIC,
    REGION,
    SHEET,
    SPHERE,
    Floats,
    Ints,
    Signs,
    Tables,
    whole,
)
from .mmap_arrays import mapped_zeros, own_memory
from .surface_features import Remainders

# Kernels: every use of a surface, by a cell, a sheet or a polygon in the box of an entry, is weighed one by one.
# They read each number once and store nothing, where arrays of all uses would be larger than the scene.
_LEAST = 1e-100
"""Times the square of the least component of a direction, this still does not underflow."""
_WIDE, _WIDEST = 2.0**10, 2.0**20
"""Unbounded bodies count as so many times as large as the scene; those of exact planes as so many times."""


@record_shapes(
    kind="s", row="s", planes="p 7", spheres="b 4", quadrics="q 4", forms="f 16", lost_of_planes="p 7",
    lost_of_quadrics="l 19",
)  # fmt: skip
class RecordTables(NamedTuple):
    """The surface records of a scene, and the remainders of planes and quadrics."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: Floats
    forms: Floats
    lost_of_planes: Floats
    lost_of_quadrics: Floats

    @classmethod
    def of(cls, tables: Tables, rest: Remainders) -> RecordTables:
        """Collect the records of a scene. In finished tables all integers have one type: kinds are narrowed here."""
        t, kind = tables, tables.surface_kind.astype(np.int8, copy=False)
        return cls(kind, t.surface_row, t.planes, t.spheres, t.quadrics, t.quadric_forms, rest.planes, rest.quadrics)


@inline
def _is_row(records: RecordTables, surface: int) -> bool:
    """Return whether a surface has this number, with a record."""
    if not 0 <= surface < len(records.kind):
        return False
    kind, row = records.kind[surface], records.row[surface]
    if kind == PLANE:
        return 0 <= row < len(records.planes)
    if kind == SPHERE:
        return 0 <= row < len(records.spheres)
    if not 0 <= row < len(records.quadrics):
        return False
    form = _form(records, row)
    return 0 <= form < len(records.forms) and form < len(records.lost_of_quadrics)


@inline
def _form(records: RecordTables, row: int) -> int:
    """Return the row of a quadric's form, which is also that of its remainders."""
    return whole(records.quadrics[row, 3])


@inline
def _anchor(records: RecordTables, surface: int, axis: int) -> float:
    kind, row = records.kind[surface], records.row[surface]
    if kind == PLANE:
        return records.planes[row, 4 + axis]
    return records.spheres[row, axis] if kind == SPHERE else records.quadrics[row, axis]


@inline
def _is_inexact(lost: Floats, row: int) -> bool:
    """Return whether anything was rounded in a record."""
    found = 0
    for k in range(lost.shape[1]):
        found += 1 if lost[row, k] != 0.0 else 0
    return found > 0


@inline
def _is_bounded(boxes: Floats, entry: int) -> bool:
    ends = 0
    for k in range(6):
        ends += 1 if abs(boxes[entry, k]) < math.inf else 0
    return ends == 6


@inline
def _reach(records: RecordTables, boxes: Floats, surface: int, entry: int, bounded: bool, size: float) -> float:
    """Return how far from its anchor a surface is used: a sphere its radius, others the farthest corner of the box."""
    # A ball is used to its radius, whatever box it is cut by
    if records.kind[surface] == SPHERE:
        return records.spheres[records.row[surface], 3]
    if not bounded:
        return _WIDE * size
    square = 0.0
    for k in range(3):
        anchor = _anchor(records, surface, k)
        below, above = abs(boxes[entry, k] - anchor), abs(boxes[entry, k + 3] - anchor)
        largest = below if below > above else above
        square += largest * largest
    # Rounded up; never 0, so that kappa, which divides by the reach, is finite
    return math.sqrt(square) * (1 + 1e-12) + 1e-300


@inline
def _kappa(records: RecordTables, surface: int, reach: float) -> float:
    """Return kappa: the share of a value's terms by which rounding may change it."""
    kind, row = records.kind[surface], records.row[surface]
    if kind == SPHERE:
        return KAPPA_OF_BALLS
    if kind == PLANE:
        return KAPPA_OF_PLANES if _is_inexact(records.lost_of_planes, row) else 0.0
    lost, square = _form(records, row), 0.0
    for k in range(3):
        square += records.lost_of_quadrics[lost, k] * records.lost_of_quadrics[lost, k]
    # The anchor of a quadric is rounded by `square`, which moves the surface by a share of its reach
    return KAPPA + 8.0 * math.sqrt(square) / reach


@inline
def _larger(known: float, x: float) -> float:
    """Return the larger of two numbers; NaN if `known` or `x` is NaN."""
    return known if known >= x or known != known else x


@inline
def _weigh_use(
    records: RecordTables, boxes: Floats, size: float, s: int, p: int, o: int, e: int, bounded: bool, limits: Floats,
    most: Floats,
) -> None:  # fmt: skip
    """Add one use to the limits: surface s, its column p of `most`, owner o, entry e, which a box bounds or not."""
    reach = _reach(records, boxes, s, e, bounded, size)
    kappa = _kappa(records, s, reach)
    # The bounds hold within `far`; rounding of positions adds RELATIVE times the distance `around`.
    around, far = _WIDE * size, FAR * reach
    if bounded:
        around = 0.0
        for k in range(6):
            around += abs(boxes[e, k])
    # Exact planes carry no rounding of their own outward, so that they are trusted farther out
    elif records.kind[s] == PLANE and kappa == 0.0:
        around = far = _WIDEST * size
    else:
        far = _WIDE * size
    # A relative error kappa of the discriminant moves the roots of a ray that just touches by about the root of kappa
    off = 0.5 * math.sqrt(kappa) * reach + RELATIVE * around
    limits[o, 0], limits[o, 1] = _larger(limits[o, 0], off), -_larger(-limits[o, 1], -far)
    most[0, p], most[1, p] = _larger(most[0, p], reach), _larger(most[1, p], kappa)
    # One unbounded use is enough: the limits of a surface hold for all its uses
    most[2, p] = most[2, p] if bounded else 1.0


@kernel(
    boxes="e 6", surface="n", place="n", owner="n", entry="n", begin="0..end", end="0..n", limits="out o 2",
    most="out 3 m",
)  # fmt: skip
def weigh(
    records: RecordTables, boxes: Floats, size: float, surface: Ints, place: Ints, owner: Ints, entry: Ints, begin: int,
    end: int, limits: Floats, most: Floats,
) -> int:  # fmt: skip
    """Add uses begin..end to the limits of their owners, and to the maxima of their surfaces.

    surface, place, owner, entry: for each use its surface, that surface's column of `most`, the row of its owner in
    `limits`, and the entry whose box it lies in. size: that of the scene. most: the largest reach, the largest kappa,
    and 1 if some use is unbounded. Return how many uses name rows that do not exist.
    """
    strange = 0
    for use in range(begin, end):
        s, p, o, e = surface[use], place[use], owner[use], entry[use]
        if _is_row(records, s) and 0 <= p < most.shape[1] and 0 <= o < len(limits) and 0 <= e < len(boxes):
            _weigh_use(records, boxes, size, s, p, o, e, _is_bounded(boxes, e), limits, most)
        else:
            strange += 1
    return strange


@record_shapes(
    entry_kind="e", entry_index="e", cell_quadric="c", cell_likes="c|0", cell_first="c+1", plane_surface="w",
    program_leaf="g", program_end="g", program_shifts="g|0 4", program_row="r", leaf_cell="v", clipped_surface="t",
    clipped_program="t",
)  # fmt: skip
class EntryTables(NamedTuple):
    """The tables that say which surfaces bound the cells, sheets and polygons of entries."""

    entry_kind: Signs
    entry_index: Ints
    cell_quadric: Ints
    cell_likes: Ints
    cell_first: Ints
    plane_surface: Ints
    program_leaf: Ints
    program_end: Ints  # the first leaf of the next program
    program_shifts: Ints
    program_row: Ints
    leaf_cell: Ints
    clipped_surface: Ints  # of sheets, then of polygons
    clipped_program: Ints

    @classmethod
    def of(cls, tables: Tables) -> EntryTables:
        """Collect these tables of a scene."""
        t = tables
        return cls(
            t.entry_kind.astype(np.int8, copy=False), t.entry_index, t.cell_quadric, t.cell_likes, t.cell_first,
            t.plane_surface, t.program_leaf[:-1], t.program_leaf[1:], t.program_shifts,
            t.program_row, t.leaf_cell,
            np.concatenate([t.sheet_surface, t.polygon_surface]), np.concatenate([t.sheet_program, t.polygon_program]),
        )  # fmt: skip


@inline
def _leaves(tables: EntryTables, program: int) -> tuple[int, int]:
    """Return (first, end) leaves of a program; (0, -1) where its rows do not exist."""
    if not 0 <= program < len(tables.program_leaf):
        return whole(0), whole(-1)
    first, end = whole(tables.program_leaf[program]), whole(tables.program_end[program])
    if len(tables.program_shifts) > 0:
        row = whole(tables.program_shifts[program, MODEL_ROW])
        if not 0 <= row < len(tables.program_row) - 1:
            return whole(0), whole(-1)
        end = first + tables.program_row[row + 1] - tables.program_row[row]
    return first, end


@inline
def _cell_of_leaf(tables: EntryTables, leaf: int) -> int:
    """Return the cell of a leaf; -1 where its row does not exist."""
    if len(tables.program_shifts) > 0:
        return whole(leaf)
    return whole(tables.leaf_cell[leaf]) if 0 <= leaf < len(tables.leaf_cell) else whole(-1)


@inline
def _row_of_cell(tables: EntryTables, cell: int) -> int:
    """Return the row of a cell in `cell_limits`; -1 for a cell that does not exist."""
    if not 0 <= cell < len(tables.cell_quadric):
        return whole(-1)
    return whole(tables.cell_likes[cell] >> 1) if len(tables.cell_likes) > 0 else whole(cell)


@kernel(boxes="e 6", place="s", sheets="0..t", begin="0..end", end="0..e", limits="out o 2", most="out 3 m")
def weigh_entries(
    records: RecordTables, tables: EntryTables, boxes: Floats, size: float, place: Ints, sheets: int, begin: int,
    end: int, limits: Floats, most: Floats,
) -> int:  # fmt: skip
    """Call `weigh` for all uses by entries begin..end, without a list of them.

    place: the column of each surface in `most`. `limits` has the rows of cells, of `sheets` sheets, and of polygons.
    """
    strange, cells = 0, len(limits) - len(tables.clipped_surface)
    for e in range(begin, end):
        kind, index = tables.entry_kind[e], tables.entry_index[e]
        if kind == BALL:  # a sphere has no limits
            continue
        bounded, first, last = _is_bounded(boxes, e), whole(0), whole(0)
        if kind == CELL:
            first, last = whole(index), whole(index) + 1
        elif kind == REGION:
            first, last = _leaves(tables, index)
        elif kind in (SHEET, POLYGON):
            at = whole(index) if kind == SHEET else whole(index) + sheets
            if not (0 <= at < len(tables.clipped_surface) and cells >= 0):
                strange += 1
                continue
            s = tables.clipped_surface[at]
            if s >= 0 and _is_row(records, s) and 0 <= place[s] < most.shape[1]:
                _weigh_use(records, boxes, size, s, place[s], cells + at, e, bounded, limits, most)
            elif s >= 0:
                strange += 1
            if tables.clipped_program[at] >= 0:
                first, last = _leaves(tables, tables.clipped_program[at])
        strange += 1 if last < first else 0
        for leaf in range(first, last):
            cell = leaf if kind == CELL else _cell_of_leaf(tables, leaf)
            o = _row_of_cell(tables, cell)
            if not 0 <= o < cells:
                strange += 1
                continue
            # The quadric first, then the planes
            for slot in range(tables.cell_first[cell] - 1, tables.cell_first[cell + 1]):
                is_plane = slot >= tables.cell_first[cell]
                if is_plane and not 0 <= slot < len(tables.plane_surface):
                    strange += 1
                    continue
                s = tables.plane_surface[slot] if is_plane else tables.cell_quadric[cell]
                if s >= 0 and _is_row(records, s) and 0 <= place[s] < most.shape[1]:
                    _weigh_use(records, boxes, size, s, place[s], o, e, bounded, limits, most)
                elif s >= 0:
                    strange += 1
    return strange


@kernel(programs="m", cells="o 2", limits="out m 2")
def put_limits_of_programs(tables: EntryTables, programs: Ints, cells: Floats, limits: Floats) -> None:
    """Write the limits of some programs: the widest of their leaves, whose crossings are compared with each other."""
    for i in range(len(programs)):
        first, last = _leaves(tables, programs[i])
        for leaf in range(first, last):
            o = _row_of_cell(tables, _cell_of_leaf(tables, leaf))
            if 0 <= o < len(cells):
                limits[i, 0] = _larger(limits[i, 0], cells[o, 0])
                limits[i, 1] = -_larger(-limits[i, 1], -cells[o, 1])


@kernel(surface="n", most="3 n", limits="out p 2")
def put_limits_of_planes(records: RecordTables, surface: Ints, most: Floats, limits: Floats) -> None:
    """Write the limits of some planes: square of the least certain rate, for |d| = 1; the least certain height.

    `most` has a column for each of `surface`. Surfaces of other kinds are skipped.
    """
    for i in range(len(surface)):
        if not _is_row(records, surface[i]) or records.kind[surface[i]] != PLANE:
            continue
        row, planes, reach, kappa = records.row[surface[i]], records.planes, most[0, i], most[1, i]
        square, along = 0.0, 0
        for k in range(3):
            square += planes[row, k] * planes[row, k]
            along += 1 if planes[row, k] != 0.0 else 0
        length, height, least = math.sqrt(square), planes[row, 3], 2.0 * math.sqrt(kappa)
        # Below this rate, rounding may have changed the sign of n·d
        rate = (least if least > 2.0**-40 else 2.0**-40) * length
        plain = along == 1 and height == 0.0 and not _is_inexact(records.lost_of_planes, row)
        limits[row, 0] = rate * rate
        # Across one axis, with nothing above the anchor, the height is the difference of two floats: its sign is exact
        limits[row, 1] = 0.0 if plain else 2.0**-40 * (length * reach + abs(height))


@inline
def _row_size(forms: Floats, form: int, line: int) -> float:
    """Return the length of one of the rows of a quadric."""
    square = 0.0
    for k in range(3):
        square += forms[form, 3 * line + k] * forms[form, 3 * line + k]
    return math.sqrt(square)


@inline
def _sizes(forms: Floats, form: int) -> tuple[float, float, float]:
    """Return bounds on the second-order, linear and constant terms at distance 1 from the anchor."""
    squares = linear = 0.0
    for line in range(3):
        length = _row_size(forms, form, line)
        squares += abs(forms[form, 9 + line]) * (length * length)
        linear += abs(forms[form, 12 + line]) * length
    return squares, linear, abs(forms[form, 15])


@inline
def _is_plain(forms: Floats, form: int) -> bool:
    """Return whether each axis along which a quadric bends is a world axis, and no coefficient underflows."""
    for line in range(3):
        square, linear = abs(forms[form, 9 + line]), abs(forms[form, 12 + line])
        if square == 0.0 and linear == 0.0:
            continue
        along, size = 0, 0.0
        for k in range(3):
            part = abs(forms[form, 3 * line + k])
            along += 1 if part != 0.0 else 0
            size = part if part > size else size
        bends = square == 0.0 or square * (size * size) > _LEAST
        if not (along <= 1 and bends and (linear == 0.0 or linear * size > _LEAST)):
            return False
    return True


@kernel(surface="n", most="3 n", limits="out f 2")
def put_limits_of_quadrics(records: RecordTables, surface: Ints, most: Floats, limits: Floats) -> None:
    """Write the limits of the forms of quadrics: least certain discriminant, for |d| = 1; least value along rulings.

    The latter is infinite where a body is unbounded and a direction's component along a bending axis is a sum: rounding
    may have made that 0, where the ray does reach a wall, however far away.
    """
    for i in range(len(surface)):
        if not _is_row(records, surface[i]) or records.kind[surface[i]] != QUADRIC:
            continue
        form, reach, share = _form(records, records.row[surface[i]]), most[0, i], most[1, i]
        a, b, k = _sizes(records.forms, form)
        # Sizes of the terms of the moment form (kernels/surface/quadric.py) up to this reach
        terms = 10.0 * a * reach * reach + 6.0 * b * reach + k
        rate = terms / reach
        limits[form, 0] = 4.0 * share * (rate * rate) if reach > 0.0 else math.inf
        limits[form, 1] = math.inf if most[2, i] > 0.0 and not _is_plain(records.forms, form) else share * terms


@inline
def _larger_finite(size: float, x: float) -> float:
    """Return the larger of two numbers, where the second is finite; else the first."""
    return x if size < x < math.inf else size


@kernel(planes="p 7", quadrics="q 4", forms="f 16", boxes="e 6")
def size_of_records(planes: Floats, quadrics: Floats, forms: Floats, boxes: Floats) -> float:
    """Return the largest finite length of a scene: coordinates and the own sizes of quadrics; 0 where there is none."""
    size = 0.0
    for row in range(len(planes)):
        for k in range(4, 7):
            size = _larger_finite(size, abs(planes[row, k]))
    for row in range(len(boxes)):
        for k in range(6):
            size = _larger_finite(size, abs(boxes[row, k]))
    for row in range(len(quadrics)):
        for k in range(3):
            size = _larger_finite(size, abs(quadrics[row, k]))
    for form in range(len(forms)):
        a, b, c = _sizes(forms, form)
        # Where terms of second and zeroth, of second and first, and of first and zeroth order balance; a zero gives inf
        # or NaN, which is left out
        size = _larger_finite(_larger_finite(_larger_finite(size, math.sqrt(c / a)), b / a), c / b)
    return size


# Limits of all tables

Whole = npt.NDArray[Any]

_USES, _ENTRIES = 1 << 17, 1 << 15
_STRANGE = "the tables of a scene name surfaces, cells or boxes that they do not have"


@dataclass
class LimitMaxima:
    """What the limits of surfaces follow from: columns (largest reach, largest kappa, 1 for unbounded uses)."""

    size: float | None  # of the scene; None where all bodies are bounded
    planes: Floats  # (3, planes)
    forms: Floats  # (3, forms of quadrics)

    def copy(self) -> LimitMaxima:
        """Copy the maxima."""
        return LimitMaxima(self.size, self.planes.copy(), self.forms.copy())

    def column(self, kind: int, row: int) -> Floats:
        """Return the column of a plane, or of a form of quadrics, as a view."""
        return (self.planes if kind == PLANE else self.forms)[:, row]

    def extend(self, kind: int) -> None:
        """Add a column for a surface that nothing uses yet."""
        if kind == PLANE:
            self.planes = np.pad(self.planes, ((0, 0), (0, 1)))
        elif kind == QUADRIC:
            self.forms = np.pad(self.forms, ((0, 0), (0, 1)))


def with_limits(tables: Tables, boxes: Floats, rest: Remainders) -> Tables:
    """Return the tables with `compute_limits` of them."""
    return tables._replace(**compute_limits(tables, boxes, rest)[0])


def limit_shapes(tables: Tables) -> dict[str, Floats]:
    """Return arrays with the shapes of `compute_limits`, without memory."""
    counts = dict(
        plane=len(tables.planes), quadric=len(tables.quadric_forms), cell=len(tables.cell_face),
        program=len(_model_programs(tables)), sheet=len(tables.sheet_surface), polygon=len(tables.polygon_surface),
    )  # fmt: skip
    return {f"{of}_limits": np.broadcast_to(0.0, (count, 2)) for of, count in counts.items()}


def compute_limits(
    tables: Tables, boxes: Floats, rest: Remainders, bounded: bool = False
) -> tuple[dict[str, Any], LimitMaxima]:
    """Compute `plane_limits`, `quadric_limits`, and the limits of cells, programs, sheets and polygons.

    Parameters
    ----------
    tables : Tables
        Tables of a scene, without limits.
    boxes : Floats
        (entries, 6) bounding boxes.
    rest : Remainders
        What rounding removed from the surface records.
    bounded : bool
        Whether all boxes are known to be finite.

    Returns
    -------
    tuple[dict[str, Floats], LimitMaxima]
        The columns (n, 2) by name, and what those of surfaces follow from.

    Raises
    ------
    IndexError
        If a use names a surface, an owner or a box that does not exist.
    """
    cells, sheets, polygons = len(tables.cell_face), len(tables.sheet_surface), len(tables.polygon_surface)
    # For bounded bodies nothing depends on the size
    size = None if bounded or np.isfinite(boxes).all() else scene_size(tables, boxes)
    limits = no_limits(cells + sheets + polygons)
    used_by = tables.cell_quadric, tables.plane_surface, tables.sheet_surface, tables.polygon_surface
    last = max(int(surface.max(initial=-1)) for surface in used_by)
    place, used = _places(tables, last)
    most = mapped_zeros((3, len(used)), np.float64)
    records = RecordTables.of(tables, rest)
    entries, strange = EntryTables.of(tables), 0
    for begin in range(0, len(boxes), _ENTRIES):  # Ctrl-C takes effect between calls
        end = min(len(boxes), begin + _ENTRIES)
        strange += weigh_entries(records, entries, boxes, size or 1.0, place, sheets, begin, end, limits, most)
    if strange:
        raise IndexError(_STRANGE)
    # Each column is kept by itself: a view would keep the whole array alive
    of_cells = own_memory(limits[:cells])
    of_planes, of_quadrics = (
        mapped_zeros((len(table), 2), np.float64) for table in (tables.planes, tables.quadric_forms)
    )
    models = _model_programs(tables)
    of_programs = no_limits(len(models))
    put_limits_of_programs(entries, models, of_cells, of_programs)
    put_limits_of_planes(records, used, most, of_planes)
    put_limits_of_quadrics(records, used, most, of_quadrics)
    columns = dict(
        plane_limits=of_planes,
        quadric_limits=of_quadrics,
        cell_limits=of_cells,
        program_limits=of_programs,
        sheet_limits=own_memory(limits[cells : cells + sheets]),
        polygon_limits=own_memory(limits[cells + sheets :]),
    )
    flat = len(tables.planes)
    return columns, LimitMaxima(size, own_memory(most[:, :flat]), own_memory(most[:, flat:-1]))


def _model_programs(tables: Tables) -> Whole:
    """Return for each row of limits of programs one of the programs that share it."""
    models = np.empty(len(tables.program_gate) - 1, np.int32)
    models[rows_of_programs(tables)] = np.arange(len(tables.program_leaf) - 1, dtype=np.int32)
    return models


def _places(tables: Tables, last: int) -> tuple[Whole, Whole]:
    """Return (the column of each surface in `most`, the surface of each column; -1 for none up to `last`).

    Each plane has a column, and quadrics of one form share one; spheres need none, and share the last.
    """
    planes, forms = len(tables.planes), len(tables.quadric_forms)
    if planes + forms == 0:  # pages of zeros that nobody writes to take no time
        return np.zeros(len(tables.surface_row), np.int32), np.full(1, -1, np.int32)
    place, surfaces = np.empty(len(tables.surface_row), np.int32), np.full(planes + forms + 1, -1, np.int32)
    kind = tables.surface_kind.astype(np.int8, copy=False)
    put_columns(kind, tables.surface_row, tables.quadrics, planes, last, place, surfaces)
    return place, surfaces


@kernel(kind="s", row="s", quadrics="q 4", place="out s", surfaces="out c")
def put_columns(
    kind: Signs, row: Ints, quadrics: Floats, planes: int, last: int, place: Ints, surfaces: Ints
) -> None:  # fmt: skip
    """Write `_places`. Limits belong to the form: quadrics of one form share the widest."""
    for i in range(len(kind)):
        at = len(surfaces) - 1
        if kind[i] == PLANE:
            at = whole(row[i])
        elif kind[i] == QUADRIC and 0 <= row[i] < len(quadrics):
            at = whole(quadrics[row[i], 3]) + planes
        place[i] = at
        if kind[i] != SPHERE and i <= last and 0 <= at < len(surfaces):
            surfaces[at] = i


def scene_size(tables: Tables, boxes: Floats) -> float:
    """Return the largest finite length of a scene; 1 where there is none."""
    return size_of_records(tables.planes, tables.quadrics, tables.quadric_forms, boxes) or 1.0


def no_limits(count: int) -> Floats:
    """Allocate limits (count, 2): the error of t for |d| = 1, and how large |o| + |t d| may be.

    Nothing is known yet.
    """
    limits = mapped_zeros((count, 2), np.float64)
    # Not limited, until a use is weighed; 0 for the error, which only grows
    limits[:, 1] = math.inf
    return limits


def weigh_all(
    records: RecordTables,
    boxes: Floats,
    size: float,
    uses: tuple[Whole, Whole, Whole, Whole],
    limits: Floats,
    most: Floats,
) -> None:
    """`weigh` for all uses: their surfaces, the columns of these in `most`, their owners and entries.

    Raises IndexError if a use names what does not exist: its owner would be trusted without a limit.
    """
    surface, place, owner, entry = (np.ascontiguousarray(each, np.int32) for each in uses)
    for begin in range(0, len(surface), _USES):  # Ctrl-C takes effect between calls
        end = min(len(surface), begin + _USES)
        if weigh(records, boxes, size, surface, place, owner, entry, begin, end, limits, most):
            raise IndexError(_STRANGE)


def program_limits(program: Whole, leaves: Floats, count: int) -> Floats:
    """Compute the limits of programs (count, 2) from those of their leaves' cells."""
    result = np.zeros((count, 2))
    result[:, 1] = math.inf
    # The crossings of all leaves are compared with each other, so that the widest bound counts for all
    np.maximum.at(result[:, 0], program, leaves[:, 0])
    np.minimum.at(result[:, 1], program, leaves[:, 1])
    return result
