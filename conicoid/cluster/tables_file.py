"""Prepared scenes in files that processes map into memory: opened in no time, and held once for all of a machine.

A file has a head (JSON), pickles, and the numbers of all tables, each of which begins where it did in a line of
memory. What is mapped is private: whoever wrote into it would write into a copy. The bodies themselves, as they were
said, are a pickle of their own that is read when somebody asks for them, as few questions do.

Pickles are read only where their hash is the one that the head says, and the head's is the one that a task says.
"""

from __future__ import annotations

import io
import json
import mmap
import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.lowering.contents import ShapesOf
from ..engine.lowering.edited.kept import Kept
from ..engine.prepared import Prepared
from ..formats.atomic import replacing
from ..shapes.labels import Labels
from ..shapes.repeated import Repeated
from ..shapes.spheres import Spheres

_MAGIC = b"conicoid tables 1\n"
_LINE = 64  # bytes of a line of memory
_BODIES, _SHAPES = "bodies", "shapes"
_TABLES, _LABELS, _REST = "tables", "labels", "rest"


def can_be_kept(prepared: Prepared) -> bool:
    """Are the tables all that was worked out? Of balls that a motion has stretched, and of lattices, they are not."""
    return not isinstance(prepared.entries, Repeated) and not any(
        isinstance(body.shape, Spheres) and "balls" in body.shape.kept for body in prepared.entries
    )


def write_tables(path: str | os.PathLike[str], edition: str, prepared: Prepared, rest: Any, bodies: bytes) -> bytes:
    """Write a file of tables, whole or not at all; returns the hash of its head.

    rest: what a scene is beyond its bodies. bodies: the pickle of a scene that has them. Raises OSError where there is
    no room.
    """
    plain = replace(prepared, kept=Kept(), forms={}, lowered=replace(prepared.lowered, laid=None))
    vars(plain)["key"] = prepared.key
    buffers: list[pickle.PickleBuffer] = []
    pickles = {
        _TABLES: _pickled(plain, prepared, buffers.append),
        _LABELS: pickle.dumps(prepared.labels, protocol=5),
        _REST: pickle.dumps(rest, protocol=5),
        _BODIES: bodies,
    }
    with replacing(path) as partial, open(partial, "r+b") as file:
        return _written(file, edition, pickles, [np.frombuffer(buffer.raw(), np.uint8) for buffer in buffers])


class _Pickler(pickle.Pickler):
    """Leaves the bodies and their shapes out, which are read later."""

    def __init__(self, file: Any, prepared: Prepared, take: Callable[[pickle.PickleBuffer], Any]) -> None:
        super().__init__(file, protocol=5, buffer_callback=take)
        self._left_out = {id(prepared.entries): _BODIES, id(prepared.lowered.exact.bodies._shapes): _SHAPES}

    def persistent_id(self, thing: Any) -> str | None:
        return self._left_out.get(id(thing))


def _pickled(thing: Any, prepared: Prepared, take: Callable[[pickle.PickleBuffer], Any]) -> bytes:
    file = io.BytesIO()
    _Pickler(file, prepared, take).dump(thing)
    return file.getvalue()


def _written(file: Any, edition: str, pickles: dict[str, bytes], buffers: list[Any]) -> bytes:
    """The head's length and itself, pickles, and the memory of the buffers, what is in several of them once."""
    regions, places = _regions(buffers)
    at = 0
    sections: dict[str, tuple[int, int, str]] = {}
    for name, data in pickles.items():
        sections[name] = at, len(data), _hash(data).hex()
        at += len(data)
    starts = []
    for address, count in regions:
        at += (address - at) % _LINE
        starts.append(at)
        at += count
    where = [[starts[region] + offset if region >= 0 else 0, count] for region, offset, count in places]
    head = json.dumps(dict(edition=edition, sections=sections, buffers=where, size=at)).encode()
    file.write(_MAGIC + len(head).to_bytes(8, "little") + head)
    first = _first(head)
    for name, data in pickles.items():
        file.seek(first + sections[name][0])
        file.write(data)
    own = {(buffer.ctypes.data, buffer.nbytes): buffer for buffer in buffers}
    for region, start in zip(regions, starts, strict=True):
        file.seek(first + start)
        file.write(own[region].data)
    file.truncate(first + at)
    return _hash(head)


def _regions(buffers: list[Any]) -> tuple[list[tuple[int, int]], list[tuple[int, int, int]]]:
    """([address, bytes] of memory, and for each buffer which of these, how far in it, and its bytes)."""
    spans = [(buffer.ctypes.data, buffer.nbytes) for buffer in buffers]
    regions: list[tuple[int, int]] = []
    for address, count in sorted((span for span in spans if span[1]), key=lambda span: (span[0], -span[1])):
        if not regions or address + count > sum(regions[-1]):
            regions.append((address, count))
    begins = np.array([address for address, _ in regions], np.int64)
    which = [int(np.searchsorted(begins, address, side="right")) - 1 if count else -1 for address, count in spans]
    return regions, [
        (k, address - regions[k][0] if k >= 0 else 0, count) for k, (address, count) in zip(which, spans, strict=True)
    ]


def _first(head: bytes) -> int:
    """Where in the file the sections begin: at a line."""
    at = len(_MAGIC) + 8 + len(head)
    return at + -at % _LINE


class Replaced(OSError):
    """Another file has taken the place of one of tables, as where two programs write the same at the same time."""


class TablesFile:
    """A file of tables that is mapped. Raises ValueError for what is none, and for one of another edition; OSError.

    digest: the hash of its head, without which it is not read; None where whoever opens it trusts the folder.
    """

    def __init__(self, path: str | os.PathLike[str], edition: str, digest: bytes | None = None) -> None:
        self.path = Path(path)
        with open(path, "rb") as file:
            start = file.read(len(_MAGIC) + 8)
            length = int.from_bytes(start[len(_MAGIC) :], "little")
            size = os.fstat(file.fileno()).st_size
            if start[: len(_MAGIC)] != _MAGIC or len(start) < len(_MAGIC) + 8 or length > size:
                raise ValueError(f"{self.path}: is not a file of tables")
            head = file.read(length)
            if digest is not None and _hash(head) != digest:
                raise Replaced(f"{self.path}: is not the file of tables that it was")
            told = json.loads(head)
            if told["edition"] != edition:
                raise ValueError(f"{self.path}: holds tables of conicoid {told['edition']}; this process has {edition}")
            self._first, self._told, self.digest = _first(head), told, _hash(head)
            if size != self._first + told["size"]:
                raise ValueError(f"{self.path}: holds {size:,} bytes of {self._first + told['size']:,}")
            self._memory = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY))

    def section(self, name: str) -> Any:
        """What one of the pickles holds."""
        return pickle.loads(self._data(name))

    def prepared(self, bodies: Sequence[Any]) -> Prepared:
        """The prepared scene, whose tables are those of the file; its bodies are as given."""
        buffers = [self._memory[self._first + at : self._first + at + count] for at, count in self._told["buffers"]]
        reader = _Unpickler(io.BytesIO(self._data(_TABLES)), bodies, buffers)
        made = object.__new__(_Opened)
        vars(made).update(vars(reader.load()), _file=self)
        return made

    def _data(self, name: str) -> memoryview:
        at, count, digest = self._told["sections"][name]
        data = self._memory[self._first + at : self._first + at + count]
        if _hash(data).hex() != digest:
            raise ValueError(f"{self.path}: is damaged")
        return data


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: Any, bodies: Sequence[Any], buffers: list[memoryview]) -> None:
        super().__init__(file, buffers=buffers)
        self._bodies = bodies

    def persistent_load(self, name: str) -> Any:
        return self._bodies if name == _BODIES else ShapesOf(self._bodies)


class _Opened(Prepared):
    """A prepared scene out of a file; its labels are read when they are asked for."""

    @cached_property
    def labels(self) -> Labels:
        labels: Labels = vars(self)["_file"].section(_LABELS)
        return labels

    can_be_edited = False
    """What edits need beyond the tables is not in the file: others are prepared from the beginning."""


class LaterBodies(Sequence[Any]):
    """The bodies of a scene out of a file, read when one of them is asked for."""

    def __init__(self, read: Callable[[], Sequence[Any]]) -> None:
        self._read: Callable[[], Sequence[Any]] | None = read
        self._all: Sequence[Any] = ()

    @property
    def are_read(self) -> bool:
        return self._read is None

    @property
    def _bodies(self) -> Sequence[Any]:
        if self._read is not None:
            self._all, self._read = self._read(), None
        return self._all

    def __len__(self) -> int:
        return len(self._bodies)

    def __getitem__(self, index: Any) -> Any:
        return self._bodies[index]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._bodies)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, tuple | LaterBodies) and tuple(self) == tuple(other)

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        return tuple, (tuple(self._bodies),)


def opened(path: str | os.PathLike[str], edition: str, digest: bytes | None = None) -> Any:
    """The scene of a file, prepared. Raises what `TablesFile` raises."""
    file = TablesFile(path, edition, digest)
    kind, parts, notes = file.section(_REST)
    scene = kind((), *parts)
    scene._bodies = LaterBodies(lambda: file.section(_BODIES)._bodies)
    scene._prepared, scene._notes = file.prepared(scene._bodies), notes
    return scene


def _hash(data: Any) -> bytes:
    return blake2b(data, digest_size=16).digest()
