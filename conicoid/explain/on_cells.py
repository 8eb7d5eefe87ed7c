"""Steps of cells: what planes and quadric leave of a ray, which crossings are true, and which case it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from ..engine.faces import cell_faces, numbers_of, plane_faces, sides_of
from ..engine.queries import recorded as kernels
from .line import Line
from .on_surfaces import Surfaces
from .recording import Recording
from .slabs import slab_pairs
from .steps import NO_ROOT, PLANES, TOUCHED, Candidate, CellStep, FaceStep, SurfaceStep

CASES = {"ccbb": 1, "cbcb": 2, "cbbc": 3, "bcbc": 4, "bccb": 5, "bbcc": 6}
"""The order of the crossings with caps and body, and the number of the case (the Clemson notes)."""


def cell_step(recording: Recording, surfaces: Surfaces, cell: int, letter: str, line: Line) -> CellStep:
    """A cell on the ray."""
    row = recording.cell(cell)
    faces = _faces(recording, surfaces, cell)
    spans = tuple(
        (t_in, recording.face_at(p)[1], t_out, recording.face_at(q)[1]) for t_in, p, t_out, q in recording.ends(row)
    )
    slab = float(row[kernels.SLAB_IN]), float(row[kernels.SLAB_OUT])
    curved = next((face for face in faces if not face.surface.flat), None)
    return CellStep(
        cell, letter, faces, slab, spans, "" if spans else _why(curved, slab, line),
        _case(curved, faces), bool(row[kernels.CELL_UNSURE]),
        float(row[kernels.CELL_OFF]), line,
    )  # fmt: skip


def _faces(recording: Recording, surfaces: Surfaces, cell: int) -> tuple[FaceStep, ...]:
    """The faces of a cell, by their numbers."""
    tables, found = recording.tables, []
    quadric = int(tables.cell_quadric[cell])
    if quadric >= 0:
        step, inside = surfaces[quadric], int(sides_of(cell_faces(tables, cell)))
        entered, left = step.roots[:1], step.roots[1:]
        if step.outside == (inside > 0):
            entered, left = left, entered
        found.append(FaceStep(int(numbers_of(cell_faces(tables, cell))), step, inside, _finite(entered), _finite(left)))
    for place in range(int(tables.cell_first[cell]), int(tables.cell_first[cell + 1])):
        step, inside = surfaces[int(tables.plane_surface[place])], int(sides_of(plane_faces(tables, place)))
        enters = (step.rate < 0) == (inside > 0)
        found.append(
            FaceStep(
                int(numbers_of(plane_faces(tables, place))),
                step,
                inside,
                step.roots if enters else (),
                () if enters else step.roots,
            )
        )
    return tuple(found)


def _finite(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(value for value in values if math.isfinite(value))


def candidates_of(faces: Sequence[FaceStep], spans: Any, line: Line) -> tuple[Candidate, ...]:
    """All crossings with faces in order of t, false ones with a face that they lie outside of (NA8FIR)."""
    true = {(t, face, True) for t, face, _, _ in spans} | {(t, face, False) for _, _, t, face in spans}
    found = []
    for face in faces:
        for entering, places in ((True, face.entered), (False, face.left)):
            for t in places:
                is_true = (t, face.face, entering) in true
                found.append(Candidate(t, face.face, entering, None if is_true else _outside_of(faces, face, t, line)))
    return tuple(sorted(found, key=lambda one: (one.t, one.face)))


def _outside_of(faces: Sequence[FaceStep], own: FaceStep, t: float, line: Line) -> int:
    """The face whose function says most strongly that a point lies outside; -1 where it lies on an edge."""
    point = line.at(t)
    values = [(one.inside * one.surface.polynomial.value(point), one.face) for one in faces if one is not own]
    value, face = max(values, default=(Fraction(0), -1))
    return face if value > 0 else -1


def _why(curved: FaceStep | None, slab: tuple[float, float], line: Line) -> str:
    """Why nothing of the ray is in the cell."""
    if not slab[0] < slab[1] or curved is None or curved.surface.roots:
        return PLANES
    return touched_or_not(curved.surface, line)


def touched_or_not(step: SurfaceStep, line: Line) -> str:
    """NO_ROOT, or TOUCHED where the discriminant is zero, exactly."""
    a, b, c = step.polynomial.on_ray(line.origin, line.direction)
    return TOUCHED if (a or b) and b * b == a * c else NO_ROOT


def _case(curved: FaceStep | None, faces: Sequence[FaceStep]) -> int:
    """Which of the six cases of body and caps it is; 0 for the special ones and for other cells."""
    if curved is None or len(faces) != 3 or curved.surface.outside == (curved.inside > 0):
        return 0
    pairs = slab_pairs(faces)
    if len(pairs) != 1:
        return 0
    body = curved.entered + curved.left
    caps = [t for k in pairs[0] for t in faces[k].entered + faces[k].left]
    if len(body) != 2 or len(caps) != 2 or len({*body, *caps}) < 4:
        return 0
    order = sorted([(t, "b") for t in body] + [(t, "c") for t in caps])
    return CASES["".join(name for _, name in order)]
