"""Processes that need the same kernel at once: it is compiled once, and nobody waits for the dead."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from .tiny import COMPILED, LOADED, Apart, apart, kept, posix_only, used


def turn_of(folder: Path):
    from conicoid._jit.compile_lock import CompileLock

    path = kept(folder)
    return CompileLock(path.with_name(f"{path.name}.lock"))


@pytest.fixture
def folder(tmp_path):
    """With a kernel in it, so that its name is known."""
    apart(tmp_path / "kernels")
    return tmp_path / "kernels"


def watched() -> object:
    """Tell the test when this process hears that the kernel is being compiled, here or elsewhere."""
    from conicoid._jit.decorators import on_compile

    from . import tiny

    with on_compile(lambda name: tiny.here.send(name)):
        return used()


def test_whoever_comes_second_waits_and_loads(folder):
    turn = turn_of(folder)
    assert turn.taken()
    path = kept(folder)
    data = path.read_bytes()
    path.unlink()
    waiting = [Apart(folder, watched) for _ in range(3)]
    for each in waiting:
        assert each.pipe.recv() == "doubled"  # it has found the turn taken
    path.write_bytes(data)
    path.chmod(0o600)
    turn.end()
    for each in waiting:
        outcome = each.outcome()
        assert outcome.quiet, outcome
        assert outcome.value == (42.0, ["doubled"])  # told, but what was told is the other process's work


def compiled_here() -> int:
    """How many kernels this process compiled itself."""
    from numba.core import event

    with event.install_recorder("numba:compile") as recorder:
        used()
    return sum(1 for _, entry in recorder.buffer if entry.is_start)


def test_many_at_once_compile_it_once(tmp_path):
    crowd = [Apart(tmp_path / "kernels", compiled_here) for _ in range(6)]
    outcomes = [each.outcome() for each in crowd]
    assert all(outcome.quiet for outcome in outcomes), outcomes
    assert sum(outcome.value for outcome in outcomes) == 1


def dies_with_the_turn() -> None:
    assert turn_of(Path(os.environ["CONICOID_CACHE_DIR"])).taken()
    os.kill(os.getpid(), signal.SIGKILL)


@posix_only
def test_the_turn_of_a_process_that_was_killed_is_over(folder):
    assert apart(folder, dies_with_the_turn).code == -signal.SIGKILL
    kept(folder).write_bytes(b"")
    started = turn_of(folder)
    assert started.taken()
    started.end()
    assert apart(folder).value == COMPILED


def impatient() -> object:
    from conicoid._jit import numba_cache as jit_cache

    jit_cache.PATIENCE = 0.2
    return used()


def test_a_process_that_never_ends_its_turn_is_not_waited_for_forever(folder):
    turn = turn_of(folder)
    assert turn.taken()
    kept(folder).write_bytes(b"")
    outcome = apart(folder, impatient)
    turn.end()
    assert outcome.quiet, outcome
    assert outcome.value == (42.0, ["doubled", "doubled"])  # another process's, then this one's
    assert apart(folder).value == LOADED


def interrupted() -> object:
    from conicoid._jit import compile_lock as others

    def keep_stopping() -> None:
        while True:
            time.sleep(0.1)
            others.stop_polling()

    threading.Thread(target=keep_stopping, daemon=True).start()
    try:
        used()
    except KeyboardInterrupt:
        return "interrupted"
    return None


def test_whoever_waits_can_be_interrupted(folder):
    turn = turn_of(folder)
    assert turn.taken()
    kept(folder).write_bytes(b"")
    outcome = apart(folder, interrupted)
    turn.end()
    assert outcome.value == "interrupted"


def fails_to_compile() -> object:
    """A turn ends also where the compiler fails."""
    from . import tiny

    try:
        tiny.declared()("no number")
    except Exception as error:
        return type(error).__name__
    return None


def test_a_compilation_that_fails_ends_the_turn(folder):
    assert apart(folder, fails_to_compile).value == "TypingError"
    assert apart(folder).value == LOADED


def without_locks() -> object:
    from conicoid._jit import compile_lock as turn

    def none(descriptor: int) -> None:
        raise OSError(38, "Function not implemented")

    turn._lock = none
    return used()


def test_where_there_are_no_locks_all_compile(tmp_path):
    outcome = apart(tmp_path / "kernels", without_locks)
    assert outcome.quiet, outcome
    assert outcome.value == COMPILED
