"""Numbers as text for people: counts with their nouns, and sizes of memory."""

from __future__ import annotations


def format_count(count: int, one: str, many: str = "") -> str:
    """Return a number with its noun: "1 cell", "2,000 bodies".

    `many` is the plural; left out, it is `one` with -s, or with -ies in place of -y.
    """
    many = many or (one[:-1] + "ies" if one.endswith("y") else one + "s")
    return f"{count:,} {one if count == 1 else many}"


def format_bytes(count: int) -> str:
    """Return a number of bytes with three digits and a unit: "12.3 MB"."""
    value, unit = float(count), "bytes"
    for unit in ("bytes", "kB", "MB", "GB"):
        if value < 1000 or unit == "GB":
            break
        value /= 1000
    return f"{value:.3g} {unit}"
