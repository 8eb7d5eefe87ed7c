#!/usr/bin/env python3
"""Compare a GPU with the CPU, to the bit, and print its rates: from wheels, in a new environment, in some minutes.

    .ci/gpu.py                       build both wheels, and try them (`make test-cuda`)
    .ci/gpu.py WHEEL CUDA_WHEEL      try these
    .ci/gpu.py --here                compare and measure in this environment, which has both
    .ci/gpu.py --few                 compare few rays, without rates: for NVIDIA's compute-sanitizer

Exit status: 0 if all answers are equal, 2 if something is missing. Rates are of whole calls: to NumPy arrays and back,
or with arrays that stay on the card. The first call of a kernel is not among them: the driver may translate the kernel
then, and keeps that on disk. Who has a card for ten minutes makes the wheels before (`python -m native.wheels host
cuda`), and passes them.

This file is not called cuda.py, since Python would take it for NVIDIA's package `cuda`.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SIDE, FEW = 1024, 64
"""Of pictures; as many random rays and points. 64 for tools that slow a card down a hundredfold."""
DEVICES = "cuda", "cpu"
PATIENCE = 0.7
"""Seconds of one rate."""
FIELDS = "t", "body", "face", "surface", "entering", "doubtful"
THERE = *FIELDS, "point", "normal", "uv"


def built(folder: Path) -> list[Path]:
    """The wheels for this machine and for its card."""
    subprocess.run([sys.executable, "-m", "native.wheels", "host", "cuda", "--out", str(folder)], cwd=ROOT, check=True)
    return sorted(folder.glob("*.whl"))


def tried(wheels: list[Path], folder: Path) -> int:
    """The exit status of `--here` in a new environment."""
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    subprocess.run([*pip, *wheels], check=True)
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("CONICOID_", "PYTHONPATH"))
    }
    state = subprocess.run([python, __file__, "--here"], cwd=folder, env=environment, check=False).returncode
    print("To look for reads and writes out of place, and of memory that nobody wrote, in an environment with both:")
    for tool in ("memcheck", "initcheck"):
        print(f"    compute-sanitizer --tool {tool} python .ci/gpu.py --few")
    return state


def scenes() -> dict[str, Any]:
    """Balls, cut quadrics and Booleans of five, nine and seventy leaves."""
    import numpy as np

    import conicoid as co

    def places(count: int) -> tuple[Any, Any]:
        r = np.random.default_rng(count)
        return r.uniform(-1, 1, (count, 3)), r.uniform(0.4, 0.8, count) * count ** (-1 / 3)

    def turned(make: Callable[[Any], Any], count: int) -> Any:
        r = np.random.default_rng(7)
        return co.Scene(
            [
                make(r)
                .scale(float(size))
                .rotate(tuple(r.normal(size=3)), float(r.uniform(0, 360)))
                .translate(tuple(at))
                for at, size in zip(*places(count), strict=True)
            ]
        )

    def quadric(r: Any) -> Any:
        kinds = (
            co.Cylinder((0, 0, -0.6), (0, 0, 0.6), 0.8),
            co.Cone((0, 0, -0.6), (0, 0, 0.6), 0.8, 0.2),
            co.Ellipsoid((0.8, 0.5, 0.9)),
        )
        return kinds[r.integers(3)]

    def drilled(r: Any) -> Any:
        holes = [
            co.Cylinder(*ends, 0.35)
            for ends in (((-1, 0, 0), (1, 0, 0)), ((0, -1, 0), (0, 1, 0)), ((0, 0, -1), (0, 0, 1)))
        ]
        return (co.Box((-0.7,) * 3, (0.7,) * 3) & co.Sphere(0.95)) - holes[0] - holes[1] - holes[2]

    def carved(leaves: int) -> Callable[[Any], Any]:
        def make(r: Any) -> Any:
            balls = [co.Sphere(0.25).translate(tuple(r.uniform(-0.8, 0.8, 3))) for _ in range(leaves - 1)]
            return co.Difference([co.Box((-0.7,) * 3, (0.7,) * 3), *balls])

        return make

    return {
        "1,000 balls": co.Scene([co.Spheres(*places(1000))]),
        "100,000 balls": co.Scene([co.Spheres(*places(100_000))]),
        "1,000 cut quadrics": turned(quadric, 1000),
        "1,000 Booleans of 5": turned(drilled, 1000),
        "100 Booleans of 9": turned(carved(9), 100),
        "30 Booleans of 70": turned(carved(70), 30),
    }


def wrong_lists(scene: Any, rays: Any) -> list[str]:
    """Fields of spans and crossings, and sums over spans, that differ, of one ray in sixteen."""
    import numpy as np

    some, wrong = [each.reshape(-1, 3)[::16] for each in rays], []
    for query in (scene.spans, scene.crossings):
        there, here = (query(*some, device=each) for each in DEVICES)
        wrong += [x for x in ("offsets", *here._columns) if getattr(there, x).tobytes() != getattr(here, x).tobytes()]
    values = np.linspace(0, 1, scene.body_count)
    sums = [scene.line_integral(values, *some, overlaps="both", device=each).tobytes() for each in DEVICES]
    return wrong + (["line_integral"] if sums[0] != sums[1] else [])


def wrong_there(scene: Any, rays: Any, sent: Callable[..., Any]) -> list[str]:
    """What differs where arrays stay, of one ray in sixteen: spans, sums, float32, gaps, rays that start on hits."""
    import numpy as np

    def differing(there: Any, here: Any, names: Sequence[str]) -> list[str]:
        return [x for x in names if np.asarray(getattr(there, x)).tobytes() != np.asarray(getattr(here, x)).tobytes()]

    some = [each.reshape(-1, 3)[::16] for each in rays]
    arrays, singles = ([sent(each.astype(kind)) for each in some] for kind in ("f8", "f4"))
    wrong = differing(scene.first_hit(*singles), scene.first_hit(*(each.astype("f4") for each in some)), THERE)
    there, here = scene.first_hit(*arrays), scene.first_hit(*some)
    directions = np.random.default_rng(2).normal(size=some[1].shape)
    lists = [(arrays, some), ([there.spawn(sent(directions))], [here.spawn(directions)])]
    values = np.linspace(0, 1, scene.body_count)
    for mine, right in lists:
        wrong += differing(scene.first_hit(*mine), scene.first_hit(*right), THERE)
        for query in (scene.spans, scene.crossings):
            expected = query(*right)
            wrong += differing(query(*mine).to_host(), expected, ("offsets", *expected._columns))
        sums = [scene.line_integral(values, *each, overlaps="both") for each in (mine, right)]
        wrong += ["line_integral"] if np.asarray(sums[0]).tobytes() != sums[1].tobytes() else []
    return wrong + differing(scene.distance(arrays[0]), scene.distance(some[0]), ("distance", "lower", "error"))


def alone(query: Callable[..., Any], *arrays: Any) -> str:
    """How many millions a second a card answers where rays and answers stay there."""
    times: list[float] = []
    while len(times) < 9 and sum(times) < PATIENCE / 2:
        begin = time.perf_counter()
        query(*arrays)
        times.append(time.perf_counter() - begin)
    return f"{arrays[0].size / 3e6 / sorted(times)[len(times) // 2]:.0f}"


def pictures(scene: Any, side: int) -> tuple[list[str], str]:
    """Integrators whose pictures differ; and how many millions of paths a second both devices follow."""
    wrong, speeds = [], []
    for integrator in ("normals", "whitted", "path"):
        times, found = [], []
        for device in DEVICES:
            scene.render(side, side, 1, integrator, device=device)  # loads the kernel
            begin = time.perf_counter()
            found.append(scene.render(side, side, 16, integrator, device=device).pixels.tobytes())
            times.append(16e-6 * side * side / (time.perf_counter() - begin))
        wrong += [integrator] if found[0] != found[1] else []
        speeds.append(f"{integrator} {times[0]:.1f} ({times[1]:.1f})")
    return wrong, ", ".join(speeds)


def beside(scene: Any, other: Any, rays: Any) -> bool:
    """Whether two threads with two scenes get the answers that each gets alone."""
    from concurrent.futures import ThreadPoolExecutor

    expected = [each.first_hit(rays, device="cpu").t.tobytes() for each in (scene, other)]
    with ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda each: each.first_hit(rays, device="cuda").t.tobytes(), [scene, other] * 4)
        return list(found) == expected * 4


def refusal(scene: Any, rays: Any, driver: Any) -> str:
    """What a query says on a card whose memory is taken, and that it answers afterwards."""
    taken, size = [], 1 << 34
    while size >= 1 << 20:
        try:
            taken.append(driver.allocate(size))
        except MemoryError:
            size //= 2
    try:
        scene.first_hit(rays, device="cuda")
        said = "answered, though nearly all memory was taken"
    except MemoryError as error:
        said = str(error)
    for address in taken:
        driver.release(address)
    scene.first_hit(rays, device="cuda")
    return said


def rates(query: Callable[..., Any], *arguments: Any) -> str:
    """How many millions a second each device answers: the median of up to five calls, after the ones before."""
    found = []
    for device in DEVICES:
        times: list[float] = []
        while len(times) < 5 and sum(times) < PATIENCE:
            begin = time.perf_counter()
            query(*arguments, device=device)
            times.append(time.perf_counter() - begin)
        found.append(SIDE * SIDE / 1e6 / sorted(times)[len(times) // 2])
    return f"{found[0]:.0f} ({found[1]:.0f})"


def here(side: int) -> int:
    """Compare and measure, with pictures of this side."""
    import numpy as np

    import conicoid as co
    from conicoid.queries.device_arrays import upload
    from conicoid.queries.device_choice import device_of

    try:
        found = device_of("test-cuda", "cuda")
    except (ImportError, RuntimeError) as error:
        print(error)
        return 2
    assert found is not None
    print(f"{getattr(found.driver, 'name', '')}; rates in millions a second, whole calls: GPU, and CPU in brackets")
    start, few = time.perf_counter(), side < SIDE
    r, count, failures = np.random.default_rng(1), side * side, 0
    camera = co.Camera((0.3, -0.2, -3.2), (0, 0, 0), field_of_view=45).rays(side, side)
    lists = {"camera": camera, "random": co.Rays(r.uniform(-1, 1, (count, 3)), r.normal(size=(count, 3)))}
    points = r.uniform(-1, 1, (count, 3))
    every = scenes()
    for name, scene in every.items():
        for kind, rays in lists.items():
            begin = time.perf_counter()
            there, hits = (scene.first_hit(rays, device=each) for each in DEVICES)
            wrong = [each for each in FIELDS if getattr(there, each).tobytes() != getattr(hits, each).tobytes()]
            if not np.array_equal(*(scene.occluded(rays, device=each) for each in DEVICES)):
                wrong.append("occluded")
            wrong += wrong_lists(scene, rays)
            failures += len(wrong)
            first = f"first calls {time.perf_counter() - begin:.1f} s, {int(hits.doubtful.sum())} doubtful"
            verdict = f"DIFFERENT: {', '.join(wrong)}" if wrong else "equal to the bit"
            arrays = [upload(found, np.asarray(each)) for each in rays]
            stays = scene.first_hit(*arrays)
            wrong = [x for x in THERE if np.asarray(getattr(stays, x)).tobytes() != getattr(hits, x).tobytes()]
            wrong += wrong_there(scene, rays, partial(upload, found))
            failures += len(wrong)
            verdict += f"; DIFFERENT where arrays stay: {', '.join(wrong)}" if wrong else ", also where arrays stay"
            speeds = (
                ""
                if few
                else f"{rates(scene.first_hit, rays)}, {alone(scene.first_hit, *arrays)} where they stay, "
                f"{rates(partial(scene.line_integral, np.ones(scene.body_count), overlaps='both'), rays)} integrals; "
            )
            print(f"{name}, {kind}: {speeds}{verdict}; {first}", flush=True)
        equal = np.array_equal(*(scene.body_at(points, device=each) for each in DEVICES))
        failures += not equal
        speeds = "" if few else f"{rates(scene.body_at, points)}; "
        print(f"{name}, points: {speeds}{'equal' if equal else 'DIFFERENT'}", flush=True)
        wrong, speeds = pictures(scene, side // 4)
        failures += len(wrong)
        verdict = f"DIFFERENT: {', '.join(wrong)}" if wrong else "equal"
        print(f"{name}, pictures: {'' if few else f'{speeds}; '}{verdict}", flush=True)
    if not few:
        scene, other = every["100,000 balls"], every["100 Booleans of 9"]
        equal = beside(scene, other, lists["camera"])
        failures += not equal
        print(f"two threads with two scenes: {'equal' if equal else 'DIFFERENT'}")
        print(f"without memory: {refusal(co.Scene([*scene.bodies]), lists['camera'], found.driver)}")
    print(f"{time.perf_counter() - start:.0f} s, {'all equal' if not failures else f'{failures} DIFFERENT'}")
    return int(failures > 0)


def main() -> int:
    """As the command line says."""
    if sys.argv[1:] in (["--here"], ["--few"]):
        return here(SIDE if sys.argv[1] == "--here" else FEW)
    with tempfile.TemporaryDirectory() as temporary:
        wheels = [Path(each).resolve() for each in sys.argv[1:]] or built(Path(temporary) / "dist")
        return tried(wheels, Path(temporary) / "environment")


if __name__ == "__main__":
    sys.exit(main())
