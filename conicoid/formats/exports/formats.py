"""The formats of other programs that Conicoid writes, each known by the suffix of the file.

A format is a module with `exported(bodies, options)`, which gives an `Exported`, and is loaded when a file of it is
written.
"""

from __future__ import annotations

import importlib
import os
from dataclasses import dataclass

from ..atomic import write_text
from ..imports.imported import first_few
from ..scene_file import SceneLike
from .exported import Exported, Options


@dataclass(frozen=True)
class Format:
    """A format: its name in messages, its suffixes, and its module."""

    name: str
    suffixes: tuple[str, ...]
    module: str

    def write(self, scene: SceneLike, path: str | os.PathLike[str], options: Options) -> Exported:
        """Write a file, whole or not at all.

        Raises ValueError that names the bodies which the format cannot say, or for remarks where none are wanted
        (`strict`); OSError where the file cannot be written.
        """
        found: Exported = importlib.import_module(self.module, __package__).exported(scene, options)
        if options.strict and found.remarks:
            told = "\n".join(first_few(found.remarks))
            raise ValueError(f"{os.fspath(path)}: would not say all of the scene, and strict is asked for:\n{told}")
        write_text(path, found.text)
        return found


FORMATS: tuple[Format, ...] = (
    Format("GDML", (".gdml",), ".gdml.written"),
    Format("OpenSCAD", (".scad", ".csg"), ".scad.written"),
    Format("OpenMC", (".xml",), ".openmc.written"),
)


def format_for(path: str | os.PathLike[str]) -> Format | None:
    """The format that a file is to have, by its suffix; None for any other."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in FORMATS if suffix in each.suffixes), None)
