"""The library's answers against the exact ones: decisions, times, bounds of their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..oracle.cases import Case
from .exact import ExactRay, as_pair
from .membership import body_at
from .oracle import Answers, Oracle
from .traced import crossings
from .wide import Array, Wide, exact

SHOWN = 4


@dataclass
class Score:
    """What was counted; `failures` are messages that reproduce."""

    rays: int = 0
    crossings: int = 0
    hard: int = 0
    wrong: dict[str, int] = field(default_factory=dict)
    errors: list[Array] = field(default_factory=list)
    bounds: list[Array] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def fail(self, what: str, count: int, message: str | Callable[[], str]) -> None:
        self.wrong[what] = self.wrong.get(what, 0) + count
        if sum(f.startswith(f"{what}:") for f in self.failures) < SHOWN:
            self.failures.append(f"{what}: {message if isinstance(message, str) else message()}")

    def add(self, other: Score) -> None:
        self.rays, self.crossings, self.hard = (
            self.rays + other.rays,
            self.crossings + other.crossings,
            self.hard + other.hard,
        )
        for what, count in other.wrong.items():
            self.wrong[what] = self.wrong.get(what, 0) + count
        self.errors += other.errors
        self.bounds += other.bounds
        for failure in other.failures:
            what = failure.split(":")[0]
            if sum(f.startswith(f"{what}:") for f in self.failures) < SHOWN:
                self.failures.append(failure)

    @property
    def slackness(self) -> float:
        """Median bound over median error, both relative to |t|."""
        return float(np.median(np.concatenate(self.bounds)) / np.median(np.concatenate(self.errors)))

    def check(self) -> None:
        assert not self.wrong, f"{self.wrong} of {self.rays} rays\n\n" + "\n\n".join(self.failures)


class Judge:
    """One scene of cases, its oracle, and rays."""

    def __init__(self, library: Any, oracle: Oracle, cases: list[Case], origins: Array, directions: Array) -> None:
        self.oracle, self.cases, self.origins, self.directions = oracle, cases, origins, directions
        self.scene = library.Scene([case.shape(library) for case in cases])
        self.score = Score(rays=len(origins))

    def run(self) -> Score:
        answers = self.oracle.answers(self.origins, self.directions)
        self.score.hard = int(answers.hard.sum())
        found = self.scene.crossings(self.origins, self.directions, t_min=-np.inf)
        self.score.crossings = len(found.t)
        good = self._decisions(answers, found)
        self._times(answers, found, good)
        self._first(answers)
        self._spans(found)
        self._membership()
        return self.score

    def _decisions(self, answers: Answers, found: Any) -> Array:
        """Rays with the right number of crossings, each of the right body, sense and face."""
        good: Array = np.diff(answers.offsets) == np.diff(found.offsets)
        self._report("count", answers, found, ~good)
        mine, theirs = good[answers.ray], good[np.repeat(np.arange(len(good)), np.diff(found.offsets))]
        for name in ("body", "entering", "face"):
            expected, told = getattr(answers, name)[mine], getattr(found, name)[theirs]
            off = (expected != told) & ((expected >= 0) if name == "face" else True)
            bad = np.zeros(len(good), bool)
            bad[answers.ray[mine][off]] = True
            self._report(name, answers, found, bad)
            good = good & ~bad if name != "face" else good
        return good

    def _times(self, answers: Answers, found: Any, good: Array) -> None:
        if not np.isfinite(found.t).all():
            self.score.fail("t is not finite", int((~np.isfinite(found.t)).sum()), repr(self.cases))
        mine, theirs = good[answers.ray], good[np.repeat(np.arange(len(good)), np.diff(found.offsets))]
        ray, t = answers.ray[mine], found.t[theirs]
        with np.errstate(all="ignore"):
            error = np.abs((t - answers.high[mine]) - answers.low[mine])
        slack, size = answers.slack[mine], np.abs(answers.high[mine])
        bound = found.t_error[theirs]
        some = size > 0
        self.score.errors.append(error[some] / size[some])
        self.score.bounds.append(bound[some] / size[some])
        row_of = np.arange(len(answers.high))[mine] - answers.offsets[ray]
        for i in np.flatnonzero(~(error * (1 + 2.0**-40) + slack <= bound)).tolist():
            least = float(error[i] * (1 - 2.0**-40) - slack[i])
            if least <= bound[i]:
                o, d = self.origins[ray[i]], self.directions[ray[i]]
                least, _ = self.oracle.error(o, d, int(row_of[i]), float(t[i]))
            if not least <= bound[i]:
                what = f"t = {t[i]!r} is {least:.4g} off, t_error {bound[i]:.4g}"
                self.score.fail("t_error", 1, lambda i=i, what=what: f"{what}\n{self._ray(ray[i])}")

    def _first(self, answers: Answers) -> None:
        hits = self.scene.first_hit(self.origins, self.directions)
        ahead = np.flatnonzero(answers.sign > 0)
        rays, first = np.unique(answers.ray[ahead], return_index=True)
        rows = ahead[first]
        hit = np.zeros(len(self.origins), bool)
        hit[rays] = True
        for name, told in (
            ("first_hit", np.isfinite(hits.t)),
            ("occluded", self.scene.occluded(self.origins, self.directions)),
        ):
            for i in np.flatnonzero(told != hit)[:SHOWN].tolist():
                self.score.fail(name, 0, f"{bool(told[i])}\n{self._ray(i)}")
            if (told != hit).any():
                self.score.wrong[name] += int((told != hit).sum())
        agree = np.isfinite(hits.t[rays])
        rays, rows = rays[agree], rows[agree]
        for name in ("body", "entering", "face"):
            expected, told = getattr(answers, name)[rows], getattr(hits, name)[rays]
            bad = (expected != told) & ((expected >= 0) if name == "face" else True)
            if bad.any():
                i = int(rays[bad][0])
                self.score.fail(
                    f"first_hit.{name}", int(bad.sum()), f"{told[bad][0]}, not {expected[bad][0]}\n{self._ray(i)}"
                )
        self._places(answers, hits, rays, rows)

    def _places(self, answers: Answers, hits: Any, rays: Array, rows: Array) -> None:
        """|t - exact| <= t_error and |point - (o + t d)| <= point_error of first hits."""
        t_error, point_error = hits.t_error, hits.point_error
        missed = ~np.isfinite(hits.t)
        for name in ("t", "t_error", "point", "point_error", "normal", "local_point", "uv"):
            if np.isnan(getattr(hits, name)[~missed if name != "t" else slice(None)]).any():
                self.score.fail("NaN", 1, f"{name}\n{self.cases!r}")
        if (t_error[missed] != 0).any() or not np.isnan(point_error[missed]).all():
            self.score.fail("miss", 1, f"t_error must be 0 and point_error NaN\n{self.cases!r}")
        o, d, point = self.origins[rays], self.directions[rays], hits.point[rays]
        t = Wide(answers.high[rows], answers.low[rows], answers.slack[rows])
        with np.errstate(all="ignore"):
            error = np.abs((hits.t[rays] - t.high) - t.low)
            off = [(exact(o[:, i]) - exact(point[:, i])) + t * exact(d[:, i]) for i in range(3)]
            scale = np.maximum.reduce([np.abs(x.high) for x in off])
            scale = np.where(scale > 0, scale, 1.0)
            distance = scale * np.sqrt(sum((x.high / scale) ** 2 for x in off))
            slack = sum(x.error for x in off)
        for name, value, loose, bound in (
            ("t_error", error, t.error, t_error[rays]),
            ("point_error", distance * (1 - 2.0**-40), slack, point_error[rays]),
        ):
            bad = np.flatnonzero(~(value - loose <= bound))
            for i in bad[:SHOWN].tolist():
                message = f"{value[i]:.6g} off, bound {bound[i]:.6g}\n{self._ray(int(rays[i]))}"
                self.score.fail(f"first_hit.{name}", 1, message)

    def _spans(self, found: Any) -> None:
        """Ends of spans are the crossings of solids, which may be told an ulp later where they stand in one list with others
        at the same place; clipped ends, at infinity, have error 0."""
        spans = self.scene.spans(self.origins, self.directions, t_min=-np.inf)
        ray = np.repeat(np.arange(len(self.origins)), np.diff(spans.offsets))
        crossing = np.repeat(np.arange(len(self.origins)), np.diff(found.offsets))
        for name, entering in (("enter", True), ("exit", False)):
            t, error, clipped = (getattr(spans, n) for n in (f"t_{name}", f"t_{name}_error", f"{name}_clipped"))
            rows = np.isin(found.body, self.solids) & (found.entering == entering)
            told = np.stack([ray, spans.body, t, error])[:, ~clipped]
            expected = np.stack([crossing, found.body, found.t, found.t_error])[:, rows]
            told, expected = (x[:, np.lexsort(x[::-1])] for x in (told, expected))
            same = told.shape == expected.shape and np.array_equal(told[:2], expected[:2])
            if not same or (np.abs(told[2] - expected[2]) > told[3] + expected[3]).any():
                self.score.fail(f"spans.t_{name}", 1, f"not those of crossings\n{self.cases!r}")
            if not ((error[clipped] == 0) & np.isinf(t[clipped])).all():
                self.score.fail(f"spans.t_{name}", 1, f"clipped ends must be infinite and have error 0\n{self.cases!r}")

    @property
    def solids(self) -> list[int]:
        return [number for number, body in enumerate(self.oracle.shape.bodies) if body.sheet is None]

    def _membership(self) -> None:
        points = np.concatenate([self.origins, self.origins + self.directions])
        points = points[np.isfinite(points).all(axis=1) & (np.abs(points) <= 1e100).all(axis=1)]
        points = np.where(np.abs(points) < 1e-100, 0.0, points)
        expected, told = body_at(self.oracle, points), self.scene.body_at(points)
        for i in np.flatnonzero(expected != told)[:SHOWN].tolist():
            self.score.fail(
                "body_at", 0, f"{told[i]} instead of {expected[i]} at {tuple(map(float, points[i]))}\n{self.cases!r}"
            )
        if (expected != told).any():
            self.score.wrong["body_at"] += int((expected != told).sum())

    def _report(self, what: str, answers: Answers, found: Any, bad: Array) -> None:
        if not bad.any():
            return
        for i in np.flatnonzero(bad)[:SHOWN].tolist():
            rows = slice(int(found.offsets[i]), int(found.offsets[i + 1]))
            told = [
                (float(t), bool(e), int(f), int(b))
                for t, e, f, b in zip(
                    found.t[rows], found.entering[rows], found.face[rows], found.body[rows], strict=True
                )
            ]
            self.score.fail(what, 0, f"found {told}\n{self._ray(i)}")
        self.score.wrong[what] += int(bad.sum())

    def _ray(self, i: int) -> str:
        o, d = tuple(map(float, self.origins[i])), tuple(map(float, self.directions[i]))
        expected = [
            (as_pair(c.root)[0], c.entering, c.face, c.body) for c in crossings(self.oracle.shape, ExactRay(o, d))
        ]
        return f"  expected {expected}\n  origin {o}\n  direction {d}\n  {self.cases!r}"
