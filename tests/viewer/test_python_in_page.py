"""The playground with Python itself: in Chromium, with Pyodide, every bit is the desktop's.

It needs the files of such a page in PLAYGROUND_FILES. `.ci/pyodide.py` makes them where NumPy for Pyodide is available.
"""

import functools
import json
import os
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from .browser import Page, needs_browser
from .test_engine import bits
from .test_playground import WIDE, WRONG, answer, examples, rays_of

FILES = os.environ.get("PLAYGROUND_FILES", "")
pytestmark = [
    needs_browser,
    pytest.mark.skipif(not FILES, reason="needs a playground with Pyodide (.ci/pyodide.py makes one)"),
]


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Log nothing for a request."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=FILES)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_every_bit_is_the_desktops(browser, address):
    with Page(browser, address, WIDE) as found:
        found.page.set_default_timeout(120_000)
        found.page.wait_for_selector(".found:not([hidden]) table.hit")
        assert "computed by Conicoid itself, which runs in this page" in found.text(".found")
        compared = 0
        for example in examples():
            request = json.dumps({"text": example["text"]})
            found.ask(
                f"playground.brain.ask('typed', {request}).then((answer) => {{ window.number = answer.number; }})"
            )
            for ray in rays_of(example, 12):
                got = found.ask(f"playground.brain.ask('pick', {{ ...{json.dumps(ray)}, number: window.number }})")
                assert bits(got) == bits(answer(example["text"], ray)), (example["name"], ray)
                compared += got["found"] is not None
        assert compared > 40
        assert found.errors == []
        assert all(each.startswith((address, "data:", "blob:")) for each in found.requests)


def test_mistakes_are_those_of_the_desktop(browser, address):
    from conicoid.viewer.playground import TextScenes

    with Page(browser, address, WIDE) as found:
        got = found.ask(f"playground.brain.ask('typed', {json.dumps({'text': WRONG})})")
        assert got == TextScenes().typed({"text": WRONG})


def test_a_failed_python_is_reported(browser, address):
    context = browser.new_context(viewport=WIDE)
    context.route("**/*.whl", lambda route: route.fulfill(status=404))
    page = context.new_page()
    page.goto(address)
    page.get_by_text("Python does not run here: conicoid-").wait_for(timeout=120_000)
    context.close()
