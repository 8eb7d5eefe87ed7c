#!/usr/bin/env python3
"""Try the newest Numba: the tests of the compiler in an environment of its own, and the digests of compiled kernels.

    .ci/newest_numba.py            the newest release
    .ci/newest_numba.py --pre      the newest, be it a release candidate
    .ci/newest_numba.py 0.65.0     this one

At the end it says what to write where. Exit status: 0 if it works, 1 if it does not, 2 if it could not be tried.
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
TESTS = (
    "tests/test_jit.py",
    "tests/native/test_digest.py",
    "tests/engine/test_targets.py",
    "tests/engine/test_assembly.py",
)
TESTS += "tests/test_forks.py", "tests/test_interrupts.py", "tests/integrators/test_whitted.py"
"""The same bits, a picture, vectors in the machine code, and what happens while something is compiled."""
ASKS_FOR_A_TESTED_ONE = "tests/test_jit.py::test_the_installed_numba_is_a_tested_one"
COMPILER, REQUIREMENTS = "conicoid/_jit/compiler.py", "pyproject.toml"


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
        r"^TESTED = \(\d+, \d+\), \((\d+), (\d+)\)$", (ROOT / COMPILER).read_text(encoding="utf-8"), re.MULTILINE
    )
    if not found:
        raise NotTriedError(f"TESTED is not in {COMPILER}")
    return int(found[1]), int(found[2])


def passes(python: Path) -> bool:
    """Do the tests pass, all in one process, which compiles each kernel once?"""
    command = [python, "-m", "pytest", "-q", "--deselect", ASKS_FOR_A_TESTED_ONE, *TESTS]
    return subprocess.run(command, cwd=ROOT, env=os.environ | {"CONICOID_JIT": "own"}, check=False).returncode == 0


def verdict(version: str, tested: tuple[int, int], works: bool) -> list[str]:
    """What is to be written where, after a trial."""
    major, minor = map(int, version.split(".")[:2])
    lines = [f"Numba {version} {'works' if works else 'fails'}."]
    if (major, minor) <= tested:
        lines.append(
            f"TESTED in {COMPILER} has it: {'nothing to raise' if works else 'mend the compiler, or lower it'}."
        )
    elif works:
        lines.append(
            f"Raise the second of TESTED in {COMPILER} from {tested} to {(major, minor)}, with it the limit of the "
            f"extra jit in {REQUIREMENTS}, and run `make lock`."
        )
    else:
        lines.append(f"Leave TESTED in {COMPILER} at {tested}: users get an older Numba. Mend the compiler.")
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
        works = passes(python)
    print("\n".join(verdict(version, tested, works)))
    return 0 if works else 1


if __name__ == "__main__":
    sys.exit(main())
