"""Damage to bytes, to lines and words of texts, and to trees of values."""

import re
from collections.abc import Sequence
from random import Random
from typing import Any

TOKENS = ["{", "}", "[", "]", ":", ",", "- ", "\n", "  ", "\t", "&a ", "*a", "!x ", "!!python/object/apply:os.getcwd ", "'", '"', "#", "|", ">",
          "%", "~", "---\n", "...\n", "<<", "? ", "\0", "\x85", "\u2028", "\ud7ff", "🙂", "\r", "\ufeff", "null", "true", "Sphere", "Union",
          "move", "shape", "\\ud800", '"\\ud800"', '"\\x00"', "0x", "0o7", "1_0"]  # fmt: skip
NUMBERS = ["0", "-0", "1", "-1", "0.5", "1e-9", "1e999", "1e-999", "-1e999", "1e100", "1e101", "1e-100", "1e-101", "5e-324", "1.7976931348623157e308",
           ".nan", ".inf", "-.inf", "1" + "0" * 400, "0x" + "f" * 300, "9007199254740993", "1e16", "180", "360", "90", "-90", "1e50", "-1e50", "3",
           "0.1", "7", "1e-50", "true", "2147483648", "18446744073709551616", "1" * 5000, "1/3"]  # fmt: skip
WORDS = ["", "a", "no", "on", "red", "#ff0000", "#zzz", "steelblue", "scene.yaml", "balls.npy", "balls.csv", "none.npy", "../x.npy", "/dev/zero", "pipe.npy",
         "zero.npy", "folder", "a/b", "C:x", "x" * 5000, "é", "\x1b[31m", "shape 1", "material 1", "ball", "wheel"]  # fmt: skip
VALUES: list[Any] = [None, True, False, 0, 1, -1, 0.5, 2, 3, 1e-9, 1e100, 1e101, -1e100, 1e-100, 1e-101, 1e300, -1e300, 5e-324, float("inf"), float("-inf"),
                     -0.0, 10**17, 10**30, 10**400, 90, 180, 360, 45, 0.1, [], {}, [0, 0, 0], [1, 0, 0], [0, 0, 1e100], [1, -1, 0], [1, 2], *WORDS]  # fmt: skip


def bytes_damaged(random: Random, data: bytes) -> bytes:
    """Change, drop, double or move a few bytes, or cut the end off."""
    result = bytearray(data)
    for _ in range(random.choice([1, 1, 1, 2, 4, 16])):
        if not result:
            break
        at, length = random.randrange(len(result)), random.choice([1, 1, 2, 4, 8, 64])
        match random.randrange(7):
            case 0:
                result[at] ^= 1 << random.randrange(8)
            case 1:
                result[at] = random.choice([0, 1, 0x7F, 0x80, 0xFF, random.randrange(256)])
            case 2:
                del result[at : at + length]
            case 3:
                result[at:at] = random.randbytes(length)
            case 4:
                result[at : at + length] = random.choice([b"\0", b"\xff"]) * len(result[at : at + length])
            case 5:
                other = random.randrange(len(result))
                result[at : at + length] = result[other : other + length]
            case 6 if random.random() < 0.3:
                del result[at:]
    return bytes(result)


def text_damaged(random: Random, text: str, tokens: Sequence[str] = TOKENS) -> str:
    """Exchange, double, drop or insert words, numbers and lines."""
    for _ in range(random.choice([1, 1, 2, 3, 6])):
        lines = text.split("\n")
        at = random.randrange(len(lines))
        match random.randrange(8):
            case 0:
                other = random.randrange(len(lines))
                lines[at], lines[other] = lines[other], lines[at]
            case 1:
                del lines[at]
            case 2:
                lines.insert(at, random.choice(lines))
            case 3:
                lines[at] = random.choice(["  ", " ", "\t", "- "]) + lines[at]
            case 4:
                lines[at] = lines[at].lstrip()
        text = "\n".join(lines)
        if random.random() < 0.5:
            text = _word_changed(random, text, tokens)
        if random.random() < 0.2:
            place = random.randrange(len(text) + 1)
            text = text[:place] + random.choice(tokens) + text[place + random.choice([0, 0, 1, 5]) :]
    return text


def _word_changed(random: Random, text: str, tokens: Sequence[str]) -> str:
    """Put one number or word in place of another."""
    found = list(re.finditer(r"-?[\d.]+(?:e-?\d+)?|\w+", text))
    if not found:
        return text
    match = random.choice(found)
    numeric = match.group()[0] in "-.0123456789"
    if tokens is not TOKENS and random.random() < 0.5:
        new = random.choice(tokens)
    else:
        new = random.choice(NUMBERS) if numeric or random.random() < 0.2 else random.choice(found).group()
    return text[: match.start()] + new + text[match.end() :]


def tree_damaged(random: Random, tree: Any, pool: list[Any]) -> Any:
    """Return a copy of a tree with some of its values exchanged for others, or for parts of other trees."""
    share = random.choice([0.0, 0.003, 0.01, 0.03, 0.1])
    numbers = random.choice([0.0, 0.003, 0.01, 0.1])

    def walk(value: Any, depth: int) -> Any:
        if random.random() < share:
            return random.choice(VALUES) if random.random() < 0.6 else random.choice(pool)
        if isinstance(value, dict):
            items = [(key, walk(item, depth + 1)) for key, item in value.items() if random.random() > share / 3]
            if random.random() < share:
                items.append((random.choice(["name", "move", "radius", "shape", "x", "file"]), random.choice(VALUES)))
            return dict(items)
        if isinstance(value, list):
            copied = [walk(item, depth + 1) for item in value if random.random() > share / 3]
            if copied and random.random() < share:
                copied.extend([random.choice(copied)] * random.choice([1, 2, 30]))
            return copied
        if isinstance(value, (int, float)) and random.random() < numbers:
            factor = random.choice([0, -1, 2, 0.5, 1e-3, 1e3, 1 + 1e-15, 10 ** random.uniform(-100, 100)])
            return value * factor
        return value

    return walk(tree, 0)


def subtrees(tree: Any) -> list[Any]:
    """Return all values in a tree."""
    found, pending = [], [tree]
    while pending:
        value = pending.pop()
        found.append(value)
        pending.extend(value.values() if isinstance(value, dict) else value if isinstance(value, list) else ())
    return found
