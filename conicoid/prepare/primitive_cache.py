"""The numbers of primitives: their surfaces and uv maps, each computed once for all bodies that have it.

Cells of one universe meet at its surfaces, so that each surface bounds several bodies, and copies have primitives in
common. `PrimitiveCache` computes the numbers of single bodies from those of their primitives.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..geometry.cell import Cell
from ..geometry.shape import Shape
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.tables import Floats, Longs
from ..numerics.tracing import Tape, TracedFloat
from .assembly import Assembly
from .csg_plan import placed_primitives
from .lower_shape import BodyFaces, own_frame, surface_numbers, world_tree
from .polyhedron_extent import learn_bounds
from .pytree import flatten, unflatten
from .tape import recordings
from .tape.recordings import NO_INPUTS

_NumberLists: TypeAlias = tuple[list[float], list[float], tuple[int, ...]]
"""Numbers of surfaces and of uv maps, and the kinds of the surfaces."""
_PrimitiveRows: TypeAlias = tuple[tuple[int, tuple[int, ...]], Longs, Floats]
"""First number of uv and the kinds of the surfaces; which primitives; the numbers of their surfaces and uv maps."""


class PrimitiveCache:
    """Computes the numbers of bodies, and caches those of their primitives.

    Many primitives of one form are computed by tapes.
    """

    def __init__(self) -> None:
        self._cache: dict[Hashable, _NumberLists] = {}
        self._flat: dict[tuple[int, tuple[Step, ...]], tuple[Shape, _FlatPrimitive | None]] = {}

    def prepare(self, shapes: Iterable[Shape]) -> None:
        """Compute the primitives of solids whose numbers are needed next."""
        missing: dict[tuple[Any, ...], dict[Hashable, tuple[Shape, tuple[Step, ...], Floats]]] = {}
        for leaf, steps in (primitive for shape in shapes for primitive in placed_primitives(shape)):
            flat = self._flatten(leaf, steps)
            if flat is not None and flat.key not in self._cache:
                missing.setdefault(flat.forms, {})[flat.key] = leaf, steps, flat.numbers
        for forms, alike in missing.items():
            if len(alike) >= recordings.FEWEST:
                keys, leaves = list(alike), list(alike.values())
                numbers = np.array([each for _, _, each in leaves])
                # Those that the tape leaves undecided are not cached
                for (first_uv, kinds), which, rows in _play_primitives(forms, numbers, leaves.__getitem__):
                    for k, row in zip(which.tolist(), rows.tolist(), strict=True):
                        self._cache[keys[k]] = row[:first_uv], row[first_uv:], kinds

    def _flatten(self, leaf: Shape, steps: tuple[Step, ...]) -> _FlatPrimitive | None:
        """`flatten_primitive`, once for each object, which is held so that its id stays unique."""
        key = id(leaf), steps
        if key not in self._flat:
            self._flat[key] = leaf, flatten_primitive(leaf, steps)
        return self._flat[key][1]

    def numbers(self, shape: Shape) -> Floats:
        """Return a solid's row of numbers without its boxes: surfaces, uv of its faces, the inverse of its frame."""
        surfaces: list[float] = []
        uv: list[float] = []
        for leaf, steps in placed_primitives(shape):
            own = self.of(leaf, steps)
            surfaces += own[0]
            uv += own[1]
        return np.array([*surfaces, *uv, *(number for line in own_frame(shape).inverse_rows for number in line)])

    def of(self, leaf: Shape, steps: tuple[Step, ...]) -> _NumberLists:
        """Return (numbers of surfaces, of uv, kinds of surfaces) of a primitive that steps move."""
        flat = self._flatten(leaf, steps)
        if flat is None:
            return _compute_numbers(leaf, steps)
        if flat.key not in self._cache:
            self._cache[flat.key] = _compute_numbers(leaf, steps)
        return self._cache[flat.key]

    def rows(
        self, forms: tuple[Any, ...], numbers: Floats, primitive: Callable[[int], tuple[Any, ...]]
    ) -> list[_PrimitiveRows]:
        """Compute primitives of equal structure (n, numbers): a few different ones singly, many on tapes."""
        places: dict[bytes, list[int]] = {}
        for which, row in enumerate(numbers):
            places.setdefault(row.tobytes(), []).append(which)
        if len(places) >= recordings.FEWEST:
            return _play_primitives(forms, numbers, primitive)
        found = []
        for key, some in places.items():
            if (forms, key) not in self._cache:
                self.of(*primitive(some[0]))
            if (forms, key) in self._cache:
                surfaces, uv, kinds = self._cache[forms, key]
                found.append(((len(surfaces), kinds), np.array(some), np.tile([*surfaces, *uv], (len(some), 1))))
        return found


class _FlatPrimitive(NamedTuple):
    """A primitive and the steps that move it, flattened to a structure and a list of numbers."""

    forms: tuple[Any, ...]
    numbers: Floats
    key: Hashable
    """A key of structure and numbers, exact to the last bit."""


def flatten_primitive(leaf: Shape, steps: tuple[Step, ...]) -> _FlatPrimitive | None:
    """Flatten a primitive and its steps; None where they hold more than numbers."""
    forms: list[Hashable] = []
    numbers: list[float] = []
    for thing in (leaf, *steps):
        flat = flatten(thing)
        if flat is None:
            return None
        forms.append(flat.form)
        numbers += flat.numbers
    every, all_forms = np.array(numbers), tuple(forms)
    return _FlatPrimitive(all_forms, every, (all_forms, every.tobytes()))


def _play_primitives(
    forms: tuple[Any, ...], numbers: Floats, primitive: Callable[[int], tuple[Any, ...]]
) -> list[_PrimitiveRows]:
    """Compute primitives of equal structure (`_FlatPrimitive.forms`) from their numbers (n, numbers) on tapes.

    `primitive` builds one of them, with its steps. Those that the tapes leave undecided are in no item.
    """
    from ..geometry.polyhedron import Polyhedron  # here, since a start does not need it

    if forms[0][0] is Polyhedron and len(forms) == 1:
        return _play_polyhedra(numbers)

    def record(which: int, tape: Tape) -> tuple[int, tuple[int, ...]]:
        leaf, steps = primitive(which)[:2]
        flat = flatten_primitive(leaf, steps)
        if flat is None or flat.forms != forms or flat.numbers.tobytes() != numbers[which].tobytes():
            raise TypeError("the primitive has another structure than these numbers")
        traced = unflatten(leaf, tape)
        object.__setattr__(traced, "motion", Motion(tuple(unflatten(step, tape) for step in steps)))
        surfaces, uv, kinds = _primitive_numbers(traced)
        traced_numbers = [float(x.value if isinstance(x, TracedFloat) else x) for x in (*surfaces, *uv)]
        expected = _compute_numbers(leaf, steps)
        if not _same_bits(traced_numbers, [*expected[0], *expected[1]]) or kinds != expected[2]:
            raise TypeError("a traced primitive has other numbers than the primitive itself")
        for number in (*surfaces, *uv):
            tape.write(number)
        return len(surfaces), kinds

    rows = np.zeros(len(numbers), np.int32)
    found, _ = recordings.RECORDINGS.play(("alone", forms), record, numbers, NO_INPUTS, rows)
    return [(label, which, played.floats) for label, which, played in found]


def _play_polyhedra(numbers: Floats) -> list[_PrimitiveRows]:
    """`_play_primitives` for polyhedra of equally many faces, which are lowered as solids."""
    from ..geometry.polyhedron import Polyhedron

    count, own = len(numbers), numbers.shape[1] // 4
    planes = np.concatenate([numbers[:, : 3 * own].reshape(count, own, 3), numbers[:, 3 * own :, None]], axis=2)
    shapes = [
        Polyhedron(tuple((a, b, c) for a, b, c, _ in rows), tuple(row[3] for row in rows)) for rows in planes.tolist()
    ]
    learn_bounds(shapes, planes.reshape(count, -1))
    near = np.repeat(np.array([shape.near for shape in shapes]), own, axis=0)
    form = flatten_primitive(shapes[0]._face(0), ())
    assert form is not None
    parts = _play_primitives(
        form.forms,
        np.concatenate([planes.reshape(-1, 4), near], axis=1),
        lambda k: (shapes[k // own]._face(k % own), ()),
    )
    if len({(label, rows.shape[1]) for label, _, rows in parts}) != 1:
        return []
    (first_uv, kinds), _, some = parts[0]
    faces = np.full((count, own, some.shape[1]), np.nan)
    for _, which, rows in parts:
        faces[which // own, which % own] = rows
    whole = np.flatnonzero(~np.isnan(faces[:, :, 0]).any(axis=1))
    both = [part[whole].reshape(len(whole), -1) for part in np.split(faces, [first_uv], axis=2)]
    return [((first_uv * own, kinds * own), whole, np.concatenate(both, axis=1))]


def _compute_numbers(leaf: Shape, steps: tuple[Step, ...]) -> _NumberLists:
    """`PrimitiveCache.of` without the cache."""
    # An unmoved primitive may hold its planes already
    return _primitive_numbers(leaf._under_steps(steps))


def _primitive_numbers(leaf: Any) -> _NumberLists:
    """Compute (numbers of surfaces, of uv, kinds of surfaces) of a primitive, which may be traced."""
    assembly, faces = Assembly(), BodyFaces()
    tree = world_tree(leaf, IDENTITY_MOTION, faces)
    if isinstance(tree, Cell):
        assembly.cell(tree)
    else:
        assembly.program(tree, {})
    kinds = tuple(record.kind for record in assembly.surfaces)
    return surface_numbers(assembly), [number for numbers in faces.maps()[0] for number in numbers], kinds


def _same_bits(some: list[float], others: list[float]) -> bool:
    """Return whether numbers are equal to the last bit."""
    return np.array(some).tobytes() == np.array(others).tobytes()
