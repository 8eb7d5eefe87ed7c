"""Path lengths and line integrals by body and by material, of all rays at once and of some at a time."""

import math
import pickle
from itertools import pairwise

import numpy as np
import pytest

import conicoid as co
from conicoid.io.openmc import read
from conicoid.queries import line_integrals as integrals

from ..samples import sampled


def kind(name, **properties):
    return co.matte(name=name, properties=properties)


FUEL, CLAD = kind("fuel", density=10.3, mu=[1.0, 2.0, 3.0]), kind("clad", density=6.5, mu=[0.5, 0.25, 0.125])
WATER, GAS = kind("water", density=0.75, mu=0), kind("water", density=0.0, mu=0)
"""A pencil along x through the middle: 1.5 of water, 0.25 of clad, 1 of fuel, 0.25 of clad, 1 of a gas that is also
named water.
"""
BALL, SHELL = co.Sphere(0.5, (2.25, 0, 0)), co.Sphere(0.75, (2.25, 0, 0))
PENCIL = co.Scene(
    [
        co.Body(BALL, FUEL), co.Body(SHELL - BALL, CLAD, "shell"), co.Body(co.Box((0, -1, -1), (3, 1, 1)) - SHELL, WATER),
        co.Body(co.Spheres([(4, 0, 0), (9, 0, 0)], [0.5, 1]), GAS), co.Body(co.Plane((1, 0, 0), 50), "red"), co.Disc((0, 0, 99), (0, 0, 1), 1),
    ]
)  # fmt: skip
ALONG = (-5, 0, 0), (1, 0, 0)


def test_lengths_by_material():
    assert PENCIL.materials == PENCIL.spans(*ALONG).materials == (FUEL, CLAD, WATER, GAS, co.matte("red"), None)
    twice = (-5, 0, 0), (2, 0, 0)
    for found in (
        PENCIL.spans(*ALONG).lengths("material"),
        PENCIL.spans(*twice).lengths("material"),
        PENCIL.lengths(*ALONG, by="material"),
    ):
        assert found.tolist() == [1, 0.5, 1.5, 3, 0, 0]
    assert PENCIL.lengths(*ALONG).tolist() == [1, 0.5, 1.5, 1, 2, 0, 0]
    assert PENCIL.lengths([ALONG[0]] * 2, ALONG[1], t_max=[5, 7.5], by="material")[:, 2].tolist() == [0, 1.5]
    assert co.Scene([]).lengths(np.zeros((3, 3)), (1, 0, 0), by="material").shape == (3, 0)


ARRAYS = np.stack([np.arange(7.0), np.arange(7.0) ** 2], axis=1)
DENSITY = 10.3 + 6.5 * 0.5 + 0.75 * 1.5


@pytest.mark.parametrize(("values", "otherwise", "expected"), [
    ("density", 0, DENSITY), ("density", None, DENSITY),  # only the materials of sheets are not looked up
    ("mu", None, [1 + 0.25, 2 + 0.125, 3 + 0.0625]), ({"fuel": 2, "clad": 4, "water": 8}, None, 2 + 2 + 8 * 4.5),
    ({"fuel": [2, 4], "clad": 0, "water": [0, 1]}, None, [2, 4 + 4.5]), ({"clad": 1}, 0, 0.5), ({"clad": 1}, [0, 2], [0.5, 0.5 + 2 * 5.5]),
    (ARRAYS[:, 0], None, 0.5 * 1 + 1.5 * 2 + 1 * 3 + 2 * 4), (ARRAYS, None, [0.5 + 3 + 3 + 8, 0.5 + 6 + 9 + 32]),
])  # fmt: skip
def test_integrals(values, otherwise, expected):
    assert PENCIL.spans(*ALONG).line_integral(values, otherwise=otherwise).tolist() == expected
    assert PENCIL.line_integral(values, *ALONG, otherwise=otherwise).tolist() == expected


def test_integrals_of_grids_of_rays():
    grid = co.Rays(np.broadcast_to(ALONG[0], (4, 5, 3)), ALONG[1])
    found = PENCIL.line_integral(ARRAYS, grid)
    assert found.shape == (4, 5, 2)
    assert found[3, 4, 0] == 14.5


def test_a_zero_stays_zero_on_infinite_spans():
    scene = co.Scene([co.Body(co.HalfSpace((1, 0, 0), 0), kind("void", mu=[0, 1]))])
    assert scene.line_integral("mu", (5, 0, 0), (-1, 0, 0)).tolist() == [0, math.inf]


@pytest.mark.parametrize("integral", [PENCIL.spans(*ALONG).line_integral, lambda v: PENCIL.line_integral(v, *ALONG)])
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ("densty", "no property 'densty' for material 'fuel', material 'clad', .*; otherwise=0"),
        (
            {"fuel": 1},
            "no value for material 'clad', material 'water', material 'water'; otherwise=0 .or another value. stands",
        ),
        ({"fule": 1}, "values: no material is called 'fule'; materials: 'fuel', 'clad', 'water'"),
        (
            {"fuel": [1, 2], "clad": [1], "water": 0},
            "must be as many for each material, got 2 for material 'fuel' and 1 for material 'clad'",
        ),
        (
            {"fuel": [[1]], "clad": 1, "water": 1},
            r"values\['fuel'\] must be a number or an array \(energies,\), got shape \(1, 1\)",
        ),
        ({"fuel": "a", "clad": 1, "water": 1}, r"values\['fuel'\] must be a number or an array \(energies,\), got 'a'"),
        (np.zeros((7, 2, 2)), r"values must have shape \(7,\) or \(7, energies\), got \(7, 2, 2\)"),
        (np.zeros((6, 2)), r"values must have shape \(7,\) or \(7, energies\), got \(6, 2\)"),
    ],
)
def test_missing_values_are_named(values, message, integral):
    with pytest.raises(ValueError, match="line_integral: .*" + message):
        integral(values)


TEXTS = co.Scene(co.Body(co.Sphere(), kind("x", mu="much", table=[[1, 2]])))


@pytest.mark.parametrize(("call", "message"), [
    (lambda: PENCIL.lengths(*ALONG, by="name"), "lengths: by must be one of body, material, got 'name'"),
    (lambda: PENCIL.line_integral(np.zeros(7), *ALONG, otherwise=0), "line_integral: otherwise goes with values by name"),
    (lambda: TEXTS.line_integral("mu", *ALONG), "property 'mu' of material 'x' must be a number or an array"),
    (lambda: TEXTS.line_integral("table", *ALONG), "property 'table' of material 'x' must be a number or an array"),
    (lambda: co.Scene([co.Sphere()]).line_integral("mu", *ALONG), "no property 'mu' for bodies without a material"),
    (lambda: co.Scene([co.Spheres(np.arange(3000.0).reshape(-1, 3), 1)]).lengths(np.broadcast_to(np.zeros(3), (2**20, 3)), (1, 0, 0)),
     "lengths: an array of 1048576 rays x 1000 bodies would take 8 GiB"),
])  # fmt: skip
def test_other_refusals(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def crowd():
    """Return balls and shells of four materials, and many random rays."""
    random = np.random.default_rng(1)
    kinds = [FUEL, CLAD, WATER, GAS]
    bodies = [
        co.Body(co.Sphere(r, tuple(c)), kinds[k % 4])
        for k, (r, c) in enumerate(zip(random.uniform(0.2, 2, 60), random.normal(size=(60, 3)), strict=True))
    ]
    return co.Scene(bodies), random.normal(0, 3, (3000, 3)), random.normal(size=(3000, 3))


ROUTES = {
    "flat": lambda o, d: co.Rays(o, d),
    "picture": lambda o, d: co.Rays(o.reshape(50, 60, 3), d[0]),
    "long rows": lambda o, d: co.Rays(o.reshape(2, 1500, 3), d.reshape(2, 1500, 3)),
    "three axes": lambda o, d: co.Rays(o.reshape(10, 10, 30, 3), d.reshape(10, 10, 30, 3)),
    "one": lambda o, d: co.Rays(o[0], d[0]),
    "none": lambda o, d: co.Rays(o[:0], d[:0]),
}


@pytest.mark.parametrize(("route", "most"), sampled([(route, most) for route in ROUTES for most in (1, 5, 64)], 4))
def test_some_at_a_time_gives_the_same_bits(route, most, monkeypatch):
    monkeypatch.setattr(integrals, "_PACKETS", most)
    scene, origins, directions = crowd()
    rays = ROUTES[route](origins, directions)
    ends = np.random.default_rng(2).uniform(0, 9, rays.shape)
    weights = np.random.default_rng(3).normal(size=(60, 2))
    for limits in ({}, {"t_max": ends}, {"t_min": -ends, "t_max": 5}):
        whole = scene.spans(rays, **limits)
        for by in ("body", "material"):
            assert np.array_equal(scene.lengths(rays, **limits, by=by), whole.lengths(by))
        for values in (weights, weights[:, 0], "mu", "density"):
            again = scene.line_integral(values, rays, **limits)
            assert np.array_equal(again, whole.line_integral(values))
            assert type(again) is type(whole.line_integral(values))


def test_pictures_in_flat_lists_and_spawned_rays():
    scene, _, _ = crowd()
    camera = co.Camera((9, 8, 7), (0, 0, 0))
    flat = co.Rays(*(lines.reshape(-1, 3) for lines in camera.rays(160, 120)))
    hits = scene.first_hit(camera.rays(40, 32))
    for rays in (flat, hits.spawn((0, 0, 1)), hits.spawn(-hits.rays.directions)):
        assert np.array_equal(scene.line_integral("mu", rays), scene.spans(rays).line_integral("mu"))


def test_doubtful_rays_have_the_sums_of_their_spans():
    """Some rays touch two balls of one kind where these cross. Exact methods find their spans."""
    scene = co.Scene([co.Body(co.Sphere(1.0), FUEL), co.Body(co.Sphere(1.0, (1, 0, 0)), CLAD)])
    origins = np.random.default_rng(5).uniform(-2, 2, (300, 3)) + (0, 0, 9)
    origins[::7, :2], origins[::11, :2] = (0.5, 0.0), (1.0, 0.0)
    whole = scene.spans(origins, (0, 0, -1))
    assert np.array_equal(scene.lengths(origins, (0, 0, -1)), whole.lengths())
    assert np.array_equal(scene.line_integral("mu", origins, (0, 0, -1)), whole.line_integral("mu"))


def test_spans_are_not_kept(monkeypatch):
    """However many rays there are, spans are made only for doubtful rays and for reports of overlaps."""
    monkeypatch.setattr(integrals, "Spans", None)
    scene, origins, _ = crowd()
    calls = []
    scene.lengths(
        np.resize(origins, (20_000, 3)), -origins[0], progress=lambda done, count: calls.append((done, count))
    )
    assert calls[-1] == (20_000, 20_000)
    assert all(a <= b for (a, _), (b, _) in pairwise(calls))


def test_overlaps_are_looked_for_in_some_rays_until_one_is_reported(monkeypatch, caplog):
    monkeypatch.setattr(integrals, "_SOME", 10)
    calls, real = [], integrals.Spans

    def counted(*arguments):
        calls.append(real(*arguments))
        return calls[-1]

    monkeypatch.setattr(integrals, "Spans", counted)
    scene, origins, directions = crowd()
    scene.lengths(origins, directions, by="material")
    assert [len(each) for each in calls] == [10]
    assert "rays go through two bodies at once" in caplog.text
    with pytest.raises(ValueError, match="line_integral: .* rays go through two bodies at once"):
        scene.line_integral("mu", origins, directions, overlaps="error")
    assert len(calls) == 2


def test_pickled_spans_know_materials_without_a_ray():
    spans = PENCIL.spans([ALONG[0], (-5, 0, 0.6)], ALONG[1])
    for again in (
        pickle.loads(pickle.dumps(spans)),
        spans.detached(),
        pickle.loads(pickle.dumps(spans[1]))[...],
        spans[1:],
    ):
        assert again.materials == PENCIL.materials
        assert np.array_equal(
            again.lengths("material"), spans.lengths("material")[-len(again) :].reshape(again.lengths("material").shape)
        )
        assert np.array_equal(
            again.line_integral("mu")[..., 0],
            np.reshape(spans.line_integral("mu")[-len(again) :, 0], again.line_integral("mu").shape[:-1]),
        )


def test_void_of_a_model_is_a_material(tmp_path):
    path = tmp_path / "model.xml"
    path.write_text("""<model><materials><material id="4" name="iron"><density units="g/cm3" value="8"/></material></materials><geometry>
        <surface id="1" type="sphere" coeffs="0 0 0 1"/><surface id="2" type="sphere" coeffs="0 0 0 3" boundary="vacuum"/>
        <cell id="1" material="4" region="-1"/><cell id="2" material="void" region="1 -2"/></geometry></model>""")
    scene = co.load_openmc(path)
    assert [material.name for material in scene.materials] == ["iron", "void"]
    assert scene.lengths((-9, 0, 0), (1, 0, 0), by="material").tolist() == [2, 4]
    assert scene.line_integral("density", (-9, 0, 0), (1, 0, 0)) == 16
    assert scene.line_integral({"void": 1, "iron": 0}, (-9, 0, 0), (1, 0, 0)) == 4
    assert co.Scene(read(path, void=False).bodies).line_integral("density", (-9, 0, 0), (1, 0, 0)) == 16
