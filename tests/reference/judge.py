"""Counts of comparisons and failures, with messages that reproduce them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, ctx

from .forms import PAIRS
from .items import Item
from .numbers import ball, number
from .quadratics import Root, Table
from .solids import bodies
from .trace import Array, Crossings, Trace, body_at

SHOWN = 3


@dataclass
class Score:
    """`wrong` counts by sort of failure; `messages` has the first few of each; `queries` counts rays times queries."""

    rays: int = 0
    queries: int = 0
    rows: int = 0
    doubtful: int = 0
    errors: list[float] = field(default_factory=list)
    """|t - exact| of crossings as a share of |t|, and the bounds of that."""
    bounds: list[float] = field(default_factory=list)
    wrong: dict[str, int] = field(default_factory=dict)
    messages: dict[str, list[str]] = field(default_factory=dict)

    def fail(self, sort: str, message: str, count: int = 1) -> None:
        self.wrong[sort] = self.wrong.get(sort, 0) + count
        shown = self.messages.setdefault(sort, [])
        if len(shown) < SHOWN:
            shown.append(message)

    def add(self, other: Score) -> None:
        for name in ("rays", "queries", "rows", "doubtful", "errors", "bounds"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for sort, count in other.wrong.items():
            self.wrong[sort] = self.wrong.get(sort, 0) + count
            shown = self.messages.setdefault(sort, [])
            shown += other.messages[sort][: SHOWN - len(shown)]

    @property
    def slackness(self) -> float:
        """Return median bound over median error, or 0 if no ray crosses anything, as where Booleans are empty."""
        if not self.errors:
            return 0.0
        return float(np.median(self.bounds) / (np.median(self.errors) or np.inf))

    def check(self) -> None:
        text = "\n\n".join(f"{sort}: {m}" for sort in self.wrong for m in self.messages[sort])
        assert not self.wrong, f"{self.wrong} of {self.rays} rays\n\n{text}"


def scene_text(items: Sequence[Item]) -> str:
    return f"scene = co.Scene([{', '.join(map(repr, items))}])"


def vector_text(v: Any) -> str:
    return "(" + ", ".join(repr(float(x)).removesuffix(".0") for x in v) + ")"


# --- The library's answers against the exact ones: lists, first hits, spans, membership, bounds of errors


LOOSE = 2.0**-20
"""The largest bound of an error, as a share of |t| and of the ray's way to the body: an answer is a place."""
FAR = 2.0**30
"""Beyond so many times the ray's way, where it is nearly an asymptote, the bound has no limit."""
ULP = 2.0**-53
BENT = 1e-3
"""A normal is not compared if an error of the place may turn it by more than this."""
NORMALS = 100
"""The count of normals that are compared in each query."""


class Judge:
    """A scene of items; `library` is the package. Bounds of errors are small up to `far` times the ray's length."""

    def __init__(self, library: Any, items: Sequence[Item], far: float = FAR) -> None:
        self.items, self.far = list(items), far
        self.scene = library.Scene([item.shape(library) for item in items])
        self.table = Table(bodies(items))
        self.solid = np.array([body.sheet is None for body in self.table.bodies], bool)
        self.extent = max(2 * item.world_size + float(np.abs(item.world_center).max()) for item in items)
        self.score = Score()

    def rays(self, origins: Array, directions: Array, rays: Any = None, start: Array | None = None) -> Comparison:
        """Return rays with their exact answers. `rays` are those of the library where hits spawned them."""
        return Comparison(self, Trace(self.table, origins, directions, start), rays)

    def membership(self, points: Array) -> None:
        expected, found = body_at(self.table, points), self.scene.body_at(points)
        inside = self.scene.contains(points)
        for name, wrong in (("body_at", expected != found), ("contains", inside != (expected >= 0))):
            for i in np.flatnonzero(wrong):
                text = f"scene.{name}({vector_text(points[i])}): the body is exactly {expected[i]}"
                self.score.fail(name, f"{scene_text(self.items)}\n  {text}")

    @cached_property
    def coefficients(self) -> list[list[arb]]:
        """The coefficients of each surface, as intervals."""
        with ctx.workprec(300):
            return [[ball(number(k), 200) for k in form.k] for form in self.table.forms]


class Comparison:
    """Some rays of a scene: the exact answer, and that of `crossings` over the whole line, or ahead of spawned rays."""

    def __init__(self, judge: Judge, trace: Trace, rays: Any) -> None:
        self.judge, self.trace, self.score = judge, trace, judge.score
        self.origins, self.directions = trace.origins, trace.directions
        self.count = len(self.origins)
        self.spawned = rays is not None
        self.arguments = (rays,) if self.spawned else (self.origins, self.directions)
        self.exact: Crossings = trace.crossings.ahead() if self.spawned else trace.crossings
        self.score.rays += self.count
        self.score.rows += len(self.exact.ray)
        self.score.queries += 4 * self.count
        self.found = judge.scene.crossings(*self.arguments, **({} if self.spawned else {"t_min": -np.inf}))
        self._held: dict[int, tuple[float, float]] = {}  # of rows, t and a bound that it has satisfied

    def where(self, ray: int, query: str = "") -> str:
        """Return a scene, a ray and its exact answer, as a user would type it."""
        e = self.exact
        rows = slice(int(e.offsets[ray]), int(e.offsets[ray + 1]))
        columns = (e.t, e.body, e.face, e.entering)
        exact = [
            (t, "in" if enters else "out", f"body {b}", f"face {f}")
            for t, b, f, enters in zip(*(c[rows].tolist() for c in columns), strict=True)
        ]
        spawned = " (spawned, without the root of its start)" if self.spawned else ""
        ray_text = f"{vector_text(self.origins[ray])}, {vector_text(self.directions[ray])}{spawned}"
        return f"{scene_text(self.judge.items)}\n  ray {ray_text}\n  {query}\n  exact crossings: {exact}"

    def fail(self, sort: str, rays: Array, query: str | Callable[[int], str] = "") -> None:
        """Count rays as wrong and show the first few."""
        rays = np.unique(rays)
        if not len(rays):
            return
        name = f"spawned {sort}" if self.spawned else sort
        for ray in rays[:SHOWN].tolist():
            self.score.fail(name, self.where(ray, query(ray) if callable(query) else query), 0)
        self.score.wrong[name] = self.score.wrong.get(name, 0) + len(rays)

    def lists(self) -> Array:
        """Compare `crossings`: number, order, bodies, faces, senses and places. Return the rays that are right."""
        exact, found = self.exact, self.found
        rays = rows_of(found.offsets)
        good = np.diff(exact.offsets) == np.diff(found.offsets)
        self.fail("crossings: number", np.flatnonzero(~good), lambda i: f"found {rows_at(found, i)}")
        for name in ("body", "entering", "face"):
            mine, theirs = good[exact.ray], good[rays]
            if name == "face":
                for row in np.flatnonzero(mine)[exact.face[mine] != found.face[theirs]]:
                    self.trace.put_face_beside(exact, row)
            wrong = exact.ray[mine][getattr(exact, name)[mine] != getattr(found, name)[theirs]]
            self.fail(f"crossings: {name}", wrong, lambda i: f"found {rows_at(found, i)}")
            good[wrong] = False
        mine, theirs = good[exact.ray], good[rays]
        self.fail("crossings: order of t", falls(found.t, rays))
        rows, t, error = np.flatnonzero(mine), found.t[theirs], found.t_error[theirs]
        self.places("crossings", exact.ray[mine], rows, t, error)
        self._identities(exact.surface[mine], found.surface[theirs], exact.ray[mine])
        with np.errstate(all="ignore"), ctx.workprec(200):
            off = np.array([float(abs(arb(x) - r.ball())) for x, r in zip(t.tolist(), exact.roots[rows], strict=True)])
            some = np.isfinite(t) & (t != 0)
            self.score.errors += (off[some] / np.abs(t[some])).tolist()
            self.score.bounds += (error[some] / np.abs(t[some])).tolist()
        return good

    def _identities(self, surfaces: Array, found: Array, rays: Array) -> None:
        """Check that equal surfaces have one number, and different ones two."""
        first = np.array([twins[0] for twins in self.judge.table.twins] or [0])[surfaces]
        for here, there in ((first, found), (found, first)):
            known: dict[int, int] = {}
            for a, b, ray in zip(here.tolist(), there.tolist(), rays.tolist(), strict=True):
                if known.setdefault(a, b) != b:
                    self.fail(
                        "crossings: surface", np.array([ray]), f"surfaces {b} and {known[a]} are one, or {a} is two"
                    )
                    return

    def places(self, sort: str, rays: Array, rows: Array, t: Array, error: Array) -> None:
        """Check |t - exact| <= t_error, and that t_error is small. `rows` are those of the exact list."""
        finite = np.isfinite(t) & np.isfinite(error) & (error >= 0)
        self.fail(f"{sort}: t or t_error is not finite", rays[~finite])
        rays, rows, t, error = (x[finite] for x in (rays, rows, t, error))
        reach = np.abs(self.origins[rays]).max(axis=1) + self.judge.extent
        with np.errstate(all="ignore"):
            length = np.abs(self.directions[rays]).max(axis=1)
            loose = (error > LOOSE * (np.abs(t) + reach / length)) & (np.abs(t) < self.judge.far * reach)
        self.fail(f"{sort}: t_error is as large as a length", rays[loose], lambda i: f"t_error {error[rays == i]}")
        for ray, row, place, bound in zip(rays.tolist(), rows.tolist(), t.tolist(), error.tolist(), strict=True):
            if not self._within(row, place, bound):
                text = f"t = {place!r}, t_error = {bound!r}"
                self.fail(f"{sort}: t is further off than t_error", np.array([ray]), text)

    def _within(self, row: int, t: float, error: float) -> bool:
        known = self._held.get(row)
        if known is not None and known[0] == t and known[1] <= error:
            return True
        is_right = holds(self.exact.roots[row], t, error)
        if is_right:
            self._held[row] = t, error
        return is_right

    def first(self) -> Any:
        """Compare `first_hit` and `occluded` from the origin on, all fields; return the hits."""
        e = self.exact
        ahead = np.flatnonzero(e.sign > 0)
        rays, index = np.unique(e.ray[ahead], return_index=True)
        rows = ahead[index]
        hit = np.zeros(self.count, bool)
        hit[rays] = True
        hits, hidden = self.judge.scene.first_hit(*self.arguments), self.judge.scene.occluded(*self.arguments)
        self.score.doubtful += int(hits.doubtful.sum())
        self.fail("first_hit: hit or miss", np.flatnonzero(np.isfinite(hits.t) != hit), lambda i: f"t = {hits.t[i]}")
        self.fail("occluded", np.flatnonzero(hidden != hit), lambda i: f"occluded is {hidden[i]}")
        agree = np.isfinite(hits.t[rays])
        rays, rows = rays[agree], rows[agree]
        for name in ("body", "entering", "face"):
            found = getattr(hits, name)
            wrong = found[rays] != getattr(e, name)[rows]
            self.fail(f"first_hit: {name}", rays[wrong], lambda i, f=found: f"found {f[i]}")
            rays, rows = rays[~wrong], rows[~wrong]
        self.places("first_hit", rays, rows, hits.t[rays], hits.t_error[rays])
        self._fields(hits)
        some = slice(None, None, 1 + len(rays) // NORMALS)
        with ctx.workprec(300):
            for ray, row in zip(rays.tolist(), rows.tolist(), strict=True):
                self._point(ray, self.exact.roots[row], hits)
            for ray, row in zip(rays[some].tolist(), rows[some].tolist(), strict=True):
                self._normal(ray, self.exact.roots[row], hits)
        return hits

    def _fields(self, hits: Any) -> None:
        found = np.isfinite(hits.t)
        self.fail("first_hit: t_error of a miss", np.flatnonzero(~found & (hits.t_error != 0)))
        for name in ("point", "normal", "local_point", "uv", "point_error"):
            value = getattr(hits, name).reshape(self.count, -1)
            self.fail(f"first_hit: {name} is not finite", np.flatnonzero(found & ~np.isfinite(value).all(axis=1)))
            self.fail(f"first_hit: {name} of a miss", np.flatnonzero(~found & ~np.isnan(value).all(axis=1)))
        with np.errstate(all="ignore"):
            length = np.abs(self.directions).max(axis=1)
            size = np.abs(self.origins).max(axis=1) + np.abs(hits.t) * length
            # Planes are rounded to pairs of floats: their share counts for points that all but meet the origin
            wide = hits.point_error > 2 * length * hits.t_error + 2.0**-48 * size + 2.0**-96 * self.judge.extent
        self.fail("first_hit: point_error is large", np.flatnonzero(found & wide))

    def _at(self, ray: int, root: Root) -> list[arb]:
        t = root.ball(250)
        return [
            arb(o) + t * arb(d) for o, d in zip(self.origins[ray].tolist(), self.directions[ray].tolist(), strict=True)
        ]

    def _point(self, ray: int, root: Root, hits: Any) -> None:
        """Check |point - (o + t d)| <= point_error, at the exact t."""
        off = [arb(p) - x for p, x in zip(hits.point[ray].tolist(), self._at(ray, root), strict=True)]
        if norm(off) > arb(float(hits.point_error[ray])):
            self.fail(
                "first_hit: point", np.array([ray]), f"point {hits.point[ray]}, point_error {hits.point_error[ray]}"
            )

    def gradient(self, ray: int, root: Root) -> tuple[list[arb], arb]:
        """Return the gradient of its surface at a root, and the magnitude of all second derivatives."""
        k, x = self.judge.coefficients[root.surface], [*self._at(ray, root), arb(1)]
        found, curved = [arb(0)] * 4, arb(0)
        for c, (i, j) in zip(k, PAIRS, strict=True):
            found[i] += c * x[j]
            found[j] += c * x[i]
            curved += 2 * c * c * (2 if i == j else 1) if j < 3 else 0
        return found[:3], curved.sqrt()

    def _normal(self, ray: int, root: Root, hits: Any) -> None:
        """Check that it is as near as curvature and error of the place allow, and against the ray where that enters."""
        gradient, curved = self.gradient(ray, root)
        size = norm(gradient)
        if not size > 0:
            return
        along = sum((g * arb(d) for g, d in zip(gradient, self.directions[ray].tolist(), strict=True)), arb(0))
        sense = -1 if bool(along > 0) == bool(hits.entering[ray]) else 1
        reach = max(*np.abs(self.origins[ray]), *np.abs(hits.point[ray]))
        speed = math.hypot(*self.directions[ray])
        off = float(abs(arb(float(hits.t[ray])) - root.ball())) * speed + 8 * ULP * float(reach)
        bend = float(curved / size)
        if not bend * off <= BENT:
            return
        turned = norm([arb(n) - sense * g / size for n, g in zip(hits.normal[ray].tolist(), gradient, strict=True)])
        if turned > 2 * bend * off + 16 * ULP:
            self.fail("first_hit: normal", np.array([ray]), f"normal {hits.normal[ray]} is {float(turned)} off")

    def spans(self, good: Array) -> None:
        """Compare spans of the whole line: between the crossings of each solid, clipped at its ends."""
        if self.spawned:
            return
        spans = self.judge.scene.spans(*self.arguments, t_min=-np.inf)
        ray = rows_of(spans.offsets)
        wrong = np.zeros(self.count, bool)
        ends = (
            (True, spans.enter_clipped, spans.t_enter, spans.t_enter_error),
            (False, spans.exit_clipped, spans.t_exit, spans.t_exit_error),
        )
        for body in np.flatnonzero(self.judge.solid):
            mine, theirs = self.exact.body == body, spans.body == body
            expected = (self._count(self.exact.ray[mine]) + self.exact.inside[body] + 1) // 2
            wrong |= self._count(ray[theirs]) != expected
            for entering, clipped, _, _ in ends:
                entered = self.exact.ray[mine & (self.exact.entering == entering)]
                wrong |= self._count(ray[theirs & ~clipped]) != self._count(entered)
        for _, clipped, t, error in ends:
            wrong[ray[clipped & (~np.isinf(t) | (error != 0))]] = True
        wrong &= good
        self.fail("spans: number", np.flatnonzero(wrong))
        with np.errstate(invalid="ignore"):
            self.fail("spans: length", ray[~(spans.t_enter <= spans.t_exit)])
        self.fail("spans: order", falls(spans.t_enter, ray))
        for entering, clipped, t, error in ends:
            self._ends(spans.body, ray, good & ~wrong, entering, clipped, t, error)

    def _count(self, rays: Array) -> Array:
        return np.bincount(rays, minlength=self.count)

    def _ends(
        self, body: Array, ray: Array, good: Array, entering: bool, clipped: Array, t: Array, error: Array
    ) -> None:
        """Check that ends of spans are the exact crossings of their bodies, in order."""
        e = self.exact
        rows = np.flatnonzero(good[e.ray] & self.judge.solid[e.body] & (e.entering == entering))
        ends = np.flatnonzero(good[ray] & ~clipped)
        rows = rows[np.lexsort((rows, e.body[rows], e.ray[rows]))]
        ends = ends[np.lexsort((t[ends], body[ends], ray[ends]))]
        if len(rows) == len(ends):
            self.places(f"spans.t_{'enter' if entering else 'exit'}", ray[ends], rows, t[ends], error[ends])


def holds(root: Root, t: float, error: float) -> bool:
    """Return whether |t - root| <= error."""
    bits = 160
    while True:
        with ctx.workprec(bits + 1200):
            off = abs(arb(t) - root.ball(bits)) - arb(error)
            if off <= 0 or bits > 4000:
                return True
            if off > 0:
                return False
        bits *= 2


def norm(v: Sequence[arb]) -> arb:
    return sum((x * x for x in v), arb(0)).sqrt()


def rows_of(offsets: Array) -> Array:
    """Return the ray of each row."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def falls(t: Array, ray: Array) -> Array:
    """Return the rays whose rows do not rise."""
    return ray[1:][(t[1:] < t[:-1]) & (ray[1:] == ray[:-1])]


def rows_at(found: Any, ray: int) -> list[tuple[Any, ...]]:
    """Return (t, body, face, entering) of each crossing of a ray."""
    rows = slice(int(found.offsets[ray]), int(found.offsets[ray + 1]))
    return list(zip(*(getattr(found, name)[rows].tolist() for name in ("t", "body", "face", "entering")), strict=True))
