"""The door compiled, and linked with the kernels' objects, by `zig cc`, which knows all targets.

For Python in a browser (Pyodide) the library is a WebAssembly module that shares its memory: LLVM's linker makes it,
and nothing of Emscripten is needed, as the door takes no more than Python's stable ABI and a few functions on memory.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from .targets import Target
from .windows import import_library

HERE = Path(__file__).resolve().parent
PAGE_ENGINE = "conicoid/viewer/engine.wasm"
"""The engine for pages in a wheel and in a checkout."""
SOURCES = "door.c", "scratch.c", "pool.c", "fma.c"
FLAGS = "-O2 -fPIC -fvisibility=hidden -Wall -Wextra -Werror -fno-math-errno -ffp-contract=off".split()
ZIG = [sys.executable, "-m", "ziglang"]
OLD_BROWSERS = "mvp+simd128+bulk_memory+sign_ext+nontrapping_fptoint+mutable_globals"  # by zig's names
SIDE_MODULE = (
    *("-shared", "--experimental-pic", "--no-entry", "--strip-all", "--gc-sections"),
    *("--export=PyInit__kernels", "--unresolved-symbols=import-dynamic"),
)


def extension_name(target: Target) -> str:
    """Return the name of the file that Python loads."""
    return "_kernels.pyd" if target.system == "windows" else "_kernels.abi3.so"


def _platform(target: Target, folder: Path) -> list[str]:
    """Return the options by which a platform's linker finds Python's own symbols."""
    if target.system == "windows":
        return [str(import_library(folder))]
    if target.system == "macos":  # the program that loads the extension has them
        return ["-undefined", "dynamic_lookup", f"-Wl,-install_name,@rpath/{extension_name(target)}"]
    return ["-Wl,-z,noexecstack", "-Wl,-z,relro,-z,now"]


def link(target: Target, header: Path, objects: list[Path]) -> Path:
    """Link the extension of a target, in the folder of its generated header."""
    out, sources = header / extension_name(target), [HERE / name for name in SOURCES]
    if target.system == "pyodide":
        return side_module(out, [*sources, HERE / "wide.c"], objects)
    files = [str(each) for each in (*sources, *objects)]
    command = [*ZIG, "cc", "-target", target.zig, *FLAGS, "-shared", "-s", f"-I{header}", f"-I{HERE}"]
    subprocess.run([*command, "-o", str(out), *files, *_platform(target, header)], check=True)
    return out


def side_module(out: Path, sources: list[Path], objects: list[Path]) -> Path:
    """Link a library for a program in WebAssembly that loads others (Emscripten's), from C and from objects."""
    made = []
    for source in sources:
        made.append(out.with_name(f"{source.stem}.o"))
        command = [
            *ZIG,
            "cc",
            "-target",
            "wasm32-wasi",
            f"-mcpu={OLD_BROWSERS}",
            *FLAGS,
            f"-I{out.parent}",
            f"-I{HERE}",
        ]
        subprocess.run([*command, "-c", str(source), "-o", str(made[-1])], check=True)
    subprocess.run([*ZIG, "wasm-ld", *SIDE_MODULE, *map(str, (*objects, *made)), "-o", str(out)], check=True)
    return out
