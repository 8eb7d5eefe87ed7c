"""Numbers that are taken for something else: tables, axes too many, angles in the other unit, truth values."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import conicoid as co

SCENE = co.Scene([co.Body(co.Sphere(), co.matte("red", name="steel"), "ball"), co.Box((2, 2, 2), (3, 3, 3))])
RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))
VECTORS = np.array([(1.0, 2, 3), (1, 0, 0), (0, 0, -2), (0.5, 1, 1)])


class Table:
    """What a DataFrame is to those who ask for an array: columns with names."""

    def __init__(self, values, columns):
        self.values, self.columns = np.asarray(values, float), columns

    def __array__(self, dtype=None, copy=None):
        return self.values if dtype is None else self.values.astype(dtype)


class Labelled:
    """An array with names of axes, as xarray's: it may be of Dask's, and has no graph where it is not."""

    def __init__(self, values):
        self.values = np.asarray(values, float)

    def __array__(self, dtype=None, copy=None):
        return self.values

    def __dask_graph__(self):
        return None


def test_columns_are_in_the_order_of_the_axes():
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
                     lambda table=table: SCENE.first_hit((0, 0, 9), table), lambda table=table: co.reflect(table, (0, 0, 1))):  # fmt: skip
            with pytest.raises(ValueError, match=r"must have columns in the order x, y, z, got \['.*; table\[\['"):
                call()


def test_labelled_arrays_are_no_lazy_ones():
    origins = Labelled([(0, 0, 5), (9, 9, 9)])
    t = SCENE.first_hit(origins, (0, 0, -1)).t
    assert type(t) is np.ndarray
    assert t.tolist() == [4, np.inf]
    assert SCENE.contains(Labelled([(0, 0, 0)])).tolist() == [True]
    assert SCENE.lengths(origins, (0, 0, -1)).tolist() == [[2, 0], [0, 0]]
    assert SCENE.first_hit(RAYS, t_max=Labelled([1, 9])).t.tolist() == [np.inf, pytest.approx(5 - 0.99**0.5)]


@pytest.mark.parametrize("bent", [co.reflect, lambda d, n: co.refract(d, n, 0.5)[0]])
def test_a_column_of_vectors_is_no_list_of_them(bent):
    """(n, 1, 3) with (n, 3) would be all pairs, and is an axis too many: as a column of etas is refused."""
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


@pytest.mark.parametrize("interval", ["t_min", "t_max"])
@pytest.mark.parametrize("value", [True, np.True_, np.array([True, False])])
def test_truth_values_are_no_distances(interval, value):
    for query in (SCENE.first_hit, SCENE.occluded, SCENE.spans, SCENE.crossings, SCENE.lengths):
        with pytest.raises(ValueError, match=f"{interval} must be a number .*, which is true or false$"):
            query(RAYS, **{interval: value})


SCANS = {
    "parallel": lambda angles: co.ct.parallel(angles, 4), "parallel3d": lambda angles: co.ct.parallel3d(angles, 2, 4),
    "fanflat": lambda angles: co.ct.fanflat(angles, 4, 50, 50), "cone": lambda angles: co.ct.cone(angles, 2, 4, 50, 50),
    "helical": lambda angles: co.ct.helical(angles, 2, 4, 50, 50, 1), "rtk": lambda angles: co.ct.rtk(angles, 2, 4, 50, 100),
}  # fmt: skip
IN_RADIANS = [np.linspace(0, np.pi, 180), np.linspace(0, 2 * np.pi, 90, endpoint=False), np.deg2rad(np.arange(0, 360, 5)),
              np.arange(0, np.pi, np.pi / 64), [0, np.pi / 2], np.linspace(0, np.pi, 13).astype(np.float32)]  # fmt: skip
IN_DEGREES = [np.linspace(0, 180, 180), np.arange(0, 360, 0.1), np.arange(12), np.linspace(0, 10, 101), [0], [],
              np.linspace(0, 3, 301), np.concatenate([[np.pi], np.arange(0, 360, 5)])]  # fmt: skip


@pytest.mark.parametrize("name", SCANS)
def test_scans_in_radians_are_warned_of(name):
    for angles in IN_RADIANS:
        with pytest.warns(
            UserWarning,
            match=rf"^{name}: (gantry_angle|angles) must be in degrees, got .* degrees are that in radians$",
        ):
            SCANS[name](angles)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for angles in IN_DEGREES:
            SCANS[name](angles)


def test_angles_of_astra_in_degrees_are_warned_of():
    given = {"type": "parallel", "DetectorCount": 4, "DetectorWidth": 1.0}
    for angles in (np.arange(0, 180, 45.0), np.linspace(0, 180, 7), np.arange(360)):
        with pytest.warns(UserWarning, match="^from_astra: ProjectionAngles must be in radians, got .* np.radians"):
            co.ct.from_astra({**given, "ProjectionAngles": np.asarray(angles, float)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for angles in (np.linspace(0, 8 * np.pi, 100), np.array([0.0, 1, 2, 3]), np.radians(np.arange(0, 1080, 7.0))):
            co.ct.from_astra({**given, "ProjectionAngles": angles})


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.ct.cone([0], 2, 2, 9, 9, spacing=(1, 2, 3)), "^cone: spacing must be 2 numbers"),
    (lambda: co.ct.parallel([0, np.nan], 3), r"^parallel: angles must be finite numbers of shape \(views,\), got nan$"),
    (lambda: co.ct.parallel(180, 3), r"np\.linspace\(0, 180, views, endpoint=False\)$"),
    (lambda: SCENE.first_hit(np.zeros((5, 6)), (0, 0, 1)), r"two arrays, a\[\.\.\., :3\] and a\[\.\.\., 3:\]$"),
    (lambda: SCENE.first_hit(np.zeros((3, 5)), (0, 0, 1)), r"its transpose, \.T, has shape \(5, 3\)$"),
    (lambda: SCENE.line_integral(0.5, RAYS), r"one number for all is np\.full\(2, \.\.\.\)$"),
    (lambda: SCENE.line_integral({"ball": 1}, RAYS), "values by body are an array in the order of their numbers$"),
    (lambda: co.Plane("z", 1), r"got 'z'; that axis is \(0, 0, 1\)$"), (lambda: co.HalfSpace("-Y", 1), r"that axis is \(0, -1, 0\)$"),
    (lambda: RAYS.save("rays.npy"), r"np\.save\(path, np\.concatenate"), (lambda: RAYS.save("rays.csv"), r"np\.savetxt\(path"),
    (lambda: co.Image("a.png"), r"PIL\.Image\.open\(path\)"),
])  # fmt: skip
def test_numbers_that_do_not_fit(call, told):
    with pytest.raises(ValueError, match=told):
        call()


def test_what_messages_advise_works(tmp_path):
    np.save(tmp_path / "rays.npy", np.concatenate([*RAYS], axis=-1))
    np.savetxt(tmp_path / "rays.csv", np.concatenate([*RAYS], axis=-1), delimiter=",")
    assert co.Rays.load(tmp_path / "rays.npy") == co.Rays.load(tmp_path / "rays.csv") == RAYS
    both = np.concatenate([*RAYS], axis=-1)
    assert SCENE.first_hit(both[..., :3], both[..., 3:]) == SCENE.first_hit(RAYS)
    square = co.ct.cone([0, 90], 2, 3, 9, 9, spacing=0.5)
    assert np.array_equal(square.vectors, co.ct.cone([0, 90], 2, 3, 9, 9, spacing=(0.5, 0.5)).vectors)
    assert np.array_equal(
        co.ct.parallel3d([0], 2, 3, spacing=2).vectors, co.ct.parallel3d([0], 2, 3, spacing=(2, 2)).vectors
    )
