"""The histograms of the errors as a picture: a panel for each family, a line for each system."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..peer import module
from .bodies import Floats
from .families import FAMILIES
from .rows import WHOLE, Outcome
from .tally import EDGES

COLORS = {"Conicoid": "#0b6e4f", "Raysect": "#c8553d", "Mitsuba": "#3d5a98", "Embree": "#8f6bb3", "trimesh": "#b8860b"}
SINGLE_ULP = 29  # log2 of a float32 ulp in ulps of float64


TOP = 46
"""The power of two at which the pictures end."""


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
    """Percent in each bin up to the last that is drawn, which takes what is beyond."""
    counts, last = np.array(histogram, float), TOP - int(EDGES[0])
    counts[last - 1] += counts[last:].sum()
    return np.asarray(100 * counts[:last] / max(counts.sum(), 1))


def _panel(ax: Any, outcomes: list[Outcome], first: bool) -> None:
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


def _legend(ax: Any, outcomes: list[Outcome], title: str) -> None:
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
