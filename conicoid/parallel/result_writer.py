"""Writers of answers to more rays than memory holds: part by part beside the file, and as one file at the end.

`result_writer` makes the writer of a query, and `write_answers` lets it write. Each format is an array for each field
(.npz, .zarr, .npy) or a table with a column for each number (.csv, .parquet).
`scene.stream` runs such a query part by part.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .._util.files import (
    create_partial,
    lock_file,
    read_regular,
    release_partial,
    replace_file,
    resolve_output,
    write_text,
)  # fmt: skip
from .._util.text import check_choice
from .._util.validation import DEFAULT_T_MAX, DEFAULT_T_MIN, check_integer, check_path as checked_path, describe_kind
from ..io.array_file import StoredArray, check_output, csv_lines, quote_csv, write_arrays, write_columns
from ..io.ray_file import RayFile, TimedRays
from ..io.result_file import (
    HIT_ROW_FIELDS,
    encode_lists,
    hit_head_arrays,
    hit_row_arrays,
    integral_columns,
    length_columns,
    list_row_arrays,
    table_columns,
)
from ..kernels.threads import Progress
from ..queries.hits import Hits
from ..queries.rays import ArrayRays, LazyRays, Rays
from ..queries.result import QueryResult
from ..queries.scene_protocol import SceneLike
from ..queries.spans import Crossings, Spans
from ..queries.weights import BODY
from .queries import RayRequest, answer_part, assemble, ray_chunks, ray_tasks, workers_of
from .shared_state import SharedObject, shared_scene, source_version
from .workers import ScheduledTask, Workers, run_tasks

SUFFIXES = (".npz", ".csv", ".parquet", ".zarr")
"""Suffixes of files of hits, spans and crossings."""
VALUE_SUFFIXES = (".npy", *SUFFIXES)
"""Suffixes of files of values: `occluded`, `lengths`, `line_integral`."""
_TEXT = "lines"
_BLOCK = 1 << 22
_MOST_STATE = 1 << 24  # bytes


class ResultParts:
    """The parts of a file of results, in a folder beside it: a file for each array or column.

    With a `key`, which names the work by its rays, its scene and the version, the folder `hits.csv.parts` stays after
    a failure. `state.json` then has the number of rays that are done and of valid bytes of each file. Bytes beyond
    belong to a piece that was not finished: each piece is written after the valid bytes of the one before. `state.json`
    is replaced after the columns are written, so it never counts more than they hold. It has the number of the folder
    that becomes the result, too: a run that was killed after that had its name is known to be finished. Without a key
    the folder has a name that nothing else has.

    Raise ValueError if the folder of parts exists and `resume` is false, or if it belongs to other work.
    """

    def __init__(self, output: Path, key: str | None, resume: bool) -> None:
        self.key = key
        self.rays = self.found = 0
        self.result: int | None = None
        self.lock = -1
        self.sizes: dict[str, int] = {}
        self.kinds: dict[str, Any] = {}
        if key is None:
            self.folder, self.lock = create_partial(resolve_output(output), ".parts", folder=True)
            return
        self.folder = parts_folder(output)
        shutil.rmtree(self._removed, ignore_errors=True)
        if self.folder.exists():
            if not resume:
                raise ValueError(f"{self.folder}: is left of an earlier run; --resume goes on with it, or remove it")
            self._read()
        else:
            self.folder.mkdir()

    def _read(self) -> None:
        """Read the state. Raise ValueError for that of other work, or if a column lacks bytes."""
        state = self.folder / "state.json"
        if not state.exists():  # the earlier run stopped before its first part
            return
        try:
            saved = json.loads(read_regular(state, _MOST_STATE))
            if saved["key"] != self.key:
                raise ValueError(f"{self.folder}: holds results of other rays, another scene or version; remove it")
            self.rays, self.found = saved["rays"], saved["found"]
            self.sizes, self.kinds, self.result = saved["sizes"], saved["kinds"], saved["result"]
            is_whole = all(self.file(name).stat().st_size >= size for name, size in self.sizes.items())
        except (KeyError, TypeError, UnicodeDecodeError, json.JSONDecodeError, FileNotFoundError):
            is_whole = False
        if not is_whole:
            raise ValueError(f"{self.folder}: is damaged; remove it")

    def file(self, name: str) -> Path:
        """Return the file of a column, which may have any name."""
        return self.folder / f"{list(self.kinds).index(name)}.part"

    def add(self, columns: Mapping[str, bytes | np.ndarray[Any, Any]], rays: int, found: int) -> None:
        """Append the columns of `rays` more rays with `found` results: bytes of a text, or rows of arrays."""
        for name, rows in columns.items():
            if isinstance(rows, bytes):
                self.kinds[name], data = None, rows
            else:
                self.kinds[name] = [np.lib.format.dtype_to_descr(rows.dtype), list(rows.shape[1:])]
                data = np.ascontiguousarray(rows).tobytes()
            path = self.file(name)
            try:
                with open(os.open(path, os.O_CREAT | os.O_WRONLY | getattr(os, "O_BINARY", 0), 0o666), "wb") as file:
                    file.truncate(self.sizes.get(name, 0))  # drop the bytes that a killed run wrote beyond
                    file.seek(0, os.SEEK_END)
                    file.write(data)
            except OSError as error:
                raise OSError(error.errno, error.strerror, os.fspath(path)) from None
            self.sizes[name] = self.sizes.get(name, 0) + len(data)
        self.rays, self.found = self.rays + rays, self.found + found
        self._write()

    def _write(self) -> None:
        """Write the state, if there is a key."""
        if self.key is not None:
            names = ("key", "rays", "found", "sizes", "kinds", "result")
            write_text(self.folder / "state.json", json.dumps({name: getattr(self, name) for name in names}))

    def write_about(self, result: int) -> None:
        """Write the number of the folder that becomes the result."""
        self.result = result
        self._write()

    def column(self, name: str) -> np.ndarray[Any, Any]:
        """Return a column of numbers, memory-mapped."""
        kind, last = np.dtype(self.kinds[name][0]), tuple(self.kinds[name][1])
        if not self.sizes[name]:
            return np.zeros((0, *last), kind)
        return np.memmap(self.file(name), kind, "r").reshape(-1, *last)

    def stored(self, name: str, shape: tuple[int, ...]) -> StoredArray:
        """Return a column as an array whose rows have the leading shape `shape`."""
        column = self.column(name)
        return StoredArray((column,), (*shape, *column.shape[1:]))

    @property
    def _removed(self) -> Path:
        """The name of the folder while it is removed."""
        return self.folder.with_name(f".{self.folder.name}")

    def remove(self) -> None:
        """Remove all parts, at one stroke: a later run begins anew."""
        folder = self.folder
        if self.key is not None:
            try:
                folder = folder.rename(self._removed)
            except OSError:  # another process reads in it
                (folder / "state.json").unlink(missing_ok=True)
        shutil.rmtree(folder, ignore_errors=True)
        release_partial(self.lock)


def parts_folder(output: Path) -> Path:
    """Return the folder of the parts of work that can be resumed."""
    return output.with_name(output.name + ".parts")


def result_writer(
    scene: SceneLike, query: str, output: Path, options: Mapping[str, Any], *, errors: bool = True,
    key: str | None = None, resume: bool = False,
) -> ResultWriter:  # fmt: skip
    """Return the writer of a query's answers.

    Parameters
    ----------
    options
        The arguments of the query beyond its rays.
    errors
        Whether tables have error bounds; other files have them in any case.
    key
        The name of the work, beside scene, query and version: with it the parts stay after a failure.
    resume
        Whether to go on from parts that an earlier run left.
    """
    kinds = dict(first_hit=HitWriter, spans=ListWriter, crossings=ListWriter)
    kind: type[ResultWriter] = kinds.get(query, ValueWriter)
    check_output(output, kind.suffixes)
    writer = kind(scene, query, output, options, errors)
    if key is not None:
        settings = f"{query} {errors} {output.suffix.lower()} {key} {source_version()}"
        # The digest names the work: `resume` continues only the same query of the same scene with the same sources.
        key = hashlib.blake2b(shared_scene(scene).key + settings.encode(), digest_size=16).hexdigest()
    writer.parts = ResultParts(output, key, resume)
    if key is not None and output.is_dir() and not writer.is_finished:
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(output))
    return writer


def write_answers(
    writer: ResultWriter, answers: Iterable[Any], shape: tuple[int, ...] | None, home: bytes | None,
    progress: Progress | None = None, total: int = 0,
) -> None:  # fmt: skip
    """Write all answers to rays of the leading shape `shape`, or to a flat sequence if it is None.

    home: the scene whose surfaces the rays start on. The progress function gets the number of rays done, and the total.
    """
    parts = writer.parts
    try:
        for answer in answers:
            writer.add(answer)
            if progress is not None:
                progress(parts.rays, max(parts.rays, total))
        writer.finish(shape, home)
    except BaseException:
        # Without a key no later run goes on with the parts: they go even after Ctrl-C.
        if parts.key is None:
            parts.remove()
        raise
    parts.remove()


class ResultWriter:
    """A writer of one query's answers: so far those to `parts.rays` rays with `parts.found` hits or rows."""

    suffixes: tuple[str, ...] = SUFFIXES
    parts: ResultParts

    def __init__(self, scene: SceneLike, query: str, output: Path, options: Mapping[str, Any], errors: bool) -> None:
        self.scene, self.query, self.output, self.options, self.errors = scene, query, output, options, errors
        self._suffix = output.suffix.lower()

    def add(self, answer: Any) -> None:
        """Add the answers to some more rays."""
        if self._suffix == ".csv":
            lines = csv_lines(self._columns(answer))
            heading = next(lines)
            rows: dict[str, Any] = {_TEXT: (("" if self.parts.rays else heading) + "".join(lines)).encode()}
        else:
            rows = self._columns(answer) if self._suffix == ".parquet" else self._arrays(answer)
        self.parts.add(rows, *self._counts(answer))

    def finish(self, shape: tuple[int, ...] | None, home: bytes | None) -> None:
        """Join all parts."""
        nothing = np.zeros((0, 3))
        # Rays with the home scene of the file: they carry its key into the head of the result.
        none = Rays._spawned(nothing, nothing, Rays(nothing, nothing)._starts, home)
        if not self.parts.rays:
            self.add(self._answer(none))
        if self._suffix == ".csv":
            text = self.parts.file(_TEXT)
            link = text.with_suffix(".link")
            if self.output.exists() and self.output.samefile(text):  # its name since a run that was killed after that
                return
            with contextlib.ExitStack() as locks, replace_file(self.output) as partial:
                locks.callback(release_partial, lock_file(text))  # until the file has its name
                link.unlink(missing_ok=True)
                try:  # the part stays until then
                    os.link(text, link)
                    os.replace(link, partial)
                except OSError:  # a file system without links
                    shutil.copyfile(text, partial)
        elif self._suffix == ".parquet":
            write_columns(self.output, {name: self.parts.column(name) for name in self.parts.kinds})
        elif not self.is_finished:
            arrays = self._whole((self.parts.rays,) if shape is None else shape, none)
            write_arrays(self.output, arrays, self.parts.write_about)

    @property
    def is_finished(self) -> bool:
        """Whether the folder of results has its name since an earlier run, which was killed after that."""
        return self.output.is_dir() and self.output.stat().st_ino == self.parts.result

    def _answer(self, rays: Rays) -> Any:
        """Return the answer to some rays in this process."""
        options = dict(self.options)
        values = (options.pop("values"),) if self.query == "line_integral" else ()
        return getattr(self.scene, self.query)(*values, rays, **options)

    def _counts(self, answer: Any) -> tuple[int, int]:
        """Return the numbers of rays and of hits or rows."""
        raise NotImplementedError

    def _columns(self, answer: Any) -> dict[str, Any]:
        """Return the columns of a table, flat."""
        return table_columns(self.query, answer, self.errors, self.parts.rays)

    def _arrays(self, answer: Any) -> dict[str, Any]:
        """Return arrays with a row for each ray, span or crossing."""
        raise NotImplementedError

    def _whole(self, leading: tuple[int, ...], none: Rays) -> dict[str, Any]:
        """Return the arrays of the whole file; `leading` is the shape of the rays, and `none` is no ray."""
        raise NotImplementedError

    def _head(self, none: Rays) -> dict[str, Any]:
        """Return the keys of scenes, and names and materials of bodies."""
        prepared = self.scene._prepared
        # Only the bodies that occur, so that the file of a few hits in a large scene is small.
        labels = prepared.labels.select(_distinct(self.parts.column("body")))
        return hit_head_arrays(none, prepared.key, labels)


class ValueWriter(ResultWriter):
    """A writer of values: an array (...) or (..., columns) with the query's name, or a table of columns."""

    suffixes = VALUE_SUFFIXES

    def __init__(self, scene: SceneLike, query: str, output: Path, options: Mapping[str, Any], errors: bool) -> None:
        super().__init__(scene, query, output, options, errors)
        nothing = np.zeros((0, 3))
        self._axes = self._answer(Rays(nothing, nothing)).shape[1:]  # those after the rays; wrong options end here

    def _counts(self, answer: Any) -> tuple[int, int]:
        count = len(answer.reshape(-1, *self._axes))
        return count, count

    def _columns(self, answer: Any) -> dict[str, Any]:
        if self.query == "occluded":
            return {self.query: answer.reshape(-1, *self._axes)}
        if self.query == "lengths":
            names = length_columns(self.scene, self.options.get("by", BODY))
        else:
            names = integral_columns(self._axes)
        rows = answer.reshape(-1, len(names))
        return {quote_csv(name): rows[:, k] for k, name in enumerate(names)}

    def _arrays(self, answer: Any) -> dict[str, Any]:
        return {self.query: answer.reshape(-1, *self._axes)}

    def _whole(self, leading: tuple[int, ...], none: Rays) -> dict[str, Any]:
        return {self.query: self.parts.stored(self.query, leading)}


class HitWriter(ResultWriter):
    """A writer of first hits, with all fields."""

    def _counts(self, answer: Hits) -> tuple[int, int]:
        return answer.size, int((answer.body >= 0).sum())

    def _arrays(self, answer: Hits) -> dict[str, Any]:
        # Parts of a picture have two axes.
        rows, count = hit_row_arrays(answer.detached()), answer.size
        starts = np.broadcast_to(rows.pop("starts"), (count,))
        return {name: row.reshape(count, *row.shape[answer.ndim :]) for name, row in rows.items()} | {"starts": starts}

    def _whole(self, leading: tuple[int, ...], none: Rays) -> dict[str, Any]:
        rows = {
            name: self.parts.stored(name, (self.parts.rays,) if name == "starts" else leading)
            for name in HIT_ROW_FIELDS
        }
        return rows | self._head(none)


class ListWriter(ResultWriter):
    """A writer of spans or crossings, with all fields."""

    def _counts(self, answer: Spans | Crossings) -> tuple[int, int]:
        return len(answer), len(answer.body)

    def _arrays(self, answer: Spans | Crossings) -> dict[str, Any]:
        arrays = encode_lists(answer.detached())
        # Offsets of a part count from 0: shift them by the rows before it.
        offsets = self.parts.found + arrays["offsets"].astype(np.int64)
        rows = {name: arrays[name] for name in list_row_arrays(answer)}
        # Both ends are two columns, as rows of a part must have one length.
        rows |= {f"ends_{k}": ends for k, ends in enumerate(arrays.get("ends", ()))}
        rows |= {name: arrays[name].reshape(-1, 3) for name in ("origins", "directions")}
        starts = np.broadcast_to(arrays["starts"], (len(answer),))
        # The first offset of a part repeats the last of the part before it.
        return rows | {"starts": starts, "offsets": offsets[1 if self.parts.rays else 0 :]}

    def _whole(self, leading: tuple[int, ...], none: Rays) -> dict[str, Any]:
        parts, arrays = self.parts, {}
        for name in parts.kinds:
            if name == "ends_0":
                both = parts.column(name), parts.column("ends_1")
                arrays["ends"] = StoredArray(both, (2, len(both[0])))
            elif name != "ends_1":
                shape = leading if name in ("origins", "directions") else (len(parts.column(name)),)
                arrays[name] = parts.stored(name, shape)
        lists = encode_lists(self._answer(none).detached())
        return arrays | {name: lists[name] for name in ("body_count", "materials") if name in lists} | self._head(none)


def _distinct(column: Any) -> Any:
    """Return the distinct numbers of a column; it is read in blocks, as it may be larger than memory."""
    distinct = np.zeros(0, column.dtype)
    for begin in range(0, len(column), _BLOCK):
        distinct = np.union1d(distinct, np.asarray(column[begin : begin + _BLOCK]))
    return distinct


def file_state(path: Path) -> str:
    """Return sizes, times and number of a file, or of the files of a folder: they differ after a change."""
    stats = [os.stat(file) for file in ([path] if path.is_file() else sorted(_files(path)))]
    return f"{sum(s.st_size for s in stats)} {max((s.st_mtime_ns for s in stats), default=0)} {len(stats)}"


def _files(folder: Path) -> Iterator[Path]:
    """Yield the files of a folder."""
    return (file for file in folder.rglob("*") if file.is_file())


# `scene.stream`: queries of more rays than memory holds, one part after the other, in order.

QUERIES = ("first_hit", "occluded", "spans", "crossings", "lengths", "line_integral")
"""The queries of `scene.stream`."""
_READ = 1 << 18  # rays to read from a file at a time
_LIMITS = DEFAULT_T_MIN, DEFAULT_T_MAX


def stream(
    scene: Any, rays: Any, query: str, chunk: int | None, executor: Any, out: Any, options: dict[str, Any]
) -> Any:
    """Run `scene.stream`."""
    check_choice("stream", "query", query, QUERIES)
    if query == "line_integral" and "values" not in options:
        raise TypeError("stream: line_integral needs values=")
    limits = options.pop("t_min", _LIMITS[0]), options.pop("t_max", _LIMITS[1])
    base = workers_of("stream", executor)
    # The user's workers keep their own size of tasks
    workers = base if chunk is None else base.changed(chunk=check_integer("stream", "chunk", chunk, 1))
    if isinstance(rays, QueryResult):
        raise TypeError(f"stream: rays must be Rays, arrays or an iterable of such, got {describe_kind(rays)}")
    if isinstance(rays, str | os.PathLike):
        # The file's own interval must not conflict with an explicit one.
        file = RayFile(rays)
        file.check_limits(*(None if limit == usual else limit for limit, usual in zip(limits, _LIMITS, strict=True)))
        rays, shape, home = file.pieces(workers.chunk or _READ), file.shape, file.home
    else:
        shape = rays.shape if isinstance(rays, Rays | LazyRays) else None
        home = rays._home if isinstance(rays, Rays) else None
    answers = _iterate_answers(scene, _sources(rays), query, options, limits, workers)
    if out is None:
        return answers

    writer = result_writer(scene, query, Path(checked_path("stream", out, "out")), options)
    write_answers(writer, answers, shape, home)
    return writer.parts.rays


def _iterate_answers(
    scene: SceneLike, sources: Iterator[Any], query: str, options: dict[str, Any], limits: tuple[Any, Any],
    workers: Workers,
) -> Iterator[Any]:  # fmt: skip
    """Yield the answers to all parts, in order."""
    pace = ray_chunks(workers, 1)

    def pieces() -> Iterator[ScheduledTask]:
        for source in sources:
            rays, *own_limits = source if isinstance(source, TimedRays) else (source, None, None)
            ends = (limit if end is None else end for end, limit in zip(own_limits, limits, strict=True))
            request = RayRequest(query, rays, None, *ends)
            # Rays of each source may have another size.
            pace.most = ray_chunks(workers, request.bytes_each).most
            yield from ray_tasks(query, request, pace)

    shared = shared_scene(scene), SharedObject(options)
    with run_tasks("stream", workers, answer_part, shared, pieces(), pace.saw) as results:
        for task, columns in results:
            yield assemble(scene, query, task.arguments[1].to_rays(), columns)


def _sources(rays: Any) -> Iterator[Rays | LazyRays | TimedRays]:
    """Yield the parts of the user's rays, each with a length."""
    if isinstance(rays, Rays | LazyRays | TimedRays):
        yield rays
    elif isinstance(rays, tuple) and len(rays) == 2 and all(hasattr(part, "shape") for part in rays):
        yield ArrayRays(*rays)
    elif hasattr(rays, "shape") and hasattr(rays, "__getitem__"):
        yield ArrayRays(rays)
    elif isinstance(rays, Iterable) and not isinstance(rays, str | bytes):
        for part in rays:
            yield from _sources(part)
    else:
        raise TypeError(f"stream: rays must be Rays, arrays or an iterable of such, got {describe_kind(rays)}")
