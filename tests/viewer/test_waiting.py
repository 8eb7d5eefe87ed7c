"""The page before the shader's first frame, and without any. Tests slow and break drivers by hand."""

import base64
import http.client
import io
import re
import threading

import numpy as np
import pytest
from PIL import Image

import conicoid as co
from conicoid.viewer import export, html, page, session
from conicoid.viewer.session import Session

from .browser import SOFTWARE_GL, WIDE, Page, needs_browser, serve, until

CAMERA = co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30)
BALL = co.Scene([co.Body(co.Sphere(1), co.matte("#d03020"))], lights=[co.AmbientLight(1)], camera=CAMERA)

# A driver that compiles until the test lets it end; one that fails; one that stops while it compiles
SLOW = """const ask = WebGL2RenderingContext.prototype.getParameter, get = WebGL2RenderingContext.prototype.getProgramParameter;
    const extension = WebGL2RenderingContext.prototype.getExtension, COMPLETE = 0x91b1;
    WebGL2RenderingContext.prototype.getExtension = function (name) {
        const found = extension.call(this, name);
        return name === "KHR_parallel_shader_compile" ? { COMPLETION_STATUS_KHR: COMPLETE } : found;
    };
    window.compiled = false;
    WebGL2RenderingContext.prototype.getProgramParameter = function (program, name) {
        if (name === COMPLETE) return window.compiled;
        if (name === this.LINK_STATUS && !window.compiled) throw new Error("waited for the driver");
        return get.call(this, program, name);
    };"""
BROKEN = """const source = WebGL2RenderingContext.prototype.shaderSource;
    WebGL2RenderingContext.prototype.shaderSource = function (shader, text) { source.call(this, shader, text + "nonsense"); };"""


def open_page(browser, url, script):
    context = browser.new_context(viewport=WIDE, device_scale_factor=0.5)
    found = context.new_page()
    found.on("pageerror", lambda error: pytest.fail(str(error)))
    found.add_init_script(script)
    found.goto(url)
    return found


def share_of_red(found):
    """Return the share of the stage's middle row, without words and buttons, that has the ball's color."""
    pixels = np.asarray(Image.open(io.BytesIO(found.locator(".stage").screenshot())).convert("RGB"), float)
    row = pixels[len(pixels) // 2]
    return ((row[:, 0] > 120) & (row[:, 1] < 80) & (row[:, 2] < 80)).mean()


@needs_browser
@pytest.mark.parametrize("kind", ["exported", "served"])
def test_the_engines_picture_and_a_line_stand_there_while_the_driver_compiles(browser, tmp_path, kind):
    export(BALL, tmp_path / "scene.html")
    with serve(Session(BALL, "scene")) as server:
        url = server.url if kind == "served" else (tmp_path / "scene.html").as_uri()
        found = open_page(browser, url, SLOW)
        until(found, "window.conicoid.film?.compiling > 0")
        words = found.locator(".waiting p[role=status]")
        until(found, "document.querySelector('.waiting img').naturalWidth >= 200")
        assert "compiling the shader" in words.inner_text()
        until(found, "document.querySelector('.waiting p').textContent.includes('picture by the engine')")
        # A ball of radius 1 in a picture 2 · 8 · tan 15° high, as wide as the stage
        width, height = found.evaluate("[conicoid.canvas.clientWidth, conicoid.canvas.clientHeight]")
        radius = height * np.tan(np.arcsin(1 / 8)) / (2 * np.tan(np.radians(15)))
        assert share_of_red(found) == pytest.approx(2 * radius / width, rel=0.05)
        assert found.evaluate("conicoid.film.samples") == 0
        found.evaluate("window.compiled = true")
        until(found, "document.querySelector('.waiting').hidden")
        assert found.evaluate("conicoid.film.samples") >= 1
        assert not words.is_visible()
        assert share_of_red(found) == pytest.approx(2 * radius / width, rel=0.05)
        found.context.close()


@needs_browser
def test_a_shader_that_the_driver_refuses_leaves_words_and_the_picture(browser, tmp_path):
    export(BALL, tmp_path / "scene.html")
    found = open_page(browser, (tmp_path / "scene.html").as_uri(), BROKEN)
    found.wait_for_selector("[role=alert]")
    assert "This browser's driver does not take the shader" in found.locator("[role=alert]").inner_text()
    assert (
        found.evaluate(
            "(async () => { const i = document.querySelector('img'); await i.decode(); return i.naturalWidth; })()"
        )
        >= 200
    )
    found.context.close()


@needs_browser
def test_a_driver_that_stops_in_compiling_is_reported(browser, tmp_path):
    export(BALL, tmp_path / "scene.html")
    found = open_page(browser, (tmp_path / "scene.html").as_uri(), SLOW)
    until(found, "window.conicoid.film?.compiling > 0")
    found.evaluate("conicoid.graphics.gl.getExtension('WEBGL_lose_context').loseContext()")
    found.wait_for_selector("[role=alert]:visible")
    assert "The graphics driver gave up on the shader" in found.locator("[role=alert]").inner_text()
    assert found.locator("img").is_visible()
    found.context.close()


@needs_browser
def test_a_changed_scene_whose_shader_fails_leaves_the_last_picture(browser, tmp_path):
    """More parts need a shader of other sizes, which compiles anew."""
    path = tmp_path / "scene.yaml"
    co.save(BALL, path)
    with serve(Session(co.load(path), "scene", path)) as server, Page(browser, server.url, WIDE) as found:
        found.wait("document.querySelector('.waiting').hidden")
        found.ask(f"(() => {{ {BROKEN} }})()")
        parts = co.Box() | co.Sphere(1.2) | co.Cylinder((0, 0, -2), (0, 0, 2), 0.3)
        co.save(co.Scene([parts], camera=CAMERA), path)
        found.wait("!document.querySelector('.trouble').hidden")
        assert "This scene cannot be drawn." in found.text(".trouble")
        assert found.page.locator("canvas").is_visible()


@needs_browser
def test_without_scripts_the_picture_and_a_line_are_there(playwright_tool, tmp_path):
    from .browser import CHROMIUM

    export(BALL, tmp_path / "scene.html")
    browser = playwright_tool.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE_GL)
    context = browser.new_context(viewport=WIDE, java_script_enabled=False)
    found = context.new_page()
    found.goto((tmp_path / "scene.html").as_uri())
    assert found.locator("noscript").inner_text() == "To walk around in this scene, allow JavaScript."
    assert not found.locator(".waiting > p").is_visible()
    assert share_of_red(found) > 0.05
    browser.close()


def test_the_picture_stands_before_the_data_and_once():
    """A page of many megabytes shows it before it has read them."""
    source = html.as_url(html.preview_of(BALL))
    text = page(BALL, "ball", source)
    assert text.count(source) == 1
    assert text.index(source) < text.index('id="conicoid-data"')
    kind, data = re.match(r"data:(\S+);base64,(\S+)", source).groups()
    assert (kind, Image.open(io.BytesIO(base64.b64decode(data))).format) == ("image/webp", "WEBP")


def test_the_small_picture_is_made_once_without_waiting(monkeypatch):
    begun, go, calls = threading.Event(), threading.Event(), []

    def slowly(scene):
        calls.append(scene)
        begun.set()
        assert go.wait(60)
        return b"picture"

    monkeypatch.setattr(session, "preview_of", slowly)
    with serve(Session(BALL, "ball")) as server:
        answers = []

        def ask(name):
            link = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
            link.request("GET", f"/{server.token}/{name}")
            answers.append(link.getresponse().read())
            link.close()

        asking = [threading.Thread(target=ask, args=("preview.webp",)) for _ in range(2)]
        for thread in asking:
            thread.start()
        assert begun.wait(60)
        ask("version")
        assert answers == [b'{"version": 0, "trouble": null}']
        go.set()
        for thread in asking:
            thread.join()
    assert answers[1:] == [b"picture", b"picture"]
    assert calls == [BALL]
