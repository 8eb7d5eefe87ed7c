"""Steps of surfaces: the kernels' numbers and the lecture's, side by side."""

from __future__ import annotations

import math
from typing import Any

from ..engine.queries import recorded as kernels
from ..engine.tables import PLANE
from .line import Line
from .polynomial import Source
from .recording import Recording
from .steps import SurfaceStep


class Surfaces:
    """The surfaces on a ray, each worked out once."""

    def __init__(self, recording: Recording, line: Line) -> None:
        self.recording, self.line = recording, line
        self._known: dict[int, SurfaceStep] = {}

    def __getitem__(self, number: int) -> SurfaceStep:
        if number not in self._known:
            self._known[number] = self._step(number)
        return self._known[number]

    def __iter__(self) -> Any:
        return iter(self._known.values())

    def _step(self, number: int) -> SurfaceStep:
        scene, row = self.recording.scene, self.recording.surface(number)
        source = Source.of(scene, number)
        crosses, flat = row[kernels.CROSSES] == 1.0, source.kind == PLANE
        roots: tuple[float, ...] = ()
        if crosses:
            roots = (float(row[kernels.T]),) if flat else (float(row[kernels.LOW]), float(row[kernels.HIGH]))
        a, b, c, discriminant, foot = (math.nan if flat else float(row[k]) for k in range(kernels.FOOT + 1))
        return SurfaceStep(
            number, flat, a, b, c, discriminant, foot,
            height=float(row[kernels.HEIGHT]) if flat else math.nan,
            rate=float(row[kernels.RATE]) if flat else math.nan,
            roots=roots,
            outside=bool(row[kernels.OUTSIDE]) and not flat,
            careful=bool(row[kernels.CANCELS]),
            doubtful=bool(row[kernels.UNSURE]),
            least=float(row[kernels.LEAST]),
            starts=number == self.recording.start,
            source=source,
            line=self.line,
        )  # fmt: skip
