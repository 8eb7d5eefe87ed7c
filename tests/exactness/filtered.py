"""Whole arrays of rays on a shape, in pairs of floats with bounds: crossings where all signs and orders are certain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .local import Local, LocalForm
from .traced import Shape
from .wide import Array, Wide, exact, two_product, two_sum

X, Y, Z, ONE = range(4)


@dataclass
class Lines:
    """Rays in local coordinates: p + s d, where t = (shift + s) 2^exponent."""

    p: list[Wide]
    d: list[Wide]
    shift: Array
    exponent: Array


@dataclass
class Filtered:
    """`decided` (N,); crossings as rows in order: ray, t as high + low within slack, entering, face, form, body."""

    decided: Array
    ray: Array
    high: Array
    low: Array
    slack: Array
    entering: Array
    face: Array
    form: Array
    body: Array


def lines(local: Local, origins: Array, directions: Array) -> Lines:
    """Direction of length about one, origin at the foot of the perpendicular."""
    longest = np.frexp(np.abs(directions).max(axis=1))[1]
    unit = 2.0**-local.exponent
    d = [exact(np.ldexp(directions[:, i], -longest)) for i in range(3)]
    u = [_relative(origins[:, i], local.anchor[i], unit) for i in range(3)]
    along = sum(a.high * b.high for a, b in zip(u, d, strict=True))
    shift = -along / sum(b.high * b.high for b in d)
    p = []
    for a, b in zip(u, d, strict=True):
        high, low = two_product(exact(shift), b)
        p.append(a + Wide(high, low, 1e-290 * (high != 0)))
    return Lines(p, d, shift, local.exponent - longest)


def _relative(x: Array, anchor: float, unit: float) -> Wide:
    """(x - anchor) unit, unit a power of two: exact, unless digits leave the range."""
    whole, rest = two_sum(x, np.full_like(x, -anchor))
    high, low = whole * unit, rest * unit
    error = np.where((high / unit == whole) & (low / unit == rest), 0.0, 1e-290)
    return Wide(high, low, np.where(np.isfinite(high), error, np.inf))


def gradient(f: LocalForm, p: list[Wide], constant: bool) -> list[Wide | None]:
    """Half the gradient at p; of the second-order part alone where p is a direction."""
    found: list[Wide | None] = []
    for i in (X, Y, Z):
        terms = [_times(f[i, j], p[j]) for j in (X, Y, Z) if f[i, j] is not None]
        if constant and f[i, ONE] is not None:
            terms.append(f[i, ONE])
        found.append(_sum(terms))
    return found


def _times(k: Wide | None, x: Wide) -> Wide:
    assert k is not None
    if k.error == 0 and k.low == 0 and abs(np.frexp(k.high)[0]) == 0.5:
        return x.scaled(k.high)
    return k * x


def _sum(terms: Sequence[Wide | None]) -> Wide | None:
    total: Wide | None = None
    for term in terms:
        if term is not None:
            total = term if total is None else total + term
    return total


def _inner(a: Sequence[Wide | None], b: Sequence[Wide]) -> Wide | None:
    return _sum([None if x is None else x * y for x, y in zip(a, b, strict=True)])


def _filled(x: Wide | None, count: int) -> Wide:
    zeros = np.zeros(count)
    if x is None:
        return Wide(zeros, zeros, zeros)
    if np.ndim(x.high) == 0:
        return Wide(zeros + x.high, zeros + x.low, zeros + x.error)
    return x


def quadratic(f: LocalForm, on: Lines) -> tuple[Wide, Wide, Wide]:
    """(a, b, c) of a t² + 2 b t + c"""
    count = len(on.shift)
    if f.flat:
        n = [f[i, ONE] for i in (X, Y, Z)]
        rate = _inner(n, on.d)
        height = _sum([_inner(n, on.p), f[ONE, ONE]])
        return _filled(None, count), _filled(rate, count).scaled(0.5), _filled(height, count)
    h = gradient(f, on.d, False)
    g = gradient(f, on.p, True)
    a, b = _inner(h, on.d), _inner(g, on.d)
    half = [f[i, ONE] for i in (X, Y, Z)]
    # g already holds half the linear part once: c = p·(g + half) + k
    c = _sum([_inner(g, on.p), _inner(half, on.p), f[ONE, ONE]])
    return _filled(a, count), _filled(b, count), _filled(c, count)


@dataclass
class Roots:
    """Two columns each, inf where there is no root."""

    high: Array
    low: Array
    error: Array
    before: Array
    known: Array


def roots(f: LocalForm, on: Lines) -> Roots:
    a, b, c = quadratic(f, on)
    linear = a.zero
    none = linear & b.zero
    with np.errstate(all="ignore"):
        discriminant = b * b - a * c
        real = discriminant.positive | (linear & (b.positive | b.negative))
        known = (a.positive | a.negative | linear) & (real | discriminant.negative | (none & (c.positive | c.negative)))
        far, near = _two(a, b, c, discriminant, linear)
        shift = exact(on.shift)
        far, near = far + shift, near + shift
    left = near.high < far.high
    pairs = []
    for x, y in ((near.high, far.high), (near.low, far.low), (near.error, far.error)):
        pairs.append(np.stack([np.where(left, x, y), np.where(left, y, x)], axis=1))
    high, low, error = pairs
    # far of a linear function does not exist: near comes first
    high[linear] = np.stack([near.high, np.full_like(near.high, np.inf)], axis=1)[linear]
    low[linear] = np.stack([near.low, near.low * 0], axis=1)[linear]
    error[linear] = np.stack([near.error, near.error * 0], axis=1)[linear]
    high[~real], low[~real], error[~real] = np.inf, 0.0, 0.0
    before = np.where(linear, np.where(none, c.negative, b.positive), a.negative)
    known &= np.isfinite(high).all(axis=1) | ~real | (linear & np.isfinite(high[:, 0]))
    return Roots(high, low, error, before, known)


def _two(a: Wide, b: Wide, c: Wide, discriminant: Wide, linear: Array) -> tuple[Wide, Wide]:
    """q / a and c / q with q = -(b + sign(b) √D)"""
    safe = np.where(discriminant.positive, 1.0, np.nan)
    root = Wide(discriminant.high * safe, discriminant.low * safe, discriminant.error * safe).sqrt()
    sign = np.where(b.high < 0, -1.0, 1.0)
    q = -(b + root.scaled(sign))
    double = -(b + b)
    q = Wide(
        *(np.where(linear, x, y) for x, y in ((double.high, q.high), (double.low, q.low), (double.error, q.error)))
    )
    return q / a, c / q


def traced(shape: Shape, local: Local, origins: Array, directions: Array) -> Filtered:
    """All crossings of whole lines, of the rays that are decided."""
    on = lines(local, origins, directions)
    found = [roots(f, on) for f in local.forms]
    count, forms = len(origins), len(found)
    high, low, error = (np.concatenate([getattr(r, name) for r in found], axis=1) for name in ("high", "low", "error"))
    order = np.argsort(high, axis=1, kind="stable")
    high, low, error = (np.take_along_axis(x, order, axis=1) for x in (high, low, error))
    which = order // 2
    decided = np.logical_and.reduce([r.known for r in found])
    there = np.isfinite(high)
    with np.errstate(all="ignore"):
        gaps = (np.diff(high, axis=1) + np.diff(low, axis=1)) * (1 - 2.0**-40)
        apart = ~there[:, 1:] | (gaps > (error[:, 1:] + error[:, :-1]) * (1 + 2.0**-40))
    decided &= apart.all(axis=1)
    state = np.empty((count, 2 * forms + 1, forms), bool)
    state[:, 0] = np.stack([r.before for r in found], axis=1)
    state[:, 1:] = (which[..., None] == np.arange(forms)) & there[..., None]
    np.logical_xor.accumulate(state, axis=1, out=state)
    parts = []
    for number, body in enumerate(shape.bodies):
        if body.sheet is None:
            part = _solid(shape, number, state, there)
        else:
            part = _sheet(shape, number, state, there, which)
            if body.sheet.loop:
                inside, certain = in_loop(local.loops[number], on, directions)
                decided &= certain | ~part.any(axis=1)
                part &= inside[:, None]
        parts.append(part)
    crossed = np.stack(parts, axis=2) & decided[:, None, None]
    return _rows(shape, crossed, state, which, (high, low, error), on.exponent, decided)


def _solid(shape: Shape, number: int, state: Array, there: Array) -> Array:
    formula = shape.bodies[number].formula
    assert formula is not None
    truth = shape.truth(formula, lambda i: state[:, :, i])
    changed: Array = (truth[:, 1:] != truth[:, :-1]) & there
    return changed


def _sheet(shape: Shape, number: int, state: Array, there: Array, which: Array) -> Array:
    body = shape.bodies[number]
    assert body.sheet is not None
    met: Array = there & (which == body.own)
    if body.sheet.one_sided:
        met = met & state[:, 1:, body.own]
    if body.formula is not None:
        met = met & shape.closed(body.formula, lambda i: state[:, :-1, i], lambda i: state[:, 1:, i])
    return met


def in_loop(loop: list[list[Wide]], on: Lines, directions: Array) -> tuple[Array, Array]:
    """(even-odd inside, certain) by the rule of `traced.in_loop`."""
    dx, dy, dz = np.abs(directions).T
    longest = np.where((dz >= dx) & (dz >= dy), 2, np.where(dx >= dy, 0, 1))
    odd, certain = np.zeros(len(longest), bool), np.ones(len(longest), bool)
    for axis, (iu, iv, iw) in enumerate(((1, 2, 0), (2, 0, 1), (0, 1, 2))):
        rays = np.flatnonzero(longest == axis)
        if not len(rays):
            continue
        p, d = ([_taken(x, rays) for x in v] for v in (on.p, on.d))
        seen = []
        for vertex in loop:
            x = [_filled(c, len(rays)) - o for c, o in zip(vertex, p, strict=True)]
            seen.append((d[iw] * x[iu] - d[iu] * x[iw], d[iw] * x[iv] - d[iv] * x[iw]))
        inside, sure = np.zeros(len(rays), bool), np.ones(len(rays), bool)
        for (ua, va), (ub, vb) in zip([seen[-1], *seen[:-1]], seen, strict=True):
            sure &= va.negative | va.positive | va.zero
            spans = va.negative != vb.negative
            side = ua * vb - ub * va
            sure &= ~spans | side.negative | side.positive
            inside ^= spans & np.where(vb.negative, side.negative, side.positive)
        odd[rays], certain[rays] = inside, sure
    return odd, certain


def _taken(x: Wide, rays: Array) -> Wide:
    return Wide(x.high[rays], x.low[rays], x.error[rays])


def _rows(
    shape: Shape,
    crossed: Array,
    state: Array,
    which: Array,
    t: tuple[Array, Array, Array],
    exponent: Array,
    decided: Array,
) -> Filtered:
    ray, event, body = np.nonzero(crossed)
    form = which[ray, event]
    entering = np.empty(len(ray), bool)
    faces = np.full((len(shape.bodies), len(shape.forms)), -1)
    for number, one in enumerate(shape.bodies):
        mine = body == number
        if one.sheet is None:
            formula = one.formula
            assert formula is not None
            truth = shape.truth(formula, lambda i: state[:, :, i])
            entering[mine] = truth[ray[mine], event[mine] + 1]
            faces[number] = shape.faces_of(number)
        else:
            entering[mine] = state[ray[mine], event[mine] + 1, one.own]
            faces[number] = 0
    high, low, slack = (np.ldexp(x[ray, event], exponent[ray]) for x in t)
    slack = slack * (1 + 2.0**-40)
    # where the power of two takes digits away the bound does not hold: leave such rays to exact arithmetic
    size = np.abs(high)
    lost = ~np.isfinite(high) | ((size < 1e-250) & (t[0][ray, event] != 0))
    decided = decided.copy()
    decided[ray[lost]] = False
    keep = decided[ray]
    return Filtered(decided, *(x[keep] for x in (ray, high, low, slack, entering, faces[body, form], form, body)))
