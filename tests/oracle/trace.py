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

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .formula import Formula, Surface, Truth
from .frames import UNIT_ROWS, Affine, transposed
from .precision import ZERO, dot, length, mp, plus, total, vector

BAND = mp.mpf(2) ** -49
BAKED = mp.mpf(2) ** -52


@dataclass(frozen=True, eq=False)
class Line:
    """origin + t direction, exact values of floats."""

    origin: tuple[Any, ...]
    direction: tuple[Any, ...]
    speed: Any

    def at(self, t: Any) -> tuple[Any, ...]:
        return plus(self.origin, self.direction, t)


def line(origin: Sequence[Any], direction: Sequence[Any]) -> Line:
    d = vector(direction)
    return Line(vector(origin), d, length(d))


@dataclass(frozen=True)
class Crossing:
    """`cosine` = normal · unit direction, negative where the ray enters; `bend`: |hessian f| / |grad f|, a bound of
    how fast the unit outward `normal` turns along the surface."""

    t: Any
    entering: bool
    face: int | None
    cosine: Any
    normal: tuple[Any, ...] = ()
    bend: Any = ZERO


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


class Restricted:
    """A surface on a line: f(t) = a t² + 2 b t + c."""

    def __init__(self, surface: Surface, on: Line, size: Any, frames: dict[int, Any]) -> None:
        self.surface, self.line, self.size = surface, on, size
        key = id(surface.own)
        if key not in frames:
            frames[key] = ((*surface.own.point(on.origin), mp.one), (*surface.own.vector(on.direction), ZERO))
        self.o, self.d = frames[key]
        o, d = self.o, self.d
        self.a = total([ZERO, *(k * d[i] * d[j] for k, i, j in surface.terms)])
        self.b = total([ZERO, *(k * x / 2 for k, i, j in surface.terms for x in (o[i] * d[j], d[i] * o[j]))])
        self.c = total([ZERO, *(k * o[i] * o[j] for k, i, j in surface.terms)])

    def value(self, t: Any) -> Any:
        return (self.a * t + 2 * self.b) * t + self.c

    def gradient(self, t: Any) -> tuple[Any, ...]:
        """World gradient: own gradient carried back by the transposed rows."""
        x = plus(self.o, self.d, t)
        own = [ZERO] * 4
        for k, i, j in self.surface.terms:
            own[i] += k * x[j]
            own[j] += k * x[i]
        if _is_unit(self.surface.own):
            return tuple(own[:3])
        return tuple(sum((r * g for r, g in zip(column, own, strict=False)), ZERO) for column in transposed(self.surface.own.rows))

    def kappa(self, t: Any) -> Any:
        """How far from zero f may be at t for a displaced surface to pass there."""
        eta = BAND * (abs(t) * self.line.speed + self.size)
        if not self.surface.exact:
            eta += BAKED * length(self.line.at(t))
        return eta * _norm(self.gradient(t)) + eta * eta * self.bend

    @cached_property
    def bend(self) -> Any:
        """At least half of the hessian's norm in the world."""
        own = sum((abs(k) for k, _, j in self.surface.terms if j < 3), ZERO)
        return own * sum((r * r for row in self.surface.own.rows for r in row), ZERO)

    def crossing(self, t: Any, sign: int, face: int | None) -> Crossing:
        """The crossing at a root with the normal sign · grad f."""
        gradient = self.gradient(t)
        size = _norm(gradient) or mp.one
        normal = tuple(sign * g / size for g in gradient)
        cosine = dot(normal, self.line.direction) / self.line.speed
        return Crossing(t, bool(cosine < 0), face, cosine, normal, 2 * self.bend / size)

    @cached_property
    def roots(self) -> list[Any]:
        """Simple real roots; a double root is no crossing."""
        return quadratic_roots(self.a, self.b, self.c)

    def doubtful(self, reach: Any) -> list[tuple[Any, Any]]:
        """The stretches of ]-reach, reach[ where |f| <= kappa, and every root with them.

        Their ends are found with kappa linear in |t|, its slope taken at the roots, the vertex and
        the origin; between two such ends the true kappa decides, at the middle.
        """
        cuts = sorted({-reach, ZERO, reach} | {t for g in self._slopes(reach) for t in self._ends(g) if abs(t) < reach})
        found: list[tuple[Any, Any]] = []
        for low, high in zip(cuts, cuts[1:], strict=False):
            if self.below_between(low, high) is None:
                if found and found[-1][1] == low:
                    found[-1] = (found[-1][0], high)
                else:
                    found.append((low, high))
        return found

    def _slopes(self, reach: Any) -> set[Any]:
        """|grad f| at the places near which a displacement may matter."""
        if not any(j < 3 for _, _, j in self.surface.terms):
            return {_norm(self.gradient(ZERO))}
        places = [ZERO, *self.roots]
        if self.a:
            places.append(-self.b / self.a)
        return {_norm(self.gradient(t)) for t in places if abs(t) < reach}

    def _ends(self, slope: Any) -> list[Any]:
        """Roots of f = ± slope (BAND (|t| speed + size) + BAKED (|o| + |t| speed)), each on its side of t = 0."""
        baked = ZERO if self.surface.exact else BAKED
        fixed = slope * (BAND * self.size + baked * _norm(self.line.origin))
        rate = slope * (BAND + baked) * self.line.speed
        found = []
        for above in (1, -1):
            for side in (1, -1):
                roots = quadratic_roots(self.a, self.b - above * side * rate / 2, self.c - above * fixed)
                found += [t for t in roots if t * side > 0]
        return found

    def below(self, t: Any) -> bool:
        return bool(self.value(t) <= 0)

    def below_between(self, low: Any, high: Any) -> Truth:
        """None where the stretch holds a root, or a displaced surface may pass its middle."""
        middle = (low + high) / 2
        if any(low <= root <= high for root in self.roots) or abs(self.value(middle)) <= self.kappa(middle):
            return None
        return self.below(middle)


def quadratic_roots(a: Any, b: Any, c: Any) -> list[Any]:
    """Simple real roots of a t² + 2 b t + c, by the formula that does not cancel."""
    if not a:
        return [-c / (2 * b)] if b else []
    disc = total([b * b, -a * c])
    if disc <= 0:
        return []
    q = -(b + mp.sign(b) * mp.sqrt(disc)) if b else mp.sqrt(disc)
    return sorted((q / a, c / q))


def _is_unit(own: Affine) -> bool:
    return own.rows is UNIT_ROWS


def _norm(v: Sequence[Any]) -> Any:
    return mp.sqrt(sum((x * x for x in v), ZERO))


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
    cuts = sorted({-reach, reach} | {t for spans in doubtful.values() for span in spans for t in span if abs(t) < reach})
    runs: list[Run] = []
    known: Truth = None
    first: Truth = None
    for index, (low, high) in enumerate(zip(cuts, cuts[1:], strict=False)):
        undecided: set[Surface] = set()

        def below(surface: Surface, low: Any = low, high: Any = high, undecided: set[Surface] = undecided) -> Truth:
            on, middle = restricted[surface], (low + high) / 2
            if not any(a <= middle <= b for a, b in doubtful[surface]):
                return on.below(middle)
            undecided.add(surface)
            return None

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
    truths = [_truth_at(formula, restricted, (a + b) / 2) for a, b in zip(edges, edges[1:], strict=False)]
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

