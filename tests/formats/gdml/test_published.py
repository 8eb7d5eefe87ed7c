"""GDML's solids, and the shapes of the same names, against the numbers that VecGeom's and Geant4's tests print."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

import conicoid as co
from conicoid.io.gdml.solids import SOLID_READERS

from ...samples import size
from .files import solid_scene
from .published import EVERY

NAMES = [one.source for one in EVERY]
READ = [(one, way) for one in EVERY for way in ("gdml", "shape") if way == "gdml" or one.shape]
ON = 1e-9
"""Points that are printed as on a surface lie on it to their last digits."""


@pytest.fixture(scope="module", params=READ, ids=[f"{one.source} as {way}" for one, way in READ])
def solid(request, tmp_path_factory):
    """(what is printed, a scene of the solid alone)"""
    one, way = request.param
    if way == "shape":
        return one, co.Scene([one.shape()])
    scene = solid_scene(tmp_path_factory.mktemp("solid"), one.gdml, "s", one.define)
    assert not [note for note in scene.notes if "left out" in note]
    return one, scene


def intervals(scene, point, direction):
    """Where the whole line through a point is inside, (n, 2), in lengths from the point."""
    unit = np.array(direction, float) / np.linalg.norm(direction)
    spans = scene.spans(point, unit, t_min=-np.inf)
    return np.stack([spans.t_enter, spans.t_exit], axis=1)


def distance_in(scene, point, direction):
    """To where the solid begins; 0 on its surface if the line goes in there, inf if it is never met."""
    scale = 1 + np.abs(point).max()
    found = [low for low, high in intervals(scene, point, direction) if high > ON * scale]
    return max(min(found), 0.0) if found else np.inf


def distance_out(scene, point, direction):
    """To where the part ends that a point is in, or on the surface of."""
    scale = 1 + np.abs(point).max()
    return max(high for low, high in intervals(scene, point, direction) if low <= ON * scale and high >= -ON * scale)


def close(found, expected, digits):
    if np.isinf(expected):
        return found == expected
    return abs(found - expected) <= digits * (1 + abs(expected))


def test_inside_and_outside(solid):
    one, scene = solid
    for points, expected in ((one.inside, True), (one.outside, False)):
        if points:
            assert (np.asarray(scene.contains(np.array(points, float))) == expected).all()


def test_distances(solid):
    one, scene = solid
    for wanted, ask in ((one.into, distance_in), (one.out, distance_out)):
        for point, direction, expected in wanted:
            found = ask(scene, point, direction)
            assert close(found, expected, one.digits), (ask.__name__, point, direction, found, expected)


def test_normals(solid):
    """Seen from a little way outside, straight on."""
    one, scene = solid
    for point, normal in one.normals:
        unit = np.array(normal, float) / np.linalg.norm(normal)
        hit = scene.first_hit(np.array(point) + 0.125 * unit, -unit)
        assert abs(hit.t - 0.125) <= 1e-12 * (1 + np.abs(point).max())
        assert np.allclose(hit.normal, unit, rtol=0, atol=1e-12)


def test_sizes(solid, monkeypatch):
    monkeypatch.setattr(importlib.import_module("conicoid.apps.measures.measure"), "RAYS", size(60_000, 1_000_000))
    one, scene = solid
    if one.extent is not None:
        low, high = scene.bounds
        rough = 1e-9 if hasattr(scene.bodies[0].shape, "operands") else 1e-14  # of combinations they are not tight
        assert np.allclose(low, one.extent[0], rtol=rough, atol=1e-13)
        assert np.allclose(high, one.extent[1], rtol=rough, atol=1e-13)
    if one.volume is None and one.area is None:
        return
    found = co.measure(
        scene.bodies[0].shape, rays=None if isinstance(scene.bodies[0].shape, co.Polyhedron) else size(3000, 12_000)
    )
    for value, error, expected in (
        (found.volume, found.volume_error, one.volume),
        (found.area, found.area_error, one.area),
    ):
        if expected is not None:
            assert abs(value - expected) <= 5 * error + 1e-11 * expected


def test_every_solid_of_gdml_that_others_print_numbers_of_is_here():
    """Of those that formats/gdml builds; xtru, cutTube, twistedtubs and others have formulas in test_solids."""
    here = {one.gdml.split()[0].lstrip("<").rstrip(">") for one in EVERY}
    elsewhere = {"cutTube", "tessellated", "xtru", "genericPolycone", "genericPolyhedra", "twistedtubs"}
    assert set(SOLID_READERS) - here == elsewhere
