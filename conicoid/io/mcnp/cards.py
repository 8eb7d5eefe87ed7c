"""Cards of MCNP decks: lines, numbers, cell cards, data cards and materials.

`read_cards` splits a file into the cards of its three blocks, with comments removed, continued lines joined and line
numbers recorded. The other parts read numbers with Fortran's notation and shortcuts, cell cards, the data cards that
concern the geometry (TR, M and entries for cells), and materials by number and density. Readers of cards raise
ValueError; the importer adds the line.
"""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from fractions import Fraction
from types import MappingProxyType

from ..._util.files import Problem, SceneFileError, read_bounded, resolve_part
from ..._util.records import dataclass
from ..._util.text import suggest_name
from ...materials.material import Properties
from ..openmc.values import OpenmcMaterial
from ..scene_file.nodes import is_beyond_float64, shorten
from ..xml_tree import XmlElement
from .transformations import FrameChange, parse_transformation

MAX_DECK_BYTES = 64 << 20
MAX_CARDS = 1_000_000
"""Most bytes and most cards of a file."""
MAX_COLUMNS = 128
"""Columns of a line that MCNP reads."""
# "c" in one of the first five columns, followed by a blank.
_COMMENT = re.compile(r" {0,4}c(?: |$)")


@dataclasses.dataclass(frozen=True, slots=True)
class Card:
    """A card: its text in lower case, joined into one line, and the number of its first line."""

    line: int
    text: str
    hint: str = ""
    """The end of messages: whether its line may be meant as a continuation, and its place in another file."""

    @property
    def element(self) -> XmlElement:
        """The place of the card, in the form in which `CellGeometry` records places."""
        return XmlElement("card", self.line, 1, {})


@dataclass
class Deck:
    """A deck: the title, the cards of the three blocks, and remarks."""

    title: str
    cells: list[Card] = field(default_factory=list)
    surfaces: list[Card] = field(default_factory=list)
    data: list[Card] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def read_cards(path: str | os.PathLike[str], root: str | os.PathLike[str] | None) -> Deck:
    """Read the cards of a file and of those within `root` that its READ cards name; None is the folder of the file.

    Raise SceneFileError if a file cannot be read or is too large, or if the file is no deck.
    """
    files = _DeckFiles(path, os.path.dirname(os.path.abspath(path)) if root is None else root)
    lines = files.read(path)
    first = _title_line(lines)
    files.lines, files.numbers = lines[: first + 1], [*range(1, first + 2)]
    files.insert(path, lines, first + 1, None)
    deck, problems = parse_deck(files.lines, files.numbers, files.places)
    if problems:
        raise SceneFileError(path, problems)
    return deck


MAX_INSERTED_FILES, MAX_INSERTED_DEPTH = 200, 8
"""Most files that READ cards insert, and most levels of them."""
# A READ card, as far as it is on one line
_READ = re.compile(r" {0,4}read(?: (.*))?", re.I)
_READ_FILE = re.compile(r"(?<![^ ])file(?=[ =]) *+=?+ *+([^ =&]+)", re.I)


@dataclass
class _DeckFiles:
    """The lines of a deck, with the files that READ cards insert.

    `numbers` are the numbers of lines in the deck itself, and `places` texts for lines of other files, by index.
    """

    deck: str | os.PathLike[str]
    root: str | os.PathLike[str]
    size: int = 0
    inserted: int = 0
    blanks: int = 0
    goes_on: bool = False  # the next line continues a card, by & at the end of the last one
    lines: list[str] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    places: dict[int, str] = field(default_factory=dict)

    def read(self, path: str | os.PathLike[str]) -> list[str]:
        """Return the lines of a file. Raise SceneFileError if it cannot be read, or is too large with those before."""
        raw = read_bounded(path, MAX_DECK_BYTES, self.size)
        self.size += len(raw)
        # Comments of old decks are in any encoding, and cards are ASCII; `splitlines` would also split at form feeds
        text = raw.decode("utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        return text.split("\n")

    def insert(
        self, path: str | os.PathLike[str], lines: list[str], start: int, line: int | None, stack: tuple[str, ...] = ()
    ) -> None:
        """Add lines of a file from the index `start` on, with the files that they insert.

        `line` is the number of the READ card of the deck itself; None for the deck.
        """
        for index in range(start, len(lines)):
            number = line or index + 1
            text = _strip_comment(lines[index].expandtabs(8))
            card = None if self.goes_on else _READ.fullmatch(text)
            # After the third block are notes, which name no files
            if card is not None and self.blanks < 3 and self._follow(path, card[1] or "", number, stack):
                continue
            self.blanks += not lines[index].strip()
            if not lines[index].strip() or (text.strip() and not _is_comment(lines[index])):
                self.goes_on = text.rstrip().endswith("&")
            if line is not None:
                self.places[len(self.numbers)] = f" (line {index + 1} of {os.path.basename(path)})"
            self.lines.append(lines[index])
            self.numbers.append(number)

    def _follow(self, path: str | os.PathLike[str], words: str, line: int, stack: tuple[str, ...]) -> bool:
        """Insert the file that a READ card names; return False for a card that is encrypted or goes on."""
        if words.endswith("&") or re.search(r"\b(de|en)code\b", words, re.I):
            return False
        name = _READ_FILE.search(words)
        # ECHO and NOECHO alone choose what MCNP prints
        if name is None:
            return {*words.lower().split()} <= {"echo", "noecho"}
        self.inserted += 1
        stack = *stack, os.path.realpath(path)
        try:
            other = self._resolve(path, name[1])
            if other in stack:
                raise ValueError(f"file {name[1][:80]!r} refers to itself, directly or through other files")
            if self.inserted > MAX_INSERTED_FILES or len(stack) > MAX_INSERTED_DEPTH:
                raise ValueError(
                    f"at most {MAX_INSERTED_FILES} files are read, nested {MAX_INSERTED_DEPTH} levels deep"
                )
        except ValueError as error:
            raise SceneFileError(self.deck, [Problem(line, 1, "read", str(error))]) from None
        try:
            lines = self.read(other)
        except SceneFileError as error:
            raise SceneFileError(self.deck, [Problem(line, 1, "read", str(error))]) from None
        # The end of the last line begins no line
        self.insert(other, lines[:-1] if not lines[-1] else lines, 0, line, stack)
        return True

    def _resolve(self, path: str | os.PathLike[str], name: str) -> str:
        """Return the path of a file that the file `path` names. Raise ValueError if it is outside of the root."""
        beside = resolve_part(path, name, self.root)
        # MCNP looks in the folder in which it runs, which is that of the deck
        with suppress(ValueError):
            if os.path.exists(first := resolve_part(self.deck, name, self.root)):
                return first
        return beside


def parse_deck(
    lines: list[str], numbers: Sequence[int] = (), places: Mapping[int, str] = MappingProxyType({})
) -> tuple[Deck, list[Problem]]:
    """Return the cards in lines of text, and the errors.

    `numbers` are those of the lines, by default 1, 2, 3 and so on; `places` are texts for lines of other files.
    """
    first = _title_line(lines)
    numbers = numbers or range(1, len(lines) + 1)
    deck = Deck(lines[first].strip() if first < len(lines) else "")
    blocks = iter((deck.cells, deck.surfaces, deck.data))
    problems: list[Problem] = []
    # The first line of a restart file, which has neither cells nor surfaces
    if deck.title.lower().startswith("continue"):
        problems.append(Problem(first + 1, 1, "", "continues another run, and holds no geometry"))
        return deck, problems
    _join_lines(lines, first + 1, blocks, problems, numbers, places)
    if sum(map(len, (deck.cells, deck.surfaces, deck.data))) > MAX_CARDS:
        problems.append(Problem(0, 0, "", f"has more than {MAX_CARDS:,} cards"))
    for card in (*deck.cells, *deck.surfaces, *deck.data):
        # READ cards of plain files are gone already
        if re.match(r"read\b", card.text):
            message = "is encrypted, or not written as READ FILE=name on one line" + card.hint
            problems.append(Problem(card.line, 1, "read", message))
        # Read as rows, a table in columns would give wrong numbers without an error; of sources it gives none
        if card.text.startswith("#") and any(map(_GEOMETRY_COLUMN.match, card.text[1:].split())):
            message = "begins a table in columns (vertical input): write it in rows" + card.hint
            problems.append(Problem(card.line, 1, "#", message))
    long = [
        n
        for n in range(first + 1, len(lines))
        if len(_strip_comment(lines[n])) > MAX_COLUMNS and not _is_comment(lines[n])
    ]
    if long:
        deck.remarks.append(f"line {numbers[long[0]]}: is read to its end, MCNP reads {MAX_COLUMNS} columns of a line")
    return deck, problems


_GEOMETRY_COLUMN = re.compile(r"\*?(tr|m)\d|\*?(imp|u|lat|fill|trcl)(:|\Z)")
"""The heading of a column that is read; nothing else of the data block is."""


def _title_line(lines: list[str]) -> int:
    """Return the index of the title: the first line, or the line after a message block and its blank line."""
    if not lines or not lines[0].lower().lstrip().startswith("message:"):
        return 0
    return next((n + 1 for n, line in enumerate(lines) if not line.strip()), len(lines))


def _join_lines(
    lines: list[str], start: int, blocks: Iterator[list[Card]], problems: list[Problem],
    numbers: Sequence[int], places: Mapping[int, str],
) -> None:  # fmt: skip
    """Join continued lines into cards and fill the blocks; a blank line ends a block.

    A line continues a card after `&` at the end of the line before, or with five blanks at its beginning.
    """
    block, pieces, begin, goes_on, hint, indent = next(blocks), [""], 0, False, "", 0

    def close() -> None:
        text = " ".join(pieces).replace("=", " ").strip()  # "=" is a blank in MCNP
        if text:
            block.append(Card(begin, text, hint))
        pieces.clear()

    for number in range(start, len(lines)):
        # MCNP knows no case, and a tab counts as blanks up to the next multiple of eight
        line = lines[number].expandtabs(8).lower()
        if not line.strip():
            close()
            goes_on = False
            following = next(blocks, None)
            # After the third block MCNP stops reading, so that notes may follow
            if following is None:
                return
            block = following
            continue
        if _is_comment(line):
            continue
        text = _strip_comment(line)
        if not text.strip():
            continue  # nothing but a comment after $
        blanks = len(line) - len(line.lstrip())
        if not goes_on and blanks < 5:
            is_short = max(indent, 1) < blanks and any(map(str.strip, pieces))
            close()
            begin, indent = numbers[number], blanks
            hint = f"; a continued line needs five blanks, this one has {blanks}" if is_short else ""
            hint += places.get(number, "")
        elif not goes_on and not any(map(str.strip, pieces)):
            message = "continues a card, and there is none before it" + places.get(number, "")
            problems.append(Problem(numbers[number], 1, "", message))
        goes_on = text.rstrip().endswith("&")
        pieces.append(text.rstrip().removesuffix("&") if goes_on else text)
    close()


def _is_comment(line: str) -> bool:
    return _COMMENT.match(line.expandtabs(8).lower().rstrip() + " ") is not None


def _strip_comment(line: str) -> str:
    """Return a line without the comment after $."""
    return line.split("$", 1)[0].rstrip()


# Numbers in Fortran's notation, as exact decimal fractions, and the shortcuts nR, nI, nM, nJ

MAX_NUMBER_LENGTH = 400
MAX_ENTRIES = 1_000_000
"""Most entries of one card, with shortcuts expanded."""
_NUMBER = re.compile(r"([-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++))(?:[ed]?([-+][0-9]+)|[ed]([0-9]+))?")
_SHORTCUT = re.compile(r"([0-9]{0,9})(r|i|j)|(.+)m")
_LOG_SHORTCUT = re.compile(r"(\d{0,9})i?log")
_INTEGER = re.compile(r"[-+]?[0-9]{1,15}")


def parse_number(word: str) -> Fraction:
    """Return the exact value of a number such as 1.5, 1.5e-3, 1.5d-3 or 1.5-3.

    Raise ValueError for other words and for numbers beyond double precision. Numbers that round to 0 are 0.
    """
    match = _NUMBER.fullmatch(word) if len(word) <= MAX_NUMBER_LENGTH else None
    if match is None:
        raise ValueError(f"{shorten(word, 40)!r} is no number")
    exponent = match[2] or match[3]
    plain = match[1] + (f"e{exponent}" if exponent else "")
    # The float only decides whether the number is in range; its value is kept exact
    nearest = float(plain)
    if is_beyond_float64(plain, nearest):
        raise ValueError(f"{shorten(word, 40)!r} is beyond double precision")
    return Fraction(plain) if nearest else Fraction(0)


def parse_integer(what: str, word: str | Fraction) -> int:
    """Return a whole number; `what` names it in the message. Raise ValueError for other values."""
    if isinstance(word, Fraction):
        if word.denominator != 1:
            raise ValueError(f"{what} must be an integer, got {float(word):g}")
        return int(word)
    if not _INTEGER.fullmatch(word):
        raise ValueError(f"{what} must be an integer, got {shorten(word, 40)!r}")
    return int(word)


def parse_numbers(words: Iterable[str]) -> list[Fraction]:
    """Return the entries of a card that has no defaults. Raise ValueError if an entry is skipped or no number."""
    entries = expand_entries(words)
    values = [value for value in entries if value is not None]
    if len(values) < len(entries):
        raise ValueError("jumps over an entry (nJ) that has no default here")
    return values


def expand_entries(words: Iterable[str]) -> list[Fraction | None]:
    """Return the entries of a card with shortcuts expanded; None for entries that nJ skips.

    nR repeats the entry before it, nI and nLOG interpolate n entries, nM multiplies. Wrong entries raise ValueError.
    """
    result: list[Fraction | None] = []
    steps, log = 0, False
    for word in words:
        # nLOG and nILOG interpolate logarithms, which needs numbers of one sign
        if match := _LOG_SHORTCUT.fullmatch(word):
            word, log = f"{match[1]}i", True
        short = _SHORTCUT.fullmatch(word)
        # "2m" is a shortcut, and so is "1.5m"; any other word with an m at its end is a mistake, which `parse_number`
        # reports
        if short is None or (short[2] is None and _NUMBER.fullmatch(short[3]) is None):
            value = parse_number(word)
            _interpolate(result, steps, value, log and bool(steps))
            log = log and not steps
            result.append(value)
            steps = 0
        elif steps:
            raise ValueError(f"a number must follow the shortcut {steps}i, got {shorten(word, 40)!r}")
        elif short[2] == "j":
            result += [None] * _repeat_count(short[1], result)
        elif not result or result[-1] is None:
            raise ValueError(f"the shortcut {shorten(word, 40)!r} needs a number before it")
        elif short[2] == "r":
            result += [result[-1]] * _repeat_count(short[1], result)
        elif short[2] == "i":
            steps = _repeat_count(short[1], result)
        else:
            result.append(result[-1] * parse_number(short[3]))
        # Before memory is taken: "999999999r" has eleven letters
        if len(result) > MAX_ENTRIES:
            raise ValueError(f"has more than {MAX_ENTRIES:,} entries")
    if steps:
        raise ValueError(f"a number must follow the shortcut {steps}i")
    return result


def _repeat_count(word: str, before: list[Fraction | None]) -> int:
    """Return n of a shortcut, 1 if it is missing. Raise ValueError before a list becomes too long."""
    times = int(word or 1)
    if times + len(before) > MAX_ENTRIES:
        raise ValueError(f"has more than {MAX_ENTRIES:,} entries")
    return times


def _interpolate(result: list[Fraction | None], steps: int, end: Fraction, log: bool) -> None:
    """Append `steps` numbers between the last entry and `end`, evenly spaced, or with `log` in even ratios."""
    if steps:
        start = result[-1]
        assert start is not None
        if log:
            if start * end <= 0:
                raise ValueError(f"the shortcut {steps}ilog needs two numbers of one sign, and not 0, around it")
            ratio = float(end / start)
            result += [start * Fraction(ratio ** (i / (steps + 1))) for i in range(1, steps + 1)]
            return
        # In fractions, so that planes at even distances have the offsets that the deck means
        result += [start + (end - start) * i / (steps + 1) for i in range(1, steps + 1)]


# Cell cards: number, material, density, region and parameters

_CELL_WORD = re.compile(r"\*?[a-z]+[0-9]*(?::[^\s()=]+)?|[():#]|[^\s():#=]+")
_CELL_PARAMETER_NAME = re.compile(r"\*?[a-z]+[0-9]*(?::.+)?")
# Of an exponential transform: into the direction of flight, or towards an axis or a vector, such as "x", "sz" or "v2"
_DIRECTION = re.compile(r"s|s?[xyz]|s?v[0-9]+")
GEOMETRY_PARAMETERS = ("u", "fill", "lat", "trcl", "imp", "mat", "rho")
OTHER_PARAMETERS = (
    "vol", "pwt", "ext", "fcl", "wwn", "dxc", "nonu", "pd", "tmp", "cosy", "bflcl", "elpt", "unc",
)  # fmt: skip
"""Parameters of particles and tallies, which are not read."""


@dataclass(frozen=True)
class CellCard:
    """A cell card; `keywords` holds the words after each parameter's name, such as "fill" or "imp:n"."""

    number: int
    card: Card
    material: int
    density: Fraction | None
    region: list[str]
    keywords: dict[str, list[str]] = field(default_factory=dict)

    def words(self, name: str) -> tuple[list[str], bool] | None:
        """Return the words of a parameter, and True if its name has a star (angles in degrees); None without it."""
        for star in ("", "*"):
            if star + name in self.keywords:
                return self.keywords[star + name], bool(star)
        return None


def read_cell_card(card: Card, earlier: Mapping[int, CellCard]) -> CellCard:
    """Return the cell of a card; LIKE n BUT copies one of the `earlier` cells. Raise ValueError for a wrong card."""
    words = _CELL_WORD.findall(card.text)
    if not words:
        raise ValueError("a cell begins with its number")
    # The order of the words on a card is fixed; only parameters have names
    cell_number = parse_integer("the number of a cell", words[0])
    if cell_number < 1:
        raise ValueError(f"the number of a cell must be > 0, got {cell_number}")
    if words[1:2] == ["like"]:
        return _read_like_card(cell_number, card, words[2:], earlier)
    if len(words) < 2:
        raise ValueError("a cell needs a material (0 for void)")
    material, at, density = parse_integer("the material", words[1]), 2, None
    if material < 0:
        raise ValueError(f"the material must be >= 0, got {material}")
    if material:  # void (0) has no density
        if len(words) < 3:
            raise ValueError("a cell with a material needs its density")
        density, at = parse_number(words[2]), 3
        if not density:
            raise ValueError("the density must not be 0")
    # Regions hold no letters, so the first name ends the region
    end = next((i for i in range(at, len(words)) if _CELL_PARAMETER_NAME.fullmatch(words[i])), len(words))
    return CellCard(cell_number, card, material, density, words[at:end], _split_parameters(words[end:]))


def _read_like_card(cell_number: int, card: Card, words: list[str], earlier: Mapping[int, CellCard]) -> CellCard:
    """Return the cell of a card LIKE n BUT, from the words after LIKE."""
    if not words:
        raise ValueError("like: 'LIKE n BUT ...' needs the number of a cell")
    other = parse_integer("the cell after LIKE", words[0])
    # References go back only, so that no cell is like itself
    if other not in earlier:
        raise ValueError(f"like: cell {other} is not defined before")
    model, changes = earlier[other], _split_parameters(words[2:] if words[1:2] == ["but"] else words[1:])
    for name in ("fill", "trcl"):  # the same parameter with and without a star: the new one replaces the old one
        if name in changes or "*" + name in changes:
            model = replace(model, keywords={k: v for k, v in model.keywords.items() if k.removeprefix("*") != name})
    material, density = model.material, model.density
    if "mat" in changes:
        material = parse_integer("mat", _single_word("mat", changes["mat"]))
    if "rho" in changes:
        density = parse_number(_single_word("rho", changes["rho"]))
    # BUT MAT= turns a void cell into matter, and void has no density to inherit
    if material and not density:
        raise ValueError("a cell with a material needs its density (rho)")
    parameters = {**model.keywords, **changes}
    return CellCard(cell_number, card, material, density if material else None, model.region, parameters)


def _single_word(name: str, words: list[str]) -> str:
    if len(words) != 1:
        raise ValueError(f"{name} must be one number, got {len(words)}")
    return words[0]


def _split_parameters(words: list[str]) -> dict[str, list[str]]:
    """Return the words after each parameter's name.

    Shortcuts without a number (r, i, j, m) and the directions of EXT are words, not names.
    """
    parameters: dict[str, list[str]] = {}
    last: list[str] | None = None
    plain = ""
    for word in words:
        is_word = word in ("r", "i", "j", "m") or (plain == "ext" and _DIRECTION.fullmatch(word))
        if not _CELL_PARAMETER_NAME.fullmatch(word) or (is_word and last is not None):
            if last is None:
                raise ValueError(
                    f"{shorten(word, 20)!r} stands where the name of a parameter must be, such as imp:n or fill"
                )
            last.append(word)
            continue
        plain = re.sub(r"[0-9:].*", "", word.removeprefix("*"))
        # A misspelt "fill" must not pass for a parameter that is of no interest
        if plain not in GEOMETRY_PARAMETERS + OTHER_PARAMETERS:
            raise ValueError(
                f"{shorten(word, 20)!r} is nothing that a cell "
                f"has{suggest_name(plain, GEOMETRY_PARAMETERS + OTHER_PARAMETERS)}"
            )
        if word in parameters:
            raise ValueError(f"{shorten(word, 20)!r} is given twice")
        last = parameters[word] = []
    return parameters


# Data cards that concern the geometry: TR, M, and parameters of cells

_DATA_CARD_NAME = re.compile(r"(\*?)([a-z]+)([0-9]{0,9})(\*|:\S+)?")
PER_CELL_CARDS = ("imp", "u", "lat", "fill", "trcl")
NuclideShares = dict[str, dict[str, Fraction]]


@dataclass
class DataCards:
    """Transformations and materials by number, and parameters of the cells, in their order, by name."""

    changes: dict[int, FrameChange] = field(default_factory=dict)
    materials: dict[int, NuclideShares] = field(default_factory=dict)
    cells: dict[str, tuple[Card, list[Fraction | None]]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    last: str = ""
    """The name of the card before, if it concerns the geometry."""

    def read(self, card: Card) -> None:
        """Read one card; cards that do not concern the geometry are ignored. Raise ValueError for a wrong card."""
        name, *words = card.text.split()
        match, last, self.last = _DATA_CARD_NAME.fullmatch(name), self.last, ""
        if match is None:
            if last and name[0] in "0123456789.+-":  # numbers without which that card means something else
                raise ValueError(f"must begin with the name of a card; numbers of {last} are not continued")
            self.remarks.append(f"line {card.line}: {shorten(name, 20)!r} is not read{card.hint}")
            return
        star, kind, digits, particles = match.groups()
        if particles == "*":  # the star may also follow the number
            star, particles = "*", None
        if kind == "tr" or (kind in PER_CELL_CARDS and not digits):
            self.last = name
        if kind == "tr":
            key = int(digits or 1)
            if key in self.changes:
                raise ValueError(f"tr{key} is given twice")
            self.changes[key] = FrameChange()  # so that references to a wrong card report no second error
            self.changes[key] = parse_transformation(expand_entries(words), bool(star))
        # M0 sets defaults of all materials
        elif kind == "m" and digits and int(digits):
            if int(digits) in self.materials:
                raise ValueError(f"m{int(digits)} is given twice")
            try:
                self.materials[int(digits)] = _nuclide_shares(words)
            except ValueError as error:  # nuclides are no geometry
                self.materials[int(digits)] = {}
                self.remarks.append(f"line {card.line}: m{int(digits)}: its nuclides are not read: {error}{card.hint}")
        elif kind in PER_CELL_CARDS and not digits:
            # Where one entry ends and the next cell's begins would need the ranges of every lattice
            if kind in ("fill", "trcl") and (star or ":" in card.text or "(" in card.text):
                raise ValueError(f"{kind} in the data block is read with one number for each cell only")
            self.cells[kind + (particles or "")] = card, expand_entries(words)
        elif kind == "void":
            self.remarks.append(f"line {card.line}: the card VOID is not obeyed: cells keep their materials")


def _repeated(words: list[str]) -> list[str]:
    """Return words with nR, which repeats the word before it."""
    result: list[str] = []
    for word in words:
        if (match := re.fullmatch(r"(\d{0,9})r", word)) and result:
            count = int(match[1] or 1)
            if count + len(result) > MAX_ENTRIES:
                raise ValueError(f"has more than {MAX_ENTRIES:,} entries")
            result += [result[-1]] * count
        else:
            result.append(word)
    return result


def _nuclide_shares(words: list[str]) -> NuclideShares:
    """Return atom fractions ("ao") and weight fractions ("wo"), which a deck writes as negative numbers."""
    fractions: NuclideShares = {"ao": {}, "wo": {}}
    words, at = _repeated(words), 0
    while at < len(words):
        name = words[at]
        if at + 1 >= len(words):
            raise ValueError(f"a fraction is missing after {shorten(name, 20)!r}")
        if re.fullmatch(r"[0-9]+(\.[0-9a-z]+)?", name):
            share = parse_number(words[at + 1])
            shares = fractions["wo" if share < 0 else "ao"]
            # A nuclide may be listed more than once, with libraries of its own
            shares[name] = shares.get(name, Fraction(0)) + abs(share)
        # Words such as gas=1 or nlib=80c are options, in pairs with their values as well; h-1 names a nuclide
        elif not re.match(r"[a-z]", name) or "-" in name:
            raise ValueError(f"{shorten(name, 20)!r} is no nuclide, such as 92235.80c")
        at += 2
    return fractions


# Materials by number and density: an MCNP deck gives densities in cells, not in materials.

FIRST_FREE_KEY = 10**12
"""First key of objects without a number of their own, above all numbers of cells and surfaces."""


@dataclass
class McnpMaterials:
    """Materials, one for each number and density in cells; the first with a number has the number as its key."""

    shares: Mapping[int, NuclideShares]
    found: dict[int, OpenmcMaterial] = field(default_factory=dict)
    keys: dict[tuple[int, Fraction], int] = field(default_factory=dict)

    def key(self, number: int, density: Fraction) -> int:
        """Return the key of a material with a density: atoms per barn and cm, or, if negative, g/cm3."""
        entry = self.keys.get((number, density))
        if entry is not None:
            return entry
        # One material at two densities is two materials in a scene
        key = number if number not in self.found else FIRST_FREE_KEY + len(self.keys)
        self.keys[number, density] = key
        density_property = {"density": float(-density)} if density < 0 else {"atom_density": float(density)}
        shares = {
            kind: {name: float(share) for name, share in parts.items()}
            for kind, parts in self.shares.get(number, {}).items()
            if parts
        }
        properties = Properties({"id": number, **density_property, **shares})
        self.found[key] = OpenmcMaterial(number, f"m{number}", properties)
        return key

    def named(self) -> dict[int, OpenmcMaterial]:
        """Return the materials by key; the names of those with several densities contain the density."""
        several = {n for n, _ in self.keys if sum(m == n for m, _ in self.keys) > 1}
        result = dict(self.found)
        for (number, density), key in self.keys.items():
            if number in several:
                unit = "g/cm3" if density < 0 else "atoms/b-cm"
                name = f"m{number} at {float(abs(density)):.15g} {unit}"
                result[key] = OpenmcMaterial(number, name, self.found[key].properties)
        return result
