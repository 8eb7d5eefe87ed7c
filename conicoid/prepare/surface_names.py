"""Names of surfaces: exact numbers before the first step of a motion that would round them.

The walls of crystals in a rotated module, or of boxes in an oblique row, coincide by the hundred. Keys in 3,000 bits
would show it, at a millisecond each. Exact sums of floats carry many surfaces at once as far as translations and
quarter turns lead, and rotations about an axis that leave a surface where it is. From there on surfaces with equal
numbers are equal after equal steps, without the shifts that move a surface within itself.

User: rows of bodies that share walls under a turn; factor over exact keys: 28 for preparing 1,728 turned boxes side by
side, 5 for 1,600 turned cylinders (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, compress
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._util.records import two_product, two_sum, unique_first_with_inverse, unique_sorted, unique_with_inverse
from ..geometry.cell import faces_of_tree
from ..geometry.surface import UPRIGHT, PlaneSurface, QuadricSurface, Surface, Triple
from ..geometry.transform import AxisFrame, Rotate, Step, Transform, Translate
from ..kernels.tables import Floats, Longs
from ..numerics import bigfloat as ex
from ..numerics.portable_math import is_float
from ..numerics.tracing import Tape
from .pytree import ParameterRows, flatten_all, positions_by_key, unflatten
from .tape import recordings
from .tape.recordings import NO_INPUTS

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


# Surfaces of a primitive in its own frame, and their forms


def own_surfaces(leaf: Any) -> Sequence[Surface]:
    """List the surfaces of a primitive solid in its own frame, once for all its copies."""
    found: Sequence[Surface] | None = leaf.own_cache.get("surfaces")
    if found is None:
        found = leaf.surfaces if leaf._face_count else [face.surface for face in faces_of_tree(leaf.tree())]
        leaf.own_cache["surfaces"] = found
    return found


def _own_form(leaf: Any, number: int) -> SurfaceForm | None:
    """Return the form of a surface of a primitive solid in its own frame, found once for all its copies."""
    found: dict[int, SurfaceForm | None] = leaf.own_cache.setdefault("forms", {})
    if number not in found:
        # A form needs no anchor, which takes fractions
        surface = PlaneSurface(*leaf._sides[number]) if leaf._face_count else own_surfaces(leaf)[number]
        found[number] = _surface_form(surface)
    return found[number]


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
    if any(float(weight) != weight for weight in weights):  # a tube of radius r has 1 / r², and squares are floats
        lead = next(abs(weight) for weight in weights if weight)
        weights, constant = [weight / lead for weight in weights], constant / lead
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
    found, rest = _float_and_rest(value)
    if rest:
        raise _InexactFormError
    return found


def _two_floats(value: Any) -> tuple[float, float]:
    """Return a number as a float and the float that is missing from it."""
    high, rest = _float_and_rest(value)
    return high, _exact_float(rest)


def _float_and_rest(value: Any) -> tuple[float, Any]:
    """Return the nearest float of a number, which may be recorded, and what is missing from it."""
    if is_float(value):
        return value, 0.0
    if isinstance(value, ex.Symbol):
        found = ex.rounded(value)
        return found, value.exact() - ex.exact(found)
    exact = _rational(value)
    found = float(exact)
    if found.as_integer_ratio() == (exact.numerator, exact.denominator):
        return found, 0.0
    return found, exact - Fraction(found)


def list_forms(leaves: Sequence[Any], leaf_of: Longs, own: Longs) -> Floats:
    """Return the forms (n, 9) of surfaces, by their primitive and number there.

    Surfaces without a form are numbered, equal ones alike.
    """
    firsts, copy_of = unique_first_with_inverse(np.array([id(leaf.own_cache) for leaf in leaves]))
    solids, count = [leaves[k] for k in firsts.tolist()], 1 + int(own.max())
    which, place = unique_with_inverse(copy_of[leaf_of] * count + own)
    solid_of, number = np.divmod(which, count)
    forms = np.full((len(which), _FORM_NUMBERS), np.nan)
    for group in flatten_all(solids) if len(which) >= recordings.FEWEST else ():
        if solids[group.which[0]]._face_count:
            continue
        row_of = np.full(len(solids), -1)
        row_of[group.which] = np.arange(len(group.which))
        rows = row_of[solid_of]
        for one in unique_sorted(number[rows >= 0]).tolist():
            some = np.flatnonzero((rows >= 0) & (number == one))
            _play_forms(group, one, [solids[k] for k in solid_of[some].tolist()], rows[some], forms, some)
    numbers: dict[Surface, int] = {}
    for row in np.flatnonzero(np.isnan(forms[:, 0])).tolist():
        leaf, one = solids[solid_of[row]], int(number[row])
        form = _own_form(leaf, one)
        if form is None:
            form = _OTHER_FORM, *_NO_FORM, numbers.setdefault(own_surfaces(leaf)[one], len(numbers)), 0.0
        forms[row] = form
    return forms[place]


def _play_forms(
    group: ParameterRows, number: int, leaves: Sequence[Any], rows: Longs, forms: Floats, places: Longs
) -> None:
    """Write the forms of one surface of primitives of equal structure to these places, where a recording gives them."""

    def record(row: int, tape: Tape) -> None:
        form = _surface_form(list(faces_of_tree(unflatten(leaves[row], tape).tree()))[number].surface)
        if form is None:
            raise TypeError("a traced surface has no form")
        for each in form:
            tape.write(each)

    inputs = group.numbers[rows]
    found, _ = recordings.RECORDINGS.play(
        ("form", group.form, number), record, inputs, NO_INPUTS, np.zeros(len(inputs), np.int32)
    )
    for _, which, played in found:
        forms[places[which]] = played.floats


class _StepKind(NamedTuple):
    """How a step carries coordinates: all of it but its numbers."""

    tag: str
    """shift; axes, if it takes axes to axes, keeps lengths and then shifts; turn, about `axis`; matrix; else other."""
    sources: tuple[int | None, ...] = (0, 1, 2)
    """For each axis the axis that it is the image of, if any."""
    signs: tuple[int, ...] = (1, 1, 1)
    axis: int = 0

    def free_axes(self, free: Sequence[bool]) -> list[bool]:
        """Return along which axes a surface is free after the step, by those along which it was."""
        if self.tag == "turn":
            return [free[k] and k == self.axis for k in range(3)]
        return [k is not None and free[k] for k in self.sources]

    def quarters(self, count: int) -> _StepKind:
        """Return the kind of a step that turns by `count` quarters about `axis`."""
        i, j = (self.axis + 1) % 3, (self.axis + 2) % 3
        sources, signs = [0, 1, 2], [1, 1, 1]
        if count % 2:
            sources[i], sources[j] = j, i
        signs[i], signs[j] = ((1, 1), (-1, 1), (-1, -1), (1, -1))[count]
        return _StepKind("axes", tuple(sources), tuple(signs))


def _split_angle(degrees: float) -> tuple[float, float]:
    """Split an angle exactly into one from above -45 to 45 degrees, and 0 to 3 quarters."""
    degrees = math.fmod(degrees, 360.0)
    rest = math.remainder(degrees, 90.0)
    rest = 45.0 if rest == -45.0 else rest
    return rest, round((degrees - rest) / 90.0) % 4


class _KnownSteps:
    """The kinds and the numbers of steps, each found once; other steps are numbered, equal ones alike."""

    def __init__(self) -> None:
        self.kinds: dict[_StepKind, int] = {_StepKind("shift"): 0}
        self._steps: dict[Step, tuple[int, tuple[float, ...]]] = {}
        self._others: dict[Step, int] = {}

    def of(self, step: Step) -> tuple[int, tuple[float, ...]]:
        """Return the number of the kind of a step, and the numbers of the step."""
        if isinstance(step, Translate):
            return 0, step.offset
        found = self._steps.get(step)
        if found is None:
            kind, numbers = self._find(step)
            found = self._steps[step] = self.kinds.setdefault(kind, len(self.kinds)), numbers
        return found

    def _find(self, step: Step) -> tuple[_StepKind, tuple[float, ...]]:
        if isinstance(step, Rotate) and sum(map(bool, step.axis)) == 1 and step.degrees % 90:
            axis = next(k for k in range(3) if step.axis[k])
            return _StepKind("turn", axis=axis), _split_angle(
                math.copysign(step.degrees, step.degrees * step.axis[axis])
            )
        sources: list[int | None] = [None] * 3
        is_oblique = isinstance(step, Rotate) and (step.degrees % 90 or sum(map(bool, step.axis)) > 1)
        if isinstance(step, AxisFrame):  # by its formulas, no axis goes to one
            is_oblique = step.reference is None and all(step.axis)
        if not is_oblique:
            linear, shift = step.affine()  # without the inverse
            for k, column in enumerate(zip(*linear, strict=True)):
                if sum(map(bool, column)) == 1:
                    sources[next(i for i in range(3) if column[i])] = k
            factors = [row[k] for row, k in zip(linear, sources, strict=True) if k is not None]
            offset = tuple(map(ex.rounded, shift))
            # Nothing is rounded where all factors are 1 or -1, and the shift consists of floats
            signed = len(factors) == 3 and all(abs(x) == ex.ONE and not x.off for x in factors)
            if signed and all(x == ex.exact(to) and not x.off for x, to in zip(shift, offset, strict=True)):
                x, y, z = (1 if factor > ex.ZERO else -1 for factor in factors)
                return _StepKind("axes", tuple(sources), (x, y, z)), offset
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
            if kind.tag == "axes":
                forms.turn(kind, active)
            if kind.tag in ("shift", "axes"):
                forms.shift(own, active)
            elif kind.tag == "turn":
                for quarters in (1, 2, 3):
                    forms.turn(kind.quarters(quarters), active & (own[:, 1] == quarters))
                active &= forms.keep(kind.axis)
            else:
                active[:] = False
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
            for place, (kind, own) in enumerate(zip(kinds[begin:], numbers[begin:], strict=True)):
                own, own_free = own[some], kind.free_axes(own_free)
                if kind.tag == "turn" and place == 0:
                    own[:, 1] = 0.0  # the forms have been turned by these quarters
                if kind.tag in ("shift", "axes", "matrix"):
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
