"""Many bodies in one entry: the same, to the bit, as the single shapes written out one after the other."""

import pickle
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.lowering import lower

from ..tables import assert_same_columns

COUNT = 24
MOTIONS = {
    "still": lambda shape: shape,
    "moved": lambda shape: shape.translate((1, 2, 0.3)),
    "turned": lambda shape: shape.translate((3, -1, 2)).rotate((1, 2, -1), 50),
    "sheared": lambda shape: shape.scale((-1, 2, 0.5)).transform(
        [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 5], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
    ),
}


def many(count: int = COUNT) -> dict[str, Any]:
    """Return one of each kind. Half of the numbers are small integers, so that walls coincide."""
    rng = np.random.default_rng(20261122)
    even = np.arange(count) % 2 == 0

    def points() -> Any:
        return np.where(even[:, None], rng.integers(-2, 3, (count, 3)), rng.uniform(-5, 5, (count, 3)))

    def sizes(*shape: int) -> Any:
        drawn = rng.uniform(0.1, 1, (count, *shape))
        return np.where(even.reshape(count, *[1] * len(shape)), np.ceil(2 * drawn), drawn)

    lows, starts, step = points(), points(), np.where(even[:, None], (0, 0, 2), (1, -1, 0.5))
    return {
        "Spheres": co.Spheres(points(), sizes()),
        "Cylinders": co.Cylinders(starts, starts + step, sizes()),
        "Capsules": co.Capsules(starts, starts + step, sizes()),
        "Cones": co.Cones(starts, starts + step, sizes(), sizes() - 0.1),
        "Ellipsoids": co.Ellipsoids(points(), sizes(3)),
        "Boxes": co.Boxes(lows, lows + sizes(3)),
        "Discs": co.Discs(points(), np.where(even[:, None], (0, 0, 1), points() + 0.1), sizes()),
        "Triangles": co.Triangles(
            starts, starts + (1, 0, 0), starts + np.where(even[:, None], (0, 1, 0), (0.3, 1, 0.2))
        ),
    }


MANY = many()
OTHERS = [name for name in MANY if name != "Spheres"]


def singles(shape: Any) -> list[Any]:
    return [shape.single(index) for index in range(len(shape))]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", OTHERS)
def test_tables_are_those_of_the_list(name: str, motion: str) -> None:
    shape = MOTIONS[motion](MANY[name])
    floor = co.Body(co.HalfSpace((0, 0, 1), -1))  # some share its wall
    together, apart = lower([floor, co.Body(shape), floor]), lower([floor, *map(co.Body, singles(shape)), floor])
    assert_same_columns(together, apart, {"body_item"})
    assert together.body_item.tolist() == [0, *[1] * COUNT, 2]
    for surface in range(0, len(together.exact), 7):
        assert together.exact[surface].key() == apart.exact[surface].key()


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", OTHERS)
def test_the_box_is_that_around_all(name: str, motion: str) -> None:
    shape = MOTIONS[motion](MANY[name])
    boxes = np.array([one.bounds for one in singles(shape)])
    assert np.array_equal(shape.bounds, (boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)))


@pytest.mark.parametrize("name", OTHERS)
def test_answers_are_those_of_the_list(name: str) -> None:
    shape = MANY[name]
    rng = np.random.default_rng(1)
    rays = co.Rays(rng.uniform(-5, 5, (600, 3)), rng.normal(size=(600, 3)))
    one, other = co.Scene([shape]), co.Scene(singles(shape))
    assert len(one) == len(other) == COUNT
    assert one[3].shape == other[3].shape
    hits, theirs = one.first_hit(rays), other.first_hit(rays)
    for field in ("t", "body", "face", "surface", "point", "normal", "uv", "entering"):
        assert np.array_equal(getattr(hits, field), getattr(theirs, field), equal_nan=True), field
    assert (hits.body >= 0).sum() > 15
    spans, others = one.spans(rays), other.spans(rays)
    for field in ("offsets", "t_enter", "t_exit", "body"):
        assert np.array_equal(getattr(spans, field), getattr(others, field)), field
    points = rng.uniform(-3, 3, (600, 3))
    assert np.array_equal(one.body_at(points), other.body_at(points))


@pytest.mark.parametrize("count", [0, 1, 3])
@pytest.mark.parametrize("name", OTHERS)
def test_few(name: str, count: int) -> None:
    """Entries have no body, or fewer than a recording needs."""
    shape = type(MANY[name]).of_table(MANY[name].table()[:count])
    assert len(shape) == count
    assert_same_columns(lower([co.Body(shape)]), lower([*map(co.Body, singles(shape))]), {"body_item"})
    low, high = shape.bounds
    assert (low <= high).all() if count else (low > high).all()


@pytest.mark.parametrize("name", MANY)
def test_values(name: str, tmp_path: Any) -> None:
    """Bulk bodies are equal, and come back from pickles and files, with arrays inline, beside the scene, in .npz."""
    shape = MANY[name].rotate("z", 20)
    assert shape == pickle.loads(pickle.dumps(shape)) != MANY[name]
    assert hash(shape) == hash(pickle.loads(pickle.dumps(shape)))
    large = type(shape).of_table(np.tile(shape.table(), (5, 1))).rotate("z", 20)
    scene = co.Scene([co.Body(shape, name="few"), co.Body(large, "red")])
    co.save(scene, tmp_path / "scene.yaml")
    (file,) = tmp_path.glob("scene-*.npy")
    assert np.load(file).shape == (5 * COUNT, len(shape.headings()))
    assert co.load(tmp_path / "scene.yaml") == scene
    np.savez(tmp_path / "many.npz", **{field: getattr(shape, field) for field in shape.columns})
    (tmp_path / "other.yaml").write_text(f"bodies: [{{shape: {{{name}: {{file: many.npz}}}}}}]")
    assert co.load(tmp_path / "other.yaml") == co.Scene([MANY[name]])


def test_a_number_or_a_vector_for_all() -> None:
    starts, ends = [(0, 0, 0), (4, 0, 0)], [(0, 0, 1), (4, 0, 1)]
    assert co.Cylinders(starts, ends, 0.5) == co.Cylinders(starts, ends, [0.5, 0.5])
    assert co.Discs(starts, (0, 0, 1), 0.5) == co.Discs(starts, [(0, 0, 1)] * 2, [0.5, 0.5])
    assert len(co.Boxes((0, 0, 0), (1, 1, 1))) == 1


def test_a_mesh_is_its_triangles() -> None:
    vertices, faces = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)], [(0, 1, 2), (0, 2, 3)]
    a, b, c = (np.array(vertices, float)[np.array(faces)[:, k]] for k in range(3))
    assert co.Triangles.of_mesh(vertices, faces) == co.Triangles(a, b, c)
    with pytest.raises(ValueError, match=r"^Triangles: faces\[1\] must be at least 0 and below 4, got \(0, 2, 4\)$"):
        co.Triangles.of_mesh(vertices, [(0, 1, 2), (0, 2, 4)])


THREE = np.zeros((3, 3))
UP = THREE + (0, 0, 1)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: co.Cylinders(THREE, UP, [1, -1, 1]), r"Cylinders: radii\[1\] must be > 0, got -1.0"),
    (lambda: co.Cylinders(THREE, THREE, 1), r"Cylinders: ends\[0\] must be another point than its start, got \[0"),
    (lambda: co.Cylinders(THREE, UP[:2], 1), r"Cylinders: arrays must be of equally many bodies, got starts of 3, ends of 2"),
    (lambda: co.Capsules(THREE, UP, np.nan), r"Capsules: radii\[0\] must be finite, got nan"),
    (lambda: co.Cones(THREE, UP, 0, [1, 0, 1]), r"Cones: end_radii\[1\] must be > 0 where start_radii is 0, got 0.0"),
    (lambda: co.Ellipsoids(THREE, [(1, 1, 1), (1, 0, 1), (1, 1, 1)]), r"Ellipsoids: radii\[1\] must be > 0, got \[1. 0. 1.\]"),
    (lambda: co.Boxes(THREE, (1, 0, 1)), r"Boxes: highs\[0\] must be > lows\[0\] = \(0.0, 0.0, 0.0\) in each component, got \(1"),
    (lambda: co.Discs(THREE, [(0, 0, 1), (0, 0, 0), (1, 0, 0)], 1), r"Discs: normals\[1\] must be another vector than zero"),
    (lambda: co.Triangles(THREE, UP, 3 * UP), r"Triangles: a\[0\], b\[0\], c\[0\] must not lie on a line, got \(0"),
    (lambda: co.Triangles(THREE, UP, np.zeros((3, 2))), r"Triangles: c must have shape \(N, 3\), or be 3 numbers for all, got shape \(3, 2\)"),
    (lambda: co.Boxes(THREE, [(1, 1, 1), (1, 1, 1e-200), (1, 1, 1)]), r"Boxes: highs\[1\] must be 0 or of magnitude 1e-100 to 1e100"),
    (lambda: co.Boxes("low", 1), r"Boxes: lows must be an array of numbers, got 'low'"),
])  # fmt: skip
def test_refusals(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        make()


@pytest.mark.parametrize("name", MANY)
def test_they_are_entries_and_do_not_combine(name: str) -> None:
    shape = MANY[name]
    for combine in (lambda: shape | co.Box(), lambda: shape & co.Box(), lambda: shape - co.Box(), lambda: ~shape,
                    lambda: co.Box() | shape, lambda: co.Box() - shape, lambda: co.Plane((0, 0, 1), 0) & shape):  # fmt: skip
        with pytest.raises(TypeError):
            combine()


@pytest.mark.parametrize("name", ["Boxes", "Discs"])
def test_measures_and_checks(name: str) -> None:
    """The boxes stand apart, so that their union is all of them."""
    places = 10.0 * np.arange(5)[:, None] * (1, 0, 0)
    shape = co.Boxes(places, places + (1, 2, 3)) if name == "Boxes" else co.Discs(places, (0, 0, 1), 2)
    found = co.measure(shape)
    assert found.area == pytest.approx(5 * 22 if name == "Boxes" else 5 * np.pi * 4, rel=1e-12)
    assert found.volume == pytest.approx(30 if name == "Boxes" else 0, abs=1e-12)
    one, other = co.Scene([shape]), co.Scene(singles(shape))
    assert [str(finding) for finding in co.check(one)] == [str(finding) for finding in co.check(other)]
