"""What an export may be asked for, what it gives, and how it refuses what a format cannot say."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from ...shapes.validate import callback, flag
from ..errors import SHOWN, printable
from ..imports.imported import counted, first_few
from ..nodes import shortened

_WIDTH = 96


@dataclass(frozen=True)
class Options:
    """How a file is written.

    strict: is what the format says less of than the scene an error, in place of a remark?
    progress: progress(done, count) is called with numbers of bodies.
    """

    strict: bool = False
    progress: Callable[[int, int], Any] | None = None

    def __post_init__(self) -> None:
        flag("export", "strict", self.strict)
        callback("export", "progress", self.progress)


@dataclass(frozen=True)
class Exported:
    """The text of a file, and what there is to say of it: `notes` are all, `remarks` those that tell of a loss."""

    text: str
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class Unsayable(Exception):
    """Why a format cannot say something; the message names the shape, the field and what to do."""


@dataclass
class Report:
    """What is told of an export: bodies that cannot be said, and what is narrowed, by kind."""

    format: str
    refused: list[str] = field(default_factory=list)
    narrowed: dict[str, list[str]] = field(default_factory=dict)

    @contextmanager
    def about(self, name: str) -> Iterator[None]:
        """What cannot be said of a body is kept, so that all such bodies are told together."""
        try:
            yield
        except Unsayable as error:
            self.refused.append(f"{named(name)}: {error}")
        except OverflowError:
            self.refused.append(f"{named(name)}: its numbers leave the range of float64")

    def narrow(self, kind: str, name: str) -> None:
        """A body of which the file says less than the scene; `kind` says what."""
        names = self.narrowed.setdefault(kind, [])
        if not names or names[-1] != name:
            names.append(name)

    def check(self) -> None:
        """Raises ValueError with the bodies that cannot be said, the first of many."""
        if not self.refused:
            return
        count = len(self.refused)
        head = f"{counted(count, 'body')} cannot be said in {self.format}:"
        kept = [_cut(line, 2 * _WIDTH) for line in self.refused[: SHOWN // 2 - 1]]
        more = count - len(kept)
        tail = [f"... and {more:,} more like this"] if more else []
        raise ValueError("\n".join([head, *kept, *tail]))

    @property
    def remarks(self) -> tuple[str, ...]:
        """A line for each kind of narrowing, with the first bodies and how many there are."""
        return tuple(first_few(self._remarks()))

    def _remarks(self) -> Iterator[str]:
        for kind, names in self.narrowed.items():
            if names == [""]:
                yield kind
                continue
            shown = ", ".join(named(name) for name in names[:3])
            more = f" and {len(names) - 3:,} more" if len(names) > 3 else ""
            yield f"{kind}: {shown}{more}"


def named(name: str) -> str:
    """A body in messages."""
    return printable(shortened(name))


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width // 2 - 3]} ... {text[3 - width // 2 :]}"
