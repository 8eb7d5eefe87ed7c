"""Warnings that point at the line of the caller, however deep in the package they come from."""

from __future__ import annotations

import os
import sys
import warnings

_PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")


def warn(message: str) -> None:
    """A UserWarning at the first line of the stack that is neither of this package nor made by Python for it."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and _is_inner(frame.f_code.co_filename):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, stacklevel=level)


def _is_inner(file: str) -> bool:
    return file.startswith((_PACKAGE, "<")) or os.path.basename(file) == "dataclasses.py"
