"""Processes that tests start, send Ctrl-C and wait for."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BOUND = 10.0
"""Seconds within which Ctrl-C must end the program, whose work would take minutes."""
COMMAND = "from conicoid.__main__ import run; run()"
needs_signals = pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent by a signal")


class Child:
    """A Python program that reports its progress by lines on stdout."""

    def __init__(self, program: str, *arguments: object, **options) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", program, *map(str, arguments)],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, preexec_fn=_hear_control_c, **options,
        )  # fmt: skip

    def line(self, bound: float = 300.0) -> str:
        """Return the next line. If it does not come in time, end the process and return nothing.

        Reading bypasses Python's buffer, because `communicate` would never see later lines that the buffer holds.
        """
        timer = threading.Timer(bound, self.process.kill)
        timer.start()
        line = b""
        try:
            while not line.endswith(b"\n") and (more := os.read(self.process.stdout.fileno(), 1)):
                line += more
        finally:
            timer.cancel()
        return line.decode().strip()

    def interrupt(self) -> None:
        """Send Ctrl-C."""
        self.process.send_signal(signal.SIGINT)

    def end(self, bound: float = BOUND) -> tuple[int, str, str]:
        """Return (exit code, the rest of stdout, stderr), or fail if the process does not end in time."""
        out, err = self.process.communicate(timeout=bound)
        return self.process.returncode, out, err


@contextmanager
def child(program: str, *arguments: object, **options) -> Iterator[Child]:
    """Start a process that ends with the block."""
    running = Child(program, *arguments, **options)
    try:
        yield running
    finally:
        running.process.kill()
        running.process.communicate()


def _hear_control_c() -> None:
    """Let Ctrl-C interrupt: a shell lets processes in the background ignore it, and children inherit that."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
