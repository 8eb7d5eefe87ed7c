"""Beams through a prescription: spots in the image plane, ray fans, and drawings of the system."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from html import escape
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..._util.records import dataclass
from ..._util.text import check_choice
from ..._util.validation import check_integer, check_number, check_path, describe_kind
from ...materials.material import Material
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike, is_scene
from ..section.drawing import svg_path
from ..section.outline import OutlineCutter
from ..section.window import Window
from .medium import check_wavelength
from .prescriptions import Prescription
from .ray_trace import follow, trace

MOST_RINGS = 1000
_INSIDE = 1 - 1e-9
"""Radius of the outermost rays, in radii of the pupil: a ray exactly on a rim would be undecided."""


@dataclass(frozen=True, eq=False)
class Spot:
    """A spot: the points of a beam in the image plane.

    Parameters
    ----------
    points : ndarray (n, 2)
        x and y of the rays that arrive.
    pupil : ndarray (n, 2)
        Their places in the entrance pupil, whose rim is at 1.
    wavelengths : ndarray (n,)
        In μm.
    vignetted : float
        Share of rays that did not arrive.
    field : float
        The field of the beam.
    """

    points: Floats
    pupil: Floats
    wavelengths: Floats
    vignetted: float
    field: float

    @property
    def centroid(self) -> Floats:
        """Mean of the points, (2,)."""
        return np.asarray(self.points.mean(axis=0))

    @property
    def rms(self) -> float:
        """Root mean square distance from the centroid."""
        return math.sqrt(float(((self.points - self.centroid) ** 2).sum(axis=1).mean()))

    @property
    def radius(self) -> float:
        """Greatest distance from the centroid."""
        return float(np.hypot(*(self.points - self.centroid).T).max())

    def __repr__(self) -> str:
        return f"Spot({len(self.points)} rays, rms {self.rms:.4g}, radius {self.radius:.4g}, field {self.field:g})"


@dataclass(frozen=True, eq=False)
class RayFan:
    """Transverse errors of a row of rays across the pupil.

    Parameters
    ----------
    pupil : ndarray (n,)
        Places in the pupil, from -1 to 1.
    error : ndarray (n, 2)
        x and y in the image plane, from the chief ray's; NaN of rays that do not arrive.
    axis, field, wavelength
        The arguments of `ray_fan`.
    """

    pupil: Floats
    error: Floats
    axis: str
    field: float
    wavelength: float


def beam(system: Prescription, field: float = 0.0, *, pupil: npt.ArrayLike) -> Rays:
    """Make the rays of one field through points of the entrance pupil.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis, or the height of a near object.
    pupil : array_like (n, 2)
        x and y in units of the pupil's radius.

    Returns
    -------
    Rays
        (n,)
    """
    angle = _field(system, "beam", field)
    disc = np.asarray(pupil, dtype=np.float64)
    if disc.ndim != 2 or disc.shape[1] != 2 or not np.isfinite(disc).all():
        raise ValueError(f"beam: pupil must be finite and of shape (n, 2), got shape {disc.shape}")
    # The points in the plane of the entrance pupil.
    through = np.column_stack([disc * (_INSIDE * system.aperture / 2), np.full(len(disc), system.pupil)])
    if not math.isinf(system.object_distance):
        start = np.array([0.0, angle, -system.object_distance])
        return Rays(np.broadcast_to(start, through.shape), through - start)
    slope = math.tan(math.radians(angle))
    way = np.array([0.0, slope, 1.0])
    low = float(system.scene.bounds[0][2]) if system.bodies else 0.0
    # Rays start in front of all bodies.
    first = min(0.0, low) - system.aperture
    way /= np.linalg.norm(way)
    return Rays(through - ((system.pupil - first) / way[2]) * way, way)


def rings(count: int) -> Floats:
    """Return points of a disc on equidistant rings, 6 k on the k-th, and the middle: (1 + 3 count (count + 1), 2)."""
    points = [np.zeros((1, 2))]
    for k in range(1, count + 1):
        # Odd rings are turned by half a step, so that rays do not line up.
        angles = 2 * math.pi * (np.arange(6 * k) + 0.5 * (k % 2)) / (6 * k)
        points.append(k / count * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.concatenate(points)


def spot(
    system: Prescription,
    field: float = 0.0,
    *,
    wavelength: float | Literal["all"] | None = None,
    count: int = 12,
    z: float | None = None,
) -> Spot:
    """Compute the spot of a field in the image plane.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis; of a near object its height.
    wavelength : float or "all", optional
        In μm; the default is the primary one. "all" is all of the prescription's.
    count : int
        Number of rings of rays in the pupil, with 6, 12, 18 ... rays.
    z : float, optional
        Of the plane; the default is that of the image.

    Returns
    -------
    Spot

    Raises
    ------
    ValueError
        If no ray arrives.
    """
    angle = _field(system, "spot", field)
    disc = rings(check_integer("spot", "count", count, 1, MOST_RINGS))
    plane = system.image if z is None else check_number("spot", "z", z)
    waves = system.wavelengths if isinstance(wavelength, str) and wavelength == "all" else (wavelength,)
    rays = beam(system, angle, pupil=disc)
    points, places, colours = [], [], []
    for choice in waves:
        wave = system.wavelength if choice is None else check_wavelength("spot", choice)
        traced = trace(system, rays, wave)
        points.append(traced.at(plane)[traced.arrived, :2])
        places.append(disc[traced.arrived])
        colours.append(np.full(len(points[-1]), wave))
    arrived = np.concatenate(points)
    if not len(arrived):
        raise ValueError(f"spot: field must be one with a ray that arrives, got {angle:g}")
    # Over all wavelengths.
    lost = 1 - len(arrived) / (len(disc) * len(waves))
    return Spot(arrived, np.concatenate(places), np.concatenate(colours), lost, angle)


def ray_fan(
    system: Prescription,
    field: float = 0.0,
    *,
    axis: Literal["x", "y"] = "y",
    wavelength: float | None = None,
    count: int = 41,
) -> RayFan:
    """Compute transverse ray errors across the pupil.

    Errors are those from the chief ray, the one through the pupil's middle. If that is obstructed, as in a telescope,
    it is traced without the obstruction.

    Parameters
    ----------
    system : Prescription
        The lens system.
    field : float
        Degrees off the axis; of a near object its height.
    axis : {"y", "x"}
        "y" is the fan in the plane of the field, "x" the one across it.
    wavelength : float, optional
        In μm; the default is the primary one.
    count : int
        Number of rays.

    Returns
    -------
    RayFan
    """
    angle = _field(system, "ray_fan", field)
    across = check_choice("ray_fan", "axis", axis, ("x", "y"))
    number_of = check_integer("ray_fan", "count", count, 2, 100_000)
    wave = system.wavelength if wavelength is None else check_wavelength("ray_fan", wavelength)
    line = np.linspace(-1, 1, number_of)
    disc = np.zeros((number_of + 1, 2))
    # Ray 0 is the chief ray, through the middle of the pupil.
    disc[1:, "xy".index(across)] = line
    rays = beam(system, angle, pupil=disc)
    points = trace(system, rays, wave).at(system.image)[1:, :2]
    chief = trace(system, rays[:1], wave, obstructions=False).at(system.image)[0, :2]
    return RayFan(line, points - chief, across, angle, wave)


def _field(system: Any, owner: str, field: Any) -> float:
    """Check the system and the field. Return the field."""
    if not isinstance(system, Prescription):
        raise TypeError(f"{owner}: system must be a Prescription, got {describe_kind(system)}")
    angle = check_number(owner, "field", field)
    if math.isinf(system.object_distance) and abs(angle) >= 90:
        raise ValueError(f"{owner}: field must be below 90 degrees, got {angle:g}")
    return angle


# Drawings of optical systems: the section of bodies with the plane x = 0, z to the right and y up, and rays, as SVG.
#
# The sections are the outlines of slices (`apps/section`), as paths. Lines, ellipses and parabolas are exact, since SVG
# has them. It has no hyperbolas: these are cubics that are within a millionth of the drawing.

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
        Names or numbers of bodies that the plane x = 0 does not cut.
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
        A scene of any bodies, which together are of finite size.
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
    bodies, left_out = _bodies(scene, box)
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

_CLOSE = 1e-6
"""Largest distance of a cubic from its hyperbola, as a share of the drawing's size."""


def format_path(value: float) -> str:
    """Return a number in the form of SVG."""
    return f"{value + 0.0:.12g}"


@dataclass(frozen=True)
class _SectionFrame:
    """The frame of the paths: lengths z to the right and -y down, about a middle."""

    middle: tuple[float, float]
    scale: tuple[float, float] = (1.0, 1.0)

    def places(self, about: Any) -> Floats:
        """Return the places in the paths of places about the middle."""
        return np.asarray((about + np.array(self.middle)) * (1.0, -1.0))


def _bodies(scene: SceneLike, box: Extent) -> tuple[list[str], tuple[str, ...]]:
    """Return the path of each body, and the names of bodies without one."""
    drawn, left_out = [], []
    across, up = 1.1 * (box[2] - box[0]), 1.1 * (box[3] - box[1])
    frame = _SectionFrame(((box[0] + box[2]) / 2, (box[1] + box[3]) / 2))
    corner = np.array([0.0, frame.middle[1] - up / 2, frame.middle[0] - across / 2])
    window = Window(corner, np.array([0.0, 0.0, across]), np.array([0.0, up, 0.0]), 1, 1)
    for i in range(len(scene)):
        body = scene.body(i)
        line = _section_path(scene, i, window, frame)
        if not line:
            left_out.append(body.name or str(i))
            continue
        title = f"<title>{escape(body.name)}</title>" if body.name else ""
        drawn.append(f'<path class="{_kind(body.material, body.shape.is_sheet)}" d="{line}">{title}</path>')
    return drawn, tuple(left_out)


def _section_path(scene: SceneLike, body: int, window: Window, frame: _SectionFrame) -> str:
    """Return the path of a body's section: closed loops around a solid, open lines of a sheet; empty if there is none.

    The pen goes along each outline with the solid on its left. The next outline is the one that starts nearest to its
    place, which is the same corner but for rounding.
    """
    parts: list[str] = []
    start, end = np.zeros(2), np.full(2, math.inf)
    rest, off = OutlineCutter(scene._prepared, window, body).outlines(), _CLOSE * max(window.size)
    while rest:
        ends = [(one.end, one.start) if body in one.right else (one.start, one.end) for one in rest]
        gaps = [float(np.linalg.norm(first - end)) for first, _ in ends]
        k = int(np.argmin(gaps))
        path = svg_path(frame, rest[k], off, format_path, body in rest[k].right)
        del rest[k]
        is_next = gaps[k] <= off
        parts.append(path.split(" ", 3)[3] if is_next else path)  # without the move to where the pen is
        start, end = start if is_next else ends[k][0], ends[k][1]
        if np.linalg.norm(end - start) <= off and not scene.body(body).shape.is_sheet:
            parts.append("Z")
            end = np.full(2, math.inf)
    return " ".join(parts)


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
