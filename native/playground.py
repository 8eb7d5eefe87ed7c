"""The playground as files for a web server: `python -m native.playground [OUT]`.

Python runs in the page itself: Pyodide, and Conicoid from its wheel, which is made unless --wheel names one. Pyodide
and NumPy come from --pyodide: an address (by default Pyodide's own), or a folder with its distribution. The page's
files of a folder are copied, so that the page loads nothing from another server.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

from conicoid.viewer.playground import first_scene, playground_page, worker

from .inspection import ROOT

PYODIDE = "314.0.7"
"""The version of Pyodide in the platform tag of the wheel (`targets`)."""
ADDRESS = f"https://cdn.jsdelivr.net/pyodide/v{PYODIDE}/full/"
PACKAGES = "numpy", "pyyaml", "pillow", "mpmath"
"""The packages of Pyodide that scenes in the text may import."""
CORE = "pyodide.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json"
WHEEL = "conicoid-*-pyemscripten_*.whl"


def made_wheel(folder: Path) -> Path:
    """Make the wheel for Pyodide in a folder."""
    command = [sys.executable, "-m", "native.wheels", "pyodide-wasm32", "--out", str(folder)]
    subprocess.run(command, check=True, cwd=ROOT)
    return next(folder.glob(WHEEL))


def files_of(distribution: Path) -> list[Path]:
    """Return the files of a folder with Pyodide that the page needs. SystemExit where one is missing."""
    lock = json.loads((distribution / "pyodide-lock.json").read_text(encoding="utf-8"))["packages"]
    program = next(iter(distribution.glob("pyodide.asm.*js")), distribution / "pyodide.asm.mjs")
    names, waiting = [*CORE, program.name], list(PACKAGES)
    for package in waiting:
        names.append(lock[package]["file_name"])
        waiting += [name for name in lock[package]["depends"] if name not in waiting]
    missing = [name for name in names if not (distribution / name).exists()]
    if missing:
        raise SystemExit(f"{distribution} lacks {', '.join(missing)}; it must be Pyodide's full distribution")
    return [distribution / name for name in names]


def write(out: Path, wheel: Path, pyodide: str = ADDRESS) -> None:
    """Write the files of the page into a folder."""
    out.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(wheel, out / wheel.name)
    if "://" not in pyodide:
        (out / "pyodide").mkdir(exist_ok=True)
        for file in files_of(Path(pyodide)):
            shutil.copyfile(file, out / "pyodide" / file.name)
        pyodide = "pyodide/"
    python = {"pyodide": pyodide.rstrip("/") + "/", "packages": PACKAGES, "wheel": wheel.name}
    (out / "index.html").write_text(playground_page(first_scene(), None, python=python), encoding="utf-8")
    (out / "worker.js").write_text(worker(), encoding="utf-8")


def main() -> None:
    """Write the playground from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "out", nargs="?", type=Path, default=ROOT / "out" / "playground", help="by default out/playground"
    )
    parser.add_argument("--wheel", type=Path)
    parser.add_argument("--pyodide", default=ADDRESS, help="an address, or a folder")
    wanted = parser.parse_args()
    write(wanted.out, wanted.wheel or made_wheel(ROOT / "dist"), wanted.pyodide)
    print(f"{wanted.out}/index.html, for a web server: python -m http.server --directory {wanted.out}")


if __name__ == "__main__":
    main()
