"""`ArrayRecord`, an object of array fields that NumPy does not take for an array, and `QueryResult`, its main subclass.

Functions format one-ray results, join results for `concatenate`, and resolve names of higher layers.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self, TypeVar

import numpy as np

from .._util.records import restore_state
from .._util.text import format_count, unknown_attribute
from .._util.validation import describe_kind, format_value
from ..geometry.labels import Labels

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene


class ArrayRecord:
    """An object whose fields are arrays, and which is no array itself.

    NumPy would take it for a sequence of Python objects, one for each ray.
    """

    __slots__ = ()
    __array_ufunc__ = None
    """Operators and universal functions raise TypeError."""

    def __array__(self, dtype: Any = None, copy: Any = None) -> NoReturn:
        raise TypeError(f"{type(self).__name__} is no array of numbers; its fields are arrays")

    if not TYPE_CHECKING:  # type checkers would otherwise accept any attribute

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(self, name)


class ShapedRecord(ArrayRecord):
    """A record with an item for each ray or point, in their leading shape; () for a single one."""

    __slots__ = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape."""
        raise NotImplementedError

    @property
    def ndim(self) -> int:
        """Number of axes of `shape`; 0 for a single ray or point."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of rays or points."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError(f"{type(self).__name__}: that of a single ray or point has no length")
        return self.shape[0]

    def _shaped(self, array: Any, *last: int) -> Any:
        """Return a flat array in the leading shape, with more axes `last`, read-only; a single item gives a scalar."""
        result = array.reshape((*self.shape, *last))
        result.flags.writeable = False
        return result if last else result[()]


# The base class of results: names and materials of their bodies, comparison, pickles, and results without a scene.


class NoScene:
    """The stand-in for the scene of a detached result: every attribute raises ValueError."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise ValueError("this result was detached from its scene, or pickled, and can compute no further fields")


NO_SCENE: Any = NoScene()


_SCENE_FIELDS = "_scene", "_met", "_moving"
"""Attributes that pickles and `detached` leave out: the scene, and data of its walls that derivatives have cached."""


class QueryResult(ArrayRecord):
    """The base class of hits, spans, crossings and distances: read-only, and equal if all fields are equal.

    A pickled or `detached` result keeps all fields and drops the scene.
    """

    __hash__ = None  # type: ignore[assignment]
    _scene: PreparedScene
    _views: ClassVar[tuple[str, ...]] = ()
    """Fields that another attribute holds in another form; pickles leave them out."""

    def __iter__(self) -> Iterator[Self]:
        for i in range(len(self)):  # type: ignore[arg-type]
            yield self[i]  # type: ignore[index]

    @cached_property
    def _home(self) -> bytes:
        """The key of the scene that surface numbers refer to (`PreparedScene.key`)."""
        return self._scene.key

    @cached_property
    def _labels(self) -> Labels:
        """Names and materials of the scene's bodies."""
        return self._scene.labels

    @property
    def _numbers(self) -> Any:
        """The body numbers for `name` and `material`."""
        return self.body  # type: ignore[attr-defined]

    @property
    def name(self) -> Any:
        """The name of each body, an object array of the shape of `body`; None for a nameless body and for a miss."""
        return _read_only(self._labels.names_of(self._numbers))

    @property
    def material(self) -> Any:
        """The material of each body, an object array of the shape of `body`, as `scene.body(number).material`.

        It is None for a miss and for a body with the default material. The paint of single faces is not included.
        """
        return _read_only(self._labels.materials_of(self._numbers))

    def detached(self) -> Self:
        """Return a copy that does not keep the scene in memory: it computes all fields first.

        Pickles do the same. Rays spawned from a copy still start on their surface, in any scene with the same surfaces.
        """
        result = object.__new__(type(self))
        result.__setstate__(self.__getstate__())
        return result

    if not TYPE_CHECKING:  # a type checker that saw __setattr__ would accept any attribute

        def __setattr__(self, name: str, value: Any) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be set")

        def __delattr__(self, name: str) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        """Return True if all fields are equal, with NaN equal to NaN; never an array."""
        if type(other) is not type(self):
            return NotImplemented
        fields = (*self._fields(), *(["_rays"] if "_rays" in vars(self) else []))
        return all(_fields_equal(getattr(self, field), getattr(other, field)) for field in fields)

    def _fields(self) -> list[str]:
        """Return the names of the public attributes and properties."""
        kind = type(self)
        properties = (f for f in dir(kind) if isinstance(getattr(kind, f), (property, cached_property)))
        return [field for field in {**dict.fromkeys(properties), **vars(self)} if not field.startswith("_")]

    def __getstate__(self) -> dict[str, Any]:
        for field in self._fields():
            getattr(self, field)  # computes and caches the field, which needs the scene
        state = {name: value for name, value in vars(self).items() if name not in (*_SCENE_FIELDS, *self._views)}
        return {**state, "_home": self._home, "_labels": self._labels.select(self._numbers)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)
        vars(self).update(_scene=NO_SCENE)

    def __copy__(self) -> Self:
        result = object.__new__(type(self))
        vars(result).update(vars(self))
        return result

    def __deepcopy__(self, memo: Any) -> Self:
        del memo  # all parts are read-only, so copies may share them
        return self.__copy__()


def _read_only(values: Any) -> Any:
    """Return an array that cannot be written, or a single value."""
    if isinstance(values, np.ndarray):
        values.flags.writeable = False
    return values


def _fields_equal(one: Any, other: Any) -> bool:
    """Return True if two fields are equal, with NaN equal to NaN."""
    if isinstance(one, np.ndarray | np.generic):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return bool(one == other)


# Texts of results of a single ray, with full precision.

_MOST_ROWS_SHOWN = 4


def format_rows(count: int, noun: str, rows: Iterable[str]) -> str:
    """Return the number of rows and the first few of them, as "2 spans: ..., ..."."""
    first = [row for row, _ in zip(rows, range(_MOST_ROWS_SHOWN), strict=False)]
    more = ", ..." if count > _MOST_ROWS_SHOWN else ""
    return format_count(count, noun, f"{noun}s") + (f": {', '.join(first)}{more}" if first else "")


def format_body(number: Any, name: Any) -> str:
    """Return the number of a body, and its name if it has one."""
    return f"{int(number)}" + (f" {format_value(name)}" if name else "")


def format_field(value: Any) -> str:
    """Return the repr of a field in plain Python types, arrays as tuples."""
    plain = value.tolist() if hasattr(value, "tolist") else value
    return repr(tuple(plain) if isinstance(plain, list) else plain)


# Results of several queries joined into one, for the `concatenate` methods.

ResultType = TypeVar("ResultType")


def check_parts(kind: type[ResultType], parts: Any) -> list[ResultType]:
    """Return `parts` as a list. Raise TypeError for others than results of class `kind`, ValueError for none."""
    name = kind.__name__
    if isinstance(parts, kind) or not isinstance(parts, Iterable):
        raise TypeError(f"{name}: parts must be a list of {name}, got {describe_kind(parts)}")
    results = list(parts)
    for i, part in enumerate(results):
        if not isinstance(part, kind):
            raise TypeError(f"{name}: parts[{i}] must be {name}, got {describe_kind(part)}")
    if not results:
        raise ValueError(f"{name}: parts must hold at least one {name}, got none")
    return results


def common_scene_state(parts: Sequence[Any], name: str) -> dict[str, Any]:
    """Return the attributes of detached results that describe their scene. Raise ValueError for different scenes."""
    for i, part in enumerate(parts):
        if part._home != parts[0]._home or getattr(part, "_distinct", ()) != getattr(parts[0], "_distinct", ()):
            raise ValueError(f"{name}: parts must be of one scene, got parts[0] and parts[{i}] of different ones")
    return {"_labels": merge_labels([part._labels for part in parts], name)}


def merge_labels(labels: Sequence[Labels], owner: str) -> Labels:
    """Return the union of labels. Raise ValueError if two of them disagree about a body."""
    label_of: dict[int, tuple[Any, ...]] = {}
    for one in labels:
        for first, *label in zip(one.firsts.tolist(), one.names, one.materials, one.solid, strict=True):
            if label_of.setdefault(first, tuple(label)) != tuple(label):
                raise ValueError(f"{owner}: parts must be of one scene, got two names or materials of body {first}")
    firsts = sorted(label_of)
    names, materials, solid = ([label_of[first][k] for first in firsts] for k in range(3))
    return Labels(np.array(firsts, np.int64), tuple(names), tuple(materials), tuple(solid))


# Names that results and applications resolve at call time, because the code behind them belongs to a higher layer.
#
# Hits, spans and rays save, load and differentiate themselves; `measure(shape)` and others take a shape and need a
# scene of it; `scene.view()` opens the viewer. The files and the derivatives lie above `queries`, the class `Scene`
# lies above all applications, and the viewer above `Scene`. So the lower module asks this registry by name instead of
# importing upwards, and `import conicoid` stays free of whatever a program does not call.
# `tests/queries/test_extensions.py` resolves every entry.

EXTENSIONS = {
    "Scene": "conicoid.scene.scene:Scene",
    "as_scene": "conicoid.scene.scene:as_scene",
    "view": "conicoid.viewer.widget:view",
    "rays.write": "conicoid.io.result_file:write_rays_file",
    "rays.read": "conicoid.io.result_file:read_rays_file",
    "hits.write": "conicoid.io.result_file:write_hits_file",
    "hits.read": "conicoid.io.result_file:read_hits_file",
    "lists.write": "conicoid.io.result_file:write_lists_file",
    "lists.read": "conicoid.io.result_file:read_lists_file",
    "hits.jvp": "conicoid.apps.derivatives.autodiff:hits_jvp",
    "hits.vjp": "conicoid.apps.derivatives.autodiff:hits_vjp",
    "hits.curvature": "conicoid.apps.derivatives.quadric_form:curvature",
    "spans.jvp": "conicoid.apps.derivatives.autodiff:spans_jvp",
    "spans.vjp": "conicoid.apps.derivatives.autodiff:spans_vjp",
}
"""Name -> "module:attribute". `lists` are spans and crossings."""


def extension(name: str) -> Any:
    """Import and return the function or class of an entry of `EXTENSIONS`."""
    module, _, attribute = EXTENSIONS[name].partition(":")
    return getattr(importlib.import_module(module), attribute)
