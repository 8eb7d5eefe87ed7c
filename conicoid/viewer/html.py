"""The exact engine in the page: its WebAssembly, and of the scene what it needs beyond the shader's tables."""

from __future__ import annotations

import base64
import io
import json
import logging
import os
import re
import zlib
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.hints import with_call_hints
from .._util.safe_files import replace_file
from .._util.validation import check_path as checked_path
from .._util.validation import describe_kind
from ..io.export.exporters import EXPORT_FORMATS, ExportOptions, find_export_format
from ..kernels.tables import Tables
from ..materials.color import srgb_encode
from ..scene.scene import Scene, as_scene
from .picks import name_of
from .scene_data import expand_tables, pack_scene

if TYPE_CHECKING:
    from ..geometry.body import Body
    from ..geometry.shape import Shape
    from ..scene.scene import Scene


ENGINE_FILE = "engine.wasm"
"""Made by `native.page`; it comes with wheels, and stands in a checkout where it was built."""
_SECTION = b"conicoid"


def stamp_sources(code: bytes, sources: str) -> bytes:
    """A module that says what it was made of, in a section of its own; unchanged for ""."""
    if not sources:
        return code
    content = bytes([len(_SECTION)]) + _SECTION + sources.encode()
    return code + bytes([0, len(content)]) + content


@cache
def read_engine() -> bytes | None:
    """The module; None where there is none, and where it was made of other sources."""
    try:
        code = (resources.files(__package__) / ENGINE_FILE).read_bytes()
    except FileNotFoundError:
        return None
    mark = code.rfind(_SECTION, -128)
    if mark >= 0:  # it was built in place: the sources may have been edited since
        from .._jit.sources import hash_of_sources

        if code[mark + len(_SECTION) :].decode() != hash_of_sources():
            return None
    return code


def engine_data(scene: Scene, shown: Any) -> dict[str, Any] | None:
    """The engine and its tables that are not `shown` to the shader as they are, compressed; None if there is none."""
    code = read_engine()
    if code is None:
        return None
    geometry, rest, tables = scene.geometry, scene.prepared.rest, scene.prepared.lowered.tables
    parts: dict[str, npt.NDArray[Any]] = {"places": geometry.places}
    others = expand_tables(tables)
    parts |= {name: getattr(tables, name) for name in Tables._fields if name not in shown or name in others}
    parts |= {f"rest_{name}": getattr(rest, name) for name in rest._fields}
    kinds = {name: _KINDS[array.dtype.kind, name == "places"] for name, array in parts.items()}
    return {
        "code": _compress(code),
        "order": Tables._fields,
        "lengths": [len(geometry.integers), len(geometry.floats)],
        "parts": [[name, kinds[name], array.size] for name, array in parts.items()],
        "content": _compress(b"".join(array.astype(f"<{kinds[name]}").tobytes() for name, array in parts.items())),
        "names": _compress(json.dumps([name_of(scene, item) for item in range(len(scene.bodies))]).encode()),
    }


_KINDS = {("f", False): "f8", ("i", False): "i4", ("i", True): "i8"}


def _compress(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()


# One page that holds everything: markup, style, modules, shaders, and the scene. It asks nobody for anything.

SHADERS = (
    "vectors", "tables", "quadric", "cell", "polygon", "walk", "program", "events", "traverse", "materials", "lights",
    "whitted", "camera", "picture",
)  # fmt: skip
"""The pieces of the shader of pictures, in the order in which they build on each other."""
PICK_SHADERS = (*SHADERS[:11], "camera", "pick")
MODULES = (
    "vectors", "tables", "graphics", "camera", "film", "pick", "state", "gestures", "section", "measure", "panel",
    "details", "asking", "editing", "live", "kernel", "engine", "exact", "waiting", "main",
)  # fmt: skip
"""The modules of the page, each after those that it imports."""
_IMPORT = re.compile(r"^import \{[^}]*\} from \"\./\w+\.js\";\n", re.MULTILINE)
_EXPORT = re.compile(r"^export (?=const|let|function|class|async)", re.MULTILINE)
_log = logging.getLogger("conicoid")
PREVIEW_BYTES = 40 << 10
_PREVIEW_ASPECT = 1.5
"""As wide as most windows: a picture of the same height covers them as the shader's will."""


@cache
def asset(name: str) -> str:
    """The text of a file of the page or of a shader."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


@cache
def script() -> str:
    """All modules as one."""
    return join_modules(MODULES)


def join_modules(modules: tuple[str, ...]) -> str:
    """Modules as one: names at their top level are distinct, so imports between them can be left out."""
    return "\n".join(_EXPORT.sub("", _IMPORT.sub("", asset(f"page/{name}.js"))) for name in modules)


@cache
def shaders() -> dict[str, Any]:
    """The pieces, and of which each shader is made; the page puts the sizes of arrays before them."""
    pieces = {name: asset(f"shaders/{name}.glsl") for name in (*SHADERS, "pick", "show")}
    return {"pieces": pieces, "picture": SHADERS, "pick": PICK_SHADERS, "show": ("show",)}


def page(scene: Scene, title: str, preview: str, served: dict[str, Any] | None = None, *, carries: bool = True) -> str:
    """The page as HTML. `preview`: where its small picture is; `served`: what a page needs that can ask its server.

    One that cannot ask carries the exact engine, where there is one for pages, unless told not to.
    """
    shown = pack_scene(scene)
    data = {"title": title, "scene": shown, "shaders": shaders(), "served": served}
    engine = engine_data(scene, shown["tables"]) if served is None and carries else None
    if engine is not None:
        data["engine"] = engine
    fields = {
        "TITLE": _text(title),
        "MACHINE": " 'wasm-unsafe-eval'" if engine else "",
        "CONNECT": "'self'" if served else "'none'",
        "STYLE": asset("page/style.css"),
        "MARKUP": markup(preview),
        "DATA": embed_json(data),
        "SCRIPT": script(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: fields[match[1]], asset("page/page.html"))


def markup(preview: str) -> str:
    """What a scene stands in. `preview`: where its small picture is; that is there before anything is computed."""
    return asset("page/markup.html").replace("{{PREVIEW}}", _text(preview))


@with_call_hints
def export(
    scene: Scene | Shape | Body, path: str | os.PathLike[str], title: str | None = None, *, strict: bool = False
) -> tuple[str, ...]:
    """Write the scene as a file for others: one HTML page that works from a disk, or a model of another program.

    path: of the file, whose suffix says what it is: .html, a page; .gdml, GDML; .scad, OpenSCAD; .xml, an OpenMC model.
    title: of the page; by default the file's name.
    strict: of a model, is what its format cannot say of the scene an error?

    Returns notes on the model: how large it is, and what it does not say; those also go to the log,
    `logging.getLogger("conicoid")`, as warnings. docs/exporting.md says what becomes of what.
    Raises ValueError for a scene that a browser cannot hold, with the limit, for bodies that a format cannot say, with
    their names, and for another suffix; OSError where it cannot be written.
    """
    scene, path = as_scene("export", scene), checked_path("export", path)
    if title is not None and not isinstance(title, str):
        raise TypeError(f"export: title must be a text or None, got {describe_kind(title)}")
    options = ExportOptions(strict)
    suffix = os.path.splitext(path)[1].lower()
    if suffix != ".html":
        return _model(scene, path, title, options)
    if strict:
        raise ValueError("export: strict means nothing for a page")
    text = page(
        scene,
        title or os.path.splitext(os.path.basename(path))[0],
        as_url(preview_of(scene)),
    )
    with replace_file(path) as part:
        part.write_text(text, encoding="utf-8")
    return ()


def _model(scene: Scene, path: str | os.PathLike[str], title: str | None, options: ExportOptions) -> tuple[str, ...]:
    """A file of another program."""
    found = find_export_format(path)
    if found is None:
        known = ", ".join(suffix for each in EXPORT_FORMATS for suffix in each.suffixes)
        raise ValueError(f"{os.fspath(path)}: scenes are exported as a page, .html, or as models: {known}")
    if title is not None:
        raise ValueError(f"export: title means nothing for {found.name}: pages have one")
    done = found.write(scene, path, options)
    if done.remarks:
        _log.warning("%s", "\n".join(f"{os.fspath(path)}: {remark}" for remark in done.remarks))
    return done.notes


def as_url(preview: bytes) -> str:
    """A small picture as an address that holds it."""
    return "data:image/webp;base64," + base64.b64encode(preview).decode()


def embed_json(data: Any) -> str:
    """JSON that may stand in a script element: no `</script>` or `<!--` in it, whatever names say."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _text(words: str) -> str:
    return words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


def preview_of(scene: Scene, width: int = 540) -> bytes:
    """A small picture by the engine, a WebP file of at most 40 KiB: shown until the browser draws, or instead."""
    from PIL import Image

    pixels = scene.render(width, round(width / _PREVIEW_ASPECT), samples=1, depth=6).pixels
    bytes_ = np.rint(255 * srgb_encode(np.clip(pixels, 0, 1))).astype(np.uint8)
    for quality in (80, 60, 40, 20, 5):
        stream = io.BytesIO()
        Image.fromarray(bytes_, "RGB").save(stream, "WEBP", quality=quality)
        if stream.tell() <= PREVIEW_BYTES:
            return stream.getvalue()
    return preview_of(scene, width // 2)
