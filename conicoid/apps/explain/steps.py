"""The steps of an explanation as data: surfaces, cells and bodies on one ray.

Floats are those of the kernels, to the bit. Everything is immutable. At the end of the file: true and false crossings
of a cell, and its planes as slabs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..._util.arrays import Vector
from ..._util.files import printable
from ..._util.records import dataclass
from ...geometry.general_quadric import PLANE
from ...numerics.rational import dot
from ...queries.hits import Hits
from ...queries.scene_protocol import SceneLike
from .document import Board
from .polynomial import ExactRay as Ray, Polynomial, SurfaceSource, as_float
from .textbook import Slab, board_of, solve_slabs

# Outcomes of a body
OUTCOMES = (
    HIT, CROSSED, STARTED, BOX_MISSED, BALL_MISSED, NO_ROOT, TOUCHED, PLANES, INTERVAL, BOOLEAN, OUTLINE, CLIPPED,
    PARALLEL, BEHIND, INSIDE,
) = (
    "hit", "crossed", "started on", "box missed", "ball missed", "no real root", "only touched", "outside its planes",
    "outside the interval", "nothing left by the Boolean", "outside its outline", "cut away", "parallel",
    "seen from behind", "inside all along",
)  # fmt: skip
"""Every `BodyStep.outcome`."""


@dataclass(frozen=True)
class Crossing:
    """A crossing of the ray with a body; `t_error` bounds the error of t in crossings of the queries, else it is 0."""

    t: float
    body: int
    face: int
    surface: int
    entering: bool
    t_error: float = field(default=0.0, compare=False)


@dataclass(frozen=True)
class Span:
    """A stretch of the ray inside a body; an end that is not a wall is clipped by the interval."""

    t_enter: float
    t_exit: float
    enter_clipped: bool
    exit_clipped: bool


@dataclass(frozen=True)
class SurfaceStep:
    """A surface on the ray, by the numbers of the kernels.

    number     of the surface
    flat       whether it is a plane
    a, b, c, foot   of a curved surface: a t² + 2 b t + c, t counted from `foot`, the foot of the perpendicular from the
               surface's anchor; NaN for a plane
    discriminant   b² − a c in its moment form (docs/theory.md, section 10)
    height, rate   of a plane: height + rate t; NaN for a curved surface
    roots      (low, high) of a curved surface that is crossed, (t,) of a plane; else ()
    outside    whether the inside is beyond the roots, or the whole ray if there are none
    careful    whether some sum cancelled, and all was computed again in two floats
    doubtful   whether the error bound leaves the crossings in doubt
    least      the smallest discriminant that is not in doubt
    starts     whether the ray starts on the surface: the root t = 0 is removed
    source, line   the exact surface and ray
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
        """The exact equation in the world."""
        return self.source.polynomial

    @property
    def kind(self) -> str:
        """The kind, as `SceneSurface.kind` has it."""
        return PLANE if self.flat else self.source.classification.kind

    @property
    def equation(self) -> str:
        """The readable equation, as `SceneSurface.equation` has it."""
        return self.source.polynomial.equation

    @cached_property
    def board(self) -> Board:
        """The solution by the documents, in exact arithmetic."""
        return board_of(self.source, self.line)


@dataclass(frozen=True)
class FaceStep:
    """A face of a cell: its surface, and where the ray enters and leaves through it.

    inside     1 if the surface's equation is negative on the cell's side, else -1
    entered, left   t of the crossings
    """

    face: int
    surface: SurfaceStep
    inside: int
    entries: tuple[float, ...] = ()
    exits: tuple[float, ...] = ()


@dataclass(frozen=True)
class Candidate:
    """A crossing with one face of a cell: true if it lies within all other faces, else false."""

    t: float
    face: int
    entering: bool
    outside_of: int | None  # a face; None of a true one


@dataclass(frozen=True)
class CellStep:
    """A cell, an intersection of at most one quadric and some planes: the part of the ray in its planes, then in all.

    letter     of its leaf in a Boolean, or ""
    slab       (t, t) within the planes; empty if the first is not the smaller
    spans      within all faces, on the whole line: ((t_enter, face, t_exit, face), ...)
    why        one of `OUTCOMES` if there are no spans, else ""
    case       for a quadric between two parallel planes, which of the six cases of the Clemson notes it is; 0 for none
    doubtful   whether error bounds leave the spans in doubt
    off        error bound of t on the cell
    line       the exact ray
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
        """All crossings with the faces in order of t, true and false ones (NA8FIR of the graphics textbook)."""
        return _candidates_of(self.faces, self.spans, self.line)

    @cached_property
    def board(self) -> Board:
        """The slabs of a cell of planes alone, solved like a box of the ray tracing notes; empty for other cells."""
        flat = all(face.surface.flat for face in self.faces)
        return _slabs_board(slab_pairs(self.faces), self.faces, self.line) if flat else Board(())


@dataclass(frozen=True)
class SweepRow:
    """An event of the sweep along the ray: an end of a leaf's span, and the counts after it.

    letter     of the leaf, "A", "B" ...
    inside     letters of the leaves that the ray is in after it
    count, need   true inputs of the topmost gate, and how many of them make it true
    value      whether the ray is inside the body after all events at this t
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
    """The Boolean of a body: its expression in letters of leaves, its value before all events, and the events."""

    expression: str
    begins: bool
    rows: tuple[SweepRow, ...]
    unused_leaves: tuple[str, ...]  # letters of leaves without an event


@dataclass(frozen=True)
class OutlineStep:
    """A polygon in the view along the ray: corners (u, v), and the edges that a half-line across the view crosses."""

    corners: tuple[tuple[float, float], ...]
    counts: tuple[bool, ...]  # of the edge that ends at each corner
    inside: bool
    board: Board = field(repr=False)


@dataclass(frozen=True)
class BoxTest:
    """The box around a body: the part `near` <= t <= `far` of the interval in it, by slabs (the ray tracing notes)."""

    low: Vector
    high: Vector
    near: float
    far: float
    board: Board = field(repr=False)

    @property
    def missed(self) -> bool:
        """Whether no part of the interval is in the box."""
        return not self.near <= self.far


@dataclass(frozen=True)
class BallTest:
    """The ball around a body, and the distance of the line from its center."""

    center: Vector
    radius: float
    distance: float


@dataclass(frozen=True)
class BodyStep:
    """A body that the ray hits or misses, and why.

    body, name, shape, kind   its number, its name, the repr of its shape, and "ball", "solid", "Boolean", "sheet" or
               "polygon"
    outcome, sentence   one of `OUTCOMES`, and the outcome as a sentence
    crossings, spans   the results of `scene.crossings` and `scene.spans` for this body
    box, ball  tests of a body that the tree leaves out
    cells, sweep   of a solid or a Boolean, or of the solid that clips a sheet
    surface    of a ball, a sheet or a polygon
    outline    of a polygon
    doubtful   whether error bounds leave the crossings in doubt
    """

    body: int
    name: str
    shape: str
    kind: str
    outcome: str
    sentence: str
    crossings: tuple[Crossing, ...] = ()
    spans: tuple[Span, ...] = ()
    box: BoxTest | None = None
    ball: BallTest | None = None
    cells: tuple[CellStep, ...] = ()
    sweep: Sweep | None = None
    surface: SurfaceStep | None = None
    outline: OutlineStep | None = None
    doubtful: bool = False

    @property
    def title(self) -> str:
        """The name on one line, without control characters and half pairs of surrogates, for drawings and texts."""
        return printable(self.name)


@dataclass(frozen=True)
class RankedPlace:
    """A crossing with a surface, located with certainty.

    rank       its rank in the order along the ray
    high, low  t as a sum of two floats, to thirty digits
    error      bound on the error of that sum
    t          the reported t
    """

    rank: int
    surface: int
    high: float
    low: float
    error: float
    t: float


@dataclass(frozen=True)
class Decision:
    """How the result was made certain.

    first      how the first hit, or the miss, was decided: "floats", "certified" (numbers in two floats that carry
               error bounds) or "exact"
    all        how all crossings were decided, in the same words: crossings behind the first hit may be in doubt alone
    t_error    bound on |t − t*| of the first hit; 0 for a miss
    places     of a doubtful ray, all crossings with surfaces in order
    """

    first: str
    all: str
    t_error: float = 0.0
    places: tuple[RankedPlace, ...] = ()


@dataclass(frozen=True)
class RayRecord:
    """All steps of one ray as data, the source of figures and texts; `Explanation` documents the fields."""

    origin: tuple[float, float, float]
    direction: tuple[float, float, float]
    t_min: float
    t_max: float
    hit: Hits
    bodies: tuple[BodyStep, ...]
    misses: int
    surfaces: dict[int, SurfaceStep]
    crossings: tuple[Crossing, ...]
    decision: Decision
    scene: SceneLike = field(repr=False)

    def __getitem__(self, which: Any) -> BodyStep:
        """Return the step of a body by its number or name. Raise a LookupError if it is not among `bodies`."""
        for step in self.bodies:
            if which in (step.body, step.name) and not isinstance(which, bool):
                return step
        names = ", ".join(repr(step.name) for step in self.bodies[:8])
        raise LookupError(f"explanation: no step of body {which!r}; there are {names}")


# Crossings with the faces of a cell, true and false.


def _candidates_of(faces: Sequence[FaceStep], spans: Any, line: Ray) -> tuple[Candidate, ...]:
    """Return all crossings with faces in order of t, false ones with a face that they lie outside of (NA8FIR)."""
    true = {(t, face, True) for t, face, _, _ in spans} | {(t, face, False) for _, _, t, face in spans}
    found = []
    for face in faces:
        for entering, places in ((True, face.entries), (False, face.exits)):
            for t in places:
                is_true = (t, face.face, entering) in true
                found.append(Candidate(t, face.face, entering, None if is_true else _outside_of(faces, face, t, line)))
    return tuple(sorted(found, key=lambda one: (one.t, one.face)))


def _outside_of(faces: Sequence[FaceStep], own: FaceStep, t: float, line: Ray) -> int:
    """Return the face with the largest positive value at a point; -1 if none is positive, on an edge."""
    # The exact polynomials at the reported t
    point = line.at(t)
    values = [(one.inside * one.surface.polynomial.value(point), one.face) for one in faces if one is not own]
    value, face = max(values, default=(Fraction(0), -1))
    return face if value > 0 else -1


# Planes of a cell in pairs: slabs, which the textbook solves.

_PARALLEL = 1e-12
"""Squared tangent of the largest angle between the sides of a slab."""


def slab_pairs(faces: Sequence[FaceStep]) -> list[tuple[int, int]]:
    """Return pairs of places in `faces` that are two sides of a slab, the one with the lower offset first."""
    flat = [k for k, face in enumerate(faces) if face.surface.flat]
    pairs: list[tuple[int, int]] = []
    for k, i in enumerate(flat):
        for j in flat[k + 1 :]:
            used = {each for pair in pairs for each in pair}
            # Each plane belongs to one slab at most
            if i not in used and j not in used and _opposite(outward(faces[i]), outward(faces[j])):
                low, high = (i, j) if _leads(outward(faces[j])) else (j, i)
                pairs.append((low, high))
    return pairs


def outward(face: FaceStep) -> list[Fraction]:
    """Return the outward normal of a plane, of any length."""
    return [2 * face.inside * half for half in face.surface.polynomial.ten[6:9]]


def _leads(normal: Sequence[Fraction]) -> bool:
    """Return True if the first component that is not negligible is positive."""
    largest = max(map(abs, normal))
    return next(c for c in normal if abs(c) > _PARALLEL * largest) > 0


def _opposite(m: Sequence[Fraction], n: Sequence[Fraction]) -> bool:
    """Return True if two normals point in opposite directions."""
    # sin² of the angle as |m|² |n|² − (m·n)², relative to (m·n)²
    along = as_float(dot(m, n))
    return along < 0 and as_float(dot(m, m)) * as_float(dot(n, n)) - along * along <= _PARALLEL * along * along


def _slabs_board(pairs: Sequence[tuple[int, int]], faces: Sequence[FaceStep], line: Ray) -> Board:
    """Return the board of the slabs of a cell, one after the other."""
    return solve_slabs([_slab(faces[i], faces[j], line, k) for k, (i, j) in enumerate(pairs)], line)


def _slab(low: FaceStep, high: FaceStep, line: Ray, k: int) -> Slab:
    """Return the slab of two planes: (name, low, high, n·o, n·d) of low <= n·p <= high; along an axis n is the axis."""
    normal = outward(high)
    # Along an axis, as of a box, the numbers are the coordinates themselves
    axes = [i for i in range(3) if normal[i]]
    scale = abs(normal[axes[0]]) if len(axes) == 1 else Fraction(1)
    normal = [value / scale for value in normal]
    name = "xyz"[axes[0]] if len(axes) == 1 else f"slab {k + 1}"
    top = -high.inside * high.surface.polynomial.ten[9] / scale
    # The other plane in the length of n: exactly along an axis, otherwise by a rounded square root
    other = outward(low)
    length = math.sqrt(as_float(dot(other, other)) / as_float(dot(normal, normal)))
    ratio = Fraction(length) if len(axes) != 1 else abs(other[axes[0]])
    bottom = low.inside * low.surface.polynomial.ten[9] / ratio
    return name, bottom, top, dot(normal, line.origin), dot(normal, line.direction)
