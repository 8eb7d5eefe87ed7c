"""`project`: the sinogram of a scene, in memory, in a file, or lazily."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.files import replace_file
from ..._util.records import ignore_fp_errors
from ..._util.validation import check_callback, check_integer, check_path as checked_path, describe_kind
from ...geometry.body import Body
from ...geometry.shape import Shape
from ...kernels.threads import Progress
from ...parallel.queries import RayRequest, value_parts, workers_of
from ...queries.line_integrals import trailing_axes
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike
from ...queries.weights import LineValues
from .scan_geometry import ScanGeometry


@ignore_fp_errors
def project(
    scene: SceneLike | Shape | Body,
    geometry: ScanGeometry,
    values: LineValues,
    *,
    otherwise: npt.ArrayLike | None = None,
    executor: Any = None,
    out: str | os.PathLike[str] | None = None,
    chunks: int | None = None,
    progress: Progress | None = None,
) -> Any:
    """Compute the sinogram of a scene: for each ray the sum of value × length over the bodies that it crosses.

    Lengths are exact but for rounding: nothing is cut into voxels. Where bodies overlap, the values of all of them
    count.

    Parameters
    ----------
    scene : Scene, Shape or Body
        The bodies.
    geometry : ScanGeometry
        A scan of `co.ct`.
    values, otherwise
        As for `scene.line_integral`: by body, (bodies,) or (bodies, energies); a mapping from names of materials; or
        the name of a property of materials.
    executor : optional
        As for `scene.first_hit`. Workers make the rays themselves.
    out : path, optional
        A .npy file for the sinogram; it appears whole or not at all. Neither rays nor sinogram are held in memory.
    chunks : int, optional
        Views of a block of a lazy array of Dask. Nothing is traced before that array is computed.
    progress : callable, optional
        progress(done, count) is called with numbers of rays.

    Returns
    -------
    ndarray, memmap or dask.array.Array
        float64 (views, rows, columns), or (views, columns) of a plane scan; several energies are one more axis, the
        last. With `out`, the file mapped into memory; with `chunks`, the lazy array.

    Raises
    ------
    TypeError
        If `geometry` is no scan, or arguments exclude each other.
    OSError
        If the file cannot be written.
    ValueError
        As `scene.line_integral`, and if `out` does not end with .npy.
    """
    target = extension("as_scene")("project", scene)
    if not isinstance(geometry, ScanGeometry):
        raise TypeError(
            f"project: geometry must be one of co.ct, got {describe_kind(geometry)}; "
            "co.ct.parallel(angles, columns) is one"
        )
    check_callback("project", "progress", progress)
    if chunks is not None:
        if executor is not None or out is not None:
            raise TypeError("project: chunks goes without executor and out: Dask's own scheduler computes lazy arrays")
        return _lazy(target, geometry, values, otherwise, check_integer("project", "chunks", chunks, 1))
    request = RayRequest("project", geometry.lazy_rays, None, *geometry.interval)
    options = dict(values=values, otherwise=otherwise)
    trailing = trailing_axes(target._prepared, "line_integral", options)
    parts = value_parts(target, "line_integral", request, options, workers_of("line_integral", executor, progress))
    shape = (*geometry.shape, *trailing)
    if out is None:
        sinogram = np.zeros(shape)
        _fill(sinogram, trailing, parts)
        return sinogram
    path = os.fspath(checked_path("project", out, "out"))
    if not path.endswith(".npy"):
        raise ValueError(f"project: out must end with .npy, got {path[:80]!r}")
    return _file(path, shape, trailing, parts)


def _fill(sinogram: Any, trailing: tuple[int, ...], parts: Iterator[tuple[int, int, Any]]) -> None:
    """Write the parts into an array."""
    flat = sinogram.reshape((-1, *trailing))
    for begin, end, part in parts:
        flat[begin:end] = part


def _file(path: str, shape: tuple[int, ...], trailing: tuple[int, ...], parts: Iterator[tuple[int, int, Any]]) -> Any:
    """Write the parts into a new file, one after the other, and map it."""
    with replace_file(path) as partial, open(partial, "wb") as file:
        header = dict(descr="<f8", fortran_order=False, shape=shape)
        np.lib.format.write_array_header_1_0(file, header)
        # The parts come in order, so that they are appended without an index.
        for _, _, part in parts:
            file.write(np.ascontiguousarray(part, "<f8").data.cast("B"))
    return np.load(path, mmap_mode="r")


def _lazy(scene: SceneLike, geometry: ScanGeometry, values: Any, otherwise: Any, views: int) -> Any:
    """Return the sinogram as an array of Dask, with one task for each block of views."""
    from ...parallel.dask_arrays import lazy_parts

    trailing = trailing_axes(scene._prepared, "line_integral", dict(values=values, otherwise=otherwise))
    # An empty scan still makes one block, with the right shape.
    starts = range(0, max(geometry.views, 1), views)
    shares = [geometry[start : start + views] for start in starts]
    return lazy_parts(scene, _views, shares, (values, otherwise), [(*share.shape, *trailing) for share in shares])


def _views(scene: SceneLike, geometry: ScanGeometry, values: tuple[Any, Any]) -> Any:
    """Return the sinogram of some views; this runs in a task."""
    return project(scene, geometry, values[0], otherwise=values[1])
