"""The registry of shapes: scene-file name -> class, for every shape of scene files."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterator, Mapping

from .shape import REGISTERED, Shape

_MODULES = {
    "Box": "primitives",
    "Discs": "bulk",
    "Triangles": "bulk",
    "Cylinders": "bulk",
    "Capsules": "bulk",
    "Cones": "bulk",
    "Ellipsoids": "bulk",
    "Boxes": "bulk",
    "Cone": "primitives",
    "Conic": "conic",
    "ConicSheet": "conic",
    "Cylinder": "primitives",
    "CylinderPatch": "sheets",
    "Disc": "sheets",
    "DoubleCone": "quadrics",
    "Ellipsoid": "quadrics",
    "EllipticCone": "quadrics",
    "EllipticCylinder": "quadrics",
    "EllipticParaboloid": "quadrics",
    "HalfSpace": "primitives",
    "HyperbolicCylinder": "quadrics",
    "HyperbolicParaboloid": "quadrics",
    "Lens": "optical_elements",
    "Mirror": "optical_elements",
    "Mesh": "polyhedron",
    "Extrusion": "polyhedron",
    "OneSheetHyperboloid": "quadrics",
    "ParabolicCylinder": "quadrics",
    "Parallelepiped": "prismatoids",
    "Plane": "sheets",
    "Polycone": "revolution",
    "Polygon": "sheets",
    "Polyhedron": "polyhedron",
    "Prism": "optical_elements",
    "PentaPrism": "optical_elements",
    "CornerCube": "optical_elements",
    "Quadric": "general_quadric",
    "Union": "shape",
    "Intersection": "shape",
    "Difference": "shape",
    "Complement": "shape",
    "Painted": "shape",
    "ClippedSheet": "shape",
    "RegularPrism": "prismatoids",
    "Pyramid": "prismatoids",
    "Revolution": "revolution",
    "Sphere": "primitives",
    "SphereSection": "revolution",
    "Spheres": "bulk",
    "Stop": "conic",
    "Trapezoid": "prismatoids",
    "Wedge": "prismatoids",
    "Triangle": "sheets",
    "Tube": "primitives",
    "TwoSheetHyperboloid": "quadrics",
    "Wall": "sheets",
}
"""Name -> the module that defines it, in the order of the reference. A new shape needs one line here."""


class Registry(Mapping[str, type[Shape]]):
    """Scene-file name -> class, in the order of the table; classes of users come last.

    A lookup imports the module of the name, so that a scene file loads only the shapes it has. If another thread is
    importing the module, the lookup waits for it.
    """

    def __getitem__(self, name: str) -> type[Shape]:
        if not isinstance(name, str):
            raise KeyError(name)
        if name in _MODULES:
            importlib.import_module(f"{__package__}.{_MODULES[name]}")
        elif name not in REGISTERED:
            _import_all()
        return REGISTERED[name]

    def __iter__(self) -> Iterator[str]:
        _import_all()
        return iter([*_MODULES, *(name for name in REGISTERED if name not in _MODULES)])

    def __len__(self) -> int:
        _import_all()
        return len(REGISTERED)

    def __repr__(self) -> str:
        return repr(dict(self))


REGISTRY = Registry()


@functools.cache
def _import_all() -> None:
    for module in sorted(set(_MODULES.values())):
        importlib.import_module(f"{__package__}.{module}")
