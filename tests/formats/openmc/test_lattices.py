"""OpenMC's lattices and whole models, against an evaluator."""

import functools
import itertools
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import conicoid as co
from conicoid._util.records import FloatArray
from conicoid.geometry.transform import IDENTITY_MOTION
from conicoid.io.openmc.expansion import ElementRoom
from conicoid.io.openmc.lattices import (
    HexagonalLattice,
    Lattice,
    LatticePrism,
    RectangularLattice,
    hexagon_order,
    read_hexagonal_lattice,
    read_rectangular_lattice,
)
from conicoid.io.openmc.placement import Extent, UniversePlacement
from conicoid.io.openmc.region import SurfaceSide
from conicoid.io.openmc.surfaces import RoundSurface
from conicoid.io.openmc.universe_block import PlaceBounds
from conicoid.io.xml_tree import XmlElement
from conicoid.render.camera import fit_extent

from ...samples import deep, marked
from .evaluator import Evaluator, same_place
from .models import NAMES, load_model, model_file

# --- Lattices: the order of their universes, their elements without gaps, and their common region


def rectangular(shape: str = "2 3") -> RectangularLattice:
    count = int(np.prod([int(n) for n in shape.split()]))
    pitch = "1.26 1.5 2"[: 2 * len(shape) + 2].strip() if len(shape) < 5 else "1.26 1.5 2"
    low = "-1 0.2 -3" if len(shape) == 5 else "-1 0.2"
    numbers = " ".join(map(str, range(count)))
    pitch = " ".join(pitch.split()[: len(shape.split())])
    attributes = {"id": "1", "dimension": shape, "lower_left": low, "pitch": pitch, "universes": numbers}
    return read_rectangular_lattice(XmlElement("lattice", 1, 1, attributes))


def hexagonal(rings: int, orientation: str, levels: int | None = None) -> HexagonalLattice:
    count = (3 * rings * (rings - 1) + 1) * (levels or 1)
    attributes = {
        "id": "1",
        "n_rings": str(rings),
        "orientation": orientation,
        "universes": " ".join(map(str, range(count))),
    }
    if levels is None:
        attributes |= {"center": "0.3 -0.1", "pitch": "1.1"}
    else:
        attributes |= {"center": "0.3 -0.1 0.2", "pitch": "1.1 0.7", "n_axial": str(levels)}
    return read_hexagonal_lattice(XmlElement("hex_lattice", 1, 1, attributes))


def test_clear_elements() -> None:
    """Of 5 x 5 squares in a box of their size the rim touches it, and the others are clear.

    In the box of one element none is clear, and without a box all are. The farthest corners of the middle element, its
    neighbours and the next are at 0.71, 1.58 and 2.12 from the center.
    """
    lattice = read_rectangular_lattice(
        XmlElement("lattice", 1, 1, dict(id="1", dimension="5 5", lower_left="0 0", pitch="1 1", universes="1 " * 25))
    )
    place = UniversePlacement()
    center = Fraction(5, 2), Fraction(5, 2), Fraction(0)
    rods = [SurfaceSide(RoundSurface(2, center, Fraction(radius)), radius < 1) for radius in (2, 3, Fraction(2, 5))]
    around = [(lattice.hull[0].sides(), 9), (lattice.prism((2, 2)).sides(), 0)]
    around += [([*lattice.hull[0].sides(), rod], count) for rod, count in zip(rods, (5, 9, 8), strict=True)]
    for sides, count in around:
        room = ElementRoom.of(lattice, place, PlaceBounds().and_(IDENTITY_MOTION, sides) or PlaceBounds())
        assert room is not None
        assert sum(room.has(lattice.center(index)) for index in lattice.universes) == count
    free = ElementRoom.of(lattice, place, PlaceBounds())
    assert free is not None
    assert all(free.has(lattice.center(index)) for index in lattice.universes)


LATTICES: list[Lattice] = [
    rectangular(), rectangular("2 3 2"), hexagonal(1, "y"), hexagonal(2, "x"), hexagonal(3, "y"), hexagonal(4, "x", 3),
    hexagonal(1, "x", 2),
]  # fmt: skip


def inside(prism: LatticePrism, points: np.ndarray) -> np.ndarray:
    rows = [points @ [float(n) for n in normal] - float(offset) for normal, offset in prism.planes]
    return np.all(np.array(rows) < 0, axis=0)


def around(lattice: Lattice, random: np.random.Generator, count: int) -> np.ndarray:
    corners = np.array([[float(c) for c in lattice.center(index)] for index in lattice.universes])
    return random.uniform(corners.min(axis=0) - 2, corners.max(axis=0) + 2, (count, 3))


def test_rectangular_universes_are_listed_from_the_top_row() -> None:
    assert rectangular().universes == {(0, 2): 0, (1, 2): 1, (0, 1): 2, (1, 1): 3, (0, 0): 4, (1, 0): 5}
    deep = rectangular("2 3 2").universes
    assert (deep[0, 2, 0], deep[1, 0, 0], deep[0, 2, 1], deep[1, 0, 1]) == (0, 5, 6, 11)


def test_hexagonal_universes_are_listed_as_in_the_documentation() -> None:
    """OpenMC's documentation has this example, with its marked element in the middle of the fifth row.

    Rows hold 1, 2, 3, 2, 3, 2, 3, 2, 1 elements.
    """
    lattice = hexagonal(3, "y")
    rows: dict[float, list[float]] = {}
    for index in lattice.universes:
        x, y, _ = lattice.center(index)
        rows.setdefault(round(float(y), 9), []).append(float(x))
    assert [len(row) for row in rows.values()] == [1, 2, 3, 2, 3, 2, 3, 2, 1]
    assert list(rows) == sorted(rows, reverse=True)
    assert all(row == sorted(row) for row in rows.values())
    assert list(lattice.universes)[9] == (0, 0)
    turned = [0] * 5
    for i, j in hexagon_order(3, "x"):
        turned[2 - j] += 1
        assert abs(i + j) < 3
    assert turned == [3, 4, 5, 4, 3]


@pytest.mark.parametrize("lattice", LATTICES, ids=str)
def test_the_hull_covers_the_elements_and_no_more(lattice: Lattice) -> None:
    points = around(lattice, np.random.default_rng(2), 20_000)
    elements = np.any([inside(lattice.prism(index), points) for index in lattice.universes], axis=0)
    hull = np.any([inside(prism, points) for prism in lattice.hull], axis=0)
    assert (elements == hull).all()


@pytest.mark.parametrize("lattice", LATTICES, ids=str)
def test_neighbours_share_their_planes(lattice: Lattice) -> None:
    """Planes are equal to the last digit, so that the wall between two elements is one surface."""
    found: dict[tuple[object, ...], int] = {}
    for index in lattice.universes:
        for normal, offset in lattice.prism(index).planes:
            sign = 1 if next(n for n in normal if n) > 0 else -1
            key = (*(sign * n for n in normal), sign * offset)
            found[key] = found.get(key, 0) + 1
    floats = {tuple(float(v) for v in key) for key in found}  # type: ignore[arg-type]
    values = sorted(floats)
    close = [
        (a, b) for a, b in itertools.pairwise(values)
        if a[:3] == b[:3] and a[3] != b[3] and abs(a[3] - b[3]) < 1e-6
    ]  # fmt: skip
    assert not close
    assert len(floats) == len(found)


@pytest.mark.parametrize("lattice", LATTICES, ids=str)
def test_no_end_of_elements_where_a_box_has_none(lattice: Lattice) -> None:
    zero, one = Fraction(0), Fraction(1)
    assert lattice.tiles_around(Extent((zero, None, zero), (one, one, one))) is None
    flat = Extent((zero, zero, None), (one, one, None))
    assert (lattice.tiles_around(flat) is None) == (len(next(iter(lattice.universes))) == 3)


@pytest.mark.parametrize("lattice", LATTICES, ids=str)
def test_elements_around_a_box_are_those_that_reach_into_it(lattice: Lattice) -> None:
    """In the box of a lattice of boxes these are its own elements, without those that only touch it.

    Of hexagons they are a few more.
    """
    zero = Fraction(0)
    whole = functools.reduce(Extent.union, (prism.extent for prism in lattice.hull))
    tiles = lattice.tiles_around(whole)
    assert tiles is not None
    found = list(tiles.indices)
    assert len(found) == len(set(found)) <= tiles.count
    assert set(lattice.universes) <= set(found)
    assert isinstance(lattice, HexagonalLattice) or set(lattice.universes) == set(found)
    assert {len(index) for index in found} == {len(next(iter(lattice.universes)))}
    # Far from there: the elements in which points of a box lie
    far = Extent((Fraction(6), Fraction(7), zero), (Fraction(9), Fraction(11), Fraction(2)))
    tiles = lattice.tiles_around(far)
    assert tiles is not None
    prisms = [lattice.prism(index) for index in tiles.indices]
    assert not any(prism.extent.common(far).is_empty for prism in prisms)
    points = np.random.default_rng(3).uniform((6, 7, 0), (9, 11, 2), (500, 3))
    assert np.any([inside(prism, points) for prism in prisms], axis=0).all()


# --- Whole geometries: every point is in the cell of OpenMC's rules, and chords have the lengths of the cells

BOXES = {"assembly": ((-10.8, -10.8, -22.0), (10.8, 10.8, 402.0)), "kinds": ((-3.1, -3.1, -3.1), (3.1, 3.1, 3.1))}


def box(name: str, scene: co.Scene) -> tuple[FloatArray, FloatArray]:
    """Return a box around the geometry with a margin."""
    low, high = BOXES.get(name, fit_extent(np.array([body.shape.bounds for body in scene.bodies]).reshape(-1, 6)))
    margin = 0.02 * (np.array(high) - low)
    return low - margin, high + margin


def grid(low: FloatArray, high: FloatArray, count: int) -> FloatArray:
    """Return points (count³, 3) that lie on no surface, at odd fractions of a step."""
    step = (high - low) / count
    axes = [a + (np.arange(count) + f) * s for a, s, f in zip(low, step, (0.4871, 0.5113, 0.4937), strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


class Model(NamedTuple):
    """A geometry as the importer reads it, and the places of OpenMC's rules."""

    name: str
    scene: co.Scene
    evaluator: Evaluator


@pytest.fixture(scope="module", params=marked((name, name != "assembly") for name in NAMES))
def model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Return a model that is read and prepared once for all tests."""
    path = model_file(request.param, tmp_path_factory.mktemp("model"))
    return Model(request.param, load_model(path), Evaluator(path))


def compare(model: Model, count: int) -> None:
    name, scene, evaluator = model
    points = grid(*box(name, scene), count)
    bodies = scene.body_at(points)
    wrong = [
        f"{points[i].tolist()}: {place} but in {scene.bodies[body].name if body >= 0 else None!r}"
        for i, (place, body) in enumerate(zip(evaluator.find(points), bodies.tolist(), strict=True))
        if not same_place(place, scene.bodies[body].name if body >= 0 else None)
    ]
    assert not wrong, f"{len(wrong)} of {len(points)} points, such as {wrong[0]}"
    assert len(set(bodies.tolist())) > min(4, len(scene.bodies)) / 2


@pytest.mark.parametrize("count", [10, deep(50)])
def test_every_point_is_in_the_cell_that_the_rules_give(model: Model, count: int) -> None:
    compare(model, count)


def test_the_scene_is_an_ordinary_one(model: Model, tmp_path: Path) -> None:
    """The scene saves, and loads as an equal one."""
    co.save(model.scene, tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == model.scene


@pytest.mark.parametrize("orientation", ["x", "y"])
def test_beside_corners_of_hexagons_rounded_walls_decide(orientation: str, tmp_path: Path) -> None:
    """Three walls should meet there, but leave gaps and overlaps of 1e-16.

    A point is in no body or in the first of the list, and so are spans.
    """
    path = tmp_path / "geometry.xml"
    path.write_text(f"""<geometry><cell id="1" universe="1" material="1"/><cell id="2" fill="5" region="-3"/>
        <hex_lattice id="5" n_rings="2" orientation="{orientation}" center="-3.3 7.77"><pitch>3.3333</pitch>
        <universes>{"1 " * 7}</universes></hex_lattice>
        <surface id="3" type="z-cylinder" coeffs="-3.3 7.77 4.9" boundary="vacuum"/></geometry>""")
    scene, random = co.load_openmc(path), np.random.default_rng(7)
    parts = [(body.shape,) if isinstance(body.shape, co.Polyhedron) else body.shape.operands for body in scene.bodies]
    solids = [next(part for part in each if isinstance(part, co.Polyhedron)) for each in parts]
    walls = [list(zip(solid.normals, solid.offsets, strict=True)) for solid in solids]
    # Corners of the middle element: 0, 60, ... degrees from those of the walls of the other orientation
    angles = np.radians(np.arange(6) * 60 + (30 if orientation == "x" else 0))
    corners = np.column_stack([np.cos(angles), np.sin(angles), angles * 0]) * 3.3333 / 3**0.5 + (-3.3, 7.77, 0)
    points = np.repeat(corners, 60, axis=0) * (1 + random.integers(-9, 10, (360, 3)) * 2.0**-53)

    def heights(body: int, point: list[float]) -> list[Fraction]:
        """Return the heights of a point over the walls of a body, exactly."""
        rows = [(map(Fraction, normal), Fraction(offset)) for normal, offset in walls[body]]
        return [sum(n * Fraction(x) for n, x in zip(normal, point, strict=True)) - offset for normal, offset in rows]

    sides = [[heights(body, point) for body in range(7)] for point in points.tolist()]
    off_walls = np.array([all(map(all, each)) for each in sides])
    inside = [[k for k in range(7) if max(each[k]) < 0] for each in itertools.compress(sides, off_walls)]
    points = points[off_walls]
    assert scene.body_at(points).tolist() == [bodies[0] if bodies else -1 for bodies in inside]
    spans = scene.spans(points - (0, 0, 1), (0, 0, 1), t_max=2)
    at = np.split(spans.body, spans.offsets[1:-1])
    assert [sorted(bodies.tolist()) for bodies in at] == inside
    # Of "y" no wall misses the others here
    assert ([] in inside) == (orientation == "x")
