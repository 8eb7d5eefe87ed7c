"""A body: a shape with a material and a name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .base import Shape
from .elsewhere import no_attribute
from .material import as_material
from .validate import shown, what


@dataclass(frozen=True)
class Body:
    """One entry of a scene.

    shape: a solid or a sheet; a `Spheres` is one entry and many bodies.
    material: a Material; or a colour, which is the matte one: "red" is matte("red"). None is the default matte one.
    name: a text, unique in a scene, or None.

    Raises TypeError for anything else.
    """

    shape: Shape
    material: Any = None
    name: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            raise TypeError(f"Body: shape must be a shape such as Sphere(...), got {what(self.shape)}")
        if self.material is not None:
            object.__setattr__(self, "material", as_material("Body", self.material))
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise ValueError(f"Body: name must be a non-empty text or None, got {shown(self.name)}")

    if not TYPE_CHECKING:  # else checkers would let any attribute be asked for

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name)
