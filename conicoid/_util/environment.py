"""The environment variables that Conicoid reads, and messages on wrong ones."""

from __future__ import annotations

import functools
import os
import warnings
from collections.abc import Iterator

THREADS, JIT, LEVEL, DEVICE = "CONICOID_THREADS", "CONICOID_JIT", "CONICOID_LEVEL", "CONICOID_DEVICE"
KERNELS = "CONICOID_KERNELS"
"""Read when a wheel is built, by native/hook.py, and never again."""
KNOWN = THREADS, JIT, LEVEL, DEVICE, KERNELS
DEVICES = "cpu", "cuda"
MOST_THREADS = 1 << 16
_LONGEST = 80
"""The largest number of characters of a value in a message."""


def read_threads() -> int | None:
    """Return the number in CONICOID_THREADS, None if it is not set; raise ValueError for anything else."""
    warn_of_unknown()
    text = os.environ.get(THREADS, "")
    if not text:
        return None
    # `int` accepts signs, spaces, underscores and other digits too
    if not (text.isascii() and text.isdigit() and len(text) < 7 and 1 <= int(text) <= MOST_THREADS):
        raise ValueError(f"{THREADS} must be an integer from 1 to {MOST_THREADS}, got {_quote(text, _LONGEST)}")
    return int(text)


def read_jit_mode() -> str:
    """Return the value of CONICOID_JIT, "own" to compile kernels, or ""; raise ValueError for anything else."""
    warn_of_unknown()
    text = os.environ.get(JIT, "")
    if text not in ("", "own"):
        raise ValueError(f"{JIT} must be 'own', got {_quote(text, _LONGEST)}")
    return text


def read_processor_level() -> str:
    """Return the processor level in CONICOID_LEVEL that selects machine code, as "x86-64-v3"; "" for the best."""
    return os.environ.get(LEVEL, "")


def read_device() -> str:
    """Return the device in CONICOID_DEVICE, "cpu" if it is not set; raise ValueError for anything else."""
    warn_of_unknown()
    text = os.environ.get(DEVICE, "") or DEVICES[0]
    if text not in DEVICES:
        raise ValueError(f"{DEVICE} must be {' or '.join(map(repr, DEVICES))}, got {_quote(text, _LONGEST)}")
    return text


def check_environment() -> None:
    """Raise ValueError for a wrong value or an unknown name; the command line ignores neither."""
    for message in _unknown():
        raise ValueError(message)
    read_threads()
    read_jit_mode()
    read_device()


@functools.cache
def warn_of_unknown() -> None:
    """Warn of unknown names, once in a process: on the first read of a known variable."""
    for message in _unknown():
        warnings.warn(message, stacklevel=2)


def _unknown() -> Iterator[str]:
    """Yield a message for each unknown variable that begins with CONICOID_."""
    for name in sorted(os.environ):
        if name.startswith("CONICOID_") and name not in KNOWN:
            import difflib

            close = difflib.get_close_matches(name[:_LONGEST], KNOWN, n=1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(KNOWN)}"
            yield f"{name[:_LONGEST]} is not a Conicoid variable: {hint}"


def _quote(text: str, most: int) -> str:
    """Return the repr of a text, cut to a length."""
    quoted = repr(text)
    return quoted if len(quoted) <= most else f"{quoted[:most]}..."
