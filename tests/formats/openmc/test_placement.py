"""Placement of OpenMC's cells: motions, omitted cells, narrowed cells."""

import itertools
import re
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid._util.records import FloatArray
from conicoid.geometry.transform import IDENTITY_MOTION
from conicoid.io import openmc
from conicoid.io.openmc.placement import (
    CellRotation,
    Extent,
    Point,
    rotation_by_angles,
    rotation_by_matrix,
    to_floats,
)
from conicoid.io.openmc.region import Conjunction, PartIntersection, PartUnion, RegionPart, SurfaceSide
from conicoid.io.openmc.surfaces import ConeSurface, FlatSurface, RoundSurface
from conicoid.io.openmc.universe_block import _carry_extent
from conicoid.numerics import bigfloat as ex

from ...samples import deeper, sampled
from .broken import geometry
from .evaluator import rotation_matrix
from .models import NAMES, geometry_file, model_file

# --- Turns, rotations and placements, against plain matrices


def point(*numbers: float) -> Point:
    x, y, z = (Fraction(n) for n in numbers)
    return x, y, z


def carried(rotation: CellRotation, p: Point) -> FloatArray:
    """Return the image of a point under a rotation."""
    if rotation.motion.is_identity:
        return np.array(to_floats(rotation.turn.apply(p)))
    return rotation.motion.matrix[:3] @ [*to_floats(p), 1.0]


@pytest.mark.parametrize(
    "angles", [*itertools.product((-90, 0, 90, 180), repeat=3), (10, 20, 30), (0, 0, -7.5), (90, 0, 33), (400, 720, 90)]
)
def test_angles_turn_the_contents_so_that_the_lookup_turns_back(angles: tuple[float, ...]) -> None:
    rotation = rotation_by_angles(point(*angles))
    p = point(0.25, -1.5, 2.0)
    assert rotation_matrix(list(angles)) @ carried(rotation, p) == pytest.approx(to_floats(p), abs=1e-15 * 20)


@pytest.mark.parametrize("angles", list(itertools.product((0, 90, 180, 270), repeat=3)))
def test_right_angles_are_exact_also_as_a_matrix(angles: tuple[float, ...]) -> None:
    rotation = rotation_by_angles(point(*angles))
    assert rotation.motion.is_identity
    rows = np.rint(rotation_matrix(list(angles))).astype(int).tolist()
    assert rotation_by_matrix(tuple(point(*row) for row in rows)) == rotation


# --- Cells without volume are omitted, with a remark for each kind


@pytest.mark.parametrize("twice", ["1 -1", "-2 2", "3 -3", "4 -4", "5 -5", "4 -6", "-4 -7"])
def test_both_sides_of_a_surface_are_nothing(twice: str, tmp_path: Path) -> None:
    """The test takes each kind of surface, the same plane by other numbers, and parallel planes."""
    surfaces = (
        '<surface id="3" type="z-cone" coeffs="0 0 0 1"/>', '<surface id="4" type="plane" coeffs="1 -2 0.5 3"/>',
        '<surface id="5" type="quadric" coeffs="1 2 3 1 0 0 0 0 0 -1"/>', '<surface id="6" type="plane" coeffs="0.2 -0.4 0.1 0.6"/>',
        '<surface id="7" type="plane" coeffs="-2 4 -1 -6.5"/>',
    )  # fmt: skip
    text = geometry(
        *surfaces, f'<cell id="1" material="1" region="{twice}"/>', '<cell id="2" material="2" region="-2"/>'
    )
    imported = openmc.read(geometry_file(text, tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 2"]
    assert "cell 1: has no volume in its only place, left out there" in imported.notes


def test_slanted_planes_that_leave_a_slab_stay(tmp_path: Path) -> None:
    """4: x + y > 1; 6: -2 x - 2 y > -3, that is x + y < 1.5; 7: x + y < 0.9."""
    surfaces = [
        f'<surface id="{i}" type="plane" coeffs="{c}"/>'
        for i, c in ((4, "1 1 0 1"), (6, "-2 -2 0 -3"), (7, "1 1 0 0.9"))
    ]
    cells = (
        '<cell id="1" material="1" region="-2 4 6"/>',
        '<cell id="2" material="1" region="-2 4 -7"/>',
        '<cell id="3" material="1" region="-2 -7 6"/>',
    )
    imported = openmc.read(geometry_file(geometry(*surfaces, *cells), tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 1", "cell 3"]


def check_cells_made_empty(name: str, folder: Path, step: int) -> None:
    """Cut cells in turn down to nothing: none leaves a body, and a note says so."""
    text = model_file(name, folder).read_text(encoding="utf-8")
    cells = re.findall(r'<cell id="(\d+)"[^>]*region="', text)
    surface = re.findall(r'<surface id="(\d+)"', text)[0]
    path = folder / "model.xml"
    for number in cells[::step]:
        spoilt = re.sub(rf'(<cell id="{number}"[^>]*region=")([^"]*)', rf"\g<1>(\g<2>) {surface} -{surface}", text)
        path.write_text(spoilt, encoding="utf-8")
        imported = openmc.read(path)
        assert not [body for body in imported.bodies if (body.name or "").split()[1] == number]
        assert any(
            re.match(rf"cell {number}\b.*: has no volume in (its only|any of its)", note) for note in imported.notes
        )


@pytest.mark.parametrize(
    ("name", "step"), [("kinds", 3), ("nested", 3), ("pin", 3), *deeper((name, 1) for name in NAMES)]
)
def test_an_emptied_cell_is_reported(name: str, step: int, tmp_path: Path) -> None:
    check_cells_made_empty(name, tmp_path, step)


def test_elements_beyond_the_surrounding_cell_are_reported(tmp_path: Path) -> None:
    """A ball of radius 1 about the corner of a lattice of 3 x 3 elements of size 1: it meets only that element."""
    text = geometry(
        '<cell id="1" universe="1" material="1"/>',
        f'<lattice id="4" name="grid" dimension="3 3" lower_left="0 0" pitch="1 1" universes="{"1 " * 9}"/>',
        '<cell id="2" fill="4" region="-2"/>',
    )
    imported = openmc.read(geometry_file(text, tmp_path))
    assert [body.name for body in imported.bodies] == ["cell 1 @ cell 2, lattice 4 [0, 0]"]
    assert "in 8 of 9 elements of lattice 4 'grid' nothing lies in the cell around it, left out" in imported.notes


def test_notes_of_a_kind_are_not_endless(tmp_path: Path) -> None:
    cells = [f'<cell id="{i}" material="1 2" region="2 -2"/>' for i in range(1, 101)]
    notes = openmc.read(geometry_file(geometry(*cells), tmp_path)).notes
    assert "0 bodies; 100 places without volume left out" in notes
    shown = sum(note.startswith("cell") and "has no volume" in note for note in notes)
    assert 10 <= shown <= 20  # a screen
    assert notes.count(f"... and {100 - shown} more like this") == 2
    assert len(notes) < 50


# --- The omission of redundant sides changes no point's answer

ZERO, ONE = Fraction(0), Fraction(1)


def quarter(random: np.random.Generator, reach: int = 8) -> Fraction:
    return Fraction(int(random.integers(-reach, reach + 1)), 4)


def side(random: np.random.Generator) -> SurfaceSide:
    """Return any kind of side, on a grid of quarters so that coincidences are common."""
    x, y, z = (quarter(random) for _ in range(3))
    kind, positive = random.integers(8), bool(random.integers(2))
    if kind < 3:
        return SurfaceSide(FlatSurface(tuple(ONE * int(i == kind) for i in range(3)), x), positive)  # type: ignore[arg-type]
    if kind == 3:
        return SurfaceSide(FlatSurface((ONE, quarter(random, 2), -ONE), x), positive)
    if kind == 4:
        return SurfaceSide(ConeSurface(2, (x, y, z), ONE), positive)
    axis = None if kind == 5 else int(random.integers(3))
    center = tuple(ZERO if i == axis else c for i, c in enumerate((x, y, z)))
    return SurfaceSide(RoundSurface(axis, center, quarter(random, 6) + Fraction(7, 4)), positive)  # type: ignore[arg-type]


def part(random: np.random.Generator, depth: int) -> RegionPart:
    if depth == 0 or random.random() < 0.6:
        return side(random)
    pieces = tuple(part(random, depth - 1) for _ in range(random.integers(2, 4)))
    return PartUnion(pieces) if random.random() < 0.6 else PartIntersection(pieces)


def inside(item: RegionPart, points: np.ndarray) -> np.ndarray:
    if isinstance(item, SurfaceSide):
        surface = item.surface
        if isinstance(surface, FlatSurface):
            values = points @ [float(n) for n in surface.normal] - float(surface.offset)
        elif isinstance(surface, RoundSurface):
            own = points - [float(c) for c in surface.center]
            values = (own[:, list(surface.cross_axes)] ** 2).sum(axis=1) - float(surface.radius) ** 2
        else:
            assert isinstance(surface, ConeSurface)
            own = points - [float(c) for c in surface.apex]
            values = own[:, 0] ** 2 + own[:, 1] ** 2 - float(surface.square) * own[:, 2] ** 2
        return values > 0 if item.positive else values < 0
    parts = [inside(piece, points) for piece in item.parts]
    return np.all(parts, axis=0) if isinstance(item, PartIntersection) else np.any(parts, axis=0)


@pytest.mark.parametrize("seed", sampled(range(150), 4))
def test_the_remainder_is_equal_in_one_step_or_many(seed: int) -> None:
    """The remainder is taken at once and step by step, as in a hierarchy, at points on no surface."""
    random = np.random.default_rng(seed)
    parts = [part(random, 2) for _ in range(random.integers(1, 9))]
    points = random.uniform(-4, 4, (4000, 3))
    points = np.concatenate([points, random.uniform(-1, 1, (2000, 3))])
    expected = inside(PartIntersection(tuple(parts)), points)
    at_once = Conjunction().and_(parts)
    stepwise: Conjunction | None = Conjunction()
    for item in parts:
        stepwise = None if stepwise is None else stepwise.and_([item])
    for found in (at_once, stepwise):
        if found is None:
            assert not expected.any()
            continue
        answer = inside(PartIntersection(found.parts), points) if found.parts else np.ones(len(points), bool)
        assert (answer == expected).all()
        for i in range(3):
            low, high = found.extent.low[i], found.extent.high[i]
            assert low is None or (points[expected, i] >= float(low)).all()
            assert high is None or (points[expected, i] <= float(high)).all()


def cylinder(radius: str, x: str = "0", axis: int | None = 2) -> RoundSurface:
    return RoundSurface(axis, (Fraction(x), ZERO, ZERO), Fraction(radius))


def planes(axis: int, low: str, high: str) -> list[SurfaceSide]:
    normal = tuple(ONE * int(i == axis) for i in range(3))
    return [
        SurfaceSide(FlatSurface(normal, Fraction(low)), True),
        SurfaceSide(FlatSurface(normal, Fraction(high)), False),
    ]  # type: ignore[arg-type]


def remaining_parts(*parts: RegionPart) -> set[tuple[object, bool]] | None:
    found = Conjunction().and_(parts)
    return None if found is None else {(s.surface, s.positive) for s in found.parts if isinstance(s, SurfaceSide)}


def test_a_vessel_around_an_element_vanishes_and_one_that_cuts_it_stays() -> None:
    walls = [*planes(0, "-1", "1"), *planes(1, "-1", "1")]
    assert len(remaining_parts(*walls, SurfaceSide(cylinder("1.5"), False)) or ()) == 4
    assert len(remaining_parts(*walls, SurfaceSide(cylinder("1.4"), False)) or ()) == 5
    assert remaining_parts(*walls, SurfaceSide(cylinder("1.5"), True)) is None
    assert remaining_parts(*walls, SurfaceSide(cylinder("0.5", "1.6"), False)) is None
    assert len(remaining_parts(*walls, SurfaceSide(cylinder("0.5", "1.6"), True)) or ()) == 4


def test_round_solids_beside_planes_are_as_fractions_say() -> None:
    """Floats decide far from a plane, and fractions where it touches."""
    random = np.random.default_rng(7)
    touching = 0
    for _ in range(3000):
        solid, plane = side(random).surface, side(random).surface
        if not isinstance(solid, RoundSurface) or not isinstance(plane, FlatSurface):
            continue
        height = sum((n * c for n, c in zip(plane.normal, solid.center, strict=True)), -plane.offset)
        reach = solid.radius**2 * sum(n * n for n in plane.normal)
        beside = height**2 > reach and not (solid.axis is not None and plane.normal[solid.axis])
        touching += height**2 == reach
        assert solid.side_of_plane(plane) == (0 if not beside else 1 if height > 0 else -1)
    assert touching > 10


# --- Turned places: boxes around them are never too narrow, and omitted bodies are counted


@pytest.mark.parametrize("far", [1e2, 1e6, 1e8, 1e10, 1e12])
def test_boxes_carried_between_turns_hold_their_corners(far: float) -> None:
    """The shifts of both motions cancel. Corners are carried in 3000 bits."""
    outer = IDENTITY_MOTION.rotate((1, 2, 3), 20).translate((far, 0.3 * far, -0.7 * far))
    inner = IDENTITY_MOTION.rotate("z", 30).translate((0.1, 0.2, 0.3)).then(outer)
    low, high = (Fraction(-1), Fraction(-2), Fraction(-3)), (Fraction(1), Fraction(1), Fraction(2))
    box = _carry_extent(Extent(low, high), inner, outer)
    rows, shift = inner.affine
    back, back_shift = outer.inverse
    for corner in product(*zip(low, high, strict=True)):
        there = ex.plus(ex.apply(rows, ex.exact_row(corner)), shift)
        for place, a, b in zip(ex.plus(ex.apply(back, there), back_shift), box.low, box.high, strict=True):
            assert a is not None
            assert b is not None
            assert ex.exact(a) <= place <= ex.exact(b)


def test_bounds_of_turned_places_hold_every_body(tmp_path: Path) -> None:
    """Along the anti-diagonal shifts cancel along an axis of the world, but rounding depends on their length."""
    count, x, y = 12, 4 / 7, 3 / 7
    universes = " ".join("1" if i + j == count - 1 else "2" for i in range(count) for j in range(count))
    text = f"""<geometry><surface id="1" type="sphere" coeffs="0 0 0 0.001"/>
<cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="void" region="1"/>
<cell id="3" universe="2" material="void"/>
<lattice id="4" dimension="{count} {count}" pitch="{x} {y}" lower_left="{-6 * x} {-6 * y}" universes="{universes}"/>
<cell id="5" universe="5" fill="4"/><cell id="6" fill="5" rotation="0.8 -0.6 0 0.6 0.8 0 0 0 1"/></geometry>"""
    scene = co.load_openmc(geometry_file(text, tmp_path), void=False)
    low, high = scene.bounds
    bounds = np.array([body.shape.bounds for body in scene.bodies])
    assert len(bounds) == count
    assert (low <= bounds[:, 0]).all()
    assert (high >= bounds[:, 1]).all()
