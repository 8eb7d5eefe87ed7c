"""One face of a solid as an open surface: thin mirrors, screens and shells of any quadric."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from .base import PrimitiveSheet, PrimitiveSolid, Solid
from .boxes import common
from .cells import All, Any_, Cell, Face, Not, SurfaceSheet, Tree, moved_uv
from .motion import STILL, Motion
from .planar import half_space_bounds
from .surface import PlaneSurface, Surface
from .validate import integer, shown, what
from .vector import Box, Vector


@dataclass(frozen=True)
class Wall(PrimitiveSheet):
    """The points of one face of a primitive `solid`, as an open surface: what of the face's surface bounds the solid.

    `face` is its number, as in ``hits.face``. Other solids cut it: ``Wall(solid, 0) & a - b``. A face of a Boolean
    solid is said so too: that of the primitive, kept inside (``&``) or outside (``-``) of the others.
    The normal is the solid's, outward. Own frame and uv: those of the solid. Face 0.
    """

    solid: Solid
    face: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.solid, Solid) or not getattr(self.solid, "combines", True):
            raise TypeError(f"Wall: solid must be a solid, got {what(self.solid)}")
        if not isinstance(self.solid, PrimitiveSolid):
            told = "Wall(part, face) & others, or - others, is a face of a combination"
            raise TypeError(f"Wall: solid must be a primitive, got {what(self.solid)}; {told}")
        object.__setattr__(self, "face", integer("Wall", "face", self.face, 0))
        found = sorted({face.number for face in _faces(self.solid.tree())})
        if self.face not in found:
            numbers = ", ".join(map(str, found))
            raise ValueError(
                f"Wall: face must be one of {type(self.solid).__name__}'s, {numbers}, got {shown(self.face)}"
            )
        (first, *_), *others = self._cuts()
        if not all(_is_same(first.surface, other.surface) for other, *_ in others):
            raise ValueError(f"Wall: face {self.face} of {type(self.solid).__name__} is on more than one surface")

    @property
    def placement(self) -> Motion:
        return self.solid.under(STILL)

    def _cuts(self) -> list[tuple[Face, bool, tuple[Tree, ...]]]:
        """(the face, whether its cell counts inside, what all must hold there) wherever it bounds the solid."""
        assert isinstance(self.solid, PrimitiveSolid)
        return _bounding(self.solid.tree(), self.face, True, ())

    def sheet(self, motion: Motion) -> SurfaceSheet:
        cuts = self._cuts()
        first, counts, _ = cuts[0]
        held = [All(rest) for _, _, rest in cuts]
        clip = _moved(held[0] if len(held) == 1 else Any_(tuple(held)), motion)
        side = first.inside if counts else -first.inside
        none = isinstance(clip, All) and not clip.parts
        return SurfaceSheet(first.surface.moved(motion), None if none else clip, side, uv=moved_uv(first.uv, motion))

    def support(self, direction: Vector) -> float:
        assert isinstance(self.solid, PrimitiveSolid)
        return self.solid.support(direction)

    def bounds_under(self, outer: Motion) -> Box:
        """Those of the solid, and of the face's plane if it is flat."""
        motion = self.under(outer)
        box = self.solid.bounds_under(self.motion.then(outer))
        surface = self._cuts()[0][0].surface
        return common([box, half_space_bounds(surface.moved(motion))]) if isinstance(surface, PlaneSurface) else box


def _faces(tree: Tree) -> list[Face]:
    """All faces of all cells."""
    if isinstance(tree, Cell):
        return list(tree.faces)
    return [face for part in ((tree.part,) if isinstance(tree, Not) else tree.parts) for face in _faces(part)]


def _is_same(a: Surface, b: Surface) -> bool:
    """Are two surfaces one, whatever their sense?"""
    if isinstance(a, PlaneSurface) and isinstance(b, PlaneSurface):
        (x, y, z), (u, v, w) = a.normal, b.normal
        return any((sign * u, sign * v, sign * w, sign * b.offset) == (x, y, z, a.offset) for sign in (1, -1))
    return a == b


def _bounding(tree: Tree, face: int, counts: bool, held: tuple[Tree, ...]) -> list[tuple[Face, bool, tuple[Tree, ...]]]:
    """Where a face decides what is inside.

    That is where its cell's other faces hold, all other parts of every `All` above, and no other of any `Any_`.
    """
    if isinstance(tree, Not):
        return _bounding(tree.part, face, not counts, held)
    if isinstance(tree, Cell):
        mine = [one for one in tree.faces if one.number == face]
        return [(one, counts, (*held, _others(tree, one))) for one in mine]
    found = []
    for part in tree.parts:
        others = [other for other in tree.parts if other is not part]
        decided: list[Tree] = [other if isinstance(tree, All) else _negated(other) for other in others]
        found += _bounding(part, face, counts, (*held, *decided))
    return found


def _others(cell: Cell, face: Face) -> Tree:
    """The faces of a cell but for one."""
    rest = tuple(one for one in cell.faces if one is not face)
    return Cell(rest) if rest else All(())


def _negated(tree: Tree) -> Tree:
    return tree.part if isinstance(tree, Not) else Not(tree)


def _moved(tree: Tree, motion: Motion) -> Any:
    """A tree carried by a motion, for clipping: its faces have no numbers of their own."""
    if isinstance(tree, Cell):
        return Cell(tuple(replace(one, surface=one.surface.moved(motion), number=0) for one in tree.faces))
    if isinstance(tree, Not):
        return _negated(_moved(tree.part, motion))
    parts = [_moved(part, motion) for part in tree.parts]
    flat: list[Tree] = []
    for part in parts:
        flat.extend(part.parts if isinstance(part, type(tree)) else (part,))
    return flat[0] if len(flat) == 1 else type(tree)(tuple(flat))
