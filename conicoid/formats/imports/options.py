"""What an import may be asked for, the same for every format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from ...shapes.suggestion import one_of
from ...shapes.validate import callback, flag, integer, shown


class Most(NamedTuple):
    """How many bodies there may be. Those that are others moved take a seventh of the memory, and next to no time."""

    bodies: int
    alone: int  # that are no others moved

    @classmethod
    def of(cls, max_bodies: int | None) -> Most:
        """As many as a user says, of either kind; None for what fits into 2 or 3 GB."""
        return MOST if max_bodies is None else cls(max_bodies, max_bodies)


MOST = Most(4_000_000, 500_000)


@dataclass(frozen=True)
class Options:
    """How a file of another program is read.

    void: are parts without material invisible bodies, so that `scene.body_at` finds every one of them?
    max_bodies: what expands into more is refused, before they are made; None for 4,000,000, of which 500,000 are no
    others moved, and for molecules, whose balls are cheap, no limit.
    strict: is whatever is not read as the file says an error, in place of a remark?
    only: only volumes on whose path of names this text or pattern ("detector/*") is; None for all.
    depth: how many levels of nested volumes are opened; what lies deeper is part of the volume around it. None for all.
    smooth: are circles round where a file asks for prisms of so many sides (OpenSCAD's $fn)?
    entities: are files in its folder read that an XML file takes in by entities, as parts of GDML files?
    progress: progress(done, count) is called with numbers of bodies.
    """

    void: bool = True
    max_bodies: int | None = None
    strict: bool = False
    only: str | None = None
    depth: int | None = None
    smooth: bool = False
    entities: bool = False
    progress: Callable[[int, int], Any] | None = None

    def __post_init__(self) -> None:
        for name in ("void", "strict", "smooth", "entities"):
            flag("load", name, getattr(self, name))
        if self.max_bodies is not None:
            integer("load", "max_bodies", self.max_bodies, 1)
        if self.depth is not None:
            integer("load", "depth", self.depth, 0)
        if self.only is not None and (not isinstance(self.only, str) or not self.only):
            raise ValueError(f"load: only must be a pattern of names or None, got {shown(self.only)}")
        callback("load", "progress", self.progress)

    @property
    def most(self) -> Most:
        """How many bodies there may be, of formats whose bodies are not cheap."""
        return Most.of(self.max_bodies)

    @classmethod
    def of(cls, **options: Any) -> Options:
        """By name. Raises TypeError for one that there is not."""
        for name in options:
            one_of("load", "option", name, [field.name for field in fields(cls)])
        return cls(**options)

    def refuse_others(self, what: str, *known: str) -> None:
        """ValueError for what is asked for and means nothing in a format; progress and max_bodies always do."""
        for field in fields(self):
            if field.name in (*known, "progress", "max_bodies") or getattr(self, field.name) == field.default:
                continue
            raise ValueError(f"load: {field.name} means nothing for {what}: there are {', '.join(known)}")
