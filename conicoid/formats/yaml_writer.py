"""Numbers, texts, lists and mappings -> YAML that people like to read and that loses no bit.

What fits on a line stands on one line, the rest one item a line. Floats are the shortest decimals
that read back exactly; every word is written so that YAML 1.1 and 1.2 readers agree on it.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

WIDTH = 110
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:[ .-][A-Za-z0-9_]+)*")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
_MEANINGFUL = {"null", "true", "false", "yes", "no", "on", "off", "y", "n", "inf", "nan"}


class Real(float):
    """A number that is written with a point, so that it is not read as an integer."""


def dump(data: dict[str, Any]) -> str:
    """A document with one section per key, an empty line before each list or mapping."""
    text = ""
    for key, value in data.items():
        simple = not isinstance(value, (list, dict))
        text += ("\n" if text and not simple else "") + "\n".join(_entry(word(key), value, "", top=True)) + "\n"
    return text


def json_text(data: dict[str, Any]) -> str:
    """The document as JSON, for which infinities do not exist: each body, and each of what has a name, on its line."""
    try:
        sections = ",\n".join(f" {_json(key)}: {_json_section(value)}" for key, value in data.items())
    except ValueError:
        raise ValueError("JSON has no infinite numbers: save this scene as .yaml") from None
    return f"{{\n{sections}\n}}\n".replace("\x7f", "\\u007f")


def _json_section(value: Any) -> str:
    if not isinstance(value, (list, dict)) or not value or not _is_section(value):
        return _json(value)
    if isinstance(value, dict):
        return "{\n" + ",\n".join(f"  {_json(key)}: {_json(item)}" for key, item in value.items()) + "\n }"
    return "[\n" + ",\n".join(f"  {_json(item)}" for item in value) + "\n ]"


def _json(value: Any) -> str:
    return json.dumps(value, allow_nan=False)


def _entry(key: str, value: Any, indent: str, top: bool = False) -> Iterator[str]:
    """`key: value`, on a line of its own if it fits and is not a section of the document."""
    inline = inlined(value, WIDTH - len(indent) - len(key) - 2)
    if inline is not None and not (top and isinstance(value, (list, dict)) and value and _is_section(value)):
        yield f"{indent}{key}: {inline}"
    else:
        yield f"{indent}{key}:"
        yield from _block(value, indent + "  ")


def _is_section(value: Any) -> bool:
    items = value.values() if isinstance(value, dict) else value
    return any(isinstance(item, (list, dict)) for item in items)


def _block(value: Any, indent: str) -> Iterator[str]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _entry(_key(key), item, indent)
        return
    for item in value:
        named = isinstance(item, dict) and "name" in item
        inline = None if named else inlined(item, WIDTH - len(indent) - 2)
        if inline is not None:
            yield f"{indent}- {inline}"
            continue
        first, *rest = _block(item, indent + "  ")
        yield f"{indent}- {first.lstrip()}"
        yield from rest


def inlined(value: Any, room: int) -> str | None:
    """The value on one line, or None for a list or mapping that takes more than `room` characters."""
    if isinstance(value, dict):
        keys = [f"{_key(key)}: " for key in value]
        return _joined("{", "}", keys, list(value.values()), room)
    if isinstance(value, (list, tuple)):
        return _joined("[", "]", [""] * len(value), value, room)
    return scalar(value)


def _joined(opening: str, closing: str, keys: Sequence[str], items: Sequence[Any], room: int) -> str | None:
    room -= 2
    if 3 * len(items) > room + 4:  # each takes a character and what parts it from the next
        return None
    texts: list[str] = []
    for key, item in zip(keys, items, strict=True):
        text = inlined(item, room - len(key))
        room -= len(key) + len(text or "") + 2
        if text is None or room < -2:
            return None
        texts.append(key + text)
    return opening + ", ".join(texts) + closing


def scalar(value: Any) -> str:
    """One word: null, a truth value, a number or a text."""
    if type(value) is float:
        return number(value)
    if value is None:
        return "null"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, Real):
        text = number(value)
        return text + ".0" if text.lstrip("-").isdigit() else text
    if isinstance(value, (float, np.floating)):
        return number(float(value))
    return word(str(value))


def number(value: float) -> str:
    """The shortest decimal that reads back as `value`, with a point before an exponent, as YAML 1.1 wants."""
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    if value.is_integer() and abs(value) < 1e15 and math.copysign(1.0, value) * value >= 0 and repr(value) != "-0.0":
        return str(int(value))
    text = repr(value)
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if mark and "." not in mantissa else text


def word(text: str) -> str:
    """A text, in quotes where it could be taken for something else; ValueError for half a surrogate pair."""
    if _WORD.fullmatch(text) and text.lower() not in _MEANINGFUL:
        return text
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise ValueError(f"a scene file cannot hold the text {text!r}: it is not Unicode")
    return '"' + "".join(_ESCAPES.get(c) or (c if c.isprintable() else _escaped(c)) for c in text) + '"'


_key = lru_cache(maxsize=256)(word)
"""Of the names of classes and fields, which stand in a file over and over."""


def _escaped(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
