"""The programs of `fresh`: a first hit on a ball from z = -3, which is at t = 2, and a small picture of a ball."""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .harness import Absent, BenchRow, Measured, Peer, Size, distribution
from .peers import POVRAY_TRACE as POVRAY_PEER

OURS = "conicoid"

HITS = {
    OURS: """\
import conicoid as co
print(co.Scene([co.Sphere()]).first_hit((0, 0, -3), (0, 0, 1)).t)
""",
    "Embree": """\
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector
rays = RayMeshIntersector(trimesh.creation.box((2, 2, 2)))
points, _, _ = rays.intersects_location([(0, 0, -3)], [(0, 0, 1)], multiple_hits=False)
print(points[0, 2] + 3)
""",
    "Raysect": """\
from raysect.core import Point3D, Ray, Vector3D, World
from raysect.primitive import Sphere
world = World()
ball = Sphere(1, parent=world)
print(world.hit(Ray(Point3D(0, 0, -3), Vector3D(0, 0, 1))).ray_distance)
""",
    "Mitsuba": """\
import mitsuba as mi
mi.set_variant("scalar_rgb")
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
print(scene.ray_intersect(mi.Ray3f([0, 0, -3], [0, 0, 1])).t)
""",
}
"""Each prints t. Embree has triangles: a box of twelve, whose wall is at the ball's place."""

PICTURES = {
    OURS: """\
import conicoid as co
camera = co.Camera((0, 0, -5), (0, 0, 0), up=(0, 1, 0))
scene = co.Scene([co.Sphere()], lights=[co.PointLight((3, 4, -5))], camera=camera, background=(0, 0, 0))
scene.render(64, 48).save("picture.png")
""",
    "Raysect": """\
import matplotlib
matplotlib.use("agg")
from raysect.core import SerialEngine
from raysect.optical import ConstantSF, Point3D, World, d65_white, translate
from raysect.optical.material import Lambert, UniformSurfaceEmitter
from raysect.optical.observer import PinholeCamera, RGBPipeline2D
from raysect.primitive import Sphere
world = World()
ball = Sphere(1, world, material=Lambert(ConstantSF(0.8)))
light = Sphere(2, world, translate(3, 4, -8), UniformSurfaceEmitter(d65_white))
picture = RGBPipeline2D(display_progress=False)
camera = PinholeCamera((64, 48), parent=world, transform=translate(0, 0, -5), pipelines=[picture])
camera.pixel_samples, camera.spectral_bins, camera.quiet, camera.render_engine = 4, 15, True, SerialEngine()
camera.observe()
picture.save("picture.png")
""",
    "Mitsuba": """\
import mitsuba as mi
mi.set_variant("scalar_rgb")
view = mi.ScalarTransform4f().look_at(origin=[0, 0, -5], target=[0, 0, 0], up=[0, 1, 0])
film = {"type": "hdrfilm", "width": 64, "height": 48}
camera = {"type": "perspective", "to_world": view, "film": film, "sampler": {"type": "independent", "sample_count": 4}}
light = {"type": "point", "position": [3, 4, -5], "intensity": 50.0}
scene = {"type": "scene", "by": {"type": "direct"}, "ball": {"type": "sphere"}, "light": light, "camera": camera}
mi.util.write_bitmap("picture.png", mi.render(mi.load_dict(scene)), write_async=False)
""",
}
"""Each writes picture.png, 64 x 48 pixels, four rays each. Raysect has no lights but what shines: a ball does."""

POVRAY = """\
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0,0,-5> look_at <0,0,0> angle 50 }
light_source { <3,4,-5> rgb 1 }
sphere { <0,0,0>, 1 texture { pigment { rgb 0.8 } finish { diffuse 0.8 } } }
"""
"""The same picture as a scene file."""


# From pressing return to the first answer: whole processes, where nothing has run yet, and where something has.
#
# Cold is the first process after an install: Python finds no bytecode of any package, and nobody has left a cache in
# the user's folder. (The standard library's bytecode is there, as it comes with Python, and files are read from memory
# if the system has them there.) Warm is every later process. Each program's output is checked first.

_PICTURE = "picture.png"
_IN_THE_FOLDER = {
    "HOME": "home", "XDG_CACHE_HOME": "cache", "PYTHONPYCACHEPREFIX": "bytecode",
}  # fmt: skip
_KEPT = "CONICOID_THREADS", "CONICOID_LEVEL", "CONICOID_JIT"
_PLACE = Path(sysconfig.get_path("stdlib"))
_STANDARD = Path("bytecode", *_PLACE.parts[1:])  # the bytecode of Python's own library, in a folder

Check = Callable[[str, Path], str]
"""Return the fault of a program's output, or of the files that it leaves in a folder; "" if there is none."""


class Sandbox:
    """A folder in which a user's programs run, and in which they look for bytecode and caches."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / _IN_THE_FOLDER["HOME"]).mkdir()
        (folder / "scene.pov").write_text(POVRAY, encoding="utf-8")
        own = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "CONICOID_")) or k in _KEPT}
        there = {name: str(folder / part) for name, part in _IN_THE_FOLDER.items()}
        self._environment = own | there | {"PYTHONPATH": str(Path(__file__).parents[2])}

    def run(self, command: list[str]) -> tuple[float, str]:
        """Return the time of a process as a whole, and its output. Raises Absent where it fails."""
        begin = time.perf_counter()
        done = subprocess.run(
            command, cwd=self.folder, env=self._environment, capture_output=True, text=True, check=False
        )
        seconds = time.perf_counter() - begin
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise Absent(f"its program ended with {done.returncode}: {lines[-1] if lines else 'it said nothing'}")
        return seconds, done.stdout

    @contextmanager
    def anew(self) -> Iterator[Sandbox]:
        """Return another one, which has of this one's bytecode the standard library's alone."""
        with open_sandbox() as new:
            if (self.folder / _STANDARD).exists():
                packages = shutil.ignore_patterns("site-packages", "dist-packages")
                shutil.copytree(self.folder / _STANDARD, new.folder / _STANDARD, ignore=packages)
            yield new

    def cold(self, command: list[str]) -> float:
        """Return the seconds of a first process."""
        with self.anew() as new:
            return new.run(command)[0]

    def warm(self, command: list[str]) -> float:
        """Return the seconds of a process after an equal one."""
        return self.run(command)[0]


@contextmanager
def open_sandbox() -> Iterator[Sandbox]:
    """Make a folder in which no program has run."""
    with tempfile.TemporaryDirectory(prefix="conicoid-bench-") as name:
        yield Sandbox(Path(name))


def check_hit(said: str, folder: Path) -> str:
    """Return the fault of a first hit."""
    del folder
    t = float(said.split()[-1])
    return "" if abs(t - 2.0) < 1e-5 else f"the hit is at {t}, not at 2"


def check_picture(said: str, folder: Path) -> str:
    """Return the fault of a picture: a ball is in its middle, and nothing in its corner."""
    del said
    from PIL import Image

    with Image.open(folder / _PICTURE) as file:
        grey = np.asarray(file.convert("L"), dtype=float)
    if grey.shape != (48, 64):
        return f"the picture has {' x '.join(map(str, grey.shape))} pixels"
    middle, corner = grey[20:28, 28:36].mean(), grey[:4, :4].mean()
    return "" if middle > corner + 20 else "the picture shows no ball"


def compare_processes(ours: list[str], theirs: list[str], check: Check, cold: bool) -> Callable[[Size], Measured]:
    """Return seconds of two commands, in turns, after a first run of each whose output is checked."""

    def measure(size: Size) -> Measured:
        with open_sandbox() as mine, open_sandbox() as other:
            wrong = [f"{whose}: {found}" for whose, found in (
                (OURS, check(mine.run(ours)[1], mine.folder)), ("peer", check(other.run(theirs)[1], other.folder)),
            ) if found]  # fmt: skip
            turn = Sandbox.cold if cold else Sandbox.warm
            rounds = [(turn(mine, ours), turn(other, theirs)) for _ in range(size.runs)]
        a, b = (statistics.median(seconds) for seconds in zip(*rounds, strict=True))
        return Measured(a, b, b / a, "s", "; ".join(wrong))

    return measure


def _python(program: str) -> list[str]:
    return [sys.executable, "-c", program]


def _versions(name: str, *packages: str) -> Callable[[], str]:
    return lambda: f"{name} {', '.join(distribution(package) for package in packages)}"


_POVRAY = ["povray", "+Iscene.pov", "+W64", "+H48", "-D", "+A", f"+O{_PICTURE}"]
_PEERS = {
    "Embree": Peer("Embree", "by trimesh, triangles", _versions("embreex and trimesh", "embreex", "trimesh")),
    "Raysect": Peer("Raysect", "its own process", _versions("Raysect", "raysect", "matplotlib")),
    "Mitsuba": Peer("Mitsuba", "scalar_rgb", _versions("Mitsuba", "mitsuba")),
    "POV-Ray": Peer("POV-Ray", "its own process", POVRAY_PEER.find),
}


def _rows() -> Iterator[BenchRow]:
    hits = {name: _python(program) for name, program in HITS.items()}
    pictures = {name: _python(program) for name, program in PICTURES.items()} | {"POV-Ray": _POVRAY}
    for what, commands, check in (("hit", hits, check_hit), ("picture", pictures, check_picture)):
        ours = commands.pop(OURS)
        for peer, theirs in commands.items():
            for when in ("cold", "warm"):
                name = f"{when}-{what}-{peer.lower().replace('-', '')}"
                about = f"fresh environment to the first {what}" if when == "cold" else f"once more to the first {what}"
                measure = compare_processes(ours, theirs, check, when == "cold")
                yield BenchRow(name, about, "a ball, whole process", _PEERS[peer], 0.0, 1.0, measure)


ROWS = tuple(_rows())
