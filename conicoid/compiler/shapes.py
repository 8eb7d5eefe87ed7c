"""What kernels say of their arguments: the shapes of arrays, the limits of whole numbers, and what is written.

`@kernel(points="out n 3", begin="0..end", end="0..n")` says that `points` is an array of n rows of three numbers that
the kernel writes, and that begin and end are within it. Machine code relies on that: whoever hands over something else
gets an error in place of a crash (`native/door.c`). The types are those of the annotations.

- An array has a length for each dimension: a number, a sum like `n`, `n+1`, `8*n` or `2*n+8`, two of these as in `n|1`
  or `n|0`, or `*` for any. `out` before them, or alone before a record, says that it is written.
- A whole number has limits, `low..high`; either may be missing. `picture n` is what `packets.load` takes as width:
  0 or a divisor of n.
- A name is a length that all arguments share, or another whole number among them, or (a name of `engine.tables.Tables`)
  the length of that table of the geometry.

What is in an array is never looked at, only how long it is. So the rows of a table of any length, `*`, are where other
tables say; those are the package's own work, as the geometry's `places` are, and a mistake in them is no caller's. Each
such table has its reason in `tests/native/test_signature.py`.

A record says it of its fields once for all kernels, by `@shaped`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

Record = TypeVar("Record", bound=type[Any])


def shaped(**shapes: str) -> Callable[[Record], Record]:
    """What the fields of a record are, for all kernels that take one."""

    def put(record: Record) -> Record:
        record.__shapes__ = shapes
        return record

    return put
