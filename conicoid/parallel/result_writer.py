"""Writers of answers to more rays than memory holds: part by part beside the file, and as one file at the end."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..io.npz import StoredArray
from ..io.ray_file import (
    CROSSING_ARRAYS,
    CROSSING_ERROR_ARRAYS,
    HIT_ARRAYS,
    HIT_ERROR_ARRAYS,
    SPAN_ARRAYS,
    SPAN_ERROR_ARRAYS,
    check_output,
    crossing_columns,
    csv_lines,
    hit_columns,
    integral_columns,
    length_columns,
    quote_csv,
    span_columns,
)
from ..io.ray_stream import RayStream
from ..io.result_file import HIT_ROW_FIELDS, ResultParts, encode_lists, hit_head_arrays, hit_row_arrays, list_row_arrays
from ..queries.rays import Rays
from ..queries.spans import Crossings, Spans
from ..queries.weights import BODY
from .shared_state import shared_scene, source_version

if TYPE_CHECKING:
    from ..queries.hits import Hits
    from ..queries.scene_protocol import SceneLike


VALUE_SUFFIXES = (".npy", ".npz", ".csv", ".parquet", ".zarr")
"""Suffixes of files of values: `occluded`, `lengths`, `line_integral`."""
_VALUE_TEXT = "lines"


class ValueWriter:
    """A writer of values: an array (...) or (..., columns) in .npy, .npz and .zarr, else a table of columns.

    In .npz and .zarr the array has the query's name.
    """

    def __init__(self, scene: SceneLike, query: str, output: Path, options: Mapping[str, Any]) -> None:
        check_output(output, VALUE_SUFFIXES)
        self.scene, self.query, self.options = scene, query, dict(options)
        self.suffix = output.suffix.lower()
        self._nothing = self._of_no_rays()
        self._parts = ResultParts(output, "", resume=False)

    @property
    def rays(self) -> int:
        """Number of rays written."""
        return self._parts.rays

    def add(self, answer: Any) -> None:
        """Add the answers to some more rays, (...) or (..., columns)."""
        answer = answer.reshape(-1, *self._nothing.shape[1:])
        rows: dict[str, Any] = {self.query: answer}
        if self.suffix == ".parquet":
            rows = self._columns(answer)
        elif self.suffix == ".csv":
            lines = csv_lines(self._columns(answer))
            heading = next(lines)
            rows = {_VALUE_TEXT: (("" if self.rays else heading) + "".join(lines)).encode()}
        self._parts.add(rows, len(answer), len(answer))

    def finish(self, shape: tuple[int, ...] | None, _home: bytes | None) -> None:
        """Join all parts, for rays of the leading shape `shape`, or for a flat sequence if it is None."""
        parts = self._parts
        if not parts.rays:
            self.add(self._nothing)
        if self.suffix == ".csv":
            parts.finish_text(_VALUE_TEXT)
        elif self.suffix == ".parquet":
            parts.finish_table()
        else:
            whole = parts.stored(self.query, shape or (parts.rays,))
            if self.suffix == ".npy":
                parts.finish_array(whole)
            else:
                parts.finish_arrays({self.query: whole}, {})

    def give_up(self) -> None:
        """Remove all parts."""
        shutil.rmtree(self._parts.folder, ignore_errors=True)

    def _of_no_rays(self) -> Any:
        """Return the answer to no rays: it has the trailing shape."""
        options, nothing = dict(self.options), np.zeros((0, 3))
        values = (options.pop("values"),) if self.query == "line_integral" else ()
        return getattr(self.scene, self.query)(*values, nothing, nothing, **options)

    def _columns(self, answer: Any) -> dict[str, Any]:
        """Return the columns of a table."""
        if self.query == "occluded":
            return {self.query: answer}
        if self.query == "lengths":
            names = length_columns(self.scene, self.options.get("by", BODY))
        else:
            names = integral_columns(answer.shape[1:])
        rows = answer.reshape(len(answer), len(names))
        return {quote_csv(name): rows[:, k] for k, name in enumerate(names)}


# Writers of hits, spans and crossings, with all fields.

if TYPE_CHECKING:
    Answer = Hits | Spans | Crossings

SUFFIXES = (".npz", ".csv", ".parquet", ".zarr")
"""Suffixes of results that are written part by part."""
_TEXT = "lines"
_BLOCK = 1 << 22
_OF_SCENES = "body_count", "materials"
_FIELDS = dict(
    first_hit=(HIT_ARRAYS, HIT_ERROR_ARRAYS),
    spans=(SPAN_ARRAYS, SPAN_ERROR_ARRAYS),
    crossings=(CROSSING_ARRAYS, CROSSING_ERROR_ARRAYS),
)
"""The fields of a table of each query's answers, and their error bounds."""


class ResultWriter:
    """A writer of hits, spans or crossings: so far `found` hits or rows of `rays` rays.

    Until the end the parts lie in a folder beside the file, from which `resume` goes on. Raise ValueError if that
    folder holds other work, and for other suffixes.
    """

    def __init__(self, scene: SceneLike, query: str, output: Path, key: str, *, errors: bool, resume: bool) -> None:
        check_output(output, SUFFIXES)
        self.scene, self.query, self.errors = scene, query, errors
        self.suffix = output.suffix.lower()
        settings = f"{query} {errors} {self.suffix} {key} {source_version()}"
        # The digest names the work: `resume` continues only the same query of the same scene with the same sources.
        digest = hashlib.blake2b(shared_scene(scene).key + settings.encode(), digest_size=16).hexdigest()
        self._parts = ResultParts(output, digest, resume)

    @property
    def rays(self) -> int:
        """Number of rays written."""
        return self._parts.rays

    @property
    def found(self) -> int:
        """Number of hits or rows written."""
        return self._parts.found

    def add(self, answer: Answer) -> None:
        """Add the answers to some more rays."""
        lists = isinstance(answer, Spans | Crossings)
        found = len(answer.body) if lists else int((answer.body >= 0).sum())
        if self.suffix in (".npz", ".zarr"):
            rows = self._list_rows(answer) if isinstance(answer, Spans | Crossings) else _hit_rows(answer)
        elif self.suffix == ".csv":
            rows = {_TEXT: self._text(answer)}
        else:
            rows = self._columns(answer)
        self._parts.add(rows, len(answer) if isinstance(answer, Spans | Crossings) else answer.size, found)

    def finish(self, shape: tuple[int, ...] | None, home: bytes | None) -> None:
        """Join all parts, for rays of the leading shape `shape`, or for a flat sequence if it is None.

        home: the scene whose surfaces the rays start on.
        """
        parts, nothing = self._parts, np.zeros((0, 3))
        # Rays with the home scene of the file: they carry its key into the head of the result.
        none = Rays._spawned(nothing, nothing, Rays(nothing, nothing)._starts, home)
        if not parts.rays:
            self.add(getattr(self.scene, self.query)(none))
        if self.suffix == ".csv":
            parts.finish_text(_TEXT)
        elif self.suffix == ".parquet":
            parts.finish_table()
        else:
            leading = shape or (parts.rays,)
            prepared = self.scene._prepared
            # Only the bodies that occur, so that the file of a few hits in a large scene is small.
            labels = prepared.labels.of_only(_distinct(parts.column("body")))
            if self.query != "first_hit":
                arrays, lists = self._lists_of(leading), getattr(self.scene, self.query)(none).detached()
                more = {name: array for name, array in encode_lists(lists).items() if name in _OF_SCENES}
            else:
                flat = {
                    name: parts.stored(name, (parts.rays,) if name == "starts" else leading) for name in HIT_ROW_FIELDS
                }
                arrays, more = flat, {}
            parts.finish_arrays(arrays, more | hit_head_arrays(none, prepared.key, labels))

    def give_up(self) -> None:
        """Remove all parts."""
        shutil.rmtree(self._parts.folder, ignore_errors=True)

    def _lists_of(self, leading: tuple[int, ...]) -> dict[str, StoredArray]:
        """Return the arrays of spans or crossings: those of rays in the rays' shape, both ends as two rows of one."""
        parts, arrays = self._parts, {}
        for name in parts.kinds:
            # Both ends were written as two columns, as rows of a part must have one length.
            if name == "ends_1":
                continue
            if name == "ends_0":
                both = parts.column(name), parts.column("ends_1")
                arrays["ends"] = StoredArray(both, (2, len(both[0])))
            else:
                vectors = name in ("origins", "directions")
                arrays[name] = parts.stored(name, leading if vectors else (len(parts.column(name)),))
        return arrays

    def _list_rows(self, answer: Spans | Crossings) -> dict[str, Any]:
        """Return the arrays of some spans or crossings, with offsets into all rows."""
        arrays = encode_lists(answer.detached())
        # Offsets of a part count from 0: shift them by the rows before it.
        offsets = self.found + arrays["offsets"].astype(np.int64)
        rows = {name: arrays[name] for name in list_row_arrays(answer)}
        rows |= {f"ends_{k}": ends for k, ends in enumerate(arrays.get("ends", ()))}
        rows |= {name: arrays[name].reshape(-1, 3) for name in ("origins", "directions")}
        starts = np.broadcast_to(arrays["starts"], (len(answer),))
        # The first offset of a part repeats the last of the part before it.
        return rows | {"starts": starts, "offsets": offsets[1 if self.rays else 0 :]}

    def _columns(self, answer: Answer) -> dict[str, Any]:
        """Return columns of a table, flat."""
        usual, errors = _FIELDS[self.query]
        names = (*usual, *(errors if self.errors else ()))
        arrays = {name: getattr(answer, name) for name in names}
        if isinstance(answer, Spans | Crossings):
            arrays["offsets"] = answer.offsets
            columns = (span_columns if self.query == "spans" else crossing_columns)(arrays, self.rays)
        else:
            columns = hit_columns(arrays)
        return {name: np.asarray(column).reshape(-1) for name, column in columns.items()}

    def _text(self, answer: Answer) -> bytes:
        """Return lines of a .csv file; the first ones with its heading."""
        lines = csv_lines(self._columns(answer))
        heading = next(lines)
        return ("" if self.rays else heading).encode() + "".join(lines).encode()


def _hit_rows(hits: Hits) -> dict[str, Any]:
    """Return all that `hits.save` writes of each ray, flat: parts of a picture have two axes."""
    rows, count = hit_row_arrays(hits.detached()), hits.size
    flat = {
        name: rows[name].reshape(count, *rows[name].shape[hits.ndim :]) for name in HIT_ROW_FIELDS if name != "starts"
    }
    return flat | {"starts": np.broadcast_to(rows["starts"], (count,))}


def _distinct(column: Any) -> Any:
    """Return the distinct numbers of a column; it is read in blocks, as it may be larger than memory."""
    distinct = np.zeros(0, column.dtype)
    for begin in range(0, len(column), _BLOCK):
        distinct = np.union1d(distinct, np.asarray(column[begin : begin + _BLOCK]))
    return distinct


def trace_file(
    scene: SceneLike, rays: RayStream, output: Path, query: str, *, chunk: int, resume: bool, errors: bool,
    t_min: float | None, t_max: float | None, executor: Any, told: Callable[[int, int], Any],
) -> tuple[int, int]:  # fmt: skip
    """Trace a file of rays into a file of answers. Return the number of hits or rows, and of rays.

    The callback gets the number of rays done, and the total if it is known.
    """
    key = f"{_state(rays.path)} {t_min} {t_max}"
    writer = ResultWriter(scene, query, output, key, errors=errors, resume=resume)
    total = 0 if rays.shape is None else int(np.prod(rays.shape))
    # Limits of the file itself stand for missing ones.
    limits: dict[str, Any] = {name: end for name, end in (("t_min", t_min), ("t_max", t_max)) if end is not None}
    pieces = rays.pieces(chunk, writer.rays)
    for answer in scene.stream(pieces, query, chunk=chunk, executor=executor, **limits):
        writer.add(answer)
        told(writer.rays, max(writer.rays, total))
    writer.finish(rays.shape if query == "first_hit" else None, rays.source.home)
    return writer.found, writer.rays


def write_answers(
    scene: SceneLike, query: str, out: Path, shape: tuple[int, ...] | None, home: bytes | None, answers: Iterator[Any],
    options: Mapping[str, Any],
) -> int:  # fmt: skip
    """Write all answers into a new file, whole or not at all. Return the number of rays."""
    writer: ResultWriter | ValueWriter
    if query in _FIELDS:
        writer = ResultWriter(scene, query, out, "", errors=True, resume=False)
    else:
        writer = ValueWriter(scene, query, out, options)
    try:
        for answer in answers:
            writer.add(answer)
        writer.finish(shape, home)
    # A failed query leaves no partial file, not even after Ctrl-C.
    except BaseException:
        writer.give_up()
        raise
    return writer.rays


def _state(path: Path) -> str:
    """Return sizes, times and number of a file, or of the files of a folder: they differ after a change."""
    stats = [os.stat(file) for file in ([path] if path.is_file() else sorted(_files(path)))]
    return f"{sum(s.st_size for s in stats)} {max((s.st_mtime_ns for s in stats), default=0)} {len(stats)}"


def _files(folder: Path) -> Iterator[Path]:
    """Yield the files of a folder."""
    return (file for file in folder.rglob("*") if file.is_file())
