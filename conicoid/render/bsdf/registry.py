"""The registry of kinds of surface, and the dispatch to them: one compiled function for each entry of `SurfaceKind`.

A material's row names its kind by its place here. The functions below compare that number with one place after the
other, so compilers see an `if` for each kind and merge the kinds' code into one function: no pointers, no tables.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import Vector
from ..sampling import Direction
from .albedo_tables import AlbedoTables
from .bsdf_sample import (
    BsdfSample,
    DiffuseCosine,
    Evaluate,
    HasExtent,
    Highlight,
    LobeSurface,
    MirrorShare,
    Sample,
    SurfaceKind,
)
from .conductor import CONDUCTOR
from .diffuse import DIFFUSE, lambert_cosine
from .layered import LAYERED, opaque_reflectance
from .material_table import MaterialTable
from .phong import PHONG, material_highlight

SURFACES: tuple[SurfaceKind, ...] = (
    CONDUCTOR,
    LAYERED,
    PHONG,
    DIFFUSE,
)
"""The kinds of surface. The first that claims a material has it; the last claims all."""

DIFFUSE_KIND = len(SURFACES) - 1
"""The number of the matte kind, which kernels test before all others: its formulas are merged into their callers."""


def surface_kind(row: Any) -> int:
    """Return the number of the kind of a filled row of the table of materials."""
    return next(number for number, kind in enumerate(SURFACES) if kind.is_kind(row))


# Dispatch. `_composed` makes the functions of all kinds into one that asks them from the first to the last. It starts
# with the last: each step closes over one kind's function and over the chain of those behind it.


def _composed(entry: str, step: Callable[[int, Any, Any], Any], default: Any = None) -> Any:
    """Return one compiled function for an entry of all kinds; the default is for those that leave it None."""
    chain = default
    for number, kind in reversed(tuple(enumerate(SURFACES))):
        own = getattr(kind, entry)
        if own is not None:
            chain = own if chain is None else step(number, own, chain)
    return chain


def _evaluate_step(number: int, own: Evaluate, others: Evaluate) -> Evaluate:
    @inline
    def evaluate(
        materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
    ) -> tuple[float, float, float, float]:
        if materials.rows[at.row].kind == number:
            return own(materials, tables, at, o, i)
        return others(materials, tables, at, o, i)

    return evaluate


def _sample_step(number: int, own: Sample, others: Sample) -> Sample:
    @inline
    def sample(
        materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
    ) -> BsdfSample:
        if materials.rows[at.row].kind == number:
            return own(materials, tables, at, o, choice, u, v)
        return others(materials, tables, at, o, choice, u, v)

    return sample


def _extent_step(number: int, own: HasExtent, others: HasExtent) -> HasExtent:
    @inline
    def has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
        if materials.rows[at.row].kind == number:
            return own(materials, at)
        return others(materials, at)

    return has_extent


def _cosine_step(number: int, own: DiffuseCosine, others: DiffuseCosine) -> DiffuseCosine:
    @inline
    def diffuse_cosine(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
        if row.kind == number:
            return own(row, light, eye, normal)
        return others(row, light, eye, normal)

    return diffuse_cosine


def _highlight_step(number: int, own: Highlight, others: Highlight) -> Highlight:
    @inline
    def highlight(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
        if row.kind == number:
            return own(row, light, eye, normal)
        return others(row, light, eye, normal)

    return highlight


def _mirror_step(number: int, own: MirrorShare, others: MirrorShare) -> MirrorShare:
    @inline
    def mirror_share(row: Any, cosine: float) -> tuple[float, float, float]:
        if row.kind == number:
            return own(row, cosine)
        return others(row, cosine)

    return mirror_share


evaluate_kind: Evaluate = _composed("evaluate", _evaluate_step)
sample_kind: Sample = _composed("sample", _sample_step)
kind_has_extent: HasExtent = _composed("has_extent", _extent_step)

# Whitted's part. Few kinds have a part of their own, and the chains hold only those: without one there is no `if`.
diffuse_cosine: DiffuseCosine = _composed("diffuse_cosine", _cosine_step, lambert_cosine)
kind_highlight: Highlight = _composed("highlight", _highlight_step, material_highlight)
mirror_share: MirrorShare = _composed("mirror_share", _mirror_step, opaque_reflectance)
