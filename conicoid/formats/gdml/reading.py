"""What is known while a GDML file is read: names, mistakes and remarks with their lines, loops."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..errors import MOST, Problem, SceneFileError, Suggestions, printable
from ..nodes import shortened
from ..openmc.xml_tree import Element
from . import units
from .evaluator import ExpressionError, evaluate

MOST_TURNS = 200_000
"""Turns of all loops of a file together."""
MOST_FACES, MOST_OF_CONVEX, MOST_EFFORT = 400, 3_000, 4_000_000
"""Faces of a concave solid and of a convex one whose parts are found in time; the sum of their squares in a file, of
which those of convex ones count a tenth."""

_BRACKETS = re.compile(r"\[([^\[\]]*)\]")
_POINTER = re.compile(r"(?<=.)0x[0-9a-fA-F]{4,}$")


class Mistake(Exception):
    """What is wrong with an element."""

    def __init__(self, element: Element, message: str) -> None:
        super().__init__(message)
        self.element, self.message = element, message


class LeftOut(Exception):
    """Why an element cannot be what the file says, and the rest of the file may still be read."""


@dataclass
class Reading:
    """The state of reading one file. `names` are constants, quantities, variables and entries of matrices."""

    path: str
    names: dict[str, Fraction] = field(default_factory=lambda: dict(units.NAMES))
    variables: set[str] = field(default_factory=set)
    vectors: dict[str, dict[str, tuple[Fraction, Fraction, Fraction]]] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)  # of matrices
    problems: list[Problem] = field(default_factory=list)
    remarks: dict[str, list[str]] = field(default_factory=dict)
    turns: int = 0
    effort: int = 0
    counter: Iterator[int] = field(default_factory=lambda: itertools.count(1))  # of materials
    suggest: Suggestions = field(default_factory=Suggestions)

    def report(self, element: Element, where: str, message: str) -> None:
        """A mistake; after very many of them the file is given up."""
        self.problems.append(Problem(element.line, element.column, where, message))
        if len(self.problems) >= MOST:
            raise SceneFileError(self.path, self.problems)

    def remark(self, element: Element, where: str, message: str) -> None:
        """What is not as the file says, by kind of element, so that no kind hides the others."""
        file = os.path.basename(self.path)
        text = f"{file}:{element.line}: {printable(shortened(where))}: {printable(message)}"
        self.remarks.setdefault(element.tag, []).append(text)

    def spend(self, faces: int, is_convex: bool) -> None:
        """Raises LeftOut where to cut what has so many faces into convex parts would take too long."""
        most, kind = (MOST_OF_CONVEX, "") if is_convex else (MOST_FACES, "concave ")
        if faces > most:
            raise LeftOut(f"it has {faces:,} faces, more than the {most:,} of a {kind}solid that are read in time")
        self.effort += faces * faces // (10 if is_convex else 1)
        if self.effort > MOST_EFFORT:
            raise LeftOut("the file has too many solids of many faces before it")

    def solved(self, text: str, element: Element) -> str:
        """A name whose [i] and [i, j] are replaced by _1 and _1_2, as Geant4 does."""
        for _ in range(8):
            found = _BRACKETS.search(text)
            if found is None:
                return text
            numbers = [self.value(part, element, "index") for part in found[1].split(",")]
            if any(number.denominator != 1 for number in numbers):
                raise Mistake(element, f"index must be whole, got [{shortened(found[1])}]")
            text = text[: found.start()] + "".join(f"_{number}" for number in numbers) + text[found.end() :]
        raise Mistake(element, "has too many brackets in a name")

    def value(self, text: str, element: Element, name: str) -> Fraction:
        """The value of an expression. Raises Mistake."""
        try:
            return evaluate(self.solved(text, element) if "[" in text else text, self.names)
        except ExpressionError as error:
            raise Mistake(element, f"{name} {error}, got {shortened(text)!r}") from None
        except KeyError as error:
            unknown = str(error.args[0])
            told = self.suggest(unknown, self.names)
            raise Mistake(element, f"{name} has {shortened(unknown)!r}, which is not defined{told}") from None

    def each(self, children: list[Element], depth: int = 0) -> Iterator[Element]:
        """The elements, those in loops as often as these turn, their variable set meanwhile."""
        for child in children:
            if child.tag != "loop":
                yield child
                continue
            try:
                first, last, step, name = self._loop(child, depth)
            except Mistake as mistake:
                self.report(mistake.element, "loop", mistake.message)
                continue
            value = first
            while (value <= last) if step > 0 else (value >= last):
                self.turns += 1
                if self.turns > MOST_TURNS:
                    found = Problem(child.line, child.column, "loop", f"loops turn more than {MOST_TURNS:,} times")
                    raise SceneFileError(self.path, [found])
                self.names[name] = value
                yield from self.each(child.children, depth + 1)
                value += step

    def _loop(self, loop: Element, depth: int) -> tuple[Fraction, Fraction, Fraction, str]:
        name = loop.attributes.get("for", "")
        if name not in self.variables:
            raise Mistake(loop, f"for must be a variable that is defined before, got {shortened(name)!r}")
        given = loop.attributes
        first = self.value(given["from"], loop, "from") if "from" in given else self.names[name]
        last = self.value(given.get("to", ""), loop, "to")
        step = self.value(given.get("step", "1"), loop, "step")
        if not step:
            raise Mistake(loop, "step must not be 0")
        return first, last, step, name


def shown_name(name: str) -> str:
    """Without the address that Geant4 adds to a name."""
    return _POINTER.sub("", name)


def local(element: Element) -> str:
    """A tag without its namespace."""
    return element.tag.rpartition(":")[2]


def reference(reading: Reading, element: Element, attribute: str = "ref") -> str:
    """What an element refers to."""
    text = element.attributes.get(attribute)
    if not text:
        raise Mistake(element, f"{attribute} must be given")
    return reading.solved(text, element)


def known(reading: Reading, table: dict[str, Any], name: str, element: Element, what: str) -> Any:
    """What a table has by a name. Raises Mistake."""
    if name not in table:
        told = reading.suggest(name, table)
        raise Mistake(element, f"there is no {what} {shortened(name)!r} before this{told}")
    return table[name]
