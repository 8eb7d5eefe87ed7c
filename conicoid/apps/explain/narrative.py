"""An explanation in words: the blocks of a body, and those of the whole ray.

A body has its box, its surfaces, its cells, the sweep of a Boolean and its spans. The ray has its interval, the first
hit, the formulas that decided it, every body, and a table of all crossings.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from .document import Block, Citation, Heading, TextLine, TextTable
from .polynomial import ExactRay, format_float, format_fraction, format_vector
from .steps import (
    BodyStep,
    BoxTest,
    CellStep,
    Crossing,
    OutlineStep,
    RankedPlace,
    RayRecord,
    SurfaceStep,
    Sweep,
    SweepRow,
)

# The blocks of a body.

_CASES = (
    "", "c₁ c₂ b₁ b₂: miss", "c₁ b₁ c₂ b₂: hit body, exit cap", "c₁ b₁ b₂ c₂: hit body, exit body",
    "b₁ c₁ b₂ c₂: hit cap, exit body", "b₁ c₁ c₂ b₂: hit cap, exit cap", "b₁ b₂ c₁ c₂: miss",
)  # fmt: skip
"""`CellStep.case` -> its words in the Clemson notes."""


def body_blocks(step: BodyStep, found: RayRecord) -> Iterator[Block]:
    """Yield the blocks of a body: its outcome, and the details in the order of the file's docstring."""
    yield Heading(f"Body {step.body} “{step.title}”: {step.outcome}", 2)
    yield TextLine(f"{step.kind}: {step.shape}")
    yield TextLine(step.sentence)
    if step.box is not None:
        yield from _box(step.box, bool(step.cells and step.cells[0].board.blocks))
    if step.surface is not None:
        yield from surface_blocks(step.surface)
    if step.outline is not None:
        yield from _outline(step.outline)
    shown_surfaces: set[int] = set()
    for cell in step.cells:
        yield from _cell(cell, shown_surfaces, step.sweep is not None)
    if step.sweep is not None:
        yield from _sweep(step.sweep)
    if step.spans:
        spans = ", ".join(f"[{format_float(one.t_enter)}, {format_float(one.t_exit)}]" for one in step.spans)
        yield TextLine(f"inside for t in {spans}")


def _box(box: BoxTest, has_own_slabs: bool) -> Iterator[Block]:
    """Yield the box around a body and its slabs; without the slabs if the body is a box and shows its own."""
    yield TextLine(f"box {format_vector(box.low)} to {format_vector(box.high)}")
    if not has_own_slabs:
        yield from box.board.blocks


def surface_blocks(step: SurfaceStep, face: str = "") -> Iterator[Block]:
    """Yield a surface as the documents solve it, then as the kernels do; `face` names its face in front."""
    yield TextLine(f"{face}surface {step.number}, {step.kind}: {step.equation}")
    yield from step.board.blocks
    yield from _plane_in_kernels(step) if step.flat else _curved_in_kernels(step)
    if step.starts:
        yield TextLine(
            "the ray starts on this surface: its root t = 0 is removed, and −2b / a is left", Citation.STARTS, 2
        )
    if step.doubtful:
        yield TextLine("by its error bound this is in doubt", Citation.DOUBT, 2)


def _curved_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    """Yield the numbers of the kernels for a curved surface."""
    careful = ", in two floats since terms cancel" if step.careful else ""
    scaled = (
        f"a = {format_float(step.a)}, b = {format_float(step.b)}, c = {format_float(step.c)}, "
        f"b² − a c = {format_float(step.discriminant)}"
    )
    yield TextLine(
        f"the kernels, about the foot of the perpendicular at t = {format_float(step.foot)}{careful}:",
        Citation.MOMENT,
        2,
    )
    yield TextLine(f"a t² + 2 b t + c = 0: {scaled}", "", 3)
    if step.roots:
        low, high = step.roots
        yield TextLine(
            f"roots q / a and c / q, q = −(b + sign(b) √(b² − a c)): t = {format_float(low)} and {format_float(high)}",
            Citation.ROOTS,
            3,
        )
    where = "beyond its roots" if step.outside else "between its roots"
    if not step.roots:
        where = "everywhere" if step.outside else "nowhere"
    yield TextLine(f"its negative side is {where}", "", 3)


def _plane_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    """Yield the numbers of the kernels for a plane."""
    careful = ", in twice the precision since terms cancel" if step.careful else ""
    t = f", t = −height / rate = {format_float(step.roots[0])}" if step.roots else ""
    yield TextLine(
        f"the kernels: height {format_float(step.height)}, rate {format_float(step.rate)}{careful}{t}",
        Citation.MOMENT,
        2,
    )


def _outline(outline: OutlineStep) -> Iterator[Block]:
    """Yield the outline of a polygon: by even-odd in the documents, then by the kernels."""
    yield from outline.board.blocks
    yield TextLine(
        "the kernels, in the view along the ray (a shared edge is the same for both polygons):",
        "docs/theory.md, section 5",
        2,
    )
    rows = tuple(
        (str(k + 1), format_float(u), format_float(v), "counted" if is_counted else "")
        for k, ((u, v), is_counted) in enumerate(zip(outline.corners[:40], outline.counts[:40], strict=True))
    )
    yield TextTable(("corner", "u", "v", "the edge that ends there"), rows, "", 2)
    count = sum(outline.counts)
    yield TextLine(f"{count} crossings: {'inside' if outline.inside else 'outside'}", "", 2)


def _cell(cell: CellStep, shown_surfaces: set[int], in_boolean: bool) -> Iterator[Block]:
    """Yield a cell: its slabs, its faces, which crossings are true, and its spans.

    `shown_surfaces` holds the surfaces that were shown before, and gets those of this cell.
    """
    if in_boolean:
        yield Heading(f"Part {cell.letter}", 3)
    if cell.board.blocks:
        yield from cell.board.blocks
    for face in cell.faces:
        side = "within" if face.inside > 0 else "beyond"
        if face.surface.number in shown_surfaces:
            yield TextLine(f"face {face.face}, {side} surface {face.surface.number}, as above")
        else:
            shown_surfaces.add(face.surface.number)
            yield from surface_blocks(face.surface, f"face {face.face}, {side} ")
    # A surface is shown once for each body
    yield from _remainder(cell)


def _remainder(cell: CellStep) -> Iterator[Block]:
    """Yield the case, the true and false crossings, the slab of the planes and the spans of a cell."""
    if cell.case:
        yield TextLine(f"caps and body in order, case {cell.case}: {_CASES[cell.case]}", Citation.CAPS)
    if len(cell.faces) > 1 and cell.candidates:
        rows = tuple(
            (format_float(one.t), f"face {one.face}", "enters" if one.entering else "leaves",
             "true" if one.outside_of is None else _false_reason(one.outside_of))
            for one in cell.candidates
        )  # fmt: skip
        yield TextTable(("t", "crossing", "", "true or false"), rows, Citation.FALSE)
    if any(face.surface.flat for face in cell.faces):
        near, far = cell.slab
        empty = "" if near < far else ": empty"
        yield TextLine(f"its planes leave t from {format_float(near)} to {format_float(far)}{empty}")
    spans = ", ".join(f"[{format_float(a)}, {format_float(b)}]" for a, _, b, _ in cell.spans)
    yield TextLine(f"inside, on the whole line: {spans or 'nothing'}{f' ({cell.why})' if cell.why else ''}")


def _false_reason(face: int) -> str:
    """Return why a crossing is false: the face that it lies outside of, -1 on an edge."""
    return f"false: outside of face {face}" if face >= 0 else "false: on an edge"


def _sweep(sweep: Sweep) -> Iterator[Block]:
    """Yield the sweep of a Boolean along the ray: its expression and its events."""
    yield Heading("The Boolean along the ray", 3)
    yield TextLine(f"the body is {sweep.expression}", Citation.BOOLEAN)
    if sweep.unused_leaves:
        yield TextLine(
            f"never entered: {', '.join(sweep.unused_leaves[:40])}{' ...' if len(sweep.unused_leaves) > 40 else ''}"
        )
    yield TextLine(f"before all events: {'inside' if sweep.begins else 'outside'}")
    if sweep.rows:
        rows = tuple(_row(row) for row in sweep.rows[:60])
        head = "t", "surface", "part", "", "inside of", "counted", "the body"
        yield TextTable(head, rows, Citation.BOOLEAN)


def _row(row: SweepRow) -> tuple[str, ...]:
    """Return the cells of an event."""
    face = f"{row.surface}, face {row.face}" if row.surface >= 0 else "−"
    return (
        format_float(row.t), face, row.letter, "entered" if row.entering else "left", row.inside or "−",
        f"{row.count} of {row.need}", "inside" if row.value else "outside",
    )  # fmt: skip


# The blocks of the ray.

_MOST_ROWS, _MOST_BODIES = 60, 12
"""Rows of a table, and bodies that are shown in full."""
_HOW = {
    "certified": "numbers in two floats that carry their error bounds",
    "exact": "exact arithmetic, since error bounds left it open",
}
"""`Decision.first` and `Decision.all` in words, where floats did not decide."""


def blocks_of(found: RayRecord) -> Iterator[Block]:
    """Yield the blocks of an explanation: the ray, the first hit, the decision, every body, and all crossings."""
    yield Heading("The ray")
    yield TextLine(f"p(t) = o + t d,  o = {format_vector(found.origin)},  d = {format_vector(found.direction)}")
    yield TextLine(
        f"interval {format_float(found.t_min)} < t < {format_float(found.t_max)}, t in units of |d|{_length(found)}"
    )
    yield Heading("The answer")
    yield from _answer(found)
    yield from _decision(found)
    full = _full_bodies(found)
    for step in found.bodies:
        if step.body in full:
            yield from body_blocks(step, found)
    if len(full) < len(found.bodies):
        yield Heading("Other bodies", 2)
        yield TextLine("in short; `body=` selects one to be explained in full")
        rows = tuple((_name(found, step.body), step.sentence) for step in found.bodies if step.body not in full)
        yield TextTable(("body", "outcome"), rows)
    if found.misses:
        yield Heading("Left out", 2)
        yield TextLine(
            f"the tree of boxes leaves out {found.misses:,} more bodies: the ray misses the boxes around them"
        )
    if len(found.crossings) > 1:
        yield Heading("Along the ray")
        yield _crossing_table(found)


def _full_bodies(found: RayRecord) -> set[int]:
    """Return the numbers of the bodies that are shown in full: all, or the first ones of many in the order of hits."""
    # Reversed, so that the first crossing of a body is the one that stays
    first = {one.body: one.t for one in reversed(found.crossings)}
    order = sorted(found.bodies, key=lambda step: (step.body != int(found.hit.body), first.get(step.body, math.inf)))
    return {step.body for step in order[:_MOST_BODIES]}


def _length(found: RayRecord) -> str:
    """Return the squared length of the direction in words; nothing for a unit vector."""
    square = ExactRay.of(found.origin, found.direction, 0.0, 1.0).square
    return "" if square == 1 else f" (d·d = {format_fraction(square)})"


def _answer(found: RayRecord) -> Iterator[Block]:
    """Yield the first hit with its point and normal, or the miss."""
    hit = found.hit
    if not hit.hit:
        yield TextLine("nothing is hit: t = ∞")
        return
    verb = "enters" if hit.entering else "leaves"
    name = _name(found, int(hit.body))
    yield TextLine(f"{verb} {name} at t = {format_float(float(hit.t))}, face {hit.face}, surface {hit.surface}")
    yield TextLine(f"point o + t d = {format_vector(hit.point.tolist())}")
    yield from _normal(found)


def _normal(found: RayRecord) -> Iterator[Block]:
    """Yield the outward normal at the first hit; of a curved surface with its gradient."""
    hit, step = found.hit, found.surfaces.get(int(found.hit.surface))
    normal = format_vector(hit.normal.tolist())
    if step is None or step.flat:
        yield TextLine(f"outward normal {normal}")
        return
    ray = ExactRay.of(found.origin, found.direction, found.t_min, found.t_max)
    # The gradient is that at the reported t, in exact arithmetic
    half = step.polynomial.half_gradient(ray.at(float(hit.t)))
    if step.kind == "sphere":
        yield TextLine(f"outward normal (p − S) / r = {normal}", Citation.SPHERE_ALGEBRAIC)
    else:
        gradient = f"half the gradient (Ax + By + Cz + D, Bx + Ey + Fz + G, Cx + Fy + Hz + I) = {format_vector(half)}"
        yield TextLine(gradient, Citation.NORMAL)
        yield TextLine(f"made unit and outward {normal}")


def _name(found: RayRecord, number: int) -> str:
    """Return the number and the name of a body; the number alone if the explanation has no step of it."""
    for step in found.bodies:
        if step.body == number:
            return f"body {number} “{step.title}”"
    return f"body {number}"


def _decision(found: RayRecord) -> Iterator[Block]:
    """Yield which formulas decided, with which bound; for a doubtful ray also the order of all crossings."""
    decision = found.decision
    bound = f": |t − t*| ≤ {decision.t_error:.2e}" if decision.t_error else ": t is exact"
    bound = bound if found.hit.hit else ""
    if decision.first == "floats":
        yield TextLine(f"decided by the float formulas, whose error bounds leave no doubt{bound}", Citation.DOUBT)
    else:
        yield TextLine(
            f"the float formulas leave it in doubt; decided by {_HOW[decision.first]}{bound}", Citation.DOUBT
        )
    if decision.all != decision.first:
        yield TextLine(f"crossings behind it are in doubt; decided by {_HOW[decision.all]}", Citation.DOUBT)
    if decision.places:
        rows = tuple(_place(place) for place in decision.places[:_MOST_ROWS])
        yield TextTable(("order", "surface", "certainly at", "± at most", "reported t"), rows, Citation.DOUBT)


def _place(place: RankedPlace) -> tuple[str, ...]:
    """Return the cells of a ranked crossing."""
    low = f" {'+' if place.low >= 0 else '−'} {abs(place.low):.3g}" if place.low else ""
    certain = f"{format_float(place.high)}{low}"
    return str(place.rank), f"surface {place.surface}", certain, f"{place.error:.1e}", format_float(place.t)


def _crossing_table(found: RayRecord) -> TextTable:
    """Return the table of all crossings."""
    rows = tuple(_crossing(one, found) for one in found.crossings[:_MOST_ROWS])
    return TextTable(("t", "± at most", "body", "", "face", "surface"), rows, Citation.DOUBT)


def _crossing(one: Crossing, found: RayRecord) -> tuple[str, ...]:
    """Return the cells of a crossing."""
    enters = "enters" if one.entering else "leaves"
    return format_float(one.t), f"{one.t_error:.1e}", _name(found, one.body), enters, str(one.face), str(one.surface)
