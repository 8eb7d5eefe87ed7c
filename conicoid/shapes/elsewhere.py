"""What is asked of a shape, a body or a scene, and has another name or its place elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .asked_of_scenes import ASKED, OF_CLASSES
from .suggestion import close_to

OF_SCENES = (
    "render", "section", "view", "first_hit", "occluded", "spans", "crossings", "lengths", "line_integral", "contains",
    "body_at", "bodies_at", "slice", "voxels", "stream", "save", "prepare", "fitting_camera", "explain", "distance",
)  # fmt: skip
"""What a scene of the shape can be asked."""
OF_MEASURES = ("volume", "area", "centroid", "inertia")
FUNCTIONS = ("check", "measure", "export", "turntable", "animate")
"""Functions of the package, not methods."""
ELSEWHERE = {
    "move": "translate", "moved": "translate", "translated": "translate", "rotated": "rotate", "scaled": "scale",
    "apply_transform": "transform", "bbox": "bounds", "aabb": "bounds", "bounding_box": "bounds", "extent": "bounds",
    "extents": "bounds",
}  # fmt: skip
"""Names that other systems have, and the ones here."""
_COMBINED = {
    "union": "|", "unite": "|", "add": "|", "intersection": "&", "intersect": "&", "difference": "-", "subtract": "-",
    "cut": "-", "minus": "-",
}  # fmt: skip
_OF_BODIES = ("material", "color", "name")
_OF_PARTS = (
    "radius",
    "radii",
    "low",
    "high",
    "start",
    "end",
    "normal",
    "offset",
    "left",
    "right",
    "a",
    "b",
    "children",
)
"""What primitives have, or two operands elsewhere, that a Boolean does not."""
CLASSES = {
    "Ball": "Sphere", "Cuboid": "Box", "Cube": "Box", "Block": "Box", "Pipe": "Tube", "Tubs": "Tube", "Cons": "Cone",
    "Ray": "Rays", "Hit": "Hits", "Span": "Spans", "Circle": "Disc", "Disk": "Disc", "Group": "Union",
    "Frustum": "Cone", "Light": "PointLight",
    "Tetrahedron": "Polyhedron", "Paraboloid": "EllipticParaboloid", "Hyperboloid": "OneSheetHyperboloid",
    "PerspectiveCamera": "Camera", "Pinhole": "Camera", "PinholeCamera": "Camera", "Texture": "Checker",
    "Checkerboard": "Checker", "EnvironmentMap": "Environment", "Sun": "DirectionalLight",
    "SunLight": "DirectionalLight", "AreaLight": "glow", "Not": "Complement", "And": "Intersection", "Or": "Union",
    "Minus": "Difference", "Plastic": "plastic", "diffuse": "matte", "lambertian": "matte", "Lambertian": "matte",
    "dielectric": "glass", "Dielectric": "glass", "metallic": "metal", "emissive": "glow", "write": "save",
    "dump": "save", "read": "load", "open": "load", "import_openmc": "load_openmc", "from_openmc": "load_openmc",
    "volume": "measure", "validate": "check", "gif": "turntable", "snell": "refract",
    "to_html": "export", "Rectangle": "Polygon", "Square": "Polygon", "Quad": "Polygon",
    "Subtract": "Difference", "Subtraction": "Difference", "Intersect": "Intersection", "Unite": "Union",
    "unite": "Union", "HollowCylinder": "Tube", "Trd": "Trapezoid", "Para": "Parallelepiped",
    "Lambert": "matte", "lambert": "matte",
    "Asphere": "Quadric", "AsphericSurface": "Quadric", "XCone": "EllipticCone",
    "YCone": "EllipticCone", "ZCone": "EllipticCone", "RightCircularCylinder": "Cylinder",
    "RectangularParallelepiped": "Box", "TriangleMesh": "Triangles", "World": "Scene", "RaycastingScene": "Scene",
}  # fmt: skip
"""Classes and functions as they are called elsewhere, and the ones here."""
_OTHERWISE = {
    **dict.fromkeys(("loads", "from_string", "parse", "load_yaml", "from_yaml", "from_dict"),
                    "scenes are read from files, co.load(path), YAML or JSON"),
    **dict.fromkeys(("dumps", "to_yaml", "to_string", "to_json"), "scenes are written to files, scene.save(path)"),
    **dict.fromkeys(("Vector", "Vec3", "vec3", "Point", "Vector3", "Point3", "Vector3D", "Point3D", "Normal3D",
    "array"),
                    "vectors are three numbers, as a tuple, a list or an array"),
    **dict.fromkeys(("Color", "RGB", "rgb", "color"), "colours are texts, 'tomato', or three linear numbers"),
    **dict.fromkeys(("Aperture",), "an aperture is co.Stop(aperture, diameter)"),
    **dict.fromkeys(("Shell", "HollowSphere", "SphericalShell"), "that is co.SphereSection(outer, inner)"),
    **dict.fromkeys(("Torus",), "bodies are made of planes and quadrics, nothing else"),
    **dict.fromkeys(("Fresnel", "fresnel_equations"),
                    "co.refract has directions, and co.fresnel the amounts by polarisation"),
    **dict.fromkeys(("Optic", "Surface", "SurfaceGroup", "Singlet"),
                    "lenses are solids, co.Sphere(r, a) & co.Sphere(r, b), and docs/tutorials/optics.md follows rays "
                    "through them"),
    **dict.fromkeys(("project", "projection", "sinogram", "radon", "forward_project"), "co.ct.project makes sinograms"),
    **dict.fromkeys(("Source", "PointSource", "Beam", "Detector", "Sensor", "Film"),
                    "sources are co.Rays(origins, directions), and detectors shapes that they hit"),
    **dict.fromkeys(("load_dict", "load_file", "load_scene", "read_scene"),
    "co.load(path) reads scene files, YAML or JSON"),
    **dict.fromkeys(("trimesh", "creation", "primitives", "Node", "Ray3f", "variants", "Plotter"),
                    "shapes are co.Sphere(...), co.Box(...) and so on, put in one list, co.Scene([...])"),
    **dict.fromkeys(("rotate_x", "rotate_y", "rotate_z"), 'shapes have motions, shape.rotate("z", degrees)'),
    **dict.fromkeys(("info", "describe", "summary"), "`conicoid info scene.yaml` lists what is in a scene file"),
    **dict.fromkeys(("Hemisphere",), "that is co.SphereSection(r, polar_range=(0, 90))"),
    **dict.fromkeys(("HexagonalPrism", "HexPrism", "Hexagon"), "that is co.RegularPrism(6, radius)"),
    **dict.fromkeys(("HollowCone", "ConicalTube", "ConeSegment"),
                    "that is co.Polycone([(z, inner, outer), (z, inner, outer)])"),
    **dict.fromkeys(("Ring", "Annulus"), "that is co.Disc(center, normal, r) - co.Cylinder(start, end, hole)"),
    **dict.fromkeys(("Capsule",), "that is a co.Cylinder united with a co.Sphere at each end"),
    **dict.fromkeys(("Cell", "Universe", "Lattice", "Geometry", "RectLattice", "HexLattice", "Settings", "Nuclide"),
                    "a cell is a co.Body of a region; co.load_openmc(path) reads whole models"),
    **dict.fromkeys(("XPlane", "YPlane", "ZPlane"), "the inside of -plane is co.HalfSpace(normal, offset)"),
    **dict.fromkeys(("XCylinder", "YCylinder", "ZCylinder"),
                    "co.Cylinder(start, end, radius) has ends, co.EllipticCylinder(1 / r**2, 1 / r**2) has none"),
    **dict.fromkeys(("seed", "set_seed"), "what is random takes a seed, scene.render(seed=1)"),
    **dict.fromkeys(("show", "plot", "display"), "pictures show themselves, scene.render().show()"),
}  # fmt: skip
"""What stands for names that are no class and no function here."""
_ALIKE = 0.75
"""How much a name has in common with the one that may be meant, at least."""
_TRACED = ("intersect", "intersects", "intersection", "trace", "cast", "raycast", "shoot", "hit")
_LONGER = ("add", "append", "extend", "insert", "remove", "add_body", "add_shape")
_MOTIONS = ("translate", "rotate", "scale", "transform", "move")


def no_attribute(thing: object, name: str) -> AttributeError:
    """The error for an attribute that a shape or a body does not have, which says where it is."""
    kind = type(thing).__name__
    return _told(thing, name, _of_shapes(kind.lower(), name) or (_of_bodies(thing, name) if kind == "Body" else ""))


def _of_shapes(it: str, name: str) -> str:
    if name in OF_SCENES:
        return f"a scene has, co.Scene({it}).{name}(...)"
    if name in OF_MEASURES:
        return f"co.measure({it}).{name} is that"
    if name in FUNCTIONS:
        return f"it is a function, co.{name}({it})"
    if name in ("center", "centre") and it == "body":
        return "body.shape.center, or co.measure(body).centroid, is that"
    if name in ("center", "centre", "mass", "surface_area", "center_of_mass"):
        return f"co.measure({it}) has volume, area, centroid and inertia"
    if name in ELSEWHERE:
        return f"it is called {ELSEWHERE[name]}"
    if name in ("rotate_x", "rotate_y", "rotate_z", "rotateX", "rotateY", "rotateZ"):
        return f'axes are named, {it}.rotate("{name[-1].lower()}", degrees)'
    if name in ("mirror", "mirrored", "reflect", "flip", "reflected", "inverted"):
        return f"{it}.scale((-1, 1, 1)) is the mirror image across the plane x = 0, about=... across another"
    if name in _COMBINED and it != "body":
        return f"shapes combine with operators, {it} {_COMBINED[name]} other"
    if name in ("replace", "copy", "_replace", "set", "with_") and it != "body":
        return f"dataclasses.replace({it}, field=...) is another; shapes do not change"
    if name in _OF_BODIES and it != "body":
        return f"a body has that, co.Body({it}, material, name)"
    if it in ("union", "intersection", "difference", "complement", "painted"):
        part = "operand" if it in ("complement", "painted") else "operands[0]"
        return f"{it}.{part} is a shape that it is made of" if name in _OF_PARTS else ""
    return ""


def _of_bodies(body: Any, name: str) -> str:
    """What the shape or the material of a body has."""
    for part in ("shape", "material"):
        found = vars(body).get(part)
        if not name.startswith("_") and (hasattr(type(found), name) or name in getattr(found, "__dict__", ())):
            return f"body.{part}.{name} is that"
    if name in ("density", "mu", "properties", "id", "volume_fraction", "refractive_index"):
        return f"a material has that: body.material.properties[{name!r}], of co.matte(color, properties={{...}})"
    if name in ("number", "index", "body_id"):
        return "a scene numbers its bodies: scene.bodies.index(body), and hits.body and scene.body_at have numbers"
    if name in ("position", "location", "origin", "pos"):
        return "co.measure(body).centroid is its centre, body.shape.bounds the box around it"
    if name in ("replace", "_replace", "with_material", "with_name", "copy", "set_material", "with_shape"):
        return "dataclasses.replace(body, material=...) is another, scene.replace(which, material=...) a scene with it"
    if name in _COMBINED:
        return f"shapes combine, co.Body(a.shape {_COMBINED[name]} b.shape, material)"
    return ""


def no_attribute_of_scene(scene: Any, name: str) -> AttributeError:
    """The error for an attribute that a scene does not have."""
    hint = ASKED.get(name, "")
    if hint:
        pass
    elif name in FUNCTIONS:
        hint = f"it is a function, co.{name}(scene)"
    elif name in OF_MEASURES:
        hint = f"co.measure(scene).by_material and co.measure(scene)[body] have {name}"
    elif name in _TRACED:
        hint = "rays are followed by first_hit, occluded, spans and crossings"
    elif name in _LONGER:
        rest = "scene.lights, scene.camera, scene.background, scene.domain"
        hint = f"scenes do not change: co.Scene([*scene.bodies, another], {rest}) and scene.replace(...) are new ones"
    elif name in _MOTIONS:
        hint = "shapes and bodies move, co.Scene([body.translate(offset) for body in scene.bodies])"
    elif name in ("ray", "get_rays", "generate_rays"):
        hint = "it is called rays(width, height)"
    elif name in ("copy", "with_camera", "set_camera", "update", "edit"):
        hint = "scenes do not change: scene.replace(camera=...), or name and shape, is another"
    elif name in ("shapes", "objects", "items", "names"):
        hint = "scene.bodies are the entries, each with shape, material and name"
    elif any(name == body.name for body in vars(scene).get("_bodies", ())):
        hint = f"a body is called so, scene[{name!r}]"
    elif not name.startswith("_"):
        close = close_to(name, [known for known in dir(type(scene)) if not known.startswith("_")], _ALIKE)
        hint = f"did you mean {close}?" if close else ""
    return _told(scene, name, hint)


class Told(type):
    """The class of classes that tell what they have instead of a name that other packages have."""

    if not TYPE_CHECKING:  # else checkers would let any name be asked for

        def __getattr__(cls, name: str) -> Any:
            hint = OF_CLASSES.get(cls.__name__, {}).get(name, "")
            text = f"type object {cls.__name__!r} has no attribute {name[:80]!r}{': ' if hint else ''}{hint}"
            raise AttributeError(text, name=name, obj=cls)


def no_attribute_of_package(name: str) -> str:
    """What to tell of a name that the package does not have."""
    if name in (*OF_SCENES, "rays", "bounds", "bodies"):
        return f": a scene has it, scene.{name}"
    if name in (*_TRACED, "raytrace", "ray_trace", "cast_rays"):
        return ": scenes are asked, scene.first_hit(origins, directions)"
    if (motion := name.lower()) in _MOTIONS:
        return f": shapes have it, shape.{ELSEWHERE.get(motion, motion)}(...)"
    if name in _OTHERWISE:
        return f": {_OTHERWISE[name]}"
    return f" (did you mean {CLASSES[name]}?)" if name in CLASSES else ""


_OF_MODULES = {
    "conicoid.ct": {
        "fan": "fanflat", "fan_beam": "fanflat", "fanbeam": "fanflat", "cone_beam": "cone", "conebeam": "cone",
        "conebeam3d": "cone", "parallel_beam": "parallel", "parallel2d": "parallel", "spiral": "helical",
        "astra": "from_astra", "sinogram": "project", "radon": "project", "forward": "project",
        "forward_project": "project", "fp": "project", "projection": "project", "scan": "cone",
    },
    "conicoid.cluster": {
        "Pool": "Processes", "ProcessPool": "Processes", "ProcessPoolExecutor": "Processes", "Executor": "Workers",
        "LocalCluster": "Processes",
    },
}  # fmt: skip
_NOT_OF_MODULES = {
    **dict.fromkeys(("fbp", "iradon", "backproject", "reconstruct", "backprojection", "FDK", "fdk"),
                    "sinograms are made here and not reconstructed: ASTRA, RTK and scikit-image do that"),
    **dict.fromkeys(("Client", "SSHCluster", "SLURMCluster"), "that is Dask's, and any of its clients is an executor="),
}  # fmt: skip


def no_attribute_of_module(module: str, name: str, known: Sequence[str]) -> AttributeError:
    """The error for a name that one of the package's public modules does not have."""
    meant = _OF_MODULES.get(module, {}).get(name, "") or ("" if name.startswith("_") else close_to(name, known, _ALIKE))
    hint = f": {_NOT_OF_MODULES[name]}" if name in _NOT_OF_MODULES else f" (did you mean {meant}?)" if meant else ""
    return AttributeError(f"module {module!r} has no attribute {name[:80]!r}{hint}", name=name)


def _told(thing: object, name: str, hint: str) -> AttributeError:
    kind = type(thing).__name__
    text = f"{kind!r} object has no attribute {name[:80]!r}{': ' if hint else ''}{hint}"
    return AttributeError(text, name=name, obj=thing)


_OPERATORS = {"+": "|", "*": "&", "|": "|", "&": "&", "-": "-"}


def no_operator(thing: object, operator: str, other: Any) -> TypeError | None:
    """The error for an operator that a shape or a body does not have; None where others may know it."""
    from .base import Shape
    from .body import Body

    kind = type(thing).__name__
    if operator == "*" and isinstance(other, int | float):
        return TypeError(f"{kind}: * {other} is no operation, {kind.lower()}.scale({other}) changes its size")
    if operator == "+" and other == 0 and isinstance(other, int):
        return TypeError(f"{kind}: sum() adds nothing up here, co.Union([...]) unites many")
    if operator in "+-" and isinstance(other, tuple | list | np.ndarray) and _are_numbers(other):
        return TypeError(f"{kind}: {operator} {other} is no operation, {kind.lower()}.translate(offset) moves it")
    if not isinstance(other, Shape | Body):
        return None
    if isinstance(thing, Body) or isinstance(other, Body):
        combined = f"a.shape {_OPERATORS[operator]} b.shape"
        return TypeError(f"Body: bodies do not combine, shapes do: co.Body({combined}, material)")
    return TypeError(
        f"{kind}: {operator} is no operation of shapes; a | b is the union, a & b what both have in common"
    )


def _are_numbers(values: Any) -> bool:
    return len(values) == 3 and all(isinstance(value, int | float | np.number) for value in values)
