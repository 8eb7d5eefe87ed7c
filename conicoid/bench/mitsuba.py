"""Mitsuba 3 on its LLVM backend: nearest hits on spheres, single precision, in a process of its own.

Its compiler is a shared LLVM of the system, which must not meet the one that is part of llvmlite.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO

import numpy as np

from ..engine.threads import thread_count
from .peer import Absent, Peer, distribution
from .scenes import Balls, Floats, Singles

OLDEST = 16
"""The oldest LLVM that Mitsuba's compiler works with on current processors."""

_FOLDERS = (
    "/usr/lib/*-linux-gnu", "/usr/lib/llvm-*/lib", "/usr/lib64", "/usr/lib64/llvm*/lib64", "/usr/lib", "/usr/local/lib",
    "/opt/homebrew/opt/llvm/lib", "/usr/local/opt/llvm/lib",
)  # fmt: skip


def _version() -> str:
    version = distribution("mitsuba")
    return f"Mitsuba {version} (llvm_ad_rgb, LLVM {_llvm_version(find_llvm())})"


PEER = Peer("Mitsuba", "LLVM, float32", _version)


def find_llvm() -> Path:
    """A shared LLVM library: DRJIT_LIBLLVM_PATH, or the newest in the usual places; raises Absent without one."""
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        if not Path(chosen).is_file():
            raise Absent(f"DRJIT_LIBLLVM_PATH names no file: {chosen}")
        return Path(chosen)
    found = [
        path
        for folder in _FOLDERS
        for path in Path("/").glob(f"{folder[1:]}/libLLVM*")
        if re.search(r"\.(so|dylib)", path.name) and _llvm_version(path) >= OLDEST
    ]
    if not found:
        raise Absent(f"needs LLVM {OLDEST} or newer: apt-get install libllvm19, or set DRJIT_LIBLLVM_PATH")
    return max(found, key=lambda path: (_llvm_version(path), path.name))


def _llvm_version(path: Path) -> int:
    """libLLVM.so.19.1 and libLLVM-19.so are 19; 0 where neither the name nor what it points to tells."""
    for name in (path.name, path.resolve().name):
        numbers = re.search(r"libLLVM(?:-(\d+)|\.so\.(\d+)|\.(\d+)\.dylib)", name)
        if numbers:
            return int(next(filter(None, numbers.groups())))
    return 0


class MitsubaScene:
    """Balls and rays (M, 3) in Mitsuba's process; use it in a `with` block."""

    def __init__(self, balls: Balls, origins: Singles, directions: Singles, coherent: bool) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="conicoid-bench-")
        folder = Path(self._folder.name)
        np.savez(
            folder / "scene.npz", centers=balls.centers, radii=balls.radii, origins=origins, directions=directions,
            coherent=coherent, threads=thread_count(),
        )  # fmt: skip
        self._complaints = (folder / "complaints.txt").open("w+")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "conicoid.bench.mitsuba_worker", str(folder)],
            env={**os.environ, "DRJIT_LIBLLVM_PATH": str(find_llvm())},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._complaints, text=True,
            start_new_session=True,  # Ctrl-C comes to us, and we end it
        )  # fmt: skip
        try:
            self._answer()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> MitsubaScene:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._complaints):
            _close(pipe)
        self._folder.cleanup()

    def seconds(self) -> float:
        """The time of one run of all rays."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write("run\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # _answer says why
        return float(self._answer())

    def distances(self) -> Floats:
        """t (M,) of the last run, inf for a miss."""
        single: Singles = np.load(Path(self._folder.name) / "t.npy")
        return single.astype(float)

    def _answer(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if line.startswith("answer "):
            return line.split()[1]
        self._complaints.seek(0)
        lines = self._complaints.read().strip().splitlines()
        raise Absent(f"Mitsuba's process ended ({self._process.wait()}): {lines[-1] if lines else line.strip()}")


def _close(pipe: IO[str] | None) -> None:
    try:
        if pipe is not None:
            pipe.close()
    except BrokenPipeError:
        pass
