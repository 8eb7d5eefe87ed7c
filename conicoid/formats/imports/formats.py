"""The formats of other programs that Conicoid reads, each known by what is in a file, not by its name.

A format is a module with `imported(path, options)`, which gives an `Imported`, and is loaded when a file of it is read.
"""

from __future__ import annotations

import importlib
import os
import re
from collections.abc import Callable
from dataclasses import dataclass

from .imported import Imported, first_few
from .options import Options

HEAD = 1 << 16
"""Bytes of a file that are looked at to know its format."""


@dataclass(frozen=True)
class Format:
    """A format: its name in messages, its module, and whether a file is of it, by its first text and its suffix."""

    name: str
    module: str
    recognises: Callable[[str, str], bool]

    def read(self, path: str | os.PathLike[str], options: Options) -> Imported:
        """The parts of the scene in a file. Raises ValueError for remarks, where none are wanted (`strict`)."""
        found: Imported = importlib.import_module(self.module, __package__).imported(path, options)
        if options.strict and found.remarks:
            told = "\n".join(first_few(found.remarks))
            raise ValueError(f"{os.fspath(path)}: is not read as it says, and strict is asked for:\n{told}")
        return found


def root_element(head: str) -> str | None:
    """The name of the first element of an XML text; None where it is no XML."""
    text = re.sub(r"\A\ufeff?\s*", "", head)
    if not text.startswith("<"):
        return None
    text = re.sub(r"<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^\[>]*(\[.*?\]\s*)?>", "", text, flags=re.S)
    found = re.match(r"\s*<(?:[\w.-]+:)?([\w.-]+)", text)
    return found[1] if found else ""


def _is_openmc(head: str, suffix: str) -> bool:
    root = root_element(head)
    return root in ("geometry", "model") or (suffix == ".xml" and root is None)  # the latter to be refused as no XML


def _is_gdml(head: str, suffix: str) -> bool:
    return root_element(head) == "gdml" or (suffix == ".gdml" and root_element(head) is not None)


def _is_molecule(head: str, suffix: str) -> bool:
    from ..molecules.detection import is_molecule

    return is_molecule(head, suffix)


def _is_csg(head: str, suffix: str) -> bool:
    from ..scad.detection import is_csg

    return is_csg(head, suffix)


def _is_zemax(head: str, suffix: str) -> bool:
    text = head.replace("\0", "")  # of UTF-16
    return suffix == ".zmx" or re.search(r"^SURF 0\s*$", text, re.M) is not None


def _is_mcnp(head: str, suffix: str) -> bool:
    from ..mcnp.detection import is_mcnp

    return is_mcnp(head, suffix)


FORMATS: tuple[Format, ...] = (
    Format("OpenMC geometries", "..openmc.imported", _is_openmc),
    Format("OpenSCAD's .csg", "..scad.imported", _is_csg),
    Format("GDML", "..gdml.imported", _is_gdml),
    Format("molecules (XYZ, PDB, mmCIF, CIF)", "..molecules.imported", _is_molecule),
    Format("Zemax lens files", "...optics.zmx_import", _is_zemax),
    Format("MCNP decks", "..mcnp.imported", _is_mcnp),
)  # fmt: skip
"""In the order in which they are asked."""


def format_of(path: str | os.PathLike[str]) -> Format | None:
    """The format of a file of another program; None for what is none of these, as scene files are."""
    try:
        with open(path, "rb") as file:
            head = file.read(HEAD)
    except OSError:
        return None  # the reader of scene files says what is the matter
    text, suffix = head.decode("utf-8", "replace"), os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in FORMATS if each.recognises(text, suffix)), None)
