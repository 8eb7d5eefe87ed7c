"""Whether a file is an MCNP deck: by its suffix, or by a cell card after its title."""

from __future__ import annotations

import re

SUFFIXES = (".mcnp", ".mcn", ".imcnp", ".inp", ".i")
_CELL = re.compile(
    r" {0,4}[0-9]+ +(?:0 +|[1-9][0-9]* +[-+]?[0-9]*\.?[0-9]+(?:[ed]?[-+]?[0-9]+)? +|like +)[-+#(0-9]", re.I
)
_OTHERS = (".yaml", ".yml", ".json", ".csv", ".xyz", ".pdb", ".cif")


def is_mcnp(head: str, suffix: str) -> bool:
    """By the first text of a file and its suffix."""
    if suffix in SUFFIXES:
        return not head.lstrip("\ufeff \t\r\n").startswith("<")
    if suffix in _OTHERS or "\0" in head:
        return False
    lines = head.replace("\r\n", "\n").expandtabs(8).split("\n")
    if lines[0].lower().startswith("message:"):
        lines = lines[next((n + 1 for n, line in enumerate(lines) if not line.strip()), len(lines)) :]
    for line in lines[1:]:
        if re.match(r" {0,4}c( |$)", line, re.I) is None:
            return _CELL.match(line) is not None
    return False
