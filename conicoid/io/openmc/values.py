"""Values of OpenMC's XML elements: words, numbers, titles, misspelt names, and materials.

`OpenmcValues` reads the attributes and child elements of one element and collects its errors. Texts may be as long as a
file, so words are counted piece by piece.
"""

from __future__ import annotations

import ast
import dataclasses
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any, TypeVar

from ..._util.files import Problem
from ..._util.records import dataclass
from ..._util.text import suggest_name
from ...materials.material import Properties
from ..scene_file.nodes import is_beyond_float64, shorten
from ..xml_tree import XmlElement

MAX_DISTINCT_WORDS = 1_000_000
"""Most words in one value, and most different words in a value that is only counted."""
_WORDS_CHUNK = 1 << 16
_SPACE = re.compile(r"\s")


def count_words(text: str) -> int:
    """Return the number of words in a text."""
    return sum(map(len, iterate_words(text)))


def count_each_word(text: str) -> Counter[str] | None:
    """Return how often each word occurs in a text; None if it has more than `MAX_DISTINCT_WORDS` different words."""
    counts: Counter[str] = Counter()
    for words in iterate_words(text):
        counts.update(words)
        if len(counts) > MAX_DISTINCT_WORDS:
            return None
    return counts


def iterate_words(text: str) -> Iterator[list[str]]:
    """Yield the words of a text in order, some thousands at a time."""
    at = 0
    while at < len(text):
        # At a space, so that no word is cut in two
        space = _SPACE.search(text, at + _WORDS_CHUNK)
        end = space.start() if space else len(text)
        yield text[at:end].split()
        at = end


# Values of an element, each an attribute or a child element, as OpenMC allows either.
#
# Numbers stay the decimal fractions that the file has: sums such as lower_left + i pitch are then exact, and surfaces
# that coincide on paper coincide in the scene.

_NUMBER = re.compile(r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][-+]?[0-9]+)?")
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}")
MAX_NUMBER_LENGTH = 400
Value = TypeVar("Value")
Other = TypeVar("Other")


class OpenmcElementError(Exception):
    """Raised with all errors in one element, which is then not read."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)


class OpenmcValues:
    """Reader of the values of one element; `where` is the name of the element in messages.

    All methods raise OpenmcElementError with the first error in a value. `attempt` records such an error, so that the
    other values are checked too, and `finish` raises all recorded errors.
    """

    def __init__(self, element: XmlElement, kind: str) -> None:
        self.element = element
        self.where = self.kind = kind
        self.problems: list[Problem] = []

    def mistake(self, message: str) -> OpenmcElementError:
        """Return an error with the place of the element."""
        return OpenmcElementError([Problem(self.element.line, self.element.column, self.where, message)])

    def add_mistake(self, message: str) -> None:
        """Record an error."""
        self.problems.extend(self.mistake(message).problems)

    def attempt(self, read: Callable[[], Value], otherwise: Other) -> Value | Other:
        """Return the result of `read`; if it raises an error, record it and return `otherwise`."""
        try:
            return read()
        except OpenmcElementError as mistake:
            self.problems.extend(mistake.problems)
            return otherwise

    def finish(self) -> None:
        """Raise the recorded errors, if any."""
        if self.problems:
            raise OpenmcElementError(self.problems)

    def title(self) -> tuple[int, str]:
        """Return the number and the name of the element, and use both in messages from now on."""
        name = self.text("name") or ""
        errors_before = len(self.problems)
        number = self.attempt(lambda: self.integer("id"), 0)
        if len(self.problems) == errors_before:
            self.where = format_title(self.kind, number, name)
        return number, name

    def text(self, name: str) -> str | None:
        """Return a value without space around it; None if it is missing. Attributes precede child elements."""
        if name in self.element.attributes:
            return self.element.attributes[name].strip()
        children = self.element.all(name)
        return children[0].text.strip() if children else None

    def require(self, name: str) -> str:
        """Return a value that must be present."""
        value = self.text(name)
        if value is None:
            raise self.mistake(f"needs the attribute or element {name!r}")
        return value

    def words(self, name: str) -> list[str] | None:
        """Return the words of a value; None if it is missing."""
        value = self.text(name)
        if value is None:
            return None
        words = value.split(None, MAX_DISTINCT_WORDS)
        if len(words) > MAX_DISTINCT_WORDS:
            raise self.mistake(f"{name} has more than {MAX_DISTINCT_WORDS:,} words")
        return words

    def integer(self, name: str) -> int:
        """Return an integer that must be present."""
        return self.integer_word(name, self.require(name))

    def optional_integer(self, name: str) -> int | None:
        """Return an integer; None if it is missing."""
        value = self.text(name)
        return None if value is None else self.integer_word(name, value)

    def integers(self, name: str) -> list[int]:
        """Return a list of integers that must be present."""
        self.require(name)
        return [self.integer_word(name, word) for word in self.words(name) or ()]

    def integer_tally(self, name: str) -> Counter[int]:
        """Return how often each integer occurs in a list, which may be very long."""
        counts: Counter[int] = Counter()
        words = count_each_word(self.require(name))
        if words is None:
            raise self.mistake(f"{name} has more than {MAX_DISTINCT_WORDS:,} different words")
        for word, count in words.items():
            counts[self.integer_word(name, word)] += count
        return counts

    def integer_word(self, name: str, word: str) -> int:
        """Return the integer that a word of the value `name` is."""
        if not _INTEGER.fullmatch(word):
            raise self.mistake(f"{name} must be an integer, got {quote_word(word)}")
        return int(word)

    def numbers(self, name: str, *counts: int) -> tuple[Fraction, ...]:
        """Return the numbers of a value that must be present; their number must be one of `counts`."""
        text = self.require(name)
        # One word more than allowed is enough to see that there are too many
        words = text.split(None, max(counts))
        if len(words) not in counts:
            expected = " or ".join(map(str, counts))
            plural = "" if counts == (1,) else "s"
            raise self.mistake(f"{name} must be {expected} number{plural}, got {count_words(text)}")
        return tuple(self._number(name, word) for word in words)

    def _number(self, name: str, word: str) -> Fraction:
        if len(word) > MAX_NUMBER_LENGTH or not _NUMBER.fullmatch(word):
            raise self.mistake(f"{name} must be a number, got {quote_word(word)}")
        nearest = float(word)
        if is_beyond_float64(word, nearest):
            raise self.mistake(f"{name} must be in the range of double precision, got {quote_word(word)}")
        # Below the smallest float the fraction would have hundreds of digits and mean 0 all the same
        return Fraction(word) if nearest else Fraction(0)


def format_title(kind: str, number: int, name: str) -> str:
    """Return a title such as "surface 3 'top'", with control characters escaped for terminals."""
    return f"{kind} {number} {shorten(name)!r}" if name else f"{kind} {number}"


# One literal as `repr` writes it: other text might nest too deep to evaluate
_ESCAPE = r"\\(?:[\\'nrt]|x[0-9a-f]{2}|u[0-9a-f]{4}|U000[0-9a-f]{5})"
_CELL_TITLE = re.compile(rf"""cell ([0-9]{{1,9}})(?: ('(?:[^'\\]|{_ESCAPE})*'|"(?:[^"\\]|{_ESCAPE})*"))?""")
_PLACE_NAME = re.compile(r"cell [0-9]{1,9}(?: '.*'| \".*\")? @ [a-z]+ .+")


def read_title(title: str) -> tuple[int, str] | None:
    """Return the number and the name of a cell whose title `format_title` made; None for another text."""
    match = _CELL_TITLE.fullmatch(title)
    try:
        number, name = (int(match[1]), ast.literal_eval(match[2] or "''")) if match else (0, "")
    except (SyntaxError, ValueError):
        return None
    return (number, name) if title == format_title("cell", number, name) else None


def is_place_name(name: str) -> bool:
    """Return True for a name that an import gave to a body of a filled cell, and an export to a cell."""
    return name.isprintable() and _PLACE_NAME.fullmatch(name) is not None


def quote_word(word: str) -> str:
    """Return a word in quotes, shortened and escaped; "nothing" for an empty one."""
    return repr(shorten(word)) if word else "nothing"


def join_limited(items: Iterable[object], most: int = 10) -> str:
    """Return items separated by commas: the first `most` and the number of the others."""
    texts = [str(item) for item in items]
    return ", ".join(texts[:most]) + (f" and {len(texts) - most} more" if len(texts) > most else "")


# Attributes and elements that OpenMC does not know, most often misspelt: they are not read, and a remark says so.

_ID_ATTRIBUTES = ("id", "name")
_LATTICE_ATTRIBUTES = (*_ID_ATTRIBUTES, "pitch", "outer", "universes")
_SHARE_ATTRIBUTES = ("name", "ao", "wo")
OPENMC_NAMES = {
    "geometry": ("surface", "cell", "lattice", "hex_lattice", "dagmc_universe"),
    "surface": (*_ID_ATTRIBUTES, "type", "coeffs", "boundary", "albedo", "periodic_surface_id"),
    "cell": (
        *_ID_ATTRIBUTES, "universe", "fill", "material", "region", "rotation", "translation",
        "temperature", "density", "volume",
    ),
    "lattice": (*_LATTICE_ATTRIBUTES, "dimension", "lower_left"),
    "hex_lattice": (*_LATTICE_ATTRIBUTES, "n_rings", "n_axial", "orientation", "center"),
    "materials": ("material", "cross_sections"),
    "material": (
        *_ID_ATTRIBUTES, "density", "nuclide", "element", "sab", "macroscopic", "temperature", "volume", "depletable",
        "isotropic", "cfg",
    ),
    "density": ("value", "units"),
    "nuclide": _SHARE_ATTRIBUTES,
    "element": _SHARE_ATTRIBUTES,
    "sab": ("name", "fraction"),
    "macroscopic": ("name",),
}  # fmt: skip
"""Names of attributes and child elements by tag (OpenMC's documentation, "Geometry" and "Materials")."""


@dataclass(frozen=True)
class UnknownName:
    """An unknown name in elements of a kind, the number of its occurrences, and the line of the first."""

    kind: str
    name: str
    times: int
    line: int

    def __str__(self) -> str:
        hint = suggest_name(self.name, OPENMC_NAMES[self.kind])
        times = f", {self.times:,} times" if self.times > 1 else ""
        return f"line {self.line}: <{self.kind}>: {shorten(self.name)!r} is not read{times}{hint}"


def find_unknown_names(root: XmlElement) -> Iterator[UnknownName]:
    """Return unknown names in the order of the file, each once for a kind of element."""
    counts: dict[tuple[str, str], list[int]] = {}
    pending = [root]
    while pending:
        element = pending.pop()
        names = OPENMC_NAMES.get(element.tag)
        if names is None:
            continue
        for name, line in (
            *((name, element.line) for name in element.attributes),
            *((child.tag, child.line) for child in element.children),
        ):
            if name not in names:
                count = counts.setdefault((element.tag, name), [0, line])
                count[0] += 1
        pending.extend(child for child in reversed(element.children) if child.tag in names)
    return (UnknownName(kind, name, times, line) for (kind, name), (times, line) in counts.items())


# Reader of OpenMC's <material> elements into names and properties.

_MASS = {"g/cm3": Fraction(1), "g/cc": Fraction(1), "kg/m3": Fraction(1, 1000)}
_ATOMS = {"atom/b-cm": Fraction(1), "atom/cm3": Fraction(1, 10**24)}
# Units without a value of their own: "sum" adds the fractions, "macro" refers to macroscopic cross sections.
_OTHER_UNITS = ("sum", "macro")
NuclideShares = dict[str, dict[str, Fraction]]
"""Fractions by kind ("ao" or "wo") and by nuclide or element."""
VACUUM_DENSITIES = {"density": 0.0, "atom_density": 0.0}
"""The properties of void."""


@dataclasses.dataclass(frozen=True, slots=True)
class OpenmcMaterial:
    """A material of a file.

    Its properties are `id`; `density` in g/cm3 or `atom_density` in atoms per barn and cm, whichever the file has; `ao`
    and `wo`, fractions by nuclide or element; `sab` and `macroscopic`, names; `temperature`, `volume`, `depletable`.
    """

    id: int
    name: str
    properties: Properties

    def __str__(self) -> str:
        return format_title("material", self.id, self.name)


def read_material(element: XmlElement) -> OpenmcMaterial:
    """Return the material of a <material> element. Raise OpenmcElementError with all its errors."""
    values = OpenmcValues(element, "material")
    # Outside of `attempt`: without a number no message could name the material.
    name = values.text("name") or ""
    number = values.integer("id")
    values.where = format_title("material", number, name)
    properties: dict[str, Any] = {"id": number}
    fractions = values.attempt(lambda: _fractions(values), {})
    for part in element.all("density"):
        properties |= values.attempt(partial(_density, _part(values, part), fractions), {})
    for kind, shares in fractions.items():
        properties |= {kind: {name: float(share) for name, share in shares.items()}} if shares else {}
    for kind in ("sab", "macroscopic"):
        names = values.attempt(partial(_names, values, kind), ())
        properties |= {kind: names} if names else {}
    for kind in ("temperature", "volume"):
        properties |= values.attempt(partial(_number, values, kind), {})
    # OpenMC writes "true", and XML allows "1"
    depletable = (values.text("depletable") or "").lower()
    properties |= {"depletable": depletable in ("true", "1")} if depletable else {}
    values.finish()
    return OpenmcMaterial(number, name, Properties(properties))


def _part(values: OpenmcValues, element: XmlElement) -> OpenmcValues:
    """Return a reader of a child element, whose messages name the material too."""
    part = OpenmcValues(element, element.tag)
    part.where = f"{values.where}: {element.tag}"
    return part


def _density(values: OpenmcValues, fractions: NuclideShares) -> dict[str, float]:
    """Return the density of a <density> element as a property; empty for macroscopic units."""
    units = values.text("units") or ""
    # OpenMC: the fractions are densities, and their sum is that of the material
    if units == "sum":
        return _sum(values, fractions)
    if units in _OTHER_UNITS:
        return {}
    if units not in _MASS and units not in _ATOMS:
        unit_names = ", ".join((*_MASS, *_ATOMS, *_OTHER_UNITS))
        raise values.mistake(f"units must be one of {unit_names}, got {quote_word(units)}")
    (value,) = values.numbers("value", 1)
    if value <= 0:
        raise values.mistake(f"value must be > 0, got {quote_word(values.require('value'))}")
    if units in _MASS:
        return {"density": float(value * _MASS[units])}
    return {"atom_density": float(value * _ATOMS[units])}


def _sum(values: OpenmcValues, fractions: NuclideShares) -> dict[str, float]:
    """Return the sum of fractions that are densities themselves: `ao` in atoms per barn and cm, `wo` in g/cm3."""
    kinds = [kind for kind, shares in fractions.items() if shares]
    if len(kinds) > 1:
        raise values.mistake("units sum needs either ao or wo of all nuclides, got both")
    names = {"ao": "atom_density", "wo": "density"}
    return {names[kind]: float(sum(fractions[kind].values())) for kind in kinds}


def _fractions(values: OpenmcValues) -> NuclideShares:
    """Return atom and weight fractions by name; fractions of the same name are added."""
    sums: dict[str, dict[str, Fraction]] = {"ao": {}, "wo": {}}
    for tag in ("nuclide", "element"):
        for element in values.element.all(tag):
            part = _part(values, element)
            name = part.require("name")
            for kind in sums:
                # Fractions are added exactly and rounded to floats once, at the end.
                if part.text(kind) is not None and name:
                    share = _not_negative(part, kind)
                    sums[kind][name] = sums[kind].get(name, Fraction(0)) + share
    return sums


def _names(values: OpenmcValues, tag: str) -> tuple[str, ...]:
    names = [_part(values, element).require("name") for element in values.element.all(tag)]
    return tuple(name for name in names if name)


def _number(values: OpenmcValues, name: str) -> dict[str, float]:
    if values.text(name) is None:
        return {}
    return {name: float(_not_negative(values, name))}


def _not_negative(values: OpenmcValues, name: str) -> Fraction:
    (value,) = values.numbers(name, 1)
    if value < 0:
        raise values.mistake(f"{name} must be >= 0, got {quote_word(values.require(name))}")
    return value
