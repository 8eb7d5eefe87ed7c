"""What is wrong with a scene file: every problem with its line, reported in one go."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

from .hints import closest_name, suggest_name

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
"""Lines of a message, of so many letters: with its first and last a screen."""
MAX_PROBLEMS = 1000


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake. `line` and `column` count from 1; 0 stands for the file as a whole."""

    line: int
    column: int
    where: str
    message: str


class SceneFileError(ValueError):
    """A scene file that cannot be used. `problems` holds them in the order of the file, at most about `MOST`."""

    def __init__(self, path: str | PathLike[str], problems: Iterable[Problem]) -> None:
        self.path = fspath(path)
        self.problems = tuple(sorted(set(problems)))
        super().__init__(self.path, self.problems)

    def __str__(self) -> str:
        lines: list[str] = []
        rows = 0
        for problem in self.problems[:MAX_LISTED_PROBLEMS]:
            line = self._line(problem)
            rows += -(-len(line) // MAX_MESSAGE_WIDTH)
            if lines and rows > MAX_LISTED_PROBLEMS:
                break
            lines.append(line)
        rest = len(self.problems) - len(lines)
        if rest > 0:
            least = "at least " if len(self.problems) >= MAX_PROBLEMS else ""
            lines.append(f"{self._file}: and {least}{rest} more problem{'s' if rest > 1 else ''}")
        return "\n".join(lines)

    @property
    def _file(self) -> str:
        return _cut_middle(printable(self.path), 400)

    def _line(self, problem: Problem) -> str:
        place = f":{problem.line}:{problem.column}" if problem.line else ""
        where = f"{_cut_middle(printable(problem.where), 160)}: " if problem.where else ""
        return f"{self._file}{place}: {where}{_cut_middle(printable(problem.message), 600)}"


class UnreadableFileError(SceneFileError, OSError):
    """A file is there that cannot be read: no permission, a folder, a failing disk."""

    def __reduce__(self) -> tuple[Any, ...]:
        return unreadable_error, (self.path, OSError(self.errno, self.strerror))


class MissingFileError(UnreadableFileError, FileNotFoundError):
    """There is no file of that name: what `except FileNotFoundError` waits for."""


def unreadable_error(path: str | PathLike[str], error: OSError) -> SceneFileError:
    """What to raise in place of an error of the system, as a scene file's and still one of its kind."""
    reason = (error.strerror or str(error)).lower()
    kind = MissingFileError if isinstance(error, FileNotFoundError) else UnreadableFileError
    told = kind(path, [Problem(0, 0, "", f"cannot be read: {reason}")])
    told.errno, told.strerror, told.filename = error.errno, error.strerror, fspath(path)
    return told


def printable(text: str) -> str:
    """The text on one line, without what a terminal would obey."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _cut_middle(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width // 2 - 2]} ... {text[-width // 2 + 3 :]}"


MAX_COMPARISONS = 20_000
"""Names that a typo is compared with, all typos of a file together: about a second."""


class Suggestions:
    """What the user of a file may have meant; after many typos no more is suggested, since only the first are read."""

    def __init__(self) -> None:
        self.left = MAX_COMPARISONS

    def __call__(self, name: str, known: Collection[str]) -> str:
        """A suggestion in brackets, or the list of what exists where that is short; empty otherwise."""
        if len(known) > self.left:
            return ""
        self.left -= len(known)
        return suggest_name(name, known)
