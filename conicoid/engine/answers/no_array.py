"""Answers and rays are no arrays of numbers: NumPy's functions are told so, but for those that keep things in files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from ...shapes.elsewhere import Told

_KEEPERS = (np.save, np.savez, np.savez_compressed)


class NoArray(metaclass=Told):
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
        if function not in _KEEPERS:
            raise self._refusal(f"{function.__name__}: ")
        kept = {name: _whole(value) for name, value in keywords.items()}
        return function(*map(_whole, args), **kept)

    if not TYPE_CHECKING:  # else checkers would let items be set

        def __setitem__(self, index: Any, value: Any) -> NoReturn:
            raise self._read_only()

        def __delitem__(self, index: Any) -> NoReturn:
            raise self._read_only()

    def _read_only(self) -> TypeError:
        first = type(self).instead.partition(",")[0].partition(" ")[0]
        return TypeError(f"{type(self).__name__} are read-only: a field as a copy is not, such as {first}.copy()")


_BINARY = {"add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**"}
_BINARY = {"add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**"}
_OPERATORS = {
    **{f"__{side}{name}__": sign for name, sign in _BINARY.items() for side in ("", "r")},
    "__neg__": "-", "__abs__": "abs", "__float__": "float", "__int__": "int",
    "__lt__": "<", "__le__": "<=", "__gt__": ">", "__ge__": ">=",
}  # fmt: skip
"""Operators that numbers have, and how they are written."""


def _refused(sign: str) -> Any:
    def refuse(self: NoArray, *others: Any) -> NoReturn:
        raise self._refusal(f"{sign}: ")

    return refuse


for _method, _sign in _OPERATORS.items():
    setattr(NoArray, _method, _refused(_sign))


def boxed(thing: Any, dtype: Any = None) -> Any:
    """An object as an array () of itself, which is how NumPy's files can keep it; never one of its parts."""
    if dtype is not None and np.dtype(dtype) != np.dtype(object):
        raise TypeError(f"{type(thing).__name__} is no array of numbers")
    box = np.empty((), object)
    box[()] = thing
    return box


def _whole(value: Any) -> Any:
    return boxed(value) if isinstance(value, NoArray) else value
