"""Published prescriptions: their scenes have the focal lengths that were printed, by real rays and by matrices."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..samples import size
from .matrices import first_order
from .published import LENSES


def system_of(lens):
    rows = [
        dict(radius=row[0], thickness=row[1], medium=row[2], conic=(*row, 0.0)[3], stop=i == lens.stop)
        for i, row in enumerate(lens.rows)
    ]
    return co.optics.prescription(rows, lens.aperture)


def last_digit(text):
    """Half a unit of the last digit of a printed number."""
    digits, _, power = text.partition("E")
    decimals = len(digits.partition(".")[2])
    return 0.5 * 10.0 ** (int(power or 0) - decimals)


def slack(lens, what):
    """By how much the quantity may differ as the indices are rounded: to first order, all of them the wrong way."""
    found = 0.0
    for i, row in enumerate(lens.rows):
        if lens.rounded and row[2] not in (1, "mirror"):
            moved = [*lens.rows[:i], (*row[:2], row[2] + lens.rounded, *row[3:]), *lens.rows[i + 1 :]]
            found += abs(first_order(moved)[what] - first_order(lens.rows)[what])
    return found


@pytest.mark.parametrize("name", LENSES)
def test_focal_lengths_are_those_printed(name):
    lens = LENSES[name]
    points = co.optics.cardinal_points(system_of(lens))
    found = {"efl": points.focal_length, "bfl": points.back_focal_length, "ffl": points.front_focal_length}
    for what, text in lens.printed.items():
        assert abs(found[what] - float(text)) <= last_digit(text) + slack(lens, what), (what, found[what], text)


@pytest.mark.parametrize("name", LENSES)
def test_real_rays_agree_with_matrices(name):
    lens = LENSES[name]
    expected, points = first_order(lens.rows), co.optics.cardinal_points(system_of(lens))
    size = abs(expected["efl"])
    assert points.focal_length == pytest.approx(expected["efl"], rel=2e-9)
    for what in ("front_focus", "rear_focus", "front_principal", "rear_principal"):
        assert getattr(points, what) == pytest.approx(expected[what], rel=2e-9, abs=2e-9 * size), what
    assert co.optics.focal_length(system_of(lens)) == points.focal_length


LENSES_OF_GLASS = [name for name, lens in LENSES.items() if all(row[2] != "mirror" for row in lens.rows)]


@pytest.mark.parametrize("name", LENSES_OF_GLASS)
def test_the_scene_alone_says_the_same(name):
    """Without the prescription: bodies and refractive indices of materials. The stop is left out, it has no index."""
    system = system_of(LENSES[name])
    glass = co.Scene([body for body in system.bodies if body.name != "stop"])
    points = co.optics.cardinal_points(glass)
    assert points.focal_length == pytest.approx(first_order(LENSES[name].rows)["efl"], rel=1e-7)


@pytest.mark.parametrize("name", ["double Gauss f/2", "Heliar", "telephoto"])
def test_cemented_walls_are_one_surface(name):
    lens = LENSES[name]
    system = system_of(lens)
    assert co.check(co.Scene([body for body in system.bodies if body.name != "stop"]), rays=size(20_000, 200_000)) == []
    walls = system.scene.crossings((0.3, 0.2, -50), (0, 0, 1))
    cemented = [i for i in range(1, len(lens.rows)) if lens.rows[i - 1][2] != 1 and lens.rows[i][2] != 1]
    shared = np.flatnonzero(np.diff(walls.t) == 0)
    assert len(shared) == len(cemented) > 0
    assert (walls.surface[shared] == walls.surface[shared + 1]).all()


def test_at_least_ten_are_compared_with_a_printed_focal_length():
    assert sum("efl" in lens.printed for lens in LENSES.values()) >= 10
