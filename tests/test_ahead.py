"""Compiling ahead: a child that does its work, fails, is interrupted or left alone; and the kernels it is said to make."""

import importlib
import os
import pkgutil
import subprocess
import sys
import threading
import time

import pytest

import conicoid
from conicoid import compile_jobs
from conicoid.compiler import ahead
from conicoid.compiler.jit import DECLARED
from conicoid.integrators import INTEGRATORS
from conicoid.render.tiles import tile_kernel

SAYS = "import sys; job = sys.stdin.readline().strip(); print('begin', 'whitted_tiles', flush=True);"
MAKES = f"{SAYS} print('made', 'whitted_tiles'); print('done', job, flush=True); sys.stdin.readline()"
FAILS = f"{SAYS} sys.exit(1)"
HANGS = f"{SAYS} sys.stdin.readline()"


@pytest.fixture
def others(monkeypatch, tmp_path):
    """A process of two cores that has compiled nothing yet, with a folder for a cache."""
    monkeypatch.setattr(ahead, "_cores", lambda: 2)
    monkeypatch.delenv("CONICOID_THREADS", raising=False)
    fresh = ahead._Others()
    monkeypatch.setattr(ahead, "_others", fresh)
    yield fresh
    children = list(fresh.children)
    fresh.stop()
    for child in children:
        child.process.wait()


def none_left(others) -> bool:
    """Have all children ended and been heard of, within some seconds?"""
    with others.changed:
        return others.changed.wait_for(lambda: not others.children, 20)


def test_no_child_without_a_kernel_that_is_missing(others):
    ahead.expect("whitted_tiles")
    assert not others.children


def test_what_a_child_makes_is_waited_for_and_told(others, monkeypatch, tmp_path):
    monkeypatch.setattr(ahead, "_PROGRAM", MAKES)
    told: list[str] = []
    with ahead.on_begin(told.append):
        ahead.expect("whitted_tiles")
        assert not ahead.obtained("grow", str(tmp_path))  # nobody else makes that one
        assert ahead.obtained("whitted_tiles", str(tmp_path))
    assert told == ["whitted_tiles"]
    assert none_left(others)


def test_a_child_that_fails_changes_nothing(others, monkeypatch, tmp_path):
    monkeypatch.setattr(ahead, "_PROGRAM", FAILS)
    ahead.expect("whitted_tiles", "rays")
    assert not ahead.obtained("grow", str(tmp_path))
    assert not ahead.obtained("whitted_tiles", str(tmp_path))
    assert none_left(others)
    assert others.off


def test_a_kernel_whose_job_nobody_has_begun_is_compiled_here(others, tmp_path):
    ahead.expect("whitted_tiles")
    assert not ahead.obtained("whitted_tiles", str(tmp_path))
    assert not others.children


def test_an_interrupt_ends_children_and_whoever_waits(others, monkeypatch, tmp_path):
    monkeypatch.setattr(ahead, "_PROGRAM", HANGS)
    ahead.expect("whitted_tiles")
    ahead.obtained("grow", str(tmp_path))
    threading.Timer(0.5, ahead.stop).start()
    with pytest.raises(KeyboardInterrupt):
        ahead.obtained("whitted_tiles", str(tmp_path))
    assert none_left(others)


def test_one_more_child_while_this_process_waits(others, monkeypatch, tmp_path):
    monkeypatch.setattr(ahead, "_PROGRAM", HANGS)
    ahead.expect("whitted_tiles", "rays", "points")
    ahead.obtained("grow", str(tmp_path))
    assert [child.job for child in others.children] == ["whitted_tiles"]
    seen: list[list[str]] = []

    def look():
        time.sleep(0.5)
        seen.append([child.job for child in others.children])
        ahead.stop()

    threading.Thread(target=look).start()
    with pytest.raises(KeyboardInterrupt):
        ahead.obtained("whitted_tiles", str(tmp_path))
    assert seen == [["whitted_tiles", "rays"]]


@pytest.mark.parametrize(
    ("change", "value"),
    [
        ("threads", "1"),
        ("cores", 1),
        ("executable", "/usr/bin/blender"),
        ("executable", ""),
        ("parent", object()),
        ("folder", "missing"),
    ],
)
def test_where_there_must_be_no_child(others, monkeypatch, tmp_path, change, value):
    folder = tmp_path
    assert ahead.possible(str(folder))
    if change == "threads":
        monkeypatch.setenv("CONICOID_THREADS", value)
    elif change == "cores":
        monkeypatch.setattr(ahead, "_cores", lambda: value)
    elif change == "executable":
        monkeypatch.setattr(sys, "executable", value)
    elif change == "parent":
        monkeypatch.setattr("multiprocessing.parent_process", lambda: value)
    else:
        folder = tmp_path / value
    assert not ahead.possible(str(folder))
    ahead.expect("whitted_tiles")
    ahead.obtained("grow", str(folder))
    assert not others.children


def child(calls: str) -> subprocess.Popen[str]:
    """The real program of a child, with other jobs."""
    program = f"import time; from conicoid.compile_jobs import main; main({calls})"
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", program], stdin=pipe, stdout=pipe, text=True)


def test_a_child_does_its_jobs_and_ends():
    with child("{'a': lambda: None, 'b': lambda: None}") as process:
        said, _ = process.communicate("a\nb\n\n", 30)
    # After the empty line it may end before it has begun
    assert "done a\ndone b\n".startswith(said)
    assert process.returncode == 0


def test_a_child_ends_in_the_middle_of_a_job_when_its_parent_has():
    with child("{'a': lambda: None, 'long': lambda: time.sleep(600)}") as process:
        process.stdin.write("a\nlong\n")
        process.stdin.flush()
        assert process.stdout.readline() == "done a\n"
        process.stdin.close()
        assert process.wait(20) == 0


def kernels() -> list[str]:
    """The name of every kernel of the package."""
    for module in pkgutil.walk_packages(conicoid.__path__, "conicoid."):
        if not module.name.startswith(("conicoid.bench", "conicoid.viewer", "conicoid.__main__")):
            importlib.import_module(module.name)
    for name in INTEGRATORS:
        tile_kernel(name)
    return list(DECLARED)


def test_a_fork_within_a_block_that_listens_leaves_it(others, monkeypatch):
    heard = []
    with ahead.on_begin(heard.append):
        monkeypatch.setattr(ahead, "_others", ahead._Others())  # what a child of `os.fork` begins with
    assert others.listeners == []


def test_jobs_name_kernels_that_there_are_once():
    names = kernels()
    promised = [name for job in compile_jobs.CALLS for name in ahead.JOBS.get(job, (job,))]
    assert [names.count(name) for name in promised] == [1] * len(promised)
    assert ahead.JOBS.keys() <= compile_jobs.CALLS.keys()
    assert "whitted_tiles" in promised


REAL = """
import conicoid as co, numpy as np
from conicoid.compiler.jit import on_compile
from conicoid.compiler.ahead import JOBS
from conicoid.compile_jobs import CALLS
made = []
with on_compile(made.append):
    scene = co.Scene([co.Sphere(1), co.Box((1, -1, -1), (3, 1, 1)) - co.Sphere(1.2, (2, 0, 0))])
    scene.render(64, 48)
    scene.first_hit(co.Camera((0.3, 0.2, 9), (0.1, 0, 0), up=(0, 1, 0)).rays(64, 64)).normal
    some = np.random.default_rng(0)
    scene.first_hit(some.uniform(-3, 3, (4096, 3)), some.normal(size=(4096, 3)))
print(*(name for name in made if any(name in JOBS.get(job, (job,)) for job in CALLS)))
"""


@pytest.mark.deep
def test_what_jobs_make_is_what_scenes_need(tmp_path):
    """Numba compiles a kernel anew for every other kind of array: none of these may differ."""
    environment = os.environ | {"CONICOID_CACHE_DIR": str(tmp_path), "CONICOID_THREADS": "1"}
    jobs = "from conicoid.compile_jobs import CALLS\nfor call in CALLS.values(): call()"
    for program in (jobs, REAL):
        run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
    assert run.stdout.split() == []
