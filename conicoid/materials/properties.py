"""The user's own values of a material: density, attenuation, a number in another program."""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from .._util.validation import describe_kind, format_value, real_array

_DIMENSIONS = 2
_LARGEST_INTEGER = 10**18  # scene files read shorter numbers as integers
_MOST_LETTERS = 8
_EXPECTED = "a number, a text, true or false, an array of numbers or texts, or a mapping from names to numbers or texts"


class Properties(Mapping[str, Any]):
    """An immutable mapping from names to values, so that materials can be compared and used as keys.

    A value is a number, a text, a truth value, an array of numbers of one or two dimensions (stored as read-only
    float64), a list of texts (stored as a tuple), or a mapping from names to numbers, texts and truth values.
    Infinite numbers are allowed, NaN is not.

    Parameters
    ----------
    values : Mapping[str, Any]
        The values by name.
    owner : str
        Name of the object, for messages.

    Raises
    ------
    ValueError, TypeError
        For any other value; the message has its name.
    """

    __slots__ = ("_hash", "_values")

    def __init__(self, values: Mapping[str, Any] = {}, *, owner: str = "Properties") -> None:
        field = f"{owner}: properties"
        self._values = {name: _value(f"{field}[{name!r}]", value, True) for name, value in _named(field, values)}
        _check_density(field, self._values.get("density"))
        self._hash: int | None = None

    @classmethod
    def _of(cls, values: dict[str, Any]) -> Properties:
        """Return the properties of values that are already checked."""
        result = cls()
        result._values = values
        return result

    def __getitem__(self, name: str) -> Any:
        try:
            return self._values[name]
        except (KeyError, TypeError):
            names = ", ".join(map(repr, self._values)) or "none"
            raise KeyError(f"no property {format_value(name)}; properties: {names}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Mapping) or self._values.keys() != other.keys():
            return False
        return all(_same(value, other[name]) for name, value in self._values.items())

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset((name, _hashed(value)) for name, value in self._values.items()))
        return self._hash

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{name!r}: {_text(value, _MOST_LETTERS)}" for name, value in self._values.items()) + "}"

    @property
    def exact_text(self) -> str:
        """Text of all values, however long: equal for values that are equal to the bit."""
        return ", ".join(f"{name!r}: {_text(value, None)}" for name, value in self._values.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return Properties, (dict(self._values),)


def _check_density(field: str, value: Any) -> None:
    """Check the one property with a fixed meaning: a density is >= 0 and no truth value."""
    wrong = isinstance(value, bool) or (isinstance(value, int | float | np.ndarray) and bool(np.any(np.less(value, 0))))
    if wrong:
        raise ValueError(f"{field}['density'] must be >= 0, got {format_value(value)}")


def _named(field: str, values: Any) -> Iterator[tuple[str, Any]]:
    """Yield (name, value). Raise TypeError if `values` is no mapping, or a name no text."""
    if not isinstance(values, Mapping):
        raise TypeError(f"{field} must be a mapping from names to values, got {describe_kind(values)}")
    for name, value in values.items():
        if not isinstance(name, str) or not name:
            raise TypeError(f"{field} must have non-empty texts as names, got {format_value(name)}")
        yield name, value


def _value(field: str, value: Any, nested: bool) -> Any:
    """Return a value in its stored form."""
    # Scalars of NumPy become Python's, so that equal values have equal texts.
    if isinstance(value, (np.generic, np.ndarray)) and value.ndim == 0:
        value = value.item()
    if isinstance(value, str):
        if not value:
            raise ValueError(f"{field} must not be an empty text")
        return str(value)
    # Before numbers, as bool is an integer type.
    if isinstance(value, bool):
        return value
    if isinstance(value, numbers.Real):
        return _number(field, value)
    if nested and isinstance(value, Mapping):
        return Properties._of({name: _value(f"{field}[{name!r}]", item, False) for name, item in _named(field, value)})
    if nested and isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (bytes, bytearray)):
        return _array(field, value)
    raise TypeError(f"{field} must be {_EXPECTED if nested else 'a number or a text'}, got {describe_kind(value)}")


def _number(field: str, value: Any) -> int | float:
    """Return an int of at most 18 digits, or a float that is not NaN."""
    if isinstance(value, numbers.Integral):
        if abs(int(value)) >= _LARGEST_INTEGER:
            raise ValueError(f"{field} must be an integer of at most 18 digits, or a float, got {format_value(value)}")
        return int(value)
    try:
        result = float(value)
    except OverflowError:
        result = math.nan
    if math.isnan(result):
        raise ValueError(f"{field} must be a number that float64 holds, not NaN, got {format_value(value)}")
    return result


def _array(field: str, values: Any) -> Any:
    """Return a tuple of texts, or a read-only array of float64."""
    if len(values) and all(isinstance(item, str) for item in values):
        if not all(values):
            raise ValueError(f"{field} must not hold empty texts")
        return tuple(map(str, values))
    array = np.array(real_array("", field, values, "an array of numbers, or a list of texts"), order="C")
    if array.ndim > _DIMENSIONS:
        raise ValueError(f"{field} must have at most {_DIMENSIONS} dimensions, got shape {array.shape}")
    if np.isnan(array).any():
        raise ValueError(f"{field} must not hold NaN")
    array.flags.writeable = False
    return array


def _same(one: Any, other: Any) -> bool:
    """Compare two values, arrays among them."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, tuple) and isinstance(other, list):
        return list(one) == other
    return bool(one == other)


def _hashed(value: Any) -> Any:
    """Return a hashable form of a value: equal for equal values."""
    if isinstance(value, np.ndarray):
        return value.shape, (value + 0.0).tobytes()  # -0 is 0
    return value


def _text(value: Any, most: int | None) -> str:
    """Return the repr of a value; long arrays and lists are shortened if `most` is a number."""
    if isinstance(value, Properties):
        return repr(value) if most is not None else "{" + value.exact_text + "}"
    if isinstance(value, np.ndarray) and (most is None or value.size <= most):
        return repr(value.tolist())
    if isinstance(value, np.ndarray):
        return f"<array of {' x '.join(map(str, value.shape))} numbers>"
    if isinstance(value, tuple) and most is not None and len(value) > most:
        return f"<{len(value)} texts>"
    return repr(value)


NO_PROPERTIES = Properties()
