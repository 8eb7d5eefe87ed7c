"""The work before the first ray: preparing bodies of each kind, edits, whole processes from a file to a picture.

    python benchmarks/preparing.py [--many 100000] [--pictures | --edits | --bulk | --faceted]
    python benchmarks/preparing.py --linear [--memory 24]      # from 1,000 bodies to 1,000,000

Preparing is timed in a process of its own for each kind, processor time on one core, first with nothing recorded (which
the first scene of a process pays for), then as often as it takes; making the objects apart. Pictures have 1,000 x 1,000
pixels; POV-Ray, where it is installed, draws the same bodies. Its table is Markdown.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

RUNS = 3
COUNTS = 1_000, 10_000, 100_000, 1_000_000
BULK = "`Spheres`", "`Triangles`", "`Ellipsoids`", "`Discs`", "`Cylinders`", "`Cones`", "`Boxes`", "`Capsules`"
LINEAR = (
    *BULK,
    "`Sphere`",
    "`Box`",
    "`Box`, turned",
    "oblique `Cylinder`",
    "box - ball - 3 cylinders, turned",
    "(ball & box) - 3 cylinders, scaled",
)


def point(rng: Any) -> Any:
    return tuple(rng.uniform(-5, 5, 3).tolist())


def size(rng: Any) -> float:
    return float(rng.uniform(0.1, 1.0))


def placed(shape: Any, rng: Any) -> Any:
    """Turned about any axis, and moved."""
    return shape.rotate(point(rng), float(rng.uniform(-180, 180))).translate(point(rng))


def box(rng: Any) -> Any:
    import conicoid as co

    low = np.array(point(rng))
    return co.Box(low.tolist(), (low + [size(rng), size(rng), size(rng)]).tolist())


def drilled(rng: Any) -> Any:
    """A box with a ball cut from it and three bores: five leaves."""
    import conicoid as co

    solid = co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(size(rng), (1, 1, 1))
    for axis in np.eye(3):
        solid = solid - co.Cylinder((-2 * axis).tolist(), (2 * axis).tolist(), 0.3 * size(rng))
    return placed(solid, rng)


def bored(rng: Any) -> Any:
    """The rest of a ball in a box after three bores, scaled and moved, as in `python -m benchmarks`: five leaves."""
    from comparison.scenes import BallRows, bored_blocks

    each = BallRows(rng.uniform(-5, 5, (1, 3)), rng.uniform(0.1, 1, 1))
    return bored_blocks(each)[0]


def lens(rng: Any) -> Any:
    """What two balls have in common, turned."""
    import conicoid as co

    return placed(co.Sphere(2, (0, 0, -1.5)) & co.Sphere(2 + size(rng), (0, 0, 1.5)), rng)


def crossed(rng: Any) -> Any:
    """What two crossed cylinders of any size have in common, turned."""
    import conicoid as co

    rods = [co.Cylinder((-2 * axis).tolist(), (2 * axis).tolist(), size(rng)) for axis in np.eye(3)[:2]]
    return placed(rods[0] & rods[1], rng)


def cut_cone(rng: Any) -> Any:
    """The part of a cone in a box of any size, turned."""
    import conicoid as co

    return placed(co.Cone((0, 0, -1), (0, 0, 1), 0.9, 0.1) & co.Box((-size(rng), -1, -1), (size(rng), 0.5, 0.5)), rng)


def nested(rng: Any) -> Any:
    """A bored block within a ball or a rod, turned: a difference and a union in an intersection."""
    import conicoid as co

    block = co.Box((-0.6, -0.6, -0.6), (0.6, 0.6, 0.6)) - co.Cylinder((-2, 0, 0), (2, 0, 0), 0.5 * size(rng))
    return placed(block & (co.Sphere(size(rng)) | co.Cylinder((0, 0, -2), (0, 0, 2), 0.5 * size(rng))), rng)


def kinds() -> dict[str, Any]:
    import conicoid as co

    return {
        "`Sphere`": lambda r: co.Sphere(size(r), point(r)),
        "`Sphere`, turned": lambda r: placed(co.Sphere(size(r), point(r)), r),
        "`Box`": box,
        "`Box`, turned": lambda r: placed(box(r), r),
        "`Triangle`": lambda r: co.Triangle(point(r), point(r), point(r)),
        "oblique `Cylinder`": lambda r: co.Cylinder(point(r), point(r), size(r)),
        "oblique `Cone`": lambda r: co.Cone(point(r), point(r), size(r), size(r)),
        "`Ellipsoid`, turned": lambda r: placed(co.Ellipsoid((size(r), size(r), size(r))), r),
        "box - ball - 3 cylinders, turned": drilled,
        "(ball & box) - 3 cylinders, scaled": bored,
        "ball & ball, turned": lens,
        "cylinder & cylinder, turned": crossed,
        "cone & box, turned": cut_cone,
        "(box - cylinder) & (ball \\| cylinder), turned": nested,
    }


def bulk(name: str, rng: Any, count: int) -> Any:
    """Many small bodies in one entry, far apart."""
    import conicoid as co

    at, along = rng.uniform(-50, 50, (count, 3)), 0.1 * rng.normal(size=(count, 3))
    radii = rng.uniform(0.05, 0.1, count)
    makers = {
        "`Spheres`": lambda: co.Spheres(at, radii),
        "`Triangles`": lambda: co.Triangles(at, at + along, at + 0.1 * rng.normal(size=(count, 3))),
        "`Ellipsoids`": lambda: co.Ellipsoids(at, rng.uniform(0.1, 0.3, (count, 3))),
        "`Discs`": lambda: co.Discs(at, along, radii),
        "`Cylinders`": lambda: co.Cylinders(at, at + along, radii),
        "`Cones`": lambda: co.Cones(at, at + along, radii, radii / 2),
        "`Boxes`": lambda: co.Boxes(at, at + rng.uniform(0.05, 0.1, (count, 3))),
        "`Capsules`": lambda: co.Capsules(at, at + along, radii),
    }
    return makers[name]()


def shapes_of(name: str, rng: Any, count: int) -> list[Any]:
    """Return so many bodies of a kind."""
    if name in BULK:
        return [bulk(name, rng, count)]
    make = kinds()[name]
    return [make(rng) for _ in range(count)]


def one_kind(name: str, count: int) -> dict[str, float]:
    """Microseconds for each body: made, prepared the first time, prepared again (other bodies of the kind)."""
    import conicoid as co

    rng = np.random.default_rng(1)
    co.Scene([co.Sphere()]).prepare()  # what any scene needs is imported
    made, prepared = [], []
    for _ in range(1 + RUNS):
        begin = time.process_time()
        shapes = shapes_of(name, rng, count)
        made.append(time.process_time() - begin)
        scene = co.Scene(shapes)
        begin = time.process_time()
        scene.prepare()
        prepared.append(time.process_time() - begin)
    micro = 1e6 / count
    return {"made": min(made) * micro, "first": prepared[0] * micro, "again": min(prepared[1:]) * micro}


def once(name: str, count: int) -> dict[str, float]:
    """Return microseconds for each body, prepared after some of the kind; the system's share; the largest memory.

    The system's share is for memory that is touched for the first time. A few bodies are prepared several times, and
    the least time counts.
    """
    import conicoid as co

    rng = np.random.default_rng(1)
    co.Scene(shapes_of(name, rng, 200)).prepare()
    prepared = []
    for _ in range(RUNS if count <= COUNTS[1] else 1):
        scene = co.Scene(shapes_of(name, rng, count))
        before = resource.getrusage(resource.RUSAGE_SELF)
        scene.prepare()
        after = resource.getrusage(resource.RUSAGE_SELF)
        system = after.ru_stime - before.ru_stime
        prepared.append((after.ru_utime - before.ru_utime + system, system))
    total, system = (1e6 * seconds / count for seconds in min(prepared))
    return {"all": total, "system": system, "GiB": after.ru_maxrss / (1 << 20)}


def linear(gib: float, names: tuple[str, ...] = LINEAR) -> None:
    """Return microseconds for each body (the system's share) in scenes of every size that memory holds."""
    print(
        "| a body | "
        + " | ".join(f"{count:,}" for count in COUNTS)
        + " | GiB |\n|---"
        + "|---" * (len(COUNTS) + 1)
        + "|"
    )
    for name in names:
        cells, memory = [], 0.0
        for before, count in zip((0, *COUNTS), COUNTS, strict=False):
            if before and memory * count / before > gib:
                cells.append("")
                continue
            told = in_a_process("--once", name, str(count))
            cells.append(f"{told['all']:.1f} ({told['system']:.1f})")
            memory = told["GiB"]
        print(f"| {name} | {' | '.join(cells)} | {memory:.2f} |", flush=True)


def in_a_process(*arguments: str) -> Any:
    done = subprocess.run([sys.executable, __file__, *arguments], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def whole_processes(folder: Path) -> None:
    """Scene files to pictures, beside POV-Ray."""
    from comparison import scenes
    from comparison.harness import Absent
    from comparison.peers import POVRAY_TRACE, write_povray

    import conicoid as co

    shapes = {"spheres": scenes.spheres, "quadrics": scenes.cut_balls, "csg": scenes.bored_blocks}
    try:
        version, there = POVRAY_TRACE.find(), True
    except Absent as absent:
        version, there = f"POV-Ray: {absent}", False
    print(
        f"\n| a picture of | bodies | `conicoid render` | POV-Ray | ratio |\n|---|---|---|---|---|\n<!-- {version} -->"
    )
    for kind, make in shapes.items():
        for count in (1_000, 10_000):
            balls = scenes.balls(count)
            camera = co.Camera((0, 0, -3), (0, 0, 0), field_of_view=53.13010235415598)
            scene, pov = folder / f"{kind}{count}.yaml", folder / f"{kind}{count}.pov"
            co.save(co.Scene(make(balls), co.PointLight((3, 4, -5)), camera), scene)
            write_povray(pov, kind, balls)
            size_ = ["--width", "1000", "--height", "1000", "--samples", "1"]
            ours = [sys.executable, "-m", "conicoid", "render", str(scene), "-o", str(folder / "a.png"), *size_]
            theirs = ["povray", f"+I{pov}", "+W1000", "+H1000", "-A", "-D", f"+O{folder / 'b.png'}"]
            mine, its = [], []
            for _ in range(RUNS):  # in turns
                mine.append(seconds(ours))
                its.append(seconds(theirs) if there else float("nan"))
            a, b = statistics.median(mine), statistics.median(its)
            print(f"| {kind} | {count:,} | {a:.2f} s | {b:.2f} s | {b / a:.2f} × |")


def edits(count: int = 10_000, turns: int = 24) -> None:
    """One body of many moved, up to the next first hit: what is held of the scenes before says whose memory is free."""
    from comparison.preparation import _MOVED

    import conicoid as co

    ways = {
        "each from the last": lambda first, held, last, k: last.moved(k, (0, 0, -0.01)),
        "the same, hits are held": lambda first, held, last, k: last.moved(k, (0, 0, -0.01)),
        "each from the first": lambda first, held, last, k: first.moved(7, (0, 0, -0.001 * k)),
        "each is held": lambda first, held, last, k: last.moved(k, (0, 0, -0.01)),
    }
    print(f"\n| one of {count:,} moved, ms (of processors) | | first | second | then |\n|---|---|---|---|---|")
    for kind, (name, shapes) in _MOVED.items():
        for way, edit in ways.items():
            first: Any = co.Scene(shapes(count))
            first.first_hit((0, 0, -3), (0.01, 0.02, 1))
            last, held, hits, found = first, [], None, []
            for k in np.random.default_rng(5).permutation(count)[:turns].tolist():
                first = first if way == "each from the first" else None
                begin = time.perf_counter(), time.process_time()
                last = edit(first, held, last, k)
                t = last.first_hit((0, 0, -3), (0.01, 0.02, 1))
                found.append((time.perf_counter() - begin[0], time.process_time() - begin[1]))
                hits = t if "hits" in way else None
                del t  # which would hold the scene
                held += [last] if way == "each is held" else []
            rows = [*found[:2], tuple(map(statistics.median, zip(*found[2:], strict=True)))]
            cells = [f"{1e3 * wall:.1f} ({1e3 * cpu:.1f})" for wall, cpu in rows]
            print(f"| {name} ({kind}) | {way} | {' | '.join(cells)} |", flush=True)
            del hits, last, held


FACETED = {
    "sphere": "sphere($fn = {n}, $fa = 12, $fs = 2, r = 10);",
    "cylinder": "cylinder($fn = {n}, $fa = 12, $fs = 2, h = 10, r1 = 5, r2 = 5, center = false);",
    "cone": "cylinder($fn = {n}, $fa = 12, $fs = 2, h = 10, r1 = 5, r2 = 2, center = false);",
    "linear_extrude": "linear_extrude(height = 10, scale = [1, 1], $fn = {n}) {{ difference() {{ "
    "circle($fn = {n}, r = 5); circle($fn = {n}, r = 3); }} }}",
    "rotate_extrude": "rotate_extrude(angle = 360, $fn = {n}) {{ "
    "polygon(points = [[2, 0], [5, 0], [5, 3], [2, 4]]); }}",
    "cube - sphere": "difference() {{ cube(size = 18, center = true); sphere($fn = {n}, $fa = 12, $fs = 2, r = 10); }}",
}
"""Calls of OpenSCAD with flat sides, by their number."""


def faceted(path: str) -> dict[str, float]:
    """Processor seconds of a file of one solid with flat sides: loaded, prepared, a first hit; µs a ray of many."""
    import conicoid as co

    co.Scene([co.Sphere()]).first_hit((3, 0, 0), (-1, 0, 0))  # what any scene needs is imported
    rng = np.random.default_rng(1)
    origins = 30 * rng.normal(size=(2_000, 3))
    directions = rng.uniform(-6, 6, (2_000, 3)) - origins
    marks = [time.process_time()]
    scene = co.load(path)
    marks.append(time.process_time())
    scene.prepare()
    marks.append(time.process_time())
    scene.first_hit((30, 1, 2), (-1, 0, 0))
    marks.append(time.process_time())
    scene.first_hit(origins, directions)
    marks.append(time.process_time())
    spent = np.diff(marks).tolist()
    return {"load": spent[0], "prepare": spent[1], "hit": spent[2], "ray": 1e6 * spent[3] / len(origins)}


def faceted_solids(folder: Path, counts: tuple[int, ...] = (20, 100, 400)) -> None:
    """Files of OpenSCAD with $fn, from the file to the first hit."""
    print(
        "\n| $fn, seconds (of processors) | sides | load | prepare | first hit | a ray, µs |\n|---|---|---|---|---|---|"
    )
    for kind, text in FACETED.items():
        for count in counts:
            file = folder / "faceted.csg"
            file.write_text(text.format(n=count) + "\n")
            found = in_a_process("--faceted-file", str(file))
            row = f"{found['load']:.2f} | {found['prepare']:.2f} | {found['hit']:.3f} | {found['ray']:.1f}"
            print(f"| {kind} | {count} | {row} |", flush=True)


def seconds(command: list[str]) -> float:
    own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    begin = time.perf_counter()
    subprocess.run(command, capture_output=True, check=True, env=own)
    return time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--many", type=int, default=100_000, help="bodies of the largest scenes of primitives")
    parser.add_argument("--pictures", action="store_true", help="whole processes alone")
    parser.add_argument("--linear", action="store_true", help="preparing alone, from 1,000 bodies to 1,000,000")
    parser.add_argument("--bulk", action="store_true", help="the same for many bodies in one entry alone")
    parser.add_argument("--memory", type=float, default=24.0, help="GiB that --linear may take, by what fewer took")
    parser.add_argument("--once", nargs=2, metavar=("KIND", "COUNT"), help=argparse.SUPPRESS)
    parser.add_argument("--edits", action="store_true", help="one body moved among many, alone")
    parser.add_argument("--faceted", action="store_true", help="files of OpenSCAD with $fn alone")
    parser.add_argument("--faceted-file", help=argparse.SUPPRESS)
    parser.add_argument("--one", nargs=2, metavar=("KIND", "COUNT"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.pictures:
        with tempfile.TemporaryDirectory() as folder:
            whole_processes(Path(folder))
        return
    if arguments.linear or arguments.bulk:
        linear(arguments.memory, BULK if arguments.bulk else LINEAR)
        return
    if arguments.once:
        print(json.dumps(once(arguments.once[0], int(arguments.once[1]))))
        return
    if arguments.faceted:
        with tempfile.TemporaryDirectory() as folder:
            faceted_solids(Path(folder))
        return
    if arguments.faceted_file:
        print(json.dumps(faceted(arguments.faceted_file)))
        return
    if arguments.edits:
        edits()
        return
    if arguments.one:
        print(json.dumps(one_kind(arguments.one[0], int(arguments.one[1]))))
        return
    print(
        f"{date.today()}, {platform.processor() or platform.machine()}, Python {platform.python_version()}, µs a body\n"
    )
    print("| a body | made | 1,000 at first | 1,000 | 10,000 | many |\n|---|---|---|---|---|---|")
    for name in (*kinds(), *BULK):
        small = in_a_process("--one", name, "1000")
        boolean = "3 cylinders" in name or "&" in name
        large = in_a_process("--one", name, "10000") if "turned" not in name or "&" not in name else None
        many = None if boolean else in_a_process("--one", name, str(arguments.many))
        cells = [f"{each['again']:.1f}" if each else "" for each in (large, many)]
        print(
            f"| {name} | {small['made']:.1f} | {small['first']:.1f} | {small['again']:.1f} | {' | '.join(cells)} |",
            flush=True,
        )
    edits()
    with tempfile.TemporaryDirectory() as folder:
        faceted_solids(Path(folder))
        whole_processes(Path(folder))


if __name__ == "__main__":
    main()
