"""co.optics.fresnel and coats, against closed forms."""

import math

import numpy as np
import pytest

import conicoid as co

COS = np.cos(np.linspace(0, 1.5, 31))


def film(w, cos, n0, n, d, ns, p):
    """Airy's sum over the beams in one film: r = (a + b e) / (1 + a b e), e = exp(2iδ), by hand from two walls."""
    sine = n0 * np.sqrt(1 - cos**2)
    c1, c2 = np.sqrt(1 - (sine / n) ** 2 + 0j), np.sqrt(1 - (sine / ns) ** 2 + 0j)

    def wall(m, u, k, v):
        return (k * u - m * v) / (k * u + m * v) if p else (m * u - k * v) / (m * u + k * v)

    a, b, turn = wall(n0, cos, n, c1), wall(n, c1, ns, c2), np.exp(4j * np.pi * n * d * c1 / w)
    return (a + b * turn) / (1 + a * b * turn)


def test_normal_incidence_and_signs():
    found = co.optics.fresnel(1.0, 1.0, 1.5)
    assert found.reflectance == pytest.approx(0.04, rel=1e-15)
    assert (found.r_s, found.r_p, found.t_s, found.t_p) == pytest.approx((-0.2, 0.2, 0.8, 0.8), rel=1e-15)


@pytest.mark.parametrize("n", [1.31, 1.5, 2.4, 4.0])
def test_brewsters_angle(n):
    brewster = co.optics.fresnel(math.cos(math.atan(n)), 1.0, n)
    assert brewster.reflectance_p < 1e-30
    assert brewster.transmittance_p == pytest.approx(1, rel=1e-14)
    # the reflected light is polarised across; its share is ((n² - 1) / (n² + 1))²
    assert brewster.reflectance_s == pytest.approx(((n * n - 1) / (n * n + 1)) ** 2, rel=1e-13)


def test_total_reflection_is_exact():
    critical = math.asin(1 / 1.5)
    found = co.optics.fresnel(np.cos(np.linspace(critical + 1e-9, math.pi / 2, 50)), 1.5, 1.0)
    assert (found.reflectance == 1).all()
    assert (found.transmittance == 0).all()
    # Fresnel's rhomb: the phases differ by 45° at 54.6° in glass of 1.51 (Born and Wolf, section 1.5.4: at 54°37')
    rhomb = co.optics.fresnel(math.cos(math.radians(54 + 37 / 60)), 1.51, 1.0)
    differ = np.degrees(np.angle(rhomb.r_p) - np.angle(rhomb.r_s)) % 360
    assert min(differ, 360 - differ) == pytest.approx(45, abs=0.01)


@pytest.mark.parametrize(("n1", "n2"), [(1.0, 1.5), (1.5, 1.0), (1.33, 2.2), (1.5, 0.2 + 3.4j), (1.0, 4 + 0.01j)])
def test_energy_is_kept(n1, n2):
    found = co.optics.fresnel(COS, n1, n2)
    for r, t in (
        (found.reflectance_s, found.transmittance_s),
        (found.reflectance_p, found.transmittance_p),
        (found.reflectance, found.transmittance),
    ):
        assert np.abs(r + t - 1).max() < 1e-14
    assert np.abs(found.absorptance).max() < 1e-14


def test_stokes_relations():
    beyond = np.sqrt(1 - (1 - COS**2) / 1.5**2)
    there, back = co.optics.fresnel(COS, 1.0, 1.5), co.optics.fresnel(beyond, 1.5, 1.0)
    for r, s, t, u in ((there.r_s, back.r_s, there.t_s, back.t_s), (there.r_p, back.r_p, there.t_p, back.t_p)):
        assert np.abs(r + s).max() < 1e-14
        assert np.abs(t * u + r * r - 1).max() < 1e-13


def test_metals():
    # Born and Wolf, section 14.2: at normal incidence ((n - 1)² + k²) / ((n + 1)² + k²)
    n, k = 0.21, 3.272
    share = ((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k)
    assert co.optics.fresnel(1.0, 1.0, n, k=k).reflectance == pytest.approx(share, rel=1e-14)
    assert co.optics.fresnel(1.0, 1.0, n + k * 1j).reflectance == pytest.approx(share, rel=1e-14)


def test_shapes_misses_and_errors():
    assert co.optics.fresnel(np.full((2, 3), 0.5), 1.0, np.array([1.1, 1.2, 1.3])).reflectance.shape == (2, 3)
    assert np.isnan(co.optics.fresnel(np.nan, 1.0, 1.5).reflectance)
    assert co.optics.fresnel(-0.5, 1.0, 1.5).reflectance == co.optics.fresnel(0.5, 1.0, 1.5).reflectance
    assert (co.optics.fresnel([0.0, 1.0], 1.4, 1.4).transmittance == 1).all()
    for arguments, told in (
        ((1.1, 1, 1.5), r"^fresnel: cos must be in \[-1, 1\]"),
        ((1.0, 0, 1.5), "^fresnel: n1 must be > 0, got 0"),
        ((1.0, 1, -1.5), "^fresnel: n2 must be > 0"),
        ((1.0, 1, 1.5, -1), "^fresnel: k must be >= 0"),
        ((np.ones(3), 1, np.ones(2)), "^fresnel: cos, n1 and n2 must broadcast"),
    ):
        with pytest.raises(ValueError, match=told):
            co.optics.fresnel(*arguments)


def test_a_quarter_wave_of_magnesium_fluoride():
    # R = ((n0 ns - n²) / (n0 ns + n²))²: 1.26 % where glass alone has 4.26 % (Macleod, section 4.1)
    coat = co.optics.Coating.quarter_wave([1.38], 0.55)
    found = coat.at(0.55, n2=1.52).reflectance
    assert found == pytest.approx(((1.52 - 1.38**2) / (1.52 + 1.38**2)) ** 2, rel=1e-13)
    assert round(100 * found, 2) == 1.26
    assert round(100 * co.optics.fresnel(1, 1, 1.52).reflectance, 2) == 4.26
    assert coat.at(0.55 / 2, n2=1.52).reflectance == pytest.approx(co.optics.fresnel(1, 1, 1.52).reflectance, rel=1e-12)


@pytest.mark.parametrize("pairs", [1, 4, 10])
def test_a_mirror_of_quarter_waves(pairs):
    # (H L)ᵖ H on glass: R = ((1 - Y) / (1 + Y))², Y = (nH / nL)²ᵖ nH² / ns (Macleod, section 6.1)
    high, low, glass = 2.3, 1.38, 1.52
    y = (high / low) ** (2 * pairs) * high**2 / glass
    coat = co.optics.Coating.quarter_wave([high, low] * pairs + [high], 0.6)
    assert coat.at(0.6, n2=glass).reflectance == pytest.approx(((1 - y) / (1 + y)) ** 2, rel=1e-12)


@pytest.mark.parametrize(("n0", "n", "ns"), [
    (1.0, 1.38, 1.52), (1.0, 2.3 + 0.1j, 1.5), (1.5, 1.0, 1.5), (1.0, 0.05 + 3.6j, 1.52), (1.33, 1.6, 0.2 + 3j),
])  # fmt: skip
def test_one_film_against_the_sum_of_its_beams(n0, n, ns):
    w, d = np.linspace(0.4, 0.8, 7)[:, None], 0.12
    found = co.optics.Coating([(n, d)]).at(w, COS, n0, ns)
    for r, share, p in ((found.r_s, found.reflectance_s, False), (found.r_p, found.reflectance_p, True)):
        want = film(w, COS, n0, n, d, ns, p)
        assert np.abs(r - want).max() < 1e-12
        assert np.abs(share - abs(want) ** 2).max() < 1e-12


def test_films_that_do_not_absorb_keep_the_light_and_pass_it_both_ways_alike():
    coat = co.optics.Coating([(2.3, 0.07), (1.38, 0.11), (1.9, 0.3)])
    beyond = np.sqrt(1 - (1 - COS**2) / 1.52**2)
    there, back = coat.at(0.5, COS, 1.0, 1.52), coat.reversed().at(0.5, beyond, 1.52, 1.0)
    assert np.abs(there.absorptance).max() < 1e-14
    assert there.transmittance_s == pytest.approx(back.transmittance_s, rel=1e-12)
    assert there.transmittance_p == pytest.approx(back.transmittance_p, rel=1e-12)


def test_a_film_may_be_split_and_thick_metal_hides_what_it_lies_on():
    one, two = co.optics.Coating([("Ag", 0.04)]), co.optics.Coating([("Ag", 0.01), ("Ag", 0.03)])
    a, b = one.at(0.6, COS, 1, 1.5), two.at(0.6, COS, 1, 1.5)
    assert a.t_p == pytest.approx(b.t_p, rel=1e-12)
    thick = co.optics.Coating([("Ag", 1e4)]).at(0.6, COS, 1, 1.5)
    assert thick.reflectance == pytest.approx(
        co.optics.fresnel(COS, 1, co.optics.glass("Ag")(0.6)).reflectance, rel=1e-12
    )
    assert (thick.transmittance == 0).all()


def test_what_is_no_coat():
    for layers, told in (
        ([(1.38, -1)], r"layers\[0\]: Layer: thickness must be > 0"), ([1.38], r"layers\[0\] must be a pair"),
        ("MgF2", "layers must be pairs"), ([(0, 1)], "refractive_index must be > 0"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=told):
            co.optics.Coating(layers)
