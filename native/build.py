"""The extension `conicoid._kernels` for a target: `python -m native.build [TARGET] [--in-place]`.

The front end runs first, then an object for each level is made on all cores, then the door is compiled and linked with
them (`link`). `--in-place` builds for this processor's level alone and puts the extension into the checkout, with a
stamp of the sources: Conicoid uses it until one of the files that the compiler read is edited. An extension that is up
to date is not built again. Intermediate files stay in `out/kernels`, so that after an edit of C alone the build takes
seconds. `--incremental` keeps the code of each function (`memory`) and an object for each source file (`groups`): the
build after an edit of one function takes seconds.
"""

from __future__ import annotations

import argparse
import importlib
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path

from .link import link
from .targets import TARGETS, Level, Target

HERE = Path(__file__).resolve().parent
KEPT = HERE.parent / "out" / "kernels"
"""Folder of the intermediate files of builds in place."""
EDITED = HERE.parent / "out" / "edited_kernels"
"""Folder of the files of incremental builds, so that the next one compiles only edited functions."""
_LONGEST = 3600
"""Seconds that a build waits for another one, and then fails."""


@contextmanager
def alone() -> Iterator[None]:
    """Wait for other builds of this checkout, which write the same files. SQLite's lock ends with its process."""
    place = HERE.parent / "out" / "build.lock"
    place.parent.mkdir(exist_ok=True)
    with closing(sqlite3.connect(place, timeout=0)) as lock:
        try:
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError:
            print("Another build of this checkout is at work; this one waits for it ...", flush=True)
            lock.execute(f"PRAGMA busy_timeout = {1000 * _LONGEST}")
            lock.execute("BEGIN EXCLUSIVE")
        yield


def _python(*words: str) -> None:
    """Run a module of this package in a process of its own."""
    environment = os.environ | {"CONICOID_JIT": "own"}  # without machine code of an earlier build
    subprocess.run([sys.executable, "-m", *words], check=True, cwd=HERE.parent, env=environment)


def lowered(folder: Path, *names: str) -> Path:
    """Return the LLVM code of all kernels, made once for all targets; of these at least, where there are names.

    In `EDITED` it is made again, but for unchanged functions.
    """
    from conicoid._jit.sources import is_current

    code = folder / "kernels.pickle"
    if folder == EDITED and not (is_newer(code, "*.py") and is_current(stamp_of(code))):
        code.unlink(missing_ok=True)
        names = ()
    if names and not code.exists():
        code = folder / "some_kernels.pickle"
    if not code.exists():
        unfinished = code.with_suffix(".unfinished")
        memory = ["--memory", str(folder / "functions.pickle")] if folder == EDITED else []
        _python("native.front", str(unfinished), *names, *memory)
        unfinished.replace(code)
    return code


def device_code(folder: Path, part: str, memory: Path | None = None) -> Path:
    """Return the LLVM code of a part of the functions of a GPU's threads (`signature.on_device`).

    With a memory (`native.memory`) it is made again where its sources have changed, but for unchanged functions.
    """
    from conicoid._jit.sources import is_current

    code, words = folder / f"{part}.pickle", ["--memory", str(memory)] if memory else []
    if memory and not (is_newer(code, "*.py") and is_current(stamp_of(code))):
        code.unlink(missing_ok=True)
    if not code.exists():
        unfinished = code.with_suffix(".unfinished")
        _python("native.front", str(unfinished), "--device", part, *words)
        unfinished.replace(code)
    return code


def _base(code: Path, target: Target, folder: Path) -> Path:
    """Return the simplified module of a target; targets of the same triple share it."""
    out = folder / f"{target.triple}.bc"
    if not out.exists():
        unfinished = out.with_suffix(".unfinished")
        _python("native.objects", str(code), target.name, str(unfinished))
        unfinished.replace(out)
    return out


def _object(base: Path, target: Target, level: Level, folder: Path) -> Path:
    """Return an object of a level; targets of the same triple share it."""
    out = folder / f"{target.triple}-{level.name}.o"
    if not out.exists():
        unfinished = out.with_suffix(".unfinished")
        _python("native.objects", str(base), target.name, level.name, str(unfinished))
        unfinished.replace(out)
    return out


def stamp_of(code: Path) -> str:
    """Return the stamp of the sources of LLVM code that `lowered` returned."""
    return code.with_suffix(".stamp").read_text(encoding="utf-8")


def build(target: Target, folder: Path, stamped: bool = False) -> Path:
    """Build the extension into the folder, with a stamp of its sources if these may change."""
    code = lowered(folder)
    if folder == EDITED:
        from . import groups  # it needs LLVM, without which the names of targets must be available

        objects = groups.build(code, target, folder)
    else:
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            base = _base(code, target, folder)
            objects = list(pool.map(lambda level: _object(base, target, level, folder), target.levels))
    header = folder / target.name
    header.mkdir(exist_ok=True)
    names = ",".join(level.name for level in target.levels)
    _python("native.tables", target.name, names, str(header / "tables.h"), *([str(code)] if stamped else []))
    return link(target, header, objects)


def put(made: Path, place: Path) -> Path:
    """Put a copy of a file at a place, as a new file: processes that have loaded the old one keep it."""
    arriving = place.with_name(f".{place.name}.part")
    arriving.write_bytes(made.read_bytes())
    arriving.replace(place)
    return place


def host() -> Target:
    """Return the target of this machine."""
    import platform

    system = {"linux": "linux", "darwin": "macos", "win32": "windows"}.get(sys.platform, sys.platform)
    if system == "linux" and platform.libc_ver()[0] != "glibc":
        system = "musl"
    machine = {"AMD64": "x86_64", "aarch64": "aarch64", "arm64": "arm64" if system == "macos" else "aarch64"}
    name = f"{system}-{machine.get(platform.machine(), platform.machine())}"
    if name not in TARGETS:
        raise SystemExit(f"there is no target {name}; known are {', '.join(TARGETS)}")
    return TARGETS[name]


def host_level(target: Target) -> str:
    """Return the best level of a target that this processor can run (as native/levels.h decides it)."""
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    wide = all(features.get(name) for name in ("avx512vl", "avx512bw", "avx512dq", "avx512cd", "avx512vbmi2"))
    needs = (2 if wide else 1) if features.get("avx2") and features.get("fma") else 0
    return [level.name for level in target.levels if level.needs <= needs][-1]


def is_newer(made: Path, files: str = "*.*") -> bool:
    """Return whether a file is newer than all files of the build, or than some."""
    return made.exists() and made.stat().st_mtime > max(each.stat().st_mtime for each in HERE.glob(files))


def drop_old_parts() -> None:
    """Remove the files of builds in place if they are from other kernels or another compiler."""
    from conicoid._jit.sources import is_current

    code = KEPT / "kernels.pickle"
    if KEPT.exists() and not (is_newer(code, "*.py") and is_current(stamp_of(code))):
        shutil.rmtree(KEPT)


def _is_there(target: Target, incremental: bool) -> bool:
    """Return whether the checkout has an extension of these sources, newer than the files of the build.

    An extension of an incremental build, which is slower, counts for another such build alone.
    """
    from conicoid._jit.sources import is_current

    try:
        found = importlib.import_module("conicoid._kernels")
    except ImportError:
        return False
    there = Path(str(found.__file__))
    slower = EDITED / target.name / there.name
    is_slower = slower.exists() and slower.read_bytes() == there.read_bytes()
    return is_current(found.sources) and is_newer(there) and (incremental or not is_slower)


def _duration(folder: Path) -> str:
    """Return about how long a build in a folder takes."""
    if folder == EDITED and (EDITED / "functions.pickle").exists():
        return "some seconds"
    return "some seconds" if (folder / "kernels.pickle").exists() else "some two and a half minutes of a core"


def main() -> None:
    """Build the extension from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", nargs="?", choices=TARGETS)
    parser.add_argument("--folder", type=Path, help="where what is made on the way is kept")
    parser.add_argument("--in-place", action="store_true")
    parser.add_argument(
        "--incremental", action="store_true", help="in place, again only what was edited since the last"
    )
    wanted = parser.parse_args()
    begin = time.monotonic()
    target = TARGETS[wanted.target] if wanted.target else host()
    with tempfile.TemporaryDirectory() as temporary, alone():
        kept = EDITED if wanted.incremental else KEPT if wanted.in_place else Path(temporary)
        folder = wanted.folder or kept
        if wanted.in_place or wanted.incremental:
            target = target.only(host_level(target))
            if _is_there(target, wanted.incremental):
                return
            if folder == KEPT:
                drop_old_parts()
            print(f"Making machine code of the kernels, for {_duration(folder)} ...", flush=True)
        folder.mkdir(parents=True, exist_ok=True)
        out = build(target, folder, wanted.in_place or wanted.incremental)
        if wanted.in_place or wanted.incremental:
            out = put(out, HERE.parent / "conicoid" / out.name)
        print(f"{out}, after {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
