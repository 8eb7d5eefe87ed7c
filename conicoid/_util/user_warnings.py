"""Warnings that point at the line of the caller, however deep in the package their cause is."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar

_PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")
_RAISE = ContextVar("refused", default=False)
"""Whether warnings are exceptions in this context."""


class SuppressedWarning(Exception):
    """Raised instead of a warning during a speculative attempt."""


@contextlib.contextmanager
def raise_warnings() -> Iterator[None]:
    """Let `warn` raise `SuppressedWarning` within the block.

    The block is an attempt; after such an error the work is done in another way, which gives the warning.
    """
    token = _RAISE.set(True)
    try:
        yield
    finally:
        _RAISE.reset(token)


def warn(message: str) -> None:
    """Give a UserWarning at the line of the caller.

    That is the first line of the stack outside of this package and of code that Python generates for it.
    """
    if _RAISE.get():
        raise SuppressedWarning(message)
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and _is_internal_frame(frame.f_code.co_filename):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, stacklevel=level)


def _is_internal_frame(file: str) -> bool:
    """Return whether a file belongs to the package, or is generated code such as that of dataclasses."""
    return file.startswith((_PACKAGE, "<")) or os.path.basename(file) == "dataclasses.py"
