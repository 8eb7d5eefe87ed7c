"""Decimal numbers that float64 does not hold."""

from __future__ import annotations

import math
import re


def is_beyond_float64(word: str, value: float) -> bool:
    """Whether a number that is written as neither infinite nor 0 became either in `value`, its nearest float64."""
    digits = re.split("[eE]", word, maxsplit=1)[0]
    return (value == 0 or math.isinf(value)) and re.search("[1-9]", digits) is not None
