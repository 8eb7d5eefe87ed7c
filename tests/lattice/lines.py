"""Rays on forms: quadratics A t² + B t + C with whole coefficients in the field, and their simple roots.

Origins and directions are floats, so with a common power of two per ray they are whole numbers: origin O / W, direction D / V.
Of all forms a ray has the same unit of t, V / W, so that order and equality of roots are those of quadratics in O and D alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, ctx, fmpq, fmpz

from .columns import Array, Column, combined, stacked
from .motions import PAIRS
from .shapes import Body, Form, forms_of, proportional

CURVED = PAIRS[:6]


class Table:
    """The distinct surfaces of some bodies; `places[id of form]` is (surface, 1 or -1: inside alike or opposite).

    Curved surfaces with opposite insides stand apart, as a ray within one is outside of either; `twins` knows them.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self.bodies = list(bodies)
        self.forms: list[Form] = []
        self.places: dict[int, tuple[int, int]] = {}
        for body in bodies:
            own = [] if body.sheet is None else [body.sheet.surface]
            clip = body.formula if body.sheet is None else body.sheet.clip
            for form in (*own, *forms_of(clip)):
                self.places[id(form)] = self._place(form)
        rows = [_whole(form) for form in self.forms]
        self.k = stacked(rows)
        self.flat = np.array([form.flat for form in self.forms])
        self.side = np.array([form.side if form.flat else 0 for form in self.forms])

    def _place(self, form: Form) -> tuple[int, int]:
        for number, known in enumerate(self.forms):
            sense = proportional(form, known)
            if sense > 0 or (sense and form.flat):
                return number, sense
        self.forms.append(form)
        return len(self.forms) - 1, 1

    @cached_property
    def twins(self) -> list[list[int]]:
        """For each surface those that are the same set of points, itself among them."""
        return [[j for j, g in enumerate(self.forms) if i == j or proportional(f, g)] for i, f in enumerate(self.forms)]


def _whole(form: Form) -> list[dict[int, int]]:
    """The ten coefficients times a positive number, whole and without a common factor."""
    common, divisor = fmpz(1), fmpz(0)
    for k in form.k:
        for c in k.k.values():
            common = common.lcm(c.q)
    for k in form.k:
        for c in k.k.values():
            divisor = divisor.gcd(c.p * (common // c.q))
    divisor = divisor or fmpz(1)
    return [{s: int(c.p * (common // c.q) // divisor) for s, c in k.k.items()} for k in form.k]


def whole_rows(rows: Array) -> tuple[Array, Array]:
    """(integers n (rays, 3), w (rays,)) with rows = n / w and w powers of two; int64 where they are small."""
    for w in (1, 2, 4, 8):
        if (rows * w == np.round(rows * w)).all() and (np.abs(rows) < 1 << 20).all():
            return (rows * w).astype(np.int64), np.full(len(rows), w, np.int64)
    numbers, powers = np.empty(rows.shape, object), np.empty(len(rows), object)
    for i, r in enumerate(rows.tolist()):
        parts = [x.as_integer_ratio() for x in r]
        powers[i] = max(q for _, q in parts)
        numbers[i] = [p * (powers[i] // q) for p, q in parts]
    return numbers, powers


def _most(x: Array) -> int:
    return int(abs(x).max()) if x.size else 0


@dataclass
class Lines:
    """Rays on a table: A, B, C of every surface and ray, shape (surfaces, rays)."""

    table: Table
    origins: Array
    directions: Array

    def __post_init__(self) -> None:
        self.o, self.w = whole_rows(self.origins)
        self.d, self.v = whole_rows(self.directions)
        if self.o.dtype == object or self.d.dtype == object:
            self.o, self.d, self.w = self.o.astype(object), self.d.astype(object), self.w.astype(object)
        o, d, w = self.o.T, self.d.T, self.w
        k = self.table.k
        aa = np.stack([d[i] * d[j] for i, j in CURVED])
        bb = np.stack([o[i] * d[j] + o[j] * d[i] for i, j in CURVED] + [w * d[i] for i in range(3)])
        cc = np.stack([o[i] * o[j] for i, j in CURVED] + [w * o[i] for i in range(3)] + [w * w])
        self.a = combined({s: x[:, :6] for s, x in k.items()}, aa, _most(aa)).tight()
        self.b = combined({s: x[:, :9] for s, x in k.items()}, bb, _most(bb)).tight()
        self.c = combined(k, cc, _most(cc)).tight()

    @property
    def count(self) -> int:
        return len(self.origins)

    @cached_property
    def discriminant(self) -> Column:
        return (self.b * self.b - (self.a * self.c).times(4)).tight()

    @cached_property
    def signs(self) -> tuple[Array, Array, Array]:
        return self.a.sign, self.b.sign, self.c.sign

    @cached_property
    def negative_at_start(self) -> Array:
        """Is each form negative towards t = -inf?  A ray within a plane: as if it stood further along its normal,
        the normal taken so that its first component is positive. A ray in a curved surface is outside."""
        a, b, c = self.signs
        within = (c == 0) & (self.table.side > 0)[:, None]
        return np.where(a != 0, a < 0, np.where(b != 0, b > 0, (c < 0) | within))

    @cached_property
    def crosses(self) -> Array:
        """(2, surfaces, rays): is there a simple root where the form falls (0), rises (1)?"""
        a, b, _ = self.signs
        two = (a != 0) & (self.discriminant.sign > 0)
        return np.stack([two | ((a == 0) & (b < 0)), two | ((a == 0) & (b > 0))])

    @cached_property
    def near(self) -> tuple[Array, Array]:
        """((2, surfaces, rays) roots in floats, bounds of their errors: inf where nothing is known), in units V / W."""
        with np.errstate(all="ignore"):
            return self._near()

    def _near(self) -> tuple[Array, Array]:
        if max(x.top for x in (self.a, self.b, self.c, self.discriminant)).bit_length() > 1000:
            shape = (2, *self.a.shape)
            return np.where(self.crosses, 0.0, np.inf), np.full(shape, np.inf)
        (a, ea, _), (b, eb, _), (c, ec, _), (d, ed, _) = (
            x.floats() for x in (self.a, self.b, self.c, self.discriminant)
        )
        exact_a = self.signs[0] == 0
        s = np.sqrt(np.maximum(d, 0.0))
        es = np.where(ed < d * 2.0**-10, ed / np.maximum(s, 1e-300), np.inf) + s * 2.0**-52
        q = -(b + np.copysign(s, b)) / 2
        eq = eb + es + np.abs(q) * 2.0**-51
        far, near = q / a, c / q
        off_far = np.abs(far) * (_part(eq, q) + _part(ea, a) + 2.0**-51)
        off_near = np.abs(near) * (_part(eq, q) + 2.0**-51) + ec / np.abs(q) * 1.01
        # slope sigma: t = (-B + sigma sqrt D) / 2 A; q / a has sigma = -sign B, and where B = 0, q / a = -s / 2a: sigma = -1
        rising_is_far = np.copysign(1.0, b) < 0
        line, off_line = -c / b, np.abs(c / b) * (_part(eb, b) + 2.0**-51) + ec / np.abs(b) * 1.01
        found, off = [], []
        for rising in (0, 1):
            is_far = rising_is_far == bool(rising)
            found.append(np.where(exact_a, line, np.where(is_far, far, near)))
            off.append(np.where(exact_a, off_line, np.where(is_far, off_far, off_near)))
        t, e = np.stack(found), np.stack(off)
        good = np.isfinite(t) & (e < np.inf)
        t, e = np.where(good, t, 0.0), np.where(good, e * 1.001, np.inf)
        return np.where(self.crosses, t, np.inf), np.where(self.crosses, e, 0.0)

    def ball(self, slope: int, surface: int, ray: int, bits: int) -> arb:
        """The root as an interval, in units V / W."""
        where = (surface, ray)
        with ctx.workprec(bits):
            a, b, c = (_ball(x.at(where)) for x in (self.a, self.b, self.c))
            if not self.signs[0][where]:
                return -c / b
            s = _ball(self.discriminant.at(where)).sqrt()
            if self.signs[1][where] >= 0:
                q = -(b + s) / 2
                return c / q if slope else q / a
            q = -(b - s) / 2
            return q / a if slope else c / q

    def unit(self, ray: int) -> fmpq:
        return fmpq(int(self.v[ray]), int(self.w[ray]))

    @cached_property
    def units(self) -> Array:
        """V / W as floats: powers of two, so exact unless it overflows."""
        return np.array(
            [math.ldexp(1.0, int(v).bit_length() - int(w).bit_length()) for v, w in zip(self.v, self.w, strict=True)]
        )


def _part(error: Any, value: Any) -> Any:
    """The relative error; inf where it is large."""
    ratio = error / np.abs(value)
    return np.where(ratio < 2.0**-10, ratio * 1.01, np.inf)


def _ball(k: dict[int, int]) -> arb:
    return sum((arb(c) * arb(s).sqrt() for s, c in k.items()), arb(0))
