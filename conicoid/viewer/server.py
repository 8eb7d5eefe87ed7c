"""The server of a page: on this machine only, under one secret path, with nothing but the page and its scene."""

from __future__ import annotations

import json
import secrets
import sys
import webbrowser
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from .scene_data import MISTAKES
from .session import Session

_MOST_BYTES = 1 << 16
"""The largest body of a request."""
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class Server(ThreadingHTTPServer):
    """Listens on 127.0.0.1. Requests must name that host, come from the page itself, and know the secret path."""

    daemon_threads = True
    request_queue_size = 128  # many windows may open the page at once

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session = session
        self.token = secrets.token_urlsafe(16)
        super().__init__(("127.0.0.1", port), _Handler)
        self.hosts = {f"127.0.0.1:{self.server_port}", f"localhost:{self.server_port}"}
        self.origins = {f"http://{host}" for host in self.hosts}

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://127.0.0.1:{self.server_port}/{self.token}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a request in a thread of its own, or in this one if the system allows no more threads."""
        try:
            super().process_request(request, client_address)
        except RuntimeError:
            self.process_request_thread(request, client_address)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a page that is closed or loaded again while it waits."""
        if not isinstance(sys.exception(), (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    """Answers requests from the session of the server."""

    server: Server
    protocol_version = "HTTP/1.1"
    timeout = 30

    def do_GET(self) -> None:
        """Answer with the page, its preview, its version or its scene."""
        name = self._name()
        session = self.server.session
        if name is None:
            return
        if name == "":
            self._answer(200, "text/html; charset=utf-8", session.page().encode())
        elif name == "preview.webp":
            self._answer(200, "image/webp", session.preview())
        elif name in ("version", "scene"):
            self._call({"version": session.version, "scene": session.scene}[name], None)
        else:
            self._refuse(404, "there is nothing here")

    def do_POST(self) -> None:
        """Answer a call of the page."""
        name = self._name()
        if name is None:
            return
        calls = self.server.session.calls
        length = self.headers.get("Content-Length", "")
        # Browsers send an origin with every POST: one without is refused too
        if self.headers.get("Origin") not in self.server.origins:
            self._refuse(403, "this request comes from another page")
        elif name not in calls:
            self._refuse(404, "there is nothing here")
        elif self.headers.get_content_type() != "application/json":
            self._refuse(415, "JSON is expected")
        elif not length.isdecimal() or int(length) > _MOST_BYTES:
            self._refuse(413, f"at most {_MOST_BYTES} bytes are taken")
        else:
            self._call(calls[name], self.rfile.read(int(length)))

    def _name(self) -> str | None:
        """Return the name in the path of a request, or None after the refusal of an invalid request."""
        # A foreign name that resolves to this machine must not reach the page
        if self.headers.get("Host") not in self.server.hosts:
            self._refuse(421, "this server answers to its own name only")
            return None
        origin = self.headers.get("Origin")
        if origin is not None and origin not in self.server.origins:
            self._refuse(403, "this request comes from another page")
            return None
        parts = self.path.partition("?")[0].split("/")
        # The comparison takes the same time for every wrong token
        if len(parts) != 3 or not secrets.compare_digest(parts[1].encode(), self.server.token.encode()):
            self._refuse(404, "there is nothing here")
            return None
        return parts[2]

    def _call(self, call: Callable[[Any], Any], body: bytes | None) -> None:
        """Answer with the result of a call, or with its error."""
        try:
            answer = call(None if body is None else json.loads(body))
        except MISTAKES as error:
            self._refuse(400, str(error) or type(error).__name__)
            return
        self._answer(200, "application/json", json.dumps(answer, allow_nan=False).encode())

    def _refuse(self, status: int, why: str) -> None:
        """Answer with an error and close the connection."""
        self.close_connection = True  # the body of a refused request is not read
        self._answer(status, "application/json", json.dumps({"error": why}).encode())

    def _answer(self, status: int, kind: str, body: bytes) -> None:
        """Send a response with the headers of this server."""
        self.send_response(status)
        for name, value in {**_HEADERS, "Content-Type": kind, "Content-Length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def version_string(self) -> str:
        """Return the name of the server, without the version of Python."""
        return "conicoid"

    def log_message(self, *_: Any) -> None:
        """Log no requests."""


def serve(session: Session, port: int, browser: bool, report: Callable[[str], None]) -> None:
    """Serve a page until Ctrl-C. Raise OSError if the port is in use."""
    with Server(session, port) as server:
        try:
            report(f"{server.url}   (Ctrl-C ends)")
            if browser:
                webbrowser.open(server.url)
            server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            report("ended")
