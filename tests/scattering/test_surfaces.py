"""Every surface model: white furnaces, both directions alike, directions of the stated density, Fresnel's formulas."""

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.render.bsdf import microfacet as fresnel

from ..compiled import compiled
from ..samples import deeper, in_turn
from .lab import INSIDE, OUTSIDE, Bench, sphere, towards

WHITE = (1.0, 1.0, 1.0)
BRIGHT = dict(metal_index=WHITE, metal_extinction=(1e6, 1e6, 1e6))  # a metal that reflects all

LOSSLESS = {
    "matte": (co.matte(WHITE),),
    "rough matte": (co.matte(WHITE, roughness=0.8),),
    "mirror": (co.mirror(1.0),),
    "share mirrored": (co.Material(WHITE, reflectivity=0.3),),
    "lacquer": (co.lacquer(WHITE),),
    "plastic": (co.plastic(WHITE),),
    "rough plastic": (co.plastic(WHITE, roughness=0.4),),
    "metal": (co.Material(**BRIGHT),),
    "rough metal": (co.Material(**BRIGHT, roughness=0.3),),
    "roughest metal": (co.Material(**BRIGHT, roughness=1),),
    "glass": (co.glass(1.5),),
    "glass from inside": (co.glass(1.5), INSIDE),
    "rough glass": (co.glass(1.5, roughness=0.3),),
    "rough glass from inside": (co.glass(1.5, roughness=0.3), INSIDE),
    "roughest glass": (co.glass(1.8, roughness=1), INSIDE),
    "pane": (co.glass(1.5), OUTSIDE, True),
    "half transparent": (co.Material(WHITE, transparency=0.5),),
}
LOSSY = {
    "phong": (co.phong(WHITE, shininess=5),),
    "half-vector": (co.blinn_phong(WHITE, shininess=5),),
    "sharp half-vector": (co.blinn_phong(WHITE, specular=1, shininess=200),),
    "gold": (co.materials.gold(0.5),),
    "grey plastic": (co.plastic((0.5, 0.5, 0.5), roughness=0.4),),
}
ALL = LOSSLESS | LOSSY
SPREADING = [name for name in ALL if name not in ("mirror", "metal", "glass", "glass from inside", "pane")]


@pytest.mark.parametrize(("name", "cosine"), in_turn(LOSSLESS, (0.05, 0.4, 0.9)))
def test_a_white_furnace_hides_every_surface(name, cosine):
    """All light is sent on: to 5 standard errors and a quarter of a percent, which tables may be off by."""
    energy, error = Bench(*LOSSLESS[name]).energy(towards(cosine), 1 << 14)
    assert np.abs(energy - 1).max() < 5 * error.max() + 2.5e-3


@pytest.mark.parametrize("name", LOSSY)
@pytest.mark.parametrize("cosine", [0.02, 0.2, 0.6, 1.0])
def test_no_more_is_sent_on_than_arrives(name, cosine):
    energy, error = Bench(*LOSSY[name]).energy(towards(cosine), 1 << 14)
    assert (energy > 0.02).all()
    assert (energy < 1 + 5 * error).all()


@pytest.mark.parametrize("name", SPREADING)
def test_light_may_go_backwards(name):
    """f(o, i) = f(i, o); through a wall f(o, i) / n_i² is the same as backwards, seen from the other side."""
    material, side = ALL[name][0], OUTSIDE if len(ALL[name]) < 2 else ALL[name][1]
    bench, other = Bench(material, side), Bench(material, not side)
    for o in (towards(0.3), towards(0.8, 0.6)):
        directions = sphere(200, seed=1)
        forth, _ = bench.evaluate(o, directions)
        for i, f in zip(directions, forth, strict=True):
            if i[2] > 0:
                back, _ = bench.evaluate(i, [o])
                assert back[0] / o[2] == pytest.approx(f / i[2], rel=1e-9, abs=1e-12)
            else:
                back, _ = other.evaluate(-i, [-o])
                assert back[0] / o[2] * bench.eta**2 == pytest.approx(f / -i[2], rel=1e-9, abs=1e-12)


def chi_square(name, o, count, rows=10, columns=12, fine=16):
    """(χ² of draws in cells of equal solid angle against the density, cells, share drawn, its integral)."""
    bench = Bench(*ALL[name])
    z = (np.arange(rows * fine) + 0.5) / (rows * fine) * 2 - 1
    turn = (np.arange(columns * fine) + 0.5) / (columns * fine) * 2 * np.pi
    r = np.sqrt(1 - z**2)[:, None]
    grid = np.stack([r * np.cos(turn), r * np.sin(turn), np.broadcast_to(z[:, None], (len(z), len(turn)))], axis=-1)
    _, density = bench.evaluate(o, grid.reshape(-1, 3))
    cells = density.reshape(rows, fine, columns, fine).sum(axis=(1, 3)) * 4 * np.pi / len(density)
    draws = bench.draw(o, count, seed=5)
    i = draws.i[draws.how == 0]
    row = np.minimum(rows - 1, ((i[:, 2] + 1) / 2 * rows).astype(int))
    column = np.minimum(columns - 1, (np.arctan2(i[:, 1], i[:, 0]) / (2 * np.pi) % 1 * columns).astype(int))
    counts = np.bincount(row * columns + column, minlength=rows * columns).reshape(rows, columns)
    expected = cells * count
    many = expected > 20
    square = ((counts - expected)[many] ** 2 / expected[many]).sum()
    return square, int(many.sum()), len(i) / count, cells.sum()


ROUND = [name for name in SPREADING if name != "sharp half-vector"]  # whose density a coarse grid integrates


@pytest.mark.parametrize("name", ROUND)
@pytest.mark.parametrize(("cosine", "count", "fine", "sigmas", "slack"), [
    (0.6, 20_000, 16, 5, 0.01), *deeper((cosine, 200_000, 64, 6, 0.05) for cosine in (0.1, 0.3, 0.6, 0.95)),
])  # fmt: skip
def test_directions_have_the_stated_density(name, cosine, count, fine, sigmas, slack):
    square, cells, share, integral = chi_square(name, towards(cosine, 0.15), count, fine=fine)
    assert cells > 10
    assert square < cells + sigmas * math.sqrt(2 * cells) + slack * cells
    assert share == pytest.approx(integral, abs=0.02 if fine == 16 else 0.01)


@pytest.mark.parametrize("name", SPREADING)
def test_samples_are_weighted_by_their_density(name):
    bench, o = Bench(*ALL[name]), towards(0.45)
    draws = bench.draw(o, 500)
    spread = draws.how == 0
    f, density = bench.evaluate(o, draws.i[spread])
    assert spread.sum() > 50
    assert draws.density[spread] == pytest.approx(density, rel=1e-9)
    assert draws.weight[spread] * density[:, None] == pytest.approx(f, rel=1e-9)


# Fresnel

wall, conductor = compiled(fresnel.dielectric_reflectance), compiled(fresnel.conductor_fresnel)


@pytest.mark.parametrize("index", [1.33, 1.5, 2.4])
def test_fresnel_at_normal_incidence(index):
    assert wall(1.0, 1 / index) == pytest.approx(((index - 1) / (index + 1)) ** 2, rel=1e-12)
    assert wall(1.0, index) == pytest.approx(((index - 1) / (index + 1)) ** 2, rel=1e-12)
    assert conductor(1.0, index, 3.0) == pytest.approx(((index - 1) ** 2 + 9) / ((index + 1) ** 2 + 9), rel=1e-12)
    assert conductor(0.37, index, 0.0) == pytest.approx(wall(0.37, 1 / index), rel=1e-9)


def test_at_brewsters_angle_one_polarisation_alone_is_mirrored():
    """tan θ = n: R = R_s / 2 with R_s = ((n² - 1) / (n² + 1))²."""
    n = 1.5
    assert wall(math.cos(math.atan(n)), 1 / n) == pytest.approx(0.5 * ((n * n - 1) / (n * n + 1)) ** 2, rel=1e-12)


def test_beyond_the_critical_angle_all_is_mirrored():
    critical = math.sqrt(1 - 1 / 1.5**2)
    assert wall(critical - 1e-9, 1.5) == 1
    assert wall(critical + 1e-3, 1.5) < 1


def test_arrays_have_the_same_formulas():
    cosines = np.linspace(0.01, 1, 30)
    for eta in (1 / 1.5, 1.5):
        assert fresnel.dielectric_reflectances(cosines, eta) == pytest.approx(
            [wall(c, eta) for c in cosines], rel=1e-12
        )
    assert fresnel.conductor_reflectances(cosines, 0.2, 3.0) == pytest.approx(
        [conductor(c, 0.2, 3.0) for c in cosines], rel=1e-12
    )


def test_gold_is_yellow_and_silver_is_not():
    """Reflectances of Johnson and Christy's metals at normal incidence, ((n - 1)² + k²) / ((n + 1)² + k²)."""
    for metal in (
        co.materials.gold(),
        co.materials.silver(),
        co.materials.copper(),
        co.materials.aluminium(),
        co.materials.iron(),
    ):
        n, k = np.array(metal.metal_index), np.array(metal.metal_extinction)
        energy, _ = Bench(metal).energy((0, 0, 1), 1)
        assert energy == pytest.approx(((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2), rel=1e-12)
    gold, _ = Bench(co.materials.gold()).energy((0, 0, 1), 1)
    silver, _ = Bench(co.materials.silver()).energy((0, 0, 1), 1)
    assert gold[0] > 0.9 > 0.5 > gold[2]
    assert silver.min() > 0.95
