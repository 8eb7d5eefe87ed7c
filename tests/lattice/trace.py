"""What rays do to bodies: every crossing of the whole line, in order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, ctx

from .columns import Array
from .lines import Lines, Table
from .loops import in_loop
from .order import Order, ordered
from .shapes import Body, Form, Formula, forms_of

NO_FACE = 1 << 30


@dataclass
class Crossings:
    """Rows in order of ray, place and body: those of ray i are offsets[i]:offsets[i + 1]; (slope, surface) is a root there."""

    offsets: Array
    ray: Array
    group: Array
    body: Array
    entering: Array
    face: Array
    slope: Array
    surface: Array
    inside: Array
    """(bodies, rays) of solids: towards t = -inf."""


class Trace:
    """Bodies of a table under rays. `start` (rays,): the surface that each starts on, or -1; one root of it, the
    nearest to t = 0, is taken out, and all is right where t > 0."""

    def __init__(self, table: Table, origins: Array, directions: Array, start: Array | None = None) -> None:
        self.table = table
        self.lines = Lines(table, np.asarray(origins, float), np.asarray(directions, float))
        self.order: Order = ordered(self.lines)
        before = self.lines.negative_at_start.copy()
        if start is not None:
            self._start(start, before)
        self.states = self._states(before)

    def _start(self, start: Array, before: Array) -> None:
        """Take out the root that each ray starts on; its form begins as it is beyond."""
        for ray in np.flatnonzero(start >= 0).tolist():
            for surface in self.table.twins[start[ray]]:
                self._start_one(ray, surface, before)

    def _start_one(self, ray: int, surface: int, before: Array) -> None:
        order = self.order
        own = np.flatnonzero(order.surface[ray] == surface)
        if not len(own):
            if self.table.flat[surface]:  # it runs along the plane that it starts on: within it
                before[surface, ray] = self.table.side[surface] > 0
            return
        if len(own) == 2 and self.lines.signs[1][surface, ray] == 0:  # a tangent: both roots are equally near
            order.surface[ray, own] = order.slope[ray, own] = -1
            return
        k = own[0] if len(own) == 1 else own[self._nearest(ray, surface, own)]
        before[surface, ray] = not before[surface, ray]
        order.surface[ray, k] = order.slope[ray, k] = -1

    def _nearest(self, ray: int, surface: int, own: Array) -> int:
        p, q = (abs(self.lines.ball(int(self.order.slope[ray, k]), surface, ray, 400)) for k in own)
        assert p < q or p > q, "two roots equally far from the origin"
        return 0 if p < q else 1

    def _states(self, before: Array) -> Array:
        """(surfaces, rays, groups + 1): negative in each gap between groups."""
        order, (forms, rays) = self.order, before.shape
        groups = int(order.group.max(initial=-1)) + 1
        turns = np.zeros((forms, rays, groups + 1), np.int8)
        ray, k = np.nonzero(order.surface >= 0)
        np.add.at(turns, (order.surface[ray, k], ray, order.group[ray, k] + 1), 1)
        return (np.cumsum(turns, axis=2) + before[:, :, None]) % 2 == 1

    def held(self, forms: Sequence[Form]) -> Array:
        """Is a cell held in each gap?"""
        found = np.ones(self.states.shape[1:], bool)
        for form in forms:
            surface, sense = self.table.places[id(form)]
            found &= self.states[surface] if sense > 0 else ~self.states[surface]
        return found

    def truth(self, formula: Formula, held: Callable[[Sequence[Form]], Array]) -> Array:
        kind, parts = formula
        if kind == "cell":
            return held(parts)
        if kind == "not":
            return ~self.truth(parts, held)
        found = self.truth(parts[0], held)
        for part in parts[1:]:
            found = found & self.truth(part, held) if kind == "all" else found | self.truth(part, held)
        return found

    def closed(self, formula: Formula) -> Array:
        """(rays, groups): is the place of a group in a clip? Its cells hold it if they hold what is before or after."""

        def held(forms: Sequence[Form]) -> Array:
            gaps = self.held(forms)
            return gaps[:, :-1] | gaps[:, 1:]

        return self.truth(formula, held)

    def flipped(self, form: Form) -> tuple[Array, Array]:
        """((rays, groups): does the form change sign, is it negative after)"""
        surface, sense = self.table.places[id(form)]
        state = self.states[surface] if sense > 0 else ~self.states[surface]
        return state[:, 1:] != state[:, :-1], state[:, 1:]

    def _faces(self, formula: Formula, wanted: Array, positive: bool = True) -> Array:
        """(rays, groups) the lowest face of the cells that turn as the body does: `wanted` after, in the leaf's sense."""
        kind, parts = formula
        if kind == "not":
            return self._faces(parts, wanted, not positive)
        if kind != "cell":
            return np.minimum.reduce([self._faces(part, wanted, positive) for part in parts])
        gaps = self.held(parts)
        turned = (gaps[:, 1:] != gaps[:, :-1]) & (gaps[:, 1:] == (wanted if positive else ~wanted))
        best = np.full(wanted.shape, NO_FACE)
        for form in parts:
            flips, after = self.flipped(form)
            mine = turned & flips & (after == gaps[:, 1:])
            best = np.where(mine, np.minimum(best, form.face), best)
        return best

    def _body(self, body: Body) -> tuple[Array, Array, Array, Array]:
        """(crossed, entering, face, inside towards -inf), (rays, groups)"""
        if body.sheet is None:
            assert body.formula is not None
            gaps = self.truth(body.formula, self.held)
            entering = gaps[:, 1:]
            face = self._faces(body.formula, entering)
            return entering != gaps[:, :-1], entering, face, gaps[:, 0]
        sheet = body.sheet
        crossed, entering = self.flipped(sheet.surface)
        if sheet.one_sided:
            crossed = crossed & entering
        if sheet.clip is not None:
            crossed = crossed & self.closed(sheet.clip)
        if sheet.loop and crossed.any():
            crossed = crossed & in_loop(sheet.loop, self.lines)[:, None]
        return crossed, entering, np.zeros(crossed.shape, int), np.zeros(len(crossed), bool)

    @cached_property
    def crossings(self) -> Crossings:
        found = [self._body(body) for body in self.table.bodies]
        crossed = np.stack([f[0] for f in found], axis=2)
        ray, group, body = np.nonzero(crossed)
        entering = np.stack([f[1] for f in found], axis=2)[ray, group, body]
        face = np.stack([f[2] for f in found], axis=2)[ray, group, body]
        assert (face < NO_FACE).all(), "a crossing on no face"
        counts = np.bincount(ray, minlength=self.lines.count)
        slope, surface = self._roots(ray, group, body, face)
        return Crossings(
            np.concatenate([[0], np.cumsum(counts)]), ray, group, body, entering, face, slope, surface,
            np.stack([f[3] for f in found]),
        )  # fmt: skip

    def _roots(self, ray: Array, group: Array, body: Array, face: Array) -> tuple[Array, Array]:
        """The root of the face that is told."""
        surface = np.array([self.surface_of(int(b), int(f)) for b, f in zip(body, face, strict=True)], int)
        match = (self.order.group[ray] == group[:, None]) & (self.order.surface[ray] == surface[:, None])
        assert match.any(axis=1).all(), "the surface of a face has no root there"
        return self.order.slope[ray, match.argmax(axis=1)], surface

    def surface_of(self, body: int, face: int) -> int:
        """The surface of a body's face."""
        return self.faces[body][face]

    @cached_property
    def faces(self) -> list[dict[int, int]]:
        return surfaces_by_face(self.table)

    def ball(self, slope: int, surface: int, ray: int, bits: int = 250) -> arb:
        """A root in units of the ray's direction."""
        with ctx.workprec(bits):
            return self.lines.ball(slope, surface, ray, bits) * arb(self.lines.unit(ray))

    def sign_of(self, slope: Array, surface: Array, ray: Array) -> Array:
        """Of roots: where they lie from the origins."""
        (t, error), (_, b, c) = self.lines.near, self.lines.signs
        t, error = t[slope, surface, ray], error[slope, surface, ray]
        found = np.sign(t).astype(int)
        zero = (c[surface, ray] == 0) & (b[surface, ray] == 2 * slope - 1)
        found[zero] = 0
        for i in np.flatnonzero(~(np.abs(t) > error) & ~zero).tolist():
            found[i] = self._sign(int(slope[i]), int(surface[i]), int(ray[i]))
        return found

    def _sign(self, slope: int, surface: int, ray: int) -> int:
        bits = 128
        while True:
            ball = self.lines.ball(slope, surface, ray, bits)
            if ball > 0 or ball < 0:
                return 1 if ball > 0 else -1
            bits *= 2

    def near(self, slope: Array, surface: Array, ray: Array) -> tuple[Array, Array]:
        """(roots in floats, bounds of their errors)"""
        t, error = self.lines.near
        unit = self.lines.units[ray]
        return t[slope, surface, ray] * unit, error[slope, surface, ray] * unit


def surfaces_by_face(table: Table) -> list[dict[int, int]]:
    """For each body the surface of each face."""
    found = []
    for body in table.bodies:
        if body.sheet is not None:
            found.append({0: table.places[id(body.sheet.surface)][0]})
        else:
            found.append({f.face: table.places[id(f)][0] for f in forms_of(body.formula)})
    return found


def body_at(table: Table, points: Array) -> Array:
    """The first body that holds each point, or -1. Leaves are closed, combinations exactly Boolean; sheets hold nothing."""
    signs = Lines(table, points, np.broadcast_to([1.0, 0.0, 0.0], points.shape)).signs[2]

    def truth(formula: Formula) -> Any:
        kind, parts = formula
        if kind == "cell":
            held = np.ones(len(points), bool)
            for form in parts:
                surface, sense = table.places[id(form)]
                held &= signs[surface] * sense <= 0
            return held
        if kind == "not":
            return ~truth(parts)
        values = [truth(part) for part in parts]
        return np.logical_and.reduce(values) if kind == "all" else np.logical_or.reduce(values)

    found = np.full(len(points), -1)
    for number, body in reversed(list(enumerate(table.bodies))):
        if body.sheet is None and body.formula is not None:
            found[truth(body.formula)] = number
    return found
