#!/usr/bin/env python3
"""Try the newest Numba: a sample of the tests in an environment of its own, in both ways of compiling.

    .ci/newest_numba.py            the newest release
    .ci/newest_numba.py --pre      the newest, be it a release candidate
    .ci/newest_numba.py 0.65.0     this one

At the end it says what to write where. Exit status: 0 if both ways work, 1 if one does not, 2 if it could not be tried.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OWN_DEEP = "tests/test_jit.py", "tests/engine/test_assembly.py"
"""For our own way, the long tests too: both ways give the same bits, and the machine code is vectors."""
OWN = "tests/engine/test_routes.py", "tests/engine/test_targets.py", "tests/kernel_cache"
OWN += "tests/test_forks.py", "tests/test_interrupts.py", "tests/integrators"
"""Answers, the cache, and what happens while something is compiled."""
PLAIN = "tests/engine/test_routes.py", "tests/integrators/test_whitted.py"
"""For Numba's `njit`: answers on all routes, and a picture. Each process compiles all anew."""
ASKS_FOR_A_TESTED_ONE = "tests/test_jit.py::test_the_installed_numba_is_one_of_these"
JIT, REQUIREMENTS = "conicoid/_jit/dispatch.py", "pyproject.toml"


class NotTriedError(Exception):
    """The environment cannot be made."""


def constraints(lock: str) -> str:
    """The locked packages without the compiler's, which are to be new, and NumPy, which has to fit them."""
    return "".join(
        line
        for line in lock.splitlines(keepends=True)
        if not re.match(r"(numba|llvmlite|numpy)\W", line, re.IGNORECASE)
    )


def install(folder: Path, wanted: str, pre: bool) -> Path:
    """A virtual environment with Conicoid, the tests' packages and a Numba; its Python."""
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    limits = folder / "constraints.txt"
    limits.write_text(constraints((ROOT / "requirements-dev.lock").read_text(encoding="utf-8")), encoding="utf-8")
    pip = [
        python,
        "-m",
        "pip",
        "--disable-pip-version-check",
        "install",
        "--quiet",
        "--retries",
        "1",
        "--constraint",
        limits,
    ]
    numba = f"numba=={wanted}" if wanted else "numba"
    # Numba in a step of its own: `--pre` is meant for nothing else
    for arguments in (
        ["--upgrade", "pip", "hatchling"],
        [*(["--pre"] if pre else []), numba],
        ["--no-build-isolation", "--editable", ".", "--group", "dev"],
    ):
        done = subprocess.run([*pip, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode:
            reason = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or [done.stderr[-500:]]
            raise NotTriedError(
                f"pip could not install {' '.join(arguments)} (is there a network?):\n" + "\n".join(reason)
            )
    return python


def version_in(python: Path) -> str:
    """Of the Numba that an environment has."""
    program = "from importlib.metadata import version; print(version('numba'))"
    return subprocess.run([python, "-c", program], capture_output=True, text=True, check=True).stdout.strip()


def last_tested() -> tuple[int, int]:
    """The end of TESTED, read and not imported: that might need the very Numba that is tried."""
    found = re.search(
        r"^TESTED = \(\d+, \d+\), \((\d+), (\d+)\)$", (ROOT / JIT).read_text(encoding="utf-8"), re.MULTILINE
    )
    if not found:
        raise NotTriedError(f"TESTED is not in {JIT}")
    return int(found[1]), int(found[2])


def passes(python: Path, way: str, tests: tuple[str, ...], folder: Path, deep: bool = False) -> bool:
    """Do tests pass in one way of compiling, with kernels of their own?"""
    environment = os.environ | {"CONICOID_JIT": way, "CONICOID_CACHE_DIR": str(folder / f"kernels-{way}")}
    command = [python, "-m", "pytest", "-q", "-m", "deep or not deep" if deep else "not deep"]
    command += ["--deselect", ASKS_FOR_A_TESTED_ONE, *tests]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode == 0


def verdict(version: str, tested: tuple[int, int], own: bool, plain: bool) -> list[str]:
    """What is to be written where, after a trial."""
    major, minor = map(int, version.split(".")[:2])
    known = (major, minor) <= tested
    lines = [f"Numba {version}: our own way {'works' if own else 'fails'}, plain njit {'works' if plain else 'fails'}."]
    if own and known:
        lines.append(f"TESTED in {JIT} has it: nothing to raise.")
    elif own:
        lines.append(f"Raise the second of TESTED in {JIT} from {tested} to {(major, minor)}, and run `make lock`.")
    elif known:
        lines.append(f"TESTED in {JIT} has it: mend our own way, or lower TESTED; meanwhile CONICOID_JIT=plain helps.")
    else:
        lines.append(f"Leave TESTED in {JIT} at {tested}: users of {major}.{minor} get plain njit. Mend our own way.")
    if not plain:
        lines.append(f"Until that is mended, {REQUIREMENTS} must refuse it: numba<{major}.{minor}.")
    return lines


def main() -> int:
    """Try, and say what came out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version", nargs="?", default="", help="a version of Numba; without it the newest")
    parser.add_argument("--pre", action="store_true", help="take release candidates as well")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="newest-numba-") as name:
        folder = Path(name)
        try:
            python = install(folder / "venv", arguments.version, arguments.pre)
            version, tested = version_in(python), last_tested()
        except NotTriedError as error:
            print(f"Not tried: {error}", file=sys.stderr)
            return 2
        print(f"Numba {version}; tested are versions up to {tested[0]}.{tested[1]}.", flush=True)
        own = passes(python, "own", OWN, folder) & passes(python, "own", OWN_DEEP, folder, deep=True)
        plain = passes(python, "plain", PLAIN, folder)
    print("\n".join(verdict(version, tested, own, plain)))
    return 0 if own and plain else 1


if __name__ == "__main__":
    sys.exit(main())
