"""A headless browser with software GL, if there is one."""

from __future__ import annotations

import base64
import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.viewer.server import Server
from conicoid.viewer.session import Session

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (Debian: apt-get install chromium)")
SOFTWARE_GL = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
NARROW = {"width": 320, "height": 444}  # the canvas is 160 x 120 there
WIDE = {"width": 760, "height": 260}  # the panel stands beside the canvas
READ = """(() => {
    const picture = conicoid.film.read(), bytes = new Uint8Array(picture.values.buffer), parts = [];
    for (let i = 0; i < bytes.length; i += 8192) parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
    return [picture.width, picture.height, btoa(parts.join(""))];
})()"""
"""The picture's numbers as bytes, because text would take longer than drawing."""


def launch(tool: Any, *flags: str) -> Any:
    """Return a browser."""
    return tool.chromium.launch(executable_path=CHROMIUM, args=[*SOFTWARE_GL, *flags])


def until(frame: Any, expression: str) -> None:
    """Wait until an expression is true, in a page or frame whose policy forbids `wait_for_function`."""
    for _ in range(600):
        if frame.evaluate(expression):
            return
        time.sleep(0.05)
    raise AssertionError(f"never: {expression}")


class Page:
    """A page of a scene and the actions of a person."""

    def __init__(self, browser: Any, url: str, viewport: dict[str, int], **context: Any) -> None:
        self.requests: list[str] = []
        self.errors: list[str] = []
        context = {"device_scale_factor": 0.5, "accept_downloads": True} | context
        self.context = browser.new_context(viewport=viewport, **context)
        self.page = self.context.new_page()
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda line: self.errors.append(line.text) if line.type == "error" else None)
        self.page.goto(url)
        # Where there is no viewer, `conicoid` is the page's element of that name
        self.ask("(() => { if (window.conicoid.film) conicoid.film.most = 1; })()")

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: Any) -> None:
        self.context.close()

    def ask(self, expression: str) -> Any:
        return self.page.evaluate(expression)

    def settle(self) -> None:
        """Wait for a picture at rest, with one sample a pixel at its center."""
        self.page.wait_for_timeout(160)  # a picture in motion comes to rest after 140 ms
        self.ask("conicoid.film.settled(1)")

    def pixels(self) -> Any:
        """Return mean linear light of the picture, (height, width, 4), the fourth 1 where the ray meets a body."""
        self.ask("conicoid.film.changed()")
        self.settle()
        width, height, values = self.ask(READ)
        numbers = np.frombuffer(base64.b64decode(values), "<f4").astype(float)
        return numbers.reshape(height, width, 4)[::-1]

    def place(self, x: float, y: float) -> tuple[int, int]:
        """Return a pixel of the picture, from shares of its width and height."""
        box = self.page.locator("canvas").bounding_box()
        return round(x * box["width"]), round(y * box["height"])

    def ray(self, x: float, y: float) -> tuple[Any, Any]:
        """Return origin and direction of the ray through a place."""
        ray = self.ask("conicoid.rayAt({}, {})".format(*self.place(x, y)))
        return ray["origin"], ray["direction"]

    def size(self) -> tuple[int, int]:
        width, height = self.ask("[conicoid.canvas.width, conicoid.canvas.height]")
        return width, height

    def at(self, x: float = 0.5, y: float = 0.5) -> tuple[float, float]:
        """Return a place of the picture in the window, from shares of its width and height."""
        box, (right, down) = self.page.locator("canvas").bounding_box(), self.place(x, y)
        return box["x"] + right, box["y"] + down

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=4)
        mouse.up()

    def wait(self, expression: str) -> None:
        """Wait until an expression is true."""
        until(self.page, expression)

    def text(self, selector: str) -> str:
        return str(self.page.locator(selector).inner_text())


def open_exported(browser: Any, scene: co.Scene, folder, viewport: dict[str, int], **context: Any) -> Page:
    """Open the exported page of a scene."""
    path = folder / "scene.html"
    co.export(scene, path)
    return Page(browser, path.as_uri(), viewport, **context)


@contextmanager
def serve(session: Session) -> Iterator[Server]:
    """Run a server of a session in a thread."""
    with Server(session) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()
