"""Drawings of optical systems: the section of bodies with the plane x = 0 as paths of SVG, z to the right and y up.

Spheres, ellipsoids and paraboloids are exact: SVG has elliptic arcs and parabolas. It has no hyperbolas: these are
drawn by pieces of cubics that are within a millionth of their width.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.dataclass import dataclass
from ..._util.validation import check_integer, check_number, check_path, describe_kind
from ...geometry.conic import Conic, ConicSheet, ConicWall, Stop
from ...geometry.optical_elements import FlatGlass, Lens, Mirror
from ...geometry.primitives import Sphere
from ...geometry.shape import Painted, Shape
from ...materials.material import Material
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike, is_scene
from .prescriptions import Prescription
from .ray_trace import follow, trace
from .spot_diagram import beam

Point: TypeAlias = tuple[float, float]
"""(z, y)"""

_CLOSE = 1e-6
_MOST_PIECES = 512


def section_path(shape: Shape) -> str | None:
    """Return the path of a section in the shape's own frame; None for other shapes."""
    if isinstance(shape, Lens):
        return _closed(_down(shape.front), _up(shape.back))
    if isinstance(shape, Mirror):
        return _mirror(shape)
    if isinstance(shape, Conic):
        return _closed(_down(shape.wall), "")
    if isinstance(shape, ConicSheet):
        return _sheet(shape.wall, shape.hole / 2)
    if isinstance(shape, Stop):
        inner, outer = shape.aperture / 2, shape.diameter / 2
        return " ".join(f"{_move((0.0, sign * outer))} {_line((0.0, sign * inner))}" for sign in (1, -1))
    if isinstance(shape, Sphere):
        r = shape.radius
        return f"{_move((-r, 0.0))} {_arc(r, r, 1, (r, 0.0))} {_arc(r, r, 1, (-r, 0.0))} Z"
    if isinstance(shape, FlatGlass):
        return _polygon(shape)
    return None


def place_path(shape: Shape) -> str | None:
    """Return the attribute that places the shape's frame; None if the motion does not map the plane x = 0 to itself."""
    m = np.asarray(shape.under().matrix)
    # The motion must neither tilt nor shift the plane x = 0.
    if np.any(m[0, 1:] != 0) or np.any(m[1:, 0] != 0):
        return None
    if np.array_equal(m, np.eye(4)):
        return ""
    # Columns of SVG's matrix: z to the right, y up, while SVG's y points down.
    numbers = (m[2, 2], -m[1, 2], -m[2, 1], m[1, 1], m[2, 3], -m[1, 3])
    return f' transform="matrix({" ".join(format_path(float(x)) for x in numbers)})"'


def format_path(value: float) -> str:
    """Return a number in the form of SVG."""
    return f"{value + 0.0:.12g}"


# Commands of paths.


def _move(point: Point) -> str:
    """Return the command that moves the pen to a point."""
    return f"M {_at(point)}"


def _line(point: Point) -> str:
    """Return the command for a line to a point."""
    return f"L {_at(point)}"


def _at(point: Point) -> str:
    """Return a point as text; y of SVG points down."""
    return f"{format_path(point[0])} {format_path(-point[1])}"


def _arc(rx: float, ry: float, sweep: int, end: Point) -> str:
    """Return the command for an elliptic arc to a point."""
    return f"A {format_path(rx)} {format_path(ry)} 0 0 {sweep} {_at(end)}"


def _closed(*parts: str) -> str:
    """Return a closed path of commands; the first one becomes a move."""
    return "M " + " ".join(part for part in parts if part).removeprefix("L ").removeprefix("M ") + " Z"


# Conics.


def _down(wall: ConicWall) -> str:
    """Return the path from the upper edge over the vertex to the lower edge."""
    return _across(wall, wall.edge, wall.semi, -wall.semi, -wall.edge)


def _up(wall: ConicWall) -> str:
    """Return the path from the lower edge over the vertex to the upper edge."""
    return _across(wall, -wall.edge, -wall.semi, wall.semi, wall.edge)


def _across(wall: ConicWall, first: float, start: float, end: float, last: float) -> str:
    """Return the path flat from `first` to `start`, along the conic to `end`, and flat again."""
    rim = _height(wall, abs(start))
    flat = [_line((rim, first)), _line((rim, start))] if abs(first) > abs(start) else [_line((rim, start))]
    tail = [_line((rim, last))] if abs(last) > abs(end) else []
    return " ".join([*flat, conic_path(wall, start, end), *tail])


def _height(wall: ConicWall, y: float) -> float:
    """Return z of the wall at the height y."""
    return float(wall.vertex) + float(wall.sag(abs(y)))


def conic_path(wall: ConicWall, start: float, end: float) -> str:
    """Return the path along a conic, from the height `start` to `end`; the pen is at its start."""
    target = (_height(wall, end), end)
    if wall.is_plane:
        return _line(target)
    radius, steep = wall.radius, 1 + wall.conic
    if steep > 0:
        # The side of the arc depends on the sign of the radius and on the direction of the pen.
        sweep = int((radius < 0) == (end < start))
        return _arc(abs(radius) / steep, abs(radius) / math.sqrt(steep), sweep, target)
    if steep == 0:  # tangents at y and y' meet at z = y y' / (2 R)
        corner = (float(wall.vertex) + start * end / (2 * radius), (start + end) / 2)
        return f"Q {_at(corner)} {_at(target)}"
    return _hyperbola(wall, start, end)


def _hyperbola(wall: ConicWall, start: float, end: float) -> str:
    """Return cubics with the hyperbola's own tangents, as many as the tolerance needs."""
    pieces = 2
    # Each doubling reduces the error of the cubics.
    while pieces < _MOST_PIECES and _error(wall, start, end, pieces) > _CLOSE * abs(end - start):
        pieces *= 2
    heights = np.linspace(start, end, pieces + 1).tolist()
    return " ".join(_cubic(wall, a, b) for a, b in itertools.pairwise(heights))


def _slope(wall: ConicWall, y: float) -> float:
    """Return dz / dy of the wall."""
    return y / (wall.radius * math.sqrt(1 - (1 + wall.conic) * (y / wall.radius) ** 2))


def _controls(wall: ConicWall, a: float, b: float) -> Sequence[Point]:
    """Return the inner control points of the cubic between two heights (Hermite)."""
    third = (b - a) / 3
    return (_height(wall, a) + third * _slope(wall, a), a + third), (
        _height(wall, b) - third * _slope(wall, b),
        b - third,
    )


def _cubic(wall: ConicWall, a: float, b: float) -> str:
    """Return the command for the cubic between two heights."""
    first, second = _controls(wall, a, b)
    return f"C {_at(first)} {_at(second)} {_at((_height(wall, b), b))}"


def _error(wall: ConicWall, start: float, end: float, pieces: int) -> float:
    """Return the distance of the middles of the pieces from the hyperbola: there a cubic is worst."""
    heights = np.linspace(start, end, pieces + 1).tolist()
    worst = 0.0
    for a, b in itertools.pairwise(heights):
        (first, _), (second, _) = _controls(wall, a, b)
        middle = (_height(wall, a) + 3 * first + 3 * second + _height(wall, b)) / 8
        worst = max(worst, abs(middle - _height(wall, (a + b) / 2)))
    return worst


# Shapes.


def _sheet(wall: ConicWall, hole: float) -> str:
    """Return the path of the conic alone, in two pieces around a hole."""
    ends = [(wall.semi, hole), (-hole, -wall.semi)] if hole else [(wall.semi, -wall.semi)]
    return " ".join(f"{_move((_height(wall, a), a))} {conic_path(wall, a, b)}" for a, b in ends)


def _mirror(shape: Mirror) -> str:
    """Return the path of a mirror with its substrate."""
    wall, back, hole = shape.front, shape.thickness, shape.hole / 2
    if not hole:
        return _closed(_down(wall), _line((back, -wall.edge)), _line((back, wall.edge)))
    pieces = [(wall.semi, hole), (-hole, -wall.semi)]
    return " ".join(
        f"{_move((_height(wall, a), a))} {conic_path(wall, a, b)} {_line((back, b))} {_line((back, a))} Z"
        for a, b in pieces
    )


def _polygon(shape: FlatGlass) -> str:
    """Return the section of a convex solid with planes: corners of its edges with the plane x = 0, in order."""
    corners = np.array([[float(c) for c in corner] for corner in shape.corners()])
    # Corners in the plane, then crossings of edges from negative to positive x.
    points: list[Any] = [c for c in corners if c[0] == 0]
    for a in corners[corners[:, 0] < 0]:
        points.extend(a + (b - a) * (a[0] / (a[0] - b[0])) for b in corners[corners[:, 0] > 0])
    section = convex_path([(float(p[2]), float(p[1])) for p in points])
    return " ".join([_move(section[0]), *map(_line, section[1:]), "Z"])


def convex_path(points: Iterable[Point]) -> list[Point]:
    """Return the corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    hull: list[Point] = []
    for run in (ordered, ordered[::-1]):
        half: list[Point] = []
        for p in run:
            while len(half) > 1 and _turn(half[-2], half[-1], p) <= 0:
                half.pop()
            half.append(p)
        hull.extend(half[:-1])
    return hull


def _turn(a: Point, b: Point, c: Point) -> float:
    """Return twice the signed area of a triangle, over 0 for a left turn."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


# The drawing of an optical system: the section of its bodies with the plane x = 0, and rays.

Floats = npt.NDArray[np.float64]

COLOURS = ("#1f6fb4", "#2a9d4b", "#d0342c", "#8a5cc2", "#e08a1e", "#14a3a8")
MOST_RAYS = 10_000
_GLASS, _EDGE, _MIRROR, _STOP = "#cfe4f3", "#2b4a60", "#55606a", "#111111"


@dataclass(frozen=True)
class Layout:
    """A drawing, which a notebook shows.

    Parameters
    ----------
    svg : str
        Its text.
    omissions : tuple of str
        Names or numbers of bodies without a section here, or without symmetry to x = 0.
    """

    svg: str
    omissions: tuple[str, ...] = ()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the drawing to a file.

        Parameters
        ----------
        path : path
            Must end with .svg.
        """
        file = _svg_path(path)
        with open(file, "w", encoding="utf-8") as out:
            out.write(self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Layout({len(self.svg):,} characters of SVG, {len(self.omissions)} bodies left out)"


def layout(
    system: Prescription | SceneLike,
    *,
    fields: float | Sequence[float] | None = None,
    rays: int | Rays = 5,
    width: float = 900,
    z_end: float | None = None,
) -> Layout:
    """Draw the section of a system through its axis, z to the right and y up, with rays. Outlines are exact curves.

    Parameters
    ----------
    system : Prescription or Scene
        A scene must be of lenses, mirrors, stops and prisms, turned about x and moved in y and z alone.
    fields : sequence of float, optional
        Fields of a prescription whose beams are drawn, each with a colour; the default is its own fields.
    rays : int or Rays
        Rays of each beam; or the rays in the plane x = 0 to draw in a scene, which has no beams.
    width : float
        Of the drawing, in pixels.
    z_end : float, optional
        End of the rays; the default is the image.

    Returns
    -------
    Layout
    """
    if not isinstance(system, Prescription) and not is_scene(system):
        raise TypeError(f"layout: system must be a Prescription or a Scene, got {describe_kind(system)}")
    pixels = check_number("layout", "width", width)
    if not 10 <= pixels <= 100_000:
        raise ValueError(f"layout: width must be from 10 to 100,000 pixels, got {pixels:g}")
    scene = system.scene if isinstance(system, Prescription) else system
    box = _box(scene, system)
    end = box[2] if z_end is None else check_number("layout", "z_end", z_end)
    lines = _lines(system, scene, fields, rays, box[0], end)
    box = _union([box, *(_extent(line) for _, line in lines)])
    bodies, left_out = _bodies(scene)
    image = system.image if isinstance(system, Prescription) else None
    return Layout(_document(box, pixels, bodies, lines, image, system), left_out)


Extent = tuple[float, float, float, float]
"""low z, low y, high z, high y"""


def _box(scene: SceneLike, system: Prescription | SceneLike) -> Extent:
    """Return the extent of the drawing without rays: the bodies, the image, and some room in front."""
    low, high = (np.asarray(end) for end in scene.bounds)
    if not np.isfinite([low, high]).all() or (low > high).any():
        raise ValueError("layout: system must have bodies of finite size")
    first, last = float(low[2]), float(high[2])
    if isinstance(system, Prescription):
        first, last = min(first, system.image), max(last, system.image)
    room = 0.12 * max(last - first, float(high[1] - low[1]))
    # A prescription ends at its image; rays of a scene need room behind it.
    depth = 0.0 if isinstance(system, Prescription) else room
    return first - room, float(low[1]), last + depth, float(high[1])


def _lines(
    system: Prescription | SceneLike, scene: SceneLike, fields: Any, rays: Any, start: float, end: float
) -> list[tuple[str, Floats]]:
    """Return (colour, corners (n, 2)) of each ray, corners as z and y."""
    if isinstance(rays, Rays):
        if isinstance(system, Prescription):
            raise TypeError("layout: rays must be a number for a Prescription: its fields are its beams")
        followed = follow(scene, rays)
        length = 2 * max(abs(end), abs(start), 1.0)
        return [(COLOURS[0], _run_out(followed, i, end, length)) for i in range(followed.points.shape[1])]
    count = check_integer("layout", "rays", rays, 0, MOST_RAYS)
    if not isinstance(system, Prescription) or count == 0:
        return []
    lines = []
    pupil = np.column_stack([np.zeros(count), np.linspace(-1, 1, count) if count > 1 else np.zeros(1)])
    for k, field in enumerate(system.fields if fields is None else np.atleast_1d(np.asarray(fields, float)).tolist()):
        traced = trace(system, beam(system, field, pupil=pupil))
        ends = traced.at(end)
        for i in np.flatnonzero(traced.arrived):
            corners = np.concatenate([traced.points[:, i], ends[i : i + 1]])[:, [2, 1]]
            # Beams start far in front: begin at the edge of the drawing.
            corners[0] = _path_from(corners[0], corners[1], start)
            lines.append((COLOURS[k % len(COLOURS)], corners))
    return lines


def _path_from(first: Floats, second: Floats, start: float) -> Floats:
    """Return the start of a ray, moved to the edge of the drawing."""
    if first[0] >= start or first[0] == second[0]:
        return first
    share = (start - first[0]) / (second[0] - first[0])
    return np.asarray(first + share * (second - first))


def _run_out(followed: Any, i: int, end: float, length: float) -> Floats:
    """Return the corners of a followed ray, and a last leg to z = `end`, or of a length."""
    corners = followed.points[:, i][:, [2, 1]]
    # Rays that have left repeat their last point: drop repetitions.
    keep = np.concatenate([[True], (np.diff(corners, axis=0) != 0).any(axis=1)])
    corners = corners[keep]
    if not followed.arrived[i]:
        return np.asarray(corners)
    way = followed.rays.directions[i, [2, 1]]
    ahead = (end - corners[-1, 0]) / way[0] if way[0] else -1.0
    way = way * ahead if ahead > 0 else way / np.hypot(*way) * length / 4
    return np.concatenate([corners, corners[-1:] + way])


def _extent(corners: Floats) -> Extent:
    """Return the extent of some points."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _union(boxes: list[Extent]) -> Extent:
    """Return the extent around others."""
    low, high = np.array(boxes)[:, :2].min(axis=0), np.array(boxes)[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


# The parts of the document.


def _bodies(scene: SceneLike) -> tuple[list[str], tuple[str, ...]]:
    """Return the path of each body, and the names of bodies without one."""
    drawn, left_out = [], []
    for i in range(len(scene)):
        body = scene.body(i)
        shape = body.shape
        while isinstance(shape, Painted) and not shape.motion.steps:
            shape = shape.operand
        line, moved = section_path(shape), place_path(shape)
        if line is None or moved is None:
            left_out.append(body.name or str(i))
            continue
        title = f"<title>{escape(body.name)}</title>" if body.name else ""
        drawn.append(f'<path class="{_kind(body.material, shape.is_sheet)}" d="{line}"{moved}>{title}</path>')
    return drawn, tuple(left_out)


def _kind(material: Material | None, is_sheet: bool) -> str:
    """Return the style class: glass, mirror or dark; a sheet is a line."""
    clear = material is not None and np.max(np.asarray(material.transparency)) > 0
    shiny = material is not None and (np.max(np.asarray(material.reflectivity)) > 0 or material.metal_index is not None)
    name = "glass" if clear else "mirror" if shiny else "stop"
    return f"{name} line" if is_sheet else name


def _document(
    box: Extent, width: float, bodies: list[str], lines: list[tuple[str, Floats]], image: float | None, system: Any
) -> str:
    """Return the text of the drawing."""
    room = 0.02 * max(box[2] - box[0], box[3] - box[1])
    left, top = box[0] - room, -box[3] - room
    wide, high = box[2] - box[0] + 2 * room, box[3] - box[1] + 2 * room
    height = max(1.0, width * high / wide)
    name = escape(system.name) if isinstance(system, Prescription) and system.name else "Layout of an optical system"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:.6g}" '
        f'viewBox="{format_path(left)} {format_path(top)} {format_path(wide)} {format_path(high)}">',
        f"<title>{name}</title>",
        "<style>path,line,polyline{vector-effect:non-scaling-stroke;fill:none;stroke-linejoin:round}"
        f".glass{{fill:{_GLASS};fill-opacity:.7;stroke:{_EDGE};stroke-width:1.2}}"
        f".mirror{{fill:#dfe3e6;stroke:{_MIRROR};stroke-width:2}}.stop{{stroke:{_STOP};stroke-width:2.5}}"
        ".line{fill:none}.axis{stroke:#999;stroke-width:.6;stroke-dasharray:8 3 2 3}.image{stroke:#444;stroke-width:1}"
        ".ray{stroke-width:.8}</style>",
        f'<line class="axis" x1="{format_path(left)}" y1="0" x2="{format_path(left + wide)}" y2="0"/>',
        *bodies,
        *(_ray(colour, corners) for colour, corners in lines),
    ]
    if image is not None:
        tall = max([0.1 * high, *(abs(float(corners[-1, 1])) for _, corners in lines)])
        x = format_path(image)
        parts.append(f'<line class="image" x1="{x}" y1="{format_path(-tall)}" x2="{x}" y2="{format_path(tall)}"/>')
    return "\n".join([*parts, "</svg>", ""])


def _ray(colour: str, corners: Floats) -> str:
    """Return the polyline of a ray."""
    points = " ".join(
        f"{format_path(z)},{format_path(-y)}" for z, y in corners.tolist() if math.isfinite(z) and math.isfinite(y)
    )
    return f'<polyline class="ray" stroke="{colour}" points="{points}"/>'


def _svg_path(value: Any) -> Any:
    """Return a checked path that ends with .svg."""
    file = check_path("Layout.save", value)
    if not str(file).lower().endswith(".svg"):
        raise ValueError(f"Layout.save: path must end with .svg, got {str(file)[:80]!r}")
    return file
