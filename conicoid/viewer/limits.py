"""How much of a scene the page takes: what every browser with WebGL 2 can be expected to hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

MOST_BYTES = 256 << 20
"""Of all tables together, as they stand in the page."""
MOST_GATES = 1024
"""In the Boolean program of one body: the shader keeps a counter for each while it follows a ray."""


def check(tables: Mapping[str, Any]) -> None:
    """Raise ValueError for tables that the page cannot take, naming the limit. The page checks its own GPU's."""
    size = sum(array.size * max(4, array.itemsize) for array in tables.values())  # signs stand there as integers
    if size > MOST_BYTES:
        raise ValueError(
            f"view: this scene's tables take {size / 2**20:,.0f} MiB, "
            f"a page holds at most {MOST_BYTES / 2**20:,.0f} MiB"
        )
    gates = int(np.diff(tables["program_gate"]).max(initial=0))
    if gates > MOST_GATES:
        raise ValueError(
            f"view: a body is a Boolean combination of {gates:,} nested steps, the shader counts at most {MOST_GATES:,}"
        )
