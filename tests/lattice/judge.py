"""The library's answers beside the exact ones: lists, first hits, spans, membership, bounds; laws between queries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import arb, ctx

from .columns import Array
from .items import Item
from .lines import Table
from .score import SHOWN, Score, scene_text, vector_text
from .shapes import bodies
from .trace import Crossings, Trace, body_at, surfaces_by_face

LOOSE = 2.0**-20
"""A bound of an error may be so much of |t| and of the ray's way to what it meets, no more: what is told is a place."""
FAR = 2.0**30
"""Beyond so many times the ray's way, where it runs all but along an asymptote, the bound may be as large as it likes."""


class Judge:
    """A scene of items; `library` is the package."""

    def __init__(self, library: Any, items: Sequence[Item]) -> None:
        self.items = list(items)
        self.scene = library.Scene([item.shape(library) for item in items])
        self.table = Table(bodies(items))
        self.solid = np.array([body.sheet is None for body in self.table.bodies], bool)
        self.faces = surfaces_by_face(self.table)
        self.score = Score()

    def asked(self, origins: Array, directions: Array, rays: Any = None, start: Array | None = None) -> Asked:
        """Rays with their exact answers. `rays`: as the library is to be asked, where they are spawned."""
        return Asked(self, Trace(self.table, origins, directions, start), rays)

    def membership(self, points: Array) -> None:
        expected, told = body_at(self.table, points), self.scene.body_at(points)
        inside = self.scene.contains(points)
        for i in np.flatnonzero(expected != told):
            self.score.fail(
                "body_at",
                f"{scene_text(self.items)}\n  scene.body_at({vector_text(points[i])}) is {told[i]}, exactly {expected[i]}",
            )
        for i in np.flatnonzero(inside != (expected >= 0)):
            self.score.fail(
                "contains", f"{scene_text(self.items)}\n  scene.contains({vector_text(points[i])}) is {inside[i]}"
            )


class Asked:
    """Some rays of a scene: what is exact, and what is told by `crossings` of the whole line (or of what is ahead)."""

    def __init__(self, judge: Judge, trace: Trace, rays: Any) -> None:
        self.judge, self.trace, self.score = judge, trace, judge.score
        self.origins, self.directions = trace.lines.origins, trace.lines.directions
        self.spawned = rays is not None
        self.rays = (rays,) if self.spawned else (self.origins, self.directions)
        self.exact = self._ahead(trace.crossings) if self.spawned else trace.crossings
        self.score.rays += trace.lines.count
        self.score.rows += len(self.exact.ray)
        self.score.asked += 4 * trace.lines.count
        self.told = judge.scene.crossings(*self.rays, **({} if self.spawned else {"t_min": -np.inf}))
        self.near, self.near_error = trace.near(self.exact.slope, self.exact.surface, self.exact.ray)

    @property
    def count(self) -> int:
        return len(self.origins)

    def _ahead(self, c: Crossings) -> Crossings:
        """Those with t > 0."""
        keep = self.trace.sign_of(c.slope, c.surface, c.ray) > 0
        counts = np.bincount(c.ray[keep], minlength=self.count)
        columns = [x[keep] for x in (c.ray, c.group, c.body, c.entering, c.face, c.slope, c.surface)]
        return Crossings(np.concatenate([[0], np.cumsum(counts)]), *columns, c.inside)

    def where(self, ray: int, query: str = "") -> str:
        """A scene, a ray and what is exact of it, as a user would type it."""
        rows = range(int(self.exact.offsets[ray]), int(self.exact.offsets[ray + 1]))
        exact = [
            (
                float(f"{self.near[k]:.17g}"),
                "in" if self.exact.entering[k] else "out",
                f"body {self.exact.body[k]}",
                f"face {self.exact.face[k]}",
            )
            for k in rows
        ]
        spawned = " (spawned, without the root of its start)" if self.spawned else ""
        return (
            f"{scene_text(self.judge.items)}\n  ray {vector_text(self.origins[ray])}, {vector_text(self.directions[ray])}{spawned}"
            f"\n  {query}\n  exact crossings: {exact}"
        )

    def fail(self, what: str, rays: Array, query: str | Callable[[int], str] = "") -> None:
        """Count rays as wrong, show the first few."""
        rays = np.unique(rays)
        if not len(rays):
            return
        name = f"spawned {what}" if self.spawned else what
        for ray in rays[:SHOWN].tolist():
            self.score.fail(name, self.where(ray, query(ray) if callable(query) else query or what), 0)
        self.score.wrong[name] = self.score.wrong.get(name, 0) + len(rays)

    def lists(self) -> Array:
        """`crossings`: how many, in which order, of which bodies, faces and senses, where. Returns the rays that are right."""
        exact, told = self.exact, self.told
        good = np.diff(exact.offsets) == np.diff(told.offsets)
        self.fail("crossings: number", np.flatnonzero(~good), "scene.crossings(...)")
        mine, theirs = good[exact.ray], good[rows_of(told.offsets)]
        for name in ("body", "entering", "face"):
            wrong = getattr(exact, name)[mine] != getattr(told, name)[theirs]
            rays = exact.ray[mine][wrong]
            self.fail(f"crossings: {name}", rays, f"told {getattr(told, name)[theirs][wrong][:1]}")
            good[rays] = False
            mine, theirs = good[exact.ray], good[rows_of(told.offsets)]
        self.fail("crossings: order of t", falls(told.t, rows_of(told.offsets)), "t must rise")
        self.places("crossings", exact.ray[mine], np.flatnonzero(mine), told.t[theirs], told.t_error[theirs])
        self._identities(exact.surface[mine], told.surface[theirs], exact.ray[mine])
        return good

    def _identities(self, surfaces: Array, told: Array, rays: Array) -> None:
        """What is one surface on paper has one number."""
        first = np.array([twins[0] for twins in self.judge.table.twins] or [0])[surfaces]
        for here, there in ((first, told), (told, first)):
            number: dict[int, int] = {}
            for a, b, ray in zip(here.tolist(), there.tolist(), rays.tolist(), strict=True):
                if number.setdefault(a, b) != b:
                    self.fail(
                        "crossings: surface", np.array([ray]), f"surfaces {b} and {number[a]} are one, or {a} is two"
                    )
                    return

    def places(self, what: str, rays: Array, rows: Array, t: Array, error: Array) -> None:
        """|t - exact| <= t_error, and that is small. `rows`: of the exact list."""
        finite = np.isfinite(t) & np.isfinite(error) & (error >= 0)
        self.fail(f"{what}: t or t_error is not finite", rays[~finite])
        rays, rows, t, error = (x[finite] for x in (rays, rows, t, error))
        reach = np.abs(self.origins[rays]).max(axis=1) + 16
        size = np.abs(t) + reach / np.abs(self.directions[rays]).max(axis=1)
        loose = (error > LOOSE * size) & (np.abs(t) < FAR * reach)
        self.fail(
            f"{what}: t_error is as large as a length", rays[loose], f"t {t[loose][:1]}, t_error {error[loose][:1]}"
        )
        with np.errstate(all="ignore"):
            clear = np.abs(t - self.near[rows]) + self.near_error[rows] <= error
        for i in np.flatnonzero(~clear).tolist():
            if not self._within(int(rows[i]), float(t[i]), float(error[i])):
                self.fail(
                    f"{what}: t is further off than t_error", rays[i : i + 1], f"t = {t[i]!r}, t_error = {error[i]!r}"
                )

    def _within(self, row: int, t: float, error: float) -> bool:
        e = self.exact
        bits = 250
        while True:
            root = self.trace.ball(int(e.slope[row]), int(e.surface[row]), int(e.ray[row]), bits)
            with ctx.workprec(bits + 1200):
                off = abs(arb(t) - root) - arb(error)
                if off <= 0 or bits > 4000:
                    return True
                if off > 0:
                    return False
            bits *= 2

    def first(self, good: Array) -> Any:
        """`first_hit` and `occluded` from the origin on, all fields; returns the hits."""
        e = self.exact
        ahead = np.flatnonzero(self.trace.sign_of(e.slope, e.surface, e.ray) > 0)
        rays, index = np.unique(e.ray[ahead], return_index=True)
        rows = ahead[index]
        hit = np.zeros(self.count, bool)
        hit[rays] = True
        hits, hidden = self.judge.scene.first_hit(*self.rays), self.judge.scene.occluded(*self.rays)
        self.score.doubtful += int(hits.doubtful.sum())
        self.fail("first_hit: hit or miss", np.flatnonzero(np.isfinite(hits.t) != hit), "scene.first_hit(...).t")
        self.fail("occluded", np.flatnonzero(hidden != hit), "scene.occluded(...)")
        agree = np.isfinite(hits.t[rays])
        rays, rows = rays[agree], rows[agree]
        for name in ("body", "entering", "face"):
            wrong = getattr(hits, name)[rays] != getattr(e, name)[rows]
            self.fail(f"first_hit: {name}", rays[wrong], f"told {getattr(hits, name)[rays][wrong][:1]}")
            rays, rows = rays[~wrong], rows[~wrong]
        self.places("first_hit", rays, rows, hits.t[rays], hits.t_error[rays])
        lonely = np.ones(self.count, bool)
        lonely[e.ray[ahead][self._beside(ahead)]] = False
        self._fields(hits, hit, lonely)
        return hits

    def _beside(self, rows: Array) -> Array:
        """Which crossings have the other of their surface so near that the ray all but touches it, or meets an apex."""
        slope, surface, ray = (x[rows] for x in (self.exact.slope, self.exact.surface, self.exact.ray))
        size = np.abs(self.near[rows]) + (np.abs(self.origins[ray]).max(axis=1) + 1) / np.abs(self.directions[ray]).max(
            axis=1
        )
        with np.errstate(invalid="ignore"):
            apart = np.abs(self.trace.near(1 - slope, surface, ray)[0] - self.near[rows])
        return np.asarray(apart <= 2.0**-40 * size)

    def _fields(self, hits: Any, hit: Array, lonely: Array) -> None:
        found = np.isfinite(hits.t)
        for name in ("point", "normal", "local_point", "uv", "point_error"):
            value = getattr(hits, name).reshape(self.count, -1)
            self.fail(f"first_hit: {name} is not finite", np.flatnonzero(found & ~np.isfinite(value).all(axis=1)))
            self.fail(f"first_hit: {name} of a miss", np.flatnonzero(~found & ~np.isnan(value).all(axis=1)))
        with np.errstate(all="ignore"):
            length = np.abs(self.directions).max(axis=1)
            far = np.abs(hits.point - (self.origins + hits.t[:, None] * self.directions)).max(axis=1)
            size = np.abs(self.origins).max(axis=1) + np.abs(hits.t) * length
            wide = hits.point_error > 2 * length * hits.t_error + 2.0**-48 * size
            off = far > 2 * hits.point_error + 2.0**-48 * size
        self.fail("first_hit: point", np.flatnonzero(found & off))
        self.fail("first_hit: point_error is large", np.flatnonzero(found & wide))
        turned = (hits.normal * self.directions).sum(axis=1)
        size = 2.0**-40 * np.linalg.norm(self.directions, axis=1)
        wrong = found & lonely & np.where(hits.entering, turned > size, turned < -size)
        self.fail("first_hit: normal", np.flatnonzero(wrong))

    def spans(self, good: Array) -> None:
        """Those of the whole line: between the crossings of each solid, clipped at its ends."""
        if self.spawned:
            return
        spans = self.judge.scene.spans(*self.rays, t_min=-np.inf)
        ray = rows_of(spans.offsets)
        wrong = np.zeros(self.count, bool)
        for number in np.flatnonzero(self.judge.solid):
            mine = (self.exact.body == number) & good[self.exact.ray]
            told = (spans.body == number) & good[ray]
            crossings = np.bincount(self.exact.ray[mine], minlength=self.count)
            inside = self.exact.inside[number] & good
            expected = (crossings + inside + 1) // 2
            wrong |= (np.bincount(ray[told], minlength=self.count) != expected) & good
            for clipped, t, starts in (
                (spans.enter_clipped, spans.t_enter, True),
                (spans.exit_clipped, spans.t_exit, False),
            ):
                ends = told & ~clipped
                counts = np.bincount(ray[ends], minlength=self.count)
                entered = mine & (self.exact.entering == starts)
                wrong |= (counts != np.bincount(self.exact.ray[entered], minlength=self.count)) & good
                wrong[ray[told & clipped & ~np.isinf(t)]] = True
        self.fail("spans: number", np.flatnonzero(wrong), "scene.spans(..., t_min=-inf)")
        with np.errstate(invalid="ignore"):
            self.fail("spans: length", ray[~(spans.t_enter <= spans.t_exit)], "t_enter <= t_exit")
        self._ends(spans, ray, good & ~wrong)
        self.fail("spans: order", falls(spans.t_enter, ray), "sorted by t_enter")

    def _ends(self, spans: Any, ray: Array, good: Array) -> None:
        """Ends of spans are the exact crossings of their bodies, in order."""
        for name, entering in (("enter", True), ("exit", False)):
            t, error, clipped = (getattr(spans, part) for part in (f"t_{name}", f"t_{name}_error", f"{name}_clipped"))
            rows = np.flatnonzero(
                good[self.exact.ray] & self.judge.solid[self.exact.body] & (self.exact.entering == entering)
            )
            ends = np.flatnonzero(good[ray] & ~clipped)
            rows = rows[np.lexsort((rows, self.exact.body[rows], self.exact.ray[rows]))]
            ends = ends[np.lexsort((t[ends], spans.body[ends], ray[ends]))]
            if len(rows) == len(ends):
                self.places(f"spans.t_{name}", ray[ends], rows, t[ends], error[ends])


def rows_of(offsets: Array) -> Array:
    """The ray of each row."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def falls(t: Array, ray: Array) -> Array:
    """The rays whose rows do not rise."""
    return ray[1:][(t[1:] < t[:-1]) & (ray[1:] == ray[:-1])]
