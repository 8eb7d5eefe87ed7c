"""`dataclass`, the decorator of the standard library, in a fifth of its time.

The standard's compiles the texts of up to six methods for each class: 0.8 ms on Python 3.11. For the 130 classes that a
first hit imports, that was a quarter of a process. Here only `__init__` is a text, compiled when a class makes its
first object, and the other methods are shared.
`dataclasses.fields` and `replace` take these classes, and the standard's decorator takes subclasses of them.
"""

from __future__ import annotations

import dataclasses
import inspect
import sys
from collections.abc import Callable, Sequence
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

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
