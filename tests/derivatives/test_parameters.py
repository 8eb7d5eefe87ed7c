"""`co.parameters`: names, values, scenes with other numbers."""

import numpy as np
import pytest

import conicoid as co

from ..contract.examples import MOTIONS, every_example
from ..samples import in_turn

EXAMPLES = dict(every_example())


def test_names_say_where_a_number_stands():
    scene = co.Scene([co.Body(co.Sphere(2, (1, 2, 3)).rotate("z", 30), name="ball"), co.Box() - co.Sphere()])
    found = co.parameters(scene)
    assert found.names[:5] == ("ball.radius", "ball.center[0]", "ball.center[1]", "ball.center[2]",
                               "ball.motion[0].axis[0]")  # fmt: skip
    assert found["ball.center[2]"] == 3
    assert found["ball.motion[0].degrees"] == 30
    assert found["bodies[1].operands[0].low[1]"] == -1
    assert found.values[found.index("bodies[1].operands[1].radius")] == 1


@pytest.mark.parametrize(("name", "motion"), in_turn(EXAMPLES, MOTIONS))
def test_a_scene_of_the_same_numbers_is_that_scene(name, motion):
    scene = co.Scene([MOTIONS[motion](EXAMPLES[name])])
    found = co.parameters(scene)
    assert len(found) == len(found.names) == len(set(found.names))
    assert found.scene(found.values) is scene
    assert np.isfinite(found.values).all()


def test_a_scene_of_other_numbers():
    scene = co.Scene([
        co.Body(co.Sphere(2).translate((1, 0, 0)), "red", "ball"),
        co.Ellipsoid.from_coefficients(1, 2, 3),
        co.Quadric(coefficients=dict(xx=1, yy=1, constant=-1)),
        co.HyperbolicParaboloid(1, 2, co.Box().rotate("z", 10)),
        co.Spheres([(0, 0, 0), (5, 0, 0)], [1, 2]),
    ])  # fmt: skip
    found = co.parameters(scene)
    changes = {
        "ball.radius": 3.0, "ball.motion[0].offset[0]": 4.0, "bodies[1].coefficients[2]": 4.0,
        "bodies[2].coefficients.constant": -2.0, "bodies[3].within.motion[0].degrees": 20.0,
        "bodies[4].radii[1]": 2.5, "bodies[4].centers[0][1]": 0.5,
    }  # fmt: skip
    other = found.scene(found.vector(changes))
    assert other == co.Scene([
        co.Body(co.Sphere(3).translate((4, 0, 0)), "red", "ball"),
        co.Ellipsoid.from_coefficients(1, 2, 4),
        co.Quadric(coefficients=dict(xx=1, yy=1, constant=-2)),
        co.HyperbolicParaboloid(1, 2, co.Box().rotate("z", 20)),
        co.Spheres([(0, 0.5, 0), (5, 0, 0)], [1, 2.5]),
    ])  # fmt: skip
    assert co.parameters(other)["ball.radius"] == 3


def test_shapes_that_stay_are_the_same_objects():
    scene = co.Scene([co.Sphere(), co.Box(), co.Box((5, 5, 5), (6, 6, 6)) - co.Sphere(2)])
    found = co.parameters(scene)
    other = found.scene(found.vector({"bodies[2].operands[1].radius": 1.5}))
    assert [a.shape is b.shape for a, b in zip(scene.bodies, other.bodies, strict=True)] == [True, True, False]
    assert other.bodies[2].shape.operands[0] is scene.bodies[2].shape.operands[0]


def test_some_of_them():
    scene = co.Scene([co.Body(co.Sphere(), name="a"), co.Body(co.Sphere(2), name="b")])
    found = co.parameters(scene, ["b.*", "a.radius"])
    assert found.names == ("a.radius", "b.radius", "b.center[0]", "b.center[1]", "b.center[2]")
    assert found.select("*.center[1]").names == ("b.center[1]",)
    assert found.scene([1, 3, 0, 0, 0]) == scene.replace("b", co.Sphere(3))
    hit = scene.first_hit((0, 0, 9), (0, 0, -1))
    assert hit.vjp(found, t=1).parameters.tolist() == [0, -1, 0, 0, -1]
    with pytest.raises(ValueError, match="nothing is called 'c"):
        co.parameters(scene, "c.radius")
    with pytest.raises(KeyError, match=r"there is no 'a\.radios'.*did you mean 'a\.radius'"):
        found.index("a.radios")


def test_what_a_shape_cannot_be_is_refused():
    found = co.parameters(co.Scene([co.Sphere(), co.Box()]))
    with pytest.raises(ValueError, match="Sphere: radius must be > 0"):
        found.scene(found.vector({"bodies[0].radius": -1.0}))
    with pytest.raises(ValueError, match=r"vector must have shape \(10,\), got \(2,\)"):
        found.scene([1, 2])
    with pytest.raises(TypeError, match="must be a Scene, got Sphere"):
        co.parameters(co.Sphere())


def test_an_infinite_end_and_the_angles_of_a_whole_turn_are_none():
    shapes = [co.Ellipsoid((1, 1, 1), z_range=(0, np.inf)), co.Cylinder((0, 0, 0), (0, 0, 1), 1)]
    names = co.parameters(co.Scene(shapes)).names
    assert [name for name in names if "z_range" in name or "angle" in name] == ["bodies[0].z_range[0]"]


def test_a_boolean_of_thousands_of_levels():
    # A chain of 1200 differences: a ball of radius 1 with 1200 others taken out of it, each by a step of its own.
    shape = co.Sphere(1)
    for k in range(1200):
        shape = co.Difference((shape, co.Sphere(0.001, (0, 5 + k, 0))))
    scene = co.Scene([co.Body(shape, name="it")])
    found = co.parameters(scene)
    assert len(found) == 4 * 1201
    assert found.scene(found.values) is scene
    values = found.values.copy()
    values[0] = 2
    other = found.scene(values)
    assert other.first_hit((0, 0, 5), (0, 0, -1)).t == 3
    gradient = scene.first_hit((0, 0, 5), (0, 0, -1)).vjp(found, t=1).parameters
    assert np.flatnonzero(gradient).tolist() == [0, 3]  # the radius, and z of the center
    assert gradient[[0, 3]].tolist() == [-1, -1]
