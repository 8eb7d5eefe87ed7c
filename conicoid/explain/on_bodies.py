"""Steps of bodies of every kind: what is met, by the kernels' numbers, and why what is not met is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..engine.programs import cells_of_leaves, leaves_of_program
from ..engine.queries import recorded as kernels
from ..engine.tables import BALL, CELL, POLYGON, REGION, SHEET
from .line import Line
from .on_cells import cell_step, touched_or_not
from .on_regions import letter_of, region_crossings, sweep_of
from .on_surfaces import Surfaces
from .outlines import outline_board
from .recording import Recording
from .steps import (
    BEHIND,
    BOOLEAN,
    CLIPPED,
    INSIDE,
    INTERVAL,
    OUTLINE,
    PARALLEL,
    STARTED,
    BodyStep,
    CellStep,
    Crossing,
    OutlineStep,
    Span,
)

KINDS = {BALL: "ball", CELL: "solid", REGION: "Boolean", SHEET: "sheet", POLYGON: "polygon"}
MOST_LEAVES = 64
"""Leaves of a Boolean that are shown one by one."""


class Bodies:
    """Works bodies out, one after the other."""

    def __init__(self, recording: Recording, surfaces: Surfaces, line: Line) -> None:
        self.recording, self.surfaces, self.line = recording, surfaces, line

    def step(self, entry: int, known: BodyStep) -> BodyStep:
        """A body that the walk reaches; `known` has its number, name and shape."""
        tables = self.recording.tables
        work = {BALL: self._ball, CELL: self._cell, REGION: self._region, SHEET: self._sheet, POLYGON: self._polygon}
        return work[int(tables.entry_kind[entry])](int(tables.entry_index[entry]), known)

    def _ball(self, surface: int, known: BodyStep) -> BodyStep:
        step = self.surfaces[surface]
        ends = [(step.roots[0], 0, surface, step.roots[1], 0, surface)] if step.roots else []
        why = "" if ends else touched_or_not(step, self.line)
        return self._met(replace(known, surface=step, doubtful=step.doubtful), ends, why)

    def _cell(self, cell: int, known: BodyStep) -> BodyStep:
        recording = self.recording
        step = cell_step(recording, self.surfaces, cell, "", self.line)
        ends = [
            (t_in, *reversed(recording.face_at(p)), t_out, *reversed(recording.face_at(q)))
            for t_in, p, t_out, q in recording.ends(recording.cell(cell))
        ]
        return self._met(replace(known, cells=(step,), doubtful=step.doubtful), ends, step.why)

    def _met(self, known: BodyStep, ends: Sequence[tuple[Any, ...]], why: str) -> BodyStep:
        """With the crossings of spans (t, face, surface, t, face, surface) of the whole line that count."""
        recording = self.recording
        found, inside, started = [], False, False
        for t_in, face_in, at_in, t_out, face_out, at_out in ends:
            inside ^= t_in <= recording.t_min < t_out
            for t, face, surface, entering in ((t_in, face_in, at_in, True), (t_out, face_out, at_out, False)):
                if recording.counts(t, surface):
                    found.append(Crossing(t, known.body, face, surface, entering))
                elif recording.is_start(t, surface):
                    started = True
                    inside ^= recording.t_min < t < recording.t_max
        if not why and not found:
            why = INSIDE if inside else (STARTED if started else INTERVAL)
        return replace(known, floats=tuple(found), spans=self.spans(found, inside), outcome=why)

    def spans(self, crossings: Sequence[Crossing], inside: bool) -> tuple[Span, ...]:
        """The stretches between crossings that are inside, clipped to the interval."""
        found, enter, clipped = [], self.recording.t_min, True
        for one in crossings:
            if inside:
                found.append(Span(enter, one.t, clipped, False))
            inside, enter, clipped = not inside, one.t, False
        if inside:
            found.append(Span(enter, self.recording.t_max, clipped, True))
        return tuple(found)

    def _region(self, program: int, known: BodyStep) -> BodyStep:
        rows = self.recording.sweep(program)
        crossings, inside = region_crossings(self.recording, known.body, program, rows)
        cells = self._leaves(program, rows)
        why = "" if crossings else (INSIDE if inside else BOOLEAN)
        doubtful = any(cell.doubtful for cell in cells)
        return replace(
            known, cells=cells, sweep=sweep_of(self.recording, program, rows), floats=tuple(crossings),
            spans=self.spans(crossings, inside), outcome=why, doubtful=doubtful,
        )  # fmt: skip

    def _leaves(self, program: int, rows: Any) -> tuple[CellStep, ...]:
        """The cells of a program, those that have events first where there are very many."""
        tables = self.recording.tables
        leaves = list(leaves_of_program(tables, program))
        if len(leaves) > MOST_LEAVES:
            met = {int(row[kernels.EVENT_LEAF]) for row in rows[1:]}
            leaves = sorted(met)[:MOST_LEAVES]
        first = int(tables.program_leaf[program])
        return tuple(
            cell_step(
                self.recording, self.surfaces, int(cells_of_leaves(tables, leaf)), letter_of(leaf - first), self.line
            )
            for leaf in leaves
        )

    def _sheet(self, sheet: int, known: BodyStep) -> BodyStep:
        tables, recording = self.recording.tables, self.recording
        number, program = int(tables.sheet_surface[sheet]), int(tables.sheet_program[sheet])
        side, one_sided = int(tables.sheet_side[sheet]), tables.sheet_one_sided[sheet] == 1
        step = self.surfaces[number]
        found, why = [], PARALLEL if step.flat else touched_or_not(step, self.line)
        falls = step.rate < 0 if step.flat else not step.outside
        for k, t in enumerate(step.roots):
            against = (falls != (k == 1)) == (side > 0)
            if not recording.counts(t, number):
                why = STARTED if recording.is_start(t, number) else INTERVAL
            elif one_sided and not against:
                why = BEHIND
            elif program >= 0 and not recording.holds(program, t):
                why = CLIPPED
            else:
                found.append(Crossing(t, known.body, 0, number, against))
        sweep = None if program < 0 else sweep_of(recording, program, recording.sweep(program))
        cells = () if program < 0 else self._leaves(program, recording.sweep(program))
        return replace(
            known, surface=step, cells=cells, sweep=sweep, floats=tuple(found), outcome="" if found else why,
            doubtful=step.doubtful,
        )  # fmt: skip

    def _polygon(self, polygon: int, known: BodyStep) -> BodyStep:
        tables, recording = self.recording.tables, self.recording
        number, program = int(tables.polygon_surface[polygon]), int(tables.polygon_program[polygon])
        step = self.surfaces[number]
        inside, seen = recording.loop(polygon)
        outline = self._outline(polygon, inside, seen)
        t = step.roots[0] if step.roots else math.nan
        found, why = [], ""
        if not step.roots:
            why = PARALLEL
        elif not recording.counts(t, number):
            why = STARTED if recording.is_start(t, number) else INTERVAL
        elif not inside:
            why = OUTLINE
        elif program >= 0 and not recording.holds(program, t):
            why = CLIPPED
        else:
            against = (step.rate < 0) == (int(tables.polygon_side[polygon]) > 0)
            found.append(Crossing(t, known.body, 0, number, against))
        return replace(
            known, surface=step, outline=outline, floats=tuple(found), outcome=why, doubtful=step.doubtful,
        )  # fmt: skip

    def _outline(self, polygon: int, inside: bool, seen: Any) -> OutlineStep:
        """The corners as the ray sees them, and which edges are counted."""
        tables = self.recording.tables
        first, last = (int(tables.polygon_first[polygon + k]) for k in range(2))
        counted, before = [], float(seen[-1, kernels.SEEN_V])
        for row in seen:
            rises, side = float(row[kernels.SEEN_V]) > before, float(row[kernels.SEEN_SIDE])
            counted.append(row[kernels.SEEN_CHANGES] == 1.0 and (side > 0 if rises else side < 0))
            before = float(row[kernels.SEEN_V])
        corners = tuple((float(row[kernels.SEEN_U]), float(row[kernels.SEEN_V])) for row in seen)
        step = self.surfaces[int(tables.polygon_surface[polygon])]
        board = outline_board(tables.vertices[first:last].tolist(), step.polynomial, self.line)
        return OutlineStep(corners, tuple(counted), inside, board)
