"""Exact ray tracing of quadric solids: spheres, cylinders, cones, all quadrics, and their Boolean combinations.

import conicoid as co

scene = co.Scene([co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)])
hits = scene.first_hit((0.7, 0, 5), (0, 0, -1))
"""

from __future__ import annotations

import importlib
import sys
from importlib.machinery import ModuleSpec

from ._util import process as _process  # noqa: F401 - forks wait from here on for the imports of other threads
from ._util.version import __version__

TYPE_CHECKING = False  # `typing` would take as long as all the rest: Ctrl-C finds the command ready soon
if TYPE_CHECKING:
    from types import ModuleType
    from typing import Any

_MODULES = {
    "._util.files": "SceneFileError",
    ".apps.checks.check": "check",
    ".apps.derivatives.parameters": "parameters",
    ".apps.measures.measure": "measure",
    ".apps.optics.refraction": "reflect refract",
    ".geometry.body": "Body",
    ".geometry.bulk": "Boxes Capsules Cones Cylinders Discs Ellipsoids Spheres Triangles",
    ".geometry.conic": "Conic ConicSheet Stop",
    ".geometry.general_quadric": "Quadric",
    ".geometry.optical_elements": "CornerCube Doublet Lens LensGroup Mirror PentaPrism Prism",
    ".geometry.polyhedron": "Extrusion Mesh Polyhedron",
    ".geometry.primitives": "Box Cone Cylinder HalfSpace Sphere Tube",
    ".geometry.prismatoids": "Parallelepiped Pyramid RegularPrism Trapezoid Wedge",
    ".geometry.quadrics": "DoubleCone Ellipsoid EllipticCone EllipticCylinder EllipticParaboloid "
    "HyperbolicCylinder HyperbolicParaboloid OneSheetHyperboloid ParabolicCylinder TwoSheetHyperboloid",
    ".geometry.revolution": "Polycone Revolution SphereSection",
    ".geometry.shape": "Complement Difference Intersection Painted Shape Sheet Solid Union",
    ".geometry.sheets": "CylinderPatch Disc Plane Polygon Triangle Wall",
    ".io.image": "Image",
    ".kernels.threads": "set_threads",
    ".materials.light": "AmbientLight DirectionalLight Environment PointLight Sky SpotLight",
    ".materials.material": "Material",
    ".materials.presets": "blinn_phong fog glass glow lacquer matte metal mirror phong plastic",
    ".materials.texture": "Checker",
    ".queries.device_choice": "set_device",
    ".queries.hits": "Hits",
    ".queries.points": "BodiesAt Distances",
    ".queries.rays": "Rays",
    ".queries.spans": "Crossings Spans",
    ".render.camera": "Camera EquirectangularCamera FisheyeCamera OrthographicCamera",
    ".scene.files": "load load_openmc save",
    ".scene.molecules": "molecule",
    ".scene.movies": "animate turntable",
    ".scene.scene": "Scene",
    ".scene.warmup": "warmup",
    ".viewer.html": "export",
}
"""Module -> the public names that it defines. They are imported on first use, so that `import conicoid` is quick.

Every shape, light and background of scene files is among them, under the word of the files; the others are materials,
what programs call most, and the classes of answers.
"""
_HOMES = {name: module for module, names in _MODULES.items() for name in names.split()}

_PACKAGES = {
    "checks": ".apps.checks",
    "ct": ".apps.ct",
    "derivatives": ".apps.derivatives",
    "explain": ".apps.explain",
    "io": ".io",
    "materials": ".materials",
    "measures": ".apps.measures",
    "optics": ".apps.optics",
    "parallel": ".parallel",
    "scene": ".scene",
    "section": ".apps.section",
}
"""Public package -> its place. Their names are for special purposes, or the classes of results."""
_LAZY_PACKAGES = ("checks", "explain", "materials", "measures", "optics", "scene", "section")
"""Packages whose names an error may look up: these import nothing before a name is used."""

_FORMER_PACKAGES = frozenset(
    "cluster collector colormap command_line compiler emitters engine environment exact files film forks formats image "
    "integrators molecules overlay scattering scene_animation scene_contents scene_edits scene_explained scene_parts "
    "scene_pictures scene_queries shading shapes slices textures turntables warmup".split()
)
"""Modules of development versions, which their pickles name."""


class _PackageFinder:
    """A finder of `sys.meta_path`: `from conicoid.optics import trace` finds the public package, wherever it lies.

    Modules that only development versions had are refused in a sentence, because their pickles name them.
    """

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Return the spec of a public package that lies deeper; raise ModuleNotFoundError for a former module."""
        package, _, rest = name.partition(".")
        if package != __name__:
            return None
        first, _, inner = rest.partition(".")
        lies_deeper = _PACKAGES.get(first, "").count(".") > 1
        if first in _FORMER_PACKAGES or (inner and lies_deeper):
            reason = f"Conicoid {__version__} has none; pickles of development versions must be made anew"
            raise ModuleNotFoundError(f"No module named {name!r}: {reason}", name=name)
        return ModuleSpec(name, _PackageFinder) if lies_deeper else None  # type: ignore[arg-type]

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """Leave the making of the module to the import system."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        """Put the public package in the place of the new module."""
        name = module.__name__
        sys.modules[name] = importlib.import_module(_PACKAGES[name.partition(".")[2]], __name__)


sys.meta_path.insert(0, _PackageFinder)

__all__ = ["__version__", *sorted(_HOMES)]  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from . import io as io, materials as materials, parallel as parallel, scene as scene
    from ._util.files import SceneFileError as SceneFileError
    from .apps import (
        checks as checks,
        ct as ct,
        derivatives as derivatives,
        explain as explain,
        measures as measures,
        optics as optics,
        section as section,
    )
    from .apps.checks.check import check as check
    from .apps.derivatives.parameters import parameters as parameters
    from .apps.measures.measure import measure as measure
    from .apps.optics.refraction import reflect as reflect, refract as refract
    from .geometry.body import Body as Body
    from .geometry.bulk import (
        Boxes as Boxes,
        Capsules as Capsules,
        Cones as Cones,
        Cylinders as Cylinders,
        Discs as Discs,
        Ellipsoids as Ellipsoids,
        Spheres as Spheres,
        Triangles as Triangles,
    )
    from .geometry.conic import Conic as Conic, ConicSheet as ConicSheet, Stop as Stop
    from .geometry.general_quadric import Quadric as Quadric
    from .geometry.optical_elements import (
        CornerCube as CornerCube,
        Doublet as Doublet,
        Lens as Lens,
        LensGroup as LensGroup,
        Mirror as Mirror,
        PentaPrism as PentaPrism,
        Prism as Prism,
    )
    from .geometry.polyhedron import Extrusion as Extrusion, Mesh as Mesh, Polyhedron as Polyhedron
    from .geometry.primitives import (
        Box as Box,
        Cone as Cone,
        Cylinder as Cylinder,
        HalfSpace as HalfSpace,
        Sphere as Sphere,
        Tube as Tube,
    )
    from .geometry.prismatoids import (
        Parallelepiped as Parallelepiped,
        Pyramid as Pyramid,
        RegularPrism as RegularPrism,
        Trapezoid as Trapezoid,
        Wedge as Wedge,
    )
    from .geometry.quadrics import (
        DoubleCone as DoubleCone,
        Ellipsoid as Ellipsoid,
        EllipticCone as EllipticCone,
        EllipticCylinder as EllipticCylinder,
        EllipticParaboloid as EllipticParaboloid,
        HyperbolicCylinder as HyperbolicCylinder,
        HyperbolicParaboloid as HyperbolicParaboloid,
        OneSheetHyperboloid as OneSheetHyperboloid,
        ParabolicCylinder as ParabolicCylinder,
        TwoSheetHyperboloid as TwoSheetHyperboloid,
    )
    from .geometry.revolution import Polycone as Polycone, Revolution as Revolution, SphereSection as SphereSection
    from .geometry.shape import (
        Complement as Complement,
        Difference as Difference,
        Intersection as Intersection,
        Painted as Painted,
        Shape as Shape,
        Sheet as Sheet,
        Solid as Solid,
        Union as Union,
    )
    from .geometry.sheets import (
        CylinderPatch as CylinderPatch,
        Disc as Disc,
        Plane as Plane,
        Polygon as Polygon,
        Triangle as Triangle,
        Wall as Wall,
    )
    from .io.image import Image as Image
    from .kernels.threads import set_threads as set_threads
    from .materials.light import (
        AmbientLight as AmbientLight,
        DirectionalLight as DirectionalLight,
        Environment as Environment,
        PointLight as PointLight,
        Sky as Sky,
        SpotLight as SpotLight,
    )
    from .materials.material import Material as Material
    from .materials.presets import (
        blinn_phong as blinn_phong,
        fog as fog,
        glass as glass,
        glow as glow,
        lacquer as lacquer,
        matte as matte,
        metal as metal,
        mirror as mirror,
        phong as phong,
        plastic as plastic,
    )
    from .materials.texture import Checker as Checker
    from .queries.device_choice import set_device as set_device
    from .queries.hits import Hits as Hits
    from .queries.points import BodiesAt as BodiesAt, Distances as Distances
    from .queries.rays import Rays as Rays
    from .queries.spans import Crossings as Crossings, Spans as Spans
    from .render.camera import (
        Camera as Camera,
        EquirectangularCamera as EquirectangularCamera,
        FisheyeCamera as FisheyeCamera,
        OrthographicCamera as OrthographicCamera,
    )
    from .scene.files import load as load, load_openmc as load_openmc, save as save
    from .scene.molecules import molecule as molecule
    from .scene.movies import animate as animate, turntable as turntable
    from .scene.scene import Scene as Scene
    from .scene.warmup import warmup as warmup
    from .viewer.html import export as export


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if name in _PACKAGES:
        return importlib.import_module(_PACKAGES[name], __name__)
    if home is None:
        raise AttributeError(f"module 'conicoid' has no attribute {name[:80]!r}{_name_hint(name)}")
    value = getattr(importlib.import_module(home, __name__), name)
    globals()[name] = value
    return value


def _name_hint(name: str) -> str:
    """Return what to add to the error for an unknown name: where the name is, or which one was probably meant."""
    if name.startswith("_"):
        return ""
    from ._util.text import closest_name

    for package in _LAZY_PACKAGES:
        if name in importlib.import_module(_PACKAGES[package], __name__).__all__:
            return f": it is co.{package}.{name}"
    close = closest_name(name, __all__, 0.7)
    return f" (did you mean {close}?)" if close else ""


def __dir__() -> list[str]:
    return sorted([*__all__, *_PACKAGES])
