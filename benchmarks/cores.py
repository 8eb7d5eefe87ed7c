"""Reactor cores from OpenMC files: how long they take to open and to be edited, and how much memory.

    python benchmarks/cores.py [--across 1 19 22 37 38] [--model standing | turned | cut]
    python benchmarks/cores.py --rays [--across 1 4 12 22 37]

The cores stand along the axes, are turned by 30 degrees, or are cut by a vessel that is 0.9 times as wide. Each core,
of so many assemblies across, is opened in a process of its own, with void and without: its bodies are read, its tables
and tree made, and one ray traced. Then a body in the middle of the list is moved, five times, each time up to the next
first hit. Prints a table in Markdown: wall time, and the largest memory of the process up to the first hit.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RAY = (0.1, 0.2, 500.0), (0.01, 0.02, -1.0)
MOVES = 5
TURNS = 9


def largest() -> int:
    """The largest memory of this process so far, in MiB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) >> 10
    raise SystemExit("cores: /proc does not tell the memory of a process here")


def once(path: str, void: bool) -> None:
    """One core, in this process."""
    import conicoid as co

    begin = time.perf_counter()
    scene = co.load_openmc(path, void=void)
    read = time.perf_counter()
    scene.first_hit(*RAY)
    ready, memory, tables = time.perf_counter(), largest(), sum(scene.memory[1:])
    moves = []
    for k in range(MOVES):
        start = time.perf_counter()
        scene = scene.moved(scene.body_count // 2, (0.0, 0.0, 0.01 * (k + 1)))
        scene.first_hit(*RAY)
        moves.append(time.perf_counter() - start)
    print(json.dumps([scene.body_count, read - begin, ready - begin, memory, tables, statistics.median(moves)]))


def trace(across: list[int], width: int = 1000) -> None:
    """The table of rays: all cores in turns, medians of them."""
    import numpy as np
    from comparison.harness import machine
    from comparison.scenes import PINS, VIEWS, rays_of_view, write_core

    import conicoid as co

    scenes = []
    with tempfile.TemporaryDirectory() as folder:
        for size in across:
            write_core(Path(folder) / "geometry.xml", size)
            scenes.append(co.load_openmc(Path(folder) / "geometry.xml", void=False))
            scenes[-1].prepare()
    print("| view | assemblies, pins | hit | different bodies | ns/ray | times the first |\n|---|---|---|---|---|---|")
    for view in VIEWS:
        pairs = [(scene, rays_of_view(view, size, width)) for scene, size in zip(scenes, across, strict=True)]
        hits = [scene.first_hit(rays) for scene, rays in pairs]
        seconds: list[list[float]] = [[] for _ in pairs]
        for _ in range(TURNS):
            for (scene, rays), times in zip(pairs, seconds, strict=True):
                scene.first_hit(rays)
                begin = time.perf_counter()
                scene.first_hit(rays)
                times.append(time.perf_counter() - begin)
        middle = [statistics.median(times) * 1e9 / width**2 for times in seconds]
        for size, found, each in zip(across, hits, middle, strict=True):
            print(
                f"| {view} | {size} × {size}, {(size * PINS) ** 2:,} | {100 * found.hit.mean():.0f} % "
                f"| {len(np.unique(found.body[found.hit])):,} | {each:.0f} | {each / middle[0]:.2f} |",
                flush=True,
            )
    print(f"\nMedians of {TURNS} turns.", *machine([]), sep="\n")


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", type=int, nargs="+", help="assemblies across a core")
    parser.add_argument("--rays", action="store_true", help="time camera rays")
    parser.add_argument("--once", nargs=2, metavar=("FILE", "VOID"), help=argparse.SUPPRESS)
    parser.add_argument(
        "--model", choices=("standing", "turned", "cut"), default="standing", help="how the cores stand"
    )
    options = parser.parse_args()
    if options.rays:
        if options.model != "standing":
            parser.error("--rays is for standing cores")
        trace(options.across or [1, 4, 12, 22, 37])
        return
    if options.once:
        once(options.once[0], options.once[1] == "1")
        return
    from comparison.harness import machine
    from comparison.scenes import PINS, pitch_of_assemblies, write_core

    print("| assemblies, pins | void | bodies | read | ready | largest memory | tables and tree | one body moved |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "geometry.xml"
        for across in options.across or [1, 19, 22, 37, 38]:
            vessel = 0.45 * across * pitch_of_assemblies() if options.model == "cut" else None
            write_core(path, across, vessel=vessel, turned="0 0 30" if options.model == "turned" else "")
            for void in (False, True):
                command = [sys.executable, __file__, "--once", str(path), str(int(void))]
                printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
                bodies, read, ready, memory, tables, moved = json.loads(printed)
                cells = (
                    f"{across} × {across}, {(across * PINS) ** 2:,}", "yes" if void else "no", f"{bodies:,}",
                    f"{read:.1f} s", f"{ready:.1f} s", f"{memory:,} MiB", f"{tables / 1e6:.0f} MB",
                    f"{1e3 * moved:,.0f} ms",
                )  # fmt: skip
                print(f"| {' | '.join(cells)} |", flush=True)
    print(f"\nWall time, medians of {MOVES} moves.", *machine([]), sep="\n")


if __name__ == "__main__":
    main()
