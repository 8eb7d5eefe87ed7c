"""The command ``conicoid``, also ``python -m conicoid``: what must be ready before anything large is imported."""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any, NoReturn

from .cli.terminal import EXIT_FAILURE, EXIT_INTERRUPT, EXIT_OK, open_streams

_YOUNG, _MIDDLE, _OLD = 100_000, 50, 100
"""Thresholds of Python's collector. What is imported and read are tens of thousands of objects that stay, and with the
usual ones it goes through them dozens of times."""


def run() -> NoReturn:
    """`main` in a process of its own, which ends without freeing what was made, object by object."""
    gc.set_threshold(_YOUNG, _MIDDLE, _OLD)
    try:
        main()
    except SystemExit as end:
        code = end.code
    others = [thread for thread in threading.enumerate() if thread is not threading.main_thread() and not thread.daemon]
    if others or _goes_on() or not (code is None or isinstance(code, int)):
        sys.exit(code)
    atexit._run_exitfuncs()
    code = _last_words(code)
    with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or none
        sys.stderr.flush()
    os._exit((code or 0) & 0xFF)


def _goes_on() -> bool:
    """Does somebody wait for the end: a profiler that tells then what it saw, or a prompt?"""
    if sys.getprofile() is not None or sys.gettrace() is not None:
        return True
    monitoring: Any = getattr(sys, "monitoring", None)  # from Python 3.12 on
    if monitoring is not None and any(monitoring.get_tool(number) is not None for number in range(6)):
        return True
    return bool(sys.flags.inspect or os.environ.get("PYTHONINSPECT"))


def main() -> NoReturn:
    """Do what the command line says, and end with one of `exit_codes`."""
    hears = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not in the background of a script
    if hears:
        signal.signal(signal.SIGINT, _end_now)
    open_streams()
    code = _command(hears)
    if hears:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    code = _last_words(code)
    if code == EXIT_INTERRUPT:
        os._exit(code)  # what was begun in compiled code would go on until it is done, or be cut off
    sys.exit(code)


def _command(hears: bool) -> Any:
    try:
        from .cli.drawing import parse_plain_render

        command: Callable[[], Any] | None = parse_plain_render(sys.argv[1:])
        if command is None:
            from .cli import app

            command = app.main
        if hears:
            signal.signal(signal.SIGINT, _interrupt)
        command()
    except SystemExit as end:
        return end.code
    except KeyboardInterrupt:
        return EXIT_INTERRUPT
    except (ImportError, MemoryError) as error:
        sys.stderr.write(f"error: {str(error) or 'not enough memory for this'}\n")
        return EXIT_FAILURE
    return EXIT_OK


def _last_words(code: Any) -> Any:
    """Results that are still to be written."""
    try:
        sys.stdout.flush()
    except SystemExit as end:
        return code or end.code
    except OSError as error:
        sys.stderr.write(f"error: {error.filename}: {(error.strerror or str(error)).lower()}\n")
        return code or EXIT_FAILURE
    return code


def _interrupt(*_: object) -> None:
    """Ctrl-C: the first is heard wherever the command is, a second ends it there."""
    signal.signal(signal.SIGINT, _end_now)
    raise KeyboardInterrupt


def _end_now(*_: object) -> None:
    """Nothing is done yet, or enough has been waited."""
    os._exit(EXIT_INTERRUPT)


if __name__ == "__main__":
    (run if vars(sys.modules["__main__"]) is globals() else main)()  # another program goes on
