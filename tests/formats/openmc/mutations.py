"""OpenMC files that chance has spoilt: in their bytes, words, numbers, attributes and structure."""

from __future__ import annotations

import random
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable

from ..fuzzing import words
from .models import EXAMPLE_FILES, TEXTS

WORDS = (
    "-1", "0", "1", "2", "5", "7", "11", "99", "1e300", "-1e-300", "1e999", "nan", "0.5", "x", "void", "|", "~", "(", ")", "&amp;",
    "-3 4", "", "z-plane", "sphere", "quadric", "z-torus", "y", "fill", "region", "universe", "9" * 30, "\u2029", "<cell/>",
)  # fmt: skip
NUMBERS = (
    "0", "-1", "1", "1e-8", "1e8", "1e-100", "1e100", "1e-101", "1e101", "1e154", "1e160", "1e308", "-1e308", "1.8e308", "5e-324",
    "1e-400", "100000000", "999999999999999999", "1" + "0" * 30, "1" * 400, "0." + "3" * 300, "90", "45", "1e15", "0.1", "-0",
)  # fmt: skip
NAMES = (
    "a\nb",
    "x\rfake  material 9",
    "\x9b31m",
    "\u202eevil",
    "\u2028",
    "🙂",
    "'",
    '"',
    "\\",
    "x" * 5000,
    "a' @ cell 9",
    "\t",
)
FIELDS = (
    "dimension", "pitch", "lower_left", "universes", "outer", "n_rings", "n_axial", "center", "translation", "rotation", "coeffs",
    "region", "fill", "material", "universe", "id", "name", "type", "boundary",
)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
MATERIALS = '<materials><material id="1" name="{}"/><material id="2"/><material id="3" name="water"/></materials>'
Chance = random.Random


def mutated(seed: int) -> tuple[str, bytes]:
    """A file's name and what stands in it."""
    chance = random.Random(seed)
    text = chance.choice([*TEXTS.values(), EXAMPLE_FILES["pin"].read_text(encoding="utf-8")])
    name = "geometry.xml"
    if "<model" not in text and chance.random() < 0.4:
        listing = MATERIALS.format(_escaped(chance.choice(NAMES)))
        text = f"<model>{listing}{text.strip()}</model>"
    if "<model" in text:
        name = "model.xml"
    for _ in range(chance.choice([1, 1, 1, 1, 2, 3])):
        text = chance.choice(KINDS)(text, chance)
    content = text.encode("utf-8", "surrogatepass")
    return name, _in_bytes(content, chance) if chance.random() < 0.15 else content


def in_words(text: str, chance: Chance) -> str:
    """Words of OpenMC."""
    return words.in_words(text, chance, WORDS)


def in_numbers(text: str, chance: Chance) -> str:
    """A few numbers replaced by those at the edges of what there is, or scaled."""
    places = list(NUMBER.finditer(text))
    for found in sorted(chance.sample(places, min(len(places), chance.choice([1, 1, 2, 4]))), key=lambda m: -m.start()):
        new = chance.choice(NUMBERS)
        if chance.random() < 0.6:
            new = f"{found[0]}e{chance.choice([-300, -9, -3, -1, -1, 1, 1, 2, 9, 300])}"
        text = text[: found.start()] + new + text[found.end() :]
    return text


def in_attributes(text: str, chance: Chance) -> str:
    """A value left out, given, replaced, repeated, or exchanged with that of another element."""

    def change(elements: list[ElementTree.Element]) -> None:
        element, other = chance.choice(elements), chance.choice(elements)
        name = chance.choice(list(element.attrib) or FIELDS) if chance.random() < 0.6 else chance.choice(FIELDS)
        match chance.randrange(6):
            case 0:
                element.attrib.pop(name, None)
            case 1:
                element.set(name, " ".join(chance.choice(NUMBERS) for _ in range(chance.choice([1, 2, 3, 9]))))
            case 2:
                element.set(name, other.get(name, chance.choice(WORDS)))
            case 3:
                element.set(name, " ".join([element.get(name, "1")] * chance.choice([2, 3, 100])))
            case 4:
                element.set("name", chance.choice(NAMES))
            case _:
                field = chance.choice(["translation", "rotation", "pitch", "dimension"])
                count = chance.choice([2, 3, 3, 9])
                element.set(field, " ".join(chance.choice(NUMBERS) for _ in range(count)))

    return _in_tree(text, chance, change)


def in_structure(text: str, chance: Chance) -> str:
    """An element left out, repeated, moved into another, or under another name."""

    def change(elements: list[ElementTree.Element]) -> None:
        parent = chance.choice([element for element in elements if len(element)])
        child = chance.choice(list(parent))
        match chance.randrange(5):
            case 0:
                parent.remove(child)
            case 1:
                parent.extend([child] * chance.choice([1, 2, 50]))
            case 2:
                chance.choice([e for e in elements if e not in child.iter()]).append(child)
            case 3:
                child.tag = chance.choice(["surface", "cell", "lattice", "hex_lattice", "material", "geometry", "x"])
            case _:
                items = list(parent)
                chance.shuffle(items)
                parent[:] = items

    return _in_tree(text, chance, change)


def _in_tree(text: str, chance: Chance, change: Callable[[list[ElementTree.Element]], None]) -> str:
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError):
        return in_words(text, chance)
    if not len(root):
        return text
    change(list(root.iter()))
    return ElementTree.tostring(root, encoding="unicode")


def _in_bytes(content: bytes, chance: Chance) -> bytes:
    """Bytes changed, inserted, left out or repeated; or cut short."""
    data = bytearray(content)
    for _ in range(chance.choice([1, 2, 8])):
        at = chance.randrange(len(data) + 1)
        match chance.randrange(5):
            case 0:
                data[at : at + 1] = bytes([chance.randrange(256)])
            case 1:
                data[at:at] = chance.randbytes(chance.choice([1, 2, 20]))
            case 2:
                del data[at : at + chance.choice([1, 5, 100])]
            case 3:
                data[at:at] = data[at : at + chance.choice([10, 1000])]
            case _:
                if chance.random() < 0.3:
                    del data[at:]
    return bytes(data)


def _escaped(name: str) -> str:
    return "".join(
        f"&#{ord(c)};" if c in "\n\r\t" else c for c in name.replace("&", "").replace("<", "").replace('"', "")
    )


KINDS = (in_words, in_numbers, in_numbers, in_attributes, in_attributes, in_structure)
