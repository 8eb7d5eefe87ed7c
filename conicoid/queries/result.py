"""Answers and rays are no arrays of numbers: NumPy's functions are told so, but for those that keep things in files."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self, TypeVar

import numpy as np

from .._util.foreign_names import HintingType
from .._util.hints import describe_names, with_method_hints
from .._util.pickling import restore_state
from .._util.user_warnings import warn
from .._util.validation import describe_kind, format_value
from ..geometry.labels import Labels, format_count
from .id_arrays import number_fields

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene
    from .hits import Hits
    from .spans import Crossings, Spans


_NUMPY_SAVERS = (np.save, np.savez, np.savez_compressed)


class NoArray(metaclass=HintingType):
    """What has arrays as its fields. Each message that refuses the whole names them (`instead`)."""

    __slots__ = ()
    instead: ClassVar[str]

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
        kept = {name: _box_result(value) for name, value in keywords.items()}
        return function(*map(_box_result, args), **kept)

    if not TYPE_CHECKING:  # else checkers would let items be set

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
"""Operators that numbers have, and how they are written."""


def _refusing_operator(sign: str) -> Any:
    def refuse(self: NoArray, *others: Any) -> NoReturn:
        raise self._refusal(f"{sign}: ")

    return refuse


for _method, _sign in _OPERATORS.items():
    setattr(NoArray, _method, _refusing_operator(_sign))


def box_object(thing: Any, dtype: Any = None) -> Any:
    """An object as an array () of itself, which is how NumPy's files can keep it; never one of its parts."""
    if dtype is not None and np.dtype(dtype) != np.dtype(object):
        raise TypeError(f"{type(thing).__name__} is no array of numbers")
    box = np.empty((), object)
    box[()] = thing
    return box


def _box_result(value: Any) -> Any:
    return box_object(value) if isinstance(value, NoArray) else value


# Names and materials of answers: arrays of objects, of which `np.unique` can tell the different ones.
#
# NumPy sorts for that, and neither None, the name of a miss, nor a material can be sorted. Here names are, None comes
# last, and materials come in the order in which they first appear. Whatever is computed with them is plain.

_UNIQUE_FUNCTIONS = ("unique", "unique_values", "unique_counts", "unique_inverse", "unique_all")


_ORDER_FUNCTIONS = ("sort", "argsort", "lexsort", "min", "max", "amin", "amax", "searchsorted")
_MOST_NAMES = 100_000


class ObjectArray(np.ndarray[Any, Any]):
    """An array of objects, most of them equal to others in it.

    Names know those of the whole scene: one that there is not equals none, and a warning tells of it.
    """

    labels: Labels | None = None

    def __eq__(self, other: object) -> Any:
        found = super().__eq__(other)
        if isinstance(other, str) and self.labels is not None:
            self._tell_unknown(other, self.labels)
        return found

    def __ne__(self, other: object) -> Any:
        found = super().__ne__(other)
        if isinstance(other, str) and self.labels is not None:
            self._tell_unknown(other, self.labels)
        return found

    __hash__ = None

    def _tell_unknown(self, name: str, labels: Labels) -> None:
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
    """The same, read-only if it is an array: one of which `np.unique` can tell the different ones.

    labels: of names, those of the whole scene.
    """
    if not isinstance(values, np.ndarray):
        return values
    values.flags.writeable = False
    found = values.view(ObjectArray)
    found.labels = labels
    return found


def _unique(function: Any, values: Any, args: Any, kwargs: Any) -> Any:
    """NumPy's function of the places of values among the different ones."""
    by_identity = {id(value): value for value in values.ravel().tolist()}  # comparing materials takes longer
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
    kept = [table[found[0]], *found[1:]]
    return type(found)(*kept) if hasattr(found, "_fields") else tuple(kept)


# What answers of a scene have in common: names and materials of the bodies in them, and a life without the scene.


class NoScene:
    """In place of the scene of an answer that has been taken from it."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise ValueError("this answer was detached from its scene, or pickled, and holds nothing that can tell")


NO_SCENE: Any = NoScene()


_SCENE_FIELDS = "_scene", "_met", "_moving"
"""What an answer keeps only as long as it has its scene: it, and what derivatives have found of its walls."""


@with_method_hints
class QueryResult(NoArray):
    """Hits, spans or crossings: read-only, and equal where all their fields are.

    Pickled or `detached`, they keep all their fields and do not keep the scene.
    """

    __hash__ = None  # type: ignore[assignment]
    _scene: PreparedScene
    _views: ClassVar[tuple[str, ...]] = ()
    """Fields that are other attributes in another form: these are not kept twice."""

    @cached_property
    def _home(self) -> bytes:
        """Which scene's surfaces the numbers belong to (`Prepared.key`)."""
        return self._scene.key

    @cached_property
    def _labels(self) -> Labels:
        """Names and materials of the scene's bodies."""
        return self._scene.labels

    @property
    def _numbers(self) -> Any:
        """The bodies that `name` and `material` are of."""
        return self.body  # type: ignore[attr-defined]

    @property
    def name(self) -> Any:
        """The name of each body, objects of the shape of `body`: a text, or None for a body without and for a miss."""
        return object_array(self._labels.names_of(self._numbers), None if self._scene is NO_SCENE else self._labels)

    @property
    def material(self) -> Any:
        """The material of each body, objects of the shape of `body`: as `scene.body(number).material`, None for a miss.

        None is also that of a body without, which is the default one. The paint of single faces is not included.
        """
        return object_array(self._labels.materials_of(self._numbers))

    def detached(self) -> Self:
        """The same without the scene, which then need not be kept: all fields are worked out, and stay.

        Pickles are like that. Rays spawned from them still know their surface, in any scene with the same surfaces.
        """
        result = object.__new__(type(self))
        result.__setstate__(self.__getstate__())
        return result

    if not TYPE_CHECKING:  # else checkers would let any name be set

        def __setattr__(self, name: str, value: Any) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be set")

        def __delattr__(self, name: str) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        """Whether all fields are equal, NaN counting as equal to NaN; never an array."""
        if type(other) is not type(self):
            return NotImplemented
        fields = (*self._fields(), *(["_rays"] if "_rays" in vars(self) else []))
        return all(_fields_equal(getattr(self, field), getattr(other, field)) for field in fields)

    def _fields(self) -> list[str]:
        """The public attributes and properties."""
        kind = type(self)
        worked_out = (f for f in dir(kind) if isinstance(getattr(kind, f), (property, cached_property)))
        return [field for field in {**dict.fromkeys(worked_out), **vars(self)} if not field.startswith("_")]

    def __getstate__(self) -> dict[str, Any]:
        for field in self._fields():
            getattr(self, field)
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
        del memo  # all of it is read-only
        return self.__copy__()


def _fields_equal(one: Any, other: Any) -> bool:
    """Are two fields equal, NaN counting as equal to NaN?"""
    if isinstance(one, np.ndarray | np.generic):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return bool(one == other)


# What answers to a single ray tell of themselves, in full digits.

_MOST_ROWS_SHOWN = 4


def format_hit(hits: Hits) -> str:
    """The fields of one hit."""
    if not hits.hit:
        return "a miss, t=inf"
    told = {name: format_field(getattr(hits, name)) for name in ("t", "point", "normal", "face", "entering")}
    return f"body {format_body(hits.body, hits.name)}, " + ", ".join(f"{name}={value}" for name, value in told.items())


def format_spans(spans: Spans) -> str:
    """The first spans of one ray."""
    rows = zip(spans.body, spans.name, spans.t_enter, spans.t_exit, strict=True)
    return _format_rows(
        len(spans.body),
        "span",
        (f"body {format_body(b, n)} [{format_field(a)}, {format_field(e)}]" for b, n, a, e in rows),
    )


def format_crossings(crossings: Crossings) -> str:
    """The first crossings of one ray."""
    rows = zip(crossings.body, crossings.name, crossings.t, strict=True)
    return _format_rows(
        len(crossings.body), "crossing", (f"body {format_body(b, n)} t={format_field(t)}" for b, n, t in rows)
    )


def _format_rows(count: int, noun: str, rows: Iterable[str]) -> str:
    first = [row for row, _ in zip(rows, range(_MOST_ROWS_SHOWN), strict=False)]
    more = ", ..." if count > _MOST_ROWS_SHOWN else ""
    return format_count(count, noun, f"{noun}s") + (f": {', '.join(first)}{more}" if first else "")


def format_body(number: Any, name: Any) -> str:
    return f"{int(number)}" + (f" {format_value(name)}" if name else "")


def format_field(value: Any) -> str:
    """Numbers without NumPy's types around them."""
    plain = value.tolist() if hasattr(value, "tolist") else value
    return repr(tuple(plain) if isinstance(plain, list) else plain)


# What is joined by `concatenate`: a list of answers of one kind.

ResultType = TypeVar("ResultType")


def check_parts(kind: type[ResultType], parts: Any) -> list[ResultType]:
    """The parts as a list; TypeError for what is none, or holds something else than answers of a kind."""
    name = kind.__name__
    if isinstance(parts, kind) or not isinstance(parts, Iterable):
        raise TypeError(f"{name}: parts must be a list of {name}, got {describe_kind(parts)}")
    given = list(parts)
    for i, part in enumerate(given):
        if not isinstance(part, kind):
            raise TypeError(f"{name}: parts[{i}] must be {name}, got {describe_kind(part)}")
    return given
