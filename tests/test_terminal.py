"""Progress, notes and numbers on a terminal; how mistakes in files are raised."""

from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

import conicoid as co
from conicoid._util.files import SceneFileError
from conicoid._util.text import format_bytes
from conicoid.cli import terminal


def bar_text(monkeypatch: pytest.MonkeyPatch, is_terminal: bool) -> str:
    stream = io.StringIO()
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    monkeypatch.setattr(terminal, "console", lambda: Console(file=stream, force_terminal=is_terminal, width=100))
    with terminal.Bar("tracing", "ray") as bar:
        bar(100, 400)
        bar(200, 400)
    return stream.getvalue()


def test_progress_has_rate_and_time_left(monkeypatch):
    text = bar_text(monkeypatch, is_terminal=True)
    assert "tracing" in text
    assert "50%" in text
    assert "ray/s" in text
    assert re.search(r"\d:\d\d:\d\d", text)


def test_no_progress_where_nobody_watches(monkeypatch):
    assert bar_text(monkeypatch, is_terminal=False) == ""


def test_numbers_for_people():
    assert [terminal.format_si(n) for n in (0, 12.345, 1234, 5.6e6, 7e9)] == ["0 ", "12.3 ", "1.23 k", "5.6 M", "7 G"]
    assert [format_bytes(n) for n in (0, 999, 1000, 12_300_000, 5 * 10**12)] == [
        "0 bytes",
        "999 bytes",
        "1 kB",
        "12.3 MB",
        "5e+03 GB",
    ]


def test_scene_file_errors_are_value_errors(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: 3\n")
    with pytest.raises(ValueError, match="must be a list") as caught:
        co.load(tmp_path / "scene.yaml")
    assert isinstance(caught.value, SceneFileError)
    assert caught.value.path == str(tmp_path / "scene.yaml")
