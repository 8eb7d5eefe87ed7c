"""The registry through which lower layers call higher ones, and the check for a scene."""

import pytest

import conicoid as co
from conicoid.queries.result import EXTENSIONS, extension
from conicoid.queries.scene_protocol import is_scene


@pytest.mark.parametrize("name", sorted(EXTENSIONS))
def test_every_entry_is_callable(name):
    found = extension(name)
    assert callable(found)
    assert f"{found.__module__}:{found.__name__}" == EXTENSIONS[name]


def test_an_unknown_entry():
    with pytest.raises(KeyError, match="nothing"):
        extension("nothing")


class Titled(co.Scene):
    pass


@pytest.mark.parametrize("scene", [co.Scene([co.Sphere()]), Titled()])
def test_scenes(scene):
    assert is_scene(scene)
    assert scene._cached_prepared is None


SCENE = co.Scene([co.Sphere()])


@pytest.mark.parametrize(
    "value",
    [co.Sphere(), co.Body(co.Sphere()), SCENE.bodies, SCENE._prepared, SCENE.first_hit((0, 0, -3), (0, 0, 1)), co.Scene, None, [], "scene"],
)  # fmt: skip
def test_other_things(value):
    assert not is_scene(value)
