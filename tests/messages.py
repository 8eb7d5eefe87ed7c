"""Messages of errors: at most a screen, so that their beginning stays readable."""

import os
from collections.abc import Callable
from typing import Any

ROWS, COLUMNS = 22, 100
PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "conicoid", "")


def rows_of(text: str) -> int:
    """Return the number of lines of a terminal that a text takes."""
    return sum(max(1, -(-len(line) // COLUMNS)) for line in text.splitlines())


def is_ours(trace: Any) -> bool:
    """Return whether the package itself raised an exception."""
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and trace.tb_frame.f_code.co_filename.startswith(PACKAGE)


def check(text: str) -> None:
    """Fail for a message that is longer than a screen."""
    assert rows_of(text) <= ROWS, f"a message of {rows_of(text)} lines: {text[:400]} ..."


def outcome(call: Callable[[], Any]) -> Any:
    """Return the result of a call, or the type and text of its error."""
    try:
        return call()
    except Exception as error:
        return type(error), str(error)
