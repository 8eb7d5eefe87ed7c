"""Numbers as text for people: counts with their nouns, sizes of memory, and tables of results for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from itertools import islice
from typing import Any


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


MOST_ROWS = 20
"""Rows that a table shows of a longer list."""


def html_table(columns: Sequence[str], rows: Iterable[Sequence[Any]], count: int) -> str:
    """Return the first rows of `count` ones as an HTML table; floats have six digits, vectors stand in brackets."""
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(_cell(value))}</td>' for value in row)}</tr>" for row in islice(rows, MOST_ROWS)
    )
    more = f"<p>and {count - MOST_ROWS:,} more</p>" if count > MOST_ROWS else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _cell(value: Any) -> str:
    """Return a value as the text of a cell; None is empty."""
    plain = value.tolist() if hasattr(value, "tolist") else value
    if plain is None:
        return ""
    if isinstance(plain, float):
        return f"{plain:.6g}"
    if isinstance(plain, list | tuple):
        return f"({', '.join(map(_cell, plain))})"
    return str(plain)
