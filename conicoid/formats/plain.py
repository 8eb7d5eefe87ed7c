"""A scene as numbers, texts, lists and mappings: what a scene file says, before it is written."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain, count
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..shapes import Shape
from ..shapes.background import Environment
from ..shapes.body import Body
from ..shapes.bulk import Bulk
from ..shapes.image_file import Pixels
from ..shapes.makers import spelled
from ..shapes.material import Material
from ..shapes.motion import Motion, Rotate, Scale, Transform, Translate
from ..shapes.properties import Properties
from ..shapes.texture import ImagePath, ImageTexture
from ..shapes.validate import shown
from .expansion import parts_of
from .fields import fields_of
from .kinds import Several
from .shape_nodes import operand_field
from .yaml_writer import Real

INLINE_BODIES = 100
MOST_NUMBERS = 1_000_000
"""Of an environment's pixels in the scene file itself, which holds four million values at most."""
LEVELS_INLINE = 20

Identity: TypeAlias = tuple[Any, ...]

KeepTable = Callable[[str, Any], str]
"""Writes an array to a file, for what it is of (`spheres`), and returns its name."""


class ShapeWriter:
    """Turns shapes into data. A Boolean stands under a name if it is used more than once, moved or not, or is deep.

    Materials stand under names, equal ones once.
    """

    def __init__(
        self,
        shapes: Iterable[Shape],
        keep_table: KeepTable,
        defaults: bool = False,
        material_names: Mapping[Material, str] | None = None,
        folder: Path | None = None,
    ) -> None:
        self.keep_table = keep_table
        self.folder = folder  # of the file, by which pictures are named; without one their mean colours are written
        self.defaults = defaults  # are a shape's fields at their defaults written too?
        self.named: dict[str, Any] = {}
        self.names: dict[Identity, str] = {}
        self.materials: dict[str, Any] = {}
        self.material_names = {material.exactly: name for material, name in (material_names or {}).items()}
        self.taken = set(self.material_names.values())
        self.letters = (name for name in map(_lettered, count()) if name not in self.taken)
        uses: Counter[Identity] = Counter()
        heights: dict[Identity, int] = {}
        for shape in list(parts_first(shapes, uses)):
            key = identity(shape)
            height = 1 + max((heights[identity(part)] for part in parts_of(shape)), default=-1)
            heights[key] = height
            if height and (uses[key] > 1 or height % LEVELS_INLINE == 0):
                written = {type(shape).__name__: self._fields(shape)}
                self.names[key] = f"shape {len(self.named) + 1}"
                self.named[self.names[key]] = written

    def data(self, shape: Shape) -> Any:
        """``{ClassName: fields, move: steps}``, or a reference to a shape that stands under a name."""
        move = {"move": steps(shape.motion)} if shape.motion.steps else {}
        name = self.names.get(identity(shape))
        if name is None:
            return {type(shape).__name__: self._fields(shape)} | move
        return {"shape": name} | move if move else name

    def _fields(self, shape: Shape) -> Any:
        if isinstance(shape, Bulk):
            return self._many(shape)
        kind = operand_field(type(shape))
        if kind is None:
            return self.record(shape)
        operands = [self.data(part) for part in parts_of(shape)]
        return operands if isinstance(kind, Several) else operands[0]

    def _many(self, shape: Bulk) -> dict[str, Any]:
        if len(shape) > INLINE_BODIES:
            return {"file": self.keep_table(type(shape).__name__.lower(), shape.table())}
        return {name: getattr(shape, name).tolist() for name in shape.columns}

    def index(self, values: Any) -> Any:
        """The places of many bodies' materials."""
        return {"file": self.keep_table("materials", values)} if len(values) > INLINE_BODIES else values.tolist()

    def record(self, item: Any) -> dict[str, Any]:
        """The arguments that rebuild a dataclass, those at their defaults left out (or those that are None)."""
        made_by: Any = type(item)
        values = {name: (getattr(item, name), field) for name, field in fields_of(made_by).items()}
        return {
            name: self.value(value)
            for name, (value, field) in values.items()
            if field.required or repr(value) != repr(field.default) or (self.defaults and value is not None)
        }

    def surroundings(self, given: Environment) -> Any:
        """The pixels of an environment: the name of their file, or all numbers of a small one."""
        pixels: Any = given.pixels
        if self.folder is None:
            return pixels.tolist()
        if given.file is not None and Path(given.file).resolve().is_relative_to(self.folder):
            return picture_name(given.file, self.folder)
        if pixels.size > MOST_NUMBERS:
            told = "co.Image(pixels).save('sky.exr') makes one" if given.file is None else f"copy {given.file!r} there"
            raise ValueError(
                "Environment: pixels must be in a file in the folder of the scene file, or below, to stand in one, "
                f"where they are more than {MOST_NUMBERS:,} numbers: {told}"
            )
        return pixels.tolist()

    def material(self, material: Any) -> str:
        """The name under which a material stands."""
        key = material.exactly
        if key not in self.material_names:
            self.material_names[key] = self._free_name(material)
            self.taken.add(self.material_names[key])
        name = self.material_names[key]
        if name not in self.materials:
            self.materials[name] = self._made_material(material, name)
        return name

    def _made_material(self, material: Material, key: str) -> dict[str, Any]:
        """The function that made it, with its arguments. The key is its name, unless they say another, or none."""
        maker, given = spelled(material)
        given.pop("name", None)
        own = {} if material.name == key else {"name": material.name}
        return {maker: {name: self.value(value) for name, value in (given | own).items()}}

    def _free_name(self, material: Material) -> str:
        """Its own; with a number where that is taken; without one, letters."""
        if material.name is None:
            return next(self.letters)
        numbered = (f"{material.name} ({number})" for number in count(2))
        return next(name for name in chain([material.name], numbered) if name not in self.taken)

    def value(self, value: Any) -> Any:
        """Any field: shapes and records by their class name, materials by name, arrays and tuples as lists."""
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
            return {name: Real(item) if isinstance(item, float) else self.value(item) for name, item in value.items()}
        if isinstance(value, Mapping):
            return {str(key): self.value(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.value(item) for item in value]
        if callable(value):
            raise ValueError(
                "Material: refractive_index must be a number, the name of a glass, a formula or a table to stand in a "
                f"scene file, got a function, {shown(value)}"
            )
        return value


def picture_name(path: str, folder: Path | None) -> str:
    """The name of a picture's file as a scene file in a folder says it."""
    final = Path(path).resolve()
    if folder is not None and not final.is_relative_to(folder):
        raise ValueError(
            f"ImageTexture: image must lie in the folder of the scene file, or below, got {path!r}: copy it there"
        )
    return final.as_posix() if folder is None else final.relative_to(folder).as_posix()


def _lettered(number: int) -> str:
    """material A, material B, ... material Z, material AA: no number, which might be taken for an importer's."""
    letters = ""
    while number >= 0:
        letters = chr(ord("A") + number % 26) + letters
        number = number // 26 - 1
    return f"material {letters}"


def parts_first(shapes: Iterable[Shape], uses: Counter[Identity]) -> Iterator[Shape]:
    """Each shape once, after the shapes it is made of; `uses` counts how often it occurs. No recursion."""
    pending = [(shape, False) for shape in shapes][::-1]
    while pending:
        shape, parts_done = pending.pop()
        if parts_done:
            yield shape
            continue
        uses[identity(shape)] += 1
        if uses[identity(shape)] == 1:
            pending.append((shape, True))
            pending.extend((part, False) for part in reversed(parts_of(shape)))


def identity(shape: Shape) -> Identity:
    """What is the same for a shape and its moved copies: its class and the very objects it is made of."""
    if not parts_of(shape):
        return type(shape), id(shape)
    values = [getattr(shape, name) for name in fields_of(type(shape))]
    return type(shape), *(repr(value) if isinstance(value, str) else _ids(value) for value in values)


def _ids(value: Any) -> Any:
    return tuple(map(id, value)) if isinstance(value, tuple) else id(value)


def body_data(body: Body, writer: ShapeWriter) -> dict[str, Any]:
    """One entry of `bodies`; a motion stands beside the shape, not in it."""
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


def steps(motion: Motion) -> list[Any]:
    """The steps of a motion as a user would write them."""
    return [_step(step) for step in motion.steps]


def _step(step: Any) -> dict[str, Any]:
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
