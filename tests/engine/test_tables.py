"""The tables of a scene: rows, maps, limits and bytes of bodies that are lowered alone and together."""

import math
import pickle
import random
from typing import Any

import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import PINS, core_xml
from conicoid.kernels.bvh.walk import ROWS
from conicoid.kernels.surface.doubt import FAR, KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES, RELATIVE
from conicoid.prepare import batch_lowering as together_module, lowering
from conicoid.prepare.error_limits import with_limits
from conicoid.prepare.lowering import lower
from conicoid.prepare.pattern import RowTable, row_blocks
from conicoid.prepare.tape import recordings

from ..samples import drawn
from ..tables import assert_same_columns
from .tapes.test_recorded import KINDS, MOTIONS, SOLIDS

# --- Scenes whose bodies are lowered together have the tables of scenes whose bodies are lowered one by one, to the bit


def solids_of(rng: random.Random) -> list[Any]:
    """Return shapes of two or three kinds, enough to be lowered together, in no order."""
    shapes: list[Any] = []
    for _ in range(rng.randint(2, 3)):
        kind, motion = rng.choice(list(KINDS)), MOTIONS[rng.choice(list(MOTIONS))]
        shared = motion(rng)
        for _ in range(rng.randint(6, 14)):
            move = shared if rng.random() < 0.5 else motion(rng)
            shapes.append(move(KINDS[kind](rng)))
    if rng.random() < 0.5:
        built = SOLIDS[rng.choice(list(SOLIDS))]
        kinds = [rng.choice(("Sphere on a grid", "Box on a grid", "upright Cylinder", "Ellipsoid")) for _ in range(3)]
        shapes += [built(rng, *(KINDS[kind](rng) for kind in kinds)).rotate("z", 90) for _ in range(8)]
    shapes += [rng.choice(shapes).translate((1.0, 0.0, -2.0)) for _ in range(3)]
    rng.shuffle(shapes)
    return shapes


def assert_same_tables(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    together = lower_all(solids_of(random.Random(seed)))
    with monkeypatch.context() as patched:
        patched.setattr(recordings, "FEWEST", 10**9)
        patched.setattr(together_module, "_FEWEST_OF_PLAN", 10**9)
        assert_same_columns(lower_all(solids_of(random.Random(seed))), together)


def lower_all(shapes: list[Any]) -> Any:
    return lowering.lower([co.Body(shape) for shape in shapes]).limited()


@pytest.mark.parametrize("seed", range(12))
def test_tables_are_the_same_to_the_bit(seed, monkeypatch):
    assert_same_tables(seed, monkeypatch)


@pytest.mark.parametrize("seed", range(12, 18))
def test_tables_of_bodies_in_blocks_are_the_same_to_the_bit(seed, monkeypatch):
    """Each block has as many bodies as a recording needs, and the last one too few."""
    monkeypatch.setattr(together_module, "_AT_ONCE", recordings.FEWEST // 2 + seed % 5)
    assert_same_tables(seed, monkeypatch)


@pytest.mark.deep
def test_tables_of_more_scenes_are_the_same_to_the_bit(monkeypatch):
    for seed in drawn(range(18, 10_000), 100):
        assert_same_tables(seed, monkeypatch)


# --- Rows of different numbers equal the rows written out, by every access


RNG = np.random.default_rng(5)


def some_rows(bodies, width, different):
    """Return (rows, the same written out)."""
    values, columns = RNG.normal(size=(bodies, different)), RNG.integers(0, different, width).astype(np.int32)
    return RowTable.of(values, columns), values[:, columns]


def every_answer(rows, whole):
    """Return pairs of found and expected values."""
    some, mask = np.array([3, 0, 5]), np.arange(len(whole)) % 3 == 1
    for a, b in ((0, whole.shape[1]), (2, 5), (4, 4), (-5, -2), (None, 7), (6, None), (0, 0)):
        for index in (slice(None), slice(1, 4), slice(0, 0), some, mask):
            yield rows[index, a:b], whole[index, a:b]
            yield rows[index][:, a:b], whole[index][:, a:b]
    for column in (0, 7, -1):
        yield rows[:, column], whole[:, column]


@pytest.mark.parametrize("seed", range(5))
def test_rows_are_those_written_out(seed):
    a, b, c = (some_rows(9, width, different) for width, different in ((12, 5), (8, 8), (6, 1)))
    parts = [(a, 3, 9), (b, 0, 8), (a, 0, 4), (c, 2, 5), (b, 4, 6)]
    joined = RowTable.joined([(rows, first, last) for (rows, _), first, last in parts])
    whole = np.concatenate([written[:, first:last] for (_, written), first, last in parts], axis=1)
    assert len(joined) == 9
    for rows, written in ((a[0], a[1]), (joined, whole), (RowTable.joined([(joined, 2, 17)]), whole[:, 2:17])):
        for found, expected in every_answer(rows, written):
            assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("count", [0, 1, 8192, 8193, 30000])
def test_blocks_hold_each_body_once(count):
    assert [k for some in row_blocks(count) for k in range(some.start, some.stop)] == list(range(count))


# --- All faces of a body share rows of the maps to uv where its shape makes them once


ROWS_OF_MAPS = {
    "box": (co.Box((0, 0, 0), (1, 2, 3)), 3),  # x, y and z, each scaled
    "cylinder": (co.Cylinder((0, 0, 0), (0, 0, 1), 2), 5),  # x, y and height of the side; x and y over the radius
    "parallelepiped": (co.Parallelepiped((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)), 3),
    "ball": (co.Sphere(1, (1, 2, 3)), 3),
    "triangle": (co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), 2),
    "two": (co.Box((0, 0, 0), (1, 2, 3)) - co.Cylinder((0, 0, 0), (0, 0, 1), 2), 8),
}


@pytest.mark.parametrize("moved", [False, True])
@pytest.mark.parametrize("name", ROWS_OF_MAPS)
def test_as_many_as_the_documented_coordinates_have(name: str, moved: bool) -> None:
    shape, count = ROWS_OF_MAPS[name]
    tables = co.Scene([shape.rotate((1, 2, 3), 40) if moved else shape])._prepared.lowered.tables
    assert len(tables.map_rows) == count
    rows = np.where(tables.face_maps < 0, -1 - tables.face_maps, tables.face_maps)
    assert set(rows.ravel().tolist()) == set(range(count))
    flat = tables.face_maps[:, 0] >= 0
    assert (rows[flat, 2] == rows[flat, 0]).all()


def test_they_are_rows_of_each_body_in_a_bulk() -> None:
    low = np.random.default_rng(1).uniform(-9, 9, (50, 3))
    tables = co.Scene([co.Boxes(low, low + 1)])._prepared.lowered.tables
    assert len(tables.map_rows) == 3 * 50
    # Row k of a body scales its axis k: (p - low) / 1
    assert (tables.map_rows.reshape(50, 3, 4)[:, :, :3] != 0).sum() == 150


def test_an_object_used_twice_is_two_bodies() -> None:
    """The count of references does not show whether a shape was made twice, or copied, or stands for many."""
    one, other, box = co.Cylinder((0, 0, 0), (0, 0, 1), 2), co.Cylinder((0, 0, 0), (0, 0, 1), 2), co.Box()
    twice, apart = (one | box) & (one | co.Sphere(2)), (one | box) & (other | co.Sphere(2))
    tables = [co.Scene([shape])._prepared.lowered.tables for shape in (twice, apart, pickle.loads(pickle.dumps(twice)))]
    assert [len(each.map_rows) for each in tables] == [5 + 3 + 5 + 3] * 3
    many = co.Scene([twice.translate((9 * k, 0, 0)) for k in range(40)])
    assert len(many._prepared.lowered.tables.map_rows) == 16 * 40
    edited = many.replace(3, apart)._prepared.lowered.tables
    anew = co.Scene([apart if k == 3 else body.shape for k, body in enumerate(many.bodies)])._prepared.lowered.tables
    assert edited.face_maps.tobytes() == anew.face_maps.tobytes()
    assert edited.map_rows.tobytes() == anew.map_rows.tobytes()


def test_equal_numbers_do_not_make_them_one() -> None:
    """The number of maps depends on the kind of a body, not on its numbers, even if the radius of a cylinder is 1."""
    shapes: list[co.Shape] = [co.Cylinder((0, 0, 0), (0, 0, 1), radius) for radius in (1, 2)]
    one, other = (co.Scene([shape])._prepared.lowered.tables for shape in shapes)
    assert len(one.map_rows) == len(other.map_rows)


# --- Limits


WIDE = 2.0**10 * 8
"""The reach of bodies without an end beside a ball of radius 8."""
R, HEIGHT = 5 * math.sqrt(2), 2.0**-40
F = {"ellipsoid": 10 * 0.75 * 9 + 0.5, "paraboloid": 10 * 0.75 * WIDE**2 + 6 * 0.125 * WIDE}
TILTED = co.Disc((0, 0, 0), (1, 2, 2), 5), co.Disc((0, 0, 0), (1, 2, 2), 2)
LIMITS = {
    "a ball and a box": (
        [co.Sphere(2) & co.Box((0, 0, 0), (1, 2, 2))],
        {"cell": [(KAPPA_OF_BALLS**0.5 + 5 * RELATIVE, 2 * FAR), (5 * RELATIVE, 3 * FAR)], "program": [(KAPPA_OF_BALLS**0.5 + 5 * RELATIVE, 2 * FAR)]},
    ),
    "an ellipsoid": (
        [co.Ellipsoid((1, 2, 2))],
        {"quadric": [(4 * KAPPA * (F["ellipsoid"] / 3) ** 2, KAPPA * F["ellipsoid"])], "cell": [(1.5 * KAPPA**0.5 + 10 * RELATIVE, 3 * FAR)]},
    ),
    "a paraboloid": (
        [co.EllipticParaboloid(2, 1), co.Sphere(8)],
        {"quadric": [(4 * KAPPA * (F["paraboloid"] / WIDE) ** 2, KAPPA * F["paraboloid"])], "cell": [((KAPPA**0.5 / 2 + RELATIVE) * WIDE, WIDE), (0, math.inf)]},
    ),
    "a paraboloid that is turned": (
        [co.EllipticParaboloid(2, 1).rotate((1, 2, 3), 30), co.Sphere(8)],
        {"quadric": [(4 * KAPPA * (F["paraboloid"] / WIDE) ** 2, math.inf)]},
    ),
    "an exact half-space": ([co.HalfSpace((0, 0, 1), 0), co.Sphere(8)], {"cell": [(8 * 2.0**20 * RELATIVE, 8 * 2.0**20), (0, math.inf)]}),
    "a half-space that is rounded": (
        [co.HalfSpace((1, 2, 2), 0.1).rotate((1, 0, 1), 10), co.Sphere(8)],
        {"plane": [(4 * KAPPA_OF_PLANES * 0.75**2, HEIGHT * 0.75 * WIDE)], "cell": [((KAPPA_OF_PLANES**0.5 / 2 + RELATIVE) * WIDE, WIDE), (0, math.inf)]},
    ),
    "discs in one plane": (TILTED, {"plane": [(4 * KAPPA_OF_PLANES, HEIGHT * R), (0, 0)]}),
    "discs in one plane, the small one first": (TILTED[::-1], {"plane": [(4 * KAPPA_OF_PLANES, HEIGHT * R), (0, 0)]}),
    "a polygon": ([co.Polygon([(0, 0, 0), (3, 0, 0), (0, 4, 0)])], {"polygon": [(7 * RELATIVE, 10 / 3 * FAR)]}),
    "a disc": ([co.Disc((0, 0, 0), (0, 0, 1), 2)], {"sheet": [(8 * RELATIVE, 8**0.5 * FAR)]}),
}  # fmt: skip
"""Bodies, and R and F of docs/dev/exactness.md, the sums of their coordinates, by hand."""


@pytest.mark.parametrize("name", LIMITS)
def test_limits_are_those_of_their_formulas(name: str) -> None:
    shapes, expected = LIMITS[name]
    tables = lower([co.Body(shape) for shape in shapes]).limited().tables
    for kind, rows in expected.items():
        np.testing.assert_allclose(getattr(tables, f"{kind}_limits"), rows, rtol=1e-8, err_msg=kind)


def test_a_use_of_a_missing_prototype_is_refused():
    """Its owner would have no limit, and exact methods would not check it."""
    lowered = lower([co.Body(co.Box()), co.Body(co.Sphere())])
    tables = lowered.tables
    beyond = tables.plane_surface.copy()
    beyond[2] = len(tables.surface_kind)
    with pytest.raises(IndexError, match="that they do not have"):
        with_limits(tables._replace(plane_surface=beyond), lowered.boxes, lowered.rest)


# --- The size of tables for one more placement of known bodies: computed from the sizes of their parts


REAL, WHOLE = 8, 4
WALL = 4 * REAL + 2 * WHOLE  # anchor and form; kind and row
PART = (4 + 1) * WHOLE  # a cell, and a leaf of a Boolean body
PLANE = 2 * WHOLE  # surface; side and face
BODY = (1 + 4 + 3 + 4) * WHOLE  # a program, and where it is; entry, face, maps
PIN = 3 * WALL + 7 * PART + 10 * PLANE + 3 * BODY
"""A pin of pellet, cladding and water, of seven parts in all, with three curved walls. Parts end at ten planes."""
EDGES = 32
"""Bytes for each place along an axis. The number of places is the square root of the number of pins."""


def test_a_pin_stores_only_its_differences(tmp_path) -> None:
    scenes = []
    for across in (2, 4):
        path = tmp_path / f"{across}.xml"
        path.write_text(core_xml(across), encoding="utf-8")
        scenes.append(co.load_openmc(path, void=False))
    few, many = (scene.memory for scene in scenes)
    one, other = (scene._prepared.lowered.tables for scene in scenes)
    pins = (4**2 - 2**2) * PINS**2
    assert (many.tables - few.tables) / pins <= PIN + EDGES
    assert len(one.quadric_forms) == len(other.quadric_forms)
    for shared in ("planes", "leaf_bounds", "face_maps"):
        assert len(getattr(other, shared)) - len(getattr(one, shared)) < pins / 16, shared
    assert len(other.leaf_items) == ROWS * len(other.entry_kind)
