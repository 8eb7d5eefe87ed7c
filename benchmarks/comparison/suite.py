"""The rows of the benchmark: the comparisons, and their required ratios.

Every row runs Conicoid and its peer in turn, five turns each, and compares medians; a ratio above one means that
Conicoid is faster. Before that the two must agree on hits and their places. The rows of `limits.py` have no peer: a
limit stands in its place.
"""

from __future__ import annotations

import math
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.table import Table

from conicoid._util.files import write_text
from conicoid.geometry.body import Body
from conicoid.geometry.shape import Shape
from conicoid.kernels.threads import set_threads
from conicoid.materials.light import AmbientLight, PointLight
from conicoid.materials.presets import matte
from conicoid.queries.rays import Rays
from conicoid.render.camera import Camera
from conicoid.scene.scene import Scene

from . import arrays, harness, limits, peers, preparation, startup
from .harness import QUICK, BenchRow, Measured, Peer, Size
from .scenes import (
    PINS,
    BallRows,
    Floats,
    Singles,
    balls,
    bored_blocks,
    boxes,
    camera_rays,
    capped_quadrics,
    cut_balls,
    growing_balls,
    random_rays,
    rays_of_view,
    spheres,
    write_core,
)

WARM = 0.1  # seconds


def time_in_turn(ours: Callable[[], float], theirs: Callable[[], float], runs: int) -> tuple[float, float]:
    """Return medians of seconds, run alternately.

    Every turn begins with runs that do not count, for a tenth of a second: the one that counts finds the caches as its
    own kind leaves them, and the other's threads at rest.
    """

    def turn(run: Callable[[], float]) -> float:
        begin = time.perf_counter()
        run()
        while time.perf_counter() - begin < WARM:
            run()
        return run()

    rounds = [(turn(ours), turn(theirs)) for _ in range(runs)]
    return statistics.median(a for a, _ in rounds), statistics.median(b for _, b in rounds)


def check_agreement(ours: Floats, theirs: Floats) -> str:
    """Return the fault of two sets of distances, one of them in single precision; nothing if they agree."""
    a, b = np.isfinite(ours), np.isfinite(theirs)
    if (a != b).mean() > 2e-3:
        return f"{100 * (a != b).mean():.2g} % of the rays hit for one only"
    both = a & b
    off = np.abs(ours[both] - theirs[both]) > 1e-3 * (1 + ours[both])
    return f"{100 * off.mean():.2g} % of the distances differ" if off.mean() > 2e-3 else ""


def _rate(count: int, ours: float, theirs: float, ours_t: Floats, theirs_t: Floats) -> Measured:
    return Measured(
        count / ours / 1e6, count / theirs / 1e6, theirs / ours, "Mray/s", check_agreement(ours_t, theirs_t)
    )


def _rays(coherent: bool, size: Size) -> tuple[Rays, Singles, Singles]:
    """Rays as we take them (a camera's as a picture), and as flat arrays."""
    if not coherent:
        flat = random_rays(size.rays)
        return Rays(*flat), *flat
    origins, directions = camera_rays(size.width)
    return Rays(origins, directions), origins.reshape(-1, 3), directions.reshape(-1, 3)


def _timed(scene: Scene, rays: Rays) -> Callable[[], float]:
    def run() -> float:
        begin = time.perf_counter()
        scene.first_hit(rays)
        return time.perf_counter() - begin

    return run


def with_mitsuba(shapes: Callable[[int], list[Shape]], count: int, coherent: bool) -> Callable[[Size], Measured]:
    """Against Mitsuba on as many balls; where ours are others, its hits are compared with ours on its balls."""

    def measure(size: Size) -> Measured:
        rays, origins, directions = _rays(coherent, size)
        scene = Scene(shapes(count))
        alike = scene if shapes is bulk else Scene(bulk(count))
        ours = _timed(scene, rays)
        with peers.MitsubaScene(balls(count), origins, directions, coherent) as theirs:
            seconds = time_in_turn(ours, theirs.seconds, size.runs)
            return _rate(len(origins), *seconds, alike.first_hit(rays).t.ravel(), theirs.distances())

    return measure


def with_embree(count: int, coherent: bool) -> Callable[[Size], Measured]:
    def measure(size: Size) -> Measured:
        rays, origins, directions = _rays(coherent, size)
        scene = Scene(bulk(count))
        with peers.EmbreeScene(balls(count)) as theirs:
            seconds = time_in_turn(_timed(scene, rays), lambda: theirs.first_hits(origins, directions)[0], size.runs)
            found = theirs.first_hits(origins, directions)[1]
        return _rate(len(origins), *seconds, scene.first_hit(rays).t.ravel(), found)

    return measure


def with_raysect(coherent: bool) -> Callable[[Size], Measured]:
    """One core each, all the rays: every 64th of a camera's would cost Raysect a fifth more."""

    def measure(size: Size) -> Measured:
        rays, origins, directions = _rays(coherent, size)
        scene, theirs = Scene(bulk(1000)), peers.RaysectScene(balls(1000), origins, directions)
        with one_thread():
            seconds = time_in_turn(_timed(scene, rays), lambda: theirs.first_hits()[0], size.runs)
        return _rate(len(origins), *seconds, scene.first_hit(rays).t.ravel(), theirs.first_hits()[1])

    return measure


@contextmanager
def one_thread() -> Iterator[None]:
    """Conicoid on one core."""
    set_threads(1)
    try:
        yield
    finally:
        set_threads(None)


def with_trimesh(size: Size) -> Measured:
    rays, origins, directions = _rays(True, size)
    blocks = boxes(1000)
    scene, theirs = Scene(blocks.shapes()), peers.TrimeshScene(blocks, origins, directions)
    seconds = time_in_turn(_timed(scene, rays), theirs.seconds, size.runs)
    return _rate(len(origins), *seconds, scene.first_hit(rays).t.ravel(), theirs.distances())


def with_povray(kind: str, shapes: Callable[[BallRows], list[Shape]]) -> Callable[[Size], Measured]:
    """A picture with one shadowed light."""

    def measure(size: Size) -> Measured:
        grey = matte((0.8, 0.8, 0.8), ambient=1.0, diffuse=0.8)
        scene = Scene(
            [Body(shape, material=grey) for shape in shapes(balls(1000))],
            lights=[AmbientLight(0.1), PointLight((3, 4, -5))],
            background=(0, 0, 0),
            camera=Camera((0, 0, -3), (0, 0, 0), up=(0, 1, 0), field_of_view=2 * math.degrees(math.atan(0.5))),
        )
        with tempfile.TemporaryDirectory(prefix="conicoid-bench-") as folder:
            file = Path(folder) / "scene.pov"
            peers.write_povray(file, kind, balls(1000))

            def ours() -> float:
                begin = time.perf_counter()
                scene.render(size.width, size.width, samples=1)
                return time.perf_counter() - begin

            seconds = time_in_turn(ours, lambda: peers.trace_povray(file, size.width)[0], size.runs)
            theirs = peers.trace_povray(file, size.width)[1]
        lit = scene.render(size.width, size.width, samples=1).pixels.max(axis=-1) > 0
        differ = float((lit != (theirs > 0)).mean())
        note = f"{100 * differ:.2g} % of the pixels are lit for one only" if differ > 5e-3 else ""
        return Measured(seconds[0], seconds[1], seconds[1] / max(seconds[0], 1e-9), "s", note)

    return measure


def building(size: Size) -> Measured:
    each = balls(size.balls)

    def ours() -> float:
        scene = Scene([Body(shape) for shape in each.shapes()])
        begin = time.perf_counter()
        _ = scene._prepared
        return time.perf_counter() - begin

    def theirs() -> float:
        with peers.EmbreeScene(each) as scene:
            return scene.build_seconds

    seconds = time_in_turn(ours, theirs, size.runs)
    return Measured(*seconds, seconds[1] / seconds[0], "s")


def growth(size: Size) -> Measured:
    """Nanoseconds a ray for a thousand balls and for the most; the ratio is how far that stays below eight times."""
    rays, _, _ = _rays(True, size)
    small, large = (Scene(growing_balls(count).shapes()) for count in (1000, size.balls))
    one, many = time_in_turn(_timed(small, rays), _timed(large, rays), size.runs)
    scale = 1e9 / size.width**2
    return Measured(one * scale, many * scale, 8 * one / many, "ns/ray")


def core_rays(size: Size) -> Measured:
    """Nanoseconds a ray for a whole core and for one assembly, seen alike; the ratio: how far below four times."""
    many = preparation.ASSEMBLIES if size.balls >= Size().balls else 2
    runs = []
    with startup.open_sandbox() as where:
        for across in (many, 1):
            write_core(where.folder / "geometry.xml", across)
            scene = preparation.open_core(where.folder / "geometry.xml", 4 * (across * PINS) ** 2)
            runs.append(_timed(scene, rays_of_view("from above", across, size.width)))
    whole, one = time_in_turn(runs[0], runs[1], size.runs)
    scale = 1e9 / size.width**2
    return Measured(whole * scale, one * scale, 4 * one / whole, "ns/ray")


def all_spans(shapes: Callable[[int], list[Shape]]) -> Callable[[Size], Measured]:
    """Every span of a camera's rays, against the same rays in no order, which are traced one by one."""

    def measure(size: Size) -> Measured:
        origins, directions = camera_rays(size.width)
        order = np.random.default_rng(2).permutation(size.width**2)
        flat = Rays(origins.reshape(-1, 3)[order], directions.reshape(-1, 3)[order])
        scene, rays = Scene(shapes(1000)), Rays(origins, directions)

        def seconds(which: Rays) -> float:
            begin = time.perf_counter()
            scene.spans(which)
            return time.perf_counter() - begin

        ours, theirs = time_in_turn(lambda: seconds(rays), lambda: seconds(flat), size.runs)
        one, other = scene.spans(rays), scene.spans(flat)
        same = np.array_equal(np.diff(one.offsets)[order], np.diff(other.offsets))
        same &= math.isclose((one.t_exit - one.t_enter).sum(), (other.t_exit - other.t_enter).sum(), rel_tol=1e-9)
        note = "" if same else "lengths differ"
        return Measured(len(order) / ours / 1e6, len(order) / theirs / 1e6, theirs / ours, "Mray/s", note)

    return measure


def bulk(count: int) -> list[Shape]:
    """As many balls as one shape."""
    return balls(count).shapes()


def quadrics(count: int) -> list[Shape]:
    return capped_quadrics(count).shapes()


def blocks(count: int) -> list[Shape]:
    return bored_blocks(balls(count))


_CAMERA, _RANDOM, _PICTURE = "camera", "random", "picture, one shadowed light"
_OURS = Peer("itself", "8 × as dear at most", lambda: "")
_ONE = Peer("itself", "4 × as dear at most", lambda: "")
_SINGLE = Peer("itself", "one ray at a time", lambda: "")

ROWS = (
    *preparation.ROWS,
    *(
        BenchRow(f"camera-{n}", _CAMERA, f"{n:,} balls", peers.MITSUBA, 0.8, 1.2, with_mitsuba(bulk, n, True))
        for n in (1000, 20_000, 100_000)
    ),
    *(
        BenchRow(
            f"camera-quadrics-{n}",
            _CAMERA,
            f"{n:,} capped quadrics (the peer: balls)",
            peers.MITSUBA,
            0.5,
            1.0,
            with_mitsuba(quadrics, n, True),
        )
        for n in (1000, 20_000)
    ),
    BenchRow("camera-embree", _CAMERA, "100,000 balls", peers.EMBREE, 2.5, 4.0, with_embree(100_000, True)),
    BenchRow("random-1000", _RANDOM, "1,000 balls", peers.MITSUBA, 1.5, 3.0, with_mitsuba(bulk, 1000, False)),
    BenchRow("random-20000", _RANDOM, "20,000 balls", peers.MITSUBA, 2.0, 3.0, with_mitsuba(bulk, 20_000, False)),
    BenchRow("random-embree", _RANDOM, "100,000 balls", peers.EMBREE, 0.8, 1.2, with_embree(100_000, False)),
    BenchRow("camera-raysect", _CAMERA, "1,000 balls, one core", peers.RAYSECT, 20.0, 0.0, with_raysect(True)),
    BenchRow("random-raysect", _RANDOM, "1,000 balls, one core", peers.RAYSECT, 6.0, 0.0, with_raysect(False)),
    BenchRow("camera-trimesh", _CAMERA, "1,000 boxes", peers.TRIMESH, 0.0, 0.0, with_trimesh),
    *(
        BenchRow(f"spans-{name}", "camera, all spans", f"1,000 {scene}", _SINGLE, 0.0, 0.0, all_spans(shapes))
        for name, scene, shapes in (
            ("balls", "balls", bulk),
            ("quadrics", "capped quadrics", quadrics),
            ("csg", "bodies of 5 leaves", blocks),
        )
    ),
    BenchRow("picture-balls", _PICTURE, "1,000 balls", peers.POVRAY_TRACE, 4.0, 0.0, with_povray("spheres", spheres)),
    BenchRow(
        "picture-quadrics",
        _PICTURE,
        "1,000 cut quadrics",
        peers.POVRAY_TRACE,
        4.0,
        0.0,
        with_povray("quadrics", cut_balls),
    ),
    BenchRow(
        "picture-csg",
        _PICTURE,
        "1,000 bodies of 5 leaves",
        peers.POVRAY_TRACE,
        3.0,
        0.0,
        with_povray("csg", bored_blocks),
    ),
    BenchRow("build", "tree", "1,000,000 balls", peers.EMBREE, 0.2, 1.0, building),
    BenchRow("growth", _CAMERA, "balls, constant hit rate: 1,000 and (as the peer) the most", _OURS, 1.0, 0.0, growth),
    BenchRow(
        "core-rays",
        _CAMERA,
        f"a core of {(preparation.ASSEMBLIES * PINS) ** 2:,} pins and (as the peer) one assembly, seen from above",
        _ONE,
        1.0,
        0.0,
        core_rays,
    ),
    *startup.ROWS,
    *arrays.ROWS,
    *limits.ROWS,
)


# The command as a function: time the rows, write the file, return the report.


class BenchSummary(NamedTuple):
    """The results of a benchmark, for a terminal and as Markdown, and lines about machine and versions."""

    table: Table
    markdown: str
    about: list[str]


def measure(wanted: Sequence[str], quick: bool, figures: Path | None, tell: Callable[[str], None]) -> BenchSummary:
    """Measure, and call `tell` with each row as it comes. Raises ValueError for an unknown row."""
    chosen = select_rows(wanted)
    size = QUICK if quick else Size()
    outcomes = harness.run(chosen, size, lambda outcome: tell("  ".join(filter(None, outcome.cells()))))
    about = harness.machine(row.peer for row in chosen)
    if figures is not None:
        write_text(figures, harness.as_json(outcomes, about))
    return BenchSummary(harness.table(outcomes), harness.markdown(outcomes, about), about)


def select_rows(wanted: Sequence[str]) -> list[BenchRow]:
    """The rows of these names, or all."""
    known = {row.name: row for row in ROWS}
    unknown = sorted(set(wanted) - set(known))
    if unknown:
        raise ValueError(f"bench: there is no row {unknown[0]!r}; the rows are {', '.join(known)}")
    return [known[name] for name in wanted] if wanted else list(ROWS)
