"""The bench: rows, commands, and fresh processes."""

import json

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import conicoid as co
from benchmarks.__main__ import app
from benchmarks.comparison import arrays, harness, limits, preparation, scenes, startup as fresh, suite
from benchmarks.comparison.harness import QUICK, Absent, BenchRow, Measured, Peer, Size
from benchmarks.comparison.startup import HITS, OURS, PICTURES

from ..samples import sampled

# --- The benchmark: names of scenes, the table of figures, and systems that are not installed

HERE = Peer("Somebody", "float32", lambda: "Somebody 1")


def _absent() -> str:
    raise Absent("not installed: pip install somebody")


def row(name, measure, peer=HERE, floor=0.8, aim=1.2):
    return BenchRow(name, "camera", "a scene", peer, floor, aim, measure)


def brute_force_balls(balls, origins, directions):
    """Return the nearest root of |o + t d - c|² = r² with t > 0 over all balls, out of an array of rays by balls."""
    o, d, c = (np.asarray(x, float) for x in (origins, directions, balls.centers))
    p = o[:, None] - c
    a, b = (d * d).sum(-1)[:, None], np.einsum("nmk,nk->nm", p, d)
    k = (p * p).sum(-1) - np.asarray(balls.radii, float) ** 2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * k)
    t = np.stack([(-b - root) / a, (-b + root) / a])
    return np.where(t > 0, t, np.inf).min(axis=(0, 2))


@pytest.mark.parametrize("coherent", [True, False])
def test_balls_and_rays_are_those_of_a_brute_force(coherent):
    each = scenes.balls(300)
    origins, directions = scenes.camera_rays(32) if coherent else scenes.random_rays(1000)
    t = co.Scene(each.shapes()).first_hit(origins, directions).t.ravel()
    expected = brute_force_balls(each, origins.reshape(-1, 3), directions.reshape(-1, 3))
    assert np.array_equal(np.isfinite(t), np.isfinite(expected))
    assert np.allclose(t[np.isfinite(t)], expected[np.isfinite(t)], rtol=1e-9)


def test_capped_quadrics_follow_their_inequalities():
    each = scenes.capped_quadrics(40)
    points = np.random.default_rng(3).uniform(-1, 1, (20_000, 3))
    inside = np.zeros(len(points), bool)
    for kind, center, r, axis in zip(each.kinds, each.centers, each.radii, each.axes, strict=True):
        p = points - center
        z = p @ axis
        rho = (p * p).sum(axis=1) - z * z
        curved = {0: rho + z * z <= r * r, 1: rho <= r * r, 2: rho <= z * z, 3: rho - z * z <= r * r / 5}[int(kind)]
        inside |= curved & (np.abs(z) <= 0.6 * r)
    assert np.array_equal(co.Scene(each.shapes()).contains(points), inside)


def test_bored_blocks_are_five_leaves():
    each = scenes.balls(20)
    points = np.random.default_rng(4).uniform(-1, 1, (20_000, 3))
    inside = np.zeros(len(points), bool)
    for center, r in zip(each.centers.astype(float), each.radii.astype(float), strict=True):
        p = (points - center) / r
        block = ((p * p).sum(axis=1) <= 1) & (np.abs(p) <= 0.75).all(axis=1)
        for k in range(3):
            a, b = (p[:, j] for j in range(3) if j != k)
            block &= ~((a * a + b * b <= 0.16) & (np.abs(p[:, k]) <= 1))
        inside |= block
    assert np.array_equal(co.Scene(scenes.bored_blocks(each)).contains(points), inside)


def test_ratios_are_printed_beside_their_aims():
    measured = Measured(60.0, 30.0, 2.0, "Mray/s")
    outcomes = harness.run(
        [row("a", lambda size: measured), row("b", lambda size: measured, Peer("X", "y", _absent))],
        QUICK,
        lambda _: None,
    )
    assert outcomes[0].cells()[3:] == ("60 Mray/s", "30 Mray/s", "2.00 ×", "0.8 ×", "1.2 ×")
    assert outcomes[1].cells()[5] == "not installed: pip install somebody"
    found = json.loads(harness.as_json(outcomes, ["a machine"]))
    assert found["rows"][0]["ratio"] == 2.0
    assert found["rows"][1]["missing"].startswith("not installed")
    assert "| 2.00 × |" in harness.markdown(outcomes, ["a machine"])


def test_agreement():
    t = np.array([1.0, 2.0, np.inf] * 1000)
    assert suite.check_agreement(t, t + 1e-5) == ""
    assert "hit for one only" in suite.check_agreement(t, np.full(3000, 1.0))
    assert "distances differ" in suite.check_agreement(t, t * 1.1)


def test_the_command(tmp_path):
    result = CliRunner().invoke(app, ["--quick", "--rows", "growth", "--json", str(tmp_path / "bench.json")])
    assert result.exit_code == 0
    assert json.loads((tmp_path / "bench.json").read_text())["rows"][0]["ratio"] > 0
    result = CliRunner().invoke(app, ["--rows", "nothing"])
    assert result.exit_code == 2
    assert "there is no row 'nothing'" in result.stderr


SMALL = Size(runs=1, balls=1000)


@pytest.mark.parametrize("name", sampled(["latency", "latency-spans", "latency-1000", "import", "command"], 3))
def test_work_around_the_rays_takes_time(name):
    """The test asserts no limit, because other work may run beside it."""
    measured = {row.name: row for row in limits.ROWS}[name].measure(SMALL)
    assert measured.ours > 0
    assert measured.ratio == measured.theirs / measured.ours


def test_the_serial_share_is_the_intercept_of_amdahls_law():
    assert arrays.serial_share({n: 2 + 6 / n for n in (1, 2, 4, 16)}) == pytest.approx(25)
    assert arrays.serial_share({1: 6.0, 2: 3.0}) == pytest.approx(0, abs=1e-9)
    assert arrays.serial_share({1: 6.0, 2: 2.0}) == 0


def test_the_time_of_the_kernel_is_that_of_the_threads():
    ran = []
    geometry = co.Scene()._prepared.geometry
    again = arrays.kernel_of(lambda: arrays.ray_queries.run_on(geometry, lambda _, a, b: ran.append((a, b)), 3, 3, 0))
    again()
    assert ran == [(0, 3), (0, 3)]
    assert arrays.ray_queries.run_on is arrays.run_on


def test_a_ball_takes_its_four_numbers_at_least():
    """Center and radius take 32 bytes; 24 GiB for ten million bodies are 2576 bytes each."""
    measured = limits.bytes_of_a_cell(SMALL)
    assert 32 < measured.ours < 1000
    assert measured.theirs == 2576


PREPARING = {row.name: row for row in preparation.ROWS}


@pytest.mark.parametrize("name", ["moved-spheres", "moved-boxes", "moved-csg", "moved-mixed"])
def test_moved_bodies_answer_as_in_a_scene_from_the_beginning(name):
    measured = PREPARING[name].measure(Size(runs=1, balls=2000))  # 20 bodies
    assert measured.apart == ""
    assert measured.theirs == 10.0


def test_a_picture_is_that_of_the_bodies_povray_gets():
    """As many pixels of the picture's middle row are lit as a line of pixel centers crosses balls."""
    each = scenes.balls(40)
    image = preparation.in_picture(scenes.spheres(each)).render(64, 64, samples=1).pixels.max(axis=-1) > 0
    centers = (np.arange(64) + 0.5) / 64 - 0.5
    x, y = np.meshgrid(centers, -centers)
    directions = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    hit = np.isfinite(brute_force_balls(each, np.broadcast_to((0, 0, -3), directions.shape), directions))
    for turned in (1, -1):  # the camera's x may be to the left
        same = (image[:, ::turned].ravel() == hit).mean()
        if same == 1:
            return
    pytest.fail("other balls are seen")


@pytest.mark.parametrize("programs", [preparation.LISTS, preparation.MOVED])
def test_our_programs_print_seconds_and_the_hit(programs, tmp_path, monkeypatch, capsys):
    each = scenes.balls(50)
    np.save(tmp_path / "balls.npy", np.column_stack([each.centers, each.radii]).astype(float))
    monkeypatch.chdir(tmp_path)
    exec(programs["conicoid"], {})
    seconds, t = map(float, capsys.readouterr().out.split())
    centers = each.centers.astype(float)
    if programs is preparation.MOVED:
        centers[1:9] += (0, 0, -0.01)
    moved = scenes.BallRows(centers, each.radii)
    expected = brute_force_balls(moved, np.array([(0, 0, -3)]), np.array([(0.01, 0.02, 1)]))[0]
    assert seconds > 0
    assert t == pytest.approx(expected, rel=1e-12)


def test_a_core_has_its_pins(tmp_path):
    """The scene has four assemblies of 3 x 3 pins 0.8 mm apart. The middle pin of each is a tube."""
    scenes.write_core(tmp_path / "geometry.xml", 2, 3)
    scene = co.load_openmc(tmp_path / "geometry.xml")
    pitch, gap = 1.26, 0.08
    centers = np.array([side * (1.5 * pitch + gap / 2) + k * pitch for side in (-1, 1) for k in (-1, 0, 1)])
    x, y = np.meshgrid(centers, centers)
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    pins = np.tile([0, 1, 0], 2)[:, None] * np.tile([0, 1, 0], 2) == 0
    fuel, clad, water = (scene.body_at(points[pins.ravel()] + (off, 0, 0)) for off in (0.0, 0.44, 0.55))
    assert len(set(fuel.tolist())) == len(set(clad.tolist())) == 32
    assert (fuel >= 0).all()
    assert (water >= 0).all()
    assert not set(fuel.tolist()) & set(clad.tolist())
    assert not set(clad.tolist()) & set(water.tolist())


# --- Whole processes in new environments: which programs they find, their answers, and how they report a failure

CACHED = """
import json, os, conicoid._util.environment
from importlib.util import cache_from_source
there = [os.path.exists(cache_from_source(each.__file__)) for each in (json, conicoid._util.environment)]
"""
BEFORE = f"import sys\nsys.dont_write_bytecode = True{CACHED}print(*there)"


def test_a_fresh_place_has_the_bytecode_of_the_standard_library_alone():
    with fresh.open_sandbox() as place:
        assert place.run(fresh._python(BEFORE))[1].split() == ["False", "False"]
        place.run(fresh._python(CACHED))
        assert place.run(fresh._python(BEFORE))[1].split() == ["True", "True"]
        with place.anew() as new:
            assert new.run(fresh._python(BEFORE))[1].split() == ["True", "False"]


@pytest.mark.deep
@pytest.mark.parametrize(("program", "check"), [(HITS[OURS], fresh.check_hit), (PICTURES[OURS], fresh.check_picture)])
def test_our_programs_give_the_expected_answers(program, check):
    ours = fresh._python(program)
    found = fresh.compare_processes(ours, ours, check, cold=False)(Size(runs=1))
    assert found.apart == ""
    assert found.ratio == found.theirs / found.ours


def test_wrong_answers_are_reported(tmp_path):
    assert fresh.check_hit("2.0\n", tmp_path) == ""
    assert fresh.check_hit("inf\n", tmp_path) == "the hit is at inf, not at 2"
    picture = np.zeros((48, 64), np.uint8)
    Image.fromarray(picture).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == "the picture shows no ball"
    picture[10:38, 18:46] = 200
    Image.fromarray(picture).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == ""
    Image.fromarray(picture[:40]).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == "the picture has 40 x 64 pixels"


def test_a_program_that_fails_is_absent_with_its_last_words():
    with fresh.open_sandbox() as place, pytest.raises(Absent, match="ended with 1: ValueError: no such thing"):
        place.run(fresh._python("raise ValueError('no such thing')"))
