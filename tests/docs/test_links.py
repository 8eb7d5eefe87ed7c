"""The link checker of the site: it finds what is wrong with a small site, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.tools.links import problems


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "other.html").write_text('<h1 id="top">Other</h1><a href="../index.html#here">back</a>')
    (tmp_path / "picture name.png").write_bytes(b"")
    return tmp_path


@pytest.mark.parametrize(
    "link",
    [
        '<a href="sub/other.html#top">',
        '<a href="#here">',
        '<a href="sub/other.html?x=1">',
        '<img src="picture%20name.png">',
        '<img src="data:image/png;base64,">',
        '<a href="https://example.org/nowhere">',
        '<a href="mailto:a@example.org">',
    ],
)
def test_what_is_right(site: Path, link: str):
    (site / "index.html").write_text(f'<p id="here">{link}')
    assert problems(site) == []


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ('<a href="missing.html">', "no such file"),
        ('<a href="sub/other.html#bottom">', "no such place"),
        ('<a href="#there">', "no such place"),
        ('<img src="missing.png">', "no such file"),
        ('<iframe src="live/missing.html">', "no such file"),
        ('<script src="https://example.org/x.js">', "another host"),
        ('<link rel="stylesheet" href="//example.org/x.css">', "another host"),
        ('<img src="https://example.org/x.png">', "another host"),
    ],
)
def test_what_is_wrong(site: Path, link: str, why: str):
    (site / "index.html").write_text(f'<p id="here">{link}')
    (found,) = problems(site)
    assert found.startswith("index.html: ")
    assert why in found


def test_a_link_out_of_the_site(site: Path):
    (site.parent / "outside.html").write_text("")
    (site / "index.html").write_text('<p id="here"><a href="../outside.html">')
    assert "outside of the site" in problems(site)[0]
