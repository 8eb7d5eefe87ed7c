"""What makes materials, by name, and what is taken for a material."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np

from .color import checked_color
from .looks import blinn_phong, fog, glass, glow, lacquer, matte, metal, mirror, phong, plastic
from .material import Material
from .metals import aluminium, conductor, copper, gold, iron, silver
from .texture import PATTERNS
from .validate import what

_ALL = (
    matte, phong, blinn_phong, lacquer, mirror, glass, metal, glow, plastic, conductor, gold, silver, copper, aluminium,
    iron, fog,
)  # fmt: skip
CONSTRUCTORS = {f.__name__: f for f in _ALL}
"""Name -> function, for scene files that name a look instead of listing the fields."""
MAKERS: dict[str, Callable[..., Material]] = {"Material": Material, **CONSTRUCTORS}
_FUNCTIONS = tuple(MAKERS.values())


def as_material(owner: str, value: Any, hint: str = "") -> Material:
    """`value` as a material: a Material, or the matte one of a colour, a Checker or a texture.

    hint: what else may have been meant by a text that is no colour.
    Raises TypeError for anything else, ValueError for what is no colour.
    """
    if isinstance(value, Material):
        return value
    if isinstance(value, PATTERNS):
        return matte(value)
    if isinstance(value, str):
        return _of_color(owner, value, hint)
    if isinstance(value, (tuple, list, np.ndarray)):
        return matte(checked_color(owner, "material", value))
    raise TypeError(f"{owner}: material must be a Material such as matte('red'), or a colour, got {no_material(value)}")


@lru_cache(maxsize=256)
def _of_color(owner: str, color: str, hint: str) -> Material:
    """The matte material of a colour's text: also of "gold" and "silver", which are metals where they are called."""
    try:
        return matte(checked_color(owner, "material", color))
    except ValueError as error:
        if color in CONSTRUCTORS:
            expected = f"materials are made by functions: co.{color}(...), without quotes"
            raise ValueError(f"{owner}: material must be a Material or a colour, got {color!r}; {expected}") from None
        raise ValueError(f"{error}{hint if not color.startswith('#') else ''}") from None


def no_material(value: Any) -> str:
    """What stands in place of a material; of what makes one, how it is meant."""
    hint = f"; call it: {value.__name__}(...)" if isinstance(value, type | FunctionType) and value in _FUNCTIONS else ""
    return what(value) + hint


def spelled(material: Material) -> tuple[str, dict[str, Any]]:
    """The name of the function, or of the class, that made a material, and the arguments that were not its defaults."""
    maker, own = vars(material).get("_made", ("Material", {}))
    given = {}
    for name, default in _defaults(maker).items():
        value = own[name] if name in own else getattr(material, name)
        if repr(value) != default:
            given[name] = value
    return maker, given


@functools.cache
def _defaults(maker: str) -> dict[str, str]:
    """The arguments of what makes materials, and the reprs of their defaults."""
    return {name: repr(one.default) for name, one in inspect.signature(MAKERS[maker]).parameters.items()}
