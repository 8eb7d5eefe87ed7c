"""Wrong values for every parameter of every public function, and the answers or errors that must follow."""

import inspect
import math
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

import conicoid as co

NAN, INF = math.nan, math.inf
HUGE = 10**400

STRANGE: dict[str, Any] = {
    "nan": NAN, "inf": INF, "-inf": -INF, "1e308": 1e308, "1e-320": 1e-320, "1e100": 1e100, "1e-100": 1e-100,
    "-1e100": -1e100, "huge": HUGE, "huge fraction": Fraction(HUGE, 3), "small fraction": Fraction(1, HUGE),
    "decimal": Decimal("1e500"), "decimal nan": Decimal("NaN"), "text": "x", "digits": "1", "none": None, "complex": 1j,
    "numpy complex": np.complex64(1), "true": True, "numpy true": np.True_, "numpy int": np.int64(3),
    "float32": np.float32(0.5), "longdouble": np.longdouble("1e400"), "masked": np.ma.masked, "list": [1.0], "nothing": [],
    "empty": np.array([]), "0-d": np.array(2.0), "1-d": np.array([2.0]), "2-d": np.array([[1.0, 2.0]]), "wrong shape": np.zeros((2, 5)),
    "objects": np.array([object()], dtype=object), "fractions": np.array([Fraction(1, 3)] * 3, dtype=object),
    "huge array": np.array([HUGE, 1, 1], dtype=object), "masked array": np.ma.array([1.0, 2.0, 3.0], mask=[1, 0, 0]),
    "texts": ["a", "b", "c"], "uneven": [[1.0], [1.0, 2.0]], "nans": (NAN, NAN, NAN), "ends": (1e100, 1e-100, 0.0),
    "over": (1e308, 1e308, 1e308), "under": (1e-320, 1e-320, 1e-320), "complexes": np.array([1j, 0, 1]),
    "zeros": (0.0, 0.0, 0.0), "dictionary": {}, "function": len, "bytes": b"abc", "numpy nat": np.datetime64("NaT"),
}  # fmt: skip


def replacements(value: Any) -> Iterator[tuple[str, Any]]:
    """Return strange values in place of a good one, as a whole and as one of its numbers."""
    yield from STRANGE.items()
    if isinstance(value, (tuple, list)) and value:
        for name, strange in STRANGE.items():
            yield f"({name}, ...)", type(value)([strange, *value[1:]])
            if isinstance(value[0], (tuple, list)) and value[0]:
                yield f"(({name}, ...), ...)", type(value)([type(value[0])([strange, *value[0][1:]]), *value[1:]])


def faults(
    function: Callable[..., Any], good: dict[str, Any], names: str | None = None, **fields: str
) -> Iterator[str]:
    """Return the faults of a function's answers to strange arguments, one at a time.

    The function may raise ValueError or TypeError that names `names` and the field, or give a finite answer.
    """
    owner = names or getattr(function, "__name__", "")
    for field, value in good.items():
        for name, strange in replacements(value):
            call = f"{owner}({field}={name})"
            try:
                answer = function(**{**good, field: strange})
            except (ValueError, TypeError) as error:
                message = str(error)
                if owner.lower() not in message.lower() or not any(
                    word in message for word in fields.get(field, field).split("|")
                ):
                    yield f"{call} does not name both: {message[:150]}"
                elif len(message) > 1000:
                    yield f"{call} takes {len(message)} characters"
            except Exception as error:
                yield f"{call}: {type(error).__name__}: {str(error)[:150]}"
            else:
                yield from (f"{call} gives {part}" for part in nan_numbers(answer))


def nan_numbers(answer: Any) -> Iterator[str]:
    """Return the numbers of an answer that are NaN. Bounds and misses may be infinite."""
    if isinstance(answer, co.Shape):
        if not isinstance(answer, co.Spheres) or len(answer):
            low, high = answer.bounds
            if np.isnan([low, high]).any():
                yield f"bounds {low} {high}"
    elif isinstance(answer, (float, np.ndarray, np.floating)):
        if np.isnan(answer).any():
            yield repr(answer)[:100]
    elif isinstance(answer, (tuple, list)):
        for part in answer:
            yield from nan_numbers(part)


def good_arguments(kind: type, instance: Any) -> dict[str, Any]:
    """Return the arguments that make an instance of a dataclass again, but for its motion."""
    return {
        name: getattr(instance, name)
        for name in inspect.signature(kind).parameters
        if name not in ("motion", "material") and getattr(instance, name, None) is not None
    }
