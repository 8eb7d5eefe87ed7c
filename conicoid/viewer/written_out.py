"""Tables in which every body has rows of its own, for the shaders: they know nothing of what bodies have in common."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine.body.maps import maps_of_faces
from ..engine.faces import cell_faces, plane_faces
from ..engine.programs import leaves_of_programs, row_of_leaf, rows_of_programs
from ..engine.tables import Ints, Tables
from ..engine.tree.leaf import ROWS
from ..engine.tree.walk import FEW


def written_out(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """The columns that differ from those of `tables`: of leaves, gates and maps of faces, and trees of a few leaves."""
    columns = _trees(tables)
    if len(tables.program_shifts):
        columns |= programs_written_out(tables)
    if len(tables.cell_likes):
        columns |= faces_written_out(tables)
    if len(tables.body_maps):
        columns["face_maps"] = maps_of_faces(tables)
    return columns


def programs_written_out(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """Leaves and gates of every program."""
    rows, (leaf_of, leaves) = rows_of_programs(tables), leaves_of_programs(tables)
    gates = np.diff(tables.program_gate)[rows]
    first = _ends(gates)
    shift = first[:-1] - tables.program_gate[rows]
    of_gates, of_leaves = np.repeat(shift, gates), np.repeat(shift, leaves)
    gate = np.arange(first[-1], dtype=np.int32) - of_gates
    programs = np.repeat(np.arange(len(rows)), leaves)
    begins = _ends(leaves)
    number = np.repeat(leaf_of - begins[:-1], leaves) + np.arange(len(programs), dtype=np.int32)
    leaf = row_of_leaf(tables, programs, number)
    parent = tables.gate_parent[gate]
    return dict(
        program_leaf=begins,
        program_gate=first,
        leaf_cell=number,
        leaf_gate=tables.leaf_gate[leaf] + of_leaves,
        leaf_negated=tables.leaf_negated[leaf],
        leaf_sense=tables.leaf_sense[leaf],
        gate_parent=np.where(parent < 0, parent, parent + of_gates),
        gate_need=tables.gate_need[gate],
        gate_negated=tables.gate_negated[gate],
        gate_start=tables.gate_start[gate],
    )


def faces_written_out(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """The faces of every cell."""
    return dict(
        cell_face=cell_faces(tables, np.arange(len(tables.cell_quadric))),
        plane_face=plane_faces(tables, np.arange(len(tables.plane_surface))),
    )


def _trees(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """The trees of bodies, whose leaves are numbered as they are written out.

    Those of a few leaves, which have none, are one leaf of a tree each; their places come last.
    """
    leaf_of, leaves = leaves_of_programs(tables)
    first = _ends(leaves)
    few = np.flatnonzero((leaves > 0) & (leaves <= FEW))
    known = _known_order(tables, leaf_of, leaves, first)
    if not len(few):
        return dict(tree_order=known)
    own = np.diff(tables.tree_root, prepend=np.zeros(len(first) + 1 - len(tables.tree_root), np.int32))
    own[few] = 1
    ends = _ends(own)
    roots = np.zeros(ends[-1], np.int32)
    others = np.ones(len(roots), bool)
    others[ends[few]] = False
    roots[others] = tables.roots
    places = len(tables.tree_order) + _ends(leaves[few])
    roots[ends[few]] = -(places[:-1] << 4 | leaves[few]) - 1
    held = np.repeat(first[few] - places[:-1], leaves[few]) + np.arange(len(tables.tree_order), places[-1])
    order = np.concatenate([known, held]).astype(np.int32)
    return dict(tree_root=ends, roots=roots, tree_order=order)


def _known_order(tables: Tables, leaf_of: Ints, leaves: Ints, first: Ints) -> Ints:
    """`Tables.tree_order`, in which leaves have the numbers from `first` on; they have those of cells with shifts."""
    if not len(tables.program_shifts):
        return tables.tree_order
    renumbered = np.zeros(len(tables.cell_quadric), np.int32)
    cells = np.repeat(leaf_of - first[:-1], leaves) + np.arange(first[-1], dtype=np.int32)
    renumbered[cells] = np.arange(first[-1], dtype=np.int32)
    order, of_bodies = tables.tree_order.copy(), len(tables.tree_order) - len(tables.leaf_items) // ROWS
    order[:of_bodies] = renumbered[order[:of_bodies]]
    return order


def _ends(counts: Any) -> Ints:
    """Where each begins, and the last ends."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])
