"""The environment variables that Conicoid reads, and messages on wrong ones."""

from __future__ import annotations

import functools
import os
import warnings
from collections.abc import Iterator

THREADS, CACHE, JIT = "CONICOID_THREADS", "CONICOID_CACHE_DIR", "CONICOID_JIT"
VECTOR_BITS = "CONICOID_VECTOR_BITS"
LEVEL = "CONICOID_LEVEL"
KNOWN = THREADS, CACHE, JIT, VECTOR_BITS, LEVEL
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
    """Return the mode in CONICOID_JIT, "plain", "own" or "" for the default; raise ValueError for anything else."""
    warn_of_unknown()
    text = os.environ.get(JIT, "")
    if text not in ("", "plain", "own"):
        raise ValueError(f"{JIT} must be 'plain' or 'own', got {_quote(text, _LONGEST)}")
    return text


def read_vector_bits() -> int:
    """Return the number in CONICOID_VECTOR_BITS, 256, 512 or 0 for the default; raise ValueError for anything else."""
    text = os.environ.get(VECTOR_BITS, "")
    if text not in ("", "256", "512"):
        raise ValueError(f"{VECTOR_BITS} must be 256 or 512, got {_quote(text, _LONGEST)}")
    return int(text or 0)


def read_processor_level() -> str:
    """Return the processor level in CONICOID_LEVEL that selects machine code, as "x86-64-v3"; "" for the best."""
    return os.environ.get(LEVEL, "")


def check_environment() -> None:
    """Raise ValueError for a wrong value or an unknown name; the command line ignores neither."""
    for message in _unknown():
        raise ValueError(message)
    read_threads()
    read_jit_mode()
    read_vector_bits()
    _check_cache(os.environ.get(CACHE, ""))


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


def _check_cache(chosen: str) -> None:
    """Raise ValueError unless the path is a folder, or can become one: every part of it is a folder or missing."""
    from pathlib import Path

    path = Path(chosen).absolute()
    # The first ancestor that exists decides: missing ones below it can be created
    for place in (path, *path.parents) if chosen else ():
        try:
            is_there = place.is_dir()
            if not is_there:
                place.lstat()
        except (FileNotFoundError, NotADirectoryError):
            continue
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ValueError(f"{CACHE} must name a folder, got {_quote(chosen)}: {reason.lower()}") from None
        if not is_there:
            raise ValueError(f"{CACHE} must name a folder, got {_quote(chosen)}: {_quote(str(place))} is none")
        return


def _quote(text: str, most: int = 2 * _LONGEST) -> str:
    """Return the repr of a text, cut to a length."""
    quoted = repr(text)
    return quoted if len(quoted) <= most else f"{quoted[:most]}..."
