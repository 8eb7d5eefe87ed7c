"""What is measured: shapes by families by inputs, each with every system that has the shape."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from ..peer import Absent
from .families import FAMILIES, SHAPES, Family, trials
from .reference import first_crossings
from .subjects import DOUBLE, SINGLE, Precision
from .systems import SYSTEMS, System
from .tally import Tally

WHOLE = "all"
"""The name of all families together."""


@dataclass(frozen=True)
class Case:
    """A shape and a family of rays, in floats of a precision."""

    shape: str
    family: Family
    inputs: Precision


@dataclass(frozen=True)
class Outcome:
    """What a system made of a case, or of all families of a shape."""

    shape: str
    family: str
    inputs: str
    system: System
    tally: Tally


def cases(wanted: Sequence[str] = ()) -> list[Case]:
    """All, or those of the shapes, families and inputs that are named; raises ValueError for an unknown name."""
    precisions = {precision.name: precision for precision in (SINGLE, DOUBLE)}
    families = {family.name: family for family in FAMILIES}
    known = [*SHAPES, *families, *precisions]
    for name in wanted:
        if name not in known:
            raise ValueError(f"bench: there are no rows {name!r}; there are {', '.join(known)}")

    def named(names: Iterable[str]) -> list[str]:
        """Those that are wanted; all where none is."""
        return [name for name in names if name in wanted] or list(names)

    return [
        Case(shape, families[family], precisions[precision])
        for precision in named(precisions)
        for shape in named(SHAPES)
        for family in named(families)
    ]


def run(chosen: Iterable[Case], rays: int, done: Callable[[Outcome], None]) -> tuple[list[Outcome], list[str]]:
    """Outcomes, and for each system that is absent a line that says why. `rays` are those of a case."""
    present, absent = _present()
    outcomes: list[Outcome] = []
    for case in chosen:
        for outcome in _measured(case, rays, present, absent):
            outcomes.append(outcome)
            done(outcome)
    return outcomes + together(outcomes), list(absent.values())


def _present() -> tuple[list[System], dict[str, str]]:
    present, absent = [], {}
    for system in SYSTEMS:
        try:
            system.peer.find()
            present.append(system)
        except Absent as reason:
            absent[system.peer.name] = f"{system.peer.name}: {reason}"
    return present, absent


def _measured(case: Case, rays: int, present: list[System], absent: dict[str, str]) -> Iterator[Outcome]:
    made = trials(case.shape, case.family, case.inputs, rays)
    exact = [first_crossings(trial.body, trial.origins, trial.directions) for trial in made]
    for system in present:
        if case.shape not in system.shapes or case.inputs.bits > system.inputs or system.peer.name in absent:
            continue
        try:
            answers = system.trace(made)
        except Absent as reason:
            absent[system.peer.name] = f"{system.peer.name}: {reason}"
            continue
        tally = Tally()
        for known, answer in zip(exact, answers, strict=True):
            tally.add(known, answer)
        yield Outcome(case.shape, case.family.name, case.inputs.name, system, tally)


def together(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """For each system, shape and kind of input all families in one, where there are several."""
    groups: dict[tuple[str, str, str], list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.inputs, outcome.shape, outcome.system.peer.name), []).append(outcome)
    made = []
    for group in groups.values():
        if len(group) > 1:
            whole = Tally()
            for outcome in group:
                whole.merge(outcome.tally)
            made.append(Outcome(group[0].shape, WHOLE, group[0].inputs, group[0].system, whole))
    return made
