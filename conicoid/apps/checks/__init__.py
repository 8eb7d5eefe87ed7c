"""Findings of `check`: overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits, undefined regions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

_HOMES = {
    "Finding": ".findings",
    "Findings": ".findings",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from .findings import Finding as Finding, Findings as Findings
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
