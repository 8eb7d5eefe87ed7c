"""The accuracy table of docs/dev/accuracy-tables.md: every shape against exact arithmetic, on random hard rays.

    python benchmarks/accuracy.py [--cases 40] [--rays 110] [--only Sphere Cone ...]

Prints Markdown. Columns: rays traced; crossings of the exact answers; rays with another number of crossings, or one of
another body, face or sense; the error of t as a share of (distance travelled + size of the solid), median and largest
where the ray meets the surface at |cos θ| >= 1/56; over all angles, how far beside the surface the crossing lies at
most, in units of 2^-53 of the same sum.
"""

from __future__ import annotations

import argparse
import datetime
import math
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import flint
import numba
import numpy as np
from flint import arb, ctx

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import conicoid as co
from tests.reference.aimed_rays import Aim, rays
from tests.reference.judge import Comparison, Judge, norm, rows_of
from tests.reference.random_items import KINDS, ordinary
from tests.reference.random_shapes import generator

HEADINGS = "shape", "rays", "crossings", "wrong rays", "median error", "largest error", "beside, 2^-53"
STEEP = 1 / 56


def processor() -> str:
    """Its name, as Linux or Python know it."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        text = ""
    names = [line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


@dataclass
class Row:
    """The sums of one kind of shape."""

    rays: int = 0
    crossings: int = 0
    wrong: int = 0
    errors: list[float] = field(default_factory=list)
    cosines: list[float] = field(default_factory=list)
    """The angles between rays and normals."""

    def add(self, other: Row) -> None:
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)

    def text(self, kind: str) -> str:
        errors, cosines = np.array(self.errors), np.array(self.cosines)
        steep, beside = errors[cosines >= STEEP].max(initial=0), (errors * cosines * 2.0**53).max(initial=0)
        cells = kind, self.rays, self.crossings, self.wrong, f"{np.median(errors):.1e}", f"{steep:.1e}", f"{beside:.1f}"
        return "| " + " | ".join(map(str, cells)) + " |"


def row(kind: str, cases: int, rays_per_case: int) -> Row:
    found = Row()
    for index in range(1000, 1000 + cases):
        random = generator(kind, index)
        item = ordinary(kind, random)
        judge = Judge(co, [item], far=0)
        compared = judge.rays(*rays(Aim(judge.table, item.world_center, item.world_size, random), rays_per_case))
        good = compared.lists()
        found.rays += len(good)
        found.wrong += int((~good).sum())
        for text in judge.score.messages.values():
            print(kind, *text, file=sys.stderr)
        measure(found, compared, good, item.world_size)
    return found


def measure(found: Row, compared: Comparison, good: np.ndarray, size: float) -> None:
    """Add the errors and angles of all crossings of good rays."""
    exact = compared.exact
    rows = np.flatnonzero(good[exact.ray])
    t = compared.found.t[good[rows_of(compared.found.offsets)]]
    found.crossings += len(exact.ray)
    with ctx.workprec(300):
        for k, place in zip(rows.tolist(), t.tolist(), strict=True):
            ray, root = int(exact.ray[k]), exact.roots[k]
            direction = compared.directions[ray].tolist()
            gradient, _ = compared.gradient(ray, root)
            speed, steepness = math.hypot(*direction), norm(gradient)
            along = sum((g * arb(d) for g, d in zip(gradient, direction, strict=True)), arb(0))
            if steepness > 0:
                found.errors.append(float(abs(arb(place) - root.ball())) * speed / (abs(place) * speed + size))
                found.cosines.append(abs(float(along / steepness)) / speed)


def table(kinds: list[str], cases: int, rays_per_case: int) -> Iterator[str]:
    """Return lines of Markdown, each as soon as it is complete; failures go to stderr."""
    versions = ", ".join(f"{module.__name__} {module.__version__}" for module in (co, np, numba, flint))
    yield f"{datetime.date.today().isoformat()}, {processor()}, Python {platform.python_version()}, {versions}.\n"
    yield "| " + " | ".join(HEADINGS) + " |"
    yield "|---" + "|--:" * (len(HEADINGS) - 1) + "|"
    whole = Row()
    for kind in kinds:
        found = row(kind, cases, rays_per_case)
        whole.add(found)
        yield found.text(kind)
    yield whole.text("**all**")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=40, help="random shapes of each kind")
    parser.add_argument("--rays", type=int, default=110, help="rays at each of them")
    parser.add_argument("--only", nargs="*", default=sorted(KINDS), choices=sorted(KINDS), metavar="KIND")
    options = parser.parse_args()
    for text in table(options.only, options.cases, options.rays):
        print(text, flush=True)


if __name__ == "__main__":
    main()
