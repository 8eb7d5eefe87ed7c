"""What answers to a single ray tell of themselves, in full digits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ...shapes.labels import counted
from ...shapes.validate import shown

if TYPE_CHECKING:
    from .hits import Hits
    from .spans import Crossings, Spans

_MOST = 4


def one_hit(hits: Hits) -> str:
    """The fields of one hit."""
    if not hits.hit:
        return "a miss, t=inf"
    told = {name: _plain(getattr(hits, name)) for name in ("t", "point", "normal", "face", "entering")}
    return f"body {_body(hits.body, hits.name)}, " + ", ".join(f"{name}={value}" for name, value in told.items())


def spans_of_one(spans: Spans) -> str:
    """The first spans of one ray."""
    rows = zip(spans.body, spans.name, spans.t_enter, spans.t_exit, strict=True)
    return _some(len(spans.body), "span", (f"body {_body(b, n)} [{_plain(a)}, {_plain(e)}]" for b, n, a, e in rows))


def crossings_of_one(crossings: Crossings) -> str:
    """The first crossings of one ray."""
    rows = zip(crossings.body, crossings.name, crossings.t, strict=True)
    return _some(len(crossings.body), "crossing", (f"body {_body(b, n)} t={_plain(t)}" for b, n, t in rows))


def _some(count: int, noun: str, rows: Iterable[str]) -> str:
    first = [row for row, _ in zip(rows, range(_MOST), strict=False)]
    more = ", ..." if count > _MOST else ""
    return counted(count, noun, f"{noun}s") + (f": {', '.join(first)}{more}" if first else "")


def _body(number: Any, name: Any) -> str:
    return f"{int(number)}" + (f" {shown(name)}" if name else "")


def _plain(value: Any) -> str:
    """Numbers without NumPy's types around them."""
    plain = value.tolist() if hasattr(value, "tolist") else value
    return repr(tuple(plain) if isinstance(plain, list) else plain)
