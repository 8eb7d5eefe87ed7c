"""Reads spoilt files in a process of its own, whose memory and time are limited: `python -m ... first end folder`.

The memory is measured as Linux tells it. Prints, as JSON, how many files were read and refused, and what went wrong with others.
"""

from __future__ import annotations

import json
import resource
import signal
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any

import conicoid as co
from conicoid.io import openmc
from conicoid.io.scene_file import scene_file

from .mutations import mutated

ROOM = 2 << 30
PATIENCE = 10.0
"""Seconds of the processor, not of a clock: a busy machine changes nothing."""
MOST_BODIES = 500


class Hang(BaseException):
    """A file took too long."""


def in_a_child(first: int, end: int, folder: Path) -> dict[str, Any]:
    """What a child process found for files with these seeds."""
    command = [sys.executable, "-m", __name__, str(first), str(end), str(folder)]
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=3600, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def limited(path: Path, room: int) -> str:
    """The message with which a file is refused in a process that has so much memory beyond what an idle one takes."""
    code = f"from {__name__} import *; limit({room}); refuse({str(path)!r})"
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def refuse(path: str) -> None:
    """Say why a file is refused."""
    try:
        openmc.read(path)
    except co.SceneFileError as error:
        sys.stdout.write(str(error))


def limit(room: int) -> None:
    """Allow so much more memory than this process has now."""
    most = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() + room
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def main(first: int, end: int, folder: Path) -> dict[str, Any]:
    limit(ROOM)
    signal.signal(signal.SIGPROF, _hang)
    read = refused = 0
    wrong: list[str] = []
    for seed in range(first, end):
        name, content = mutated(seed)
        path = folder / name
        path.write_bytes(content)
        signal.setitimer(signal.ITIMER_PROF, PATIENCE)
        try:
            _try(path)
            read += 1
        except co.SceneFileError as error:
            refused += 1
            if not all(line.isprintable() for line in str(error).splitlines()) or not error.problems:
                wrong.append(f"{seed}: its message is not printable: {str(error)!r}")
        except MemoryError:
            wrong.append(f"{seed}: takes over 2 GiB")
        except Hang:
            wrong.append(f"{seed}: takes over {PATIENCE:g} s: {''.join(traceback.format_stack()[-3:])}")
        except BaseException as error:
            wrong.append(f"{seed}: {type(error).__name__}: {error}: {traceback.format_exc()[-800:]}")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
    return {"read": read, "refused": refused, "wrong": wrong}


def _try(path: Path) -> None:
    """Read a file, and use what comes of it: a scene file that gives the same scene, and lines that can be printed."""
    imported = openmc.read(path, max_bodies=MOST_BODIES)
    for line in (*imported.notes, *map(str, imported.legend), *(body.name or "" for body in imported.bodies)):
        assert line.isprintable(), repr(line)
    for body in imported.bodies[:20]:
        assert body.shape.bounds is not None
    output = path.with_suffix(".yaml")
    try:
        scene_file.write_scene(imported, output, imported.material_names)
    except ValueError as error:
        assert "a scene file holds at most" in str(error), error
        return
    assert scene_file.read_scene(output).bodies == imported.bodies


def _hang(*_: object) -> None:
    raise Hang


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))))
