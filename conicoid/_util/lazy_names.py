"""Public names of a package that are imported on first use, so that `import conicoid` stays quick; and extras."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package, whose `__name__` is `package`.

    Parameters
    ----------
    package : str
        The full name of the package.
    homes : mapping
        Public name -> module that defines it, relative to the package.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise _name_error(package, name, sorted(homes))
        value = getattr(importlib.import_module(homes[name], package), name)
        vars(sys.modules[package])[name] = value
        return value

    return find, lambda: sorted(homes)


def _name_error(package: str, name: str, known: list[str]) -> AttributeError:
    """Return the error for an unknown name, with the name that was probably meant."""
    from importlib.util import find_spec

    from .text import unknown_package_name

    root = sys.modules[package.partition(".")[0]]
    if name in getattr(root, "__all__", ()):
        return AttributeError(f"module {package!r} has no attribute {name!r}: it is co.{name}", name=name)
    # `from package import module` asks for the module as an attribute before it imports it: no search for a hint then
    if name.isidentifier() and not name.startswith("__") and find_spec(f"{package}.{name}") is not None:
        return AttributeError(f"module {package!r} has no attribute {name!r}", name=name)
    return unknown_package_name(package, name, known)


def import_extra(module: str, need: str, extra: str) -> Any:
    """Return a module of an extra. Raise ImportError with who needs it and the way to install it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"{need}: pip install 'conicoid[{extra}]'") from None
