"""Tasks that end badly, by functions that workers can import. `file` counts how often a task began."""

import os
import signal
import time


def starts(file):
    """Return how often the task began, this time included."""
    with open(file, "ab") as counts:
        counts.write(b"x")
    return os.path.getsize(file)


def dies(file, times):
    """Return the number of the process; the first `times` processes die."""
    if starts(file) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


class _Deadly:
    """An object that ends the process that pickles it."""

    def __reduce__(self):
        os._exit(1)


def dies_in_transfer(file):
    """Return a result that kills its process as this sends it. Raise an error the second time."""
    if starts(file) == 1:
        return _Deadly()
    raise ValueError("the second one fails by itself")


def slow(seconds):
    """Return the number of the process after a while."""
    time.sleep(seconds)
    return os.getpid()
