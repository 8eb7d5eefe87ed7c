"""Decks that chance has spoilt: in their words, numbers, lines and characters."""

from __future__ import annotations

import random

from .models import MODELS
from .test_reading import PIN

WORDS = (
    "0", "-1", "1", "2", "7", "99", "1e300", "1e-300", "1e999", "nan", "x", "(", ")", ":", "#", "#1", "&", "$", "3r", "r", "2i", "5j",
    "1e9r", "999999999r", "lat=1", "lat=2", "u=1", "u=2", "fill=1", "fill=2", "fill=0:1 0:1 0:0", "trcl=1", "*trcl=(1 2 3 4 5 6)",
    "like 1 but", "imp:n=0", "mat=1", "rho=-1", "tz", "so", "gq", "rpp", "hex", "arb", "k/z", "1.1", "-10.3", "1" * 500, "\u2029",
    "message:", "read", "-999999:999999", "tr1", "*tr2", "m1", "c", "=", "\x00", "é",
)  # fmt: skip
DECKS = (PIN, *(model.text for model in MODELS.values()))


def mutated(seed: int) -> str:
    """A deck."""
    chance = random.Random(seed)
    lines = chance.choice(DECKS).split("\n")
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        at = chance.randrange(len(lines))
        words = lines[at].split(" ")
        place = chance.randrange(len(words))
        match chance.randrange(7):
            case 0 | 1:
                words[place] = chance.choice(WORDS)
            case 2:
                words.insert(place, chance.choice(WORDS))
            case 3:
                del words[place]
            case 4:
                other = chance.randrange(len(lines))
                lines[at], lines[other] = lines[other], lines[at]
                continue
            case 5:
                lines.insert(at, chance.choice(lines))
                continue
            case _:
                text = lines[at]
                cut = chance.randrange(len(text) + 1)
                lines[at] = text[:cut] + chance.choice("()#:-.*+&$ 0123456789ex\t") + text[cut + chance.randrange(2) :]
                continue
        lines[at] = " ".join(words)
    return "\n".join(lines)
