"""The sections of a scene file, and the kind of what stands in each."""

from __future__ import annotations

from typing import Any

from ..shapes.animation import TRACKS
from ..shapes.background import Background, as_background
from ..shapes.light import LIGHTS
from .fields import Arguments, MaterialKind, Tagged, kind_of
from .kinds import Kind, Schema, Several
from .nodes import Node, Table
from .reading import BAD, Reader

VERSION = 1
SECTIONS = ("conicoid", "camera", "background", "lights", "materials", "shapes", "domain", "bodies", "animation")
BODY = ("name", "shape", "move", "material", "materials", "material_index")


class CameraKind(Kind):
    """The fields of a `Camera`, or ``{ClassName: fields}`` for any camera."""

    phrase = "the fields of a camera, or a mapping such as {OrthographicCamera: {...}}"

    def __init__(self) -> None:
        from ..render.cameras import CAMERAS

        self.cameras = CAMERAS

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        entry = reader.only_entry(node)
        if entry is not None and entry[0] not in Arguments(self.cameras["Camera"]).fields:
            return Tagged(self.cameras, "camera").read(node, reader, where)
        if not isinstance(node, Table):
            return reader.expected(node, where, self.phrase)
        return Arguments(self.cameras["Camera"]).read(node, reader, where)

    def schema(self) -> Schema:
        tagged = Tagged(self.cameras, "camera").schema()["anyOf"]
        return {"anyOf": [Arguments(self.cameras["Camera"]).schema(), *tagged]}

    def fits(self, node: Node) -> bool:
        return isinstance(node, Table)


def light_kind() -> Kind:
    return Several(Tagged(LIGHTS, "light"))


def animation_kind() -> Kind:
    return Several(Tagged(TRACKS, "track"))


def material_kind() -> Tagged:
    return MaterialKind().written


_MAPPINGS = ("Sky", "Environment")
"""Backgrounds that have arguments."""


class BackgroundKind(Kind):
    """A colour or a sky, checked as a scene checks it."""

    def __init__(self) -> None:
        self.written = kind_of(Background | None)
        self.phrase = self.written.phrase

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        value = self.written.read(node, reader, where)
        if isinstance(value, str) and value in _MAPPINGS:
            return reader.report(node, where, f"must be a mapping, {{{value}: {{...}}}}, got the bare word {value!r}")
        holder = Table(node.line, node.column, {where: node})
        return BAD if value is BAD else reader.made(holder, "scene", lambda: as_background(value))

    def schema(self) -> Schema:
        return self.written.schema()

    def fits(self, node: Node) -> bool:
        return self.written.fits(node)
