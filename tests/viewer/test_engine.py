"""The engine in exported pages: every bit is the desktop's, in node and in a page from a disk."""

import json
import math
import shutil
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co
from benchmarks.digest import Numbers, rays, scenes
from conicoid.kernels.first_hits import HitBuffers
from conicoid.queries.exact.error_bounds import errors_of_t
from conicoid.queries.exact.ranks import Ranks
from conicoid.viewer import html, html as engine
from conicoid.viewer.scene_data import pack_scene, pick

from ..reference.routes import in_doubt
from ..samples import deep
from .browser import WIDE, Page, needs_browser, open_exported

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")
needs_engine = pytest.mark.skipif(
    engine.read_engine() is None, reason="no engine for pages has been built of these sources (python -m native.page)"
)
RUN = Path(__file__).with_name("engine_rays.mjs")
OPEN = "Floating point cannot decide this ray: it takes the exact arithmetic of Conicoid's desktop engine."


def sheets() -> co.Scene:
    """Return bodies that the digest's scenes of solids lack, and walls that bodies share."""
    ball = co.Sphere(1.0, (3, 0, 0))
    return co.Scene([
        co.Polygon([(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0.5, 0), (0, 2, 0)]), co.Triangle((0, 0, 1), (1, 0, 1), (0, 1, 2)),
        co.Disc((0, 0, 2), (0, 1, 2), 1.0), co.Plane((1, 2, 2), -6), ball & co.HalfSpace((0, 0, 1), 0), ball,
        ball - co.Box((2, -1, -1), (4, 1, 0)), co.Cylinder((0, 0, -1), (0, 0, 1), 1),
        co.Cylinder((0, 0, -1), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1),
    ])  # fmt: skip


def rays_to_trace(scene: co.Scene, seed: int, count: int) -> Iterator[dict[str, Any]]:
    """Return rays of the digest, and tangents at their hits; some with hidden bodies, some with a section."""
    numbers, lines = Numbers(seed), []
    for origins, directions, _ in rays(numbers):
        o, d = np.broadcast_arrays(origins, directions)
        some = [numbers.next() % (o.size // 3) for _ in range(count)]
        lines += list(zip(o.reshape(-1, 3)[some], d.reshape(-1, 3)[some], strict=True))
        hits = scene.first_hit(o.reshape(-1, 3)[some], d.reshape(-1, 3)[some])
        for hit in hits[hits.hit][: count // 3]:
            along = np.cross(hit.normal, (0.5, 0.25, 1.0))
            lines.append((hit.point - 2 * along, along))
    for k, (origin, direction) in enumerate(lines):
        if not direction.any():
            continue
        hidden = [k % len(scene.bodies)] if k % 4 == 1 else []
        section = {"normal": [0.25, 1.0, -0.5], "offset": (k % 5 - 2) / 4} if k % 4 == 2 else None
        yield {"origin": origin.tolist(), "direction": direction.tolist(), "hidden": hidden, "section": section}


def bits(value: Any) -> Any:
    """Return the same with every number as the bits of its float64."""
    if isinstance(value, dict):
        return {name: bits(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [bits(item) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return "nan" if math.isnan(value) else str(struct.unpack("<q", struct.pack("<d", value))[0])


def in_node(cases: list[tuple[co.Scene, list[dict[str, Any]]]], folder: Path) -> list[list[Any]]:
    """Return the answers of the page's engine."""
    module, cases_file = folder / "page.mjs", folder / "cases.json"
    module.write_text(html.script() + "\nexport { Exact, bitsOf, decodedScene };\n", encoding="utf-8")
    data = [(pack_scene(scene), rays, scene) for scene, rays in cases]
    whole = [
        {"scene": shown, "engine": engine.engine_data(scene, shown["tables"]), "rays": rays}
        for shown, rays, scene in data
    ]
    cases_file.write_text(json.dumps(whole), encoding="utf-8")
    run = subprocess.run(
        [str(NODE), str(RUN), str(module), str(cases_file)], capture_output=True, text=True, timeout=600
    )
    assert run.returncode == 0, run.stderr[-2000:]
    answers: list[list[Any]] = json.loads(run.stdout)
    return answers


def bound(scene: co.Scene, ray: dict[str, Any], row: dict[str, Any]) -> float:
    """Return the bound without exact arithmetic."""
    errors, lines = np.empty(1), [np.array([ray[name]]) for name in ("origin", "direction")]
    t, surface = np.array([row["t"]]), np.array([row["surface"]], np.int32)
    errors_of_t(scene._prepared.geometry, scene._prepared.rest, *lines, np.zeros(0, np.int64), t, surface, 0, 1, errors)
    return float(errors[0])


def without_exact_bounds(scene: co.Scene, ray: dict[str, Any], found: Any) -> Any:
    """Return the desktop's answer in the form of a page, without bounds that take exact arithmetic."""
    if found is None:
        return None
    size = max(map(abs, ray["origin"])) / max(map(abs, ray["direction"]))
    for row in (found, *found["crossings"]):
        if row.get("surface") is not None and not bound(scene, ray, row) <= 2.0**-24 * (abs(row["t"]) + size):
            row["t_error"] = None
    return found


def compare(some: list[co.Scene], count: int, folder: Path) -> tuple[int, int, int]:
    """Return (answers with the desktop's bits, of these how many exact methods settled, rays left to the desktop)."""
    cases = [(scene, list(rays_to_trace(scene, k + 1, count))) for k, scene in enumerate(some)]
    same = settled = left = 0
    for (scene, lines), answers in zip(cases, in_node(cases, folder), strict=True):
        for ray, answer in zip(lines, answers, strict=True):
            if answer.get("error") == OPEN:
                left += 1
                continue
            expected = without_exact_bounds(scene, ray, pick(scene, ray)["found"])
            assert answer == {"found": bits(expected)}, ray
            same += 1
            settled += bool(in_doubt(scene, co.Rays(ray["origin"], ray["direction"]))[0])
    return same, settled, left


@needs_node
@needs_engine
@pytest.mark.parametrize(("every", "rays", "least"), [(5, 30, (1000, 20)), deep((1, 150, (10_000, 200)))])
def test_every_bit_is_the_desktops(tmp_path, every, rays, least):
    some = list(scenes())
    same, settled, left = compare([*some[::every], some[-3], sheets()], rays, tmp_path)
    assert same > least[0]
    assert settled > least[1]
    assert left < same // 10


@needs_engine
def test_a_page_has_the_memory_that_the_kernels_declare():
    """A new field of `Ranks` or `HitBuffers` is in the page without a change there, with the size of `record_shapes`."""
    scene = sheets()
    data, tables = engine.engine_data(scene, {}), scene._prepared.lowered.tables
    lengths = {"surface_kind": len(tables.surface_kind), "polygon_surface": len(tables.polygon_surface)}
    assert [count for _, count in data["ranks"]] == [eval(size, lengths) for size in Ranks.__shapes__.values()]
    assert [name for name, _ in data["hit"]] == list(HitBuffers._fields)


@needs_node
@needs_engine
def test_exact_arithmetic_is_left_to_the_desktop(tmp_path):
    """The ray enters both balls at t = 5 - sqrt(3)/2, which no float is. Only exact arithmetic finds one t."""
    scene = co.Scene([co.Sphere(1.0), co.Sphere(1.0, (1.0, 0.0, 0.0))])
    ray = {"origin": [0.5, 0.0, 5.0], "direction": [0.0, 0.0, -1.0], "hidden": [], "section": None}
    assert in_node([(scene, [ray])], tmp_path) == [[{"error": OPEN}]]


@needs_node
@needs_engine
def test_a_hidden_body_does_not_answer_for_the_wall_it_shares(tmp_path):
    """A rod is hidden.

    From within, the ray meets the bore around it first: one surface, which the list has as the rod's.
    """
    turn = (1, 2, 3), 40
    rod, tube = (co.Cylinder((0, 0, -1), (0, 0, 1), radius).rotate(*turn) for radius in (0.7, 1.9))
    ball = co.Sphere(0.4, (0.2, 0.1, 0.3))
    scene = co.Scene([ball, rod, tube - rod, co.Box((-3, -3, -3), (3, 3, 3)) - ball])
    directions = np.random.default_rng(3).normal(size=(60, 3)).tolist()
    lines = [{"origin": [-0.2, -0.1, 0.0], "direction": d, "hidden": [0, 1], "section": None} for d in directions]
    expected = [pick(scene, ray) for ray in lines]
    assert in_node([(scene, lines)], tmp_path) == [bits(expected)]
    assert {0, 1} & {scene.first_hit(ray["origin"], ray["direction"]).body for ray in lines}
    assert {answer["found"]["body"] for answer in expected} == {2, 3}


@needs_node
@needs_engine
def test_all_bodies_have_their_names(tmp_path):
    """The names include those beyond the length of the page's list."""
    bodies = [co.Body(co.Sphere(0.1, (k, 0, 0)), name=f"\u00e4 {k}" if k % 2 else None) for k in range(450)]
    rays = [{"origin": [k, 0, 9], "direction": [0, 0, -1], "hidden": [], "section": None} for k in (0, 1, 448, 449)]
    found = [answer["found"]["name"] for answer in in_node([(co.Scene(bodies), rays)], tmp_path)[0]]
    assert found == ["Sphere 0", "\u00e4 1", "Sphere 448", "\u00e4 449"]


@needs_node
@needs_engine
def test_the_engine_takes_nothing_from_javascript(tmp_path):
    code = engine.read_engine()
    (tmp_path / "engine.wasm").write_bytes(code)
    script = "console.log(WebAssembly.Module.imports(new WebAssembly.Module(require('fs').readFileSync(process.argv[1]))).length)"
    run = subprocess.run(
        [str(NODE), "-e", script, str(tmp_path / "engine.wasm")], capture_output=True, text=True, timeout=60
    )
    assert run.stdout.strip() == "0", run.stderr
    assert len(code) < 256 << 10


SCENE = co.Scene(
    [
        co.Body(co.Sphere(0.8, (-1, 0, 0)), co.matte("#c03028"), name="red ball"),
        co.Body(co.Box((0.4, -0.6, -0.6), (1.6, 0.6, 0.6)) - co.Sphere(0.4, (1, -0.6, 0)), name="block"),
    ],
    lights=[co.AmbientLight(0.4)],
    camera=co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30),
)
HIT = ".found:not([hidden]) table.hit"


@needs_browser
@needs_engine
def test_a_click_in_a_file_shows_the_desktops_numbers(browser, tmp_path):
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        for x in (0.33, 0.62):
            page.page.mouse.click(*page.at(x))
            page.page.wait_for_selector(HIT)
            ray = page.ray(x, 0.5)
            hit, spans = SCENE.first_hit(*ray), SCENE.spans(*ray)
            page.wait(f"conicoid.state.found.t === {float(hit.t)!r}")
            text = page.text(".found")
            assert "Exact: computed in this page, to the same bits as by Conicoid's engine." in text
            for number in (hit.t, hit.t_error, *hit.point, *hit.normal, *spans.t_enter, *spans.t_exit):
                assert page.ask(f"String({float(number)!r})") in text
        assert page.requests == [(tmp_path / "scene.html").as_uri()]
        assert page.errors == []


@needs_browser
@needs_engine
def test_a_ray_is_typed(browser, tmp_path):
    """From x = -1 along y the ball is at -0.8. Enter and the button trace, and a text that is not a ray is refused."""
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.page.get_by_label("Origin", exact=True).fill("[-1, -5, 0]")
        page.page.get_by_label("Direction", exact=True).fill("0 2.0 0")
        page.page.get_by_label("Direction", exact=True).press("Enter")
        page.page.wait_for_selector(HIT)
        hit = SCENE.first_hit((-1, -5, 0), (0, 2, 0))
        assert page.ask("conicoid.state.found.t") == hit.t
        assert hit.t == pytest.approx(2.1, rel=1e-15)
        page.page.get_by_label("Direction", exact=True).fill("0, 2")
        page.page.get_by_role("button", name="Ask").click()
        page.wait("document.querySelector('.toast').textContent === 'Direction: three numbers, such as 0, 0, 5'")
        page.page.get_by_label("Direction", exact=True).fill("0, 0, 0")
        page.page.get_by_role("button", name="Ask").click()
        page.wait("document.querySelector('.toast').textContent.includes('the direction is zero')")
        page.page.mouse.click(*page.at(0.33))
        page.wait("document.querySelector('[name=origin]').value === '0, -8, 0'")
        assert page.errors == []


@needs_browser
@needs_engine
def test_a_browser_has_the_bits_of_the_desktop(browser, tmp_path):
    """The rays go through places of the picture, as clicks do."""
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.page.mouse.click(*page.at(0.33))
        page.page.wait_for_selector(HIT)
        lines = [page.ray(x / 16, y / 8) for x in range(16) for y in range(8)]
        rays = [{"origin": origin, "direction": direction} for origin, direction in lines]
        state = "{ hidden: new Set(), section: null }"
        found = page.ask(f"conicoid.exact.then((exact) => {json.dumps(rays)}.map((ray) => exact.pick(ray, {state})))")
        expected = [pick(SCENE, ray) for ray in rays]
        assert bits(found) == bits(expected)
        assert sum(answer["found"] is not None for answer in expected) > 10


@needs_browser
@needs_engine
def test_a_blocked_engine_is_reported(browser, tmp_path):
    path = tmp_path / "strict.html"
    html.export(SCENE, path)
    path.write_text(path.read_text(encoding="utf-8").replace(" 'wasm-unsafe-eval'", ""), encoding="utf-8")
    with Page(browser, path.as_uri(), WIDE) as page:
        page.page.mouse.click(*page.at(0.33))
        page.page.wait_for_selector(HIT)
        assert "Computed by the shader, in single precision. The engine in this page does not run" in page.text(".how")


@needs_browser
@needs_engine
def test_undecided_answers_are_shown(browser, tmp_path):
    """Without an answer of the engine the page shows the shader's, with the reason."""
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.ask(
            "(() => { conicoid.exact = Promise.reject(new Error('No room here.')); conicoid.exact.catch(() => 0); })()"
        )
        page.page.mouse.click(*page.at(0.33))
        page.page.wait_for_selector(HIT)
        assert page.text(".how") == "Computed by the shader, in single precision. No room here."


@needs_browser
@needs_engine
def test_undecided_bounds_are_shown(browser, tmp_path):
    """The bound of a distance along an asymptote is undecided. The page shows all other parts of the answer."""
    without = "const answer = exact.pick(...asked); answer.found.t_error = null; return answer;"
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.page.mouse.click(*page.at(0.62))
        page.page.wait_for_selector(HIT)
        assert "left open" not in page.text(".found")
        page.ask(f"conicoid.exact = conicoid.exact.then((exact) => ({{ pick(...asked) {{ {without} }} }})), 0")
        page.page.mouse.click(*page.at(0.33))
        page.wait(
            "document.querySelector('.found').textContent.includes('left open: its bound takes exact arithmetic')"
        )
        assert page.ask(f"String({float(SCENE.first_hit(*page.ray(0.33, 0.5)).t)!r})") in page.text(".found")
        assert page.errors == []


@needs_browser
def test_a_page_without_an_engine_is_answered_by_the_shader(browser, tmp_path, no_engine):
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.page.mouse.click(*page.at(0.33))
        page.page.wait_for_selector(HIT)
        assert page.text(".how") == "Computed by the shader, in single precision."


@needs_engine
def test_the_engine_adds_little_to_a_page(monkeypatch):
    """The engine is compressed. Only pages that carry it may run other code than text."""
    with_it = html.page(SCENE, "x", "data:,")
    monkeypatch.setattr(engine, "read_engine", lambda: None)
    without = html.page(SCENE, "x", "data:,")
    assert len(with_it) - len(without) < 100 << 10
    assert "script-src 'unsafe-inline' 'wasm-unsafe-eval';" in with_it
    assert "script-src 'unsafe-inline';" in without
    assert "wasm" not in html.page(SCENE, "x", "data:,", {"version": 0}).partition("<body>")[0]


def test_an_engine_of_other_sources_is_not_taken(monkeypatch, tmp_path):
    module = b"\0asm\1\0\0\0"
    (tmp_path / engine.ENGINE_FILE).write_bytes(engine.stamp_sources(module, "of yesterday"))
    monkeypatch.setattr("importlib.resources.files", lambda package: tmp_path)
    assert engine.read_engine.__wrapped__() is None
    (tmp_path / engine.ENGINE_FILE).write_bytes(engine.stamp_sources(module, ""))
    assert engine.read_engine.__wrapped__() == module
    (tmp_path / engine.ENGINE_FILE).unlink()
    assert engine.read_engine.__wrapped__() is None
