"""The derivatives of spans, lengths, line integrals and volumes: by closed forms, and as transposes of one another."""

import math

import numpy as np
import pytest

import conicoid as co


def test_chords_of_a_ball():
    # The chord at distance h is 2 sqrt(r² - h²): by r it changes by 2 r / sqrt(r² - h²).
    scene = co.Scene([co.Sphere(5)])
    found = scene.spans((3, 0, -9), (0, 0, 2)).jvp(co.parameters(scene), [1, 0, 0, 0])
    assert found.lengths() == pytest.approx([2 * 5 / 4], rel=1e-14)
    assert found.line_integral([3.0]) == pytest.approx(3 * 2 * 5 / 4, rel=1e-14)
    assert (found.t_enter, found.t_exit) == (pytest.approx([-5 / 8]), pytest.approx([5 / 8]))


def test_clipped_ends_stay():
    scene = co.Scene([co.Sphere(5)])
    found = scene.spans((0, 0, 0), (0, 0, 1), t_max=2).jvp(co.parameters(scene), [1, 0, 0, 0], d_origins=(0, 0, 1))
    assert (found.t_enter.tolist(), found.t_exit.tolist()) == ([0], [0])


def test_abutting_bodies_have_derivatives_of_their_own():
    scene = co.Scene([co.Body(co.Box((0, 0, 0), (1, 1, 1)), name="a"), co.Body(co.Box((1, 0, 0), (2, 1, 1)), name="b")])
    parameters = co.parameters(scene)
    tangent = parameters.vector({}) * 0
    tangent[parameters.index("a.high[0]")] = 1
    found = scene.spans((-1, 0.5, 0.5), (1, 0, 0)).jvp(parameters, tangent)
    assert found.lengths().tolist() == [1, 0]


@pytest.fixture(scope="module")
def setting():
    both = co.Box((0, 0, 0), (1, 1, 1)) | co.Box((1.5, 0, 0), (2.5, 1, 1)) | co.Sphere(0.5, (1.2, 0.5, 0.5))
    scene = co.Scene([
        co.Body(co.Ellipsoid((1, 2, 1.5)).rotate((1, 2, 3), 20), name="ball"), both.translate((0.3, 0.1, 0)),
        co.Cylinder((0, 0, -3), (0, 1, 3), 0.4),
    ])  # fmt: skip
    random = np.random.default_rng(0)
    origins = random.normal(size=(2000, 3)) * 8
    return scene, origins, random.normal(size=(2000, 3)) - origins


def test_line_integrals_by_differences(setting):
    scene, origins, directions = setting
    random = np.random.default_rng(1)
    parameters, values, step = co.parameters(scene), np.array([1.0, 2.0, -3.0]), 1e-7
    tangent, do, dd = random.normal(size=len(parameters)), *random.normal(size=(2, 2000, 3))
    found = scene.spans(origins, directions).jvp(parameters, tangent, d_origins=do, d_directions=dd)

    def spans(s):
        other = parameters.scene(parameters.values + s * step * tangent)
        return other.spans(origins + s * step * do, directions + s * step * dd)

    near, here, far = spans(-1), spans(0), spans(1)
    for name in ("lengths", "line_integral"):
        arguments = () if name == "lengths" else (values,)
        a, b, c = (getattr(each, name)(*arguments) for each in (near, here, far))
        # At edges the changes to both sides differ; at outlines chords change ever faster
        smooth = np.abs((c - b) - (b - a)) < 1e-5 * step
        assert smooth.mean() > 0.75
        change = (c - a) / (2 * step)
        assert getattr(found, name)(*arguments)[smooth] == pytest.approx(change[smooth], rel=1e-5, abs=1e-5)


def test_vjp_is_the_transpose_of_jvp(setting):
    scene, origins, directions = setting
    random = np.random.default_rng(2)
    parameters, values = co.parameters(scene), random.normal(size=(3, 2))
    tangent, do, dd = random.normal(size=len(parameters)), *random.normal(size=(2, 2000, 3))
    spans = scene.spans(origins, directions)
    found = spans.jvp(parameters, tangent, d_origins=do, d_directions=dd)
    cotangents, of_t = random.normal(size=(2000, 2)), random.normal(size=len(spans.body))
    forth = (cotangents * found.line_integral(values)).sum() + of_t @ found.t_exit
    back = spans.vjp(parameters, t_exit=of_t, line_integral=cotangents, values=values)
    total = math.fsum((back.parameters @ tangent, (back.origins * do).sum(), (back.directions * dd).sum()))
    assert total == pytest.approx(forth, rel=1e-11)
    with pytest.raises(ValueError, match="line_integral needs values"):
        spans.vjp(parameters, line_integral=cotangents)


def test_sums_over_a_detector_lose_nothing_at_outlines():
    # Σ chord · pixel is the volume, 4/3 π r³, and changes by 4 π r², though chords change without bound at the outline.
    scene = co.Scene([co.Sphere(2)])
    pixel = 5 / 600
    places = (np.arange(600) + 0.5) * pixel - 2.5
    origins = np.stack(np.broadcast_arrays(places[:, None], places, -9.0), axis=-1)
    parameters = co.parameters(scene, "*.radius")
    spans = scene.spans(origins, (0, 0, 1))
    cotangents = np.full((600, 600), pixel**2)
    found = spans.vjp(parameters, line_integral=cotangents, values=[1.0]).parameters[0]
    assert found == pytest.approx(16 * math.pi, rel=1e-2)
    assert found == pytest.approx((spans.jvp(parameters, [1.0]).line_integral([1.0]) * cotangents).sum(), rel=1e-12)


def within_errors(found, expected, names):
    for name, value in expected.items():
        place = names.index(name)
        assert abs(found.gradient[place] - value) <= 5 * found.error[place] + 1e-9 * abs(value), name


def test_volumes_of_closed_forms():
    block = co.Box((0, 0, 0), (2, 3, 4)) - co.Cylinder((1, 1, -1), (1, 1, 5), 0.5)
    scene = co.Scene([
        co.Body(co.Ellipsoid((1, 2, 3)).scale((2, 1, 1)), name="egg"), co.Body(block, name="block"),
        co.Spheres([(0, 0, 0), (1, 0, 0)], [1, 2]),
    ])  # fmt: skip
    parameters = co.parameters(scene)
    names = list(parameters.names)
    # V = 4/3 π a b c k
    egg = co.derivatives.volume_gradient(parameters, "egg", rays=30_000)
    third = 4 / 3 * math.pi
    expected = {"egg.radii[0]": 12 * third, "egg.radii[1]": 6 * third, "egg.radii[2]": 4 * third,
                "egg.center[0]": 0, "egg.motion[0].factors[0]": 6 * third}  # fmt: skip
    within_errors(egg, expected, names)
    assert egg.error[names.index("egg.radii[2]")] < 0.05
    # V = (2 · 3 - π r²) · 4; moving the bore changes nothing, nor do its ends, which are outside
    bored = co.derivatives.volume_gradient(parameters, "block", rays=30_000)
    hole = math.pi / 4
    expected = {"block.operands[0].high[2]": 6 - hole, "block.operands[0].high[0]": 12, "block.operands[1].radius": -4 * math.pi,
                "block.operands[1].end[2]": 0, "egg.radii[0]": 0}  # fmt: skip
    within_errors(bored, expected, names)
    # A ball of many: 4 π r²
    many = co.derivatives.volume_gradient(parameters, 3, rays=30_000)
    within_errors(many, {"bodies[2].radii[1]": 16 * math.pi, "bodies[2].radii[0]": 0}, names)


def test_volumes_that_have_no_derivative():
    flush = co.Box((0, 0, 0), (2, 1, 1)) | co.Box((1, 0, 0), (3, 1, 1))
    scene = co.Scene([flush, co.HalfSpace((0, 0, 1), 0), co.Disc((0, 0, 0), (0, 0, 1), 1)])
    parameters = co.parameters(scene)
    found = co.derivatives.volume_gradient(parameters, 0, rays=1000).gradient
    assert np.isnan(found[parameters.index("bodies[0].operands[0].high[2]")])
    assert not np.isnan(found[parameters.index("bodies[0].operands[0].low[0]")])
    with pytest.raises(ValueError, match="must be bounded"):
        co.derivatives.volume_gradient(parameters, 1)
    with pytest.raises(ValueError, match="must be a solid"):
        co.derivatives.volume_gradient(parameters, 2)
