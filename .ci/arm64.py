#!/usr/bin/env python3
"""Try the wheel for Linux on ARM on a machine with another processor: Debian's Python for ARM, under qemu.

    .ci/arm64.py                                     build it, and try it
    .ci/arm64.py dist/...manylinux_2_17_aarch64.whl  try this one

Needs apt, dpkg, pip and `apt-get install qemu-user`. Nothing is installed on this machine: Python, NumPy and the rest
are unpacked into a folder. Programs cannot start others there, so the tests are those that stay in one process: the
digests of all answers, the engine's routes, exact samples, pictures: three minutes. Exit status: 0 if they pass, 1 if
not, 2 if not tried.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from wheel import ROOT, TOOLS, suite

TARGET = "linux-aarch64"
DEBIAN = "python3.11-minimal", "libpython3.11-stdlib", "libstdc++6"
PLATFORMS = "manylinux2014_aarch64", "manylinux_2_17_aarch64", "manylinux_2_27_aarch64", "manylinux_2_28_aarch64"
TESTS = "tests/native/test_digest.py", "tests/integrators/test_whitted.py", "tests/exactness/test_whole_bodies.py"
TESTS += ("tests/engine/test_routes.py",)
APT = """\
APT::Architecture "arm64";
APT::Architectures {{ "arm64"; }};
Dir::State "{folder}/state";
Dir::State::status "{folder}/status";
Dir::Cache "{folder}/cache";
"""


def debian(folder: Path) -> Path:
    """A folder with Debian's Python for ARM and what it needs."""
    for name in ("state/lists/partial", "cache/archives/partial", "root"):
        (folder / name).mkdir(parents=True)
    (folder / "status").touch()  # nothing is installed there
    (folder / "apt.conf").write_text(APT.format(folder=folder))
    environment = os.environ | {"APT_CONFIG": str(folder / "apt.conf")}
    for words in (["update"], ["install", "--yes", "--download-only", "--no-install-recommends", *DEBIAN]):
        subprocess.run(["apt-get", "--quiet=2", *words], env=environment, check=True, stdout=subprocess.DEVNULL)
    for package in sorted((folder / "cache" / "archives").glob("*.deb")):
        subprocess.run(["dpkg", "--extract", package, folder / "root"], check=True)
    return folder / "root"


def packages(wheel: Path, folder: Path) -> Path:
    """The wheel, what it needs and the tests' tools, as they are for ARM."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--only-binary", ":all:"]
    pip += ["--target", str(folder), "--python-version", "3.11", "--implementation", "cp"]
    pip += [word for name in PLATFORMS for word in ("--platform", name)]
    subprocess.run([*pip, "--constraint", ROOT / "requirements-dev.lock", wheel, *TOOLS], check=True)
    return folder


def built(folder: Path) -> Path:
    """The wheel for ARM."""
    subprocess.run([sys.executable, "-m", "native.wheels", TARGET, "--out", str(folder)], cwd=ROOT, check=True)
    return next(folder.glob("*.whl"))


def main() -> int:
    """Build if need be, and try."""
    missing = [name for name in ("apt-get", "dpkg", "qemu-aarch64") if shutil.which(name) is None]
    if missing:
        print(f"Not tried: there is no {', '.join(missing)} (apt-get install qemu-user)", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="arm64-") as name:
        folder = Path(name)
        wheel = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else built(folder / "dist")
        try:
            root = debian(folder / "debian")
            site = packages(wheel, folder / "site")
        except subprocess.CalledProcessError as error:
            print(f"Not tried: {error} (is there a network?)", file=sys.stderr)
            return 2
        (folder / "suite").mkdir()
        qemu = ["qemu-aarch64", "-L", str(root), "-E", f"PYTHONPATH={site}", "-E", "OPENBLAS_NUM_THREADS=1"]
        python = [*qemu, str(root / "usr" / "bin" / "python3.11")]
        tests = [*python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *TESTS]
        done = subprocess.run(tests, cwd=suite(folder / "suite"), check=False)
    print(f"{wheel.name}: {'works' if done.returncode == 0 else 'fails'}")
    return 0 if done.returncode == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
