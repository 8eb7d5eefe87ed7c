"""What is told of a body: its box, its surfaces, its cells, the sweep, its crossings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from . import sources
from .blocks import Block, Heading, Line, Table
from .numbers import told, vector
from .steps import BodyStep, BoxTest, CellStep, OutlineStep, SurfaceStep, Sweep, SweepRow

if TYPE_CHECKING:
    from .explanation import Explanation

_CASES = (
    "", "c₁ c₂ b₁ b₂: miss", "c₁ b₁ c₂ b₂: hit body, exit cap", "c₁ b₁ b₂ c₂: hit body, exit body",
    "b₁ c₁ b₂ c₂: hit cap, exit body", "b₁ c₁ c₂ b₂: hit cap, exit cap", "b₁ b₂ c₁ c₂: miss",
)  # fmt: skip


def body_blocks(step: BodyStep, found: Explanation) -> Iterator[Block]:
    """A body met or missed, and why."""
    yield Heading(f"Body {step.body} “{step.name}”: {step.outcome}", 2)
    yield Line(f"{step.kind}: {step.shape}")
    yield Line(step.told)
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
        yield Line(f"by the float formulas alone it would be: {_crossed(step.floats)}", sources.DOUBT)
    if step.spans:
        spans = ", ".join(f"[{told(one.t_enter)}, {told(one.t_exit)}]" for one in step.spans)
        yield Line(f"inside for t in {spans}")


def _crossed(crossings: Sequence[object]) -> str:
    return ", ".join(told(one.t) for one in crossings) or "not crossed"  # type: ignore[attr-defined]


def _box(box: BoxTest, told_again: bool) -> Iterator[Block]:
    """The slabs of a box around a body, unless they are told of the body itself."""
    yield Line(f"box {vector(box.low)} to {vector(box.high)}")
    if not told_again:
        yield from box.board.blocks


def surface_blocks(step: SurfaceStep, face: str = "") -> Iterator[Block]:
    """A surface, of a face: as the documents work it out, and as the kernels do."""
    yield Line(f"{face}surface {step.number}, {step.kind}: {step.equation}")
    yield from step.board.blocks
    yield from _plane_in_kernels(step) if step.flat else _curved_in_kernels(step)
    if step.starts:
        yield Line("the ray starts on this surface: its root t = 0 is removed, and −2b / a is left", sources.STARTS, 2)
    if step.doubtful:
        yield Line("by its error bound this is in doubt", sources.DOUBT, 2)


def _curved_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    careful = ", in two floats since terms cancel" if step.careful else ""
    scaled = f"a = {told(step.a)}, b = {told(step.b)}, c = {told(step.c)}, b² − a c = {told(step.discriminant)}"
    yield Line(
        f"the kernels, about the foot of the perpendicular at t = {told(step.foot)}{careful}:", sources.MOMENT, 2
    )
    yield Line(f"a t² + 2 b t + c = 0: {scaled}", "", 3)
    if step.roots:
        low, high = step.roots
        yield Line(f"roots q / a and c / q, q = −(b + sign(b) √(b² − a c)): t = {told(low)} and {told(high)}",
                   sources.ROOTS, 3)  # fmt: skip
    where = "beyond its roots" if step.outside else "between its roots"
    if not step.roots:
        where = "all along" if step.outside else "nowhere"
    yield Line(f"its negative side is {where}", "", 3)


def _plane_in_kernels(step: SurfaceStep) -> Iterator[Block]:
    careful = ", in twice the precision since terms cancel" if step.careful else ""
    t = f", t = −height / rate = {told(step.roots[0])}" if step.roots else ""
    yield Line(f"the kernels: height {told(step.height)}, rate {told(step.rate)}{careful}{t}", sources.MOMENT, 2)


def _outline(outline: OutlineStep) -> Iterator[Block]:
    yield from outline.board.blocks
    yield Line(
        "the kernels, in the view along the ray, so that a shared edge is seen alike:", "docs/theory.md, section 5", 2
    )
    rows = tuple(
        (str(k + 1), told(u), told(v), "counted" if counted else "")
        for k, ((u, v), counted) in enumerate(zip(outline.corners[:40], outline.counted[:40], strict=True))
    )
    yield Table(("corner", "u", "v", "the edge that ends there"), rows, "", 2)
    count = sum(outline.counted)
    yield Line(f"{count} crossings: {'inside' if outline.inside else 'outside'}", "", 2)


def _cell(cell: CellStep, told_of: set[int], in_boolean: bool) -> Iterator[Block]:
    """A cell: its faces, which crossings are true, and what is left."""
    if in_boolean:
        yield Heading(f"Part {cell.letter}", 3)
    if cell.board.blocks:
        yield from cell.board.blocks
    for face in cell.faces:
        side = "within" if face.inside > 0 else "beyond"
        if face.surface.number in told_of:
            yield Line(f"face {face.face}, {side} surface {face.surface.number}, as above")
        else:
            told_of.add(face.surface.number)
            yield from surface_blocks(face.surface, f"face {face.face}, {side} ")
    yield from _left(cell)


def _left(cell: CellStep) -> Iterator[Block]:
    """What is left of the ray in a cell."""
    if cell.case:
        yield Line(f"caps and body in order, case {cell.case}: {_CASES[cell.case]}", sources.CAPS)
    if len(cell.faces) > 1 and cell.candidates:
        rows = tuple(
            (told(one.t), f"face {one.face}", "enters" if one.entering else "leaves",
             "true" if one.outside_of is None else _false(one.outside_of))
            for one in cell.candidates
        )  # fmt: skip
        yield Table(("t", "crossing", "", "true or false"), rows, sources.FALSE)
    if any(face.surface.flat for face in cell.faces):
        near, far = cell.slab
        empty = "" if near < far else ": empty"
        yield Line(f"its planes leave t from {told(near)} to {told(far)}{empty}")
    spans = ", ".join(f"[{told(a)}, {told(b)}]" for a, _, b, _ in cell.spans)
    yield Line(f"inside, on the whole line: {spans or 'nothing'}{f' ({cell.why})' if cell.why else ''}")


def _false(face: int) -> str:
    return f"false: outside of face {face}" if face >= 0 else "false: on an edge"


def _sweep(sweep: Sweep) -> Iterator[Block]:
    """The Boolean along the ray."""
    yield Heading("The Boolean along the ray", 3)
    yield Line(f"the body is {sweep.expression}", sources.BOOLEAN)
    if sweep.left_out:
        yield Line(f"never entered: {', '.join(sweep.left_out[:40])}{' ...' if len(sweep.left_out) > 40 else ''}")
    yield Line(f"before everything: {'inside' if sweep.begins else 'outside'}")
    if sweep.rows:
        rows = tuple(_row(row) for row in sweep.rows[:60])
        head = "t", "surface", "part", "", "inside of", "counted", "the body"
        yield Table(head, rows, sources.BOOLEAN)


def _row(row: SweepRow) -> tuple[str, ...]:
    face = f"{row.surface}, face {row.face}" if row.surface >= 0 else "−"
    return (
        told(row.t), face, row.letter, "entered" if row.entering else "left", row.inside or "−",
        f"{row.count} of {row.need}", "inside" if row.value else "outside",
    )  # fmt: skip
