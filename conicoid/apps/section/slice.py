"""`Slice`, the intersection of a scene with a plane: bodies per pixel, exact outlines of walls, and images of both."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.records import FloatArray, ignore_fp_errors
from ..._util.text import NameTuple, check_choice
from ..._util.validation import check_callback, check_flag, check_path as checked_path
from ...io.image import Image
from ...kernels.threads import Progress
from ...queries.scene_protocol import SceneLike
from ...render.options import BY, CURVES, check_suffix
from .drawing import OVERLAPPING, UNDEFINED, SliceColors, SliceDrawing, color_slice, pdf_bytes, rasterize, svg_text
from .outline import Outline, OutlineCutter
from .window import Window, make_window

_ROWS = 1 << 21  # points of a query
_OBLIQUE = ((0.41, 0.62, 1.0), (-0.37, -0.58, 1.0))
"""Directions along u, v and the normal that lie in few walls; two, since one of them may pass an edge."""
Mask = npt.NDArray[np.bool_]


class Slice:
    """The bodies that a plane cuts, in pixels of a window; row 0 is the top row. A notebook displays it as an image.

    Attributes
    ----------
    body : int32 (height, width)
        The first listed body at the pixel's centre; -1 for none.
    material : int32 (height, width)
        Its index in `materials`; -1 for none.
    materials : tuple
        The distinct materials of the scene, like `scene.materials`.
    extent : (left, right, bottom, top)
        Coordinates along u and v; across an axis these are world coordinates.
    corner, u, v : float64 (3,)
        The window: corner + s u + t v with 0 <= s, t <= 1.
    """

    def __init__(self, scene: SceneLike, window: Window, body: npt.NDArray[np.int32]) -> None:
        self._scene, self._window = scene, window
        body.setflags(write=False)
        self.body: npt.NDArray[np.int32] = body

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Slice):
            return NotImplemented
        fields = ("corner", "u", "v", "body", "material")
        return self._scene == other._scene and all(np.array_equal(getattr(self, f), getattr(other, f)) for f in fields)

    __hash__ = None  # type: ignore[assignment]

    @property
    def corner(self) -> FloatArray:
        """The lower left corner, (3,)."""
        return self._window.corner

    @property
    def u(self) -> FloatArray:
        """The vector to the right, along the whole width, (3,)."""
        return self._window.u

    @property
    def v(self) -> FloatArray:
        """The vector up, along the whole height, (3,)."""
        return self._window.v

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top), as `plt.imshow(..., extent=...)` takes it."""
        return self._window.extent

    @property
    def materials(self) -> tuple[Any, ...]:
        """The distinct materials of the scene."""
        return NameTuple((material for material, _ in self._scene._prepared.labels.distinct), "slice.materials")

    @cached_property
    def material(self) -> npt.NDArray[np.int32]:
        """The index in `materials` of the body at each pixel, -1 for none."""
        columns = np.where(self.body >= 0, self._columns[self.body], -1).astype(np.int32)
        columns.setflags(write=False)
        return columns

    @cached_property
    def _columns(self) -> Any:
        """The material of each body; one more -1 at the end serves the body -1."""
        return np.append(self._scene._prepared.material_columns, np.int32(-1))

    @cached_property
    def outlines(self) -> tuple[Outline, ...]:
        """Every piece of every wall as a curve, also of sheets and of walls inside other bodies; computed on demand.

        A piece ends where its wall meets others of the same bodies, where the bodies on its sides change, and at the
        edge of the window.
        """
        return tuple(self._cut())

    def _cut(self, progress: Progress | None = None) -> list[Outline]:
        """Compute the outlines."""
        return OutlineCutter(self._scene._prepared, self._window).outlines(progress)

    @cached_property
    def overlapping(self) -> Mask:
        """bool (height, width): whether the pixel's centre is where bodies overlap; bodies that only touch do not."""
        return self._each_row(self._share_space)

    def _share_space(self, points: FloatArray) -> Mask:
        """Return where several bodies hold a point and the beginning of a ray from it, one ray of four.

        A point inside of an overlap or of one of its faces is always found, one on its edge may not be.
        """
        shared = self._scene.bodies_at(points).counts > 1
        rows = np.flatnonzero(shared)
        across, up = self._window.size
        u, v = self.u / across, self.v / up
        directions = np.array(_OBLIQUE) @ np.stack([u, v, np.cross(u, v)])
        reach = min(across / self._window.width, up / self._window.height)
        for d in (*directions, *-directions):
            spans = self._scene.spans(points.reshape(-1, 3)[rows], d, t_max=reach)
            # A body that the ray begins in has a span that begins at no wall
            begun = np.append(0, np.cumsum(spans.enter_clipped))
            rows = rows[np.diff(begun[spans.offsets]) < 2]
        shared.reshape(-1)[rows] = False
        return shared

    @cached_property
    def undefined(self) -> Mask:
        """bool (height, width): whether the pixel's centre is in the scene's domain but in no body.

        False everywhere for a scene without a domain.
        """
        if self._scene.domain is None:
            return np.zeros(self.body.shape, bool)
        domain = type(self._scene)([self._scene.domain])
        return self._each_row(domain.contains) & (self.body < 0)

    def _each_row(self, query: Any) -> Mask:
        """Evaluate a query of points on all pixels, block by block."""
        blocks = [query(self._window.rows(a, b)) for a, b in _blocks(self._window)]
        mask: Mask = np.concatenate(blocks)
        mask.setflags(write=False)
        return mask

    @ignore_fp_errors
    def image(self, by: str = "body", *, outlines: bool = True, legend: bool = True, problems: bool = False) -> Image:
        """Return the slice as an image.

        Parameters
        ----------
        by : "body" or "material"
            Which of them get distinct colours. Materials keep their own colours, as in `Scene.section`, unless two of
            those in the slice look the same.
        outlines : bool
            Draw sheets, and the walls between regions of different colours.
        legend : bool
            Add a legend beside the slice.
        problems : bool
            Paint red where bodies overlap and magenta where the domain is undefined, and draw all walls, hidden ones
            too.

        Returns
        -------
        Image

        Raises
        ------
        ValueError
            For another `by`.
        """
        return rasterize(self._drawing(by, outlines, legend, problems))

    @ignore_fp_errors
    def save(
        self, path: str | os.PathLike[str], by: str = "body", *, outlines: bool = True, legend: bool = True,
        problems: bool = False,
    ) -> None:  # fmt: skip
        """Write the slice to a file: .svg or .pdf with outlines as curves, or the pixels of `image`.

        In .svg, elliptic arcs and parabolas are exact. Hyperbolas, and in .pdf ellipses too, are at most a millionth of
        a pixel off.

        Parameters
        ----------
        path : path-like
            The suffix gives the format.
        by, outlines, legend, problems
            The arguments of `image`.

        Raises
        ------
        ValueError
            For another suffix.
        OSError
            If the file cannot be written.
        """
        from ..._util.files import replace_file

        path = checked_path("Slice", path)
        suffix = os.path.splitext(os.fspath(path))[1].lower()
        check_suffix(suffix, path)
        if suffix not in CURVES:
            self.image(by, outlines=outlines, legend=legend, problems=problems).save(path)
            return
        drawing = self._drawing(by, outlines, legend, problems)
        # The file appears complete or not at all.
        with replace_file(path) as file:
            file.write_bytes(svg_text(drawing).encode() if suffix == ".svg" else pdf_bytes(drawing))

    def _drawing(self, by: str, outlines: bool, legend: bool, problems: bool) -> SliceDrawing:
        """Return the drawing, whatever the format."""
        kind = check_choice("Slice", "by", by, BY)
        lines, legend, problems = (
            check_flag("Slice", name, on)
            for name, on in (("outlines", outlines), ("legend", legend), ("problems", problems))
        )
        colored = color_slice(self._scene._prepared, self.body, self.material, kind)
        if problems:
            colored = self._with_problems(colored)
        across, up = self._window.size
        scale = self._window.width / across, self._window.height / up
        # With `problems` all walls are drawn, hidden ones too.
        drawn = tuple(one for one in self.outlines if problems or self._shows(one, kind)) if lines else ()
        return SliceDrawing(colored, drawn, scale, legend)

    def _with_problems(self, colored: SliceColors) -> SliceColors:
        """Paint overlaps and undefined regions over the colours, and list them in the legend."""
        pixels, rows = colored.pixels.copy(), list(colored.legend)
        for mask, color, text in (
            (self.undefined, UNDEFINED, "undefined"), (self.overlapping, OVERLAPPING, "overlapping"),
        ):  # fmt: skip
            if mask.any():
                pixels[mask] = color
                rows.append((text, color))
        return SliceColors(pixels, tuple(rows))

    def _shows(self, outline: Outline, by: str) -> bool:
        """Return whether an outline is a sheet, or its sides have different colours."""
        # The first listed body on each side is the one that is shown.
        left, right = (side[0] if side else -1 for side in (outline.left, outline.right))
        if by == "body":
            differs = left != right
        else:
            differs = bool(self._columns[left] != self._columns[right])
        return differs or outline.left == outline.right

    def _repr_png_(self) -> bytes:
        return self.image()._repr_png_()

    def __repr__(self) -> str:
        left, right, bottom, top = self.extent
        window = f"[{left:.6g}, {right:.6g}] x [{bottom:.6g}, {top:.6g}]"
        return f"<Slice {self._window.width} x {self._window.height} pixels of {window}>"


def _blocks(window: Window) -> list[tuple[int, int]]:
    """Return (first, last) rows of each query: multiples of eight rows, like the packets of the kernels."""
    step = max(8, _ROWS // window.width // 8 * 8)
    return [(a, min(window.height, a + step)) for a in range(0, window.height, step)]


def cut_scene(
    scene: SceneLike, plane: Any, at: Any, corner: tuple[Any, Any, Any], pixels: Any, progress: Progress | None,
    executor: Any,
) -> Slice:  # fmt: skip
    """Implement `Scene.slice`; `corner` is (origin, u, v)."""
    check_callback("slice", "progress", progress)
    window = make_window(plane, at, corner, pixels, scene.extent)
    body = np.empty((window.height, window.width), np.int32)
    for first, last in _blocks(window):
        body[first:last] = scene.body_at(window.rows(first, last), executor=executor)
        if progress is not None:
            progress(last * window.width, window.height * window.width)
    return Slice(scene, window, body)
