"""Intervals that begin and end at crossings, beside them by one float or two, at 0 and at infinity: what every query must say of them.

An end at 0 is the origin itself, others are compared with the t that is told.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .columns import Array
from .judge import Asked, falls, rows_of
from .kinds import Random

IN, OUT, EDGE = 1, -1, 0


def ends(r: Random, asked: Asked) -> tuple[Array, Array]:
    """(t_min, t_max) of each ray, most of them at or beside told crossings."""
    told = asked.told
    count = np.diff(told.offsets)
    found = []
    for plain in ((-np.inf, 0.0, -1.0, 0.5, -3.5), (np.inf, 0.0, 2.0, 9.0, -0.5)):
        value = r.choice(plain, asked.count)
        row = told.offsets[:-1] + r.integers(0, 1 << 30, asked.count) % np.maximum(count, 1)
        some = np.flatnonzero((count > 0) & (r.random(asked.count) < 0.7))
        t = told.t[row[some]]
        for _ in range(2):
            up, down = np.nextafter(t, np.inf), np.nextafter(t, -np.inf)
            t = np.where(r.random(len(t)) < 0.35, np.where(r.random(len(t)) < 0.5, up, down), t)
        value[some] = t
        found.append(value)
    low, high = np.minimum(*found), np.maximum(*found)
    return (np.maximum(low, 0.0), np.maximum(high, 0.0)) if asked.spawned else (low, high)


class Interval:
    """All queries over ]low, high[ of the rays of `asked`; `good` rays have the right list over the whole line."""

    def __init__(self, asked: Asked, good: Array, low: Array, high: Array) -> None:
        self.asked, self.good, self.low, self.high = asked, good, low, high
        scene, limits = asked.judge.scene, {"t_min": low, "t_max": high}
        self.first = scene.first_hit(*asked.rays, **limits)
        self.hidden = scene.occluded(*asked.rays, **limits)
        self.listed = scene.crossings(*asked.rays, **limits)
        self.spans = scene.spans(*asked.rays, **limits)
        asked.score.asked += 4 * asked.count

    def fail(self, what: str, rays: Array) -> None:
        self.asked.fail(f"interval, {what}", rays, self._told)

    def _told(self, i: int) -> str:
        limits = f"t_min={float(self.low[i])!r}, t_max={float(self.high[i])!r}"
        spans = self.spans
        rows = range(int(spans.offsets[i]), int(spans.offsets[i + 1]))
        stretches = [
            tuple(
                getattr(spans, name)[k].item()
                for name in ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped")
            )
            for k in rows
        ]
        return f"{limits}: first_hit {float(self.first.t[i])!r}, occluded {bool(self.hidden[i])}, crossings {self._list(i)}, spans {stretches}"

    def _list(self, i: int) -> list[tuple[Any, ...]]:
        rows = slice(int(self.listed.offsets[i]), int(self.listed.offsets[i + 1]))
        columns = (self.listed.t, self.listed.body, self.listed.face, self.listed.entering)
        return [(float(t), int(b), int(f), bool(e)) for t, b, f, e in zip(*(c[rows] for c in columns), strict=True)]

    def judge(self) -> None:
        self._laws()
        self._membership()
        self._spans()

    def _laws(self) -> None:
        """Between the queries, on every ray."""
        first, listed = self.first, self.listed
        hit = np.isfinite(first.t)
        self.fail("occluded is not first_hit.t < inf", np.flatnonzero(self.hidden != hit))
        some = np.diff(listed.offsets) > 0
        self.fail("crossings and first_hit disagree on a hit", np.flatnonzero(some != hit))
        both = np.flatnonzero(some & hit)
        rows = listed.offsets[:-1][both]
        for name in ("t", "t_error", "body", "face", "surface", "entering"):
            self.fail(
                f"{name} of the first crossing is not that of first_hit",
                both[getattr(listed, name)[rows] != getattr(first, name)[both]],
            )
        ray = rows_of(listed.offsets)
        beyond = (listed.t <= self.low[ray]) & (self.low[ray] != 0) | (listed.t >= self.high[ray]) & (
            self.high[ray] != 0
        )
        self.fail("a crossing is not within", ray[beyond])
        self.fail("order of t", falls(listed.t, ray))

    def status(self) -> Array:
        """Of each row of the whole line's list: IN, OUT, or at an EDGE where its exact place and what is told leave it open."""
        a = self.asked
        exact, told = a.exact, a.told
        aligned = np.flatnonzero(self.good[exact.ray])
        t, error = np.zeros(len(exact.ray)), np.zeros(len(exact.ray))
        mine = self.good[rows_of(told.offsets)]
        t[aligned], error[aligned] = told.t[mine], told.t_error[mine]
        self.t = t
        slack = 4 * error + 8 * np.spacing(np.abs(t))
        low, high = self.low[exact.ray], self.high[exact.ray]
        sign = a.trace.sign_of(exact.slope, exact.surface, exact.ray)
        slack = np.minimum(slack, 1e300)  # where the bound is none, that is told elsewhere
        above = np.where(t > low + slack, IN, np.where(t < low - slack, OUT, EDGE))
        below = np.where(t < high - slack, IN, np.where(t > high + slack, OUT, EDGE))
        alone = self._alone(t, slack)
        above = np.where((above == EDGE) & alone, np.where(t > low, IN, OUT), above)
        below = np.where((below == EDGE) & alone, np.where(t < high, IN, OUT), below)
        above = np.where(low == 0, np.where(sign > 0, IN, OUT), above)
        below = np.where(high == 0, np.where(sign < 0, IN, OUT), below)
        return np.where((above == IN) & (below == IN), IN, np.where((above == OUT) | (below == OUT), OUT, EDGE))

    def _alone(self, t: Array, slack: Array) -> Array:
        """Is there no other root of any surface near a row's?"""
        lines, ray = self.asked.trace.lines, self.asked.exact.ray
        near, error = lines.near
        near, error = (x[:, :, ray] * lines.units[ray] for x in (near, error))
        with np.errstate(invalid="ignore"):
            close = np.abs(near - t) <= 2 * slack + error
        return (close & lines.crosses[:, :, ray]).sum(axis=(0, 1)) == 1

    def _membership(self) -> None:
        """What must be in the list is, in order, and nothing that must not."""
        exact, status = self.asked.exact, self.status()
        self.rows_status = status
        listed = rows_of(self.listed.offsets)
        open_ = np.zeros(self.asked.count, bool)
        open_[exact.ray[status == EDGE]] = True
        plain = self.good & ~open_
        expected = np.flatnonzero((status == IN) & plain[exact.ray])
        told = np.flatnonzero(plain[listed])
        counts = [np.bincount(x, minlength=self.asked.count) for x in (exact.ray[expected], listed[told])]
        same = counts[0] == counts[1]
        self.fail("number of crossings", np.flatnonzero(~same & plain))
        expected, told = expected[same[exact.ray[expected]]], told[same[listed[told]]]
        for name in ("body", "entering", "face"):
            wrong = getattr(exact, name)[expected] != getattr(self.listed, name)[told]
            self.fail(f"{name} of crossings", exact.ray[expected][wrong])
        self.asked.places(
            "interval, crossings", exact.ray[expected], expected, self.listed.t[told], self.listed.t_error[told]
        )
        for ray in np.flatnonzero(open_ & self.good).tolist():
            if not self._fits(ray, status):
                self.fail("crossings at its ends", np.array([ray]))

    def _fits(self, ray: int, status: Array) -> bool:
        """Is the list one of those that EDGE rows allow?"""
        exact = self.asked.exact
        rows = iter(range(int(exact.offsets[ray]), int(exact.offsets[ray + 1])))
        for _, body, face, entering in self._list(ray):
            for k in rows:
                if status[k] != OUT and (exact.body[k], exact.face[k], exact.entering[k]) == (body, face, entering):
                    break
                if status[k] == IN:
                    return False
            else:
                return False
        return all(status[k] != IN for k in rows)

    def _spans(self) -> None:
        """Ends within the interval are the crossings listed for it, others are its own ends and flagged."""
        spans, listed, solid = self.spans, self.listed, self.asked.judge.solid
        ray, rows = rows_of(spans.offsets), rows_of(listed.offsets)
        low, high = self.low[ray], self.high[ray]
        self.fail(
            "a clipped end of a span is not that of the interval",
            ray[(spans.enter_clipped & (spans.t_enter != low)) | (spans.exit_clipped & (spans.t_exit != high))],
        )
        with np.errstate(invalid="ignore"):
            wrong = ~(spans.t_enter <= spans.t_exit) & (low < high)
        self.fail("a span ends before it begins", ray[wrong])
        for name, entering in (("enter", True), ("exit", False)):
            t, error, clipped = (getattr(spans, part) for part in (f"t_{name}", f"t_{name}_error", f"{name}_clipped"))
            mine = np.flatnonzero(solid[listed.body] & (listed.entering == entering)) if len(rows) else np.zeros(0, int)
            ends = np.flatnonzero(~clipped)
            mine = mine[np.lexsort((listed.t[mine], listed.body[mine], rows[mine]))]
            ends = ends[np.lexsort((t[ends], spans.body[ends], ray[ends]))]
            counts = [np.bincount(x, minlength=self.asked.count) for x in (rows[mine], ray[ends])]
            self.fail("spans and crossings", np.flatnonzero(counts[0] != counts[1]))
            if len(mine) == len(ends):
                off = (listed.body[mine] != spans.body[ends]) | (rows[mine] != ray[ends])
                off |= np.abs(listed.t[mine] - t[ends]) > listed.t_error[mine] + error[ends]
                self.fail("ends of spans and crossings", ray[ends][off])
