"""The door with checks of addresses and undefined behaviour: a sample of queries, wrong arguments, and the pool alone."""

import os
import shutil
import subprocess
import sys

import pytest

from native import build, link

from ..children import ROOT
from ..machine_code import needs_machine_code

CHECKS = "-O1 -g -fPIC -shared -fsanitize=address,undefined -fno-sanitize-recover=undefined -ffp-contract=off".split()
SAMPLE = "tests/engine/test_routes.py", "tests/exactness/test_whole_bodies.py", "tests/integrators"

pytestmark = [
    needs_machine_code,
    pytest.mark.deep,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc with its sanitizers is needed"),
]


@pytest.fixture(scope="module")
def checked_copy(tmp_path_factory):
    """Return a copy of the package with a checked extension, and its environment."""
    folder = tmp_path_factory.mktemp("checked")
    runtime = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True).stdout.strip()
    if not os.path.isabs(runtime):
        pytest.skip("gcc has no address sanitizer here")
    for part in ("conicoid", "tests", "native", "benchmarks", "docs", "examples"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__", "_kernels.*"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    target = build.host()
    target = target.only(build.host_level(target))
    made = folder / "made"
    made.mkdir()
    plain = build.build(target, made)
    sources = [str(link.HERE / name) for name in link.SOURCES]
    out = folder / "conicoid" / plain.name
    headers = [f"-I{plain.parent}", f"-I{link.HERE}"]
    subprocess.run(["gcc", *CHECKS, *headers, "-o", str(out), *sources, *map(str, made.glob("*.o"))], check=True)
    checks = {"ASAN_OPTIONS": "detect_leaks=0", "LD_PRELOAD": runtime, "PYTHONPATH": str(folder)}
    return folder, os.environ | checks


@pytest.mark.parametrize("checks", ["thread", "address,undefined"])
def test_threads_of_the_pool(tmp_path, checks):
    sources = [ROOT / "tests" / "native" / "crowd.c", link.HERE / "pool.c", link.HERE / "scratch.c"]
    command = ["gcc", "-g", "-O1", "-pthread", f"-fsanitize={checks}", f"-I{link.HERE}", "-o", str(tmp_path / "crowd")]
    subprocess.run([*command, *map(str, sources)], check=True)
    run = subprocess.run([tmp_path / "crowd"], capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, (run.stdout + run.stderr)[-3000:]


@pytest.mark.parametrize(
    "words",
    [("pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", *SAMPLE), ("tests.native.fuzz", "20000", "7")],
)
def test_queries_and_wrong_arguments(checked_copy, words):
    folder, environment = checked_copy
    command = [sys.executable, "-m", *words]
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=3000)
    assert run.returncode == 0, (run.stdout + run.stderr)[-3000:]
