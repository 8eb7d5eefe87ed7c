"""First hits, occlusion and crossings of every shape, solids and sheets."""

import math

import numpy as np

import conicoid as co


def test_misses(subject):
    hits = subject.scene.first_hit(*subject.rays)
    miss = np.isinf(hits.t)
    assert (hits.t[miss] > 0).all()
    for name in ("body", "face", "surface"):
        assert (getattr(hits, name)[miss] == -1).all()
        assert (getattr(hits, name)[~miss] >= 0).all()
    assert not hits.entering[miss].any()
    for name in ("point", "local_point", "normal", "uv"):
        assert np.isnan(getattr(hits, name)[miss]).all(), name
        assert np.isfinite(getattr(hits, name)[~miss]).all(), name


def test_hits_lie_within_the_bounds(subject):
    hits = subject.scene.first_hit(*subject.rays)
    hit = np.isfinite(hits.t)
    slack = (
        1e-14 * (np.abs(subject.rays[0][hit]).max(axis=1) + subject.size + hits.t[hit] * subject.speed[hit])[:, None]
    )
    for low, high in (subject.shape.bounds, subject.scene.bounds):
        assert (hits.point[hit] >= low - slack).all()
        assert (hits.point[hit] <= high + slack).all()


def test_scene_bounds_are_those_of_the_shape(subject):
    """Bounds of parts that cut one another come from another method.

    They are as tight, or narrower, but for 1e-6 of the size.
    """
    box, exact = np.array(subject.scene.bounds), np.array(subject.shape.bounds)
    if isinstance(subject.shape, (co.Intersection, co.Difference, co.Union)):
        finite = np.isfinite(exact[1] - exact[0])
        slack = 1e-6 * (exact[1] - exact[0])[finite].max(initial=0.0)
        assert (box[0] >= exact[0] - slack).all()
        assert (box[1] <= exact[1] + slack).all()
    else:
        assert np.array_equal(box, exact)


def test_direction_scaled_by_a_power_of_two_scales_t_exactly(subject):
    o, d = subject.rays
    once = subject.scene.crossings(o, d, t_min=-math.inf)
    for factor in (0.5, 1024.0):
        other = subject.scene.crossings(o, d * factor, t_min=-math.inf)
        assert np.array_equal(once.offsets, other.offsets)
        assert np.array_equal(once.t, other.t * factor)
        assert np.array_equal(once.face, other.face)


def test_leading_shapes(subject):
    o, d = (x[:12] for x in subject.rays)
    flat = subject.scene.first_hit(o, d)
    grid = subject.scene.first_hit(o.reshape(3, 4, 3), d.reshape(3, 4, 3))
    widths = {
        "t": 0,
        "body": 0,
        "face": 0,
        "surface": 0,
        "entering": 0,
        "point": 3,
        "local_point": 3,
        "normal": 3,
        "uv": 2,
    }
    for name, width in widths.items():
        last = (width,) if width else ()
        assert getattr(flat, name).shape == (12, *last)
        assert getattr(grid, name).shape == (3, 4, *last)
        assert np.array_equal(getattr(flat, name), getattr(grid, name).reshape(12, *last), equal_nan=True)
    empty = subject.scene.first_hit(np.zeros((0, 3)), np.zeros((0, 3)))
    assert (empty.t.shape, empty.point.shape) == ((0,), (0, 3))
    assert subject.scene.occluded(o.reshape(3, 4, 3), d.reshape(3, 4, 3)).shape == (3, 4)


def test_single_rays_give_scalars(subject):
    o, d = subject.rays
    many = subject.scene.first_hit(o, d)
    index = int(np.argmin(many.t))
    one = subject.scene.first_hit(o[index], d[index])
    for name in ("t", "body", "face", "surface", "entering"):
        value = getattr(one, name)
        assert np.ndim(value) == 0
        assert not isinstance(value, np.ndarray)
        assert value == getattr(many, name)[index]
    assert isinstance(bool(subject.scene.occluded(o[index], d[index])), bool)
    assert np.ndim(subject.scene.occluded(o[index], d[index])) == 0
    assert np.ndim(subject.scene.contains(o[index])) == np.ndim(subject.scene.body_at(o[index])) == 0


def test_uv(subject):
    """On surfaces of revolution u is a turn in [0, 1), and v of a finite shape is a height in [0, 1]."""
    hits = subject.scene.first_hit(*subject.rays)
    hit = np.isfinite(hits.t)
    name = type(subject.shape).__name__
    if name == "Triangle":
        u, v = hits.uv[hit].T
        assert (u >= -1e-12).all()
        assert (v >= -1e-12).all()
        assert (u + v <= 1 + 1e-12).all()
    turned = {"Sphere", "Spheres", "Ellipsoid", "Cylinder", "Cone", "DoubleCone", "EllipticParaboloid", "OneSheetHyperboloid",
              "TwoSheetHyperboloid", "EllipticCone", "EllipticCylinder", "CylinderPatch"}  # fmt: skip
    if name not in turned:
        return
    side = hit & (hits.face == 0)
    u, v = hits.uv[side].T
    assert (u >= 0).all()
    assert (u < 1).all()
    caps = hits.uv[hit & (hits.face != 0)]
    assert (np.abs(caps) <= 1 + 1e-12).all()
    if subject.bounded:
        assert (v >= -1e-12).all()
        assert (v <= 1 + 1e-12).all()


def test_bounds_of_a_prepared_scene_are_those_of_its_shapes(subject):
    shapes = [subject.shape, subject.shape.translate((0.1, 7.3, -2.6))]
    before, after = co.Scene(shapes), co.Scene(shapes)
    after.prepare()
    for name in ("bounds", "extent"):
        assert np.array_equal(getattr(before, name), getattr(after, name)), name
