"""The table for the documentation. `python -m tests.viewer.mirrors.markdown` writes it into the page."""

from __future__ import annotations

import re
from pathlib import Path

from conicoid.viewer.html import asset, shaders

from .table import MIRRORS, NO_MIRROR, python_name

PAGE = Path(__file__).resolve().parents[3] / "docs" / "viewer.md"
BEGIN, END = "<!-- mirrors: written by tests.viewer.mirrors.markdown -->\n", "<!-- end of mirrors -->\n"


def tables() -> str:
    """Return the mirrors of each function in each piece, and the functions without one."""
    pieces = {name: asset(f"shaders/{name}.glsl") for name in shaders()["pieces"]}
    place = {name: piece for piece, text in pieces.items() for name in re.findall(r"^\w+ (\w+)\(", text, re.MULTILINE)}
    rows = []
    for piece in pieces:
        for name in (name for name in MIRRORS if place[name] == piece):
            python = ", ".join(f"`{python_name(function)}`" for function in MIRRORS[name].python)
            rows.append(f"| `{piece}.glsl` | `{name}` | {python} |")
    reasons: dict[str, list[str]] = {}
    for name, reason in NO_MIRROR.items():
        reasons.setdefault(reason, []).append(f"`{name}`")
    others = [f"| {', '.join(names)} | {reason} |" for reason, names in reasons.items()]
    head = "| piece | function | mirrors |\n|---|---|---|\n"
    return f"{head}{_lines(rows)}\nThese mirror none:\n\n| function | why |\n|---|---|\n{_lines(others)}"


def _lines(rows: list[str]) -> str:
    return "".join(f"{row}\n" for row in rows)


def written(text: str) -> str:
    """Return the page with the current table."""
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{tables()}\n{END}{rest.split(END)[1]}"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
