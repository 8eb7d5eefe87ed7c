"""Batches of primitives: record the lowering of one primitive on a tape, and play it for all of equal structure.

Shapes are alike if their types and the structure of their fields agree (as many numbers, or none), whatever their
motions. Each kind has a few recordings, because comparisons of numbers turn out one way or the other. What they cannot
decide is left to `lower_shape`: numbers that four floats leave open, kinds that inspect their numbers in untraceable
ways, and kinds with too few shapes. `batch_lowering.py` composes bodies of these primitives.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from .._util.arrays import unique_sorted
from .._util.records import dataclass
from ..geometry.bulk import Bulk
from ..geometry.cell import Any_, Cell, Face, Tree
from ..geometry.facets import PlaneSide
from ..geometry.shape import Shape
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.tables import CELL, MAP_SIZE, PLANE, PLANE_SIZE, REGION, Floats, Ints, Longs, Signs
from ..numerics.tracing import Tape, TracedFloat
from .assembly import Assembly, SurfaceSlot
from .csg_plan import FORMS, PrimitiveForm, placed_primitives
from .lower_shape import LoweredShape, compute_shape, widen_boxes
from .motion_batch import SIMILARITY, UNKNOWN_MOTION, MotionBatch, MotionChains, count_translations, input_motion
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable
from .polyhedron_extent import learn_bounds, polyhedron_boxes
from .pytree import flatten, flatten_all, positions_by_key, unflatten
from .tape import recordings
from .tape.recordings import NO_INPUTS

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
        from ..geometry.polyhedron import points_near

        learn_bounds(self.shapes, self.planes)
        motions, places = np.concatenate(self.motions), np.concatenate(self.places)
        ends = np.array([shape._own_bounds for shape in self.shapes])
        common = [points_near(ends, self.planes.reshape(len(ends), -1, 4))]
        if count_translations(self.steps[0]) > 0:
            common.append(np.array([[x for step in steps for x in step.offset] for steps in self.steps]))  # type: ignore[union-attr]
        numbers = [self.planes.reshape(-1, 4), *(np.repeat(each, self.faces, axis=0) for each in common)]
        return np.concatenate(numbers, axis=1), np.repeat(motions, self.faces), places


class _FlatWalls:
    """The walls of meshes and extrusions, given by their hulls: they are lowered as shapes.

    A solid that stands in several bodies at one place is lowered once: a GDML daughter stands in its mother, too.
    """

    def __init__(self, hulls: _ShapeList) -> None:
        solids: list[Any] = [hull.solid for hull in hulls.shapes]  # type: ignore[attr-defined]
        offsets, motions, places = hulls.columns()
        parts = [solid.parts for solid in solids]
        # Copies of a solid with other motions keep the parts that its constructor made
        keys = zip(map(id, parts), motions.tolist(), (row.tobytes() for row in offsets), strict=True)
        uses = list(positions_by_key(list(keys)).values())
        self.places: list[Ints] = [places[some] for some in uses]
        """The places of each solid."""
        first = [int(some[0]) for some in uses]
        self.offsets, self.motions = offsets[first], motions[first]
        self.solids, self.parts = [solids[k] for k in first], [parts[k] for k in first]
        self.hulls = _ShapeList([hulls.shapes[k] for k in first], [hulls.steps[k] for k in first])
        self.first: Longs = np.cumsum([0, *(len(solid.walls) for solid in self.solids)])
        """The first wall of each solid, and the number of walls."""

    def __len__(self) -> int:
        return int(self.first[-1])

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`ShapeBatch.of`"""
        which = int(np.searchsorted(self.first, index, side="right")) - 1
        return self.solids[which].wall(index - int(self.first[which])), self.hulls.steps[which]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`ShapeBatch.columns`; walls have no places"""
        count, walls = np.diff(self.first), np.concatenate([solid.walls for solid in self.solids])
        numbers = np.concatenate([walls, np.repeat(self.offsets, count, axis=0)], axis=1)
        return numbers, np.repeat(self.motions, count), np.zeros(0, np.int32)


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
LeftPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...], int]
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
        self._hulls: dict[Hashable, _ShapeList] = {}

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
        if counts_of_faces.any():
            from ..geometry.polyhedron import FlatSolid, learn_walls

            learn_walls([shape for shape in shapes if isinstance(shape, FlatSolid)])
        hulls = {k: hull for k in np.flatnonzero(counts_of_faces).tolist() if (hull := shapes[k]._hull) is not None}
        if hulls:
            counts_of_faces[list(hulls)] = 0
            # One that is its own hull is lowered whole
            hulls = {k: hull for k, hull in hulls.items() if hull is not shapes[k]}
            shapes = [hulls.get(k, shape) for k, shape in enumerate(shapes)]
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
                kind = self._hulls if which[0] in hulls else self._like
                like = kind.setdefault((group.form, "moved" if count < 0 else count), _ShapeList())
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

    def lower(self, report: Callable[[int], Any] = lambda _: None) -> tuple[list[PrimitiveRows], list[LeftPrimitive]]:
        """Lower all primitives; `report` receives the count of kinds done.

        Return those lowered together, and those that are left.
        """
        motions_given, kinds, self.frames = self._motions.compute()
        results: list[PrimitiveRows] = []
        left: list[LeftPrimitive] = []
        every: list[tuple[Hashable, ShapeBatch]] = [*self._like.items(), *self._many]
        for done, (key, like) in enumerate(every):
            report(done)
            numbers, motions, places = like.columns()
            for kind, rows_of_kind in _split_by_motion(key, motions, kinds):
                given = _BatchInputs(like, rows_of_kind, numbers[rows_of_kind], motions_given, motions[rows_of_kind])
                found, rest = self._lower_kind(key, kind, given)
                results += [(form, places[rows_of_kind[which]], rows) for form, which, rows in found]
                left += [(*like.of(i), int(places[i])) for i in rows_of_kind[rest].tolist()]
        for done, ((_, key), polyhedra) in enumerate(self._polyhedra.items(), start=len(every)):
            from ..geometry.polyhedron import MANY_FACES

            report(done)
            if len(polyhedra) >= MANY_FACES:
                results.append(self._lower_polyhedra(key, polyhedra, motions_given, kinds))
                continue
            of_places = np.concatenate(polyhedra.places).tolist()
            left += zip(polyhedra.shapes, polyhedra.steps, of_places, strict=True)
        for key, hulls in self._hulls.items():
            results += self._lower_flat(key, _FlatWalls(hulls), motions_given, kinds)
        return results, left

    def _first_columns(
        self, key: Hashable, of: ShapeBatch, numbers: Floats, motions: Ints, given: Floats, kinds: Signs, width: int
    ) -> Floats:
        """Return the first numbers in the rows of shapes: each computed apart if it is of a rare kind."""
        first = np.empty((len(of), width))
        for kind, some in _split_by_motion(key, motions, kinds):
            found, rest = self._lower_kind(key, kind, _BatchInputs(of, some, numbers[some], given, motions[some]))
            for _, which, rows in found:
                first[some[which]] = rows[:, :width]
            for i in some[rest].tolist():
                shape, steps = of.of(i)
                first[i] = compute_shape(shape._under_steps(steps)).row[:width]
        return first

    def _lower_flat(self, key: Hashable, of: _FlatWalls, given: Floats, kinds: Signs) -> list[PrimitiveRows]:
        """Return the rows of meshes and extrusions, from those of their walls and of their hulls."""
        numbers, motions, _ = of.columns()
        flat = flatten(of.of(0)[0])
        assert flat is not None
        assert isinstance(key, tuple)
        walls = self._first_columns((flat.form, key[1]), of, numbers, motions, given, kinds, _FACE_NUMBERS)
        hulls = self._first_columns(key, of.hulls, of.offsets, of.motions, given, kinds, BOX_NUMBERS + FRAME_NUMBERS)
        results = []
        for some in positions_by_key([(each.numbers, each.parts) for each in of.parts]).values():
            form, columns = _flat_form(of.parts[some[0]].numbers, of.parts[some[0]].parts)
            own = np.array([walls[of.first[k] : of.first[k + 1]].ravel() for k in some])
            blank, grown = np.zeros((len(some), MAP_SIZE)), widen_boxes(hulls[some, :BOX_NUMBERS])
            values = np.concatenate([own, blank, grown, hulls[some]], axis=1)
            places = [of.places[k] for k in some]
            rows = RowTable.of(np.repeat(values, list(map(len, places)), axis=0), columns)
            results.append((form, np.concatenate(places), rows))
        return results

    def _lower_polyhedra(self, key: Hashable, of: _Polyhedra, given: Floats, kinds: Signs) -> PrimitiveRows:
        """Return the rows of polyhedra, from the rows of their faces: each computed apart if it is of a rare kind."""
        numbers, motions, places = of.columns()
        faces = self._first_columns(key, of, numbers, motions, given, kinds, _FACE_NUMBERS)
        count, own = len(of.shapes), motions[:: of.faces]
        frames = np.tile(np.eye(3, 4).ravel(), (count, 1))
        forward, translations = None, count_translations(of.steps[0])
        if translations < 0:
            frames = self.frames[own]
            forward = given[own, :FRAME_NUMBERS].reshape(count, -1)
        elif translations == 1:
            frames[:, 3::4] = -numbers[:: of.faces, -3:]
        elif translations > 1:
            offsets = ([step.offset for step in steps] for steps in of.steps)  # type: ignore[union-attr]
            frames[:, 3::4] = [[0.0 - math.fsum(along) for along in zip(*each, strict=True)] for each in offsets]
        for row in np.flatnonzero(np.isnan(frames[:, 0])).tolist():
            frames[row] = np.ravel(Motion(of.steps[row]).inverse_rows)
        parts = [
            faces[:, :_PLANE_NUMBERS].reshape(count, -1), faces[:, _PLANE_NUMBERS:].reshape(count, -1),
            polyhedron_boxes(of.shapes, of.steps, of.planes, forward), frames,
        ]  # fmt: skip
        form = _polyhedron_form(of.faces)
        whole = np.concatenate(parts, axis=1)
        return form, places, RowTable.of(whole, np.arange(whole.shape[1], dtype=np.int32))

    def _lower_kind(
        self, key: Hashable, kind: int, of: _BatchInputs
    ) -> tuple[list[tuple[PrimitiveForm, Longs, RowTable]], Longs]:
        """`lower` for some shapes of equal structure, by their positions among them; and the positions that are left.

        `kind` is that of their motions; where it is not known, all are left.
        """
        every = np.arange(len(of.chosen))
        if kind == UNKNOWN_MOTION:
            return [], every
        if not of.like.of(int(of.chosen[0]))[0]._has_batch_support:  # type: ignore[attr-defined]
            return self._play_kind(key, kind, of, every, np.zeros((len(every), 0)))
        reaches, which, left = self._reaches(key, kind, of)
        results = []
        for some in positions_by_key(list(map(tuple, np.where(np.isfinite(reaches), 0.0, reaches).tolist()))).values():
            found, rest = self._play_kind(key, kind, of, which[some], reaches[some])
            results += found
            left = np.concatenate([left, rest])
        return results, left

    def _reaches(self, key: Hashable, kind: int, of: _BatchInputs) -> tuple[Floats, Longs, Longs]:
        """Return the supports that give the boxes of shapes (n, 6), the positions of these shapes, and those left.

        One recording gives the directions, the shapes themselves their supports, and another recording all numbers.
        """

        def record(row: int, tape: Tape) -> None:
            shape, steps = of.like.of(int(of.chosen[row]))
            traced = _trace_shape(shape, steps, tape, _is_moved(key), kind)

            def write(direction: Any) -> float:
                for number in direction:
                    tape.write(number)
                return 1.0

            object.__setattr__(traced, "support", write)
            traced.ends(traced.under())

        given = self._motion_inputs(key, of)
        results, left = recordings.RECORDINGS.play(("directions", key, kind), record, of.numbers, given, of.motions)
        reaches, places = [np.zeros((0, BOX_NUMBERS))], [np.zeros(0, np.int64)]
        for _, which, played in results:
            shapes = [of.like.of(number)[0] for number in of.chosen[which].tolist()]
            reaches.append(type(shapes[0])._supports(shapes, played.floats.reshape(-1, BOX_NUMBERS, 3)))  # type: ignore[attr-defined]
            places.append(which)
        return np.concatenate(reaches), np.concatenate(places), left

    def _motion_inputs(self, key: Hashable, of: _BatchInputs) -> Floats:
        """Return the numbers of the motions where the recordings of a kind read them."""
        return of.motions_given if _is_moved(key) else NO_INPUTS

    def _play_kind(
        self, key: Hashable, kind: int, of: _BatchInputs, some: Longs, reaches: Floats
    ) -> tuple[list[tuple[PrimitiveForm, Longs, RowTable]], Longs]:
        """`_lower_kind` for some of the shapes; `reaches` (n, 6) are their supports where these are computed apart.

        The same supports are infinite for all of them.
        """

        def record(row: int, tape: Tape) -> tuple[PrimitiveForm, Ints]:
            shape, steps = of.like.of(int(of.chosen[some[row]]))
            traced = _trace_shape(shape, steps, tape, _is_moved(key), kind)
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
        found, left = recordings.RECORDINGS.play(
            (key, kind, endless), record, np.concatenate([of.numbers[some], reaches[:, is_finite]], axis=1),
            self._motion_inputs(key, of), of.motions[some],
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


@lru_cache(maxsize=64)
def _flat_form(numbers: tuple[int, ...], parts: tuple[tuple[PlaneSide, ...], ...]) -> tuple[PrimitiveForm, Ints]:
    """Return the form of a flat solid, and the columns of its row.

    They are among: the rows of its planes, a blank row of a map, its box widened, its box, its frame.
    """
    surface, assembly = itertools.count(), Assembly()
    trees: list[Tree] = []
    for of in (lambda: next(surface), lambda: SurfaceSlot(PLANE, 0, 0)):
        cells = [Cell(tuple(Face(of(), numbers[k], inside=sense) for k, sense in part)) for part in parts]  # type: ignore[arg-type]
        trees.append(cells[0] if len(cells) == 1 else Any_(tuple(cells)))
    tree, slots = trees
    kind, index = (CELL, assembly.cell(slots)) if isinstance(slots, Cell) else (REGION, assembly.program(slots, {}))
    planes = [plane for part in parts for plane, _ in part]
    blank = len(numbers) * _FACE_NUMBERS
    grown, box = blank + MAP_SIZE, blank + MAP_SIZE + BOX_NUMBERS
    # A face has the map of the last of its planes. Numbers without a plane share a blank one, as in `BodyFaces`
    plane_of = {numbers[k]: k for k in planes}
    uv = {n: plane_of[n] * _FACE_NUMBERS + _PLANE_NUMBERS if n in plane_of else blank for n in range(max(plane_of) + 1)}
    row_of: dict[int, int] = {}
    maps = []
    for at in uv.values():
        u, v = (row_of.setdefault(row, len(row_of)) for row in (at, at if at == blank else at + MAP_SIZE))
        maps.append((u, v, u))
    pattern = BodyPattern.of(assembly, kind, index, [False] * len(maps), maps)
    pieces = [(k * _FACE_NUMBERS, _PLANE_NUMBERS) for k in planes] + [(at, MAP_SIZE) for at in row_of]
    pieces += [(grown, BOX_NUMBERS)] * len(assembly.leaves) + [(box, BOX_NUMBERS + FRAME_NUMBERS)]
    return FORMS.of(pattern, tree), np.concatenate([np.arange(at, at + size, dtype=np.int32) for at, size in pieces])


def _write_row(part: LoweredShape, tape: Tape) -> Ints:
    """Make a tape write each number of a row once; return which of the written numbers is in each column."""
    places: dict[int, int] = {}
    columns = [places.setdefault(tape.plain_of(number).register, len(places)) for number in part.row]
    tape.written += places
    return np.array(columns, np.int32)


def _float_key(number: Any) -> str:
    """Return a float, traced or not, in full precision."""
    return float(number.value if isinstance(number, TracedFloat) else number).hex()


def _split_by_motion(key: Hashable, motions: Ints, kinds: Signs) -> list[tuple[int, Longs]]:
    """Split shapes by the kinds of their motions."""
    if not _is_moved(key):
        return [(SIMILARITY, np.arange(len(motions)))]
    own = kinds[motions]
    return [(kind, np.flatnonzero(own == kind)) for kind in unique_sorted(own)[::-1].tolist()]


def _trace_shape(shape: Shape, steps: tuple[Step, ...], tape: Tape, moved: bool, kind: int) -> Any:
    """Return a shape whose numbers are those of a tape."""
    traced = unflatten(shape, tape)
    if not moved:
        motion = Motion(tuple(unflatten(step, tape) for step in steps)) if steps else IDENTITY_MOTION
    else:
        motion = input_motion(tape, kind, Motion(steps))
    object.__setattr__(traced, "motion", motion)
    return traced
