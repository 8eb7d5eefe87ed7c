"""A shape that is registered is tested."""

from __future__ import annotations

import pytest

import conicoid as co
from conicoid.shapes import REGISTRY

from .examples import LISTED, derived, examples_of


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_every_registered_shape_has_examples(name):
    found = examples_of(name)
    assert found
    assert all(type(shape).__name__ == name for shape in found)


PUBLIC = """Sphere Ellipsoid Box Cylinder Cone DoubleCone EllipticParaboloid HyperbolicParaboloid OneSheetHyperboloid
TwoSheetHyperboloid EllipticCone EllipticCylinder HyperbolicCylinder ParabolicCylinder Quadric HalfSpace Polyhedron Spheres
Plane Disc Triangle Polygon CylinderPatch""".split()


@pytest.mark.parametrize("name", PUBLIC)
def test_every_shape_of_the_interface_is_public_and_registered(name):
    assert getattr(co, name) is REGISTRY[name]


@pytest.mark.parametrize("name", ["Sphere", "Cone", "EllipticCone", "Disc", "HalfSpace", "Polyhedron"])
def test_usual_field_names_need_no_entry(name):
    """What a new shape would go through: an instance made from its fields alone."""
    assert name in LISTED
    assert type(derived(REGISTRY[name])[0]) is REGISTRY[name]
