"""Arguments that were not given: what is usual stands for them, unless what is asked has something of its own."""

from __future__ import annotations

import math
from typing import Any, Final


class Usual(float):
    """A number that nobody gave."""

    __slots__ = ()


START: Final = Usual(0.0)
"""Where rays begin that say nothing else, in units of their directions' lengths."""
END: Final = Usual(math.inf)
"""Where they end."""


def given_or(own: Any, value: Any) -> Any:
    """A value that was given, or else its own of what is asked."""
    return own if isinstance(value, Usual) else value
