"""The steps of an explanation, as data: what was computed of surfaces, cells and bodies for one ray.

Floats are the kernels' own, to the bit. Everything is immutable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..._util.arrays import Vector
from ...geometry.quadric_classification import PLANE
from .document import Board
from .polynomial import ExactRay as Ray
from .polynomial import Polynomial, SurfaceSource, as_float, dot
from .textbook import Slab, board_of, solve_slabs

if TYPE_CHECKING:
    from ...queries.hits import Hits
    from ...queries.scene_protocol import SceneLike

# How a body ends
HIT, CROSSED, STARTED = "hit", "crossed", "started on"
BOX_MISSED, BALL_MISSED, NO_ROOT, TOUCHED, PLANES, INTERVAL = (
    "box missed", "ball missed", "no real root", "only touched", "outside its planes", "outside the interval",
)  # fmt: skip
BOOLEAN, OUTLINE, CLIPPED, PARALLEL, BEHIND, INSIDE = (
    "nothing left by the Boolean", "outside its outline", "cut away", "parallel", "seen from behind",
    "inside all along",
)  # fmt: skip
OUTCOMES = (
    HIT,
    CROSSED,
    STARTED,
    BOX_MISSED,
    BALL_MISSED,
    NO_ROOT,
    TOUCHED,
    PLANES,
    INTERVAL,
    BOOLEAN,
    OUTLINE,
    CLIPPED,
    PARALLEL,
    BEHIND,
    INSIDE,
)
"""Every `BodyStep.outcome`."""


@dataclass(frozen=True)
class Crossing:
    """A crossing of the ray with a body; the exact one is at most `t_error` away, where that has been asked for."""

    t: float
    body: int
    face: int
    surface: int
    entering: bool
    t_error: float = field(default=0.0, compare=False)


@dataclass(frozen=True)
class Span:
    """A stretch of the ray inside a body; ends that are no walls are clipped by the interval."""

    t_enter: float
    t_exit: float
    enter_clipped: bool
    exit_clipped: bool


@dataclass(frozen=True)
class SurfaceStep:
    """A surface on the ray, as the kernels have it.

    number     of the surface
    flat       a plane, on which the ray has the value height + rate t; else a t² + 2 b t + c about the foot of the
               perpendicular from the surface's anchor, t being counted from `foot` there
    discriminant   b² − a c in its moment form (docs/theory.md, section 10)
    roots      (low, high) of a curved surface that is crossed, (t,) of a plane; else ()
    outside    the inside is beyond the roots, or all of the ray where there are none
    careful    some sum cancelled, and all was computed again in two floats
    doubtful   by its error bound this surface might be met otherwise
    least      the discriminant from which on it would not be doubtful
    starts     the ray starts on it: the root t = 0 is removed
    """

    number: int
    flat: bool
    a: float
    b: float
    c: float
    discriminant: float
    foot: float
    height: float
    rate: float
    roots: tuple[float, ...]
    outside: bool
    careful: bool
    doubtful: bool
    least: float
    starts: bool
    source: SurfaceSource = field(repr=False)
    line: Ray = field(repr=False)

    @property
    def polynomial(self) -> Polynomial:
        """Its equation in the world, exact."""
        return self.source.polynomial

    @property
    def kind(self) -> str:
        """As `SceneSurface.kind` tells it."""
        return PLANE if self.flat else self.source.classification.kind

    @property
    def equation(self) -> str:
        """As `SceneSurface.equation` tells it."""
        return self.source.polynomial.equation

    @cached_property
    def board(self) -> Board:
        """What the documents make of it, in exact arithmetic."""
        return board_of(self.source, self.line)


@dataclass(frozen=True)
class FaceStep:
    """A face of a cell: its surface, and where it is entered and left.

    inside     1 where the cell has the side on which the surface's equation is negative, else -1
    entered, left   t of its crossings
    """

    face: int
    surface: SurfaceStep
    inside: int
    entered: tuple[float, ...] = ()
    left: tuple[float, ...] = ()


@dataclass(frozen=True)
class Candidate:
    """A crossing with one face of a cell: true if it lies within all others, else false because of one of them."""

    t: float
    face: int
    entering: bool
    outside_of: int | None  # a face; None of a true one


@dataclass(frozen=True)
class CellStep:
    """A cell, which is at most one quadric and some planes: what is left of the ray by its planes, then by all.

    slab       (t, t) that the planes leave, empty where the first is not the smaller
    spans      what is inside, on the whole line: ((t_enter, face, t_exit, face), ...)
    why        one of `OUTCOMES` where there is none
    case       of a quadric between two parallel planes, which of the Clemson notes' six cases it is; 0 for none
    """

    number: int
    letter: str
    faces: tuple[FaceStep, ...]
    slab: tuple[float, float]
    spans: tuple[tuple[float, int, float, int], ...]
    why: str
    case: int
    doubtful: bool
    off: float
    line: Ray = field(repr=False)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        """All crossings with its faces in order of t, which are true or false (NA8FIR of the graphics textbook)."""
        return _candidates_of(self.faces, self.spans, self.line)

    @cached_property
    def board(self) -> Board:
        """Of a cell of planes alone: its slabs, worked out as the ray tracing notes do with a box."""
        flat = all(face.surface.flat for face in self.faces)
        return _slabs_board(slab_pairs(self.faces), self.faces, self.line) if flat else Board(())


@dataclass(frozen=True)
class SweepRow:
    """An end of a leaf's span, in the sweep along the ray: what is counted after it.

    letter     of the leaf, "A", "B" ...; `inside` the letters of all that the ray is in now
    count, need   true inputs of the topmost gate, and how many it takes
    value      is the ray inside the body after all that happens at this t?
    """

    t: float
    surface: int
    face: int
    letter: str
    entering: bool
    inside: str
    count: int
    need: int
    value: bool


@dataclass(frozen=True)
class Sweep:
    """The Boolean of a body: its expression in letters of leaves, the value before all, and the events in order."""

    expression: str
    begins: bool
    rows: tuple[SweepRow, ...]
    left_out: tuple[str, ...]  # letters of leaves whose boxes the ray misses


@dataclass(frozen=True)
class OutlineStep:
    """A polygon as the ray sees it: corners (u, v), and the edges that the half-line across the view meets."""

    corners: tuple[tuple[float, float], ...]
    counted: tuple[bool, ...]  # of the edge that ends at each corner
    inside: bool
    board: Board = field(repr=False)


@dataclass(frozen=True)
class BoxTest:
    """The box around a body: t from `near` to `far` in it, of the interval, by its slabs (the ray tracing notes)."""

    low: Vector
    high: Vector
    near: float
    far: float
    board: Board = field(repr=False)

    @property
    def missed(self) -> bool:
        return not self.near <= self.far


@dataclass(frozen=True)
class BallTest:
    """The ball around a body: how far from its center the line passes."""

    center: Vector
    radius: float
    distance: float


@dataclass(frozen=True)
class BodyStep:
    """A body met or missed, and why.

    outcome    one of `OUTCOMES`, which `told` says in words
    crossings, spans   the answers of `scene.crossings` and `scene.spans` for this body
    floats     crossings that the float formulas alone find; others than `crossings` only where the ray is doubtful
    """

    body: int
    name: str
    shape: str
    kind: str
    outcome: str
    told: str
    crossings: tuple[Crossing, ...] = ()
    spans: tuple[Span, ...] = ()
    floats: tuple[Crossing, ...] = ()
    box: BoxTest | None = None
    ball: BallTest | None = None
    cells: tuple[CellStep, ...] = ()
    sweep: Sweep | None = None
    surface: SurfaceStep | None = None
    outline: OutlineStep | None = None
    doubtful: bool = False


@dataclass(frozen=True)
class RankedPlace:
    """A crossing with a surface, located with certainty: its rank along the ray, and where it is to thirty digits."""

    rank: int
    surface: int
    high: float
    low: float
    error: float
    t: float


@dataclass(frozen=True)
class Decision:
    """How the answer was made certain.

    first      how the first hit was decided, or that there is none: "floats", "certified" (numbers in two floats that
               carry error bounds) or "exact"
    all        how all crossings were: the same words, as what lies beyond the first hit may be in doubt
    t_error    a bound on |t − t*| of the first hit; 0 for a miss
    places     of a doubtful ray all crossings with surfaces in their order
    """

    first: str
    all: str
    t_error: float = 0.0
    places: tuple[RankedPlace, ...] = ()


@dataclass(frozen=True)
class RayRecord:
    """All steps of one ray as data, which figures and texts are made of; `Explanation` documents the fields."""

    origin: tuple[float, float, float]
    direction: tuple[float, float, float]
    t_min: float
    t_max: float
    hit: Hits
    bodies: tuple[BodyStep, ...]
    missed: int
    surfaces: dict[int, SurfaceStep]
    crossings: tuple[Crossing, ...]
    decision: Decision
    scene: SceneLike = field(repr=False)

    def __getitem__(self, which: Any) -> BodyStep:
        """The step of a body, by its number or name. A LookupError where it is none of `bodies`."""
        for step in self.bodies:
            if which in (step.body, step.name) and not isinstance(which, bool):
                return step
        known = ", ".join(repr(step.name) for step in self.bodies[:8])
        raise LookupError(f"explanation: no step of body {which!r}; there are {known}")


# Crossings with the faces of a cell, true and false.


def _candidates_of(faces: Sequence[FaceStep], spans: Any, line: Ray) -> tuple[Candidate, ...]:
    """All crossings with faces in order of t, false ones with a face that they lie outside of (NA8FIR)."""
    true = {(t, face, True) for t, face, _, _ in spans} | {(t, face, False) for _, _, t, face in spans}
    found = []
    for face in faces:
        for entering, places in ((True, face.entered), (False, face.left)):
            for t in places:
                is_true = (t, face.face, entering) in true
                found.append(Candidate(t, face.face, entering, None if is_true else _outside_of(faces, face, t, line)))
    return tuple(sorted(found, key=lambda one: (one.t, one.face)))


def _outside_of(faces: Sequence[FaceStep], own: FaceStep, t: float, line: Ray) -> int:
    """The face whose function says most strongly that a point lies outside; -1 where it lies on an edge."""
    point = line.at(t)
    values = [(one.inside * one.surface.polynomial.value(point), one.face) for one in faces if one is not own]
    value, face = max(values, default=(Fraction(0), -1))
    return face if value > 0 else -1


# Planes of a cell in pairs: slabs, which the textbook solves.

_PARALLEL = 1e-12


def slab_pairs(faces: Sequence[FaceStep]) -> list[tuple[int, int]]:
    """Which planes are two sides of a slab: (the one with the lower offset along the axis, the other)."""
    flat = [k for k, face in enumerate(faces) if face.surface.flat]
    pairs: list[tuple[int, int]] = []
    for k, i in enumerate(flat):
        for j in flat[k + 1 :]:
            used = {each for pair in pairs for each in pair}
            if i not in used and j not in used and _opposite(outward(faces[i]), outward(faces[j])):
                low, high = (i, j) if _leads(outward(faces[j])) else (j, i)
                pairs.append((low, high))
    return pairs


def outward(face: FaceStep) -> list[Fraction]:
    """The outward normal of a plane, of any length."""
    return [2 * face.inside * half for half in face.surface.polynomial.ten[6:9]]


def _leads(normal: Sequence[Fraction]) -> bool:
    """Is the first component that counts positive?"""
    largest = max(map(abs, normal))
    return next(c for c in normal if abs(c) > _PARALLEL * largest) > 0


def _opposite(m: Sequence[Fraction], n: Sequence[Fraction]) -> bool:
    along = as_float(dot(m, n))
    return along < 0 and as_float(dot(m, m)) * as_float(dot(n, n)) - along * along <= _PARALLEL * along * along


def _slabs_board(pairs: Sequence[tuple[int, int]], faces: Sequence[FaceStep], line: Ray) -> Board:
    """The slabs of a cell, one after the other."""
    return solve_slabs([_slab(faces[i], faces[j], line, k) for k, (i, j) in enumerate(pairs)], line)


def _slab(low: FaceStep, high: FaceStep, line: Ray, k: int) -> Slab:
    """(name, low <= n·p <= high, n·o, n·d); along an axis n is the axis."""
    normal = outward(high)
    axes = [i for i in range(3) if normal[i]]
    scale = abs(normal[axes[0]]) if len(axes) == 1 else Fraction(1)
    normal = [value / scale for value in normal]
    name = "xyz"[axes[0]] if len(axes) == 1 else f"slab {k + 1}"
    top = -high.inside * high.surface.polynomial.ten[9] / scale
    other = outward(low)
    length = math.sqrt(as_float(dot(other, other)) / as_float(dot(normal, normal)))
    ratio = Fraction(length) if len(axes) != 1 else abs(other[axes[0]])
    bottom = low.inside * low.surface.polynomial.ten[9] / ratio
    return name, bottom, top, dot(normal, line.origin), dot(normal, line.direction)
