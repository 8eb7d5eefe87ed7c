"""`hits.jvp`, `hits.vjp` and `hits.curvature`: by hand, as transposes of one another, and where there is no derivative."""

import math

import numpy as np
import pytest

import conicoid as co


def tangents_of(scene, rays, **changes):
    """Return the tangents of first hits for changes of parameters by their names."""
    parameters = co.parameters(scene)
    tangent = np.zeros(len(parameters))
    for name, change in changes.items():
        tangent[parameters.index(name.replace("__", "."))] = change
    return scene.first_hit(*rays).jvp(parameters, tangent)


def test_a_ball_that_grows():
    # t = 5 - sqrt(r² - h²) for a ray at height h, so dt/dr = -r / sqrt(r² - h²)
    scene = co.Scene([co.Body(co.Sphere(2), name="ball")])
    found = tangents_of(scene, ((-5, 1, 0), (1, 0, 0)), ball__radius=1)
    assert found.t == pytest.approx(-2 / math.sqrt(3), rel=1e-14)
    # x = -sqrt(r² - h²) at y = h: the normal (x, h, 0) / r turns with it
    assert found.point == pytest.approx([-2 / math.sqrt(3), 0, 0], abs=1e-14)
    assert found.normal == pytest.approx([-1 / (4 * math.sqrt(3)), -1 / 4, 0], abs=1e-14)


def test_units_of_t_are_those_of_the_direction():
    scene = co.Scene([co.Body(co.Sphere(2), name="ball")])
    assert tangents_of(scene, ((-5, 0, 0), (4, 0, 0)), ball__radius=1).t == pytest.approx(-0.25, rel=1e-15)


def test_the_wall_of_a_bore_moves_with_the_bore_alone():
    block = co.Box((0, 0, 0), (4, 4, 4)) - co.Cylinder((2, 2, -1), (2, 2, 5), 1)
    scene = co.Scene([co.Body(block, name="block")])
    hits = scene.first_hit((2, 2, 2), (1, 0, 0))
    parameters = co.parameters(scene)
    gradient = dict(zip(parameters.names, hits.vjp(parameters, t=1).parameters, strict=True))
    assert gradient["block.operands[1].radius"] == pytest.approx(1, rel=1e-15)
    assert [name for name in gradient if gradient[name] and "operands[0]" in name] == []


@pytest.fixture(scope="module")
def crowd():
    random = np.random.default_rng(3)
    shapes = [
        co.Ellipsoid((1, 2, 1.5)).rotate((1, 2, 3), 20).translate((4, 0, 0)),
        (co.Box((0, 0, 0), (2, 2, 2)) - co.Cylinder((1, 1, -1), (1, 1.25, 3), 0.5)).scale((1, 1.2, 0.9)),
        co.Spheres(random.uniform(-5, 5, (20, 3)), random.uniform(0.3, 1, 20)),
        co.Cones([(-4, 3, 0)], [(-3, 4.5, 2)], [1], [0.5]).rotate("z", 30),
        co.Disc((0, -4, 0), (1, 2, 0.5), 2),
    ]
    scene = co.Scene(shapes)
    origins = random.normal(size=(700, 3)) * 9
    return scene, origins, random.uniform(-4, 4, (700, 3)) - origins


def test_vjp_is_the_transpose_of_jvp(crowd):
    scene, origins, directions = crowd
    hits, parameters = scene.first_hit(origins, directions), co.parameters(scene)
    assert 300 < hits.hit.sum() < 700
    assert len(np.unique(hits.body)) > 20
    random = np.random.default_rng(4)
    tangents = random.normal(size=len(parameters)), *random.normal(size=(2, 700, 3))
    found = hits.jvp(parameters, tangents[0], d_origins=tangents[1], d_directions=tangents[2])
    cotangents = {name: np.where(np.isfinite(getattr(found, name)), random.normal(size=np.shape(getattr(found, name))), 0.0)
             for name in ("t", "point", "normal", "uv")}  # fmt: skip
    forth = sum(float(np.nansum(getattr(found, name) * weight)) for name, weight in cotangents.items())
    back = hits.vjp(parameters, **cotangents)
    sums = (back.parameters @ tangents[0], (back.origins * tangents[1]).sum(), (back.directions * tangents[2]).sum())
    assert math.fsum(sums) == pytest.approx(forth, rel=1e-12)


def test_differences_of_a_crowd(crowd):
    # Scenes with other numbers are traced, so that bulk bodies and Booleans take a user's route.
    scene, origins, directions = crowd
    parameters = co.parameters(scene)
    random = np.random.default_rng(5)
    tangent, step = random.normal(size=len(parameters)), 1e-6
    tangent[[name.startswith("bodies[4].normal") for name in parameters.names]] = 0
    hits = scene.first_hit(origins, directions)
    found = hits.jvp(parameters, tangent)
    near, far = (
        parameters.scene(parameters.values + s * step * tangent).first_hit(origins, directions) for s in (-1, 1)
    )
    steep = np.abs((hits.normal * directions).sum(axis=-1)) > 0.3 * np.sqrt((directions**2).sum(axis=-1))
    same = hits.hit & (near.body == far.body) & (near.face == far.face) & (near.body == hits.body) & steep
    assert same.sum() > 250
    for name in ("t", "point", "normal", "uv"):
        change = (getattr(far, name)[same] - getattr(near, name)[same]) / (2 * step)
        assert getattr(found, name)[same] == pytest.approx(change, abs=1e-6, rel=1e-6)


def test_shapes_of_rays_are_kept():
    scene = co.Scene([co.Sphere()])
    hits = scene.first_hit(np.zeros((2, 3, 3)), (0, 0, 1))
    found = hits.jvp(d_origins=(0, 0, 1))
    assert found.t.shape == (2, 3)
    assert found.uv.shape == (2, 3, 2)
    assert found.t == pytest.approx(np.full((2, 3), -1.0))
    assert hits.vjp(t=np.ones((2, 3))).directions.shape == (2, 3, 3)
    assert scene.first_hit(np.zeros((0, 3)), (0, 0, 1)).jvp().normal.shape == (0, 3)


def test_tied_walls_have_no_derivative():
    boxes = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1))])
    # The common wall, an edge, a corner; a wall of one alone has a derivative
    hits = boxes.first_hit([(0.5, 0.5, 0.5), (-1, -1, 0.5), (-1, -1, -1), (-1, 0.5, 0.5)],
                           [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 0)])  # fmt: skip
    found = hits.jvp(d_origins=(1, 0, 0))
    assert np.isnan(found.t).tolist() == [True, True, True, False]
    assert np.isnan(found.normal).all(axis=1).tolist() == [True, True, True, False]
    assert found.t[3] == -1
    back = hits.vjp(co.parameters(boxes), t=[0, 0, 0, 2.0])
    assert np.isfinite(back.parameters).all()
    assert np.isnan(hits.vjp(co.parameters(boxes), t=[0, 1, 0, 0]).parameters).any()


def test_walls_of_bodies_that_cross_tie_where_they_do():
    # Two balls of radius 5, 6 apart, have the circle of radius 4 at x = 3 in common.
    scene = co.Scene([co.Sphere(5), co.Sphere(5, (6, 0, 0)), co.Sphere(1, (0, 0, 99))])
    hits = scene.first_hit([(3, 9, 0), (3.001, 9, 0), (0, 9, 0)], (0, -1, 0))
    assert hits.t[0] == 5
    assert np.isnan(hits.jvp(d_origins=(0, 1, 0)).t).tolist() == [True, False, False]
    # A ray that starts on one wall is no tie with it
    away = scene.first_hit(hits[1:].spawn((0, 1, 0.01)))
    assert not away.hit.any()
    inside = scene.first_hit(hits[2].spawn((0, -1, 0)))
    assert inside.t == pytest.approx(10)
    assert inside.jvp(d_origins=(0, 1, 0)).t == pytest.approx(1)


def test_flush_walls_tie_where_both_are_walls():
    # Two boxes of one body, flush at z = 1, overlap between x = 1 and x = 2.
    both = co.Scene([co.Box((0, 0, 0), (2, 1, 1)) | co.Box((1, 0, 0), (3, 1, 1))])
    hits = both.first_hit([(0.5, 0.5, 5), (1.5, 0.5, 5), (2.5, 0.5, 5)], (0, 0, -1))
    assert np.isnan(hits.jvp(d_origins=(0, 0, 1)).t).tolist() == [False, True, False]


def test_u_jumps_only_by_numbers_that_tilt_an_axis():
    """On the side of an upright cylinder v = (z - start) / (end - start).

    u counts from x or y, which are equally small.
    """
    scene, ray = co.Scene([co.Body(co.Cylinder((0, 0, -1), (0, 0, 3), 1), name="rod")]), ((5, 0.5, 1.5), (-1, 0, 0))
    assert tangents_of(scene, ray, **{"rod__start[2]": 1}).uv == pytest.approx([0, (1.5 - 3) / 4**2], abs=1e-15)
    assert tangents_of(scene, ray, **{"rod__end[2]": 1}).uv == pytest.approx([0, -(1.5 + 1) / 4**2], abs=1e-15)
    for number in ("start[0]", "start[1]", "end[0]", "end[1]"):
        assert np.isnan(tangents_of(scene, ray, **{f"rod__{number}": 1}).uv[0])


@pytest.mark.parametrize("low", [0.0, -1.0])
def test_v_of_a_bowl_cut_at_its_vertex_has_a_kink(low):
    """v = z / 2 counts from the cut or the vertex, whichever is higher."""
    scene, ray = co.Scene([co.Body(co.EllipticParaboloid(1, 1, (low, 2)), name="bowl")]), ((5, 0, 1), (-1, 0, 0))
    assert np.isnan(tangents_of(scene, ray, **{"bowl__z_range[0]": 1}).uv).tolist() == [False, low == 0]
    assert tangents_of(scene, ray, **{"bowl__z_range[1]": 1}).uv == pytest.approx([0, -1 / 2**2])


def test_an_apex_has_no_derivative():
    hit = co.Scene([co.Cone((0, 0, 0), (0, 0, 1), 1, 0)]).first_hit((0, 0, 5), (0, 0, -1))
    assert hit.t == 4
    assert math.isnan(hit.jvp(d_origins=(1, 0, 0)).t)


def test_misses_are_nan_and_take_no_cotangents():
    hits = co.Scene([co.Sphere()]).first_hit([(0, 0, 5), (9, 0, 5)], (0, 0, -1))
    assert np.isnan(hits.jvp(d_origins=(0, 0, 1)).t).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"0 for rays that hit nothing, as the ray \[1\] does"):
        hits.vjp(t=[1, 1])


def test_invalid_calls_are_refused():
    scene, other = co.Scene([co.Sphere()]), co.Scene([co.Box()])
    hits = scene.first_hit((0, 0, 5), (0, 0, -1))
    for call, error, message in (
        (lambda: hits.jvp(co.parameters(other), np.zeros(6)), ValueError, "same shapes"),
        (
            lambda: hits.jvp(co.parameters(scene), np.zeros(3)),
            ValueError,
            r"d_parameters must have shape \(4,\), got \(3,\)",
        ),
        (lambda: hits.jvp(d_parameters=np.zeros(4)), ValueError, "d_parameters need parameters"),
        (lambda: hits.jvp([1.0], [1.0]), TypeError, r"co\.parameters\(scene\), got list"),
        (lambda: hits.jvp(d_origins=np.zeros((2, 3))), ValueError, r"d_origins must broadcast to \(3,\)"),
        (lambda: hits.detached().jvp(), ValueError, "detached"),
    ):
        with pytest.raises(error, match=message):
            call()


@pytest.mark.parametrize(
    ("shape", "ray", "expected"),
    [
        (co.Sphere(2), ((5, 0, 0), (-1, 0, 0)), (0.5, 0.5)),
        (~co.Sphere(2), ((0, 0, 0), (1, 0, 0)), (-0.5, -0.5)),  # hollow
        (co.Cylinder((0, 0, -3), (0, 0, 3), 2), ((5, 0, 0), (-1, 0, 0)), (0.5, 0)),
        (co.Box(), ((5, 0, 0), (-1, 0, 0)), (0, 0)),
        (co.Ellipsoid((3, 2, 1)), ((5, 0, 0), (-1, 0, 0)), (3 / 1, 3 / 4)),  # a / c², a / b² at the end of a
        (co.HyperbolicParaboloid(1, 2), ((0, 0, 5), (0, 0, -1)), (2, -4)),  # z = x² - 2 y²: its inside is above
    ],
)
def test_principal_curvatures(shape, ray, expected):
    hit = co.Scene([shape]).first_hit(*ray)
    found = hit.curvature()
    assert sorted((found.k1, found.k2)) == pytest.approx(sorted(expected), abs=1e-14)
    frame = np.array([found.direction1, found.direction2, hit.normal])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-14)
    assert found.mean == pytest.approx(sum(expected) / 2, abs=1e-14)
    assert found.gaussian == pytest.approx(expected[0] * expected[1], abs=1e-14)


def test_normals_turn_by_the_curvature():
    # Along a principal direction e the normal turns by k e (Rodrigues' formula).
    scene = co.Scene([co.Ellipsoid((1, 2, 3)).rotate((1, 1, 1), 40)])
    random = np.random.default_rng(1)
    hits = scene.first_hit(random.normal(size=(50, 3)) * 9, -random.normal(size=(50, 3)))
    hits = scene.first_hit(hits.rays.origins, -hits.rays.origins)
    bent = hits.curvature()
    for k, along in ((bent.k1, bent.direction1), (bent.k2, bent.direction2)):
        turned = hits.jvp(d_origins=along).normal
        assert turned == pytest.approx(k[:, None] * along, abs=1e-12)


def test_radii_that_are_equal_have_derivatives():
    """The largest radius is a unit alone: dt / dr = x² / (r x·d), along each axis."""
    scene = co.Scene([co.Ellipsoid((2, 2, 2))])
    numbers, hit = co.parameters(scene), scene.first_hit((5, 0.1, 0.2), (-1, 0, 0))
    slopes = [float(hit.jvp(numbers, row).t) for row in np.eye(len(numbers))[:3]]
    x, y, z = np.sqrt(4 - 0.05), 0.1, 0.2
    assert slopes == pytest.approx([-x / 2, -y * y / x / 2, -z * z / x / 2], rel=1e-14)
    for radii in ((2, 2, 1), (1, 2, 2), (2, 2, 2)):  # also of a cut one, and of normal and uv
        solid = co.Scene([co.Ellipsoid(radii, z_range=(-0.5, 0.75))])
        numbers, (o, d) = co.parameters(solid), ([(5, 0.1, 0.2), (0.3, 0.2, 5)], [(-1, 0.01, 0), (0.01, 0, -1)])
        hits, values = solid.first_hit(o, d), np.array(numbers.values)
        for row in np.eye(len(numbers)):
            low, high = (numbers.scene(values + side * 1e-5 * row).first_hit(o, d) for side in (-1, 1))
            for field in ("t", "normal", "uv"):
                slope = (getattr(high, field) - getattr(low, field)) / 2e-5
                assert getattr(hits.jvp(numbers, row), field) == pytest.approx(slope, abs=1e-8)


# --- The derivatives of spans, lengths, line integrals and volumes: by closed forms, and as transposes of one another


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


def test_vjp_of_spans_is_the_transpose_of_jvp(setting):
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
