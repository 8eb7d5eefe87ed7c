"""Errors of scene files: every problem with its line, reported at once, and suggestions for misspelt names."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

from .names import closest_name, suggest_name

__all__ = [
    "MAX_LISTED_PROBLEMS",
    "MAX_PROBLEMS",
    "Problem",
    "SceneFileError",
    "Suggestions",
    "closest_name",
    "printable",
    "suggest_name",
    "unreadable_error",
]

MAX_LISTED_PROBLEMS, MAX_MESSAGE_WIDTH = 18, 100
"""The largest number of lines of a message, and their width: one screen, with its first and last line."""
MAX_PROBLEMS = 1000


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake. `line` and `column` count from 1; 0 stands for the file as a whole."""

    line: int
    column: int
    where: str
    message: str


class SceneFileError(ValueError):
    """A scene file that cannot be used. `problems` has them in the order of the file, at most about `MAX_PROBLEMS`."""

    def __init__(self, path: str | PathLike[str], problems: Iterable[Problem]) -> None:
        self.path = fspath(path)
        self.problems = tuple(sorted(set(problems)))
        super().__init__(self.path, self.problems)

    def __str__(self) -> str:
        lines: list[str] = []
        rows = 0
        for problem in self.problems[:MAX_LISTED_PROBLEMS]:
            line = self._line(problem)
            rows += -(-len(line) // MAX_MESSAGE_WIDTH)  # a long line takes several of the screen
            if lines and rows > MAX_LISTED_PROBLEMS:
                break
            lines.append(line)
        rest = len(self.problems) - len(lines)
        if rest > 0:
            # A reader stops at that number, so there may be more
            least = "at least " if len(self.problems) >= MAX_PROBLEMS else ""
            lines.append(f"{self._file}: and {least}{rest} more problem{'s' if rest > 1 else ''}")
        return "\n".join(lines)

    @property
    def _file(self) -> str:
        """The path for messages."""
        return _cut_middle(printable(self.path), 400)

    def _line(self, problem: Problem) -> str:
        """Return the line of a message for a problem."""
        place = f":{problem.line}:{problem.column}" if problem.line else ""
        where = f"{_cut_middle(printable(problem.where), 160)}: " if problem.where else ""
        return f"{self._file}{place}: {where}{_cut_middle(printable(problem.message), 600)}"


class UnreadableFileError(SceneFileError, OSError):
    """A file that exists and cannot be read: no permission, a folder, a failing disk."""

    def __reduce__(self) -> tuple[Any, ...]:
        return unreadable_error, (self.path, OSError(self.errno, self.strerror))


class MissingFileError(UnreadableFileError, FileNotFoundError):
    """A file that does not exist, which `except FileNotFoundError` catches too."""


def unreadable_error(path: str | PathLike[str], error: OSError) -> SceneFileError:
    """Return the error for a scene file in place of an OSError, of the same kind and with its fields."""
    reason = (error.strerror or str(error)).lower()
    kind = MissingFileError if isinstance(error, FileNotFoundError) else UnreadableFileError
    unreadable = kind(path, [Problem(0, 0, "", f"cannot be read: {reason}")])
    unreadable.errno, unreadable.strerror, unreadable.filename = error.errno, error.strerror, fspath(path)
    return unreadable


def printable(text: str) -> str:
    """Return text on one line, without characters that a terminal would obey."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _cut_middle(text: str, width: int) -> str:
    """Return text without its middle if it is longer than `width`."""
    return text if len(text) <= width else f"{text[: width // 2 - 2]} ... {text[-width // 2 + 3 :]}"


MAX_COMPARISONS = 20_000
"""Names that all typos of a file together are compared with: about a second."""


class Suggestions:
    """Suggestions for misspelt names of one file; none after many, since only the first are read."""

    def __init__(self) -> None:
        self.budget = MAX_COMPARISONS

    def __call__(self, name: str, known: Collection[str]) -> str:
        """Return a suggestion in brackets, or the list of known names if that is short; else ""."""
        if len(known) > self.budget:
            return ""
        self.budget -= len(known)
        return suggest_name(name, known)
