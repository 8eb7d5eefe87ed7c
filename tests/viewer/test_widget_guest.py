"""The notebook's widget as a guest: it leaves the page around it alone, fits its cell, follows its model and ends."""

import io
import json

import numpy as np
import pytest
from PIL import Image

import conicoid as co

from .browser import needs_browser

pytest.importorskip("anywidget", reason="needs anywidget")
CAMERA = co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30)
RED = co.matte("#b02018")
BALL = co.Scene([co.Body(co.Sphere(1), RED, name="ball")], lights=[co.AmbientLight(1)], camera=CAMERA)

HOST = """<!doctype html><html><head><style>body { margin: 13px }</style><style>CSS</style></head><body>
<div id="cell" style="width: WIDTHpx"></div><script type="module">
MODULE
const listeners = new Map(), values = DATA;
const model = { get: (name) => values[name], on: (name, call) => listeners.set(name, call) };
window.end = WIDGET.render({ model, el: document.getElementById("cell") });
window.change = (data) => { values.data = data; listeners.get("change:data")(); };
</script></body></html>"""


def host(widget, width):
    assert "export default {" in widget._esm
    module = widget._esm.replace("export default {", "const WIDGET = {")
    data = json.dumps({"data": widget.data, "height": widget.height}).replace("<", "\\u003c")
    fields = {"CSS": widget._css, "WIDTH": str(width), "MODULE": module, "DATA": data}
    text = HOST
    for name, value in fields.items():
        text = text.replace(name, value, 1)
    return text


def seen(page):
    """Return grey levels of the screen."""
    return np.asarray(Image.open(io.BytesIO(page.locator("canvas").screenshot())).convert("L"), dtype=float)


@needs_browser
@pytest.mark.parametrize("width", [760, 360])
def test_it_draws_in_its_cell_and_leaves_the_page_alone(browser, tmp_path, width):
    widget = BALL.view(height=300)
    (tmp_path / "host.html").write_text(host(widget, width), encoding="utf-8")
    context = browser.new_context(viewport={"width": 800, "height": 900}, device_scale_factor=0.5)
    page = context.new_page()
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto((tmp_path / "host.html").as_uri())
    page.wait_for_function("document.querySelector('.quality').textContent.includes('samples')")
    assert page.evaluate("getComputedStyle(document.body).margin") == "13px"
    cell = page.locator(".conicoid").bounding_box()
    canvas = page.locator("canvas").bounding_box()
    assert cell["height"] == 300
    assert canvas["height"] >= 0.5 * cell["height"]
    before = seen(page)
    assert before.std() > 10
    smaller = co.Scene([co.Body(co.Sphere(0.2), RED, name="ball")], lights=[co.AmbientLight(1)], camera=CAMERA)
    page.evaluate("window.change(" + json.dumps(smaller.view(height=300).data) + ")")
    for _ in range(300):  # until it has drawn, at once or later on a busy machine
        if changed := np.abs(seen(page) - before).max() > 30:
            break
        page.wait_for_timeout(100)
    assert changed
    page.evaluate("window.end()")
    assert errors == []
    context.close()
