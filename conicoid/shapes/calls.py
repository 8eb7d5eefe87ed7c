"""Calls that do not fit: what is told instead of Python's own words."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from numbers import Number
from types import FunctionType
from typing import Any, ParamSpec, TypeAlias, TypeVar

from .fixed import fixed
from .order import misplaced, order
from .suggestion import close_to
from .synonyms import meant_by
from .validate import listed

P = ParamSpec("P")
R = TypeVar("R")
Kind = TypeVar("Kind", bound=type)
Refusal: TypeAlias = Callable[[Sequence[Any], Mapping[str, Any]], str]

_OF_BODIES = ("name", "material", "color", "colour")
"""What a body is given, and neither its shape nor its scene."""
_ALIKE = 0.7
"""How much an argument's name has in common with the one that was meant, at least: name is not camera."""
_ELSEWHERE = {
    **dict.fromkeys(("background", "lights", "domain"), "a scene has it, scene.replace({0}=...)"),
    **dict.fromkeys(("output", "filename", "path", "file"), "what comes back is saved, image.save(path)"),
    **dict.fromkeys(("exposure", "tone", "gamma"), "what comes back is developed, image.developed(exposure, tone)"),
    **dict.fromkeys(("denoise", "denoised", "denoiser"), "what comes back has that, image.denoised()"),
}
"""What is no argument of a picture."""
_HIDDEN = ("self", "cls")
_SPAWNED = "no small distance is needed: spawned rays know the surface that they start on"
_NOTES: tuple[tuple[tuple[str, ...], set[str], str], ...] = (
    (
        ("t_min", "t_max"),
        {"origins", "directions"},
        "intervals go with the question, scene.first_hit(rays, t_min=0, t_max=...)",
    ),
    (
        ("threads", "n_threads", "workers", "n_jobs", "processes", "n_workers", "pool", "client"),
        {"executor"},
        "executor=co.cluster.Processes(count), or any other executor, does that; threads are co.set_threads(count)",
    ),
    (("epsilon", "eps", "offset", "bias", "delta", "t_min"), {"directions"}, _SPAWNED),
    (
        ("aspect", "aspect_ratio", "width", "resolution", "size"),
        {"position", "look_at", "up", "field_of_view"},
        "pictures have that, scene.render(width, height)",
    ),
    (
        ("density", "mu", "refractive_index", "ior", "n", "properties", "transparency"),
        {"shape", "material"},
        "a material has that, Body(shape, material)",
    ),
    (
        ("bodies", "items", "shapes"),
        {"which", "item"},
        "scene.added(items) and scene.without(which) are scenes of others",
    ),
)
"""Arguments that are none, where these others are, and where they stand."""
_POSITIONAL = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
_OPEN = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


def explained(function: Callable[P, R], refusal: Refusal | None = None) -> Callable[P, R]:
    """The function, which tells in the words of the field where a call does not fit it.

    refusal: of a class, says why a call that would fit is not taken; an empty text where it is.
    """

    @functools.wraps(function)
    def called(*args: P.args, **keywords: P.kwargs) -> R:
        if refusal is not None and (told_first := refusal(args[1:], keywords)):
            raise TypeError(told_first)
        try:
            return function(*args, **keywords)
        except TypeError as error:
            if (told := misfit(function, args, keywords, error)) is None:
                _tell_order(function, args, error)
                raise
            raise told from None
        except ValueError as error:
            _tell_order(function, args, error)
            raise

    return called


def _tell_order(function: Callable[..., Any], args: Sequence[Any], error: TypeError | ValueError) -> None:
    """Add to an error how the call goes, where arguments are in each other's places."""
    told = error.args
    if type(error) not in (TypeError, ValueError) or len(told) != 1 or not isinstance(told[0], str):
        return
    names = inspect.signature(function).parameters
    is_method = next(iter(names), "") in ("self", "cls")
    if "; call it as" in told[0] or not misplaced(names, args[is_method:]):
        return
    name = _owner(function, args, is_method).rpartition(".")[2]
    error.args = (told[0] + order(name, _written(names)),)


def explain(kind: type) -> None:
    """Make a class tell where a call does not fit its fields, and where one is set; once is enough."""
    fixed(kind)
    made_by = vars(kind).get("__init__")
    if made_by is not None and not hasattr(made_by, "__wrapped__") and not issubclass(kind, BaseException):
        setattr(kind, "__init__", explained(made_by, getattr(kind, "_refused_call", None)))  # noqa: B010 (for types, a method is not to be set)


def explained_methods(kind: Kind) -> Kind:
    """A class whose public methods tell where a call does not fit them."""
    for name, value in list(vars(kind).items()):
        function = value.__func__ if isinstance(value, staticmethod | classmethod) else value
        if name.startswith("_") or not isinstance(function, FunctionType) or hasattr(function, "__wrapped__"):
            continue
        told = explained(function)
        setattr(kind, name, type(value)(told) if function is not value else told)
    return kind


def misfit(
    function: Callable[..., Any], args: Sequence[Any], keywords: Mapping[str, Any], error: TypeError
) -> TypeError | None:
    """What to raise where an error says that a call did not fit; None for any other error."""
    trace = error.__traceback__
    if trace is None or trace.tb_next is not None:  # it comes from within the function
        return None
    names: Mapping[str, inspect.Parameter] = inspect.signature(function).parameters
    if any(parameter.kind in _OPEN for parameter in names.values()):
        positional = [name for name, parameter in names.items() if parameter.kind in _POSITIONAL]
        if len(args) <= len(positional) or _OPEN[0] in {parameter.kind for parameter in names.values()}:
            return None
        names, keywords = {name: one for name, one in names.items() if one.kind not in _OPEN}, {}
    is_method = next(iter(names), "") in ("self", "cls")
    problems = _problems(names, args, keywords, is_method)
    owner = _owner(function, args, is_method)
    name = owner.rpartition(".")[2]
    text = f"{owner}() {'; '.join(problems)}; call it as {name}({_written(names)})"
    return TypeError(text + _vector_hint(name, names, args[is_method:])) if problems else None


def _owner(function: Callable[..., Any], args: Sequence[Any], is_method: bool) -> str:
    """What a message calls a function: a method with the class that it was asked of."""
    owner = function.__qualname__.removesuffix(".__init__")
    if not is_method or not args or owner == function.__qualname__.rpartition(".")[0]:
        return owner
    kind = args[0] if isinstance(args[0], type) else type(args[0])
    if not hasattr(kind, function.__name__):  # asked of the class, with something else in place of the instance
        return owner
    return f"{kind.__name__}.{function.__name__}"


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
        listed_in = next((name for name in ("parts", "operands") if name in names), "")
        hint = f" (put {listed_in} in a list)" if listed_in else ""
        hint = f" ({_SPAWNED})" if [*names] == ["self", "directions"] and count == 2 else hint
        found.append(f"takes {most or 'no'} argument{'' if most == 1 else 's'}{unnamed}, got {count}{hint}")
    found += [f"has no argument {name[:40]!r}{_suggested(name, names)}" for name in unknown[:4]]
    return found + [f"is given {name} twice" for name in twice]


def _suggested(name: str, names: Collection[str]) -> str:
    """The argument that may have been meant, or what takes it."""
    shown = [other for other in names if other not in _HIDDEN and not _is_motion(names, other)]
    if note := _noted(name, shown):
        return f": {note}"
    if name in _ELSEWHERE and {"width", "samples", "seed"} <= set(shown):
        return f": {_ELSEWHERE[name].format(name)}"
    if meant := meant_by(name, shown):
        return f" (did you mean {meant}?)"
    if name in ("x", "y", "z") and {"plane", "at"} <= set(shown):
        return f": section('{name}', 0.5) is the one by {name} = 0.5"
    if name in _OF_BODIES and (_is_motion(names, "motion") or "items" in names):
        return ": a body has that, Body(shape, material, name)"
    begun = [other for other in shown if len(name) > 2 and other.startswith(name)]
    meant = close_to(name, shown, _ALIKE) or "".join(begun[:1])
    return f" (did you mean {meant}?)" if meant else ""


def _is_motion(names: Any, name: str) -> bool:
    """Whether an argument is the motion of a shape, which only the shape's own methods give."""
    one = names.get(name) if isinstance(names, Mapping) else None
    return name == "motion" and one is not None and one.kind is one.KEYWORD_ONLY


def _noted(name: str, shown: Collection[str]) -> str:
    """What to tell of an argument that stands elsewhere, as the others show what is called."""
    for names, among, note in _NOTES:
        if name in names and among <= set(shown) and name not in shown:
            return note.format(name)
    return ""


def _written(names: Mapping[str, inspect.Parameter]) -> str:
    """The arguments as a call has them."""
    named = {name: one for name, one in names.items() if name not in _HIDDEN and not _is_motion(names, name)}
    keyword_only = [name for name, one in named.items() if one.kind is one.KEYWORD_ONLY]
    plain = [name for name in named if name not in keyword_only]
    return listed([*plain, *(["*"] if keyword_only else []), *keyword_only], 20)


def _vector_hint(name: str, names: Mapping[str, inspect.Parameter], args: Sequence[Any]) -> str:
    """For three numbers in place of a vector."""
    if len(args) != 3 or not all(isinstance(value, Number) for value in args):
        return ""
    first = next((other for other in names if other not in _HIDDEN), "")
    return f", a vector in brackets: {name}(({', '.join(map(repr, args))}))" if first and len(names) < 4 else ""
