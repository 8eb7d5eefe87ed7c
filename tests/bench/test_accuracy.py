"""The accuracy that the bench reports, and the numbers that it compares with."""

import itertools
import json
import math

import numpy as np
import pytest
from flint import arb, ctx
from typer.testing import CliRunner

from benchmarks.__main__ import app
from benchmarks.comparison.accuracy import suite, systems
from benchmarks.comparison.accuracy.bodies import (
    DOUBLE,
    FAMILIES,
    SHAPES,
    SINGLE,
    ExactBall,
    ExactBlock,
    ExactQuadric,
    ExactRevolution,
    Trial,
    inside,
    trials,
)
from benchmarks.comparison.accuracy.reference import EDGES, ExactCrossings, SystemAnswer, Tally, first_crossings
from benchmarks.comparison.accuracy.systems import along_axis
from benchmarks.comparison.harness import Absent, Peer

from ..reference.items import Item
from ..reference.quadratics import Table
from ..reference.solids import bodies
from ..reference.trace import Trace
from ..samples import sampled

# --- `python -m benchmarks --accuracy`: exact rays, right statistics, and the same bodies in every system

FAMILY = {family.name: family for family in FAMILIES}


def numbers_of(body):
    for value in vars(body).values():
        yield from value.values() if isinstance(value, dict) else np.ravel(value)


@pytest.mark.parametrize("family", FAMILY)
@pytest.mark.parametrize("shape", SHAPES)
def test_every_input_is_a_float32_where_it_must_be(shape, family):
    for trial in trials(shape, FAMILY[family], SINGLE, 200):
        for number in (*numbers_of(trial.body), *trial.origins.ravel(), *trial.directions.ravel()):
            assert float(np.float32(number)) == number


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_from_inside_start_inside(shape):
    for trial in trials(shape, FAMILY["inside"], DOUBLE, 200):
        assert inside(trial.body, trial.origins).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_rim_is_on_the_surface(shape):
    random = np.random.default_rng(1)
    for _ in range(6):
        subject = SHAPES[shape](random, DOUBLE, 1.0)
        points, normals = subject.rim(random, 50)
        assert inside(subject.body, points - 1e-6 * normals).all()
        assert not inside(subject.body, points + 1e-6 * normals).any()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("length", [2.0, -2.0])
def test_frames_turn_z_to_the_axis(axis, length):
    start = np.array([1.0, 2.0, 3.0])
    frame, height = along_axis(tuple(start), tuple(start + length * np.eye(3)[axis]))
    assert height == 2.0
    assert np.linalg.det(frame[:3, :3]) == 1
    assert np.array_equal(frame @ (0, 0, 2, 1), [*(start + length * np.eye(3)[axis]), 1])
    assert np.array_equal(frame[:3, :3] @ frame[:3, :3].T, np.eye(3))


def tally_of(exact, found, low=None, tie=None, bound=None):
    exact, found = np.array(exact, float), np.array(found, float)
    low = np.zeros(len(exact)) if low is None else np.array(low, float)
    tie = np.zeros(len(exact), bool) if tie is None else np.array(tie)
    tally = Tally()
    tally.add(ExactCrossings(exact, low, tie), SystemAnswer(found, None if bound is None else np.array(bound, float)))
    return tally


def test_wrong_answers_are_counted_without_ties():
    inf = math.inf
    tally = tally_of([1, inf, 2, inf, 3], [inf, 1, 2, inf, inf], tie=[False, False, False, False, True])
    assert (tally.rays, tally.ties, tally.hits, tally.wrong_hits, tally.wrong_misses) == (4, 1, 2, 1, 1)
    assert tally.per_million(tally.wrong_hits) == 250_000


def test_errors_are_in_ulps_of_float64():
    # an ulp is 2^-52 in [1, 2), 2^-50 in [4, 8)
    tally = tally_of([1, 1, 4], [1 + 2**-51, 1, 4 - 2**-51], low=[0, 2**-54, 0])
    spread = tally.spread()
    assert spread.median == 0.5
    assert spread.largest == 2
    assert spread.most == pytest.approx(2 - 0.002 * 1.5)  # between 0.5 and 2, 0.998 of the way
    assert {int(EDGES[k]) for k, count in enumerate(spread.histogram) if count} == {-2, -1, 1}


def test_bounds_are_held_against_the_errors():
    ulp = 2.0**-52
    tally = tally_of([1, 1, 1], [1 + ulp, 1 + 2 * ulp, 1 + 4 * ulp], bound=[ulp, 8 * ulp, 3 * ulp])
    spread = tally.spread()
    assert spread.violations == 1
    assert spread.bound_ratio == 3 / 2
    assert {int(EDGES[k]): count for k, count in enumerate(spread.bounds) if count} == {0: 1, 1: 1, 3: 1}


def test_bounds_of_exact_answers_have_no_ratio_and_stay_json():
    tally = tally_of([1, 1], [1, 1], bound=[2.0**-52, 0])
    assert (tally.spread().bound_ratio, tally.spread().violations) == (None, 0)
    outcome = suite.CaseOutcome("sphere", "near", "float32", SYSTEM, tally)
    assert suite.cells(outcome)[-2:] == ("", "0")
    assert "Infinity" not in suite.as_json([outcome], [], [])


def shifted(offset):
    """A system whose t is the exact one plus an offset."""
    return lambda cases: [SystemAnswer(first_crossings(t.body, t.origins, t.directions).high + offset) for t in cases]


def _absent():
    raise Absent("not installed: pip install somebody")


SYSTEM = systems.System(Peer("Somebody", "float64", lambda: "Somebody 1"), 53, 53, ("sphere",), shifted(0.0))


def test_systems_are_measured_by_the_queries_they_have(monkeypatch):
    single = systems.System(Peer("Single", "", lambda: ""), 24, 24, ("sphere", "box"), shifted(2.0**-20))
    absent = systems.System(Peer("Nobody", "", _absent), 53, 53, ("sphere",), shifted(0.0))
    monkeypatch.setattr(suite, "SYSTEMS", (SYSTEM, single, absent))
    reports = []
    outcomes, missing = suite.run(suite.cases(["near", "sphere", "box"]), 300, reports.append)
    names = [(o.inputs, o.shape, o.system.peer.name) for o in outcomes]
    assert names == [
        ("float32", "sphere", "Somebody"), ("float32", "sphere", "Single"), ("float32", "box", "Single"),
        ("float64", "sphere", "Somebody"),
    ]  # fmt: skip
    assert reports == outcomes
    assert missing == ["Nobody: not installed: pip install somebody"]
    assert outcomes[0].tally.spread().largest <= 0.5
    # t is between 1 and 32, where an ulp is between 2^-52 and 2^-48
    assert 2.0**28 - 1 <= outcomes[1].tally.spread().median <= 2.0**32


def test_the_command(tmp_path):
    file = tmp_path / "errors.json"
    command = ["--accuracy", "--rows", "sphere", "--rows", "near", "--rows", "far", "--rays", "400"]
    result = CliRunner().invoke(app, [*command, "--markdown", "--json", str(file)])
    assert result.exit_code == 0
    found = json.loads(file.read_text())
    ours = [row for row in found["rows"] if row["system"] == "Conicoid"]
    assert [(row["inputs"], row["family"]) for row in ours] == [
        ("float32", "near"), ("float32", "far"), ("float64", "near"), ("float64", "far"), ("float32", "all"), ("float64", "all"),
    ]  # fmt: skip
    assert all(row["wrong_hits"] == row["wrong_misses"] == 0 for row in ours)
    assert all(sum(row["histogram"]) == row["hits"] for row in ours)
    assert "| float32 | sphere | near | Conicoid | 0 | 0 |" in result.stdout
    result = CliRunner().invoke(app, ["--accuracy", "--rows", "nothing"])
    assert result.exit_code == 2
    assert "there are no rows 'nothing'" in result.stderr


@pytest.mark.parametrize(("option", "message"), [
    (["--rays", "5"], "go with --accuracy"), (["--picture", "errors.png"], "go with --accuracy"),
    (["--accuracy", "--quick", "--rays", "10"], "either --rays or --quick"),
])  # fmt: skip
def test_options_that_do_not_go_together(option, message):
    result = CliRunner().invoke(app, option)
    assert result.exit_code == 2
    assert message in result.stderr


def test_the_picture(tmp_path):
    pytest.importorskip("matplotlib", reason="matplotlib comes with the group `bench`")
    from PIL import Image

    from benchmarks.comparison.accuracy.suite import draw

    outcomes = [
        suite.CaseOutcome("sphere", f, "float32", SYSTEM, tally_of([1, 2], [1, 2.5], bound=[1, 1]))
        for f in ("near", "far")
    ]
    draw(outcomes, tmp_path / "errors.png")
    with Image.open(tmp_path / "errors.png") as picture:
        assert min(picture.size) > 200
        assert len(picture.convert("RGB").getcolors(1 << 20)) > 10
    with pytest.raises(ValueError, match="nothing to draw"):
        draw([], tmp_path / "none.png")


BODIES = {
    "sphere": ExactBall((0.5, -1, 2), 1.25),
    "box": ExactBlock((-1, 0.5, 1), (0.5, 2, 1.75)),
    "cylinder": ExactRevolution((0.5, 1, -1), (-1.5, 1, -1), 0.75, 0.75),
    "cone": ExactRevolution((0.5, 1, -1), (0.5, -1.5, -1), 0.75, 0.0),
}


def shot_at(body):
    random = np.random.default_rng(2)
    origins = random.uniform(-6, 6, (500, 3))
    middle = body.center if isinstance(body, ExactBall) else np.mean([*vars(body).values()][:2], axis=0)
    directions = middle + random.uniform(-1, 1, (500, 3)) - origins
    return Trial(body, SINGLE.rounded(origins), SINGLE.rounded(directions))


@pytest.mark.parametrize("system", systems.SYSTEMS, ids=lambda system: system.peer.name)
def test_systems_see_the_same_bodies(system):
    """Each system that is installed answers within single precision. So it has received the right bodies and rays."""
    try:
        system.peer.find()
    except Absent as reason:
        pytest.skip(str(reason))
    for shape in set(BODIES) & set(system.shapes):
        trial = shot_at(BODIES[shape])
        exact = first_crossings(trial.body, trial.origins, trial.directions)
        (answer,) = system.trace([trial])
        assert 100 < np.isfinite(exact.high).sum() < len(exact.high)
        assert np.array_equal(np.isfinite(answer.t), np.isfinite(exact.high))
        hit = np.isfinite(exact.high)
        assert np.allclose(answer.t[hit], exact.high[hit], rtol=1e-4, atol=1e-5)


# --- The integer reference of `python -m benchmarks --accuracy` against that of the tests, and exact cases by hand

BALL = ExactBall((0.1, 0.2, 0.3), 1.3)
BLOCK = ExactBlock((-1, -0.5, -0.25), (1, 0.7, 0.3))
ROD = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.7, 0.7)
CONE = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.8, 0.0)
FRUSTUM = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.2, 0.5)
HYPERBOLOID = ExactQuadric(dict(xx=1.0, yy=2.0, zz=-1.5, xy=0.3, yz=0.2, xz=-0.4, x=0.1, y=0.2, z=0.3, constant=-1.0))
REFERENCE_BODIES = {
    "ball": BALL,
    "block": BLOCK,
    "rod": ROD,
    "cone": CONE,
    "frustum": FRUSTUM,
    "hyperboloid": HYPERBOLOID,
}


ITEMS = {
    ExactBall: lambda body: Item("Sphere", {"radius": body.radius, "center": body.center}),
    ExactBlock: lambda body: Item("Box", {"low": body.low, "high": body.high}),
    ExactRevolution: lambda body: Item("Cone", {**vars(body)}),
    ExactQuadric: lambda body: Item("Quadric", {"coefficients": body.coefficients}),
}


def check(body, origins, directions):
    """Compare all rays but ties; returns how many hit."""
    found, table = first_crossings(body, origins, directions), Table(bodies([ITEMS[type(body)](body)]))
    exact, sure = Trace(table, origins, directions).crossings.ahead(), ~found.tie
    hit = np.diff(exact.offsets) > 0
    assert np.array_equal(np.isfinite(found.high)[sure], hit[sure])
    first = exact.offsets[:-1][sure & hit]
    assert np.array_equal(found.high[sure & hit], exact.t[first])
    with ctx.workprec(300):
        for high, low, root in zip(found.high[sure & hit], found.low[sure & hit], exact.roots[first], strict=True):
            assert abs((arb(high) + arb(low)) / root.ball(250) - 1) < 2.0**-104
    return np.isfinite(found.high).sum()


@pytest.mark.parametrize("single", [True, False], ids=["float32", "float64"])
@pytest.mark.parametrize("name", REFERENCE_BODIES)
def test_first_crossings_are_those_of_the_reference(name, single):
    random = np.random.default_rng(5)
    origins = random.uniform(-3, 3, (150, 3))
    directions = random.uniform(-1, 1, (150, 3)) - origins * random.uniform(0, 1, (150, 1))
    if single:
        origins, directions = (x.astype(np.float32).astype(float) for x in (origins, directions))
    assert check(REFERENCE_BODIES[name], origins, directions) > 15


@pytest.mark.parametrize(
    ("shape", "family", "precision"),
    sampled(itertools.product(SHAPES, FAMILIES, (SINGLE, DOUBLE)), 5),
    ids=lambda value: getattr(value, "name", value),
)
def test_the_measured_rays_have_the_answers_of_the_reference(shape, family, precision):
    cases = trials(shape, family, precision, 60)
    assert sum(check(trial.body, trial.origins, trial.directions) for trial in cases) > 10


@pytest.mark.parametrize(
    ("body", "origin", "direction"),
    [
        (ExactBall((0, 0, 0), 5.0), (3, 4, -9), (0, 0, 1)),  # touches it: 3² + 4² = 5²
        (ExactBlock((0, 0, 0), (1, 1, 1)), (0.25, 0, -1), (0, 0, 1)),  # runs in a face
        (ExactBlock((0, 0, 0), (1, 1, 1)), (-1, 0.5, 0), (1, 0, 1)),  # passes through an edge only
        (ExactRevolution((0, 0, 0), (0, 0, 2), 5.0, 5.0), (3, 4, -1), (0, 0, 1)),  # runs in the wall
        (ExactBall((0, 0, 0), 5.0), (3, 4, 0), (1, 0, 0)),  # starts on it
    ],
)
def test_grazing_rays_have_no_agreed_answer(body, origin, direction):
    found = first_crossings(body, *(np.array([x], float) for x in (origin, direction)))
    assert found.tie.tolist() == [True]
