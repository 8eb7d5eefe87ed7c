"""Arguments that were not given: what is usual stands for them, unless what is asked has something of its own."""

from __future__ import annotations

import math
from typing import Any, Final


class DefaultFloat(float):
    """A number that nobody gave."""

    __slots__ = ()


DEFAULT_T_MIN: Final = DefaultFloat(0.0)
"""Where rays begin that say nothing else, in units of their directions' lengths."""
DEFAULT_T_MAX: Final = DefaultFloat(math.inf)
"""Where they end."""


def replace_default(own: Any, value: Any) -> Any:
    """A value that was given, or else its own of what is asked."""
    return own if isinstance(value, DefaultFloat) else value
