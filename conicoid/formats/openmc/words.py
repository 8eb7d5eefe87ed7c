"""The words of texts that may be as long as a file, counted piece by piece."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

MOST_WORDS = 1_000_000
"""Words in one value, and different words where they are only counted."""
_PIECE = 1 << 16
_SPACE = re.compile(r"\s")


def count_words(text: str) -> int:
    return sum(map(len, pieces(text)))


def tally(text: str) -> Counter[str] | None:
    """How often each word stands in a text; None where more than `MOST_WORDS` of them differ."""
    counts: Counter[str] = Counter()
    for words in pieces(text):
        counts.update(words)
        if len(counts) > MOST_WORDS:
            return None
    return counts


def pieces(text: str) -> Iterator[list[str]]:
    """The words in order, some thousands at a time."""
    at = 0
    while at < len(text):
        space = _SPACE.search(text, at + _PIECE)
        end = space.start() if space else len(text)
        yield text[at:end].split()
        at = end
