"""Which Conicoid this is, to the letter: processes work together only where all have the same."""

from __future__ import annotations

import functools


@functools.cache
def edition() -> str:
    """Version and sources of this process' Conicoid: tasks are done only by the same."""
    from .. import __version__
    from ..compiler.sources import digest_of_files

    return f"{__version__} (sources {digest_of_files()[:8] or 'unknown'})"
