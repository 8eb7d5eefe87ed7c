"""Batch lowering: record the lowering of one primitive on a tape, and play it for all primitives of equal structure.

Shapes are alike if their types and the structure of their fields agree (as many numbers, or none), whatever their
motions. Each kind has a few recordings, because comparisons of numbers turn out one way or the other. What they cannot
decide is left to `lower_shape`: numbers that four floats leave open, kinds that inspect their numbers in untraceable
ways, and kinds with too few shapes.

A Boolean body passes through these files, in this order:

1. `body_collector.py` hands each body to `BatchLowering` here.
2. `csg_plan.py` splits it into its primitives and the plan by which they are combined.
3. `motion_batch.py` computes the motions of the primitives, each once.
4. `tape/recording_cache.py` finds or records the formulas of their kind; `tape/program.py` plays them for all at once.
   Supports that no tape can hold are computed by the shapes, in between.
5. `csg_batch.py` composes the rows of the primitives to the row of the body.
6. `csg_plan.py` finds its box, by `region_extent.py` where the boxes of the parts are not enough. Polyhedra have
   theirs from `polyhedron_extent.py`.
7. `tables_builder.py` lays out the rows (`pattern.py`) as columns; `coincidence.py` merges equal surfaces.

`lower_shape.py` does 2 to 6 for a single body, in 3000 bits.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from .._util.arrays import unique_first_with_inverse, unique_sorted, unique_with_inverse
from ..geometry.bulk import Bulk
from ..geometry.cell import Cell, Face
from ..geometry.shape import Boolean, Painted, Primitive, Shape, region_bounds
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.tables import CELL, MAP_SIZE, PLANE, PLANE_SIZE, Floats, Ints, Longs, Signs
from ..materials.material import Material
from ..numerics.tracing import Tape, TracedFloat
from .assembly import Assembly, SurfaceSlot
from .csg_batch import CsgArray, CsgBatch, CsgComposition, exceeds_translation
from .csg_plan import FORMS, CsgPlan, PrimitiveForm, bound_bodies, box_columns, csg_plan, is_subclass, placed_primitives
from .lower_shape import LoweredShape, compute_shape, lower_shape
from .motion_batch import MotionBatch, MotionChains, count_translations, input_motion
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable
from .polyhedron_extent import learn_bounds, polyhedron_boxes
from .pytree import flatten, flatten_all, positions_by_key, unflatten
from .tape import recording_cache
from .tape.program import NO_INPUTS

if TYPE_CHECKING:
    from ..geometry.polyhedron import Polyhedron


class ShapeBatch(Protocol):
    """Shapes of equal structure, with their parameters."""

    def __len__(self) -> int: ...

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """Return one of the shapes, and the steps that move it."""
        ...

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """Return the parameters (n, numbers), and for each shape its motion and its place."""
        ...


@dataclass
class _ShapeList:
    """Shapes of single bodies, and of parts of Boolean ones, added block by block."""

    shapes: list[Shape] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)
    numbers: list[Floats] = field(default_factory=list)
    motions: list[Ints] = field(default_factory=list)
    places: list[Ints] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.shapes)

    def add(self, shapes: Sequence[Shape], steps: list[tuple[Step, ...]], which: Longs, places: Ints) -> None:
        """Add some of these shapes, with the steps of each."""
        self.shapes += [shapes[k] for k in which.tolist()]
        self.steps += steps
        self.places.append(places[which])

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`ShapeBatch.of`"""
        return self.shapes[index], self.steps[index]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`ShapeBatch.columns`"""
        return np.concatenate(self.numbers), np.concatenate(self.motions), np.concatenate(self.places)


@dataclass
class _ShapeArray:
    """One primitive of each of the many bodies of a bulk entry."""

    shape: Bulk
    leaf: int
    steps: tuple[Step, ...]
    numbers: Floats
    motion: int
    places: Ints

    def __len__(self) -> int:
        return len(self.places)

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`ShapeBatch.of`"""
        return placed_primitives(self.shape.single(index))[self.leaf]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`ShapeBatch.columns`"""
        return self.numbers, np.full(len(self), self.motion, np.int32), self.places


@dataclass
class _Polyhedra:
    """Polyhedra of equally many faces, added block by block: their faces are lowered as shapes."""

    shapes: list[Polyhedron] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)
    motions: list[Ints] = field(default_factory=list)
    places: list[Ints] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.shapes) * self.faces

    @property
    def faces(self) -> int:
        """How many faces each has."""
        return self.shapes[0]._face_count

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`ShapeBatch.of`"""
        which, face = divmod(index, self.faces)
        return self.shapes[which]._face(face), self.steps[which]

    @cached_property
    def planes(self) -> Floats:
        """(n, 4 faces) normals and offsets."""
        normals = np.array([shape.normals for shape in self.shapes])
        offsets = np.array([shape.offsets for shape in self.shapes])
        return np.concatenate([normals, offsets[:, :, None]], axis=2).reshape(len(normals), -1)

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`ShapeBatch.columns`"""
        learn_bounds(self.shapes, self.planes)
        motions, places = np.concatenate(self.motions), np.concatenate(self.places)
        common = [np.array([shape.near for shape in self.shapes])]
        if count_translations(self.steps[0]) > 0:
            common.append(np.array([[x for step in steps for x in step.offset] for steps in self.steps]))  # type: ignore[union-attr]
        numbers = [self.planes.reshape(-1, 4), *(np.repeat(each, self.faces, axis=0) for each in common)]
        return np.concatenate(numbers, axis=1), np.repeat(motions, self.faces), places


@dataclass
class _BatchInputs:
    """Some shapes of equal structure: which ones, their parameters, the numbers of motions, and the motion of each."""

    like: ShapeBatch
    chosen: Longs
    numbers: Floats
    motions_given: Floats
    motions: Ints


PrimitiveRows: TypeAlias = tuple[PrimitiveForm, Ints, RowTable]
"""Primitives of one form, with a place and a row each."""
_LeftPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...], int]
"""A primitive that is not lowered, the steps that move it, and its place."""


class PrimitiveBatch:
    """Primitives to be lowered together; each has a place in a common numbering."""

    def __init__(self) -> None:
        self._motions = MotionBatch()
        self.frames = np.zeros((0, FRAME_NUMBERS))
        """(motions, 12) the inverse of each motion that `frame` numbered; NaN where it is not known."""
        self._like: dict[Hashable, _ShapeList] = {}
        self._many: list[tuple[Hashable, _ShapeArray]] = []
        self._polyhedra: dict[tuple[int, Hashable], _Polyhedra] = {}

    def add_many(self, shape: Bulk, places: Ints) -> None:
        """Add the primitives of the bodies of a bulk entry; places (bodies, primitives)."""
        for leaf, (primitive, steps) in enumerate(placed_primitives(shape.single(0))):
            flat = flatten(primitive)
            assert flat is not None
            numbers = shape.numbers(leaf)
            key, more, row = self._motion(flat.form, steps, len(shape))
            if more:
                numbers = np.concatenate([numbers, np.tile(np.array(more), (len(numbers), 1))], axis=1)
            self._many.append(
                (key, _ShapeArray(shape, leaf, steps, numbers, row, np.ascontiguousarray(places[:, leaf])))
            )

    def _motion(self, form: Hashable, steps: tuple[Step, ...], uses: int = 1) -> tuple[Hashable, list[float], int]:
        """Return (key of equal structure, numbers of the steps where the recording reads them, number of the motion).

        Translations are recorded with their offsets as inputs; any other motion is an input itself.
        """
        if count_translations(steps) >= 0:
            return (form, len(steps)), [x for step in steps for x in step.offset], 0  # type: ignore[union-attr]
        return (form, "moved"), [], self._motions.row(steps, uses)

    def add(self, shapes: Sequence[Shape], chains: MotionChains, places: Ints) -> Longs:
        """Add shapes, each moved by steps and for a place.

        Return the positions of those that must be lowered singly.
        """
        counts_of_faces = np.array([shape._face_count for shape in shapes])
        in_batch = counts_of_faces > 0
        if in_batch.any():
            self._add_polyhedra(shapes, counts_of_faces, chains, places)
        others = np.flatnonzero(~in_batch)
        for group in flatten_all([shapes[k] for k in others.tolist()] if len(others) < len(shapes) else shapes):
            group = dataclasses.replace(group, which=others[group.which])
            in_batch[group.which] = True
            counts = chains.translations[group.which]
            for count in sorted(set(counts.tolist())):
                some = np.flatnonzero(counts == count)
                which = group.which[some]
                like = self._like.setdefault((group.form, "moved" if count < 0 else count), _ShapeList())
                like.add(shapes, [chains.steps[k] for k in which.tolist()], which, places)
                numbers, motions = group.numbers[some], np.zeros(len(which), np.int32)
                if count < 0:
                    motions = self._motions.rows(chains, which)
                elif count:
                    offsets = [step.offset for steps in like.steps[-len(which) :] for step in steps]  # type: ignore[union-attr]
                    numbers = np.concatenate([numbers, np.array(offsets).reshape(len(which), -1)], axis=1)
                like.numbers.append(numbers)
                like.motions.append(motions)
        return np.flatnonzero(~in_batch)

    def _add_polyhedra(self, shapes: Sequence[Any], counts: Longs, chains: MotionChains, places: Ints) -> None:
        """Add polyhedra, whose faces are lowered together."""
        from ..geometry.polyhedron import PolyhedronFace

        flat = flatten(PolyhedronFace((1.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)))
        assert flat is not None
        codes = counts * (2 + int(chains.translations.max())) + chains.translations  # translations are -1 or more
        for code in unique_sorted(codes[counts > 0]).tolist():
            which = np.flatnonzero(codes == code)
            some, count = which.tolist(), int(chains.translations[which[0]])
            key = int(counts[which[0]]), (flat.form, "moved" if count < 0 else count)
            like = self._polyhedra.setdefault(key, _Polyhedra())
            like.shapes += [shapes[k] for k in some]
            like.steps += [chains.steps[k] for k in some]
            like.places.append(places[which])
            like.motions.append(self._motions.rows(chains, which) if count < 0 else np.zeros(len(which), np.int32))

    def frames_of(self, chains: MotionChains) -> Ints:
        """`frame` of many chains of steps; -1 for chains of at most one translation."""
        more = np.flatnonzero((chains.translations < 0) | (chains.translations > 1))
        found = np.full(len(chains.steps), -1, np.int32)
        found[more] = self._motions.rows(chains, more)
        return found

    def frame(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """Number the motion of these steps in `frames`; to be called before the primitives are lowered."""
        return self._motions.row(steps, uses)

    @property
    def places_of_polyhedra(self) -> set[int]:
        """The places of polyhedra of many faces."""
        if not self._polyhedra:
            return set()
        from ..geometry.polyhedron import MANY_FACES

        many = (like for like in self._polyhedra.values() if like.faces >= MANY_FACES)
        return {place for like in many for places in like.places for place in places.tolist()}

    @property
    def kinds(self) -> int:
        """How many kinds of equal structure were added."""
        return len(self._like) + len(self._many) + len(self._polyhedra)

    def lower(self, report: Callable[[int], Any] = lambda _: None) -> tuple[list[PrimitiveRows], list[_LeftPrimitive]]:
        """Lower all primitives; `report` receives the count of kinds done.

        Return those lowered together, and those that are left.
        """
        motions_given, similar, self.frames = self._motions.compute()
        results: list[PrimitiveRows] = []
        left: list[_LeftPrimitive] = []
        every: list[tuple[Hashable, ShapeBatch]] = [*self._like.items(), *self._many]
        for done, (key, like) in enumerate(every):
            report(done)
            numbers, motions, places = like.columns()
            for kind, rows_of_kind in _split_by_motion(key, motions, similar):
                given = _BatchInputs(like, rows_of_kind, numbers[rows_of_kind], motions_given, motions[rows_of_kind])
                found, rest = self._lower_kind(key, kind, given)
                results += [(form, places[rows_of_kind[which]], rows) for form, which, rows in found]
                left += [(*like.of(i), int(places[i])) for i in rows_of_kind[rest].tolist()]
        for done, ((_, key), polyhedra) in enumerate(self._polyhedra.items(), start=len(every)):
            from ..geometry.polyhedron import MANY_FACES

            report(done)
            if len(polyhedra) >= MANY_FACES:
                results.append(self._lower_polyhedra(key, polyhedra, motions_given, similar))
                continue
            of_places = np.concatenate(polyhedra.places).tolist()
            left += zip(polyhedra.shapes, polyhedra.steps, of_places, strict=True)
        return results, left

    def _lower_polyhedra(self, key: Hashable, of: _Polyhedra, given: Floats, similar: Signs) -> PrimitiveRows:
        """Return the rows of polyhedra, from the rows of their faces: each computed apart if it is of a rare kind."""
        numbers, motions, places = of.columns()
        faces = np.empty((len(of), _FACE_NUMBERS))
        for kind, some in _split_by_motion(key, motions, similar):
            found, rest = self._lower_kind(key, kind, _BatchInputs(of, some, numbers[some], given, motions[some]))
            for _, which, rows in found:
                faces[some[which]] = rows[:, :_FACE_NUMBERS]
            for i in some[rest].tolist():
                shape, steps = of.of(i)
                faces[i] = compute_shape(shape._under_steps(steps)).row[:_FACE_NUMBERS]
        count, own = len(of.shapes), motions[:: of.faces]
        frames = np.tile(np.eye(3, 4).ravel(), (count, 1))
        forward, translations = None, count_translations(of.steps[0])
        if translations < 0:
            frames = self.frames[own]
            forward = given[own, :FRAME_NUMBERS].reshape(count, -1)
        elif translations == 1:
            frames[:, 3::4] = -numbers[:: of.faces, -3:]
        for row in range(count) if translations > 1 else np.flatnonzero(np.isnan(frames[:, 0])).tolist():
            frames[row] = np.ravel(Motion(of.steps[row]).inverse_rows)
        parts = [
            faces[:, :_PLANE_NUMBERS].reshape(count, -1), faces[:, _PLANE_NUMBERS:].reshape(count, -1),
            polyhedron_boxes(of.shapes, of.steps, of.planes, forward), frames,
        ]  # fmt: skip
        form = _polyhedron_form(of.faces)
        whole = np.concatenate(parts, axis=1)
        return form, places, RowTable.of(whole, np.arange(whole.shape[1], dtype=np.int32))

    def _lower_kind(
        self, key: Hashable, similar: bool | None, of: _BatchInputs
    ) -> tuple[list[tuple[PrimitiveForm, Longs, RowTable]], Longs]:
        """`lower` for some shapes of equal structure, by their positions among them; and the positions that are left.

        `similar` says whether their motions are similarities; where that is None, all are left.
        """
        every = np.arange(len(of.chosen))
        if similar is None:
            return [], every
        if not of.like.of(int(of.chosen[0]))[0]._support_is_apart:  # type: ignore[attr-defined]
            return self._play_kind(key, similar, of, every, np.zeros((len(every), 0)))
        reaches, which, left = self._reaches(key, similar, of)
        results = []
        for some in positions_by_key(list(map(tuple, np.where(np.isfinite(reaches), 0.0, reaches).tolist()))).values():
            found, rest = self._play_kind(key, similar, of, which[some], reaches[some])
            results += found
            left = np.concatenate([left, rest])
        return results, left

    def _reaches(self, key: Hashable, similar: bool, of: _BatchInputs) -> tuple[Floats, Longs, Longs]:
        """Return the supports that give the boxes of shapes (n, 6), the positions of these shapes, and those left.

        One recording gives the directions, the shapes themselves their supports, and another recording all numbers.
        """

        def record(row: int, tape: Tape) -> None:
            shape, steps = of.like.of(int(of.chosen[row]))
            traced = _trace_shape(shape, steps, tape, _is_moved(key), similar)

            def write(direction: Any) -> float:
                for number in direction:
                    tape.write(number)
                return 1.0

            object.__setattr__(traced, "support", write)
            traced.ends(traced.under())

        given = self._given(key, of)
        results, left = recording_cache.RECORDINGS.play(
            ("directions", key, similar), record, of.numbers, given, of.motions
        )
        reaches, places = [np.zeros((0, BOX_NUMBERS))], [np.zeros(0, np.int64)]
        for _, which, played in results:
            shapes = [of.like.of(number)[0] for number in of.chosen[which].tolist()]
            reaches.append(type(shapes[0])._supports(shapes, played.floats.reshape(-1, BOX_NUMBERS, 3)))  # type: ignore[attr-defined]
            places.append(which)
        return np.concatenate(reaches), np.concatenate(places), left

    def _given(self, key: Hashable, of: _BatchInputs) -> Floats:
        """Return the numbers of the motions where the recordings of a kind read them."""
        return of.motions_given if _is_moved(key) else NO_INPUTS

    def _play_kind(
        self, key: Hashable, similar: bool, of: _BatchInputs, some: Longs, reaches: Floats
    ) -> tuple[list[tuple[PrimitiveForm, Longs, RowTable]], Longs]:
        """`_lower_kind` for some of the shapes; `reaches` (n, 6) are their supports where these are computed apart.

        The same supports are infinite for all of them.
        """

        def record(row: int, tape: Tape) -> tuple[PrimitiveForm, Ints]:
            shape, steps = of.like.of(int(of.chosen[some[row]]))
            traced = _trace_shape(shape, steps, tape, _is_moved(key), similar)
            if reaches.shape[1]:
                ends = itertools.cycle([tape.input(x) if math.isfinite(x) else x for x in reaches[row].tolist()])
                object.__setattr__(traced, "support", lambda _: next(ends))
            part = compute_shape(traced)
            expected = compute_shape(shape._under_steps(steps))
            if part.pattern != expected.pattern or list(map(_float_key, part.row)) != list(
                map(_float_key, expected.row)
            ):
                raise TypeError("a traced shape has another pattern or other numbers than the shape itself")
            return FORMS.of(part.pattern, part.tree), _write_row(part, tape)

        is_finite: Any = np.isfinite(reaches).all(axis=0)
        endless = tuple(reaches[0, ~is_finite].tolist()), tuple(is_finite.tolist())
        found, left = recording_cache.RECORDINGS.play(
            (key, similar, endless), record, np.concatenate([of.numbers[some], reaches[:, is_finite]], axis=1),
            self._given(key, of), of.motions[some],
        )  # fmt: skip
        return [
            (form, some[which], RowTable.of(played.floats, columns)) for (form, columns), which, played in found
        ], some[left]


def _is_moved(key: Hashable) -> bool:
    """Return whether shapes of a kind have motions other than translations."""
    return isinstance(key, tuple) and key[1] == "moved"


_PLANE_NUMBERS = 2 * PLANE_SIZE + 1
"""The record of a plane, its remainders, and its sense."""
_FACE_NUMBERS = _PLANE_NUMBERS + 2 * MAP_SIZE


@lru_cache(maxsize=8)
def _polyhedron_form(count: int) -> PrimitiveForm:
    """Return the form of a polyhedron of so many faces, each with a map of two rows of its own."""
    assembly = Assembly([SurfaceSlot(PLANE, 0, i) for i in range(count)])
    assembly.cells, assembly.cell_planes = [(-1, 1, -1)], [count]
    assembly.planes = [(i, 1, i) for i in range(count)]
    maps = [(2 * i, 2 * i + 1, 2 * i) for i in range(count)]
    pattern = BodyPattern.of(assembly, CELL, 0, [False] * count, maps)
    return FORMS.of(pattern, Cell(tuple(Face(i, i) for i in range(count))))  # type: ignore[arg-type]


def _write_row(part: LoweredShape, tape: Tape) -> Ints:
    """Make a tape write each number of a row once; return which of the written numbers is in each column."""
    places: dict[int, int] = {}
    columns = [places.setdefault(tape.plain_of(number).register, len(places)) for number in part.row]
    tape.written += places
    return np.array(columns, np.int32)


def _float_key(number: Any) -> str:
    """Return a float, traced or not, in full precision."""
    return float(number.value if isinstance(number, TracedFloat) else number).hex()


def _split_by_motion(key: Hashable, motions: Ints, similar: Signs) -> list[tuple[bool | None, Longs]]:
    """Split shapes by their motions: similarities (True), other maps (False), and undecided ones (None)."""
    if not _is_moved(key):
        return [(True, np.arange(len(motions)))]
    kinds = similar[motions]
    chosen = ((kind, np.flatnonzero(kinds == number)) for kind, number in ((True, 1), (False, 0), (None, -1)))
    return [(kind, which) for kind, which in chosen if len(which)]


def _trace_shape(shape: Shape, steps: tuple[Step, ...], tape: Tape, moved: bool, similar: bool) -> Any:
    """Return a shape whose numbers are those of a tape."""
    traced = unflatten(shape, tape)
    if not moved:
        motion = Motion(tuple(unflatten(step, tape) for step in steps)) if steps else IDENTITY_MOTION
    else:
        motion = input_motion(tape, similar, Motion(steps))
    object.__setattr__(traced, "motion", motion)
    return traced


# Batches of bodies: primitives as they are recorded, and Boolean bodies composed of theirs

LoweredGroup = tuple[BodyPattern, Ints, RowTable]
ProgressCallback = Callable[[int, int], Any]
_AT_ONCE = 8192
"""Where there are many primitives, single or in Boolean bodies, so many are lowered at a time."""
_FEWEST_OF_PLAN = 4
"""Fewer bodies of a plan are lowered one by one where a recording cannot lower all of their primitives."""
_MANY_LEAVES = 16
"""A plan with so many primitives, in all of its bodies, is composed however few the bodies are."""


@dataclass
class _RowLocations:
    """Where the row of each place is: in which table of rows, and at which row of it."""

    forms: list[PrimitiveForm]
    rows: list[RowTable]
    number: Ints  # the table of each place; -1 for none
    row: Ints

    def of(self, places: Ints) -> RowTable:
        """Return the rows of places that have one form."""
        numbers, row = self.number[places], self.row[places]
        rows = self.rows[numbers[0]]
        if (numbers == numbers[0]).all():
            every = len(row) == len(rows) and (row == np.arange(len(row), dtype=np.int32)).all()
            return rows if every else rows[row]
        width = self.forms[numbers[0]].pattern.width
        found = np.empty((len(places), width))
        for number in unique_sorted(numbers).tolist():
            mine = numbers == number
            found[mine] = self.rows[number][row[mine], :]
        return RowTable.of(found, np.arange(width, dtype=np.int32))


class BatchLowering:
    """Collects bodies, and lowers those that can be lowered together."""

    def __init__(self) -> None:
        self._primitives = PrimitiveBatch()
        self._owners: list[Ints] = []  # for each place the number of its body, -1 for a part of one
        self._places = 0
        self._single: tuple[list[Shape], list[int]] = [], []  # shapes and numbers
        self._templates: dict[Hashable, tuple[Sequence[Shape], CsgPlan | None]] = {}
        self._plans: dict[Hashable, CsgBatch] = {}
        self._many: list[CsgArray] = []
        self._left: list[_LeftPrimitive] = []  # primitives of Boolean bodies that have more than numbers
        self.paints: dict[int, dict[int, Material]] = {}

    def add(self, shape: Shape, number: int) -> bool:
        """Add a body under a number; return False where it must be lowered singly."""
        kind = type(shape)
        if is_subclass(kind, Boolean):
            return self._add_planned(shape, number)  # type: ignore[arg-type]
        if not is_subclass(kind, Primitive):
            return False
        shapes, numbers = self._single
        shapes.append(shape)
        numbers.append(number)
        return True

    def _reserve(self, owners: Ints) -> Ints:
        """Reserve the next places for these bodies."""
        first = self._places
        self._places += len(owners)
        self._owners.append(owners)
        return np.arange(first, self._places, dtype=np.int32)

    def add_many(self, shape: Bulk, number: int) -> None:
        """Add the bodies of a bulk entry, numbered from `number` on."""
        if not len(shape):
            return
        leaves = len(shape.leaves)
        if leaves == 1:
            owners = np.arange(number, number + len(shape), dtype=np.int32)
        else:
            owners = np.full(len(shape) * leaves, -1, np.int32)
            self._many.append(CsgArray(shape, number, self._places, self._frame_of(shape.motion, len(shape))))
        self._primitives.add_many(shape, self._reserve(owners).reshape(-1, leaves))

    def _frame_of(self, motion: Motion, uses: int = 1) -> int:
        """Return the number by which `PrimitiveBatch.frames` knows a motion.

        -1 for a translation, which needs no lookup.
        """
        return self._primitives.frame(motion.steps, uses) if exceeds_translation(motion) else -1

    def _add_planned(self, shape: Boolean, number: int) -> bool:
        # Copies of a Boolean shape share their operands: the plan is built once for each combination of these.
        key = type(shape), *map(id, shape.operands), id(shape.material) if isinstance(shape, Painted) else None
        found = self._templates.get(key)
        if found is None:
            # The tuple keeps the operands alive, and with them their ids
            found = self._templates[key] = (shape,), csg_plan(shape, still=True)
        plan = found[1]
        if plan is None:
            return False
        like = self._plans.get(plan.key)
        if like is None:
            like = self._plans[plan.key] = CsgBatch()
        like.shapes.append(shape)
        like.plans.append(plan)
        like.numbers.append(number)
        return True

    def _take_single(self) -> list[tuple[Shape, int]]:
        """Pass the bodies that are primitives to the batch; return those that are left."""
        shapes, numbers = self._single
        if not shapes:
            return []
        places = self._reserve(np.array(numbers, np.int32))
        left = self._primitives.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), places)
        return [(shapes[k], numbers[k]) for k in left.tolist()]

    def _take_planned(self) -> None:
        """Pass the primitives of Boolean bodies to the batch.

        A body with a primitive that is left is left as a whole.
        """
        for like in self._plans.values():
            count, leaves = len(like.shapes), len(like.plans[0].leaves)
            places = self._reserve(np.full(count * leaves, -1, np.int32)).reshape(count, leaves)
            own = MotionChains([shape.motion.steps for shape in like.shapes])
            for leaf in range(leaves):
                listed = [plan.leaves[leaf] for plan in like.plans]
                chains = own
                if any(inner for _, inner in listed):
                    chains = MotionChains([inner + mine for (_, inner), mine in zip(listed, own.steps, strict=True)])
                rest = self._primitives.add([shape for shape, _ in listed], chains, places[:, leaf])
                self._left += [(listed[k][0], chains.steps[k], int(places[k, leaf])) for k in rest.tolist()]
            # Frames of at most one translation need no lookup.
            like.first, like.frames = places[:, 0].copy(), self._primitives.frames_of(own)

    def lower(self, report: ProgressCallback = lambda *_: None) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """Lower all bodies.

        Many bodies of a kind are lowered in blocks, so that intermediate results stay in the cache. Bodies that a block
        leaves may find enough of their kind among those that other blocks left.

        Parameters
        ----------
        report : ProgressCallback, optional
            Called now and then with (parts done, parts in all).

        Returns
        -------
        tuple[list[LoweredGroup], list[tuple[Shape, int]]]
            (pattern, body numbers, rows) of bodies lowered together; shapes and numbers of those that are left.
        """
        results: list[LoweredGroup] = []
        pending = [*self._blocks_of_plans(), *self._blocks_of_single()]
        count = len(pending)
        for done in range(count):
            report(done, count + 1)
            block = pending.pop(0)  # the last reference: frees the inputs after the block
            found, left = block._lower_block(lambda *_: None)
            results += found
            self.paints.update(block.paints)
            for shape, number in left:
                if not self.add(shape, number):
                    raise AssertionError("a shape that was in a batch cannot be added to one again")
        found, rest = self._lower_block((lambda *_: None) if count else report)
        return results + found, rest

    def _blocks_of_plans(self) -> Iterator[BatchLowering]:
        """Move the Boolean bodies of large kinds to blocks."""
        for key, like in list(self._plans.items()):
            size = _AT_ONCE // len(like.plans[0].leaves) + 1
            if len(like.shapes) > 2 * size:
                del self._plans[key]
                for begin in range(0, len(like.shapes), size):
                    block = BatchLowering()
                    block._plans[key] = like.some(begin, begin + size)
                    yield block

    def _blocks_of_single(self) -> Iterator[BatchLowering]:
        """Move the primitives of large kinds to blocks."""
        shapes, numbers = self._single
        if len(shapes) <= 2 * _AT_ONCE:
            return
        left: list[int] = []
        for places in positions_by_key(list(map(type, shapes))).values():
            if len(places) <= 2 * _AT_ONCE:
                left += places
                continue
            for begin in range(0, len(places), _AT_ONCE):
                block, some = BatchLowering(), places[begin : begin + _AT_ONCE]
                block._single = [shapes[k] for k in some], [numbers[k] for k in some]
                yield block
        self._single = [shapes[k] for k in left], [numbers[k] for k in left]

    def _lower_block(self, report: ProgressCallback) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """`lower`, in one block."""
        rest = self._take_single()
        self._take_planned()
        kinds = self._primitives.kinds + len(self._plans) + len(self._many)
        found, left = self._primitives.lower(lambda done: report(done, kinds))
        owners = np.concatenate([np.zeros(0, np.int32), *self._owners])
        results: list[LoweredGroup] = []
        for form, places, rows in found:
            single = owners[places] >= 0
            if single.all():
                results.append((form.pattern, owners[places], rows))
            elif single.any():
                results.append((form.pattern, owners[places[single]], rows[single]))
        rest += [(shape, int(owners[place])) for shape, _, place in left if owners[place] >= 0]
        found += _lower_parts([*left, *self._left], self._places_of_plans())
        if self._plans or self._many:
            rows_of = _rows_by_place(found, len(owners))
            every: list[CsgBatch | CsgArray] = [*self._plans.values(), *self._many]
            for done, like in enumerate(every, start=self._primitives.kinds):
                report(done, kinds)
                composed, others = self._compose(like, rows_of)
                results += composed
                rest += others
        return results, rest

    def _places_of_plans(self) -> set[int]:
        """Return the places of primitives of listed bodies with the plan of several others, or with a polyhedron.

        A body that is left as a whole would be left with all faces of a polyhedron, or with all the volumes that are
        cut from it, most of them lowered already.
        """
        found: set[int] = set()
        polyhedra = self._primitives.places_of_polyhedra
        for like in self._plans.values():
            begin, count = int(like.first[0]), len(like.shapes) * len(like.plans[0].leaves)
            places = range(begin, begin + count)
            many = len(like.shapes) >= _FEWEST_OF_PLAN or count >= _MANY_LEAVES
            if many or not polyhedra.isdisjoint(places):
                found.update(places)
        return found

    def _compose(
        self, like: CsgBatch | CsgArray, rows: _RowLocations
    ) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """Compose the bodies of one plan; return also those that are left."""
        _, plan = like.of(0)
        key, count = plan.key, len(plan.leaves)
        bodies, first, frame_rows = like.columns()
        places = first[:, None] + np.arange(count, dtype=np.int32)
        frames = like.frames_of(frame_rows, self._primitives.frames)
        known = (rows.number[places] >= 0).all(axis=1) & ~np.isnan(frames[:, 0])
        left: list[tuple[Shape, int]] = [(like.of(i)[0], int(bodies[i])) for i in np.flatnonzero(~known).tolist()]
        numbers = {id(form): number for number, form in enumerate(rows.forms)}
        form_of = np.array([numbers[id(form)] for form in rows.forms], np.int32)
        results: list[LoweredGroup] = []
        for forms, chosen in _group_by_forms(form_of, rows.number[places], np.flatnonzero(known)):
            composition = CsgComposition.of(key, [rows.forms[form] for form in forms])
            some: Any = slice(None) if len(chosen) == len(bodies) else chosen
            parts = [rows.of(places[some, part]) for part in range(count)]
            # The leaves of the others have the same forms
            leaves = [leaf for leaf, _ in like.of(int(chosen[0]))[1].leaves]
            boxes, certain = bound_bodies(key, leaves, [rows.forms[form] for form in forms], parts)
            others = np.flatnonzero(~certain)
            if len(others):
                uncertain = [like.of(i) for i in chosen[others].tolist()]
                boxes[others] = _exact_bounds(uncertain, [box_columns(part[others]) for part in parts])
            results.append((composition.pattern, bodies[chosen], composition.rows(parts, boxes, frames[some])))
            for i in chosen.tolist() if plan.painted else ():
                painted = like.plans[i].painted if isinstance(like, CsgBatch) else like.of(i)[1].painted
                self._paint(int(bodies[i]), painted, composition)
        return results, left

    def _paint(self, number: int, painted: list[tuple[int, int, Material]], composition: CsgComposition) -> None:
        """Record the materials of faces that have their own; paint further in takes precedence."""
        ends = [*composition.faces, len(composition.pattern.angular)]
        paints = self.paints.setdefault(number, {})
        for first, last, material in painted:
            for face in range(ends[first], ends[last]):
                paints.setdefault(face, material)


def _lower_parts(left: Sequence[_LeftPrimitive], places: Container[int]) -> list[PrimitiveRows]:
    """Lower primitives at these places one by one, each once for all bodies that it is part of.

    Bodies of one plan are composed together even if a recording cannot lower all of their primitives.
    """
    known: dict[Hashable, LoweredShape] = {}
    rows: dict[PrimitiveForm, tuple[list[int], list[list[float]]]] = {}
    for shape, steps, place in left:
        if place not in places:
            continue
        key = id(shape), steps
        if key not in known:
            try:
                known[key] = lower_shape(shape._under_steps(steps))  # cached: it may be a body as well
            except (OverflowError, ValueError):  # its body is left, and `lower_shape` names what is wrong
                continue
        part = known[key]
        numbers, values = rows.setdefault(FORMS.of(part.pattern, part.tree), ([], []))
        numbers.append(place)
        values.append(part.row)
    return [
        (
            form,
            np.array(numbers, np.int32),
            RowTable.of(np.array(values), np.arange(form.pattern.width, dtype=np.int32)),
        )
        for form, (numbers, values) in rows.items()
    ]


def _exact_bounds(bodies: Sequence[tuple[Boolean, CsgPlan]], parts: Sequence[Floats]) -> Floats:
    """Compute bounds of bodies in numbers of 3000 bits, from the boxes of their parts."""
    found = np.empty((len(bodies), 6))
    for row, (shape, plan) in enumerate(bodies):
        box_of = {
            (id(leaf), steps): (boxes[row, :3], boxes[row, 3:])
            for (leaf, steps), boxes in zip(plan.leaves, parts, strict=True)
        }
        found[row] = np.concatenate(region_bounds(shape, IDENTITY_MOTION, box_of))
    return found


def _group_by_forms(form_of: Ints, tables: Ints, which: Any) -> Iterator[tuple[list[int], Any]]:
    """Yield (forms of the parts, bodies with these forms); `tables` (bodies, parts) holds numbers of forms."""
    if not len(which):
        return
    forms = form_of[tables[which]].astype(np.int64)
    if (forms == forms[0]).all():
        yield forms[0].tolist(), which
        return
    code = forms[:, 0]
    for part in range(1, forms.shape[1]):
        code = unique_with_inverse(code)[1] * len(form_of) + forms[:, part]
    first, group = unique_first_with_inverse(code)
    for number, example in enumerate(first.tolist()):
        yield forms[example].tolist(), which[group == number]


def _rows_by_place(found: list[PrimitiveRows], count: int) -> _RowLocations:
    """Index rows by places."""
    table, row = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    for number, (_, places, rows) in enumerate(found):
        table[places] = number
        row[places] = np.arange(len(rows), dtype=np.int32)
    return _RowLocations([form for form, _, _ in found], [rows for _, _, rows in found], table, row)
