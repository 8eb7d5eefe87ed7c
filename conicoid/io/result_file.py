"""Files of rays, hits, spans and crossings, from which the objects are read back; and columns of tables of results.

The .npz files hold every field, the rays, and the names and materials of bodies, but neither a scene nor a pickle.
`docs/reference/files.md` describes the columns.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .._util.files import SceneFileError, open_regular, printable
from .._util.records import dataclass
from .._util.validation import format_list, format_value
from ..geometry.body import Body
from ..geometry.labels import Labels
from ..geometry.primitives import Sphere
from ..geometry.sheets import Disc
from ..kernels.first_hits import HitBuffers
from ..kernels.ray import DEAD
from ..materials.material import Material
from ..queries.hits import Hits
from ..queries.rays import Rays
from ..queries.scene_protocol import SceneLike
from ..queries.spans import RayLists
from .array_file import SOURCE_SUFFIXES, as_integers, quote_csv, write_arrays, write_columns
from .npz import NpzArchive
from .ray_file import RayFile
from .scene_file.scene_file import SceneParts, parse_scene, scene_data
from .scene_file.writer import dump_json

# Parts that all these files share: rays, and labels (names and materials of bodies).

RAY_FIELDS = ("origins", "directions", "starts", "starts_home")
LABEL_FIELDS = ("first_bodies", "labels")
"""`labels` holds the bytes of a scene file, in which a ball stands for any solid and a disc for any sheet."""
Arrays = dict[str, Any]


def read_arrays(
    path: str | os.PathLike[str], names: Collection[str], needed: Collection[str], what: str,
    flags: Collection[str] = (),
) -> Arrays:  # fmt: skip
    """Read the `names` arrays of a .npz file; those in `needed` must exist, those in `flags` may be booleans.

    `what` is the method that writes such files. Raise ValueError if the file lacks an array or holds others.
    """
    with open_regular(path) as file:
        archive = NpzArchive(file)
        missing = [name for name in needed if name not in archive.members]
        if missing:
            there = [printable(name) for name in archive.members]
            lacks = f"it lacks {', '.join(missing[:5])} and holds {format_list(there, 5)}"
            raise ValueError(f"is not a file of {what}: {lacks}")
        others = [printable(name) for name in archive.members if name not in names]
        if others:
            raise ValueError(f"is not a file of {what}: it also holds {format_list(others, 5)}")
        return dict(archive.arrays(names, flags))


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
    """Read rays from a file of any format, from a .npz file with the surfaces that they start on.

    Raise ValueError, with the name of the file, or OSError.
    """
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in SOURCE_SUFFIXES:
        suffixes = f"{', '.join(SOURCE_SUFFIXES[:-1])} or {SOURCE_SUFFIXES[-1]}"
        raise ValueError(f"load: path of rays must end with {suffixes}, got {format_value(os.fspath(path))}")
    if suffix != ".npz":
        file = RayFile(path, whole=True)
        if file.limits:
            raise ValueError(f"{file.path}: holds {' and '.join(file.limits)}, and rays have no intervals")
        return file.read().rays
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
    starts = as_integers("starts", arrays["starts"], -(2**31), 2**31 - 1, np.int32)
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
    firsts = as_integers("first_bodies", arrays["first_bodies"], 0, 2**53, np.int64)
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


def encode_bytes(content: bytes) -> npt.NDArray[np.uint8]:
    """Return bytes as an array of uint8."""
    return np.frombuffer(content, np.uint8)


def decode_text(name: str, arrays: Arrays) -> bytes:
    """Return the bytes that `encode_bytes` stored. Raise ValueError for numbers that are not bytes."""
    return as_integers(name, arrays[name], 0, 255, np.uint8).tobytes()


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
        name: as_integers(name, arrays[name], -1 if name != "side" else -2, 2**31 - 1, np.int32) for name in _HIT_INTS
    }
    flags = {name: as_integers(name, arrays[name], 0, 1, np.bool_).ravel() for name in _HIT_FLAGS}
    nothing = np.zeros(arrays["t"].size, np.int32)
    turn = np.where(flags["entering"], 2, 1).astype(np.int8)
    state = {
        "rays": decode_rays(arrays),
        "_buffers": HitBuffers(arrays["t"].ravel(), ints["body"].ravel(), nothing, nothing, turn),
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
    return result


def _decode_list_rows(arrays: Arrays, fields: _ListFields) -> dict[str, Any]:
    rays = decode_rays(arrays)
    offsets = as_integers("offsets", arrays["offsets"], 0, 2**53, np.int64)
    if offsets.shape != (rays.origins.size // 3 + 1,) or offsets[0] != 0 or (np.diff(offsets) < 0).any():
        raise ValueError(f"offsets must rise from 0, one for each ray and one more, got shape {offsets.shape}")
    check_array_shapes(
        arrays, (int(offsets[-1]),), {**fields.floats, **dict.fromkeys((*fields.ints, *fields.flags), ())}
    )
    return {
        **{name: arrays[name] for name in fields.floats},
        **{
            # Only before and after may be -1, for no body.
            name: as_integers(name, arrays[name], -(name in _SIDE_NAMES), 2**31 - 1, np.int32)
            for name in fields.ints
        },
        **{name: as_integers(name, arrays[name], 0, 1, np.bool_) for name in fields.flags},
        "offsets": offsets,
        "_rays": rays,
        "_home": decode_text("home", arrays),
    }


def _decode_scene_fields(arrays: Arrays, path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the fields that only spans have: surfaces at both ends, the number of bodies, and all materials."""
    check_array_shapes(arrays, (2, len(arrays["t_enter"])), {"ends": ()})
    check_array_shapes(arrays, (), {"body_count": ()})
    count = int(as_integers("body_count", arrays["body_count"], 0, 2**31 - 1, np.int64))
    if (arrays["body"] >= count).any():
        raise ValueError(f"body must be below body_count, {count}")
    entries = decode_bodies("materials", arrays, path)
    return {
        "_ends": as_integers("ends", arrays["ends"], -(2**31), 2**31 - 1, np.int32),
        "_body_count": count,
        "_distinct": tuple((entry.material, not entry.shape.is_sheet) for entry in entries),
    }


# Tables of results: columns of one length.

_TABLES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "first_hit": (("t", "point", "normal", "uv", "body", "face", "surface", "entering"), ("t_error",)),
    "spans": (("body", "t_enter", "t_exit", "enter_clipped", "exit_clipped"), ("t_enter_error", "t_exit_error")),
    "crossings": (
        ("t", "point", "normal", "body", "face", "surface", "entering", "before", "after"), ("t_error",),
    ),
}  # fmt: skip
"""The fields of hits, spans and crossings in tables, and their error bounds."""
_VECTOR_COLUMNS = {"point": ("x", "y", "z"), "normal": ("normal_x", "normal_y", "normal_z"), "uv": ("u", "v")}


def table_columns(query: str, answer: Any, errors: bool, first: int = 0) -> dict[str, Any]:
    """Return the columns of a table of hits, spans or crossings, flat; `first` is the number of the first ray."""
    fields, bounds = _TABLES[query]
    columns = {}
    if query != "first_hit":
        # Row i of the lists belongs to the ray whose offsets enclose i
        counts = np.diff(answer.offsets)
        columns["ray"] = np.repeat(np.arange(first, first + len(counts)), counts)
    for name in (*fields, *(bounds if errors else ())):
        values = np.asarray(getattr(answer, name))
        parts = _VECTOR_COLUMNS.get(name, (name,))
        columns |= dict(zip(parts, values.reshape(-1, len(parts)).T, strict=True))
    return columns


def write_values(
    path: str | os.PathLike[str], name: str, values: Any, columns: Sequence[str], *, with_names: bool
) -> None:
    """Write numbers for each ray, (...) or (..., columns), to .npz (an array `name`) or .csv (a line for each ray).

    `with_names`: a .npz file also gets an array of texts, `columns`.
    """
    rows = np.asarray(values).reshape(-1, max(1, len(columns)))
    if Path(path).suffix.lower() == ".csv":
        write_columns(path, {quote_csv(column): rows[:, k] for k, column in enumerate(columns)})
    else:
        write_arrays(path, {name: values} | ({"columns": np.array(columns, dtype=np.str_)} if with_names else {}))


# Names of the columns of lengths and line integrals.


def length_columns(scene: SceneLike, by: str) -> list[str]:
    """Return a column name for each body or material of a scene: its name, or its number.

    `by` is "body" or "material". A name that occurs twice, or looks like a number's column, gets the number too.
    """
    if by == "body":
        names = [body.name for body in scene[:]]
    else:
        names = ["no material" if material is None else material.name for material in scene.materials]
    counts = Counter(names)
    return [
        f"{by} {number}" if not name
        else f"{by} {number} ({name})" if counts[name] > 1 or name.startswith(f"{by} ") else name
        for number, name in enumerate(names)
    ]  # fmt: skip


def integral_columns(energies: tuple[int, ...]) -> list[str]:
    """Return one column name, or one for each energy.

    `energies` is the part of an array's shape after the shape of the rays: () or (number of energies,).
    """
    return [f"line_integral_{k}" for k in range(energies[0])] if energies else ["line_integral"]
