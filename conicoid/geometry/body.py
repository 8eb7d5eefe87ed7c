"""`Body`: a shape with a material and a name, one entry of a scene."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import VectorLike
from .._util.records import dataclass, restore_state
from .._util.text import html_table, unknown_attribute
from .._util.validation import describe_kind, format_value, real_array
from ..materials.presets import as_material
from .bulk import Bulk
from .shape import Shape

MaterialIndex = npt.NDArray[np.int32]


def check_materials(count: int, material: Any, materials: Any, index: Any) -> tuple[tuple[Any, ...], MaterialIndex]:
    """Return (materials, the index of each body's material) of an entry of `count` bodies.

    Raise TypeError for no list of materials, ValueError for an index that does not fit.
    """
    if material is not None:
        raise ValueError("Body: material must be left out where materials are given")
    if materials is None:
        raise ValueError("Body: material_index must be left out, or go with materials")
    if isinstance(materials, (str, bytes)) or not isinstance(materials, Iterable):
        raise TypeError(f"Body: materials must be a list of materials and colours, got {describe_kind(materials)}")
    checked = tuple(
        None if each is None else as_material(f"Body: materials[{i}]", each) for i, each in enumerate(materials)
    )
    return checked, _check_index(index, len(checked), count)


def _check_index(index: Any, materials: int, bodies: int) -> MaterialIndex:
    if index is None:
        if materials != bodies:
            found = f"{materials:,} materials for {bodies:,} bodies"
            raise ValueError(f"Body: materials must be as many as bodies where there is no material_index, got {found}")
        index = np.arange(bodies)
    values = real_array("Body", "material_index", index)
    if not (values == np.floor(values)).all():
        raise ValueError(f"Body: material_index must be integers, got {format_value(index)}")
    if values.shape != (bodies,):
        raise ValueError(f"Body: material_index must have shape ({bodies},) as there are bodies, got {values.shape}")
    bad = np.flatnonzero((values < 0) | (values >= materials))
    if len(bad):
        found = f"at least 0 and below {materials}, got {values[bad[0]]:g}"
        raise ValueError(f"Body: material_index[{bad[0]}] must be {found}")
    result = values.astype(np.int32)
    result.flags.writeable = False
    return result


@dataclass(frozen=True)
class Body:
    """One entry of a scene: a shape with a material and a name.

    Parameters
    ----------
    shape : Shape
        A solid or a sheet. A `Spheres`, `Cylinders` and so on is one entry and many bodies.
    material : Material or colour, optional
        A colour is the matte material: "red" is matte("red"). None is the default, matte grey.
    name : str, optional
        Unique in a scene.
    materials : list of Material or colour, optional
        For an entry of many bodies, in place of `material`.
    material_index : array (N,), optional
        For each body the index of its material in `materials`. Without it there is one of these for each body.

    Raises
    ------
    TypeError
        For an argument of another type.
    ValueError
        For an index without a material, or an empty name.
    """

    shape: Shape
    material: Any = None
    name: str | None = None
    materials: Any = field(default=None, kw_only=True)
    material_index: Any = field(default=None, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            raise TypeError(f"Body: shape must be a shape such as Sphere(...), got {describe_kind(self.shape)}")
        if self.material is not None:
            object.__setattr__(self, "material", as_material("Body", self.material))
        if self.materials is not None or self.material_index is not None:
            if not isinstance(self.shape, Bulk):
                found = describe_kind(self.shape)
                raise TypeError(f"Body: materials are for many bodies in one entry, such as Spheres, got {found}")
            materials, index = check_materials(len(self.shape), self.material, self.materials, self.material_index)
            vars(self).update(materials=materials, material_index=index)
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise ValueError(f"Body: name must be a non-empty text or None, got {format_value(self.name)}")

    def __eq__(self, other: object) -> bool:
        """Return True for a body with equal shape, material and name."""
        if isinstance(other, np.ndarray | np.generic):  # no element could be equal
            raise TypeError(
                "Body: numbers and names are no bodies: compare hits.name == body.name, or hits.body == number"
            )
        if not isinstance(other, Body):
            return NotImplemented
        mine, its = ((one.shape, one.material, one.name, one.materials) for one in (self, other))
        return mine == its and np.array_equal(self.material_index, other.material_index)

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)

    __array_ufunc__ = None  # so that `array == body` calls `Body.__eq__`

    def translate(self, offset: VectorLike) -> Body:
        """Return the body with its shape moved by `offset`, three numbers."""
        return dataclasses.replace(self, shape=self.shape.translate(offset))

    def rotate(self, axis: str | VectorLike, degrees: float, *, about: VectorLike | None = None) -> Body:
        """Return the body turned by `degrees` about an `axis` through the origin or the point `about`.

        Parameters
        ----------
        axis, degrees, about
            As for `Shape.rotate`.
        """
        return dataclasses.replace(self, shape=self.shape.rotate(axis, degrees, about=about))

    def scale(self, factors: float | VectorLike, *, about: VectorLike | None = None) -> Body:
        """Return the body scaled by `factors` about the origin or the point `about`, as `Shape.scale` does."""
        return dataclasses.replace(self, shape=self.shape.scale(factors, about=about))

    def transform(self, matrix: Any) -> Body:
        """Return the body carried by an affine motion, a `matrix` (4, 4), as `Shape.transform` does."""
        return dataclasses.replace(self, shape=self.shape.transform(matrix))

    if not TYPE_CHECKING:  # type checkers would otherwise accept any attribute

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(self, name)


def bodies_table(bodies: Sequence[Body]) -> str:
    """Return the table of entries that a notebook shows."""
    rows = (
        (number, body.name, type(body.shape).__name__, getattr(body.material, "name", None) or body.material)
        for number, body in enumerate(bodies)
    )
    return html_table(("entry", "name", "shape", "material"), rows, len(bodies))
