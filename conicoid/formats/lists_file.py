"""Spans and crossings in .npz files: every field, the rays, and what bodies are called and made of."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .answer_file import (
    LABELS,
    RAYS,
    Arrays,
    arrays_of_labels,
    arrays_of_rays,
    bodies_array,
    bodies_in,
    bytes_array,
    check_shapes,
    labels_in,
    naming,
    rays_in,
    read_arrays,
    text_in,
    whole_array,
    write_arrays,
)

if TYPE_CHECKING:
    from ..engine.answers.by_ray import ByRay

Lists = TypeVar("Lists", bound="ByRay")
_VECTOR = (3,)


@dataclass(frozen=True)
class _Fields:
    """The rows of a kind of answer: numbers, with what follows their number, integers, and truth values."""

    floats: dict[str, tuple[int, ...]]
    ints: tuple[str, ...]
    flags: tuple[str, ...]
    materials: bool
    """Whether the scene's materials are known, with the number of its bodies and the surfaces at both ends."""

    @property
    def names(self) -> tuple[str, ...]:
        more = ("ends", "body_count", "materials") if self.materials else ()
        return (*self.floats, *self.ints, *self.flags, "offsets", *more, *RAYS, "home", *LABELS)


_SPANS = _Fields(
    dict.fromkeys(("t_enter", "t_exit", "t_enter_error", "t_exit_error"), ()),
    ("body",), ("enter_clipped", "exit_clipped"), True,
)  # fmt: skip
_CROSSINGS = _Fields(
    {"t": (), "t_error": (), "point": _VECTOR, "normal": _VECTOR},
    ("body", "face", "surface", "before", "after"),
    ("entering",),
    False,
)
_SIDES = ("before", "after")
_OF = {"Spans": _SPANS, "Crossings": _CROSSINGS}


def write_lists_file(path: str | os.PathLike[str], answer: Any) -> None:
    """Write spans or crossings, with or without their scene. The file appears whole or not at all; raises OSError."""
    write_arrays(path, arrays_of_lists(answer.detached()))


def arrays_of_lists(kept: Any) -> Arrays:
    """All that is written of spans or crossings without their scene."""
    fields = _OF[type(kept).__name__]
    arrays: Arrays = {name: getattr(kept, name) for name in (*fields.floats, *fields.ints, "offsets", *fields.flags)}
    if fields.materials:
        arrays["ends"], arrays["body_count"] = kept._ends, np.array(kept._body_count)
        arrays["materials"] = bodies_array((of_solids, material, None) for material, of_solids in kept._distinct)
    return arrays | arrays_of_rays(kept._rays) | {"home": bytes_array(kept._home)} | arrays_of_labels(kept._labels)


def rows_of_lists(answer: Any) -> tuple[str, ...]:
    """The arrays that have a row for each span or crossing, but for `ends`."""
    fields = _OF[type(answer).__name__]
    return (*fields.floats, *fields.ints, *fields.flags)


def read_lists_file(path: str | os.PathLike[str], kind: type[Lists]) -> Lists:
    """Spans or crossings without their scene. Raises ValueError, naming the file, and OSError."""
    fields = _OF[kind.__name__]
    with naming(path):
        arrays = read_arrays(path, fields.names, fields.names, f"{kind.__name__.lower()}.save", fields.flags)
        state = _rows(arrays, fields) | {"_labels": labels_in(arrays, arrays["body"], path)}
        if fields.materials:
            state |= _of_scene(arrays, path)
    result: Any = object.__new__(kind)
    result.__setstate__(state)
    return result  # type: ignore[no-any-return]


def _rows(arrays: Arrays, fields: _Fields) -> dict[str, Any]:
    rays = rays_in(arrays)
    offsets = whole_array("offsets", arrays["offsets"], 0, 2**53, np.int64)
    if offsets.shape != (rays.origins.size // 3 + 1,) or offsets[0] != 0 or (np.diff(offsets) < 0).any():
        raise ValueError(f"offsets must rise from 0, one for each ray and one more, got shape {offsets.shape}")
    check_shapes(arrays, (int(offsets[-1]),), {**fields.floats, **dict.fromkeys((*fields.ints, *fields.flags), ())})
    return {
        **{name: arrays[name] for name in fields.floats},
        **{name: whole_array(name, arrays[name], -(name in _SIDES), 2**31 - 1, np.int32) for name in fields.ints},
        **{name: whole_array(name, arrays[name], 0, 1, np.bool_) for name in fields.flags},
        "offsets": offsets,
        "_rays": rays,
        "_home": text_in("home", arrays),
    }


def _of_scene(arrays: Arrays, path: str | os.PathLike[str]) -> dict[str, Any]:
    """What only spans know: surfaces at their ends, how many bodies there are, and the materials of all of them."""
    check_shapes(arrays, (2, len(arrays["t_enter"])), {"ends": ()})
    check_shapes(arrays, (), {"body_count": ()})
    count = int(whole_array("body_count", arrays["body_count"], 0, 2**31 - 1, np.int64))
    if (arrays["body"] >= count).any():
        raise ValueError(f"body must be below body_count, {count}")
    entries = bodies_in("materials", arrays, path)
    return {
        "_ends": whole_array("ends", arrays["ends"], -(2**31), 2**31 - 1, np.int32),
        "_body_count": count,
        "_distinct": tuple((entry.material, not entry.shape.is_sheet) for entry in entries),
    }
