#!/usr/bin/env python3
"""Build the wheel for this machine and try it as users get it: in a new environment, without any compiler.

    .ci/wheel.py              build it, and try it
    .ci/wheel.py WHEEL        try this one
    .ci/wheel.py --whole      with the whole fast suite (`make test-wheel`)

Tests are copied to where no source of the package is. A sample of them runs with the best level of machine code, and
the digests of all answers with each level that this processor can run. Tests of the compiler are left out
(tests/conftest.py). Exit status: 0 if all is well.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TOOLS = "pytest", "pytest-xdist", "hypothesis", "python-flint"
BESIDE = (
    "tests",
    "benchmarks",
    "docs",
    "examples",
    "native",
    ".ci",
    "pyproject.toml",
    "LICENSE",
    "CITATION.cff",
    "Makefile",
)
NO_COMPILER = "numba", "llvmlite", "ziglang"
ALL_TOOLS = (
    *(
        "abi3info",
        "anywidget",
        "av",
        "basedpyright",
        "mypy",
        "dask[array]",
        "distributed",
        "hatchling",
        "ipykernel",
        "joblib",
        "jsonschema",
    ),
    *("lief", "nbclient", "OpenEXR", "playwright"),
)
EACH_LEVEL = "tests/native/test_digest.py", "tests/native/test_no_compiler.py", "tests/test_system.py"
SAMPLE = (
    *("tests/reference", "tests/exactness/test_random_bodies.py", "tests/exactness/test_whole_bodies.py"),
    *("tests/engine/test_routes.py", "tests/integrators/test_whitted.py", "tests/seeds", "tests/test_commands.py"),
    *("tests/viewer/test_engine.py", "tests/native/test_start.py", "tests/derivatives/test_every_shape.py"),
    *("tests/test_docs.py::test_code_runs[README.md]", "tests/test_docs.py::test_code_runs[docs/index.md]"),
)


def built(folder: Path) -> Path:
    """The wheel for this machine."""
    subprocess.run([sys.executable, "-m", "native.wheels", "host", "--out", str(folder)], cwd=ROOT, check=True)
    return next(folder.glob("*.whl"))


def installed(wheel: Path, folder: Path, *more: str) -> Path:
    """An environment with a wheel and what tests need; its Python."""
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    subprocess.run([*pip, "--constraint", ROOT / "requirements-dev.lock", wheel, *TOOLS, *more], check=True)
    program = f"import importlib.util as find; print([name for name in {NO_COMPILER} if find.find_spec(name)])"
    found = subprocess.run([python, "-c", program], check=True, capture_output=True, text=True).stdout.strip()
    if found != "[]":
        raise SystemExit(f"the wheel brings {found}")
    return python


def levels(python: Path, folder: Path) -> list[str]:
    """The levels of machine code that this processor can run."""
    program = "from conicoid._jit.machine_code import levels; print(*levels())"
    command = [python, "-c", program]
    return subprocess.run(command, cwd=folder, env=users(), check=True, capture_output=True, text=True).stdout.split()


def users() -> dict[str, str]:
    """The variables that a process gets: nothing of this one's leads it to other code."""
    return {name: value for name, value in os.environ.items() if not name.startswith(("CONICOID_", "PYTHONPATH"))}


def suite(folder: Path) -> Path:
    """The tests and what they read, without the package."""
    for name in BESIDE:
        there = ROOT / name
        if there.is_dir():
            shutil.copytree(there, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(there, folder / name)
    for page in ROOT.glob("*.md"):
        shutil.copy(page, folder / page.name)
    return folder


def passes(python: Path, folder: Path, level: str, tests: tuple[str, ...], shown: bool = True) -> bool:
    """Do tests pass with a level? What they print is shown as it comes, or when they have ended."""
    environment = users() | {"CONICOID_LEVEL": level}
    command = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests]
    kept: dict[str, Any] = {} if shown else {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    done = subprocess.run(command, cwd=folder, env=environment, check=False, **kept)
    print(f"{level}: {' '.join(tests[:1])}, {len(tests)} in all\n{done.stdout or ''}", flush=True)
    return done.returncode == 0


def main() -> int:
    """Build if need be, and try."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", nargs="?", type=Path)
    parser.add_argument("--whole", action="store_true")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="wheel-") as name:
        folder = Path(name)
        wheel = wanted.wheel.resolve() if wanted.wheel else built(folder / "dist")
        python = installed(wheel, folder / "venv", *(ALL_TOOLS if wanted.whole else ()))
        (folder / "suite").mkdir()
        tests = suite(folder / "suite")
        *older, best = levels(python, tests)
        spread = "--numprocesses=auto", "--maxprocesses=4", "--dist=worksteal"
        with ThreadPoolExecutor() as pool:  # the older levels beside the best
            trials = [pool.submit(passes, python, tests, level, EACH_LEVEL, False) for level in older]
            fine = [passes(python, tests, best, (*(("tests",) if wanted.whole else EACH_LEVEL + SAMPLE), *spread))]
            fine += [trial.result() for trial in trials]
    print(f"{wheel.name}: {'works' if all(fine) else 'fails'}, {', '.join((*older, best))}")
    return 0 if all(fine) else 1


if __name__ == "__main__":
    sys.exit(main())
