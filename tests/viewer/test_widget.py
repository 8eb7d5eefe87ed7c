"""The widget of notebooks: its module, as anywidget runs it."""

import base64
import io
import json
import sys

import numpy as np
import pytest
from PIL import Image

import conicoid as co
from conicoid.materials.color import srgb_encode
from conicoid.viewer import scene_data as limits

from .browser import needs_browser

CAMERA = co.Camera((0, -6, 1), (0, 0, 0), field_of_view=30)
SCENE = co.Scene(
    [co.Body(co.Sphere(1) - co.Box((-0.4, -2, -0.4), (0.4, 2, 0.4)), co.matte("#c03028"))],
    lights=[co.AmbientLight(0.4), co.DirectionalLight((0.2, 1, -0.4), 0.6)],
    camera=CAMERA,
)
HOST = """<!doctype html><style>{css} body {{ margin: 0; }}</style><div id="host" style="width: 320px"></div>
<script type="module">
const module = await import(URL.createObjectURL(new Blob([{esm}], {{ type: "text/javascript" }})));
const values = {values};
module.default.render({{ model: {{ get: (name) => values[name], on() {{}} }}, el: document.getElementById("host") }});
</script>"""


def widget():
    pytest.importorskip("anywidget", reason="needs anywidget")
    return SCENE.view(height=420)


def test_a_scene_shows_itself():
    shown = widget()
    assert json.loads(shown.data)["scene"]["item_count"] == 1
    bundle = SCENE._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "application/vnd.jupyter.widget-view+json" in data


@pytest.mark.parametrize("reason", ["not installed", "too large"])
def test_else_it_is_a_picture(monkeypatch, reason):
    if reason == "too large":
        monkeypatch.setattr(limits, "MOST_BYTES", 10)
    else:
        monkeypatch.setitem(sys.modules, "anywidget", None)
        from conicoid.viewer import widget as module

        module._widget_class.cache_clear()
    data = SCENE._repr_mimebundle_()
    picture = Image.open(io.BytesIO(base64.b64decode(data["image/png"])))
    assert picture.size == (480, 360)


@needs_browser
def test_the_module_draws(browser, tmp_path):
    shown = widget()
    path = tmp_path / "host.html"
    text = json.dumps(shown._esm).replace("</", "<\\/")
    path.write_text(
        HOST.format(
            css=shown._css, esm=text, values=json.dumps({"data": shown.data, "height": 420}).replace("</", "<\\/")
        )
    )
    page = browser.new_context(viewport={"width": 320, "height": 420}, device_scale_factor=0.5).new_page()
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    samples = "parseInt(document.querySelector('#host .quality')?.textContent.split(', ')[1])"  # of each pixel
    page.wait_for_function(f"{samples} >= 4", timeout=300_000)
    url = page.evaluate("document.querySelector('#host canvas').toDataURL()")
    drawn = np.asarray(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB"), float) / 255
    page.context.close()
    assert errors == []
    height, width = drawn.shape[:2]
    expected = srgb_encode(np.clip(SCENE.render(width, height, samples=4).pixels, 0, 1))
    assert np.abs(drawn - expected).mean() < 0.02
    assert drawn.std() > 0.1
