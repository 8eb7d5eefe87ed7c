"""Arguments of a call as numbers, lists and matrices, with mistakes told at the call."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from ...shapes.validate import shown
from ..errors import SceneFileError
from .syntax import Call, Text

Made = TypeVar("Made")


class Arguments:
    """The arguments of one call, asked for by name."""

    def __init__(self, text: Text, call: Call) -> None:
        self._text, self.call = text, call

    def refuse(self, message: str) -> Exception:
        """What is wrong with the call."""
        return self._text.mistake(self.call.position, self.call.name, message)

    def given(self, name: str) -> Any:
        """A value, None where it is not given."""
        return self.call.arguments.get(name)

    def number(self, name: str, otherwise: float) -> float:
        """A finite number."""
        value = self.given(name)
        if value is None:
            return otherwise
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            raise self.refuse(f"{name} must be a finite number, got {shown(value)}")
        return value

    def flag(self, name: str) -> bool:
        """True or false; false where it is not given."""
        value = self.given(name)
        if value is not None and not isinstance(value, bool):
            raise self.refuse(f"{name} must be true or false, got {shown(value)}")
        return bool(value)

    def rows(self, name: str, width: int) -> list[tuple[float, ...]]:
        """A list of points of so many finite numbers."""
        value = self.given(name)
        try:
            rows = [tuple(float(number) for number in row) for row in value]
        except (TypeError, ValueError):
            raise self.refuse(f"{name} must be a list of points, got {shown(value)}") from None
        for k, row in enumerate(rows):
            if len(row) != width or not all(map(math.isfinite, row)):
                raise self.refuse(f"{name}[{k}] must be {width} finite numbers, got {shown(row)}")
        return rows

    def paths(self, name: str, count: int) -> list[tuple[int, ...]]:
        """A list of lists of numbers of points."""
        value = self.given(name)
        found = []
        for k, row in enumerate(value if isinstance(value, list) else [value]):
            numbers = row if isinstance(row, list) else [row]
            whole = [int(n) for n in numbers if isinstance(n, float) and n == n // 1 and 0 <= n < count]
            if len(whole) != len(numbers) or len(whole) < 3:
                raise self.refuse(
                    f"{name}[{k}] must be three or more numbers of points below {count}, got {shown(row)}"
                )
            found.append(tuple(whole))
        return found

    def matrix(self) -> np.ndarray[Any, Any]:
        """(4, 4) of multmatrix, whose last row may be left out."""
        rows = self.given("m") or self.given("0")
        try:
            found = np.array(rows, np.float64)
        except (TypeError, ValueError):
            found = np.zeros(0)
        if found.shape == (3, 4):
            found = np.vstack([found, [0, 0, 0, 1]])
        if found.shape != (4, 4) or not np.isfinite(found).all() or found[3].tolist() != [0, 0, 0, 1]:
            raise self.refuse(f"m must be four rows of four finite numbers, the last 0 0 0 1, got {shown(rows)}")
        return found

    def sides(self, smooth: bool) -> int:
        """How many sides a circle has that is asked for as a polygon by $fn; 0 for a round one."""
        value = self.given("$fn")
        if smooth or not isinstance(value, float) or not value > 0:
            return 0
        if value > 10_000:
            raise self.refuse(f"$fn must be at most 10,000, got {value:g}")
        return max(3, int(value))

    def made(self, make: Callable[[], Made]) -> Made:
        """make(), with what shapes refuse told at the call."""
        try:
            return make()
        except SceneFileError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise self.refuse(str(error)) from None
