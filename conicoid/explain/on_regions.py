"""Steps of Boolean bodies: the expression, the sweep along the ray, and the crossings that come of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ..engine.programs import gates_of_program, leaves_of_program, row_of_leaf
from ..engine.queries import recorded as kernels
from .recording import Recording
from .steps import Crossing, Sweep, SweepRow

_SINGLE = 26


def letter_of(leaf: int) -> str:
    """A, B, ... Z, A2, B2 and so on: leaves by their numbers in a body."""
    return "ABCDEFGHIJKLMNOPQRSTUVWXYZ"[leaf % _SINGLE] + (str(leaf // _SINGLE + 1) if leaf >= _SINGLE else "")


def expression_of(tables: Any, program: int) -> str:
    """A Boolean program in the letters of its leaves, with ∪, ∩ and ¬; longer ones are cut."""
    first = int(tables.program_leaf[program])
    gates = gates_of_program(tables, program)
    inputs: dict[int, list[str]] = {gate: [] for gate in gates}
    for leaf in leaves_of_program(tables, program):
        row = int(row_of_leaf(tables, program, leaf))
        negated = "¬" if tables.leaf_negated[row] else ""
        inputs[int(tables.leaf_gate[row])].append(negated + letter_of(leaf - first))
    for gate in sorted(gates, key=lambda gate: -_depth(tables, gate)):
        need, names = int(tables.gate_need[gate]), inputs[gate]
        sign = " ∪ " if need == 1 else " ∩ "
        text = sign.join(names) if need in (1, len(names)) else f"at least {need} of {', '.join(names)}"
        text = text or ("nothing" if need else "all")
        parent = int(tables.gate_parent[gate])
        bracketed = f"({text})" if len(names) > 1 else text
        negated = "¬" if tables.gate_negated[gate] else ""
        if parent < 0:
            return f"{negated}{bracketed}" if negated else text
        inputs[parent].append(negated + bracketed)
    return ""


def _depth(tables: Any, gate: int) -> int:
    depth = 0
    while tables.gate_parent[gate] >= 0:
        gate, depth = int(tables.gate_parent[gate]), depth + 1
    return depth


def sweep_of(recording: Recording, program: int, rows: Any) -> Sweep:
    """The events of a program as a table."""
    tables = recording.tables
    first, need = int(tables.program_leaf[program]), int(tables.gate_need[gates_of_program(tables, program)[0]])
    inside: list[int] = []
    found = []
    for row in rows[1:]:
        leaf, on = int(row[kernels.EVENT_LEAF]), row[kernels.EVENT_ON] == 1.0
        inside = sorted({*inside, leaf}) if on else [each for each in inside if each != leaf]
        surface, face = recording.face_at(int(row[kernels.EVENT_PLACE]))
        found.append(
            SweepRow(
                float(row[kernels.EVENT_T]), surface, face, letter_of(leaf - first), on,
                "".join(letter_of(each - first) for each in inside), int(row[kernels.EVENT_COUNT]), need,
                row[kernels.EVENT_INSIDE] == 1.0,
            )
        )  # fmt: skip
    met, letters = (
        {row.letter for row in found},
        [letter_of(leaf - first) for leaf in leaves_of_program(tables, program)],
    )
    return Sweep(
        expression_of(tables, program), rows[0, kernels.EVENT_INSIDE] == 1.0, tuple(found),
        tuple(letter for letter in letters if letter not in met),
    )  # fmt: skip


def groups(rows: Any) -> Iterator[Any]:
    """Events at equal t, which act together."""
    k = 1
    while k < len(rows):
        end = k
        while end < len(rows) and rows[end, kernels.EVENT_T] == rows[k, kernels.EVENT_T]:
            end += 1
        yield rows[k:end]
        k = end


def region_crossings(recording: Recording, body: int, program: int, rows: Any) -> tuple[list[Crossing], bool]:
    """(crossings within the interval, inside just after t_min) from recorded events: as `body/boolean.sweep`."""
    found: list[Crossing] = []
    inside = rows[0, kernels.EVENT_INSIDE] == 1.0
    started = inside
    for group in groups(rows):
        t, value = float(group[0, kernels.EVENT_T]), group[0, kernels.EVENT_INSIDE] == 1.0
        if t <= recording.t_min:
            inside = started = value
            continue
        if not t < recording.t_max:
            break
        if value == inside:
            continue
        inside = value
        surface, face = recording.face_at(int(_shown(recording.tables, program, group, value)[kernels.EVENT_PLACE]))
        if recording.is_start(t, surface):
            started = not started
        else:
            found.append(Crossing(t, body, face, surface, value))
    return found, started


def _shown(tables: Any, program: int, group: Sequence[Any], entered: bool) -> Any:
    """The event whose face is reported: the first of the group that turned the way the body did."""
    for row in group:
        sense = int(tables.leaf_sense[row_of_leaf(tables, program, int(row[kernels.EVENT_LEAF]))])
        if (row[kernels.EVENT_ON] == 1.0) == (entered == (sense > 0)):
            return row
    return group[0]
