"""What a third trial of the package from its documentation stumbled on: right answers, or words that help."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import conicoid as co

SCENE = co.Scene([
    co.Body(co.Sphere(1), "red", "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), "blue", "pillar"),
])  # fmt: skip
HITS = SCENE.first_hit([(0, 0, 9), (3, 0, 9), (9, 9, 9)], (0, 0, -1))
BK7 = co.optics.glass("N-BK7")


# --- names ---


@pytest.mark.parametrize("compare", [lambda name: HITS.name == name, lambda name: HITS.name != name])
def test_a_name_that_no_body_has_is_warned_of(compare):
    with pytest.warns(UserWarning, match=r"^no body is called 'piller', .* \(did you mean 'pillar'\?\)$"):
        compare("piller")
    compare("pillar")
    compare(None)


def test_answers_without_their_scene_know_only_their_own_names():
    assert not (HITS[:1].detached().name == "pillar").any()


@pytest.mark.parametrize(("call", "told"), [
    (lambda: SCENE.number("ball"), r"scene.bodies.index\(name\) is its place$"),
    (lambda: co.molecule([(0, 0, 0)], ["O"]).elements, "they are called symbols, and numbers the atomic numbers$"),
    (lambda: co.optics.trace_paths(SCENE, co.Rays([(0, 0, 9)], (0, 0, -1))).name, r"scene.body\(number\).name is that of one$"),
])  # fmt: skip
def test_names_that_are_elsewhere(call, told):
    with pytest.raises(AttributeError, match=told):
        call()


def test_a_list_is_not_added_to_a_scene():
    with pytest.raises(TypeError, match=r"^Scene: a scene does not change, scene.added\(items\) is one with more"):
        _ = SCENE + [co.Sphere()]


def test_the_numbers_of_bodies_in_a_picture_are_no_names():
    image = SCENE.render(16, 12, samples=1, layers=["body"])
    assert set(np.unique(image.layers["body"]).tolist()) == {-1, 0, 1}
    with pytest.raises(TypeError, match="^numbers of bodies are no names, got 'ball'"):
        _ = image.layers["body"] == "ball"


# --- light at a wavelength ---

WAVES = 0.45, 0.5875618, 0.65


def index_by_tracing(scene, wavelength):
    """The index of the first medium, by what `trace_paths` says of it."""
    paths = co.optics.trace_paths(scene, co.Rays([(1, 0, -5)], (0, 0, 1)), depth=1, wavelength=wavelength)
    return float(paths.index[(paths.level == 1) & ~paths.mirrored][0])


@pytest.mark.parametrize("wavelength", WAVES)
@pytest.mark.parametrize(("glass", "index"), [
    (co.glass(1.5, dispersion=0.01), lambda w: 1.5 + 0.01 * (1 / w**2 - 1 / 0.5875618**2)),
    (co.glass(co.optics.Cauchy([1.47, 0.01])), lambda w: 1.47 + 0.01 / w**2),
    (co.glass("N-BK7"), BK7), (co.glass(1.5 + 1e-3j), lambda w: 1.5), (co.glass(lambda w: 1.4 + 0.1 * w), lambda w: 1.4 + 0.1 * w),
])  # fmt: skip
def test_paths_and_focal_lengths_go_by_the_same_index(glass, index, wavelength):
    """A ball's focal length is n D / (4 (n - 1)). Paths took a glass's `dispersion` for none."""
    scene, n = co.Scene([co.Body(co.Sphere(10, (0, 0, 10)), glass)]), float(index(wavelength))
    assert math.isclose(index_by_tracing(scene, wavelength), n, rel_tol=1e-14)
    assert math.isclose(co.optics.focal_length(scene, wavelength), 20 * n / (4 * (n - 1)), rel_tol=1e-9)


@pytest.mark.parametrize("medium", ["N-SF11", co.glass("N-SF11"), (1.78472, 25.68), co.glass(1.7, dispersion=0.012)])
@pytest.mark.parametrize("wavelength", WAVES)
def test_the_scene_of_a_prescription_is_of_the_same_glass(medium, wavelength):
    lens = co.optics.prescription([(50, 5, medium, 20), (-50, None)], aperture=5)
    n = index_by_tracing(lens.scene, wavelength)
    if "N-SF11" in str(medium):
        assert math.isclose(n, co.optics.glass("N-SF11")(wavelength), rel_tol=1e-14)
    lensmaker = (n - 1) * (2 / 50 - (n - 1) * 5 / (n * 50**2))
    assert math.isclose(co.optics.focal_length(lens, wavelength) * lensmaker, 1, rel_tol=1e-9)
    assert math.isclose(co.optics.focal_length(lens.scene, wavelength) * lensmaker, 1, rel_tol=1e-9)


def test_a_doublet_is_made_of_glasses_by_name():
    by_name = co.Doublet((62.8, -45.7, -128.2), (4, 2.5), 25.4, ("N-BK7", co.optics.glass("SF5")))
    assert [material.refractive_index for material in by_name.materials] == ["N-BK7", co.optics.glass("SF5")]
    with pytest.raises(ValueError, match="N-BK77"):
        co.Doublet((62.8, -45.7, -128.2), (4, 2.5), 25.4, ("N-BK77", 1.7))


def test_what_rays_did_is_told_in_a_line():
    lens = co.optics.prescription([(50, 5, 1.5, 20), (-50, None)], aperture=5)
    rays = co.optics.beam(lens, pupil=[(0, 0), (0, 1)])
    assert repr(co.optics.trace(lens, rays)) == "Trace(2 of 2 rays arrived, 2 surfaces)"
    assert repr(co.optics.follow(lens.scene, rays)) == "Followed(2 of 2 rays left, 2 walls met at most)"


def test_coefficients_are_a_list():
    with pytest.raises(ValueError, match=r"^Cauchy: coefficients must be a list of one number or more, got 1.5$"):
        co.optics.Cauchy(1.5)


# --- equal things ---


@pytest.mark.parametrize("make", [
    lambda scene: scene.slice("z", pixels=8), lambda scene: scene.voxels(shape=4),
    lambda scene: scene.voxels(shape=4, fractions="material"), co.parameters,
])  # fmt: skip
def test_what_a_pickle_holds_is_equal(make):
    made = make(SCENE)
    assert made == pickle.loads(pickle.dumps(made)) == make(SCENE)
    assert made != make(SCENE.moved("ball", (0, 0, 0.5)))
    assert made != 3


# --- what moves, and how good a picture is ---

TRACK = co.scene.BodyTrack("ball", times=(0, 1), translate=((0, 0, 0), (2, 0, 0)))


def test_a_track_of_no_body_is_refused_at_once(tmp_path):
    """It was saved, too, as a file that `load` refused."""
    with pytest.raises(KeyError, match=r"Scene: animation\[0\]: no body named 'ball'"):
        co.Scene([co.Sphere()], animation=TRACK)
    moving = SCENE.replace(animation=TRACK)
    for change in (lambda: moving.without("ball"), lambda: moving.replace("ball", name="disc")):
        with pytest.raises(KeyError, match=r"Scene: animation\[0\]: no body named 'ball'"):
            change()
    assert moving.replace(animation=None).without("ball").body_count == 1
    co.save(moving, tmp_path / "moving.yaml")
    assert co.load(tmp_path / "moving.yaml") == moving


def test_a_finished_picture_knows_its_noise():
    image = SCENE.render(16, 12, noise=0.05, integrator="path", samples=64)
    assert image.noise is not None
    assert 0 < image.noise < 0.2
    error = SCENE.render(16, 12, integrator="path", samples=4, layers=["error"])
    assert math.isclose(error.noise, math.sqrt((error.layers["error"].astype(float) ** 2).mean()), rel_tol=1e-5)


# --- files of answers, and numbers of bodies ---


@pytest.mark.parametrize("chunk", [None, 7, 1])
@pytest.mark.parametrize("make", [
    lambda camera: camera.rays(8, 6), lambda camera: co.Rays.from_camera(camera, 8, 6), lambda camera: camera.rays(8, 6)[2],
])  # fmt: skip
def test_hits_of_a_picture_are_written_as_they_come(make, chunk, tmp_path):
    """The file said that its arrays were eight times as large, and nothing could read it."""
    rays = make(co.Camera((4, -9, 2), (2, 0, 0)))
    SCENE.stream(rays, out=tmp_path / "hits.npz", chunk=chunk)
    found = co.Hits.load(tmp_path / "hits.npz")
    assert found == SCENE.first_hit(rays).detached()
    assert SCENE.stream(rays, out=tmp_path / "hits.csv", chunk=chunk) == found.size
    assert np.genfromtxt(tmp_path / "hits.csv", delimiter=",", names=True)["t"].tolist() == found.t.ravel().tolist()


def test_the_place_of_a_body_of_a_lattice_by_its_name(tmp_path):
    (tmp_path / "g.xml").write_text("""<geometry>
      <surface id="1" type="z-cylinder" coeffs="0 0 0.4"/>
      <surface id="9" type="sphere" coeffs="0 0 0 9" boundary="vacuum"/>
      <cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="2" region="1"/>
      <lattice id="5" dimension="3 3" lower_left="-1.5 -1.5" pitch="1 1" universes="1 1 1 1 1 1 1 1 1"/>
      <cell id="4" fill="5" region="-9"/></geometry>""")
    scene = co.load(tmp_path / "g.xml")
    for number in range(len(scene)):
        body = scene.body(number)
        assert scene.bodies.index(body) == scene.bodies.index(body.name) == number
    with pytest.raises(KeyError, match="no body named 'cell 7'"):
        scene.bodies.index("cell 7")
    with pytest.raises(ValueError, match="is none of them"):
        scene.bodies.index(SCENE["ball"])


@pytest.mark.parametrize("function", [np.sort, np.argsort, np.max])
def test_names_of_misses_have_no_order(function):
    with pytest.raises(TypeError, match=r": a miss has no name .* and hits\[hits.hit\] no misses$"):
        function(HITS.name)
    assert np.sort(HITS[HITS.hit].name).tolist() == ["ball", "pillar"]
