"""Value types from type hints: the arguments of a dataclass or function in a scene file, and the sections of a file.

Nothing is declared twice: the fields of a shape, a material or a light, with their types and defaults, are all that
reading, writing and the schema need.
"""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import types
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ..._util.arrays import Matrix4
from ..._util.records import dataclass
from ...geometry.registry import REGISTRY
from ...geometry.shape import REGISTERED, Shape
from ...geometry.tracks import TRACKS
from ...materials.color import near_color
from ...materials.light import LIGHTS, Background, as_background
from ...materials.material import Material
from ...materials.presets import CONSTRUCTORS, matte
from ...materials.texture import ImagePath
from ..npz import resolve_data_file
from .nodes import (
    BAD,
    BoolType,
    ChoiceType,
    FixedListType,
    IntegerType,
    ListType,
    MappingNode,
    MappingType,
    Node,
    NodeReader,
    NumberType,
    OptionalType,
    ScalarNode,
    Schema,
    SequenceNode,
    TextType,
    UnionType,
    ValueType,
    describe_node,
    is_text,
)

REQUIRED = inspect.Parameter.empty
# A number, or nested lists of numbers up to two deep: any array of a field.
NUMBERS = UnionType((NumberType(), ListType(UnionType((NumberType(), ListType(NumberType()))))))


@dataclass(frozen=True)
class ArgumentField:
    """One argument: its type, and its default or `REQUIRED`."""

    kind: ValueType
    default: Any

    @property
    def is_required(self) -> bool:
        """True if the argument has no default."""
        return self.default is REQUIRED


class _MappingType(ValueType):
    """A type whose values are mappings."""

    def fits(self, node: Node) -> bool:
        return isinstance(node, MappingNode)


class ArgumentsType(_MappingType):
    """The arguments of a class or function as a mapping; `read` returns the result of the call."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self.make = make
        self.phrase = f"the fields of {make.__name__}"

    @property
    def fields(self) -> dict[str, ArgumentField]:
        """The arguments by name."""
        return argument_fields(self.make)

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        where = f"{where}: {self.make.__name__}" if where else self.make.__name__
        required = [name for name, field in self.fields.items() if field.is_required]
        entries = reader.entries(node, where, self.fields, required)
        present = node.entries if isinstance(node, MappingNode) else {}
        values = {
            name: field.kind.read(present[name], reader, f"{where}: {name}")
            for name, field in self.fields.items()
            if name in present
        }
        if not isinstance(entries, dict) or any(value is BAD for value in values.values()):
            return BAD
        return reader.build(node, where, lambda: self.make(**values))

    def schema(self) -> Schema:
        properties = {name: field.kind.schema() for name, field in self.fields.items()}
        required = [name for name, field in self.fields.items() if field.is_required]
        result: Schema = {"type": "object" if required else ["object", "null"], "properties": properties}
        if required:
            result["required"] = required
        return result | {"additionalProperties": False}


class TaggedType(_MappingType):
    """``{Name: {arguments}}`` for one of several classes or functions."""

    def __init__(self, makers: Mapping[str, Callable[..., Any]], what: str) -> None:
        self.makers = dict(makers)
        self.what = what
        self.phrase = f"a {what} such as {{{next(iter(makers), '')}: {{...}}}}"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        entry = reader.only_entry(node)
        if entry is None:
            return reader.report_mismatch(node, where, self.phrase)
        name, key, value = entry
        if name not in self.makers:
            return reader.unknown(key, where, self.what, name, self.makers)
        return ArgumentsType(self.makers[name]).read(value, reader, where)

    def schema(self) -> Schema:
        return {
            "anyOf": [tagged_schema(name, ArgumentsType(make).schema(), make) for name, make in self.makers.items()]
        }


class ShapeType(_MappingType):
    """A shape of a class or its subclasses: one kind of shape, any solid, any sheet, or any shape."""

    def __init__(self, base: type[Shape]) -> None:
        self.base = base
        if base.__name__ in REGISTERED:
            self.phrase = f"a {base.__name__}, {{{base.__name__}: {{...}}}}"
        else:
            self.phrase = (
                f"a {base.__name__.lower()} such as {{{'Disc' if base.__name__ == 'Sheet' else 'Sphere'}: {{...}}}}"
            )

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        return reader.shape(node, where, self.base)

    def schema(self) -> Schema:
        name = self.base.__name__
        if name not in REGISTERED:
            return {"$ref": f"#/$defs/{name.lower()}"}
        return {"anyOf": [{"$ref": f"#/$defs/{name}"}, {"$ref": "#/$defs/reference"}]}


class MaterialType(ValueType):
    """A material by its constructor or by all its fields, the name of one under `materials`, or a colour."""

    phrase = "a material such as {matte: {...}}, or the name of one under `materials`, or a colour such as 'gray'"

    def __init__(self) -> None:
        self.value_type = TaggedType({**CONSTRUCTORS, "Material": Material}, "material")

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if isinstance(node, ScalarNode) and is_text(node):
            # Names of the file first, so that a new name of a colour never changes an old scene
            if node.text in reader.materials:
                return reader.materials[node.text]
            if node.text in reader.colors:
                return reader.colors[node.text]
            with contextlib.suppress(ValueError):  # materials of the file come before names of colours
                return reader.colors.setdefault(node.text, matte(node.text))
            near = reader.suggestions(node.text, reader.materials) or near_color(node.text)
            return reader.report(node, where, f"must be {self.phrase}, got {describe_node(node)}{near}")
        if reader.only_entry(node) is None:
            return reader.report_mismatch(node, where, self.phrase)
        return self.value_type.read(node, reader, where)

    def schema(self) -> Schema:
        described = {"type": "string", "description": "A material under `materials`, or a colour."}
        return {"anyOf": [described, {"$ref": "#/$defs/material"}]}

    def fits(self, node: Node) -> bool:
        return is_text(node) or self.value_type.fits(node)


class PictureFileType(TextType):
    """The name of an image file in the folder of the scene file, or below; any path if the reader allows it."""

    phrase = "the name of a picture's file"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        name = super().read(node, reader, where)
        if name is BAD:
            return name
        if reader.takes_any_file:
            return ImagePath(reader.folder / name)
        try:
            return ImagePath(resolve_data_file(reader.folder, name))
        except ValueError as error:
            allowed = "; co.load(..., outside=True) allows it" if "scene's folder" in str(error) else ""
            return reader.report(node, where, f"{error}{allowed}")


class AnyValueType(ValueType):
    """Any value: numbers, texts, lists and mappings, for fields whose type is `Any`."""

    phrase = "a value"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if isinstance(node, SequenceNode):
            return ListType(self).read(node, reader, where)
        if isinstance(node, MappingNode):
            return MappingType(self).read(node, reader, where)
        for kind in (BoolType(), IntegerType(), TextType()):  # integers before numbers, so that 1 stays an int
            if kind.fits(node):
                return kind.read(node, reader, where)
        return OptionalType(NumberType()).read(node, reader, where)

    def schema(self) -> Schema:
        return {}

    def fits(self, node: Node) -> bool:
        return True


class UserValueType(AnyValueType):
    """A value in the properties of a material, which the class `Properties` checks."""

    phrase = "a number, a text, true or false, an array of numbers or texts, or a mapping to numbers or texts"

    def schema(self) -> Schema:
        single: list[str] = ["number", "string", "boolean"]
        rows: Schema = {"type": "array", "items": {"type": "number"}}
        items = {"anyOf": [{"type": ["number", "string"]}, rows]}
        return {
            "anyOf": [
                {"type": single},
                {"type": "array", "items": items},
                {"type": "object", "additionalProperties": {"type": single}},
            ]
        }


def tagged_schema(name: str, arguments: Schema, make: Callable[..., Any]) -> Schema:
    """Return the schema of ``{name: arguments}``; its description is the first paragraph of the docstring."""
    text = " ".join((inspect.getdoc(make) or name).split("\n\n")[0].split())
    return {
        "type": "object",
        "description": text,
        "properties": {name: arguments},
        "required": [name],
        "additionalProperties": False,
    }


@cache
def argument_fields(make: Callable[..., Any]) -> dict[str, ArgumentField]:
    """Return the arguments of a class or function by name, without the motion of a shape."""
    source = (
        make if dataclasses.is_dataclass(make) else getattr(make, "__init__", make) if isinstance(make, type) else make
    )
    hints = _hints(source)
    parameters = inspect.signature(make).parameters
    return {
        name: ArgumentField(resolve_type(hints.get(name, Any)), parameter.default)
        for name, parameter in parameters.items()
        if name != "motion" or not (isinstance(make, type) and issubclass(make, Shape))
    }


def _hints(source: Any) -> dict[str, Any]:
    """Return the type hints of a class or function, which may name shapes that its file does not import."""
    try:
        return get_type_hints(source, localns={})
    except NameError:
        return get_type_hints(source, localns=dict(REGISTRY))


def resolve_type(hint: Any) -> ValueType:
    """Return the value type of a type hint."""
    if hint is ImagePath:
        return PictureFileType()
    simple: dict[Any, ValueType] = {float: NumberType(), int: IntegerType(), bool: BoolType(), str: TextType()}
    if isinstance(hint, type) and hint in simple:
        return simple[hint]
    if hint == Matrix4:
        return FixedListType(FixedListType(NumberType(), 4), 4)
    origin, arguments = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return _alternatives(arguments)
    if origin is Literal:
        return ChoiceType(arguments)
    # tuple[float, ...] has any length, tuple[float, float, float] exactly three
    if origin is tuple and len(arguments) == 2 and arguments[1] is Ellipsis:
        return ListType(resolve_type(arguments[0]))
    if origin is tuple and len(set(arguments)) == 1:
        return FixedListType(resolve_type(arguments[0]), len(arguments))
    if isinstance(origin, type) and issubclass(origin, np.ndarray):
        return NUMBERS
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return MappingType(UserValueType() if arguments[1] is Any else resolve_type(arguments[1]))
    if isinstance(origin, type) and issubclass(origin, Sequence):
        return ListType(resolve_type(arguments[0]))
    if isinstance(hint, type) and issubclass(hint, Shape):
        return ShapeType(hint)
    if hint is Material:
        return MaterialType()
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return TaggedType({hint.__name__: hint}, hint.__name__)
    return AnyValueType()


def _alternatives(hints: tuple[Any, ...]) -> ValueType:
    """Return the value type of a union."""
    # No file holds a function.
    rest = [hint for hint in hints if hint is not type(None) and get_origin(hint) is not Callable]
    classes = [hint for hint in rest if isinstance(hint, type) and not issubclass(hint, Shape)]
    records = {hint.__name__: hint for hint in classes if dataclasses.is_dataclass(hint)}
    kinds = [resolve_type(hint) for hint in rest if hint not in records.values()]
    if records:
        several = "pattern" if "Checker" in records else "formula"
        kinds.append(TaggedType(records, next(iter(records)) if len(records) == 1 else several))
    kind = kinds[0] if len(kinds) == 1 else UnionType(tuple(kinds))
    return OptionalType(kind) if type(None) in hints else kind


# Sections of a scene file, and their types.

SCENE_VERSION = 1
SECTIONS = (
    "conicoid", "unit", "camera", "background", "lights", "materials", "shapes", "domain", "bodies", "animation",
)  # fmt: skip
BODY_KEYS = ("name", "shape", "move", "material", "materials", "material_index", "columns")


class CameraType(_MappingType):
    """The fields of a `Camera`, or ``{ClassName: fields}`` for any camera."""

    phrase = "the fields of a camera, or a mapping such as {OrthographicCamera: {...}}"

    def __init__(self) -> None:
        from ...render.camera import CAMERAS

        self.cameras = CAMERAS

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        entry = reader.only_entry(node)
        # The fields of a `Camera` without its name are the short form of most scenes
        if entry is not None and entry[0] not in ArgumentsType(self.cameras["Camera"]).fields:
            return TaggedType(self.cameras, "camera").read(node, reader, where)
        if not isinstance(node, MappingNode):
            return reader.report_mismatch(node, where, self.phrase)
        return ArgumentsType(self.cameras["Camera"]).read(node, reader, where)

    def schema(self) -> Schema:
        tagged = TaggedType(self.cameras, "camera").schema()["anyOf"]
        return {"anyOf": [ArgumentsType(self.cameras["Camera"]).schema(), *tagged]}


def light_type() -> ValueType:
    """Return the type of the section `lights`."""
    return ListType(TaggedType(LIGHTS, "light"))


def animation_type() -> ValueType:
    """Return the type of the section `animation`."""
    return ListType(TaggedType(TRACKS, "track"))


def material_type() -> TaggedType:
    """Return the type of the values in the section `materials`."""
    return MaterialType().value_type


_MAPPINGS = ("Sky", "Environment")
"""Backgrounds with arguments, which are mappings."""


class BackgroundType(ValueType):
    """A colour, a sky or an environment, with the checks of a scene."""

    def __init__(self) -> None:
        self.value_type = resolve_type(Background | None)
        self.phrase = self.value_type.phrase

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        value = self.value_type.read(node, reader, where)
        if isinstance(value, str) and value in _MAPPINGS:
            return reader.report(node, where, f"must be a mapping, {{{value}: {{...}}}}, got the bare word {value!r}")
        # `as_background` names the scene in its messages, so the node of the scene goes with it
        holder = MappingNode(node.line, node.column, {where: node})
        return BAD if value is BAD else reader.build(holder, "scene", lambda: as_background(value))

    def schema(self) -> Schema:
        return self.value_type.schema()

    def fits(self, node: Node) -> bool:
        return self.value_type.fits(node)
