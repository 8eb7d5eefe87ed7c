"""Exact ray tracing of quadric solids: spheres, cylinders, cones, all quadrics, and their Boolean combinations.

import conicoid as co

scene = co.Scene([co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)])
hits = scene.first_hit((0.7, 0, 5), (0, 0, -1))
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Public name -> module that defines it. Loaded on first use, so that importing the package is quick.
_SHAPES = {
    "Box": "box", "Cone": "cone", "Cylinder": "cylinder", "CylinderPatch": "cylinder_patch", "Disc": "disc",
    "DoubleCone": "double_cone", "Ellipsoid": "ellipsoid", "EllipticCone": "elliptic_cone",
    "EllipticCylinder": "elliptic_cylinder", "EllipticParaboloid": "elliptic_paraboloid", "HalfSpace": "half_space",
    "HyperbolicCylinder": "hyperbolic_cylinder", "HyperbolicParaboloid": "hyperbolic_paraboloid",
    "OneSheetHyperboloid": "one_sheet_hyperboloid", "ParabolicCylinder": "parabolic_cylinder", "Plane": "plane",
    "Polygon": "polygon", "Polyhedron": "polyhedron", "Quadric": "quadric", "Sphere": "sphere", "Spheres": "spheres",
    "Boxes": "bulk_solids", "Capsules": "bulk_solids", "Cones": "bulk_solids", "Cylinders": "bulk_solids",
    "Ellipsoids": "bulk_solids", "Discs": "bulk_sheets", "Triangles": "bulk_sheets",
    "Mesh": "mesh", "Extrusion": "mesh", "Revolution": "revolution",
    "Tube": "tube", "Polycone": "polycone", "SphereSection": "sphere_section", "Trapezoid": "trapezoid",
    "Wedge": "trapezoid", "RegularPrism": "regular_prism", "Pyramid": "regular_prism",
    "Parallelepiped": "parallelepiped",
    "Triangle": "triangle", "TwoSheetHyperboloid": "two_sheet_hyperboloid",
    "Union": "region", "Intersection": "region", "Difference": "region", "Complement": "region",
    "Painted": "region",
    "Conic": "conic", "ConicSheet": "conic", "Lens": "lens", "Mirror": "lens", "Stop": "stop", "Wall": "wall",
    "Prism": "prism", "PentaPrism": "prism", "CornerCube": "prism",
    "LensGroup": "lens_group", "Doublet": "lens_group",
    "Shape": "base", "Solid": "base", "Sheet": "base", "Body": "body",
    "Material": "material", "matte": "looks", "phong": "looks", "blinn_phong": "looks", "lacquer": "looks",
    "mirror": "looks", "glass": "looks", "metal": "looks", "glow": "looks", "plastic": "looks",
    "conductor": "metals", "gold": "metals", "silver": "metals", "copper": "metals", "aluminium": "metals",
    "iron": "metals", "fog": "looks",
    "AIR": "material", "WATER": "material", "GLASS": "material", "VACUUM": "material", "Checker": "checker",
    "ImageTexture": "texture", "Gradient": "texture", "Noise": "texture", "Wood": "texture", "Brick": "texture",
    "AmbientLight": "light", "DirectionalLight": "light", "PointLight": "light", "SpotLight": "light",
    "Environment": "background", "Sky": "background", "clear_sky": "clear_sky",
    "BodyTrack": "animation", "CameraTrack": "animation", "LightTrack": "animation",
}  # fmt: skip
_HOMES = {name: f".shapes.{module}" for name, module in _SHAPES.items()} | {
    "Scene": ".scene", "Image": ".image", "Camera": ".render.camera", "OrthographicCamera": ".render.camera",
    "EquirectangularCamera": ".render.wide_cameras", "FisheyeCamera": ".render.wide_cameras",
    "Rays": ".engine.answers.rays", "Hits": ".engine.answers.hits", "Spans": ".engine.answers.spans",
    "Crossings": ".engine.answers.spans", "Distances": ".engine.answers.distances",
    "BodiesAt": ".engine.answers.bodies_at", "Slice": ".slices.slice", "Outline": ".slices.outline",
    "Voxels": ".slices.voxels",
    "fresnel": ".shapes.fresnel", "trace_paths": ".optics.tracing",
    "reflect": ".shading.optics", "refract": ".shading.optics", "set_threads": ".engine.threads",
    "load": ".files", "save": ".files", "load_openmc": ".files", "SceneFileError": ".formats.errors",
    "Explanation": ".explain.explanation", "SceneSurface": ".explain.surfaces",
    "check": ".checks.check", "Finding": ".checks.finding",
    "Findings": ".checks.finding",
    "measure": ".measures.measure", "Measures": ".measures.measure",
    "SceneMeasures": ".measures.scene_measures",
    "molecule": ".molecules", "Molecule": ".molecules",
    "turntable": ".turntables.turntable", "animate": ".turntables.animation",
    "export": ".viewer.html", "warmup": ".warmup", "parameters": ".derivatives.parameters",
}  # fmt: skip

_PACKAGES = ("cluster", "ct", "derivatives", "optics")
"""Public names that are packages themselves."""

__all__ = ["__version__", *sorted(_HOMES)]  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from . import cluster as cluster
    from . import ct as ct
    from . import derivatives as derivatives
    from . import optics as optics
    from .checks.check import check as check
    from .checks.finding import Finding as Finding
    from .checks.finding import Findings as Findings
    from .derivatives.parameters import parameters as parameters
    from .engine.answers.bodies_at import BodiesAt as BodiesAt
    from .engine.answers.distances import Distances as Distances
    from .engine.answers.hits import Hits as Hits
    from .engine.answers.rays import Rays as Rays
    from .engine.answers.spans import Crossings as Crossings
    from .engine.answers.spans import Spans as Spans
    from .engine.threads import set_threads as set_threads
    from .explain.explanation import Explanation as Explanation
    from .explain.surfaces import SceneSurface as SceneSurface
    from .files import load as load
    from .files import load_openmc as load_openmc
    from .files import save as save
    from .formats.errors import SceneFileError as SceneFileError
    from .image import Image as Image
    from .measures.measure import Measures as Measures
    from .measures.measure import measure as measure
    from .measures.scene_measures import SceneMeasures as SceneMeasures
    from .molecules import Molecule as Molecule
    from .molecules import molecule as molecule
    from .optics.tracing import trace_paths as trace_paths
    from .render.camera import Camera as Camera
    from .render.camera import OrthographicCamera as OrthographicCamera
    from .render.wide_cameras import EquirectangularCamera as EquirectangularCamera
    from .render.wide_cameras import FisheyeCamera as FisheyeCamera
    from .scene import Scene as Scene
    from .shading.optics import reflect as reflect
    from .shading.optics import refract as refract
    from .shapes.animation import BodyTrack as BodyTrack
    from .shapes.animation import CameraTrack as CameraTrack
    from .shapes.animation import LightTrack as LightTrack
    from .shapes.background import Environment as Environment
    from .shapes.background import Sky as Sky
    from .shapes.base import Shape as Shape
    from .shapes.base import Sheet as Sheet
    from .shapes.base import Solid as Solid
    from .shapes.body import Body as Body
    from .shapes.box import Box as Box
    from .shapes.bulk_sheets import Discs as Discs
    from .shapes.bulk_sheets import Triangles as Triangles
    from .shapes.bulk_solids import Boxes as Boxes
    from .shapes.bulk_solids import Capsules as Capsules
    from .shapes.bulk_solids import Cones as Cones
    from .shapes.bulk_solids import Cylinders as Cylinders
    from .shapes.bulk_solids import Ellipsoids as Ellipsoids
    from .shapes.checker import Checker as Checker
    from .shapes.clear_sky import clear_sky as clear_sky
    from .shapes.cone import Cone as Cone
    from .shapes.conic import Conic as Conic
    from .shapes.conic import ConicSheet as ConicSheet
    from .shapes.cylinder import Cylinder as Cylinder
    from .shapes.cylinder_patch import CylinderPatch as CylinderPatch
    from .shapes.disc import Disc as Disc
    from .shapes.double_cone import DoubleCone as DoubleCone
    from .shapes.ellipsoid import Ellipsoid as Ellipsoid
    from .shapes.elliptic_cone import EllipticCone as EllipticCone
    from .shapes.elliptic_cylinder import EllipticCylinder as EllipticCylinder
    from .shapes.elliptic_paraboloid import EllipticParaboloid as EllipticParaboloid
    from .shapes.fresnel import fresnel as fresnel
    from .shapes.half_space import HalfSpace as HalfSpace
    from .shapes.hyperbolic_cylinder import HyperbolicCylinder as HyperbolicCylinder
    from .shapes.hyperbolic_paraboloid import HyperbolicParaboloid as HyperbolicParaboloid
    from .shapes.lens import Lens as Lens
    from .shapes.lens import Mirror as Mirror
    from .shapes.lens_group import Doublet as Doublet
    from .shapes.lens_group import LensGroup as LensGroup
    from .shapes.light import AmbientLight as AmbientLight
    from .shapes.light import DirectionalLight as DirectionalLight
    from .shapes.light import PointLight as PointLight
    from .shapes.light import SpotLight as SpotLight
    from .shapes.looks import blinn_phong as blinn_phong
    from .shapes.looks import fog as fog
    from .shapes.looks import glass as glass
    from .shapes.looks import glow as glow
    from .shapes.looks import lacquer as lacquer
    from .shapes.looks import matte as matte
    from .shapes.looks import metal as metal
    from .shapes.looks import mirror as mirror
    from .shapes.looks import phong as phong
    from .shapes.looks import plastic as plastic
    from .shapes.material import AIR as AIR
    from .shapes.material import GLASS as GLASS
    from .shapes.material import VACUUM as VACUUM
    from .shapes.material import WATER as WATER
    from .shapes.material import Material as Material
    from .shapes.mesh import Extrusion as Extrusion
    from .shapes.mesh import Mesh as Mesh
    from .shapes.metals import aluminium as aluminium
    from .shapes.metals import conductor as conductor
    from .shapes.metals import copper as copper
    from .shapes.metals import gold as gold
    from .shapes.metals import iron as iron
    from .shapes.metals import silver as silver
    from .shapes.one_sheet_hyperboloid import OneSheetHyperboloid as OneSheetHyperboloid
    from .shapes.parabolic_cylinder import ParabolicCylinder as ParabolicCylinder
    from .shapes.parallelepiped import Parallelepiped as Parallelepiped
    from .shapes.plane import Plane as Plane
    from .shapes.polycone import Polycone as Polycone
    from .shapes.polygon import Polygon as Polygon
    from .shapes.polyhedron import Polyhedron as Polyhedron
    from .shapes.prism import CornerCube as CornerCube
    from .shapes.prism import PentaPrism as PentaPrism
    from .shapes.prism import Prism as Prism
    from .shapes.quadric import Quadric as Quadric
    from .shapes.region import Complement as Complement
    from .shapes.region import Difference as Difference
    from .shapes.region import Intersection as Intersection
    from .shapes.region import Painted as Painted
    from .shapes.region import Union as Union
    from .shapes.regular_prism import Pyramid as Pyramid
    from .shapes.regular_prism import RegularPrism as RegularPrism
    from .shapes.revolution import Revolution as Revolution
    from .shapes.sphere import Sphere as Sphere
    from .shapes.sphere_section import SphereSection as SphereSection
    from .shapes.spheres import Spheres as Spheres
    from .shapes.stop import Stop as Stop
    from .shapes.texture import Brick as Brick
    from .shapes.texture import Gradient as Gradient
    from .shapes.texture import ImageTexture as ImageTexture
    from .shapes.texture import Noise as Noise
    from .shapes.texture import Wood as Wood
    from .shapes.trapezoid import Trapezoid as Trapezoid
    from .shapes.trapezoid import Wedge as Wedge
    from .shapes.triangle import Triangle as Triangle
    from .shapes.tube import Tube as Tube
    from .shapes.two_sheet_hyperboloid import TwoSheetHyperboloid as TwoSheetHyperboloid
    from .shapes.wall import Wall as Wall
    from .slices.outline import Outline as Outline
    from .slices.slice import Slice as Slice
    from .slices.voxels import Voxels as Voxels
    from .turntables.animation import animate as animate
    from .turntables.turntable import turntable as turntable
    from .viewer.html import export as export
    from .warmup import warmup as warmup


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if name in _PACKAGES:
        return importlib.import_module(f".{name}", __name__)
    if home is None:
        raise AttributeError(f"module 'conicoid' has no attribute {name[:80]!r}{_meant(name)}")
    value = getattr(importlib.import_module(home, __name__), name)
    if isinstance(value, type):
        from .shapes.calls import explain

        explain(value)
    globals()[name] = value
    return value


def _meant(name: str) -> str:
    """What to tell of a name that there is not."""
    if name.startswith("_"):
        return ""
    from .shapes.elsewhere import no_attribute_of_package
    from .shapes.suggestion import close_to

    close = close_to(name, __all__, 0.7)
    return no_attribute_of_package(name) or (f" (did you mean {close}?)" if close else "")


def __dir__() -> list[str]:
    return sorted([*__all__, *_PACKAGES])
