"""Calls that do not fit: what is told instead of Python's own words."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from numbers import Number
from typing import Any, ParamSpec, TypeVar

from .suggestion import close_to
from .validate import listed

P = ParamSpec("P")
R = TypeVar("R")

_MEANT = {
    "fov": "field_of_view", "fovy": "field_of_view", "n": "refractive_index", "ior": "refractive_index",
    "index": "refractive_index", "r": "radius", "angle": "degrees", "theta": "degrees", "size": "width and height",
    "resolution": "width and height", "shape": "width and height", "spp": "samples", "eye": "position",
    "target": "look_at", "center": "look_at", "objects": "items", "bodies": "items", "file": "path", "filename": "path",
}  # fmt: skip
"""What arguments are called elsewhere, and here."""
_HIDDEN = ("self", "cls", "motion")
_POSITIONAL = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
_OPEN = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


def explained(function: Callable[P, R]) -> Callable[P, R]:
    """The function, which tells in the words of the field where a call does not fit it."""

    @functools.wraps(function)
    def called(*args: P.args, **keywords: P.kwargs) -> R:
        try:
            return function(*args, **keywords)
        except TypeError as error:
            if (told := misfit(function, args, keywords, error)) is None:
                raise
            raise told from None

    return called


def explain(kind: type) -> None:
    """Make a class tell where a call does not fit its fields; once is enough."""
    made_by = vars(kind).get("__init__")
    if made_by is not None and not hasattr(made_by, "__wrapped__") and not issubclass(kind, BaseException):
        setattr(kind, "__init__", explained(made_by))  # noqa: B010 (for types, a method is not to be set)


def misfit(
    function: Callable[..., Any], args: Sequence[Any], keywords: Mapping[str, Any], error: TypeError
) -> TypeError | None:
    """What to raise where an error says that a call did not fit; None for any other error."""
    trace = error.__traceback__
    if trace is None or trace.tb_next is not None:  # it comes from within the function
        return None
    names = inspect.signature(function).parameters
    if any(parameter.kind in _OPEN for parameter in names.values()):
        return None
    is_method = next(iter(names), "") in ("self", "cls")
    problems = _problems(names, args, keywords, is_method)
    owner = function.__qualname__.removesuffix(".__init__")
    name = owner.rpartition(".")[2]
    text = f"{owner}() {'; '.join(problems)}; call it as {name}({_written(names)})"
    return TypeError(text + _vector_hint(name, names, args[is_method:])) if problems else None


def _problems(
    names: Mapping[str, inspect.Parameter], args: Sequence[Any], keywords: Mapping[str, Any], is_method: bool
) -> list[str]:
    positional = [name for name, parameter in names.items() if parameter.kind in _POSITIONAL]
    given = {*positional[: len(args)], *keywords}
    most, count = len(positional) - is_method, len(args) - is_method
    missing = [name for name, one in names.items() if one.default is one.empty and name not in given]
    unknown = [name for name in keywords if name not in names]
    twice = [name for name in positional[: len(args)] if name in keywords]
    found = [f"missing {' and '.join(missing)}"] if missing else []
    if count > most:
        unnamed = " without a name" if len(names) > len(positional) else ""
        found.append(f"takes {most or 'no'} argument{'' if most == 1 else 's'}{unnamed}, got {count}")
    found += [f"has no argument {name[:40]!r}{_suggested(name, names)}" for name in unknown[:4]]
    return found + [f"is given {name} twice" for name in twice]


def _suggested(name: str, names: Collection[str]) -> str:
    """The argument that may have been meant."""
    shown = [other for other in names if other not in _HIDDEN]
    meant = _MEANT.get(name.casefold(), "")
    if not meant or not set(meant.split(" and ")) <= set(shown):
        begun = [other for other in shown if len(name) > 2 and other.startswith(name)]
        meant = close_to(name, shown) or "".join(begun[:1])
    return f" (did you mean {meant}?)" if meant else ""


def _written(names: Mapping[str, inspect.Parameter]) -> str:
    """The arguments as a call has them."""
    keyword_only = [name for name, one in names.items() if one.kind is one.KEYWORD_ONLY and name not in _HIDDEN]
    plain = [name for name in names if name not in (*keyword_only, *_HIDDEN)]
    return listed([*plain, *(["*"] if keyword_only else []), *keyword_only], 20)


def _vector_hint(name: str, names: Mapping[str, inspect.Parameter], args: Sequence[Any]) -> str:
    """For three numbers in place of a vector."""
    if len(args) != 3 or not all(isinstance(value, Number) for value in args):
        return ""
    first = next((other for other in names if other not in _HIDDEN), "")
    return f", a vector in brackets: {name}(({', '.join(map(repr, args))}))" if first and len(names) < 4 else ""
