"""The base classes of shapes, and their Boolean combinations.

Every shape has motions, bounds, operators and a name in scene files. To add a primitive, subclass `PrimitiveSolid` or
`PrimitiveSheet` in a file of this package and supply data: the fields, `tree` (or `sheet`) and `support` in the shape's
own frame, and `placement` if the fields put that frame somewhere. Motions, Booleans, bounds, rays, uv, scene files and
the contract tests then work.

Operators return Boolean nodes and Boolean nodes are shapes, so both are in this file.
"""

from __future__ import annotations

import dataclasses
import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NoReturn, Self, overload

import numpy as np

from .._util.arrays import BoxEnds, FloatArray, Vector, VectorLike, ignore_fp_errors
from .._util.records import dataclass, pickle_state, restore_state
from .._util.text import unknown_attribute
from .._util.validation import check_integer, describe_kind, format_value
from ..materials.material import Material
from ..materials.presets import as_material
from .bounds.aabb import Bounds, intersect_boxes
from .bounds.intersection import (
    BoundingSurfaces,
    BoundsKind,
    region_bounds,
    surfaces_around,
)
from .bounds.support import bound_by_support
from .cell import Cell, PolygonSheet, SurfaceSheet, Tree
from .transform import IDENTITY_MOTION, Motion, Step, apply_about as moved_about


def _check_motion_first(check: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a `__post_init__` that checks the motion, which all shapes have, and then the fields of the class."""

    @functools.wraps(check)
    def checked(self: Any) -> None:
        self._check_motion()
        check(self)

    return checked


REGISTERED: dict[str, type[Shape]] = {}
"""Scene-file name -> class, for the shapes whose files have been imported; `registry.REGISTRY` has all."""


@dataclass(frozen=True)
class Shape(ABC):
    """A solid or a sheet, immutable.

    `motion` holds the steps that move it. The methods `translate`, `rotate`, `scale` and `transform` return a shape
    with one step more; the constructor leaves `motion` out.
    """

    motion: Motion = field(default=IDENTITY_MOTION, kw_only=True, repr=False)
    abstract: ClassVar[bool] = True
    bounds_kind: ClassVar[BoundsKind] = ""
    _source: ClassVar[Any] = None
    """The element of a file that an importer made this shape of. Moved shapes keep it, and exports write it again."""
    is_sheet: ClassVar[bool]
    """True for open surfaces, which bound no volume."""

    def __init_subclass__(cls, abstract: bool = False) -> None:
        cls.abstract = abstract
        if cls.__repr__ is Shape.__repr__:
            # `dataclass` writes a repr of its own unless the class itself has one
            setattr(cls, "__repr__", Shape.__repr__)  # noqa: B010 - mypy refuses to assign a method
        if "__post_init__" in vars(cls):
            setattr(cls, "__post_init__", _check_motion_first(vars(cls)["__post_init__"]))  # noqa: B010 - as above
        known = REGISTERED.get(cls.__name__)
        is_ours = cls.__module__.startswith(f"{__package__}.")
        # A user's class keeps its name when a file of this package, imported later, defines a class of the same name
        if not abstract and (known is None or not is_ours or known.__module__.startswith(f"{__package__}.")):
            REGISTERED[cls.__name__] = cls

    def __post_init__(self) -> None:
        self._check_motion()

    def _check_motion(self) -> None:
        if not isinstance(self.motion, Motion):
            expected = "left out: shape.translate(...), .rotate(...), .scale(...) and .transform(...) move it"
            raise TypeError(f"{type(self).__name__}: motion must be {expected}; got {format_value(self.motion)}")

    def __getstate__(self) -> dict[str, Any]:
        return pickle_state(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)

    def __repr__(self) -> str:
        """The call that makes the shape, followed by the steps that move it."""
        names = [each.name for each in dataclasses.fields(self) if each.repr]
        fields = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__qualname__}({fields}){self.motion.calls}"

    @property
    def placement(self) -> Motion:
        """The motion from the shape's own frame to the place that its fields give."""
        return IDENTITY_MOTION

    def under(self, outer: Motion = IDENTITY_MOTION) -> Motion:
        """Return the motion from the shape's own frame to the world if `outer` moves the whole shape as well."""
        return self._placed if not outer.steps else self.motion.then(outer).placed(self.placement)

    @cached_property
    def cache(self) -> dict[str, Any]:
        """A cache, by name, of values that later stages derive from the shape, which is immutable."""
        return {}

    @cached_property
    def own_cache(self) -> dict[str, Any]:
        """A cache like `cache` of values that do not depend on the motion; moved copies share it."""
        return {}

    @cached_property
    def _placed(self) -> Motion:
        return self.motion.placed(self.placement)

    def _moved(self, motion: Motion) -> Self:
        """Return this shape with another motion. Raise ValueError if the motion leaves the domain of numbers."""
        motion.check(type(self).__name__)
        return self._with_motion(motion)

    def _with_motion(self, motion: Motion) -> Self:
        """Return this shape with another motion, which the caller has checked."""
        # The fields are those of this shape and were checked once: no constructor runs
        kind = type(self)
        shape = kind.__new__(kind)
        vars(shape).update(pickle_state(self), motion=motion, own_cache=self.own_cache)
        return shape

    def _under_steps(self, steps: tuple[Step, ...]) -> Self:
        """Return this shape with these steps for its motion: itself where it has them, with all that it caches."""
        return self if self.motion.steps == steps else self._with_motion(Motion(steps))

    def translate(self, offset: VectorLike) -> Self:
        """Return the shape moved by `offset`, three numbers."""
        return self._moved(self.motion.translate(offset))

    def rotate(self, axis: str | VectorLike, degrees: float, *, about: VectorLike | None = None) -> Self:
        """Return the shape turned about an axis through the world's origin, or through the point `about`.

        Parameters
        ----------
        axis : three numbers, or "x", "y", "z", "-x", "-y", "-z"
            The direction of the axis, of any length.
        degrees : float
            The angle, right-handed: counter-clockwise if the axis points towards the viewer.
        about : three numbers, optional
            A point of the axis: the shape is moved by -about, turned and moved back, exactly.
        """
        return self._moved(moved_about("rotate", self.motion, about, lambda motion: motion.rotate(axis, degrees)))

    def scale(self, factors: float | VectorLike, *, about: VectorLike | None = None) -> Self:
        """Return the shape scaled about the world's origin, or about the point `about`.

        Parameters
        ----------
        factors : float or three numbers
            One factor for all axes, or one for each. Negative factors mirror; 0 raises ValueError.
        about : three numbers, optional
            The point that stays where it is.
        """
        return self._moved(moved_about("scale", self.motion, about, lambda motion: motion.scale(factors)))

    def transform(self, matrix: Any) -> Self:
        """Return the shape carried by an affine motion.

        Parameters
        ----------
        matrix : array (4, 4)
            Invertible, with the last row (0, 0, 0, 1). Points are columns (x, y, z, 1).
        """
        return self._moved(self.motion.transform(matrix))

    @property
    def _face_count(self) -> int:
        """The number of faces of a polyhedron, whose numbers are computed together; 0 for other shapes."""
        return 0

    @property
    def _hull(self) -> Shape | None:
        """The shape whose corners bound a solid of flat faces, which may be concave; None for other shapes."""
        return None

    @property
    def bounds(self) -> Bounds:
        """The tightest box, (low, high), two arrays (3,): ±inf where unbounded, low > high if the shape is empty."""
        low, high = self._bounds
        return Bounds(low.copy(), high.copy())

    @cached_property
    @ignore_fp_errors
    def _bounds(self) -> BoxEnds:
        return self.bounds_under(IDENTITY_MOTION)

    @abstractmethod
    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds (low, high) of the shape after the further motion `outer`."""

    def __bool__(self) -> NoReturn:
        raise TypeError(
            f"{type(self).__name__} is neither true nor false: shapes combine with & | - ~, "
            "not with `and`, `or`, `not`; whether there is one: `shape is not None`"
        )

    if not TYPE_CHECKING:  # type checkers would otherwise accept any attribute

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(self, name)


class Primitive(Shape, abstract=True):
    """A shape with a frame of its own and a support function in it."""

    @abstractmethod
    def support(self, direction: Vector) -> float:
        """Return sup direction·p over the shape in its own frame; inf where unbounded, -inf if empty."""

    @property
    def _has_batch_support(self) -> bool:
        """True where `support` takes no recorded numbers (numerics/tracing.py): `_supports` gives those of many."""
        return False

    @classmethod
    def _supports(cls, shapes: Sequence[Any], directions: FloatArray) -> FloatArray:
        """Return the supports (n, m) of shapes of this class, each in directions of its own (n, m, 3)."""
        rows = zip(shapes, directions.tolist(), strict=True)
        return np.array([[shape.support((x, y, z)) for x, y, z in row] for shape, row in rows])

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds (low, high) of the shape after the further motion `outer`."""
        ends = self.ends(self.under(outer))
        return np.array(ends[:3]), np.array(ends[3:])

    def ends(self, motion: Motion) -> list[float]:
        """Return (low x, y, z, high x, y, z) of the shape if `motion` carries its own frame to the world."""
        return bound_by_support(self.support, motion)


class Solid(Shape, abstract=True):
    """A shape with an inside. Solids combine with ``|``, ``&``, ``-`` and ``~``."""

    is_sheet = False
    combines: ClassVar[bool] = True
    """False for entries of many bodies, such as `Spheres`, which are no operands."""

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds of the complement after `outer`: all of space, unless a subclass knows better."""
        return np.full(3, -np.inf), np.full(3, np.inf)

    def has_unbounded_outside(self) -> bool:
        """Return True if surely no plane and no quadric bounds the complement."""
        return False

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces:
        """Return surfaces in the world that contain the inside (or the outside) of the solid after `outer`.

        All of that part lies inside of each of them. The list may leave out any of them: bounds stay valid.
        """
        return []

    def __or__(self, other: Solid) -> Union:
        return _unite(self, other)

    @overload
    def __and__(self, other: Solid) -> Intersection: ...

    @overload
    def __and__(self, other: Sheet) -> ClippedSheet: ...

    def __and__(self, other: Any) -> Intersection | ClippedSheet:
        return _intersect(self, other)

    def __sub__(self, other: Solid) -> Difference:
        return _subtract(self, other)

    def __invert__(self) -> Complement:
        return Complement(self)

    def painted(self, material: Any, faces: Iterable[int] | None = None) -> Painted:
        """Return the solid with a material of its own for its faces: ``body - bore.painted(red)`` has red cuts.

        Parameters
        ----------
        material : Material or colour
            As for `Body`.
        faces : iterable of int, optional
            Only these faces, by the numbers that hits on the solid report; all without it.
        """
        return Painted(self, material, faces)  # type: ignore[arg-type]  # it makes the tuple


class PrimitiveSolid(Solid, Primitive, abstract=True):
    """A solid given by a tree of cells in its own frame."""

    @abstractmethod
    def tree(self) -> Tree:
        """Return the cells in the shape's own frame."""

    def _axial_name(self, number: int) -> tuple[float, ...] | None:
        """Return an exact name of a placed surface of `tree`, if the ends of an axis give it one; else None."""
        return None

    def has_unbounded_outside(self, tree: Tree | None = None) -> bool:
        """Return True if surely no plane and no quadric bounds the complement; `tree` is its own, moved or not."""
        # A class that bounds its complement (half-spaces do) says so by this method
        if type(self).outside_bounds_under is not Solid.outside_bounds_under:
            return False
        if self.bounds_kind in ("ball", "box", "round"):
            return True
        # The outside of a cell with several faces is a union: none of its surfaces bounds all of it
        tree = self.tree() if tree is None else tree
        return isinstance(tree, Cell) and len(tree.faces) > 1

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces:
        return surfaces_around(self.tree(), self.under(outer), inside)


class Sheet(Shape, abstract=True):
    """An open surface. ``sheet & solid`` and ``sheet - solid`` clip it."""

    is_sheet = True

    def __and__(self, solid: Solid) -> ClippedSheet:
        return _clip_sheet(self, solid, keep_inside=True)

    def __rand__(self, solid: Solid) -> ClippedSheet:
        return self & solid

    def __sub__(self, solid: Solid) -> ClippedSheet:
        return _clip_sheet(self, solid, keep_inside=False)

    def __or__(self, other: Any) -> Any:
        raise TypeError(f"{type(self).__name__} is a sheet: only `sheet & solid` and `sheet - solid` clip it")

    __ror__ = __rsub__ = __or__

    def __invert__(self) -> Any:
        raise TypeError(f"{type(self).__name__} is a sheet and has no complement")


class PrimitiveSheet(Sheet, Primitive, abstract=True):
    """A sheet given by one surface and the solid that clips it, in its own frame."""

    @abstractmethod
    def sheet(self, motion: Motion) -> SurfaceSheet | PolygonSheet:
        """Return the sheet after `motion`, which carries its own frame to the world."""


# Boolean combinations of solids, and sheets clipped by solids
#
# Trees may be thousands of levels deep, as a sum of many solids in a loop makes them. So every function here walks a
# tree with a list of pending nodes; none calls itself from level to level.


class Boolean(Solid, abstract=True):
    """A combination of solids, of any depth."""

    operands: tuple[Solid, ...]

    @classmethod
    def _sides(cls, count: int, inside: bool) -> list[bool]:
        """Return whether the inside of each of `count` operands counts for the inside, or the outside, of a node.

        That side is the intersection of these sides, or their union: see `_is_intersection` (De Morgan).
        """
        return [inside] * count

    @classmethod
    def _is_intersection(cls, inside: bool) -> bool:
        """Return whether the inside, or the outside, of a node is the intersection of its `_sides`, not their union."""
        return inside

    def bounds_under(self, outer: Motion) -> BoxEnds:
        return region_bounds(self, outer)

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        return region_bounds(self, outer, inside=False)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Boolean):
            return NotImplemented
        return self is other or list(_flatten_tree(self)) == list(_flatten_tree(other))

    def __hash__(self) -> int:
        return hash(tuple(_flatten_tree(self)))

    def __reduce__(self) -> tuple[Any, ...]:
        sources = ((k, vars(node).get("_source")) for k, node in enumerate(_tree_nodes(self)))
        kept = {k: source for k, source in sources if source is not None}
        return _rebuild_tree, (list(_flatten_tree(self)), kept)

    def __repr__(self) -> str:
        first = ", ".join(map(_short_repr, self.operands[:8]))
        more = f", ... {len(self.operands) - 8} more" if len(self.operands) > 8 else ""
        return f"{type(self).__name__}(({first}{more})){self.motion.calls}"


@dataclass(frozen=True, eq=False, repr=False)
class Union(Boolean):
    """The union ``a | b``: inside at least one of the `operands`.

    Its faces are those of the operands, numbered on from left to right.
    """

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", _check_solids("Union", self.operands))

    @classmethod
    def _is_intersection(cls, inside: bool) -> bool:
        return not inside


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(Boolean):
    """The intersection ``a & b``: inside all `operands`.

    Its faces are those of the operands, numbered on from left to right.
    """

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", _check_solids("Intersection", self.operands))


@dataclass(frozen=True, eq=False, repr=False)
class Difference(Boolean):
    """The difference ``a - b``: inside the first of the `operands` and outside the others.

    A cut has the face number of the cutter.
    """

    operands: tuple[Solid, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "operands", _check_solids("Difference", self.operands))

    @classmethod
    def _sides(cls, count: int, inside: bool) -> list[bool]:
        return [inside, *[not inside] * (count - 1)]


@dataclass(frozen=True, eq=False, repr=False)
class Complement(Boolean):
    """The complement ``~a``: exactly the points that the solid `operand` does not contain."""

    operand: Solid

    def __post_init__(self) -> None:
        object.__setattr__(self, "operand", _check_solids("Complement", (self.operand,))[0])

    @classmethod
    def _sides(cls, count: int, inside: bool) -> list[bool]:
        return [not inside]

    @classmethod
    def _is_intersection(cls, inside: bool) -> bool:
        return True

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)


@dataclass(frozen=True, eq=False, repr=False)
class Painted(Boolean):
    """The solid `operand`, whose faces have a `material` of their own and keep it in any Boolean combination.

    ``body - bore.painted(red)`` has red cuts. With `faces` only these numbers of its faces are painted. All other faces
    have the material of the body, and so has the inside of a transparent body. Of two paints on one face the inner one
    stays. A colour stands for the matte material.
    """

    operand: Solid
    material: Material
    faces: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        vars(self).update(
            operand=_check_solids("Painted", (self.operand,))[0], material=as_material("Painted", self.material)
        )
        if self.faces is not None:
            if isinstance(self.faces, str) or not isinstance(self.faces, Iterable):
                raise TypeError(f"Painted: faces must be numbers of faces, got {format_value(self.faces)}")
            faces = [check_integer("Painted", f"faces[{k}]", face, 0) for k, face in enumerate(self.faces)]
            object.__setattr__(self, "faces", tuple(sorted(set(faces))))

    @classmethod
    def _is_intersection(cls, inside: bool) -> bool:
        return True

    @property
    def paint(self) -> tuple[Material, tuple[int, ...] | None]:
        """The material, and the numbers of its faces."""
        return self.material, self.faces

    def painted_faces(self, first: int, last: int) -> Iterable[int]:
        """Return the painted ones of the operand's faces, which have the numbers from `first` to `last` in a body.

        Raise ValueError for a number beyond them.
        """
        if self.faces is None:
            return range(first, last)
        if self.faces and self.faces[-1] >= last - first:
            raise ValueError(f"Painted: faces must be below {last - first}, of its operand, got {self.faces[-1]}")
        return [first + face for face in self.faces]

    @property
    def operands(self) -> tuple[Solid, ...]:  # type: ignore[override]
        """The one operand, as a tuple."""
        return (self.operand,)

    def __repr__(self) -> str:
        faces = "" if self.faces is None else f", faces={self.faces}"
        return f"Painted({_short_repr(self.operand)}, {self.material!r}{faces}){self.motion.calls}"


def _short_repr(solid: Solid) -> str:
    """Return the repr of an operand; a Boolean one without its own operands."""
    return f"{type(solid).__name__}(...){solid.motion.calls}" if isinstance(solid, Boolean) else repr(solid)


def _tree_nodes(shape: Shape) -> Iterator[Shape]:
    """Yield the nodes of a tree, parents first and operands from left to right."""
    pending = [shape]
    while pending:
        node = pending.pop()
        yield node
        if isinstance(node, Boolean):
            pending.extend(reversed(node.operands))


def _flatten_tree(solid: Solid) -> Iterator[Any]:
    """Yield the kinds of the nodes of a tree, parents first. Two trees are equal if these sequences are."""
    for node in _tree_nodes(solid):
        if isinstance(node, Boolean):
            yield type(node), node.motion, len(node.operands), getattr(node, "paint", None)
        else:
            yield node


def _rebuild_tree(nodes: Sequence[Any], sources: Mapping[int, Any]) -> Solid:
    """Return the tree of a sequence of `_flatten_tree`, for pickle and copy.

    `sources` has the elements of files that nodes were made of, by their places.
    """
    # From the end: operands come before their parents
    done: list[Solid] = []
    for place in range(len(nodes) - 1, -1, -1):
        part = nodes[place]
        if isinstance(part, Solid):
            done.append(part)
            continue
        kind, motion, count, paint = part
        operands = tuple(done.pop() for _ in range(count))
        if issubclass(kind, (Union, Intersection, Difference)):
            done.append(kind(operands, motion=motion))
        elif issubclass(kind, Painted):
            done.append(kind(operands[0], *paint, motion=motion))
        else:
            done.append(kind(operands[0], motion=motion))
        if place in sources:
            vars(done[-1])["_source"] = sources[place]
    return done[0]


@dataclass(frozen=True)
class ClippedSheet(Sheet):
    """The part of the sheet `base` that is inside (`keep` = "inside") or outside ("outside") the `solid`."""

    base: Sheet
    solid: Solid
    keep: Literal["inside", "outside"] = "inside"

    def __post_init__(self) -> None:
        if not isinstance(self.base, Sheet):
            raise TypeError(f"ClippedSheet: base must be a sheet, got {describe_kind(self.base)}")
        object.__setattr__(self, "solid", _check_solids("ClippedSheet", (self.solid,))[0])
        if not isinstance(self.keep, str) or self.keep not in ("inside", "outside"):
            raise ValueError(f"ClippedSheet: keep must be 'inside' or 'outside', got {format_value(self.keep)}")

    def __repr__(self) -> str:
        sign = "&" if self.keep == "inside" else "-"
        return f"({self.base!r} {sign} {_short_repr(self.solid)}){self.motion.calls}"

    def bounds_under(self, outer: Motion) -> BoxEnds:
        motion = self.motion.then(outer)
        clip = self.solid if self.keep == "inside" else Complement(self.solid)
        return intersect_boxes([self.base.bounds_under(motion), clip.bounds_under(motion)])


def _check_solids(owner: str, operands: Any) -> tuple[Solid, ...]:
    """Return `operands` as a tuple of at least one solid. Raise TypeError for anything else, sheets too."""
    if isinstance(operands, (str, bytes)) or not isinstance(operands, Iterable):
        raise TypeError(f"{owner}: operands must be a list of solids, got {describe_kind(operands)}")
    items = tuple(operands)
    if not items:
        raise ValueError(f"{owner}: operands must hold at least one solid, got none")
    for item in items:
        if isinstance(item, Sheet):
            raise TypeError(
                f"{owner}: {type(item).__name__} is a sheet: only `sheet & solid` and `sheet - solid` clip it"
            )
        if not isinstance(item, Solid) or not getattr(item, "combines", True):
            raise TypeError(f"{owner}: operands must be solids, got {describe_kind(item)}")
    return items


def _merge_operands(kind: type, shapes: Sequence[Solid]) -> tuple[Solid, ...]:
    """Return the operands of a new node; an unmoved node of the same kind gives its own, so that a | b | c is one."""
    parts: list[Solid] = []
    for shape in shapes:
        merged = isinstance(shape, kind) and isinstance(shape, Boolean) and shape.motion == IDENTITY_MOTION
        parts.extend(shape.operands if isinstance(shape, Boolean) and merged else (shape,))
    return tuple(parts)


def _unite(a: Solid, b: Solid) -> Union:
    return Union(_merge_operands(Union, (a, b)) if isinstance(b, Solid) else (a, b))


def _intersect(a: Solid, b: Any) -> Intersection | ClippedSheet:
    if isinstance(b, Sheet):
        return _clip_sheet(b, a, keep_inside=True)
    return Intersection(_merge_operands(Intersection, (a, b)) if isinstance(b, Solid) else (a, b))


def _subtract(a: Solid, b: Solid) -> Difference:
    first = a.operands if isinstance(a, Difference) and a.motion == IDENTITY_MOTION else (a,)
    return Difference((*first, b))


def _clip_sheet(sheet: Sheet, solid: Any, *, keep_inside: bool) -> ClippedSheet:
    if not isinstance(solid, Solid):
        raise TypeError(f"{type(sheet).__name__}: only a solid can clip it, got {describe_kind(solid)}")
    return ClippedSheet(sheet, solid, "inside" if keep_inside else "outside")
