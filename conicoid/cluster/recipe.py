"""What workers need for a task and what is the same for all of them: it is sent once, not with each task.

A recipe is the pickle of what a user said (a scene without its tables), known by a hash of these bytes. A task carries
a `Reference`: the hash, and the bytes where they are few, or the name of a file that workers of this machine can read.
A worker that has none of these answers with `MISSING`, and gets the bytes with the task's second copy. What it has made
of them stays, so that a scene is prepared once in each process, and again wherever a new process takes over; where
workers can read the file of its prepared tables (`tables_file`), they map that and prepare nothing.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import shutil
import tempfile
import weakref
from collections import OrderedDict
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

from ..forks import lock
from .edition import edition
from .tables_file import TablesFile, can_be_kept, opened, write_tables

SMALL = 1 << 12
"""Recipes of up to so many bytes travel with each task."""
KEPT = 8
"""So many things are kept by a worker, the latest."""


@dataclass(frozen=True)
class Reference:
    """Where a worker finds a recipe, or the recipe itself."""

    key: bytes
    data: bytes | None = None
    path: str | None = None
    tables: tuple[str, bytes] | None = None
    """A file of prepared tables, and the hash of its head."""


class Recipe:
    """Something that tasks share, as bytes."""

    def __init__(self, thing: Any) -> None:
        self.data = pickle.dumps(thing, protocol=5)
        self.key = _key_of(self.data)
        self._path: str | None = None
        self._tables: tuple[str, bytes] | None = None
        self._own_folder: str | None = None
        self._tried = False
        with _lock:
            _own[self.key] = self
            self.thing = thing

    @property
    def labels(self) -> Any:
        """Of a scene, what its bodies are called and made of."""
        scene: Any = self.thing.scene() if isinstance(self.thing, _Bare) else self.thing
        return scene.prepared.labels

    def reference(self, whole: bool = False) -> Reference:
        """What a task carries; `whole` for a worker that has nothing but the task."""
        if whole or len(self.data) <= SMALL:
            return Reference(self.key, self.data, None, self._tables)
        if not self._tried:
            self._tried, self._path = True, self._written()
        return Reference(self.key, None, self._path, self._tables)

    def share_tables(self, edition: str, store: str | None) -> None:
        """Have a file of the scene's prepared tables, for workers that can read it, if the scene is not a small one.

        store: a folder that workers share; None for one of this machine, which goes away with the scene. Tables that
        are there already are taken. Raises ValueError for files of a store that are damaged or of another edition.
        """
        scene = self.thing.scene() if isinstance(self.thing, _Bare) else None
        if scene is None or len(self.data) <= SMALL or type(scene).__module__ != _Bare.home:
            return
        folder = store or self._folder()
        if folder is None or (self._tables is not None and os.path.dirname(self._tables[0]) == folder):
            return
        path = os.path.join(folder, f"{self.key.hex()}-{_key_of(edition.encode()).hex()[:8]}.tables")
        with contextlib.suppress(OSError):
            if os.path.exists(path):
                file = TablesFile(path, edition)
                if scene._prepared is None:
                    scene._prepared = file.prepared(scene._bodies)
                self._tables = path, file.digest
            elif can_be_kept(scene.prepared):
                rest = type(scene), scene._parts[1:], scene._notes
                self._tables = path, write_tables(path, edition, scene.prepared, rest, self.data)

    def _folder(self) -> str | None:
        """A folder that only this user can read, until the recipe goes away; None where there is no room."""
        if self._own_folder is None:
            with contextlib.suppress(OSError):
                self._own_folder = tempfile.mkdtemp(prefix="conicoid-")
                weakref.finalize(self, _remove, self._own_folder, os.getpid())
        return self._own_folder

    def _written(self) -> str | None:
        """The name of a file of the bytes; None where there is no room."""
        folder = self._folder()
        if folder is None:
            return None
        path = os.path.join(folder, self.key.hex())
        try:
            with open(path, "xb") as file:
                file.write(self.data)
        except OSError:
            return None
        return path


def recipe_of(scene: Any) -> Recipe:
    """The recipe of a scene, which is immutable and so has one."""
    known: Recipe | None = vars(scene).get("_recipe")
    if known is None:
        known = Recipe(_Bare(scene))
        vars(scene)["_recipe"] = known
    return known


class _Bare:
    """A scene as it travels: only a weak reference keeps it from here, as it owns its recipe."""

    home = "conicoid.scene"  # the module of scenes that are nothing else

    def __init__(self, scene: Any) -> None:
        self.scene = weakref.ref(scene)

    def __reduce__(self) -> tuple[Any, ...]:
        return _same, (self.scene(),)


def _same(scene: Any) -> Any:
    return scene


_lock = lock()
_own: weakref.WeakValueDictionary[bytes, Recipe] = weakref.WeakValueDictionary()
_kept: OrderedDict[bytes, Any] = OrderedDict()


def found(reference: Reference) -> tuple[Any, ...]:
    """(what was made by a recipe,), or () in a worker that has none.

    In the process of the one who asks, and in its forks, that is the very scene, prepared as it is.
    """
    with _lock:
        mine = _own.get(reference.key)
        thing = mine.thing if mine is not None else None
        thing = thing.scene() if isinstance(thing, _Bare) else thing
        if thing is not None:
            return (thing,)
        if reference.key not in _kept and reference.tables is not None:
            path, digest = reference.tables
            with contextlib.suppress(OSError):  # it is on another machine, or another file by now
                _kept[reference.key] = opened(path, edition(), digest)
        if reference.key not in _kept:
            data = reference.data if reference.data is not None else _read(reference)
            if data is None:
                return ()
            _kept[reference.key] = pickle.loads(data)
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
        _kept.move_to_end(reference.key)
        return (_kept[reference.key],)


def _read(reference: Reference) -> bytes | None:
    """The bytes in the file of a recipe, if they are those that its hash is of."""
    if reference.path is None:
        return None
    with contextlib.suppress(OSError), open(reference.path, "rb") as file:
        data = file.read()
        return data if _key_of(data) == reference.key else None
    return None


def _remove(folder: str, process: int) -> None:
    """Remove a folder, in the process that made it and not in its forks."""
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _key_of(data: bytes) -> bytes:
    return blake2b(data, digest_size=16).digest()
