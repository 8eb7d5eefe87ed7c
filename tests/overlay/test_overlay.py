"""Overlays are at the right places in pictures, and leave all other pixels."""

import numpy as np
import pytest

import conicoid as co
from conicoid.render.overlay import (
    Canvas,
    _depths,
    _runs,
    find_hidden,
    is_in_font,
    pixel_sizes,
    printable_label,
    round_down_125,
)

SCENE = co.Scene(
    [co.Body(co.Sphere(0.5, (-1.5, 0, 0)), name="left"), co.Sphere(0.5, (1.5, 0, 0))],
    lights=co.AmbientLight(1),
    camera=co.OrthographicCamera((0, 0, 9), (0, 0, 0), height=6),
    background="black",
)
SIZE = dict(width=240, height=180, samples=1)
PLAIN = SCENE.render(**SIZE).pixels


def _drawn_pixels(**options: bool) -> np.ndarray:
    """Return, as (height, width), which pixels the overlay covers, and check that the others are the same to the bit."""
    drawn = SCENE.render(**SIZE, **options).pixels
    assert drawn.dtype == np.float32
    return (drawn != PLAIN).any(axis=2)


def test_an_empty_overlay_changes_no_pixel():
    assert not _drawn_pixels().any()
    assert not _drawn_pixels(axes=False, labels=False, normals=False).any()


def test_axes_are_where_the_camera_projects_them():
    """30 pixels are a unit. x runs from the middle to the right, y up, both in their color."""
    drawn = SCENE.render(**SIZE, axes=True).pixels
    x, y = drawn[90, 120:165], drawn[62:90, 120]
    assert (x.argmax(axis=1) == 0).mean() > 0.8  # the number at 1 is beside the axis
    assert (y.argmax(axis=1) == 1).mean() > 0.8
    changed = _drawn_pixels(axes=True)
    assert not changed[:, :100].any()
    assert not changed[130:].any()


def test_a_name_lies_on_its_body():
    changed = _drawn_pixels(labels=True)
    rows, columns = np.nonzero(changed)
    for half, middle in ((columns < 120, 75), (columns >= 120, 165)):
        assert abs(columns[half].mean() - middle) < 3
        assert abs(rows[half].mean() - 90) < 4


def test_names_go_where_most_of_the_body_is():
    entries = np.zeros((9, 20), int)
    entries[:, 6:] = 1
    entries[2:7, 12:] = 2
    depths = _depths(entries)
    assert depths[4, 3] == 2  # six columns wide, and its outer edge is the picture's
    assert depths[4, 2:4].min() == depths[:, :6].max()
    assert depths[0].max() == depths[:, 0].max() == 0


def test_normals_point_outward():
    """From above, arrows on a ball point away from its middle, and none is longer than its length."""
    sizes = SIZE | dict(width=480, height=360)
    drawn = SCENE.render(**sizes, normals=True).pixels != SCENE.render(**sizes).pixels
    rows, columns = np.nonzero(drawn.any(axis=2))
    distance = np.minimum(np.hypot(columns - 150, rows - 180), np.hypot(columns - 330, rows - 180))
    assert len(rows) > 50
    assert distance.max() < 30 + 22 + 3
    assert distance.max() > 30


def test_bodies_hide_lines_behind_them():
    camera = co.Camera((0, -9, 0), (0, 0, 0))
    scene = co.Scene(co.Box((-1, -1, -1), (1, 1, 1)))
    points = np.array([(0, -1, 0), (0, 0, 0), (0, 2, 0), (0, 2, 3), (0, -8, 0), (0, -10, 0)], float)
    assert find_hidden(scene, camera, points).tolist() == [False, True, True, False, False, True]
    parallel = co.OrthographicCamera((0, -9, 0), (0, 0, 0))
    assert find_hidden(scene, parallel, points).tolist() == [False, True, True, False, False, True]
    assert pixel_sizes(parallel, points, 100).tolist() == [0.02] * 6
    wide = co.Camera((0, -9, 0), (0, 0, 0), field_of_view=90)
    assert pixel_sizes(wide, points[:2], 100) == pytest.approx([0.16, 0.18])


def test_sheets():
    sheet = Canvas(20, 10)
    below = np.random.default_rng(0).random((10, 20, 3)).astype(np.float32)
    assert np.array_equal(sheet.over(below), below)
    sheet.line([(-1e9, 5), (1e9, 5)], "red", 2)
    over = sheet.over(below)
    assert over[4:6] == pytest.approx(np.broadcast_to((1, 0, 0), (2, 20, 3)), abs=0.35)
    assert np.array_equal(over[:3], below[:3])
    assert np.array_equal(over[7:], below[7:])


def test_numbers_along_axes_are_round():
    assert [round_down_125(x) for x in (1.0, 1.99, 2.0, 4.9, 5.0, 9.9, 0.03)] == [1, 1, 2, 2, 5, 5, 0.02]
    assert _runs(np.array([1, 1, 0, 0, 1], bool)) == [(0, 2), (4, 5)]
    assert _runs(np.zeros(3, bool)) == []


@pytest.mark.parametrize("scene", [
    co.Scene([]), co.Scene(co.Plane((0, 0, 1), 0)), co.Scene(co.Sphere(1e-80)), co.Scene(co.Sphere(1e80, (1e85, 0, 0))),
    co.Scene(co.Body(co.Sphere(), name="\x1b[31m" + "name " * 100)), co.Scene(co.Spheres(np.zeros((0, 3)), 1)),
    co.Scene(co.Sphere(), camera=co.Camera((0, 0, 0.5), (0, 0, 9))),
])  # fmt: skip
def test_any_scene_can_be_drawn_over(scene):
    image = scene.render(64, 48, samples=1, axes=True, labels=True, normals=True)
    assert np.isfinite(image.pixels).all()


def test_small_pictures_have_a_number_on_each_axis(monkeypatch):
    calls: list[str] = []
    monkeypatch.setattr(Canvas, "text", lambda self, place, text, color, size: calls.append(text))
    camera = co.Camera((6, -8, 5), (0, 0, 0))
    co.Scene(co.Sphere(2), camera=camera).render(200, 150, samples=1, axes=True)
    assert [t for t in calls if t in "xyz"] == ["x", "y", "z"]
    assert [float(t) > 0 for t in calls if t not in "xyz"] == [True] * 3


def test_names_are_written_in_letters_that_the_font_has():
    assert printable_label("Öffnung é, 45° ±1 …") == "Offnung e, 45° ±1 …"
    assert printable_label("日") == "\\u65e5"
    assert all(is_in_font(letter) for letter in printable_label("Ångström ß 日本 α"))
