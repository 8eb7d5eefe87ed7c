"""What a reader of nodes carries along: the problems so far, and how to report the next one."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

from ..shapes.synonyms import meant_by
from .errors import MOST, Problem, Suggestions
from .nodes import Node, Scalar, Standing, Table, is_null, shortened, shown

Value = TypeVar("Value")
NOWHERE: Mapping[str, str] = {}


class Bad:
    """Stands for a value that could not be read; its problem is reported already."""


BAD: Final = Bad()


class TooManyProblems(Exception):
    """There is no point in reading on."""


class Reader:
    """Collects problems. Reading goes on after one, so that a user sees them all at once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.takes_any_file = False
        """May pictures lie outside of the folder?"""
        self.problems: list[Problem] = []
        self.did_you_mean = Suggestions()
        self.materials: dict[str, Any] = {}
        """The materials of the scene by name, BAD where one could not be read."""
        self.shape: Callable[[Node, str, type], Any] = _no_shape
        """Reads a shape of at least the given class; set by whoever knows the scene's named shapes."""

    def report(self, node: Standing, where: str, message: str) -> Bad:
        self.problems.append(Problem(node.line, node.column, where, message))
        if len(self.problems) >= MOST:
            raise TooManyProblems
        return BAD

    def expected(self, node: Node, where: str, what: str) -> Bad:
        """Report that `what` must stand here, with what stands here instead."""
        return self.report(node, where, f"must be {what}, got {shown(node)}")

    def unknown(self, node: Node, where: str, what: str, name: str, known: Collection[str]) -> Bad:
        """Report a name that stands for nothing, with a suggestion."""
        return self.report(node, where, f"unknown {what} {shortened(name)!r}{self.did_you_mean(name, known)}")

    def entries(
        self, node: Node, where: str, known: Iterable[str], required: Iterable[str] = (),
        elsewhere: Mapping[str, str] = NOWHERE,
    ) -> dict[str, Node] | Bad:  # fmt: skip
        """The known entries of a mapping (an empty one may be left out); others, and missing ones, are reported.

        elsewhere: where the place of some others is.
        """
        if is_null(node):
            node = Table(node.line, node.column)
        names = list(known)
        if not isinstance(node, Table):
            listed = ", ".join(names)
            return self.expected(node, where, f"a mapping with {listed}" if len(listed) < 200 else "a mapping")
        found = {name: value for name, value in node.entries.items() if name in names}
        good = len(found) == len(node.entries)
        for key in () if good else node.heads:
            if key.text not in found:
                left = [other for other in names if other not in node.entries]
                moved = elsewhere.get(key.text)
                meant = meant_by(key.text, left)
                hint = (
                    f" ({moved})"
                    if moved
                    else f" (did you mean {_quoted(meant)}?)"
                    if meant
                    else " (a comma ends a value: 1.5 is written with a point)"
                    if key.text.isdigit()
                    else self.did_you_mean(key.text, left)
                )
                self.report(key, where, f"unknown key {shortened(key.text)!r}{hint}")
        if missing := [name for name in required if name not in node.entries]:
            good = False
            self.report(node, where, f"{' and '.join(missing)} must be given")
        return found if good else BAD

    def only_entry(self, node: Node) -> tuple[str, Scalar, Node] | None:
        """(name, key, value) of a mapping with one entry, None for anything else."""
        if not isinstance(node, Table) or len(node.entries) != 1:
            return None
        ((name, value),) = node.entries.items()
        return name, node.heads[0], value

    def made(self, node: Node, where: str, make: Callable[[], Value]) -> Value | Bad:
        """make(), with a ValueError or TypeError reported at the field that its text names."""
        try:
            return make()
        except RecursionError:
            return self.report(node, where, "nested too deeply")
        except (ValueError, TypeError, ArithmeticError) as error:
            return self.report(*_located(node, where, str(error)))


def _quoted(meant: str) -> str:
    """A key as messages name it; several, with what there is to say of them, as they are."""
    return repr(meant) if meant.isidentifier() else meant


def _no_shape(node: Node, where: str, base: type) -> Any:
    raise LookupError(
        f"{where}: a reader without a scene has no shapes, asked for a {base.__name__} in line {node.line}"
    )


def _located(node: Node, where: str, message: str) -> tuple[Node, str, str]:
    """The node that an error such as "Ellipsoid: radii[1] must be > 0, got -2.0" speaks of."""
    message = re.sub(r"^\w+: ", "", message)
    found: Any = node
    match = re.match(r"(\w+)((?:\[\d+\])*)", message)
    if match and isinstance(found, Table) and match.group(1) in found.entries:
        found = found.entries[match.group(1)]
        for index in re.findall(r"\d+", match.group(2)):
            items = getattr(found, "items", [])
            found = items[int(index)] if int(index) < len(items) else found
    return found, where, message
