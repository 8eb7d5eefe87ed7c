"""What the sources are that code was compiled of: one hash over all of them, which costs milliseconds at each start."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator
from typing import Any

_PACKAGE = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def _version(package: str) -> str:
    """The version of a package, which is not imported for that: the name of the folder that says all about it."""
    from importlib.util import find_spec

    found = find_spec(package)
    if found is None or found.origin is None:
        return ""
    with os.scandir(os.path.dirname(os.path.dirname(found.origin))) as entries:
        names = (each.name for each in entries)
        return " ".join(sorted(n for n in names if n.startswith(f"{package}-") and n.endswith(".dist-info")))


def _files(folder: str) -> Iterator[str]:
    """Every source below a folder."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith(".py"):
                yield entry.path
            elif entry.is_dir() and entry.name != "__pycache__":
                yield from _files(entry.path)


def hash_of_sources() -> str:
    """A hash over every source file of the package and the compilers' versions; empty where they cannot be read."""
    from hashlib import sha256

    return _digest(sha256(" ".join(map(_version, ("numba", "llvmlite"))).encode()))[:20]


def digest_of_files() -> str:
    """A hash over every source file of the package alone; empty where they cannot be read."""
    from hashlib import sha256

    return _digest(sha256())


def _digest(digest: Any) -> str:
    """The hash with every source file in it, as hexadecimal digits; empty where they cannot be read."""
    try:
        paths = sorted(_files(_PACKAGE))
        for path in paths:
            digest.update(path.removeprefix(_PACKAGE).replace(os.sep, "/").encode())
            with open(path, "rb", buffering=0) as file:
                digest.update(file.read())
    except OSError:
        return ""
    return str(digest.hexdigest()) if paths else ""


@functools.cache
def source_hash() -> str:
    """The hash at the first call, which is when the first kernel is declared: later edits do not change it."""
    return hash_of_sources()
