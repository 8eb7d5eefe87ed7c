"""Programs of Conicoid and of peers that time themselves: from lists of numbers to a first hit, and one body moved.

Each reads centers and radii from a file into lists, and prints its seconds and the t of the hit. Its imports, and the
first small scene of its process, are not timed.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from conicoid._util.files import SceneFileError
from conicoid.geometry.body import Body
from conicoid.geometry.shape import Shape
from conicoid.io import openmc
from conicoid.io.scene_file import scene_file
from conicoid.materials.light import AmbientLight, PointLight
from conicoid.materials.presets import matte
from conicoid.render.camera import Camera
from conicoid.scene.scene import Scene

from . import peers
from .harness import Absent, BenchRow, Measured, Peer, Size, distribution
from .limits import LIMIT, check_limit
from .scenes import PINS, BallRows, balls, bored_blocks, boxes, cut_balls, spheres, write_core
from .startup import Sandbox, open_sandbox

LISTS = {
    "conicoid": """\
import sys, time
import numpy as np
import conicoid as co
data = np.load("balls.npy").tolist()
o, d = (0.0, 0.0, -3.0), (0.01, 0.02, 1.0)
co.Scene([co.Sphere(1.0, (0.1 * k, 0.0, 0.0)) for k in range(10)]).first_hit(o, d)
begin = time.perf_counter()
scene = co.Scene([co.Sphere(r, (x, y, z)) for x, y, z, r in data])
t = scene.first_hit(o, d).t
print(time.perf_counter() - begin, t)
""",
    "Raysect": """\
import time
import numpy as np
from raysect.core import Point3D, Ray, Vector3D, World, translate
from raysect.primitive import Sphere
data = np.load("balls.npy").tolist()
begin = time.perf_counter()
world = World()
balls = [Sphere(r, parent=world, transform=translate(x, y, z)) for x, y, z, r in data]
direction = Vector3D(0.01, 0.02, 1.0)
found = world.hit(Ray(Point3D(0, 0, -3), direction))
t = found.ray_distance if found is not None else float("inf")
print(time.perf_counter() - begin, t)
""",
    "Mitsuba": """\
import time
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
data = np.load("balls.npy").tolist()
ray = mi.Ray3f([0, 0, -3], [0.01, 0.02, 1.0])
begin = time.perf_counter()
listed = {f"s{i}": {"type": "sphere", "center": [x, y, z], "radius": r} for i, (x, y, z, r) in enumerate(data)}
scene = mi.load_dict({"type": "scene", **listed})
t = scene.ray_intersect(ray).t
print(time.perf_counter() - begin, t)
""",
}
"""From lists to a first hit."""

MOVED = {
    "conicoid": LISTS["conicoid"].partition("begin =")[0]
    + """\
scene = co.Scene([co.Sphere(r, (x, y, z)) for x, y, z, r in data])
scene.first_hit(o, d)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    scene = scene.moved(k, (0.0, 0.0, -0.01))
    t = scene.first_hit(o, d).t
    times.append(time.perf_counter() - begin)
print(sorted(times)[4], t)
""",
    "Raysect": LISTS["Raysect"].partition("begin =")[0]
    + """\
world, direction = World(), Vector3D(0.01, 0.02, 1.0)
balls = [Sphere(r, parent=world, transform=translate(x, y, z)) for x, y, z, r in data]
ray = Ray(Point3D(0, 0, -3), direction)
world.hit(ray)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    balls[k].transform = translate(0, 0, -0.01) * balls[k].transform
    found = world.hit(ray)
    times.append(time.perf_counter() - begin)
t = found.ray_distance if found is not None else float("inf")
print(sorted(times)[4], t)
""",
    "Mitsuba": LISTS["Mitsuba"].partition("begin =")[0]
    + """\
move = mi.ScalarTransform4f().translate([0, 0, -0.01])
listed = {f"s{i}": {"type": "sphere", "center": [x, y, z], "radius": r} for i, (x, y, z, r) in enumerate(data)}
scene = mi.load_dict({"type": "scene", **listed})
scene.ray_intersect(ray)
parameters = mi.traverse(scene)
times = []
for k in range(1, 9):
    begin = time.perf_counter()
    name = f"s{k}.to_world"
    parameters[name] = move @ mi.ScalarTransform4f(parameters[name].matrix)
    parameters.update()
    t = scene.ray_intersect(ray).t
    times.append(time.perf_counter() - begin)
print(sorted(times)[4], t)
""",
}
"""One ball moved, to the next first hit: the median of eight, a ball each. Peers have their own programs."""


# The time of a user before the rays: scene files to pictures, lists to first hits, an edit, a core that opens.

_PICTURE = "picture.png"
_FIELD_OF_VIEW = 2 * math.degrees(math.atan(0.5))
_MOST_MOVED = 0.010
"""Seconds from moving one body of ten thousand to the next first hit, at most."""
_OPENED = 10.0
"""Seconds in which a core of 400,000 pins opens, at most."""
ASSEMBLIES = 38


def in_picture(shapes: list[Shape]) -> Scene:
    """Grey bodies under one light that casts shadows, as `povray.write_scene` has them."""
    grey = matte((0.8, 0.8, 0.8), ambient=1.0, diffuse=0.8)
    camera = Camera((0, 0, -3), (0, 0, 0), up=(0, 1, 0), field_of_view=_FIELD_OF_VIEW)
    lights = [AmbientLight(0.1), PointLight((3, 4, -5))]
    return Scene([Body(shape, grey) for shape in shapes], lights, camera, (0, 0, 0))


def fewer(count: int, size: Size) -> int:
    """Return how many bodies, fewer where a run is shorter than usual."""
    return max(10, count * size.balls // Size().balls)


def file_to_picture(kind: str, shapes: Callable[[BallRows], list[Shape]], most: int) -> Callable[[Size], Measured]:
    """Time whole processes, from a scene file of so many bodies to a picture; both have run before."""

    def measure(size: Size) -> Measured:
        each, side = balls(fewer(most, size)), str(size.width)
        with open_sandbox() as mine, open_sandbox() as other:
            scene_file.write_scene(in_picture(shapes(each)), mine.folder / "scene.yaml")
            peers.write_povray(other.folder / "scene.pov", kind, each)
            ours = [sys.executable, "-m", "conicoid", "render", "scene.yaml", "-o", _PICTURE, "--samples", "1"]
            ours += ["--width", side, "--height", side]
            theirs = ["povray", "+Iscene.pov", f"+W{side}", f"+H{side}", "-A", "-D", f"+O{_PICTURE}"]
            pairs = (mine, ours), (other, theirs)
            for where, command in pairs:
                where.run(command)
            differ = float((_lit(mine.folder) != _lit(other.folder)[:, ::-1]).mean())
            rounds = [tuple(where.warm(command) for where, command in pairs) for _ in range(size.runs)]
        a, b = (statistics.median(seconds) for seconds in zip(*rounds, strict=True))
        note = f"{100 * differ:.2g} % of the pixels are lit for one only" if differ > 1e-2 else ""
        return Measured(a, b, b / a, "s", note)

    return measure


def _lit(folder: Path) -> Any:
    """Return which pixels of a picture are lit."""
    from PIL import Image

    with Image.open(folder / _PICTURE) as file:
        return np.asarray(file.convert("L")) > 0


def timed_programs(programs: dict[str, str], peer: str, count: int, tolerance: float) -> Callable[[Size], Measured]:
    """Time programs that read so many balls and print their seconds and t, in processes of their own, in turns."""

    def measure(size: Size) -> Measured:
        each = balls(fewer(count, size))
        rows = np.column_stack([each.centers, each.radii]).astype(float)
        with open_sandbox() as mine, open_sandbox() as other:
            for where in (mine, other):
                np.save(where.folder / "balls.npy", rows)
            pairs = (mine, programs["conicoid"]), (other, programs[peer])
            rounds = [tuple(_seconds(*pair) for pair in pairs) for _ in range(size.runs + 1)][1:]
        (a, t), (b, other_t) = (
            (statistics.median(seconds for seconds, _ in runs), runs[0][1]) for runs in zip(*rounds, strict=True)
        )
        same = t == other_t or abs(t - other_t) < tolerance * (1 + abs(t))
        return Measured(1e3 * a, 1e3 * b, b / a, "ms", "" if same else f"t is {t} and {other_t}")

    return measure


def _seconds(where: Sandbox, program: str) -> tuple[float, float]:
    """Return the output of a program: seconds, and t."""
    seconds, t = map(float, where.run([sys.executable, "-c", program])[1].split()[-2:])
    return seconds, t


def moved(shapes: Callable[[int], list[Shape]]) -> Callable[[Size], Measured]:
    """Milliseconds from moving one body of a prepared scene to the next first hit, each time another body."""

    def measure(size: Size) -> Measured:
        listed = shapes(fewer(10_000, size))
        scene, turns, direction = Scene(listed), [], (0.01, 0.02, 1.0)
        scene.first_hit((0.0, 0.0, -3.0), direction)
        which = np.random.default_rng(5).permutation(len(listed))[: 4 * size.runs + 2].tolist()
        for number in which:
            begin = time.perf_counter()
            scene = scene.moved(number, (0.0, 0.0, -0.01))
            t = scene.first_hit((0.0, 0.0, -3.0), direction).t
            turns.append(time.perf_counter() - begin)
        found = check_limit(1e3 * _MOST_MOVED, 1e3 * statistics.median(turns[2:]), "ms")
        again = Scene(scene.bodies).first_hit((0.0, 0.0, -3.0), direction).t
        note = "" if t == again else f"t is {t}, and {again} in a scene from the beginning"
        return Measured(found.ours, found.theirs, found.ratio, found.unit, note)

    return measure


def mixed(count: int) -> list[Shape]:
    """Balls, turned boxes and bodies of five leaves, a third each."""
    each = balls(count)
    parts = spheres(each), boxes(count).shapes(), bored_blocks(each)
    return [parts[k % 3][k] for k in range(count)]


def open_core(path: Path, most: int) -> Scene:
    """Return the scene of an OpenMC file of at most so many bodies."""
    try:
        parts = openmc.read(path, max_bodies=most)
        return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)
    except (SceneFileError, MemoryError) as error:
        raise Absent(f"cannot be opened: {str(error).splitlines()[0][:100]}") from None


def core_opens(size: Size) -> Measured:
    """Seconds from an OpenMC core's file to the first hits of a camera's rays."""
    across = ASSEMBLIES if size.balls >= Size().balls else 1
    pins = (across * PINS) ** 2
    with open_sandbox() as where:
        write_core(where.folder / "geometry.xml", across, PINS)
        begin = time.perf_counter()
        scene = open_core(where.folder / "geometry.xml", 4 * pins)
        half = 0.5 * across * PINS * 1.26
        rays = Camera((0.1, 0.2, 3 * half), (0, 0, 0), up=(0, 1, 0), field_of_view=30).rays(64, 64)
        hits = scene.first_hit(rays)
        seconds = time.perf_counter() - begin
    found = check_limit(_OPENED, seconds, "s")
    note = "" if bool(hits.hit[32, 32]) else "the middle of the core is not hit"
    return Measured(found.ours, found.theirs, found.ratio, found.unit, note)


def _mitsuba() -> str:
    return f"Mitsuba {distribution('mitsuba')} (scalar_rgb)"


_POVRAY = Peer("POV-Ray", "whole process", peers.POVRAY_TRACE.find)
_PEERS = {"Raysect": peers.RAYSECT, "Mitsuba": Peer("Mitsuba", "scalar_rgb", _mitsuba)}
_KINDS = {
    "spheres": ("spheres", spheres),
    "quadrics": ("cut quadrics", cut_balls),
    "csg": ("bodies of 5 leaves", bored_blocks),
}
_MOVED = {
    "spheres": ("balls", lambda count: spheres(balls(count))),
    "boxes": ("turned boxes", lambda count: boxes(count).shapes()),
    "csg": ("bodies of 5 leaves", lambda count: bored_blocks(balls(count))),
    "mixed": ("balls, turned boxes, bodies of 5 leaves", mixed),
}


def _rows() -> Iterator[BenchRow]:
    for kind, (name, shapes) in _KINDS.items():
        for count in (1000, 10_000):
            measure = file_to_picture(kind, shapes, count)
            yield BenchRow(
                f"file-{kind}-{count}", "scene file to picture", f"{count:,} {name}", _POVRAY, 1.0, 3.0, measure
            )
    for peer, about in _PEERS.items():
        name = peer.lower()
        lists = timed_programs(LISTS, peer, 10_000, 1e-4)
        yield BenchRow(f"lists-{name}", "Python lists to first hit", "10,000 balls", about, 0.0, 1.0, lists)
        edits = timed_programs(MOVED, peer, 10_000, 1e-4)
        yield BenchRow(f"moved-{name}", "one body moved, to first hit", "10,000 balls", about, 0.0, 1.0, edits)
    for kind, (name, made) in _MOVED.items():
        many = f"10,000 {name}"
        yield BenchRow(f"moved-{kind}", "one body moved, to first hit", many, LIMIT, 1.0, 0.0, moved(made))
    yield BenchRow("core", "camera, from the file", f"a core of {(ASSEMBLIES * PINS) ** 2:,} pins", LIMIT, 1.0, 0.0,
              core_opens)  # fmt: skip


ROWS = tuple(_rows())
