"""By which numbers surfaces are found that may be one with new ones: frames that are guessed, and places in them."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.edits import buffer_pool
from conicoid.prepare.edits.neighbour_index import NeighbourFrame, find_neighbours, surface_columns
from tests.engine.edits import CUBE, bodies, moved, same_tables

from ..samples import sampled


def some(reach, count=1_600):
    """So many bodies with planes, balls and other quadrics, as far away as that: a guess looks at a few of them."""
    made = []
    for number, at in enumerate(np.random.default_rng(1).uniform(-reach, reach, (count, 3)).tolist()):
        small = 0.01 * reach
        turned = CUBE.scale(small).rotate((1, 2, 3), number).translate(at)
        made.append((turned, co.Sphere(small, at), co.Cylinder(at, (0, 0, 0), small))[number % 3])
    return made


def records(shapes):
    return surface_columns(co.Scene(shapes)._prepared.lowered.tables)


def lengths(frame, found):
    """The largest in units: distances of planes from the middle, coordinates of centers and constants of balls.

    |x - c|² - r² is what is 0 on a ball; its constant about a point is |c|² - r².
    """
    planes, spheres, _ = found
    away = np.einsum("ij,ij->i", planes[:, 4:] - frame.middle_of_planes, planes[:, :3]) - planes[:, 3]
    centers = spheres[:, :3] - frame.middle
    constants = (centers**2).sum(axis=1) - spheres[:, 3] ** 2
    curved = max(np.abs(centers).max(initial=0.0), np.sqrt(np.abs(constants)).max(initial=0.0))
    flat = np.abs(away / np.linalg.norm(planes[:, :3], axis=1)).max(initial=0.0)
    return np.array([flat / frame.unit_of_planes, curved / frame.unit])


@pytest.mark.parametrize(("far", "reach"), sampled([(None, 1e-6), (None, 1e9), (1e6, 1e-6), (1e6, 1e9)][::-1], 4))
def test_a_frame_has_room_for_all_and_not_too_much(reach, far):
    """Also where no record that the guess is made from is as far away as some of the others."""
    shapes = some(reach)
    if far is not None:
        shapes[1597] = co.Sphere(reach, (far * reach, 0, 0))
        shapes[1593] = CUBE.scale(reach).rotate((1, 2, 3), 5).translate((0, far * reach, 0))
    found = records(shapes)
    frame, (places,) = NeighbourFrame.of_scenes(found)
    assert (lengths(frame, found) <= 0.5 * (1 + 1e-12)).all()
    assert (lengths(frame, found) > 0.01).all()
    again = frame.places_within(*found)
    assert again is not None
    for name in ("planes", "spheres", "quadrics"):
        assert np.array_equal(getattr(again, name), getattr(places, name))
    outside = [co.Sphere(reach, (2 * frame.unit, 0, 0))], [co.HalfSpace((1, 0, 0), 2 * frame.unit_of_planes)]
    assert [frame.places_within(*records(one)) for one in outside] == [None, None]


def test_frames_where_there_are_no_surfaces_of_a_kind_or_none_at_all():
    balls, none = records([co.Sphere(1, (5, 0, 0)), co.Sphere(1, (7, 0, 0))]), records([])
    frame, (places, others) = NeighbourFrame.of_scenes(none, balls)
    assert (lengths(frame, balls) <= 0.5).all()
    assert (len(places.spheres), len(others.spheres)) == (0, 2)
    assert NeighbourFrame.of_scenes(none)[0].unit == 1.0


def test_a_frame_of_planes_through_one_point_but_for_one():
    """None of the others has a length, so that there is nothing to guess by."""
    normals = np.random.default_rng(2).normal(size=(600, 3)).tolist()
    found = records([*(co.HalfSpace(normal, 0) for normal in normals[1:]), co.HalfSpace(normals[0], 1e-6)])
    frame, _ = NeighbourFrame.of_scenes(found)
    assert 0.01 < lengths(frame, found)[0] <= 0.5


def test_equal_surfaces_are_near_and_few_others_are():
    """A ball that was turned, a wall of an angle that is on the other side, a cylinder that begins elsewhere."""
    mine = [co.Sphere(1, (1, 2, 3)), co.HalfSpace((3, 0, 4), 2), co.Cylinder((0, 0, 0), (1, 2, 2), 0.5)]
    theirs = [
        co.Ellipsoid((1, 1, 1)).rotate("x", 20).translate((1, 2, 3)),
        co.HalfSpace((-6, 0, -8), -4),
        co.Cylinder((2, 4, 4), (3, 6, 6), 0.5),
    ]
    scene, new = records([*mine, *some(3.0)]), records(theirs)
    _, (places, own) = NeighbourFrame.of_scenes(scene, new)
    curved = np.concatenate([own.spheres, own.quadrics])
    columns = (places.planes, own.planes), (places.spheres, curved), (places.quadrics, curved)
    for (column, others), marks in zip(columns, places.marks, strict=True):
        rows = find_neighbours(column, marks, others)
        assert rows[0] == 0
        assert len(rows) < 5


@pytest.mark.parametrize("placed", [0, 1 << 18])
def test_a_scene_has_places_from_the_beginning_unless_it_is_large(monkeypatch, placed):
    """Large is more than a number of surfaces; the first edit works them out there."""
    monkeypatch.setattr(buffer_pool, "_PLACED", placed)
    rng, scene = np.random.default_rng(3), bodies(40, 3)
    scene.prepare()
    kept = scene._prepared.edit_state
    assert (kept.places is None) == (placed == 0)
    assert (kept.frame is None) == (placed == 0)
    del kept
    for _ in range(4):
        scene = moved(scene, rng)
        same_tables(scene, co.Scene(scene.bodies))


@pytest.mark.parametrize("placed", [0, 1 << 18])
def test_places_are_worked_out_once_for_all_edits_of_a_scene(monkeypatch, placed):
    """As a slider does: each from the same scene."""
    monkeypatch.setattr(buffer_pool, "_PLACED", placed)
    found, begin = [], NeighbourFrame.of_scenes
    monkeypatch.setattr(NeighbourFrame, "of_scenes", lambda *scenes: found.append(len(scenes)) or begin(*scenes))
    first = co.Scene([CUBE.rotate((1, 2, 3), 7 * k).translate((3 * k, 0, 0)) for k in range(9)])
    first.prepare()
    for number in range(4):
        first.moved(3, (0, 0.1 * number, 0.1)).prepare()
    assert found == [2 if placed == 0 else 1]


def test_places_in_memory_of_a_scene_with_another_frame_are_written_anew():
    """Where a body has gone far away all have other places than in the memory that is taken next."""
    scene = co.Scene([co.Body(CUBE.rotate((1, 2, 3), 7 * k).translate((3 * k, 0, 0)), name=str(k)) for k in range(9)])
    for number in (0, 1):
        hits = scene.first_hit((0, 0, 9), (0, 0, -1))  # holds the scene: two take turns
        scene = scene.moved(str(number), (0, 0.1, 0))
    frame = scene._prepared.edit_state.frame
    hits = scene.first_hit((0, 0, 9), (0, 0, -1))
    scene = scene.moved("2", (0, 1e4, 0))
    assert scene._prepared.edit_state.frame != frame
    for number in (5, 6):  # a corner of what stays where it was, and so three of its walls
        scene = scene.replace("3", CUBE.scale(0.5).translate((0.5, 0.5, 0.5)).rotate((1, 2, 3), 7 * number)
                              .translate((3 * number, 0, 0)))  # fmt: skip
        anew = co.Scene(scene.bodies)
        assert len(anew._prepared.lowered.tables.surface_kind) == 6 * 9 - 3
        same_tables(scene, anew)
    del hits
