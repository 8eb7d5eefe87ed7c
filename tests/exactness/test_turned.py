"""Motions with irrational numbers that leave a surface rational: what is rational on paper is found to be.

All expectations are those of the same bodies unturned, or are worked out in the comments.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.exact_crossings import surface_form

UP = (0, 0, 1)
ROUND = {
    "cylinder": co.Cylinder((0, 0, -1), UP, 1),
    "cone": co.Cone((0, 0, -1), UP, 2, 1),
    "ellipsoid": co.Ellipsoid((1, 1, 0.5)),
    "barrel": co.Ellipsoid((1, 1, 2), z_range=(-1, 1)),
    "double cone": co.DoubleCone(2, z_range=(-1, 2)),
    "paraboloid": co.EllipticParaboloid(1, 1, z_range=(-math.inf, 2)),
    "one sheet": co.OneSheetHyperboloid(1, 1, 4, z_range=(-2, 2)),
    "two sheets": co.TwoSheetHyperboloid(1, 1, 4, z_range=(-2, 2)),
}
ANGLES = [15, 105, 16, 45, 1e-3, 33.3, -75]


def forms(shape):
    scene = co.Scene([shape])
    return [surface_form(surface) for surface in scene._prepared.lowered.exact]


@pytest.mark.parametrize("name", ROUND)
@pytest.mark.parametrize("degrees", ANGLES)
def test_a_turn_about_the_own_axis_changes_nothing(name, degrees):
    """The coefficients are integers again; and rays from lattice points, tangent ones among them, cross as before."""
    still = ROUND[name]
    turned = still.rotate(UP, degrees)
    assert all(form.off is None for form in forms(turned))
    rng = np.random.default_rng(7)
    origins = rng.integers(-3, 4, (300, 3)).astype(float)
    directions = rng.integers(-2, 3, (300, 3)).astype(float)
    some = directions.any(axis=1)
    origins, directions = origins[some], directions[some]
    found = co.Scene([turned]).crossings(origins, directions, t_min=-np.inf)
    expected = co.Scene([still]).crossings(origins, directions, t_min=-np.inf)
    assert found.offsets.tolist() == expected.offsets.tolist()
    assert found.face.tolist() == expected.face.tolist()
    assert (abs(found.t - expected.t) <= found.t_error + expected.t_error).all()
    assert (found.t_error <= 1e-14 * (1 + abs(found.t))).all()


def test_the_cone_that_was_missed():
    """On (2, 3, 3) - t (2, 2, 2): z = 1 at t = 1, through the rim; and z = -1 at t = 2, beyond the wall at 13 / 7."""
    scene = co.Scene([co.Cone((0, 0, -1), UP, 2, 1).rotate(UP, 15)])
    found = scene.crossings((2, 3, 3), (-2, -2, -2), t_min=-9)
    assert found.t.tolist() == [1.0, 13 / 7]


@pytest.mark.parametrize("half_degrees", range(1, 361, 7))
def test_tangents_of_a_turned_cylinder_touch(half_degrees):
    scene = co.Scene([co.Cylinder((0, 0, -1), UP, 1).rotate(UP, half_degrees / 2)])
    rays = ((5, -1, 0), (0, 5, 0), (1, 1, -3)), ((-1, 0, 0), (0, -1, 0), (0, 0, 1))
    t = scene.first_hit(*rays).t
    assert t.tolist() == [math.inf, 4.0, math.inf]


RATIONAL = {
    "45 about an axis": co.Ellipsoid((1, 2, 3)).rotate(UP, 45),
    "120 about a diagonal": co.Ellipsoid((1, 2, 3)).rotate((1, 1, 1), 120),
    "180 about an oblique axis": co.Ellipsoid((1, 2, 3)).rotate((1, 2, 3), 180),
    "there and back": co.Ellipsoid((1, 2, 3)).rotate((1, 2, 2), 20).translate((1, 0, 0)).rotate((1, 2, 2), -20),
    "a third": co.Ellipsoid((1, 2, 3)).scale(3).translate((1, 2, 3)),
    "oblique axis": co.Cylinder((0, 0, 0), (1, 2, 3), 1),
    "a plane by 120": co.Plane((1, 0, 0), 0.1).rotate((1, 1, 1), 120),
    "15 and 75 about a rational axis": co.HyperbolicParaboloid(1, 2).rotate((1, 2, 2), 15).rotate((1, 2, 2), 75),
}


@pytest.mark.parametrize("name", [name for name in RATIONAL if name not in ("there and back", "oblique axis")])
def test_rational_surfaces_are_recognised(name):
    assert all(form.off is None for form in forms(RATIONAL[name]))


def test_the_wall_of_an_oblique_cylinder_is_rational():
    """|x|² - (a·x)² / a·a = r²; its caps stand at irrational heights from the origin unless they pass through lattice points."""
    assert all(form.off is None for form in forms(RATIONAL["oblique axis"]))


def test_a_translation_that_was_turned_is_not():
    """Moved by cos 20: nothing rational about it; but the second-order part is, and 45 bits of luck must not count."""
    assert any(form.off is not None for form in forms(RATIONAL["there and back"]))


def test_a_plane_at_an_irrational_distance_is_not():
    (form,) = forms(co.Plane((1, 0, 0), 1).rotate(UP, 45))
    assert form.off is not None


def test_long_chains_of_motions_are_composed_as_they_grow():
    """Nothing is multiplied before it is asked for; then each motion goes on from the product before it."""
    shape = co.Sphere()
    for k in range(60):
        shape = shape.rotate((1, 2, 3), 6)
        assert "affine" not in shape.motion.__dict__
        if k % 7 == 0:
            assert shape.motion.matrix is shape.motion.matrix
            assert "affine" in shape.motion.__dict__
    matrix = shape.motion.matrix
    assert np.array_equal(matrix, np.eye(4))  # 60 times 6 degrees


def test_motions_in_a_chain_are_multiplied_once(monkeypatch):
    from conicoid.geometry import transform as motion

    calls = []
    affine = motion.Rotate.affine
    monkeypatch.setattr(motion.Rotate, "affine", lambda self: calls.append(1) or affine(self))
    shape = co.Sphere()
    for _ in range(30):
        shape = shape.rotate((1, 2, 3), 0.01)
    co.Scene([shape])
    assert len(calls) <= 60
