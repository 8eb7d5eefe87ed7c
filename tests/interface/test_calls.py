"""Calls with values that do not fit: errors, warnings, and their words."""

import copy
import inspect
import math
import re
import warnings

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.scene_file import parse_scene

from ..contract.examples import examples_of
from ..public_names import PUBLIC

BALL, BOX = co.Sphere(), co.Box((2, 2, 2), (3, 3, 3))


SCENE = co.Scene([co.Body(BALL, co.matte("red", name="steel"), "ball"), BOX])


RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))


HITS = SCENE.first_hit(RAYS)


CAMERA = co.Camera((0, 0, 5), (0, 0, 0))


LEAD = co.metal("gray", name="lead", properties={"density": 11.35})


LEAD_SCENE = co.Scene([co.Body(BALL, LEAD, "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), "blue", name="pillar")])


LEAD_RAYS = co.Rays([(-5, 0, 0), (-5, 0, 9)], (1, 0, 0))


PIXELS = np.random.default_rng(3).random((4, 8, 3))


SCAN = co.ct.cone([0, 30], 2, 5, 3, 2, spacing=0.4)
IMAGE = LEAD_SCENE.render(8, 6, samples=1, layers=["depth"])


VECTORS = np.array([(1.0, 2, 3), (1, 0, 0), (0, 0, -2), (0.5, 1, 1)])


# --- shapes and bodies


def test_ellipsoid_of_coefficients_moves():
    ball = co.Ellipsoid(coefficients=(1, 1, 1)).translate((1, 0, 0))
    assert ball.coefficients == (1, 1, 1)
    assert ball.radii == (1, 1, 1)


def test_box_by_corners():
    assert co.Box() == co.Box((-1, -1, -1), (1, 1, 1)) == co.Box(high=(1, 1, 1), low=(-1, -1, -1))
    assert co.Box(low=(0, 0, 0)) == co.Box((0, 0, 0), (1, 1, 1))
    assert parse_scene("bodies: [{shape: {Box: {low: [0, 0, 0]}}}]", "x.yaml").bodies[0].shape == co.Box(low=(0, 0, 0))
    assert list(inspect.signature(co.Box).parameters) == ["low", "high", "motion"]


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_shapes_refuse_motions_that_are_none(name):
    shape = examples_of(name)[0]
    fields = {field: getattr(shape, field) for field in inspect.signature(type(shape)).parameters if field != "motion"}
    for motion in ("x", None, 3, np.eye(4), ()):
        with pytest.raises(TypeError, match=rf"^{name}: motion must be left out: .*translate.*; got "):
            type(shape)(**fields, motion=motion)
    assert type(shape)(**fields, motion=shape.motion) == shape


@pytest.mark.parametrize("make", [
    lambda box: co.HyperbolicCylinder(1, 1, box), lambda box: co.ParabolicCylinder(0.25, box),
    lambda box: co.HyperbolicParaboloid(1, 1, box),
])  # fmt: skip
def test_within_must_hold_a_part(make):
    far = co.Box((5, -0.1, -1), (6, 0.1, 1))
    for box in (far, far.rotate("y", 90).rotate("y", -90), far.rotate("x", 10)):
        with pytest.raises(ValueError, match=r"^\w+: within must hold a part of the solid"):
            make(box)
    assert make(co.Box()).within == co.Box()


def test_z_range_that_leaves_something():
    tip = np.nextafter(1, 0)
    for shape in (co.Ellipsoid((1, 1, 1), z_range=(tip, 2)), co.EllipticParaboloid(1, 1, (-1, 5e-100)),
                  co.TwoSheetHyperboloid(1, 1, 1, (-1, np.nextafter(1, 2))), co.EllipticCone(1, 1, 1, (-1, 0)),
                  co.DoubleCone(1, (0, 1)), co.OneSheetHyperboloid(1, 1, 1, (-9, -8)),
                  co.EllipticCylinder(1, 1, (5, 6)), co.TwoSheetHyperboloid(1, 1, 1, (-np.inf, 0))):  # fmt: skip
        low, high = shape.bounds
        assert (low <= high).all()


def test_body_equality():
    body = SCENE["ball"]
    assert body == co.Body(co.Sphere(), co.matte("red", name="steel"), "ball")
    assert hash(body) == hash(co.Body(co.Sphere(), co.matte("red", name="steel"), "ball"))
    assert body not in (None, 3, "ball", co.Sphere(), co.Body(co.Sphere(), "red", "ball"))
    assert (HITS.name == body.name).all()


@pytest.mark.parametrize("comparison", [
    lambda hits: hits.material == "lead", lambda hits: hits.material[0] == "lead", lambda hits: LEAD != "lead",
    lambda hits: "lead" in [LEAD],
])  # fmt: skip
def test_material_compared_with_a_text_warns(comparison):
    with pytest.warns(UserWarning, match="a material equals no text, got 'lead': material.name == 'lead' compares"):
        comparison(LEAD_SCENE.first_hit(LEAD_RAYS))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert copy.copy(LEAD) == LEAD
        assert LEAD not in (co.matte("red"), None, 3)


# --- scenes and queries


@pytest.mark.parametrize("query", sorted({"first_hit", "occluded", "spans", "crossings", "lengths", "line_integral"}))
def test_query_errors_begin_with_its_name(query):
    values = ([1, 1],) if query == "line_integral" else ()
    method = getattr(SCENE, query)
    for arguments in (((0, 0, 1),), (RAYS, (0, 0, 1)), (SCENE,)):
        with pytest.raises(TypeError, match=f"^{query}: "):
            method(*values, *arguments)


def test_errors_of_callbacks_pass():
    def fails(done, count):
        raise TypeError("mine")

    with pytest.raises(TypeError, match="^mine$"):
        SCENE.render(2, 2, progress=fails)
    with pytest.raises(TypeError, match="is a sheet"):
        _ = co.Disc((0, 0, 0), (0, 0, 1), 1) | BALL
    assert list(inspect.signature(co.Sphere).parameters) == ["radius", "center", "motion"]
    assert next(iter(inspect.signature(co.glass).parameters)) == "refractive_index"


def test_scene_attributes_are_read_only():
    scene = co.Scene(co.Sphere())
    with pytest.raises(AttributeError, match="read-only, camera cannot be set; scene.replace makes another$"):
        scene.camera = co.Camera((0, 0, 5), (0, 0, 0))
    with pytest.raises(AttributeError, match="a Scene is read-only, ligths cannot be set"):
        scene.ligths = [co.AmbientLight()]

    class Titled(co.Scene):
        pass

    titled = Titled(co.Sphere())
    titled.title = "a scene of one's own"
    assert titled.title


@pytest.mark.parametrize(
    "progress", [print, lambda *numbers: None, lambda done, count: None, lambda done, count, more=0: None]
)
def test_progress_takes_any_callable(progress):
    co.Scene([BALL]).prepare(progress)


@pytest.mark.parametrize("two", [2, 2.0, np.int64(2), np.uint8(2), np.float32(2)])
def test_whole_numbers_of_any_type(two):
    scene = co.Scene(co.Sphere())
    co.set_threads(two)
    co.set_threads(None)
    assert scene.render(two, two, two, seed=two, depth=two).pixels.shape == (2, 2, 3)
    assert co.check(scene, rays=100 * two, seed=two) == []
    shape = co.Sphere() - co.Cone((0, 0, 0), (1, 1, 3), 0.5, 0.1)
    assert co.measure(shape, rays=1e2 * two).volume == co.measure(shape, rays=200).volume
    assert scene.fitting_camera().rays(two, two).shape == (2, 2)


@pytest.mark.parametrize("other", [2.5, True, "2", None, np.array([2, 2]), float("inf"), 1e400, float("nan"), 2 + 0j])
def test_whole_numbers_refused(other):
    for call in (lambda: co.check(co.Sphere(), rays=other), lambda: co.Scene(co.Sphere()).render(other, 2),
                lambda: co.Scene(co.Sphere()).render(2, 2, seed=other)):  # fmt: skip
        with pytest.raises(ValueError, match=r"must be an integer|must be a whole number"):
            call()
    if other is not None:
        with pytest.raises(ValueError, match="set_threads: count must be an integer from 1 to 65536 or None"):
            co.set_threads(other)


# --- arrays


class Table:
    """A DataFrame as functions for arrays see it: columns with names."""

    def __init__(self, values, columns):
        self.values, self.columns = np.asarray(values, float), columns

    def __array__(self, dtype=None, copy=None):
        return self.values if dtype is None else self.values.astype(dtype)


class Labelled:
    """An array with names of axes, as xarray's. It may hold one of Dask's, and has no graph where it does not."""

    def __init__(self, values):
        self.values = np.asarray(values, float)

    def __array__(self, dtype=None, copy=None):
        return self.values

    def __dask_graph__(self):
        return None


def test_table_columns_are_in_the_order_of_the_axes():
    points = [(1.0, 0, 0), (0, 2, 0)]
    for columns in (
        ["x", "y", "z"],
        ["X", "Y", "Z"],
        ["pos_x", "pos_y", "pos_z"],
        ["x_mm", "y_mm", "z_mm"],
        [0, 1, 2],
        list("abc"),
    ):
        assert np.array_equal(co.Rays(Table(points, columns), (0, 0, 1)).origins, points)
    for columns in (["z", "y", "x"], ["y_mm", "x_mm", "z_mm"], ["vz", "vx", "vy"]):
        table = Table(points, columns)
        for call in (lambda table=table: co.Rays(table, (0, 0, 1)), lambda table=table: SCENE.contains(table),
                     lambda table=table: SCENE.first_hit((0, 0, 9), table),
                     lambda table=table: co.reflect(table, (0, 0, 1))):  # fmt: skip
            with pytest.raises(ValueError, match=r"must have columns in the order x, y, z, got \['.*; table\[\['"):
                call()


def test_labelled_arrays_are_taken():
    origins = Labelled([(0, 0, 5), (9, 9, 9)])
    t = SCENE.first_hit(origins, (0, 0, -1)).t
    assert type(t) is np.ndarray
    assert t.tolist() == [4, np.inf]
    assert SCENE.contains(Labelled([(0, 0, 0)])).tolist() == [True]
    assert SCENE.lengths(origins, (0, 0, -1)).tolist() == [[2, 0], [0, 0]]
    assert SCENE.first_hit(RAYS, t_max=Labelled([1, 9])).t.tolist() == [np.inf, pytest.approx(5 - 0.99**0.5)]


@pytest.mark.parametrize("bent", [co.reflect, lambda d, n: co.refract(d, n, 0.5)[0]])
def test_reflect_and_refract_refuse_a_column_of_vectors(bent):
    """(n, 1, 3) with (n, 3) would be all pairs, and has an axis too many. A column of etas is refused in the same way."""
    column, row = VECTORS[:, None], VECTORS[None]
    for pair in (
        (column, VECTORS),
        (VECTORS, column),
        (np.stack([column] * 2), VECTORS),
        (VECTORS[None, :, None], VECTORS[None]),
    ):
        with pytest.raises(
            ValueError, match=r"directions and normals must have one shape, got .*; all pairs are .* with \(1, "
        ):
            bent(*pair)
    pairs = bent(column, row)
    assert pairs.shape == (4, 4, 3)
    for i in range(4):
        assert np.array_equal(pairs[i], bent(VECTORS[i], VECTORS))
    for single in (VECTORS[0], VECTORS[:1], VECTORS[:1, None]):
        assert np.array_equal(bent(column, single), bent(VECTORS, VECTORS[0])[:, None])
    assert np.array_equal(bent(np.stack([VECTORS] * 2), VECTORS)[1], bent(VECTORS, VECTORS))
    assert bent(column, np.ones((5, 3))).shape == (4, 5, 3)


@pytest.mark.parametrize("query", [SCENE.first_hit, SCENE.occluded, SCENE.spans, SCENE.crossings, SCENE.lengths])
@pytest.mark.parametrize("interval", ["t_min", "t_max"])
@pytest.mark.parametrize("value", [True, np.True_, np.array([True, False])])
def test_intervals_refuse_truth_values(interval, value, query):
    with pytest.raises(ValueError, match=f"{interval} must be a number .*, which is true or false$"):
        query(RAYS, **{interval: value})


def test_advice_of_messages_works(tmp_path):
    np.save(tmp_path / "rays.npy", np.concatenate([*RAYS], axis=-1))
    np.savetxt(tmp_path / "rays.csv", np.concatenate([*RAYS], axis=-1), delimiter=",")
    assert co.Rays.load(tmp_path / "rays.npy") == co.Rays.load(tmp_path / "rays.csv") == RAYS
    square = co.ct.cone([0, 90], 2, 3, 9, 9, spacing=0.5)
    assert np.array_equal(square.vectors, co.ct.cone([0, 90], 2, 3, 9, 9, spacing=(0.5, 0.5)).vectors)
    assert np.array_equal(
        co.ct.parallel3d([0], 2, 3, spacing=2).vectors, co.ct.parallel3d([0], 2, 3, spacing=(2, 2)).vectors
    )


# --- units


SCAN_MAKERS = {
    "parallel": lambda angles: co.ct.parallel(angles, 4),
    "parallel3d": lambda angles: co.ct.parallel3d(angles, 2, 4),
    "fanflat": lambda angles: co.ct.fanflat(angles, 4, 50, 50),
    "cone": lambda angles: co.ct.cone(angles, 2, 4, 50, 50),
    "helical": lambda angles: co.ct.helical(angles, 2, 4, 50, 50, 1),
    "rtk": lambda angles: co.ct.rtk(angles, 2, 4, 50, 100),
}


IN_RADIANS = [
    np.linspace(0, np.pi, 180),
    np.linspace(0, 2 * np.pi, 90, endpoint=False),
    np.deg2rad(np.arange(0, 360, 5)),
    np.arange(0, np.pi, np.pi / 64),
    [0, np.pi / 2],
    np.linspace(0, np.pi, 13).astype(np.float32),
]


IN_DEGREES = [np.linspace(0, 180, 180), np.arange(0, 360, 0.1), np.arange(12), np.linspace(0, 10, 101), [0], [],
              np.linspace(0, 3, 301), np.concatenate([[np.pi], np.arange(0, 360, 5)])]  # fmt: skip


@pytest.mark.parametrize("name", SCAN_MAKERS)
def test_ct_angles_in_radians_are_warned_of(name):
    for angles in IN_RADIANS:
        with pytest.warns(
            UserWarning,
            match=rf"^{name}: (gantry_angle|angles) must be in degrees, got .* degrees are that in radians$",
        ):
            SCAN_MAKERS[name](angles)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for angles in IN_DEGREES:
            SCAN_MAKERS[name](angles)


def test_from_astra_warns_of_degrees():
    geometry = {"type": "parallel", "DetectorCount": 4, "DetectorWidth": 1.0}
    for angles in (np.arange(0, 180, 45.0), np.linspace(0, 180, 7), np.arange(360)):
        with pytest.warns(UserWarning, match="^from_astra: ProjectionAngles must be in radians, got .* np.radians"):
            co.ct.from_astra({**geometry, "ProjectionAngles": np.asarray(angles, float)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for angles in (np.linspace(0, 8 * np.pi, 100), np.array([0.0, 1, 2, 3]), np.radians(np.arange(0, 1080, 7.0))):
            co.ct.from_astra({**geometry, "ProjectionAngles": angles})


@pytest.mark.parametrize(("call", "message"), [
    (lambda: co.Environment(PIXELS, rotation=math.pi / 2), "Environment: rotation must be in degrees, got"),
    (lambda: co.Environment(PIXELS, 1, math.radians(30)), "Environment: rotation must be in degrees, got"),
    (lambda: co.materials.ImageTexture(255 * PIXELS), "ImageTexture: most numbers of the array, up to .* are beyond 1"),
])  # fmt: skip
def test_doubtful_pixels_and_angles_are_warned_of(call, message):
    with pytest.warns(UserWarning, match=message):
        call()


def test_image_refuses_bytes_as_floats(tmp_path):
    levels = np.random.default_rng(1).integers(0, 256, (8, 8, 3))
    for dtype in (np.float32, np.float64):
        with pytest.raises(ValueError, match=r"whole numbers up to \d+ must be of uint8, sRGB bytes .*got float"):
            co.Image(levels.astype(dtype))
    with pytest.warns(
        UserWarning, match=r"Image: most numbers of the array, up to 25\d\.\d*, are beyond 1, which is white"
    ):
        co.Image(levels * 0.999)
    bright = np.random.default_rng(1).random((8, 8, 3)) ** 8 * 90  # a highlight causes no warning
    assert co.Image(bright).pixels.max() > 16
    lamp = co.Scene(co.Body(co.Box(), co.matte((1, 1, 1))), lights=[co.AmbientLight(30.0)], background=(1, 1, 1))
    assert lamp.render(8, 8, samples=1).pixels.max() == 30
    assert "NaN" in co.Image.__doc__


@pytest.mark.parametrize("make", [co.Environment, co.materials.ImageTexture])
@pytest.mark.parametrize("kind", [np.int64, np.uint16, np.float64, np.float32])
def test_environment_refuses_bytes_in_another_type(make, kind):
    board = np.arange(4 * 8 * 3).reshape(4, 8, 3).astype(kind)
    with pytest.raises(ValueError, match=r"up to 95 must be of uint8, sRGB bytes \(array.astype\('uint8'\)\)"):
        make(board)
    make(board.astype(np.uint8))
    make(np.where(board > 50, 20.0, 0.0))  # few whole numbers: a lamp, and not a picture


# --- docstrings


_NOT_FOR_USERS = re.compile(r".*_under|unbounded_support|placed")


def _public():
    """Return name and callable of every public callable: functions, classes, and their methods."""
    for name, value in PUBLIC.items():
        if not callable(value):
            continue
        if not issubclass(value, co.Hits | co.Spans | co.Crossings | Exception) if isinstance(value, type) else True:
            yield name, value
        for method in dir(value) if isinstance(value, type) else ():
            found = inspect.getattr_static(value, method)
            found = getattr(found, "__func__", found)
            if inspect.isfunction(found) and not method.startswith("_") and not _NOT_FOR_USERS.fullmatch(method):
                yield f"{name}.{method}", found


def test_docstrings_name_every_argument():
    functions = {function: name for name, function in _public() if "conicoid" in function.__module__}
    assert len(functions) > 300
    for function, name in functions.items():
        text = inspect.getdoc(function) or ""
        arguments = inspect.signature(function).parameters.keys() - {"self", "cls", "motion"}
        assert [one for one in arguments if not re.search(rf"\b{re.escape(one)}\b", text)] == [], name


NO_PART = r"^\w+: z_range must leave a part of the solid"
NO_TRUTH = r"is neither true nor false: shapes combine with & \| - ~, not with `and`"
NO_BODY = "^Body: numbers and names are no bodies: compare hits.name == body.name"
REFUSED = [
    # ellipsoid: radii beside coefficients
    *(
        (
            lambda radii=radii: co.Ellipsoid(radii=radii, coefficients=(1, 1, 1)),
            ValueError,
            "radii must be left out where coefficients are given",
        )
        for radii in ((1, 2, 3), np.array([1.0, 2.0, 3.0]))
    ),
    # one corner is no box
    *(
        (
            lambda corner=corner: co.Box(corner),
            TypeError,
            r"^Box: a box is given by two corners, Box\(low, high\), got .* Box\(\(-x/2, ",
        )
        for corner in ((0.5, 0.5, 0.5), (-1, -1, -1), np.ones(3))
    ),
    # shapes have no truth value
    (lambda: BALL and BOX, TypeError, NO_TRUTH),
    (lambda: (BALL - BOX) or BOX, TypeError, NO_TRUTH),
    (lambda: not co.Disc((0, 0, 0), (0, 0, 1), 1), TypeError, NO_TRUTH),
    (lambda: bool(~BOX), TypeError, NO_TRUTH),
    # a range that leaves nothing
    (lambda: co.Ellipsoid((1, 1, 1), z_range=(2, 3)), ValueError, NO_PART),
    (lambda: co.Ellipsoid((1, 2, 3), z_range=(3, 4)), ValueError, NO_PART),
    (lambda: co.Ellipsoid((1, 2, 3), (0, 0, 9), z_range=(-np.inf, -3)), ValueError, NO_PART),
    (lambda: co.Ellipsoid.from_coefficients(1, 1, 4, z_range=(0.5, 1)), ValueError, NO_PART),
    (lambda: co.EllipticParaboloid(1, 1, (-3, -2)), ValueError, NO_PART),
    (lambda: co.EllipticParaboloid(1, 1, (-np.inf, 0)), ValueError, NO_PART),
    (lambda: co.TwoSheetHyperboloid(1, 1, 1, (-0.5, 0.5)), ValueError, NO_PART),
    (lambda: co.TwoSheetHyperboloid(1, 1, 4, (-0.5, 0.5)), ValueError, NO_PART),
    # bodies are not compared with numbers and names
    (lambda: HITS.body == SCENE["ball"], TypeError, NO_BODY),
    (lambda: SCENE["ball"] == HITS.body, TypeError, NO_BODY),
    (lambda: HITS.name == SCENE["ball"], TypeError, NO_BODY),
    (lambda: HITS.body[0] == SCENE["ball"], TypeError, NO_BODY),
    (lambda: HITS.body != SCENE["ball"], TypeError, NO_BODY),
    # the order of arguments; modules are called
    (
        lambda: SCENE.line_integral(RAYS, [1, 2]),
        TypeError,
        "^line_integral: values come before the rays, got Rays first$",
    ),
    # errors of queries show the value
    (lambda: SCENE.first_hit(HITS), TypeError, "^first_hit: origins must be a Rays, or an array .*, got Hits alone$"),
    (lambda: SCENE.contains((0, 0, np.nan)), ValueError, "^contains: points must be finite"),
    (lambda: SCENE.first_hit(), TypeError, r"^Scene\.first_hit\(\) missing"),
    # items cannot be set
    (lambda: SCENE + co.Sphere(), TypeError, r"scene\.added\(items\)"),
    # unknown properties
    *(
        (
            lambda scene=scene: scene.line_integral("mu", LEAD_RAYS, otherwise=0),
            ValueError,
            "no material has a property 'mu'; properties: ",
        )
        for scene in (co.Scene([BALL]), co.Scene([co.Body(BALL, "red")]), LEAD_SCENE)
    ),
    (
        lambda: LEAD_SCENE.spans(LEAD_RAYS).line_integral("mu", otherwise=0),
        ValueError,
        "no material has a property 'mu'; properties: ",
    ),
    # a colour map is for numbers
    *(
        (
            lambda options=options: co.Image(np.full((2, 2, 3), 0.5), **options),
            ValueError,
            r"Image: \w+ goes with a number per pixel, got colours, \(2, 2, 3\)",
        )
        for options in (dict(vmin=0), dict(vmax=1), dict(colormap="dusk"), dict(colormap="grey"))
    ),
    # box distinguishes a number from three
    (lambda: co.Box(low=2, high=(3, 3, 3)), ValueError, "low must be 3 numbers, got the number 2$"),
    # scene items refused
    (
        lambda: co.Scene(BALL, BOX),
        TypeError,
        "^Scene: lights must be a list of .*, got Box$",
    ),
    (
        lambda: co.Scene([(BALL, "red")]),
        TypeError,
        r"items\[0\] must be a shape or a Body, got tuple$",
    ),
    # values refused
    (lambda: co.Polyhedron([(0, 0, 1)], [1, 2]), ValueError, "Polyhedron: offsets must be a list of 1 number, got 2:"),
    (
        lambda: co.Polyhedron([(0, 0, 1)], 2),
        ValueError,
        "Polyhedron: offsets must be a list of 1 number, got the number 2$",
    ),
    (
        lambda: BALL.rotate("w", 30),
        ValueError,
        "rotate: axis must be 3 numbers, or 'x', 'y', 'z', '-x', '-y', '-z', got 'w'$",
    ),
    *(
        (lambda name=name: BALL.rotate(name, 30), ValueError, "rotate: axis must be 3 numbers")
        for name in ("xy", "--x", "", "-")
    ),
    (lambda: BALL.scale("2"), ValueError, "scale: factors must be one number or 3 numbers, got '2'$"),
    (
        lambda: co.refract(np.ones((4, 3)), np.ones((4, 3)), np.ones(3)),
        ValueError,
        (
            r"refract: eta must be a number or broadcast to the "
            r"rays' shape \(4,\), got shape \(3,\)$"
        ),
    ),
    (
        lambda: co.refract(np.ones((4, 3)), np.ones((5, 3)), 1.5),
        ValueError,
        r"refract: directions and normals must .* \(4, 3\) and \(5, 3\)$",
    ),
    (lambda: SCENE.spans(RAYS, t_min="a"), ValueError, "^spans: t_min must be a number"),
    (lambda: SCENE.crossings(RAYS, t_max=np.nan), ValueError, "^crossings: t_max must not be NaN"),
    (lambda: SCENE.lengths(RAYS, t_max=[1, 2, 3]), ValueError, "^lengths: t_max must be a number or broadcast"),
    (
        lambda: SCENE.line_integral([1, 1], RAYS, t_max=[1, 2, 3]),
        ValueError,
        "^line_integral: t_max must be a number or broadcast",
    ),
    (lambda: SCENE.render(2, 2, integrator="whited"), ValueError, r"got 'whited' \(did you mean 'whitted'\?\)$"),
    (lambda: SCENE.lengths(RAYS, by="materials"), ValueError, r"got 'materials' \(did you mean 'material'\?\)$"),
    (lambda: co.Image(np.eye(2), colormap="grayy"), ValueError, r"got 'grayy' \(did you mean 'grey'\?\)$"),
    (
        lambda: co.Body(BALL, "#3366c"),
        ValueError,
        "must be three linear numbers, '#rrggbb' or a CSS colour name, got '#3366c'$",
    ),
    (lambda: co.matte("bleu"), ValueError, r"got 'bleu' \(did you mean 'blue'\?\)$"),
    # scene index refused
    (lambda: SCENE.replace(7, co.Box()), IndexError, "replace: which number must be at least 0 and below 2, got 7$"),
    # things of another kind refused
    (lambda: SCENE.lengths(RAYS, "material"), TypeError, "^lengths: directions must be left out .*, got str$"),
    (lambda: co.check([BALL]), TypeError, "^check: scene must be a Scene, a shape or a Body, got list$"),
    (lambda: co.ct.project(SCENE, [0, 1], "mu"), TypeError, r"co\.ct\.parallel\(angles, columns\)"),
    # rays name the bad ray
    (lambda: co.Rays((0, 0, 5), (0, 0, np.nan)), ValueError, r"got \(0\.0, 0\.0, nan\)$"),
    (lambda: co.Rays((0, 0, 5), [(0, 0, 1), (0, 0, np.nan)]), ValueError, r"got \(0\.0, 0\.0, nan\) for ray\[1\]$"),
    # section refuses an equation
    (lambda: SCENE.section("z=0"), ValueError, "plane must be 'x', 'y', 'z' or .*, got 'z=0'$"),
    # pictures streams and options refused
    (lambda: LEAD_SCENE.replace("ball"), TypeError, "^replace: item must be a shape or a Body, got None$"),
    (lambda: LEAD_SCENE.rays(-1, 48), ValueError, "^rays: width must be a whole number of pixels >= 1, got -1"),
    (lambda: CAMERA.rays(3, 0), ValueError, "^rays: height must be"),
    (lambda: CAMERA.project((0, 0, 0), 0, 1), ValueError, "^project: width must be"),
    (lambda: LEAD_SCENE.render(0, 4), ValueError, "^render: width must be"),
    (lambda: LEAD_SCENE.section("z", 0, width=0), ValueError, "^section: width must be"),
    (lambda: co.turntable(LEAD_SCENE, "x.gif", width=0), ValueError, "^turntable: width must be"),
    (lambda: co.Rays.from_camera(CAMERA, 0, 1), ValueError, "^rays: width must be"),
    (lambda: IMAGE.layers["body"], KeyError, r"rendered without 'body': scene.render\(layers=\['body'\]\) has it"),
    (lambda: IMAGE.layers["color"], KeyError, "no layer is called 'color': those are albedo, normal, depth"),
    (lambda: co.Image(PIXELS).layers["depth"], KeyError, "rendered without 'depth'"),
    (lambda: IMAGE * 2, TypeError, r"Image: pictures are no numbers: co.Image\(2 \* image.pixels\)"),
    (lambda: 0.5 * IMAGE, TypeError, "Image: pictures are no numbers"),
    (lambda: IMAGE - IMAGE, TypeError, "Image: pictures are no numbers"),
    (
        lambda: co.Spheres([(0, 0, 0)], [1]).single(3),
        IndexError,
        "Spheres.single: index must be at least 0 and below 1, got 3",
    ),
    (
        lambda: co.Boxes([(0, 0, 0)], [(1, 1, 1)]).single(-1),
        IndexError,
        "Boxes.single: index must be at least 0 and below 1",
    ),
    (
        lambda: co.Spheres([(0, 0, 0)], [1]).single("a"),
        TypeError,
        "Spheres.single: index must be a whole number, got 'a'",
    ),
    (
        lambda: next(LEAD_SCENE.stream(LEAD_RAYS, "line_integral", values="mu")),
        ValueError,
        "^line_integral: values: no property 'mu'",
    ),
    (lambda: LEAD_SCENE.stream(*LEAD_RAYS), ValueError, "^stream: query must be one of first_hit, .*, got array"),
    (lambda: next(LEAD_SCENE.stream(CAMERA)), TypeError, "^stream: rays must be Rays, arrays or .*, got Camera$"),
    (
        lambda: LEAD_SCENE.render(8, 6, progress=lambda done: None),
        TypeError,
        r"^render: progress must be called as progress\(done, count\); got the function <lambda>, which",
    ),
    (
        lambda: LEAD_SCENE.render(8, 6, preview=lambda image, more: None),
        TypeError,
        r"must be called as preview\(image\)",
    ),
    (lambda: co.measure(BALL - co.Box(), progress=lambda: None), TypeError, r"^measure: progress must be called as"),
    (
        lambda: LEAD_SCENE.render(8, 6, camera="front"),
        TypeError,
        "camera must be a Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None",
    ),
    (lambda: co.Scene([BALL], background=3), TypeError, "background must be a colour, a Sky, an Environment or None"),
    (lambda: co.Quadric({"xx": 1}), ValueError, r"Quadric\(coefficients=\{...\}\) takes it"),
    # view height refused
    (lambda: co.Scene(co.Sphere()).view(height="big"), ValueError, "view: height must be an integer >= 1, got 'big'"),
    # numbers refused
    (lambda: co.ct.cone([0], 2, 2, 9, 9, spacing=(1, 2, 3)), ValueError, "^cone: spacing must be 2 numbers"),
    (
        lambda: co.ct.parallel([0, np.nan], 3),
        ValueError,
        r"^parallel: angles must be finite numbers of shape \(views,\), got nan$",
    ),
    (
        lambda: SCENE.line_integral({"ball": 1}, RAYS),
        ValueError,
        "no material is called 'ball'; materials: 'steel'$",
    ),
    (lambda: co.Plane("z", 1), ValueError, r"got 'z'; that axis is \(0, 0, 1\)$"),
    (lambda: co.HalfSpace("-Y", 1), ValueError, r"that axis is \(0, -1, 0\)$"),
    (lambda: RAYS.save("rays.npy"), ValueError, r"np\.save\(path, np\.concatenate"),
    (lambda: RAYS.save("rays.csv"), ValueError, r"np\.savetxt\(path"),
    # cauchy coefficients are a list
    (
        lambda: co.optics.Cauchy(1.5),
        ValueError,
        r"^Cauchy: coefficients must be a list of one number or more, got 1.5$",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED)
def test_invalid_arguments_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
