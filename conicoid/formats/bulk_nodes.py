"""Many bodies of one kind in a scene file: arrays written out, or those of a .npy, .npz or .csv file beside it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..shapes.bulk import Bulk
from .data_files import MAX_BYTES, beside, read_array, read_rows
from .kinds import Fixed, Integer, Kind, Number, OneOf, Schema, Several, Text
from .nodes import Node, Table, shortened
from .npy import NotPlain
from .npz import Archive
from .reading import BAD, Bad, Reader
from .regular import open_regular

INDEX: Schema = {
    "description": "Of many bodies in one entry, the place of each one's material among the materials.",
    "anyOf": [
        Several(Integer()).schema(),
        {
            "type": "object",
            "properties": {"file": {"type": "string", "description": "A .npy file of integers beside the scene."}},
            "required": ["file"],
            "additionalProperties": False,
        },
    ],
}


def array_kind(cls: type[Bulk], field: str) -> Kind:
    """What stands for a field: an array, or what is the same for all bodies."""
    width = len(cls.columns[field])
    one: Kind = Number() if width == 1 else Fixed(Number(), width)
    return OneOf((one, Several(one)))


def read_many(cls: type[Bulk], value: Node, reader: Reader, where: str) -> Any:
    """The shape at a node, or BAD after a report."""
    fields = tuple(cls.columns)
    entries = reader.entries(value, where, (*fields, "file"))
    if isinstance(entries, Bad):
        return BAD
    if set(entries) not in (set(fields), {"file"}):
        told = f"{', '.join(fields[:-1])} and {fields[-1]}"
        return reader.report(value, where, f"either {told}, or file, must be given")
    if "file" in entries:
        return _read_file(cls, entries["file"], reader, f"{where}: file")
    found = {name: _read_array(cls, name, entries[name], reader, f"{where}: {name}") for name in fields}
    if any(each is BAD for each in found.values()):
        return BAD
    return reader.made(value, where, lambda: cls(**found))


def _read_array(cls: type[Bulk], field: str, node: Node, reader: Reader, where: str) -> Any:
    """Several are told from one by what they hold: a vector for all holds numbers."""
    width = len(cls.columns[field])
    if width == 1:
        return array_kind(cls, field).read(node, reader, where)
    one = Fixed(Number(), width)
    items = getattr(node, "items", ())
    if len(items) and all(Number().fits(item) for item in items):
        return one.read(node, reader, where)
    found = Several(one).read(node, reader, where)
    return BAD if found is BAD else np.array(found, np.float64).reshape(len(found), width)


def _read_file(cls: type[Bulk], node: Node, reader: Reader, where: str) -> Any:
    name = Text().read(node, reader, where)
    if name is BAD:
        return BAD

    def load() -> Bulk:
        path = _read(name, lambda: _found(beside(reader.folder, name), name))
        if path.suffix.lower() == ".npz":
            return cls(**_arrays(path, tuple(cls.columns)))
        headings = cls.headings()
        table, lines = _read(name, lambda: read_rows(path, len(headings), headings))
        try:
            made: Bulk = cls.of_table(table)
        except ValueError as error:
            raise ValueError(_in_line(str(error), shortened(name), lines)) from None
        return made

    return reader.made(node, where, load)


def read_index(node: Node, reader: Reader, where: str) -> Any:
    """The places of materials: integers written out, or in a .npy file."""
    if not isinstance(node, Table):
        return Several(Integer()).read(node, reader, where)
    entries = reader.entries(node, where, ("file",), ("file",))
    name: Any = BAD
    if not isinstance(entries, Bad) and "file" in entries:
        name = Text().read(entries["file"], reader, where)
    if name is BAD:
        return BAD

    def load() -> Any:
        path = _read(name, lambda: _found(beside(reader.folder, name), name))
        found, values = _read(name, lambda: read_array(path))
        if values is None or values.ndim != 1 or not (np.isfinite(values) & (values == np.floor(values))).all():
            raise ValueError(f"{path.name} must hold integers of shape (N,), got {found}")
        return values.astype(np.int64)

    return reader.made(node, where, load)


def _found(path: Path, name: str) -> Path:
    if path.suffix.lower() in (".npy", ".npz") and path.stat().st_size > MAX_BYTES:
        raise ValueError(f"{shortened(name)} is larger than {MAX_BYTES >> 30} GiB")
    return path


def _read(name: str, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except OSError as error:
        raise ValueError(f"{shortened(name)!r} cannot be read: {(error.strerror or str(error)).lower()}") from None


def _arrays(path: Path, fields: Sequence[str]) -> dict[str, Any]:
    """The arrays of a .npz file; a ValueError where one is missing."""

    def read() -> dict[str, Any]:
        with open_regular(path) as file:
            try:
                archive = Archive(file, os.fstat(file.fileno()).st_size)
            except NotPlain as error:
                raise ValueError(f"{path.name} is not a .npz file ({error})") from None
            missing = [name for name in fields if name not in archive.members]
            if missing:
                raise ValueError(f"{path.name} must hold the arrays {', '.join(fields)}; {missing[0]} is missing")
            try:
                return dict(archive.arrays(fields))
            except ValueError as error:
                raise ValueError(f"{path.name}: {error}") from None

    found: dict[str, Any] = _read(path.name, read)
    return found


def _in_line(message: str, name: str, lines: Sequence[int]) -> str:
    """A message about one of the bodies of a file with the line it stands in, where the file has lines."""
    row = re.search(r"\[(\d+)\]", message)
    if row is None or not int(row[1]) < len(lines):
        return message
    owner, _, rest = message.partition(": ")
    return f"{owner}: {name}:{lines[int(row[1])]}: {rest}"
