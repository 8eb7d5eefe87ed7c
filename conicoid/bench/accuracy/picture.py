"""The histograms of the errors as a picture: a panel for each family, a line for each system."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..peer import module
from .families import FAMILIES
from .rows import WHOLE, Outcome
from .tally import EDGES

COLORS = {"Conicoid": "#0b6e4f", "Raysect": "#c8553d", "Mitsuba": "#3d5a98", "Embree": "#8f6bb3", "trimesh": "#b8860b"}
SINGLE_ULP = 29  # log2 of a float32 ulp in ulps of float64


def draw(outcomes: Iterable[Outcome], file: Path) -> None:
    """Of the first shape and kind of input. Raises Absent without matplotlib, ValueError where nothing was hit."""
    outcomes = [o for o in outcomes if o.family != WHOLE and o.tally.hits]
    if not outcomes:
        raise ValueError("bench: there is nothing to draw")
    shape, inputs = outcomes[0].shape, outcomes[0].inputs
    shown = [o for o in outcomes if (o.shape, o.inputs) == (shape, inputs)]
    families = [f for f in FAMILIES if any(o.family == f.name for o in shown)]
    columns = min(len(families) + 1, 4)
    rows = -(-(len(families) + 1) // columns)
    figure: Any = module("matplotlib.figure", "matplotlib").Figure((2.9 * columns, 2.3 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for ax, family in zip(axes, families, strict=False):
        _panel(ax, [o for o in shown if o.family == family.name])
        ax.set_title(f"{family.name}", fontsize=10, fontweight="bold", loc="left")
    _legend(axes[len(families)], shown, f"{shape}, inputs {inputs}")
    for ax in axes[len(families) + 1 :]:
        ax.set_axis_off()
    figure.savefig(file, dpi=110)


def _panel(ax: Any, outcomes: list[Outcome]) -> None:
    for k, outcome in enumerate(outcomes):
        spread = outcome.tally.spread()
        if spread is None:
            continue
        color = COLORS.get(outcome.system.peer.name, "black")
        share = 100 * np.array(spread.histogram) / sum(spread.histogram)
        ax.stairs(share[:-1], EDGES, color=color, linewidth=1.3, fill=True, alpha=0.18)
        ax.stairs(share[:-1], EDGES, color=color, linewidth=1.3)
        wrong = outcome.tally.per_million(outcome.tally.wrong_hits + outcome.tally.wrong_misses)
        ax.text(0.98, 0.95 - 0.105 * k, f"{wrong:,.0f}", color=color, fontsize=8, ha="right", va="top",
                transform=ax.transAxes)  # fmt: skip
    ax.set_xlim(EDGES[0], EDGES[-1])
    ax.set_ylim(0, None)
    ax.set_xticks(range(0, 51, 10), [f"$2^{{{k}}}$" for k in range(0, 51, 10)])
    ax.axvline(SINGLE_ULP, color="0.75", linewidth=0.8, linestyle=":", zorder=0)
    ax.tick_params(labelsize=8)
    ax.spines[["top", "right"]].set_visible(False)


def _legend(ax: Any, outcomes: list[Outcome], title: str) -> None:
    ax.set_axis_off()
    names = dict.fromkeys(o.system.peer.name for o in outcomes)
    ax.text(0, 1.02, title, fontsize=10, fontweight="bold", transform=ax.transAxes)
    for k, name in enumerate(names):
        ax.text(0, 0.88 - 0.11 * k, f"■ {name}", color=COLORS.get(name, "black"), fontsize=9, transform=ax.transAxes)
    about = (
        "Across: error of t in ulps of float64;\ndotted: an ulp of float32. Up: % of the hits.\n"
        "Numbers: wrong hits and misses\nper million rays."
    )
    ax.text(0, 0.80 - 0.11 * len(names), about, fontsize=7.5, color="0.3", va="top", transform=ax.transAxes)
