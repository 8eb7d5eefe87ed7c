"""Scenes after chains of edits, of bodies apart or with walls in common, and the laws that each must satisfy.

An edited scene has the tables of the scene from the beginning, to the bit, and its answers.
"""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co
from conicoid.kernels.bvh.walk import ROWS
from conicoid.prepare.bvh.leaf_items import put_items
from conicoid.prepare.edits import in_place as exchange

from ..tables import assert_same_columns, columns
from .nodes import Nodes

OF_TREES = {"node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items"}
CUBE, UNIT = co.Box((-1, -1, -1), (1, 1, 1)), co.Box((0, 0, 0), (1, 1, 1))
Edit = Callable[[co.Scene, Any], co.Scene]


def same_tables(a, b):
    """Compare all tables but trees, to the bit."""
    p, q = a._prepared.lowered, b._prepared.lowered
    assert_same_columns(p, q, OF_TREES)
    assert (p.face_paint, p.body_count) == (q.face_paint, q.body_count)
    assert np.array_equal(p.exact.single, q.exact.single)
    assert a._prepared.key == b._prepared.key


def same_answers(a, b, rng, count=200):
    origins, directions = rng.normal(size=(count, 3)) * 4, rng.normal(size=(count, 3))
    for query, names in (
        ("first_hit", "t body face surface"),
        ("crossings", "t body"),
        ("spans", "t_enter t_exit body"),
    ):
        ours, theirs = getattr(a, query)(origins, directions), getattr(b, query)(origins, directions)
        for name in names.split():
            assert np.array_equal(getattr(ours, name), getattr(theirs, name)), (query, name)
    assert np.array_equal(a.body_at(origins), b.body_at(origins))


def same(scene):
    """Compare the tables, and the classes of equal surfaces for the next edit, with those of a new scene."""
    fresh = co.Scene(scene.bodies)
    same_tables(scene, fresh)
    ours, others = scene._prepared.lowered.layout, fresh._prepared.lowered.layout
    for name in ("kinds", "input_senses", "senses", "first", "ids", "first_body"):
        one, other = getattr(ours, name), getattr(others, name)
        assert (one is None) == (other is None), name
        assert one is None or np.array_equal(one, other), name


def leaves(scene):
    """Return the items of each leaf of the tree over the entries, by the leaf's first place."""
    found, tree = {}, Nodes(scene)
    tables, first = scene._prepared.lowered.tables, int(scene._prepared.woods.places[-1])
    items = tables.leaf_items
    assert len(items) == ROWS * (len(tables.tree_order) - first)
    for code in [*tree.children[tree.children < 0].tolist(), *(root for root in tree.roots if root < 0)]:
        place, count = (-code - 1) >> 4, (-code - 1) & 15
        if place >= first:
            found[place] = items[ROWS * (place - first) : ROWS * (place - first + count)].tobytes()
    return found


def rewritten_leaves(scene):
    """Return `leaves` after all leaves have been written."""
    before = leaves(scene)
    copy = scene._prepared.geometry._replace(floats=scene._prepared.geometry.floats.copy())
    scene._prepared.lowered.tables.leaf_items[...] = 0.0
    put_items(scene._prepared.geometry, scene._prepared.lowered.boxes, int(scene._prepared.woods.places[-1]))
    after = leaves(scene)
    scene._prepared.geometry.floats[...] = copy.floats
    return before, after


def check_scene(scene):
    """Check the scene, its trees and the items of their leaves against the scene from the beginning."""
    same(scene)
    Nodes(scene).check()
    before, after = rewritten_leaves(scene)
    assert before == after


def content(scene):
    """Return all numbers of a scene."""
    return [column.tobytes() for column in columns(scene._prepared.lowered).values()]


def note_memory_taken(monkeypatch) -> list[bool]:
    """Note whether each exchange from now on takes the memory of another scene, or that of the scene before."""
    found, begin = [], exchange.InPlaceEdit.__init__

    def noted(self, *arguments):
        begin(self, *arguments)
        found.append(self._buffer is not None)

    monkeypatch.setattr(exchange.InPlaceEdit, "__init__", noted)
    return found


# Bodies of all kinds


def block_with_bores(radius, at):
    """Return a body of five leaves. The walls of three pairs of leaves are a pair of planes each."""
    solid = CUBE & co.Sphere(1.3)
    for axis in np.eye(3):
        solid = solid - co.Cylinder((-2 * axis).tolist(), (2 * axis).tolist(), radius)
    return solid.scale(0.3).translate(at)


def anywhere(rng):
    """Return a body of one of many kinds, with walls that no other body has."""
    at, turn = tuple(rng.uniform(-4, 4, 3).tolist()), (tuple(rng.normal(size=3).tolist()), float(rng.uniform(0, 180)))
    red = co.matte("red")
    many = CUBE
    for corner in rng.uniform(-1, 1, (14, 3)).tolist():
        many = many - co.Sphere(0.2, corner)
    kinds = [
        lambda: block_with_bores(0.3, at),
        lambda: co.Sphere(float(rng.uniform(0.2, 1)), at),
        lambda: co.Ellipsoid((1, 2, 0.5)).rotate(*turn).translate(at),
        lambda: CUBE.rotate(*turn).translate(at),
        lambda: co.Cylinder(at, (0, 0, 0), 0.3),
        lambda: (CUBE - co.Sphere(0.9, (1, 1, 1)).painted(red)).rotate(*turn).translate(at),
        lambda: many.rotate(*turn).translate(at),
        lambda: (co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Sphere(1)).rotate(*turn).translate(at),
        lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).rotate(*turn).translate(at),
        lambda: CUBE.scale(0.2).translate((float(rng.integers(-2, 3)), 0, 0)),  # walls that others have too
    ]
    return kinds[-1 if rng.random() < 0.03 else rng.integers(0, len(kinds) - 1)]()


def bodies(count, seed=1, more=()):
    rng = np.random.default_rng(seed)
    return co.Scene([*(co.Body(anywhere(rng), name=str(k)) for k in range(count)), *more])


def moved(scene, rng):
    """Move one or two bodies, or exchange them for others of their kind or of any."""
    for _ in range(rng.integers(1, 3)):
        name = str(rng.integers(0, 20))
        motion = tuple(rng.uniform(-0.3, 0.3, 3).tolist())
        choice = rng.integers(0, 20)
        if choice == 0:
            scene = scene.replace(name, anywhere(rng))
        elif choice < 5:
            scene = scene.moved(name, lambda shape: shape.rotate((1, 2, 3), 10))
        else:
            scene = scene.moved(name, motion)
    return scene


def body_on_floor(rng):
    """Return a body that stands on the floor z = 0, or is as high as others, or is the same ball as others."""
    x, y = rng.uniform(-4, 4, 2).tolist()
    kinds = [
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)),
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)) - co.Sphere(0.3, (x, y, 1)),
        lambda: co.Cylinder((x, y, 0), (x, y, 2), 0.2),
        lambda: ~co.HalfSpace((0, 0, 1), 0) & co.Sphere(1, (x, y, 0)),
        lambda: co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Ellipsoid((0.2, 0.2, 0.2)).rotate("x", 20).translate((1, 1, 1)),
        lambda: co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 2, 3), 30) & ~co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Disc((x, y, 2), (0, 0, 1), 0.5),
    ]
    return kinds[rng.integers(0, len(kinds))]()


def slid(scene, rng):
    """Slide bodies along the floor, or raise them, or swap them with others that stand there."""
    for _ in range(rng.integers(1, 3)):
        name, choice = str(rng.integers(0, 20)), rng.integers(0, 12)
        along = (*rng.uniform(-0.3, 0.3, 2).tolist(), 0.0)
        if choice == 0:
            scene = scene.replace(name, body_on_floor(rng))
        elif choice == 1:
            scene = scene.moved(name, (0, 0, 1))
        else:
            scene = scene.moved(name, along)
    return scene


def some_shape(rng) -> co.Shape:
    """Return a shape on a coarse grid, so that much coincides, of any kind with its own lowering."""
    x, y, z = at = tuple(float(v) for v in rng.integers(-2, 3, 3))
    drilled = UNIT - co.Sphere(0.5, (1, 1, 1)).painted(co.matte("red"))
    many = UNIT
    for corner in rng.uniform(0, 1, (14, 3)).tolist():
        many = many - co.Sphere(0.1, corner)
    kinds = [
        lambda: UNIT.translate(at),
        lambda: UNIT.rotate("z", 30).translate(at),
        lambda: co.Sphere(1, at),
        lambda: co.Ellipsoid((1, 1, 1)).translate(at).rotate("z", 30 * float(rng.integers(0, 4))),
        lambda: co.Cylinder(at, (x, y, z + 1), 0.5),
        lambda: drilled.rotate((1, 2, 3), 40).translate(at),
        lambda: many.translate(at),
        lambda: co.Spheres(rng.integers(-2, 3, (5, 3)).astype(float), 1.0),
        lambda: co.Spheres(rng.normal(size=(4, 3)), 0.2).scale((1, 1, 2)),
        lambda: co.Disc(at, (0, 0, 1), 2) - co.Sphere(1, at),
        lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).rotate("x", 10).translate(at),
        lambda: co.Plane((0, 0, 1), z),
        lambda: co.Cylinder((0, 0, 0), (0, 0, 1), 1) & co.HalfSpace((0, 0, 1), z),
    ]
    return kinds[rng.integers(0, len(kinds))]()


def edited(scene: co.Scene, rng, names) -> co.Scene:
    """Make one edit, of the first or the last entry in some cases."""
    last = len(scene.bodies) - 1
    name = scene.bodies[int(rng.choice([0, last, rng.integers(0, last + 1)]))].name
    choice = rng.integers(0, 4)
    if choice == 0:
        new = [co.Body(some_shape(rng), name=next(names)) for _ in range(rng.integers(1, 3))]
        return scene.added(new, before=name if rng.random() < 0.8 else None)
    if choice == 1 and last > 3:
        return scene.without(name)
    if choice == 2:
        return scene.moved(name, (0, 0, float(rng.integers(-1, 2))))
    return scene.replace(name, some_shape(rng))


def wall_to_wall(rng):
    """Return blocks, pins and balls on a grid of eighths, so that some walls coincide."""
    at = tuple((rng.integers(-8, 9, 3) / 8).tolist())
    many = UNIT
    for corner in (rng.integers(0, 9, (3, 3)) / 8).tolist():
        many = many - co.Sphere(0.25, corner)
    pin = co.Cylinder((0.5, 0.5, 0), (0.5, 0.5, 1), 0.25)
    kinds = [
        lambda: UNIT.translate(at), lambda: many.translate(at), lambda: (UNIT - pin).translate(at),
        lambda: pin.translate(at), lambda: co.Sphere(0.25, at), lambda: UNIT.rotate("z", 30).translate(at),
        lambda: co.Disc(at, (0, 0, 1), 2) - co.Sphere(1, at), lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).translate(at),
        lambda: co.HalfSpace((0, 0, -1), at[2]) & co.Sphere(2, at), lambda: co.Ellipsoid((0.25,) * 3).rotate("z", 7).translate(at),
    ]  # fmt: skip
    return kinds[rng.integers(0, len(kinds))]()


def pushed(scene, rng):
    """Move bodies by eighths, turn them, or exchange them; half of them along a wall."""
    for _ in range(rng.integers(1, 3)):
        name, choice = str(rng.integers(0, 20)), rng.random()
        step = rng.integers(-4, 5, 3) / 8 * (rng.random(3) < 0.5)
        if choice < 0.1:
            scene = scene.moved(name, lambda shape: shape.rotate("z", 90))
        elif choice < 0.15:
            scene = scene.replace(name, wall_to_wall(rng))
        else:
            scene = scene.moved(name, tuple(step.tolist()))
    return scene


# Groups that touch: bodies that stay lie between those that move together. So the rows that move are in several pieces of
# the tables, and each piece moves by another number of places. A step often equals the distance of two sides of a box.

GROUPS = (("2", "4"), ("6", "8", "10"), ("12", "13"), ("15", "16"), ("18", "20"))
"""Two of these are bodies one behind the other in the list, which are one piece."""
_BODIES, _OFTEN = 22, (0.3, 0.1, 0.15, 0.15, 0.3)
_UNIT = 2.0**-20
"""All walls are at whole multiples of this, which sums and differences do not round."""


def _whole(rng, low, high, size=3):
    """Return random numbers, nearly all different."""
    return rng.integers(int(low / _UNIT), int(high / _UNIT), size) * _UNIT


def boxes_in_contact(rng, count, axis):
    """Return boxes and a ball for each. Most boxes share a wall with the one before, and many balls are the same."""
    boxes, balls = [], []
    for number in range(count):
        low, size = _whole(rng, -4, 4), _whole(rng, 0.25, 2)
        if number and rng.random() < 0.95:
            low[axis] = boxes[-1][rng.integers(0, 2)][axis] - rng.integers(0, 2) * size[axis]
        boxes.append((low, low + size))
        balls.append(low if not balls or rng.random() < 0.5 else balls[rng.integers(0, number)])
    shapes = [co.Box(low.tolist(), high.tolist()) for low, high in boxes]
    return shapes, [co.Sphere(0.125, balls[index].tolist()) for index in rng.permutation(count).tolist()]


def _exchanged_group(rng, group, kinds):
    """Return the new bodies of a group: each of its own kind, with walls in common across an axis or other walls."""
    axis = rng.integers(0, 3) if rng.random() < 0.1 else GROUPS.index(group) % 3
    boxes, balls = boxes_in_contact(rng, len(group), axis)
    return [box - ball if name in kinds else box for name, box, ball in zip(group, boxes, balls, strict=True)]


def neighbours(rng):
    """Return (scene, names of the bodies with a hole of a ball)."""
    kinds = {str(number) for number in range(_BODIES) if rng.random() < 0.2}
    shapes = {}
    for group in GROUPS:
        shapes.update(zip(group, _exchanged_group(rng, group, kinds), strict=True))
    for number in range(_BODIES):
        at = _whole(rng, -4, 4).tolist()
        shapes.setdefault(str(number), co.Box(at, (5, 6, 7)) if number == 7 else co.Sphere(0.25, at))
    return co.Scene([co.Body(shapes[str(number)], name=str(number)) for number in range(_BODIES)]), kinds


def rearranged(scene, rng, kinds):
    """Move one or two groups as they are, or with other walls in common than before, or a part of a group.

    All changes go into one preparation.
    """
    for index in rng.choice(len(GROUPS), rng.integers(1, 3), replace=False, p=_OFTEN).tolist():
        group, choice = GROUPS[index], rng.random()
        if choice < 0.4:
            step = tuple(_whole(rng, -1, 1).tolist())
            for name in group[choice > 0.36 :]:
                scene = scene.moved(name, step)
        else:
            for name, shape in zip(group, _exchanged_group(rng, group, kinds), strict=True):
                scene = scene.replace(name, shape)
    return scene


# Worlds

MORE = {
    "of all kinds": (
        (), (co.Plane((0, 0, 1), -3), co.HalfSpace((1, 0, 0), -20)),
        (co.Spheres(np.random.default_rng(1).normal(size=(30, 3)), 0.2),),
        (CUBE.translate((7, 0, 0)), CUBE.translate((9, 0, 0)), co.Spheres([(7.0, 5, 5)], 1.0), co.Sphere(1, (7, 5, 5))),
    ),
    "on one floor": (
        (), (co.Plane((0, 0, 1), 0),), (co.HalfSpace((0, 0, 1), 0),), (co.Spheres([(1, 1, 1), (2, 2, 2)], 0.2),),
        (co.Box((-9, -9, -1), (9, 9, 0)), co.Plane((0, 0, 1), -3)),
    ),
    "blocks and pins": (
        (), (co.Plane((0, 0, 1), 0),), (co.Spheres(np.random.default_rng(2).integers(-8, 9, (9, 3)) / 8, 0.25),),
    ),
}  # fmt: skip
"""Bodies beside those that are edited, by seed."""
KINDS = {
    "of all kinds": (anywhere, moved),
    "on one floor": (body_on_floor, slid),
    "blocks and pins": (wall_to_wall, pushed),
}
WORLDS = (*KINDS, "on a grid", "groups that touch")


def world(name: str, seed: int, count: int, rng: Any) -> tuple[co.Scene, Edit]:
    """Return (a scene of so many bodies, its edit)."""
    if name == "groups that touch":
        scene, kinds = neighbours(rng)
        return scene, lambda scene, rng: rearranged(scene, rng, kinds)
    if name == "on a grid":
        names = map(str, itertools.count())
        first = [co.Body(some_shape(rng), name=next(names)) for _ in range(count)]
        return co.Scene(first), lambda scene, rng: edited(scene, rng, names)
    body, change = KINDS[name]
    bodies = [co.Body(body(rng), name=str(number)) for number in range(max(count, 20))]
    return co.Scene([*bodies, *MORE[name][seed % len(MORE[name])]]), change


def chain(name: str, seed: int, edits: int, count: int) -> int:
    """Make edits one after the other and check each; with odd seeds, hold some of the scenes.

    Return how many changed the coincidences.
    """
    rng = np.random.default_rng(seed)
    scene, change = world(name, seed, count, rng)
    scene.prepare()
    scenes, merged = [(scene, content(scene))] if seed % 2 else [], []
    for number in range(edits):
        before = scenes[rng.integers(0, len(scenes))][0] if scenes and rng.random() < 0.15 else scene
        scene = change(before, rng)
        if rng.random() < 0.3:  # two at once
            scene = change(scene, rng)
        assert scene is before or scene._previous is before._prepared
        del before
        answer = (
            scene.first_hit((0, 0, 9), (0, 0.1, -1)) if number % 7 == 0 else None
        )  # which is held until the next edit
        check_scene(scene)
        if seed % 2 and rng.random() < 0.3:
            scenes = [*scenes[-2:], (scene, content(scene))]
        assert all(content(one) == numbers for one, numbers in scenes)
        if number % 10 == 0:
            for one in (scene, *(one for one, _ in scenes)):
                same_answers(one, co.Scene(one.bodies), rng, 60)
        ids = scene._prepared.lowered.layout.ids
        merged.append(0 if ids is None else len(ids) - len(np.unique(ids)))
        del answer
    return int((np.diff(merged) != 0).sum())
