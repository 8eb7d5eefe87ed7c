"""Walls that coincide under a turn that they have in common are one, as their exact names say; without these names."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.shape import Solid
from conicoid.kernels.tables import PLANE
from conicoid.prepare import body_collector as contents
from conicoid.prepare.body_collector import ExactBodySurfaces, exact_surface
from conicoid.prepare.lower_shape import lower_shape
from conicoid.prepare.lowering import lower


def at_an_angle(shape: Solid) -> Solid:
    return shape.rotate("z", 30).rotate((1, 2, 3), 20)


def walls() -> list[co.Body]:
    """Boxes, balls and pipes at an angle that share walls, with each other and with what is moved otherwise."""
    shapes: list[Solid] = []
    for i in range(6):
        for j in range(4):
            own = co.Box((i, j, 0), (i + 1, j + 1, 1)) if j % 2 else co.Box((0, 0, 0), (1, 1, 1)).translate((i, j, 0))
            shapes.append(at_an_angle(own))
    shapes += [(co.Sphere(0.3, (i, 0.5, 2)) & co.HalfSpace((0, 1, 1), 2.5)).rotate("x", 12) for i in range(8)]
    shapes += [
        (co.Cylinder((0, 0, 5), (0, 0, 6 + k), 1.5) - co.Sphere(0.5, (0, 0, 5))).rotate("x", 12) for k in range(8)
    ]
    shapes.append(at_an_angle(co.Box((math.nextafter(1.0, 2.0), 3.5, 4), (2, 4, 5))))
    shapes.append(at_an_angle(co.Box((1, 3.5, 7), (2, 4, 8))))
    shapes.append(co.Box((-1, -4, 9), (2, 4, 10)).rotate("z", 10).rotate("z", 20).rotate((1, 2, 3), 20))
    shapes.append(at_an_angle(co.Box((0, 0, 0), (6, 4, 1))))
    return [co.Body(shape, "red") for shape in shapes]


@pytest.fixture
def named(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The surfaces whose exact names are asked for."""
    found: list[int] = []
    name = ExactBodySurfaces.name

    def watched(self: ExactBodySurfaces, index: int) -> object:
        found.append(index)
        return name(self, index)

    monkeypatch.setattr(ExactBodySurfaces, "name", watched)
    return found


def test_tables_are_those_of_exact_names(named: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    found = lower(walls())
    few = len(named)
    monkeypatch.setattr(contents, "FEWEST_SURFACES", 10**9)
    expected = lower(walls())
    assert 0 < few < (len(named) - few) / 3
    for field, mine, its in zip(found.tables._fields, found.tables, expected.tables, strict=True):
        assert mine.tobytes() == its.tobytes(), field


def test_walls_an_ulp_apart_are_two() -> None:
    bodies = walls()
    tables = lower(bodies).tables
    near, at = (
        set(tables.plane_surface[tables.cell_first[cell] : tables.cell_first[cell + 1]].tolist())
        for cell in tables.entry_index[[len(bodies) - 4, len(bodies) - 3]].tolist()
    )
    assert len(near & at) == 3  # x = 2, y = 3.5 and y = 4, but not x = 1


def test_single_surfaces_are_those_of_the_whole_body() -> None:
    shapes = [body.shape for body in walls()]
    shapes.append(co.Union(tuple(shapes[::5])).translate((0.1, 0.2, 0.3)) - shapes[1])
    shapes.append(co.Box((-9, -9, -9), (9, 9, 9)) - shapes[-1].rotate("y", 3))
    for shape in shapes:
        count = len(lower_shape(shape).exact)
        shape.cache.pop("part")
        alone = [exact_surface(shape, number).key() for number in range(count)]
        assert "part" not in shape.cache
        assert alone == [surface.key() for surface in lower_shape(shape).exact]


def test_crystals_of_modules_are_prepared_without_a_name_for_each(named: list[int]) -> None:
    """Five modules of 10 × 5 crystals: 2 × 10 planes across each, 2 × 5 along, and two that all have in common."""
    crystal = co.Box((-0.45, -0.45, -0.5), (0.45, 0.45, 0.5))
    bodies = [
        co.Body(crystal.translate((10 + i, j, 0)).rotate("z", angle), "red")
        for angle in np.linspace(7, 307, 5) for i in range(10) for j in range(5)
    ]  # fmt: skip
    assert (lower(bodies).tables.surface_kind == PLANE).sum() == 5 * (20 + 10) + 2
    assert len(named) < 20


def test_volumes_cut_from_another_share_its_walls_without_exact_names(named: list[int]) -> None:
    """As detectors are written: 40 turned frustums, and the block that they are cut from."""
    rng = np.random.default_rng(3)
    places = np.stack(np.meshgrid(np.arange(5), np.arange(8), indexing="ij"), axis=-1).reshape(-1, 2) * 6.0

    def frustum(place: np.ndarray, radii: np.ndarray, axis: np.ndarray) -> Solid:
        own = co.Cone((0, 0, 0), (0, 0, 1), *radii.tolist())
        return own.rotate(axis.tolist(), 33).translate((*place.tolist(), 0))

    numbers = list(zip(places, rng.uniform(0.5, 1.5, (40, 2)), rng.normal(size=(40, 3)), strict=True))
    block: Solid = co.Box((-9, -9, -9), (60, 60, 9))
    world = co.Difference((block, *(frustum(*each) for each in numbers)))
    scene = co.Scene([world, *(frustum(*each) for each in numbers)])
    centers = np.column_stack([places, np.zeros(40)])
    spans = scene.crossings(centers - (0, 0, 20), np.broadcast_to((0.01, 0.02, 1.0), (40, 3)))
    assert not named
    inner = spans.surface[(spans.point[:, 2] > -8.9) & (spans.point[:, 2] < 8.9)]
    assert len(inner) >= 80
    # Each wall is met by the frustum and by the block: two crossings of one surface
    assert (np.unique(inner, return_counts=True)[1] % 2 == 0).all()


def slanted_cells(factor: float) -> list[co.Body]:
    """As files list cells: 60 slanted planes, each of a solid on one side and, times a factor, of a gap on the other."""
    rng = np.random.default_rng(5)
    bodies: list[co.Body] = []
    for normal, offset in zip(rng.normal(size=(60, 3)).tolist(), rng.uniform(0.5, 2, 60).tolist(), strict=True):
        bodies.append(co.Body(co.Box((-3, -3, -3), (3, 3, 3)) & co.HalfSpace(normal, offset)))
        rows = [[-factor * x for x in normal], (1, 0, 0), (0, 1, 1)]
        bodies.append(co.Body(co.Polyhedron(rows, [-factor * offset, 4, 5]) - co.Sphere(0.1)))
    return bodies


@pytest.mark.parametrize(("factor", "names"), [(1.0, 0), (2.0, 0), (3.0, 120)])
def test_half_spaces_have_exact_names_only_where_their_numbers_differ(factor, names, named, monkeypatch) -> None:
    found = lower(slanted_cells(factor))
    few = len(named)
    assert few == names
    monkeypatch.setattr(contents, "FEWEST_SURFACES", 10**9)
    expected = lower(slanted_cells(factor))
    assert len(named) - few >= 120
    for field, mine, its in zip(found.tables._fields, found.tables, expected.tables, strict=True):
        assert mine.tobytes() == its.tobytes(), field


@pytest.mark.parametrize("count", [1, 10])
@pytest.mark.parametrize("size", [1e61, 1e8])
def test_flat_solids_whose_planes_floats_do_not_fit(size, count):
    """Corners beyond 1e60, and a wall 1e-7 thin at 1e8: such solids are lowered whole, alone and among others."""
    thin = ((1e8, 0.0), (1e8 + 1, 0.0), (1e8 + 1, 1e-7), (1e8, 1e-7))
    huge = tuple((size * x, size * y) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)))
    outline, at = (huge, (1.0, 1.0)) if size > 1e60 else (thin, (1e8 + 0.5, 5e-8))
    scene = co.Scene([co.Extrusion(outline, (k, k + 1)) for k in range(count)])
    assert scene.first_hit((*at, -5), (0, 0, 1)).t == pytest.approx(5, rel=1e-12)
    assert scene.body_at((*at, count - 0.5)) == count - 1
