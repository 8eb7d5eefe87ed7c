"""Files of rays, hits, spans and crossings, from which the objects are read back; and results in parts.

The .npz files hold every field, the rays, and the names and materials of bodies, but neither a scene nor a pickle.
`ResultParts` collects results that are written piece by piece and can be resumed.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from .._util.file_errors import SceneFileError, printable
from .._util.safe_files import open_regular, replace_file, write_text
from .._util.validation import format_list, format_value
from ..geometry.body import Body
from ..geometry.labels import Labels
from ..geometry.primitives import Sphere
from ..geometry.sheets import Disc
from ..kernels.entry.first_hits import HitBuffers
from ..kernels.ray import DEAD
from ..materials.material import Material
from ..queries.hits import Hits
from ..queries.rays import Rays
from .npz import NpyFormatError, NpzArchive, StoredArray, write_npy, write_npz
from .ray_file import read_rays
from .ray_stream import write_parquet, write_zarr
from .scene_file.scene_file import SceneParts, parse_scene, scene_data
from .scene_file.writer import dump_json

if TYPE_CHECKING:
    from ..queries.spans import RayLists


# Parts that all these files share: rays, and labels (names and materials of bodies).

RAY_FIELDS = ("origins", "directions", "starts", "starts_home")
LABEL_FIELDS = ("first_bodies", "labels")
"""`labels` holds the bytes of a scene file, in which a ball stands for any solid and a disc for any sheet."""
Arrays = dict[str, Any]


def write_arrays(path: str | os.PathLike[str], arrays: Arrays) -> None:
    """Write a .npz file; it appears whole or not at all. Raise OSError."""
    with replace_file(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)


def read_arrays(
    path: str | os.PathLike[str], wanted: Collection[str], needed: Collection[str], what: str,
    flags: Collection[str] = (),
) -> Arrays:  # fmt: skip
    """Read the `wanted` arrays of a .npz file; those in `needed` must exist, those in `flags` may be booleans.

    `what` is the method that writes such files. Raise ValueError if the file lacks an array or holds others.
    """
    with open_regular(path) as file:
        try:
            archive = NpzArchive(file, os.fstat(file.fileno()).st_size)
        except NpyFormatError as error:
            raise ValueError(f"is not a .npz file ({error})") from None
        missing = [name for name in needed if name not in archive.members]
        if missing:
            there = [printable(name) for name in archive.members]
            lacks = f"it lacks {', '.join(missing[:5])} and holds {format_list(there, 5)}"
            raise ValueError(f"is not a file of {what}: {lacks}{_guess_reader(archive.members, what)}")
        others = [printable(name) for name in archive.members if name not in wanted]
        if others:
            extra = f"it also holds {format_list(others, 5)}{_guess_reader(archive.members, what)}"
            raise ValueError(f"is not a file of {what}: {extra}")
        return dict(archive.arrays(wanted, flags))


_MARKER_FIELDS = {"crossings": ("offsets", "point"), "spans": ("offsets", "ends"), "hits": ("t", "local_point")}


def _guess_reader(members: Collection[str], what: str) -> str:
    """Return a hint for a message: the function that reads a file with these arrays, unless it belongs to `what`."""
    for kind, marks in _MARKER_FIELDS.items():
        if set(marks) <= set(members):
            return f"; co.{kind.capitalize()}.load reads it" if what != f"{kind}.save" else ""
    if {"origins", "directions"} <= set(members):
        intervals = "; rays have no intervals: numpy.load reads them, and first_hit(rays, t_min=...) takes them"
        return intervals if what == "rays.save" else "; co.Rays.load reads it"
    return "; numpy.load reads any .npz file"


@contextlib.contextmanager
def name_file_in_errors(path: str | os.PathLike[str]) -> Iterator[None]:
    """Convert errors of decoding into a ValueError that names the file."""
    try:
        yield
    except SceneFileError as error:
        raise ValueError(f"{os.fspath(path)}: labels are damaged: {error.problems[0].message}") from None
    except (ValueError, IndexError, OverflowError) as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from None


def write_rays_file(path: str | os.PathLike[str], rays: Rays) -> None:
    """Write rays with the surfaces that they start on."""
    write_arrays(path, encode_rays(rays))


def read_rays_file(path: str | os.PathLike[str]) -> Rays:
    """Read rays with the surfaces that they start on, if a .npz file has them; or from a .npy or .csv file.

    Raise ValueError, with the name of the file, or OSError.
    """
    suffix = os.path.splitext(path)[1].lower()
    if suffix in (".npy", ".csv"):
        table = read_rays(path)
        with name_file_in_errors(path):
            return Rays(table.origins, table.directions)
    if suffix != ".npz":
        raise ValueError(f"load: path of rays must end with .npz, .npy or .csv, got {format_value(os.fspath(path))}")
    with name_file_in_errors(path):
        arrays = read_arrays(path, RAY_FIELDS, RAY_FIELDS[:2], "rays.save")
        if "starts" in arrays:
            return decode_rays(arrays)
        return Rays(arrays["origins"], arrays["directions"])


def encode_rays(rays: Rays) -> Arrays:
    """Return the arrays of `RAY_FIELDS`; `starts_home` holds the key of the scene of the starts, or no bytes."""
    home = encode_bytes(rays._home or b"")
    return {"origins": rays.origins, "directions": rays.directions, "starts": rays._starts, "starts_home": home}


def decode_rays(arrays: Arrays) -> Rays:
    """Return the rays of a file's arrays. Raise ValueError for arrays of other shapes and for invalid rays."""
    origins, directions = arrays["origins"], arrays["directions"]
    for name, array in (("origins", origins), ("directions", directions)):
        if array.ndim == 0 or array.shape != origins.shape or array.shape[-1] != 3:
            raise ValueError(f"{name} must have shape {(*origins.shape[:-1], 3)}, got {array.shape}")
    shape, count = origins.shape[:-1], origins.size // 3
    starts = check_integers("starts", arrays["starts"], -(2**31), 2**31 - 1, np.int32)
    if starts.shape not in ((1,), (count,)):
        raise ValueError(f"starts must have shape (1,) or ({count},), got {starts.shape}")
    alive = np.broadcast_to(starts, (count,)).reshape(shape) != DEAD
    Rays(origins[alive], directions[alive])  # raises for invalid rays; dead rays need not be valid
    home = decode_text("starts_home", arrays) if "starts_home" in arrays else b""
    return Rays._spawned(origins, directions, starts, home or None)


def encode_labels(labels: Labels) -> Arrays:
    """Return the arrays of `LABEL_FIELDS`."""
    entries = zip(labels.solid, labels.materials, labels.names, strict=True)
    return {"first_bodies": labels.firsts, "labels": encode_bodies(entries)}


def encode_bodies(entries: Iterable[tuple[bool, Material | None, str | None]]) -> npt.NDArray[np.uint8]:
    """Return entries (is solid, material, name) as the bytes of a scene file, an array of uint8."""
    bodies = tuple(
        Body(Sphere() if solid else Disc((0, 0, 0), (0, 0, 1), 1), material, name) for solid, material, name in entries
    )
    return encode_bytes(dump_json(scene_data(SceneParts(bodies), None)).encode())


def decode_bodies(name: str, arrays: Arrays, path: str | os.PathLike[str]) -> Sequence[Body]:
    """Return the bodies that `encode_bodies` wrote: balls and discs with names and materials."""
    return parse_scene(decode_text(name, arrays).decode(), path).bodies


def decode_labels(arrays: Arrays, bodies: Any, path: str | os.PathLike[str]) -> Labels:
    """Return the labels of a file. Raise ValueError if they do not cover the body numbers in `bodies`."""
    entries = decode_bodies("labels", arrays, path)
    firsts = check_integers("first_bodies", arrays["first_bodies"], 0, 2**53, np.int64)
    if firsts.shape != (len(entries),) or (np.diff(firsts) <= 0).any():
        raise ValueError(f"first_bodies must be {len(entries)} rising numbers, got {firsts.shape}")
    if (bodies >= 0).any() and not (len(firsts) and firsts[0] <= bodies[bodies >= 0].min()):
        raise ValueError("first_bodies must not be above the numbers in body")
    return dataclasses.replace(Labels.of(entries), firsts=firsts)


def check_array_shapes(arrays: Arrays, shape: tuple[int, ...], lasts: dict[str, tuple[int, ...]]) -> None:
    """Raise ValueError unless each array has the shape `shape` + `lasts[name]`."""
    for name, last in lasts.items():
        if arrays[name].shape != (*shape, *last):
            raise ValueError(f"{name} must have shape {(*shape, *last)}, got {arrays[name].shape}")


def check_integers(name: str, array: Any, least: int, most: int, kind: Any) -> Any:
    """Return the floats of a file as integers of dtype `kind`. Raise ValueError for others than `least` to `most`."""
    if not ((array == np.floor(array)) & (array >= least) & (array <= most)).all():
        raise ValueError(f"{name} must hold integers from {least} to {most}")
    return array.astype(kind)


def encode_bytes(content: bytes) -> npt.NDArray[np.uint8]:
    """Return bytes as an array of uint8."""
    return np.frombuffer(content, np.uint8)


def decode_text(name: str, arrays: Arrays) -> bytes:
    """Return the bytes that `encode_bytes` stored. Raise ValueError for numbers that are not bytes."""
    content: bytes = check_integers(name, arrays[name], 0, 255, np.uint8).tobytes()
    return content


# First hits.

_HIT_FLOATS = {
    "t": (),
    "t_error": (),
    "point_error": (),
    "point": (3,),
    "local_point": (3,),
    "normal": (3,),
    "uv": (2,),
}
_HIT_INTS = dict.fromkeys(("body", "face", "surface", "before", "after", "side"), np.int32)
_HIT_FLAGS = ("hit", "entering", "doubtful")
_HIT_FIELDS = (*_HIT_FLOATS, *_HIT_INTS, *_HIT_FLAGS, *RAY_FIELDS, "home", *LABEL_FIELDS)
"""The arrays of a file of hits. `home` holds the bytes of the key of their scene."""


HIT_ROW_FIELDS = tuple(name for name in _HIT_FIELDS if name not in ("home", "starts_home", *LABEL_FIELDS))
"""The arrays with an item for each ray."""


def write_hits_file(path: str | os.PathLike[str], hits: Hits) -> None:
    """Write hits, with or without their scene; the file appears whole or not at all. Raise OSError."""
    detached = hits.detached()
    write_arrays(path, hit_row_arrays(detached) | hit_head_arrays(detached.rays, detached._home, detached._labels))


def hit_row_arrays(hits: Hits) -> dict[str, Any]:
    """Return the arrays with an item for each ray; `starts` is flat, and has one item if all rays share it."""
    rays = encode_rays(hits.rays)
    arrays: dict[str, Any] = {
        name: getattr(hits, name) for name in (*_HIT_FLOATS, *_HIT_INTS, *_HIT_FLAGS) if name != "side"
    }
    arrays["side"] = hits._faces[2].reshape(hits.rays.shape)
    return arrays | {name: rays[name] for name in HIT_ROW_FIELDS if name in rays}


def hit_head_arrays(rays: Rays, home: bytes, labels: Labels) -> dict[str, Any]:
    """Return the other arrays: the keys of the scenes that rays start in and hit, and the labels."""
    return {"starts_home": encode_rays(rays)["starts_home"], "home": encode_bytes(home)} | encode_labels(labels)


def read_hits_file(path: str | os.PathLike[str]) -> Hits:
    """Read hits without their scene, as `hits.detached()`. Raise ValueError, with the name of the file, or OSError."""
    with name_file_in_errors(path):
        return _decode_hits(read_arrays(path, _HIT_FIELDS, _HIT_FIELDS, "hits.save", _HIT_FLAGS), path)


def _decode_hits(arrays: dict[str, Any], path: str | os.PathLike[str]) -> Hits:
    shape = arrays["t"].shape
    check_array_shapes(arrays, shape, {**_HIT_FLOATS, **dict.fromkeys((*_HIT_INTS, *_HIT_FLAGS), ()), "origins": (3,)})
    ints = {
        name: check_integers(name, arrays[name], -1 if name != "side" else -2, 2**31 - 1, np.int32)
        for name in _HIT_INTS
    }
    flags = {name: check_integers(name, arrays[name], 0, 1, np.bool_).ravel() for name in _HIT_FLAGS}
    nothing = np.zeros(arrays["t"].size, np.int32)
    turn = np.where(flags["entering"], 2, 1).astype(np.int8)
    state = {
        "rays": decode_rays(arrays),
        "_found": HitBuffers(arrays["t"].ravel(), ints["body"].ravel(), nothing, nothing, turn),
        "_doubtful": np.flatnonzero(flags["doubtful"]),
        "_faces": np.stack([ints[name].ravel() for name in ("surface", "face", "side")]),
        "_points": arrays["point"].reshape(-1, 3),
        "_errors": arrays["t_error"].ravel(),
        **{name: arrays[name][()] for name in ("point_error", "local_point", "normal", "uv")},
        **{name: ints[name][()] for name in ("before", "after")},
        "_home": decode_text("home", arrays),
        "_labels": decode_labels(arrays, ints["body"], path),
    }
    result = object.__new__(Hits)
    result.__setstate__(state)
    return result


# Spans and crossings: rows by ray, with offsets.

RowsByRay = TypeVar("RowsByRay", bound="RayLists")
_VECTOR = (3,)


@dataclass(frozen=True)
class _ListFields:
    """The row arrays of spans or of crossings: floats with their last axes, integers, and flags."""

    floats: dict[str, tuple[int, ...]]
    ints: tuple[str, ...]
    flags: tuple[str, ...]
    materials: bool
    """True if the file also has the scene's materials, its number of bodies and the surfaces at both ends."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all arrays of a file."""
        more = ("ends", "body_count", "materials") if self.materials else ()
        return (*self.floats, *self.ints, *self.flags, "offsets", *more, *RAY_FIELDS, "home", *LABEL_FIELDS)


_SPAN_FIELDS = _ListFields(
    dict.fromkeys(("t_enter", "t_exit", "t_enter_error", "t_exit_error"), ()),
    ("body",), ("enter_clipped", "exit_clipped"), True,
)  # fmt: skip
_CROSSING_FIELDS = _ListFields(
    {"t": (), "t_error": (), "point": _VECTOR, "normal": _VECTOR},
    ("body", "face", "surface", "before", "after"),
    ("entering",),
    False,
)
_SIDE_NAMES = ("before", "after")
_FIELDS_BY_CLASS = {"Spans": _SPAN_FIELDS, "Crossings": _CROSSING_FIELDS}


def write_lists_file(path: str | os.PathLike[str], answer: Any) -> None:
    """Write spans or crossings, with or without their scene; the file appears whole or not at all. Raise OSError."""
    write_arrays(path, encode_lists(answer.detached()))


def encode_lists(lists: Any) -> Arrays:
    """Return the arrays of a file of spans or crossings, without their scene."""
    fields = _FIELDS_BY_CLASS[type(lists).__name__]
    arrays: Arrays = {name: getattr(lists, name) for name in (*fields.floats, *fields.ints, "offsets", *fields.flags)}
    if fields.materials:
        arrays["ends"], arrays["body_count"] = lists._ends, np.array(lists._body_count)
        arrays["materials"] = encode_bodies((of_solids, material, None) for material, of_solids in lists._distinct)
    return arrays | encode_rays(lists._rays) | {"home": encode_bytes(lists._home)} | encode_labels(lists._labels)


def list_row_arrays(answer: Any) -> tuple[str, ...]:
    """Return the names of the arrays with a row for each span or crossing, except `ends`, which has two."""
    fields = _FIELDS_BY_CLASS[type(answer).__name__]
    return (*fields.floats, *fields.ints, *fields.flags)


def read_lists_file(path: str | os.PathLike[str], kind: type[RowsByRay]) -> RowsByRay:
    """Read spans or crossings without their scene. Raise ValueError, with the name of the file, or OSError."""
    fields = _FIELDS_BY_CLASS[kind.__name__]
    with name_file_in_errors(path):
        arrays = read_arrays(path, fields.names, fields.names, f"{kind.__name__.lower()}.save", fields.flags)
        state = _decode_list_rows(arrays, fields) | {"_labels": decode_labels(arrays, arrays["body"], path)}
        if fields.materials:
            state |= _decode_scene_fields(arrays, path)
    result: Any = object.__new__(kind)
    result.__setstate__(state)
    return result  # type: ignore[no-any-return]


def _decode_list_rows(arrays: Arrays, fields: _ListFields) -> dict[str, Any]:
    rays = decode_rays(arrays)
    offsets = check_integers("offsets", arrays["offsets"], 0, 2**53, np.int64)
    if offsets.shape != (rays.origins.size // 3 + 1,) or offsets[0] != 0 or (np.diff(offsets) < 0).any():
        raise ValueError(f"offsets must rise from 0, one for each ray and one more, got shape {offsets.shape}")
    check_array_shapes(
        arrays, (int(offsets[-1]),), {**fields.floats, **dict.fromkeys((*fields.ints, *fields.flags), ())}
    )
    return {
        **{name: arrays[name] for name in fields.floats},
        **{
            # Only before and after may be -1, for no body.
            name: check_integers(name, arrays[name], -(name in _SIDE_NAMES), 2**31 - 1, np.int32)
            for name in fields.ints
        },
        **{name: check_integers(name, arrays[name], 0, 1, np.bool_) for name in fields.flags},
        "offsets": offsets,
        "_rays": rays,
        "_home": decode_text("home", arrays),
    }


def _decode_scene_fields(arrays: Arrays, path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the fields that only spans have: surfaces at both ends, the number of bodies, and all materials."""
    check_array_shapes(arrays, (2, len(arrays["t_enter"])), {"ends": ()})
    check_array_shapes(arrays, (), {"body_count": ()})
    count = int(check_integers("body_count", arrays["body_count"], 0, 2**31 - 1, np.int64))
    if (arrays["body"] >= count).any():
        raise ValueError(f"body must be below body_count, {count}")
    entries = decode_bodies("materials", arrays, path)
    return {
        "_ends": check_integers("ends", arrays["ends"], -(2**31), 2**31 - 1, np.int32),
        "_body_count": count,
        "_distinct": tuple((entry.material, not entry.shape.is_sheet) for entry in entries),
    }


# Results that are written piece by piece and can be resumed.
#
# Until `hits.csv` is complete, the folder `hits.csv.parts` holds a file for each column, and `state.json` with the
# number of rays that are done and the number of valid bytes of each file. Bytes beyond belong to a piece that was not
# finished; they are cut off on resuming. `state.json` is replaced after the columns are written, so it never counts
# more than they hold.


class ResultParts:
    """The parts of the results at `output`. `key` identifies the work: rays, scene and version.

    Raise ValueError if the folder of parts exists and `resume` is false, or if it belongs to other work.
    """

    def __init__(self, output: Path, key: str, resume: bool) -> None:
        self.output, self.key = output, key
        self.folder = output.with_name(output.name + ".parts")
        self.rays = self.found = 0
        self.sizes: dict[str, int] = {}
        self.kinds: dict[str, Any] = {}
        if self.folder.exists():
            if not resume:
                raise ValueError(f"{self.folder}: is left of an earlier run; --resume goes on with it, or remove it")
            self._read()
        else:
            self.folder.mkdir()

    def _read(self) -> None:
        state = self.folder / "state.json"
        if not state.exists():  # the earlier run stopped before its first part
            return
        saved = json.loads(state.read_text(encoding="utf-8"))
        if saved["key"] != self.key:
            raise ValueError(f"{self.folder}: holds results of other rays, another scene or version; remove it")
        self.rays, self.found = saved["rays"], saved["found"]
        self.sizes, self.kinds = saved["sizes"], saved["kinds"]
        for name, size in self.sizes.items():
            os.truncate(self.folder / name, size)

    def add(self, columns: Mapping[str, bytes | np.ndarray[Any, Any]], rays: int, found: int) -> None:
        """Append the columns of `rays` more rays with `found` results: bytes of a text, or rows of arrays."""
        for name, rows in columns.items():
            if not isinstance(rows, bytes):
                self.kinds[name] = [np.lib.format.dtype_to_descr(rows.dtype), list(rows.shape[1:])]
            data = rows if isinstance(rows, bytes) else np.ascontiguousarray(rows).tobytes()
            path = self.folder / name
            try:
                with open(path, "ab") as file:
                    file.write(data)
            except OSError as error:
                raise OSError(error.errno, error.strerror, os.fspath(path)) from None
            self.sizes[name] = self.sizes.get(name, 0) + len(data)
        self.rays, self.found = self.rays + rays, self.found + found
        state = dict(key=self.key, rays=self.rays, found=self.found, sizes=self.sizes, kinds=self.kinds)
        write_text(self.folder / "state.json", json.dumps(state))

    def column(self, name: str) -> np.ndarray[Any, Any]:
        """Return a column of numbers, memory-mapped."""
        kind, last = np.dtype(self.kinds[name][0]), tuple(self.kinds[name][1])
        if not self.sizes[name]:
            return np.zeros((0, *last), kind)
        return np.memmap(self.folder / name, kind, "r").reshape(-1, *last)

    def finish_text(self, name: str) -> None:
        """Move the text of one column to the output, and remove the parts."""
        with replace_file(self.output) as partial:
            os.replace(self.folder / name, partial)
        shutil.rmtree(self.folder)

    def stored(self, name: str, shape: tuple[int, ...]) -> StoredArray:
        """Return a column as an array whose rows have the leading shape `shape`."""
        column = self.column(name)
        return StoredArray((column,), (*shape, *column.shape[1:]))

    def finish_arrays(self, arrays: Mapping[str, StoredArray], more: Mapping[str, Any]) -> None:
        """Write stored arrays and `more` in memory to the output, a .npz file or a .zarr folder; remove the parts."""
        if self.output.suffix.lower() == ".zarr":
            write_zarr(self.output, arrays, more)
        else:
            write_npz(self.output, arrays, more)
        shutil.rmtree(self.folder)

    def finish_array(self, array: StoredArray) -> None:
        """Write one stored array to the output, a .npy file, and remove the parts."""
        write_npy(self.output, array)
        shutil.rmtree(self.folder)

    def finish_table(self) -> None:
        """Write all columns to the output, a .parquet file, and remove the parts."""
        write_parquet(self.output, {name: self.column(name) for name in self.kinds})
        shutil.rmtree(self.folder)
