"""Clicks in the widget: answers of the exact engine in the kernel, or of the shader where no kernel answers."""

import json
import math

import pytest

import conicoid as co
from conicoid.viewer.widget import answer

from .browser import WIDE, needs_browser, until
from .test_widget_guest import host

pytest.importorskip("anywidget", reason="needs anywidget")
CAMERA = co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30)
SCENE = co.Scene([co.Body(co.Sphere(1), co.matte("#b02018"), name="ball")], lights=[co.AmbientLight(1)], camera=CAMERA)
RAY = {"origin": [0.0, -8.0, 0.0], "direction": [0.0, 1.0, 0.0]}

# The model as front ends see it: messages of the page go to the kernel, and the kernel's come as events.
MODEL = """const model = { get: (name) => values[name], on: (name, call) => listeners.set(name, call),
    send: async (message) => { window.sent = (window.sent ?? 0) + 1; hear(await window.kernel(JSON.stringify(message))); } };
const hear = (text) => { if (text) listeners.get("msg:custom")(JSON.parse(text)); };
window.late = (text) => hear(text);"""


class Kernel:
    """A stand-in for a running kernel between a page and a widget; `busy` delays the answers."""

    def __init__(self, widget, busy=False):
        self.widget, self.busy, self.kept, self.answers = widget, busy, [], []
        widget.send = lambda content, buffers=None: self.answers.append(json.dumps(content))

    def __call__(self, text):
        self.widget._handle_custom_msg(json.loads(text), [])
        found = self.answers.pop() if self.answers else None
        if self.busy:
            self.kept.append(found)
            return None
        return found


def open_widget(browser, tmp_path, kernel):
    widget = SCENE.view(height=300)
    text = host(widget, 760)
    start = text.index("const model = {")
    text = text[:start] + MODEL + text[text.index("\n", start) :] if kernel is not None else text
    (tmp_path / "host.html").write_text(text, encoding="utf-8")
    page = browser.new_context(viewport=WIDE, device_scale_factor=0.5).new_page()
    page.on("pageerror", lambda error: pytest.fail(str(error)))
    between = Kernel(widget, kernel == "busy") if kernel is not None else None
    if between:
        page.expose_function("kernel", between)
    page.goto((tmp_path / "host.html").as_uri())
    until(page, "document.querySelector('.waiting').hidden")
    return page, between


def click(page):
    box = page.locator("canvas").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2 + 20, box["y"] + box["height"] / 2)
    page.wait_for_selector(".hit")
    return {row.split("\t")[0]: row.split("\t")[1] for row in page.locator(".hit").inner_text().splitlines()}


def test_the_answer_is_the_engines():
    """The ball's front is at (0, -1, 0). Its distance is 7, rounding included."""
    found = answer(SCENE, {"ask": "pick", "id": "a 1", "request": RAY})
    hit = found["answer"]["found"]
    assert found["id"] == "a 1"
    assert (hit["name"], hit["t"], hit["point"], hit["normal"]) == ("ball", 7.0, [0.0, -1.0, 0.0], [0.0, -1.0, 0.0])
    assert hit["t_error"] == SCENE.first_hit(RAY["origin"], RAY["direction"]).t_error
    assert 0 <= hit["t_error"] < 1e-14
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize(("message", "error"), [
    ({"ask": "pick", "id": 1, "request": {"origin": [0, 0, 0], "direction": [0, 0, 0]}}, "direction"),
    ({"ask": "pick", "id": 1, "request": None}, "NoneType"),
    ({"ask": "pick", "id": 1}, "request"),
])  # fmt: skip
def test_mistakes_are_answered_and_not_raised(message, error):
    found = answer(SCENE, message)
    assert set(found) == {"id", "error"}
    assert error in found["error"]


@pytest.mark.parametrize(
    "message", [None, [], "pick", {}, {"ask": "scene", "id": 1}, {"id": 1, "kind": "anywidget-command"}]
)
def test_messages_of_others_are_left_alone(message):
    assert answer(SCENE, message) is None


def test_why_is_the_working_of_the_ray_with_the_body():
    found = answer(SCENE, {"ask": "why", "id": 2, "request": RAY | {"body": 0}})
    assert found == {"id": 2, "answer": {"text": SCENE.explain(RAY["origin"], RAY["direction"], body=0).text}}
    for request in (RAY, RAY | {"body": 7}, RAY | {"body": "ball"}, None):
        assert set(answer(SCENE, {"ask": "why", "id": 3, "request": request})) == {"id", "error"}


@needs_browser
def test_a_pick_explains_itself(browser, tmp_path):
    """The ball's front is where t² − 16 t + 63 = 0 for a ray through its middle; here beside it."""
    page, _ = open_widget(browser, tmp_path, "alive")
    click(page)
    assert page.locator("pre.why").is_visible() is False
    page.locator(".reasons summary").click()
    until(page, "document.querySelector('pre.why').textContent.includes('Body 0 “ball”: hit')")
    text = page.locator("pre.why").inner_text()
    assert "B = (d, o − S) = " in text
    assert "the ray tracing notes" in text
    page.context.close()


@needs_browser
def test_the_shader_gives_no_reasons(browser, tmp_path):
    page, _ = open_widget(browser, tmp_path, None)
    click(page)
    assert page.locator(".reasons").count() == 0
    page.context.close()


@needs_browser
def test_a_click_is_answered_by_the_kernel(browser, tmp_path):
    page, _ = open_widget(browser, tmp_path, "alive")
    rows = click(page)
    assert page.locator(".how").first.inner_text() == "Computed by the exact engine."
    assert rows["Body"] == "ball"
    point, normal = ([float(word) for word in rows[name].split()] for name in ("Point", "Normal"))
    assert point == pytest.approx(normal, abs=1e-15)  # of a ball of radius 1 about the origin
    assert math.hypot(*point) == pytest.approx(1, abs=1e-15)
    assert 0 <= float(rows["Its error"].removeprefix("at most ")) < 1e-13
    page.context.close()


@needs_browser
def test_the_shader_answers_without_a_kernel_and_is_named(browser, tmp_path):
    """A notebook as HTML has the model, but no program receives its messages."""
    page, _ = open_widget(browser, tmp_path, None)
    rows = click(page)
    text = page.locator(".how").first.inner_text()
    assert text == "Computed by the shader, in single precision. No kernel has answered: it is busy, or there is none."
    assert rows["Body"] == "ball"
    assert "Its error" not in rows
    assert float(rows["Distance"]) == pytest.approx(7, abs=0.1)
    page.context.close()


@needs_browser
def test_a_busy_kernels_answer_takes_the_place_of_the_shaders(browser, tmp_path):
    page, kernel = open_widget(browser, tmp_path, "busy")
    page.locator("[name=measure]").check()
    click(page)
    assert "by the shader" in page.locator(".how").first.inner_text()
    for text in kernel.kept:
        page.evaluate("(text) => window.late(text)", text)
    until(page, "document.querySelector('.how').textContent.includes('exact engine')")
    # It is still the first of the two measured points
    assert page.locator(".distance").inner_text() == "Click a second point."
    page.context.close()
