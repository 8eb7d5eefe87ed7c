"""Glass: catalogues, Fresnel's formulas, and the bodies on both sides of a hit."""

import math
import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid.render.bsdf.registry import lower_materials

from .printed import PRINTED

# --- Refractive indices by wavelength: the catalogue against the makers' sheets, and materials of the catalogue

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


FORMULAS = [
    "N-BK7", 1.5, co.optics.Sellmeier((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),
    co.optics.Cauchy((1.5, 0.004)), co.optics.Schott((2.25, -0.01, 0.01, 0.0, 0.0, 0.0)), co.optics.glass("air"),
    co.optics.Tabulated((0.4, 0.7), (1.5, 1.6), (0.0, 0.1)), co.optics.glass("N-SF11"), 1.5 + 0.1j,
]  # fmt: skip


@pytest.mark.parametrize("index", FORMULAS, ids=str)
def test_materials_of_any_index_are_pickled_written_and_drawn(index, tmp_path):
    coat = co.optics.Coating([(1.38, 0.1), ("MgF2", 0.2), (2.0 + 1j, 0.01)])
    scene = co.Scene([co.Body(co.Sphere(), co.glass(index, coating=coat))])
    material = scene.bodies[0].material
    assert pickle.loads(pickle.dumps(material)) == material
    assert hash(material) == hash(pickle.loads(pickle.dumps(material)))
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml").bodies[0].material == material
    assert np.isfinite(scene.render(4, 4, samples=1).pixels).all()


def bend(w):
    return 1.5 + 0.004 / w**2


def test_an_index_may_be_a_function():
    material = co.glass(bend)
    assert pickle.loads(pickle.dumps(material)) == material
    with pytest.raises(ValueError, match="refractive_index must be a number, the name of a glass.*got a function"):
        co.save(co.Scene([co.Body(co.Sphere(), material)]), "scene.yaml")


def test_pictures_take_n_d_and_the_slope_between_blue_and_red():
    looks = [co.glass("N-SF11"), co.glass(bend), co.glass("Ge"), co.glass(1.5), co.glass("N-SF11", dispersion=0.001)]
    rows = lower_materials(looks, [False] * 5, np.arange(5), {}).rows
    sf11 = co.optics.glass("N-SF11")
    assert rows["index"][0] == sf11.n_d
    assert rows["index"][3] == 1.5
    # Cauchy's formula with it gives the Abbe number of the catalogue
    assert rows["dispersion"][0] * (0.4861327**-2 - 0.6562725**-2) == pytest.approx(
        (sf11.n_d - 1) / sf11.abbe_number, rel=1e-12
    )
    assert rows["dispersion"][1] == pytest.approx(0.004, rel=1e-9)
    assert rows["dispersion"][4] == 0.001
    assert rows["index"][2] == pytest.approx(co.optics.glass("Ge")(2.0))  # the end of its range that is nearest
    assert rows["dispersion"][2] == rows["dispersion"][3] == 0


# --- co.optics.fresnel and coats, against closed forms

COS = np.cos(np.linspace(0, 1.5, 31))


def film(w, cos, n0, n, d, ns, p):
    """Return Airy's sum over the beams in one film: r = (a + b e) / (1 + a b e), e = exp(2iδ), by hand from two walls."""
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
def test_energy_is_conserved(n1, n2):
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


def test_a_film_may_be_split_and_thick_metal_hides_its_substrate():
    one, two = co.optics.Coating([("Ag", 0.04)]), co.optics.Coating([("Ag", 0.01), ("Ag", 0.03)])
    a, b = one.at(0.6, COS, 1, 1.5), two.at(0.6, COS, 1, 1.5)
    assert a.t_p == pytest.approx(b.t_p, rel=1e-12)
    thick = co.optics.Coating([("Ag", 19)]).at(0.6, COS, 1, 1.5)
    assert thick.reflectance == pytest.approx(
        co.optics.fresnel(COS, 1, co.optics.glass("Ag")(0.6)).reflectance, rel=1e-12
    )
    assert (thick.transmittance == 0).all()


COAT, LENS = co.optics.Coating([(1.38, 0.0996)]), co.optics.prescription([(50, 5, (1.5, 40)), (-50,)], 10)
ROOTLESS = (
    co.optics.Sellmeier((-5,), (0,)), co.optics.Schott((-1, 0, 0, 0, 0, 0)), co.optics.Cauchy((-1.5,)),
    co.optics.Edlen((1,), (4,)), co.optics.CatalogueFormula(7, (1, 1, 0.25)),
)  # fmt: skip
"""At 0.5 μm these are roots of numbers below 0, poles, or below 0. Films had NaN, inf and -1.5."""
REFUSED = [
    (lambda: co.optics.glass("N-BK7")(587.6), r"'N-BK7': wavelength must be in \[0.3, 2.5\] μm.*got 587.6$"),
    (lambda: co.optics.glass("N-BK7")(-1), "finite and > 0"),
    (lambda: co.optics.glass("BK7"), "got 'BK7' .did you mean 'N-BK7'"),
    (lambda: co.optics.glasses["N-SF-11"], "did you mean 'N-SF11'"),
    (lambda: co.glass("BK7"), "the name of a glass, got 'BK7' .did you mean 'N-BK7'"),
    *((lambda index=index: co.glass(index), "the function must return") for index in (
        lambda w: -1.0, lambda w: "a", lambda w: np.ones(7), lambda w: 1 - 1j)),
    *((lambda formula=formula, use=use: use(formula), rf"{type(formula).__name__}: index must be n > 0, or n .* got (nan|-?inf|-1.5)")
      for formula in ROOTLESS for use in (lambda n: n(0.5), lambda n: co.optics.Coating([(n, 0.1)]).at(0.5))),
    (lambda: co.optics.Sellmeier((1, 2), (1,)), "b and c must be as many, got 2 and 1"),
    (lambda: co.optics.Schott((1, 2)), "coefficients must be a list of 6 numbers, got 2"),
    (lambda: co.optics.Cauchy(()), "coefficients must be a list of one number or more"),
    (lambda: co.optics.Tabulated((2, 1), (1, 1)), "wavelengths must be > 0 and rising"),
    (lambda: co.optics.Tabulated((1, 2), (1, -1)), "n must be > 0, got -1"),
    (lambda: co.optics.Tabulated((1, 2), (1, 1), (0,)), "k must be as many as wavelengths, 2, got 1"),
    (lambda: co.optics.Cauchy((1.5,), range=(2, 1)), "range must be two rising wavelengths"),
    (lambda: co.optics.fresnel(1.1, 1, 1.5), r"^fresnel: cos must be in \[-1, 1\]"),
    (lambda: co.optics.fresnel(1.0, 0, 1.5), "^fresnel: n1 must be > 0, got 0"),
    (lambda: co.optics.fresnel(1.0, 1, -1.5), "^fresnel: n2 must be > 0"),
    (lambda: co.optics.fresnel(1.0, 1, 1.5, -1), "^fresnel: k must be >= 0"),
    (lambda: co.optics.fresnel(np.ones(3), 1, np.ones(2)), "^fresnel: cos, n1 and n2 must broadcast"),
    (lambda: co.optics.Coating([(1.38, -1)]), r"layers\[0\]: Layer: thickness must be > 0"),
    (lambda: co.optics.Coating([1.38]), r"layers\[0\] must be a pair"),
    (lambda: co.optics.Coating([(1.38, 99.6)]), r"layers\[0\]: Layer: thickness must be in μm.*99.6 nm are 0.0996"),
    (lambda: co.optics.Coating([(1.38, 99.6e-9)]), r"layers\[0\]: Layer: thickness must be in μm.*9.96e-08 m are 0.0996"),
    (lambda: co.optics.Coating("MgF2"), "layers must be pairs"),
    (lambda: co.optics.Coating([(0, 1)]), "refractive_index must be > 0"),
    # Wavelengths in nanometres or metres
    *((call, "Coating: wavelength must be in μm.*got 550$") for call in (
        lambda: COAT.at(550), lambda: COAT.at([0.5, 550]), lambda: co.optics.Coating.quarter_wave([1.38], 550))),
    *((lambda index=index, wave=wave: co.optics.index_at(index, wave), f"wavelength must be in μm.*got {text}$")
      for index in (1.5, co.optics.Cauchy((1.5, 0.004)), lambda w: 1.5 + 0 * w) for wave, text in (([0.5, 550], "550"), (5.5e-7, "5.5e-07"))),
    *((call, "wavelength must be in μm.*got 550$") for call in (
        lambda: LENS.thin(550), lambda: co.optics.Tabulated((550, 700), (1.5, 1.4)),
        lambda: co.optics.Tabulated((550,), (1.5,)), lambda: co.optics.Cauchy((1.5,), range=(550, 700)))),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_impossible_glasses_coats_and_wavelengths_are_refused(call, message):
    with pytest.raises((ValueError, KeyError), match=message):
        call()


# --- hits.before and hits.after: the body that holds a ray on both sides of a wall


SOLIDS = [
    co.Cone((0, 0, -1), (0, 0, 2), 1, 0.3),
    co.Cylinder((0, 0, -1), (1, 0, 1), 0.7),
    co.DoubleCone(0.8, (-1, 1)),
    co.OneSheetHyperboloid(2, 3, 1, (-1, 1)),
    co.TwoSheetHyperboloid(1, 1, 9, (-1, 1)),
    co.Ellipsoid((1, 2, 0.5)),
    co.EllipticParaboloid(1, 2, (0, 1.5)),
    co.Box() - co.Sphere(1.2),
    co.Sphere() | co.Sphere(1, (1, 0, 0)),
    co.Cylinder((0, 0, -1), (0, 0, 1), 1, 20, 300, (1, 0, 0)),
    co.HalfSpace((0, 0.1, 1), -1.5),
    ~co.Sphere(6),
]
BLOCKS = [  # with walls in common, as parts of one body and of several
    co.Box((-2, -2, -2), (0, 2, 2)), co.Box((0, -2, -2), (2, 2, 2)) - co.Box((0, -1, -1), (1, 1, 1)), co.Box((0, -1, -1), (1, 1, 1)),
    co.Box((-2, -2, 2), (2, 2, 3)) | co.Box((-2, 2, -2), (2, 3, 2)), co.Sphere(1, (0, 0, 0)), co.Box((-1, -1, -1), (1, 1, 1)) & co.Sphere(1),
]  # fmt: skip


@pytest.mark.parametrize("look", [None, co.glass(1.4)])
def test_between_two_walls_a_ray_is_in_one_body(look):
    """After each wall, and before the next one, the ray is in the body that holds the point midway."""
    rng = np.random.default_rng(7)
    strewn = [
        [shape.rotate(rng.normal(size=3), 360 * rng.random()).translate(rng.normal(0, 0.7, 3)) for shape in SOLIDS]
        for _ in range(5)
    ]
    for shapes in (*strewn, *[BLOCKS] * 5):
        scene = co.Scene([co.Body(shapes[k], look) for k in rng.permutation(len(shapes))])
        walls = scene.crossings(rng.uniform(-3, 3, (200, 3)), rng.normal(size=(200, 3)))
        ray = np.repeat(np.arange(200), np.diff(walls.offsets))
        one = np.flatnonzero((np.diff(ray) == 0) & (np.diff(walls.t) > 1e-9))
        origins, directions = walls.rays
        middle = origins[ray[one]] + ((walls.t[one] + walls.t[one + 1]) / 2)[:, None] * directions[ray[one]]
        there = scene.body_at(middle)
        assert len(one) > 100
        assert (walls.after[one] == there).all()
        assert (walls.before[one + 1] == there).all()
        hits = scene.first_hit(walls.rays)
        first = walls.offsets[:-1][hits.hit]
        assert (hits.before[hits.hit] == walls.before[first]).all()
        assert (hits.after[hits.hit] == walls.after[first]).all()


def test_a_transparent_body_counts_before_an_opaque_one():
    room, ball = co.Body(co.Box((-5, -5, -5), (5, 5, 5)), "white"), co.Body(co.Sphere(), co.glass())
    core, pane = co.Body(co.Sphere(0.5), "red"), co.Body(co.Disc((0, 0, 3), (0, 0, 1), 1), co.glass())
    scene = co.Scene([room, core, ball, pane])
    hits = scene.first_hit([(0, 0, 4), (0, 0, 2), (0, 0, 0.9), (9, 9, 9)], (0, 0, -1))
    assert hits.body.tolist() == [3, 2, 1, -1]
    assert hits.before.tolist() == [0, 0, 2, -1]
    assert hits.after.tolist() == [0, 2, 2, -1]
    assert (int(hits[1].before), int(hits[1].after)) == (0, 2)
    detached = hits.detached()
    assert detached == hits
    assert (detached[1:].after == hits.after[1:]).all()
    walls = scene.crossings([(0, 0, 4), (9, 9, 9)], (0, 0, -1))
    assert walls.before.tolist() == [0, 0, 2, 2, 2, 0]
    assert (walls.detached()[0].after == walls.after[:6]).all()
