"""The tables by which the door tests arguments, written as C."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from conicoid.kernels.tables import SPARE, Tables

from .signature import (
    MOST_ARRAYS,
    MOST_NAMES,
    MOST_SLOTS,
    TABLES,
    Leaf,
    Length,
    Signature,
    declared,
    is_geometry,
    names_in,
)
from .targets import Target

_FORMATS = {"f8": "d", "f4": "f", "i8": "lq", "i4": "il", "i1": "b", "b1": "?"}
_ANY = "{0, {ANY, NOTHING}, {0, 0}}"


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


class _Symbols:
    """The names in a signature, by number."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def number(self, name: str) -> str:
        if name in TABLES:
            return f"TABLE + {TABLES[name]}"
        return str(self.numbers.setdefault(name, len(self.numbers)))

    def sum(self, length: Length | None) -> str:
        if length is None:
            return _ANY
        parts = [(self.number(name), times) for name, times in length.names]
        parts += [("NOTHING", 0)] * (2 - len(parts))
        return f"{{{length.constant}, {{{parts[0][0]}, {parts[1][0]}}}, {{{parts[0][1]}, {parts[1][1]}}}}}"

    def length(self, length: Length | None) -> str:
        other = None if length is None else length.other
        return f"{{{self.sum(length)}, {self.sum(other)}}}"


def _format(dtype: np.dtype[Any]) -> str:
    """Return the letters of `struct` that fit; of a record `|` and its whole description."""
    if dtype.fields is None:
        return _FORMATS[dtype.str[1:]]
    return "|" + memoryview(np.zeros(1, dtype)).format


def _leaf(leaf: Leaf, symbols: _Symbols, referred: set[str]) -> str:
    kind = leaf.kind.upper()
    if leaf.kind == "(":
        kind = "OPEN_GEOMETRY" if is_geometry(leaf) else "OPEN"
    if leaf.kind == ")":
        kind = "CLOSE"
    lengths = leaf.lengths if leaf.kind in ("array", "int") else ()
    count = leaf.lengths[0].constant if leaf.kind == "(" and leaf.lengths[0] else len(lengths)
    symbol = symbols.number(leaf.name) if leaf.kind == "int" and leaf.name in referred else "NOTHING"
    size, form = (leaf.dtype.itemsize, _text(_format(leaf.dtype))) if leaf.kind == "array" else (0, "0")
    shown = ", ".join([*map(symbols.length, lengths), *([symbols.length(None)] * (3 - len(lengths)))])
    numbers = f"{count}, {int(leaf.written)}, {int(leaf.strided)}, {int(leaf.divides)}, {symbol}, {size}"
    return f"    {{{_text(leaf.name)}, {kind}, {numbers}, {form}, {{{shown}}}}},"


def _top(leaves: list[Leaf]) -> int:
    """Return how many arguments Python hands over."""
    depth = count = 0
    for leaf in leaves:
        count += depth == 0
        depth += (leaf.kind == "(") - (leaf.kind == ")")
    return count


def _lines(kernels: list[Signature], target: Target, sources: str) -> Iterator[str]:
    levels = target.levels
    yield f"static const char *const LEVELS[] = {{{', '.join(_text(level.name) for level in levels)}}};"
    yield f"static const int NEEDS[] = {{{', '.join(str(level.needs) for level in levels)}}};"
    yield f"#define SOURCES {_text(sources)}"
    yield f"enum {{ MOST_SYMBOLS = {MOST_NAMES}, MOST_SLOTS = {MOST_SLOTS}, MOST_ARRAYS = {MOST_ARRAYS} }};"
    yield f"#define GEOMETRY_TABLES {len(Tables._fields)}"
    yield f"#define GEOMETRY_SPARE {SPARE}"
    real = ["Floats" in str(kind) for kind in Tables.__annotations__.values()]
    yield f"static const uint8_t GEOMETRY_IS_REAL[] = {{{', '.join(str(int(each)) for each in real)}}};"
    for kernel in kernels:
        for level in levels:
            yield f"int {level.prefix}{kernel.name}(void *result, const int64_t *slots);"
        symbols, referred = _Symbols(), names_in(kernel.leaves)
        yield f"static const Leaf {kernel.name}_leaves[] = {{"
        for leaf in kernel.leaves:
            yield _leaf(leaf, symbols, referred)
        yield "};"
        entries = ", ".join(level.prefix + kernel.name for level in levels)
        yield f"static const Kernel {kernel.name}_levels[] = {{{entries}}};"
    yield "static const Entry ENTRIES[] = {"
    for kernel in kernels:
        parts = f"{kernel.name}_leaves, {_top(kernel.leaves)}, {len(kernel.leaves)}, {kernel.name}_levels"
        yield f"    {{{_text(kernel.name)}, {_text(kernel.result)}, {parts}}},"
    yield "};"


def tables(kernels: list[Signature], target: Target, sources: str) -> str:
    """Return the C header. `sources` is the stamp of the kernels' sources; "" if they cannot change."""
    return "\n".join(_lines(kernels, target, sources)) + "\n"


def main(target: str, levels: str, out: str, code: str = "") -> None:
    """Write the header, with the stamp of the LLVM code in the file `code`."""
    from .build import stamp_of
    from .targets import TARGETS

    sources = stamp_of(Path(code)) if code else ""
    Path(out).write_text(tables(declared(), TARGETS[target].only(levels), sources))


if __name__ == "__main__":
    main(*sys.argv[1:])
