"""The other end of `Processes`: a process that does one task after the other."""

from __future__ import annotations

import os
import pickle
import signal
import sys

from .processes import receive, send


def serve() -> None:
    """Answer tasks on standard input until it ends. What they print goes to standard error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asks
    tasks, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    sys.stdin = open(os.devnull)  # noqa: SIM115 - for the life of the process
    send(answers, b"ready")
    while True:
        try:
            data = receive(tasks)
        except EOFError:
            os._exit(0)
        try:
            call, arguments, keywords = pickle.loads(data)
            answer = pickle.dumps((True, call(*arguments, **keywords)), protocol=5)
        except BaseException as error:
            answer = _told(error)
        try:
            send(answers, answer)
        except OSError:
            os._exit(0)


def _told(error: BaseException) -> bytes:
    """An exception as an answer; as its text where it cannot be pickled."""
    try:
        data = pickle.dumps((False, error), protocol=5)
        pickle.loads(data)
        return data
    except Exception:
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")), protocol=5)
