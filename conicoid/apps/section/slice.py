"""A slice of a scene by a plane: what is at each pixel, the exact outlines of walls, and pictures of both."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray
from ..._util.errstate import ignore_fp_errors
from ..._util.hints import check_choice, with_method_hints
from ..._util.name_tuples import NamedPartTuple
from ..._util.validation import check_callback, check_flag
from ..._util.validation import check_path as checked_path
from ...io.images.image import Image
from ...queries.id_arrays import as_id_array
from .drawing import OVERLAPPING, UNDEFINED, SliceColors, SliceDrawing, color_slice
from .options import BY, CURVES, check_suffix
from .outline import Outline, OutlineCutter
from .window import Window, make_window

if TYPE_CHECKING:
    from ...kernels.threads import Progress
    from ...queries.scene_protocol import SceneLike

_ROWS = 1 << 21  # points asked at a time
Mask = npt.NDArray[np.bool_]


@with_method_hints
class Slice:
    """What a plane meets, in pixels of a window; row 0 is the uppermost. Shows itself in a notebook.

    body       int32 (height, width): the first listed body at the pixel's centre, -1 for none
    material   int32 (height, width): its place in `materials`, -1 for none
    materials  the different materials of the scene, as `scene.materials`
    extent     (left, right, bottom, top): along u and v, and so, across an axis, coordinates of the world
    corner, u, v   the window: corner + s u + t v with 0 <= s, t <= 1
    """

    def __init__(self, scene: SceneLike, window: Window, body: npt.NDArray[np.int32]) -> None:
        self._scene, self._window = scene, window
        body.setflags(write=False)
        self.body: npt.NDArray[np.int32] = as_id_array("body", body)

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
        """To the right, over the whole width, (3,)."""
        return self._window.u

    @property
    def v(self) -> FloatArray:
        """Up, over the whole height, (3,)."""
        return self._window.v

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top), what `plt.imshow(..., extent=...)` takes."""
        return self._window.extent

    @property
    def materials(self) -> tuple[Any, ...]:
        """The different materials of the scene."""
        return NamedPartTuple((material for material, _ in self._scene.prepared.labels.distinct), "slice.materials")

    @cached_property
    def material(self) -> npt.NDArray[np.int32]:
        """The place in `materials` of what is at each pixel, -1 for none."""
        found = np.where(self.body >= 0, self._columns[self.body], -1).astype(np.int32)
        found.setflags(write=False)
        result: npt.NDArray[np.int32] = as_id_array("material", found)
        return result

    @cached_property
    def _columns(self) -> Any:
        """The material of each body, -1 behind the last."""
        prepared = self._scene.prepared
        numbers = np.arange(prepared.lowered.body_count)
        return np.append(prepared.labels.columns_of(numbers, self.materials), -1) if len(numbers) else np.array([-1])

    @cached_property
    def outlines(self) -> tuple[Outline, ...]:
        """Every piece of every wall, as a curve, found when first asked for: sheets and what is hidden too.

        Each ends where its wall meets others of the same bodies, or where what is on its sides changes, or at the edge
        of the window.
        """
        return tuple(self._cut())

    def _cut(self, progress: Progress | None = None) -> list[Outline]:
        return OutlineCutter(self._scene.prepared, self._window).outlines(progress)

    @cached_property
    def overlapping(self) -> Mask:
        """bool (height, width): is the pixel's centre in more than one body?"""
        return self._each_row(lambda rows: self._scene.bodies_at(rows).counts > 1)

    @cached_property
    def undefined(self) -> Mask:
        """bool (height, width): is the pixel's centre in the scene's domain, and in no body? Without one, none is."""
        if self._scene.domain is None:
            return np.zeros(self.body.shape, bool)
        domain = type(self._scene)([self._scene.domain])
        return self._each_row(domain.contains) & (self.body < 0)

    def _each_row(self, ask: Any) -> Mask:
        found = [ask(self._window.rows(a, b)) for a, b in _blocks(self._window)]
        mask: Mask = np.concatenate(found)
        mask.setflags(write=False)
        return mask

    @ignore_fp_errors
    def image(self, by: str = "body", *, outlines: bool = True, legend: bool = True, problems: bool = False) -> Image:
        """The slice as a picture.

        by: "body" or "material": what has a colour of its own. Materials have their own, as in `Scene.section`, if no
            two of those in the slice look the same.
        outlines: draw the walls between what is coloured apart, and sheets.
        legend: beside the slice, of what is in it.
        problems: red where bodies overlap, magenta where the domain is undefined; and all walls, hidden ones too.
        """
        from .raster import rasterize

        return rasterize(self._drawing(by, outlines, legend, problems))

    @ignore_fp_errors
    def save(
        self, path: str | os.PathLike[str], by: str = "body", *, outlines: bool = True, legend: bool = True,
        problems: bool = False,
    ) -> None:  # fmt: skip
        """Write the slice at `path`, as .svg or .pdf with outlines that are curves, or as an `Image` is saved.

        by, outlines, legend, problems: as for `image`.

        In .svg arcs of ellipses and parabolas are exact, hyperbolas, and in .pdf ellipses, are at most a millionth of a
        pixel off. Raises ValueError for another suffix, OSError where it cannot be written.
        """
        from ..._util.safe_files import replace_file

        path = checked_path("Slice", path)
        suffix = os.path.splitext(os.fspath(path))[1].lower()
        check_suffix(suffix, path)
        if suffix not in CURVES:
            self.image(by, outlines=outlines, legend=legend, problems=problems).save(path)
            return
        drawing = self._drawing(by, outlines, legend, problems)
        with replace_file(path) as file:
            file.write_bytes(_write_slice(drawing, suffix))

    def _drawing(self, by: str, outlines: bool, legend: bool, problems: bool) -> SliceDrawing:
        """What is drawn, in any format."""
        kind = check_choice("Slice", "by", by, BY)
        lines, legend, problems = (
            check_flag("Slice", name, on)
            for name, on in (("outlines", outlines), ("legend", legend), ("problems", problems))
        )
        colored = color_slice(self._scene.prepared, self.body, self.material, kind)
        if problems:
            colored = self._with_problems(colored)
        across, up = self._window.size
        scale = self._window.width / across, self._window.height / up
        drawn = tuple(one for one in self.outlines if problems or self._shows(one, kind)) if lines else ()
        return SliceDrawing(colored, drawn, scale, legend)

    def _with_problems(self, colored: SliceColors) -> SliceColors:
        pixels, rows = colored.pixels.copy(), list(colored.legend)
        for mask, color, text in (
            (self.undefined, UNDEFINED, "undefined"), (self.overlapping, OVERLAPPING, "overlapping"),
        ):  # fmt: skip
            if mask.any():
                pixels[mask] = color
                rows.append((text, color))
        return SliceColors(pixels, tuple(rows))

    def _shows(self, outline: Outline, by: str) -> bool:
        """Is what is seen on both sides coloured apart, or is it a sheet?"""
        left, right = (side[0] if side else -1 for side in (outline.left, outline.right))
        if by == "body":
            apart = left != right
        else:
            apart = bool(self._columns[left] != self._columns[right])
        return apart or outline.left == outline.right

    def _repr_png_(self) -> bytes:
        return self.image()._repr_png_()

    def __repr__(self) -> str:
        left, right, bottom, top = self.extent
        window = f"[{left:.6g}, {right:.6g}] x [{bottom:.6g}, {top:.6g}]"
        return f"<Slice {self._window.width} x {self._window.height} pixels of {window}>"


def _write_slice(drawing: SliceDrawing, suffix: str) -> bytes:
    if suffix == ".svg":
        from .svg import svg_text

        return svg_text(drawing).encode()
    from .pdf import pdf_bytes

    return pdf_bytes(drawing)


def _blocks(window: Window) -> list[tuple[int, int]]:
    """Rows that are asked at a time: of few blocks of eight rows, as packets are."""
    step = max(8, _ROWS // window.width // 8 * 8)
    return [(a, min(window.height, a + step)) for a in range(0, window.height, step)]


def cut_scene(
    scene: SceneLike, origin: Any, u: Any, v: Any, pixels: Any, at: Any, progress: Progress | None, executor: Any
) -> Slice:
    """`Scene.slice`"""
    check_callback("slice", "progress", progress)
    window = make_window(origin, u, v, pixels, at, scene.extent)
    body = np.empty((window.height, window.width), np.int32)
    for first, last in _blocks(window):
        body[first:last] = scene.body_at(window.rows(first, last), executor=executor)
        if progress is not None:
            progress(last * window.width, window.height * window.width)
    return Slice(scene, window, body)
