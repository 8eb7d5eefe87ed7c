"""What an import gives: bodies, the legend of their materials, and what there is to say about it."""

from __future__ import annotations

import importlib
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from fnmatch import fnmatchcase
from itertools import islice
from typing import Any, NamedTuple

from .._util.file_errors import MAX_LISTED_PROBLEMS, printable
from .._util.hints import check_choice
from .._util.validation import check_callback, check_flag, check_integer, format_value
from ..geometry.body import Body
from ..geometry.shape import Solid
from ..materials.color import srgb_encode
from ..materials.material import Material
from ..numerics.portable_math import sin_cos
from .scene_file.nodes import shorten


@dataclass(frozen=True)
class LegendEntry:
    """A material with its colour and how many bodies have it.

    `material` is its number in the file; None where it has none, and for void, whose `color` is None too.
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
    """The parts of a scene, which `conicoid.Scene` and `conicoid.save` take, with `legend` and `notes`."""

    bodies: Sequence[Body]
    legend: tuple[LegendEntry, ...]
    notes: tuple[str, ...]
    """All that there is to say: how large it is, and the remarks."""
    remarks: tuple[str, ...] = ()
    """Those of the notes that tell what is not as the file says, or may not be meant."""
    material_names: Mapping[Material, str] = field(default_factory=dict)  # as in the legend, for scene files
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Solid | None = None
    """What bodies are to fill, where the file says that."""


def select_bodies(imported: ImportResult, pattern: str) -> ImportResult:
    """Only the bodies that a pattern names (`is_named`). Raises ValueError where it names none."""
    bodies = [body for body in imported.bodies if matches_name(pattern, body.name or "")]
    if not bodies:
        raise ValueError(f"load: only {pattern!r} names none of {format_count(len(imported.bodies), 'body')}")
    left = Counter(body.material for body in bodies)
    names = {material: name for material, name in imported.material_names.items() if material in left}
    told = f"{format_count(len(bodies), 'body')} of {len(imported.bodies):,} named by {pattern!r}"
    notes = (*imported.notes, told)
    return replace(imported, bodies=bodies, legend=(), notes=notes, material_names=names, domain=None)


def matches_name(pattern: str, name: str) -> bool:
    """Is a text in a name or, with * and ?, a pattern of all of it? Capital letters count."""
    if "*" in pattern or "?" in pattern:
        return fnmatchcase(name, pattern)
    return pattern in name


def format_count(count: int, what: str) -> str:
    """3 cells"""
    plural = what[:-1] + "ies" if what.endswith("y") else what + "s"
    return f"{count:,} {what if count == 1 else plural}"


def limit_notes(notes: Iterable[str]) -> Iterator[str]:
    """The first few of many notes of a kind, and how many more there are."""
    kept = list(islice(notes := iter(notes), MAX_LISTED_PROBLEMS))
    yield from kept
    more = sum(1 for _ in notes)
    if more:
        yield f"... and {more:,} more like this"


# What an import may be asked for, the same for every format.


class BodyLimits(NamedTuple):
    """How many bodies there may be. Those that are others moved take a seventh of the memory, and next to no time."""

    bodies: int
    alone: int  # that are no others moved

    @classmethod
    def of(cls, max_bodies: int | None) -> BodyLimits:
        """As many as a user says, of either kind; None for what fits into 2 or 3 GB."""
        return DEFAULT_BODY_LIMITS if max_bodies is None else cls(max_bodies, max_bodies)


DEFAULT_BODY_LIMITS = BodyLimits(4_000_000, 500_000)


@dataclass(frozen=True)
class ImportOptions:
    """How a file of another program is read.

    void: are parts without material invisible bodies, so that `scene.body_at` finds every one of them?
    max_bodies: what expands into more is refused, before they are made; None for 4,000,000, of which 500,000 are no
    others moved, and for molecules, whose balls are cheap, no limit.
    strict: is whatever is not read as the file says an error, in place of a remark?
    only: only volumes on whose path of names this text or pattern ("detector/*") is; None for all.
    depth: how many levels of nested volumes are opened; what lies deeper is part of the volume around it. None for all.
    smooth: are circles round where a file asks for prisms of so many sides (OpenSCAD's $fn)?
    entities: are files in its folder read that an XML file takes in by entities, as parts of GDML files?
    progress: progress(done, count) is called with numbers of bodies.
    """

    void: bool = True
    max_bodies: int | None = None
    strict: bool = False
    only: str | None = None
    depth: int | None = None
    smooth: bool = False
    entities: bool = False
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
        check_callback("load", "progress", self.progress)

    @property
    def most(self) -> BodyLimits:
        """How many bodies there may be, of formats whose bodies are not cheap."""
        return BodyLimits.of(self.max_bodies)

    @classmethod
    def of(cls, **options: Any) -> ImportOptions:
        """By name. Raises TypeError for one that there is not."""
        for name in options:
            check_choice("load", "option", name, [field.name for field in fields(cls)])
        return cls(**options)

    def refuse_others(self, what: str, *known: str) -> None:
        """ValueError for what is asked for and means nothing in a format; progress and max_bodies always do."""
        for option in fields(self):
            if option.name in (*known, "progress", "max_bodies") or getattr(self, option.name) == option.default:
                continue
            raise ValueError(f"load: {option.name} means nothing for {what}: there are {', '.join(known)}")


# The formats of other programs that Conicoid reads, each known by what is in a file, not by its name.
#
# A format is a module with `imported(path, options)`, which gives an `Imported`, and is loaded when a file of it is
# read.

DETECTION_BYTES = 1 << 16
"""Bytes of a file that are looked at to know its format."""


@dataclass(frozen=True)
class ImportFormat:
    """A format: its name in messages, its module, and whether a file is of it, by its first text and its suffix."""

    name: str
    module: str
    recognises: Callable[[str, str], bool]

    def read(self, path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
        """The parts of the scene in a file. Raises ValueError for remarks, where none are wanted (`strict`)."""
        found: ImportResult = importlib.import_module(self.module, __package__).import_file(path, options)
        if options.strict and found.remarks:
            told = "\n".join(limit_notes(found.remarks))
            raise ValueError(f"{os.fspath(path)}: is not read as it says, and strict is asked for:\n{told}")
        return found


def find_root_element(head: str) -> str | None:
    """The name of the first element of an XML text; None where it is no XML."""
    text = re.sub(r"\A\ufeff?\s*", "", head)
    if not text.startswith("<"):
        return None
    text = re.sub(r"<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^\[>]*(\[.*?\]\s*)?>", "", text, flags=re.S)
    found = re.match(r"\s*<(?:[\w.-]+:)?([\w.-]+)", text)
    return found[1] if found else ""


def _is_openmc(head: str, suffix: str) -> bool:
    root = find_root_element(head)
    return root in ("geometry", "model") or (suffix == ".xml" and root is None)  # the latter to be refused as no XML


def _is_gdml(head: str, suffix: str) -> bool:
    return find_root_element(head) == "gdml" or (suffix == ".gdml" and find_root_element(head) is not None)


def _is_molecule(head: str, suffix: str) -> bool:

    return is_molecule(head, suffix)


def _is_csg(head: str, suffix: str) -> bool:

    return is_csg(head, suffix)


def _is_zemax(head: str, suffix: str) -> bool:
    text = head.replace("\0", "")  # of UTF-16
    return suffix == ".zmx" or re.search(r"^SURF 0\s*$", text, re.M) is not None


def _is_mcnp(head: str, suffix: str) -> bool:

    return is_mcnp(head, suffix)


IMPORT_FORMATS: tuple[ImportFormat, ...] = (
    ImportFormat("OpenMC geometries", ".openmc.importer", _is_openmc),
    ImportFormat("OpenSCAD's .csg", ".openscad.importer", _is_csg),
    ImportFormat("GDML", ".gdml.importer", _is_gdml),
    ImportFormat("molecules (XYZ, PDB, mmCIF, CIF)", ".molecules.importer", _is_molecule),
    ImportFormat("Zemax lens files", "..apps.optics.zmx", _is_zemax),
    ImportFormat("MCNP decks", ".mcnp.importer", _is_mcnp),
)  # fmt: skip
"""In the order in which they are asked."""


def detect_format(path: str | os.PathLike[str]) -> ImportFormat | None:
    """The format of a file of another program; None for what is none of these, as scene files are."""
    try:
        with open(path, "rb") as file:
            head = file.read(DETECTION_BYTES)
    except OSError:
        return None  # the reader of scene files says what is the matter
    text, suffix = head.decode("utf-8", "replace"), os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in IMPORT_FORMATS if each.recognises(text, suffix)), None)


# Files of other programs as scenes: which formats there are, what may be asked of all, and what they give.


# Colours for materials: by their number alone, far apart for neighbouring numbers.
#
# Hue and lightness follow the two-dimensional sequence of Roberts ("The unreasonable effectiveness of
# quasirandom sequences", 2018), whose points keep apart however many are taken, in the perceptual
# space OKLCh (Björn Ottosson, "A perceptual color space for image processing", 2020).

_PLASTIC = 1.324717957244746  # the real root of x³ = x + 1
_CHROMA = 0.15


def palette_color(number: int) -> str:
    """The colour of the material with this number, as #rrggbb."""
    hue = 2 * math.pi * ((0.385 + number / _PLASTIC) % 1)
    lightness = 0.55 + 0.32 * ((0.5 + number / (_PLASTIC * _PLASTIC)) % 1)
    chroma = _CHROMA
    while not all(-1e-9 <= channel <= 1 + 1e-9 for channel in oklch_to_linear(lightness, chroma, hue)):
        chroma *= 0.95
    channels = srgb_encode([min(max(c, 0.0), 1.0) for c in oklch_to_linear(lightness, chroma, hue)])
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels.tolist())


def oklch_to_linear(lightness: float, chroma: float, hue: float) -> tuple[float, float, float]:
    """Linear light (Rec. 709 primaries) of OKLCh, hue in radians; outside of [0, 1] where no screen can show it."""
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


# Whether a file is an MCNP deck: by its suffix, or by a cell card after its title.

MCNP_SUFFIXES = (".mcnp", ".mcn", ".imcnp", ".inp", ".i")
_MCNP_CELL = re.compile(
    r" {0,4}[0-9]+ +(?:0 +|[1-9][0-9]* +[-+]?[0-9]*\.?[0-9]+(?:[ed]?[-+]?[0-9]+)? +|like +)[-+#(0-9]", re.I
)
_OTHER_SUFFIXES = (".yaml", ".yml", ".json", ".csv", ".xyz", ".pdb", ".cif")


def is_mcnp(head: str, suffix: str) -> bool:
    """By the first text of a file and its suffix."""
    if suffix in MCNP_SUFFIXES:
        return not head.lstrip("\ufeff \t\r\n").startswith("<")
    if suffix in _OTHER_SUFFIXES or "\0" in head:
        return False
    lines = head.replace("\r\n", "\n").expandtabs(8).split("\n")
    if lines[0].lower().startswith("message:"):
        lines = lines[next((n + 1 for n, line in enumerate(lines) if not line.strip()), len(lines)) :]
    for line in lines[1:]:
        if re.match(r" {0,4}c( |$)", line, re.I) is None:
            return _MCNP_CELL.match(line) is not None
    return False


# What files of molecules are known by, before anything that reads them is loaded.

_CIF_DATA = re.compile(r"\A(\s*(#[^\n]*)?\n)*\s*data_\S*", re.I)
_PDB_RECORDS = re.compile(r"^(ATOM  |HETATM)[ \d]{5}.{19}[ \d.+-]{24}", re.M)
_XYZ_HEAD = re.compile(r"\A\s*\d+[ \t]*\r?\n[^\n]*(\n\s*([A-Za-z]{1,3}|\d{1,3})(\s+[-+.\d][^\s]*){3})")


def is_cif(head: str, suffix: str) -> bool:
    """Is a text a CIF or mmCIF, by its first block?"""
    return _CIF_DATA.match(head.removeprefix("\ufeff")) is not None


def is_pdb(head: str, suffix: str) -> bool:
    """Is a text a PDB: has it a line of an atom, or the first lines of a long header?"""
    return _PDB_RECORDS.search(head) is not None or (
        head.startswith("HEADER    ") and re.search(r"^(TITLE|COMPND|REMARK)", head, re.M) is not None
    )


def is_xyz(head: str, suffix: str) -> bool:
    """Is a text an XYZ, by its first three lines?"""
    return suffix == ".xyz" or _XYZ_HEAD.match(head) is not None


def is_molecule(head: str, suffix: str) -> bool:
    """Is a text one of these, by its beginning?"""
    return any(recognises(head, suffix) for recognises in (is_cif, is_pdb, is_xyz))


# Whether a file is OpenSCAD's: by its suffix, or by its first call.

_CSG_CALLS = "group|multmatrix|union|difference|intersection|color|cube|sphere|cylinder|polyhedron|linear_extrude|"
_CSG_CALLS += "rotate_extrude|hull|minkowski|render"
_CSG_FIRST_CALL = re.compile(rf"\A\ufeff?(\s|//[^\n]*\n|/\*.*?\*/)*[%#!*]?({_CSG_CALLS})\s*\(", re.S)


def is_csg(head: str, suffix: str) -> bool:
    """Is a text one, by its first call, or by the name of the file?"""
    return suffix in (".csg", ".scad") or _CSG_FIRST_CALL.match(head) is not None
