"""Reconstruction filters: samples lie as the filters' integrals say, and pictures are the same for any tiles and threads."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.render.film import RADII, lower_filter
from conicoid.render.options import FILTERS

MOMENT = {
    "box": 1 / 12,
    "tent": 1 / 6,
    # 2 ∫₀¹ x² (7 x³ - 12 x² + 16/3) / 6 + 2 ∫₁² x² (-7/3 x³ + 12 x² - 20 x + 32/3) / 6
    "mitchell": (7 / 6 - 12 / 5 + 16 / 9) / 3 + (-7 / 18 * 63 + 12 / 5 * 31 - 5 * 15 + 32 / 9 * 7) / 3,
}
"""∫x² f / ∫f in closed form."""


def quadrature(name, power, signed):
    """∫xᵖ f dx, or of |f|, by the midpoint rule, of formulas written down once more."""
    r = RADII[name]
    x = (np.arange(200_000) + 0.5) / 200_000 * 2 * r - r
    t = 2 * np.pi * (x + r) / (2 * r)
    f = {
        "box": lambda: np.ones_like(x),
        "tent": lambda: 1 - abs(x),
        "gaussian": lambda: np.exp(-2 * x**2) - np.exp(-4.5),
        "mitchell": lambda: np.where(
            abs(x) < 1, 7 * abs(x) ** 3 - 12 * x**2 + 16 / 3, -7 / 3 * abs(x) ** 3 + 12 * x**2 - 20 * abs(x) + 32 / 3
        ) / 6,
        "blackman-harris": lambda: 0.35875 - 0.48829 * np.cos(t) + 0.14128 * np.cos(2 * t) - 0.01168 * np.cos(3 * t),
    }[name]()  # fmt: skip
    return np.sum(x**power * (f if signed else abs(f))) * 2 * r / 200_000


@pytest.mark.parametrize("name", FILTERS)
def test_samples_lie_as_the_filter_says(name):
    quantiles, change, scale = lower_filter(name)
    assert (quantiles == -quantiles[::-1]).all()
    assert (quantiles[0], quantiles[-1]) == (-RADII[name], RADII[name])
    # x is linear between quantiles, each of which is as likely: the moments of |f|, and of f by the signs
    a, b = quantiles[:-1], quantiles[1:]
    second = (a * a + a * b + b * b) / 3
    sign = np.where(np.abs((a + b) / 2) > change, -1, 1)
    assert second.mean() == pytest.approx(
        quadrature(name, 2, False) / quadrature(name, 0, False), rel=4e-3
    )  # of 1024 steps
    assert (sign * second).mean() * math.sqrt(scale) == pytest.approx(
        quadrature(name, 2, True) / quadrature(name, 0, True), rel=4e-3, abs=4e-3
    )
    assert sign.mean() * math.sqrt(scale) == pytest.approx(1, abs=2e-3)
    if name in MOMENT:
        assert quadrature(name, 2, True) == pytest.approx(MOMENT[name], abs=1e-9)


def test_mitchells_cubic_is_a_partition_of_unity():
    """Its copies one pixel apart add up to 1, so that flat light stays flat (Mitchell and Netravali 1988)."""
    from conicoid.render.film import mitchell

    x = np.linspace(0, 1, 101)
    assert sum(mitchell(x + k) for k in range(-2, 3)) == pytest.approx(np.ones(101), abs=1e-14)


@pytest.mark.parametrize("name", FILTERS)
def test_flat_light_stays_flat_and_an_edge_is_the_integral_of_the_filter(name):
    wall = co.Body(co.Polygon([(0, 4, -50), (50, 4, -50), (50, 4, 50), (0, 4, 50)]), "white")
    camera = co.OrthographicCamera((0, 0, 0), (0, 1, 0), height=16)  # a pixel is one unit
    scene = co.Scene([wall], camera=camera, background="black", lights=[co.AmbientLight(1)])
    rows = scene.render(16, 16, 4096, filter=name).pixels[8, :, 0]
    x = np.arange(16) + 0.5 - 8  # of the pixels' middles
    fine = np.linspace(-RADII[name], RADII[name], 4001)
    middles, step = (fine[1:] + fine[:-1]) / 2, fine[1] - fine[0]
    from conicoid.render.film import _CURVES

    f = _CURVES[name](middles)
    expected = [f[middles > -place].sum() * step for place in x] / (f.sum() * step)
    assert np.abs(rows - expected).max() < (0.04 if name == "mitchell" else 0.01)


@pytest.mark.parametrize("name", FILTERS)
def test_the_same_picture_for_any_threads(name):
    scene = co.Scene([co.Sphere(), co.Body(co.Sphere(0.5, (1, -1, 0)), co.glass())])
    pictures = []
    try:
        for threads in (1, 2, 7):
            co.set_threads(threads)
            pictures.append(scene.render(50, 40, 3, filter=name).pixels)
    finally:
        co.set_threads(None)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()
    with co.parallel.Processes(1) as pool:
        far = scene.render(50, 40, 3, filter=name, executor=pool) if name == "mitchell" else None
    assert far is None or (far.pixels == pictures[0]).all()


def test_unknown_filters():
    with pytest.raises(
        ValueError, match=r"render: filter must be one of box, .*, got 'gausian' \(did you mean 'gaussian'"
    ):
        co.Scene([]).render(2, 2, filter="gausian")
