"""What is told of a body: its box, its surfaces, its cells, the sweep, its crossings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from . import sources
from .document import Block, Heading, TextLine, TextTable
from .polynomial import format_float, format_fraction, format_vector
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

_CASES = (
    "", "c₁ c₂ b₁ b₂: miss", "c₁ b₁ c₂ b₂: hit body, exit cap", "c₁ b₁ b₂ c₂: hit body, exit body",
    "b₁ c₁ b₂ c₂: hit cap, exit body", "b₁ c₁ c₂ b₂: hit cap, exit cap", "b₁ b₂ c₁ c₂: miss",
)  # fmt: skip


def body_blocks(step: BodyStep, found: RayRecord) -> Iterator[Block]:
    """A body met or missed, and why."""
    yield Heading(f"Body {step.body} “{step.name}”: {step.outcome}", 2)
    yield TextLine(f"{step.kind}: {step.shape}")
    yield TextLine(step.told)
    if step.box is not None:
        yield from _box(step.box, bool(step.cells and step.cells[0].board.blocks))
    if step.surface is not None:
        yield from surface_blocks(step.surface)
    if step.outline is not None:
        yield from _outline(step.outline)
    told_of: set[int] = set()
    for cell in step.cells:
        yield from _cell(cell, told_of, step.sweep is not None)
    if step.sweep is not None:
        yield from _sweep(step.sweep)
    if step.floats != step.crossings:
        yield TextLine(f"by the float formulas alone it would be: {_crossed(step.floats)}", sources.DOUBT)
    if step.spans:
        spans = ", ".join(f"[{format_float(one.t_enter)}, {format_float(one.t_exit)}]" for one in step.spans)
        yield TextLine(f"inside for t in {spans}")


def _crossed(crossings: Sequence[object]) -> str:
    return ", ".join(format_float(one.t) for one in crossings) or "not crossed"  # type: ignore[attr-defined]


def _box(box: BoxTest, told_again: bool) -> Iterator[Block]:
    """The slabs of a box around a body, unless they are told of the body itself."""
    yield TextLine(f"box {format_vector(box.low)} to {format_vector(box.high)}")
    if not told_again:
        yield from box.board.blocks


def surface_blocks(step: SurfaceStep, face: str = "") -> Iterator[Block]:
    """A surface, of a face: as the documents work it out, and as the kernels do."""
    yield TextLine(f"{face}surface {step.number}, {step.kind}: {step.equation}")
    yield from step.board.blocks
    yield from _plane_in_kernels(step) if step.flat else _curved_in_kernels(step)
    if step.starts:
        yield TextLine(
            "the ray starts on this surface: its root t = 0 is removed, and −2b / a is left", sources.STARTS, 2
        )
    if step.doubtful:
        yield TextLine("by its error bound this is in doubt", sources.DOUBT, 2)


def _curved_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    careful = ", in two floats since terms cancel" if step.careful else ""
    scaled = (
        f"a = {format_float(step.a)}, b = {format_float(step.b)}, c = {format_float(step.c)}, "
        f"b² − a c = {format_float(step.discriminant)}"
    )
    yield TextLine(
        f"the kernels, about the foot of the perpendicular at t = {format_float(step.foot)}{careful}:",
        sources.MOMENT,
        2,
    )
    yield TextLine(f"a t² + 2 b t + c = 0: {scaled}", "", 3)
    if step.roots:
        low, high = step.roots
        yield TextLine(
            f"roots q / a and c / q, q = −(b + sign(b) √(b² − a c)): t = {format_float(low)} and {format_float(high)}",
            sources.ROOTS,
            3,
        )
    where = "beyond its roots" if step.outside else "between its roots"
    if not step.roots:
        where = "all along" if step.outside else "nowhere"
    yield TextLine(f"its negative side is {where}", "", 3)


def _plane_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    careful = ", in twice the precision since terms cancel" if step.careful else ""
    t = f", t = −height / rate = {format_float(step.roots[0])}" if step.roots else ""
    yield TextLine(
        f"the kernels: height {format_float(step.height)}, rate {format_float(step.rate)}{careful}{t}",
        sources.MOMENT,
        2,
    )


def _outline(outline: OutlineStep) -> Iterator[Block]:
    yield from outline.board.blocks
    yield TextLine(
        "the kernels, in the view along the ray, so that a shared edge is seen alike:", "docs/theory.md, section 5", 2
    )
    rows = tuple(
        (str(k + 1), format_float(u), format_float(v), "counted" if counted else "")
        for k, ((u, v), counted) in enumerate(zip(outline.corners[:40], outline.counted[:40], strict=True))
    )
    yield TextTable(("corner", "u", "v", "the edge that ends there"), rows, "", 2)
    count = sum(outline.counted)
    yield TextLine(f"{count} crossings: {'inside' if outline.inside else 'outside'}", "", 2)


def _cell(cell: CellStep, told_of: set[int], in_boolean: bool) -> Iterator[Block]:
    """A cell: its faces, which crossings are true, and what is left."""
    if in_boolean:
        yield Heading(f"Part {cell.letter}", 3)
    if cell.board.blocks:
        yield from cell.board.blocks
    for face in cell.faces:
        side = "within" if face.inside > 0 else "beyond"
        if face.surface.number in told_of:
            yield TextLine(f"face {face.face}, {side} surface {face.surface.number}, as above")
        else:
            told_of.add(face.surface.number)
            yield from surface_blocks(face.surface, f"face {face.face}, {side} ")
    yield from _left(cell)


def _left(cell: CellStep) -> Iterator[Block]:
    """What is left of the ray in a cell."""
    if cell.case:
        yield TextLine(f"caps and body in order, case {cell.case}: {_CASES[cell.case]}", sources.CAPS)
    if len(cell.faces) > 1 and cell.candidates:
        rows = tuple(
            (format_float(one.t), f"face {one.face}", "enters" if one.entering else "leaves",
             "true" if one.outside_of is None else _false(one.outside_of))
            for one in cell.candidates
        )  # fmt: skip
        yield TextTable(("t", "crossing", "", "true or false"), rows, sources.FALSE)
    if any(face.surface.flat for face in cell.faces):
        near, far = cell.slab
        empty = "" if near < far else ": empty"
        yield TextLine(f"its planes leave t from {format_float(near)} to {format_float(far)}{empty}")
    spans = ", ".join(f"[{format_float(a)}, {format_float(b)}]" for a, _, b, _ in cell.spans)
    yield TextLine(f"inside, on the whole line: {spans or 'nothing'}{f' ({cell.why})' if cell.why else ''}")


def _false(face: int) -> str:
    return f"false: outside of face {face}" if face >= 0 else "false: on an edge"


def _sweep(sweep: Sweep) -> Iterator[Block]:
    """The Boolean along the ray."""
    yield Heading("The Boolean along the ray", 3)
    yield TextLine(f"the body is {sweep.expression}", sources.BOOLEAN)
    if sweep.left_out:
        yield TextLine(f"never entered: {', '.join(sweep.left_out[:40])}{' ...' if len(sweep.left_out) > 40 else ''}")
    yield TextLine(f"before everything: {'inside' if sweep.begins else 'outside'}")
    if sweep.rows:
        rows = tuple(_row(row) for row in sweep.rows[:60])
        head = "t", "surface", "part", "", "inside of", "counted", "the body"
        yield TextTable(head, rows, sources.BOOLEAN)


def _row(row: SweepRow) -> tuple[str, ...]:
    face = f"{row.surface}, face {row.face}" if row.surface >= 0 else "−"
    return (
        format_float(row.t), face, row.letter, "entered" if row.entering else "left", row.inside or "−",
        f"{row.count} of {row.need}", "inside" if row.value else "outside",
    )  # fmt: skip


# An explanation in words: which blocks are told, in which order.

_MOST_ROWS, _MOST_BODIES = 60, 12
_HOW = {
    "certified": "numbers in two floats that carry their error bounds",
    "exact": "exact arithmetic, since error bounds left it open",
}


def blocks_of(found: RayRecord) -> Iterator[Block]:
    """The ray, the answer, what decided it, every body, and all that is along the ray."""
    yield Heading("The ray")
    yield TextLine(f"p(t) = o + t d,  o = {format_vector(found.origin)},  d = {format_vector(found.direction)}")
    yield TextLine(
        f"asked for {format_float(found.t_min)} < t < {format_float(found.t_max)}, t in units of |d|{_length(found)}"
    )
    yield Heading("The answer")
    yield from _answer(found)
    yield from _decision(found)
    whole = _told_whole(found)
    for step in found.bodies:
        if step.body in whole:
            yield from body_blocks(step, found)
    if len(whole) < len(found.bodies):
        yield Heading("Other bodies", 2)
        yield TextLine("in short; `body=` names one that is to be told whole")
        rows = tuple((_name(found, step.body), step.told) for step in found.bodies if step.body not in whole)
        yield TextTable(("body", "what happens"), rows)
    if found.missed:
        yield Heading("Left out", 2)
        yield TextLine(
            f"the tree of boxes leaves out {found.missed:,} more bodies: the ray misses the boxes around them"
        )
    if len(found.crossings) > 1:
        yield Heading("Along the ray")
        yield _along(found)


def _told_whole(found: RayRecord) -> set[int]:
    """The bodies whose working is told: all, or of many those that are met first, and then those that are not."""
    first = {one.body: one.t for one in reversed(found.crossings)}
    order = sorted(found.bodies, key=lambda step: (step.body != int(found.hit.body), first.get(step.body, math.inf)))
    return {step.body for step in order[:_MOST_BODIES]}


def _length(found: RayRecord) -> str:
    from .polynomial import ExactRay as Ray

    square = Ray.of(found.origin, found.direction, 0.0, 1.0).square
    return "" if square == 1 else f" (d·d = {format_fraction(square)})"


def _answer(found: RayRecord) -> Iterator[Block]:
    """The first hit, with its point and normal."""
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
    hit, step = found.hit, found.surfaces.get(int(found.hit.surface))
    normal = format_vector(hit.normal.tolist())
    if step is None or step.flat:
        yield TextLine(f"outward normal {normal}")
        return
    from .polynomial import ExactRay as Ray

    ray = Ray.of(found.origin, found.direction, found.t_min, found.t_max)
    half = step.polynomial.half_gradient(ray.at(float(hit.t)))
    if step.kind == "sphere":
        yield TextLine(f"outward normal (p − S) / r = {normal}", sources.SPHERE_ALGEBRAIC)
    else:
        gradient = f"half the gradient (Ax + By + Cz + D, Bx + Ey + Fz + G, Cx + Fy + Hz + I) = {format_vector(half)}"
        yield TextLine(gradient, sources.NORMAL)
        yield TextLine(f"made unit and outward {normal}")


def _name(found: RayRecord, number: int) -> str:
    for step in found.bodies:
        if step.body == number:
            return f"body {number} “{step.name}”"
    return f"body {number}"


def _decision(found: RayRecord) -> Iterator[Block]:
    """Which formulas decided, with what bound; of a doubtful ray the order of all crossings."""
    decision = found.decision
    bound = f": |t − t*| ≤ {decision.t_error:.2e}" if decision.t_error else ": t is exact"
    bound = bound if found.hit.hit else ""
    if decision.first == "floats":
        yield TextLine(
            f"decided by the float formulas, which their error bounds leave no doubt of{bound}", sources.DOUBT
        )
    else:
        yield TextLine(f"the float formulas leave it in doubt; decided by {_HOW[decision.first]}{bound}", sources.DOUBT)
    if decision.all != decision.first:
        yield TextLine(f"what comes after it is in doubt; decided by {_HOW[decision.all]}", sources.DOUBT)
    if decision.places:
        rows = tuple(_place(place, found) for place in decision.places[:_MOST_ROWS])
        yield TextTable(("order", "surface", "certainly at", "± at most", "told as t"), rows, sources.DOUBT)


def _place(place: RankedPlace, found: RayRecord) -> tuple[str, ...]:
    low = f" {'+' if place.low >= 0 else '−'} {abs(place.low):.3g}" if place.low else ""
    certain = f"{format_float(place.high)}{low}"
    return str(place.rank), f"surface {place.surface}", certain, f"{place.error:.1e}", format_float(place.t)


def _along(found: RayRecord) -> TextTable:
    rows = tuple(_crossing(one, found) for one in found.crossings[:_MOST_ROWS])
    return TextTable(("t", "± at most", "body", "", "face", "surface"), rows, sources.DOUBT)


def _crossing(one: Crossing, found: RayRecord) -> tuple[str, ...]:
    enters = "enters" if one.entering else "leaves"
    return format_float(one.t), f"{one.t_error:.1e}", _name(found, one.body), enters, str(one.face), str(one.surface)
