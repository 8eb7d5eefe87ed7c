"""GDML's <define>: numbers, vectors and matrices by name."""

from __future__ import annotations

from fractions import Fraction

from ..nodes import shortened
from ..openmc.xml_tree import Element
from .reading import Mistake, Reading, local
from .values import vector

MOST_ENTRIES = 1_000_000
_VECTORS = ("position", "rotation", "scale")


def read_defines(reading: Reading, section: Element) -> None:
    """All of a section; what is wrong is reported."""
    for element in reading.each(section.children):
        name = element.attributes.get("name", "")
        try:
            name = reading.solved(name, element)
            _define(reading, element, name)
        except Mistake as mistake:
            reading.report(mistake.element, f"{local(element)} {name!r}", mistake.message)


def _define(reading: Reading, element: Element, name: str) -> None:
    tag = local(element)
    if tag == "expression":
        reading.names[_named(element, name)] = reading.value(element.text.strip(), element, "expression")
    elif tag in ("constant", "variable", "quantity"):
        value = _number(reading, element)
        if tag == "quantity":
            value *= reading.value(element.attributes.get("unit") or "1", element, "unit")
        if tag == "variable":
            reading.variables.add(name)
        reading.names[_named(element, name)] = value
    elif tag in _VECTORS:
        reading.vectors.setdefault(tag, {})[_named(element, name)] = vector(reading, element, tag)
    elif tag == "matrix":
        _matrix(reading, element, _named(element, name))
    else:
        reading.remark(element, f"{tag} {name!r}", "is no definition that is known, left out")


def _named(element: Element, name: str) -> str:
    if not name:
        raise Mistake(element, "name must be given")
    return name


def _number(reading: Reading, element: Element) -> Fraction:
    text = element.attributes.get("value")
    if text is None:
        raise Mistake(element, "value must be given")
    return reading.value(text, element, "value")


def _matrix(reading: Reading, element: Element, name: str) -> None:
    """Entries are name_1_1, and name_1 where there is one row or column."""
    words = element.attributes.get("values", "").split()
    columns = reading.value(element.attributes.get("coldim", "1"), element, "coldim")
    if columns.denominator != 1 or columns < 1 or not words or len(words) % int(columns):
        raise Mistake(element, f"values must fill rows of coldim = {shortened(str(columns))}, got {len(words):,}")
    reading.columns[name] = count = int(columns)
    rows = len(words) // count
    if len(reading.names) + len(words) > MOST_ENTRIES:
        raise Mistake(element, f"has more than {MOST_ENTRIES:,} entries, with all other names")
    for k, word in enumerate(words):
        value = reading.value(word, element, "values")
        row, column = divmod(k, count)
        reading.names[f"{name}_{row + 1}_{column + 1}"] = value
        if rows == 1 or count == 1:
            reading.names[f"{name}_{k + 1}"] = value
