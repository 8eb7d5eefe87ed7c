"""Answers in the hands of a new user: sizes, joins, indices, NumPy's functions, names, empty intervals, pictures."""

from __future__ import annotations

import io
import itertools
import math
import pickle

import numpy as np
import pytest

import conicoid as co

RED, BLUE = co.matte("red", name="steel", properties={"density": 8.0}), co.matte("blue", name="steel")
SCENE = co.Scene([
    co.Body(co.Sphere(), RED, "car"), co.Body(co.Box((2, -1, -1), (3, 1, 1)), BLUE, "wall"),
    co.Spheres([(0, 0, 9), (0, 0, 12)], [1, 1]),
])  # fmt: skip
ORIGINS = np.stack(np.broadcast_arrays(np.linspace(-0.9, 3, 12).reshape(3, 4), 0.1, 20.0), axis=-1)
RAYS = co.Rays(ORIGINS, (0, 0, -1))
HITS, SPANS, CROSSINGS = SCENE.first_hit(RAYS), SCENE.spans(RAYS), SCENE.crossings(RAYS)


def test_answers_have_a_shape():
    assert HITS.shape == HITS.t.shape == SPANS.shape == CROSSINGS.shape == RAYS.shape == (3, 4)
    assert (HITS.ndim, HITS.size, RAYS.ndim, RAYS.size) == (2, 12, 2, 12)
    one = SCENE.first_hit((0, 0, 5), (0, 0, -1))
    assert (one.shape, one.ndim, one.size, one.rays.size) == ((), 0, 1, 1)
    assert SPANS.rays is SPANS[:].detached()._rays or SPANS.rays == RAYS
    assert repr(CROSSINGS) == f"Crossings(shape=(3, 4), {len(CROSSINGS.t)} crossings)"
    assert pickle.loads(pickle.dumps(SPANS)).shape == (3, 4)


@pytest.mark.parametrize("kind", ["spans", "crossings"])
@pytest.mark.parametrize("detached", [(), (0,), (0, 1, 2)])
def test_lists_of_batches_are_joined(kind, detached):
    ask = getattr(SCENE, kind)
    parts = [ask(RAYS[k]) for k in (slice(0, 1), slice(1, 3))] + [ask(RAYS[2:])]
    whole = ask(co.Rays.concatenate([RAYS, RAYS[2:]]))
    given = [part.detached() if k in detached else part for k, part in enumerate(parts)]
    joined = type(whole).concatenate(given)
    assert joined == whole
    assert joined.shape == (4, 4)
    assert joined[6] == whole[6]
    assert len(joined[5].body) == np.diff(whole.offsets)[5]
    rows = type(whole).concatenate(itertools.chain(ask(RAYS)))
    assert rows == ask(RAYS[:].__class__(ORIGINS.reshape(-1, 3), (0, 0, -1)))


def test_what_is_not_joined():
    for kind, part in ((co.Spans, SPANS), (co.Crossings, CROSSINGS)):
        name = kind.__name__
        with pytest.raises(TypeError, match=rf"{name}: parts\[1\] must be {name}, got Hits"):
            kind.concatenate([part, HITS])
        with pytest.raises(TypeError, match=f"{name}: parts must be a list of {name}, got {name}"):
            kind.concatenate(part)
        with pytest.raises(ValueError, match=f"{name}: parts must hold at least one"):
            kind.concatenate([])
        with pytest.raises(ValueError, match=f"{name}: parts must have shapes that differ in the first axis"):
            kind.concatenate([part, part[0]])
        other = getattr(co.Scene(co.Box((0, 0, 0), (9, 9, 9))), name.lower())(RAYS)
        with pytest.raises(ValueError, match=f"{name}: parts must be of one scene"):
            kind.concatenate([part, other])


def test_an_index_that_is_none_says_what_may_be_meant():
    with pytest.raises(
        IndexError, match=r"got \(1, 2\); rays are counted flat: that of the index \(1, 2\) is spans\[6\]$"
    ):
        SPANS[1, 2]
    with pytest.raises(IndexError, match=r"that of the index \(2, -1\) is crossings\[11\]$"):
        CROSSINGS[2, -1]
    assert SPANS[6] == SCENE.spans(RAYS[1, 2])
    flat = SCENE.spans(co.Rays(ORIGINS.reshape(-1, 3), (0, 0, -1)))
    with pytest.raises(IndexError, match=r"got \(0, 1\); one row of one ray is spans\[0\]\.t_enter\[1\]$"):
        flat[0, 1]
    with pytest.raises(IndexError, match=r"Spans: index must be .*, got 't_enter'; spans\.t_enter is a field$"):
        SPANS["t_enter"]
    with pytest.raises(IndexError, match=r"Hits: index must be .*, got 'point'; hits\.point is a field$"):
        HITS["point"]
    with pytest.raises(IndexError, match=r"Rays: index must be .*, got 'origins'; rays\.origins is a field$"):
        RAYS["origins"]


@pytest.mark.parametrize(("thing", "field"), [
    (HITS, r"hits\.t, "), (HITS[0, 0], r"hits\.t, "), (SPANS, r"spans\.t_enter"), (CROSSINGS, r"crossings\.t, "),
    (RAYS, r"rays\.origins"),
])  # fmt: skip
def test_what_is_no_array_says_where_its_arrays_are(thing, field):
    for use in (np.asarray, np.mean, np.isinf, np.min, lambda x: np.float64(1) + x, lambda x: np.array([1.0]) < x):
        with pytest.raises(TypeError, match=f"is no array of numbers: its fields are, such as {field}"):
            use(thing)
    for use in (
        SCENE.contains,
        lambda x: co.refract(x, (0, 0, 1), 1.5),
        lambda x: co.reflect((0, 0, 1), x),
        HITS.spawn,
    ):
        with pytest.raises(ValueError, match=f"; {field}.* are arrays$"):
            use(thing)
    with pytest.raises(ValueError, match=f"; co.{type(thing).__name__}.concatenate joins them$"):
        co.Rays([thing, thing], (0, 0, 1))
    file = io.BytesIO()
    np.savez_compressed(file, thing=thing)
    file.seek(0)
    assert np.load(file, allow_pickle=True)["thing"].item() == thing


def test_scenes_are_sequences_of_their_bodies():
    assert len(SCENE) == SCENE.body_count == 4
    assert list(SCENE) == [SCENE[k] for k in range(4)]
    assert len(co.Scene([])) == 0
    file = io.BytesIO()
    np.savez(file, scene=SCENE)
    file.seek(0)
    assert np.load(file, allow_pickle=True)["scene"].item() == SCENE


def test_rays_of_a_picture_without_a_camera():
    assert SCENE.camera is None
    assert SCENE.rays(8, 6) == SCENE.fitting_camera(8 / 6).rays(8, 6)
    camera = co.Camera((0, 0, 50), (0, 0, 0))
    assert SCENE.replace(camera=camera).rays(8, 6) == camera.rays(8, 6)


def test_each_hit_has_its_ray():
    """`zip(rays, hits)` would pair the two arrays that a Rays unpacks to."""
    flat = SCENE.first_hit(co.Rays(ORIGINS.reshape(-1, 3), (0, 0, -1)))
    for k, hit in enumerate(flat):
        origin, direction = hit.rays
        assert hit.rays == flat.rays[k]
        if hit:
            assert np.allclose(hit.point, origin + hit.t * direction)
    assert "zip(rays, hits)" in co.Rays.__doc__
    assert "hit.rays" in co.Rays.__doc__


@pytest.mark.parametrize(("low", "high"), [(5, 1), (np.inf, -np.inf), (np.full((3, 4), 30.0), 2), (19, 19)])
def test_an_empty_interval_holds_nothing(low, high):
    """Where t_min is not below t_max."""
    assert not SCENE.first_hit(RAYS, t_min=low, t_max=high).hit.any()
    assert not SCENE.occluded(RAYS, t_min=low, t_max=high).any()
    assert not len(SCENE.crossings(RAYS, t_min=low, t_max=high).t)
    assert not SCENE.lengths(RAYS, t_min=low, t_max=high).any()
    assert not SCENE.spans(RAYS, t_min=low, t_max=high).lengths().any()
    assert not SCENE.line_integral([1, 1, 1, 1], RAYS, t_min=low, t_max=high).any()


def test_a_name_stands_for_all_materials_that_have_it():
    """Columns, and `by_material`, have one place for each different material; a name is for all of that name."""
    assert SCENE.materials == SPANS.materials == (RED, BLUE, None)
    columns = SPANS.lengths(by="material")
    assert np.array_equal(SCENE.lengths(RAYS, by="material"), columns)
    by_name = SPANS.line_integral({"steel": 1}, otherwise=0)
    assert np.allclose(by_name, columns[..., 0] + columns[..., 1], rtol=1e-15)
    found = co.measure(SCENE)
    assert math.isclose(found["steel"].volume, found.by_material[0].volume + found.by_material[1].volume)
    titles = [line.split("  ")[0] for line in str(found).splitlines()[1:4]]
    assert titles == ["material 'steel' of body 0", "material 'steel' of body 1", "no material"]


def test_measures_are_found_by_the_names_of_bodies():
    found = co.measure(SCENE)
    assert found["car"] is found[0]
    assert found["wall"].volume == 4
    with pytest.raises(
        KeyError, match="no material is called 'cra'; materials: 'steel', 'steel'; a body is called 'car'"
    ):
        found["cra"]
    water = co.matte(name="water")
    both = co.Scene([co.Body(co.Box(), water, "water"), co.Body(co.Sphere(), water)])
    with pytest.raises(KeyError, match="both a material and a body are called 'water'"):
        co.measure(both)["water"]
    assert co.measure(co.Scene(both.bodies[:1]))["water"].volume == 8


def test_materials_without_names_are_told_apart():
    scene = co.Scene([co.Body(co.Box(), "red"), co.Body(co.Sphere(), "blue", "b"), co.Body(co.Sphere(2), "red")])
    titles = [line.split("  ")[0] for line in str(co.measure(scene)).splitlines()[1:3]]
    assert titles == ["material of body 0", "material of body 1"]
    with pytest.raises(ValueError, match="no property 'mu' for a material without a name, color 'red'"):
        scene.line_integral("mu", (0, 0, 9), (0, 0, -1))


@pytest.mark.parametrize("turn", [lambda s: s, lambda s: s.translate((0.5, -1, 0.1)), lambda s: s.rotate("z", 90)])
def test_bounds_that_are_zero_are_zero(turn):
    balls = turn(co.Spheres([(1, 0.5, 2), (3, 0.5, 2)], [1, 0.5]))
    low, high = co.Scene([balls, co.Body(turn(co.Sphere(0.5, (0.5, 0.5, 0.5))))]).bounds
    assert not any(0 < abs(end) < 1e-300 for end in (*low, *high))
    low, high = co.Spheres([(1, 2, 3)], [1]).bounds
    assert (low.tolist(), high.tolist()) == ([0, 1, 2], [2, 3, 4])


def test_bounds_of_balls_hold_them_exactly():
    from fractions import Fraction

    random = np.random.default_rng(3)
    centers, radii, shift = random.normal(size=(200, 3)), random.random(200) + 1e-9, (0.1, 1e-17, -3e8)
    low, high = co.Spheres(centers, radii).translate(shift).bounds
    for i in range(3):
        ends = [
            (Fraction(c) + Fraction(shift[i]), Fraction(r))
            for c, r in zip(centers[:, i].tolist(), radii.tolist(), strict=True)
        ]
        most, least = max(c + r for c, r in ends), min(c - r for c, r in ends)
        assert Fraction(np.nextafter(high[i], -np.inf).item()) < most <= Fraction(high[i].item())
        assert Fraction(low[i].item()) <= least < Fraction(np.nextafter(low[i], np.inf).item())


@pytest.mark.parametrize("make", [
    lambda: co.Ellipsoid((1, 1, 1), z_range=(2, 3)), lambda: co.Ellipsoid((1, 2, 3), z_range=(3, 4)),
    lambda: co.Ellipsoid((1, 2, 3), (0, 0, 9), z_range=(-np.inf, -3)),
    lambda: co.Ellipsoid.from_coefficients(1, 1, 4, z_range=(0.5, 1)),
    lambda: co.EllipticParaboloid(1, 1, (-3, -2)), lambda: co.EllipticParaboloid(1, 1, (-np.inf, 0)),
    lambda: co.TwoSheetHyperboloid(1, 1, 1, (-0.5, 0.5)), lambda: co.TwoSheetHyperboloid(1, 1, 4, (-0.5, 0.5)),
])  # fmt: skip
def test_ranges_that_leave_nothing_are_refused(make):
    with pytest.raises(ValueError, match=r"^\w+: z_range must leave a part of the solid"):
        make()


@pytest.mark.parametrize("make", [
    lambda box: co.HyperbolicCylinder(1, 1, box), lambda box: co.ParabolicCylinder(0.25, box),
    lambda box: co.HyperbolicParaboloid(1, 1, box),
])  # fmt: skip
def test_boxes_that_hold_nothing_are_refused(make):
    far = co.Box((5, -0.1, -1), (6, 0.1, 1))
    for box in (far, far.rotate("y", 90).rotate("y", -90), far.rotate("x", 10)):
        with pytest.raises(ValueError, match=r"^\w+: within must hold a part of the solid"):
            make(box)
    assert make(co.Box()).within == co.Box()


def test_ranges_that_leave_something_are_taken():
    tip = np.nextafter(1, 0)
    for shape in (co.Ellipsoid((1, 1, 1), z_range=(tip, 2)), co.EllipticParaboloid(1, 1, (-1, 5e-100)),
                  co.TwoSheetHyperboloid(1, 1, 1, (-1, np.nextafter(1, 2))), co.EllipticCone(1, 1, 1, (-1, 0)),
                  co.DoubleCone(1, (0, 1)), co.OneSheetHyperboloid(1, 1, 1, (-9, -8)), co.EllipticCylinder(1, 1, (5, 6)),
                  co.TwoSheetHyperboloid(1, 1, 1, (-np.inf, 0))):  # fmt: skip
        low, high = shape.bounds
        assert (low <= high).all()


def test_colours_take_no_colour_map():
    colors = np.full((2, 2, 3), 0.5)
    for field, value in (("vmin", 0), ("vmax", 1), ("colormap", "dusk"), ("colormap", "grey")):
        with pytest.raises(ValueError, match=rf"Image: {field} goes with a number per pixel, got colours, \(2, 2, 3\)"):
            co.Image(colors, **{field: value})
    assert co.Image(colors).pixels.max() == 0.5


def test_bytes_as_floats_are_no_colours(tmp_path):
    levels = np.random.default_rng(1).integers(0, 256, (8, 8, 3))
    for dtype in (np.float32, np.float64):
        with pytest.raises(ValueError, match=r"whole numbers up to \d+ must be of uint8, sRGB bytes .*got float"):
            co.Image(levels.astype(dtype))
    with pytest.warns(
        UserWarning, match=r"Image: most numbers of the array, up to 25\d\.\d*, are beyond 1, which is white"
    ):
        co.Image(levels * 0.999)
    bright = np.random.default_rng(1).random((8, 8, 3)) ** 8 * 90  # a highlight, and no warning
    assert co.Image(bright).pixels.max() > 16
    lamp = co.Scene(co.Body(co.Box(), co.matte((1, 1, 1))), lights=[co.AmbientLight(30.0)], background=(1, 1, 1))
    assert lamp.render(8, 8, samples=1).pixels.max() == 30
    assert "NaN" in co.Image.__doc__


@pytest.mark.parametrize(
    ("shape", "moves"),
    [
        ((co.Sphere() - co.Box()).translate((1, 2, 3)), ").translate((1.0, 2.0, 3.0))"),
        (co.Sphere() - (co.Sphere() | co.Box()).scale(2), "Union(...).scale((2.0, 2.0, 2.0)))"),
        (co.Spheres([(0, 0, 0)], 1).translate((0, 0, 1)), ".translate((0.0, 0.0, 1.0))"),
        (co.Box().painted("red").translate((1, 0, 0)), ".translate((1.0, 0.0, 0.0))"),
    ],
)
def test_the_repr_of_what_was_moved_shows_how(shape, moves):
    assert moves in repr(shape)


def test_the_repr_of_a_moved_shape_is_a_call_that_makes_it():
    names = {name: getattr(co, name) for name in ("Sphere", "Box", "Cylinder", "Disc")}
    for shape in (
        co.Sphere(1.5).translate((1, 2, 3)), co.Box().rotate("z", 30).scale((1, 2, 3)),
        co.Cylinder((0, 0, 0), (0, 0, 1), 2).transform([(1, 0, 0, 2), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]),
        co.Disc((0, 0, 0), (0, 0, 1), 1).rotate((1, 1, 0), 45.5).translate((0, 0, 1e-9)),
    ):  # fmt: skip
        assert eval(repr(shape), names) == shape
    long = co.Sphere()
    for _ in range(30):
        long = long.translate((0, 0, 1))
    assert len(repr(long)) < 500
    assert " ... 22 more moves ... " in repr(long)
