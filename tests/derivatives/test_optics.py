"""The derivatives of reflection and refraction, and the parameters of scenes."""

import mpmath
import numpy as np
import pytest

import conicoid as co

from ..contract.examples import MOTIONS, every_example
from ..samples import in_turn

# --- The derivatives of reflection and refraction, against differences in 40 digits of Snell's law in the plane


mp = mpmath.MPContext()
mp.dps = 40
STEP = mp.mpf(10) ** -15


def mirrored(d, n):
    n = n / mp.norm(n)
    return d - 2 * (d.T * n)[0] * n


def refracted_direction(d, n, eta):
    """Apply Snell's law by angles: sin θ₂ = eta sin θ₁, in the plane of d and n."""
    size, n = mp.norm(d), n / mp.norm(n)
    u = d / size
    n = n if (u.T * n)[0] > 0 else -n
    angle = mp.acos((u.T * n)[0])
    sine = eta * mp.sin(angle)
    if sine > 1:
        return mirrored(d, n)
    aside = u - (u.T * n)[0] * n
    aside = aside / mp.norm(aside)
    beyond = mp.asin(sine)
    return size * (mp.cos(beyond) * n + mp.sin(beyond) * aside)


def column(values):
    return mp.matrix([mp.mpf(float(value)) for value in values])


@pytest.fixture(scope="module")
def vectors():
    random = np.random.default_rng(0)
    vectors = random.normal(size=(5, 60, 3))
    return *vectors, random.uniform(0.5, 1.9, 60), random.normal(size=60)


def check_differences(found, moved, rel):
    """Compare derivatives with central differences of `moved(i, step)`, vector i with all inputs changed by a step."""
    for i, own in enumerate(found):
        difference = (moved(i, STEP) - moved(i, -STEP)) / (2 * STEP)
        assert own == pytest.approx([float(x) for x in difference], rel=rel, abs=rel)


def test_reflection(vectors):
    d, n, dd, dn, w, _, _ = vectors
    found = co.derivatives.reflect_jvp(d, n, dd, dn)

    def moved(i, s):
        return mirrored(column(d[i]) + s * column(dd[i]), column(n[i]) + s * column(dn[i]))

    check_differences(found, moved, 1e-12)
    of_d, of_n = co.derivatives.reflect_vjp(d, n, w)
    assert (of_d * dd + of_n * dn).sum() == pytest.approx((w * found).sum(), rel=1e-12)


def test_refraction(vectors):
    d, n, dd, dn, w, eta, de = vectors
    found = co.derivatives.refract_jvp(d, n, eta, dd, dn, de)
    _, total = co.refract(d, n, eta)
    assert 5 < total.sum() < 50

    def moved(i, s):
        direction, normal = column(d[i]) + s * column(dd[i]), column(n[i]) + s * column(dn[i])
        return refracted_direction(direction, normal, mp.mpf(eta[i]) + s * mp.mpf(de[i]))

    check_differences(found, moved, 1e-10)
    of_d, of_n, of_eta = co.derivatives.refract_vjp(d, n, eta, w)
    assert (of_d * dd + of_n * dn).sum() + of_eta @ de == pytest.approx((w * found).sum(), rel=1e-12)


def test_arguments_broadcast():
    assert co.derivatives.refract_jvp((0, 0, -1), np.ones((4, 3)), 1.5, d_eta=1.0).shape == (4, 3)
    assert co.derivatives.refract_vjp((0, 0, -1), np.ones((4, 3)), 1.5, (1, 0, 0))[2].shape == (4,)


def test_the_critical_angle_has_no_derivative():
    # sin θ = 0.6, eta = 5 / 3 in floats that make s exactly 0
    directions, eta = np.array([0.0, 0.0, -1.0]), 1.0
    found = co.derivatives.refract_jvp(directions, (1, 0, 0), eta, d_eta=1.0)
    assert np.isnan(found).any()


BOTH = co.parameters(co.Scene([co.Sphere(), co.Box()]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: co.derivatives.reflect_jvp((0, 0, 1), (0, 0, 1), d_normals=np.zeros((2, 3))),
            r"reflect_jvp: d_normals must broadcast to \(3,\), got \(2, 3\)",
        ),
        (
            lambda: co.derivatives.refract_vjp((0, 0, 1), (0, 0, 1), 1.5, "x"),
            r"refract_vjp: cotangents must be an array of numbers",
        ),
        (lambda: co.derivatives.reflect_vjp((0, 0, 0), (0, 0, 1), (1, 0, 0)), "finite and not zero"),
        (lambda: BOTH.scene(BOTH.vector({"bodies[0].radius": -1.0})), "Sphere: radius must be > 0"),
        (lambda: BOTH.scene([1, 2]), r"vector must have shape \(10,\), got \(2,\)"),
        (lambda: co.parameters(co.Sphere()), "must be a Scene, got Sphere"),
    ],
)
def test_invalid_calls_are_refused(call, message):
    with pytest.raises((ValueError, TypeError), match=message):
        call()


# --- `co.parameters`: names, values, scenes with other numbers


EXAMPLES = dict(every_example())


def test_names_of_parameters_give_their_places():
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
