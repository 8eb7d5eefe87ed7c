"""The examples: every picture of the gallery, small, and the lens against paraxial theory."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

from .samples import deep

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    before = set(sys.modules)
    yield importlib.import_module
    for name in set(sys.modules) - before:
        if getattr(sys.modules[name], "__file__", None) and Path(str(sys.modules[name].__file__)).parent == EXAMPLES:
            del sys.modules[name]


@pytest.mark.parametrize("every", [15, deep(1)])
def test_every_picture_of_the_gallery(load, every):
    """A fast run draws one picture in fifteen."""
    for name, picture in list(load("gallery").PICTURES.items())[::every]:
        pixels = picture(None, 0.1).pixels
        assert np.isfinite(pixels).all(), name
        assert pixels.std() > 0.05, name


LARGE = ["clay_assembly"]
"""Pictures whose scenes take seconds to read."""


def _is_seen(picture):
    pixels = picture(None, 0.04, samples=2).pixels
    return np.isfinite(pixels).all() and pixels.std() > 0.005


@pytest.mark.parametrize("is_large", [False, deep(True)])
def test_pictures_by_light_transport(load, is_large):
    """Each has a few pixels, with two samples. All of it is light, and some body is visible."""
    light = load("gallery").LIGHT
    assert [name for name in light if (name in LARGE) == is_large and not _is_seen(light[name])] == []


def test_the_ball_lens_has_its_paraxial_focus(load):
    """The focus is n R / (2 (n - 1)) from the center, up to spherical aberration of second order in the height."""
    lens = load("trace_ball_lens")
    paraxial = 1.52 / (2 * 0.52)
    errors = [paraxial - lens.focal_length(height) for height in (0.1, 0.01, 0.001)]
    assert 0 < errors[2] < 1e-6
    assert errors[1] / errors[2] == pytest.approx(100, rel=1e-2)


def test_the_explained_ray_goes_through_the_bore(load, tmp_path, capsys):
    """The ray crosses the bore of radius 1/2 about z at x = −4 + t = ∓1/2. The lens's balls of radius 2.2 follow."""
    example = load("explained")
    example.main(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"explained.svg", "explained.html"}
    assert capsys.readouterr().out.startswith("The ray\n")
    found = example.scene().explain(*example.RAY)
    assert [crossing.t for crossing in found["barrel"].crossings[1:3]] == pytest.approx([3.5, 4.5], rel=1e-15)
    # |(−4 + t − c, 0.9 − 0.12 t)|² = 2.2²: the later entry and the earlier exit of c = 5.5 and 2.5
    roots = [np.roots([1 + 0.12**2, -2 * (4 + c) - 0.216, (4 + c) ** 2 + 0.81 - 2.2**2]) for c in (5.5, 2.5)]
    expected = [max(map(min, roots)), min(map(max, roots))]
    assert [crossing.t for crossing in found["lens"].crossings] == pytest.approx(expected, rel=1e-12)
    assert found["box"].outcome == "box missed"


def test_the_head_is_that_of_the_shared_figures(load):
    """There are ten ellipsoids, and the projection integrates to their mass."""
    head = load("shepp_logan")
    solids, density = head.head()
    assert len(solids) == len(density) == 10
    assert density.sum() == pytest.approx(1 - 0.8 - 0.4 + 0.6)
    projection = head.projection(64)
    assert projection.shape == (64, 64)
    # total mass: sum of density times 4/3 pi a b c, for pixels of (2 / 64)²
    mass = sum(d * 4 / 3 * np.pi * np.prod(size) for d, size in zip(density, sizes(), strict=True))
    assert projection.sum() * (2 / 64) ** 2 == pytest.approx(mass, rel=5e-3)


def test_the_head_follows_its_euler_angles(load):
    """A point is inside where p = Rz(psi) Rx(theta) Rz(phi) (x - center), as coordinates turn, has Σ (p / axis)² <= 1."""
    solids, _ = load("shepp_logan").head()
    points = np.random.default_rng(3).uniform(-1, 1, (20_000, 3))
    for solid, row in zip(solids, table(), strict=True):
        _, a, b, c, x, y, z, phi, theta, psi = row
        turn = about_z(psi) @ about_x(theta) @ about_z(phi)
        own = (points - (x, y, z)) @ turn.T
        inside = ((own / (a, b, c)) ** 2).sum(axis=1)
        clear = np.abs(inside - 1) > 1e-9
        assert (co.Scene([solid]).contains(points)[clear] == (inside <= 1)[clear]).all()


def about_z(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def about_x(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def sizes() -> list[list[float]]:
    return [row[1:4] for row in table()]


def table() -> list[list[float]]:
    lines = (EXAMPLES / "shepp_logan.csv").read_text(encoding="utf-8").splitlines()
    return [[float(x) for x in line.split(",")] for line in lines if line[0] in "-01"]


def test_tracks_cross_all_parts_of_the_detector(load, capsys):
    """A track straight up crosses the thickness of each tube. Tubes are cut open towards -y and +z."""
    example = load("detector_tracks")
    found = example.parts().lengths((0, 0, 0), (0, 1, 0))
    layers = [outer - inner for inner, outer, *_ in load("detector").LAYERS]
    assert found[:5] == pytest.approx([0.02, *layers], rel=1e-12)
    assert found[7] == pytest.approx(3.22 - 2.86, rel=1e-12)  # the coil
    example.main(2000)
    assert len(capsys.readouterr().out.splitlines()) == len(found)
