"""From pressing return to the first answer: whole processes, where nothing has run yet, and where something has.

Cold is the first process after an install: Python finds no bytecode of any package, and nobody has left a cache in the
user's folder. (The standard library's bytecode is there, as it comes with Python, and files are read from wherever the
system has them, most likely memory.) Warm is every later process. What each program prints or draws is checked first.
"""

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

from .fresh_programs import HITS, OURS, PICTURES, POVRAY
from .peer import Absent, Peer, distribution
from .povray import PEER as POVRAY_PEER
from .row import Measured, Row, Size

_PICTURE = "picture.png"
_IN_THE_FOLDER = {
    "HOME": "home", "XDG_CACHE_HOME": "cache", "PYTHONPYCACHEPREFIX": "bytecode", "CONICOID_CACHE_DIR": "kernels",
}  # fmt: skip
_KEPT = "CONICOID_THREADS", "CONICOID_LEVEL", "CONICOID_JIT"
_PLACE = Path(sysconfig.get_path("stdlib"))
_STANDARD = Path("bytecode", *_PLACE.parts[1:])  # the bytecode of Python's own library, in a folder

Check = Callable[[str, Path], str]
"""What is wrong with what a program says, or leaves in a folder; "" if nothing is."""


class Place:
    """A folder in which a user's programs run, and where they look for bytecode and caches."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / _IN_THE_FOLDER["HOME"]).mkdir()
        (folder / "scene.pov").write_text(POVRAY, encoding="utf-8")
        own = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "CONICOID_")) or k in _KEPT}
        there = {name: str(folder / part) for name, part in _IN_THE_FOLDER.items()}
        self._environment = own | there | {"PYTHONPATH": str(Path(__file__).parents[2])}

    def run(self, command: list[str]) -> tuple[float, str]:
        """How long a process takes as a whole, and what it says. Raises Absent where it fails."""
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
    def anew(self) -> Iterator[Place]:
        """Another, which has of this one's bytecode the standard library's alone."""
        with place() as new:
            if (self.folder / _STANDARD).exists():
                packages = shutil.ignore_patterns("site-packages", "dist-packages")
                shutil.copytree(self.folder / _STANDARD, new.folder / _STANDARD, ignore=packages)
            yield new

    def cold(self, command: list[str]) -> float:
        """The seconds of a process where nothing has run before."""
        with self.anew() as new:
            return new.run(command)[0]

    def warm(self, command: list[str]) -> float:
        """The seconds of a process where the same has run before."""
        return self.run(command)[0]


@contextmanager
def place() -> Iterator[Place]:
    """One in which nothing has run."""
    with tempfile.TemporaryDirectory(prefix="conicoid-bench-") as name:
        yield Place(Path(name))


def hit(said: str, folder: Path) -> str:
    """What is wrong with a first hit."""
    del folder
    t = float(said.split()[-1])
    return "" if abs(t - 2.0) < 1e-5 else f"the hit is at {t}, not at 2"


def drawn(said: str, folder: Path) -> str:
    """What is wrong with a picture: a ball is in its middle, and nothing in its corner."""
    del said
    from PIL import Image

    with Image.open(folder / _PICTURE) as file:
        grey = np.asarray(file.convert("L"), dtype=float)
    if grey.shape != (48, 64):
        return f"the picture has {' x '.join(map(str, grey.shape))} pixels"
    middle, corner = grey[20:28, 28:36].mean(), grey[:4, :4].mean()
    return "" if middle > corner + 20 else "the picture shows no ball"


def against(ours: list[str], theirs: list[str], check: Check, cold: bool) -> Callable[[Size], Measured]:
    """Seconds of two commands, in turns, after a first run of each that is checked."""

    def measure(size: Size) -> Measured:
        with place() as mine, place() as other:
            wrong = [f"{whose}: {found}" for whose, found in (
                (OURS, check(mine.run(ours)[1], mine.folder)), ("peer", check(other.run(theirs)[1], other.folder)),
            ) if found]  # fmt: skip
            turn = Place.cold if cold else Place.warm
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


def _rows() -> Iterator[Row]:
    hits = {name: _python(program) for name, program in HITS.items()}
    pictures = {name: _python(program) for name, program in PICTURES.items()} | {"POV-Ray": _POVRAY}
    for what, commands, check in (("hit", hits, hit), ("picture", pictures, drawn)):
        ours = commands.pop(OURS)
        for peer, theirs in commands.items():
            for when in ("cold", "warm"):
                name = f"{when}-{what}-{peer.lower().replace('-', '')}"
                about = f"fresh environment to the first {what}" if when == "cold" else f"once more to the first {what}"
                measure = against(ours, theirs, check, when == "cold")
                yield Row(name, about, "a ball, whole process", _PEERS[peer], 0.0, 1.0, measure)


ROWS = tuple(_rows())
