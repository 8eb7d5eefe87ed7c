"""Every crossing of a ray with a formula, and which of them small perturbations could change.

The tangency band, exactly. Float64 answers can be right only for a scene a little beside the one
that was asked for, so a reference must say how far beside. Here every surface of a solid may be
displaced along its normal, each by its own amount, by up to

    eta(t) = BAND · (|t| |d| + size) [+ BAKED · |x(t)| for a solid that was moved]

at the point x(t) = o + t d: |t| |d| is the distance travelled, `size` the largest extent of the
solid. BAND = 2^-49, sixteen half units in the last place; BAKED = 2^-52 is what one rounding of an anchor
may move it by. To second order a surface f = 0 displaced by eta passes through x where

    |f(x)| <= kappa = eta |grad f| + eta² |hessian f| / 2.

Each inequality thus is certain or, where |f| <= kappa, undecided, and the formula is evaluated in
three-valued logic along the ray. The undecided stretches are the *runs*: a run with different known
values on its two sides holds a crossing; **a ray is in the tangency band if it has a run with equal
values on both sides or with more than one exact crossing in it**. Every ray, in the band or not,
must have its crossings inside runs and the right parity in each; outside the band, their number,
sense and face are exact.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from .formula import Formula, Surface, Truth
from .precision import ZERO, dot
from .restricted import Crossing, Line, Restricted, line


@dataclass
class Run:
    """An undecided stretch: truth before and after it, and the exact crossings in it."""

    low: Any
    high: Any
    before: Truth
    after: Truth
    crossings: list[Crossing] = field(default_factory=list)
    surfaces: set[Surface] = field(default_factory=set)
    """The surfaces that are undecided in it."""

    @property
    def certain(self) -> bool:
        return None not in (self.before, self.after) and self.before is not self.after and len(self.crossings) == 1


@dataclass(frozen=True, eq=False)
class Traced:
    """`crossings`: the exact ones in ]-reach, reach[. `runs`: the undecided stretches there."""

    crossings: list[Crossing]
    runs: list[Run]
    first: Truth
    """Truth of the formula at -reach."""

    @property
    def in_band(self) -> bool:
        return any(not run.certain for run in self.runs)


def trace(formula: Formula, on: Line, size: Any, reach: Any) -> Traced:
    """Crossings of a solid for |t| < reach."""
    frames: dict[int, Any] = {}
    restricted = {s: Restricted(s, on, size, frames) for s in dict.fromkeys(formula.surfaces())}
    crossings = exact_crossings(formula, restricted, reach)
    doubtful = {s: r.doubtful(reach) for s, r in restricted.items()}
    cuts = sorted(
        {-reach, reach} | {t for spans in doubtful.values() for span in spans for t in span if abs(t) < reach}
    )
    runs: list[Run] = []
    known: Truth = None
    first: Truth = None
    for index, (low, high) in enumerate(itertools.pairwise(cuts)):
        middle = (low + high) / 2
        undecided = {s for s, spans in doubtful.items() if any(a <= middle <= b for a, b in spans)}

        def below(surface: Surface, at: Any = middle, undecided: set[Surface] = undecided) -> Truth:
            return None if surface in undecided else restricted[surface].below(at)

        truth = formula.truth(below)
        if index == 0:
            first = truth
        open_run = runs[-1] if runs and runs[-1].after is None and runs[-1].high == low else None
        if truth is None:
            if open_run is None:
                open_run = Run(low, high, known, None)
                runs.append(open_run)
            open_run.high = high
            open_run.surfaces |= undecided
        else:
            if open_run is not None:
                open_run.after = truth
            elif known is not None and truth is not known:
                runs.append(Run(low, low, known, truth))
            known = truth
    for crossing in crossings:
        holder = next((run for run in runs if run.low <= crossing.t <= run.high), None)
        assert holder is not None, "an exact crossing outside of every undecided stretch"
        holder.crossings.append(crossing)
    return Traced(crossings, runs, first)


def exact_crossings(formula: Formula, restricted: dict[Surface, Restricted], reach: Any) -> list[Crossing]:
    """Roots in order; a crossing is where the formula differs between the gaps on both sides."""
    events = sorted(
        ((t, s) for s, r in restricted.items() for t in r.roots if abs(t) < reach), key=lambda event: event[0]
    )
    times = sorted({t for t, _ in events})
    edges = [-reach, *times, reach]
    truths = [_truth_at(formula, restricted, (a + b) / 2) for a, b in itertools.pairwise(edges)]
    found = []
    for index, t in enumerate(times):
        before, after = truths[index], truths[index + 1]
        if before is after:
            continue
        surfaces = [s for u, s in events if u == t]
        found.append(_crossing(restricted[surfaces[0]], t, bool(after), len(surfaces) == 1))
    return found


def _truth_at(formula: Formula, restricted: dict[Surface, Restricted], t: Any) -> Truth:
    return formula.truth(lambda surface: restricted[surface].below(t))


def _crossing(on: Restricted, t: Any, entering: bool, simple: bool) -> Crossing:
    """Outward is against the ray where it enters."""
    rising = dot(on.gradient(t), on.line.direction) > 0
    return on.crossing(t, -1 if rising == entering else 1, on.surface.face if simple else None)


def inside(formula: Formula, point: Sequence[Any]) -> bool:
    """Exact membership of a point, surfaces included."""
    here = line(point, (1, 0, 0))
    frames: dict[int, Any] = {}
    return bool(formula.truth(lambda surface: Restricted(surface, here, ZERO, frames).below(ZERO)))
