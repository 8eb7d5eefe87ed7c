"""What is joined by `concatenate`: a list of answers of one kind."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

from ...shapes.validate import what

Kind = TypeVar("Kind")


def parts_of(kind: type[Kind], parts: Any) -> list[Kind]:
    """The parts as a list; TypeError for what is none, or holds something else than answers of a kind."""
    name = kind.__name__
    if isinstance(parts, kind) or not isinstance(parts, Iterable):
        raise TypeError(f"{name}: parts must be a list of {name}, got {what(parts)}")
    given = list(parts)
    for i, part in enumerate(given):
        if not isinstance(part, kind):
            raise TypeError(f"{name}: parts[{i}] must be {name}, got {what(part)}")
    return given
