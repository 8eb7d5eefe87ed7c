"""The figure of an explanation, and the calls and commands that draw it."""

import dataclasses
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.explain.polynomial import SurfaceSource
from conicoid.apps.explain.steps import OUTCOMES

from ..booleans.random_solids import EXAMPLES
from ..command_line import execute, failure, run, scene_file
from ..samples import sampled

# --- The figure: exact sections, crossings at their places, and a well-formed picture without links


SVG = "{http://www.w3.org/2000/svg}"


def figure(shape, origin, direction):
    return co.Scene([co.Body(shape, name="it")]).explain(origin, direction).figure()


def test_a_ball_is_cut_in_a_circle():
    """The plane through ray and center cuts the unit ball in a circle of radius 1, 0.6 beside the ray."""
    drawing = figure(co.Sphere(1), (-3, 0.6, 0), (1, 0, 0))
    (arc,) = drawing.arcs[0]
    assert arc.kind == "ellipse"
    assert arc.radii == pytest.approx((1, 1), rel=1e-14)
    assert arc.is_closed
    assert drawing.about == "The plane through the ray and the middle of “it”."
    assert np.linalg.norm(drawing.plane.points(np.array([arc.center]))) == pytest.approx(0, abs=1e-14)


def test_a_drum_along_its_axis_is_a_rectangle():
    """The drum has radius 1 and height 2.

    Through the axis, walls are at ±1 over the height 2, and caps over the width 2.
    """
    drawing = figure(co.Cylinder((0, 0, 0), (0, 0, 2), 1), (-3, 0, 0.5), (1, 0, 0.25))
    lengths = sorted(float(np.linalg.norm(arc.start - arc.end)) for arc in drawing.arcs[0])
    assert lengths == pytest.approx([2, 2, 2, 2], rel=1e-12)
    assert {arc.kind for arc in drawing.arcs[0]} == {"line"}
    assert drawing.about == "The plane through the ray and the axis of “it”."


@pytest.mark.parametrize(("shape", "kind", "pieces"), [
    (co.OneSheetHyperboloid(1, 1, 1, z_range=(-1, 1)), "hyperbola", 2),
    (co.EllipticParaboloid(1, 1, z_range=(0, 1)), "parabola", 1),
    (co.DoubleCone(1, z_range=(-1, 1)), "line", 4),   # two lines through the apex, each in two pieces
    (co.Ellipsoid((1, 1, 2), z_range=(-1, 1)), "ellipse", 2),
])  # fmt: skip
def test_sections_along_the_axis(shape, kind, pieces):
    drawing = figure(shape, (-3, 0, 0.25), (1, 0, 0.1))
    assert len([arc for arc in drawing.arcs[0] if arc.kind == kind and 0 in arc.surfaces]) == pieces


@pytest.mark.parametrize(("shape", "kinds"), [
    (co.Cylinder((0, 0, -1), (0, 0, 1), 1), {"line"}), (co.DoubleCone(1, z_range=(-1, 1)), {"line"}),
    (co.EllipticParaboloid(1, 1, z_range=(0, 1)), {"line", "parabola"}),
])  # fmt: skip
@pytest.mark.parametrize("degrees", sampled([17.0, 40.0, 61.0], 3))
def test_sections_along_a_rounded_axis(shape, kinds, degrees):
    """The plane through a turned axis misses it by rounding. A cylinder's sides are lines, and no long ellipse."""
    turned = shape.rotate((1, 2, 3), degrees)
    axis = np.array(co.Scene([turned]).surface(0).classification.axes[2])
    aside = np.cross(axis, (0.3, -0.4, 0.6))
    drawing = figure(turned, (-3 * aside + 0.6 * axis).tolist(), (aside + 0.1 * axis).tolist())
    assert {arc.kind for arc in drawing.arcs[0]} == kinds


SAMPLE = [
    pytest.param(one, id=type(one).__name__, marks=[pytest.mark.deep] if k % 5 else [])
    for k, one in enumerate(EXAMPLES)
]


@pytest.mark.parametrize("shape", SAMPLE)
def test_walls_lie_on_their_surfaces_and_end_at_crossings(shape):
    """Points of every arc satisfy the surface's equation. Each crossing in the window lies on an arc of its surface."""
    scene = co.Scene([shape])
    low, high = (np.array(end) for end in scene.extent)
    direction = np.array([0.3, 0.2, -1.0])
    found = scene.explain((low + high) / 2 - 2 * direction * np.linalg.norm(high - low), direction)
    drawing = found.figure()
    ET.fromstring(drawing.svg)
    for arc in drawing.arcs.get(0, ()):
        polynomial = SurfaceSource.of(scene._prepared, arc.surfaces[0]).polynomial
        for point in drawing.plane.points(arc.points(9)).tolist():
            size = float(sum(abs(c) for c in polynomial.coefficients.values())) * (1 + max(map(abs, point))) ** 2
            assert abs(float(polynomial.value(point))) <= 1e-10 * size
    times = np.array([[c.t] for c in found.crossings]).reshape(-1, 1)
    places = drawing.plane.places(np.array(found.origin) + times * np.array(found.direction))
    for one, place in zip(found.crossings, places.reshape(-1, 2), strict=True):
        if abs(place[0]) <= drawing.plane.reach:
            mine = [arc for arc in drawing.arcs[0] if one.surface in arc.surfaces]
            near = [np.linalg.norm(arc.points(4001) - place, axis=1).min() for arc in mine]
            assert min(near) <= 2e-3 * drawing.plane.reach


def test_the_picture_shows_t_without_network_access():
    found = co.Scene([co.Body(co.Sphere(1), name="<ball>")]).explain((-3, 0.6, 0), (1, 0, 0))
    root = ET.fromstring(found.svg)
    texts = [node.text for node in root.iter(f"{SVG}text")]
    assert {"t = 2.2", "t = 3.8", "o, t = 0", "<ball>"} <= set(texts)
    for text in (found.svg, found.html):
        assert "<script" not in text
        assert "href" not in text
        assert [part for part in text.split('"') if part.startswith("http")] in ([], ["http://www.w3.org/2000/svg"])


def test_marks_are_at_t():
    """Crossings are at 2.2 and 3.8 along the ray.

    In pixels their distance is 1.6 times the scale, and that of o and 2.2 is 2.2 times.
    """
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


BALL = co.Sphere(1)
ODD = {  # bodies, a ray, and a part of the text
    "nothing": ([], ((0, 0, 0), (1, 0, 0)), "nothing is hit: t = ∞"),
    "a miss": ([BALL], ((0, 5, 0), (1, 0, 0)), "nothing is hit: t = ∞"),
    "from inside": ([co.HalfSpace((0, 0, 1), 0)], ((0, 0, -1), (1, 0, 0)), "nothing is hit: t = ∞"),
    "apart": ([BALL & co.Sphere(1, (5, 0, 0))], ((-3, 0, 0), (1, 0, 0)), "it is empty"),
    "empty": ([BALL - BALL], ((-3, 0, 0), (1, 0, 0)), ""),
    "endless": ([~BALL], ((-3, 0, 0), (1, 0, 0)), ""),
    "tiny": ([co.Sphere(1e-90)], ((-3e-90, 0.2e-90, 0), (1e-90, 0, 0)), ""),
    "huge": ([co.Sphere(1e90)], ((-3e90, 0.2e90, 0), (1, 0, 0)), ""),
    "a saddle": ([co.HyperbolicParaboloid(1, 1)], ((0, 0, 5), (0.1, 0.2, -1)), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", ODD)
def test_odd_scenes_are_drawn_and_described(name):
    bodies, ray, words = ODD[name]
    found = co.Scene(bodies).explain(*ray)
    ET.fromstring(found.svg)
    assert words in found.text
    assert all(len(arcs) <= 4 for arcs in found.figure().arcs.values())


def test_an_interval():
    assert "nothing is hit: t = ∞" in SCENE.explain(*RAY, t_min=2, t_max=1).text
    assert SCENE.explain(*RAY, t_min=2.5).hit.t == 3.8


# --- Explanations in Python, in a notebook and on the command line; wrong arguments


SCENE = co.Scene(
    [co.Body(co.Sphere(1), name="ball"), co.Box((3, -1, -1), (5, 1, 1)), co.Spheres([(0, 9, 0), (0, 12, 0)], 1)]
)
RAY = (-3, 0.6, 0), (1, 0, 0)


def test_rays_and_bodies_by_name_and_number():
    found = SCENE.explain(co.Rays(*RAY))
    assert found.text == SCENE.explain(*RAY).text == str(found)
    assert [step.body for step in found.bodies] == [0, 1, 2, 3]
    assert found["ball"] is found[0]
    assert [step.body for step in SCENE.explain(*RAY, body="ball").bodies] == [0]
    assert [step.body for step in SCENE.explain(*RAY, body=np.int32(3)).bodies] == [3]
    assert {step.outcome for step in found.bodies} == {"hit", "crossed", "box missed"}
    assert set(OUTCOMES) >= {step.outcome for step in found.bodies}


def test_a_spawned_ray_knows_where_it_starts():
    """The ray goes into the ball from (−0.8, 0.6, 0) along x.

    On the surface t² + 2 B t = 0, B = −0.8: the hit is t = 1.6, not t = 0.
    """
    found = SCENE.explain(SCENE.first_hit(*RAY).spawn((1, 0, 0)))
    step = found.surfaces[int(found.hit.surface)]
    assert step.starts
    assert step.c == 0
    assert found.hit.t == pytest.approx(1.6, rel=1e-15)
    assert "the ray starts on this surface: its root t = 0 is removed, and −2b / a is left" in found.text
    outward = SCENE.explain(SCENE.first_hit(*RAY).spawn((-1, 0, 0)))
    assert outward[0].outcome == "started on"


@pytest.mark.parametrize(("call", "error", "message"), [
    (lambda: SCENE.explain([[0, 0, 0]], [[1, 0, 0]]), ValueError, r"explain: origin and direction must be one ray, got rays of shape \(1,\); rays\[i\] is one of them"),
    (lambda: SCENE.explain((0, 0, 0), (0, 0, 0)), ValueError, "direction must not be zero"),
    (lambda: SCENE.explain((0, 0, 0)), TypeError, "explain: origins must be a Rays, or an array with directions beside it, got tuple alone"),
    (lambda: SCENE.explain(*RAY, math.nan), ValueError, "explain: t_min must not be NaN"),
    (lambda: SCENE.explain(*RAY, body="bal"), KeyError, "no body named 'bal'"),
    (lambda: SCENE.explain(*RAY, body=-1), IndexError, "body: number must be at least 0 and below 4, got -1"),
    (lambda: SCENE.explain(*RAY)["bal"], LookupError, "no step of body 'bal'; there are 'ball', 'Box 1'"),
    (lambda: SCENE.explain(*RAY).save("why.pdf"), ValueError, r"must end with \.html, \.svg or \.txt, got '.*why\.pdf'"),
])  # fmt: skip
def test_invalid_calls_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_steps_are_values():
    found = SCENE.explain(*RAY)
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.bodies[0].outcome = "missed"
    assert len(repr(found)) < 200


def test_many_bodies_are_counted():
    """A thousand balls stand in a row along y. The ray along x meets the one at y = 0, and the tree omits the rest."""
    found = co.Scene([co.Spheres([(0, 3 * k, 0) for k in range(1000)], 1)]).explain((-5, 0, 0), (1, 0, 0))
    assert len(found.bodies) + found.misses == 1000
    assert len(found.bodies) < 40
    assert f"the tree of boxes leaves out {found.misses} more bodies" in found.text


def test_html_stands_by_itself():
    text = co.Scene([co.Body(co.Sphere(1), name="a<b>&c")]).explain(*RAY)._repr_html_()
    assert text.count("<div") == text.count("</div>")
    assert "a&lt;b&gt;&amp;c" in text
    assert "a<b>" not in text
    assert "<i>t</i><sup>2</sup> + 2 <i>B</i> <i>t</i> + <i>C</i> = 0" in text
    assert re.search(r"<i>t</i><sub>0</sub> = .*= 2\.2</p>", text)
    assert "<svg" in text


def test_text_has_no_blank_lines_at_its_end():
    lines = SCENE.explain(*RAY).text.split("\n")
    assert lines[-1] == ""
    assert [line for line in lines if line != line.rstrip()] == []


def test_command(tmp_path):
    path = scene_file(tmp_path)
    result = execute("explain", path, "--ray", -3, 0.6, 0, 1, 0, 0, "--body", "ball", "--html", tmp_path / "why.html")
    assert result.stdout == co.load(path).explain(*RAY, body="ball").text
    assert "t₀ = −B − √D = 2.2" in result.stdout
    assert (tmp_path / "why.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    numbered = run("explain", path, "--ray", -3, 0.6, 0, 1, 0, 0, "--body", 1, "--t-max", 3)
    assert "Body 1 “Box 1”" in numbered.stdout
    assert "0 < t < 3" in numbered.stdout


ALONG = ("--ray", 0, 0, 0, 1, 0, 0)


@pytest.mark.parametrize(("options", "message"), [
    ((*ALONG, "--body", "bal"), "no body named 'bal'"), ((*ALONG, "--body", 9), "body: number must be at least 0 and below 5, got 9"),
    ((*ALONG, "--html", "x.pdf"), "the page is written as .html"), (("--ray", 0, 0, 0, 0, 0, 0), "direction must not be zero"),
    (("--ray", 0, 0, 0, 1), "requires 6 arguments"),
])  # fmt: skip
def test_command_refuses(options, message, tmp_path):
    assert message in failure("explain", scene_file(tmp_path), *options)


def test_a_sweep_counts_the_inputs_of_its_own_body():
    """Two boxes have x in [0, 4] and in [1, 3]. A ray must be in both at once to be in their intersection."""
    slab = co.Box((0, -1, -1), (4, 1, 1)) & co.Box((1, -2, -2), (3, 2, 2))
    scene = co.Scene([slab.translate((0, 9, 0)), slab])
    sweep = scene.explain((-5, 0, 0), (1, 0, 0), body=1).bodies[-1].sweep
    assert [(row.t, row.count, row.need) for row in sweep.rows] == [(5, 1, 2), (6, 2, 2), (8, 1, 2), (9, 0, 2)]
