"""What the benchmark knows of a peer: is it here, how does one get it."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from typing import Any


class Absent(Exception):
    """A peer is not installed, or does not run; the message says what to do."""


@dataclass(frozen=True)
class Peer:
    """`find()` returns its version, or raises Absent."""

    name: str
    about: str
    find: Callable[[], str]


def distribution(name: str) -> str:
    """The version of an installed package; raises Absent with the way to install it."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        raise Absent(f"not installed: pip install {name}") from None


def module(name: str, package: str) -> Any:
    """A module of a package; raises Absent where it cannot be imported."""
    distribution(package)
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise Absent(f"{package} is installed but cannot be imported: {error}") from None
