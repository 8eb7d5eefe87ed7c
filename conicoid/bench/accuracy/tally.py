"""Errors counted: wrong answers per million, the spread of the errors of t in units in the last place."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from .bodies import Floats
from .reference import Exact

EDGES = np.arange(-5, 55)
"""Of the histogram, powers of two: an error of e ulps is in bin k where 2^EDGES[k] <= e < 2^EDGES[k + 1]; the first and
the last bin take what is beyond."""


@dataclass(frozen=True)
class Answer:
    """t (n,) of a system, inf for a miss, and its bounds on |t - exact|, where it gives any."""

    t: Floats
    bound: Floats | None = None


@dataclass(frozen=True)
class Spread:
    """Errors of t in ulps of float64 at the exact t, over all rays that both sides say hit.

    `bounds` is the histogram of the bounds, `bound_ratio` their median over the median error (None where that is
    0), `violations` how many errors exceed their bound.
    """

    median: float
    most: float
    largest: float
    histogram: list[int]
    bounds: list[int] | None = None
    bound_ratio: float | None = None
    violations: int | None = None


@dataclass
class Tally:
    """Wrong answers and errors of a system; rays without an agreed answer are left out of everything else."""

    rays: int = 0
    ties: int = 0
    hits: int = 0
    wrong_hits: int = 0
    wrong_misses: int = 0
    errors: list[Floats] = field(default_factory=list)
    bounds: list[Floats] = field(default_factory=list)
    violations: int = 0

    def add(self, exact: Exact, answer: Answer) -> None:
        agreed = ~exact.tie
        ours, theirs = np.isfinite(answer.t) & agreed, np.isfinite(exact.high) & agreed
        self.rays += int(agreed.sum())
        self.ties += int(exact.tie.sum())
        self.hits += int(theirs.sum())
        self.wrong_hits += int((ours & ~theirs).sum())
        self.wrong_misses += int((theirs & ~ours).sum())
        both = ours & theirs
        error, ulp = exact.errors(answer.t)[both], ulps(exact.high[both])
        self.errors.append(error / ulp)
        if answer.bound is not None:
            bound = answer.bound[both]
            self.bounds.append(bound / ulp)
            # the error is rounded twice by 2^-53: half an ulp below it is no proof of an excess
            self.violations += int((np.nextafter(error, 0) > bound).sum())

    def merge(self, other: Tally) -> None:
        """Take in what another has counted."""
        for name in ("rays", "ties", "hits", "wrong_hits", "wrong_misses", "errors", "bounds", "violations"):
            setattr(self, name, getattr(self, name) + getattr(other, name))

    def per_million(self, count: int) -> float:
        return 1e6 * count / max(self.rays, 1)

    def spread(self) -> Spread | None:
        """None where nothing was hit."""
        errors = np.concatenate([np.empty(0), *self.errors])
        if not len(errors):
            return None
        median, most = np.quantile(errors, (0.5, 0.999)).tolist()
        if not self.bounds:
            return Spread(median, most, float(errors.max()), histogram(errors))
        bounds = np.concatenate(self.bounds)
        ratio = float(np.median(bounds)) / median if median else None
        return Spread(median, most, float(errors.max()), histogram(errors), histogram(bounds), ratio, self.violations)


def histogram(errors: Floats) -> list[int]:
    """How many lie in each of the bins of `EDGES`."""
    with np.errstate(divide="ignore"):
        bins = np.clip(np.floor(np.log2(errors)), EDGES[0], EDGES[-1]) - EDGES[0]
    counts: list[int] = np.bincount(bins.astype(int), minlength=len(EDGES)).tolist()
    return counts


def ulps(t: Floats) -> Floats:
    """The distance from float64 to float64 at t."""
    spacing: npt.NDArray[np.float64] = np.spacing(np.abs(t))
    return spacing
