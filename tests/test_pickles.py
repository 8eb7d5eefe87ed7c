"""Everything public survives pickle, copy and deepcopy with all its contents."""

import copy
import pickle
import pickletools
import re
from functools import cached_property

import numpy as np
import pytest

import conicoid as co

from .contract.examples import MOTIONS, every_example
from .public_names import PUBLIC
from .samples import in_turn

ANSWERS = (co.Hits, co.Spans, co.Crossings)
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
WAYS = {f"protocol {n}": (lambda x, n=n: pickle.loads(pickle.dumps(x, n))) for n in PROTOCOLS}
WAYS |= {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "detached": lambda x: x.detached() if isinstance(x, ANSWERS) else x,
}
RED = co.matte("red")
SCENE = co.Scene(
    [
        co.Body(co.Spheres([(0, 0, 0), (3, 0, 0)], [1, 0.5]), RED, "balls"),
        co.Body(co.Box((-1, -1, -5), (4, 1, -4)) - co.Cylinder((0, 0, -9), (0, 0, 9), 0.5), name="plate"),
        co.Plane((0, 0, 1), -7),
    ],
    lights=[co.PointLight((0, 0, 9))],
    camera=co.Camera((1, 2, 9), (0, 0, 0)),
    background="navy",
)
DOWN = (0.0, 0.0, -1.0)
ORIGINS = np.array([[(0, 0, 5), (0.25, 0.3, 5)], [(3, 0.2, 5), (2, 0, 5)], [(40, 0, 5), (0, 0, -8)]], float)


def fields(answer):
    kind = type(answer)
    named = {f for f in dir(kind) if isinstance(getattr(kind, f), (property, cached_property))} | set(vars(answer))
    return sorted(f for f in named if not f.startswith("_") and f != "rays")


def assert_same(answer, again):
    """Assert that every field of an answer agrees in type, shape and all bits, and is as read-only as before."""
    assert type(again) is type(answer)
    assert fields(again) == fields(answer)
    for field in fields(answer):
        a, b = getattr(answer, field), getattr(again, field)
        assert type(a) is type(b), field
        if isinstance(a, np.ndarray):
            assert (a.dtype, a.shape) == (b.dtype, b.shape), field
            assert not b.flags.writeable, field
            assert np.array_equal(a, b, equal_nan=a.dtype != object), field
        else:
            assert a == b or a != a, field


def answers(scene, origins, directions):
    yield scene.first_hit(origins, directions)
    yield scene.crossings(origins, directions)
    yield scene.spans(origins, directions)


@pytest.fixture(params=WAYS)
def way(request):
    return WAYS[request.param]


def test_hits_spans_and_crossings(way):
    for answer in answers(SCENE, ORIGINS, DOWN):
        assert_same(answer, way(answer))
        assert_same(answer, way(way(answer)))
    for answer in answers(SCENE, ORIGINS[0, 0], DOWN):
        assert_same(answer, way(answer))
    for answer in answers(co.Scene([]), np.zeros((0, 3)), DOWN):
        assert_same(answer, way(answer))


@pytest.mark.parametrize("index", [0, (1, 0), (slice(None), 1), [0, 2], np.array([True, False, True]), ..., ()])
def test_hits_without_their_scene_can_be_chosen_from(way, index):
    hits = SCENE.first_hit(ORIGINS, DOWN)
    assert_same(hits[index], way(hits)[index])
    assert np.array_equal(hits[index].rays.origins, way(hits)[index].rays.origins)


@pytest.mark.parametrize("answer", [SCENE.crossings(ORIGINS, DOWN), SCENE.spans(ORIGINS, DOWN)])
@pytest.mark.parametrize("index", [0, 3, slice(1, 4), [2, 0], np.array([[True, False], [True, True], [False, False]])])
def test_rows_of_chosen_rays(way, index, answer):
    """They are as read-only as the whole, so that copies may share them."""
    for field in fields(answer):  # cached fields are selected, too
        found = getattr(answer[index], field)
        assert not isinstance(found, np.ndarray) or not found.flags.writeable, field
        getattr(answer, field)
    assert_same(answer[index], way(answer[index]))
    assert_same(answer[index], way(answer)[index])


def test_hits_spawn_rays_that_know_their_surface(way):
    hits = SCENE.first_hit(ORIGINS, DOWN)
    expected = SCENE.first_hit(hits.spawn(DOWN)).t
    assert (expected[:2] > 0.1).all()
    for scene in (SCENE, way(SCENE)):
        for rays in (way(hits).spawn(DOWN), way(hits.spawn(DOWN)), way(way(hits).spawn(DOWN))):
            assert np.array_equal(scene.first_hit(rays).t, expected)
            assert not rays.origins.flags.writeable
    other = co.Scene([co.Plane((0, 0, 1), -50), co.Plane((0, 0, 1), -60)])
    assert np.array_equal(
        other.first_hit(way(hits).spawn(DOWN)).t, np.where(hits.t < np.inf, hits.point[..., 2] + 50, np.inf)
    )


def test_scenes(way):
    SCENE.first_hit(ORIGINS, DOWN)
    again = way(SCENE)
    assert again == SCENE
    assert repr(again.bodies) == repr(SCENE.bodies)
    assert not again.bodies[0].shape.centers.flags.writeable
    for answer, same in zip(answers(SCENE, ORIGINS, DOWN), answers(again, ORIGINS, DOWN), strict=True):
        assert_same(answer, same)


def test_a_pickled_scene_holds_the_arguments_of_the_user_alone():
    def scene():
        turned = co.Cylinder((0, 0, 0), (1, 2, 3), 1).rotate((1, 2, 3), 33)
        return co.Scene(
            [
                co.Spheres(np.arange(300.0).reshape(100, 3), 1),
                turned,
                turned - co.Quadric(coefficients={"xx": 1, "yy": 2, "z": 1}),
            ]
        )

    for protocol in PROTOCOLS:
        used = scene()
        fresh = pickle.dumps(used, protocol)
        assert used.bounds
        used.first_hit(ORIGINS, DOWN)
        used.spans(ORIGINS, DOWN)
        assert len(pickle.dumps(used, protocol)) == len(fresh)
    assert len(fresh) < 100 * 4 * 8 + 2000
    assert all(word not in fresh for word in (b"Prepared", b"lock", b"Lowered"))


def test_a_copied_scene_is_prepared_once():
    scene = co.Scene([co.Sphere()])
    assert scene._prepared is scene._prepared
    assert copy.copy(scene)._prepared is scene._prepared


@pytest.mark.parametrize("array", [np.linspace(0, 1, 24).reshape(2, 4, 3), np.arange(6).reshape(2, 3)])
def test_images(way, array):
    image = co.Image(array)
    again = way(image)
    assert_same(image, again)
    assert again._repr_png_() == image._repr_png_()


def test_all_other_public_classes(way):
    things = [
        *PUBLIC.values(),
        co.Sky("red", "blue"),
        co.AmbientLight(),
        co.DirectionalLight((0, 0, 1)),
        co.PointLight((0, 0, 1)),
        co.SpotLight((0, 0, 1), (0, 0, -1)),
        co.OrthographicCamera((1, 0, 5), (0, 0, 0)),
        co.glass(),
        co.Body(co.Sphere(), RED),
        co.matte(co.Checker("red", "blue")),
    ]
    for value in things:
        assert repr(way(value)) == repr(value)
    for finding in co.check(co.Scene([co.Sphere(), co.Sphere(1.5)]), rays=500):
        assert str(way(finding)) == str(finding)


def test_a_mistake_in_a_file_comes_back_from_another_process(way, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("bodies:\n- Spher: {}\n- Sphere: {radius: -1}\n")
    with pytest.raises(co.SceneFileError) as caught:
        co.load(path)
    again = way(caught.value)
    assert str(again) == str(caught.value)
    assert again.problems == caught.value.problems


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_shape(motion):
    for k, (name, shape) in enumerate(every_example()):
        moved = MOTIONS[motion](shape)
        assert len(moved.bounds) == 2  # it caches its result
        for way in list(WAYS.values())[k % len(WAYS) :: len(WAYS)]:
            again = way(moved)
            assert again == moved, name
            assert repr(again.motion) == repr(moved.motion)
            assert np.array_equal(again.bounds, moved.bounds)


FORMS = {
    "differences": lambda a, b: (a | b) - b,
    "complements": lambda a, b: ~(a & b),
    "painted": lambda a, b: ((a - b) | b).painted(RED),
}


@pytest.mark.parametrize(("through", "form"), in_turn(WAYS, FORMS, {"protocol 2", "protocol 5", "deepcopy"}))
def test_trees_as_deep_as_they_may_be(through, form):
    shape = co.Sphere()
    for level in range(1100):
        shape = FORMS[form](shape, co.Sphere(center=(level, 0, 0)))
    assert WAYS[through](shape) == shape


def test_many_hits_are_pickled_as_arrays_and_not_one_by_one():
    def pickled(count):
        return pickle.dumps(SCENE.first_hit(np.resize(ORIGINS, (count, 3)), DOWN))

    few, many = (sum(1 for _ in pickletools.genops(pickled(count))) for count in (12, 12_000))
    assert many < few + 50
    # A hit takes 189 bytes: 17 numbers of 8, with origin and direction 6 more, 7 of 4 and 3 of one
    assert len(pickled(12_000)) - len(pickled(12)) < 230 * 12_000


def test_detached_results_name_their_missing_scene():
    hits = SCENE.first_hit(ORIGINS, DOWN).detached()
    with pytest.raises(ValueError, match="detached from its scene, or pickled"):
        hits._scene.geometry  # noqa: B018


def test_pickles_of_development_versions_are_refused_with_the_version():
    """They name modules of old paths: `c` is pickle's instruction for the attribute of a module."""
    with pytest.raises(
        ModuleNotFoundError, match=rf"'conicoid.shapes'.* Conicoid {re.escape(co.__version__)} has none"
    ):
        pickle.loads(b"cconicoid.shapes.sphere\nSphere\n.")
