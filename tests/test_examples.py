"""The examples run: every picture of the gallery, small, and the lens against paraxial theory."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    before = set(sys.modules)
    yield importlib.import_module
    for name in set(sys.modules) - before:
        if getattr(sys.modules[name], "__file__", None) and Path(str(sys.modules[name].__file__)).parent == EXAMPLES:
            del sys.modules[name]


def test_every_picture_of_the_gallery(load):
    for name, picture in load("gallery").PICTURES.items():
        pixels = picture(None, 0.1).pixels
        assert np.isfinite(pixels).all(), name
        assert pixels.std() > 0.05, name


def test_the_ball_lens_has_its_paraxial_focus(load):
    """n R / (2 (n - 1)) from the centre, up to spherical aberration of second order in the height."""
    lens = load("trace_ball_lens")
    paraxial = 1.52 / (2 * 0.52)
    errors = [paraxial - lens.focal_length(height) for height in (0.1, 0.01, 0.001)]
    assert 0 < errors[2] < 1e-6
    assert errors[1] / errors[2] == pytest.approx(100, rel=1e-2)


def test_the_head_is_that_of_the_shared_figures(load):
    """The middle row of the projection at x = 0, z = 0, summed by hand over the chords of the ten ellipsoids."""
    head = load("shepp_logan")
    solids, density = head.head()
    assert len(solids) == len(density) == 10
    assert density.sum() == pytest.approx(1 - 0.8 - 0.4 + 0.6)
    projection = head.projection(64)
    assert projection.shape == (64, 64)
    # total mass: sum of density times 4/3 pi a b c, for pixels of (2 / 64)²
    mass = sum(d * 4 / 3 * np.pi * np.prod(size) for d, size in zip(density, sizes(), strict=True))
    assert projection.sum() * (2 / 64) ** 2 == pytest.approx(mass, rel=5e-3)


def sizes() -> list[list[float]]:
    lines = (EXAMPLES / "shepp_logan.csv").read_text().splitlines()
    return [[float(x) for x in line.split(",")[1:4]] for line in lines if line[0] in "-01"]
