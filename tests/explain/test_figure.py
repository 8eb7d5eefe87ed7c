"""The figure: exact sections, crossings where they belong, and a picture that is well-formed and in itself."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.explain.polynomial import SurfaceSource

from ..booleans.random_solids import EXAMPLES
from ..samples import sampled

SVG = "{http://www.w3.org/2000/svg}"


def figure(shape, origin, direction):
    return co.Scene([co.Body(shape, name="it")]).explain(origin, direction).figure()


def test_a_ball_is_cut_in_a_circle():
    """Beside the centre by 0.6: the plane through ray and centre cuts the unit ball in a circle of radius 1."""
    made = figure(co.Sphere(1), (-3, 0.6, 0), (1, 0, 0))
    (arc,) = made.arcs[0]
    assert arc.kind == "ellipse"
    assert arc.radii == pytest.approx((1, 1), rel=1e-14)
    assert arc.is_closed
    assert made.about == "The plane through the ray and the middle of “it”."
    assert np.linalg.norm(made.plane.points(np.array([arc.center]))) == pytest.approx(0, abs=1e-14)


def test_a_drum_along_its_axis_is_a_rectangle():
    """Radius 1, height 2: through the axis, walls at ±1 over the height 2, caps over the width 2."""
    made = figure(co.Cylinder((0, 0, 0), (0, 0, 2), 1), (-3, 0, 0.5), (1, 0, 0.25))
    lengths = sorted(float(np.linalg.norm(arc.start - arc.end)) for arc in made.arcs[0])
    assert lengths == pytest.approx([2, 2, 2, 2], rel=1e-12)
    assert {arc.kind for arc in made.arcs[0]} == {"line"}
    assert made.about == "The plane through the ray and the axis of “it”."


@pytest.mark.parametrize(("shape", "kind", "pieces"), [
    (co.OneSheetHyperboloid(1, 1, 1, z_range=(-1, 1)), "hyperbola", 2),
    (co.EllipticParaboloid(1, 1, z_range=(0, 1)), "parabola", 1),
    (co.DoubleCone(1, z_range=(-1, 1)), "line", 4),   # two lines through the apex, each in two pieces
    (co.Ellipsoid((1, 1, 2), z_range=(-1, 1)), "ellipse", 2),
])  # fmt: skip
def test_sections_along_the_axis(shape, kind, pieces):
    made = figure(shape, (-3, 0, 0.25), (1, 0, 0.1))
    assert len([arc for arc in made.arcs[0] if arc.kind == kind and 0 in arc.surfaces]) == pieces


@pytest.mark.parametrize(("shape", "kinds"), [
    (co.Cylinder((0, 0, -1), (0, 0, 1), 1), {"line"}), (co.DoubleCone(1, z_range=(-1, 1)), {"line"}),
    (co.EllipticParaboloid(1, 1, z_range=(0, 1)), {"line", "parabola"}),
])  # fmt: skip
@pytest.mark.parametrize("degrees", sampled([17.0, 40.0, 61.0], 3))
def test_sections_along_an_axis_that_is_rounded(shape, kinds, degrees):
    """The plane through a turned axis misses it by rounding: a cylinder's sides are lines, and no long ellipse."""
    turned = shape.rotate((1, 2, 3), degrees)
    axis = np.array(co.Scene([turned]).surface(0).classification.axes[2])
    aside = np.cross(axis, (0.3, -0.4, 0.6))
    made = figure(turned, (-3 * aside + 0.6 * axis).tolist(), (aside + 0.1 * axis).tolist())
    assert {arc.kind for arc in made.arcs[0]} == kinds


SAMPLE = [
    pytest.param(one, id=type(one).__name__, marks=[pytest.mark.deep] if k % 5 else [])
    for k, one in enumerate(EXAMPLES)
]


@pytest.mark.parametrize("shape", SAMPLE)
def test_walls_lie_on_their_surfaces_and_end_at_crossings(shape):
    """Points of every arc satisfy the surface's equation; each crossing in the window lies on an arc of its surface."""
    scene = co.Scene([shape])
    low, high = (np.array(end) for end in scene.extent)
    direction = np.array([0.3, 0.2, -1.0])
    found = scene.explain((low + high) / 2 - 2 * direction * np.linalg.norm(high - low), direction)
    made = found.figure()
    ET.fromstring(made.svg)
    for arc in made.arcs.get(0, ()):
        polynomial = SurfaceSource.of(scene._prepared, arc.surfaces[0]).polynomial
        for point in made.plane.points(arc.points(9)).tolist():
            size = float(sum(abs(c) for c in polynomial.coefficients.values())) * (1 + max(map(abs, point))) ** 2
            assert abs(float(polynomial.value(point))) <= 1e-10 * size
    times = np.array([[c.t] for c in found.crossings]).reshape(-1, 1)
    places = made.plane.places(np.array(found.origin) + times * np.array(found.direction))
    for one, place in zip(found.crossings, places.reshape(-1, 2), strict=True):
        if abs(place[0]) <= made.plane.reach:
            mine = [arc for arc in made.arcs[0] if one.surface in arc.surfaces]
            near = [np.linalg.norm(arc.points(4001) - place, axis=1).min() for arc in mine]
            assert min(near) <= 2e-3 * made.plane.reach


def test_the_picture_shows_t_and_asks_nobody():
    found = co.Scene([co.Body(co.Sphere(1), name="<ball>")]).explain((-3, 0.6, 0), (1, 0, 0))
    root = ET.fromstring(found.svg)
    texts = [node.text for node in root.iter(f"{SVG}text")]
    assert {"t = 2.2", "t = 3.8", "o, t = 0", "<ball>"} <= set(texts)
    for text in (found.svg, found.html):
        assert "<script" not in text
        assert "href" not in text
        assert [part for part in text.split('"') if part.startswith("http")] in ([], ["http://www.w3.org/2000/svg"])


def test_marks_are_where_t_says():
    """2.2 and 3.8 along the ray, in pixels of the drawing: their distance is 1.6 of its scale, that of o and 2.2 is 2.2."""
    root = ET.fromstring(co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0)).svg)
    xs = [float(node.get("cx")) for node in root.iter(f"{SVG}circle")]
    origin, first, second = xs
    assert (second - first) / (first - origin) == pytest.approx(1.6 / 2.2, rel=1e-3)


def test_files(tmp_path):
    found = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0))
    for ending, begins in ((".html", "<!doctype html>"), (".svg", "<svg"), (".txt", "The ray\n")):
        found.save(tmp_path / f"why{ending}")
        assert (tmp_path / f"why{ending}").read_text(encoding="utf-8").startswith(begins)
    found.figure(width=300).save(tmp_path / "f.svg")
    assert 'width="300"' in (tmp_path / "f.svg").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"must end with \.html, \.svg or \.txt, got '.*why\.pdf'"):
        found.save(tmp_path / "why.pdf")


def test_nothing_and_misses_are_drawn_too():
    ET.fromstring(co.Scene([]).explain((0, 0, 0), (1, 0, 0)).svg)
    ET.fromstring(co.Scene([co.Sphere(1)]).explain((0, 5, 0), (1, 0, 0)).svg)
    ET.fromstring(co.Scene([co.HalfSpace((0, 0, 1), 0)]).explain((0, 0, -1), (1, 0, 0)).svg)


def test_empty_tiny_and_endless_bodies():
    ball = co.Sphere(1)
    assert "it is empty" in co.Scene([ball & co.Sphere(1, (5, 0, 0))]).explain((-3, 0, 0), (1, 0, 0)).text
    for shape, ray in ((ball - ball, ((-3, 0, 0), (1, 0, 0))), (~ball, ((-3, 0, 0), (1, 0, 0))),
                       (co.Sphere(1e-90), ((-3e-90, 0.2e-90, 0), (1e-90, 0, 0))),
                       (co.Sphere(1e90), ((-3e90, 0.2e90, 0), (1, 0, 0))),
                       (co.HyperbolicParaboloid(1, 1), ((0, 0, 5), (0.1, 0.2, -1)))):  # fmt: skip
        found = co.Scene([shape]).explain(*ray)
        ET.fromstring(found.svg)
        assert found.text
        assert all(len(arcs) <= 4 for arcs in found.figure().arcs.values())
