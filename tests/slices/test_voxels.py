"""Voxels: shares sum to closed volumes within their bounds, and each is the mean of dense points in it."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import conicoid as co

BALL, BOX = co.Sphere(), co.Box((-1, -1, -1), (1, 1, 1))
Box = tuple[tuple[float, ...], tuple[float, ...]]
WINDOW = (-1.25, -1.3, -1.2), (1.2, 1.25, 1.35)
DRUM = co.Cylinder((0, 0, -1), (0, 0, 1), 0.5)
CLOSED = {
    "ball": (BALL, 4 / 3 * math.pi),
    "box": (BOX, 8.0),
    "turned box": (BOX.scale(0.6).rotate((1, 2, 3), 30), 8 * 0.6**3),
    "drum": (DRUM, math.pi / 2),
    "oblique drum": (DRUM.rotate((1, 2, 0), 40), math.pi / 2),
    "cone": (co.Cone((0, 0, -1), (0, 0, 1), 1, 0.5), math.pi * 2 / 3 * (1 + 0.5 + 0.25)),
    "ellipsoid": (co.Ellipsoid((1, 0.5, 0.75)).rotate((0, 1, 1), 25), 4 / 3 * math.pi * 0.375),
    "bowl": (co.EllipticParaboloid(1, 1, (0, 1)), math.pi / 2),
    # π h r² (1 + h² / 12 r²): x² + y² <= 1/4 + z² / 4 from -1 to 1 is π ∫ (1 + z²) / 4
    "cooling tower": (co.OneSheetHyperboloid(4, 4, 1, (-1, 1)), math.pi * (2 + 2 / 3) / 4),
    "bored box": (BOX - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5), 8 - math.pi / 2),
    "bored across": (BOX - co.Cylinder((-2, 0.1, 0), (2, 0.1, 0), 0.5), 8 - math.pi / 2),
    "steinmetz": (co.Cylinder((-2, 0, 0), (2, 0, 0), 1) & co.Cylinder((0, -2, 0), (0, 2, 0), 1), 16 / 3),
    # Two balls about (±1/2, 0, 0): caps of the height h = 1/2, π h² (3 - h) / 3 each
    "lens": (co.Sphere(1, (-0.5, 0, 0)) & co.Sphere(1, (0.5, 0, 0)), 2 * math.pi * 0.25 * 2.5 / 3),
    "hollow": (BALL - co.Sphere(0.8), 4 / 3 * math.pi * (1 - 0.8**3)),
    "all but a ball": (~BALL, 2.45 * 2.55 * 2.55 - 4 / 3 * math.pi),
    "union": (BOX.scale(0.5) | co.Box((0, 0, 0), (1, 1, 1)), 1 + 1 - 0.125),
}


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("name", CLOSED)
def test_shares_sum_to_closed_volumes(name: str, axis):
    shape, volume = CLOSED[name]
    scene = co.Scene([shape])
    wide = scene.voxels(WINDOW, (12, 13, 14), fractions="body", axis=axis, samples=2)
    fine = scene.voxels(WINDOW, (12, 13, 14), fractions="body", axis=axis, samples=6)
    for voxels, least in ((wide, 1.0), (fine, 0.35)):
        (found,), (off,) = voxels.volumes()
        assert abs(found - volume) <= off <= least * max(volume, 1.7)
        assert voxels.fractions.min() >= 0
        assert voxels.fractions.max() <= 1 + 1e-12
    assert (np.abs(wide.fractions - fine.fractions) <= wide.bounds + fine.bounds).all()
    assert fine.bounds.sum() < 0.6 * wide.bounds.sum() + 1e-12


@pytest.mark.parametrize("name", ["turned box", "cone", "bored across", "steinmetz", "hollow", "lens"])
def test_every_share_is_that_of_dense_points(name: str):
    scene = co.Scene([CLOSED[name][0]])
    shares = scene.voxels(WINDOW, (5, 6, 7), fractions="body", samples=8)
    dense = scene.voxels(WINDOW, (5 * 24, 6 * 24, 7 * 24)).body.reshape(5, 24, 6, 24, 7, 24)
    counted = (dense == 0).mean(axis=(1, 3, 5))
    # A wall changes at most about a layer of points, of 24 of them; and half of these on each side
    assert (np.abs(shares.fractions[0] - counted) <= shares.bounds[0] + 2.5 / 24).all()
    sure = (shares.bounds[0] == 0) | (shares.bounds[0] < 1e-12)
    whole = sure & (np.isin(shares.fractions[0], (0, 1)))
    assert whole.sum() > 20
    assert (shares.fractions[0][whole] == counted[whole]).all()


def _around(count: int, middle: tuple[float, float, float], half: float, holes: float) -> tuple[co.Solid, list[Box]]:
    """Return a box less `count` small ones, and these: more leaves than bodies without trees have."""
    corners = [np.array((11.0 * (k % 4), 11.0 * (k // 4), 0.0)) + middle for k in range(count)]
    boxes = [(tuple((at - holes).tolist()), tuple((at + holes).tolist())) for at in corners]
    solid: co.Solid = co.Box(*(tuple((np.array(middle) + sign * half).tolist()) for sign in (-1, 1)))
    for low, high in boxes:
        solid = solid - co.Box(low, high)
    return solid, boxes


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("samples", [1, 2, 3])
def test_bounds_hold_of_bodies_of_many_parts(axis, samples: int):
    """Boxes less fourteen boxes each are compared with these boxes' overlaps with each voxel."""
    solids, holes = zip(*(_around(14, middle, 100, 5.0) for middle in ((0, 0, 0), (3.5, -7.25, 1.125))), strict=True)
    window, shape = ((-100.0, -100.0, -25.0), (100.0, 100.0, 25.0)), (6, 6, 2)
    found = co.Scene(list(solids)).voxels(window, shape, fractions="body", axis=axis, samples=samples)
    edges = [np.linspace(window[0][k], window[1][k], shape[k] + 1) for k in range(3)]

    def overlaps(low: tuple[float, ...], high: tuple[float, ...]) -> np.ndarray:
        shares = [
            np.clip(np.minimum(edge[1:], end) - np.maximum(edge[:-1], begin), 0, None) / np.diff(edge)
            for edge, begin, end in zip(edges, low, high, strict=True)
        ]
        return np.einsum("i,j,k->ijk", *shares)

    for number, (middle, boxes) in enumerate(zip(((0, 0, 0), (3.5, -7.25, 1.125)), holes, strict=True)):
        low, high = (np.array(middle) + sign * 100 for sign in (-1, 1))
        exact = overlaps(tuple(low), tuple(high)) - sum(overlaps(*box) for box in boxes)
        off = np.abs(found.fractions[number] - exact)
        assert (off <= found.bounds[number] + 1e-12).all()
        assert (off > found.bounds[number] / 1000).any()  # the middle of a column does not represent all of it


def test_prisms_along_the_rays_are_exact_but_for_rounding():
    # A wedge of boxes whose walls lie between voxels, and ends that do not.
    scene = co.Scene([co.Box((-0.5, -0.25, -0.3), (0.5, 0.75, 0.7)), co.Box((0, -1, -1), (1, 1, 1))])
    voxels = scene.voxels(((-1, -1, -1), (1, 1, 1)), (8, 8, 5), fractions="body", samples=1)
    found, off = voxels.volumes()
    assert found == pytest.approx([1 * 1 * 1, 1 * 2 * 2], rel=1e-14)
    assert (off < 1e-11).all()
    # z from -0.3: the voxel [-0.6, -0.2] holds a quarter of its height
    assert voxels.fractions[0, 4, 4].tolist() == pytest.approx([0, 0.25, 1, 1, 0.25], rel=1e-14)


def test_materials_and_overlaps():
    steel, air = co.matte("#808080", name="steel"), co.matte("#ffffff", name="air")
    scene = co.Scene([co.Body(BOX, steel), co.Body(BOX.translate((1, 0, 0)), steel), co.Body(BALL, air)])
    voxels = scene.voxels(((-1, -1, -1), (2, 1, 1)), (6, 4, 4), fractions="material")
    assert voxels.names == ("steel", "air")
    (steel_volume, air_volume), _ = voxels.volumes()
    assert steel_volume == pytest.approx(16, rel=1e-13)  # the overlap of two bodies counts twice
    assert abs(air_volume - 4 / 3 * math.pi) <= voxels.volumes()[1][1]


def test_ids_are_those_of_the_centres():
    scene = co.Scene(
        [co.Body(BALL, co.matte("red")), co.Body(BOX, co.matte("blue")), co.Body(BOX.scale(2), co.matte("red"))]
    )
    voxels = scene.voxels(((-2, -2, -2), (2.5, 2.5, 2)), (9, 9, 8))
    x, y, z = voxels.centers
    assert x.tolist() == [-1.75 + 0.5 * k for k in range(9)]
    assert z[-1] == 1.75
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
    inside = [(places**2).sum(axis=-1) <= 1, (np.abs(places) <= 1).all(axis=-1), (np.abs(places) <= 2).all(axis=-1)]
    expected = np.select(inside, [0, 1, 2], -1)
    assert (voxels.body == expected).all()
    assert (voxels.material == np.array([0, 1, 0, -1])[expected]).all()
    assert co.Scene([]).voxels(WINDOW, 4).body.max() == -1


def test_parts_computed_by_workers_are_equal_to_the_bit():
    scene = co.Scene([CLOSED["bored across"][0], co.Body(BALL, name="ball")])
    calls = []
    here = scene.voxels(WINDOW, 20, fractions="body", progress=lambda done, count: calls.append((done, count)))
    with ThreadPoolExecutor(2) as executor:
        there = scene.voxels(WINDOW, 20, fractions="body", executor=executor)
    assert (here.fractions == there.fractions).all()
    assert (here.bounds == there.bounds).all()
    assert calls[-1][0] == calls[-1][1]
    assert here.names == ("body 0", "ball")


@pytest.mark.parametrize(("call", "message"), [
    *((lambda options=options: co.Scene([BALL]).voxels(**options), message) for options, message in (
        (dict(bounds=(0, 1)), "bounds"), (dict(bounds=((0, 0, 0), (1, 1, 0))), "low below high"), (dict(shape=0), "shape must be"),
        (dict(shape=(1, 2)), "shape must be"), (dict(shape=(1 << 20, 1 << 20, 1)), "GiB"), (dict(fractions="bodies"), "did you mean 'body'"),
        (dict(samples=0), "samples must be"), (dict(axis="w"), "axis must be one of x, y, z"))),
    (lambda: co.Scene([co.HalfSpace((0, 0, 1), 0)]).voxels(), "bounds must be given"),
    (lambda: co.Scene([BALL]).voxels(shape=2).volumes(), "no fractions"),
])  # fmt: skip
def test_invalid_voxels_are_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
