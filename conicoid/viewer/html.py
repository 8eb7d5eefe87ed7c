"""The page of a scene as one HTML file, which loads nothing: markup, style, modules, shaders, and the scene.

`export` writes it, or a model of another program. An exported page also carries the exact engine: its WebAssembly,
and those tables of the scene that the shaders do not need.
"""

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
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.files import replace_file
from .._util.validation import check_path as checked_path, describe_kind
from ..geometry.body import Body
from ..geometry.shape import Shape
from ..io.export.exporters import EXPORT_FORMATS, ExportOptions, find_export_format
from ..kernels.first_hits import HitBuffers
from ..kernels.tables import Tables
from ..materials.color import srgb_encode
from ..queries.exact.doubtful_rays import new_rank_scratch
from ..scene.scene import Scene, as_scene
from .scene_data import expand_tables, name_of, pack_scene

_LONGEST_STAMP = 1 << 16
ENGINE_FILE = "engine.wasm"
"""The exact engine as WebAssembly. `native.page` builds it in a checkout; wheels contain it."""
_SECTION = b"conicoid"
"""The name of the custom section with the stamp of the sources."""


def stamp_sources(code: bytes, stamp: str) -> bytes:
    """Return a WebAssembly module with the stamp of its sources in a custom section; unchanged for ""."""
    if not stamp:
        return code
    content = bytes([len(_SECTION)]) + _SECTION + stamp.encode()
    size, count = b"", len(content)
    while count > 127:  # LEB128: seven bits a byte, the lowest first
        size, count = size + bytes([count & 127 | 128]), count >> 7
    return code + bytes([0, *size, count]) + content


@cache
def read_engine() -> bytes | None:
    """Return the WebAssembly module of the exact engine.

    None if there is no module, or if it was built from other sources than those of this package.
    """
    try:
        code = (resources.files(__package__) / ENGINE_FILE).read_bytes()
    except FileNotFoundError:
        return None
    # `stamp_sources` puts its section at the end, so only the last bytes can hold it
    mark = code.rfind(bytes([len(_SECTION)]) + _SECTION, -_LONGEST_STAMP)
    if mark >= 0:  # built in a checkout, whose sources may have changed since
        from .._jit.sources import is_current

        if not is_current(code[mark + 1 + len(_SECTION) :].decode(errors="replace")):
            return None
    return code


def engine_data(scene: Scene, shown: Any) -> dict[str, Any] | None:
    """Return the engine and its tables, compressed, for the data of a page; None without an engine.

    shown: the tables that the shader has in the same form, and that the page need not hold twice.
    """
    code = read_engine()
    if code is None:
        return None
    geometry, rest, tables = scene._prepared.geometry, scene._prepared.rest, scene._prepared.lowered.tables
    parts: dict[str, npt.NDArray[Any]] = {"places": geometry.places}
    # The shader has tables without shared rows; of those the engine needs the originals as well
    others = expand_tables(tables)
    parts |= {name: getattr(tables, name) for name in Tables._fields if name not in shown or name in others}
    parts |= {f"rest_{name}": getattr(rest, name) for name in rest._fields}
    kinds = {name: _KINDS[array.dtype.kind, name == "places"] for name, array in parts.items()}
    room = new_rank_scratch(scene._prepared)
    return {
        "code": _compress(code),
        "order": Tables._fields,
        "lengths": [len(geometry.integers), len(geometry.floats)],
        "parts": [[name, kinds[name], array.size] for name, array in parts.items()],
        "content": _compress(b"".join(array.astype(f"<{kinds[name]}").tobytes() for name, array in parts.items())),
        # Memory of the kernels, from the records themselves: the page need not know their fields
        "ranks": [[array.dtype.str[1:], array.size] for array in room.ranks],
        "canonical": room.stand.floats.size,
        "hit": [[name, array.dtype.str[1:]] for name, array in HitBuffers.new(1)._asdict().items()],
        "names": _compress(json.dumps([name_of(scene, item) for item in range(len(scene.bodies))]).encode()),
    }


# (kind of the array, whether it is `places`) -> type in the page
_KINDS = {("f", False): "f8", ("i", False): "i4", ("i", True): "i8"}


def _compress(content: bytes) -> str:
    """Return compressed bytes as base64."""
    return base64.b64encode(zlib.compress(content, 9)).decode()


# --- The page, and models of other programs

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
"""The largest small picture."""
_PREVIEW_ASPECT = 1.5
"""Width over height, as of most windows: a picture of their height covers them as that of the shader does."""


@cache
def asset(name: str) -> str:
    """Return the text of a file of the page or of a shader."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


@cache
def script() -> str:
    """Return all modules of the page as one script."""
    return join_modules(MODULES)


def join_modules(modules: tuple[str, ...]) -> str:
    """Return modules as one script, without imports: names at their top level are distinct."""
    return "\n".join(_EXPORT.sub("", _IMPORT.sub("", asset(f"page/{name}.js"))) for name in modules)


@cache
def shaders() -> dict[str, Any]:
    """Return the pieces of the shaders, and the list of pieces of each; the page puts array sizes before them."""
    pieces = {name: asset(f"shaders/{name}.glsl") for name in (*SHADERS, "pick", "show")}
    return {"pieces": pieces, "picture": SHADERS, "pick": PICK_SHADERS, "show": ("show",)}


def page(scene: Scene, title: str, preview: str, served: dict[str, Any] | None = None, *, carries: bool = True) -> str:
    """Return the page of a scene as HTML.

    A page without a server carries the exact engine, if there is a module of it.

    Parameters
    ----------
    scene : Scene
        The scene.
    title : str
        The title of the page.
    preview : str
        The address of its small picture.
    served : dict, optional
        The data of the page for requests to its server.
    carries : bool
        False leaves out the engine.

    Raises
    ------
    ValueError
        For a scene that is too large for a browser.
    """
    shown = pack_scene(scene)
    data = {"title": title, "scene": shown, "shaders": shaders(), "served": served}
    # A served page needs no engine of its own: it asks the process that serves it
    engine = engine_data(scene, shown["tables"]) if served is None and carries else None
    if engine is not None:
        data["engine"] = engine
    fields = {
        "TITLE": _text(title),
        # Content security policy: WebAssembly only with an engine, connections only to a server of the page
        "MACHINE": " 'wasm-unsafe-eval'" if engine else "",
        "CONNECT": "'self'" if served else "'none'",
        "STYLE": asset("page/style.css"),
        "MARKUP": markup(preview),
        "DATA": embed_json(data),
        "SCRIPT": script(),
    }
    # One pass over the template: braces in a title or in data are not replaced
    return re.sub(r"\{\{(\w+)\}\}", lambda match: fields[match[1]], asset("page/page.html"))


def markup(preview: str) -> str:
    """Return the markup around a scene; the picture at `preview` shows before anything is computed."""
    return asset("page/markup.html").replace("{{PREVIEW}}", _text(preview))


def export(
    scene: Scene | Shape | Body, path: str | os.PathLike[str], title: str | None = None, *, strict: bool = False
) -> tuple[str, ...]:
    """Write the scene as a file for others: one HTML page that works from a disk, or a model of another program.

    docs/exporting.md describes how each part of a scene is exported.

    Parameters
    ----------
    scene : Scene, Shape or Body
        The scene.
    path : path
        The file. Its suffix chooses the format: .html, a page; .gdml, GDML; .scad, OpenSCAD; .xml, an OpenMC model.
    title : str, optional
        The title of the page. Default: the name of the file.
    strict : bool
        For a model: a part of the scene that the format cannot hold is an error.

    Returns
    -------
    tuple of str
        Notes on the model: its size, and the parts of the scene that it leaves out. The latter also go to the log,
        `logging.getLogger("conicoid")`, as warnings.

    Raises
    ------
    ValueError
        For a scene that is too large for a browser, with the limit; for bodies that a format cannot hold, with their
        names; and for another suffix.
    OSError
        If the file cannot be written.
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
    """Write a model of another program; return its notes."""
    exporter = find_export_format(path)
    if exporter is None:
        suffixes = ", ".join(suffix for each in EXPORT_FORMATS for suffix in each.suffixes)
        raise ValueError(f"{os.fspath(path)}: scenes are exported as a page, .html, or as models: {suffixes}")
    if title is not None:
        raise ValueError(f"export: title means nothing for {exporter.name}: pages have one")
    result = exporter.write(scene, path, options)
    if result.remarks:
        _log.warning("%s", "\n".join(f"{os.fspath(path)}: {remark}" for remark in result.remarks))
    return result.notes


def as_url(preview: bytes) -> str:
    """Return a small picture as a data URL."""
    return "data:image/webp;base64," + base64.b64encode(preview).decode()


def embed_json(data: Any) -> str:
    """Return JSON that may stand in a script element: without `</script>` or `<!--`, whatever names hold."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _text(words: str) -> str:
    """Return text escaped for HTML."""
    return words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


def preview_of(scene: Scene, width: int = 540) -> bytes:
    """Return a small picture by the engine, a WebP file of at most 40 KiB.

    A page shows it until the browser draws, or in place of that. Quality falls first, then the size.
    """
    from PIL import Image

    pixels = scene.render(width, round(width / _PREVIEW_ASPECT), samples=1, depth=6).pixels
    bytes_ = np.rint(255 * srgb_encode(np.clip(pixels, 0, 1))).astype(np.uint8)
    for quality in (80, 60, 40, 20, 5):
        stream = io.BytesIO()
        Image.fromarray(bytes_, "RGB").save(stream, "WEBP", quality=quality)
        if stream.tell() <= PREVIEW_BYTES:
            return stream.getvalue()
    return preview_of(scene, width // 2)
