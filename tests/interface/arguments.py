"""Every public constructor and function with good arguments, and objects that fit no argument."""

from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co

BALL = co.Sphere()
SCENE = co.Scene([BALL])
CAMERA = co.Camera((0, -5, 0), (0, 0, 0))
MOVING = co.Scene(
    [co.Body(co.Sphere(1), name="a")],
    camera=CAMERA,
    animation=co.scene.BodyTrack("a", (0, 1), translate=((0, 0, 0), (1, 0, 0))),
)
ORIGINS, DIRECTIONS = np.array([[0, 0, 5.0]]), np.array([[0, 0, -1.0]])
DISC = co.Disc((0, 0, 0), (0, 0, 1), 1)


def _sides(**radii: Any) -> dict[str, Any]:
    return dict(start=(0, 0, 0), end=(0, 0, 1), **radii, start_angle=0, end_angle=90, reference=(1, 0, 0))


def _query(name: str) -> Callable[..., Any]:
    return lambda **arguments: getattr(SCENE, name)(**arguments)


Call = tuple[Callable[..., Any], dict[str, Any]]
RAYS = dict(origins=ORIGINS, directions=DIRECTIONS)
SECTION = dict(radius=2, inner_radius=1, polar_range=(0, 90), start_angle=0, end_angle=90, center=(0, 0, 0))
REGULAR = dict(sides=6, radius=1, z_range=(0, 1), start_angle=0, radius_to="corners")
SHAPES: dict[str, Call] = {
    "Sphere": (co.Sphere, dict(radius=1, center=(0, 0, 0))),
    "Ellipsoid": (co.Ellipsoid, dict(radii=(1, 2, 3), center=(0, 0, 0), z_range=None)),
    "Ellipsoid.from_coefficients": (co.Ellipsoid.from_coefficients, dict(A=1, E=1, H=1)),
    "Box": (co.Box, dict(low=(0, 0, 0), high=(5, 5, 5))),
    "Cylinder": (co.Cylinder, _sides(radius=1)),
    "CylinderPatch": (co.CylinderPatch, _sides(radius=1)),
    "Cone": (co.Cone, _sides(start_radius=1, end_radius=0)),
    "DoubleCone": (co.DoubleCone, dict(slope=1, z_range=None)),
    "EllipticParaboloid": (co.EllipticParaboloid, dict(A=1, E=1, z_range=None)),
    "HyperbolicParaboloid": (co.HyperbolicParaboloid, dict(A=1, E=1, within=None)),
    "OneSheetHyperboloid": (co.OneSheetHyperboloid, dict(A=1, E=1, H=1, z_range=None)),
    "TwoSheetHyperboloid": (co.TwoSheetHyperboloid, dict(A=1, E=1, H=1, z_range=None)),
    "EllipticCone": (co.EllipticCone, dict(A=1, E=1, H=1, z_range=None)),
    "EllipticCylinder": (co.EllipticCylinder, dict(A=1, E=1, z_range=None)),
    "HyperbolicCylinder": (co.HyperbolicCylinder, dict(A=1, E=1, within=None)),
    "ParabolicCylinder": (co.ParabolicCylinder, dict(G=1, within=None)),
    "Quadric of a matrix": (co.Quadric, dict(matrix=np.diag([1, 1, 1, -1]))),
    "Quadric of coefficients": (co.Quadric, dict(coefficients=dict(xx=1, constant=-1))),
    "HalfSpace": (co.HalfSpace, dict(normal=(0, 0, 1), offset=0)),
    "Polyhedron": (co.Polyhedron, dict(normals=[(1, 0, 0)], offsets=[1])),
    "Mesh": (
        co.Mesh,
        dict(
            vertices=[(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)],
            faces=[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
        ),
    ),
    "Extrusion": (co.Extrusion, dict(outline=[(0, 0), (1, 0), (0, 1)], z_range=(0, 1), scale_at_top=1)),
    "Revolution": (co.Revolution, dict(profile=[(1, 0), (2, 0), (2, 1)], start_angle=0, end_angle=90)),
    "Tube": (co.Tube, _sides(inner_radius=1, outer_radius=2)),
    "Polycone": (co.Polycone, dict(sections=[(0, 1, 2), (1, 1, 3)], start_angle=0, end_angle=90)),
    "SphereSection": (co.SphereSection, SECTION),
    "Trapezoid": (co.Trapezoid, dict(bottom=(2, 2), top=(1, 1), z_range=(0, 1), shift=(0, 0))),
    "Wedge": (co.Wedge, dict(length=2, width=2, height=1, edge_length=1, edge_shift=0)),
    "RegularPrism": (co.RegularPrism, REGULAR),
    "Pyramid": (co.Pyramid, REGULAR | dict(top_radius=0.5)),
    "Parallelepiped": (co.Parallelepiped, dict(corner=(0, 0, 0), a=(1, 0, 0), b=(0, 1, 0), c=(0, 0, 1))),
    "Spheres": (co.Spheres, dict(centers=[(0, 0, 0)], radii=1)),
    "Cylinders": (co.Cylinders, dict(starts=[(0, 0, 0)], ends=[(0, 0, 1)], radii=1)),
    "Capsules": (co.Capsules, dict(starts=[(0, 0, 0)], ends=[(0, 0, 1)], radii=1)),
    "Cones": (co.Cones, dict(starts=[(0, 0, 0)], ends=[(0, 0, 1)], start_radii=1, end_radii=0)),
    "Ellipsoids": (co.Ellipsoids, dict(centers=[(0, 0, 0)], radii=[(1, 2, 3)])),
    "Boxes": (co.Boxes, dict(lows=[(0, 0, 0)], highs=[(5, 5, 5)])),
    "Discs": (co.Discs, dict(centers=[(0, 0, 0)], normals=[(0, 0, 1)], radii=1)),
    "Triangles": (co.Triangles, dict(a=[(0, 0, 0)], b=[(1, 0, 0)], c=[(0, 1, 0)])),
    "Triangles.of_mesh": (
        co.Triangles.of_mesh,
        dict(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)]),
    ),
    "Plane": (co.Plane, dict(normal=(0, 0, 1), offset=0, one_sided=False)),
    "Disc": (co.Disc, dict(center=(0, 0, 0), normal=(0, 0, 1), radius=1)),
    "Triangle": (co.Triangle, dict(a=(0, 0, 0), b=(1, 0, 0), c=(0, 1, 0))),
    "Polygon": (co.Polygon, dict(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)])),
    "Conic": (co.Conic, dict(radius_of_curvature=5, conic_constant=-1, aperture=2)),
    "ConicSheet": (co.ConicSheet, dict(radius_of_curvature=5, conic_constant=-1, aperture=2, hole=1)),
    "Lens": (
        co.Lens,
        dict(
            front_radius=5,
            back_radius=-5,
            thickness=1,
            diameter=2,
            front_conic=0,
            back_conic=0,
            front_aperture=1,
            back_aperture=1,
        ),
    ),
    "LensGroup": (
        co.LensGroup,
        dict(radii=(5, -5), thicknesses=(1,), diameter=2, materials=(1.5,), conics=(0, 0), names=("a",)),
    ),
    "Doublet": (
        co.Doublet,
        dict(radii=(5, -5, 9), thicknesses=(1, 1), diameter=2, materials=(1.5, 1.6), conics=None, names=None),
    ),
    "Mirror": (co.Mirror, dict(radius_of_curvature=-5, conic_constant=-1, diameter=2, thickness=1, hole=1)),
    "Stop": (co.Stop, dict(aperture=1, diameter=2)),
    "Prism": (co.Prism, dict(apex_angle=60, side=1, length=1)),
    "PentaPrism": (co.PentaPrism, dict(side=1, length=1)),
    "CornerCube": (co.CornerCube, dict(height=1)),
    "Wall": (co.Wall, dict(solid=BALL, face=0)),
    "Union": (co.Union, dict(operands=(BALL, BALL))),
    "Intersection": (co.Intersection, dict(operands=(BALL, BALL))),
    "Difference": (co.Difference, dict(operands=(BALL, BALL))),
    "Complement": (co.Complement, dict(operand=BALL)),
    "Painted": (co.Painted, dict(operand=BALL, material=co.matte())),
    "painted": (BALL.painted, dict(material=co.matte())),
    "translate": (BALL.translate, dict(offset=(0, 0, 0))),
    "rotate": (BALL.rotate, dict(axis=(0, 0, 1), degrees=3)),
    "scale": (BALL.scale, dict(factors=2)),
    "transform": (BALL.transform, dict(matrix=np.eye(4))),
    "|": (lambda solids: BALL | solids, dict(solids=BALL)),
    "&": (lambda solids: BALL & solids, dict(solids=BALL)),
    "-": (lambda solids: BALL - solids, dict(solids=BALL)),
    "sheet &": (lambda solid: DISC & solid, dict(solid=BALL)),
}
LOOKS: dict[str, Call] = {
    "Material": (
        co.Material,
        dict(color="red", ambient=1, diffuse=1, specular=0, shininess=1, highlight="phong", reflectivity=0)
        | dict(fresnel=False, transparency=0, refractive_index=1, absorption=0, name="a", properties={"a": 1})
        | dict(roughness=0.1, bump=co.materials.Noise(), bump_height=1),
    ),
    **{name: (getattr(co, name), dict(color="red")) for name in ("matte", "phong", "blinn_phong", "lacquer")},
    "metal": (co.metal, dict(color="red", shininess=3, reflectivity=1)),
    "mirror": (co.mirror, dict(reflectivity=1)),
    "glass": (co.glass, dict(refractive_index=1.5, absorption=0, transparency=1, specular=0.5)),
    "Checker": (co.Checker, dict(a="red", b="blue", scale=1, space=False)),
    "AmbientLight": (co.AmbientLight, dict(intensity=1)),
    "DirectionalLight": (co.DirectionalLight, dict(direction=(0, 0, 1), intensity=1)),
    "PointLight": (co.PointLight, dict(position=(0, 0, 1), intensity=1, falloff="none")),
    "SpotLight": (
        co.SpotLight,
        dict(position=(0, 0, 1), direction=(0, 0, 1), angle=3, soft_edge=1, intensity=1, falloff="none"),
    ),
    "Sky": (co.Sky, dict(zenith="red", horizon="red", ground="red")),
    "glow": (co.glow, dict(emission=3, color="red")),
    "plastic": (co.plastic, dict(color="red", refractive_index=1.5, roughness=0.2)),
    "conductor": (co.materials.conductor, dict(index=(1, 1, 1), extinction=(1, 1, 1), roughness=0.2)),
    **{
        each.__name__: (each, dict(roughness=0.2))
        for each in (
            co.materials.gold,
            co.materials.silver,
            co.materials.copper,
            co.materials.aluminium,
            co.materials.iron,
        )
    },
    "fog": (co.fog, dict(scattering=1, absorption=1, anisotropy=0.5)),
    "Environment": (co.Environment, dict(pixels=[[[1, 1, 1]]], intensity=1, rotation=0)),
    "clear_sky": (co.materials.clear_sky, dict(sun=(0, 0, 1), turbidity=3, ground="red", intensity=1, height=4)),
    "Camera": (co.Camera, dict(position=(7, 0, 0), look_at=(0, 0, 0), up=(0, 0, 1), field_of_view=40)),
    "OrthographicCamera": (
        co.OrthographicCamera,
        dict(position=(7, 0, 0), look_at=(0, 0, 0), up=(0, 0, 1), height=4),
    ),
    "EquirectangularCamera": (co.EquirectangularCamera, dict(position=(7, 0, 0), look_at=(0, 0, 0), up=(0, 0, 1))),
    "FisheyeCamera": (
        co.FisheyeCamera,
        dict(position=(7, 0, 0), look_at=(0, 0, 0), up=(0, 0, 1), field_of_view=180, projection="equisolid"),
    ),
    "Camera with a lens": (
        co.Camera,
        dict(position=(7, 0, 0), look_at=(0, 0, 0), aperture=0.1, focus_distance=3, blades=5),
    ),
    "ImageTexture": (
        co.materials.ImageTexture,
        dict(image=np.zeros((2, 2, 3), np.uint8), mapping="uv", scale=1, offset=(0, 0), wrap="clamp", data=False),
    ),
    "Gradient": (co.materials.Gradient, dict(a="red", b="blue", along="x", length=1, offset=0)),
    "Noise": (co.materials.Noise, dict(a="red", b="blue", scale=1, octaves=2, contrast=1)),
    "Wood": (co.materials.Wood, dict(early="red", late="blue", ring=1, offset=(0, 0), roughness=0.5)),
    "Brick": (
        co.materials.Brick,
        dict(bricks="red", mortar="blue", size=(1, 1), joint=0.1, variation=0.1, mapping="uv"),
    ),
    "camera.rays": (CAMERA.rays, dict(width=3, height=3)),
    "camera.project": (CAMERA.project, dict(points=ORIGINS, width=3, height=3)),
    "Image": (co.Image, dict(array=np.zeros((2, 2)), colormap="dusk", vmin=0, vmax=1)),
}
ANSWERS = {
    "Rays": lambda: co.Rays(**RAYS),
    "Spans": lambda: SCENE.spans(**RAYS),
    "Crossings": lambda: SCENE.crossings(**RAYS),
}
SCENES: dict[str, Call] = {
    "Body": (co.Body, dict(shape=BALL, material=co.matte(), name="a")),
    "Scene": (
        co.Scene,
        dict(items=[BALL], lights=[co.AmbientLight()], camera=CAMERA, background="white", domain=BALL, unit="mm"),
    ),
    "render": (
        _query("render"),
        dict(width=4, height=3, samples=1, integrator="normals", seed=0, depth=1, progress=None)
        | dict(shutter=(0, 1), times=1)
        | dict(camera=CAMERA, axes=False, labels=False, normals=False),
    ),
    "prepare": (_query("prepare"), dict(progress=None)),
    "fitting_camera": (_query("fitting_camera"), dict(aspect=1)),
    "section": (_query("section"), dict(plane="z", at=0, width=4, height=3, samples=1)),
    "replace": (lambda item: SCENE.replace(0, item), dict(item=BALL)),
    "replace in part": (lambda **parts: SCENE.replace(0, **parts), dict(material="red", name="a")),
    "export": (co.export, dict(scene=SCENE, path="page.html", title=None, strict=False)),
    **{
        f"{name}.save": (lambda path, name=name: ANSWERS[name]().save(path), dict(path="answer.npz"))
        for name in ("Rays", "Spans", "Crossings")
    },
    **{f"{name}.load": (getattr(co, name).load, dict(path="answer.npz")) for name in ("Rays", "Spans", "Crossings")},
    "Hits.concatenate": (co.Hits.concatenate, dict(parts=[])),
    "Hits.save": (lambda path: SCENE.first_hit(**RAYS).save(path), dict(path="hits.npz")),
    "Hits.load": (co.Hits.load, dict(path="hits.npz")),
    "turntable": (
        co.turntable,
        dict(scene=SCENE, path="spin.gif", frames=1, seconds=1, width=4, height=3, samples=1, integrator="normals")
        | dict(seed=0, depth=1, camera=CAMERA, axes=False, labels=False, normals=False, folder=None, keep=False)
        | dict(progress=None),
    ),
    "animate": (
        co.animate,
        dict(scene=MOVING, path="film.gif", frames=1, seconds=1, start=0, shutter=0, times=1, width=4, height=3)
        | dict(samples=1, integrator="normals", seed=0, depth=1, camera=CAMERA, axes=False, labels=False)
        | dict(normals=False, folder=None, keep=False, progress=None),
    ),
    "BodyTrack": (
        co.scene.BodyTrack,
        dict(body="a", times=(0, 1), translate=((0, 0, 0), (1, 0, 0)), degrees=(0, 9), axis="z", about=(0, 0, 0))
        | dict(ease="smooth"),
    ),
    "CameraTrack": (
        co.scene.CameraTrack,
        dict(times=(0, 1), position=((0, 0, 0), (1, 0, 0)), look_at=((0, 0, 0), (1, 0, 0)), field_of_view=(40, 30))
        | dict(focus_distance=(1, 2), ease="smooth"),
    ),
    "LightTrack": (
        co.scene.LightTrack,
        dict(light=0, times=(0, 1), position=((0, 0, 0), (1, 0, 0)), direction=((0, 0, -1), (1, 0, 0)))
        | dict(intensity=(1, 2), ease="smooth"),
    ),
    "at": (MOVING.at, dict(time=0.5)),
    "Rays": (co.Rays, RAYS),
    **{name: (_query(name), RAYS | dict(t_min=0, t_max=9)) for name in ("first_hit", "occluded", "spans", "crossings")},
    "contains": (_query("contains"), dict(points=ORIGINS)),
    "body_at": (_query("body_at"), dict(points=ORIGINS)),
    "bodies_at": (_query("bodies_at"), dict(points=ORIGINS)),
    "slice": (_query("slice"), dict(origin=(-2, -2, 0), u=(4, 0, 0), v=(0, 4, 0), pixels=(4, 3), progress=None)),
    "slice across": (_query("slice"), dict(plane="z", pixels=4, at=0)),
    "voxels": (
        _query("voxels"),
        dict(bounds=((-2, -2, -2), (2, 2, 2)), shape=(2, 2, 2), fractions="body", samples=1, axis="z", progress=None),
    ),
    "distance": (_query("distance"), dict(points=ORIGINS, exact=True, max_distance=9.0, progress=None)),
    "Distances.concatenate": (co.Distances.concatenate, dict(parts=[])),
    "spawn": (lambda directions: SCENE.first_hit(**RAYS).spawn(directions), dict(directions=DIRECTIONS)),
    "line_integral": (lambda values: SCENE.spans(**RAYS).line_integral(values), dict(values=[1])),
    "scene.line_integral": (
        _query("line_integral"),
        RAYS | dict(values=[1], t_min=0, t_max=9, progress=None),
    ),
    "scene.lengths": (_query("lengths"), RAYS | dict(t_min=0, t_max=9, by="material", progress=None)),
    "spans.lengths": (lambda by: SCENE.spans(**RAYS).lengths(by), dict(by="body")),
    "reflect": (co.reflect, dict(directions=DIRECTIONS, normals=DIRECTIONS)),
    "refract": (co.refract, dict(directions=DIRECTIONS, normals=DIRECTIONS, eta=1)),
    "molecule": (co.molecule, dict(atoms=ORIGINS, elements=["C"], bonds=[], cell=np.eye(3))),
    "fresnel": (co.optics.fresnel, dict(cos=1, n1=1, n2=1.5, k=0)),
    "trace_paths": (
        co.optics.trace_paths,
        dict(scene=SCENE, rays=co.Rays(**RAYS), depth=2, split=True, wavelength=0.5, weight=1, least=0, seed=0, unit=1),
    ),
    "measure": (co.measure, dict(shape=BALL, rays=100, seed=0, progress=None)),
    "check": (co.check, dict(scene=SCENE, rays=100, seed=0, progress=None)),
    "parameters": (co.parameters, dict(scene=SCENE, names=None)),
    "load": (co.load, dict(path="scene.yaml")),
    "save": (co.save, dict(scene=SCENE, path="scene.yaml")),
    "Image.save": (co.Image(np.zeros((2, 2))).save, dict(path="picture.png")),
    "load_openmc": (co.load_openmc, dict(path="geometry.xml", void=True, max_bodies=3, progress=None)),
    "set_threads": (co.set_threads, dict(count=None)),
    "set_device": (co.set_device, dict(device=None)),
}
CALLS = SHAPES | LOOKS | SCENES

JUNK: dict[str, Any] = {
    "a function": co.matte,
    "a class": co.Sphere,
    "an object": object(),
    "a mapping": {"a": 1},
    "a text": "no such thing",
    "a long text": "x" * 5000,
    "bytes": b"ab",
    "a set": {1, 2, 3},
    "a nest": [[object()]],
    "texts": ["a", "b", "c"],
    "an array": np.zeros((5, 7)),
    "a long list": list(range(100_000)),
    "a huge number": 10**400,
    "a complex number": 1j,
    "NaN": float("nan"),
    "a camera": CAMERA,
    "a scene": SCENE,
    "a light": co.AmbientLight(),
}
TAKEN = {
    *((name, argument, "a text") for name, argument in (("save", "path"), ("Body", "name"), ("Material", "name"))),
    *((name, "name", "a long text") for name in ("Body", "Material")),
    ("Material", "properties", "a mapping"),
    *(
        (name, argument, "a huge number")
        for name, argument in (
            ("measure", "seed"),
            ("check", "seed"),
            ("trace_paths", "seed"),
            ("load_openmc", "max_bodies"),
        )
    ),
    *(
        (name, "progress", "a function")
        for name in (
            "slice",
            "voxels",
            "measure",
            "check",
            "render",
            "load_openmc",
            "prepare",
            "turntable",
            "animate",
            "scene.line_integral",
            "scene.lengths",
            "distance",
        )
    ),
    *((name, "camera", "a camera") for name in ("render", "turntable", "animate")),
    *(("BodyTrack", "body", kind) for kind in ("a text", "a long text")),
    ("animate", "scene", "a scene"),
    *(("animate", "folder", kind) for kind in ("a text", "a long text")),
    ("trace_paths", "scene", "a scene"),
    *(("fresnel", argument, "an array") for argument in ("cos", "k")),
    ("fresnel", "k", "a long list"),
    ("fresnel", "cos", "NaN"),
    ("export", "scene", "a scene"),
    *(("export", "title", kind) for kind in ("a text", "a long text")),
    *(("replace in part", "name", kind) for kind in ("a text", "a long text")),
    *(("turntable", "folder", kind) for kind in ("a text", "a long text")),
    ("turntable", "scene", "a scene"),
    ("camera.project", "points", "NaN"),
    *((name, "directions", "NaN") for name in ("reflect", "refract")),
    *((name, "normals", "NaN") for name in ("reflect", "refract")),
    ("Image", "array", "an array"),
    ("check", "scene", "a scene"),
    ("parameters", "scene", "a scene"),
    ("measure", "shape", "a scene"),
    ("save", "scene", "a scene"),
    ("Scene", "camera", "a camera"),
    ("Scene", "lights", "a light"),
}
"""Strange values that some arguments take all the same."""
