"""Random shapes, motions, bodies and scenes for Hypothesis.

The kinds that scene files know draw arguments. A class with more rules than its types has a line in `SPECIAL`. A new
shape with fields of the usual kinds needs nothing here.
"""

import functools
import math
from typing import Any

from hypothesis import assume, strategies as st

import conicoid as co
from conicoid.geometry.bulk import Bulk
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.fields import ShapeType, argument_fields
from conicoid.io.scene_file.nodes import (
    BoolType,
    ChoiceType,
    FixedListType,
    ListType,
    MappingType,
    NumberType,
    OptionalType,
    TextType,
    UnionType,
    ValueType,
)
from conicoid.materials.light import LIGHTS
from conicoid.materials.presets import CONSTRUCTORS

COMBINED = ("Union", "Intersection", "Difference", "Complement", "Painted", "ClippedSheet")
PRIMITIVES = sorted(set(REGISTRY) - set(COMBINED))
SOLIDS = [
    name for name in PRIMITIVES if issubclass(REGISTRY[name], co.Solid) and getattr(REGISTRY[name], "combines", True)
]
SHEETS = [name for name in PRIMITIVES if issubclass(REGISTRY[name], co.Sheet) and not issubclass(REGISTRY[name], Bulk)]


def within_domain(x: float) -> float:
    """Return zero in place of numbers that are too small for a scene."""
    return x if abs(x) >= 1e-100 else 0.0


numbers = st.one_of(
    st.floats(-1e3, 1e3, allow_subnormal=False).map(within_domain),
    st.integers(-10, 10).map(float),
    st.floats(-1e30, 1e30).map(within_domain),
    st.sampled_from([0.1, 1e-9, 1e16, -0.0, 1 / 3, 123456789.0, 1e-100, 2.0**60]),
)
positive = st.one_of(st.floats(1e-3, 1e3), st.integers(1, 10).map(float), st.floats(1e-30, 1e30))
ranges = st.tuples(
    st.one_of(st.just(-math.inf), st.floats(-5, 0).map(within_domain)), st.one_of(st.just(math.inf), st.floats(0.1, 5))
).filter(lambda pair: pair != (-math.inf, math.inf))
texts = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=12)

_near = st.integers(-8, 8).map(lambda k: k / 4)
points = st.tuples(_near, _near, _near)
flat_points = st.tuples(
    st.sampled_from([0.0, 0.5, -1.0]), st.lists(st.tuples(_near, _near), min_size=3, max_size=8)
).map(lambda drawn: [(x, y, drawn[0]) for x, y in drawn[1]])
angles = st.tuples(st.floats(-360, 360).map(within_domain), st.floats(1, 360)).map(
    lambda a: {"start_angle": a[0], "end_angle": a[0] + a[1]}
)


def _round(cls: str) -> st.SearchStrategy[Any]:
    ends = {"start": points, "end": points, "radius": positive}
    whole = st.fixed_dictionaries(ends)
    wedge = st.tuples(st.fixed_dictionaries(ends | {"reference": points}), angles).map(lambda a: a[0] | a[1])
    return built(cls, st.one_of(whole, wedge))


def _polyhedra() -> st.SearchStrategy[Any]:
    rows = st.lists(st.tuples(points, st.floats(-3, 3).map(within_domain)), min_size=1, max_size=6)
    return built("Polyhedron", rows.map(lambda r: {"normals": [n for n, _ in r], "offsets": [o for _, o in r]}))


def _quadrics() -> st.SearchStrategy[Any]:
    names = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
    matrix = st.fixed_dictionaries({"matrix": st.tuples(*[st.tuples(*[_near] * 4)] * 4)})
    named = st.fixed_dictionaries({"coefficients": st.dictionaries(st.sampled_from(names), _near, min_size=1)})
    return built("Quadric", st.one_of(matrix, named))


def _ellipsoids() -> st.SearchStrategy[Any]:
    radii = st.fixed_dictionaries({"radii": st.tuples(*[positive] * 3)}, optional={"center": points, "z_range": ranges})
    named = st.fixed_dictionaries({"coefficients": st.tuples(*[positive] * 3)}, optional={"z_range": ranges})
    return built("Ellipsoid", st.one_of(radii, named))


def _spheres() -> st.SearchStrategy[Any]:
    rows = st.lists(st.tuples(points, positive), max_size=130)
    return built("Spheres", rows.map(lambda r: {"centers": [c for c, _ in r], "radii": [k for _, k in r]}))


MANY = {
    "Cylinders": {"starts": points, "ends": points, "radii": positive},
    "Capsules": {"starts": points, "ends": points, "radii": positive},
    "Cones": {"starts": points, "ends": points, "start_radii": positive, "end_radii": positive},
    "Ellipsoids": {"centers": points, "radii": st.tuples(*[positive] * 3)},
    "Boxes": {"lows": points, "highs": points.map(lambda p: tuple(x + 5 for x in p))},
    "Discs": {"centers": points, "normals": points, "radii": positive},
    "Triangles": {"a": points, "b": points, "c": points},
}


def _many(name: str) -> st.SearchStrategy[Any]:
    """Return one array for each field, of equally many bodies, sometimes more than a scene file holds inline."""
    rows = st.lists(st.fixed_dictionaries(MANY[name]), max_size=4)
    often = st.sampled_from([1, 1, 40])
    return built(
        name,
        st.tuples(rows, often).map(
            lambda drawn: {field: [row[field] for row in drawn[0]] * drawn[1] for field in MANY[name]}
        ),
    )


def built(name: str, arguments: st.SearchStrategy[dict[str, Any]]) -> st.SearchStrategy[Any]:
    """Return shapes of a class from arguments, without those that it refuses."""

    def make(drawn: dict[str, Any]) -> Any:
        try:
            return REGISTRY[name](**drawn)
        except ValueError:
            return None

    return arguments.map(make).filter(lambda shape: shape is not None)


def _lenses() -> dict[str, Any]:
    """Return solids of revolution from numbers that are often a lens."""
    radii = st.one_of(st.floats(2, 50), st.floats(-50, -2), st.just(math.inf))
    curved, conics, near = radii.filter(math.isfinite), st.floats(-4, 2).map(within_domain), st.floats(0.5, 2)
    conic = {"radius_of_curvature": curved, "conic_constant": conics, "aperture": near}
    lens = {"front_radius": radii, "back_radius": radii, "thickness": near, "diameter": st.just(2.0)}
    more = {"front_conic": conics, "back_conic": conics, "front_aperture": near, "back_aperture": near}
    mirror = {"radius_of_curvature": radii, "conic_constant": conics, "diameter": near, "thickness": st.floats(1, 3)}
    hole = {"hole": st.floats(0, 0.4).map(within_domain)}
    walls = st.tuples(_near, st.sampled_from([0, 3, 5])).map(
        lambda drawn: {"solid": co.Box((-3, -3, -3), (drawn[0] + 0.125, 4, 4)), "face": drawn[1]}
    )
    return {
        "Conic": lambda: built("Conic", st.fixed_dictionaries(conic)),
        "ConicSheet": lambda: built("ConicSheet", st.fixed_dictionaries(conic | {"radius_of_curvature": radii}, optional=hole)),
        "Lens": lambda: built("Lens", st.fixed_dictionaries(lens, optional=more)),
        "Mirror": lambda: built("Mirror", st.fixed_dictionaries(mirror, optional=hole)),
        "Stop": lambda: built("Stop", near.map(lambda a: {"aperture": a, "diameter": a + 0.5})),
        "Prism": lambda: built("Prism", st.fixed_dictionaries({"apex_angle": st.floats(1, 179), "side": positive, "length": positive})),
        "Wall": lambda: built("Wall", walls),
    }  # fmt: skip


def _outlined() -> dict[str, Any]:
    """Return shapes of outlines and faces. Corners are random, and outlines that cross themselves are refused."""
    corners = st.tuples(st.floats(0.1, 5).map(within_domain), st.floats(0.1, 5).map(within_domain))
    outline = corners.map(lambda p: [(0.0, 0.0), (p[0], 0.0), (p[0] / 2, p[1] / 2), (0.0, p[1])])
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    return {
        "Mesh": lambda: built("Mesh", corners.map(
            lambda p: {"vertices": [(0, 0, 0), (p[0], 0, 0), (0, p[1], 0), (0, 0, 1)], "faces": faces})),
        "Extrusion": lambda: built("Extrusion", st.fixed_dictionaries(
            {"outline": outline}, optional={"scale_at_top": st.floats(0, 2).map(within_domain)})),
        "Revolution": lambda: built("Revolution", st.fixed_dictionaries(
            {"profile": outline}, optional={"end_angle": st.floats(1, 360).map(within_domain)})),
    }  # fmt: skip


def _angular() -> dict[str, Any]:
    """Return shapes with ranges of angles, two radii, or sections."""
    near, small = st.floats(1, 4), st.floats(0, 0.9).map(within_domain)
    ends = {"start": points, "end": points}
    radii = st.tuples(small, near).map(lambda r: {"inner_radius": r[0], "outer_radius": r[1]})
    tubes = st.tuples(st.fixed_dictionaries(ends), radii).map(lambda a: a[0] | a[1])
    cones = st.fixed_dictionaries(ends | {"start_radius": near, "end_radius": small})
    turned = st.tuples(angles, points).map(lambda a: a[0] | {"reference": a[1]})
    polar = st.tuples(st.floats(0, 90).map(within_domain), st.floats(90.5, 180))
    spheres = st.fixed_dictionaries(
        {"radius": near}, optional={"inner_radius": small, "polar_range": polar, "center": points}
    )
    stacks = st.lists(st.tuples(_near, small, near), min_size=2, max_size=5).map(
        lambda rows: {"sections": sorted(rows, key=lambda row: row[0])}
    )
    sizes, heights = st.tuples(near, near), st.tuples(st.floats(-2, 0).map(within_domain), st.floats(0.5, 3))
    around = {"sides": st.integers(3, 9), "radius": near}
    more = {
        "z_range": heights,
        "start_angle": st.floats(-400, 400).map(within_domain),
        "radius_to": st.sampled_from(["corners", "sides"]),
    }

    def either(plain: Any, angular: Any) -> Any:
        return st.one_of(plain, st.tuples(plain, angular).map(lambda a: a[0] | a[1]))

    return {
        "Tube": lambda: built("Tube", either(tubes, turned)),
        "Cone": lambda: built("Cone", either(cones, turned)),
        "SphereSection": lambda: built("SphereSection", either(spheres, angles)),
        "Polycone": lambda: built("Polycone", either(stacks, angles)),
        "Trapezoid": lambda: built("Trapezoid", st.fixed_dictionaries(
            {"bottom": sizes, "top": sizes}, optional={"z_range": heights, "shift": st.tuples(_near, _near)})),
        "Wedge": lambda: built("Wedge", st.fixed_dictionaries(
            {"length": near, "width": near, "height": near}, optional={"edge_length": small, "edge_shift": _near})),
        "RegularPrism": lambda: built("RegularPrism", st.fixed_dictionaries(around, optional=more)),
        "Pyramid": lambda: built("Pyramid", st.fixed_dictionaries(around, optional=more | {"top_radius": small})),
        "Parallelepiped": lambda: built("Parallelepiped", st.fixed_dictionaries(
            {"corner": points, "a": points, "b": points, "c": points})),
    }  # fmt: skip


SPECIAL: dict[str, Any] = {
    **_outlined(),
    **_angular(),
    **_lenses(),
    "Cylinder": lambda: _round("Cylinder"), "CylinderPatch": lambda: _round("CylinderPatch"),
    "Polyhedron": _polyhedra, "Quadric": _quadrics, "Ellipsoid": _ellipsoids, "Spheres": _spheres,
    **{name: functools.partial(_many, name) for name in MANY},
    "Polygon": lambda: built("Polygon", flat_points.map(lambda vertices: {"vertices": vertices})),
    "Triangle": lambda: built("Triangle", st.fixed_dictionaries({"a": points, "b": points, "c": points})),
    "Box": lambda: built("Box", st.tuples(points, st.tuples(*[st.floats(0.5, 9)] * 3)).map(
        lambda drawn: {"low": drawn[0], "high": [a + b for a, b in zip(*drawn, strict=True)]})),
}  # fmt: skip


def of_kind(kind: ValueType, name: str) -> st.SearchStrategy[Any]:
    """Return values of a kind; `name` distinguishes lengths and texts with a meaning from plain ones."""
    if isinstance(kind, OptionalType):
        return st.none() | of_kind(kind.item, name)
    if isinstance(kind, NumberType):
        return (
            positive
            if name in ("radius", "slope", "scale")
            or name.isupper()
            or "radius" in name
            or name in ("side", "height", "length")
            else numbers
        )
    if isinstance(kind, FixedListType):
        return ranges if kind.count == 2 else st.tuples(*[of_kind(kind.item, name)] * kind.count)
    if isinstance(kind, ListType):
        return st.lists(of_kind(kind.item, name), min_size=1, max_size=5)
    if isinstance(kind, MappingType):
        return st.dictionaries(texts, of_kind(kind.item, name), max_size=3)
    if isinstance(kind, UnionType):
        return st.one_of(*[of_kind(item, name) for item in kind.items])
    if isinstance(kind, ChoiceType):
        return st.sampled_from(kind.values)
    if isinstance(kind, BoolType):
        return st.booleans()
    if isinstance(kind, ShapeType):
        return primitive(kind.base.__name__)
    assert isinstance(kind, TextType), f"no values for {kind} of {name}"
    return texts


def primitive(name: str) -> st.SearchStrategy[Any]:
    """Return unmoved shapes of a class."""
    if name in SPECIAL:
        return SPECIAL[name]()
    fields = argument_fields(REGISTRY[name]).items()
    required = {name: of_kind(field.kind, name) for name, field in fields if field.is_required}
    optional = {name: of_kind(field.kind, name) for name, field in fields if not field.is_required}
    return built(name, st.fixed_dictionaries(required, optional=optional))


@st.composite
def moved(draw: Any, shapes: st.SearchStrategy[Any]) -> Any:
    """Return shapes after up to three steps of motion."""
    shape = draw(shapes)
    for _ in range(draw(st.integers(0, 3))):
        verb = draw(st.sampled_from(["translate", "rotate", "scale", "transform"]))
        try:
            if verb == "translate":
                shape = shape.translate(draw(st.tuples(numbers, numbers, numbers)))
            elif verb == "rotate":
                shape = shape.rotate(
                    draw(points),
                    draw(st.one_of(st.sampled_from([90.0, -45.0]), st.floats(-400, 400).map(within_domain))),
                )
            elif verb == "scale":
                shape = shape.scale(
                    draw(st.one_of(st.floats(0.1, 10), st.tuples(*[st.floats(-3, 3).map(within_domain)] * 3)))
                )
            else:
                rows = [[draw(_near) for _ in range(4)] for _ in range(3)]
                shape = shape.transform([*rows, [0, 0, 0, 1]])
        except ValueError:
            assume(False)
    return shape


def solids() -> st.SearchStrategy[Any]:
    """Return solids of every class, moved, combined and moved again."""
    leaves = moved(st.sampled_from(SOLIDS).flatmap(primitive))

    def combined(parts: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
        pair = st.tuples(parts, parts)
        return moved(
            st.one_of(
                pair.map(lambda p: p[0] | p[1]),
                pair.map(lambda p: p[0] & p[1]),
                pair.map(lambda p: p[0] - p[1]),
                parts.map(lambda p: ~p),
                st.tuples(parts, materials).map(lambda p: p[0].painted(p[1])),
                parts.map(lambda p: p | p.translate((1, 0, 0))),
            )
        )

    return st.recursive(leaves, combined, max_leaves=6)


def sheets() -> st.SearchStrategy[Any]:
    leaves = moved(st.sampled_from(SHEETS).flatmap(primitive))
    clips = st.tuples(leaves, solids())
    return st.one_of(leaves, clips.map(lambda p: p[0] & p[1]), clips.map(lambda p: p[0] - p[1]))


unit = st.floats(0, 1).map(within_domain)
colors = st.one_of(st.tuples(unit, unit, unit), st.sampled_from(["red", "steelblue", "#fa0", "#00ff7f"]))
amounts = st.one_of(unit, colors)
checkers = st.builds(co.Checker, colors, colors, st.one_of(positive, st.tuples(positive, positive)), st.booleans())
materials = st.one_of(
    st.builds(co.Material, color=st.one_of(colors, checkers), specular=amounts, shininess=positive, reflectivity=amounts,
              absorption=st.one_of(positive, st.tuples(unit, unit, unit)), fresnel=st.booleans(),
              highlight=st.sampled_from(["phong", "blinn_phong"]), name=st.none() | texts,
              properties=st.dictionaries(texts, st.one_of(numbers, st.lists(numbers, max_size=4), texts), max_size=2)),
    st.sampled_from(sorted(CONSTRUCTORS)).map(lambda name: CONSTRUCTORS[name]()),
)  # fmt: skip
directions = points.filter(any)
lights = st.one_of(
    st.builds(LIGHTS["PointLight"], points, amounts, st.sampled_from(["none", "inverse_square"])),
    st.builds(LIGHTS["DirectionalLight"], directions, positive),
    st.builds(LIGHTS["AmbientLight"], amounts),
    st.builds(LIGHTS["SpotLight"], points, directions, st.floats(6, 180)),
)
cameras = st.one_of(
    st.none(),
    st.builds(co.Camera, st.just((5.0, 4.0, 3.0)), points, field_of_view=st.floats(1, 179)),
    st.builds(co.OrthographicCamera, st.just((5.0, 4.0, 3.0)), points, height=positive),
)
backgrounds = st.one_of(st.none(), colors, st.builds(co.Sky, colors, colors, st.one_of(st.none(), colors)))


@st.composite
def scenes(draw: Any) -> co.Scene:
    many = [moved(primitive(name)) for name in ("Spheres", *MANY)]
    shapes = draw(st.lists(st.one_of(solids(), sheets(), *many), max_size=4))
    names = draw(st.lists(st.one_of(st.none(), texts), min_size=len(shapes), max_size=len(shapes)))
    names_of_bodies = [name for name in names if name is not None]
    assume(len(set(names_of_bodies)) == len(names_of_bodies))
    looks = draw(st.lists(st.one_of(st.none(), materials), min_size=len(shapes), max_size=len(shapes)))
    bodies = [co.Body(*parts) for parts in zip(shapes, looks, names, strict=True)]
    return co.Scene(bodies, draw(st.lists(lights, max_size=3)), draw(cameras), draw(backgrounds))


__all__ = ["PRIMITIVES", "moved", "primitive", "scenes", "sheets", "solids"]
