"""Answers and rays are no arrays of numbers: NumPy's functions are told so, but for those that keep things in files."""

from __future__ import annotations

from typing import Any, ClassVar, NoReturn

import numpy as np

_KEEPERS = (np.save, np.savez, np.savez_compressed)


class NoArray:
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


def boxed(thing: Any, dtype: Any = None) -> Any:
    """An object as an array () of itself, which is how NumPy's files can keep it; never one of its parts."""
    if dtype is not None and np.dtype(dtype) != np.dtype(object):
        raise TypeError(f"{type(thing).__name__} is no array of numbers")
    box = np.empty((), object)
    box[()] = thing
    return box


def _whole(value: Any) -> Any:
    return boxed(value) if isinstance(value, NoArray) else value
