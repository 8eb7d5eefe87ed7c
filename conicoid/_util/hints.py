"""What may have been meant by a name that there is not."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from numbers import Number, Real
from types import FunctionType
from typing import Any, NoReturn, ParamSpec, TypeAlias, TypeVar

import numpy as np

from .validation import format_list, format_value

Name = TypeVar("Name", bound=str)

_MOST_COMPARED = 5000
"""Names that one is compared with, which takes a fraction of a second."""


def closest_name(name: str, known: Collection[str], least: float = 0.6) -> str:
    """The known name that is most like this one; empty where none is, by `least` of all letters."""
    import difflib

    folded = {item.casefold(): item for item in known if len(item) <= 100}
    close = difflib.get_close_matches(name.casefold()[:100], folded, n=1, cutoff=least)
    return folded[close[0]] if close else ""


def check_choice(owner: str, field: str, value: Any, known: Collection[Name]) -> Name:
    """The value, where it is one of the known names; a ValueError that lists them, and says which may be meant."""
    if isinstance(value, str):
        for name in known:
            if value == name:
                return name
    close = closest_name(value, known) if isinstance(value, str) else ""
    meant = f" (did you mean {close!r}?)" if close else ""
    raise ValueError(f"{owner}: {field} must be one of {', '.join(known)}, got {format_value(value)}{meant}")


def suggest_name(name: str, known: Collection[str]) -> str:
    """A suggestion in brackets, or the list of what exists where that is short; empty otherwise."""
    if close := closest_name(name, known):
        return f" (did you mean {close!r}?)"
    names = [item for item in known if len(item) <= 100]
    return f" (known: {', '.join(sorted(names))})" if 0 < len(names) <= 16 else ""


def describe_names(name: object, what: str, known: Sequence[str]) -> str:
    """What to tell of a name that is not among some: those that hold it, or the first and the one most like it.

    `what` they are, such as "materials".
    """
    if not known:
        return f"{what}: none has a name"
    folded = name.casefold() if isinstance(name, str) else ""
    if folded and (holding := [repr(item) for item in known if folded in item.casefold()]):
        return f"{what} with it in their names: {format_list(holding)}"
    close = closest_name(name, known[:_MOST_COMPARED]) if isinstance(name, str) else ""
    meant = f" (did you mean {format_list([repr(close)])}?)" if close else ""
    return f"{what}: {format_list([repr(item) for item in known])}{meant}"


# Arguments in each other's places: a call whose numbers stand where vectors are wanted is told how it goes.

_NUMBER_ANNOTATIONS, _VECTOR_ANNOTATIONS = ("float", "int"), ("VectorLike", "VectorLike | None")
_RECEIVER_NAMES = ("self", "cls")
_ORDER_NOTES = {
    "Plane": "; through a point p its offset is normal·p",
    "HalfSpace": "; through a point p its offset is normal·p",
    "Cylinder": "; along an axis, end is start + height * axis",
    "Cone": "; along an axis, end is start + height * axis",
    "Camera": "; an angle is named, field_of_view=40",
    "Body": "",
}
"""What there is to say besides of things that are given otherwise elsewhere."""


def has_misplaced_arguments(names: Mapping[str, inspect.Parameter], args: Sequence[Any]) -> bool:
    """Whether an argument without a name is plainly none of its place: a number for a vector, a vector for a number.

    Or anything for a shape, where a shape is in another place. One argument alone has no other place.
    """
    places = [one for name, one in names.items() if name not in _RECEIVER_NAMES]
    pairs = [(str(one.annotation), value) for one, value in zip(places, args, strict=False)]
    if len(pairs) < 2:
        return False
    some_number = any(_is_number(value) for wanted, value in pairs if wanted not in _NUMBER_ANNOTATIONS)
    for wanted, value in pairs:
        if wanted in _NUMBER_ANNOTATIONS and (_is_vector(value) or (isinstance(value, str) and some_number)):
            return True
        if wanted in _VECTOR_ANNOTATIONS and _is_number(value):
            return True
        if wanted == "Shape" and not _is_shape(value) and any(map(_is_shape, args)):
            return True
    return False


def call_order_hint(name: str, written: str) -> str:
    """What to add to a message: how the call goes."""
    return f"; call it as {name}({written}){_ORDER_NOTES.get(name, '')}"


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_vector(value: Any) -> bool:
    return isinstance(value, (tuple, list, np.ndarray)) and len(np.shape(value)) == 1 and len(value) == 3


def _is_shape(value: Any) -> bool:
    return hasattr(value, "bounds_under")


# What arguments are called in other programs: for messages of calls that do not fit, and of keys in scene files.

_ARGUMENT_SYNONYMS = {
    "fov": "field_of_view|camera (its field_of_view)|height (of the window)",
    "fovy": "field_of_view|camera (its field_of_view)",
    "fovx": "field_of_view (the vertical one)", "n": "refractive_index", "num": "rays", "ior": "refractive_index",
    "index": "refractive_index", "r": "radius", "angle": "degrees|field_of_view|start_radius and end_radius",
    "deg": "degrees", "radians": "degrees", "size": "width and height|scale", "resolution": "width and height",
    "shape": "width and height|item", "aspect": "width and height", "spp": "samples", "samples": "rays",
    "n_rays": "rays",
    "num_rays": "rays", "nrays": "rays", "eye": "position", "from": "position", "look_from": "position",
    "lookfrom": "position", "target": "look_at|direction (target - position)|directions (target - origins)",
    "lookat": "look_at|direction (look_at - position)", "to": "look_at|direction",
    "center": "look_at|about|start and end", "position": "center|camera (its position)|origins",
    "up": "camera (its up)",
    "centre": "center|look_at|start and end", "pos": "position|center", "location": "position|center",
    "pivot": "about", "origin": "center|position|about", "point": "about|points|center|offset (normal·point)",
    "vup": "up",
    "up_vector": "up", "height": "start and end", "length": "start and end", "p1": "start", "p2": "end",
    "base": "start", "top": "end", "radius1": "start_radius", "radius2": "end_radius", "r1": "start_radius",
    "r2": "end_radius", "diameter": "radius (half of it)", "min": "low", "max": "high",
    "axis": "plane|direction|start and end", "value": "at|values", "apex": "start and end",
    "radius": "start_radius and end_radius",
    "vector": "offset|direction|axis", "distance": "t_max|offset", "d": "offset|directions", "o": "origins",
    "objects": "items|bodies",
    "geometry": "bodies", "version": "conicoid", "shapes": "items", "bodies": "items", "light": "lights",
    "bg": "background", "sky": "background", "file": "path", "filename": "path",
    "color": "color|intensity|material|transparency (a colour tints at each wall)",
    "colour": "color|intensity|material|transparency (a colour tints at each wall)", "rgb": "color|intensity",
    "power": "intensity", "strength": "intensity", "brightness": "intensity", "energy": "intensity",
    "alpha": "transparency", "opacity": "transparency", "transmission": "transparency", "roughness": "shininess",
    "mu": "properties", "density": "properties", "reflection": "reflectivity", "cmap": "colormap",
    "palette": "colormap", "clim": "vmin and vmax", "data": "array", "image": "array", "tmin": "t_min",
    "tmax": "t_max", "callback": "progress", "verbose": "progress", "random_state": "seed", "rng": "seed",
    "max_depth": "depth", "bounces": "depth", "n1": "eta (index before / index behind)",
    **dict.fromkeys(("semi_axes", "semiaxes", "axes", "a", "b", "c"), "radii"),
    **dict.fromkeys(("xmin", "xmax", "ymin", "ymax", "zmin", "zmax", "x_min", "x_max"), "low and high"),
    **dict.fromkeys(("x0", "y0", "z0"), "center|normal and offset"),
    **dict.fromkeys(("x", "y", "z"), "normal and offset|offset (a vector, (x, y, z))"),
    **dict.fromkeys(("max_t", "maxt", "far", "tfar", "max_distance", "max_dist", "max_range", "range"), "t_max"),
    **dict.fromkeys(("min_t", "mint", "near", "tnear", "min_distance"), "t_min"),
    **dict.fromkeys(("default", "fill_value", "missing"), "otherwise"),
    **dict.fromkeys(("positions", "coords", "xyz"), "centers"),
    **dict.fromkeys(("vertices", "faces"), "normals and offsets"),
    **dict.fromkeys(("material_id", "id", "nuclides", "attenuation"), "properties"),
    **dict.fromkeys(("det_spacing", "pixel_size", "detector_width", "det_width", "pixel_spacing"), "spacing"),
    **dict.fromkeys(("sod", "source_distance", "dso", "sid"), "source_origin|source_to_isocenter"),
    **dict.fromkeys(("odd", "detector_distance", "ddo"), "origin_detector"),
    **dict.fromkeys(("sdd", "dsd"), "origin_detector (sdd - source_origin)|source_to_detector"),
    **dict.fromkeys(("theta", "views", "projections"), "degrees|angles"), "det_count": "columns", "ncols": "columns",
    "detectors": "columns", "det_row_count": "rows", "nrows": "rows", "zoom": "height (of the window)",
    "scale": "height (of the window)", "rays": "origins",
    "n2": "eta (index before / index behind)", "look_at": "direction (look_at - position)|camera (its look_at)",
    "direction": "directions|look_at (position + direction)", "fps": "frames and seconds", "duration": "seconds",
    "field_of_view": "camera (its field_of_view)|height (of the window)", "width": "height (of the window)",
}  # fmt: skip
"""What each is here: the first of these that a call takes, with what there is to say of it in brackets."""


def argument_synonym(name: str, known: Collection[str]) -> str:
    """The argument, or arguments, of some that a name stands for elsewhere; empty where there is none."""
    for meant in _ARGUMENT_SYNONYMS.get(name.casefold(), "").split("|"):
        if meant.endswith("(of the window)") and "look_at" not in known:  # a picture has a height as well
            continue
        if meant and set(meant.partition(" (")[0].split(" and ")) <= set(known):
            return meant
    return ""


# Fields of what a user says, which never change: what to write where one is set.

FrozenKind = TypeVar("FrozenKind", bound=type)
_RESULT_CLASSES = ("Measures", "SceneMeasures", "Finding")
"""What is found, and not said."""
_FIELD_CUTOFF = 0.7


def frozen_with_hints(kind: FrozenKind) -> FrozenKind:
    """A frozen dataclass that tells what to write instead of setting or deleting a field; once is enough.

    The error stays a `dataclasses.FrozenInstanceError`.
    """
    parameters = getattr(kind, "__dataclass_params__", None)
    if parameters is not None and parameters.frozen and vars(kind).get("__setattr__") is not _refuse_set:
        setattr(kind, "__setattr__", _refuse_set)  # noqa: B010 (the decorator of dataclasses leaves none that is there before)
        setattr(kind, "__delattr__", _refuse_delete)  # noqa: B010
    return kind


def _refuse_set(thing: Any, name: str, value: Any) -> NoReturn:
    del value
    raise _frozen_error(thing, name, "set")


def _refuse_delete(thing: Any, name: str) -> NoReturn:
    raise _frozen_error(thing, name, "deleted")


def _frozen_error(thing: Any, name: str, what: str) -> dataclasses.FrozenInstanceError:
    """The error for a field that cannot be set or deleted."""
    kind, shown = type(thing).__name__, name[:80]
    fields = [field.name for field in dataclasses.fields(thing) if field.init]
    told = f"{kind}: {shown} cannot be {what}"
    if name not in fields:
        close = closest_name(name, fields, _FIELD_CUTOFF)
        told = f"{kind}: there is no field {shown!r}{f' (did you mean {close}?)' if close else ''}"
        name = close or fields[0]
    if kind in _RESULT_CLASSES:
        return dataclasses.FrozenInstanceError(f"{told}: what was found does not change")
    another = f"dataclasses.replace({kind.lower()}, {name}=...) is another"
    return dataclasses.FrozenInstanceError(f"{told}, and fields never change: {another}{_scene_hint(kind, name)}")


def _scene_hint(kind: str, name: str) -> str:
    """Which scene has the other."""
    if kind == "Body":
        given = "shape" if name == "shape" else f"{name}=..."
        return f", scene.replace(which, {given}) a scene with it" if name in ("shape", "material", "name") else ""
    part = "lights" if kind.endswith("Light") else "camera" if kind.endswith("Camera") else ""
    part = "background" if kind == "Sky" else part
    return f", scene.replace({part}=...) a scene with it" if part else ""


# Calls that do not fit: what is told instead of Python's own words.

P = ParamSpec("P")
R = TypeVar("R")
Kind = TypeVar("Kind", bound=type)
Refusal: TypeAlias = Callable[[Sequence[Any], Mapping[str, Any]], str]

_BODY_ARGUMENTS = ("name", "material", "color", "colour")
"""What a body is given, and neither its shape nor its scene."""
_ARGUMENT_CUTOFF = 0.7
"""How much an argument's name has in common with the one that was meant, at least: name is not camera."""
_PICTURE_ARGUMENT_HINTS = {
    **dict.fromkeys(("background", "lights", "domain"), "a scene has it, scene.replace({0}=...)"),
    **dict.fromkeys(("output", "filename", "path", "file"), "what comes back is saved, image.save(path)"),
    **dict.fromkeys(("exposure", "tone", "gamma"), "what comes back is developed, image.developed(exposure, tone)"),
    **dict.fromkeys(("denoise", "denoised", "denoiser"), "what comes back has that, image.denoised()"),
}
"""What is no argument of a picture."""
_HIDDEN_ARGUMENTS = ("self", "cls")
_SPAWN_NOTE = "no small distance is needed: spawned rays know the surface that they start on"
_ARGUMENT_NOTES: tuple[tuple[tuple[str, ...], set[str], str], ...] = (
    (
        ("t_min", "t_max"),
        {"origins", "directions"},
        "intervals go with the question, scene.first_hit(rays, t_min=0, t_max=...)",
    ),
    (
        ("threads", "n_threads", "workers", "n_jobs", "processes", "n_workers", "pool", "client"),
        {"executor"},
        "executor=co.parallel.Processes(count), or any other executor, does that; threads are co.set_threads(count)",
    ),
    (("epsilon", "eps", "offset", "bias", "delta", "t_min"), {"directions"}, _SPAWN_NOTE),
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
_VARIADIC = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


def with_call_hints(function: Callable[P, R], refusal: Refusal | None = None) -> Callable[P, R]:
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
            if (told := misfit_error(function, args, keywords, error)) is None:
                _add_order_hint(function, args, error)
                raise
            raise told from None
        except ValueError as error:
            _add_order_hint(function, args, error)
            raise

    return called


def _add_order_hint(function: Callable[..., Any], args: Sequence[Any], error: TypeError | ValueError) -> None:
    """Add to an error how the call goes, where arguments are in each other's places."""
    told = error.args
    if type(error) not in (TypeError, ValueError) or len(told) != 1 or not isinstance(told[0], str):
        return
    names = inspect.signature(function).parameters
    is_method = next(iter(names), "") in ("self", "cls")
    if "; call it as" in told[0] or not has_misplaced_arguments(names, args[is_method:]):
        return
    name = _call_name(function, args, is_method).rpartition(".")[2]
    error.args = (told[0] + call_order_hint(name, _format_signature(names)),)


def add_call_hints(kind: type) -> None:
    """Make a class tell where a call does not fit its fields, and where one is set; once is enough."""
    frozen_with_hints(kind)
    made_by = vars(kind).get("__init__")
    if made_by is not None and not hasattr(made_by, "__wrapped__") and not issubclass(kind, BaseException):
        setattr(kind, "__init__", with_call_hints(made_by, getattr(kind, "_refused_call", None)))  # noqa: B010 (for types, a method is not to be set)


def with_method_hints(kind: Kind) -> Kind:
    """A class whose public methods tell where a call does not fit them."""
    for name, value in list(vars(kind).items()):
        function = value.__func__ if isinstance(value, staticmethod | classmethod) else value
        if name.startswith("_") or not isinstance(function, FunctionType) or hasattr(function, "__wrapped__"):
            continue
        told = with_call_hints(function)
        setattr(kind, name, type(value)(told) if function is not value else told)
    return kind


def misfit_error(
    function: Callable[..., Any], args: Sequence[Any], keywords: Mapping[str, Any], error: TypeError
) -> TypeError | None:
    """What to raise where an error says that a call did not fit; None for any other error."""
    trace = error.__traceback__
    if trace is None or trace.tb_next is not None:  # it comes from within the function
        return None
    names: Mapping[str, inspect.Parameter] = inspect.signature(function).parameters
    if any(parameter.kind in _VARIADIC for parameter in names.values()):
        positional = [name for name, parameter in names.items() if parameter.kind in _POSITIONAL]
        if len(args) <= len(positional) or _VARIADIC[0] in {parameter.kind for parameter in names.values()}:
            return None
        names, keywords = {name: one for name, one in names.items() if one.kind not in _VARIADIC}, {}
    is_method = next(iter(names), "") in ("self", "cls")
    problems = _problems(names, args, keywords, is_method)
    owner = _call_name(function, args, is_method)
    name = owner.rpartition(".")[2]
    text = f"{owner}() {'; '.join(problems)}; call it as {name}({_format_signature(names)})"
    return TypeError(text + _vector_hint(name, names, args[is_method:])) if problems else None


def _call_name(function: Callable[..., Any], args: Sequence[Any], is_method: bool) -> str:
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
        hint = f" ({_SPAWN_NOTE})" if [*names] == ["self", "directions"] and count == 2 else hint
        found.append(f"takes {most or 'no'} argument{'' if most == 1 else 's'}{unnamed}, got {count}{hint}")
    found += [f"has no argument {name[:40]!r}{_argument_hint(name, names)}" for name in unknown[:4]]
    return found + [f"is given {name} twice" for name in twice]


def _argument_hint(name: str, names: Collection[str]) -> str:
    """The argument that may have been meant, or what takes it."""
    shown = [other for other in names if other not in _HIDDEN_ARGUMENTS and not _is_motion(names, other)]
    if note := _argument_note(name, shown):
        return f": {note}"
    if name in _PICTURE_ARGUMENT_HINTS and {"width", "samples", "seed"} <= set(shown):
        return f": {_PICTURE_ARGUMENT_HINTS[name].format(name)}"
    if meant := argument_synonym(name, shown):
        return f" (did you mean {meant}?)"
    if name in ("x", "y", "z") and {"plane", "at"} <= set(shown):
        return f": section('{name}', 0.5) is the one by {name} = 0.5"
    if name in _BODY_ARGUMENTS and (_is_motion(names, "motion") or "items" in names):
        return ": a body has that, Body(shape, material, name)"
    begun = [other for other in shown if len(name) > 2 and other.startswith(name)]
    meant = closest_name(name, shown, _ARGUMENT_CUTOFF) or "".join(begun[:1])
    return f" (did you mean {meant}?)" if meant else ""


def _is_motion(names: Any, name: str) -> bool:
    """Whether an argument is the motion of a shape, which only the shape's own methods give."""
    one = names.get(name) if isinstance(names, Mapping) else None
    return name == "motion" and one is not None and one.kind is one.KEYWORD_ONLY


def _argument_note(name: str, shown: Collection[str]) -> str:
    """What to tell of an argument that stands elsewhere, as the others show what is called."""
    for names, among, note in _ARGUMENT_NOTES:
        if name in names and among <= set(shown) and name not in shown:
            return note.format(name)
    return ""


def _format_signature(names: Mapping[str, inspect.Parameter]) -> str:
    """The arguments as a call has them."""
    named = {name: one for name, one in names.items() if name not in _HIDDEN_ARGUMENTS and not _is_motion(names, name)}
    keyword_only = [name for name, one in named.items() if one.kind is one.KEYWORD_ONLY]
    plain = [name for name in named if name not in keyword_only]
    return format_list([*plain, *(["*"] if keyword_only else []), *keyword_only], 20)


def _vector_hint(name: str, names: Mapping[str, inspect.Parameter], args: Sequence[Any]) -> str:
    """For three numbers in place of a vector."""
    if len(args) != 3 or not all(isinstance(value, Number) for value in args):
        return ""
    first = next((other for other in names if other not in _HIDDEN_ARGUMENTS), "")
    return f", a vector in brackets: {name}(({', '.join(map(repr, args))}))" if first and len(names) < 4 else ""
