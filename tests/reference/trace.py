"""Every crossing of rays with bodies on the whole line, in order."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb, fmpz

from .forms import Form, Row
from .numbers import Number, ball, number, sign
from .quadratics import Root, Table, in_order, negative_at_start, roots, whole_ray
from .solids import Body, Formula, Sheet

Array = npt.NDArray[Any]
NO_FACE = 1 << 30
STEP = 2.0**-20
"""The distance, in sizes of nearby bodies, of the rays beside one that decide which walls have a face where it crosses
them.
"""
BESIDE = 2.0**-12
"""Crossings of these rays differ less than this from its own."""
_DIRECTIONS = np.random.default_rng(1).normal(size=(64, 3))


@dataclass
class Crossings:
    """Rows in order of ray, place and body: those of ray i are offsets[i]:offsets[i + 1]; `roots` are their exact places."""

    offsets: Array
    ray: Array
    body: Array
    entering: Array
    face: Array
    surface: Array
    roots: Array
    inside: Array
    """(bodies, rays) of solids, towards t = -inf."""

    @cached_property
    def t(self) -> Array:
        """The places rounded to floats."""
        return np.array([root.place for root in self.roots], float)

    @cached_property
    def sign(self) -> Array:
        """The sides of the origins on which they lie."""
        return np.array([root.sign for root in self.roots], int)

    def ahead(self) -> Crossings:
        """Return those with t > 0."""
        keep = self.sign > 0
        offsets = np.concatenate([[0], np.cumsum(np.bincount(self.ray[keep], minlength=len(self.offsets) - 1))])
        columns = (x[keep] for x in (self.ray, self.body, self.entering, self.face, self.surface, self.roots))
        return Crossings(offsets, *columns, self.inside)


class Trace:
    """Bodies of a table under rays.

    `start` (rays,) is the surface that each starts on, or -1. Its root nearest to t = 0 is removed, and all is right
    where t > 0.
    """

    def __init__(self, table: Table, origins: Array, directions: Array, start: Array | None = None) -> None:
        self.table, self.origins, self.directions = table, np.asarray(origins, float), np.asarray(directions, float)
        self.groups: list[list[list[Root]]] = []  # of each ray, equal roots together, in order
        self.before = np.zeros((len(table.forms), len(self.origins)), bool)
        quadratics = table.quadratics(self.origins, self.directions)
        for ray, row in enumerate(quadratics):
            self._ray(ray, row, -1 if start is None else int(start[ray]))

    def _ray(self, ray: int, quadratics: Sequence[Any], start: int) -> None:
        every: list[Root] = []
        for surface, (form, quadratic) in enumerate(zip(self.table.forms, quadratics, strict=True)):
            found = roots(surface, quadratic, form.exact)
            negative = negative_at_start(form, quadratic)
            if start >= 0 and surface in self.table.twins[start]:
                found, negative = _without_start(form, found, negative)
            every += found
            self.before[surface, ray] = negative
        self.groups.append(in_order(every))

    @cached_property
    def states(self) -> Array:
        """Return (surfaces, rays, groups + 1): negative in each gap between groups."""
        turns = np.zeros((*self.before.shape, max(map(len, self.groups), default=0) + 1), np.int8)
        turns[:, :, 0] = self.before
        for ray, groups in enumerate(self.groups):
            for k, group in enumerate(groups):
                for root in group:
                    turns[root.surface, ray, k + 1] += 1
        return np.cumsum(turns, axis=2, dtype=np.int8) % 2 == 1

    def state(self, form: Form) -> Array:
        surface, sense = self.table.places[id(form)]
        return self.states[surface] if sense > 0 else ~self.states[surface]

    def held(self, forms: Sequence[Form]) -> Array:
        """Return whether a cell holds each gap."""
        found = np.ones(self.states.shape[1:], bool)
        for form in forms:
            found &= self.state(form)
        return found

    def closed(self, formula: Formula) -> Array:
        """Return, as (rays, groups), whether the place of a group is in a clip.

        Its cells hold it if they hold the gap before or after.
        """

        def held(forms: Sequence[Form]) -> Array:
            gaps = self.held(forms)
            return gaps[:, :-1] | gaps[:, 1:]

        return truth(formula, held)

    def _faces(self, formula: Formula, truth_after: Array) -> Array:
        """Return, as (rays, groups), the lowest face of cells that turn a formula to `wanted`, in the leaf's sense.

        A part that does not turn itself has no face there: a wall of its cells is cut away, or within the part.
        """
        kind, parts = formula
        if kind == "not":
            return self._faces(parts, ~truth_after)
        gaps = truth(formula, self.held)
        turned = (gaps[:, 1:] != gaps[:, :-1]) & (gaps[:, 1:] == truth_after)
        if kind != "cell":
            return np.where(turned, np.minimum.reduce([self._faces(part, truth_after) for part in parts]), NO_FACE)
        best = np.full(truth_after.shape, NO_FACE)
        for form in parts:
            state = self.state(form)
            mine = turned & (state[:, 1:] != state[:, :-1]) & (state[:, 1:] == gaps[:, 1:])
            best[mine] = np.minimum(best[mine], form.face)
        return best

    def _body(self, body: Body) -> tuple[Array, Array, Array, Array]:
        """Return (crossed, entering, face), each (rays, groups); inside towards -inf."""
        if body.sheet is None:
            gaps = truth(body.formula, self.held)
            entering = gaps[:, 1:]
            return entering != gaps[:, :-1], entering, self._faces(body.formula, entering), gaps[:, 0]
        sheet, state = body.sheet, self.state(body.sheet.surface)
        entering = state[:, 1:]
        crossed = entering != state[:, :-1]
        if sheet.one_sided:
            crossed = crossed & entering
        if sheet.clip is not None:
            crossed = crossed & self.closed(sheet.clip)
        if sheet.loop:
            inside = Loop(sheet)
            for ray in np.flatnonzero(crossed.any(axis=1)).tolist():
                crossed[ray] &= inside(self.origins[ray], self.directions[ray])
        return crossed, entering, np.zeros(crossed.shape, int), np.zeros(len(crossed), bool)

    @cached_property
    def crossings(self) -> Crossings:
        found = [self._body(body) for body in self.table.bodies]
        ray, group, body = np.nonzero(np.stack([f[0] for f in found], axis=2))
        entering, face = (np.stack([f[k] for f in found], axis=2)[ray, group, body] for k in (1, 2))
        assert (face < NO_FACE).all(), "a crossing on no face"
        surface = np.array([self.table.faces[b][f] for b, f in zip(body.tolist(), face.tolist(), strict=True)], int)
        at = np.empty(len(ray), object)
        for k, (r, g, s) in enumerate(zip(ray.tolist(), group.tolist(), surface.tolist(), strict=True)):
            at[k] = next(root for root in self.groups[r][g] if root.surface == s)
        offsets = np.concatenate([[0], np.cumsum(np.bincount(ray, minlength=len(self.origins)))])
        return Crossings(offsets, ray, body, entering, face, surface, at, np.stack([f[3] for f in found]))

    def put_face_beside(self, e: Crossings, row: int) -> None:
        """Give a crossing the lowest face that rays beside it cross there: the lowest of its walls may only touch."""
        ray, body, place = int(e.ray[row]), int(e.body[row]), float(e.t[row])
        d = self.directions[ray]
        origin = self.origins[ray] + place * d  # not exact: rays through it are beside that one
        size = np.abs(origin).max() + np.abs(d).max()
        beside = Trace(
            Table([self.table.bodies[body]]), origin + STEP * size * _DIRECTIONS, np.tile(d, (64, 1))
        ).crossings
        near = (np.abs(beside.t) * np.abs(d).max() < BESIDE * size) & (beside.entering == e.entering[row])
        if near.any():
            e.face[row] = beside.face[near].min()
            e.surface[row] = surface = self.table.faces[body][e.face[row]]
            group = next(group for group in self.groups[ray] if any(root is e.roots[row] for root in group))
            e.roots[row] = next(root for root in group if root.surface == surface)


def _without_start(form: Form, found: list[Root], negative: bool) -> tuple[list[Root], bool]:
    """Remove the root that a ray starts on. The form begins with its value beyond it."""
    if not found:  # it runs along the plane that it starts on: within it
        return found, form.side > 0 if form.flat else negative
    if len(found) == 2:
        p, q = (abs(root.ball(400)) for root in found)
        if not (p < q or p > q):  # a tangent, or a tip but for the rounding of sines: both roots are equally near
            return [], negative
        return found[1:] if p < q else found[:1], not negative
    return [], not negative


class Loop:
    """A test whether a ray is within the polygon of a sheet: even-odd, as documented, in the view along the ray."""

    def __init__(self, sheet: Sheet) -> None:
        every = [x for point in sheet.loop for x in point]
        if all(x.exact and x.k.keys() <= {1} for x in every):
            common = fmpz(1)
            for x in every:
                common = common.lcm(x.fraction.q)
            self.points: list[Any] = [[x.fraction.p * (common // x.fraction.q) for x in point] for point in sheet.loop]
            self.common = common
        else:
            self.points, self.common = list(sheet.loop), number(1)

    def __call__(self, origin: Sequence[float], direction: Sequence[float]) -> bool:
        """Return whether the ray is within.

        Vertices along the ray are (u, v) = (d_z X - d_x Z, d_z Y - d_y Z) with z the longest axis of the direction
        (ties: z before x before y). An edge counts from its lower end inclusive, where u > 0.
        """
        o, d, w = whole_ray(origin, direction)
        dx, dy, dz = map(abs, d)
        longest = 2 if dz >= dx and dz >= dy else 0 if dx >= dy else 1
        iu, iv, iw = ((1, 2, 0), (2, 0, 1), (0, 1, 2))[longest]
        corners = []
        for point in self.points:
            x = [c * w - self.common * p for c, p in zip(point, o, strict=True)]
            corners.append((d[iw] * x[iu] - d[iu] * x[iw], d[iw] * x[iv] - d[iv] * x[iw]))
        odd = False
        for (ua, va), (ub, vb) in itertools.pairwise([corners[-1], *corners]):
            below = sign(va) < 0
            if below != (sign(vb) < 0):
                odd ^= sign(ua * vb - ub * va) == (1 if below else -1)
        return odd


def truth(formula: Formula, held: Callable[[Sequence[Form]], Array]) -> Array:
    kind, parts = formula
    if kind == "cell":
        return held(parts)
    if kind == "not":
        return ~truth(parts, held)
    values = [truth(part, held) for part in parts]
    return (np.logical_and if kind == "all" else np.logical_or).reduce(values)


def values_at(table: Table, points: Array) -> list[Sequence[Any]]:
    """Return for each point the value of each form, times a positive number."""
    axis = np.broadcast_to([1.0, 0.0, 0.0], points.shape)
    return [[c for _, _, c in row] for row in table.quadratics(points, axis)]


def distances(table: Table, points: Array, surfaces: Array) -> Array:
    """Return the distance of points from one surface each, to first order: |f| / |grad f|, f exact.

    A step along an axis from a point is a quadratic A t² + B t + C, so that f is C and its slope B.
    """
    found = []
    rows = zip(*(table.quadratics(points, np.broadcast_to(axis, points.shape)) for axis in np.eye(3)), strict=True)
    for row, surface in zip(rows, surfaces.tolist(), strict=True):
        value = ball(row[0][surface][2], 100)
        slopes = [ball(quadratic[surface][1], 100) for quadratic in row]
        found.append(float(abs(value) / sum((b * b for b in slopes), arb(0)).sqrt()))
    return np.array(found)


def body_at(table: Table, points: Array) -> Array:
    """Return the first body that holds each point, or -1.

    Leaves are closed, combinations exactly Boolean; sheets hold nothing.
    """
    signs = np.array([[sign(v) for v in row] for row in values_at(table, points)], int).reshape(len(points), -1).T

    def held(forms: Sequence[Form]) -> Array:
        found = np.ones(len(points), bool)
        for form in forms:
            surface, sense = table.places[id(form)]
            found &= signs[surface] * sense <= 0
        return found

    found = np.full(len(points), -1)
    for index, body in reversed(list(enumerate(table.bodies))):
        if body.sheet is None and body.formula is not None:
            found[truth(body.formula, held)] = index
    return found


__all__ = ["Array", "Crossings", "Loop", "Number", "Row", "Trace", "body_at", "truth", "values_at"]
