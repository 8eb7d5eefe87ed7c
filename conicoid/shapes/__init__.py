"""What a user can say: frozen dataclasses, data only.

Every file here that defines a shape registers it by defining it; scene files and the contract
tests find it in `REGISTRY`, which imports what it is asked for: whoever makes a ball needs only its own file.
"""

from __future__ import annotations

import functools
import importlib
import re
from collections.abc import Iterator, Mapping

from .base import REGISTERED, Shape, Sheet, Solid

__all__ = ["REGISTRY", "Shape", "Sheet", "Solid"]

_BOOLEANS = dict.fromkeys(("Union", "Intersection", "Difference", "Complement"), "region")
"""What is not in a file of its own name, and is asked for all the time."""
_CAPITAL = re.compile(r"(?<=.)(?=[A-Z])")


class Registry(Mapping[str, type[Shape]]):
    """Scene-file name -> class, for every shape a user can write; in the order of files, a user's own last.

    The file of a name is imported, or waited for where another thread imports it: its class is made by then.
    """

    def __getitem__(self, name: str) -> type[Shape]:
        if not isinstance(name, str):
            raise KeyError(name)
        file = _file_of(name)
        if file is not None:
            importlib.import_module(file)
        if name not in REGISTERED:
            _import_all()
        return REGISTERED[name]

    def __iter__(self) -> Iterator[str]:
        _import_all()
        own = f"{__name__}."
        return iter(sorted(REGISTERED, key=lambda name: _place(REGISTERED[name].__module__, own)))

    def __len__(self) -> int:
        _import_all()
        return len(REGISTERED)

    def __repr__(self) -> str:
        return repr(dict(self))


REGISTRY = Registry()


def _place(module: str, own: str) -> tuple[bool, str]:
    """Where in the order a file's shapes are."""
    return (False, module) if module.startswith(own) else (True, "")


@functools.lru_cache(maxsize=1024)
def _file_of(name: str) -> str | None:
    """The file that has the name of a shape, as a module; None if there is none."""
    file = _BOOLEANS.get(name) or _CAPITAL.sub("_", name).lower()
    return f"{__name__}.{file}" if file in _files() else None


@functools.cache
def _import_all() -> None:
    for file in sorted(_files()):
        importlib.import_module(f"{__name__}.{file}")


@functools.cache
def _files() -> frozenset[str]:
    """The names of the files here."""
    import pkgutil

    return frozenset(module.name for module in pkgutil.iter_modules(__path__))
