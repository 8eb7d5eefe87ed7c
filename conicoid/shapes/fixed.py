"""Fields of what a user says, which never change: what to write where one is set."""

from __future__ import annotations

import dataclasses
from typing import Any, NoReturn, TypeVar

from .suggestion import close_to

Kind = TypeVar("Kind", bound=type)
_FOUND = ("Measures", "SceneMeasures", "Finding")
"""What is found, and not said."""
_ALIKE = 0.7


def fixed(kind: Kind) -> Kind:
    """A frozen dataclass that tells what to write instead of setting or deleting a field; once is enough.

    The error stays a `dataclasses.FrozenInstanceError`.
    """
    parameters = getattr(kind, "__dataclass_params__", None)
    if parameters is not None and parameters.frozen and vars(kind).get("__setattr__") is not _set:
        setattr(kind, "__setattr__", _set)  # noqa: B010 (the decorator of dataclasses leaves none that is there before)
        setattr(kind, "__delattr__", _deleted)  # noqa: B010
    return kind


def _set(thing: Any, name: str, value: Any) -> NoReturn:
    del value
    raise _refusal(thing, name, "set")


def _deleted(thing: Any, name: str) -> NoReturn:
    raise _refusal(thing, name, "deleted")


def _refusal(thing: Any, name: str, what: str) -> dataclasses.FrozenInstanceError:
    """The error for a field that cannot be set or deleted."""
    kind, shown = type(thing).__name__, name[:80]
    fields = [field.name for field in dataclasses.fields(thing) if field.init]
    told = f"{kind}: {shown} cannot be {what}"
    if name not in fields:
        close = close_to(name, fields, _ALIKE)
        told = f"{kind}: there is no field {shown!r}{f' (did you mean {close}?)' if close else ''}"
        name = close or fields[0]
    if kind in _FOUND:
        return dataclasses.FrozenInstanceError(f"{told}: what was found does not change")
    another = f"dataclasses.replace({kind.lower()}, {name}=...) is another"
    return dataclasses.FrozenInstanceError(f"{told}, and fields never change: {another}{_in_scenes(kind, name)}")


def _in_scenes(kind: str, name: str) -> str:
    """Which scene has the other."""
    if kind == "Body":
        given = "shape" if name == "shape" else f"{name}=..."
        return f", scene.replace(which, {given}) a scene with it" if name in ("shape", "material", "name") else ""
    part = "lights" if kind.endswith("Light") else "camera" if kind.endswith("Camera") else ""
    part = "background" if kind == "Sky" else part
    return f", scene.replace({part}=...) a scene with it" if part else ""
