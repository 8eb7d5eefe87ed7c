"""Tasks that end badly, by functions that workers can import. `file` counts how often a task was begun."""

import os
import signal
import time


def begun(file):
    """How often it was begun, this time included."""
    with open(file, "ab") as counts:
        counts.write(b"x")
    return os.path.getsize(file)


def dies(file, times):
    """The number of the process; the first `times` die of it."""
    if begun(file) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


class _Deadly:
    """What a process dies of when it sends it."""

    def __reduce__(self):
        os._exit(1)


def dies_when_asked(file):
    """A result whose process dies when it is fetched; the second time an error."""
    if begun(file) == 1:
        return _Deadly()
    raise ValueError("the second one fails by itself")


def slow(seconds):
    """The number of the process, after a while."""
    time.sleep(seconds)
    return os.getpid()
