"""Collect the bodies of a scene into groups of equal pattern, with their rows of numbers; exact surfaces on demand.

A volume may be a Boolean shape of thousands of primitives, and only one of them is needed for an exact surface. So
each surface is computed from the primitive alone that it belongs to.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import cache
from itertools import accumulate, chain, compress
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import kernel
from .._util.arrays import FloatArray, two_product, two_sum, unique_first_with_inverse, unique_sorted
from .._util.dataclass import dataclass
from ..geometry.body import Body
from ..geometry.bulk import Bulk, Spheres
from ..geometry.cell import Cell, Not, Tree
from ..geometry.instances import InstanceList
from ..geometry.shape import PrimitiveSolid, Shape
from ..geometry.surface import UPRIGHT, Key, PlaneSurface, QuadricSurface, Surface, Triple
from ..geometry.transform import IDENTITY_MOTION, AxisFrame, Motion, Rotate, Step, Transform, Translate
from ..kernels.numbers.double_double import next_float_down, next_float_up
from ..kernels.tables import Floats, Ints, Longs
from ..kernels.threads import KernelRange, run_chunks
from ..materials.material import Material
from ..numerics import bigfloat as ex
from .batch_lowering import BatchLowering
from .csg_plan import placed_primitives
from .instances import instance_rows
from .lower_shape import lower_shape, lower_stretched_balls
from .motion_batch import PointPlaneMover
from .pattern import BodyGroup, BodyGroups, BodyPattern, BulkBalls, Primitives
from .primitive_cache import PrimitiveCache
from .progress import AFTER_BATCH, AFTER_READING, ProgressStages
from .pytree import positions_by_key


@dataclass
class _ShapeLeaves:
    """The primitives of a body, the number of the first surface of each, and the surfaces computed so far."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, Surface] = field(default_factory=dict)
    motions: dict[int, Motion] = field(default_factory=dict)
    """The motions of primitives from their own frames: the surfaces of one share the products of its steps."""

    def moved_surface(self, number: int) -> Surface:
        """Return a surface, computed without the uv maps of its faces."""
        which = bisect_right(self.first, number) - 1
        leaf, steps = self.moved[which]
        if which not in self.motions:
            self.motions[which] = leaf._under_steps(steps).under()
        return own_surfaces(leaf)[number - self.first[which]].moved(self.motions[which])


def exact_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body, by its number among those of all its primitives."""
    leaves = None if "part" in shape.cache else _shape_leaves(shape)
    if leaves is None:
        return lower_shape(shape).exact[number]
    if number not in leaves.known:
        leaves.known[number] = leaves.moved_surface(number)
    return leaves.known[number]


def _shape_leaves(shape: Shape) -> _ShapeLeaves | None:
    """Return the primitives of a body, which caches them; None where one of them is no solid."""
    leaves: _ShapeLeaves | None = shape.cache.get("leaves")
    if leaves is None:
        moved = placed_primitives(shape)
        if not all(isinstance(leaf, PrimitiveSolid) for leaf, _ in moved):
            return None
        counts = (leaf._face_count or len(own_surfaces(leaf)) for leaf, _ in moved)
        leaves = shape.cache["leaves"] = _ShapeLeaves(moved, [0, *accumulate(counts)])
    return leaves


def own_surfaces(leaf: Any) -> Sequence[Surface]:
    """List the surfaces of a primitive solid in its own frame, once for all its copies."""
    found: Sequence[Surface] | None = leaf.own_cache.get("surfaces")
    if found is None:
        found = leaf.own_cache["surfaces"] = leaf.surfaces if leaf._face_count else _tree_surfaces(leaf.tree())
    return found


def own_forms(leaf: Any) -> Sequence[SurfaceForm | None]:
    """List the forms of the surfaces of a primitive solid in its own frame, once for all its copies."""
    found: list[SurfaceForm | None] | None = leaf.own_cache.get("forms")
    if found is None:
        found = leaf.own_cache["forms"] = list(map(_surface_form, own_surfaces(leaf)))
    return found


def _tree_surfaces(tree: Tree) -> list[Surface]:
    """List the surfaces of all cells, from left to right."""
    found: list[Surface] = []
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            found += [face.surface for face in part.faces]
        else:
            pending.extend(reversed((part.part,) if isinstance(part, Not) else part.parts))
    return found


# Names of surfaces: exact numbers before the first step of a motion that would round them
#
# The walls of crystals in a rotated module, or of boxes in an oblique row, coincide by the hundred. Keys in 3,000 bits
# would show it, at a millisecond each. Exact sums of floats carry many surfaces at once as far as translations and
# quarter turns lead, and rotations about an axis that leave a surface where it is. From there on surfaces with equal
# numbers are equal after equal steps, without the shifts that move a surface within itself.

FEWEST_SURFACES = 64
"""For fewer surfaces exact keys are as quick."""
_QUADRIC_FORM, _PLANE_FORM, _OTHER_FORM = 0.0, 1.0, 2.0

SurfaceForm: TypeAlias = tuple[float, ...]
"""Exact floats: kind, weights w (3), center c (3), and d as a sum of two.

Planes are w·(x - c) = d, upright quadrics the sum of w[i] (x[i] - c[i])² = d; c[i] = 0 where w[i] = 0.
"""
_FORM_NUMBERS = 9
_NO_FORM = (1.0, 2.0, 3.0, 0.0, 0.0, 0.0)
"""Weights and center of surfaces without a form: no rotation keeps them."""
_LEAST_PRODUCT = 2.0**-900
"""The rounding error of smaller products may underflow."""


def _surface_form(surface: Surface) -> SurfaceForm | None:
    """Return the form of a surface; None if its numbers do not fit into floats, or if it is not upright."""
    try:
        if isinstance(surface, PlaneSurface):
            weights, center = surface.normal, (0.0, 0.0, 0.0)
            kind, constant = _PLANE_FORM, surface.offset
        elif surface.rows is UPRIGHT and not any(surface.linear):
            kind, weights, constant = _QUADRIC_FORM, surface.squares, surface.constant
            x, y, z = (c if weight else 0.0 for c, weight in zip(surface.anchor, weights, strict=True))
            center = x, y, z
        else:
            kind, (weights, center, constant) = _QUADRIC_FORM, _complete_squares(surface)
        return kind, *map(_exact_float, (*weights, *center)), *_two_floats(constant)
    except (_InexactFormError, OverflowError):
        return None


def _complete_squares(surface: QuadricSurface) -> tuple[Triple, Triple, Fraction]:
    """Return (weights, center, constant) of an upright quadric."""
    constant, weights, center = _rational(surface.constant), [], []
    for axis, row in enumerate(surface.rows):
        square, linear, factor = map(_rational, (surface.squares[axis], surface.linear[axis], row[axis]))
        if any(row[k] for k in range(3) if k != axis) or (linear and not square):
            raise _InexactFormError
        weights.append(square if factor == 1 else square * factor * factor)
        anchor = _rational(surface.anchor[axis]) if square else _ZERO
        center.append(anchor - linear / (square * factor) if linear else anchor)
        constant += linear * linear / square if linear else 0
    return (weights[0], weights[1], weights[2]), (center[0], center[1], center[2]), constant


class _InexactFormError(Exception):
    """A surface has a number that was rounded or has derivatives, or it is turned in its own frame."""


_ZERO = Fraction(0)


def _rational(value: Any) -> Fraction:
    """Return a number as a fraction; raise `_InexactFormError` for one that was rounded or has derivatives."""
    if isinstance(value, (float, Fraction, int)) or (isinstance(value, ex.BigFloat) and not value.off):
        return ex.fraction(value)
    raise _InexactFormError


def _exact_float(value: Any) -> float:
    """Return a number as a float; raise `_InexactFormError` if it is none."""
    if type(value) is float:
        return value
    exact = _rational(value)
    found = float(exact)
    if found != exact:
        raise _InexactFormError
    return found


def _two_floats(value: Any) -> tuple[float, float]:
    """Return a number as a float and the float that is missing from it."""
    if type(value) is float:
        return value, 0.0
    exact = _rational(value)
    high = float(exact)
    return high, 0.0 if high == exact else _exact_float(exact - Fraction(high))


def _list_forms(leaves: Sequence[Any], leaf_of: Longs, own: Longs) -> Floats:
    """Return the forms (n, 9) of surfaces, by their primitive and number there.

    Surfaces without a form are numbered, equal ones alike.
    """
    numbers: dict[Surface, int] = {}
    rows: list[SurfaceForm] = []
    first: dict[int, int] = {}  # copies of a primitive share the list of its forms
    for leaf in leaves:
        forms = own_forms(leaf)
        if first.setdefault(id(forms), len(rows)) == len(rows):
            others = ((k, own_surfaces(leaf)[k]) for k, form in enumerate(forms) if form is None)
            other = {k: (_OTHER_FORM, *_NO_FORM, numbers.setdefault(each, len(numbers)), 0.0) for k, each in others}
            rows += [other[k] if form is None else form for k, form in enumerate(forms)]
    begin = np.array([first[id(own_forms(leaf))] for leaf in leaves])
    return np.array(rows).reshape(-1, _FORM_NUMBERS)[begin[leaf_of] + own]


class _StepKind(NamedTuple):
    """How a step carries coordinates: all of it but its numbers."""

    tag: str
    """shift; axes, if it takes axes to axes and keeps lengths; turn, about `axis`; else other."""
    sources: tuple[int | None, ...] = (0, 1, 2)
    """For each axis the axis that it is the image of, if any."""
    signs: tuple[int, ...] = (1, 1, 1)
    axis: int = 0


class _KnownSteps:
    """The kinds and the numbers of steps, each found once; other steps are numbered, equal ones alike."""

    def __init__(self) -> None:
        self.kinds: dict[_StepKind, int] = {_StepKind("shift"): 0}
        self._steps: dict[int, tuple[Step, int, tuple[float, ...]]] = {}
        self._others: dict[Step, int] = {}

    def of(self, step: Step) -> tuple[int, tuple[float, ...]]:
        """Return the number of the kind of a step, and the numbers of the step."""
        if isinstance(step, Translate):
            return 0, step.offset
        found = self._steps.get(id(step))
        if found is None:
            kind, numbers = self._find(step)
            found = self._steps[id(step)] = step, self.kinds.setdefault(kind, len(self.kinds)), numbers
        return found[1], found[2]

    def _find(self, step: Step) -> tuple[_StepKind, tuple[float, ...]]:
        if isinstance(step, Rotate) and sum(map(bool, step.axis)) == 1 and step.degrees % 90:
            axis = next(k for k in range(3) if step.axis[k])
            kept = tuple(k if k == axis else None for k in range(3))
            return _StepKind("turn", kept, axis=axis), (*step.axis, step.degrees)
        sources: list[int | None] = [None] * 3
        is_oblique = isinstance(step, Rotate) and (step.degrees % 90 or sum(map(bool, step.axis)) > 1)
        if isinstance(step, AxisFrame):  # by its formulas, no axis goes to one
            is_oblique = step.reference is None and all(step.axis)
        if not is_oblique:
            linear, shift = step.forth_and_back[0]
            for k, column in enumerate(zip(*linear, strict=True)):
                if sum(map(bool, column)) == 1:
                    sources[next(i for i in range(3) if column[i])] = k
            factors = [row[k] for row, k in zip(linear, sources, strict=True) if k is not None]
            # Nothing is rounded where all of it are signs
            if len(factors) == 3 and all(abs(x) == ex.ONE and not x.off for x in factors) and not any(shift):
                x, y, z = (1 if factor > ex.ZERO else -1 for factor in factors)
                return _StepKind("axes", tuple(sources), (x, y, z)), ()
        if isinstance(step, Transform):
            # The shift of each row comes last, as that of a translation
            numbers = [x for k in range(3) for x in step.matrix[k][:3]]
            return _StepKind("matrix", tuple(sources)), (*numbers, *(row[3] for row in step.matrix[:3]))
        return _StepKind("other", tuple(sources)), (float(self._others.setdefault(step, len(self._others))),)


def name_surfaces(forms: Floats, chains: Sequence[tuple[Step, ...]], chain_of: Longs) -> Longs:
    """Number surfaces that chains of steps carry: equal numbers are equal surfaces with the same inside, or planes.

    Centers move exactly, as sums of two floats, as far as steps shift and exchange axes, or turn a surface within
    itself. From there on surfaces of equal numbers are equal after equal steps, without the shifts that move them
    within themselves: so the caps of parallel wires, side by side, are one plane.

    Parameters
    ----------
    forms : array
        (n, 9) the surfaces before any step, as `SurfaceForm`.
    chains : sequence of tuples of steps
        The motions.
    chain_of : array
        (n,) the motion of each surface.

    Returns
    -------
    array
        (n,) the number of each. Where its numbers are no sums of two floats, others have it under equal steps alone.
    """
    known, rows, found = _KnownSteps(), _NameRows(), np.full(len(forms), -1)
    every = list(chain.from_iterable(chains))
    first_of, step_of = unique_first_with_inverse(np.fromiter(map(id, every), np.int64, len(every)))
    steps = [known.of(every[k]) for k in first_of.tolist()]
    codes, place, tables = np.array([code for code, _ in steps], np.int64), np.zeros(len(steps), np.int64), []
    for code in range(len(known.kinds)):
        mine = np.flatnonzero(codes == code)
        place[mine] = np.arange(len(mine))
        tables.append(np.array([steps[k][1] for k in mine.tolist()]).reshape(len(mine), -1) if len(mine) else codes)
    sizes = np.array(list(map(len, chains)), np.int64)
    begins = np.cumsum(sizes) - sizes
    raw = codes[step_of].tobytes()
    keys = [raw[8 * at : 8 * end] for at, end in zip(begins.tolist(), (begins + sizes).tolist(), strict=True)]
    group, position = np.zeros(len(chains), np.int64), np.zeros(len(chains), np.int64)
    kinds_of = positions_by_key(keys)
    for number, members in enumerate(kinds_of.values()):
        group[members], position[members] = number, np.arange(len(members))
    all_kinds = list(known.kinds)
    for number, members in enumerate(kinds_of.values()):
        which = np.flatnonzero(group[chain_of] == number)
        if len(which):
            begin, own = begins[members], codes[step_of[begins[members[0]] : begins[members[0]] + sizes[members[0]]]]
            at = position[chain_of[which]]
            columns = [tables[code][place[step_of[begin + k]]][at] for k, code in enumerate(own.tolist())]
            rows.add(_CarriedForms(forms[which]), which, [all_kinds[code] for code in own.tolist()], columns)
    rows.number(found)
    return found


class _CarriedForms:
    """Some forms with their centers as sums of two floats, and which of them are exact."""

    def __init__(self, forms: Floats) -> None:
        self.given = forms
        self.kind, self.weights, self.rests = forms[:, 0], forms[:, 1:4].copy(), np.zeros((len(forms), 3))
        self.centers, self.constant = forms[:, 4:7].copy(), forms[:, 7:9].copy()
        self.exact = np.ones(len(forms), bool)

    def shift(self, offsets: Floats, rows: npt.NDArray[np.bool_]) -> None:
        """Move the centers of some forms."""
        for axis in range(3):
            some = np.flatnonzero(rows & (self.weights[:, axis] != 0.0) & (offsets[:, axis] != 0.0))
            if len(some):
                pair = np.stack([self.centers[some, axis], self.rests[some, axis]], axis=1)
                self.centers[some, axis], self.rests[some, axis] = self._sum(pair, offsets[some, axis], some).T

    def turn(self, kind: _StepKind, rows: npt.NDArray[np.bool_]) -> None:
        """Exchange the axes of some forms."""
        sources, signs = np.array(kind.sources, np.int64), np.array(kind.signs, np.float64)
        self.centers[rows] = self.centers[rows][:, sources] * signs
        self.rests[rows] = self.rests[rows][:, sources] * signs
        signed = np.where((self.kind[rows] == _QUADRIC_FORM)[:, None], 1.0, signs)
        self.weights[rows] = self.weights[rows][:, sources] * signed

    def keep(self, axis: int) -> npt.NDArray[np.bool_]:
        """Return which forms a rotation about an axis leaves where they are."""
        i, j = (k for k in range(3) if k != axis)
        centered = (self.centers[:, [i, j]] == 0.0).all(axis=1) & (self.kind == _QUADRIC_FORM)
        return (self.weights[:, i] == self.weights[:, j]) & ((self.weights[:, i] == 0.0) | centered)

    def _sum(self, pair: Floats, number: Floats, rows: Longs) -> Floats:
        """Add numbers (n,) to sums of two floats (n, 2) of these rows, and note where the sum is none."""
        total, lost = two_sum(pair[:, 0], number)
        rest, least = two_sum(pair[:, 1], lost)
        self.exact[rows] &= least == 0.0
        return np.stack(two_sum(total, rest), axis=1)

    def columns(self) -> Floats:
        """Return the numbers of all forms: planes by their normals and distances, up to sign and powers of two."""
        flat = np.flatnonzero(self.kind == _PLANE_FORM)
        constant = self.constant[flat]
        for axis in range(3):
            for part in (self.centers, self.rests):
                product, lost = two_product(self.weights[flat, axis], part[flat, axis])
                self.exact[flat] &= (product == 0.0) | (np.abs(product) > _LEAST_PRODUCT)
                for number in (product, lost):
                    if number.any():
                        constant = self._sum(constant, number, flat)
        weights = self.weights[flat]
        lead = weights[np.arange(len(flat)), (weights != 0.0).argmax(axis=1)]
        scale = np.copysign(np.exp2(1.0 - np.frexp(lead)[1]), lead)[:, None]
        self.weights[flat], self.constant[flat] = weights * scale, constant * scale
        self.exact[flat] &= (self.constant[flat] / scale == constant).all(axis=1)
        self.centers[flat] = self.rests[flat] = 0.0
        return np.concatenate([self.kind[:, None], self.weights, self.centers, self.rests, self.constant], axis=1)


class _NameRows:
    """Rows of numbers, each under the kinds of the steps that are left: equal rows are equal surfaces."""

    def __init__(self) -> None:
        self._rows: dict[tuple[_StepKind | None, ...], list[tuple[Longs, Floats]]] = {}

    def add(self, forms: _CarriedForms, which: Longs, kinds: Sequence[_StepKind], numbers: Sequence[Floats]) -> None:
        """Carry forms as far as they stay exact, and add their rows; `numbers` are those of each step."""
        active, count = np.ones(len(which), bool), np.zeros(len(which), np.int64)
        for kind, own in zip(kinds, numbers, strict=True):
            if kind.tag == "shift":
                forms.shift(own, active)
            elif kind.tag == "axes":
                forms.turn(kind, active)
            else:
                active &= forms.keep(kind.axis) if kind.tag == "turn" else False
            count += active
        rows, free = forms.columns(), forms.weights == 0.0
        others = np.flatnonzero(~forms.exact)
        if len(others):
            whole = [forms.given[others], *(own[others] for own in numbers)]
            self._rows.setdefault((None, *kinds), []).append((which[others], np.concatenate(whole, axis=1)))
        code = count * 8 + free @ (1, 2, 4)
        for one in unique_sorted(code[forms.exact]).tolist():
            some = np.flatnonzero(forms.exact & (code == one))
            begin, own_free = one // 8, [bool(one >> axis & 1) for axis in range(3)]
            columns, moves = [], []
            for kind, own in zip(kinds[begin:], numbers[begin:], strict=True):
                own = own[some]
                if kind.tag != "shift":
                    own_free = [k is not None and own_free[k] for k in kind.sources]
                if kind.tag in ("shift", "matrix"):
                    own[:, -3:][:, own_free] = 0.0
                columns.append(own)
                moves.append(own.any(axis=1) if kind.tag == "shift" else np.ones(len(some), bool))
            # Shifts within the surface count as none
            patterns, pattern_of = np.unique(np.array(moves, bool).reshape(-1, len(some)), axis=1, return_inverse=True)
            for number, moved in enumerate(patterns.T.tolist()):
                mine = np.flatnonzero(pattern_of.ravel() == number)
                key = tuple(compress(kinds[begin:], moved))
                parts = [part[mine] for part in (rows[some], *compress(columns, moved))]
                self._rows.setdefault(key, []).append((which[some[mine]], np.concatenate(parts, axis=1)))

    def number(self, names: Longs) -> None:
        """Write the number of each surface."""
        known: dict[tuple[int, bytes], int] = {}
        for key, parts in enumerate(self._rows.values()):
            for which, rows in parts:
                raw, width = (rows + 0.0).tobytes(), 8 * rows.shape[1]
                names[which] = [
                    known.setdefault((key, raw[at : at + width]), len(known)) for at in range(0, len(raw), width)
                ]


# --- Bodies in groups of equal pattern

_CHUNK = 1 << 13


class ShapeSource(Protocol):
    """A source of shapes, by the number of their entry."""

    def __getitem__(self, number: int, /) -> Shape: ...


class BodyShapes:
    """The shapes of bodies, read one by one on demand, because not all bodies may exist yet."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies

    def __getitem__(self, number: int) -> Shape:
        return self._bodies[number].shape


class ExactBodySurfaces:
    """The exact surfaces of a scene's bodies, in body order, and the exact outlines of polygons.

    Few are ever needed: surfaces that may coincide with others, and those that a doubtful ray hits. The surfaces of a
    shape are computed on first use and cached with the shape.
    """

    def __init__(self, shapes: ShapeSource, starts: Any, first: Any, first_outline: Any) -> None:
        """Create the source.

        `shapes` gives the shape of each entry; `starts` the number of its first body (None: each entry has one body).
        `first` and `first_outline` give for each body the number of its first surface and first outline.
        """
        self._shapes, self._starts, self.first, self._first_outline = shapes, starts, first, first_outline

    def of(self, shapes: ShapeSource, first: Any = None) -> ExactBodySurfaces:
        """Return the same for other entries with as many bodies, and surfaces, unless `first` says how many."""
        first = self.first if first is None else first
        return ExactBodySurfaces(shapes, self._starts, first, self._first_outline)

    def __getitem__(self, index: int) -> Surface:
        return _body_surface(*self._of(index))

    def name(self, index: int) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        shape, own = self._of(index)
        names: dict[int, tuple[Key, int]] = shape.cache.setdefault("names", {})
        if own not in names:
            names[own] = _body_surface(shape, own).key()
        return names[own]

    def known_names(self, surfaces: Longs, primitives: Primitives | None) -> Longs:
        """Return names, known without exact keys, that are equal only for surfaces that are certainly equal.

        -1 for no name; few surfaces have none, as exact keys are as quick.
        """
        if len(surfaces) < FEWEST_SURFACES:
            return np.full(len(surfaces), -1)
        parts, which, own = self._locate(surfaces, primitives)
        names = np.where(which < 0, -1, which * (1 + int(own.max())) + own)
        solid = np.flatnonzero(which >= 0)
        if len(solid):
            first_of, place = unique_first_with_inverse(names[solid])
            some, numbers = which[solid[first_of]], own[solid[first_of]]
            carried = unique_sorted(some)
            leaf_of, leaves = np.searchsorted(carried, some), [parts[k] for k in carried.tolist()]
            forms = _list_forms([leaf for leaf, _ in leaves], leaf_of, numbers)
            chains = [(*leaf.placement.steps, *steps) for leaf, steps in leaves]
            names[solid] = name_surfaces(forms, chains, leaf_of)[place]
        return names

    def _locate(
        self, surfaces: Longs, primitives: Primitives | None
    ) -> tuple[list[tuple[Any, tuple[Step, ...]]], Longs, Longs]:
        """Return primitives with their steps, and for each surface the number of its primitive and its number there.

        -1 stands for primitives that are no solids.
        """
        parts: list[tuple[Any, tuple[Step, ...]]] = []
        which, own = np.full((2, len(surfaces)), -1)
        if primitives is not None:
            parts = [(leaf, leaf.motion.steps) for leaf in primitives.leaves]
            is_solid = np.array([*(isinstance(leaf, PrimitiveSolid) for leaf, _ in parts), False])
            which, own = primitives.leaf[surfaces].astype(np.int64), primitives.number[surfaces].astype(np.int64)
            which[~is_solid[which]] = -1
        left = np.flatnonzero(which < 0)
        if not len(left):
            return parts, which, own
        known: dict[tuple[int, int], int] = {}
        starts: list[int] = []  # of each primitive of each body the first surface, and the number of the primitive
        numbers: list[int] = []
        bodies = unique_sorted(np.searchsorted(self.first, surfaces[left], side="right") - 1)
        for body, first in zip(bodies.tolist(), self.first[bodies].tolist(), strict=True):
            found = _shape_leaves(self._single(body))
            if found is None:
                starts.append(first)
                numbers.append(-1)
                continue
            starts += [first + begin for begin in found.first[:-1]]
            for leaf in found.moved:
                numbers.append(known.setdefault((id(leaf[0]), id(leaf[1])), len(parts)))
                if numbers[-1] == len(parts):
                    parts.append(leaf)
        at = np.searchsorted(starts, surfaces[left], side="right") - 1
        which[left], own[left] = np.array(numbers)[at], surfaces[left] - np.array(starts)[at]
        return parts, which, own

    def outline(self, polygon: int) -> tuple[ex.Row, ...]:
        """Return the exact corners of a polygon."""
        body = int(np.searchsorted(self._first_outline, polygon, side="right")) - 1
        return lower_shape(self._shape(body)).outlines[polygon - int(self._first_outline[body])]

    def _of(self, index: int) -> tuple[Shape, int]:
        """Return the shape that a surface belongs to, and the number of the surface within that shape."""
        # Of the type of the array, which would be converted otherwise
        body = int(np.searchsorted(self.first, self.first.dtype.type(index), side="right")) - 1
        shape = self._shape(body)
        return shape, body - self._start(body) if isinstance(shape, Spheres) else index - int(self.first[body])

    def _entry(self, body: int) -> int:
        """Return the entry that a body belongs to."""
        return body if self._starts is None else int(np.searchsorted(self._starts, body, side="right")) - 1

    def _start(self, body: int) -> int:
        """Return the first body of the entry that a body belongs to."""
        return body if self._starts is None else int(self._starts[self._entry(body)])

    def _single(self, body: int) -> Shape:
        """Return the shape of a body, which nobody needs to cache."""
        shape = self._shapes[self._entry(body)]
        return shape.single(body - self._start(body)) if isinstance(shape, Bulk) else shape

    def _shape(self, body: int) -> Shape:
        """Return the shape of a body in which its surfaces and their names are cached.

        A `Spheres` caches those of its balls.
        """
        shape = self._shapes[self._entry(body)]
        if not isinstance(shape, Bulk) or isinstance(shape, Spheres):
            return shape
        singles: dict[int, Shape] = shape.cache.setdefault("singles", {})
        own = body - self._start(body)
        if own not in singles:
            singles[own] = shape.single(own)
        return singles[own]


def _body_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body; of a `Spheres`, the surface of one of its balls."""
    if isinstance(shape, Spheres):
        return shape.cache["balls"][2][number]
    return exact_surface(shape, number)


class BodyCollector:
    """Sorts a scene's bodies into groups, and numbers them in the order of the entries."""

    def __init__(self) -> None:
        self.contents = BodyGroups(0)
        self.items: Sequence[int] | Ints = []  # bodies of each entry of the scene
        self.frames: Sequence[int] = []  # frames of balls up to and with each entry
        self.paints: dict[int, dict[int, Material]] = {}  # body -> face -> material, where it is not the body's
        self._batch = BatchLowering()
        self._single_shapes: list[tuple[Shape, int]] = []
        self._rows_by_pattern: dict[BodyPattern, tuple[list[int], list[list[float]]]] = {}

    def collect(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Lower all bodies of a scene, and report progress."""
        if isinstance(bodies, InstanceList):
            self._take_instances(bodies, stages)
        else:
            self._take(bodies, stages)
        found, left = self._batch.lower(lambda part, of: stages.advance(AFTER_READING, AFTER_BATCH, part, of))
        single = [*self._single_shapes, *left]
        done = len(bodies) - len(single)
        stages.bodies(done)
        self.contents.groups += found
        self.paints.update(self._batch.paints)
        self._batch = BatchLowering()  # releases the inputs of the batch
        for more, (shape, number) in enumerate(single, start=1):
            self._add(shape, number)
            stages.bodies(done + more)
        for pattern, (numbers, rows) in self._rows_by_pattern.items():
            self.contents.groups.append(BodyGroup(pattern, np.array(numbers, np.int32), np.array(rows)))

    def _take(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Sort bodies by the way in which they are lowered: in batches, one by one, or as bulk balls."""
        done, items, frames = 0, [], []
        for number, body in enumerate(bodies):
            # Progress costs time: report every 1,024 entries.
            if number & 1023 == 0:
                stages.advance(0.0, AFTER_READING, number, len(bodies))
            before, shape = self.contents.body_count, body.shape
            if not _is_bulk(type(shape)):
                self.contents.body_count += 1
                self._add_one(shape, before)
            elif isinstance(shape, Spheres):
                self._add_spheres(shape)
                done += 1
                if not stages.many:
                    stages.bodies(done)
            elif isinstance(shape, Bulk):
                self._batch.add_many(shape, before)
                self.contents.body_count += len(shape)
            items.append(self.contents.body_count - before)
            frames.append(len(self.contents.ball_frames))
        self.items, self.frames = items, frames

    def _add_one(self, shape: Shape, number: int) -> None:
        """Queue a body for the batch, or for single lowering where it is lowered already or cannot be batched."""
        # A shape that was lowered before is in its own cache already.
        if "part" in vars(shape).get("cache", ()) or not self._batch.add(shape, number):
            self._single_shapes.append((shape, number))

    def _take_instances(self, bodies: InstanceList, stages: ProgressStages) -> None:
        """`_take` for a scene with instances: each kind of body is lowered from few of its copies, where possible."""
        self.contents.body_count, done = len(bodies), 0
        self.items = np.ones(len(bodies), np.int32)
        primitives, mover = PrimitiveCache(), PointPlaneMover()
        for kind, numbers in enumerate(bodies.members):
            stages.advance(0.0, AFTER_READING, done, len(bodies))
            rows = instance_rows(bodies, kind, numbers, primitives, mover)
            done += len(numbers)
            if rows is not None:
                self.contents.groups.append(BodyGroup(rows[0], numbers, rows[1]))
                continue
            for number in numbers.tolist():
                self._add_one(bodies.shape(number), number)

    def _add(self, shape: Shape, place: int) -> None:
        """Lower one body by itself."""
        part = lower_shape(shape)
        numbers, rows = self._rows_by_pattern.setdefault(part.pattern, ([], []))
        numbers.append(place)
        rows.append(part.row)
        if part.paints:
            self.paints[place] = part.paints

    def _add_spheres(self, shape: Spheres) -> None:
        """Add balls straight from arrays; as ellipsoids where the motion is no similarity."""
        contents = self.contents
        centers, linear, factor = shape.placed(IDENTITY_MOTION)
        boxes = _ball_boxes(centers, shape.radii, np.sqrt((linear**2).sum(axis=1)))
        back = shape.motion.inverse_matrix[:3, :3]
        contents.ball_frames.append(back.ravel())
        frame = -len(contents.ball_frames)
        bodies = np.arange(contents.body_count, contents.body_count + len(shape), dtype=np.int32)
        contents.body_count += len(shape)
        if factor is not None:
            balls = np.empty((len(shape), 4))

            def place(begin: int, end: int) -> None:
                """Write the records of balls begin..end."""
                balls[begin:end, :3] = centers[begin:end]
                np.multiply(shape.radii[begin:end], factor, out=balls[begin:end, 3])

            run_chunks(place, len(shape), _CHUNK)
            contents.balls.append(BulkBalls(bodies, balls, boxes, frame))
        elif len(shape):
            pattern, rows, _ = lower_stretched_balls(shape, centers, boxes, back)
            contents.groups.append(BodyGroup(pattern, bodies, rows, frame))


@cache
def _is_bulk(kind: type) -> bool:
    """Return whether entries of a type have many bodies."""
    return issubclass(kind, Bulk)


def _ball_boxes(centers: FloatArray, radii: FloatArray, stretch: FloatArray) -> Floats:
    """Return boxes (n, 6) around balls whose radius is stretched along each axis."""
    boxes, arrays = np.empty((len(radii), 6)), (np.ascontiguousarray(centers), np.ascontiguousarray(radii))
    run_chunks(KernelRange(box_balls, arrays, (tuple(stretch.tolist()), boxes)), len(radii), _CHUNK)
    return boxes


@kernel(centers="n 3", radii="n", begin="0..end", end="0..n", boxes="out n 6")
def box_balls(
    centers: Floats, radii: Floats, begin: int, end: int, stretch: tuple[float, float, float], boxes: Floats
) -> None:
    """Write the boxes of balls begin..end."""
    for i in range(begin, end):
        for k in range(3):
            reach = radii[i] * stretch[k]
            # One ulp outward covers the rounding of the sum.
            boxes[i, k], boxes[i, k + 3] = next_float_down(centers[i, k] - reach), next_float_up(centers[i, k] + reach)
