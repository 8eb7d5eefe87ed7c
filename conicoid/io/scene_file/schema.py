"""The JSON Schema of scene files, for editors. It is made from the classes, so that it cannot become outdated."""

from __future__ import annotations

from typing import Any

from ...geometry.bulk import Bulk
from ...geometry.entries import LENGTH_UNITS
from ...geometry.registry import REGISTRY
from ...geometry.shape import Difference, Intersection, Shape, Sheet, Solid
from .fields import (
    SCENE_VERSION,
    ArgumentsType,
    BackgroundType,
    CameraType,
    animation_type,
    light_type,
    material_type,
    tagged_schema,
)
from .nodes import FixedListType, ListType, NumberType, Schema
from .shape_reader import AXIS_TYPE, INDEX_SCHEMA, VECTOR_TYPE, array_type, operand_field
from .template import COLUMN_TYPE

# One entry for each kind of step in a `move` list.
STEP_SCHEMAS: dict[str, Schema] = {
    "translate": VECTOR_TYPE.schema(),
    "rotate": {
        "type": "object",
        "properties": {"axis": AXIS_TYPE.schema(), "degrees": {"type": "number"}, "about": VECTOR_TYPE.schema()},
        "required": ["axis", "degrees"],
        "additionalProperties": False,
    },
    "scale": {"anyOf": [{"type": "number"}, VECTOR_TYPE.schema()]},
    "transform": FixedListType(FixedListType(NumberType(), 4), 4).schema(),
}


def scene_schema() -> dict[str, Any]:
    """Return the schema of a whole file (JSON Schema, draft 2020-12)."""
    move = {"type": "array", "items": {"anyOf": [_single(name, step) for name, step in STEP_SCHEMAS.items()]}}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Conicoid scene",
        "type": "object",
        "properties": {
            "conicoid": {"const": SCENE_VERSION, "description": "Version of the format."},
            "unit": {"enum": [*LENGTH_UNITS, None], "description": "Of lengths."},
            "camera": {"anyOf": [CameraType().schema(), {"type": "null"}]},
            "background": BackgroundType().schema(),
            "lights": {"anyOf": [light_type().schema(), {"type": "null"}]},
            "materials": _by_name({"$ref": "#/$defs/material"}),
            "shapes": _by_name({"$ref": "#/$defs/shape"}),
            "domain": {"anyOf": [{"$ref": "#/$defs/solid"}, {"type": "null"}]},
            "bodies": {"type": "array", "items": {"anyOf": [{"$ref": "#/$defs/body"}, {"$ref": "#/$defs/template"}]}},
            "animation": {"anyOf": [animation_type().schema(), {"type": "null"}]},
        },
        "required": ["bodies"],
        "additionalProperties": False,
        "$defs": {
            "move": move | {"description": "Steps about the world's origin, first to last."},
            "material": material_type().schema(),
            "body": _body(),
            "template": _template(),
            "reference": {
                "description": "The name of a shape under `shapes`, alone or with a move.",
                "anyOf": [{"type": "string", "minLength": 1}, _with_move(_single("shape", {"$ref": "#/$defs/shape"}))],
            },
            "shape": _shapes(Shape),
            "solid": _shapes(Solid),
            "sheet": _shapes(Sheet),
        }
        | {name: _with_move(tagged_schema(name, _arguments(cls), cls)) for name, cls in REGISTRY.items()},
    }


def _body() -> Schema:
    return {
        "type": "object",
        "properties": {
            "name": {"type": ["string", "null"], "minLength": 1},
            "shape": {"$ref": "#/$defs/shape"},
            "move": {"$ref": "#/$defs/move"},
            "material": _material(),
            "materials": {
                "type": "array",
                "items": _material(),
                "description": "Of many bodies in one entry, such as Spheres, in place of a material.",
            },
            "material_index": INDEX_SCHEMA,
        },
        "required": ["shape"],
        "additionalProperties": False,
    }


def _template() -> Schema:
    """Return the schema of a template, whose shape and motion are not described: names may stand for numbers there."""
    properties = _body()["properties"]
    file = _single("file", {"type": "string", "description": "A .npz file beside the scene: an array for each name."})
    return {
        "type": "object",
        "properties": {
            "shape": {"type": ["object", "string"], "description": "A shape with names such as $radius for numbers."},
            "move": {"type": "array", "items": {"type": "object"}},
            **{name: properties[name] for name in ("material", "materials", "material_index")},
            "columns": {"anyOf": [file, {"type": "object", "additionalProperties": COLUMN_TYPE.schema()}]},
        },
        "required": ["shape", "columns"],
        "additionalProperties": False,
    }


def _material() -> Schema:
    return {"anyOf": [{"type": ["string", "null"]}, {"$ref": "#/$defs/material"}]}


def _shapes(base: type) -> Schema:
    """Return the schema of a reference or of any registered shape of a class."""
    names = [name for name, cls in REGISTRY.items() if issubclass(cls, base)]
    return {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in ("reference", *names)]}


def _arguments(cls: type[Shape]) -> Schema:
    """Return the schema of the fields, arrays or operands of a shape."""
    if issubclass(cls, Bulk):
        inline = {name: array_type(cls, name).schema() for name in cls.columns}
        arrays = f", or an .npz file with the arrays {', '.join(cls.columns)}"
        text = f"A .npy or .csv file beside the scene with columns {', '.join(cls.headings())}{arrays}."
        return {
            "anyOf": [
                {"type": "object", "properties": inline, "required": list(inline), "additionalProperties": False},
                _single("file", {"type": "string", "description": text}),
            ]
        }
    kind = operand_field(cls)
    if kind is None:
        return ArgumentsType(cls).schema()
    # Operands are solids, but a sheet may be cut by solids.
    clips = {"items": {"$ref": "#/$defs/shape"}} if issubclass(cls, Difference | Intersection) else {}
    return kind.schema() | ({"minItems": 1} if isinstance(kind, ListType) else {}) | clips


def _with_move(schema: Schema) -> Schema:
    """Return a schema that also allows `move` beside its property."""
    return schema | {"properties": schema["properties"] | {"move": {"$ref": "#/$defs/move"}}}


def _single(name: str, value: Schema) -> Schema:
    """Return the schema of a mapping with exactly one entry."""
    return {"type": "object", "properties": {name: value}, "required": [name], "additionalProperties": False}


def _by_name(value: Schema) -> Schema:
    """Return the schema of a section of named values."""
    return {"type": ["object", "null"], "additionalProperties": value}
