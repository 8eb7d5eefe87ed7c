"""The exact engine in the page: its WebAssembly, and of the scene what it needs beyond the shader's tables."""

from __future__ import annotations

import base64
import json
import zlib
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from ..engine.tables import Tables
from .picks import name_of
from .written_out import written_out

if TYPE_CHECKING:
    from ..scene import Scene

NAME = "engine.wasm"
"""Made by `native.page`; it comes with wheels, and stands in a checkout where it was built."""
_SECTION = b"conicoid"


def marked(code: bytes, sources: str) -> bytes:
    """A module that says what it was made of, in a section of its own; unchanged for ""."""
    if not sources:
        return code
    content = bytes([len(_SECTION)]) + _SECTION + sources.encode()
    return code + bytes([0, len(content)]) + content


@cache
def shipped() -> bytes | None:
    """The module; None where there is none, and where it was made of other sources."""
    try:
        code = (resources.files(__package__) / NAME).read_bytes()
    except FileNotFoundError:
        return None
    mark = code.rfind(_SECTION, -128)
    if mark >= 0:  # it was built in place: the sources may have been edited since
        from ..compiler.sources import hash_of_sources

        if code[mark + len(_SECTION) :].decode() != hash_of_sources():
            return None
    return code


def engine_data(scene: Scene, shown: Any) -> dict[str, Any] | None:
    """The engine and its tables that are not `shown` to the shader as they are, compressed; None if there is none."""
    code = shipped()
    if code is None:
        return None
    geometry, rest, tables = scene.geometry, scene.prepared.rest, scene.prepared.lowered.tables
    parts: dict[str, npt.NDArray[Any]] = {"places": geometry.places}
    others = written_out(tables)
    parts |= {name: getattr(tables, name) for name in Tables._fields if name not in shown or name in others}
    parts |= {f"rest_{name}": getattr(rest, name) for name in rest._fields}
    kinds = {name: _KINDS[array.dtype.kind, name == "places"] for name, array in parts.items()}
    return {
        "code": _packed(code),
        "order": Tables._fields,
        "lengths": [len(geometry.integers), len(geometry.floats)],
        "parts": [[name, kinds[name], array.size] for name, array in parts.items()],
        "content": _packed(b"".join(array.astype(f"<{kinds[name]}").tobytes() for name, array in parts.items())),
        "names": _packed(json.dumps([name_of(scene, item) for item in range(len(scene.bodies))]).encode()),
    }


_KINDS = {("f", False): "f8", ("i", False): "i4", ("i", True): "i8"}


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
