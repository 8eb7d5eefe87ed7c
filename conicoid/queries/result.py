"""Base classes of query results: `NoArray`, which keeps NumPy from treating a result as numbers, and `QueryResult`.

A result has arrays as fields and is no array itself. `ObjectArray` holds names and materials of bodies. The functions
at the end format one-ray results and join results for `concatenate`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self, TypeVar

import numpy as np

from .._util.foreign_names import HintingType
from .._util.hints import describe_names, with_method_hints
from .._util.pickling import restore_state
from .._util.text import format_count
from .._util.user_warnings import warn
from .._util.validation import describe_kind, format_value
from ..geometry.labels import Labels
from .id_arrays import number_fields

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene


_NUMPY_SAVERS = (np.save, np.savez, np.savez_compressed)
"""NumPy functions that accept a result, since they only store it."""


class NoArray(metaclass=HintingType):
    """An object whose fields are arrays. NumPy functions and operators raise a TypeError that names fields to use."""

    __slots__ = ()
    instead: ClassVar[str]
    """The fields that messages recommend."""

    def _refusal(self, what: str = "") -> TypeError:
        kind = type(self).__name__
        return TypeError(f"{what}{kind} is no array of numbers: its fields are, such as {type(self).instead}")

    def __array__(self, dtype: Any = None, copy: Any = None) -> NoReturn:
        raise self._refusal()

    def __array_ufunc__(self, function: Any, *_: Any, **__: Any) -> NoReturn:
        raise self._refusal(f"{function.__name__}: ")

    def __array_function__(self, function: Any, types: Any, args: Any, keywords: Any) -> Any:
        if function not in _NUMPY_SAVERS:
            raise self._refusal(f"{function.__name__}: ")
        boxed = {name: _box_result(value) for name, value in keywords.items()}
        return function(*map(_box_result, args), **boxed)

    if not TYPE_CHECKING:  # a type checker that saw __setitem__ would accept assignments to items

        def __setitem__(self, index: Any, value: Any) -> NoReturn:
            raise self._read_only()

        def __delitem__(self, index: Any) -> NoReturn:
            raise self._read_only()

    def _read_only(self) -> TypeError:
        first = type(self).instead.partition(",")[0].partition(" ")[0]
        return TypeError(f"{type(self).__name__} are read-only: a field as a copy is not, such as {first}.copy()")


_BINARY = {"add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**"}
_OPERATORS = {
    **{f"__{side}{name}__": sign for name, sign in _BINARY.items() for side in ("", "r")},
    "__neg__": "-", "__abs__": "abs", "__float__": "float", "__int__": "int",
    "__lt__": "<", "__le__": "<=", "__gt__": ">", "__ge__": ">=",
}  # fmt: skip
"""Special methods of numbers, and the operator that each implements."""


def _refusing_operator(sign: str) -> Any:
    def refuse(self: NoArray, *others: Any) -> NoReturn:
        raise self._refusal(f"{sign}: ")

    return refuse


for _method, _sign in _OPERATORS.items():
    setattr(NoArray, _method, _refusing_operator(_sign))


def box_object(thing: Any, dtype: Any = None) -> Any:
    """Return an array of shape () that holds `thing` itself, so that NumPy can store it in a file.

    Without the box NumPy would unpack a sequence into its parts. Raise TypeError for a `dtype` other than object.
    """
    if dtype is not None and np.dtype(dtype) != np.dtype(object):
        raise TypeError(f"{type(thing).__name__} is no array of numbers")
    box = np.empty((), object)
    box[()] = thing
    return box


def _box_result(value: Any) -> Any:
    """Return a result in a box, and anything else unchanged."""
    return box_object(value) if isinstance(value, NoArray) else value


# Names and materials of results: arrays of objects that `np.unique` accepts.
#
# NumPy sorts in `unique`, and neither None (the name of a miss) nor a material has an order. Here names sort as texts,
# None comes last, and materials keep the order of their first appearance. Arrays computed from these are plain.

_UNIQUE_FUNCTIONS = ("unique", "unique_values", "unique_counts", "unique_inverse", "unique_all")


_ORDER_FUNCTIONS = ("sort", "argsort", "lexsort", "min", "max", "amin", "amax", "searchsorted")
_MOST_NAMES = 100_000  # above this a scene's names are not searched, since each comparison would take too long


class ObjectArray(np.ndarray[Any, Any]):
    """An array of names or materials, many of them equal.

    Comparing an array of names with a name that no body of the scene has gives False throughout, and warns.
    """

    labels: Labels | None = None
    """Names and materials of the whole scene; None where they are unknown."""

    def __eq__(self, other: object) -> Any:
        found = super().__eq__(other)
        if isinstance(other, str) and self.labels is not None:
            self._warn_unknown(other, self.labels)
        return found

    def __ne__(self, other: object) -> Any:
        found = super().__ne__(other)
        if isinstance(other, str) and self.labels is not None:
            self._warn_unknown(other, self.labels)
        return found

    __hash__ = None

    def _warn_unknown(self, name: str, labels: Labels) -> None:
        """Warn if no body of the scene has this name."""
        # A subclass of Labels makes names on demand, so testing for one there would make all of them
        if type(labels) is Labels and len(labels.names) <= _MOST_NAMES and name not in labels.names:
            known = [one for one in labels.names if one is not None]
            warn(
                f"no body is called {format_value(name)}, which so equals none of "
                f"these; {describe_names(name, 'names', known)}"
            )

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        del context
        return array[()] if return_scalar or array.ndim == 0 else np.asarray(array)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function.__name__ in _UNIQUE_FUNCTIONS and args and args[0] is self and self.dtype == object:
            return _unique(function, np.asarray(self), args[1:], kwargs)
        if function.__name__ in _ORDER_FUNCTIONS and self.dtype == object and any(value is None for value in self.flat):
            raise TypeError(
                f"{function.__name__}: a miss has no name and no material, and None has no order: "
                f"np.unique(...) has the different ones, and hits[hits.hit] no misses"
            )
        return super().__array_function__(function, types, args, kwargs)

    def __reduce_ex__(self, protocol: Any) -> Any:
        return np.asarray(self).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(np.asarray(self))


def object_array(values: Any, labels: Labels | None = None) -> Any:
    """Return `values` as a read-only `ObjectArray`; a single value is returned unchanged.

    labels: of names, the labels of the whole scene.
    """
    if not isinstance(values, np.ndarray):
        return values
    values.flags.writeable = False
    array = values.view(ObjectArray)
    array.labels = labels
    return array


def _unique(function: Any, values: Any, args: Any, kwargs: Any) -> Any:
    """Apply one of NumPy's `unique` functions to objects: to the place of each among the distinct ones, in order."""
    by_identity = {id(value): value for value in values.ravel().tolist()}  # faster than comparing materials
    different = list(dict.fromkeys(by_identity.values()))
    texts = sorted(value for value in different if isinstance(value, str))
    others = [value for value in different if value is not None and not isinstance(value, str)]
    ordered = [*texts, *others, *([None] if None in by_identity.values() else [])]
    places = {value: place for place, value in enumerate(ordered)}
    place_of = {one: places[value] for one, value in by_identity.items()}
    codes = np.array([place_of[id(value)] for value in values.ravel().tolist()], np.int64).reshape(values.shape)
    table = np.empty(len(ordered), object)
    table[:] = ordered
    found = function(codes, *args, **kwargs)
    if isinstance(found, np.ndarray):
        return table[found]
    parts = [table[found[0]], *found[1:]]
    return type(found)(*parts) if hasattr(found, "_fields") else tuple(parts)


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


@with_method_hints
class QueryResult(NoArray):
    """The base class of hits, spans, crossings and distances: read-only, and equal if all fields are equal.

    A pickled or `detached` result keeps all fields and drops the scene.
    """

    __hash__ = None  # type: ignore[assignment]
    _scene: PreparedScene
    _views: ClassVar[tuple[str, ...]] = ()
    """Fields that another attribute holds in another form; pickles leave them out."""

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
        return object_array(self._labels.names_of(self._numbers), None if self._scene is NO_SCENE else self._labels)

    @property
    def material(self) -> Any:
        """The material of each body, an object array of the shape of `body`, as `scene.body(number).material`.

        It is None for a miss and for a body with the default material. The paint of single faces is not included.
        """
        return object_array(self._labels.materials_of(self._numbers))

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
        return {**state, "_home": self._home, "_labels": self._labels.of_only(self._numbers)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)
        vars(self).update(number_fields(vars(self)), _scene=NO_SCENE)

    def __copy__(self) -> Self:
        result = object.__new__(type(self))
        vars(result).update(vars(self))
        return result

    def __deepcopy__(self, memo: Any) -> Self:
        del memo  # all parts are read-only, so copies may share them
        return self.__copy__()


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
    """Return `parts` as a list. Raise TypeError if it is no list of results of class `kind`."""
    name = kind.__name__
    if isinstance(parts, kind) or not isinstance(parts, Iterable):
        raise TypeError(f"{name}: parts must be a list of {name}, got {describe_kind(parts)}")
    results = list(parts)
    for i, part in enumerate(results):
        if not isinstance(part, kind):
            raise TypeError(f"{name}: parts[{i}] must be {name}, got {describe_kind(part)}")
    return results


def common_scene_state(parts: Sequence[Any], name: str) -> dict[str, Any]:
    """Return the attributes of detached results that describe their scene. Raise ValueError for different scenes."""
    for i, part in enumerate(parts):
        if part._home != parts[0]._home or getattr(part, "_distinct", ()) != getattr(parts[0], "_distinct", ()):
            raise ValueError(f"{name}: parts must be of one scene, got parts[0] and parts[{i}] of different ones")
    return {"_labels": merge_labels([part._labels for part in parts], name)}


def merge_labels(labels: Sequence[Labels], owner: str) -> Labels:
    """Return the union of labels. Raise ValueError if two of them disagree about a body."""
    known: dict[int, tuple[Any, ...]] = {}
    for one in labels:
        for first, *label in zip(one.firsts.tolist(), one.names, one.materials, one.solid, strict=True):
            if known.setdefault(first, tuple(label)) != tuple(label):
                raise ValueError(f"{owner}: parts must be of one scene, got two names or materials of body {first}")
    firsts = sorted(known)
    names, materials, solid = ([known[first][k] for first in firsts] for k in range(3))
    return Labels(np.array(firsts, np.int64), tuple(names), tuple(materials), tuple(solid))
