"""Records: `dataclass`, and values that compare, copy and pickle by their fields."""

from __future__ import annotations

import dataclasses
import inspect
import sys
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, cached_property
from itertools import repeat
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

# `dataclass`, the decorator of the standard library, in a fifth of its time.
#
# The standard's compiles the texts of up to six methods for each class: 0.8 ms on Python 3.11. For the 130 classes that
# a first hit imports, that was a quarter of a process. Here only `__init__` is a text, compiled when a class makes its
# first object, and the other methods are shared. `dataclasses.fields` and `replace` take these classes, and the
# standard's decorator takes subclasses of them.

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True, repr=True):  # noqa: A002 - the standard's name
        """Make a class a dataclass; for `slots` and `order` take the standard's."""
        if cls is None:
            return lambda cls: _decorate(cls, frozen, eq, repr)
        return _decorate(cls, frozen, eq, repr)


class _Factory:
    """The default of an argument whose field has a factory, as the standard's signatures write it."""

    def __repr__(self) -> str:
        return "<factory>"


_FACTORY = _Factory()
_SHARED: dict[tuple[bool, ...], dict[str, Any]] = {}
"""The attributes that all classes of the standard's have in common, by the options."""


def _decorate(cls: type[Any], *options: bool) -> type[Any]:
    """Give a class its fields and methods."""
    own, (frozen, is_compared, is_shown) = dict(vars(cls)), options
    if options not in _SHARED:
        standard = dataclasses.dataclass(frozen=frozen, eq=is_compared, repr=is_shown)
        empty = vars(standard(type("Empty", (), {})))
        # `__replace__` is that of `copy.replace`, from Python 3.13 on
        _SHARED[options] = {name: empty[name] for name in ("__dataclass_params__", "__replace__") if name in empty}
    methods = dict(_SHARED[options])
    _put_fields(cls)
    fields = dataclasses.fields(cls)
    values = _getter([field.name for field in fields if field.compare])
    if "__match_args__" not in own:
        methods["__match_args__"] = tuple(field.name for field in fields if field.init and not field.kw_only)
    if is_compared and own.get("__hash__") is None and ("__hash__" not in own or "__eq__" in own):
        methods["__hash__"] = _hash(values) if frozen else None
    if is_compared and "__eq__" not in own:
        methods["__eq__"] = _equality(values)
    if is_shown and "__repr__" not in own:
        methods["__repr__"] = _represent
    if frozen:
        methods["__setattr__"], methods["__delattr__"] = _refusals(cls)
    if "__init__" not in own:
        methods["__init__"] = _Initializer(cls, fields, frozen)
    for name, method in methods.items():
        setattr(cls, name, method)
    return cls


def _put_fields(cls: type[Any]) -> None:
    """Set `__dataclass_fields__` to the fields of a class and of its bases, and the class's attributes to defaults."""
    annotations = inspect.get_annotations(cls)
    defaults = {name: vars(cls)[name] for name in annotations if name in vars(cls)}
    # The standard's decorator reads the fields, of a class without bases and without methods
    carrier = type(
        cls.__name__, (), dict(__module__=cls.__module__, __annotations__=annotations, __doc__="Fields", **defaults)
    )
    dataclasses.dataclass(init=False, repr=False, eq=False)(carrier)
    fields: dict[str, Any] = {}
    for kind in (*cls.__mro__[:0:-1], carrier):
        fields |= vars(kind).get("__dataclass_fields__", {})
    cls.__dataclass_fields__ = fields
    for name in defaults:
        if name in vars(carrier):
            setattr(cls, name, vars(carrier)[name])
        else:
            delattr(cls, name)


def _getter(names: Sequence[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return a function that returns the attributes of these names as a tuple."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda thing: tuple(getattr(thing, name) for name in names)


def _equality(values: Callable[[Any], tuple[Any, ...]]) -> Callable[[Any, object], Any]:
    """Return `__eq__` of a class."""

    def __eq__(self: Any, other: object) -> Any:
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    return __eq__


def _hash(values: Callable[[Any], tuple[Any, ...]]) -> Callable[[Any], int]:
    """Return `__hash__` of a frozen class."""

    def __hash__(self: Any) -> int:
        return hash(values(self))

    return __hash__


@recursive_repr()
def _represent(self: Any) -> str:
    """Return the name of the class and the fields, as Python writes them."""
    shown = (f"{field.name}={getattr(self, field.name)!r}" for field in dataclasses.fields(self) if field.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _refusals(cls: type[Any]) -> tuple[Callable[..., None], Callable[..., None]]:
    """Return `__setattr__` and `__delattr__` of a frozen class; subclasses without a decorator may add attributes."""

    def __setattr__(self: Any, name: str, value: Any) -> None:
        if type(self) is cls or name in cls.__dataclass_fields__:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: Any, name: str) -> None:
        if type(self) is cls or name in cls.__dataclass_fields__:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    return __setattr__, __delattr__


class _Initializer:
    """`__init__` of a class until somebody looks it up: it is compiled then, and put in the place of this object.

    Most classes that a process imports make no object in it.
    """

    def __init__(self, cls: type[Any], *of: Any) -> None:
        self._cls, self._of, self._module = cls, of, vars(sys.modules[cls.__module__])

    def __get__(self, thing: Any, owner: type[Any]) -> Callable[..., None]:
        init: Any = _compile_initializer(self._cls, self._module, *self._of)
        self._cls.__init__ = init
        found: Callable[..., None] = init.__get__(thing, owner)
        return found


def _compile_initializer(
    cls: type[Any], module: dict[str, Any], fields: Sequence[dataclasses.Field[Any]], frozen: bool
) -> Callable[..., None]:
    """Compile `__init__` of a class, in the namespace of its module."""
    names: dict[str, Any] = {"FACTORY": _FACTORY, "PUT": object.__setattr__}
    # Checks of fields write to the dictionary in any case: a store in it takes a fifth of `object.__setattr__`
    is_checked = hasattr(cls, "__post_init__")
    store = "FIELDS['{}'] = {}" if frozen and is_checked else "PUT(self, '{}', {})" if frozen else "self.{} = {}"
    positional: list[str] = []
    named: list[str] = []
    lines = ["FIELDS = self.__dict__"] if frozen and is_checked else []
    for field in fields:
        value, argument, has_factory = field.name, field.name, field.default_factory is not dataclasses.MISSING
        if has_factory:
            names[f"make_{field.name}"], argument = field.default_factory, f"{field.name}=FACTORY"
            value = f"make_{field.name}()" + (f" if {field.name} is FACTORY else {field.name}" if field.init else "")
        elif field.default is not dataclasses.MISSING:
            names[f"default_{field.name}"], argument = field.default, f"{field.name}=default_{field.name}"
        if field.init:
            (named if field.kw_only else positional).append(argument)
        if field.init or has_factory:
            lines.append(store.format(field.name, value))
    if is_checked:
        lines.append("self.__post_init__()")
    arguments = ", ".join(("self", *positional, *(["*", *named] if named else [])))
    body = "\n  ".join(lines or ["pass"])
    text = f"def make({', '.join(names)}):\n def __init__({arguments}):\n  {body}\n return __init__"
    made: dict[str, Any] = {}
    exec(text, module, made)
    init: Callable[..., None] = made["make"](**names)
    init.__qualname__ = f"{cls.__qualname__}.__init__"
    init.__annotations__ = {field.name: field.type for field in fields if field.init} | {"return": None}
    return init


# Objects that are values: equality and hashes by fields, arrays among them, and pickles.
#
# Equality is one truth value, and NaN equals NaN. Fields travel in a pickle, values of cached properties do not.

Kind = TypeVar("Kind", bound=type)
_HASH_BYTES = 64
"""Bytes of an array that enter a hash."""


def equal_values(one: Any, other: Any) -> bool:
    """Return whether two fields are equal, including arrays, tuples and mappings at any depth."""
    if isinstance(one, np.ndarray | np.generic) or isinstance(other, np.ndarray | np.generic):
        one, other = np.asarray(one), np.asarray(other)
        # `equal_nan` fails for arrays of texts and objects
        return np.array_equal(one, other, equal_nan=one.dtype.kind == other.dtype.kind == "f")
    if isinstance(one, tuple | list) and type(one) is type(other):
        return len(one) == len(other) and all(map(equal_values, one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal_values(one[name], other[name]) for name in one)
    return bool(one == other) or (isinstance(one, float) and isinstance(other, float) and one != one and other != other)


def compare_by_value(*names: str) -> Callable[[Kind], Kind]:
    """Return a decorator for classes whose instances are equal if these fields are; default: those of a dataclass."""

    def decorate(kind: Kind) -> Kind:
        fields = names or tuple(field.name for field in dataclasses.fields(kind))

        def equal(self: Any, other: object) -> Any:
            if type(other) is not type(self):
                return NotImplemented
            return self is other or all(equal_values(getattr(self, name), getattr(other, name)) for name in fields)

        def hash_of(self: Any) -> int:
            return hash((type(self), *(_hashable(getattr(self, name)) for name in fields)))

        for name, method in (("__eq__", equal), ("__hash__", hash_of)):
            setattr(kind, name, method)
        return kind

    return decorate


def _hashable(value: Any) -> Any:
    """Return a hashable part of a value that equal values share."""
    if isinstance(value, np.ndarray):
        return value.shape, _hash_sample(value).tobytes()
    if isinstance(value, tuple | list):
        return tuple(map(_hashable, value))
    if isinstance(value, Mapping):
        return len(value)  # equal mappings may differ in order
    # NaN hashes by identity, but equals NaN here
    return None if isinstance(value, float) and value != value else value


def _hash_sample(array: Any) -> Any:
    """Return the first numbers of an array; 0 and -0 become one, and all numbers that are not finite do."""
    first = array.reshape(-1)[: _HASH_BYTES // max(array.itemsize, 1)]
    return np.where(np.isfinite(first), first, 0) + 0 if first.dtype.kind == "f" else first


# --- Pickles and copies


def pickle_state(thing: Any) -> dict[str, Any]:
    """Return the attributes of an object without the values of its cached properties."""
    kind: type = type(thing)
    cached = _cached_names(kind)
    return {name: value for name, value in vars(thing).items() if name not in cached}


@cache
def _cached_names(kind: type) -> frozenset[str]:
    """Return the names of the cached properties of a class."""
    # Bases first: a subclass may replace a cached property
    attributes = {name: value for base in reversed(kind.__mro__) for name, value in vars(base).items()}
    return frozenset(name for name, value in attributes.items() if isinstance(value, cached_property))


def restore_state(thing: Any, state: dict[str, Any]) -> None:
    """Set the attributes of an object; make arrays read-only, which pickles do not preserve."""
    vars(thing).update({name: align_array(value) for name, value in state.items()})
    freeze_arrays(thing)


def construct_many(kind: type[Any], count: int, **fields: Iterable[Any]) -> list[Any]:
    """Return `count` objects of a class from the values of all its fields, without checks.

    The caller has checked each value.
    """
    objects = list(map(object.__new__, repeat(kind, count)))
    # The loop over objects runs in C, and sets frozen fields without the `__setattr__` of the class
    for name, values in fields.items():
        deque(map(object.__setattr__, objects, repeat(name), values), maxlen=0)
    return objects


def align_array(value: Any) -> Any:
    """Return the value; for an array that is not aligned, as in a message of a network, an aligned copy."""
    return value.copy() if isinstance(value, np.ndarray) and not value.flags.aligned else value


def freeze_arrays(thing: Any) -> None:
    """Make all arrays among the attributes of an object read-only."""
    for value in vars(thing).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
