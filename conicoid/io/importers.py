"""Import of other programs' files: results, options, formats and their detection, and palette colours.

Every format is a module with `import_file(path, options)`, which returns an `ImportResult`; the module is loaded when a
file of the format is read. `detect_format` recognises a format by the contents of a file, not by its name alone.
"""

from __future__ import annotations

import importlib
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, fields, replace
from fnmatch import fnmatchcase
from functools import cache
from itertools import islice
from typing import Any, NamedTuple

from .._util.files import MAX_LISTED_PROBLEMS, open_regular, printable
from .._util.records import dataclass
from .._util.text import check_choice, format_count
from .._util.validation import check_callback, check_flag, check_integer, check_path, format_value
from ..geometry.body import Body
from ..geometry.shape import Solid
from ..materials.color import srgb_encode
from ..materials.material import Material
from ..numerics.portable_math import sin_cos
from .scene_file.nodes import shorten


@dataclass(frozen=True)
class LegendEntry:
    """A material with its colour and the number of bodies that have it.

    `material` is its number in the file; None for a material without a number and for void, whose `color` is None too.
    """

    material: int | None
    name: str
    color: str | None
    bodies: int

    def __str__(self) -> str:
        number = f"material {self.material}" if self.material is not None else "void" if self.color is None else ""
        name = printable(shorten(self.name))
        bodies = "body  " if self.bodies == 1 else "bodies"
        return f"{self.color or 'invisible':<9}  {number:<14} {self.bodies:>9,} {bodies}  {name}".rstrip()


@dataclass(frozen=True)
class ImportResult:
    """The parts of a scene, as `conicoid.Scene` and `conicoid.save` take them, with `legend` and `notes`."""

    bodies: Sequence[Body]
    legend: tuple[LegendEntry, ...]
    notes: tuple[str, ...]
    """All notes for the user: sizes and remarks."""
    remarks: tuple[str, ...] = ()
    """Notes about parts that differ from the file, or that the file may not intend."""
    material_names: Mapping[Material, str] = field(default_factory=dict)  # names of the legend, for scene files
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Solid | None = None
    """The region that bodies must fill, if the file defines one."""
    unit: str | None = None
    """The unit of lengths, as for `Scene`."""


def select_bodies(imported: ImportResult, pattern: str) -> ImportResult:
    """Return the import with only the bodies that a pattern names (`matches_name`).

    The selection has no legend and no domain. Raise ValueError if the pattern names no body.
    """
    bodies = [body for body in imported.bodies if matches_name(pattern, body.name or "")]
    if not bodies:
        raise ValueError(f"load: only {pattern!r} names none of {format_count(len(imported.bodies), 'body')}")
    left = Counter(body.material for body in bodies)
    names = {material: name for material, name in imported.material_names.items() if material in left}
    note = f"{format_count(len(bodies), 'body')} of {len(imported.bodies):,} named by {pattern!r}"
    notes = (*imported.notes, note)
    return replace(imported, bodies=bodies, legend=(), notes=notes, material_names=names, domain=None)


def matches_name(pattern: str, name: str) -> bool:
    """Return True if a name contains the text or, with * or ?, matches it as a whole; case matters."""
    if "*" in pattern or "?" in pattern:
        return fnmatchcase(name, pattern)
    return pattern in name


def limit_notes(notes: Iterable[str]) -> Iterator[str]:
    """Yield the first `MAX_LISTED_PROBLEMS` notes of a kind, then one line with the number of further notes."""
    first = list(islice(notes := iter(notes), MAX_LISTED_PROBLEMS))
    yield from first
    more = sum(1 for _ in notes)
    if more:
        yield f"... and {more:,} more like this"


class OmittedPart(Exception):
    """Raised for a part of a file that is valid and left out, as no quadric bounds it, or as it encloses nothing.

    The message says why, as the rest of a sentence that begins with the name of the part. The reader catches it, makes
    a remark and reads on.
    """


# Options, the same for every format


class BodyLimits(NamedTuple):
    """Most bodies of an import. Translated copies take a seventh of the memory of others, and next to no time."""

    bodies: int
    singles: int  # bodies that are no translated copies

    @classmethod
    def of(cls, max_bodies: int | None) -> BodyLimits:
        """Return the limits for the option `max_bodies`, the same for both kinds; None for what fits into 2 or 3 GB."""
        return DEFAULT_BODY_LIMITS if max_bodies is None else cls(max_bodies, max_bodies)


DEFAULT_BODY_LIMITS = BodyLimits(4_000_000, 500_000)


@dataclass(frozen=True)
class ImportOptions:
    """Options for reading a file of another program.

    Parameters
    ----------
    void
        Whether parts without a material become invisible bodies, so that `scene.body_at` finds each of them.
    max_bodies
        Most bodies; a file that expands into more is refused before they are built. None allows 4,000,000 bodies, of
        them 500,000 that are no translated copies, and any number of atoms of molecules, which are cheap.
    strict
        Whether anything that is read differently from the file is an error instead of a remark.
    only
        Text or pattern ("detector/*"): import only volumes whose path of names contains or matches it; None for all.
    depth
        Number of levels of nested volumes that are opened; deeper volumes are part of the volume around them. None for
        all levels.
    smooth
        Whether circles stay round if the file requests prisms of a number of sides (OpenSCAD's $fn).
    entities
        Whether to read files that an XML file includes by entities, such as parts of GDML files.
    root
        The folder within which a file may name others (modules of GDML, READ of MCNP); nothing outside of it is opened.
        None is the folder of the file.
    glasses
        Media by name, or the path of a catalogue of glasses (.agf), for lens files.
    progress
        Called as progress(done, count) with numbers of bodies.

    Raises
    ------
    TypeError, ValueError
        An option has a wrong type or value.

    """

    void: bool = True
    max_bodies: int | None = None
    strict: bool = False
    only: str | None = None
    depth: int | None = None
    smooth: bool = False
    entities: bool = False
    root: str | os.PathLike[str] | None = None
    glasses: Mapping[str, Any] | str | os.PathLike[str] | None = None
    progress: Callable[[int, int], Any] | None = None

    def __post_init__(self) -> None:
        for name in ("void", "strict", "smooth", "entities"):
            check_flag("load", name, getattr(self, name))
        if self.max_bodies is not None:
            check_integer("load", "max_bodies", self.max_bodies, 1)
        if self.depth is not None:
            check_integer("load", "depth", self.depth, 0)
        if self.only is not None and (not isinstance(self.only, str) or not self.only):
            raise ValueError(f"load: only must be a pattern of names or None, got {format_value(self.only)}")
        if self.root is not None and not os.path.isdir(check_path("load", self.root, "root")):
            raise ValueError(f"load: root must be a folder, got {format_value(os.fspath(self.root))}")
        check_callback("load", "progress", self.progress)

    @property
    def most(self) -> BodyLimits:
        """Most bodies, for formats whose bodies are not cheap."""
        return BodyLimits.of(self.max_bodies)

    @classmethod
    def of(cls, **options: Any) -> ImportOptions:
        """Return options by name. Raise TypeError for an unknown name."""
        for name in options:
            check_choice("load", "option", name, [field.name for field in fields(cls)])
        return cls(**options)

    def refuse_others(self, what: str, *known: str) -> None:
        """Raise ValueError for an option that is set but does not apply to a format.

        Parameters
        ----------
        what
            The format, for the message.
        *known
            Options that apply; progress and max_bodies always do.

        """
        for option in fields(self):
            if option.name in (*known, "progress", "max_bodies") or getattr(self, option.name) == option.default:
                continue
            raise ValueError(f"load: {option.name} means nothing for {what}: there are {', '.join(known)}")


# Formats and their detection

DETECTION_BYTES = 1 << 16
"""Bytes at the start of a file that detection reads."""


@dataclass(frozen=True)
class ImportFormat:
    """A format: its name in messages, its module, and a test of the first text of a file and its suffix."""

    name: str
    module: str
    recognises: Callable[[str, str], bool]

    def read(self, path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
        """Import a file.

        Parameters
        ----------
        path
            The file.
        options
            Options of the import.

        Returns
        -------
        ImportResult
            The parts of the scene in the file.

        Raises
        ------
        SceneFileError
            The file has errors.
        ValueError
            An option does not apply to the format, or the option `strict` is set and the file gives remarks.

        """
        result: ImportResult = importlib.import_module(self.module, __package__).import_file(path, options)
        if options.strict and result.remarks:
            remarks = "\n".join(limit_notes(result.remarks))
            raise ValueError(f"{os.fspath(path)}: is not read exactly as written, and strict is set:\n{remarks}")
        return result


# Patterns of detection are linear in the length of hostile text, as their repetitions are possessive
_XML_PROLOG = re.compile(r"\s*+(?:<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^\[>]*+(?:\[.*?\]\s*+)?>)", re.S)
_XML_NAME = re.compile(r"\s*+<(?:[\w.-]++:)?([\w.-]++)")


def find_root_element(head: str) -> str | None:
    """Return the name of the first element of an XML text, "" if none has begun yet; None for other texts."""
    text = head.lstrip()
    if not text.startswith("<"):
        return None
    position = 0
    while match := _XML_PROLOG.match(text, position):
        position = match.end()
    match = _XML_NAME.match(text, position)
    return match[1] if match else ""


def _is_openmc(head: str, suffix: str) -> bool:
    root = find_root_element(head)
    # A file .xml that is no XML goes to OpenMC's reader, which refuses it with that reason.
    return root in ("geometry", "model") or (suffix == ".xml" and root is None)


def _is_gdml(head: str, suffix: str) -> bool:
    return find_root_element(head) == "gdml" or (suffix == ".gdml" and find_root_element(head) is not None)


def _is_zemax(head: str, suffix: str) -> bool:
    text = head.replace("\0", "")  # UTF-16 has a zero byte in each of these characters
    return suffix == ".zmx" or re.search(r"(?:\A|[\r\n])SURF 0[^\S\r\n]*+(?:[\r\n]|\Z)", text) is not None


def detect_format(path: str | os.PathLike[str]) -> ImportFormat | None:
    """Return the format of another program's file; None for other files, such as scene files and unreadable files."""
    try:
        with open_regular(path) as file:
            head = file.read(DETECTION_BYTES)
    except (OSError, ValueError):  # ValueError: a name that no file can have
        return None  # the reader of scene files reports the error
    text, suffix = head.decode("utf-8-sig", "replace"), os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in IMPORT_FORMATS if each.recognises(text, suffix)), None)


# Palette colours: a colour depends on the number of a material alone, and neighbouring numbers have distant colours.
#
# Hue and lightness follow the two-dimensional sequence of Roberts ("The unreasonable effectiveness of
# quasirandom sequences", 2018), whose points keep apart however many are taken, in the perceptual
# space OKLCh (Björn Ottosson, "A perceptual color space for image processing", 2020).

_PLASTIC = 1.324717957244746  # the real root of x³ = x + 1
_CHROMA = 0.15


@cache
def palette_color(number: int) -> str:
    """Return the colour of the material with a number, as #rrggbb."""
    hue = 2 * math.pi * ((0.385 + number / _PLASTIC) % 1)
    lightness = 0.55 + 0.32 * ((0.5 + number / (_PLASTIC * _PLASTIC)) % 1)
    chroma = _CHROMA
    # Less chroma until a screen can show the colour.
    while not all(-1e-9 <= channel <= 1 + 1e-9 for channel in oklch_to_linear(lightness, chroma, hue)):
        chroma *= 0.95
    channels = srgb_encode([min(max(c, 0.0), 1.0) for c in oklch_to_linear(lightness, chroma, hue)])
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels.tolist())


def oklch_to_linear(lightness: float, chroma: float, hue: float) -> tuple[float, float, float]:
    """Return linear red, green and blue (Rec. 709 primaries) of a colour in OKLCh.

    The hue is in radians. Channels lie outside [0, 1] for colours that no screen can show.
    Source: Björn Ottosson, "A perceptual color space for image processing", 2020.
    """
    s, c = sin_cos(hue)
    a, b = chroma * c, chroma * s
    long = _cube(lightness + 0.3963377774 * a + 0.2158037573 * b)
    medium = _cube(lightness - 0.1055613458 * a - 0.0638541728 * b)
    short = _cube(lightness - 0.0894841775 * a - 1.2914855480 * b)
    return (
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    )


def _cube(x: float) -> float:
    return x * x * x


# Detection of MCNP decks: by suffix, or by a cell card or a READ card after the title

MCNP_SUFFIXES = (".mcnp", ".mcn", ".imcnp", ".inp", ".i")
_MCNP_CARD = re.compile(
    r" {0,4}[0-9]++ ++(?:0 ++|[1-9][0-9]*+ ++[-+]?(?:[0-9]++(?:\.[0-9]++)?|\.[0-9]++)(?:(?:[ed][-+]?|[-+])[0-9]++)? ++"
    r"|like ++)[-+#(0-9]"
    r"| {0,4}read ++(?:(?:no)?echo ++)?file(?: ++| *+= *+)[^ =]",
    re.I,
)
_OTHER_SUFFIXES = (".yaml", ".yml", ".json", ".csv", ".xyz", ".pdb", ".cif")


def is_mcnp(head: str, suffix: str) -> bool:
    """Return True for an MCNP deck, by the first text of a file and its suffix."""
    if suffix in MCNP_SUFFIXES:  # XML is no deck, whatever its suffix
        return not head.lstrip(" \t\r\n").startswith("<")
    if suffix in _OTHER_SUFFIXES or "\0" in head:
        return False
    lines = head.replace("\r\n", "\n").expandtabs(8).split("\n")
    if lines[0].lower().startswith("message:"):
        lines = lines[next((n + 1 for n, line in enumerate(lines) if not line.strip()), len(lines)) :]
    for line in lines[1:]:
        if re.match(r" {0,4}c( |$)", line, re.I) is None:
            return _MCNP_CARD.match(line) is not None
    return False


# Detection of molecules, here so that it does not load their readers

_CIF_DATA = re.compile(r"\A(?:\s++|#[^\n]*+)*+data_", re.I)
_PDB_RECORDS = re.compile(r"^(ATOM  |HETATM)[ \dA-Za-z*]{5}.{19}[ \d.+-]{24}", re.M)
_XYZ_HEAD = re.compile(r"\A\s*+\d++[ \t]*+\r?\n[^\n]*+\n\s*+(?:[A-Za-z]{1,3}|\d{1,3})(?:\s++[-+.\d]\S*+){3}")


def is_cif(head: str, suffix: str) -> bool:
    """Return True for a CIF or mmCIF, by its first data block."""
    return _CIF_DATA.match(head) is not None


def is_pdb(head: str, suffix: str) -> bool:
    """Return True for a PDB: it has a record of an atom, or the first records of a long header."""
    return _PDB_RECORDS.search(head) is not None or (
        head.startswith("HEADER    ") and re.search(r"^(TITLE|COMPND|REMARK)", head, re.M) is not None
    )


def is_xyz(head: str, suffix: str) -> bool:
    """Return True for an XYZ, by its suffix or its first three lines."""
    return suffix == ".xyz" or _XYZ_HEAD.match(head) is not None


def is_molecule(head: str, suffix: str) -> bool:
    """Return True for a file of a molecule in any of these formats."""
    return any(recognises(head, suffix) for recognises in (is_cif, is_pdb, is_xyz))


# Detection of OpenSCAD's .csg: by suffix, or by the first call

_CSG_CALLS = "group|multmatrix|union|difference|intersection|color|cube|sphere|cylinder|polyhedron|linear_extrude|"
_CSG_CALLS += "rotate_extrude|hull|minkowski|render"
_CSG_FIRST_CALL = re.compile(rf"\A(?:\s++|//[^\n]*+\n|(?>/\*.*?\*/))*+[%#!*]?(?:{_CSG_CALLS})\s*+\(", re.S)


def is_csg(head: str, suffix: str) -> bool:
    """Return True for a file of OpenSCAD, by its suffix or its first call."""
    return suffix in (".csg", ".scad") or _CSG_FIRST_CALL.match(head) is not None


IMPORT_FORMATS: tuple[ImportFormat, ...] = (
    ImportFormat("OpenMC geometries", ".openmc.importer", _is_openmc),
    ImportFormat("OpenSCAD's .csg", ".openscad.importer", is_csg),
    ImportFormat("GDML", ".gdml.importer", _is_gdml),
    ImportFormat("molecules (XYZ, PDB, mmCIF, CIF)", ".molecules.importer", is_molecule),
    ImportFormat("Zemax lens files", "..apps.optics.zmx", _is_zemax),
    ImportFormat("MCNP decks", ".mcnp.importer", is_mcnp),
)  # fmt: skip
"""In the order in which detection tries them."""
