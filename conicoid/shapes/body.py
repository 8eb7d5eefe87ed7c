"""A body: a shape with a material and a name."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .base import Shape
from .body_materials import checked_materials
from .calls import explained_methods
from .carried import restore
from .elsewhere import no_attribute, no_operator
from .fixed import fixed
from .makers import as_material
from .material import Material
from .validate import shown, what


@fixed
@explained_methods
@dataclass(frozen=True)
class Body:
    """One entry of a scene.

    shape: a solid or a sheet; a `Spheres`, `Cylinders` and so on is one entry and many bodies.
    material: a Material; or a colour, which is the matte one: "red" is matte("red"). None is the default matte one.
    name: a text, unique in a scene, or None.
    materials: of many bodies in one entry, what takes the place of `material`: materials and colours, with
    material_index: (N,) for each body its place among them. Left out, there is one of the materials for each body.

    Raises TypeError for anything else, ValueError for an index that there is not.
    """

    shape: Shape
    material: Any = None
    name: str | None = None
    materials: Any = field(default=None, kw_only=True)
    material_index: Any = field(default=None, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            hint = "; co.Union(shapes) is one of several" if isinstance(self.shape, list | tuple) else ""
            raise TypeError(f"Body: shape must be a shape such as Sphere(...), got {what(self.shape)}{hint}")
        if isinstance(self.material, list | tuple) and any(isinstance(one, str | Material) for one in self.material):
            told = "Body(shape, materials=[...]), with material_index, are those of many bodies in one entry"
            raise TypeError(f"Body: material must be one, got a {type(self.material).__name__} of them; {told}")
        if self.material is not None:
            object.__setattr__(self, "material", as_material("Body", self.material, _meant_as_name(self)))
        if self.materials is not None or self.material_index is not None:
            materials, index = checked_materials(self.shape, self.material, self.materials, self.material_index)
            object.__setattr__(self, "materials", materials)
            object.__setattr__(self, "material_index", index)
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise ValueError(f"Body: name must be a non-empty text or None, got {shown(self.name)}")

    def __eq__(self, other: object) -> bool:
        """Whether it is a body of an equal shape, material and name."""
        if isinstance(other, np.ndarray | np.generic):  # which would be False throughout
            raise TypeError(
                "Body: numbers and names are no bodies: compare hits.name == body.name, or hits.body == number"
            )
        if not isinstance(other, Body):
            return NotImplemented
        mine, its = ((one.shape, one.material, one.name, one.materials) for one in (self, other))
        return mine == its and np.array_equal(self.material_index, other.material_index)

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore(self, state)

    __array_ufunc__ = None  # so that arrays ask the body

    def translate(self, offset: Any) -> Body:
        """The body, moved by `offset`, three numbers: its shape is."""
        return dataclasses.replace(self, shape=self.shape.translate(offset))

    def rotate(self, axis: Any, degrees: float, *, about: Any = None) -> Body:
        """The body, turned by `degrees` about an `axis` through the origin or the point `about`, as a shape is."""
        return dataclasses.replace(self, shape=self.shape.rotate(axis, degrees, about=about))

    def scale(self, factors: Any, *, about: Any = None) -> Body:
        """The body, scaled by `factors` about the origin or the point `about`, as a shape is."""
        return dataclasses.replace(self, shape=self.shape.scale(factors, about=about))

    def transform(self, matrix: Any) -> Body:
        """The body, carried by an affine motion: a `matrix` (4, 4), as a shape is."""
        return dataclasses.replace(self, shape=self.shape.transform(matrix))

    if not TYPE_CHECKING:  # else checkers would let any attribute be asked for, and any operator be used

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name)

        def __contains__(self, other: Any) -> bool:
            told = "points are asked of a scene: co.Scene(body).contains(points)"
            raise TypeError(f"Body: `in` means nothing here; {told}")

        def __or__(self, other: Any) -> Any:
            return _no_operator(self, "|", other)

        def __and__(self, other: Any) -> Any:
            return _no_operator(self, "&", other)

        def __sub__(self, other: Any) -> Any:
            return _no_operator(self, "-", other)

        def __add__(self, other: Any) -> Any:
            return _no_operator(self, "+", other)


def _meant_as_name(body: Body) -> str:
    """What to tell of a text that is no colour where a material is wanted."""
    if not isinstance(body.material, str) or body.name is not None:
        return ""
    return f"; a name is the third, Body(shape, name={shown(body.material)})"


def _no_operator(body: Body, operator: str, other: Any) -> Any:
    """NotImplemented, unless there is something to tell."""
    told = no_operator(body, operator, other)
    if told is None:
        return NotImplemented
    raise told
