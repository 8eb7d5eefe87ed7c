"""What a check reports."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..._util.arrays import FloatArray
from ..._util.equality import compare_by_value
from ..._util.foreign_names import with_attribute_hints
from ..._util.hints import frozen_with_hints

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike

OVERLAP, SLIVER, COINCIDENCE, EMPTY, DIGITS = "overlap", "sliver", "near-coincidence", "empty", "lost digits"
UNDEFINED = "undefined"
KINDS = (OVERLAP, SLIVER, COINCIDENCE, EMPTY, DIGITS, UNDEFINED)


@with_attribute_hints
@frozen_with_hints
@compare_by_value()
@dataclass(frozen=True, eq=False)
class Finding:
    """Something that a scene's author may not have meant.

    kind       "overlap", "sliver", "near-coincidence", "empty", "lost digits" or "undefined"
    bodies     ids of the bodies concerned
    message    one sentence
    size       the longest common stretch, the thickness, or the relative difference; 0 for an empty body; the decimal
               digits that remain; the estimated volume of an undefined region
    size_error the standard error of that volume, as estimated by random points; 0 for other kinds
    origin, direction   (3,) a ray that shows it: ask `scene.spans(origin, direction)`; None where none does
    point      (3,) a point of an undefined region; None for other kinds
    """

    kind: str
    bodies: tuple[int, ...]
    message: str
    size: float
    origin: FloatArray | None = None
    direction: FloatArray | None = None
    point: FloatArray | None = None
    size_error: float = 0.0

    def __str__(self) -> str:
        if self.origin is None or self.direction is None:
            return f"{self.kind}: {self.message}"
        origin, direction = (", ".join(repr(float(c)) for c in row) for row in (self.origin, self.direction))
        return f"{self.kind}: {self.message}; ray from ({origin}) along ({direction})"


_LIST_HINT = (
    "they are a list, empty where nothing was found: `if not findings`, and each has kind, bodies, message, size"
)


class Findings(list[Finding]):
    """What `check` has found: a list, with what it has not looked for.

    not_looked_for   texts, each with its reason; empty where everything was

    Equal to a list of the same findings. `print` shows a line for each finding, and for what was not looked for.
    """

    def __init__(self, found: Iterable[Finding] = (), not_looked_for: Iterable[str] = ()) -> None:
        super().__init__(found)
        self.not_looked_for = tuple(not_looked_for)

    if not TYPE_CHECKING:  # else checkers would let any name be asked for

        def __getattr__(self, name: str) -> Any:
            raise AttributeError(f"'Findings' object has no attribute {name[:80]!r}: {_LIST_HINT}", name=name, obj=self)

    def __repr__(self) -> str:
        left = f", not looked for: {'; '.join(self.not_looked_for)}" if self.not_looked_for else ""
        return f"Findings({super().__repr__()}{left})"

    def __str__(self) -> str:
        lines = [str(finding) for finding in self] or ["nothing found"]
        return "\n".join(lines + [f"not looked for: {text}" for text in self.not_looked_for])


def body_titles(scene: SceneLike, bodies: tuple[int, ...]) -> str:
    """Bodies as a person would call them: 'body 3 (barrel)' or 'bodies 3 (barrel) and 5'."""
    items = scene.lowered.body_item
    names = [scene.bodies[int(items[body])].name for body in bodies]
    labels = [f"{body} ({name})" if name else f"{body}" for body, name in zip(bodies, names, strict=True)]
    listed = " and ".join([", ".join(labels[:-1]), labels[-1]] if len(labels) > 2 else labels)
    return f"body {labels[0]}" if len(labels) == 1 else f"bodies {listed}"
