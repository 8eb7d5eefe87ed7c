"""Imports and exports of a WebAssembly module."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

_IMPORTS, _EXPORTS = 2, 7
_KINDS = "function", "table", "memory", "global"
_FUNCTION, _TABLE, _MEMORY, _GLOBAL = range(4)


@dataclass
class Module:
    """Names of imports, as (module, name), and of exports."""

    imports: set[tuple[str, str]] = field(default_factory=set)
    exports: set[str] = field(default_factory=set)


class _Reader:
    def __init__(self, code: bytes, at: int) -> None:
        self.code, self.at = code, at

    def number(self) -> int:
        """Return a number in LEB128."""
        value = shift = 0
        while True:
            byte = self.code[self.at]
            value |= (byte & 127) << shift
            shift, self.at = shift + 7, self.at + 1
            if byte < 128:
                return value

    def text(self) -> str:
        size = self.number()
        self.at += size
        return self.code[self.at - size : self.at].decode()

    def limits(self) -> None:
        """Skip the limits of a table or a memory."""
        for _ in range(1 + (self.number() & 1)):
            self.number()

    def skip(self, kind: int) -> None:
        """Skip the description of an import of a kind."""
        if kind == _FUNCTION:
            self.number()
        elif kind == _GLOBAL:
            self.at += 2
        else:
            self.at += kind == _TABLE
            self.limits()


def _sections(code: bytes) -> Iterator[tuple[int, _Reader]]:
    reader = _Reader(code, 8)
    while reader.at < len(code):
        kind = code[reader.at]
        reader.at += 1
        size = reader.number()
        yield kind, _Reader(code, reader.at)
        reader.at += size


def read(code: bytes) -> Module:
    """Return the imports and exports of a module. ValueError for bytes that are no module."""
    if code[:8] != b"\0asm\1\0\0\0":
        raise ValueError("is no WebAssembly")
    found = Module()
    for section, reader in _sections(code):
        for _ in range(reader.number() if section in (_IMPORTS, _EXPORTS) else 0):
            if section == _IMPORTS:
                found.imports.add((reader.text(), reader.text()))
                kind = reader.number()
                reader.skip(kind)
            else:
                found.exports.add(reader.text())
                reader.at += 1
                reader.number()
    return found
