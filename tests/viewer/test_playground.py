"""The playground: it reads the text, every answer is the engine's to the bit, and mistakes have their places."""

import importlib
import json
import math
import re

import numpy as np
import pytest

import conicoid as co
from conicoid.viewer.playground import Playground, TextScenes, examples, in_page, playground_page, scene_of, worker
from conicoid.viewer.scene_data import pick

from .browser import Page, needs_browser, serve
from .test_engine import bits
from .test_server import ask

BALL = "bodies:\n  - name: ball\n    shape: {Sphere: {radius: 1}}\n"
WRONG = "bodies:\n  - name: ball\n    shape: {Sphere: {radius: -1}}\n  - name: cube\n    shape: {Box: {low: [0, 0]}}\n"
RAY = {"origin": [0.5, 0.0, 5.0], "direction": [0.0, 0.0, -2.0]}
WIDE, NARROW = {"width": 1160, "height": 320}, {"width": 400, "height": 500}
HIT = ".found:not([hidden]) table.hit"


def rays_of(example: dict[str, str], count: int) -> list[dict[str, list[float]]]:
    """Return the example's own ray, and others from there in nearly the same direction."""
    numbers = [float(word) for word in example["ray"].split()]
    turns = np.random.default_rng(5).normal(scale=0.05, size=(count, 3))
    turns[0] = 0
    return [{"origin": numbers[:3], "direction": (numbers[3:] + turn).tolist()} for turn in turns]


def answer(text: str, ray: dict[str, list[float]]) -> dict:
    """Return the engine's own answer about a ray."""
    scene, (origin, direction) = scene_of(text), ray.values()
    found = pick(scene, ray)["found"]
    if found is None:
        return {"found": None}
    crossings, spans = scene.crossings(origin, direction), scene.spans(origin, direction)
    for row, normal in zip(found["crossings"], crossings.normal, strict=True):
        row["normal"] = normal.tolist()
    for row, enter, exit_ in zip(found["spans"], spans.t_enter_error, spans.t_exit_error, strict=True):
        row["enter_error"], row["exit_error"] = (e if math.isfinite(e) else None for e in (enter, exit_))
    return {"found": found}


# Without a browser ----------------------------------------------------------------------------------


def test_every_example_has_a_ray_that_meets_something():
    for example in examples():
        assert scene_of(example["text"]).crossings(*rays_of(example, 1)[0].values()).t.size >= 2, example["name"]
        assert max(map(len, example["text"].splitlines())) < 100


def test_the_example_of_touching_bodies():
    """The squares of the floats next to 0.28 and 0.96 add up to less than 1, and those of 0.6 and 0.8 to more."""
    from fractions import Fraction

    assert Fraction(0.28) ** 2 + Fraction(0.96) ** 2 < 1 < Fraction(0.6) ** 2 + Fraction(0.8) ** 2
    scene = scene_of(next(example["text"] for example in examples() if "touches" in example["name"]))
    assert scene.first_hit((0.28, -3, 0.96), (0, 1, 0)).hit
    assert not scene.first_hit((0.6, -3, 0.8), (0, 1, 0)).hit


def test_answers_have_normals_and_bounds_in_every_row():
    scenes = TextScenes()
    for example in examples():
        number = scenes.typed({"text": example["text"]})["number"]
        for ray in rays_of(example, 4):
            assert bits(scenes.pick({**ray, "number": number})) == bits(answer(example["text"], ray))


def test_hidden_bodies_and_a_section_keep_their_rows():
    """The ball from 4 to 6 is cut at z = 0.25, where no wall is. That end has no bound."""
    scenes = TextScenes()
    number = scenes.typed({"text": BALL + "  - {name: lid, shape: {Box: {low: [-1, -1, 2], high: [1, 1, 3]}}}\n"})[
        "number"
    ]
    ray = {"origin": [0.0, 0.0, 5.0], "direction": [0.0, 0.0, -1.0], "number": number}
    cut = scenes.pick({**ray, "hidden": [1], "section": {"normal": [0, 0, 1], "offset": 0.25}})["found"]
    assert [(row["name"], row["enter"], row["exit"]) for row in cut["spans"]] == [("ball", 4.75, 6.0)]
    assert cut["spans"][0]["enter_error"] is None
    assert 0 <= cut["spans"][0]["exit_error"] < 1e-15
    assert [row["normal"] for row in cut["crossings"]] == [[0.0, 0.0, -1.0]]


def test_mistakes_have_their_places():
    found = TextScenes().typed({"text": WRONG})
    lines, places = WRONG.splitlines(), [(problem["line"], problem["column"]) for problem in found["problems"]]
    assert places == [(3, lines[2].index("-1") + 1), (5, lines[4].index("[0, 0]") + 1)]
    assert found["count"] == 2
    assert ["ball" in problem["where"] for problem in found["problems"]] == [True, False]
    assert TextScenes().typed({"text": ""})["problems"][0]["line"] == 0


def test_no_file_is_read(tmp_path, monkeypatch):
    """A scene in the text that names a file of numbers finds none, in any working folder of Python."""
    np.save(tmp_path / "balls.npy", np.zeros((2, 4)))
    monkeypatch.chdir(tmp_path)
    found = TextScenes().typed({"text": "bodies:\n  - shape: {Spheres: {file: balls.npy}}\n"})
    assert found["problems"]
    assert "scene" not in found


def test_pages_that_are_open_at_once_have_their_own_scenes():
    scenes = TextScenes()
    first, second = (scenes.typed({"text": BALL.replace("1}", f"{radius}}}")})["number"] for radius in (1, 2))
    ray = {"origin": [0, 0, 5], "direction": [0, 0, -1]}
    assert [scenes.pick({**ray, "number": n})["found"]["t"] for n in (first, second, first)] == [4.0, 3.0, 4.0]
    for _ in range(16):
        scenes.typed({"text": BALL})
    with pytest.raises(ValueError, match="no longer known"):
        scenes.pick({**ray, "number": first})


def test_python_in_a_page_speaks_json():
    ask_it = in_page()
    number = json.loads(ask_it("typed", json.dumps({"text": BALL})))["answer"]["number"]
    found = json.loads(ask_it("pick", json.dumps({**RAY, "number": number})))["answer"]
    assert bits(found) == bits(answer(BALL, RAY))
    refused = json.loads(ask_it("pick", json.dumps({**RAY, "direction": [0, 0, 0], "number": number})))
    assert "direction" in refused["error"]
    assert "error" in json.loads(ask_it("typed", "{}"))


def test_a_served_playground_serves_its_files_alone():
    with serve(Playground()) as server:
        status, text = ask(server, "GET", "")
        assert (status, b'name="scene"' in text) == (200, True)
        assert json.loads(ask(server, "POST", "typed", json.dumps({"text": WRONG}))[1])["count"] == 2
        assert ask(server, "POST", "edit", json.dumps({"path": [], "value": 1}))[0] == 404
        status, message = ask(server, "POST", "typed", json.dumps({"text": "#" * 70_000}))
        assert (status, json.loads(message)) == (413, {"error": "at most 65536 bytes are taken"})


def test_the_playground_begins_with_a_file_and_the_files_it_names(tmp_path):
    np.save(tmp_path / "balls.npy", np.array([[0.0, 0, 0, 1], [3, 0, 0, 1]]))
    co.save(co.Scene([co.Spheres(np.arange(600.0).reshape(200, 3), 1.0)]), tmp_path / "many.yaml")
    session = Playground(tmp_path / "many.yaml")
    assert "Spheres" in session.page()
    number = session.calls["typed"]({"text": (tmp_path / "many.yaml").read_text(encoding="utf-8")})["number"]
    assert session.calls["pick"]({"origin": [0, 1, 9], "direction": [0, 0, -1], "number": number})["found"]["body"] == 0


def test_a_page_with_python_names_its_address():
    text = playground_page(
        scene_of(BALL), None, python={"pyodide": "pyodide/", "packages": ["numpy"], "wheel": "x.whl"}
    )
    assert "worker-src 'self'" in text
    assert '"wheel":"x.whl"' in text
    assert "{{" not in text.partition("<script")[0]


# In a browser ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def playground_server():
    with serve(Playground()) as server:
        yield server


@needs_browser
def test_the_bits_of_the_engine_are_in_the_page(browser, playground_server):
    with Page(browser, playground_server.url, WIDE) as found:
        found.wait("window.playground && playground.brain.number > 0")
        for example in examples():
            for ray in rays_of(example, 3):
                words = " ".join(map(repr, (*ray["origin"], *ray["direction"])))
                found.ask(f"playground.take({json.dumps(example['text'])}, {json.dumps(words)})")
                expected = answer(example["text"], ray)["found"]
                shown = found.ask("conicoid.state.found")
                assert bits({name: (shown or {}).get(name) for name in expected or {}}) == bits(expected or {})
                assert (shown is None) == (expected is None)
        assert found.errors == []


@needs_browser
def test_a_promise_of_a_scene_that_waits_ends_when_it_is_drawn(browser, playground_server):
    """Of three scenes the first is pending, and the third replaces the second. All that wait, wait for the third."""
    with Page(browser, playground_server.url, WIDE) as found:
        found.wait("window.playground && playground.brain.number > 0")
        for index, last in enumerate((0.5, 0.25, 0.75)):
            texts = [BALL.replace("1}", f"{radius}}}") for radius in (1, 2, last)]
            takes = ", ".join(f"playground.take({json.dumps(text)}, '0 0 3 0 0 -1')" for text in texts)
            assert found.ask(f"[{takes}][{index}].then(() => conicoid.state.found.t)") == 3 - last
        assert found.errors == []


@needs_browser
def test_a_change_is_read_and_the_ray_traced_again(browser, playground_server):
    """A ray from 3 meets the ball of radius 1 at 2, and of radius 0.5 at 2.5. A mistake keeps the last good scene."""
    with Page(browser, playground_server.url, WIDE) as found:
        found.wait("window.playground && playground.brain.number > 0")
        found.ask(f"playground.take({json.dumps(BALL)}, '0 0 3 0 0 -1')")
        found.page.wait_for_selector(HIT)
        assert found.ask("conicoid.state.found.t") == 2.0
        text = found.page.get_by_label("The scene, as YAML")
        text.fill(BALL.replace("1}", "0.5}"))
        found.wait("conicoid.state.found?.t === 2.5")
        assert found.text(".reading") == "1 body, as typed."
        text.fill(WRONG)
        found.wait("document.querySelectorAll('.problems li').length === 2")
        assert found.text(".reading") == "2 mistakes; the last good scene is shown."
        assert found.page.locator(".numbers .bad").all_inner_texts() == ["3\n", "5\n"]
        assert found.ask("conicoid.state.found.t") == 2.5
        found.page.locator(".problems button").nth(1).click()
        assert found.ask("playground.text.value.slice(playground.text.selectionStart).startsWith('[0, 0]')")
        text.fill(BALL)
        found.wait("conicoid.state.found?.t === 2")
        assert not found.page.locator(".problems").is_visible()
        text.fill("bodies: [")
        text.press("Control+Enter")  # without delay
        found.wait("document.querySelectorAll('.problems li').length === 1")


@needs_browser
def test_the_table_has_every_crossing_with_its_bound_and_normal(browser, playground_server):
    with Page(browser, playground_server.url, WIDE) as found:
        found.page.wait_for_selector(HIT)
        first = examples()[0]
        expected = answer(first["text"], rays_of(first, 1)[0])["found"]
        text = found.text(".found")
        assert len(expected["crossings"]) == 4
        for row in expected["crossings"]:
            for number in (row["t"], *row["normal"]):
                assert found.ask(f"String({number!r})") in text
        bounds = [row[f"{end}_error"] for row in expected["spans"] for end in ("enter", "exit")]
        bounds += [row["t_error"] for row in expected["crossings"]]
        shown = [float(word) for word in re.findall(r"± (\S+?)[,;\s]", text)]
        assert len(shown) == len(bounds) == 8
        assert all(bound <= rounded < 1.1 * bound for bound, rounded in zip(bounds, shown, strict=True))
        assert found.page.locator(".overlay path.within").count() == len(expected["spans"])


@needs_browser
def test_a_link_holds_the_scene_and_the_ray(browser, playground_server):
    with Page(browser, playground_server.url, WIDE) as found:
        found.wait("window.playground && playground.brain.number > 0")
        found.ask(f"playground.take({json.dumps(BALL + '# über')}, '0 0 3 0 0 -0.1')")
        found.wait("location.hash.endsWith('-0.1')")
        address = found.ask("location.href")
    with Page(browser, address, WIDE) as found:
        found.page.wait_for_selector(HIT)
        assert found.ask("playground.text.value") == BALL + "# über"
        assert found.ask("conicoid.state.found.t") == co.Scene([co.Sphere(1)]).first_hit((0, 0, 3), (0, 0, -0.1)).t
    with Page(browser, playground_server.url + "#scene=nothing", WIDE) as found:
        found.wait("document.querySelector('.toast').textContent === 'The link holds no scene that can be read.'")


@needs_browser
def test_it_fits_a_phone_and_the_keyboard(browser, playground_server):
    """Nothing is wider than 400 pixels. Tab goes from the examples to the link, the text, the picture and the ray."""
    with Page(browser, playground_server.url, NARROW) as found:
        found.page.wait_for_selector(HIT)
        assert found.ask("document.documentElement.scrollWidth") == 400
        assert found.ask("document.querySelector('.conicoid').scrollWidth") <= 400
        tops = [
            found.ask(f"document.querySelector('{part}').getBoundingClientRect().top")
            for part in (".stage", ".typing", ".panel")
        ]
        assert tops == sorted(tops)
        names = []
        for _ in range(24):
            found.page.keyboard.press("Tab")
            names.append(
                found.ask(
                    "document.activeElement.name || document.activeElement.dataset.do || document.activeElement.tagName"
                )
            )
        order = ["example", "link", "scene", "CANVAS", "fit", "origin", "direction", "ask"]
        assert [name for name in names if name in order] == order
        assert found.errors == []


def test_the_worker_asks_a_function_that_is_there() -> None:
    """Python in the page needs Pyodide; its first line does not."""
    line = re.search(r"from ([\w.]+) import (\w+)", worker())
    assert line is not None
    assert getattr(importlib.import_module(line[1]), line[2]) is in_page
