"""The drawing of an optical system: the section of its bodies with the plane x = 0, and rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine.answers.rays import Rays
from ..scene import Scene
from ..shapes.calls import explained, explained_methods
from ..shapes.material import Material
from ..shapes.region import Painted
from ..shapes.validate import integer, number, path, what
from .following import follow
from .outline import outline, placed, written
from .prescriptions import Prescription
from .sequence import trace
from .spots import beam

Floats = npt.NDArray[np.float64]

COLOURS = ("#1f6fb4", "#2a9d4b", "#d0342c", "#8a5cc2", "#e08a1e", "#14a3a8")
MOST_RAYS = 10_000
_GLASS, _EDGE, _MIRROR, _STOP = "#cfe4f3", "#2b4a60", "#55606a", "#111111"


@explained_methods
@dataclass(frozen=True)
class Layout:
    """A drawing, which shows itself in a notebook.

    svg: its text. left_out: names or numbers of bodies that have no section here, or are not symmetric to x = 0.
    """

    svg: str
    left_out: tuple[str, ...] = ()

    def save(self, path: Any) -> None:
        """Write the drawing to a `path` that ends with .svg."""
        file = _svg_path(path)
        with open(file, "w", encoding="utf-8") as out:
            out.write(self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Layout({len(self.svg):,} characters of SVG, {len(self.left_out)} bodies left out)"


@explained
def layout(
    system: Prescription | Scene,
    *,
    fields: Any = None,
    rays: Any = 5,
    width: Any = 900,
    z_end: Any = None,
) -> Layout:
    """The section of a system through its axis, z to the right and y up, with rays.

    system: a `Prescription`, or a `Scene` of lenses, mirrors, stops and prisms, turned about x and moved in y and z
    alone. Outlines are exact curves, not polygons.
    fields: of a prescription, the beams that are drawn: its own fields where left out; each has a colour.
    rays: how many rays of each beam; or `co.Rays`, which a scene needs to have any, in the plane x = 0.
    width: of the drawing, in pixels. z_end: where rays end, at the image where left out.
    """
    if not isinstance(system, Prescription | Scene):
        raise TypeError(f"layout: system must be a Prescription or a Scene, got {what(system)}")
    pixels = number("layout", "width", width)
    if not 10 <= pixels <= 100_000:
        raise ValueError(f"layout: width must be from 10 to 100,000 pixels, got {pixels:g}")
    scene = system.scene if isinstance(system, Prescription) else system
    box = _box(scene, system)
    end = box[2] if z_end is None else number("layout", "z_end", z_end)
    lines = _lines(system, scene, fields, rays, box[0], end)
    box = _around([box, *(_extent(line) for _, line in lines)])
    bodies, left_out = _bodies(scene, box)
    image = system.image if isinstance(system, Prescription) else None
    return Layout(_document(box, pixels, bodies, lines, image, system), left_out)


Extent = tuple[float, float, float, float]
"""low z, low y, high z, high y"""


def _box(scene: Scene, system: Prescription | Scene) -> Extent:
    """What is drawn, before rays: the bodies, the image, and some room in front."""
    low, high = (np.asarray(end) for end in scene.bounds)
    if not np.isfinite([low, high]).all() or (low > high).any():
        raise ValueError("layout: system must have bodies of finite size")
    first, last = float(low[2]), float(high[2])
    if isinstance(system, Prescription):
        first, last = min(first, system.image), max(last, system.image)
    room = 0.12 * max(last - first, float(high[1] - low[1]))
    behind = 0.0 if isinstance(system, Prescription) else room
    return first - room, float(low[1]), last + behind, float(high[1])


def _lines(
    system: Prescription | Scene, scene: Scene, fields: Any, rays: Any, start: float, end: float
) -> list[tuple[str, Floats]]:
    """(colour, corners (n, 2)) of each ray, corners as z and y."""
    if isinstance(rays, Rays):
        if isinstance(system, Prescription):
            raise TypeError("layout: rays must be a number for a Prescription: its fields say which")
        found = follow(scene, rays)
        length = 2 * max(abs(end), abs(start), 1.0)
        return [(COLOURS[0], _run_out(found, i, end, length)) for i in range(found.points.shape[1])]
    count = integer("layout", "rays", rays, 0, MOST_RAYS)
    if not isinstance(system, Prescription) or count == 0:
        return []
    lines = []
    pupil = np.column_stack([np.zeros(count), np.linspace(-1, 1, count) if count > 1 else np.zeros(1)])
    for k, field in enumerate(system.fields if fields is None else np.atleast_1d(np.asarray(fields, float)).tolist()):
        traced = trace(system, beam(system, field, pupil=pupil))
        ends = traced.at(end)
        for i in np.flatnonzero(traced.arrived):
            corners = np.concatenate([traced.points[:, i], ends[i : i + 1]])[:, [2, 1]]
            corners[0] = _from(corners[0], corners[1], start)
            lines.append((COLOURS[k % len(COLOURS)], corners))
    return lines


def _from(first: Floats, second: Floats, start: float) -> Floats:
    """A ray's beginning, brought to the edge of the drawing."""
    if first[0] >= start or first[0] == second[0]:
        return first
    share = (start - first[0]) / (second[0] - first[0])
    return np.asarray(first + share * (second - first))


def _run_out(found: Any, i: int, end: float, length: float) -> Floats:
    """The corners of a followed ray, and a last leg to a height `end`, or of a length."""
    corners = found.points[:, i][:, [2, 1]]
    keep = np.concatenate([[True], (np.diff(corners, axis=0) != 0).any(axis=1)])
    corners = corners[keep]
    if not found.arrived[i]:
        return np.asarray(corners)
    way = found.rays.directions[i, [2, 1]]
    ahead = (end - corners[-1, 0]) / way[0] if way[0] else -1.0
    way = way * ahead if ahead > 0 else way / np.hypot(*way) * length / 4
    return np.concatenate([corners, corners[-1:] + way])


def _extent(corners: Floats) -> Extent:
    low, high = corners.min(axis=0), corners.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _around(boxes: list[Extent]) -> Extent:
    low, high = np.array(boxes)[:, :2].min(axis=0), np.array(boxes)[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _bodies(scene: Scene, box: Extent) -> tuple[list[str], tuple[str, ...]]:
    """The path of each body, and what has none."""
    del box
    drawn, left_out = [], []
    for i in range(len(scene)):
        body = scene.body(i)
        shape = body.shape.operand if isinstance(body.shape, Painted) and not body.shape.motion.steps else body.shape
        line, moved = outline(shape), placed(shape)
        if line is None or moved is None:
            left_out.append(body.name or str(i))
            continue
        title = f"<title>{escape(body.name)}</title>" if body.name else ""
        drawn.append(f'<path class="{_kind(body.material, shape.is_sheet)}" d="{line}"{moved}>{title}</path>')
    return drawn, tuple(left_out)


def _kind(material: Material | None, is_sheet: bool) -> str:
    """Glass, mirror or dark; a sheet is a line."""
    clear = material is not None and np.max(np.asarray(material.transparency)) > 0
    shiny = material is not None and (np.max(np.asarray(material.reflectivity)) > 0 or material.metal_index is not None)
    name = "glass" if clear else "mirror" if shiny else "stop"
    return f"{name} line" if is_sheet else name


def _document(
    box: Extent, width: float, bodies: list[str], lines: list[tuple[str, Floats]], image: float | None, system: Any
) -> str:
    room = 0.02 * max(box[2] - box[0], box[3] - box[1])
    left, top = box[0] - room, -box[3] - room
    wide, high = box[2] - box[0] + 2 * room, box[3] - box[1] + 2 * room
    height = max(1.0, width * high / wide)
    name = escape(system.name) if isinstance(system, Prescription) and system.name else "Layout of an optical system"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:.6g}" '
        f'viewBox="{written(left)} {written(top)} {written(wide)} {written(high)}">',
        f"<title>{name}</title>",
        "<style>path,line,polyline{vector-effect:non-scaling-stroke;fill:none;stroke-linejoin:round}"
        f".glass{{fill:{_GLASS};fill-opacity:.7;stroke:{_EDGE};stroke-width:1.2}}"
        f".mirror{{fill:#dfe3e6;stroke:{_MIRROR};stroke-width:2}}.stop{{stroke:{_STOP};stroke-width:2.5}}"
        ".line{fill:none}.axis{stroke:#999;stroke-width:.6;stroke-dasharray:8 3 2 3}.image{stroke:#444;stroke-width:1}"
        ".ray{stroke-width:.8}</style>",
        f'<line class="axis" x1="{written(left)}" y1="0" x2="{written(left + wide)}" y2="0"/>',
        *bodies,
        *(_ray(colour, corners) for colour, corners in lines),
    ]
    if image is not None:
        tall = max([0.1 * high, *(abs(float(corners[-1, 1])) for _, corners in lines)])
        x = written(image)
        parts.append(f'<line class="image" x1="{x}" y1="{written(-tall)}" x2="{x}" y2="{written(tall)}"/>')
    return "\n".join([*parts, "</svg>", ""])


def _ray(colour: str, corners: Floats) -> str:
    points = " ".join(
        f"{written(z)},{written(-y)}" for z, y in corners.tolist() if math.isfinite(z) and math.isfinite(y)
    )
    return f'<polyline class="ray" stroke="{colour}" points="{points}"/>'


def _svg_path(value: Any) -> Any:
    file = path("Layout.save", value)
    if not str(file).lower().endswith(".svg"):
        raise ValueError(f"Layout.save: path must end with .svg, got {str(file)[:80]!r}")
    return file
