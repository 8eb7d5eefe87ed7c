"""Words of a text in disorder, for fuzzers of formats that are XML."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence


def in_words(text: str, chance: random.Random, words_of_its_own: Sequence[str]) -> str:
    """Some words replaced by those of a format, doubled, exchanged or left out; now and then a piece of the file."""
    words = re.split(r"(\W+)", text)
    for _ in range(chance.choice([1, 1, 2, 5])):
        i, j = (chance.randrange(len(words)) for _ in range(2))
        match chance.randrange(5):
            case 0:
                words[i] = chance.choice(words_of_its_own)
            case 1:
                words[i] += words[j]
            case 2:
                words[i], words[j] = words[j], words[i]
            case 3:
                words[i] = ""
            case _:
                del words[i : i + chance.randrange(1, 30)]
                words.append("")
    return "".join(words)
