"""Turn arguments of callers into plain floats, tuples and arrays, or refuse them by name.

Every error reads ``Sphere: radius must be > 0, got -1.0``: the object, the field, what was expected and what was found.
Angles in radians in place of degrees give a warning. Warnings point at the line of the caller, however deep in the
package their cause is.
"""

from __future__ import annotations

import contextlib
import inspect
import itertools
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from contextvars import ContextVar
from typing import Any, Final

import numpy as np

from .records import FloatArray, Matrix4, Vector

_PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")
_RAISE = ContextVar("refused", default=False)
"""Whether warnings are exceptions in this context."""


class SuppressedWarning(Exception):
    """Raised instead of a warning during a speculative attempt."""


@contextlib.contextmanager
def raise_warnings() -> Iterator[None]:
    """Let `warn` raise `SuppressedWarning` within the block.

    The block is an attempt; after such an error the work is done in another way, which gives the warning.
    """
    token = _RAISE.set(True)
    try:
        yield
    finally:
        _RAISE.reset(token)


def warn(message: str) -> None:
    """Give a UserWarning at the line of the caller.

    That is the first line of the stack outside of this package and of code that Python generates for it.
    """
    if _RAISE.get():
        raise SuppressedWarning(message)
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and _is_internal_frame(frame.f_code.co_filename):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, stacklevel=level)


def _is_internal_frame(file: str) -> bool:
    """Return whether a file belongs to the package, or is generated code such as that of dataclasses."""
    return file.startswith((_PACKAGE, "<")) or os.path.basename(file) == "dataclasses.py"


# --- Numbers and vectors

SMALLEST, LARGEST = 1e-100, 1e100
"""The domain of every number: 0, or a magnitude between these. Squares and fourth powers then stay in float64."""
DOMAIN = "0 or of magnitude 1e-100 to 1e100"


_POSITIVE = "> 0, from 1e-100 to 1e100"


def is_outside_domain(values: Any) -> Any:
    """Return which finite numbers of an array lie outside of the domain."""
    sizes = np.abs(values)
    return (sizes != 0) & ~((sizes >= SMALLEST) & (sizes <= LARGEST))


_LONGEST = 80


def format_value(value: Any) -> str:
    """Return a value for a message: of thousands of digits or entries the first."""
    try:
        text = repr(value)
    except Exception:  # an integer may have more digits than Python prints
        text = ""
    if not text or len(text) > _LONGEST:
        return f"{text[:_LONGEST]}... of type {type(value).__name__}" if text else f"a {type(value).__name__}"
    return text


def format_list(texts: Sequence[str], most: int = 8) -> str:
    """Return the first texts, with commas between, each cut to the width of a line, and the number of the others."""
    first = [text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..." for text in texts[:most]]
    return ", ".join(first) + (f" and {len(texts) - most:,} more" if len(texts) > most else "")


def describe_kind(value: Any) -> str:
    """Return the kind of an unexpected value for a message: the class, the function, or its type."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if callable(value) and isinstance(getattr(value, "__name__", None), str):
        return f"the function {value.__name__}"
    return f"{value!r}" if value is None or isinstance(value, bool) else type(value).__name__


def masked_arrays() -> Any:
    """Return the class of masked arrays of NumPy; () if nobody has imported it, so that nothing can be one."""
    return getattr(sys.modules.get("numpy.ma"), "MaskedArray", ())


def _is_number(value: Any) -> bool:
    """Return whether float() is right for a value: no text, bool, complex number, masked entry or array with axes."""
    if isinstance(value, (bool, np.bool_, str, bytes)) or value is None or isinstance(value, masked_arrays()):
        return False
    return not (isinstance(value, np.ndarray) and value.ndim) and not is_complex(value)


def is_complex(value: Any) -> bool:
    """Return whether float() would drop an imaginary part, with a warning."""
    return isinstance(value, complex) or getattr(getattr(value, "dtype", None), "kind", "") == "c"


def check_number(owner: str, field: str, value: Any, *, finite: bool = True, domain: str = DOMAIN) -> float:
    """Return `value` as a float; NaN is refused, infinity too unless `finite` is False.

    domain: the domain in messages.
    """
    # The usual case first: a float of the domain needs no other test
    if type(value) is float and (SMALLEST <= value <= LARGEST or -LARGEST <= value <= -SMALLEST):
        return value
    if type(value) not in (float, int) and not _is_number(value):
        raise ValueError(f"{owner}: {field} must be a number, got {format_value(value)}")
    try:
        result = float(value)
    except OverflowError:
        raise ValueError(f"{owner}: {field} must be {domain}, got {format_value(value)}") from None
    except (TypeError, ValueError):
        raise ValueError(f"{owner}: {field} must be a number, got {format_value(value)}") from None
    if math.isnan(result) or (finite and math.isinf(result)):
        raise ValueError(f"{owner}: {field} must be {'finite' if finite else 'a number'}, got {result}")
    if result and not SMALLEST <= abs(result) <= LARGEST and not math.isinf(result):
        raise ValueError(f"{owner}: {field} must be {domain}, got {result}")
    return result


def check_positive(owner: str, field: str, value: Any) -> float:
    """Return `value` as a finite float > 0."""
    result = check_number(owner, field, value, domain=_POSITIVE)
    if not result > 0:
        raise ValueError(f"{owner}: {field} must be > 0, got {result}")
    return result


def check_nonnegative(owner: str, field: str, value: Any) -> float:
    """Return `value` as a finite float >= 0."""
    result = check_number(owner, field, value)
    if result < 0:
        raise ValueError(f"{owner}: {field} must be >= 0, got {result}")
    return result


def as_integer(value: Any) -> int | None:
    """Return an integer, or a float without a fraction such as 1e5, as an int, also for NumPy types; else None.

    This is the one rule for whole numbers in the package.
    """
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, (int, np.integer)):
        return int(value)
    return int(value) if isinstance(value, (float, np.floating)) and float(value).is_integer() else None


def check_integer(owner: str, field: str, value: Any, least: int, most: int | None = None) -> int:
    """Return `value` as an integer from `least` to `most`."""
    found = as_integer(value)
    if found is None or found < least:
        raise ValueError(f"{owner}: {field} must be an integer >= {least}, got {format_value(value)}")
    if most is not None and found > most:
        raise ValueError(f"{owner}: {field} must be an integer <= {most:,}, got {format_value(value)}")
    return found


def check_flag(owner: str, field: str, value: Any) -> bool:
    """Return `value` as a bool; no other type is accepted."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{owner}: {field} must be true or false, got {format_value(value)}")
    return bool(value)


def check_vector(owner: str, field: str, value: Any, *, nonzero: bool = False) -> Vector:
    """Return `value` as three finite floats; all zero is refused if `nonzero`."""
    plain = _plain_vector(value)
    # Zero vectors take the slow path, which has the messages
    if plain is not None and not (nonzero and plain == (0.0, 0.0, 0.0)):
        return plain
    x, y, z = check_numbers(owner, field, value, 3)
    if nonzero and x == y == z == 0:
        raise ValueError(f"{owner}: {field} must not be zero, got {(x, y, z)}")
    return x, y, z


def _plain_vector(value: Any) -> Vector | None:
    """Return three floats of the domain, as nearly all vectors are; None if `check_numbers` must decide."""
    kind = type(value)
    if kind is np.ndarray and value.dtype == np.float64 and value.shape == (3,):
        value = value.tolist()
    elif (kind is not tuple and kind is not list) or len(value) != 3:
        return None
    x, y, z = value
    if not (type(x) is type(y) is type(z) is float):
        return None
    for number_ in (x, y, z):
        # NaN fails every comparison, so it is left to `check_numbers`
        if not (SMALLEST <= number_ <= LARGEST or -LARGEST <= number_ <= -SMALLEST or number_ == 0):
            return None
    return x, y, z


def _items(value: Any) -> tuple[Any, ...] | None:
    """Return the items of a list, tuple or array; None for a text, a set, and anything that is not iterable."""
    if (
        isinstance(value, (str, bytes, Set, Mapping))
        or not isinstance(value, Iterable)
        or getattr(value, "ndim", 1) == 0
    ):
        return None
    return tuple(value)


_AXIS_VECTORS = {
    "x": "(1, 0, 0)",
    "y": "(0, 1, 0)",
    "z": "(0, 0, 1)",
    "-x": "(-1, 0, 0)",
    "-y": "(0, -1, 0)",
    "-z": "(0, 0, -1)",
}


def check_numbers(owner: str, field: str, value: Any, count: int) -> tuple[float, ...]:
    """Return `value` as a tuple of `count` finite floats."""
    items = _items(value)
    if items is None:
        kind = "the number " if _is_number(value) and isinstance(value, (int, float, np.number)) else ""
        axis = _AXIS_VECTORS.get(value.casefold()) if isinstance(value, str) and count == 3 else None
        meant = f"; that axis is {axis}" if axis else ""
        raise ValueError(f"{owner}: {field} must be {_count_phrase(count)}, got {kind}{format_value(value)}{meant}")
    if len(items) != count:
        raise ValueError(f"{owner}: {field} must be {_count_phrase(count)}, got {len(items)}: {format_value(value)}")
    return tuple(check_number(owner, f"{field}[{i}]", item) for i, item in enumerate(items))


def _count_phrase(count: int) -> str:
    """Return a number of numbers in words."""
    return "a list of 1 number" if count == 1 else f"{count} numbers"


def check_interval(owner: str, field: str, value: Any) -> tuple[float, float] | None:
    """Return None, or (low, high) with low < high; either end may be infinite."""
    if value is None:
        return None
    ends = value if type(value) is tuple else _items(value)
    if ends is None or len(ends) != 2:
        raise ValueError(f"{owner}: {field} must be (low, high), got {format_value(value)}")
    low = check_number(owner, f"{field}[0]", ends[0], finite=False)
    high = check_number(owner, f"{field}[1]", ends[1], finite=False)
    if not low < high or low == math.inf or high == -math.inf:
        raise ValueError(f"{owner}: {field} must have low < high, got ({low}, {high})")
    return low, high


def check_vectors(owner: str, field: str, value: Any, minimum: int) -> tuple[Vector, ...]:
    """Return `value` as a tuple of at least `minimum` points."""
    items = _items(value)
    if items is None:
        raise ValueError(f"{owner}: {field} must be a list of points, got {format_value(value)}")
    points = tuple(check_vector(owner, f"{field}[{i}]", item) for i, item in enumerate(items))
    if len(points) < minimum:
        raise ValueError(f"{owner}: {field} must have at least {minimum} points, got {len(points)}")
    return points


def check_direction(owner: str, field: str, value: Any) -> Vector:
    """Return `value` as three finite floats, not all zero."""
    return check_vector(owner, field, value, nonzero=True)


def optional(check: Callable[[str, str, Any], Any]) -> Callable[[str, str, Any], Any]:
    """Return the check of a value that may be None."""
    return lambda owner, field, value: None if value is None else check(owner, field, value)


def check_fields(thing: Any, **checks: Callable[[str, str, Any], Any]) -> None:
    """Check fields of a frozen dataclass in the given order, and set what each check(class, field, value) returns."""
    owner, values = type(thing).__name__, thing.__dict__
    for field, check in checks.items():
        values[field] = check(owner, field, values[field])


def check_matrix4(owner: str, field: str, value: Any) -> Matrix4:
    """Return `value` as a 4 × 4 tuple of rows of finite floats."""
    rows = _items(value)
    if rows is None:
        raise ValueError(f"{owner}: {field} must be a 4 x 4 matrix, got {format_value(value)}")
    if len(rows) != 4:
        raise ValueError(f"{owner}: {field} must be a 4 x 4 matrix, got {len(rows)} rows")
    return tuple(check_numbers(owner, f"{field}[{i}]", row, 4) for i, row in enumerate(rows))


def check_callback(owner: str, field: str, value: Any, takes: str = "done, count") -> None:
    """Raise TypeError for a value that is neither a function nor None, or that takes other arguments."""
    if value is None:
        return
    if not callable(value) or isinstance(value, type):
        raise TypeError(f"{owner}: {field} must be a function or None, got {describe_kind(value)}")
    try:
        inspect.signature(value).bind(*takes.split(", "))
    except ValueError:  # a builtin function may have no signature
        return
    except TypeError as error:
        found = f"got {describe_kind(value)}, which does not: {error}"
        raise TypeError(f"{owner}: {field} must be called as {field}({takes}); {found}") from None


def check_path(owner: str, value: Any, field: str = "path") -> str | os.PathLike[str]:
    """Return `value`; raise TypeError unless it is a path."""
    if not isinstance(value, (str, os.PathLike)) or not os.fspath(value):
        raise TypeError(f"{owner}: {field} must be a text or a Path, got {format_value(value)}")
    return value


def check_npz_path(owner: str, what: str, value: Any) -> str | os.PathLike[str]:
    """Return the path of a file of arrays; raise ValueError for another suffix than .npz."""
    file = check_path(owner, value)
    if not os.fspath(file).lower().endswith(".npz"):
        raise ValueError(f"{owner}: path of {what} must end with .npz, got {format_value(os.fspath(file))}")
    return file


def check_list(owner: str, field: str, values: Any, kinds: Mapping[str, type]) -> tuple[Any, ...]:
    """Return values of some kinds, by name, as a tuple; a single value stands for a list of it. Raise TypeError."""
    if isinstance(values, tuple(kinds.values())):
        return (values,)
    names = ", ".join(kinds)
    if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
        raise TypeError(f"{owner}: {field} must be a list of {names}, or one of them, got {describe_kind(values)}")
    items = tuple(values)
    for i, item in enumerate(items):
        if not isinstance(item, tuple(kinds.values())):
            raise TypeError(f"{owner}: {field}[{i}] must be one of {names}, got {describe_kind(item)}")
    return items


# --- Arrays

_MASK_SEARCH_DEPTH = 5
"""The depth of lists that are searched for masked entries."""
BELOW_ROUNDING = 2.0**-60
"""Components below this part of the largest of a vector are negligible, see `zero_negligible`."""


def real_array(owner: str, field: str, values: Any, expected: str = "an array of numbers") -> FloatArray:
    """Return `values` as an array of float64, with NaN and infinity; without a copy if it is an aligned one already.

    Raises ValueError with object and field for anything but real numbers: texts, None, complex numbers, masked entries,
    numbers beyond float64, lists of uneven lengths.
    """
    name = f"{owner}: {field}" if owner else field
    if isinstance(values, np.ndarray) and values.dtype == np.float64 and not isinstance(values, masked_arrays()):
        return values if values.flags.aligned else values.copy()  # messages of networks and records are not aligned
    if _is_plain_row(values):  # of one ray: the checks below take longer than its tracing
        with contextlib.suppress(OverflowError):
            return np.array(values, dtype=np.float64)
    if is_masked(values):
        raise ValueError(f"{name} must be {expected} without masked entries")
    try:
        with np.errstate(all="ignore"):  # numbers that become infinite are for the caller to refuse
            array = np.asarray(values)
            if array.dtype == object:
                # Fractions, decimals and large integers
                array = np.array([_real_float(item) for item in array.ravel()]).reshape(array.shape)
            if array.dtype.kind not in "fiub":
                raise TypeError
            return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        if is_on_card(values):
            raise ValueError(f"{name} must be {expected}, got one on a card: copy it to NumPy") from None
        found = f"an array of {values.dtype}" if isinstance(values, np.ndarray) else format_value(values)
        raise ValueError(f"{name} must be {expected}, got {found}") from None


_AXIS_LETTERS = ["x", "y", "z"]


def refuse_columns(owner: str, field: str, values: Any) -> None:
    """Raise ValueError for a table whose three columns are named after x, y and z, in another order."""
    columns = getattr(values, "columns", None)
    if columns is None or len(columns) != 3:
        return
    names = [str(name) for name in columns]
    axes = [
        next((letter for letter in (name[-1:].lower(), name[:1].lower()) if letter in _AXIS_LETTERS), "")
        for name in names
    ]
    if sorted(axes) == _AXIS_LETTERS and axes != _AXIS_LETTERS:
        ordered = [names[axes.index(axis)] for axis in _AXIS_LETTERS]
        raise ValueError(
            f"{owner}: {field} must have columns in the order x, y, z, got {names}; table[{ordered}] has it"
        )


_PLAIN_KINDS = frozenset((float, int))


def _is_plain_row(values: Any) -> bool:
    """Return whether a value is a number of Python, or a list or tuple of such."""
    kind = type(values)
    return kind in _PLAIN_KINDS or (
        (kind is tuple or kind is list) and bool(values) and _PLAIN_KINDS.issuperset(map(type, values))
    )


def _real_float(item: Any) -> float:
    """Return an item as a float; raise TypeError for a text, None or a complex number."""
    if item is None or isinstance(item, (str, bytes)) or is_complex(item):
        raise TypeError
    return float(item)


def is_dask_array(values: Any) -> bool:
    """Return whether an array is lazy, by Dask.

    One of xarray is as lazy as its data: it has no graph if they are in memory. The class has the method: objects of
    this package would answer for a missing attribute with a search for similar names.
    """
    return hasattr(type(values), "__dask_graph__") and values.__dask_graph__() is not None


def is_on_card(values: Any) -> bool:
    """Return whether an array lives on a GPU of NVIDIA's, such as one of CuPy, PyTorch or JAX; `DeviceRays` do."""
    if hasattr(type(values), "__dlpack_device__"):
        with contextlib.suppress(BufferError, ValueError):  # in parts on several devices, or on one without a number
            return values.__dlpack_device__()[0] in (2, 13)  # memory of a card, or shared with it
    return hasattr(type(values), "__cuda_array_interface__") or hasattr(type(values), "_is_on_card")


def is_masked(values: Any) -> bool:
    """Return whether there are masked entries, also within lists, where NumPy takes them for NaN with a warning."""
    level = [values]  # the items of one depth
    for _ in range(_MASK_SEARCH_DEPTH):
        kinds = set(map(type, level))
        if any(issubclass(kind, masked_arrays()) for kind in kinds) and any(map(_has_masked, level)):
            return True
        lists = {kind for kind in kinds if issubclass(kind, Sequence) and not issubclass(kind, (str, bytes))}
        level = list(itertools.chain.from_iterable(item for item in level if type(item) in lists))
    return False


def _has_masked(item: Any) -> bool:
    """Return whether an item is an array with masked entries."""
    return isinstance(item, masked_arrays()) and bool(np.ma.getmaskarray(item).any())


def zero_negligible(vectors: FloatArray) -> FloatArray:
    """Return rounded vectors (..., 3), with 0 for components that are outside of the domain and negligible.

    A component below 1e-100 and below 2^-60 of the largest is smaller than the rounding of the length of the vector.
    """
    sizes = np.abs(vectors)
    small = sizes < SMALLEST
    if not small.any():  # the usual case
        return vectors
    with np.errstate(all="ignore"):
        trace = small & (sizes <= BELOW_ROUNDING * sizes.max(axis=-1, keepdims=True, initial=0.0))
    return np.where(trace, 0.0, vectors) if trace.any() else vectors


# --- Angles, which are in degrees in the whole package

_LARGEST_RADIANS = 4 * math.pi
"""Two turns: larger numbers are no angles in radians."""
_RADIANS_STEP = math.pi / 1800
"""A tenth of a degree, in radians."""
_RADIANS_ROUNDINGS = 3
"""Roundings of an angle in radians: of math.radians, of π / 6, of 2 * (π / 3)."""


def check_degrees(owner: str, field: str, value: Any) -> float:
    """Return `value` as a finite float; warn if it is a plain angle in radians to the last bits."""
    angle = check_number(owner, field, value)
    if looks_like_radians(angle) or (isinstance(value, np.float32) and _looks_like_radians32(value)):
        warn(
            f"{owner}: {field} must be in degrees, got {angle!r}: "
            f"{_radians_as_degrees(angle)} degrees are that in radians"
        )
    return angle


def check_angle_range(thing: Any) -> None:
    """Check the fields start_angle and end_angle, counter-clockwise in degrees: their difference is in (0, 360]."""
    check_fields(thing, start_angle=check_degrees, end_angle=check_degrees)
    first, last, owner = thing.start_angle, thing.end_angle, type(thing).__name__
    if not 0 < last - first <= 360:
        raise ValueError(f"{owner}: end_angle - start_angle must be in (0, 360], got {last} - {first} = {last - first}")


def warn_of_radians(owner: str, field: str, values: Any) -> None:
    """Warn if one of several angles, which must be in degrees, is a plain angle in radians.

    All of them must be within two turns in radians, as those of a scan in radians are.
    """
    angles = np.asarray(values)
    # Integers are never angles in radians; the factor allows for the rounding of float32
    if angles.dtype.kind != "f" or not angles.size or np.abs(angles).max() > _LARGEST_RADIANS * (1 + 1e-6):
        return
    is_plain = (
        (lambda angle: _looks_like_radians32(np.float32(angle))) if angles.dtype == np.float32 else looks_like_radians
    )
    found = next((angle for angle in angles.ravel().tolist() if is_plain(angle)), None)
    if found is not None:
        warn(
            f"{owner}: {field} must be in degrees, got {found!r}: "
            f"{_radians_as_degrees(found)} degrees are that in radians"
        )


def warn_of_degrees(owner: str, field: str, angles: FloatArray) -> None:
    """Warn if one of several angles, which must be in radians, is a whole number beyond a turn."""
    found = angles[(np.abs(angles) > 2 * math.pi) & (angles == np.round(angles))]
    if len(found):
        warn(f"{owner}: {field} must be in radians, got {found[0]:g}: np.radians(angles) makes them of degrees")


def looks_like_radians(angle: float) -> bool:
    """Return whether a number is, apart from rounding, a multiple of a tenth of a degree in radians.

    No number of degrees is so by chance: no decimal up to 4π with six digits after the point or fewer is, since π has
    no such multiples.
    """
    size = abs(angle)
    if not _RADIANS_STEP / 2 < size <= _LARGEST_RADIANS * (1 + 1e-12):
        return False
    return abs(size - round(size / _RADIANS_STEP) * _RADIANS_STEP) <= _RADIANS_ROUNDINGS * math.ulp(size)


def _looks_like_radians32(angle: np.float32) -> bool:
    """Return the same for float32, which has fewer digits: only multiples of 15 degrees are distinct."""
    size, step = abs(float(angle)), math.pi / 12  # 15 degrees
    if not step / 2 < size <= _LARGEST_RADIANS * (1 + 1e-6):
        return False
    return abs(size - round(size / step) * step) <= 2 * float(np.spacing(np.float32(size)))


def _radians_as_degrees(angle: float) -> str:
    """Return an angle in radians as text in degrees."""
    return f"{round(angle / _RADIANS_STEP) / 10:g}"


# --- Limits of rays: an argument that was not passed leaves the limits of a `Rays` in force


class DefaultFloat(float):
    """Sentinel for a number that was not passed."""

    __slots__ = ()


DEFAULT_T_MIN: Final = DefaultFloat(0.0)
"""Where rays begin without other limits, in units of the lengths of their directions."""
DEFAULT_T_MAX: Final = DefaultFloat(math.inf)
"""Where rays end without other limits."""


def replace_default(own: Any, value: Any) -> Any:
    """Return the value that was passed, or `own`, that of the object, for a sentinel."""
    return own if isinstance(value, DefaultFloat) else value
