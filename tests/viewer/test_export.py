"""Pages in files: their contents and their size."""

import re
from pathlib import Path

import pytest

import conicoid as co
from conicoid.kernels.tables import Tables
from conicoid.viewer import export, page, scene_data as limits
from conicoid.viewer.html import PREVIEW_BYTES, preview_of
from conicoid.viewer.scene_data import expand_tables

from ..command_line import execute, failure
from .browser import NARROW, launch, needs_browser, open_exported

# --- The exported page: small, alone, safe; and its message where it cannot draw

BARREL = Path(__file__).resolve().parents[2] / "examples" / "scenes" / "barrel.yaml"


def test_the_barrel_is_small_and_alone(tmp_path, no_engine):
    execute("export", BARREL, tmp_path / "barrel.html")
    text = (tmp_path / "barrel.html").read_text(encoding="utf-8")
    assert len(text.encode()) < 200 * 1024
    assert re.findall(r"(?:src|href)=[\"']?(?!data:)[a-z]+:", text) == []
    assert "connect-src 'none'" in text


def test_the_policy_of_a_page_leaves_nothing_open(tmp_path):
    """The policy must name all that `default-src` does not cover: targets of forms and the base of relative links."""
    served, alone = (page(co.Scene([co.Sphere()]), "x", "", more) for more in ({"version": 0}, None))
    for text, connect in ((served, "'self'"), (alone, "'none'")):
        (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
        rules = dict(rule.split(maxsplit=1) for rule in policy.split("; "))
        assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"
        assert rules["connect-src"] == connect
        assert "'unsafe-eval'" not in rules["script-src"]


@needs_browser
def test_the_page_loads_nothing(browser, tmp_path):
    with open_exported(browser, co.load(BARREL), tmp_path, NARROW) as shown:
        shown.settle()
        assert shown.requests == [(tmp_path / "scene.html").as_uri()]
        assert shown.errors == []


@needs_browser
def test_a_picture_replaces_missing_webgl(playwright_tool, tmp_path):
    browser = launch(playwright_tool, "--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis")
    size = "(async () => { const i = document.querySelector('img'); await i.decode(); return i.naturalWidth; })()"
    with open_exported(browser, co.Scene([co.Sphere()]), tmp_path, NARROW) as shown:
        assert "This browser offers no WebGL 2." in shown.text("[role=alert]")
        assert shown.ask(size) >= 200
    browser.close()


@needs_browser
def test_scenes_too_large_for_browsers_are_refused_with_the_limit(browser, tmp_path):
    export(co.Scene([co.Sphere()]), tmp_path / "scene.html")
    context = browser.new_context(viewport=NARROW)
    page = context.new_page()
    page.add_init_script("""const ask = WebGL2RenderingContext.prototype.getParameter;
        WebGL2RenderingContext.prototype.getParameter = function (name) {
            return name === this.MAX_TEXTURE_SIZE ? 1024 : ask.call(this, name);
        };""")
    page.goto((tmp_path / "scene.html").as_uri())
    assert "MAX_TEXTURE_SIZE of this browser is 1024" in page.locator("[role=alert]").inner_text()
    context.close()


def test_the_small_picture_is_small():
    data = preview_of(co.load(BARREL))
    assert data[:4] == b"RIFF"
    assert data[8:12] == b"WEBP"
    assert len(data) <= PREVIEW_BYTES == 40 * 1024


def test_names_cannot_leave_their_place():
    evil = "</script><script>alert(1)</script><!-- \u2028 &"
    text = page(co.Scene([co.Body(co.Sphere(), name=evil)]), evil, "data:,")
    assert "<script>alert" not in text
    assert text.count("</script>") == 2


@pytest.mark.parametrize(("name", "value", "message"), [
    ("MOST_BYTES", 100, r"tables take .* MiB, a page holds at most"),
    ("MOST_GATES", 1, r"a Boolean combination of 3 nested steps, the shader counts at most 1"),
])  # fmt: skip
def test_limits_are_named(monkeypatch, tmp_path, name, value, message):
    monkeypatch.setattr(limits, name, value)
    shape = (co.Box() - co.Sphere(1.2)) | (co.Sphere(0.3) & co.Box())
    with pytest.raises(ValueError, match=message):
        export(co.Scene([shape]), tmp_path / "scene.html")
    assert not (tmp_path / "scene.html").exists()


def test_mistakes_are_reported(tmp_path):
    assert "pages are saved as .html" in failure("export", BARREL, tmp_path / "page.png")


# --- The tables of pages, in which every body has rows of its own: each body's tree holds the leaves of that body

_BOXES = 16
"""Boxes in a module. The box around them has more leaves than bodies without trees."""


def modules(folder: Path) -> co.Scene:
    """Return thirty-six boxes with sixteen boxes in each, as GDML."""
    solids = "".join(f'<box name="b{k}" x="{2 + 0.1 * k}" y="2" z="2" lunit="mm"/>' for k in range(_BOXES))
    volumes = "".join(
        f'<volume name="v{k}"><materialref ref="m"/><solidref ref="b{k}"/></volume>' for k in range(_BOXES)
    )
    placed = "".join(
        f'<physvol><volumeref ref="v{k}"/><position x="{-30 + 20 * (k % 4)}" y="{-30 + 20 * (k // 4)}" z="0"/></physvol>'
        for k in range(_BOXES)
    )
    around = "".join(
        f'<physvol><volumeref ref="module"/><position x="{110 * (k % 6)}" y="{110 * (k // 6)}" z="0"/></physvol>'
        for k in range(36)
    )
    path = folder / "modules.gdml"
    path.write_text(
        f"""<gdml><define/><materials><material name="m" Z="1"><D value="1"/><atom value="1"/></material></materials>
        <solids><box name="w" x="2000" y="2000" z="500" lunit="mm"/><box name="s" x="100" y="100" z="100" lunit="mm"/>
        {solids}</solids><structure>{volumes}
        <volume name="module"><materialref ref="m"/><solidref ref="s"/>{placed}</volume>
        <volume name="world"><materialref ref="m"/><solidref ref="w"/>{around}</volume></structure>
        <setup name="d" version="1"><world ref="world"/></setup></gdml>""",
        encoding="utf-8",
    )
    scene = co.load(path)
    assert isinstance(scene, co.Scene)
    return scene


def leaves_below(tables: Tables, roots: list[int]) -> list[int]:
    """Return the leaves of a tree, in order of their numbers."""
    found, codes = [], list(roots)
    while codes:
        code = codes.pop()
        if code < 0:
            first, count = (-code - 1) >> 4, (-code - 1) & 15
            found += tables.tree_order[first : first + count].tolist()
        else:
            codes += [child for child in tables.node_children[code].tolist() if child != 0]
    return sorted(found)


@pytest.mark.parametrize("edit", ["none", "before", "instead", "behind"])
def test_trees_hold_the_leaves_of_their_bodies(edit: str, tmp_path: Path) -> None:
    scene, box = modules(tmp_path), co.Box((-1, -1, 100), (1, 1, 101))
    if edit == "before":
        scene = scene.added(box, before=0)
    elif edit == "instead":
        scene = scene.replace(0, box)
    elif edit == "behind":
        scene = scene.added(box)
    tables = scene._prepared.lowered.tables
    assert len(tables.program_shifts) > 0  # otherwise leaves already have numbers of their own
    out = tables._replace(**expand_tables(tables))
    sizes = []
    for program in range(len(out.program_leaf) - 1):
        roots = out.roots[out.tree_root[program] : out.tree_root[program + 1]].tolist()
        first, end = out.program_leaf[program : program + 2].tolist()
        assert leaves_below(out, roots) == list(range(first, end))
        sizes.append(end - first)
    assert max(sizes) > _BOXES
    assert min(sizes) > 0
