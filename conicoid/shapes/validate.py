"""Turn what a caller passes into plain floats and tuples, or refuse it by name.

Every error reads ``Sphere: radius must be > 0, got -1.0``: the object, the field, what was
expected and what was found.
"""

from __future__ import annotations

import inspect
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import Any

import numpy as np

from .vector import Matrix4, Vector

SMALLEST, LARGEST = 1e-100, 1e100
"""The domain of every number: 0, or of a magnitude between these. Squares and fourth powers then stay in float64."""
DOMAIN = "0 or of magnitude 1e-100 to 1e100"


_POSITIVE = "> 0, from 1e-100 to 1e100"


def outside_domain(values: Any) -> Any:
    """Which finite numbers of an array lie outside of the domain."""
    sizes = np.abs(values)
    return (sizes != 0) & ~((sizes >= SMALLEST) & (sizes <= LARGEST))


_LONGEST = 80


def shown(value: Any) -> str:
    """A value as a message tells it: of thousands of digits or entries the first."""
    try:
        text = repr(value)
    except Exception:  # as of an integer with more digits than Python prints
        text = ""
    if not text or len(text) > _LONGEST:
        return f"{text[:_LONGEST]}... of type {type(value).__name__}" if text else f"a {type(value).__name__}"
    return text


def listed(texts: Sequence[str], most: int = 8) -> str:
    """The first of some texts, one after the other, each cut to what a line holds; and how many more there are."""
    first = [text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..." for text in texts[:most]]
    return ", ".join(first) + (f" and {len(texts) - most:,} more" if len(texts) > most else "")


def what(value: Any) -> str:
    """What something is that has no business here: the class, the function, or the kind of thing."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if callable(value) and isinstance(getattr(value, "__name__", None), str):
        return f"the function {value.__name__}"
    return f"{value!r}" if value is None or isinstance(value, bool) else type(value).__name__


def masked_arrays() -> Any:
    """NumPy's class of masked arrays; () where nobody has imported it, so that nothing can be one."""
    return getattr(sys.modules.get("numpy.ma"), "MaskedArray", ())


def _is_number(value: Any) -> bool:
    """Whether float() says what is meant: no text, truth value, complex number, masked entry or array with axes."""
    if isinstance(value, (bool, np.bool_, str, bytes)) or value is None or isinstance(value, masked_arrays()):
        return False
    return not (isinstance(value, np.ndarray) and value.ndim) and not is_complex(value)


def is_complex(value: Any) -> bool:
    """Whether float() would drop an imaginary part, with a warning."""
    return isinstance(value, complex) or getattr(getattr(value, "dtype", None), "kind", "") == "c"


def number(owner: str, field: str, value: Any, *, finite: bool = True, domain: str = DOMAIN) -> float:
    """`value` as a float; NaN is refused, infinity too unless `finite` is False. domain: what messages call it."""
    if type(value) is float and (SMALLEST <= value <= LARGEST or -LARGEST <= value <= -SMALLEST):
        return value
    if type(value) not in (float, int) and not _is_number(value):
        raise ValueError(f"{owner}: {field} must be a number, got {shown(value)}")
    try:
        result = float(value)
    except OverflowError:
        raise ValueError(f"{owner}: {field} must be {domain}, got {shown(value)}") from None
    except (TypeError, ValueError):
        raise ValueError(f"{owner}: {field} must be a number, got {shown(value)}") from None
    if math.isnan(result) or (finite and math.isinf(result)):
        raise ValueError(f"{owner}: {field} must be {'finite' if finite else 'a number'}, got {result}")
    if result and not SMALLEST <= abs(result) <= LARGEST and not math.isinf(result):
        raise ValueError(f"{owner}: {field} must be {domain}, got {result}")
    return result


def positive(owner: str, field: str, value: Any) -> float:
    """`value` as a finite float > 0."""
    result = number(owner, field, value, domain=_POSITIVE)
    if not result > 0:
        raise ValueError(f"{owner}: {field} must be > 0, got {result}")
    return result


def nonnegative(owner: str, field: str, value: Any) -> float:
    """`value` as a finite float >= 0."""
    result = number(owner, field, value)
    if result < 0:
        raise ValueError(f"{owner}: {field} must be >= 0, got {result}")
    return result


def whole(value: Any) -> int | None:
    """The one rule for whole numbers: an integer, or a float without a fraction such as 1e5, NumPy's too; else None."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, (int, np.integer)):
        return int(value)
    return int(value) if isinstance(value, (float, np.floating)) and float(value).is_integer() else None


def integer(owner: str, field: str, value: Any, least: int, most: int | None = None) -> int:
    """`value` as an integer from `least` to `most`."""
    found = whole(value)
    if found is None or found < least:
        raise ValueError(f"{owner}: {field} must be an integer >= {least}, got {shown(value)}")
    if most is not None and found > most:
        raise ValueError(f"{owner}: {field} must be an integer <= {most:,}, got {shown(value)}")
    return found


def flag(owner: str, field: str, value: Any) -> bool:
    """`value` as a bool; nothing else is taken for one."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{owner}: {field} must be true or false, got {shown(value)}")
    return bool(value)


def vector(owner: str, field: str, value: Any, *, nonzero: bool = False) -> Vector:
    """`value` as three finite floats; all zero is refused if `nonzero`."""
    plain = _plain_vector(value)
    if plain is not None and not (nonzero and plain == (0.0, 0.0, 0.0)):
        return plain
    x, y, z = numbers(owner, field, value, 3)
    if nonzero and x == y == z == 0:
        raise ValueError(f"{owner}: {field} must not be zero, got {(x, y, z)}")
    return x, y, z


def _plain_vector(value: Any) -> Vector | None:
    """Three floats of the domain, as nearly all vectors are; None for `numbers` to look closer."""
    kind = type(value)
    if kind is np.ndarray and value.dtype == np.float64 and value.shape == (3,):
        value = value.tolist()
    elif (kind is not tuple and kind is not list) or len(value) != 3:
        return None
    x, y, z = value
    if not (type(x) is type(y) is type(z) is float):
        return None
    for number_ in (x, y, z):
        if not (SMALLEST <= number_ <= LARGEST or -LARGEST <= number_ <= -SMALLEST or number_ == 0):
            return None
    return x, y, z


def _items(value: Any) -> tuple[Any, ...] | None:
    """What a list, tuple or array holds; None for a text, a set, and what cannot be gone through."""
    if (
        isinstance(value, (str, bytes, Set, Mapping))
        or not isinstance(value, Iterable)
        or getattr(value, "ndim", 1) == 0
    ):
        return None
    return tuple(value)


_AXES = {
    "x": "(1, 0, 0)",
    "y": "(0, 1, 0)",
    "z": "(0, 0, 1)",
    "-x": "(-1, 0, 0)",
    "-y": "(0, -1, 0)",
    "-z": "(0, 0, -1)",
}


def numbers(owner: str, field: str, value: Any, count: int) -> tuple[float, ...]:
    """`value` as a tuple of `count` finite floats."""
    items = _items(value)
    if items is None:
        kind = "the number " if _is_number(value) and isinstance(value, (int, float, np.number)) else ""
        axis = _AXES.get(value.casefold()) if isinstance(value, str) and count == 3 else None
        meant = f"; that axis is {axis}" if axis else ""
        raise ValueError(f"{owner}: {field} must be {_of_numbers(count)}, got {kind}{shown(value)}{meant}")
    if len(items) != count:
        raise ValueError(f"{owner}: {field} must be {_of_numbers(count)}, got {len(items)}: {shown(value)}")
    return tuple(number(owner, f"{field}[{i}]", item) for i, item in enumerate(items))


def _of_numbers(count: int) -> str:
    return "a list of 1 number" if count == 1 else f"{count} numbers"


def interval(owner: str, field: str, value: Any) -> tuple[float, float] | None:
    """None, or (low, high) with low < high; either end may be infinite."""
    if value is None:
        return None
    ends = value if type(value) is tuple else _items(value)
    if ends is None or len(ends) != 2:
        raise ValueError(f"{owner}: {field} must be (low, high), got {shown(value)}")
    low = number(owner, f"{field}[0]", ends[0], finite=False)
    high = number(owner, f"{field}[1]", ends[1], finite=False)
    if not low < high or low == math.inf or high == -math.inf:
        raise ValueError(f"{owner}: {field} must have low < high, got ({low}, {high})")
    return low, high


def vectors(owner: str, field: str, value: Any, minimum: int) -> tuple[Vector, ...]:
    """`value` as a tuple of at least `minimum` points."""
    items = _items(value)
    if items is None:
        raise ValueError(f"{owner}: {field} must be a list of points, got {shown(value)}")
    points = tuple(vector(owner, f"{field}[{i}]", item) for i, item in enumerate(items))
    if len(points) < minimum:
        raise ValueError(f"{owner}: {field} must have at least {minimum} points, got {len(points)}")
    return points


def matrix4(owner: str, field: str, value: Any) -> Matrix4:
    """`value` as a 4 × 4 tuple of rows of finite floats."""
    rows = _items(value)
    if rows is None:
        raise ValueError(f"{owner}: {field} must be a 4 x 4 matrix, got {shown(value)}")
    if len(rows) != 4:
        raise ValueError(f"{owner}: {field} must be a 4 x 4 matrix, got {len(rows)} rows")
    return tuple(numbers(owner, f"{field}[{i}]", row, 4) for i, row in enumerate(rows))


def callback(owner: str, field: str, value: Any, takes: str = "done, count") -> None:
    """Refuse what is neither a function nor None, or takes other arguments."""
    if value is None:
        return
    if not callable(value) or isinstance(value, type):
        raise TypeError(f"{owner}: {field} must be a function or None, got {what(value)}")
    try:
        inspect.signature(value).bind(*takes.split(", "))
    except ValueError:  # one of Python's own, which tell nothing
        return
    except TypeError as error:
        told = f"got {what(value)}, which does not: {error}"
        raise TypeError(f"{owner}: {field} must be called as {field}({takes}); {told}") from None


def path(owner: str, value: Any, field: str = "path") -> str | os.PathLike[str]:
    """Refuse what is no path of a file."""
    if not isinstance(value, (str, os.PathLike)) or not os.fspath(value):
        raise TypeError(f"{owner}: {field} must be a text or a Path, got {shown(value)}")
    return value


def npz_path(owner: str, what: str, value: Any) -> str | os.PathLike[str]:
    """The path of a file of arrays; a ValueError for another suffix than .npz."""
    file = path(owner, value)
    if not os.fspath(file).lower().endswith(".npz"):
        table = owner == "load" and os.fspath(file).lower().endswith(".csv")
        hint = "; a table of conicoid trace is read by np.genfromtxt(path, delimiter=',', names=True)" if table else ""
        raise ValueError(f"{owner}: path of {what} must end with .npz, got {shown(os.fspath(file))}{hint}")
    return file


def refuse_with(owner: str, field: str, **others: Any) -> None:
    """ValueError for the first of some arguments that is given beside one that it does not go with."""
    for name, value in others.items():
        if value is not None:
            raise ValueError(f"{owner}: {name} does not go with {field}")
