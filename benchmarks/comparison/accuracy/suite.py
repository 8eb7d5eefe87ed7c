"""The measurements: shapes by families by inputs, each with every system that has the shape."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from conicoid._util.files import replace_file, write_text

from ..harness import Absent, machine, module
from ..suite import BenchSummary
from .bodies import DOUBLE, FAMILIES, SHAPES, SINGLE, Floats, Precision, RayFamily, trials
from .reference import EDGES, Tally, first_crossings
from .systems import SYSTEMS, System

ALL_FAMILIES = "all"
"""The name of all families together."""


@dataclass(frozen=True)
class Case:
    """A shape and a family of rays, in floats of a precision."""

    shape: str
    family: RayFamily
    inputs: Precision


@dataclass(frozen=True)
class CaseOutcome:
    """The results of a system for a case, or for all families of a shape."""

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
        """Return the chosen ones, or all where there is no choice."""
        return [name for name in names if name in wanted] or list(names)

    return [
        Case(shape, families[family], precisions[precision])
        for precision in named(precisions)
        for shape in named(SHAPES)
        for family in named(families)
    ]


def run(chosen: Iterable[Case], rays: int, done: Callable[[CaseOutcome], None]) -> tuple[list[CaseOutcome], list[str]]:
    """Outcomes, and for each system that is absent a line that says why. `rays` are those of a case."""
    present, absent = _present()
    outcomes: list[CaseOutcome] = []
    for case in chosen:
        for outcome in _measured(case, rays, present, absent):
            outcomes.append(outcome)
            done(outcome)
    return outcomes + merge_outcomes(outcomes), list(absent.values())


def _present() -> tuple[list[System], dict[str, str]]:
    present, absent = [], {}
    for system in SYSTEMS:
        try:
            system.peer.find()
            present.append(system)
        except Absent as reason:
            absent[system.peer.name] = f"{system.peer.name}: {reason}"
    return present, absent


def _measured(case: Case, rays: int, present: list[System], absent: dict[str, str]) -> Iterator[CaseOutcome]:
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
        yield CaseOutcome(case.shape, case.family.name, case.inputs.name, system, tally)


def merge_outcomes(outcomes: Iterable[CaseOutcome]) -> list[CaseOutcome]:
    """For each system, shape and kind of input all families in one, where there are several."""
    groups: dict[tuple[str, str, str], list[CaseOutcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.inputs, outcome.shape, outcome.system.peer.name), []).append(outcome)
    made = []
    for group in groups.values():
        if len(group) > 1:
            whole = Tally()
            for outcome in group:
                whole.merge(outcome.tally)
            made.append(CaseOutcome(group[0].shape, ALL_FAMILIES, group[0].inputs, group[0].system, whole))
    return made


# Reports of measurements: as a table, as Markdown, as JSON.

HEAD = (
    "inputs",
    "shape",
    "rays",
    "system",
    "wrong hits",
    "wrong misses",
    "median",
    "99.9 %",
    "largest",
    "bound",
    "broken",
)
NOTE = (
    "Wrong hits and misses: per million rays. Errors of t: in ulps of float64, and in brackets in ulps of float32 "
    "where the answer is one. Bound: its median over the median error; broken: errors beyond their bound."
)


def cells(outcome: CaseOutcome) -> tuple[str, ...]:
    """As the columns of `HEAD`."""
    tally, spread = outcome.tally, outcome.tally.spread()
    start = (outcome.inputs, outcome.shape, outcome.family, outcome.system.peer.name)
    wrong = tuple(f"{tally.per_million(count):.0f}" for count in (tally.wrong_hits, tally.wrong_misses))
    if spread is None:
        return (*start, *wrong, "", "", "", "", "")
    single = outcome.system.answers == 24
    errors = tuple(in_ulps(error, single) for error in (spread.median, spread.most, spread.largest))
    ratio = "" if spread.bound_ratio is None else f"{spread.bound_ratio:.2f} ×"
    return (*start, *wrong, *errors, ratio, "" if spread.violations is None else f"{spread.violations}")


def in_ulps(error: float, single: bool) -> str:
    """An error in ulps of float64; of single answers also in their own, which are 2^29 of them."""
    if error < 9950:
        text = f"{float(f'{error:.2g}'):g}"
    else:
        text = f"{error:.1e}".replace("e+0", "e").replace("e+", "e")
    return f"{text} ({in_ulps(error / 2**29, False)})" if single else text


def table(outcomes: Iterable[CaseOutcome]) -> Table:
    made = Table(*HEAD)
    for outcome in outcomes:
        made.add_row(*cells(outcome))
    return made


def markdown(outcomes: Iterable[CaseOutcome], about: Iterable[str]) -> str:
    lines = [*(f"{line}  " for line in about), "", "| " + " | ".join(HEAD) + " |"]
    lines.append("|---" * 4 + "|--:" * (len(HEAD) - 4) + "|")
    lines += ["| " + " | ".join(cells(outcome)) + " |" for outcome in outcomes]
    return "\n".join(lines) + "\n"


def as_json(outcomes: Iterable[CaseOutcome], about: list[str], absent: list[str]) -> str:
    def entry(outcome: CaseOutcome) -> dict[str, Any]:
        tally, spread = outcome.tally, outcome.tally.spread()
        data: dict[str, Any] = {
            "inputs": outcome.inputs, "shape": outcome.shape, "family": outcome.family,
            "system": outcome.system.peer.name, "answer_bits": outcome.system.answers,
        }  # fmt: skip
        data |= {name: getattr(tally, name) for name in ("rays", "ties", "hits", "wrong_hits", "wrong_misses")}
        if spread is not None:
            data |= {"median_ulps": spread.median, "most_ulps": spread.most, "largest_ulps": spread.largest}
            data |= {"histogram": spread.histogram}
            data |= {"bounds": spread.bounds, "bound_ratio": spread.bound_ratio, "violations": spread.violations}
        return data

    whole = {
        "machine": about, "absent": absent, "histogram_log2_ulps": [int(edge) for edge in EDGES],
        "rows": [entry(outcome) for outcome in outcomes],
    }  # fmt: skip
    return json.dumps(whole, indent=1) + "\n"


# The histograms of the errors as a picture: a panel for each family, a line for each system.

COLORS = {"Conicoid": "#0b6e4f", "Raysect": "#c8553d", "Mitsuba": "#3d5a98", "Embree": "#8f6bb3", "trimesh": "#b8860b"}
SINGLE_ULP = 29  # log2 of a float32 ulp in ulps of float64


TOP = 46
"""The power of two at which the pictures end."""


def draw(outcomes: Iterable[CaseOutcome], file: Path) -> None:
    """Of the first shape and kind of input. Raises Absent without matplotlib, ValueError where nothing was hit."""
    outcomes = [o for o in outcomes if o.family != ALL_FAMILIES and o.tally.hits]
    if not outcomes:
        raise ValueError("bench: there is nothing to draw")
    shape, inputs = outcomes[0].shape, outcomes[0].inputs
    shown = [o for o in outcomes if (o.shape, o.inputs) == (shape, inputs)]
    families = [f for f in FAMILIES if any(o.family == f.name for o in shown)]
    columns = min(len(families) + 1, 4)
    rows = -(-(len(families) + 1) // columns)
    figure: Any = module("matplotlib.figure", "matplotlib").Figure((2.9 * columns, 2.3 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel()
    for k, (ax, family) in enumerate(zip(axes, families, strict=False)):
        _panel(ax, [o for o in shown if o.family == family.name], k % columns == 0)
        ax.set_title(f"{family.name}", fontsize=10, fontweight="bold", loc="left")
    spreads = [spread for o in shown if (spread := o.tally.spread())]
    axes[0].set_ylim(0, 1.04 * max(_shares(spread.histogram).max() for spread in spreads))
    _legend(axes[len(families)], shown, f"{shape}, {inputs} inputs")
    for ax in axes[len(families) + 1 :]:
        ax.set_axis_off()
    figure.savefig(file, dpi=110)


def _shares(histogram: list[int]) -> Floats:
    """Return percent in each bin up to the last of the picture, which takes all beyond."""
    counts, last = np.array(histogram, float), TOP - int(EDGES[0])
    counts[last - 1] += counts[last:].sum()
    return np.asarray(100 * counts[:last] / max(counts.sum(), 1))


def _panel(ax: Any, outcomes: list[CaseOutcome], first: bool) -> None:
    small: Any = {"fontsize": 8, "ha": "right", "va": "top", "transform": ax.transAxes}
    ax.text(0.98, 0.96, "wrong / 10⁶", color="0.4", **small)
    for k, outcome in enumerate(outcomes):
        spread = outcome.tally.spread()
        if spread is None:
            continue
        color, share = COLORS.get(outcome.system.peer.name, "black"), _shares(spread.histogram)
        edges = EDGES[: len(share) + 1]
        ax.stairs(share, edges, color=color, linewidth=0, fill=True, alpha=0.18)
        ax.stairs(share, edges, color=color, linewidth=1.3)
        if spread.bounds is not None:
            ax.stairs(_shares(spread.bounds), edges, color="black", linewidth=0.8, linestyle=(0, (3, 3)), zorder=3)
        wrong = outcome.tally.per_million(outcome.tally.wrong_hits + outcome.tally.wrong_misses)
        ax.text(0.98, 0.85 - 0.105 * k, f"{wrong:,.0f}", color=color, **small)
    ax.set_xlim(EDGES[0], TOP)
    ax.set_xticks(range(0, TOP, 10), [f"$2^{{{k}}}$" for k in range(0, TOP, 10)])
    ax.axvline(SINGLE_ULP, color="0.7", linewidth=0.8, linestyle=":", zorder=0)
    ax.tick_params(labelsize=8)
    ax.spines[["top", "right"]].set_visible(False)
    if first:
        ax.set_ylabel("% of the hits", fontsize=8)


def _legend(ax: Any, outcomes: list[CaseOutcome], title: str) -> None:
    ax.set_axis_off()
    names = dict.fromkeys(o.system.peer.name for o in outcomes)
    ax.text(0, 0.95, title, fontsize=10, fontweight="bold", transform=ax.transAxes)
    for k, name in enumerate(names):
        ax.text(0, 0.82 - 0.11 * k, f"■ {name}", color=COLORS.get(name, "black"), fontsize=9, transform=ax.transAxes)
    about = (
        "Across: error of t in ulps of float64;\nthe first bin has all below. Dotted: an ulp\nof float32. "
        "Numbers: wrong hits and\nmisses per million rays."
    )
    if any(o.tally.bounds for o in outcomes):
        about += "\nDashed: Conicoid's bounds on its errors."
    ax.text(0, 0.82 - 0.11 * len(names), about, fontsize=7.5, color="0.3", va="top", transform=ax.transAxes)


# The command as a function: measure, write the files, return the report.


def measure(
    wanted: Sequence[str], rays: int, figures: Path | None, picture: Path | None, tell: Callable[[str], None]
) -> BenchSummary:
    """Measure, and call `tell` with each outcome as it comes.

    Raises ValueError for unknown rows, and for a picture without matplotlib.
    """
    chosen = cases(wanted)
    if picture is not None:
        try:
            module("matplotlib.figure", "matplotlib")
        except Absent as reason:
            raise ValueError(f"bench: a picture needs matplotlib: {reason}") from None
    outcomes, absent = run(chosen, rays, lambda outcome: tell("  ".join(filter(None, cells(outcome)))))
    about = [*machine(system.peer for system in SYSTEMS), *absent, f"{rays:,} rays a row. {NOTE}"]
    if figures is not None:
        write_text(figures, as_json(outcomes, about, absent))
    if picture is not None:
        with replace_file(picture) as partial:
            draw(outcomes, partial)
    return BenchSummary(table(outcomes), markdown(outcomes, about), about)
