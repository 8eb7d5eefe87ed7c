"""What may have been meant by a name that there is not."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, TypeVar

from .validate import listed, shown

Name = TypeVar("Name", bound=str)

_COMPARED = 5000
"""Names that one is compared with, which takes a fraction of a second."""


def close_to(name: str, known: Collection[str], least: float = 0.6) -> str:
    """The known name that is most like this one; empty where none is, by `least` of all letters."""
    import difflib

    folded = {item.casefold(): item for item in known if len(item) <= 100}
    close = difflib.get_close_matches(name.casefold()[:100], folded, n=1, cutoff=least)
    return folded[close[0]] if close else ""


def one_of(owner: str, field: str, value: Any, known: Collection[Name]) -> Name:
    """The value, where it is one of the known names; a ValueError that lists them, and says which may be meant."""
    if isinstance(value, str):
        for name in known:
            if value == name:
                return name
    close = close_to(value, known) if isinstance(value, str) else ""
    meant = f" (did you mean {close!r}?)" if close else ""
    raise ValueError(f"{owner}: {field} must be one of {', '.join(known)}, got {shown(value)}{meant}")


def did_you_mean(name: str, known: Collection[str]) -> str:
    """A suggestion in brackets, or the list of what exists where that is short; empty otherwise."""
    if close := close_to(name, known):
        return f" (did you mean {close!r}?)"
    names = [item for item in known if len(item) <= 100]
    return f" (known: {', '.join(sorted(names))})" if 0 < len(names) <= 16 else ""


def known_names(name: object, what: str, known: Sequence[str]) -> str:
    """What to tell of a name that is not among some: those that hold it, or the first and the one most like it.

    `what` they are, such as "materials".
    """
    if not known:
        return f"{what}: none has a name"
    folded = name.casefold() if isinstance(name, str) else ""
    if folded and (holding := [repr(item) for item in known if folded in item.casefold()]):
        return f"{what} with it in their names: {listed(holding)}"
    close = close_to(name, known[:_COMPARED]) if isinstance(name, str) else ""
    meant = f" (did you mean {listed([repr(close)])}?)" if close else ""
    return f"{what}: {listed([repr(item) for item in known])}{meant}"
