"""Hashes of source files, which identify compiled code and the version of a checkout; they cost milliseconds.

Machine code that is built in a checkout has a stamp: a digest of the files that the compiler read, and their names. It
is used until one of these changes, whatever happens to the others.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable, Iterator

_PACKAGE = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def _version(package: str) -> str:
    """Return the names of a package's dist-info folders, which hold its version, without importing the package."""
    from importlib.util import find_spec

    spec = find_spec(package)
    if spec is None or spec.origin is None:
        return ""
    with os.scandir(os.path.dirname(os.path.dirname(spec.origin))) as entries:
        names = (each.name for each in entries)
        return " ".join(sorted(n for n in names if n.startswith(f"{package}-") and n.endswith(".dist-info")))


def _files(folder: str) -> Iterator[str]:
    """Yield the path of every source file below a folder."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith(".py"):
                yield entry.path
            elif entry.is_dir() and entry.name != "__pycache__":
                yield from _files(entry.path)


@functools.cache
def digest_of_files() -> str:
    """Return a hash of every source file of the package as of the first call; "" if they are unreadable."""
    from hashlib import sha256

    # Names count as well, with slashes on every system: a file that is only renamed changes the hash
    digest = sha256()
    try:
        paths = sorted(_files(_PACKAGE))
        for path in paths:
            digest.update(path.removeprefix(_PACKAGE).replace(os.sep, "/").encode())
            # Whole files at once need no buffer.
            with open(path, "rb", buffering=0) as file:
                digest.update(file.read())
    except OSError:
        return ""
    return digest.hexdigest() if paths else ""


def package_files() -> list[str]:
    """Return the names of all source files below the package, with slashes."""
    return sorted(path.removeprefix(_PACKAGE).replace(os.sep, "/") for path in _files(_PACKAGE))


def stamp_of(files: Iterable[str], compilers: bool = True) -> str:
    """Return the stamp of code that was compiled from files, given as `package_files` returns them; "" if unreadable.

    The compilers' versions count as well, unless users need none.
    """
    from hashlib import sha256

    names = sorted(files)
    digest = sha256(" ".join(map(_version, ("numba", "llvmlite") if compilers else ())).encode())
    try:
        for name in names:
            digest.update(name.encode())
            with open(_PACKAGE + name, "rb", buffering=0) as file:
                digest.update(file.read())
    except OSError:
        return ""
    return "\n".join([digest.hexdigest()[:20], *names])


def is_current(stamp: str, compilers: bool = True) -> bool:
    """Return whether the files of a stamp are as they were."""
    return bool(stamp) and stamp == stamp_of(stamp.split("\n")[1:], compilers)
