"""The engine that exported pages carry, as WebAssembly: `python -m native.page` puts it into the checkout.

The kernels that answer a click, for one ray at a time, and their memory (page.c). It takes nothing from JavaScript:
there is no function of it that could decide bits. Where the kernels ask for a fused multiply-add, it is that of fma.c.
"""

from __future__ import annotations

import argparse
import pickle
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from . import objects
from .build import HERE, KEPT, alone, drop_old_parts, is_newer, lowered, put, stamp_of
from .link import PAGE_ENGINE
from .targets import WASM

TRIPLE = "wasm32-unknown-unknown"
LEVEL = replace(WASM[0], name="page")
KERNELS = (
    "errors_of_t", "faces_of", "first_invalid", "hit_points", "normals_of", "settle_first", "settle_rows",
    "trace_first_alone", "trace_rows_alone", "uvs_of",
)  # fmt: skip
SOURCES = "page.c", "fma.c", "wide.c"
COMPILE = "-target wasm32-freestanding -O2 -Wall -Wextra -Werror -ffp-contract=off -ffreestanding -c".split()
LINK = "--no-entry --stack-first -z stack-size=1048576 --gc-sections --strip-all".split()


def _object(code: Path, folder: Path) -> Path:
    """Return the kernels' object."""
    out = folder / "page.o"
    if not out.exists() or out.stat().st_mtime < code.stat().st_mtime:
        unfinished = out.with_suffix(".unfinished")
        subprocess.run(
            [sys.executable, "-m", "native.page", "--object", str(code), str(unfinished)], check=True, cwd=HERE.parent
        )
        unfinished.replace(out)
    return out


def emit(code: Path, out: Path) -> None:
    """Write the kernels' object."""
    kernels, codes = pickle.loads(code.read_bytes())
    machine = objects.machine_for(TRIPLE, LEVEL, relocation="static")
    whole = objects.linked({name: kernels[name] for name in KERNELS}, codes, machine, TRIPLE, LEVEL.prefix)
    objects.simplify(whole, machine)
    objects.optimize(whole, machine)
    out.write_bytes(machine.emit_object(whole))


def build(folder: Path, stamped: bool = False) -> Path:
    """Build the engine into the folder, with a stamp of its sources if these may change."""
    code = lowered(folder, *KERNELS)
    kernels, out = _object(code, folder), folder / Path(PAGE_ENGINE).name
    zig, parts = [sys.executable, "-m", "ziglang"], [kernels]
    for name in SOURCES:
        parts.append(folder / f"{name}.o")
        subprocess.run([*zig, "cc", *COMPILE, str(HERE / name), "-o", str(parts[-1])], check=True)
    exports = [f"--export={LEVEL.prefix}{name}" for name in KERNELS]
    subprocess.run([*zig, "wasm-ld", *LINK, *exports, *map(str, parts), "-o", str(out)], check=True)
    if stamped:
        from conicoid.viewer.html import stamp_sources

        out.write_bytes(stamp_sources(out.read_bytes(), stamp_of(code)))
    return out


def main() -> None:
    """Build the engine of pages from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, help="where what is made on the way is kept")
    parser.add_argument("--object", type=Path, nargs=2, metavar=("CODE", "OUT"), help=argparse.SUPPRESS)
    wanted = parser.parse_args()
    if wanted.object:
        emit(*wanted.object)
        return
    from conicoid.viewer.html import read_engine

    place = HERE.parent / PAGE_ENGINE
    with tempfile.TemporaryDirectory() as temporary, alone():
        if read_engine() is not None and is_newer(place):
            return
        print("Making the engine for pages ...", flush=True)
        drop_old_parts()
        folder = wanted.folder or (KEPT if (KEPT / "kernels.pickle").exists() else Path(temporary))
        folder.mkdir(parents=True, exist_ok=True)
        print(put(build(folder, stamped=True), place))


if __name__ == "__main__":
    main()
