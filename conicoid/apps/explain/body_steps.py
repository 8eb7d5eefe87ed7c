"""The steps of surfaces, cells and bodies on a ray: the recorded numbers of the kernels as data of `steps.py`.

Order of the file: surfaces, cells, Boolean bodies, bodies of every kind, bodies that the tree leaves out, outcomes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from ...kernels.faces import cell_faces, numbers_of, plane_faces, sides_of
from ...kernels.programs import cells_of_leaves, gates_of_program, leaves_of_program, row_of_leaf
from ...kernels.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET
from . import ray_records as kernels
from .polynomial import ExactRay, SurfaceSource, as_float, format_float
from .ray_records import RayRecording
from .steps import (
    BALL_MISSED,
    BEHIND,
    BOOLEAN,
    BOX_MISSED,
    CLIPPED,
    CROSSED,
    HIT,
    INSIDE,
    INTERVAL,
    NO_ROOT,
    OUTLINE,
    PARALLEL,
    PLANES,
    STARTED,
    TOUCHED,
    BallTest,
    BodyStep,
    BoxTest,
    CellStep,
    Crossing,
    FaceStep,
    OutlineStep,
    Span,
    SurfaceStep,
    Sweep,
    SweepRow,
    slab_pairs,
)
from .textbook import outline_board, solve_slabs


class SurfaceSteps:
    """The steps of surfaces on a ray by number, each computed once; iterates over those computed so far."""

    def __init__(self, recording: RayRecording, line: ExactRay) -> None:
        self.recording, self.line = recording, line
        self._cache: dict[int, SurfaceStep] = {}

    def __getitem__(self, number: int) -> SurfaceStep:
        if number not in self._cache:
            self._cache[number] = self._step(number)
        return self._cache[number]

    def __iter__(self) -> Any:
        return iter(self._cache.values())

    def _step(self, number: int) -> SurfaceStep:
        """Return the step of a surface from its recorded row."""
        scene, row = self.recording.scene, self.recording.surface(number)
        source = SurfaceSource.of(scene, number)
        crosses, flat = row[kernels.CROSSES] == 1.0, source.kind == PLANE
        roots: tuple[float, ...] = ()
        if crosses:
            roots = (float(row[kernels.T]),) if flat else (float(row[kernels.LOW]), float(row[kernels.HIGH]))
        a, b, c, discriminant, foot = (math.nan if flat else float(row[k]) for k in range(kernels.FOOT + 1))
        return SurfaceStep(
            number, flat, a, b, c, discriminant, foot,
            height=float(row[kernels.HEIGHT]) if flat else math.nan,
            rate=float(row[kernels.RATE]) if flat else math.nan,
            roots=roots,
            outside=bool(row[kernels.OUTSIDE]) and not flat,
            careful=bool(row[kernels.CANCELS]),
            doubtful=bool(row[kernels.UNSURE]),
            least=float(row[kernels.LEAST]),
            starts=number == self.recording.start,
            source=source,
            line=self.line,
        )  # fmt: skip


# Steps of cells: the parts of the ray inside the planes and the quadric, true crossings, and the case.

CASES = {"ccbb": 1, "cbcb": 2, "cbbc": 3, "bcbc": 4, "bccb": 5, "bbcc": 6}
"""Order of the crossings with caps (c) and body (b) -> number of the case in the Clemson notes."""


def cell_step(recording: RayRecording, surfaces: SurfaceSteps, cell: int, letter: str, line: ExactRay) -> CellStep:
    """Return the step of a cell on the ray; `letter` is that of its leaf in a Boolean."""
    row = recording.cell(cell)
    faces = _faces(recording, surfaces, cell)
    spans = tuple(
        (t_in, recording.face_at(p)[1], t_out, recording.face_at(q)[1]) for t_in, p, t_out, q in recording.ends(row)
    )
    slab = float(row[kernels.SLAB_IN]), float(row[kernels.SLAB_OUT])
    curved = next((face for face in faces if not face.surface.flat), None)
    return CellStep(
        cell, letter, faces, slab, spans, "" if spans else _miss_reason(curved, slab, line),
        _case(curved, faces), bool(row[kernels.CELL_UNSURE]),
        float(row[kernels.CELL_OFF]), line,
    )  # fmt: skip


def _faces(recording: RayRecording, surfaces: SurfaceSteps, cell: int) -> tuple[FaceStep, ...]:
    """Return the faces of a cell: that of the quadric, if there is one, then those of the planes."""
    tables, steps = recording.tables, []
    quadric = int(tables.cell_quadric[cell])
    if quadric >= 0:
        step, inside = surfaces[quadric], int(sides_of(cell_faces(tables, cell)))
        entered, left = step.roots[:1], step.roots[1:]
        # `outside` is for the negative side; the cell may have the other one
        if step.outside == (inside > 0):
            entered, left = left, entered
        steps.append(
            FaceStep(
                int(numbers_of(cell_faces(tables, cell))), step, inside, _finite_roots(entered), _finite_roots(left)
            )
        )
    for place in range(int(tables.cell_first[cell]), int(tables.cell_first[cell + 1])):
        step, inside = surfaces[int(tables.plane_surface[place])], int(sides_of(plane_faces(tables, place)))
        enters = (step.rate < 0) == (inside > 0)
        steps.append(
            FaceStep(
                int(numbers_of(plane_faces(tables, place))),
                step,
                inside,
                step.roots if enters else (),
                () if enters else step.roots,
            )
        )
    return tuple(steps)


def _finite_roots(values: Sequence[float]) -> tuple[float, ...]:
    """Return the values that are finite."""
    return tuple(value for value in values if math.isfinite(value))


def _miss_reason(curved: FaceStep | None, slab: tuple[float, float], line: ExactRay) -> str:
    """Return the outcome of a cell that the ray does not enter."""
    if not slab[0] < slab[1] or curved is None or curved.surface.roots:
        return PLANES
    return miss_outcome(curved.surface, line)


def miss_outcome(step: SurfaceStep, line: ExactRay) -> str:
    """Return NO_ROOT, or TOUCHED if the discriminant is exactly zero."""
    a, b, c = step.polynomial.on_ray(line.origin, line.direction)
    return TOUCHED if (a or b) and b * b == a * c else NO_ROOT


def _case(curved: FaceStep | None, faces: Sequence[FaceStep]) -> int:
    """Return which of the six cases of body and caps it is; 0 for equal crossings and for other cells."""
    if curved is None or len(faces) != 3 or curved.surface.outside == (curved.inside > 0):
        return 0
    pairs = slab_pairs(faces)
    if len(pairs) != 1:
        return 0
    body = curved.entries + curved.exits
    caps = [t for k in pairs[0] for t in faces[k].entries + faces[k].exits]
    if len(body) != 2 or len(caps) != 2 or len({*body, *caps}) < 4:
        return 0
    order = sorted([(t, "b") for t in body] + [(t, "c") for t in caps])
    return CASES["".join(name for _, name in order)]


# Steps of Boolean bodies: the expression, the sweep along the ray, and the crossings.

_SINGLE = 26
"""Letters of the alphabet."""


def letter_of(leaf: int) -> str:
    """Return the letter of a leaf by its number in a body: A, B, ... Z, A2, B2 and so on."""
    return "ABCDEFGHIJKLMNOPQRSTUVWXYZ"[leaf % _SINGLE] + (str(leaf // _SINGLE + 1) if leaf >= _SINGLE else "")


def expression_of(tables: Any, program: int) -> str:
    """Return a Boolean program as an expression in the letters of its leaves, with ∪, ∩ and ¬."""
    first = int(tables.program_leaf[program])
    gates = gates_of_program(tables, program)
    inputs: dict[int, list[str]] = {gate: [] for gate in gates}
    for leaf in leaves_of_program(tables, program):
        row = int(row_of_leaf(tables, program, leaf))
        negated = "¬" if tables.leaf_negated[row] else ""
        inputs[int(tables.leaf_gate[row])].append(negated + letter_of(leaf - first))
    # The deepest gates first, so that the text of a gate's inputs is complete
    for gate in sorted(gates, key=lambda gate: -_depth(tables, gate)):
        need, names = int(tables.gate_need[gate]), inputs[gate]
        # One true input is a union, all of them an intersection
        sign = " ∪ " if need == 1 else " ∩ "
        text = sign.join(names) if need in (1, len(names)) else f"at least {need} of {', '.join(names)}"
        text = text or ("nothing" if need else "all")
        # A parent has a smaller depth: its inputs are written before it
        parent = int(tables.gate_parent[gate])
        bracketed = f"({text})" if len(names) > 1 else text
        negated = "¬" if tables.gate_negated[gate] else ""
        if parent < 0:
            return f"{negated}{bracketed}" if negated else text
        inputs[parent].append(negated + bracketed)
    return ""


def _depth(tables: Any, gate: int) -> int:
    """Return the number of gates above a gate."""
    depth = 0
    while tables.gate_parent[gate] >= 0:
        gate, depth = int(tables.gate_parent[gate]), depth + 1
    return depth


def sweep_of(recording: RayRecording, program: int, rows: Any) -> Sweep:
    """Return the recorded events of a program as a table."""
    tables = recording.tables
    first, need = int(tables.program_leaf[program]), int(tables.gate_need[gates_of_program(tables, program)[0]])
    inside: list[int] = []
    events = []
    for row in rows[1:]:
        leaf, on = int(row[kernels.EVENT_LEAF]), row[kernels.EVENT_ON] == 1.0
        # The leaves that the ray is in after the event
        inside = sorted({*inside, leaf}) if on else [each for each in inside if each != leaf]
        surface, face = recording.face_at(int(row[kernels.EVENT_PLACE]))
        events.append(
            SweepRow(
                float(row[kernels.EVENT_T]), surface, face, letter_of(leaf - first), on,
                "".join(letter_of(each - first) for each in inside), int(row[kernels.EVENT_COUNT]), need,
                row[kernels.EVENT_INSIDE] == 1.0,
            )
        )  # fmt: skip
    entered_letters, letters = (
        {row.letter for row in events},
        [letter_of(leaf - first) for leaf in leaves_of_program(tables, program)],
    )
    return Sweep(
        expression_of(tables, program), rows[0, kernels.EVENT_INSIDE] == 1.0, tuple(events),
        tuple(letter for letter in letters if letter not in entered_letters),
    )  # fmt: skip


# Steps of bodies of every kind: the crossings, by the numbers of the kernels, or the reason of a miss.

KINDS = {BALL: "ball", CELL: "solid", REGION: "Boolean", SHEET: "sheet", POLYGON: "polygon"}
"""Kind of entry -> its name in `BodyStep.kind`."""
MOST_LEAVES = 64
"""A Boolean of more leaves shows those alone that have events, at most so many."""


class BodySteps:
    """Computes the steps of bodies on one ray."""

    def __init__(self, recording: RayRecording, surfaces: SurfaceSteps, line: ExactRay) -> None:
        self.recording, self.surfaces, self.line = recording, surfaces, line

    def step(self, entry: int, known: BodyStep) -> BodyStep:
        """Return the step of a body whose ball the ray hits; `known` has its number, name and shape."""
        tables = self.recording.tables
        work = {BALL: self._ball, CELL: self._cell, REGION: self._region, SHEET: self._sheet, POLYGON: self._polygon}
        return work[int(tables.entry_kind[entry])](int(tables.entry_index[entry]), known)

    def _ball(self, surface: int, known: BodyStep) -> BodyStep:
        """Return the step of a ball."""
        step = self.surfaces[surface]
        ends = [(t, surface) for t in step.roots]
        why = self._outcome(ends) if ends else miss_outcome(step, self.line)
        return replace(known, surface=step, outcome=why, doubtful=step.doubtful)

    def _cell(self, cell: int, known: BodyStep) -> BodyStep:
        """Return the step of a body that is one cell."""
        recording = self.recording
        step = cell_step(recording, self.surfaces, cell, "", self.line)
        places = [end for span in recording.ends(recording.cell(cell)) for end in (span[:2], span[2:])]
        ends = [(t, recording.face_at(place)[0]) for t, place in places]
        return replace(known, cells=(step,), outcome=step.why or self._outcome(ends), doubtful=step.doubtful)

    def _outcome(self, ends: Sequence[tuple[float, int]]) -> str:
        """Return why none of some (t, surface) is a crossing; nothing if one is."""
        if any(self.recording.counts(t, surface) for t, surface in ends):
            return ""
        return STARTED if any(self.recording.is_start(t, surface) for t, surface in ends) else INTERVAL

    def _region(self, program: int, known: BodyStep) -> BodyStep:
        """Return the step of a Boolean body."""
        rows = self.recording.sweep(program)
        cells = self._leaves(program, rows)
        doubtful = any(cell.doubtful for cell in cells)
        sweep = sweep_of(self.recording, program, rows)
        return replace(known, cells=cells, sweep=sweep, outcome=BOOLEAN, doubtful=doubtful)

    def _leaves(self, program: int, rows: Any) -> tuple[CellStep, ...]:
        """Return the cells of a program; if they are very many, some of those with events."""
        tables = self.recording.tables
        leaves = list(leaves_of_program(tables, program))
        if len(leaves) > MOST_LEAVES:
            reached = {int(row[kernels.EVENT_LEAF]) for row in rows[1:]}
            leaves = sorted(reached)[:MOST_LEAVES]
        first = int(tables.program_leaf[program])
        return tuple(
            cell_step(
                self.recording, self.surfaces, int(cells_of_leaves(tables, leaf)), letter_of(leaf - first), self.line
            )
            for leaf in leaves
        )

    def _sheet(self, sheet: int, known: BodyStep) -> BodyStep:
        """Return the step of a sheet: roots of its surface that count, on the right side, where it is not cut away."""
        tables, recording = self.recording.tables, self.recording
        number, program = int(tables.sheet_surface[sheet]), int(tables.sheet_program[sheet])
        side, one_sided = int(tables.sheet_side[sheet]), tables.sheet_one_sided[sheet] == 1
        step = self.surfaces[number]
        outcomes = [] if step.roots else [PARALLEL if step.flat else miss_outcome(step, self.line)]
        # Does the surface's function fall at the first root? At the second it does the opposite
        falls = step.rate < 0 if step.flat else not step.outside
        for k, t in enumerate(step.roots):
            against = (falls != (k == 1)) == (side > 0)
            why = self._outcome([(t, number)])
            if not why and one_sided and not against:
                why = BEHIND
            elif not why and program >= 0 and not recording.holds(program, t):
                why = CLIPPED
            outcomes.append(why)
        sweep = None if program < 0 else sweep_of(recording, program, recording.sweep(program))
        cells = () if program < 0 else self._leaves(program, recording.sweep(program))
        outcome = "" if "" in outcomes else outcomes[-1]
        return replace(known, surface=step, cells=cells, sweep=sweep, outcome=outcome, doubtful=step.doubtful)

    def _polygon(self, polygon: int, known: BodyStep) -> BodyStep:
        """Return the step of a polygon: the root of its plane if it counts, within the outline, not cut away."""
        tables, recording = self.recording.tables, self.recording
        number, program = int(tables.polygon_surface[polygon]), int(tables.polygon_program[polygon])
        step = self.surfaces[number]
        inside, seen = recording.loop(polygon)
        outline = self._outline(polygon, inside, seen)
        why = self._outcome([(t, number) for t in step.roots]) if step.roots else PARALLEL
        if not why and not inside:
            why = OUTLINE
        elif not why and program >= 0 and not recording.holds(program, step.roots[0]):
            why = CLIPPED
        return replace(known, surface=step, outline=outline, outcome=why, doubtful=step.doubtful)

    def _outline(self, polygon: int, inside: bool, seen: Any) -> OutlineStep:
        """Return the corners in the view along the ray, and which edges are counted."""
        tables = self.recording.tables
        first, last = (int(tables.polygon_first[polygon + k]) for k in range(2))
        # The edge that ends at the first corner begins at the last one
        is_counted, before = [], float(seen[-1, kernels.SEEN_V])
        for row in seen:
            rises, side = float(row[kernels.SEEN_V]) > before, float(row[kernels.SEEN_SIDE])
            is_counted.append(row[kernels.SEEN_CHANGES] == 1.0 and (side > 0 if rises else side < 0))
            before = float(row[kernels.SEEN_V])
        corners = tuple((float(row[kernels.SEEN_U]), float(row[kernels.SEEN_V])) for row in seen)
        step = self.surfaces[int(tables.polygon_surface[polygon])]
        board = outline_board(tables.vertices[first:last].tolist(), step.polynomial, self.line)
        return OutlineStep(corners, tuple(is_counted), inside, board)


# Bodies that the tree leaves out: boxes by slabs, as in the ray tracing notes, and balls that the ray misses.


def box_test(box: Sequence[float], line: ExactRay) -> BoxTest:
    """Return the slab test of a box of six floats (low, high); axes along which it is infinite are left out."""
    ends = [(box[axis], box[axis + 3]) for axis in range(3)]
    slabs = [
        ("xyz"[k], Fraction(low), Fraction(high), line.origin[k], line.direction[k])
        for k, (low, high) in enumerate(ends)
        if math.isfinite(low) and math.isfinite(high)
    ]
    # The floats of the test; the board has the exact numbers
    near, far = line.t_min, line.t_max
    for _, low, high, at, slope in slabs:
        # A ray parallel to a slab is within it throughout, or never
        first, last = (-math.inf, math.inf) if low <= at <= high else (math.inf, -math.inf)
        if slope:
            first, last = sorted((as_float((low - at) / slope), as_float((high - at) / slope)))
        near, far = max(near, first), min(far, last)
    x, y, z, u, v, w = box
    return BoxTest((x, y, z), (u, v, w), near, far, solve_slabs(slabs, line))


def ball_test(ball: Sequence[float], line: ExactRay) -> BallTest:
    """Return the distance of the line from the center of a ball of four floats: center and radius."""
    x, y, z, radius = ball
    out = [o - c for o, c in zip(map(float, line.origin), (x, y, z), strict=True)]
    d = list(map(float, line.direction))
    length = math.hypot(*d)
    # Distance of a point from a line: |out × d| / |d|
    cross = (out[1] * d[2] - out[2] * d[1], out[2] * d[0] - out[0] * d[2], out[0] * d[1] - out[1] * d[0])
    return BallTest((x, y, z), radius, math.hypot(*cross) / length)


def box_miss_step(known: BodyStep, box: BoxTest) -> BodyStep:
    """Return the step of a body whose box the ray misses."""
    if box.low > box.high:
        why = "it is empty"
    elif box.near == math.inf or box.far == -math.inf:
        why = "the ray misses its box: it runs beside it, parallel to two of its sides"
    elif box.near > box.far:
        why = (
            f"the ray misses its box within the interval: t_near = {format_float(box.near)} "
            f"> t_far = {format_float(box.far)}"
        )
    else:
        why = "the ray misses its box"
    return _miss_step(known, BOX_MISSED, why, box, None)


def ball_miss_step(known: BodyStep, box: BoxTest, ball: BallTest) -> BodyStep:
    """Return the step of a body whose ball the ray misses."""
    if ball.distance > ball.radius:
        why = (
            f"the ray misses the ball around it: {format_float(ball.distance)} from "
            f"its center, radius {format_float(ball.radius)}"
        )
    else:
        why = "the ball around it lies outside the interval"
    return _miss_step(known, BALL_MISSED, why, box, ball)


def _miss_step(known: BodyStep, outcome: str, why: str, box: BoxTest, ball: BallTest | None) -> BodyStep:
    """Return the step of a body that the tree leaves out."""
    return BodyStep(known.body, known.name, known.shape, known.kind, outcome, why, box=box, ball=ball)


# Outcomes of bodies, and their sentences.

_OUTCOME_WORDS = {
    NO_ROOT: "the discriminant is negative: there is no real root",
    TOUCHED: "the ray only touches it, which counts as a miss",
    PLANES: "no part of the ray is inside all of its faces",
    INTERVAL: "its crossings lie outside the interval of t",
    BOOLEAN: "the Boolean's value does not change within the interval, whichever parts the ray crosses",
    OUTLINE: "the ray crosses its plane outside its outline",
    CLIPPED: "the ray crosses its surface where that has been cut away",
    PARALLEL: "the ray is parallel to its plane",
    BEHIND: "it is one-sided and seen from behind",
    INSIDE: "the ray is inside all along, and crosses nothing",
    STARTED: "the ray starts on it; that crossing is left out, and there is no other",
}


def finish_step(
    step: BodyStep, crossings: Sequence[Crossing], spans: Mapping[int, Sequence[Span]], first: Crossing
) -> BodyStep:
    """Return a step with the results of the queries, its outcome and its sentence.

    `crossings` and `spans` are those of all bodies; `first` is the first hit.
    """
    own = tuple(one for one in crossings if one.body == step.body)
    inside = tuple(spans.get(step.body, ()))
    if step.outcome in (BOX_MISSED, BALL_MISSED):
        return replace(step, crossings=own, spans=inside)
    outcome = step.outcome
    if own:
        outcome = HIT if first.body == step.body else CROSSED
    elif inside:
        outcome = INSIDE
    elif not outcome:  # a crossing by the float formulas, which were in doubt
        outcome = TOUCHED
    sentence = _crossings_text(own, outcome) if own else _OUTCOME_WORDS[outcome]
    return replace(step, outcome=outcome, sentence=sentence, crossings=own, spans=inside)


def merge_missed_step(bare_step: BodyStep, worked: BodyStep) -> BodyStep:
    """Return the step of a body that the tree leaves out, with the details that its own test gives."""
    why = _OUTCOME_WORDS.get(worked.outcome)
    sentence = f"{bare_step.sentence}; without the tree: {why}" if why else bare_step.sentence
    return replace(worked, outcome=bare_step.outcome, sentence=sentence, box=bare_step.box, ball=bare_step.ball)


def _crossings_text(crossings: Sequence[Crossing], outcome: str) -> str:
    """Return where a body is entered and left, in words."""
    parts = [
        f"{'entered' if one.entering else 'left'} at t = {format_float(one.t)} (face {one.face})" for one in crossings
    ]
    return ("first hit: " if outcome == HIT else "") + ", ".join(parts)
