"""The tape that a formula is recorded on while it is worked out by the numbers of `traced`."""

from __future__ import annotations

import struct
from typing import Any

from .number import Number, Symbol, exact
from .traced import Plain, Wide

_BITS = struct.Struct("d").pack
Operation = tuple[str, int, int, int, int]
"""Which, the register written, operands."""


class Tape:
    """Operations in the order in which they were asked for, and what they need."""

    def __init__(self) -> None:
        self.code: list[Operation] = []
        self.wide_makers: list[int] = []  # of each register of a kind, the place of the operation that writes it
        self.plain_makers: list[int] = []
        self.numbers: dict[bytes, tuple[int, float]] = {}  # floats that are constants, by their bits
        self.constants: dict[tuple[int, int, int], tuple[int, Number]] = {}
        self.written: list[int] = []
        self.wide_outputs = self.inputs = 0
        self._made: dict[tuple[str, int, int, int], Any] = {}  # what an operation gave: it is not done twice
        self._tested: set[tuple[str, int, int]] = set()

    @property
    def wides(self) -> int:
        """How many registers there are for numbers of many digits."""
        return len(self.wide_makers)

    @property
    def plains(self) -> int:
        """How many registers there are for floats."""
        return len(self.plain_makers)

    @property
    def zero(self) -> Plain:
        return self.plain_of(0.0)

    def plain(self, which: str, value: float, a: int = 0, b: int = 0, c: int = 0) -> Plain:
        """What an operation gives, a float."""
        made: Plain | None = self._made.get((which, a, b, c))
        if made is None:
            register = len(self.plain_makers)
            made = self._made[which, a, b, c] = Plain(self, register, value)
            self.plain_makers.append(len(self.code))
            self.code.append((which, register, a, b, c))
        return made

    def wide(self, which: str, value: Number, a: int = 0, b: int = 0) -> Wide:
        """What an operation gives, a number."""
        made: Wide | None = self._made.get((which, a, b, 0))
        if made is None:
            register = len(self.wide_makers)
            made = self._made[which, a, b, 0] = Wide(self, register, value)
            self.wide_makers.append(len(self.code))
            self.code.append((which, register, a, b, 0))
        return made

    def made(self, which: str, a: int, b: int = 0) -> Any:
        """What an operation has given, if it was done."""
        return self._made.get((which, a, b, 0))

    def input(self, value: float) -> Plain:
        """The next of a body's numbers, which the tape begins with."""
        self.inputs += 1
        return self.plain("input", value, self.inputs - 1)

    def sine_cosine(self, angle: int, sine: Number, cosine: Number) -> tuple[Wide, Wide]:
        """What the operation gives that fills two registers."""
        made = self.wide("sine and cosine", sine, angle)
        other = self._made.get(("cosine", angle, 0, 0))
        if other is None:
            other = self._made["cosine", angle, 0, 0] = Wide(self, len(self.wide_makers), cosine)
            self.wide_makers.append(len(self.code) - 1)
        return made, other

    def given(self, value: Number, column: int) -> Wide:
        """A number of many digits that a body comes with."""
        return self.wide("given", value, column)

    def test(self, which: str, register: int, sign: int, expected: int) -> bool:
        """Record that the sign is among those expected, or that it is not; which of the two holds now."""
        holds = bool(sign & expected)
        found = expected if holds else 15 - expected
        if (which, register, found) not in self._tested:
            self._tested.add((which, register, found))
            self.code.append((which, 0, register, found, 0))
        return holds

    def write(self, value: Any) -> None:
        """The next output: a float, or one that was recorded."""
        self.written.append(self.plain_of(value).register)

    def write_wide(self, value: Any) -> None:
        """The next output among the numbers of many digits."""
        self.code.append(("write wide", self.wide_outputs, self.wide_of(exact(value)).register, 0, 0))
        self.wide_outputs += 1

    def plain_of(self, value: Any) -> Plain:
        """A float, as one of the tape's own."""
        if isinstance(value, Plain):
            return value
        if isinstance(value, Symbol):
            raise TypeError("a number of many digits where a float is needed")
        value = float(value)
        row, _ = self.numbers.setdefault(_BITS(value), (len(self.numbers), value))
        return self.plain("number", value, row)

    def wide_of(self, value: Number) -> Wide:
        """A number of many digits, as one of the tape's own."""
        if isinstance(value, Wide):
            return value
        key = value.mantissa, value.exponent, value.off
        row, _ = self.constants.setdefault(key, (len(self.constants), value))
        return self.wide("constant", value, row)
