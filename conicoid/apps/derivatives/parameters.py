"""Every number of a shape, by a name that says where it stands; and the shape again with other numbers.

One walk, in one order, serves both: the operands of Booleans, the steps of motions and a box within which a shape is
cut are gone into. Numbers are floats; what is infinite, such as the end of a range, is none.
"""

from __future__ import annotations

import dataclasses
import fnmatch
import math
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.errstate import ignore_fp_errors
from ..._util.hints import describe_names, with_method_hints
from ..._util.validation import describe_kind, format_value, real_array
from ...geometry.body import Body
from ...geometry.bulk import Bulk, Spheres
from ...geometry.instances import InstanceList
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution
from ...geometry.shape import Shape
from ...geometry.transform import IDENTITY_MOTION, Motion, Rotate, Scale, Step, Transform, Translate
from ...queries.scene_protocol import SceneLike, is_scene

Take: TypeAlias = Callable[[str, float], Any]
"""What is to stand in place of a number, by its name."""
Make: TypeAlias = Callable[[Any, dict[str, Any]], Any]
"""A shape or a step with other values of some fields."""

Task: TypeAlias = Generator["Task", Any, Any]
"""What yields the tasks that it needs the results of."""

_ANGLES = ("start_angle", "end_angle")


def map_numbers(shape: Any, take: Take, make: Make, path: str | None = "") -> Any:
    """The shape with every number replaced by what `take` gives for it. path: before the names; None for no names."""
    return _run_task(_map_shape(shape, take, make, path))


def map_value(value: Any, take: Take, make: Make) -> Any:
    """The value of a field with every number replaced."""
    return _run_task(_map_value(value, take, make, None))


def _run_task(task: Task) -> Any:
    """What a task returns, which yields the tasks that it needs done before: nothing calls itself level by level."""
    waiting, result = [task], None
    while waiting:
        try:
            before = waiting[-1].send(result)
        except StopIteration as done:
            waiting.pop()
            result = done.value
        else:
            waiting.append(before)
            result = None
    return result


def _join_path(path: str | None, more: str) -> str | None:
    return None if path is None else path + more


def _map_shape(shape: Any, take: Take, make: Make, path: str | None) -> Task:
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(shape):
        if not field.init or field.name == "motion" or is_derived(shape, field.name):
            continue
        old = getattr(shape, field.name)
        new = yield _map_value(old, take, make, _join_path(path, field.name))
        if new is not old:
            changes[field.name] = new
    motion = map_motion(shape.motion, take, make, _join_path(path, "motion"))
    if motion is not shape.motion:
        changes["motion"] = motion
    return make(shape, changes) if changes else shape


def is_derived(shape: Any, name: str) -> bool:
    """Does a field say nothing of its own: radii besides coefficients, angles of a whole turn?"""
    if name == "radii" and getattr(shape, "coefficients", None) is not None:
        return True
    if isinstance(shape, Revolution) and name in _ANGLES:
        return bool(shape.end_angle - shape.start_angle >= 360)
    return name in _ANGLES and getattr(shape, "reference", 0) is None


def map_motion(motion: Motion, take: Take, make: Make, path: str | None) -> Motion:
    """The motion with every number of its steps replaced."""
    steps = tuple(
        _run_task(_map_step(step, take, make, _join_path(path, f"[{k}]."))) for k, step in enumerate(motion.steps)
    )
    return motion if all(new is old for new, old in zip(steps, motion.steps, strict=True)) else Motion(steps)


def _map_step(step: Any, take: Take, make: Make, path: str | None) -> Task:
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(step):
        old = getattr(step, field.name)
        if isinstance(step, Transform):
            rows = yield _map_value(old[:3], take, make, _join_path(path, "matrix"))
            new: Any = (
                old if rows is old[:3] or all(a is b for a, b in zip(rows, old, strict=False)) else (*rows, old[3])
            )
        else:
            new = yield _map_value(old, take, make, _join_path(path, field.name))
        if new is not old:
            changes[field.name] = new
    return make(step, changes) if changes else step


def _map_value(value: Any, take: Take, make: Make, path: str | None) -> Task:
    if isinstance(value, float):
        return take(path or "", value) if math.isfinite(value) else value
    if isinstance(value, np.ndarray):
        return _map_array(value, take, path)
    if isinstance(value, Shape):
        made = yield _map_shape(value, take, make, _join_path(path, "."))
        return made
    if isinstance(value, Mapping):
        new = {name: take(_join_path(path, f".{name}") or "", number) for name, number in value.items()}
        return value if all(new[name] is number for name, number in value.items()) else new
    if isinstance(value, tuple):
        parts = []
        for k, part in enumerate(value):
            made = yield _map_value(part, take, make, _join_path(path, f"[{k}]"))
            parts.append(made)
        return value if all(new is old for new, old in zip(parts, value, strict=True)) else tuple(parts)
    return value


def _map_array(values: Any, take: Take, path: str | None) -> Any:
    """The numbers of many bodies."""
    old = values.tolist()
    if values.ndim == 1:
        new = [take(_join_path(path, f"[{i}]") or "", x) for i, x in enumerate(old)]
    else:
        new = [[take(_join_path(path, f"[{i}][{k}]") or "", x) for k, x in enumerate(row)] for i, row in enumerate(old)]
    return values if new == old else np.array(new)


def replace_unchecked(thing: Any, changes: dict[str, Any]) -> Any:
    """A shape or a step with other values of fields, of which nothing is checked."""
    made = object.__new__(type(thing))
    for field in dataclasses.fields(thing):
        object.__setattr__(made, field.name, changes.get(field.name, getattr(thing, field.name)))
    return made


def replace_checked(thing: Any, changes: dict[str, Any]) -> Any:
    """A shape with other values of fields, as if it was said so. Raises what its class raises."""
    if not isinstance(thing, Shape):
        return replace_unchecked(thing, changes)
    motion = changes.pop("motion", None)
    made = dataclasses.replace(thing, **_constructor_arguments(thing, changes)) if changes else thing
    return made if motion is None else _apply_motion(made, motion)


def _constructor_arguments(thing: Any, changes: dict[str, Any]) -> dict[str, Any]:
    if "coefficients" in changes and isinstance(thing, Ellipsoid):
        return {"radii": Ellipsoid.radii, **changes}
    return changes


def _apply_motion(shape: Shape, motion: Motion) -> Shape:
    """The shape under a motion whose steps are asked for anew, so that they are checked."""
    told = IDENTITY_MOTION
    for step in motion.steps:
        told = _append_step(told, step)
    made: Shape = dataclasses.replace(shape, motion=told)
    told.check(type(shape).__name__)
    return made


def _append_step(motion: Motion, step: Step) -> Motion:
    if isinstance(step, Translate):
        return motion.translate(step.offset)
    if isinstance(step, Rotate):
        return motion.rotate(step.axis, step.degrees)
    if isinstance(step, Scale):
        return motion.scale(step.factors)
    return motion.transform(step.matrix) if isinstance(step, Transform) else motion.then(Motion((step,)))


def numbers_of(shape: Shape, path: str | None = "") -> tuple[list[str], list[float]]:
    """The names and the values of all numbers of a shape."""
    names: list[str] = []
    values: list[float] = []

    def take(name: str, value: float) -> float:
        names.append(name)
        values.append(value)
        return value

    map_numbers(shape, take, replace_unchecked, path)
    return names, values


def values_of(shape: Shape) -> Any:
    """`numbers_of`, the values alone: quickly also of many bodies."""
    if not isinstance(shape, Bulk):
        return np.array(numbers_of(shape, None)[1])
    parts = [np.ravel(getattr(shape, name)) for name in shape.columns]
    steps: list[float] = []

    def take(_: str, value: float) -> float:
        steps.append(value)
        return value

    map_motion(shape.motion, take, replace_unchecked, None)
    return np.concatenate([*parts, np.array(steps)])


def columns_of_leaf(shape: Bulk, leaf: int) -> tuple[str | float, ...]:
    """What the fields of one primitive of each body are of: columns, or constants."""
    leaves: Any = (("radii", "centers"),) if isinstance(shape, Spheres) else shape.leaves
    return tuple(leaves[leaf])


# `co.parameters`: the numbers of a scene's shapes as one flat vector with names, and scenes with other numbers.


@ignore_fp_errors
def parameters(scene: Any, only: str | Iterable[str] | None = None) -> Parameters:
    """The numbers of a scene's shapes: a flat vector with names, from which scenes with other numbers are made.

    scene: a `Scene`; of a model that was imported as copies moved there are none, as its bodies are made on demand.
    only: a name or several, or patterns such as "lens.*.radius": the parameters that there are to be, in the scene's
        order; None takes all.

    Raises TypeError for what is no scene, ValueError for a name or pattern that nothing has.
    """
    if not is_scene(scene):
        raise TypeError(f"parameters: scene must be a Scene, got {describe_kind(scene)}")
    found = Parameters(scene)
    return found if only is None else found.only(only)


@with_method_hints
class Parameters:
    """Numbers of a scene's shapes, in a fixed order. Immutable; arrays are read-only.

    values   float64 (parameters,): what they are
    names    their names: the body's name, or bodies[i], and the way to the number, as in "lens.operands[0].radii[2]"

    Every finite number that a shape was said by is one: of operands of Booleans and of the steps of motions too. What
    is said by other numbers is none: the radii of an ellipsoid that is given by coefficients, the angles of a whole
    turn without a reference.
    """

    def __init__(self, scene: SceneLike, chosen: Any = None, full: FloatArray | None = None) -> None:
        bodies = scene.bodies
        self._scene, self._bodies = scene, () if isinstance(bodies, InstanceList) else tuple(bodies)
        parts = [values_of(body.shape) for body in self._bodies]
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
            found += numbers_of(body.shape, f"{owner}.")[0]
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
            told = describe_names(str(name), "names", list(self.names))
            raise KeyError(f"parameters: there is no {format_value(name)}; {told}")
        return self._places[name]

    def only(self, names: str | Iterable[str]) -> Parameters:
        """Some of them, by `names` or patterns, in which * stands for any letters. Raises ValueError for others."""
        patterns = _patterns(names)
        own = self.names
        kept: set[int] = set()
        for pattern in patterns:
            found = [self._places[pattern]] if pattern in self._places else _matching(own, pattern)
            if not found:
                known = describe_names(str(pattern), "names", list(own))
                raise ValueError(f"parameters: only: nothing is called {format_value(pattern)}; {known}")
            kept.update(found)
        return Parameters(self._scene, self._chosen[sorted(kept)], self._full)

    def vector(self, values: Mapping[str, float]) -> FloatArray:
        """The vector with other `values` for some names: {"lens.radius": 2.5}. Raises KeyError for unknown ones."""
        vector = self.values.copy()
        for name, value in values.items():
            vector[self.index(name)] = value
        return vector

    @ignore_fp_errors
    def scene(self, vector: Any) -> SceneLike:
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
        return _replace_bodies(self._scene, bodies)

    def _fits(self, entries: Sequence[Body]) -> bool:
        """Have the shapes of other entries their numbers in the same places?"""
        if entries is self._scene.bodies:
            return True
        if isinstance(entries, InstanceList):
            return not len(self._bodies)
        counts = np.diff(self._firsts).tolist()
        return len(entries) == len(counts) and all(
            mine is body or mine.shape is body.shape
            or (type(mine.shape) is type(body.shape) and values_of(body.shape).size == count)
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
            raise TypeError(
                f"parameters: only must be a name or pattern, or a list of them, got {format_value(pattern)}"
            )
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

    return dataclasses.replace(body, shape=map_numbers(body.shape, take, replace_checked, None))


def _replace_bodies(scene: SceneLike, bodies: Sequence[Body]) -> SceneLike:
    """The scene with other bodies, as `scene.replace` makes it: it takes what is prepared, and prepares what is new."""
    from ...geometry.entries import Entries

    return scene._edited(Entries(bodies))
