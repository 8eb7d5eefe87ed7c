"""`scene.explain` traces one ray and shows the steps of the kernels; `scene.surface` describes a surface of a scene."""

from __future__ import annotations

import html
import math
import os
from functools import cached_property
from typing import Any

import numpy as np

from ..._util.files import write_text
from ..._util.records import dataclass
from ..._util.validation import check_path as checked_path, format_value
from ...geometry.entries import as_index, find_entry
from ...geometry.general_quadric import Classification
from ...kernels.faces import cell_faces, numbers_of, plane_faces, sides_of
from ...kernels.programs import cells_of_leaves, leaves_of_programs, row_of_leaf
from ...kernels.surface.exact_crossing import CROSSES
from ...kernels.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET, Tables
from ...prepare.prepared_scene import PreparedScene
from ...queries.exact.doubtful_rays import ranks_of
from ...queries.ray_queries import as_rays
from ...queries.rays import Rays
from ...queries.scene_protocol import SceneLike
from . import ray_records as kernels
from .body_steps import (
    KINDS,
    BodySteps,
    SurfaceSteps,
    ball_miss_step,
    ball_test,
    box_miss_step,
    box_test,
    finish_step,
    merge_missed_step,
)
from .document import Block, html_of, text_of
from .figure import Figure, figure_of
from .polynomial import ExactRay, SurfaceSource
from .ray_records import RayRecording
from .steps import BodyStep, Crossing, Decision, RankedPlace, RayRecord, Span


@dataclass(frozen=True)
class Explanation(RayRecord):
    """One ray step by step: how every body is hit or missed, and why. `scene.explain` returns it.

    `str()` is the text, a notebook shows it as HTML, and `figure()` is a drawing. `explanation[3]` and
    `explanation["ball"]` are the steps of one body.

    Attributes
    ----------
    origin, direction : tuple of 3 floats
        The ray.
    t_min, t_max : float
        The open interval.
    hit : Hits
        The first hit, as `scene.first_hit` returns it.
    bodies : tuple of BodyStep
        Steps of the bodies that the tree of boxes does not leave out, and of the first 16 that it does.
    misses : int
        Number of further bodies that the tree leaves out.
    surfaces : dict of int to SurfaceStep
        Steps of the surfaces that were computed, by number.
    crossings : tuple of Crossing
        All crossings in order, as `scene.crossings` returns them.
    decision : Decision
        Which formulas decided the result, and its error bound.
    scene : Scene
        The scene.
    """

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The text as blocks: headings, lines and tables."""
        from .narrative import blocks_of

        return tuple(blocks_of(self))

    @property
    def text(self) -> str:
        """The whole explanation as text for a terminal."""
        return text_of(self.blocks)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        found = "a miss" if not self.hit.hit else f"t={float(self.hit.t)!r}"
        return f"Explanation(origin={self.origin}, direction={self.direction}, {found}; print it for all steps)"

    def figure(self, body: int | str | None = None, width: int = 640) -> Figure:
        """Draw the ray in a plane: the exact sections of the bodies, and the crossings with their t.

        Parameters
        ----------
        body : int or str, optional
            Number or name of the body through whose axis the plane goes. Default: the body that is hit first.
        width : int
            Pixels, 200 to 4000.

        Returns
        -------
        Figure

        Raises
        ------
        LookupError
            If the explanation has no step of the body.
        TypeError, ValueError
            For a wrong width.
        """
        return figure_of(self, body, width)

    @cached_property
    def svg(self) -> str:
        """`figure()` as the text of an SVG picture."""
        return self.figure().svg

    @property
    def html(self) -> str:
        """The whole explanation with its figure as self-contained HTML: a part of a page."""
        return html_of(self.blocks, self.svg)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the explanation to a file.

        Parameters
        ----------
        path : str or os.PathLike
            The ending selects the format: a page (.html), the drawing alone (.svg) or the text (.txt).

        Raises
        ------
        ValueError
            For other endings.
        OSError
            If the file cannot be written.
        """
        name = checked_path("save", path)
        suffix = os.path.splitext(name)[1].lower()
        if suffix == ".html":
            content = page_of("A ray explained", self.html)
        elif suffix == ".svg":
            content = self.svg
        elif suffix == ".txt":
            content = self.text
        else:
            raise ValueError(
                f"save: path of an explanation must end with .html, .svg or .txt, got {format_value(str(path))}"
            )
        write_text(name, content)

    def _repr_html_(self) -> str:
        return self.html


def page_of(title: str, body: str) -> str:
    """Return a whole HTML page with a title and a body."""
    style = "body { margin: 2rem auto; max-width: 60rem; padding: 0 1rem; }"
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{style}</style></head><body>\n{body}\n</body></html>\n"
    )


def as_floats_tuple(values: Any) -> tuple[float, ...]:
    """Return an array of floats as a tuple."""
    return tuple(np.asarray(values, np.float64).tolist())


# `scene.explain`: one ray traced by the queries, and the numbers of the kernels collected into steps.

MOST_MISSED = 16
"""Bodies left out by the tree that get a step each."""
FEW_BODIES = 8
"""A scene of no more bodies also computes the steps of those that the tree leaves out."""
_LONGEST_REPR = 160
"""Characters of a shape's repr that are shown."""


def explain(
    scene: SceneLike, origin: Any, direction: Any, t_min: Any, t_max: Any, body: int | str | None
) -> Explanation:
    """Explain a single ray in the open interval t_min < t < t_max.

    Parameters
    ----------
    scene : Scene
    origin, direction : (3,)
        Or a `Rays` of one ray.
    t_min, t_max : float
    body : int, str or None
        The number or name of the only body to explain; None for all.

    Raises
    ------
    ValueError
        For several rays.
    """
    ray = as_rays("explain", origin, direction)
    if ray.shape:
        raise ValueError(
            f"explain: origin and direction must be one ray, got rays of shape {ray.shape}; rays[i] is one of them"
        )
    recording = RayRecording(scene._prepared, ray, t_min, t_max)
    origin, direction = as_floats_tuple(ray.origins), as_floats_tuple(ray.directions)
    line = ExactRay.of(origin, direction, recording.t_min, recording.t_max)
    surfaces = SurfaceSteps(recording, line)
    selection = None if body is None else _body_range(scene, body)
    # The results of the queries, which exact arithmetic may have decided
    hit = scene.first_hit(ray, t_min=recording.t_min, t_max=recording.t_max)
    crossings, spans = _trace_all(scene, ray, recording)
    first = Crossing(float(hit.t), int(hit.body), int(hit.face), int(hit.surface), bool(hit.entering))
    # The steps from the numbers of the float formulas, then completed by these results
    steps, missed = _steps(scene, recording, surfaces, line, selection)
    completed = tuple(finish_step(step, crossings, spans, first) for step in steps)
    decision = _decision(recording, surfaces, hit)
    return Explanation(
        origin, direction, recording.t_min, recording.t_max, hit, completed, missed,
        {step.number: step for step in surfaces}, tuple(crossings), decision, scene,
    )  # fmt: skip


def _body_range(scene: SceneLike, body: Any) -> range:
    """Return the numbers of the bodies that a number or a name stands for; LookupError if there are none."""
    if isinstance(body, str):
        entry = find_entry(scene.bodies, body)
        firsts = scene._firsts
        return range(int(firsts[entry]), int(firsts[entry + 1]))
    scene.body(body)
    return range(int(body), int(body) + 1)


def _trace_all(scene: SceneLike, ray: Rays, recording: RayRecording) -> tuple[list[Crossing], dict[int, list[Span]]]:
    """Return all crossings in order, and the spans by body, as the queries give them."""
    limits = dict(t_min=recording.t_min, t_max=recording.t_max)
    crossings, inside = scene.crossings(ray, **limits), scene.spans(ray, **limits)
    columns = crossings.t, crossings.body, crossings.face, crossings.surface, crossings.entering, crossings.t_error
    rows = zip(*(column.tolist() for column in columns), strict=True)
    spans: dict[int, list[Span]] = {}
    ends_of = inside.body, inside.t_enter, inside.t_exit, inside.enter_clipped, inside.exit_clipped
    for number, *ends in zip(*(column.tolist() for column in ends_of), strict=True):
        spans.setdefault(number, []).append(Span(*ends))
    return [Crossing(*row) for row in rows], spans


def _steps(
    scene: SceneLike, recording: RayRecording, surfaces: SurfaceSteps, line: ExactRay, selection: range | None
) -> tuple[list[BodyStep], int]:
    """Return the steps of bodies whose ball the ray hits and of the first that it misses, and the number of others.

    `reached` holds how far the ray gets with each body: to its leaf of the tree, or into the ball around it.
    """
    reached, balls = recording.walk()
    tables, boxes = recording.tables, scene._prepared.lowered.boxes
    work, selected = BodySteps(recording, surfaces, line), np.ones(len(boxes), np.bool_)
    # Other bodies than the selected ones are treated as absent
    if selection is not None:
        selected[: selection.start], selected[selection.stop :] = False, False
    hits = np.flatnonzero(selected & (reached == kernels.IN_BALL))
    misses = np.flatnonzero(selected & (reached != kernels.IN_BALL))
    steps = []
    # In the order of the bodies' numbers
    for entry in sorted([*hits.tolist(), *misses[:MOST_MISSED].tolist()]):
        step = _initial_step(scene, entry, int(tables.entry_kind[entry]))
        if reached[entry] == kernels.IN_BALL:
            steps.append(work.step(entry, step))
            continue
        box = box_test(boxes[entry].tolist(), line)
        # The tree tests the box of a leaf first, then the ball of a body
        if reached[entry] == kernels.REACHED and not box.missed:
            left_out = ball_miss_step(step, box, ball_test(balls[entry].tolist(), line))
        else:
            left_out = box_miss_step(step, box)
        if selection is not None or len(boxes) <= FEW_BODIES:
            left_out = merge_missed_step(left_out, work.step(entry, step))
        steps.append(left_out)
    return steps, max(0, len(misses) - MOST_MISSED)


def _initial_step(scene: SceneLike, number: int, kind: int) -> BodyStep:
    """Return a step with the number, name, shape and kind of a body alone."""
    body = scene.body(number)
    shape = repr(body.shape)
    shape = shape if len(shape) <= _LONGEST_REPR else f"{shape[:_LONGEST_REPR]} ..."
    return BodyStep(number, body.name or f"{type(body.shape).__name__} {number}", shape, KINDS[kind], "", "")


def _decision(recording: RayRecording, surfaces: SurfaceSteps, hit: Any) -> Decision:
    """Return which formulas decided; the first hit may be certain where a crossing behind it is not."""
    error, doubtful = (float(hit.t_error) if hit.hit else 0.0), recording.is_first_doubtful(hit)
    if not (doubtful or recording.is_doubtful()):
        return Decision("floats", "floats", error)
    # Ranks of a surface's crossings stand at first[number]: one of a plane, two of a curved surface
    ranks, exact = ranks_of(recording.scene, recording.arrays, 0)
    places = []
    for step in surfaces:
        number = step.number
        # Surfaces that the ray does not cross have no rank
        if ranks.verdict[2 * number] != CROSSES:
            continue
        first = int(ranks.first[number])
        for k in (first,) if step.flat else (first, first + 1):
            if math.isfinite(ranks.t[k]):
                # From t of the traced ray to t of the given one
                t = (float(column[k]) * recording.scale for column in (ranks.high, ranks.low, ranks.error, ranks.t))
                places.append(RankedPlace(int(ranks.rank[k]), number, *t))
    how = "exact" if exact else "certified"
    return Decision(how if doubtful else "floats", how, error, tuple(sorted(places, key=lambda one: one.rank)))


# `scene.surface`: the equation and the kind of a surface of a scene, and the faces of bodies that lie on it.


@dataclass(frozen=True)
class Owner:
    """A face that lies on a surface, and the side of the surface on which its body is.

    Attributes
    ----------
    body : int
        Number of the body.
    name : str or None
        Name of the body.
    face : int
        Number of the face.
    side : int
        1 if the left side of the surface's equation is negative on the body's side, else -1.
    """

    body: int
    name: str | None
    face: int
    side: int


@dataclass(frozen=True)
class SceneSurface:
    """One of the distinct surfaces of a scene; bodies that share a wall share its surface.

    Attributes
    ----------
    number : int
        Number in the scene, as in `hits.surface`.
    equation : str
        Readable equation in the world, numbers to six digits.
    coefficients : dict of str to float
        Coefficients of the equation with all digits, each rounded once, as `Quadric(coefficients=)` takes them.
    classification : Classification
        The kind of quadric or plane, as in `Quadric.classification`, for the side on which the left side of the
        equation is negative.
    owners : tuple of Owner
        The faces that lie on the surface.
    """

    number: int
    equation: str
    coefficients: dict[str, float]
    classification: Classification
    owners: tuple[Owner, ...]

    @property
    def kind(self) -> str:
        """The kind in a word or two, as "ellipsoid" or "plane"."""
        return self.classification.kind

    def __str__(self) -> str:
        faces = [
            f"face {one.face} of body {one.body}" + (f" {format_value(one.name)}" if one.name else "")
            for one in self.owners
        ]
        lines = [f"surface {self.number}: {self.equation}", str(self.classification)]
        return "\n".join([*lines, f"shared by {', '.join(faces)}" if len(faces) > 1 else "".join(faces)])


def surface_of(scene: SceneLike, number: Any) -> SceneSurface:
    """Return the surface of a number: see `Scene.surface`."""
    index, count = as_index(number), len(scene._prepared.lowered.tables.surface_kind)
    if index is None:
        raise TypeError(
            f"surface: number must be one integer, got {format_value(number)}; scene.surface(int(k)) for each"
        )
    if not 0 <= index < count:
        miss = "; -1 stands for a miss" if index == -1 else ""
        raise IndexError(f"surface: number must be at least 0 and below {count}, got {index}{miss}")
    source = SurfaceSource.of(scene._prepared, index)
    polynomial = source.polynomial
    return SceneSurface(
        index, polynomial.equation, polynomial.coefficients, source.classification, owners_of(scene._prepared, index)
    )


def owners_of(scene: PreparedScene, number: int) -> tuple[Owner, ...]:
    """Return the faces on a surface, in the order of bodies."""
    tables = scene.lowered.tables
    is_plane = tables.surface_kind[number] == PLANE
    found: set[tuple[int, int, int]] = set()  # (body, face, side)
    if is_plane:
        places = np.flatnonzero(tables.plane_surface == number)
        cells = np.searchsorted(tables.cell_first, places, side="right") - 1
        both = plane_faces(tables, places)
    else:
        cells = np.flatnonzero(tables.cell_quadric == number)
        both = cell_faces(tables, cells)
        # A ball is the inside of its sphere, with one face 0
        balls = np.flatnonzero((tables.entry_kind == BALL) & (tables.entry_index == number))
        found |= {(body, 0, 1) for body in balls.tolist()}
    faces, sides = numbers_of(both), sides_of(both)
    which, bodies, senses = _bodies_of(tables, cells)
    # The side of a face turns if the body has the complement of the cell
    found |= set(zip(bodies.tolist(), faces[which].tolist(), (sides[which] * senses).tolist(), strict=True))
    for kind, surfaces, normals in (
        (SHEET, tables.sheet_surface, tables.sheet_side),
        (POLYGON, tables.polygon_surface, tables.polygon_side),
    ):
        rows = np.flatnonzero(surfaces == number)
        # A sheet has one face 0, on the side of its normal
        entries = np.flatnonzero((tables.entry_kind == kind) & np.isin(tables.entry_index, rows))
        found |= {(entry, 0, int(normals[tables.entry_index[entry]])) for entry in entries.tolist()}
    names = scene.labels.names_of(np.array([body for body, _, _ in sorted(found)], np.int64))
    return tuple(Owner(body, name, face, side) for (body, face, side), name in zip(sorted(found), names, strict=True))


def _bodies_of(tables: Tables, cells: Any) -> tuple[Any, Any, Any]:
    """Return (which of some cells, its body, sense) of each use: -1 where the complement of the cell counts, else 1."""
    # Bodies that are one cell, then cells in the leaves of Boolean bodies
    which, entries = _entries_among(tables, CELL, cells)
    order = np.argsort(cells, kind="stable")
    leaves = _leaves_of(tables, cells)
    cells_of = cells_of_leaves(tables, leaves)
    first, last = (np.searchsorted(cells[order], cells_of, side=end) for end in ("left", "right"))
    leaf, at = _ranges(first, last)
    # The program of each leaf: leaves of a program follow each other
    programs = np.searchsorted(tables.program_leaf, leaves, side="right") - 1
    part, regions = _entries_among(tables, REGION, programs[leaf])
    senses = tables.leaf_sense[row_of_leaf(tables, programs, leaves)]
    return (
        np.concatenate([which, order[at][part]]),
        np.concatenate([entries, regions]),
        np.concatenate([np.ones(len(which), np.int64), senses[leaf][part]]),
    )


def _leaves_of(tables: Tables, cells: Any) -> Any:
    """Return the leaves that use some cells, in rising order."""
    # Without shifted programs each leaf has its own row; with them a leaf has the number of its cell
    if not len(tables.program_shifts):
        return np.flatnonzero(np.isin(tables.leaf_cell, cells))
    leaves, (first, count) = np.unique(cells), leaves_of_programs(tables)
    programs = np.searchsorted(first, leaves, side="right") - 1
    return leaves[(programs >= 0) & (leaves < (first + count)[programs])]


def _entries_among(tables: Tables, kind: int, rows: Any) -> tuple[Any, Any]:
    """Return (which of some rows, entry) for each entry of a kind that uses one of these cells or programs."""
    entries = np.flatnonzero(tables.entry_kind == kind)
    entries = entries[np.argsort(tables.entry_index[entries], kind="stable")]
    index = tables.entry_index[entries]
    which, at = _ranges(*(np.searchsorted(index, rows, side=end) for end in ("left", "right")))
    return which, entries[at]


def _ranges(first: Any, last: Any) -> tuple[Any, Any]:
    """Return (number of the range, place) of every place of some ranges from `first` to `last`."""
    counts = last - first
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts - first, counts)
