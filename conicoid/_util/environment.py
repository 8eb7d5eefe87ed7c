"""The environment variables that Conicoid reads, and what is wrong with them."""

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


def read_threads() -> int | None:
    """The number in CONICOID_THREADS; None where it is not set. Raises ValueError for anything else."""
    warn_of_unknown()
    wanted = os.environ.get(THREADS, "")
    if not wanted:
        return None
    if not (wanted.isascii() and wanted.isdigit() and len(wanted) < 7 and 1 <= int(wanted) <= MOST_THREADS):
        raise ValueError(f"{THREADS} must be an integer from 1 to {MOST_THREADS}, got {_shown(wanted, _LONGEST)}")
    return int(wanted)


def read_jit_mode() -> str:
    """What CONICOID_JIT asks for: "plain", "own", or nothing, "". Raises ValueError for anything else."""
    warn_of_unknown()
    wanted = os.environ.get(JIT, "")
    if wanted not in ("", "plain", "own"):
        raise ValueError(f"{JIT} must be 'plain' or 'own', got {_shown(wanted, _LONGEST)}")
    return wanted


def read_vector_bits() -> int:
    """What CONICOID_VECTOR_BITS asks for: 256, 512, or nothing, 0. Raises ValueError for anything else."""
    wanted = os.environ.get(VECTOR_BITS, "")
    if wanted not in ("", "256", "512"):
        raise ValueError(f"{VECTOR_BITS} must be 256 or 512, got {_shown(wanted, _LONGEST)}")
    return int(wanted or 0)


def read_processor_level() -> str:
    """The level of processor in CONICOID_LEVEL, whose machine code is to be taken, as "x86-64-v3"; "" for the best."""
    return os.environ.get(LEVEL, "")


def check_environment() -> None:
    """Raise ValueError for what the command line is not to pass over: a wrong value, or an unknown name."""
    for message in _unknown():
        raise ValueError(message)
    read_threads()
    read_jit_mode()
    read_vector_bits()
    _check_cache(os.environ.get(CACHE, ""))


@functools.cache
def warn_of_unknown() -> None:
    """Warn of names that nobody reads, once in a process: when those that somebody reads are read."""
    for message in _unknown():
        warnings.warn(message, stacklevel=2)


def _unknown() -> Iterator[str]:
    """What there is to say of each variable that begins with CONICOID_ and is none of ours."""
    for name in sorted(os.environ):
        if name.startswith("CONICOID_") and name not in KNOWN:
            import difflib

            close = difflib.get_close_matches(name[:_LONGEST], KNOWN, n=1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(KNOWN)}"
            yield f"{name[:_LONGEST]} is not a Conicoid variable: {hint}"


def _check_cache(chosen: str) -> None:
    """A folder, or what can become one: nothing on the way to it is something else."""
    from pathlib import Path

    path = Path(chosen).absolute()
    for place in (path, *path.parents) if chosen else ():
        try:
            is_there = place.is_dir()
            if not is_there:
                place.lstat()
        except (FileNotFoundError, NotADirectoryError):
            continue
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ValueError(f"{CACHE} must name a folder, got {_shown(chosen)}: {reason.lower()}") from None
        if not is_there:
            raise ValueError(f"{CACHE} must name a folder, got {_shown(chosen)}: {_shown(str(place))} is none")
        return


def _shown(text: str, most: int = 2 * _LONGEST) -> str:
    shown = repr(text)
    return shown if len(shown) <= most else f"{shown[:most]}..."
