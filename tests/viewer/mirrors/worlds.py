"""Scenes whose tables the functions read, for the shaders and for Python the same numbers to the bit."""

from __future__ import annotations

import base64
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import conicoid as co
from conicoid.kernels import tables as table
from conicoid.kernels.tables import Geometry, Tables, length
from conicoid.render.lights.light_tables import ShadingTables
from conicoid.viewer.scene_data import look_of, pack_scene

from ...engine.test_ties import random_tree
from .table import new_stack

ROUNDING = 2.0**-24
"""The rounding of one operation in single precision, relative to its result."""
SHIFT = 16 * ROUNDING
"""Shifts of inputs, relative to their size: no function rounds more often between an input and an answer."""
LENS = np.float32(np.random.default_rng(4).normal(size=(6, 3))).astype(float)
"""A camera's vectors: any six are one."""
BOX_MARGIN = 4e-6
"""The widening of boxes in page/tables.js, as a share of their distance and of the scene's diagonal."""

_ROW = -1
"""The column with the row of another table, which is not a size."""

# Tables of floats and the parts of their rows: (columns, ...), one size to all columns of a part
_PARTS: dict[int, tuple[int, ...]] = {
    table.PLANES: (3, 1, 3),
    table.SPHERES: (3, 1),
    table.QUADRICS: (3, _ROW),
    table.QUADRIC_FORMS: (9, 1, 1, 1, 1, 1, 1, 1),
    table.VERTICES: (3,),
    table.BALL_FRAMES: (9,),
    table.MAP_ROWS: (4,),
}


class World(NamedTuple):
    """The arguments of kernels."""

    geometry: Geometry
    wide: Geometry  # with boxes wider than those that the page gives to the shaders
    look: ShadingTables
    lens: Any  # of a camera, (6, 3)
    stack: Any


class Scene(NamedTuple):
    """One world: `python` in double precision, `shifted` at random; `data` for the page, about `origin`."""

    python: World
    shifted: tuple[World, ...]
    data: Any
    origin: list[float]
    scene: co.Scene


def _slice(geometry: Geometry, number: int) -> Any:
    begin = int(geometry.places[number])
    return geometry.floats[begin : begin + int(length(geometry, number))]


def _copy(geometry: Geometry) -> Geometry:
    return Geometry(geometry.places.copy(), geometry.integers.copy(), geometry.floats.copy())


def _rounded(geometry: Geometry) -> Geometry:
    """Return coefficients as the textures hold them.

    Balls and boxes stay: balls consist of float32, and boxes are bounds.
    """
    result = _copy(geometry)
    for number in _PARTS:
        values = _slice(result, number)
        values[:] = values.astype(np.float32)
    return result


def _shifted(geometry: Geometry, rng: Any) -> Geometry:
    result = _copy(geometry)
    for number, parts in _PARTS.items():
        rows = _slice(result, number).reshape(-1, sum(map(abs, parts)))
        at = 0
        for size in parts:
            if size == _ROW:
                at += 1
                continue
            part = rows[:, at : at + size]
            part += SHIFT * rng.uniform(-1, 1, part.shape) * np.abs(part).max(axis=1, keepdims=True, initial=0)
            at += size
    return result


def _widened(geometry: Geometry, origin: Any) -> Geometry:
    result = _copy(geometry)
    boxes = _slice(result, table.NODE_BOXES).reshape(-1, 2, 3, 8)
    diagonal = _slice(geometry, table.EXTENT)[0]
    middle = np.asarray(origin)[None, :, None]
    for side, sign in ((0, -1.0), (1, 1.0)):
        corner = boxes[:, side]
        corner += sign * 3 * BOX_MARGIN * np.where(np.isfinite(corner), np.abs(corner - middle) + diagonal, 0.0)
    return result


def _base64(values: Any) -> dict[str, str]:
    return {"f8": base64.b64encode(np.ascontiguousarray(values, "<f8").tobytes()).decode()}


def _rounded_records(records: Any) -> Any:
    result = records.copy()
    for name in result.dtype.names:
        if result.dtype[name].base.kind == "f":
            result[name] = result[name].astype(np.float32)
    return result


def world_of(scene: co.Scene, shifts: int) -> Scene:
    """Return a scene as a world."""
    rng, origin = np.random.default_rng(1), [0.0, 0.0, 0.0]
    geometry = _rounded(scene._prepared.geometry)
    data = pack_scene(scene)
    for number in _PARTS:
        data["tables"][Tables._fields[number]] = _base64(_slice(geometry, number))
    look = look_of(scene, scene.lights)
    materials = look.materials._replace(rows=_rounded_records(look.materials.rows))
    background = tuple(tuple(float(np.float32(v)) for v in color) for color in look.background)
    look = look._replace(materials=materials, lights=_rounded_records(look.lights), background=background)
    world = World(geometry, _widened(geometry, origin), look, LENS, new_stack(8))
    shifted = tuple(world._replace(geometry=_shifted(geometry, rng)) for _ in range(shifts))
    return Scene(world, shifted, data, origin, scene)


def _solids(rng: Any) -> tuple[list[co.Shape], list[co.Shape]]:
    """Return solids of one cell, of every kind of quadric and of many planes, under affine motions or shifts."""
    box = co.Box((-1, -1, -1), (1, 1, 1))
    plain = [
        box,
        co.Ellipsoid((1.0, 0.7, 0.5)),
        co.Cylinder((-0.5, 0, 0), (0.6, 0.3, 0.2), 0.6),
        co.Cylinder((0, 0, -0.7), (0, 0.1, 0.8), 0.8, 30, 200, (1, 0, 0)),
        co.Cone((0, 0, -0.8), (0.1, 0, 0.9), 0.9, 0.3),
        co.DoubleCone(0.8, z_range=(-1, 0.9)),
        co.HalfSpace((0.3, 0.5, 0.8), 0.2),
    ]
    for signs, linear in (
        ((1, 1, -1), 0),
        ((1, 1, -1), 0),
        ((1, -1, 0), 0),
        ((1, 0, 0), 1),
        ((1, 1, 0), 1),
        ((1, -1, 0), 1),
        ((1, 1, 1), 0),
        ((1, 1, 0), 0),
    ):
        scales = rng.uniform(0.5, 2, 3) * signs
        constant = rng.choice([-0.3, 0.3])
        names = dict(zip(("xx", "yy", "zz"), scales.tolist(), strict=True))
        for sign in (1.0, -1.0):
            coefficients = {
                k: sign * v
                for k, v in (names | {"z": float(linear), "x": 0.2, "xy": 0.1, "constant": constant}).items()
            }
            try:
                plain.append(co.Quadric(coefficients=coefficients) & box)
                plain.append(co.Quadric(coefficients=coefficients))
            except ValueError:  # empty, or all of space
                continue
    turned = [shape.rotate(tuple(rng.normal(size=3)), float(rng.uniform(0, 360))) for shape in plain]
    # Bounds of what many planes cut are exact, and dear for long fractions
    moved = [shape.translate(tuple((rng.integers(-32, 33, 3) / 64).tolist())) for shape in plain]
    return [shape.translate(tuple(rng.uniform(-0.5, 0.5, 3))) for shape in turned], moved


def _both_sides() -> list[co.Shape]:
    """Return solids on either side of one surface, which has one row of the tables."""
    box = co.Box((-1, -1, -1), (1, 1, 1))
    forms = dict(xx=1.0, yy=0.75, zz=-0.5, x=0.25, constant=-0.25), dict(xx=0.5, yy=-0.75, z=1.0), dict(yy=1.0, x=-0.5)
    return [
        co.Quadric(coefficients={name: sign * value for name, value in form.items()}) & box
        for form in forms
        for sign in (1, -1)
    ]


def _ball(rng: Any) -> co.Sphere:
    center = np.float32(rng.uniform(-0.7, 0.7, 3)).astype(float)
    return co.Sphere(float(np.float32(rng.uniform(0.2, 1))), tuple(center))


def _region(solids: list[co.Shape], rng: Any) -> co.Shape:
    """Return a Boolean tree whose leaves repeat, so that faces coincide and cancel."""
    shape = solids[rng.integers(len(solids))]
    for _ in range(rng.integers(1, 7)):
        other = solids[rng.integers(len(solids))]
        shape = (shape | other, shape & other, shape - other, other - shape, ~shape | other)[rng.integers(5)]
    return shape


def _sheets(solids: list[co.Shape], rng: Any) -> list[co.Shape]:
    plain = [
        co.Plane((0.2, 0.3, 0.9), 0.1),
        co.Plane((0.2, -0.3, 0.9), -0.1, one_sided=True),
        co.Disc((0.1, 0.2, 0.1), (1, 2, 3), 0.9),
        co.Triangle((-1, -1, 0), (1, -0.8, 0.2), (0.1, 1.2, -0.1)),
        co.Polygon([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (0, 0.2, 0), (-1, 1, 0)]),
        co.CylinderPatch((0, 0, -0.8), (0, 0, 0.9), 0.7, 10, 300, (1, 0, 0)),
    ]
    turned = [shape.rotate(tuple(rng.normal(size=3)), float(rng.uniform(0, 360))) for shape in plain]
    clipped = [shape & solids[rng.integers(len(solids))] for shape in turned]
    return [*turned, *clipped]


def _materials(rng: Any) -> list[co.Material]:
    color = lambda: tuple(rng.uniform(0.1, 1, 3).tolist())  # noqa: E731
    return [
        co.Material(color(), specular=color(), shininess=20.0, reflectivity=color(), fresnel=True),
        co.Material(co.Checker(color(), color(), scale=0.3, space=True), highlight="phong", specular=0.4),
        co.Material(co.Checker(color(), color(), scale=0.2), ambient=0.4, diffuse=0.6),
        co.Material(color(), transparency=color(), refractive_index=1.5, absorption=color()),
        co.Material(color(), transparency=1.0, refractive_index=1.25, absorption=(0.5, 0, 0.25)),
        co.Material(color(), transparency=1.0, refractive_index=1.25, absorption=(0.5, 0, 0.25), name="the same"),
        co.Material(color(), transparency=1.0, refractive_index=1.25, absorption=(0.5, 0, 0.25), specular=0.5),
        co.Material(color(), transparency=(1, 1, 0.5), refractive_index=1.25, absorption=(0.5, 0, 0.25)),
        co.Material(color(), transparency=1.0, refractive_index=1.0),
        co.Material(color(), transparency=1.0, refractive_index=1.0, name="another vacuum"),
        co.Material(color(), transparency=1.0, refractive_index=1.0, absorption=0.1),
        co.Material(color(), diffuse=0.0, specular=0.7, shininess=300.0),
    ]  # fmt: skip


LIGHTS = [
    co.AmbientLight(0.3),
    co.DirectionalLight((0.3, 0.4, -0.9), 0.8),
    co.PointLight((2, 3, 4), (1.0, 0.5, 0.25)),
    co.PointLight((-2, 1, 3), 20.0, falloff="inverse_square"),
    co.SpotLight((0, -4, 2), (0, 1, -0.4), angle=25, soft_edge=10),
    co.SpotLight((3, 0, 2), (-1, 0, -0.4), angle=30, soft_edge=0, falloff="inverse_square"),
]
SKY = co.Sky((0.2, 0.3, 0.6), (0.8, 0.8, 0.9), (0.3, 0.2, 0.1))


def _scene(shapes: list[co.Shape], rng: Any) -> co.Scene:
    materials = _materials(rng)
    bodies = [co.Body(shape, material=materials[k % len(materials)]) for k, shape in enumerate(shapes)]
    return co.Scene(bodies, lights=LIGHTS, camera=co.Camera((0, -6, 2), (0, 0, 0)), background=SKY)


@cache
def random_world() -> Scene:
    """Return everything about the origin, one in another, at random places."""
    rng = np.random.default_rng(15)
    solids, moved = _solids(rng)
    balls = [_ball(rng) for _ in range(6)]
    many = co.Spheres(
        np.float32(rng.uniform(-1, 1, (40, 3))).astype(float), np.float32(rng.uniform(0.05, 0.3, 40)).astype(float)
    )
    painted = co.Painted(co.Box((-0.4, -0.3, -0.2), (0.5, 0.6, 0.7)), _materials(rng)[0])
    regions = [_region([*moved, *balls], rng) for _ in range(40)]
    solids += _both_sides()
    many_sided = co.Polyhedron(rng.integers(-8, 9, (9, 3)).astype(float), np.full(9, 6.0))
    return world_of(
        _scene(
            [*solids, *balls, many_sided, many, *regions, co.Sphere(0.75) - painted, *_sheets([*moved, *balls], rng)],
            rng,
        ),
        8,
    )


@cache
def exact_world() -> Scene:
    """Return coincident faces, contacts and corners at short binary fractions, which are exact in single precision."""
    rng = np.random.default_rng(16)
    five = 1.25  # with 0.75 and 1 a right triangle
    solids: list[co.Shape] = [
        co.Box((-1, -1, -1), (1, 1, 1)),
        co.Box((0, -1, -1), (1, 1, 1)),
        co.Box((-1, -1, 0), (1, 1, 2)),
        co.Box((-2, -0.5, -2), (2, 0.75, 0.75)),
        co.Sphere(five),
        co.Sphere(1.0, (1, 0, 0)),
        co.Cylinder((0, 0, -1), (0, 0, 1), five),
        co.Cylinder((0, 0, -1), (0, 0, 0.75), 1.0),
        co.Cylinder((-1, 0, 0), (2, 0, 0), five),
        co.DoubleCone(1.0, z_range=(-1, 1)),
        co.DoubleCone(1.0, z_range=(-2, -1)),
        co.DoubleCone(1.0, z_range=(0.75, 2)),
        co.Quadric(coefficients=dict(xx=1, yy=-1)) & co.Box((-1, -1, -1), (1, 1, 1)),
        co.Quadric(coefficients=dict(xx=1, z=-1)) & co.Box((-1, -1, -1), (1, 1, 2)),
        co.Quadric(coefficients=dict(xx=-1, yy=1)) & co.Box((-1, -1, -1), (1, 1, 1)),  # one surface, its other side
        co.Quadric(coefficients=dict(xx=-1, z=1)) & co.Box((-1, -1, -1), (1, 1, 2)),
        co.HalfSpace((0, 0, 1), 0.0),
        co.HalfSpace((1, 0, 0), 0.75),
        co.HalfSpace((-1, 0, 0), 0.75),
    ]
    regions = [_region(solids, rng) for _ in range(60)]
    square = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    sheets: list[co.Shape] = [
        co.Plane((0, 0, 1), 0.0),
        co.Plane((0, 0, 1), 1.0, one_sided=True),
        co.Plane((1, 0, 0), 0.75),
        co.Disc((0, 0, 0), (0, 0, 1), five),
        co.Disc((0, 0, -1), (0, 0, -1), 1.0),
        co.Polygon(square),
        co.Polygon([(0, 0, 0.75), (2, 0, 0.75), (2, 2, 0.75), (1, 1, 0.75), (0, 2, 0.75)]),
        co.Polygon([(0, 0, 0.75), (0, -2, 0.75), (2, 0, 0.75)]),
    ]
    clipped = [sheet & solids[rng.integers(len(solids))] for sheet in sheets[:4] for _ in range(3)]
    return world_of(_scene([*solids, *regions, *sheets, *clipped], rng), 0)


@cache
def tied_trees() -> list[Any]:
    """Return trees of boxes whose walls coincide and are often cut away there, with their solids, for `tied_world`."""
    rng = np.random.default_rng(17)
    return [random_tree(rng, 2 + k % 4, [0]) for k in range(40)]


@cache
def tied_world() -> Scene:
    return world_of(_scene([solid for _, solid in tied_trees()], np.random.default_rng(18)), 0)
