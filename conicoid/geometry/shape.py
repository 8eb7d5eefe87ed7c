"""What every shape has: motions, bounds, Boolean operators, a name in scene files.

To add a primitive, subclass `Solid` or `Sheet` in a file of this folder and give data: fields,
`tree` (or `sheet`) and `support` in the shape's own frame, and `placement` where the fields put
that frame somewhere. Motions, Booleans, bounds, rays, uv, scene files and the contract tests
then work.
"""

from __future__ import annotations

import dataclasses
import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self, overload

import numpy as np

from .._util.arrays import BoxEnds, Vector
from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import operator_error, shape_attribute_error
from .._util.hints import frozen_with_hints, with_call_hints
from .._util.pickling import pickle_state, restore_state
from .._util.validation import format_value
from .bounds.aabb import Bounds
from .bounds.support import bound_by_support
from .cell import PolygonSheet, SurfaceSheet, Tree
from .transform import IDENTITY_MOTION, Motion
from .transform import apply_about as moved_about

if TYPE_CHECKING:
    from .csg import ClippedSheet, Complement, Difference, Intersection, Painted, Union


def _check_motion_first(check: Callable[[Any], None]) -> Callable[[Any], None]:
    """What checks the fields of a class, and before that the one that all classes have."""

    @functools.wraps(check)
    def checked(self: Any) -> None:
        self._check_motion()
        check(self)

    return checked


REGISTERED: dict[str, type[Shape]] = {}
"""Scene-file name -> class, for the shapes whose files have been imported; `shapes.REGISTRY` has all."""


@dataclass(frozen=True)
class Shape(ABC):
    """A solid or a sheet, immutable. `motion` holds the steps it was moved by."""

    motion: Motion = field(default=IDENTITY_MOTION, kw_only=True, repr=False)
    abstract: ClassVar[bool] = True

    def __init_subclass__(cls, abstract: bool = False) -> None:
        cls.abstract = abstract
        if cls.__repr__ is Shape.__repr__:
            setattr(cls, "__repr__", Shape.__repr__)  # noqa: B010 (a dataclass leaves one that is there)
        if "__post_init__" in vars(cls):
            setattr(cls, "__post_init__", _check_motion_first(vars(cls)["__post_init__"]))  # noqa: B010 (as above)
        known = REGISTERED.get(cls.__name__)
        is_ours = cls.__module__.startswith(f"{__package__}.")
        if not abstract and (known is None or not is_ours or known.__module__.startswith(f"{__package__}.")):
            REGISTERED[cls.__name__] = cls  # in place of a user's own of this name only another of theirs

    def __post_init__(self) -> None:
        self._check_motion()

    def _check_motion(self) -> None:
        frozen_with_hints(type(self))
        if not isinstance(self.motion, Motion):
            expected = "left out: shape.translate(...), .rotate(...), .scale(...) and .transform(...) move it"
            raise TypeError(f"{type(self).__name__}: motion must be {expected}; got {format_value(self.motion)}")

    def __getstate__(self) -> dict[str, Any]:
        return pickle_state(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore_state(self, state)

    def __repr__(self) -> str:
        """The fields as a call has them, and the steps that it was moved by."""
        shown = [each.name for each in dataclasses.fields(self) if each.repr]
        fields = ", ".join(f"{name}={getattr(self, name)!r}" for name in shown)
        return f"{type(self).__qualname__}({fields}){self.motion.calls}"

    @property
    def placement(self) -> Motion:
        """The motion that takes the shape's own frame to where its fields put it."""
        return IDENTITY_MOTION

    def under(self, outer: Motion = IDENTITY_MOTION) -> Motion:
        """Own frame to world, when the whole shape is moved by `outer` as well."""
        return self._placed if not outer.steps else self.motion.then(outer).placed(self.placement)

    @cached_property
    def kept(self) -> dict[str, Any]:
        """What later stages have worked out for the shape, by name: it never changes, as the shape does not."""
        return {}

    @cached_property
    def _placed(self) -> Motion:
        return self.motion.placed(self.placement)

    def _moved(self, motion: Motion) -> Self:
        """The shape under another motion: its fields have been checked and are those of this one."""
        motion.check(type(self).__name__)
        return self._with_motion(motion)

    def _with_motion(self, motion: Motion) -> Self:
        """`_moved`, by a motion that was checked."""
        kind = type(self)
        made = kind.__new__(kind)
        vars(made).update(pickle_state(self), motion=motion)
        return made

    @with_call_hints
    def translate(self, offset: Any) -> Self:
        """Moved by `offset`, three numbers."""
        return self._moved(self.motion.translate(offset))

    @with_call_hints
    def rotate(self, axis: Any, degrees: float, *, about: Any = None) -> Self:
        """Turned about an axis through the world's origin, or through the point `about`.

        axis: three numbers, its direction, of any length; or "x", "y", "z", "-x", "-y", "-z".
        degrees: the angle, right-handed: counter-clockwise for one who sees the axis come towards him.
        about: a point of the axis, three numbers: the shape is moved by -about, turned and moved back, exactly.
        """
        return self._moved(moved_about("rotate", self.motion, about, lambda motion: motion.rotate(axis, degrees)))

    @with_call_hints
    def scale(self, factors: Any, *, about: Any = None) -> Self:
        """Scaled about the world's origin, or about the point `about`.

        factors: one number for all axes, or three; negative ones mirror, 0 is refused.
        about: the point that stays where it is, three numbers.
        """
        return self._moved(moved_about("scale", self.motion, about, lambda motion: motion.scale(factors)))

    @with_call_hints
    def transform(self, matrix: Any) -> Self:
        """Carried by an affine motion.

        matrix: (4, 4), invertible, with the last row (0, 0, 0, 1); points are columns (x, y, z, 1).
        """
        return self._moved(self.motion.transform(matrix))

    @property
    def bounds(self) -> Bounds:
        """(low, high), two (3,) arrays: the tightest box, ±inf where unbounded; low > high if empty."""
        low, high = self._bounds
        return Bounds(low.copy(), high.copy())

    @cached_property
    @ignore_fp_errors
    def _bounds(self) -> BoxEnds:
        return self.bounds_under(IDENTITY_MOTION)

    @abstractmethod
    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Bounds of the shape after a further motion."""

    def __bool__(self) -> NoReturn:
        raise TypeError(
            f"{type(self).__name__} is neither true nor false: shapes combine with & | - ~, "
            "not with `and`, `or`, `not`; whether there is one: `shape is not None`"
        )

    if not TYPE_CHECKING:  # else checkers would let any attribute be asked for

        def __getattr__(self, name: str) -> Any:
            raise shape_attribute_error(self, name)

        def __add__(self, other: Any) -> Any:
            return _reject_operator(self, "+", other)

        def __mul__(self, other: Any) -> Any:
            return _reject_operator(self, "*", other)

        def __radd__(self, other: Any) -> Any:
            return _reject_operator(self, "+", other)

        def __neg__(self) -> Any:
            raise TypeError(
                f"{type(self).__name__}: signs mean nothing here: a shape is its inside, ~shape the outside"
            )

        def __xor__(self, other: Any) -> Any:
            told = "^ is no operation of shapes; (a | b) - (a & b) is what either of two has alone"
            raise TypeError(f"{type(self).__name__}: {told}")

        def __contains__(self, other: Any) -> bool:
            told = f"points are asked of a scene: co.Scene({type(self).__name__.lower()}).contains(points)"
            raise TypeError(f"{type(self).__name__}: `in` means nothing here; {told}")

        __rmul__, __pos__, __rxor__ = __mul__, __neg__, __xor__

    is_sheet: ClassVar[bool]
    """True for open surfaces, which bound no volume."""


def _reject_operator(shape: Shape, operator: str, other: Any) -> Any:
    """NotImplemented, unless there is something to tell."""
    told = operator_error(shape, operator, other)
    if told is None:
        return NotImplemented
    raise told


def _refuse_body(shape: Shape, operator: str, other: Any) -> None:
    """TypeError for what is no shape and can be told of: a body, or an offset."""
    if not isinstance(other, Shape) and (told := operator_error(shape, operator, other)) is not None:
        raise told


class Primitive(Shape, abstract=True):
    """A shape with a frame of its own and a support function there."""

    @abstractmethod
    def support(self, direction: Vector) -> float:
        """sup of direction·p over the shape in its own frame; inf where unbounded, -inf if empty."""

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Bounds of the shape after a further motion (`ends`)."""
        ends = self.ends(self.under(outer))
        return np.array(ends[:3]), np.array(ends[3:])

    def ends(self, motion: Motion) -> list[float]:
        """(low x, y, z, high x, y, z) of the shape where a motion puts its own frame."""
        return bound_by_support(self.support, motion)


class Solid(Shape, abstract=True):
    """A shape with an inside. Solids combine with ``|``, ``&``, ``-`` and ``~``."""

    is_sheet = False
    combines: ClassVar[bool] = True

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Bounds of the complement: all of space, unless the shape knows better (half-spaces do)."""
        del outer
        return np.full(3, -np.inf), np.full(3, np.inf)

    def __or__(self, other: Solid) -> Union:
        _refuse_body(self, "|", other)
        from .csg import union

        return union(self, other)

    @overload
    def __and__(self, other: Solid) -> Intersection: ...

    @overload
    def __and__(self, other: Sheet) -> ClippedSheet: ...

    def __and__(self, other: Any) -> Intersection | ClippedSheet:
        _refuse_body(self, "&", other)
        from .csg import intersection

        return intersection(self, other)

    def __sub__(self, other: Solid) -> Difference:
        _refuse_body(self, "-", other)
        from .csg import difference

        return difference(self, other)

    def __invert__(self) -> Complement:
        from .csg import Complement

        return Complement(self)

    @with_call_hints
    def painted(self, material: Any) -> Painted:
        """The solid with its faces in a material of their own: ``body - bore.painted(red)`` has red cuts.

        material: a Material or a colour, as of a `Body`.
        """
        from .csg import Painted

        return Painted(self, material)


class PrimitiveSolid(Solid, Primitive, abstract=True):
    """A solid given by a tree of cells in its own frame."""

    @abstractmethod
    def tree(self) -> Tree:
        """The cells, in the shape's own frame."""


class Sheet(Shape, abstract=True):
    """An open surface. ``sheet & solid`` and ``sheet - solid`` clip it."""

    is_sheet = True

    def __and__(self, solid: Solid) -> ClippedSheet:
        from .csg import clip

        return clip(self, solid, keep_inside=True)

    def __rand__(self, solid: Solid) -> ClippedSheet:
        return self & solid

    def __sub__(self, solid: Solid) -> ClippedSheet:
        from .csg import clip

        return clip(self, solid, keep_inside=False)

    def __or__(self, other: Any) -> Any:
        raise TypeError(f"{type(self).__name__} is a sheet: only `sheet & solid` and `sheet - solid` clip it")

    __ror__ = __rsub__ = __or__

    def __invert__(self) -> Any:
        raise TypeError(f"{type(self).__name__} is a sheet and has no complement")


class PrimitiveSheet(Sheet, Primitive, abstract=True):
    """A sheet given by one surface and what clips it, in its own frame."""

    @abstractmethod
    def sheet(self, motion: Motion) -> SurfaceSheet | PolygonSheet:
        """The sheet, carried by `motion` from its own frame to the world."""


def leaves(shape: Shape) -> Iterator[Shape]:
    """The primitives a shape is made of, left to right."""
    pending = [shape]
    while pending:
        node = pending.pop()
        operands: tuple[Shape, ...] | None = getattr(node, "operands", None)
        if operands is None:
            yield node
        else:
            pending.extend(reversed(operands))
