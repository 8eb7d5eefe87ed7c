"""`co.parameters`: the numbers of a scene's shapes as a flat vector with names, and scenes with other numbers.

One traversal, in one order, reads the numbers of a shape and rebuilds the shape with others. It visits the operands of
Booleans, the steps of motions, and the box that clips a shape. Parameters are finite floats: an infinite value, such as
the end of a range, is not a parameter.
"""

from __future__ import annotations

import dataclasses
import fnmatch
import math
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.text import describe_names
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
"""(name, value of a number) -> its replacement."""
Make: TypeAlias = Callable[[Any, dict[str, Any]], Any]
"""(shape or step, new values by field) -> shape or step with these values."""

Task: TypeAlias = Generator["Task", Any, Any]
"""A generator that yields the tasks whose results it needs, and returns its own result."""

_ANGLES = ("start_angle", "end_angle")
"""Fields that are no parameters for a whole turn without a reference."""


def map_numbers(shape: Any, take: Take, make: Make, path: str | None = "") -> Any:
    """Return a shape, or a motion, with every number replaced by `take`.

    `path` precedes the names; None makes no names.
    """
    if isinstance(shape, Motion):
        return map_motion(shape, take, make, path)
    return _run_task(_map_shape(shape, take, make, path))


def map_value(value: Any, take: Take, make: Make) -> Any:
    """Return the value of a field with every number replaced."""
    return _run_task(_map_value(value, take, make, None))


def _run_task(task: Task) -> Any:
    """Run a task and the tasks that it yields, on a stack of their own: nesting does not use Python's recursion."""
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
    """Append to a path; None stays None."""
    return None if path is None else path + more


def _map_shape(shape: Any, take: Take, make: Make, path: str | None) -> Task:
    """Map the fields of a shape in their order, and its motion last; unchanged shapes are returned as they are."""
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(shape):
        if not field.init or field.name == "motion" or is_derived(shape, field.name):
            continue
        old = getattr(shape, field.name)
        new = yield _map_value(old, take, make, _join_path(path, field.name))
        if new is not old:
            changes[field.name] = new
    # Identity tells whether a value changed: `take` returns the same object for an equal number.
    motion = map_motion(shape.motion, take, make, _join_path(path, "motion"))
    if motion is not shape.motion:
        changes["motion"] = motion
    return make(shape, changes) if changes else shape


def is_derived(shape: Any, name: str) -> bool:
    """Return whether other fields determine a field: radii next to coefficients, angles of a whole turn."""
    # The radii of an ellipsoid that is given by coefficients.
    if name == "radii" and getattr(shape, "coefficients", None) is not None:
        return True
    if isinstance(shape, Revolution) and name in _ANGLES:
        return bool(shape.end_angle - shape.start_angle >= 360)
    return name in _ANGLES and getattr(shape, "reference", 0) is None


def map_motion(motion: Motion, take: Take, make: Make, path: str | None) -> Motion:
    """Return the motion with every number of its steps replaced."""
    steps = tuple(
        _run_task(_map_step(step, take, make, _join_path(path, f"[{k}]."))) for k, step in enumerate(motion.steps)
    )
    return motion if all(new is old for new, old in zip(steps, motion.steps, strict=True)) else Motion(steps)


def _map_step(step: Any, take: Take, make: Make, path: str | None) -> Task:
    """Map the fields of a step; of a matrix only the first three rows, as the last one is fixed."""
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(step):
        old = getattr(step, field.name)
        if isinstance(step, Transform):
            # The last row of an affine matrix is fixed.
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
    """Map a float, an array, a shape, or a mapping or tuple of such; other values stay."""
    if isinstance(value, float):
        return take(path or "", value) if math.isfinite(value) else value
    if isinstance(value, np.ndarray):
        return _map_array(value, take, path)
    if isinstance(value, Shape):
        part_value = yield _map_shape(value, take, make, _join_path(path, "."))
        return part_value
    if isinstance(value, Mapping):
        new = {name: take(_join_path(path, f".{name}") or "", number) for name, number in value.items()}
        return value if all(new[name] is number for name, number in value.items()) else new
    if isinstance(value, tuple):
        parts = []
        for k, part in enumerate(value):
            part_value = yield _map_value(part, take, make, _join_path(path, f"[{k}]"))
            parts.append(part_value)
        return value if all(new is old for new, old in zip(parts, value, strict=True)) else tuple(parts)
    return value


def _map_array(values: Any, take: Take, path: str | None) -> Any:
    """Map a column of `Bulk` shapes: one number, or one row of numbers, for each body."""
    old = values.tolist()
    if values.ndim == 1:
        new = [take(_join_path(path, f"[{i}]") or "", x) for i, x in enumerate(old)]
    else:
        new = [[take(_join_path(path, f"[{i}][{k}]") or "", x) for k, x in enumerate(row)] for i, row in enumerate(old)]
    return values if new == old else np.array(new)


def replace_unchecked(thing: Any, changes: dict[str, Any]) -> Any:
    """Return a shape or step with other values of fields, without any check."""
    # The constructor would check and convert the values, and they may be duals.
    copy = object.__new__(type(thing))
    for field in dataclasses.fields(thing):
        object.__setattr__(copy, field.name, changes.get(field.name, getattr(thing, field.name)))
    return copy


def replace_checked(thing: Any, changes: dict[str, Any]) -> Any:
    """Return a shape with other values of fields, built by its constructor, whose errors it raises."""
    # Steps are not checked here: `_apply_motion` appends them anew, which checks them.
    if not isinstance(thing, Shape):
        return replace_unchecked(thing, changes)
    motion = changes.pop("motion", None)
    copy = dataclasses.replace(thing, **_constructor_arguments(thing, changes)) if changes else thing
    return copy if motion is None else _apply_motion(copy, motion)


def _constructor_arguments(thing: Any, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the fields that the constructor needs: radii derived from old coefficients are reset to the default."""
    if "coefficients" in changes and isinstance(thing, Ellipsoid):
        return {"radii": Ellipsoid.radii, **changes}
    return changes


def _apply_motion(shape: Shape, motion: Motion) -> Shape:
    """Return the shape with a motion that is rebuilt step by step, so that every step is checked."""
    checked = IDENTITY_MOTION
    for step in motion.steps:
        checked = _append_step(checked, step)
    result: Shape = dataclasses.replace(shape, motion=checked)
    checked.check(type(shape).__name__)
    return result


def _append_step(motion: Motion, step: Step) -> Motion:
    """Append a step through the public method of its kind."""
    if isinstance(step, Translate):
        return motion.translate(step.offset)
    if isinstance(step, Rotate):
        return motion.rotate(step.axis, step.degrees)
    if isinstance(step, Scale):
        return motion.scale(step.factors)
    return motion.transform(step.matrix) if isinstance(step, Transform) else motion.then(Motion((step,)))


def numbers_of(shape: Any, path: str | None = "") -> tuple[list[str], list[float]]:
    """Return the names and the values of all numbers of a shape or a motion."""
    names: list[str] = []
    values: list[float] = []

    def take(name: str, value: float) -> float:
        names.append(name)
        values.append(value)
        return value

    map_numbers(shape, take, replace_unchecked, path)
    return names, values


def values_of(shape: Shape) -> Any:
    """Return the values of `numbers_of` alone; fast for `Bulk` shapes too, whose columns are copied whole."""
    if not isinstance(shape, Bulk):
        return np.array(numbers_of(shape, None)[1])
    # The order is that of `numbers_of`: the columns, then the motion.
    parts = [np.ravel(getattr(shape, name)) for name in shape.columns]
    steps: list[float] = []

    def take(_: str, value: float) -> float:
        steps.append(value)
        return value

    map_motion(shape.motion, take, replace_unchecked, None)
    return np.concatenate([*parts, np.array(steps)])


def columns_of_leaf(shape: Bulk, leaf: int) -> tuple[str | float, ...]:
    """Return the source of each field of one leaf of a `Bulk` shape: the name of a column, or a constant."""
    leaves: Any = (("radii", "centers"),) if isinstance(shape, Spheres) else shape.leaves
    return tuple(leaves[leaf])


# --- The vector of a scene


@ignore_fp_errors
def parameters(scene: SceneLike, names: str | Iterable[str] | None = None) -> Parameters:
    """Return the numbers of a scene's shapes as a flat vector with names, from which edited scenes are made.

    Parameters
    ----------
    scene : Scene
        A model that was imported as moved copies has no parameters, since its bodies are made on demand.
    names : str or iterable of str, optional
        Names, or patterns such as "lens.*.radius", of the parameters to select. They keep the order of the scene. None
        selects all.

    Returns
    -------
    derivatives.Parameters

    Raises
    ------
    TypeError
        For an object that is not a scene.
    ValueError
        For a name or pattern that fits no parameter.
    """
    if not is_scene(scene):
        raise TypeError(f"parameters: scene must be a Scene, got {describe_kind(scene)}")
    every = Parameters(scene)
    return every if names is None else every.select(names)


class Parameters:
    """Numbers of a scene's shapes, in a fixed order. Immutable; arrays are read-only.

    Every finite number that defines a shape is a parameter, also in the operands of Booleans and the steps of motions.
    Derived numbers are not: the radii of an ellipsoid that is given by coefficients, and the angles of a whole turn
    without a reference.

    Attributes
    ----------
    values : float64 (parameters,)
        Their values.
    names : tuple of str
        The body's name, or bodies[i], and the path to the number, as in "lens.operands[0].radii[2]".
    """

    def __init__(self, scene: SceneLike, chosen: Any = None, full: FloatArray | None = None) -> None:
        bodies = scene.bodies
        self._scene, self._bodies = scene, () if isinstance(bodies, InstanceList) else tuple(bodies)
        parts = [values_of(body.shape) for body in self._bodies]
        # The index of the first number of each entry, and last the count of all.
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
        """The names of all numbers of the scene, selected or not."""
        names: list[str] = []
        for number, body in enumerate(self._bodies):
            owner = body.name if body.name is not None else f"bodies[{number}]"
            names += numbers_of(body.shape, f"{owner}.")[0]
        return names

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.names)}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Parameters):
            return NotImplemented
        own, others = ((one._scene, one._chosen.tolist(), one._full.tolist()) for one in (self, other))
        return own == others

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self._chosen)

    def __getitem__(self, name: str) -> float:
        """Return the value of a parameter by name. Raise KeyError for an unknown name."""
        return float(self.values[self.index(name)])

    def index(self, name: str) -> int:
        """Return the index of a parameter in the vector.

        Parameters
        ----------
        name : str
            One of `names`.

        Raises
        ------
        KeyError
            For an unknown name.
        """
        if not isinstance(name, str) or name not in self._places:
            hint = describe_names(str(name), "names", list(self.names))
            raise KeyError(f"parameters: there is no {format_value(name)}; {hint}")
        return self._places[name]

    def select(self, names: str | Iterable[str]) -> Parameters:
        """Return a selection of the parameters, in the order of the scene.

        Parameters
        ----------
        names : str or iterable of str
            Names, or patterns in which * stands for any characters.

        Raises
        ------
        TypeError
            For names that are not strings.
        ValueError
            For a name or pattern that fits no parameter.
        """
        patterns = _patterns(names)
        own = self.names
        indices: set[int] = set()
        for pattern in patterns:
            places = [self._places[pattern]] if pattern in self._places else _matching(own, pattern)
            if not places:
                hint = describe_names(str(pattern), "names", list(own))
                raise ValueError(f"parameters: names: nothing is called {format_value(pattern)}; {hint}")
            indices.update(places)
        return Parameters(self._scene, self._chosen[sorted(indices)], self._full)

    def vector(self, values: Mapping[str, float]) -> FloatArray:
        """Return the vector of values with some of them replaced.

        Parameters
        ----------
        values : mapping of str to float
            New values by name: {"lens.radius": 2.5}.

        Raises
        ------
        KeyError
            For an unknown name.
        """
        vector = self.values.copy()
        for name, value in values.items():
            vector[self.index(name)] = value
        return vector

    @ignore_fp_errors
    def scene(self, vector: npt.ArrayLike) -> SceneLike:
        """Return the scene with other numbers. Unchanged shapes are shared, so only changed ones are prepared anew.

        Parameters
        ----------
        vector : array_like (parameters,)
            The new values.

        Raises
        ------
        ValueError
            For a vector of another length, and for values that a shape refuses.
        """
        full = self._filled(real_array("parameters.scene", "vector", vector, "numbers (parameters,)"))
        changed = np.flatnonzero(full != self._full)
        if not len(changed):
            return self._scene
        bodies: list[Body] = list(self._bodies)
        # Only entries with a changed number are rebuilt.
        for entry in np.unique(np.searchsorted(self._firsts, changed, side="right") - 1).tolist():
            part = full[self._firsts[entry] : self._firsts[entry + 1]]
            bodies[entry] = _with_numbers(bodies[entry], part)
        return _replace_bodies(self._scene, bodies)

    def _fits(self, entries: Sequence[Body]) -> bool:
        """Return whether other entries have the same kinds of shapes with as many numbers each."""
        if entries is self._scene.bodies:
            return True
        if isinstance(entries, InstanceList):
            return not len(self._bodies)
        # Counts of numbers are compared last: equal bodies and equal shapes are quicker to recognise.
        counts = np.diff(self._firsts).tolist()
        return len(entries) == len(counts) and all(
            mine is body or mine.shape is body.shape
            or (type(mine.shape) is type(body.shape) and values_of(body.shape).size == count)
            for mine, body, count in zip(self._bodies, entries, counts, strict=True)
        )  # fmt: skip

    def _filled(self, vector: FloatArray) -> FloatArray:
        """Return all numbers, with those of `vector` for the selected ones."""
        if vector.shape != (len(self),):
            raise ValueError(f"parameters.scene: vector must have shape ({len(self)},), got {vector.shape}")
        full = self._full.copy()
        full[self._chosen] = vector
        return full

    def _spread(self, tangent: FloatArray) -> FloatArray:
        """Return a tangent of all numbers from one of the selected ones; the others do not change."""
        full = np.zeros(len(self._full))
        full[self._chosen] = tangent
        return full

    def __repr__(self) -> str:
        few = ", ".join(f"{name}={value:.6g}" for name, value in zip(self.names[:4], self.values[:4], strict=True))
        more = f", ... {len(self) - 4} more" if len(self) > 4 else ""
        return f"Parameters({few}{more})"


def _patterns(names: Any) -> list[str]:
    """Return names or patterns as a list. Raise TypeError for anything but strings."""
    patterns = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else [names]
    for pattern in patterns:
        if not isinstance(pattern, str):
            raise TypeError(
                f"parameters: names must be a name or pattern, or a list of them, got {format_value(pattern)}"
            )
    return patterns


def _matching(names: Sequence[str], pattern: str) -> list[int]:
    """Return the indices of the names that a pattern fits; brackets stand for themselves."""
    # fnmatch reads [...] as a set of characters; [[] stands for the bracket itself.
    plain = pattern.replace("[", "[[]")
    return [place for place, name in enumerate(names) if fnmatch.fnmatchcase(name, plain)]


def _with_numbers(body: Body, numbers: FloatArray) -> Body:
    """Return the body with other numbers in its shape."""
    rest = iter(numbers.tolist())

    def take(_: str, old: float) -> float:
        new = float(next(rest))
        return old if new == old else new  # the same object, so that unchanged parts are recognised

    return dataclasses.replace(body, shape=map_numbers(body.shape, take, replace_checked, None))


def _replace_bodies(scene: SceneLike, bodies: Sequence[Body]) -> SceneLike:
    """Return the scene with other bodies, as `scene.replace` does: prepared entries are kept, new ones prepared."""
    from ...geometry.entries import Entries

    return scene._edited(Entries(bodies))
