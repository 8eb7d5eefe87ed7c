"""Compiling ahead: while this process compiles one kernel, others compile what it will need next, into the same cache.

Numba compiles on one core. Whoever begins something large says what it will need (`expect`). The first time that
the cache lacks a kernel, children are started, one for each further core, and one more while this process waits.
They run `compile_jobs` and report line by line which kernels they begin and have made. Whatever goes wrong with them
costs time only: a kernel that no child has made is compiled here.
"""

from __future__ import annotations

import atexit
import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

JOBS: dict[str, tuple[str, ...]] = {
    "rays": ("coherent_packets", "trace_first"),
    "streams": ("ray_keys", "_begin_places", "trace_ordered"),
    "points": ("faces_of", "points_along", "normals_of"),
}
"""The jobs of a child, and the kernels that each makes.

An integrator's kernel is a job as well, by its own name.
"""

_PROGRAM = "from conicoid.compile_jobs import main; main()"

Listener = Callable[[str], None]


_APART: dict[str, Any] = {"start_new_session": True}  # Ctrl-C is for this process, which ends the others
if sys.platform == "win32":
    _APART = {"creationflags": subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP}


def _kernels(job: str) -> tuple[str, ...]:
    """The kernels that a job makes."""
    return JOBS.get(job, (job,))


class _Child:
    """A process that compiles one job after the other. It ends when its pipe is closed, or with this process."""

    def __init__(self, others: _Others, job: str) -> None:
        self.job = job
        path = [entry for entry in sys.path if isinstance(entry, str)]
        program = f"import sys; sys.path[:] = {path!r}; {_PROGRAM}"
        self.process = subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, encoding="utf-8", **_APART,
        )  # fmt: skip
        try:
            threading.Thread(target=self._listen, args=(others,), name="conicoid-ahead", daemon=True).start()
        except RuntimeError:  # the system gives no more threads
            self.process.kill()
            self.process.communicate()
            raise
        self.give(job)

    def give(self, job: str) -> None:
        """Another job; none, "", ends the process."""
        self.job = job
        stdin = self.process.stdin
        assert stdin is not None
        with contextlib.suppress(OSError, ValueError):  # it has ended: `_listen` hears of that
            stdin.write(f"{job}\n")
            stdin.flush()
        if not job:
            with contextlib.suppress(OSError):
                stdin.close()

    def _listen(self, others: _Others) -> None:
        """Read the reports of the child until it ends."""
        stdout = self.process.stdout
        assert stdout is not None
        with stdout:
            for line in stdout:
                word, _, name = line.strip().partition(" ")
                others.hear(self, word, name)
        self.give("")
        self.process.wait()
        others.forget(self)


class _Others:
    """What is wanted, and the children that make it."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.wanted: list[str] = []
        self.asked: set[str] = set()
        self.made: set[str] = set()
        self.children: list[_Child] = []
        self.listeners: list[Listener] = []
        self.waiting = 0
        self.cold = False  # has the cache lacked a kernel?
        self.off = False
        self.interrupted = False

    def expect(self, jobs: tuple[str, ...]) -> None:
        with self.changed:
            self.wanted += [job for job in jobs if job not in self.asked]
            self.asked.update(jobs)
            if self.cold:
                self._start()

    def obtained(self, kernel: str, cache: str) -> bool:
        with self.changed:
            self.cold = True
            self.off = self.off or not possible(cache)
            self.wanted = [job for job in self.wanted if kernel not in _kernels(job)]
            self._start()
            if not self._promised(kernel):
                return False
            self.waiting += 1
            self._start()
            self.interrupted = False
            self.changed.wait_for(lambda: self.interrupted or not self._promised(kernel))
            self.waiting -= 1
            if self.interrupted:
                raise KeyboardInterrupt
            return kernel in self.made

    def hear(self, child: _Child, word: str, name: str) -> None:
        """Handle a child's report: it begins a kernel, has made one, or is done with a job."""
        with self.changed:
            listeners = list(self.listeners) if word == "begin" else []
            if word == "made":
                self.made.add(name)
            if word == "done":
                more = self.wanted and not self.off and len(self.children) <= self._allowed()
                child.give(self.wanted.pop(0) if more else "")
            self.changed.notify_all()
        for listener in listeners:
            listener(name)

    def forget(self, child: _Child) -> None:
        """A child has ended; after a failure no others are started."""
        with self.changed:
            self.children.remove(child)
            self.off = self.off or child.process.returncode != 0
            self.changed.notify_all()

    def poll(self, done: Callable[[], bool], limit: float) -> None:
        deadline = time.monotonic() + limit
        with self.changed:
            self.interrupted = False
            while not done() and time.monotonic() < deadline:
                self.changed.wait(0.05)
                if self.interrupted:
                    raise KeyboardInterrupt

    def stop(self) -> None:
        """End the children; whoever waits is interrupted."""
        with self.changed:
            self.wanted, self.interrupted = [], True
            for child in self.children:
                child.process.kill()
            self.changed.notify_all()

    def _promised(self, kernel: str) -> bool:
        """Is some child to make a kernel that is not made yet?"""
        return kernel not in self.made and any(kernel in _kernels(child.job) for child in self.children)

    def _allowed(self) -> int:
        """How many children there may be now."""
        return _cores() - (0 if self.waiting else 1)

    def _start(self) -> None:
        """Start children while there are jobs and cores for them."""
        while not self.off and self.wanted and len(self.children) < self._allowed():
            try:
                self.children.append(_Child(self, self.wanted.pop(0)))
            except (OSError, RuntimeError):
                self.off = True


def _cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def possible(cache: str) -> bool:
    """May this process have children that compile into a folder?

    Not on one core or thread, as one of several workers, where the folder cannot be written, or where the program
    that runs is something else with a Python in it.
    """
    return (
        _cores() > 1
        and os.environ.get("CONICOID_THREADS", "") != "1"
        and multiprocessing.parent_process() is None
        and os.access(cache, os.W_OK)
        and not getattr(sys, "frozen", False)
        and Path(sys.executable or "").name.lower().startswith("python")
    )


_others = _Others()
_forked: list[_Others] = []  # of processes that this one is a fork of


def _begin_anew() -> None:
    """In a fork of this process: the children are not its own, and it has none."""
    global _others
    _forked.append(_others)
    _others = _Others()
    _others.off = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_anew)


@atexit.register
def _end() -> None:
    """The children are ended, and not left behind by one more Ctrl-C."""
    others = _others
    with _deaf():
        others.stop()
        for child in list(others.children):
            child.process.wait()


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """Within the block, which is over in a moment, Ctrl-C is not heard."""
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


def expect(*jobs: str) -> None:
    """Announce what will be needed soon; nothing happens unless the cache turns out to lack kernels."""
    if not _others.asked.issuperset(jobs):
        _others.expect(jobs)


def obtained(kernel: str, cache: str) -> bool:
    """For a kernel that the cache in a folder lacks: True if another process has put it there, which is waited for.

    Raises KeyboardInterrupt if `stop` is called meanwhile.
    """
    return _others.obtained(kernel, cache)


def poll(done: Callable[[], bool], limit: float) -> None:
    """Poll until `done()` is true, for some seconds at most.

    Raises KeyboardInterrupt if `stop` is called meanwhile.
    """
    _others.poll(done, limit)


def begun(kernel: str) -> None:
    """Notify listeners that another process, which is no child of this one, is compiling a kernel."""
    for listener in list(_others.listeners):
        listener(kernel)


def stop() -> None:
    """End all that is compiled ahead."""
    _others.stop()


def alone() -> None:
    """Start no children: for one that is a child itself."""
    _others.off = True


@contextlib.contextmanager
def on_begin(callback: Listener) -> Iterator[None]:
    """Within the block, call `callback(name)` when another process begins a kernel."""
    listeners = _others.listeners  # a fork that leaves the block has others
    listeners.append(callback)
    try:
        yield
    finally:
        listeners.remove(callback)
