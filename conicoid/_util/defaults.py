"""Sentinels for the limits of rays: an argument that was not passed leaves the limits of a `Rays` in force."""

from __future__ import annotations

import math
from typing import Any, Final


class DefaultFloat(float):
    """Sentinel for a number that was not passed."""

    __slots__ = ()


DEFAULT_T_MIN: Final = DefaultFloat(0.0)
"""Where rays begin without other limits, in units of the lengths of their directions."""
DEFAULT_T_MAX: Final = DefaultFloat(math.inf)
"""Where rays end without other limits."""


def replace_default(own: Any, value: Any) -> Any:
    """Return the value that was passed, or `own`, that of the object, for a sentinel."""
    return own if isinstance(value, DefaultFloat) else value
