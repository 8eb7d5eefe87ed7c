"""Drawings: the curves of the paths are the sections, point by point."""

import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import conicoid as co

NAME = "{http://www.w3.org/2000/svg}"


def paths_of(layout):
    """Return the path data of each body."""
    return [path.get("d") for path in ET.fromstring(layout.svg).iter(NAME + "path")]


def samples(d, count=40):
    """Return points (n, 2) of a path, (z, y) with y up, by a small evaluator of the commands M L A Q C Z."""
    tokens = re.findall(r"[MLAQCZ]|[-+]?[\d.]+(?:e[-+]?\d+)?", d)
    points, at, start, i = [], np.zeros(2), np.zeros(2), 0

    def numbers(k):
        nonlocal i
        values = np.array([float(x) for x in tokens[i : i + k]])
        i += k
        return values

    u = np.linspace(0, 1, count)[:, None]
    while i < len(tokens):
        command = tokens[i]
        i += 1
        if command == "M":
            at = start = numbers(2)
        elif command in "LZ":
            to = numbers(2) if command == "L" else start
            points.append(at + u * (to - at))
            at = to
        elif command == "Q":
            p, to = np.split(numbers(4), 2)
            points.append((1 - u) ** 2 * at + 2 * u * (1 - u) * p + u**2 * to)
            at = to
        elif command == "C":
            p, q, to = np.split(numbers(6), 3)
            points.append((1 - u) ** 3 * at + 3 * u * (1 - u) ** 2 * p + 3 * u**2 * (1 - u) * q + u**3 * to)
            at = to
        else:
            rx, ry, turn, large, sweep, *to = numbers(7)
            assert large == 0
            s, c = math.sin(math.radians(turn)), math.cos(math.radians(turn))
            own = np.array([[c, s], [-s, c]])  # to the axes of the ellipse
            points.append(arc(own @ at, own @ to, rx, ry, sweep, u[:, 0]) @ own)
            at = np.array(to)
    return np.concatenate(points) * (1, -1)


def arc(start, end, rx, ry, sweep, u):
    """Evaluate the small arc of an ellipse in the frame of its axes, by SVG 2, appendix B.2.4."""
    a, b = start / (rx, ry), end / (rx, ry)
    half, middle = (b - a) / 2, (a + b) / 2
    rest = math.sqrt(max(0.0, 1 - half @ half))
    across = np.array([-half[1], half[0]]) / np.hypot(*half)
    center = middle + across * rest * (1 if sweep else -1)
    first, last = math.atan2(*(a - center)[::-1]), math.atan2(*(b - center)[::-1])
    angle = (last - first) % (2 * math.pi) if sweep else -((first - last) % (2 * math.pi))
    angles = first + u * angle
    return (center + np.column_stack([np.cos(angles), np.sin(angles)])) * (rx, ry)


SOLIDS = {
    "sphere": co.Lens(30, -40, 6, 20), "ellipsoid": co.Lens(12, -16, 13, 20, -0.5, 0.3), "parabola": co.Lens(-30, 40, 3, 20, -1, -1),
    "plane and ring": co.Lens(math.inf, 20, 3, 24, back_aperture=18), "rod": co.Lens(5, -5, 30, 10),
    "mirror": co.Mirror(-50, -1, 30, 5, 8), "mirror's back": co.Mirror(60, 0, 30, -5), "cap": co.Conic(-20, -0.5, 20),
    "prism": co.Prism(50, 20, 10), "penta": co.PentaPrism(10, 8), "corner": co.CornerCube(10), "ball": co.Sphere(7),
    "hyperbola": co.Lens(20, -30, 6, 20, -4, -2), "moved": co.Lens(30, -40, 6, 20, -0.5).rotate("x", 25).translate((0, 3, 40)).scale((1, 1, -1)),
    "cut": co.Sphere(3) & co.Box((-1, -2, -9), (1, 2, 9)), "tilted": co.Lens(20, -20, 4, 10).rotate("y", 30).translate((1, 0, 9)),
    "tube": co.Tube((0, 0, -4), (1, 0, 4), 2, 3), "shell": co.Sphere(3) - co.Sphere(2, (0, 0, 0.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", SOLIDS)
def test_a_drawn_curve_is_the_section(name):
    """Every point of the path is on the solid's surface: glass is a little inside of it, and none a little outside."""
    scene = co.Scene([co.Body(SOLIDS[name], co.glass())])
    drawing = co.optics.layout(scene)
    assert drawing.omissions == ()
    (d,) = paths_of(drawing)
    assert d.count("Z") == d.count("M")
    points = samples(d)
    xyz = np.column_stack([np.zeros(len(points)), points[:, ::-1]])
    step = 5e-5 if "hyperbola" in name else 1e-9
    turns = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    around = xyz[:, None] + step * np.column_stack([np.zeros(64), np.sin(turns), np.cos(turns)])
    inside = scene.contains(around)
    assert inside.any(axis=1).all()
    assert (~inside).any(axis=1).all()
    if name in ("corner", "tilted", "tube"):
        return  # their widest parts lie beside the plane
    low, high = (np.array(end) for end in scene.bounds)
    assert xyz[:, 1:].min(axis=0) == pytest.approx(low[1:], abs=2e-2)
    assert xyz[:, 1:].max(axis=0) == pytest.approx(high[1:], abs=2e-2)


def test_sheets_are_open_lines():
    scene = co.Scene([co.Body(co.ConicSheet(-50, -1, 30, 10), co.mirror()), co.Body(co.Stop(4, 20), "black")])
    mirror, stop = paths_of(co.optics.layout(scene))
    assert "Z" not in mirror + stop
    points = samples(mirror)
    y = points[:, 1]
    assert points[:, 0] == pytest.approx(-(y**2) / 100, abs=1e-12)
    assert (np.abs(y).min(), np.abs(y).max()) == (5, 15)
    y = np.abs(samples(stop)[:, 1])
    assert (y.min(), y.max()) == (2, 10)


def test_drawn_rays_follow_the_trace():
    system = co.optics.prescription([(50, 6, 1.5168, 20), (-50, None, 1, 20)], 12, fields=(0, 3), name="a <lens>")
    drawing = co.optics.layout(system, rays=3)
    root = ET.fromstring(drawing.svg)
    assert root.find(NAME + "title").text == "a <lens>"
    rays = [
        np.array([float(x) for x in re.split("[ ,]", line.get("points"))]).reshape(-1, 2)
        for line in root.iter(NAME + "polyline")
    ]
    assert len(rays) == 6
    assert {line.get("stroke") for line in root.iter(NAME + "polyline")} == {"#1f6fb4", "#2a9d4b"}
    pupil = np.column_stack([np.zeros(3), [-1, 0, 1]])
    for k, field in enumerate((0, 3)):
        found = co.optics.trace(system, co.optics.beam(system, field, pupil=pupil))
        for i in range(3):
            drawn = rays[3 * k + i] * (1, -1)
            assert drawn[1:-1] == pytest.approx(found.points[1:, i][:, [2, 1]], abs=1e-10)
            assert drawn[-1] == pytest.approx(found.at(system.image)[i, [2, 1]], abs=1e-10)


def test_bodies_beside_the_plane_are_named(tmp_path):
    bodies = [
        co.Body(co.Sphere(3), co.glass(), "ball"),
        co.Body(co.Sphere(3, (9, 0, 0)) & co.Box((5, -1, -1), (9, 1, 1)), co.glass(), "beside"),
        co.Body(co.Sphere(1, (9, 0, 0)), co.glass()),
    ]
    drawing = co.optics.layout(co.Scene(bodies))
    assert drawing.omissions == ("beside", "2")
    assert len(paths_of(drawing)) == 1
    drawing.save(tmp_path / "x.svg")
    assert (tmp_path / "x.svg").read_text(encoding="utf-8") == drawing.svg == drawing._repr_svg_()
    for call, error, message in (
        (lambda: drawing.save(tmp_path / "x.png"), ValueError, "Layout.save: path must end with .svg"),
        (
            lambda: co.optics.layout(co.Scene([co.HalfSpace((0, 0, 1), 0)])),
            ValueError,
            "layout: system must have bodies of finite size",
        ),
        (
            lambda: co.optics.layout(
                co.optics.prescription([(50, 6, 1.5, 20), (-50, None)], 5), rays=co.Rays((0, 0, 0), (0, 0, 1))
            ),
            TypeError,
            "layout: rays must be a number for a Prescription",
        ),
    ):
        with pytest.raises(error, match=message):
            call()


@pytest.mark.parametrize("faces", [(0,), (1,), (0, 1)])
def test_coats_change_no_drawing(faces):
    coat = co.optics.Coating.quarter_wave([1.38], 0.55)
    coats = [coat if face in faces else None for face in (0, 1)]
    plain, coated = (
        co.Scene([*co.LensGroup((50, -60), (6,), 20, (1.5,), coatings=coatings)]) for coatings in (None, coats)
    )
    assert paths_of(co.optics.layout(coated)) == paths_of(co.optics.layout(plain))
