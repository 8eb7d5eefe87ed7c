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


WITHIN = (
    lambda box: co.HyperbolicCylinder(1, 1, box), lambda box: co.ParabolicCylinder(0.25, box),
    lambda box: co.HyperbolicParaboloid(1, 1, box),
)  # fmt: skip


@pytest.mark.parametrize("make", WITHIN)
def test_within_keeps_its_box(make):
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
