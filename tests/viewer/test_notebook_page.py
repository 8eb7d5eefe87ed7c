"""A notebook as HTML: the scene is a page in itself there, which loads nothing."""

import html
import os
import re
import sys
from html.parser import HTMLParser
from types import SimpleNamespace

import pytest

import conicoid as co
from conicoid.viewer import widget as module
from conicoid.viewer.widget import run_by_a_program

from .browser import WIDE, needs_browser, until

pytest.importorskip("anywidget", reason="needs anywidget")
CAMERA = co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30)
SCENE = co.Scene(
    [co.Body(co.Sphere(1), co.matte("#b02018"), name='a "ball" & </iframe>')],
    lights=[co.AmbientLight(1)],
    camera=CAMERA,
)
WIDGET = "application/vnd.jupyter.widget-view+json"


def bundle():
    return SCENE.view(height=300)._repr_mimebundle_()[0]


def cell_run_by(monkeypatch, **content):
    shell = SimpleNamespace(get_parent=lambda: {"content": content})
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))


def test_the_widget_brings_a_page_for_where_there_are_no_widgets():
    found = bundle()
    assert WIDGET in found
    tags = dict(Tags(found["text/html"]).found)
    assert list(tags) == ["div", "img", "iframe"]
    assert tags["img"]["src"].startswith("data:image/webp;base64,")
    assert "connect-src 'none'" in tags["iframe"]["srcdoc"]
    assert "allow-same-origin" not in tags["iframe"]["sandbox"]
    assert re.findall(r"(?:src|href|import)[=( ]+[\"']?https?:", html.unescape(found["text/html"])) == []


def test_the_widgets_front_end_is_its_own():
    """The module imports nothing from other places."""
    widget = SCENE.view()
    addresses = set(re.findall(r"https?://[^\"'` )]+", widget._esm + widget._css))
    assert addresses == {"http://www.w3.org/2000/svg"}  # a name and no address
    assert re.findall(r"^\s*import |import\(|@import|url\(", widget._esm + widget._css, re.MULTILINE) == []


def test_a_larger_scene_leaves_the_engine_out(monkeypatch):
    monkeypatch.setattr("conicoid.viewer.html.read_engine", lambda: os.urandom(2 << 20))
    monkeypatch.setattr(module, "MOST_BYTES", 1 << 20)
    found = bundle()["text/html"]
    assert "iframe" in [tag for tag, _ in Tags(found).found]
    assert len(found) < 1 << 20


def test_a_large_scene_leaves_its_picture_only(monkeypatch):
    monkeypatch.setattr(module, "MOST_BYTES", 1000)
    tags = [tag for tag, _ in Tags(bundle()["text/html"]).found]
    assert tags == ["div", "img"]


@pytest.mark.parametrize(("content", "environment", "expected"), [
    ({"allow_stdin": False}, "", True),  # nbclient, which nbconvert, papermill and Jupyter Book use
    ({"allow_stdin": True}, "", False),
    ({}, "", False),
    ({"allow_stdin": False}, "voila/0.5", False),
])  # fmt: skip
def test_programs_are_distinguished_from_people(monkeypatch, content, environment, expected):
    cell_run_by(monkeypatch, **content)
    monkeypatch.setenv("SERVER_SOFTWARE", environment)
    assert run_by_a_program() is expected


def test_no_message_is_sent_outside_of_notebooks(monkeypatch):
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    assert run_by_a_program() is False


def test_programs_get_no_widget(monkeypatch):
    cell_run_by(monkeypatch, allow_stdin=False)
    widget = SCENE.view()
    assert widget.comm is None
    found = widget._repr_mimebundle_()[0]
    assert set(found) == {"text/html", "text/plain"}


@needs_browser
def test_the_page_draws_and_answers_without_a_network(browser, tmp_path, no_engine):
    (tmp_path / "book.html").write_text(f"<!doctype html><body>{bundle()['text/html']}</body>", encoding="utf-8")
    context = browser.new_context(viewport=WIDE, device_scale_factor=0.5)
    page = context.new_page()
    requests, errors = [], []
    page.on("request", lambda request: requests.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto((tmp_path / "book.html").as_uri())
    frame = page.locator("iframe").element_handle().content_frame()
    until(frame, "document.querySelector('.waiting').hidden")
    box = frame.locator("canvas").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    frame.wait_for_selector(".hit")
    assert 'a "ball" & </iframe>' in frame.locator(".hit").inner_text()
    assert frame.locator(".how").first.inner_text() == "Computed by the shader, in single precision."
    assert {url.partition(":")[0] for url in requests} <= {"file", "data", "about"}
    assert errors == []
    context.close()
