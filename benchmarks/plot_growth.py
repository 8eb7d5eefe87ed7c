"""Draw the growth of the time per ray with the number of balls: docs/images/growth.svg.

    python benchmarks/plot_growth.py [OUTPUT]

The figures are those of benchmarks/results/growth.json, which `benchmarks/growth.py` measured. Only Python is needed.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "growth.json"
WIDTH, HEIGHT = 650, 412
LEFT, RIGHT, TOP, BOTTOM = 76, 532, 20, 344  # of the plane of the plot, in pixels
BALLS, TIMES = (10, 10**7), (5, 5000)  # ranges of the two axes, in balls and in ns
CURVES = {"camera": (1, "#8a4b1f"), "random": (2, "#2b5f8f")}  # the column and the colour of each
INK, GRID = "#333333", "#dddddd"
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def across(balls: float) -> float:
    """Return the horizontal place of a number of balls."""
    low, high = map(math.log, BALLS)
    return LEFT + (math.log(balls) - low) / (high - low) * (RIGHT - LEFT)


def up(time: float) -> float:
    """Return the vertical place of a time in ns."""
    low, high = map(math.log, TIMES)
    return BOTTOM - (math.log(time) - low) / (high - low) * (BOTTOM - TOP)


def text(x: float, y: float, words: str, anchor: str = "middle", color: str = INK, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}"{more}>{words}</text>'


def line(points: list[tuple[float, float]], color: str, more: str = "") -> str:
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{places}" fill="none" stroke="{color}"{more}/>'


def axes() -> list[str]:
    """Return the grid, the numbers at the axes, and their names."""
    parts = []
    for power in range(1, 8):
        x = across(10**power)
        parts.append(line([(x, TOP), (x, BOTTOM)], GRID))
        parts.append(text(x, BOTTOM + 18, "10" + (str(power).translate(SUPERSCRIPTS) if power > 1 else "")))
    for time in (5, 10, 50, 100, 500, 1000, 5000):
        y = up(time)
        parts.append(line([(LEFT, y), (RIGHT, y)], GRID))
        parts.append(text(LEFT - 8, y + 4, f"{time:,}", "end"))
    parts.append(line([(LEFT, TOP), (LEFT, BOTTOM), (RIGHT, BOTTOM)], INK))
    parts.append(text((LEFT + RIGHT) / 2, BOTTOM + 40, "balls in the scene"))
    middle = (TOP + BOTTOM) / 2
    turned = f' transform="rotate(-90 16 {middle:.1f})"'
    parts.append(text(16, middle, "nanoseconds per ray, two threads", more=turned))
    return parts


def curve(name: str, quiet: list[list[float]], busy: list[list[float]]) -> list[str]:
    """Return one curve: full where nothing is noted, hollow and dashed where other work ran."""
    column, color = CURVES[name]
    points = [(across(row[0]), up(row[column])) for row in quiet]
    others = [(across(row[0]), up(row[column])) for row in busy]
    return [
        line(points, color, ' stroke-width="2"'),
        line([points[-1], *others], color, ' stroke-width="2" stroke-dasharray="4 4"'),
        *(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>' for x, y in points),
        *(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="white" stroke="{color}" stroke-width="2"/>'
            for x, y in others
        ),
        text(RIGHT + 12, others[-1][1] + 4, f"{name} rays", "start", color),
    ]


def picture(results: dict[str, Any]) -> str:
    """Return the SVG text of a file of results."""
    quiet, busy = (table["rows"] for table in results["tables"][:2])
    source = f"{results['date']}, {results['processor']}. Hollow: other work used one of the two cores."
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="Helvetica, Arial, sans-serif" font-size="13">',
        f"<title>{results['title']}</title>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        *axes(),
        *(part for name in CURVES for part in curve(name, quiet, busy)),
        text(WIDTH - 8, HEIGHT - 4, source, "end", "#777777", ' font-size="10"'),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "growth.svg"
    target.write_text(picture(json.loads(RESULTS.read_text(encoding="utf-8"))), encoding="utf-8")


if __name__ == "__main__":
    main()
