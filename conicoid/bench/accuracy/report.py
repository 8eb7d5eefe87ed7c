"""Saying what was measured: as a table, as Markdown, as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from rich.table import Table

from .rows import Outcome
from .tally import EDGES

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


def cells(outcome: Outcome) -> tuple[str, ...]:
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


def table(outcomes: Iterable[Outcome]) -> Table:
    made = Table(*HEAD)
    for outcome in outcomes:
        made.add_row(*cells(outcome))
    return made


def markdown(outcomes: Iterable[Outcome], about: Iterable[str]) -> str:
    lines = [*(f"{line}  " for line in about), "", "| " + " | ".join(HEAD) + " |"]
    lines.append("|---" * 4 + "|--:" * (len(HEAD) - 4) + "|")
    lines += ["| " + " | ".join(cells(outcome)) + " |" for outcome in outcomes]
    return "\n".join(lines) + "\n"


def as_json(outcomes: Iterable[Outcome], about: list[str], absent: list[str]) -> str:
    def entry(outcome: Outcome) -> dict[str, Any]:
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
