"""`hits.jvp`, `hits.vjp` and `spans.vjp`: what they take and give."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.answer import NO_SCENE
from ..shapes.arrays import real_array
from ..shapes.validate import what
from ..shapes.vector import FloatArray
from .backward import unpacked
from .met import Met, Moving, combined, gathered, met, moving
from .parameters import Parameters

if TYPE_CHECKING:
    from ..engine.prepared import Prepared


@dataclass(frozen=True)
class Tangents:
    """How first hits change: of t (...), of point and normal (..., 3), of uv (..., 2).

    NaN where there is no derivative, and for misses (docs/derivatives.md).
    """

    t: Any
    point: FloatArray
    normal: FloatArray
    uv: FloatArray


@dataclass(frozen=True)
class Cotangents:
    """What is asked of an answer, handed back to what it depends on: the gradient of Σ asked · answer.

    parameters (parameters,), None where none were named; origins and directions (..., 3), shaped like the rays.
    """

    parameters: FloatArray | None
    origins: FloatArray
    directions: FloatArray


def checked_parameters(owner: str, parameters: Any, prepared: Prepared) -> Parameters:
    """Parameters of the scene that an answer is of, or of one whose shapes have their numbers in the same places."""
    if not isinstance(parameters, Parameters):
        raise TypeError(f"{owner}: parameters must be those of co.parameters(scene), got {what(parameters)}")
    if not parameters._fits(prepared.entries):
        raise ValueError(f"{owner}: parameters must be of a scene with the same shapes, but for their numbers")
    return parameters


def scene_of(owner: str, answer: Any) -> Prepared:
    """The scene of an answer that still has one."""
    if answer._scene is NO_SCENE:
        raise ValueError(f"{owner}: these answers were detached from their scene, or pickled; derivatives need it")
    prepared: Prepared = answer._scene
    return prepared


def array_of(owner: str, name: str, given: Any, shape: tuple[int, ...], width: int) -> FloatArray | None:
    """An array shaped like the answer, flattened to (n,) or (n, width); None if it was not given."""
    if given is None:
        return None
    expected = shape if width == 1 else (*shape, width)
    array = real_array(owner, name, given)
    try:
        whole = np.broadcast_to(array, expected)
    except ValueError:
        raise ValueError(f"{owner}: {name} must broadcast to {expected}, got {array.shape}") from None
    return whole.reshape((-1,) if width == 1 else (-1, width))


def vector_of(owner: str, name: str, given: Any, parameters: Parameters) -> FloatArray:
    """A change of the parameters as one of all numbers of the scene."""
    vector = real_array(owner, name, given)
    if vector.shape != (len(parameters),):
        raise ValueError(f"{owner}: {name} must have shape ({len(parameters)},), got {vector.shape}")
    return parameters._spread(vector)


def change_of(
    owner: str, prepared: Prepared, answer: Any, walls: Met, parameters: Any, d_parameters: Any
) -> FloatArray | None:
    """How walls change (w, 22), their forms and maps; None where no parameter changes."""
    if d_parameters is None:
        if parameters is not None:
            checked_parameters(owner, parameters, prepared)
        return None
    if parameters is None:
        raise ValueError(f"{owner}: d_parameters need parameters, those of co.parameters(scene)")
    checked = checked_parameters(owner, parameters, prepared)
    tangent = vector_of(owner, "d_parameters", d_parameters, checked)
    return np.concatenate(combined(_moving(prepared, answer, walls, checked), tangent), axis=1)


def handed_back(
    owner: str, prepared: Prepared, answer: Any, walls: Met, parameters: Any, asked: FloatArray
) -> FloatArray | None:
    """What is asked of walls (w, 22) as what is asked of parameters (parameters,)."""
    if parameters is None:
        return None
    checked = checked_parameters(owner, parameters, prepared)
    every = gathered(_moving(prepared, answer, walls, checked), *unpacked(asked), len(checked._full))
    result: FloatArray = every[checked._chosen]
    return result


def _moving(prepared: Prepared, answer: Any, walls: Met, parameters: Parameters) -> Moving:
    """What moves the walls of an answer; kept with it."""
    known: Moving | None = vars(answer).get("_moving")
    if known is None:
        known = vars(answer)["_moving"] = moving(prepared, walls, parameters)
    return known


__all__ = ["Cotangents", "Met", "Tangents", "met"]
