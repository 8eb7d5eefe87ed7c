"""The command ``conicoid``, also ``python -m conicoid``: signals and streams are ready before any large import.

Ctrl-C before that prints Python's traceback, so this module and those before it import little at their head.
"""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, NoReturn

_YOUNG, _MIDDLE, _OLD = 100_000, 50, 100
"""Thresholds of the garbage collector. Imports and files make tens of thousands of objects that stay, and with the
default thresholds the collector goes through them dozens of times."""


def run() -> NoReturn:
    """Run `main` in a process of its own, which ends without freeing objects one by one."""
    import atexit
    import contextlib
    import gc
    import threading

    gc.set_threshold(_YOUNG, _MIDDLE, _OLD)
    try:
        main()
    except SystemExit as end:
        code = end.code
    others = [thread for thread in threading.enumerate() if thread is not threading.main_thread() and not thread.daemon]
    if others or _must_end_normally() or not (code is None or isinstance(code, int)):
        sys.exit(code)
    atexit._run_exitfuncs()  # `os._exit` below skips them
    code = _flush_results(code)
    with contextlib.suppress(OSError, ValueError, AttributeError):  # stderr is closed, or None
        sys.stderr.flush()
    os._exit((code or 0) & 0xFF)


def _must_end_normally() -> bool:
    """Return whether the process must end as usual: for a profiler or tracer that reports then, or for a prompt."""
    if sys.getprofile() is not None or sys.gettrace() is not None:
        return True
    monitoring: Any = getattr(sys, "monitoring", None)  # from Python 3.12 on
    if monitoring is not None and any(monitoring.get_tool(number) is not None for number in range(6)):
        return True
    return bool(sys.flags.inspect or os.environ.get("PYTHONINSPECT"))


def main() -> NoReturn:
    """Run the command line, and end with one of the exit codes of `cli.terminal`."""
    # Shells let programs in the background of a script ignore the signal: then this one does, too
    takes_interrupts = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if takes_interrupts:
        signal.signal(signal.SIGINT, _end_now)
    from .cli.terminal import EXIT_INTERRUPT, open_streams

    open_streams()
    code = _command(takes_interrupts)
    if takes_interrupts:  # the work is done: a late Ctrl-C must not spoil its results
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    code = _flush_results(code)
    if code == EXIT_INTERRUPT:
        os._exit(code)  # compiled code that still runs would go on to its end, or be cut off
    sys.exit(code)


def _command(takes_interrupts: bool) -> Any:
    """Run the command; return its exit code."""
    from .cli.terminal import EXIT_FAILURE, EXIT_INTERRUPT, EXIT_OK

    try:
        from .cli.drawing import parse_plain_render

        command: Callable[[], Any] | None = parse_plain_render(sys.argv[1:])
        if command is None:
            from .cli import app

            command = app.main
        if takes_interrupts:  # from here on Ctrl-C has a message; imports before end at once
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


def _flush_results(code: Any) -> Any:
    """Write results that are still in a buffer; return the exit code."""
    from .cli.terminal import EXIT_FAILURE

    try:
        sys.stdout.flush()
    except SystemExit as end:
        return code or end.code
    except OSError as error:
        sys.stderr.write(f"error: {error.filename}: {(error.strerror or str(error)).lower()}\n")
        return code or EXIT_FAILURE
    return code


def _interrupt(*_: object) -> None:
    """Raise KeyboardInterrupt at the first Ctrl-C; a second ends the process."""
    signal.signal(signal.SIGINT, _end_now)
    raise KeyboardInterrupt


def _end_now(*_: object) -> None:
    """End the process at once: nothing is done yet, or the user has waited enough."""
    os._exit(130)  # `EXIT_INTERRUPT`, which may not be imported yet


if __name__ == "__main__":
    (run if vars(sys.modules["__main__"]) is globals() else main)()  # run by another program, which continues
