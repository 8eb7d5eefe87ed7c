"""The accuracy table of docs/dev/accuracy-tables.md: every shape against 90 digits, on random hard rays.

    python benchmarks/accuracy.py [--cases 200] [--rays 55] [--only Sphere Cone ...]

Prints Markdown. Columns: rays traced; crossings compared; rays in the tangency band (stated in
tests/oracle/trace.py); wrong hits and misses outside of it; the error of t as a share of (distance
travelled + size of the solid), median and largest where the ray meets the surface at |cos θ| >= 1/56;
and, over all angles, how far beside the surface the crossing lies at most, in units of 2^-53 of the
same sum.
"""

from __future__ import annotations

import argparse
import datetime
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

import mpmath
import numba
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import conicoid as co
from tests.oracle.compare import Score, compare
from tests.oracle.rays import rays
from tests.oracle.samples import KINDS, generator, random_case

HEADINGS = (
    "shape",
    "rays",
    "crossings",
    "in band",
    "wrong hits",
    "wrong misses",
    "median error",
    "largest error",
    "beside, 2^-53",
)


def processor() -> str:
    """Its name, as Linux or Python know it."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        text = ""
    names = [line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def score_of(kind: str, cases: int, rays_per_case: int) -> Score:
    score = Score()
    for index in range(1000, 1000 + cases):
        random = generator(kind, index)
        case = random_case(kind, random)
        score.add(compare(case, co, *rays(case, rays_per_case, random)))
    return score


def row(kind: str, score: Score) -> str:
    cells = (
        kind, score.rays, score.crossings, score.in_band, score.wrong_hits, score.wrong_misses, f"{score.median:.1e}",
        f"{max(score.steep_errors, default=0.0):.1e}", f"{max(score.displacements, default=0.0):.1f}",
    )  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |"


def table(kinds: list[str], cases: int, rays_per_case: int) -> Iterator[str]:
    """Lines of Markdown, each as soon as it is known; failures go to stderr."""
    versions = ", ".join(f"{module.__name__} {module.__version__}" for module in (co, np, numba, mpmath))
    yield f"{datetime.date.today().isoformat()}, {processor()}, Python {platform.python_version()}, {versions}.\n"
    yield "| " + " | ".join(HEADINGS) + " |"
    yield "|---" + "|--:" * (len(HEADINGS) - 1) + "|"
    whole = Score()
    for kind in kinds:
        score = score_of(kind, cases, rays_per_case)
        for failure in score.failures:
            print(kind, failure, file=sys.stderr)
        whole.add(score)
        yield row(kind, score)
    yield row("**all**", whole)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200, help="random shapes of each kind")
    parser.add_argument("--rays", type=int, default=55, help="rays at each of them")
    parser.add_argument("--only", nargs="*", default=sorted(KINDS), choices=sorted(KINDS), metavar="KIND")
    options = parser.parse_args()
    for text in table(options.only, options.cases, options.rays):
        print(text, flush=True)


if __name__ == "__main__":
    main()
