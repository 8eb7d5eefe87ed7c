"""Warnings that point at the line of the caller, however deep in the package they come from."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar

_PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")
_RAISE = ContextVar("refused", default=False)


class SuppressedWarning(Exception):
    """There is something to warn of, where nothing is to be said yet."""


@contextlib.contextmanager
def raise_warnings() -> Iterator[None]:
    """Warnings are exceptions, `Warned`, meanwhile: what is tried here is done in another way, which tells of them."""
    token = _RAISE.set(True)
    try:
        yield
    finally:
        _RAISE.reset(token)


def warn(message: str) -> None:
    """A UserWarning at the first line of the stack that is neither of this package nor made by Python for it."""
    if _RAISE.get():
        raise SuppressedWarning(message)
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and _is_internal_frame(frame.f_code.co_filename):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, stacklevel=level)


def _is_internal_frame(file: str) -> bool:
    return file.startswith((_PACKAGE, "<")) or os.path.basename(file) == "dataclasses.py"
