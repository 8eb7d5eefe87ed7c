"""`Finding` and `Findings`: the result of `check`."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

from ..._util.arrays import FloatArray
from ..._util.records import compare_by_value, dataclass

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike

OVERLAP, SLIVER, COINCIDENCE, EMPTY, DIGITS = "overlap", "sliver", "near-coincidence", "empty", "lost digits"
UNDEFINED = "undefined"
KINDS = (OVERLAP, SLIVER, COINCIDENCE, EMPTY, DIGITS, UNDEFINED)
"""Every `Finding.kind`, in the order of the report."""


@compare_by_value()
@dataclass(frozen=True, eq=False)
class Finding:
    """A probable mistake in a scene.

    Attributes
    ----------
    kind : str
        "overlap", "sliver", "near-coincidence", "empty", "lost digits" or "undefined".
    bodies : tuple of int
        Ids of the bodies concerned.
    message : str
        One sentence.
    size : float
        By kind: the longest common stretch, the thickness, the relative difference, 0, the decimal digits that remain,
        the estimated volume of the region.
    size_error : float
        Standard error of that volume, which random points estimate; 0 for other kinds.
    origin, direction : float64 (3,) or None
        A ray that shows the finding in `scene.spans(origin, direction)`; None if there is none.
    point : float64 (3,) or None
        A point of an undefined region; None for other kinds.
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


class Findings(list[Finding]):
    """The findings of `check`: a list, equal to a plain list of the same findings.

    `print` shows a line for each finding, and one for each skipped check.

    Parameters
    ----------
    found : iterable of Finding
        The findings.
    omissions : iterable of str
        Checks that were skipped, each with its reason.

    Attributes
    ----------
    omissions : tuple of str
        Checks that were skipped, each with its reason; empty if all were done.
    """

    def __init__(self, found: Iterable[Finding] = (), omissions: Iterable[str] = ()) -> None:
        super().__init__(found)
        self.omissions = tuple(omissions)

    def __repr__(self) -> str:
        skipped = f", not looked for: {'; '.join(self.omissions)}" if self.omissions else ""
        return f"Findings({super().__repr__()}{skipped})"

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        from ..._util.text import html_table

        rows = ((one.kind, one.bodies, one.size, one.message) for one in self)
        skipped = "".join(f"<p>not looked for: {escape(text)}</p>" for text in self.omissions)
        return html_table(("kind", "bodies", "size", "message"), rows, len(self)) + skipped

    def __str__(self) -> str:
        lines = [str(finding) for finding in self] or ["nothing found"]
        return "\n".join(lines + [f"not looked for: {text}" for text in self.omissions])


def body_titles(scene: SceneLike, bodies: tuple[int, ...]) -> str:
    """Return bodies in words: 'body 3 (barrel)' or 'bodies 3 (barrel) and 5'."""
    items = scene._prepared.lowered.body_item
    names = [scene.bodies[int(items[body])].name for body in bodies]
    labels = [f"{body} ({name})" if name else f"{body}" for body, name in zip(bodies, names, strict=True)]
    listed = " and ".join([", ".join(labels[:-1]), labels[-1]] if len(labels) > 2 else labels)
    return f"body {labels[0]}" if len(labels) == 1 else f"bodies {listed}"
