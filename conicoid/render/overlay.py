"""Axes, names and normals, drawn over a picture. Pixels that nothing is drawn on stay as they are, to the bit.

`Canvas` is the transparent sheet to draw on. It is finer than the picture below it, so that lines and letters are
smooth.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from decimal import Decimal
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.files import printable
from .._util.records import dot_rows, ignore_fp_errors, row_lengths
from ..materials.color import linear_rgb, srgb_decode, srgb_encode
from ..numerics.portable_math import hypot
from .camera import Camera, FisheyeCamera, OrthographicCamera

if TYPE_CHECKING:
    from .._util.records import FloatArray
    from ..queries.scene_protocol import SceneLike
    from .camera import AnyCamera


_SUPERSAMPLING = 3
Place = Sequence[float]


class Canvas:
    """Drawing in pixels of the picture, from its top left corner."""

    def __init__(self, width: int, height: int) -> None:
        from PIL import Image, ImageDraw

        self.width, self.height = width, height
        self._sheet = Image.new("RGBA", (_SUPERSAMPLING * width, _SUPERSAMPLING * height))
        self._draw = ImageDraw.Draw(self._sheet)

    @cached_property
    def unit(self) -> float:
        """Pixels that stand for one on a picture 480 high: lines and letters grow with large pictures."""
        return max(1.0, min(self.width, self.height) / 480)

    def line(self, places: Sequence[Place], color: str, width: float, opacity: float = 1.0) -> None:
        """A line along some places; places far beside the picture are no harm."""
        ends = [tuple(_SUPERSAMPLING * min(max(c, -1e5), 1e5) for c in place) for place in places]
        self._draw.line(
            ends, (*_bytes(color), round(255 * opacity)), round(_SUPERSAMPLING * width * self.unit), "curve"
        )

    def size_of(self, text: str, size: float) -> tuple[float, float]:
        """Width and height of a text."""
        left, top, right, bottom = self._draw.textbbox((0, 0), text, self._font(size), "mm")
        return (right - left) / _SUPERSAMPLING, (bottom - top) / _SUPERSAMPLING

    def text(self, place: Place, text: str, color: str, size: float) -> None:
        """A text about a place, with a light rim that keeps it legible."""
        x, y = (_SUPERSAMPLING * c for c in place)
        rim, light = round(1.5 * _SUPERSAMPLING * self.unit), (255, 255, 255, 225)
        fill, font = (*_bytes(color), 255), self._font(size)
        self._draw.text((x, y), text, fill, font, "mm", stroke_width=rim, stroke_fill=light)

    def _font(self, size: float) -> Any:
        from PIL import ImageFont

        return ImageFont.load_default(_SUPERSAMPLING * size * self.unit)

    def over(self, pixels: Any) -> Any:
        """Linear pixels with the sheet upon them."""
        drawn = np.asarray(self._sheet).reshape(self.height, _SUPERSAMPLING, self.width, _SUPERSAMPLING, 4)
        opacity = drawn[..., 3:] / 255
        share = opacity.mean(axis=(1, 3))
        light = srgb_decode(np.arange(256) / 255)[drawn[..., :3]]
        color = (light * opacity).mean(axis=(1, 3))
        return np.where(share > 0, pixels * (1 - share) + color, pixels).astype(np.float32)


@cache
def is_in_font(letter: str) -> bool:
    """Whether a letter looks other than one that no font has."""
    from PIL import ImageFont

    font: Any = ImageFont.load_default(20)
    return letter.isascii() or bytes(font.getmask(letter)) != bytes(font.getmask("\U0010ffff"))


def _bytes(color: str) -> tuple[int, int, int]:
    red, green, blue = (round(255 * float(c)) for c in srgb_encode(linear_rgb(color)))
    return red, green, blue


def round_down_125(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most a length."""
    power = float(f"1e{Decimal(length).adjusted()}")
    return power * next((k for k in (5, 2) if k * power <= length), 1)


# Points of the world as a camera sees them.

_NEARLY_WHOLE = 1 - 1e-6  # of the way to a point: the surface that it lies on does not hide it


def find_hidden(scene: SceneLike, camera: AnyCamera, points: Any) -> Any:
    """bool (n,): do bodies stand between the camera and points (n, 3) in front of it?"""
    lens = camera.lens
    depths = dot_rows(points - lens[0], lens[3])
    result = np.ones(len(points), bool)
    is_around = not isinstance(camera, Camera | OrthographicCamera)
    front = (points != lens[0]).any(axis=-1) if is_around else depths > 0
    ways = depths[front, None] * lens[3] if isinstance(camera, OrthographicCamera) else points[front] - lens[0]
    result[front] = scene.occluded(points[front] - ways, ways, t_max=_NEARLY_WHOLE) if front.any() else False
    return result


def pixel_sizes(camera: AnyCamera, points: Any, height: int) -> Any:
    """(n,): the length in the world that is a pixel long, where points (n, 3) are."""
    if isinstance(camera, OrthographicCamera):
        return np.full(len(points), camera.height / height)
    lens = camera.lens
    if not isinstance(camera, Camera):
        angle = math.radians(camera.field_of_view if isinstance(camera, FisheyeCamera) else 180.0)
        return row_lengths(points - lens[0]) * (angle / height)
    return 2 * dot_rows(points - lens[0], lens[3]) * row_lengths(lens[5]) / height


def grid_of_hits(scene: SceneLike, camera: AnyCamera, width: int, height: int, step: float) -> Any:
    """The first hits (rows, columns) of rays about `step` pixels apart."""
    return scene.first_hit(camera.rays(max(1, round(width / step)), max(1, round(height / step))))


# The axes of the world: from the origin, or from a corner where that is far away; dim where bodies hide them.

_AXIS_COLORS = ("#c8102e", "#1a7f37", "#1f4fd0")
_AXIS_STEPS = 240
_NUMBER_GAP = 30  # pixels between two numbers, at least


def draw_axes(sheet: Canvas, scene: SceneLike, camera: AnyCamera) -> None:
    """x in red, y in green, z in blue, with ticks and numbers."""
    low, high = scene.extent
    size = float((high - low).max())
    near = ((low - size <= 0) & (high + size >= 0)).all()
    start = np.zeros(3) if near else low
    for axis in range(3):
        end = start.copy()
        end[axis] = max(high[axis], start[axis]) + 0.15 * size
        _draw_axis(sheet, scene, camera, axis, start, end, round_down_125(size / 3))


def _draw_axis(
    sheet: Canvas, scene: SceneLike, camera: AnyCamera, axis: int, start: FloatArray, end: FloatArray, step: float
) -> None:
    points = start + np.linspace(0, 1, _AXIS_STEPS + 1)[:, None] * (end - start)
    places = camera.project(points, sheet.width, sheet.height)
    is_projected = ~np.isnan(places[:, 0])
    is_hidden = find_hidden(scene, camera, (points[:-1] + points[1:]) / 2)
    for dim in (True, False):  # visible parts are drawn last
        for first, last in _runs((is_hidden == dim) & is_projected[:-1] & is_projected[1:]):
            line = places[first : last + 1].tolist()
            if not dim:
                sheet.line(line, "white", 4, 0.6)
            sheet.line(line, _AXIS_COLORS[axis], 1.2 if dim else 2, 0.35 if dim else 1.0)
    _draw_numbers(sheet, camera, axis, start, end, step)
    if is_projected[-1]:
        sheet.text(places[-1].tolist(), "xyz"[axis], _AXIS_COLORS[axis], 17)


def _draw_numbers(sheet: Canvas, camera: AnyCamera, axis: int, start: FloatArray, end: FloatArray, step: float) -> None:
    numbers = np.arange(np.floor(start[axis] / step) + 1, np.ceil(end[axis] / step)) * step
    numbers = numbers[numbers <= end[axis] - 0.3 * step]
    points = np.tile(start, (len(numbers), 1))
    points[:, axis] = numbers
    ends = camera.project(np.array([start, end]), sheet.width, sheet.height)
    along = ends[1] - ends[0]
    length = hypot(*along.tolist())
    if not length >= 0.5 * _NUMBER_GAP * sheet.unit:
        return  # the axis points at the eye
    if length * step / abs(end[axis] - start[axis]) < _NUMBER_GAP * sheet.unit:
        numbers, points = numbers[-1:], points[-1:]
    across = np.array([-along[1], along[0]]) / length
    across *= np.sign(across[1]) or 1.0  # below the line, or to its right
    for number, place in zip(numbers.tolist(), camera.project(points, sheet.width, sheet.height), strict=True):
        if np.isfinite(place).all():
            tick = across * 4 * sheet.unit
            sheet.line([(place - tick).tolist(), (place + tick).tolist()], _AXIS_COLORS[axis], 1.5)
            sheet.text((place + 3.2 * tick).tolist(), f"{number + 0.0:g}", _AXIS_COLORS[axis], 11)


def _runs(mask: FloatArray) -> list[tuple[int, int]]:
    """[first, last) of each stretch of true entries."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


# Names of bodies, each where most of its entry is seen; the largest first, as long as there is room.

_FINEST = 512  # rays along the longer side
_MOST, _LONGEST = 60, 40
_LEAST_RAYS = 6  # rays that must see an entry
_SIZE = 14
_SHIFTS = ((0, 0), (0, -1.2), (0, 1.2), (0, -2.4), (0, 2.4))
Box = tuple[float, float, float, float]
Ints = npt.NDArray[np.int32]


def draw_labels(sheet: Canvas, scene: SceneLike, camera: AnyCamera) -> None:
    """The name of each entry that is seen, or the number of its first body where it has none."""
    step = max(1.0, max(sheet.width, sheet.height) / _FINEST)
    hits = grid_of_hits(scene, camera, sheet.width, sheet.height, step)
    entries = np.where(hits.hit, np.append(scene._prepared.lowered.body_item, -1)[hits.body], -1)
    depths = _depths(entries)
    boxes: list[Box] = []
    found, counts = np.unique(entries[entries >= 0], return_counts=True)
    for k in np.argsort(-counts, kind="stable")[:_MOST].tolist():
        if counts[k] < _LEAST_RAYS:
            return
        own = np.where(entries == found[k], depths, -1)
        deepest = np.argwhere(own == own.max())
        row, column = deepest[np.argmin(((deepest - deepest.mean(axis=0)) ** 2).sum(axis=1))]
        place = camera.project(hits.point[row, column], sheet.width, sheet.height)
        _place_label(sheet, _entry_label(scene, int(found[k])), place.tolist(), boxes)


def _depths(entries: Ints) -> Ints:
    """How many steps each pixel is away from the next that shows another entry, or from the edge."""
    depths = np.zeros(entries.shape, np.int32)
    inner = np.zeros(entries.shape, bool)
    middle = entries[1:-1, 1:-1]
    inner[1:-1, 1:-1] = (middle == entries[:-2, 1:-1]) & (middle == entries[2:, 1:-1])
    inner[1:-1, 1:-1] &= (middle == entries[1:-1, :-2]) & (middle == entries[1:-1, 2:])
    while inner.any():
        depths += inner
        across = inner[1:-1, :-2] & inner[1:-1, 2:]
        inner[1:-1, 1:-1] &= inner[:-2, 1:-1] & inner[2:, 1:-1] & across
    return depths


def _entry_label(scene: SceneLike, entry: int) -> str:
    number = int(np.searchsorted(scene._prepared.lowered.body_item, entry))
    name = printable_label(scene.bodies[entry].name or str(number))
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"


def printable_label(text: str) -> str:
    """A text in letters that the font has, which are ASCII and a few signs: without accents, others by number."""
    return "".join(c if is_in_font(c) else _plain(c) for c in printable(text))


def _plain(letter: str) -> str:
    base = "".join(c for c in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(c))
    return base.encode("ascii", "backslashreplace").decode()


def _place_label(sheet: Canvas, text: str, place: list[float], boxes: list[Box]) -> None:
    """Draw a text near a place, where it covers no other; nowhere if there is no such room."""
    width, height = (size + 4 * sheet.unit for size in sheet.size_of(text, _SIZE))
    x = min(max(place[0], width / 2), max(width / 2, sheet.width - width / 2))
    for across, down in _SHIFTS:
        left, y = x + across * width, place[1] + down * height
        y = min(max(y, height / 2), max(height / 2, sheet.height - height / 2))
        box = (left - width / 2, y - height / 2, left + width / 2, y + height / 2)
        if not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in boxes):
            boxes.append(box)
            sheet.text((left, y), text, "#101010", _SIZE)
            return


# --- Outward normals of visible surfaces, as arrows of one length in the picture, shorter if they point at the eye

_ARROW_SPACING, _ARROW_LENGTH, _ARROW_HEAD = 30, 22, 5  # pixels of a small picture
_ARROW_COLOR = "#7a1fa2"


def draw_normals(sheet: Canvas, scene: SceneLike, camera: AnyCamera) -> None:
    """An arrow on each point of a grid of pixels that shows a body."""
    hits = grid_of_hits(scene, camera, sheet.width, sheet.height, _ARROW_SPACING * sheet.unit)
    hits = hits[hits.hit]
    lengths = _ARROW_LENGTH * sheet.unit * pixel_sizes(camera, hits.point, sheet.height)
    starts = camera.project(hits.point, sheet.width, sheet.height)
    ends = camera.project(hits.point + lengths[:, None] * hits.normal, sheet.width, sheet.height)
    for start, end in zip(starts, ends, strict=True):
        if np.isfinite(end).all():
            arrow = _arrow(start, end, _ARROW_HEAD * sheet.unit)
            for color, width, opacity in (("white", 3.5, 0.6), (_ARROW_COLOR, 1.5, 1.0)):
                for line in arrow:
                    sheet.line(line, color, width, opacity)


def _arrow(start: np.ndarray, end: np.ndarray, head: float) -> list[list[list[float]]]:
    """Its shaft and its head; a cross where it points at the eye."""
    along = end - start
    length = hypot(*along.tolist())
    if length < 1:
        a, b = np.array([head / 2, 0]), np.array([0, head / 2])
        return [[(start - a).tolist(), (start + a).tolist()], [(start - b).tolist(), (start + b).tolist()]]
    along *= min(head, 0.6 * length) / length
    side = np.array([-along[1], along[0]]) * 0.6
    return [
        [start.tolist(), end.tolist()],
        [(end - along + side).tolist(), end.tolist(), (end - along - side).tolist()],
    ]


@ignore_fp_errors
def draw_overlay(
    pixels: npt.NDArray[np.float32], scene: SceneLike, camera: AnyCamera, *, axes: bool, labels: bool, normals: bool
) -> npt.NDArray[np.float32]:
    """Return linear pixels (height, width, 3) with axes, names of bodies and normals drawn over them, as chosen."""
    height, width = pixels.shape[:2]
    sheet = Canvas(width, height)
    for wanted, draw in ((normals, draw_normals), (axes, draw_axes), (labels, draw_labels)):
        if wanted:
            draw(sheet, scene, camera)
    return sheet.over(pixels)
