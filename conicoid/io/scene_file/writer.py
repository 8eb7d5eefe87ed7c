"""From shapes, materials and bodies to data, and from data to readable YAML or JSON that loses no bit.

`ShapeWriter` makes data: numbers, texts, lists and mappings. `dump_yaml` puts a value on one line if it fits, else one
item a line. Floats are the shortest decimals that read back exactly; every word is written so that readers of YAML 1.1
and 1.2 agree on it.
"""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain, count
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..._util.validation import format_value
from ...geometry.body import Body
from ...geometry.bulk import Bulk
from ...geometry.shape import Shape
from ...geometry.transform import Rotate, Scale, Transform, Translate
from ...materials.image_file import Pixels
from ...materials.light import Environment
from ...materials.material import Material, Properties, constructor_call
from ...materials.texture import ImagePath, ImageTexture
from .fields import argument_fields
from .nodes import ListType
from .shape_reader import operand_field, operand_shapes

# From data to text.

WIDTH = 110
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:[ .-][A-Za-z0-9_]+)*")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
# Words that some reader of YAML 1.1 or 1.2 takes for something other than a text.
_MEANINGFUL = {"null", "true", "false", "yes", "no", "on", "off", "y", "n", "inf", "nan"}


class YamlFloat(float):
    """A number that is written with a point, so that it is not read as an integer."""


def dump_yaml(data: dict[str, Any]) -> str:
    """Return a document with one section per key, and an empty line before each list or mapping."""
    text = ""
    for key, value in data.items():
        simple = not isinstance(value, (list, dict))
        text += ("\n" if text and not simple else "") + "\n".join(_entry(format_text(key), value, "", top=True)) + "\n"
    return text


def dump_json(data: dict[str, Any]) -> str:
    """Return a document as JSON, with each body and each named value on its own line.

    Raise ValueError for infinite numbers, which JSON lacks.
    """
    try:
        sections = ",\n".join(f" {_json(key)}: {_json_section(value)}" for key, value in data.items())
    except ValueError:
        raise ValueError("JSON has no infinite numbers: save this scene as .yaml") from None
    if "\\ud" in sections:  # no reader takes half a surrogate pair
        try:
            json.dumps(data, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            text = error.object[: error.end].rpartition('"')[2]
            raise ValueError(f"a scene file cannot hold the text {text!r}: it is not Unicode") from None
    return f"{{\n{sections}\n}}\n".replace("\x7f", "\\u007f")  # YAML readers refuse the bare character


def _json_section(value: Any) -> str:
    if not isinstance(value, (list, dict)) or not value or not _is_section(value):
        return _json(value)
    if isinstance(value, dict):
        return "{\n" + ",\n".join(f"  {_json(key)}: {_json(item)}" for key, item in value.items()) + "\n }"
    return "[\n" + ",\n".join(f"  {_json(item)}" for item in value) + "\n ]"


def _json(value: Any) -> str:
    return json.dumps(value, allow_nan=False)


def _entry(key: str, value: Any, indent: str, top: bool = False) -> Iterator[str]:
    """Yield the lines of `key: value`: one line if it fits and is not a section of the document."""
    inline = inline_yaml(value, WIDTH - len(indent) - len(key) - 2)
    if inline is not None and not (top and isinstance(value, (list, dict)) and value and _is_section(value)):
        yield f"{indent}{key}: {inline}"
    else:
        yield f"{indent}{key}:"
        yield from _block(value, indent + "  ")


def _is_section(value: Any) -> bool:
    """Return True for a list or mapping that holds lists or mappings."""
    items = value.values() if isinstance(value, dict) else value
    return any(isinstance(item, (list, dict)) for item in items)


def _block(value: Any, indent: str) -> Iterator[str]:
    """Yield the lines of a list or mapping, one item a line where it fits."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _entry(_key(key), item, indent)
        return
    for item in value:
        named = isinstance(item, dict) and "name" in item
        inline = None if named else inline_yaml(item, WIDTH - len(indent) - 2)
        if inline is not None:
            yield f"{indent}- {inline}"
            continue
        first, *rest = _block(item, indent + "  ")
        yield f"{indent}- {first.lstrip()}"
        yield from rest


def inline_yaml(value: Any, room: int) -> str | None:
    """Return a value on one line, or None for a list or mapping that takes more than `room` characters."""
    if isinstance(value, dict):
        keys = [f"{_key(key)}: " for key in value]
        return _join_inline("{", "}", keys, list(value.values()), room)
    if isinstance(value, (list, tuple)):
        return _join_inline("[", "]", [""] * len(value), value, room)
    return format_scalar(value)


def _join_inline(opening: str, closing: str, keys: Sequence[str], items: Sequence[Any], room: int) -> str | None:
    room -= 2
    if 3 * len(items) > room + 4:  # each item takes a character and ", " at least
        return None
    texts: list[str] = []
    for key, item in zip(keys, items, strict=True):
        text = inline_yaml(item, room - len(key))
        room -= len(key) + len(text or "") + 2
        if text is None or room < -2:
            return None
        texts.append(key + text)
    return opening + ", ".join(texts) + closing


def format_scalar(value: Any) -> str:
    """Return one word: null, a boolean, a number or a text."""
    if type(value) is float:
        return format_number(value)
    if value is None:
        return "null"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, YamlFloat):
        text = format_number(value)
        return text + ".0" if text.lstrip("-").isdigit() else text
    if isinstance(value, (float, np.floating)):
        return format_number(float(value))
    return format_text(str(value))


def format_number(value: float) -> str:
    """Return the shortest decimal that reads back as `value`, with a point before an exponent, as YAML 1.1 requires."""
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    # Integers in full up to 1e15, where floats still hold them; -0.0 keeps its sign.
    if value.is_integer() and abs(value) < 1e15 and math.copysign(1.0, value) * value >= 0 and repr(value) != "-0.0":
        return str(int(value))
    text = repr(value)
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if mark and "." not in mantissa else text


def format_text(text: str) -> str:
    """Return a text, in quotes if a reader could misread it. Raise ValueError for half a surrogate pair."""
    if _WORD.fullmatch(text) and text.lower() not in _MEANINGFUL:
        return text
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise ValueError(f"a scene file cannot hold the text {text!r}: it is not Unicode")
    return '"' + "".join(_ESCAPES.get(c) or (c if c.isprintable() else _escape(c)) for c in text) + '"'


_key = lru_cache(maxsize=256)(format_text)
"""`format_text` of the names of classes and fields, which a file repeats."""


def _escape(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


# From a scene to data.

INLINE_BODIES = 100
"""Most bodies of one entry whose arrays stand in the scene file; larger arrays go to files beside it."""
MOST_NUMBERS = 1_000_000
"""Most numbers of an environment's pixels in the scene file itself, which holds four million values at most."""
LEVELS_INLINE = 20
"""Levels of Booleans after which a part gets a name, so that files are not nested too deep for their reader."""
_LONGEST_KEY = 100
"""Most characters of a material's name as a key: YAML reads keys of 1,024, and an escape takes ten."""

ShapeIdentity: TypeAlias = tuple[Any, ...]

KeepTable = Callable[[str, Any], str]
"""A function (kind, array) that writes an array to a file, `kind` being such as "spheres", and returns its name."""


class ShapeWriter:
    """Turns shapes, materials and other fields into data.

    A Boolean gets a name if it is used more than once, moved or not, or if it is deep. Materials get names, equal ones
    once.
    """

    def __init__(
        self,
        shapes: Iterable[Shape],
        keep_table: KeepTable,
        material_names: Mapping[Material, str] | None = None,
        folder: Path | None = None,
    ) -> None:
        self.keep_table = keep_table
        self.folder = folder  # of the file; images are named relative to it, without it mean colours are written
        self.named_nodes: dict[str, Any] = {}
        self.names: dict[ShapeIdentity, str] = {}
        self.materials: dict[str, Any] = {}
        short = {material: name for material, name in (material_names or {}).items() if len(name) <= _LONGEST_KEY}
        self.material_names = {material.exact_text: name for material, name in short.items()}
        self.used_names = set(self.material_names.values())
        self.letters = (name for name in map(_letter_name, count()) if name not in self.used_names)
        uses: Counter[ShapeIdentity] = Counter()
        heights: dict[ShapeIdentity, int] = {}
        for shape in list(sort_by_parts(shapes, uses)):
            key = shape_identity(shape)
            height = 1 + max((heights[shape_identity(part)] for part in operand_shapes(shape)), default=-1)
            heights[key] = height
            if height and (uses[key] > 1 or height % LEVELS_INLINE == 0):
                written = {type(shape).__name__: self._fields(shape)}
                self.names[key] = f"shape {len(self.named_nodes) + 1}"
                self.named_nodes[self.names[key]] = written

    def data(self, shape: Shape) -> Any:
        """Return ``{ClassName: fields, move: steps}``, or a reference to a named shape."""
        move = {"move": [_step_data(step) for step in shape.motion.steps]} if shape.motion.steps else {}
        name = self.names.get(shape_identity(shape))
        if name is None:
            return {type(shape).__name__: self._fields(shape)} | move
        return {"shape": name} | move if move else name

    def _fields(self, shape: Shape) -> Any:
        """Return the fields, arrays or operands of a shape."""
        if isinstance(shape, Bulk):
            return self._bulk(shape)
        kind = operand_field(type(shape))
        if kind is None:
            return self.record(shape)
        operands = [self.data(part) for part in operand_shapes(shape)]
        return operands if isinstance(kind, ListType) else operands[0]

    def _bulk(self, shape: Bulk) -> dict[str, Any]:
        """Return the arrays of many bodies, or the file that holds them."""
        if len(shape) > INLINE_BODIES:
            return {"file": self.keep_table(type(shape).__name__.lower(), shape.table())}
        return {name: getattr(shape, name).tolist() for name in shape.columns}

    def index(self, values: Any) -> Any:
        """Return the `material_index` of many bodies, or the file that holds it."""
        return {"file": self.keep_table("materials", values)} if len(values) > INLINE_BODIES else values.tolist()

    def record(self, item: Any) -> dict[str, Any]:
        """Return the arguments that rebuild a dataclass, without those at their defaults."""
        cls: Any = type(item)
        values = {name: (getattr(item, name), field) for name, field in argument_fields(cls).items()}
        return {
            name: self.value(value)
            for name, (value, field) in values.items()
            if field.is_required or repr(value) != repr(field.default)
        }

    def surroundings(self, environment: Environment) -> Any:
        """Return the pixels of an environment: the name of their file, or all numbers of a small one.

        Raise ValueError for many pixels without a file in the folder.
        """
        pixels: Any = environment.pixels
        if self.folder is None:
            return pixels.tolist()
        file = environment.file
        if file is not None and Path(file).resolve().is_relative_to(self.folder):
            return picture_name(file, self.folder)
        if pixels.size > MOST_NUMBERS:
            remedy = "co.Image(pixels).save('sky.exr') makes one" if file is None else f"copy {file!r} there"
            raise ValueError(
                "Environment: pixels must be in a file in the folder of the scene file, or below, to be saved, "
                f"if they are more than {MOST_NUMBERS:,} numbers: {remedy}"
            )
        return pixels.tolist()

    def material(self, material: Any) -> str:
        """Return the name of a material in the file; it is added to `materials` on first use."""
        key = material.exact_text
        if key not in self.material_names:
            self.material_names[key] = self._free_name(material)
            self.used_names.add(self.material_names[key])
        name = self.material_names[key]
        if name not in self.materials:
            self.materials[name] = self._material_call(material, name)
        return name

    def _material_call(self, material: Material, key: str) -> dict[str, Any]:
        """Return the constructor of a material with its arguments; `name` is one only if it differs from the key."""
        maker, arguments = constructor_call(material)
        arguments.pop("name", None)
        own = {} if material.name == key else {"name": material.name}
        return {maker: {name: self.value(value) for name, value in (arguments | own).items()}}

    def _free_name(self, material: Material) -> str:
        """Return a free name for a material: its own, with a number if that is taken, or letters if it has none."""
        if material.name is None or len(material.name) > _LONGEST_KEY:
            return next(self.letters)
        numbered = (f"{material.name} ({number})" for number in count(2))
        return next(name for name in chain([material.name], numbered) if name not in self.used_names)

    def value(self, value: Any) -> Any:
        """Return the data of any field: shapes and records by class name, materials by name, arrays as lists.

        Raise ValueError for values that a file cannot hold: pixels without a file, and functions.
        """
        if isinstance(value, Shape):
            return self.data(value)
        if isinstance(value, Material):
            return self.material(value)
        if isinstance(value, ImageTexture) and self.folder is None:
            return self.value(value.mean)
        if isinstance(value, ImagePath):
            return picture_name(value, self.folder)
        if isinstance(value, Environment):
            return {"Environment": self.record(value) | {"pixels": self.surroundings(value)}}
        if isinstance(value, Pixels):
            raise ValueError("ImageTexture: image must be a file to stand in a scene file: co.Image(array).save(path)")
        if dataclasses.is_dataclass(value):
            return {type(value).__name__: self.record(value)}
        if isinstance(value, np.ndarray):
            return value.tolist()
        if isinstance(value, Properties):
            return {
                name: YamlFloat(item) if isinstance(item, float) else self.value(item) for name, item in value.items()
            }
        if isinstance(value, Mapping):
            return {str(key): self.value(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.value(item) for item in value]
        if callable(value):
            raise ValueError(
                "Material: refractive_index must be a number, the name of a glass, a formula or a table to stand in a "
                f"scene file, got a function, {format_value(value)}"
            )
        return value


def picture_name(path: str, folder: Path | None) -> str:
    """Return the name of an image file for a scene file in a folder. Raise ValueError for a file outside of it."""
    final = Path(path).resolve()
    if folder is not None and not final.is_relative_to(folder):
        raise ValueError(
            f"ImageTexture: image must lie in the folder of the scene file, or below, got {path!r}: copy it there"
        )
    return final.as_posix() if folder is None else final.relative_to(folder).as_posix()


def _letter_name(number: int) -> str:
    """Return material A, material B, ..., material Z, material AA, ...

    Letters cannot be mistaken for the numbers that importers give.
    """
    letters = ""
    while number >= 0:
        letters = chr(ord("A") + number % 26) + letters
        number = number // 26 - 1
    return f"material {letters}"


def sort_by_parts(shapes: Iterable[Shape], uses: Counter[ShapeIdentity]) -> Iterator[Shape]:
    """Yield each shape once, after its operands, and count in `uses` how often it occurs; without recursion."""
    pending = [(shape, False) for shape in shapes][::-1]
    while pending:
        shape, parts_done = pending.pop()
        if parts_done:
            yield shape
            continue
        uses[shape_identity(shape)] += 1
        if uses[shape_identity(shape)] == 1:
            pending.append((shape, True))
            pending.extend((part, False) for part in reversed(operand_shapes(shape)))


def shape_identity(shape: Shape) -> ShapeIdentity:
    """Return a key that a shape shares with its moved copies: its class and the identities of its fields."""
    if not operand_shapes(shape):
        return type(shape), id(shape)
    # Moved copies share the very objects of their fields. Small texts may be equal without being one object.
    values = [getattr(shape, name) for name in argument_fields(type(shape))]
    return type(shape), *(repr(value) if isinstance(value, str) else _ids(value) for value in values)


def _ids(value: Any) -> Any:
    return tuple(map(id, value)) if isinstance(value, tuple) else id(value)


def body_data(body: Body, writer: ShapeWriter) -> dict[str, Any]:
    """Return one entry of `bodies`; a motion stands beside the shape, not in it."""
    data: dict[str, Any] = {"name": body.name} if body.name is not None else {}
    shape = writer.data(body.shape)
    if isinstance(shape, dict):
        move = shape.pop("move", None)
        shape = shape.get("shape", shape)
        data |= {"shape": shape} | ({"move": move} if move else {})
    else:
        data["shape"] = shape
    if body.materials is not None:
        names = [None if each is None else writer.material(each) for each in body.materials]
        return data | {"materials": names, "material_index": writer.index(body.material_index)}
    return data | ({"material": writer.material(body.material)} if body.material is not None else {})


def _step_data(step: Any) -> dict[str, Any]:
    if isinstance(step, Translate):
        return {"translate": list(step.offset)}
    if isinstance(step, Rotate):
        return {"rotate": {"axis": list(step.axis), "degrees": step.degrees}}
    if isinstance(step, Scale):
        x, y, z = step.factors
        return {"scale": x if repr(x) == repr(y) == repr(z) else [x, y, z]}
    if isinstance(step, Transform):
        return {"transform": [list(row) for row in step.matrix]}
    raise TypeError(f"a scene file has no step for {type(step).__name__}")
