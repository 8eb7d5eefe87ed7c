"""`co.parameters`: the numbers of a scene's shapes as one flat vector with names, and scenes with other numbers."""

from __future__ import annotations

import dataclasses
import fnmatch
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.arrays import real_array
from ..shapes.body import Body
from ..shapes.calls import explained_methods
from ..shapes.calm import calm
from ..shapes.repeated import Repeated
from ..shapes.suggestion import known_names
from ..shapes.validate import shown, what
from ..shapes.vector import FloatArray
from . import fields

if TYPE_CHECKING:
    from ..scene import Scene


@calm
def parameters(scene: Any, only: str | Iterable[str] | None = None) -> Parameters:
    """The numbers of a scene's shapes: a flat vector with names, from which scenes with other numbers are made.

    scene: a `Scene`; of a model that was imported as copies moved there are none, as its bodies are made on demand.
    only: a name or several, or patterns such as "lens.*.radius": the parameters that there are to be, in the scene's
        order; None takes all.

    Raises TypeError for what is no scene, ValueError for a name or pattern that nothing has.
    """
    from ..scene import Scene

    if not isinstance(scene, Scene):
        raise TypeError(f"parameters: scene must be a Scene, got {what(scene)}")
    found = Parameters(scene)
    return found if only is None else found.only(only)


@explained_methods
class Parameters:
    """Numbers of a scene's shapes, in a fixed order. Immutable; arrays are read-only.

    values   float64 (parameters,): what they are
    names    their names: the body's name, or bodies[i], and the way to the number, as in "lens.operands[0].radii[2]"

    Every finite number that a shape was said by is one: of operands of Booleans and of the steps of motions too. What
    is said by other numbers is none: the radii of an ellipsoid that is given by coefficients, the angles of a whole
    turn without a reference.
    """

    def __init__(self, scene: Scene, chosen: Any = None, full: FloatArray | None = None) -> None:
        bodies = scene.bodies
        self._scene, self._bodies = scene, () if isinstance(bodies, Repeated) else tuple(bodies)
        parts = [fields.values_of(body.shape) for body in self._bodies]
        self._firsts = np.cumsum([0, *map(len, parts)], dtype=np.int64)
        self._full: FloatArray = np.concatenate([np.zeros(0), *parts]) if full is None else full
        self._chosen = np.arange(len(self._full)) if chosen is None else chosen
        self._chosen.flags.writeable = self._full.flags.writeable = False

    @cached_property
    def values(self) -> FloatArray:
        values: FloatArray = self._full[self._chosen]
        values.flags.writeable = False
        return values

    @cached_property
    def names(self) -> tuple[str, ...]:
        every = self._names
        return tuple(every[i] for i in self._chosen.tolist())

    @cached_property
    def _names(self) -> list[str]:
        """Of all, chosen or not."""
        found: list[str] = []
        for number, body in enumerate(self._bodies):
            owner = body.name if body.name is not None else f"bodies[{number}]"
            found += fields.numbers_of(body.shape, f"{owner}.")[0]
        return found

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.names)}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Parameters):
            return NotImplemented
        mine, its = ((one._scene, one._chosen.tolist(), one._full.tolist()) for one in (self, other))
        return mine == its

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self._chosen)

    def __getitem__(self, name: str) -> float:
        """The value of a parameter."""
        return float(self.values[self.index(name)])

    def index(self, name: str) -> int:
        """The place of a `name` in the vector. Raises KeyError for one that there is not."""
        if not isinstance(name, str) or name not in self._places:
            told = known_names(str(name), "names", list(self.names))
            raise KeyError(f"parameters: there is no {shown(name)}; {told}")
        return self._places[name]

    def only(self, names: str | Iterable[str]) -> Parameters:
        """Some of them, by `names` or patterns, in which * stands for any letters. Raises ValueError for others."""
        patterns = _patterns(names)
        own = self.names
        kept: set[int] = set()
        for pattern in patterns:
            found = [self._places[pattern]] if pattern in self._places else _matching(own, pattern)
            if not found:
                known = known_names(str(pattern), "names", list(own))
                raise ValueError(f"parameters: only: nothing is called {shown(pattern)}; {known}")
            kept.update(found)
        return Parameters(self._scene, self._chosen[sorted(kept)], self._full)

    def vector(self, values: Mapping[str, float]) -> FloatArray:
        """The vector with other `values` for some names: {"lens.radius": 2.5}. Raises KeyError for unknown ones."""
        vector = self.values.copy()
        for name, value in values.items():
            vector[self.index(name)] = value
        return vector

    @calm
    def scene(self, vector: Any) -> Scene:
        """The scene with the numbers of a `vector` (parameters,); shapes that do not change stay what they are.

        So it prepares only what is new. Raises ValueError for a vector of another shape, or what a shape cannot be.
        """
        full = self._filled(real_array("parameters.scene", "vector", vector, "numbers (parameters,)"))
        changed = np.flatnonzero(full != self._full)
        if not len(changed):
            return self._scene
        bodies: list[Body] = list(self._bodies)
        for entry in np.unique(np.searchsorted(self._firsts, changed, side="right") - 1).tolist():
            part = full[self._firsts[entry] : self._firsts[entry + 1]]
            bodies[entry] = _with_numbers(bodies[entry], part)
        return _edited(self._scene, bodies)

    def _fits(self, entries: Sequence[Body]) -> bool:
        """Have the shapes of other entries their numbers in the same places?"""
        if entries is self._scene.bodies:
            return True
        if isinstance(entries, Repeated):
            return not len(self._bodies)
        counts = np.diff(self._firsts).tolist()
        return len(entries) == len(counts) and all(
            mine is body or mine.shape is body.shape
            or (type(mine.shape) is type(body.shape) and fields.values_of(body.shape).size == count)
            for mine, body, count in zip(self._bodies, entries, counts, strict=True)
        )  # fmt: skip

    def _filled(self, vector: FloatArray) -> FloatArray:
        """All numbers, with those of a vector of the chosen ones."""
        if vector.shape != (len(self),):
            raise ValueError(f"parameters.scene: vector must have shape ({len(self)},), got {vector.shape}")
        full = self._full.copy()
        full[self._chosen] = vector
        return full

    def _spread(self, tangent: FloatArray) -> FloatArray:
        """A change of the chosen ones as a change of all."""
        full = np.zeros(len(self._full))
        full[self._chosen] = tangent
        return full

    def __repr__(self) -> str:
        few = ", ".join(f"{name}={value:.6g}" for name, value in zip(self.names[:4], self.values[:4], strict=True))
        more = f", ... {len(self) - 4} more" if len(self) > 4 else ""
        return f"Parameters({few}{more})"


def _patterns(names: Any) -> list[str]:
    """Names or patterns, one or several. Raises TypeError for anything else."""
    patterns = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else [names]
    for pattern in patterns:
        if not isinstance(pattern, str):
            raise TypeError(f"parameters: only must be a name or pattern, or a list of them, got {shown(pattern)}")
    return patterns


def _matching(names: Sequence[str], pattern: str) -> list[int]:
    """The places of names that a pattern fits; brackets stand for themselves."""
    plain = pattern.replace("[", "[[]")
    return [place for place, name in enumerate(names) if fnmatch.fnmatchcase(name, plain)]


def _with_numbers(body: Body, numbers: FloatArray) -> Body:
    """A body whose shape has other numbers."""
    rest = iter(numbers.tolist())

    def take(_: str, old: float) -> float:
        new = float(next(rest))
        return old if new == old else new

    return dataclasses.replace(body, shape=fields.retold(body.shape, take, fields.checked, None))


def _edited(scene: Scene, bodies: Sequence[Body]) -> Scene:
    """The scene with other bodies, as `scene.replace` makes it: it takes what is prepared, and prepares what is new."""
    from ..scene_parts import Entries

    return scene._edited(Entries(bodies))
