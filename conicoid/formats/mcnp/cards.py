"""The lines of a deck as cards in three blocks: comments dropped, continued lines joined, line numbers kept."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..errors import Problem, SceneFileError, cannot_be_read
from ..openmc.xml_tree import Element
from ..regular import open_regular

MAX_BYTES = 64 << 20
MAX_CARDS = 1_000_000
WIDEST = 128
"""Columns of a line that MCNP reads."""
_COMMENT = re.compile(r" {0,4}c(?: |$)")


@dataclass(frozen=True, slots=True)
class Card:
    """A card in small letters, on one line, and where it begins."""

    line: int
    text: str

    @property
    def element(self) -> Element:
        """Where it stands, as the records of geometries keep it."""
        return Element("card", self.line, 1, {})


@dataclass
class Deck:
    """The title, the cards of the three blocks, and remarks."""

    title: str
    cells: list[Card] = field(default_factory=list)
    surfaces: list[Card] = field(default_factory=list)
    data: list[Card] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def read_cards(path: str | os.PathLike[str]) -> Deck:
    """The cards of a file. Raises SceneFileError for what is no deck of bearable size."""
    try:
        with open_regular(path) as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise cannot_be_read(path, error) from None
    if len(raw) > MAX_BYTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"is too large: at most {MAX_BYTES >> 20} MB are read")])
    lines = raw.decode("utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    deck, problems = deck_of(lines)
    if problems:
        raise SceneFileError(path, problems)
    return deck


def deck_of(lines: list[str]) -> tuple[Deck, list[Problem]]:
    """The cards in some lines, and what is wrong."""
    first = _title_line(lines)
    deck = Deck(lines[first].strip() if first < len(lines) else "")
    blocks = iter((deck.cells, deck.surfaces, deck.data))
    problems: list[Problem] = []
    if deck.title.lower().startswith("continue"):
        problems.append(Problem(first + 1, 1, "", "continues another run, and holds no geometry"))
        return deck, problems
    for number, text in _joined(lines, first + 1, blocks, problems):
        del number, text
    if sum(map(len, (deck.cells, deck.surfaces, deck.data))) > MAX_CARDS:
        problems.append(Problem(0, 0, "", f"has more than {MAX_CARDS:,} cards"))
    for card in (*deck.cells, *deck.surfaces, *deck.data):
        if re.match(r"read\b", card.text):
            problems.append(Problem(card.line, 1, "read", "refers to another file, which is not opened"))
        if card.text.startswith("#"):
            problems.append(Problem(card.line, 1, "#", "begins a table in columns (vertical input): write it in rows"))
    long = [n for n in range(first + 1, len(lines)) if len(_plain(lines[n])) > WIDEST and not _is_comment(lines[n])]
    if long:
        deck.remarks.append(f"line {long[0] + 1}: is read to its end, MCNP reads {WIDEST} columns of a line")
    return deck, problems


def _title_line(lines: list[str]) -> int:
    """Where the title is: first, or after a message block and its blank line."""
    if not lines or not lines[0].lower().lstrip().startswith("message:"):
        return 0
    return next((n + 1 for n, line in enumerate(lines) if not line.strip()), len(lines))


def _joined(
    lines: list[str], start: int, blocks: Iterator[list[Card]], problems: list[Problem]
) -> Iterator[tuple[int, str]]:
    """Fill the blocks; a blank line ends each."""
    block, pieces, begin, goes_on = next(blocks), [""], 0, False

    def close() -> None:
        text = " ".join(pieces).replace("=", " ").strip()
        if text:
            block.append(Card(begin, text))
        pieces.clear()

    for number in range(start, len(lines)):
        line = lines[number].expandtabs(8).lower()
        if not line.strip():
            close()
            goes_on = False
            following = next(blocks, None)
            if following is None:
                return
            block = following
            continue
        if _is_comment(line):
            continue
        text = _plain(line)
        if not text.strip():
            continue  # only a comment after $
        if not goes_on and not line.startswith("     "):
            close()
            begin = number + 1
        elif not goes_on and not "".join(pieces).strip():
            problems.append(Problem(number + 1, 1, "", "continues a card, and there is none before it"))
        goes_on = text.rstrip().endswith("&")
        pieces.append(text.rstrip().removesuffix("&") if goes_on else text)
        yield number, text
    close()


def _is_comment(line: str) -> bool:
    return _COMMENT.match(line.expandtabs(8).lower().rstrip() + " ") is not None


def _plain(line: str) -> str:
    """Without what stands after $."""
    return line.split("$", 1)[0].rstrip()
