"""Refractive indices by wavelength: the catalogue against what its makers print, and materials that have them."""

import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid.render.bsdf.registry import lower_materials

from .printed import PRINTED

ROWS = [line.split() for line in PRINTED.strip().split("\n")]


def test_every_glass_has_the_index_and_abbe_number_that_its_maker_prints():
    assert len(ROWS) > 200
    for name, index, abbe in ROWS:
        found = co.optics.glasses[name]
        assert found.n_d == pytest.approx(float(index), abs=1e-5), name
        assert found.abbe_number == pytest.approx(float(abbe), abs=0.02), name


@pytest.mark.parametrize(("name", "wavelength", "index", "within"), [
    ("fused silica", 0.5875618, 1.458464, 1e-6),  # Malitson's table: 1.45846 at d
    ("fused silica", 1.55, 1.444024, 1e-6),
    ("water", 0.589, 1.33334, 2e-5),  # 1.3334 of distilled water at 20 °C and 589 nm
    # Edlén 1953: (n - 1) 1e8 = 6432.8 + 2949810 / (146 - σ²) + 25540 / (41 - σ²), σ = 1 / λ
    ("air", 0.633, 1 + 1e-8 * (6432.8 + 2949810 / (146 - 0.633**-2) + 25540 / (41 - 0.633**-2)), 1.5e-8),
    ("germanium", 10.0, 4.0040, 1e-4),  # Burnett: 4.0040 at 10 μm
    ("sapphire", 0.5875618, 1.76817, 1e-5), ("CaF2", 0.5875618, 1.43385, 1e-5), ("MgF2", 0.5875618, 1.37774, 1e-5),
    ("diamond", 0.5893, 2.417, 1e-3), ("NaCl", 0.5893, 1.5443, 3e-4),
    ("ZnSe", 10.6, 2.4028, 2e-4), ("Si", 4.0, 3.4255, 2e-4),
])  # fmt: skip
def test_crystals_liquids_and_gases(name, wavelength, index, within):
    assert co.optics.glass(name)(wavelength) == pytest.approx(index, abs=within)


def test_metals_are_complex():
    # Johnson and Christy measured 0.21 + 3.272i at 2.01 eV, which is 616.8 nm
    assert co.optics.glass("gold")(0.6168) == pytest.approx(0.21 + 3.272j)
    assert np.iscomplexobj(co.optics.glass("Al")([0.5, 0.6]))


def test_outside_of_its_range_there_is_no_index():
    with pytest.raises(
        ValueError, match=r"'N-BK7': wavelength must be in \[0.3, 2.5\] μm.*got 587.6; 587.6 nm are 0.5876"
    ):
        co.optics.glass("N-BK7")(587.6)
    with pytest.raises(ValueError, match="finite and > 0"):
        co.optics.glass("N-BK7")(-1)


def test_names_that_there_are_not():
    with pytest.raises(ValueError, match="'N-BK7' is a glass of the catalogue"):
        co.optics.glass("BK7")
    with pytest.raises(KeyError, match="did you mean 'N-SF11'"):
        co.optics.glasses["N-SF-11"]
    with pytest.raises(ValueError, match="refractive_index must be a number, got 'BK7'.*'N-BK7' is a glass"):
        co.glass("BK7")


FORMULAS = [
    "N-BK7", 1.5, co.optics.Sellmeier((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),
    co.optics.Cauchy((1.5, 0.004)), co.optics.Schott((2.25, -0.01, 0.01, 0.0, 0.0, 0.0)), co.optics.glass("air"),
    co.optics.Tabulated((0.4, 0.7), (1.5, 1.6), (0.0, 0.1)), co.optics.glass("N-SF11"), 1.5 + 0.1j,
]  # fmt: skip


@pytest.mark.parametrize("index", FORMULAS, ids=str)
def test_materials_of_any_index_are_pickled_written_and_drawn(index, tmp_path):
    coat = co.optics.Coating([(1.38, 0.1), ("MgF2", 0.2), (2.0 + 1j, 0.01)])
    scene = co.Scene([co.Body(co.Sphere(), co.glass(index, coating=coat))])
    made = scene.bodies[0].material
    assert pickle.loads(pickle.dumps(made)) == made
    assert hash(made) == hash(pickle.loads(pickle.dumps(made)))
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml").bodies[0].material == made
    assert np.isfinite(scene.render(4, 4, samples=1).pixels).all()


def bend(w):
    return 1.5 + 0.004 / w**2


def test_an_index_may_be_a_function():
    made = co.glass(bend)
    assert pickle.loads(pickle.dumps(made)) == made
    with pytest.raises(ValueError, match="refractive_index must be a number, the name of a glass.*got a function"):
        co.save(co.Scene([co.Body(co.Sphere(), made)]), "scene.yaml")
    for wrong in (lambda w: -1.0, lambda w: "a", lambda w: np.ones(7), lambda w: 1 - 1j):
        with pytest.raises(ValueError, match="the function must return"):
            co.glass(wrong)


def test_pictures_take_n_d_and_the_slope_between_blue_and_red():
    looks = [co.glass("N-SF11"), co.glass(bend), co.glass("Ge"), co.glass(1.5), co.glass("N-SF11", dispersion=0.001)]
    rows = lower_materials(looks, [False] * 5, np.arange(5), {}).rows
    sf11 = co.optics.glass("N-SF11")
    assert rows["index"][0] == sf11.n_d
    assert rows["index"][3] == 1.5
    # by Cauchy's formula with it, the Abbe number is that of the catalogue
    assert rows["dispersion"][0] * (0.4861327**-2 - 0.6562725**-2) == pytest.approx(
        (sf11.n_d - 1) / sf11.abbe_number, rel=1e-12
    )
    assert rows["dispersion"][1] == pytest.approx(0.004, rel=1e-9)
    assert rows["dispersion"][4] == 0.001
    assert rows["index"][2] == pytest.approx(co.optics.glass("Ge")(2.0))  # the end of its range that is nearest
    assert rows["dispersion"][2] == rows["dispersion"][3] == 0


def test_what_is_no_formula():
    for make, told in (
        (lambda: co.optics.Sellmeier((1, 2), (1,)), "b and c must be as many, got 2 and 1"),
        (lambda: co.optics.Schott((1, 2)), "coefficients must be a list of 6 numbers, got 2"),
        (lambda: co.optics.Cauchy(()), "coefficients must be a list of one number or more"),
        (lambda: co.optics.Tabulated((2, 1), (1, 1)), "wavelengths must be > 0 and rising"),
        (lambda: co.optics.Tabulated((1, 2), (1, -1)), "n must be > 0, got -1"),
        (lambda: co.optics.Tabulated((1, 2), (1, 1), (0,)), "k must be as many as wavelengths, 2, got 1"),
        (lambda: co.optics.Cauchy((1.5,), range=(2, 1)), "range must be two rising wavelengths"),
    ):
        with pytest.raises(ValueError, match=told):
            make()
