"""Boolean bodies by their form, and the rays that wait for them; the memory of both.

Two bodies are of one form if they differ in the numbers of their surfaces only.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import allocator, helper, inline
from .. import tables as table
from ..culling import bit_count
from ..faces import cell_side, plane_side
from ..programs import cell_of_leaf, gates_of, leaves_of, root_of, rows_of_leaves
from ..tables import Floats, Geometry, Ints, integer, length, whole
from .booleans import LEAVES_SIZE, MOST, TRUTHS_SIZE, in_lanes
from .lanes import LANES, SIZE

FORMS = 8
"""Bodies of so many forms are met in lanes, of those that a thread meets first."""
EVERY = 1 << 30
"""As many programs as there may be: the forms of all are kept."""
FACES = 64
"""Where the faces of a body are numbered: those of leaf k from 64 k on, its quadric last."""

# Rows of lanes behind those of packets: 24 numbers of a record, its limits, its surface; limits of a cell and a body
_ROWS_AT = (SIZE + LANES - 1) // LANES * LANES
(
    R0, R1, R2, R3, R4, R5, R6, R7, R8, R9, R10, R11, R12, R13, R14, R15, R16, R17, R18,
    _R19, _R20, _R21, _R22, _R23, LIMIT, OTHER_LIMIT, SURFACE, CELL_OFF, CELL_FAR, BODY_OFF, BODY_FAR,
) = (np.uint64(row) for row in range(_ROWS_AT, _ROWS_AT + 31 * LANES, LANES))  # fmt: skip
_ALL_ROWS = _ROWS_AT + 31 * LANES


# In `Bodies.numbers`: 64 each. Behind them the forms' counts, their models, and how many forms there are
PROGRAM, CELL, AT, WAITING = 0, LANES, 2 * LANES, 3 * LANES
ENTRIES = WAITING + FORMS * LANES
COUNTS = ENTRIES + FORMS * LANES
MODELS = COUNTS + FORMS
KNOWN = MODELS + FORMS


class Bodies(NamedTuple):
    """Rays and Boolean bodies that wait to be tested, and the lanes in which they are."""

    lanes: Floats
    leaves: Floats
    truths: Floats
    spans: Ints
    numbers: Any  # int64
    forms: Ints  # of programs as `form_of` finds them: 256 tag + 2 + form, form -1 if it is not met in lanes; or 0


@allocator
def new_bodies(geometry: Geometry, most: int) -> Bodies:
    """Memory for one thread, in which forms of so many programs are kept at most."""
    programs, size = length(geometry, table.PROGRAM_LEAF), 1
    while size < min(programs, most):
        size *= 2
    room = np.zeros(_ALL_ROWS + 8)
    first = -(room.ctypes.data >> 3) & 7
    return Bodies(
        room[first : first + _ALL_ROWS], np.empty(LEAVES_SIZE), np.empty(TRUTHS_SIZE), np.zeros(MOST, np.int32),
        np.zeros(KNOWN + 1, np.int64), np.zeros(size, np.int32),
    )  # fmt: skip


@inline
def _same(geometry: Geometry, numbers: int, a: int, b: int) -> bool:
    """Do rows a and b of a table of whole numbers agree?"""
    return integer(geometry, numbers, a) == integer(geometry, numbers, b)


@inline
def _same_faces(geometry: Geometry, a: int, b: int) -> bool:
    """Have two cells as many planes, on the same sides, and the same kind of quadric?"""
    first, other = integer(geometry, table.CELL_FIRST, a), integer(geometry, table.CELL_FIRST, b)
    count = integer(geometry, table.CELL_FIRST, a + 1) - first
    same = count < FACES and integer(geometry, table.CELL_FIRST, b + 1) - other == count
    for k in range(count if same else 0):
        same = same and plane_side(geometry, first + k) == plane_side(geometry, other + k)
    p, q = integer(geometry, table.CELL_QUADRIC, a), integer(geometry, table.CELL_QUADRIC, b)
    if p < 0 or q < 0:
        return same and p < 0 and q < 0
    return same and _same(geometry, table.SURFACE_KIND, p, q) and cell_side(geometry, a) == cell_side(geometry, b)


@inline
def _same_cells(geometry: Geometry, leaf: int, other: int, leaves: int) -> bool:
    """Do the cells of so many leaves, from two on, differ in the numbers of their surfaces only?"""
    for k in range(leaves):
        if not _same_faces(geometry, cell_of_leaf(geometry, leaf + k), cell_of_leaf(geometry, other + k)):
            return False
    return True


@helper
def _of_one_form(geometry: Geometry, p: int, q: int) -> bool:
    """Do two programs differ in the numbers of their surfaces only?"""
    (leaf, end), (other, its_end) = leaves_of(geometry, p), leaves_of(geometry, q)
    leaves, gates = end - leaf, gates_of(geometry, p)
    gate, its = gates[0], root_of(geometry, q)
    if p != q and gate == its:  # one another moved: the rows of gates and leaves are the same ones
        return _same_cells(geometry, leaf, other, leaves)
    if its_end - other != leaves or gates_of(geometry, q)[1] - its != gates[1] - gate:
        return False
    row, its_row = rows_of_leaves(geometry, p), rows_of_leaves(geometry, q)
    for k in range(gates[1] - gate):
        a, b = gate + k, its + k
        same = _same(geometry, table.GATE_NEED, a, b) and _same(geometry, table.GATE_NEGATED, a, b)
        same = same and _same(geometry, table.GATE_START, a, b)
        above, below = integer(geometry, table.GATE_PARENT, a), integer(geometry, table.GATE_PARENT, b)
        if not same or (above < 0) != (below < 0) or (above >= 0 and above - gate != below - its):
            return False
    for k in range(leaves):
        a, b = leaf + k + row, other + k + its_row
        same = _same(geometry, table.LEAF_NEGATED, a, b) and _same(geometry, table.LEAF_SENSE, a, b)
        same = same and integer(geometry, table.LEAF_GATE, a) - gate == integer(geometry, table.LEAF_GATE, b) - its
        if not same:
            return False
    return _same_cells(geometry, leaf, other, leaves)


@helper
def _find_form(geometry: Geometry, bodies: Bodies, program: int) -> int:
    """The form of a program that has not been met yet, or of late."""
    numbers, known = bodies.numbers, bodies.numbers[KNOWN]
    if in_lanes(geometry, program):
        for form in range(known):
            if _of_one_form(geometry, numbers[MODELS + form], program):
                return form
        if known < FORMS and _of_one_form(geometry, program, program):
            numbers[MODELS + known] = program
            numbers[KNOWN] += 1
            return known
    return -1


@inline
def form_of(geometry: Geometry, bodies: Bodies, program: int) -> int:
    """The form of a program; -1: it is not met in lanes.

    It is kept in the place that the last bits of its number say, until a program with the same ones, and another tag,
    is met.
    """
    last = len(bodies.forms) - 1
    place, tag = program & last, program >> bit_count(last)
    kept = whole(bodies.forms[place])
    if kept >> 8 == tag and kept & 255 != 0:
        return (kept & 255) - 2
    form = _find_form(geometry, bodies, program)
    bodies.forms[place] = tag << 8 | form + 2
    return form


@inline
def put_body(bodies: Bodies, form: int, ray: int, entry: int) -> bool:
    """A ray that may meet a body of a form waits; are there 64 now?"""
    numbers, count = bodies.numbers, bodies.numbers[COUNTS + form]
    numbers[WAITING + LANES * form + count], numbers[ENTRIES + LANES * form + count] = ray, entry
    numbers[COUNTS + form] = count + 1
    return count + 1 == LANES


@inline
def forms_known(bodies: Bodies) -> int:
    """How many forms there are."""
    return bodies.numbers[KNOWN]


@inline
def take_waiting(bodies: Bodies, form: int) -> int:
    """How many wait of a form: none, from now on."""
    count = bodies.numbers[COUNTS + form]
    bodies.numbers[COUNTS + form] = 0
    return count


@inline
def waiting_body(bodies: Bodies, form: int, k: int) -> tuple[int, int]:
    """(ray, entry) of number k of those that wait of a form."""
    return bodies.numbers[WAITING + LANES * form + k], bodies.numbers[ENTRIES + LANES * form + k]
