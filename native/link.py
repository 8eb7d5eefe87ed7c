"""The door compiled, and linked with the kernels' objects, by `zig cc`, which knows all targets."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from .targets import Target
from .windows import import_library

HERE = Path(__file__).resolve().parent
SOURCES = "door.c", "scratch.c", "fma.c"
FLAGS = "-O2 -fPIC -shared -fvisibility=hidden -Wall -Wextra -Werror -fno-math-errno -ffp-contract=off -s".split()


def extension_name(target: Target) -> str:
    """The file that Python looks for."""
    return "_kernels.pyd" if target.system == "windows" else "_kernels.abi3.so"


def _platform(target: Target, folder: Path) -> list[str]:
    """What a platform's linker has to be told: where Python's own symbols are."""
    if target.system == "windows":
        return [str(import_library(folder))]
    if target.system == "macos":  # the program that loads the extension has them
        return ["-undefined", "dynamic_lookup", f"-Wl,-install_name,@rpath/{extension_name(target)}"]
    return ["-Wl,-z,noexecstack", "-Wl,-z,relro,-z,now"]


def link(target: Target, header: Path, objects: list[Path]) -> Path:
    """The extension of a target, in the folder of its generated header."""
    out = header / extension_name(target)
    files = [str(HERE / name) for name in SOURCES] + [str(each) for each in objects]
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig, *FLAGS, f"-I{header}", f"-I{HERE}"]
    subprocess.run([*command, "-o", str(out), *files, *_platform(target, header)], check=True)
    return out
