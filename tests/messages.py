"""How long a message may be: a screen, so that what comes first can be read."""

from __future__ import annotations

import os
from typing import Any

ROWS, COLUMNS = 22, 100
PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "conicoid", "")


def rows_of(text: str) -> int:
    """Lines of a terminal that a text takes."""
    return sum(max(1, -(-len(line) // COLUMNS)) for line in text.splitlines())


def is_ours(trace: Any) -> bool:
    """Whether an exception was raised in the package itself."""
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and trace.tb_frame.f_code.co_filename.startswith(PACKAGE)


def check(text: str) -> None:
    """Fail for a message that is longer than a screen."""
    assert rows_of(text) <= ROWS, f"a message of {rows_of(text)} lines: {text[:400]} ..."
