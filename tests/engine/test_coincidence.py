"""Which walls are one surface: by exact names, before turns in common, for many shapes at once."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.instances import InstanceList, Shift, ShiftTable
from conicoid.geometry.transform import Rotate, Translate
from conicoid.kernels.tables import PLANE, QUADRIC
from conicoid.prepare import body_collector, coincidence, lowering, surface_names
from conicoid.prepare.body_collector import ExactBodySurfaces
from conicoid.prepare.instances import _first_records
from conicoid.prepare.lowering import lower
from conicoid.prepare.surface_features import (
    FIRST_DIRECTION,
    CurvedFeatures,
    PlaneFeatures,
    QuadricTable,
    coefficients,
)
from conicoid.scene.warmup import CutCylinders

from .tapes.test_recorded import KINDS
from .test_tables import solids_of

# --- Where surfaces lie side by side, and which planes across axes are one: kernels against formulas on whole arrays


def test_copies_of_a_far_plane_move_nothing():
    """A half-space that is turned about its own normal (1, 2, 3), and carried along its wall, is the same plane.

    Copies do not move the point about which places are computed.
    """
    far = 0.1 * 10**5
    same = [
        co.HalfSpace((1, 2, 3), k * 0.1).rotate((1, 2, 3), 17 + m).translate((3 * far * m, 0, -far * m))
        for k in range(4)
        for m in range(4)
    ]
    copied = co.HalfSpace((1, 2, 3), 0.7).translate((27 * far, 0, -9 * far))
    lowered = lower([co.Body(shape) for shape in [*same, *[copied] * 1000]])
    assert len(lowered.tables.surface_kind) == 4 + 1


@pytest.mark.parametrize("seed", range(6))
def test_surfaces_are_one_where_their_names_are(seed):
    """The test compares exact names of every two surfaces of a random scene, without regard to their places."""
    bricks = [co.Box((k, 0, 0), (k + 1, 1, 1)).rotate((1, 2, 3), 20) for k in range(4)]
    lowered = lower([co.Body(shape) for shape in solids_of(random.Random(seed)) + bricks])
    tables, exact = lowered.tables, lowered.exact
    names = [exact.bodies.name(int(number))[0] for number in exact.single]
    assert len(set(names)) == len(names) == len(tables.surface_kind)
    count = len(lowered.layout.kinds)
    every = {exact.bodies.name(number)[0] for number in range(count)}
    assert every == set(names)
    assert count >= len(names) + 15  # four sides and three walls between bricks are common
    assert (tables.surface_kind == PLANE).sum() >= 9


# --- Walls that coincide under a common turn are one, as their exact names have it, even where no names are computed


def at_an_angle(shape: co.Solid) -> co.Solid:
    return shape.rotate("z", 30).rotate((1, 2, 3), 20)


def walls() -> list[co.Body]:
    """Return boxes, balls and pipes at an angle that share walls, with each other and with bodies under another motion."""
    shapes: list[co.Solid] = []
    for i in range(6):
        for j in range(4):
            own = co.Box((i, j, 0), (i + 1, j + 1, 1)) if j % 2 else co.Box((0, 0, 0), (1, 1, 1)).translate((i, j, 0))
            shapes.append(at_an_angle(own))
    shapes += [(co.Sphere(0.3, (i, 0.5, 2)) & co.HalfSpace((0, 1, 1), 2.5)).rotate("x", 12) for i in range(8)]
    shapes += [
        (co.Cylinder((0, 0, 5), (0, 0, 6 + k), 1.5) - co.Sphere(0.5, (0, 0, 5))).rotate("x", 12) for k in range(8)
    ]
    # Turned by quarters and the same rest, either way about the axis; rods that end in a wall, and rods end to end
    spoke = co.Box((2, -0.1, 50), (3, 0.1, 51))
    shapes += [spoke.rotate("z", 30 * k).rotate((1, 2, 3), 20) for k in range(-4, 15)]
    shapes += [spoke.rotate("-z", 45 + 90 * k).rotate((1, 2, 3), 20) for k in range(6)]
    shapes += [spoke.rotate("z", 45).rotate((1, 2, 3), 20)]
    shapes += [at_an_angle(co.Cylinder((i, 1, 60), (i, 1, 61), 0.3)) for i in range(4)]
    shapes += [at_an_angle(co.Cylinder((i, 2, 61), (i, 1, 61), 0.3)) for i in range(4)]
    shapes += [at_an_angle(co.Box((-1, 1, 60), (9, 4, 61)))]
    shapes += [at_an_angle(co.Cylinder((k, 2 * k, 70 + 3 * k), (k + 1, 2 * k + 2, 73 + 3 * k), 0.3)) for k in range(4)]
    shapes += [at_an_angle(co.Tube((2, 4, 76), (-1, -2, 67), r, 0.3)) for r in (0.1, 0.2)]
    # Mirrored, slanted before the turn, and under shears and scalings that keep one direction
    shapes += [co.Box((k, 0, 20), (k + 1, 1, 21)).scale((-1, 1, 1)).rotate("y", 33) for k in range(4)]
    slanted = co.Sphere(2) & co.HalfSpace((3, 1, 0), 0.3)
    for shift in ((0.5, 0.25, 8), (0.25, 1.0, 8), (0.75, -0.5, 8)):  # 3 x + y is 1.75 in all
        shapes.append(slanted.translate(shift).rotate("x", 12))
    shear = [[1, 0, 0, 0], [0.5, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    shapes += [co.Box((0, k, 30), (1, k + 1, 31)).transform(shear).rotate("z", 7) for k in range(4)]
    shapes += [co.Box((0, k, 40), (1, k + 1, 41)).scale((2, 3, 4)).rotate("z", 7) for k in range(4)]
    shapes.append(at_an_angle(co.Box((math.nextafter(1.0, 2.0), 3.5, 4), (2, 4, 5))))
    shapes.append(at_an_angle(co.Box((1, 3.5, 7), (2, 4, 8))))
    shapes.append(co.Box((-1, -4, 9), (2, 4, 10)).rotate("z", 10).rotate("z", 20).rotate((1, 2, 3), 20))
    shapes.append(at_an_angle(co.Box((0, 0, 0), (6, 4, 1))))
    return [co.Body(shape, "red") for shape in shapes]


@pytest.fixture
def named_surfaces(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the numbers of the surfaces that get an exact name."""
    found: list[int] = []
    name = ExactBodySurfaces.name

    def watched(self: ExactBodySurfaces, index: int, primitives=None) -> object:
        found.append(index)
        return name(self, index, primitives)

    monkeypatch.setattr(ExactBodySurfaces, "name", watched)
    return found


def test_tables_are_those_of_exact_names(named_surfaces: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    found = lower(walls())
    few = len(named_surfaces)
    monkeypatch.setattr(body_collector, "FEWEST_SURFACES", 10**9)
    expected = lower(walls())
    assert 0 < few < (len(named_surfaces) - few) / 3
    for field, mine, its in zip(found.tables._fields, found.tables, expected.tables, strict=True):
        assert mine.tobytes() == its.tobytes(), field


def test_planes_that_shifts_carry_are_named_by_their_exact_sums() -> None:
    """Two floats do not hold sums such as 2^60 + 1 + 2^-60. For equal names, equal steps are enough."""
    offsets = [
        (0.1, 0.2),
        (0.3,),
        (0.5, 0.25),
        (0.75,),
        (0.2, 0.1),
        (1e16, 1.0, -1e16),
        (1.0,),
        *[(2.0**60, 1.0, 2.0**-60)] * 2,
    ]
    chains = [tuple(Translate((x, 0.0, 0.0)) for x in row) for row in offsets]
    plane = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    names = surface_names.name_surfaces(np.array([plane] * len(chains)), chains, np.arange(len(chains))).tolist()
    sums = [sum(map(Fraction, row)) for row in offsets]
    assert [[a == b for b in names] for a in names] == [[a == b for b in sums] for a in sums]


def test_a_wire_from_both_sides_of_its_frame_has_one_name() -> None:
    """Wires of two halves of a detector touch end to end: frames with opposite axes carry both to one cylinder."""
    wire = co.Revolution([(0, 1), (0.075, 1), (0.075, 2), (0, 2)])
    chains = [(Translate((0.1, sign * 12190.7, 0.0)), Rotate((1.0, 0.0, 0.0), sign * 90.0)) for sign in (1, -1)]
    chains.append((Translate((0.1, 12190.6, 0.0)), Rotate((1.0, 0.0, 0.0), 90.0)))
    forms = surface_names.list_forms([wire], np.zeros(3, np.int64), np.zeros(3, np.int64))
    names = surface_names.name_surfaces(forms, chains, np.arange(3)).tolist()
    assert names[0] == names[1] != names[2]


@pytest.mark.parametrize("turn", [("z", 0), ("z", 90), ("x", -90)])
def test_surfaces_within_which_bodies_turn_or_slide_need_no_exact_name(turn, named_surfaces: list[int]) -> None:
    """40 plates are turned about the normal of their faces, and 40 segments of a pipe along its axis, all tilted."""
    plates = [co.Box((2, -0.1, 0), (3, 0.1, 1)).rotate("z", 7 * k).translate((0, 0, 0.25)) for k in range(40)]
    pipe = [co.Revolution([(0, k), (0.3, k), (0.3, k + 1), (0, k + 1)]).translate((5, 1, 0)) for k in range(40)]
    spun = [part.rotate("z", 11) for part in pipe]  # off its axis: another pipe
    shapes = [part.rotate(*turn).translate((1, 2, 3)).rotate("x", 20) for part in (*plates, *pipe, *spun)]
    tables = lower([co.Body(shape) for shape in shapes]).tables
    assert not named_surfaces
    assert (tables.surface_kind == QUADRIC).sum() == 2
    # Four sides of each plate, no two in one direction, and all ends at 0.25, at 1.25, and at 0 to 40
    assert (tables.surface_kind == PLANE).sum() == 4 * 40 + 2 + 41


def test_walls_an_ulp_apart_are_two() -> None:
    bodies = walls()
    tables = lower(bodies).tables
    near, at = (
        set(tables.plane_surface[tables.cell_first[cell] : tables.cell_first[cell + 1]].tolist())
        for cell in tables.entry_index[[len(bodies) - 4, len(bodies) - 3]].tolist()
    )
    assert len(near & at) == 3  # x = 2, y = 3.5 and y = 4, but not x = 1


def test_crystals_of_modules_are_prepared_without_a_name_for_each(named_surfaces: list[int]) -> None:
    """Five modules of 10 × 5 crystals have 2 × 10 planes each across, 2 × 5 along, and two that all share."""
    crystal = co.Box((-0.45, -0.45, -0.5), (0.45, 0.45, 0.5))
    bodies = [
        co.Body(crystal.translate((10 + i, j, 0)).rotate("z", angle), "red")
        for angle in np.linspace(7, 307, 5) for i in range(10) for j in range(5)
    ]  # fmt: skip
    assert (lower(bodies).tables.surface_kind == PLANE).sum() == 5 * (20 + 10) + 2
    assert len(named_surfaces) < 20


@pytest.mark.parametrize(("axis", "caps"), [("x", 2 * 40), ((1, 1e-3, 0), 2 * 120)])
def test_caps_of_parallel_wires_are_one_plane_where_the_wires_lie_side_by_side(named_surfaces, axis, caps) -> None:
    """As in detectors, three layers of 40 wires stand one after the other along x, all turned about x.

    About another axis the same shift moves the caps, because n·s is not 0 for a shift s.
    """
    bodies = [
        co.Cylinder((0, 0, -5 - k / 7), (0, 0, 5 + k / 7), 0.1).rotate(axis, 35.7).translate((x, 3.1 * k, 0.7 * k))
        for k in range(40) for x in (-3678.601, 3577.9885, 0.1)
    ]  # fmt: skip
    tables = lower([co.Body(body) for body in bodies]).tables
    assert (tables.surface_kind == PLANE).sum() == caps
    assert not named_surfaces


def slanted_cells(factor: float) -> list[co.Body]:
    """Return cells as files list them: 60 slanted planes of a solid on one side, times a factor of a gap on the other."""
    rng = np.random.default_rng(5)
    bodies: list[co.Body] = []
    for normal, offset in zip(rng.normal(size=(60, 3)).tolist(), rng.uniform(0.5, 2, 60).tolist(), strict=True):
        bodies.append(co.Body(co.Box((-3, -3, -3), (3, 3, 3)) & co.HalfSpace(normal, offset)))
        rows = [[-factor * x for x in normal], (1, 0, 0), (0, 1, 1)]
        bodies.append(co.Body(co.Polyhedron(rows, [-factor * offset, 4, 5]) - co.Sphere(0.1)))
    return bodies


@pytest.mark.parametrize("factor", [1.0, 2.0, 3.0])
def test_half_spaces_have_exact_names_only_where_their_numbers_differ(factor, named_surfaces, monkeypatch) -> None:
    """Multiples by powers of two have the numbers of the plane itself. Most other multiples round to another plane."""
    equal = sum(
        all(Fraction(factor * x) == 3 * Fraction(x) for x in (*plane.normal, plane.offset))
        for plane in (body.shape.operands[1] for body in slanted_cells(factor)[::2])
    )
    found = lower(slanted_cells(factor))
    few = len(named_surfaces)
    assert 2 * equal <= few < (1 if factor < 3 else 60)
    monkeypatch.setattr(body_collector, "FEWEST_SURFACES", 10**9)
    expected = lower(slanted_cells(factor))
    assert len(named_surfaces) - few >= (120 if factor < 3 else 2 * equal)
    for field, mine, its in zip(found.tables._fields, found.tables, expected.tables, strict=True):
        assert mine.tobytes() == its.tobytes(), field


@pytest.mark.parametrize("count", [1, 10])
@pytest.mark.parametrize("size", [1e61, 1e8])
def test_flat_solids_whose_planes_floats_do_not_fit(size, count):
    """The corners lie beyond 1e60, or a wall is 1e-7 thin at 1e8.

    Such solids are lowered whole, alone and among others.
    """
    thin = ((1e8, 0.0), (1e8 + 1, 0.0), (1e8 + 1, 1e-7), (1e8, 1e-7))
    huge = tuple((size * x, size * y) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)))
    outline, at = (huge, (1.0, 1.0)) if size > 1e60 else (thin, (1e8 + 0.5, 5e-8))
    scene = co.Scene([co.Extrusion(outline, (k, k + 1)) for k in range(count)])
    assert scene.first_hit((*at, -5), (0, 0, 1)).t == pytest.approx(5, rel=1e-12)
    assert scene.body_at((*at, count - 0.5)) == count - 1


# --- Places of many shapes at once are those of each; surfaces that are near by chance get no names


def test_frames_of_bodies_that_are_turned_or_only_moved():
    block = co.Box() - co.Sphere(0.5)
    moved = {
        "still": lambda s, k: s,
        "moved": lambda s, k: s.translate((k, -0.0, 1.5)),
        "moved twice": lambda s, k: s.translate((k, 0.1, 0)).translate((0.2, 0, k)),
        "turned": lambda s, k: s.rotate("z", 30 + k).translate((0, k, 0)),
    }
    bodies = [co.Body(move(block, float(k))) for k in range(12) for move in moved.values()]
    lowered = lowering.lower(bodies)
    for number, body in enumerate(bodies):
        expected = body.shape.motion.inverse_matrix[:3]
        assert lowered.frames[lowered.body_frame[number]].tolist() == expected.tolist()


def exact_place(kind, row, middle, scale, pivot):
    """Return the place in fractions: of n·x + c, or of the polynomial, by its values at ten points."""
    if kind == PLANE:
        *normal, height = row[:4]
        terms = [*normal, sum(n * (a - m) for n, a, m in zip(normal, row[4:], middle, strict=True)) - height]
        terms[3] *= scale
    else:

        def value(*x):
            local = [m + c / scale - a for m, c, a in zip(middle, x, row[:3], strict=True)]
            y = [sum(w * c for w, c in zip(row[3 + 3 * k : 6 + 3 * k], local, strict=True)) for k in range(3)]
            found = sum(s * c * c + 2 * b * c for s, b, c in zip(row[12:15], row[15:18], y, strict=True)) - row[18]
            return found * scale * scale

        unit = [tuple(int(i == k) for i in range(3)) for k in range(3)]
        constant = value(0, 0, 0)
        linear = [(value(*e) - value(*(-c for c in e))) / 4 for e in unit]
        second = [(value(*e) + value(*(-c for c in e))) / 2 - constant for e in unit]
        for i, j in ((0, 1), (0, 2), (1, 2)):
            both = value(*(a + b for a, b in zip(unit[i], unit[j], strict=True)))
            mixed = both - constant - second[i] - second[j] - 2 * linear[i] - 2 * linear[j]
            second.append(mixed / 2)
        terms = [*second, *linear, constant]
    return sum(x * Fraction(float(w)) for x, w in zip(terms, FIRST_DIRECTION, strict=False)) / terms[pivot]


@pytest.mark.parametrize("size", [1e-150, 1e-60, 1.0, 1e60, 1e150])
@pytest.mark.parametrize("kind", [PLANE, QUADRIC])
def test_bounded_places_hold_the_exact_ones(kind, size):
    """Records of any size with remainders lie near others. The error bound holds and is small."""
    rng = np.random.default_rng(11)
    records = rng.normal(size=(40, 7 if kind == PLANE else 19))
    lengths = slice(3, 7) if kind == PLANE else slice(0, 3)
    records[:, lengths] *= size
    if kind == QUADRIC:
        records[:, 15:18] *= size
        records[:, 18] *= size**2
    records[20:] = records[:20] * (1 + 2.0**-52 * rng.integers(0, 2, (20, 1)))
    rests = records * rng.uniform(-(2.0**-54), 2.0**-54, records.shape)
    rests[::3] = 0.0
    rows = np.arange(40, dtype=np.int32)
    if kind == PLANE:
        features = PlaneFeatures.of(rows, records, rests)
    else:
        table = QuadricTable.of(records, records[:, 3:])
        features = CurvedFeatures.of(np.full(40, QUADRIC, np.int8), rows, np.empty((0, 4)), table, rests)
    found = features.bounded_places(rows, np.zeros(40, np.int64))
    scale = Fraction(2) ** -math.frexp(features.unit)[1]
    middle = [Fraction(m) for m in features.middle]
    leading = records[0, :3] if kind == PLANE else coefficients(
        np.array([QUADRIC], np.int8), rows[:1], np.empty((0, 4)), table, np.array(features.middle)
    )[0, :6]  # fmt: skip
    pivot = int(np.abs(leading).argmax())
    for (high, low, error), record, rest in zip(found.tolist(), records.tolist(), rests.tolist(), strict=True):
        row = [Fraction(x) + Fraction(y) for x, y in zip(record, rest, strict=True)]
        off = abs(Fraction(high) + Fraction(low) - exact_place(kind, row, middle, scale, pivot))
        assert off <= Fraction(error)
        assert error < 1e-24 * max(1.0, abs(high))
    assert np.isinf(features.bounded_places(rows, np.zeros(40, np.int64))[:, 2]).sum() == 0


def test_planes_through_corners_are_exact():
    """The height of a triangle's anchor over its plane, record and rest, is n·(anchor - a) in fractions.

    n is the normal of the record plus its remainder, so both sides are exact but for 2^-106.
    """
    rng = random.Random(5)
    shapes = [KINDS["Triangle"](rng) for _ in range(300)]
    lowered = lowering.lower([co.Body(shape) for shape in shapes])
    for record, rest, shape in zip(lowered.tables.planes, lowered.rest.planes, shapes, strict=True):
        exact = [Fraction(x) + Fraction(y) for x, y in zip(record.tolist(), rest.tolist(), strict=True)]
        aside = [Fraction(p) - Fraction(q) for p, q in zip(record[4:].tolist(), shape.a, strict=True)]
        height = sum(n * d for n, d in zip(exact[:3], aside, strict=True))
        assert abs(height - exact[3]) <= Fraction(2) ** -100 * sum(abs(d) for d in aside)


def test_halves_of_rods_are_named_only_where_their_axes_are_one(noted_calls):
    """Two half rods meet at a rounded middle. Fractions decide whether they have one axis."""
    rng = np.random.default_rng(8)
    starts, ends = rng.uniform(-9, 9, (2, 60, 3)) + 32 * np.arange(60)[:, None] * (1, 0, 0)
    starts[:20], ends[:20] = np.round(8 * starts[:20]) / 8, np.round(8 * ends[:20]) / 8
    middles = (starts + ends) / 2
    one = [all(Fraction(a) + Fraction(b) == 2 * Fraction(m) for a, b, m in zip(*row, strict=True))
           for row in zip(starts, ends, middles, strict=True)]  # fmt: skip
    named_surfaces = noted_calls(coincidence._SurfaceMerger, "_name")
    rods = [co.Cylinder(a, b, 0.1) for pair in ((starts, middles), (middles, ends)) for a, b in zip(*pair, strict=True)]
    scene = co.Scene(rods)
    across = np.cross(ends - starts, rng.normal(size=(60, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    quarters = [starts + (ends - starts) * share for share in (0.25, 0.75)]
    found = [scene.first_hit(quarter + across, -across).surface for quarter in quarters]
    assert (found[0] == found[1]).tolist() == one
    assert 20 <= sum(one) < 60
    assert len(named_surfaces) <= 4 * sum(one)  # the sides and the caps in the middle of both halves


class Rods(CutCylinders):
    """Copies of two solids at the same 64 places."""

    def __init__(self, *solids: co.Solid) -> None:
        super().__init__()
        x, kinds, z = self.shifts.index
        shifts = ShiftTable(self.shifts.values, np.stack([x, 0 * x, z]))
        InstanceList.__init__(self, kinds.copy(), shifts, [None, None])
        self.solids = solids

    def shape_at(self, kind: int, shift: Shift) -> co.Solid:
        x, y, z = map(float, shift)
        return self.solids[kind].translate((x, y, z))


ROD = co.Cylinder((0, 0, 0), (0, 0, 1), 0.5)


@pytest.mark.parametrize(
    ("other", "walls"),
    [
        (co.Cylinder((0, 0, 2), (0, 0, 3), 0.5), 64),  # the same wall from an anchor farther along it
        (co.Cylinder((0, 0, 1), (0, 0, 2), 0.25).scale(2), 64),  # the same wall, written otherwise
        (co.Cylinder((1, 0, 0), (1, 0, 1), 0.5), 65),  # 63 walls in common
        (co.Cylinder((0, 0, 2), (0, 0, 3), 0.25), 128),
        (co.Cylinder((0, 0.25, 0), (0, 0.25, 1), 0.5), 128),
        (co.Sphere(0.5), 128),
    ],
)
def test_walls_of_copies_are_one_where_they_coincide(other: co.Solid, walls: int) -> None:
    kinds = lower(Rods(ROD, other)).tables.surface_kind
    assert (kinds != PLANE).sum() == walls


def test_first_records_by_more_numbers_than_one_float_holds():
    """The test compares records number by number: by three among 2^18 each, which makes 2^54 records."""
    values, last = np.arange(2.0**18), np.full(2, 2**18 - 1, np.int32)
    records = [(values, last), (values, last), (values, np.array([1, 0], np.int32))]
    assert _first_records(np.zeros(2, np.int32), records).tolist() == [1, 1]


def test_caps_of_coaxial_cylinders_are_named_by_their_ends(monkeypatch):
    """Exact numbers of two planes took half a millisecond for a turned tube. It has two sides and two caps."""
    monkeypatch.setattr(body_collector, "name_surfaces", None)
    start, end = (0, 0.1, -1), (0.2, 0, 1)
    tube = co.Cylinder(start, end, 0.5) - co.Cylinder(start, end, 0.3)
    tubes = [tube.rotate((1, 2, 3), 10 + k).translate((3.0 * k, 0, 0)) for k in range(40)]
    assert len(lowering.lower(list(map(co.Body, tubes))).tables.surface_kind) == 4 * len(tubes)


@pytest.mark.parametrize(
    ("outer", "inner", "surfaces"),
    [
        (ROD, co.Cylinder((0, 0, 0), (0, 0, 1), 0.3), 4),
        (ROD, co.Cone((0, 0, 0), (0, 0, 1), 0.3, 0.1), 4),
        (ROD, co.Cylinder((0, 0, 0), (0, 0, 1), 0.3).rotate("x", 1e-40), 6),  # equal ends under another turn
        (ROD, co.Cylinder((0, 0, 1e-40), (0, 0, 1), 0.3), 5),
        (ROD, co.Cylinder((0, 0, 0), (1e-40, 0, 1), 0.3), 6),
        (co.Cylinder((0, 0, 0), (0, 0, 1e-40), 0.5), co.Cylinder((0, 0, 0), (0, 0, 1e-40), 0.3), 4),
        (co.Cylinder((0, 0, 0), (0, 0, 1), 0.5, 0, 90, (1, 0, 0)), co.Cylinder((0, 0, 0), (0, 0, 1), 0.3, 1e-40, 90, (1, 0, 0)), 7),
    ],
)  # fmt: skip
def test_caps_are_one_where_ends_and_steps_are_equal(outer: co.Solid, inner: co.Solid, surfaces: int) -> None:
    """The first 100 bits of these planes are equal. So names decide which planes are one."""
    tubes = [(outer - inner).rotate((1, 2, 3), 10 + k).translate((3.0 * k, 0, 0)) for k in range(40)]
    assert len(lowering.lower(list(map(co.Body, tubes))).tables.surface_kind) == surfaces * len(tubes)


def test_primitives_of_sectors_side_by_side_are_listed(monkeypatch):
    """The search by surfaces took three milliseconds a body.

    A sector has two sides and two walls, and caps in common with others.
    """
    monkeypatch.setattr(body_collector, "_shape_leaves", None)
    outer, inner = (co.Cylinder((0, 0, 0), (0, 0, 1), r, 10, 70, (1, 0, 0)) for r in (0.5, 0.3))
    sectors = [(outer - inner).translate((3.0 * k, 0, 0)) for k in range(40)]
    assert len(lowering.lower(list(map(co.Body, sectors))).tables.surface_kind) == 4 * len(sectors) + 2


def test_surfaces_of_primitives_that_two_bodies_have_are_not_compared(monkeypatch):
    """A volume and the hole in its mother are one primitive: its side and its two caps have equal numbers, rounded."""
    rng = np.random.default_rng(3)
    starts = rng.uniform(-1, 1, (40, 3)) + 4 * np.arange(40)[:, None] * (1, 0, 0)
    rods = [co.Cylinder((0, 0, 0), (0, 0, 1), 0.1).rotate(at, 20 + at[1]).translate(at) for at in starts]
    compared = []
    monkeypatch.setattr(
        coincidence.SurfaceSubset, "known_names", lambda _, surfaces, clusters: compared.extend(surfaces) or surfaces
    )
    mother = co.Difference((co.Box((-9, -9, -9), (200, 9, 9)), *rods))
    lowered = lowering.lower([co.Body(shape) for shape in (mother, *rods)])
    assert len(lowered.tables.surface_kind) == 6 + 3 * len(rods)
    assert not compared
