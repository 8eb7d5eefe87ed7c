"""What workers need for a task and what is the same for all of them: it is sent once, not with each task.

A recipe is the pickle of what a user said (a scene without its tables), known by a hash of these bytes. A task carries
a `Reference`: the hash, and the bytes where they are few, or the name of a file that workers of this machine can read.
A worker that has none of these answers with `MISSING`, and gets the bytes with the task's second copy. What it has made
of them stays, so that a scene is prepared once in each process, and again wherever a new process takes over.
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


class Recipe:
    """Something that tasks share, as bytes."""

    def __init__(self, thing: Any) -> None:
        self.data = pickle.dumps(thing, protocol=5)
        self.key = _key_of(self.data)
        self._path: str | None = None
        self._tried = False
        with _lock:
            _own[self.key] = self
            self.thing = thing

    @property
    def labels(self) -> Any:
        """Of a scene, what its bodies are called and made of."""
        return self.thing.scene().prepared.labels

    def reference(self, whole: bool = False) -> Reference:
        """What a task carries; `whole` for a worker that has nothing but the task."""
        if whole or len(self.data) <= SMALL:
            return Reference(self.key, self.data)
        if not self._tried:
            self._tried, self._path = True, self._written()
        return Reference(self.key, None, self._path)

    def _written(self) -> str | None:
        """The name of a file of the bytes, in a folder that only this user can read; None where there is no room."""
        try:
            folder = tempfile.mkdtemp(prefix="conicoid-")
        except OSError:
            return None
        weakref.finalize(self, _remove, folder, os.getpid())
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
