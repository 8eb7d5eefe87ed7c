"""Intervals that begin and end at crossings, beside them by one float or two, at 0 and at infinity, by every query.

An end at 0 is the origin itself; other ends are compared with the t of the answer.
"""

from typing import Any

import numpy as np

from .judge import Comparison, falls, rows_at, rows_of
from .trace import Array

Random = np.random.Generator

IN, OUT, EDGE = 1, -1, 0


def ends(r: Random, offsets: Array, t: Array) -> tuple[Array, Array]:
    """Return (t_min, t_max) of each ray, most of them at or beside its crossings."""
    count, found = np.diff(offsets), []
    for plain in ((-np.inf, 0.0, -1.0, 0.5, -3.5), (np.inf, 0.0, 2.0, 9.0, -0.5)):
        value = r.choice(plain, len(count))
        some = np.flatnonzero((count > 0) & (r.random(len(count)) < 0.7))
        place = t[offsets[:-1][some] + r.integers(0, 1 << 30, len(some)) % count[some]]
        for _ in range(2):
            beside = np.nextafter(place, r.choice([-np.inf, np.inf], len(place)))
            place = np.where(r.random(len(place)) < 0.35, beside, place)
        value[some] = place
        found.append(value)
    return np.minimum(*found), np.maximum(*found)


class Answers:
    """All queries over ]low, high[ of rays, as arguments of a query."""

    def __init__(self, scene: Any, rays: tuple[Any, ...], low: Array, high: Array) -> None:
        self.low, self.high = low, high
        limits = {"t_min": low, "t_max": high}
        self.first = scene.first_hit(*rays, **limits)
        self.hidden = scene.occluded(*rays, **limits)
        self.listed = scene.crossings(*rays, **limits)
        self.spans = scene.spans(*rays, **limits)

    def laws(self) -> dict[str, Array]:
        """Return laws between the queries, each with the rays that break it."""
        first, listed, ray = self.first, self.listed, rows_of(self.listed.offsets)
        hit, some = np.isfinite(first.t), np.diff(listed.offsets) > 0
        before = (listed.t <= self.low[ray]) & (self.low[ray] != 0)
        beyond = (listed.t >= self.high[ray]) & (self.high[ray] != 0)
        wrong = {
            "occluded is not first_hit.t < inf": np.flatnonzero(self.hidden != hit),
            "crossings and first_hit disagree on a hit": np.flatnonzero(some != hit),
            "a crossing is not within": ray[before | beyond],
            "order of t": falls(listed.t, ray),
            "order of spans": falls(self.spans.t_enter, rows_of(self.spans.offsets)),
        }
        both = np.flatnonzero(some & hit)
        rows = listed.offsets[:-1][both]
        for name in ("t", "t_error", "body", "face", "surface", "entering"):
            off = getattr(listed, name)[rows] != getattr(first, name)[both]
            wrong[f"{name} of the first crossing is not that of first_hit"] = both[off]
        return wrong


class Interval(Answers):
    """The answers of the rays of a comparison; `good` rays have the right list over the whole line."""

    def __init__(self, comparison: Comparison, good: Array, low: Array, high: Array) -> None:
        super().__init__(comparison.judge.scene, comparison.arguments, low, high)
        self.comparison, self.good = comparison, good
        comparison.score.queries += 4 * comparison.count

    def fail(self, sort: str, rays: Array) -> None:
        self.comparison.fail(f"interval, {sort}", rays, self._text)

    def _text(self, i: int) -> str:
        limits = f"t_min={float(self.low[i])!r}, t_max={float(self.high[i])!r}"
        rows = slice(int(self.spans.offsets[i]), int(self.spans.offsets[i + 1]))
        names = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped")
        stretches = list(zip(*(getattr(self.spans, name)[rows].tolist() for name in names), strict=True))
        first = f"first_hit {float(self.first.t[i])!r}, occluded {bool(self.hidden[i])}"
        return f"{limits}: {first}, crossings {rows_at(self.listed, i)}, spans {stretches}"

    def judge(self) -> None:
        for sort, rays in self.laws().items():
            self.fail(sort, rays)
        self._membership()
        self._spans()

    def status(self) -> Array:
        """Return the status of each row: IN, OUT, or EDGE where its exact place and that of the answer do not decide."""
        a = self.comparison
        exact, found = a.exact, a.found
        aligned = np.flatnonzero(self.good[exact.ray])
        t, error = np.zeros(len(exact.ray)), np.zeros(len(exact.ray))
        mine = self.good[rows_of(found.offsets)]
        t[aligned], error[aligned] = found.t[mine], found.t_error[mine]
        self.t = t
        slack = 4 * error + 8 * np.spacing(np.abs(t))
        low, high = self.low[exact.ray], self.high[exact.ray]
        slack = np.minimum(slack, 1e300)  # `places` complains where the bound is none
        above = np.where(t > low + slack, IN, np.where(t < low - slack, OUT, EDGE))
        below = np.where(t < high - slack, IN, np.where(t > high + slack, OUT, EDGE))
        alone = self._alone(t, slack, (above == EDGE) | (below == EDGE))
        above = np.where((above == EDGE) & alone, np.where(t > low, IN, OUT), above)
        below = np.where((below == EDGE) & alone, np.where(t < high, IN, OUT), below)
        above = np.where(low == 0, np.where(exact.sign > 0, IN, OUT), above)
        below = np.where(high == 0, np.where(exact.sign < 0, IN, OUT), below)
        return np.where((above == IN) & (below == IN), IN, np.where((above == OUT) | (below == OUT), OUT, EDGE))

    def _alone(self, t: Array, slack: Array, statuses: Array) -> Array:
        """Return whether no root of any other surface is near a row's."""
        found = np.zeros(len(t), bool)
        for k in np.flatnonzero(statuses).tolist():
            groups = self.comparison.trace.groups[self.comparison.exact.ray[k]]
            found[k] = sum(abs(root.place - t[k]) <= 2 * slack[k] for group in groups for root in group) == 1
        return found

    def _membership(self) -> None:
        """Check that the list has, in order, all that it must have and nothing else."""
        exact, status = self.comparison.exact, self.status()
        self.rows_status = status
        listed = rows_of(self.listed.offsets)
        open_ = np.zeros(self.comparison.count, bool)
        open_[exact.ray[status == EDGE]] = True
        plain = self.good & ~open_
        expected = np.flatnonzero((status == IN) & plain[exact.ray])
        found = np.flatnonzero(plain[listed])
        counts = [np.bincount(x, minlength=self.comparison.count) for x in (exact.ray[expected], listed[found])]
        same = counts[0] == counts[1]
        self.fail("number of crossings", np.flatnonzero(~same & plain))
        expected, found = expected[same[exact.ray[expected]]], found[same[listed[found]]]
        for name in ("body", "entering", "face"):
            wrong = getattr(exact, name)[expected] != getattr(self.listed, name)[found]
            self.fail(f"{name} of crossings", exact.ray[expected][wrong])
        self.comparison.places(
            "interval, crossings", exact.ray[expected], expected, self.listed.t[found], self.listed.t_error[found]
        )
        for ray in np.flatnonzero(open_ & self.good).tolist():
            if not self._fits(ray, status):
                self.fail("crossings at its ends", np.array([ray]))

    def _fits(self, ray: int, status: Array) -> bool:
        """Return whether the list is one of those that EDGE rows allow."""
        exact = self.comparison.exact
        rows = iter(range(int(exact.offsets[ray]), int(exact.offsets[ray + 1])))
        for _, body, face, entering in rows_at(self.listed, ray):
            for k in rows:
                if status[k] != OUT and (exact.body[k], exact.face[k], exact.entering[k]) == (body, face, entering):
                    break
                if status[k] == IN:
                    return False
            else:
                return False
        return all(status[k] != IN for k in rows)

    def _spans(self) -> None:
        """Check that ends within the interval are the crossings of its list, and others are its own ends, with a flag."""
        spans, listed, solid = self.spans, self.listed, self.comparison.judge.solid
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
            counts = [np.bincount(x, minlength=self.comparison.count) for x in (rows[mine], ray[ends])]
            self.fail("spans and crossings", np.flatnonzero(counts[0] != counts[1]))
            if len(mine) == len(ends):
                off = (listed.body[mine] != spans.body[ends]) | (rows[mine] != ray[ends])
                off |= np.abs(listed.t[mine] - t[ends]) > listed.t_error[mine] + error[ends]
                self.fail("ends of spans and crossings", ray[ends][off])
