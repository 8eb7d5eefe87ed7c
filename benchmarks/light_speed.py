"""Light transport beside Mitsuba 3 in one run: samples a second, and the time to the same noise.

    python benchmarks/light_speed.py [--size 512] [--samples 64] [--runs 5] [--threads N] [--python PYTHON]
        [--variant llvm_ad_rgb]

1,000 matte balls: paths under an even sky, of at most five scatterings (Mitsuba's depth of 6), and direct light from a
point. Then balls with three bores in a box, five leaves each, in place of the balls, which only we have. Mitsuba runs
by PYTHON, which has it installed, in a process for each of its pictures, since scenes in one process slow each other;
its LLVM variants need DRJIT_LIBLLVM_PATH. All take turns, each with a warm-up before, and the shortest times count: of
the wall and, as other programs may run, of processors. Noise is that of two pictures with different seeds, whose
difference has twice the variance of either; the time to a given root mean square of it goes with variance times time.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
EYE, TARGET, ANGLE = (0.0, 0.0, -3.0), (0.0, 0.0, 0.0), math.degrees(2 * math.atan(0.5))
LIGHT, GREY = (2.0, 3.0, -4.0), 0.7
TURNS = 5
SAMPLERS = ("independent", "ldsampler")
"""Mitsuba's default, and the one whose points are as evenly spread as ours."""


class Timed(NamedTuple):
    """A picture's shortest times, in seconds, and the variance of its pixels."""

    wall: float
    processor: float
    variance: float
    mean: float


Render = Callable[[int], tuple[float, float, Any]]
"""By seed: seconds of the wall, seconds of processors, and the pixels."""


def main() -> None:
    """Print both tables."""
    if len(sys.argv) > 1 and sys.argv[1] == "--worker":
        worker(Path(sys.argv[2]))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    import conicoid as co
    from conicoid.kernels.threads import thread_count

    if options.threads:
        co.set_threads(options.threads)
    rays = options.size**2 * options.samples
    print(f"{options.size} x {options.size} pixels, {options.samples} samples, {thread_count()} threads\n")
    print("| light | who | Msamples/s | per processor second | mean | RMS of noise |")
    print("|---|---|---|---|---|---|")
    found, ours = {}, our_pictures(options)
    for kind in ("paths", "direct"):
        with contextlib.ExitStack() as open_peers:
            peers = {name: open_peers.enter_context(Peer(options, kind, name)) for name in SAMPLERS}
            theirs = {f"Mitsuba, {name}": peer.picture for name, peer in peers.items()}
            found[kind] = in_turns({"ours": ours[kind], **theirs}, options.runs)
        told(kind, found[kind], rays)
    found["bored"] = in_turns({"balls": ours["paths"], "bored": ours["bored"]}, options.runs)
    told("paths", {"bored balls, ours": found["bored"]["bored"]}, rays)
    print()
    for kind in ("paths", "direct"):
        for name, theirs in found[kind].items():
            if name != "ours":
                compared(kind, found[kind]["ours"], name, theirs)
    each, of = found["bored"]["bored"], found["bored"]["balls"]
    print(f"bored balls / balls: rate {of.wall / each.wall:.2f} (processors: {of.processor / each.processor:.2f})")


def told(kind: str, rows: dict[str, Timed], rays: int) -> None:
    """Rows of the table."""
    for name, one in rows.items():
        rates = f"{rays / one.wall / 1e6:.2f} | {rays / one.processor / 1e6:.2f}"
        print(f"| {kind} | {name} | {rates} | {one.mean:.5f} | {math.sqrt(one.variance):.5f} |", flush=True)


def compared(kind: str, ours: Timed, name: str, theirs: Timed) -> None:
    """A line of ratios."""
    wall, processor = theirs.wall / ours.wall, theirs.processor / ours.processor
    noise = ours.variance / theirs.variance
    print(
        f"{kind}, against {name}: rate x {wall:.2f} (processors: {processor:.2f}), "
        f"time to the same noise x {noise / wall:.2f} ({noise / processor:.2f})"
    )


def in_turns(pictures: dict[str, Render], runs: int) -> dict[str, Timed]:
    """All pictures, one after the other and again, after a warm-up of each."""
    for render in pictures.values():
        render(0)
    made: dict[str, list[tuple[float, float, Any]]] = {name: [] for name in pictures}
    for run in range(max(2, runs)):
        for name, render in pictures.items():
            made[name].append(render(run + 1))
    return {name: _timed(all_runs) for name, all_runs in made.items()}


def _timed(runs: list[tuple[float, float, Any]]) -> Timed:
    wall, processor, pixels = zip(*runs, strict=True)
    variance = 0.5 * float(np.mean((pixels[0].astype(float) - pixels[1].astype(float)) ** 2))
    return Timed(min(wall), min(processor), variance, float(np.mean([one.mean() for one in pixels])))


def our_pictures(options: argparse.Namespace) -> dict[str, Render]:
    """Ours by name."""
    from comparison.scenes import balls, bored_blocks

    import conicoid as co

    each, camera, grey = balls(1000), co.Camera(EYE, TARGET, up=(0, 1, 0), field_of_view=ANGLE), co.matte((GREY,) * 3)
    whole = [co.Body(shape, grey) for shape in each.shapes()]
    bored = [co.Body(shape, grey) for shape in bored_blocks(each)]
    point = [co.PointLight(LIGHT, 10 / math.pi, falloff="inverse_square")]

    def picture(integrator: str, bodies: list[Any], **more: Any) -> Render:
        scene, size = co.Scene(bodies, camera=camera, **more), options.size

        def render(seed: int) -> tuple[float, float, Any]:
            wall, processor = time.perf_counter(), time.process_time()
            pixels = scene.render(size, size, options.samples, integrator, seed, depth=TURNS).pixels
            return time.perf_counter() - wall, time.process_time() - processor, pixels

        return render

    return {
        "paths": picture("path", whole, background="white"),
        "bored": picture("path", bored, background="white"),
        "direct": picture("direct", whole, lights=point, background="black"),
    }


# ---- Mitsuba's side: knows nothing of ours but the balls ----


class Peer:
    """Mitsuba with one picture; use it in a `with` block."""

    def __init__(self, options: argparse.Namespace, kind: str, sampler: str) -> None:
        from comparison.scenes import balls

        each = balls(1000)
        self._held = tempfile.TemporaryDirectory()
        self._folder = Path(self._held.name)
        given = dict(
            vars(options), kind=kind, sampler=sampler, centers=each.centers.tolist(), radii=each.radii.tolist()
        )
        (self._folder / "task.json").write_text(json.dumps(given), encoding="utf-8")
        self._process = subprocess.Popen(
            [options.python, __file__, "--worker", str(self._folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        self._held.cleanup()

    def picture(self, seed: int) -> tuple[float, float, Any]:
        """The picture with a seed, and its seconds: of the wall, and of processors."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{seed}\n")
        self._process.stdin.flush()
        wall, processor = map(float, self._process.stdout.readline().split())
        return wall, processor, np.load(self._folder / "picture.npy")


def worker(folder: Path) -> None:
    """For each line on the input a picture, and its seconds."""
    import mitsuba as mi  # type: ignore[import-not-found]

    task = json.loads((folder / "task.json").read_text(encoding="utf-8"))
    mi.set_variant(task["variant"])
    import drjit as dr  # type: ignore[import-not-found]

    if task["threads"]:
        dr.set_thread_count(task["threads"])
    scene = _scene(mi, task, task["kind"], task["sampler"])
    for seed in sys.stdin:
        wall, processor = time.perf_counter(), time.process_time()
        pixels = np.array(mi.render(scene, spp=task["samples"], seed=int(seed)))
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        np.save(folder / "picture.npy", pixels)
        print(wall, processor, flush=True)


def _scene(mi: Any, task: dict[str, Any], kind: str, sampler: str) -> Any:
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [GREY] * 3}}
    shapes = {
        f"ball{k}": {"type": "sphere", "center": center, "radius": radius, "bsdf": {"type": "ref", "id": "grey"}}
        for k, (center, radius) in enumerate(zip(task["centers"], task["radii"], strict=True))
    }
    if kind == "paths":
        light = {"type": "constant", "radiance": {"type": "rgb", "value": [1.0] * 3}}
        integrator = {"type": "path", "max_depth": TURNS + 1}
    else:
        light = {"type": "point", "position": list(LIGHT), "intensity": {"type": "rgb", "value": [10.0] * 3}}
        integrator = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
    return mi.load_dict({
        "type": "scene", "integrator": integrator, "grey": grey, "light": light, **shapes,
        "sensor": {
            "type": "perspective", "fov": ANGLE, "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(list(EYE), list(TARGET), [0, 1, 0]),
            "film": {
                "type": "hdrfilm", "width": task["size"], "height": task["size"], "rfilter": {"type": "box"},
            },
            "sampler": {"type": sampler, "sample_count": task["samples"]},
        },
    })  # fmt: skip


if __name__ == "__main__":
    main()
