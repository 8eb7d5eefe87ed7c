"""What the exact engine says about a ray that the page asks about: the first hit, spans, entries and exits."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np

from .._util.arrays import FloatArray, Vector, dot_rows, row_lengths
from .._util.validation import check_number, check_vector
from ..queries.hits import Hits
from ..scene.scene import Scene

Interval = tuple[float, float]
MISTAKES = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)
"""What a request that makes no sense raises, here and in the edits of numbers."""


def pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """The answer to {origin, direction, hidden, section}: {found: null}, or the hit with all that is on the ray.

    `hidden` lists entries of the scene that are passed over; `section` {normal, offset} keeps the solids' parts
    where normal·x <= offset. Floats are exact. Raises ValueError for a request that makes no sense.
    """
    origin, direction = (np.array(_vector(request, name)) for name in ("origin", "direction"))
    hidden = {int(item) for item in request.get("hidden") or ()}
    kept = _interval(request.get("section"), origin, direction)
    crossings = _crossings(scene, origin, direction, hidden, kept)
    spans, cuts = _spans(scene, origin, direction, hidden, kept)
    cuts = [cut for cut in cuts if not crossings or cut["t"] <= crossings[0]["t"]]
    rest = {"spans": spans, "crossings": crossings}
    if cuts:
        return {"found": _cut(cuts[0], request["section"], origin, direction) | rest}
    if not crossings:
        return {"found": None}
    return {"found": _hit(scene, origin, direction, crossings[0], bool(hidden) or kept != (-math.inf, math.inf)) | rest}


def explain_pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """The answer to {origin, direction, body}: {text}, the working of a ray with a body; nothing is passed over."""
    body = request.get("body")
    found = scene.explain(*(_vector(request, name) for name in ("origin", "direction")), body=int(body))  # type: ignore[arg-type]
    return {"text": found.text}


def name_of(scene: Scene, item: int) -> str:
    """A body's name, or its shape and number, as the page has it."""
    body = scene.bodies[item]
    return body.name or f"{type(body.shape).__name__} {item}"


def _vector(request: dict[str, Any], name: str) -> Vector:
    return check_vector("pick", name, request.get(name), nonzero=name == "direction")


def _interval(section: Any, origin: FloatArray, direction: FloatArray) -> Interval:
    """Where a ray is in the half-space that is kept."""
    if section is None:
        return -math.inf, math.inf
    normal = np.array(check_vector("section", "normal", section.get("normal"), nonzero=True))
    height = float(dot_rows(normal, origin)) - check_number("section", "offset", section.get("offset"))
    rate = float(dot_rows(normal, direction))
    if rate == 0.0:
        return (-math.inf, math.inf) if height <= 0.0 else (math.inf, -math.inf)
    return (-height / rate, math.inf) if rate < 0.0 else (-math.inf, -height / rate)


def _crossings(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], kept: Interval
) -> list[dict[str, Any]]:
    found = scene.crossings(origin, direction)
    items = scene.lowered.body_item
    rows: list[dict[str, Any]] = []
    columns = found.t, found.t_error, found.body, found.face, found.surface, found.entering
    for t, error, body, face, surface, entering in zip(*columns, strict=True):
        item = int(items[body])
        if item in hidden or not (scene.bodies[item].shape.is_sheet or kept[0] < t < kept[1]):
            continue
        row = {"t": float(t), "body": int(body), "face": int(face), "surface": int(surface), "entering": bool(entering)}
        rows.append(row | {"t_error": _finite(error), "name": name_of(scene, item)})
    return rows


def _spans(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], kept: Interval
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """(spans, the ends that the section plane makes, in order)."""
    low, high = max(0.0, kept[0]), kept[1]
    if not low < high:
        return [], []
    found = scene.spans(origin, direction, t_min=low, t_max=high)
    spans: list[dict[str, Any]] = []
    cuts: list[dict[str, Any]] = []
    for enter, exit_, body, starts, ends in zip(
        found.t_enter, found.t_exit, found.body, found.enter_clipped, found.exit_clipped, strict=True
    ):
        item = int(scene.lowered.body_item[body])
        if item in hidden:
            continue
        name = name_of(scene, item)
        spans.append({"name": name, "body": int(body), "enter": _finite(enter), "exit": _finite(exit_)})
        if starts and enter == kept[0] > 0.0:
            cuts.append({"t": float(enter), "body": int(body), "name": name, "entering": True})
        if ends and exit_ == kept[1]:
            cuts.append({"t": float(exit_), "body": int(body), "name": name, "entering": False})
    return spans, sorted((cut for cut in cuts if math.isfinite(cut["t"])), key=lambda cut: cut["t"])


def _finite(t: float) -> float | None:
    return float(t) if math.isfinite(t) else None


def _cut(cut: dict[str, Any], section: Any, origin: FloatArray, direction: FloatArray) -> dict[str, Any]:
    normal = np.array(section["normal"], dtype=np.float64)
    point = origin + cut["t"] * direction
    return cut | {
        "face": None, "surface": None, "point": point.tolist(), "normal": (normal / row_lengths(normal)).tolist(),
        "uv": None,
    }  # fmt: skip


def _hit(
    scene: Scene, origin: FloatArray, direction: FloatArray, first: dict[str, Any], chosen: bool
) -> dict[str, Any]:
    """The first hit; `chosen`: of what is shown, which is a crossing known already."""
    t = first["t"]
    limits = (math.nextafter(t, -math.inf), math.nextafter(t, math.inf)) if chosen else (0.0, math.inf)
    hit = scene.first_hit(origin, direction, *limits)
    if hit.body != first["body"]:
        hit = _hit_of_one(scene, origin, direction, first)
    return {
        "name": first["name"], "t": t, "t_error": first["t_error"],
        "body": first["body"], "face": first["face"], "surface": first["surface"],
        "entering": first["entering"],
        "point": hit.point.tolist(), "normal": hit.normal.tolist(), "uv": hit.uv.tolist(),
    }  # fmt: skip


def _hit_of_one(scene: Scene, origin: FloatArray, direction: FloatArray, first: dict[str, Any]) -> Hits:
    """The hit of a crossing whose wall is also a hidden body's, which is listed earlier and would be found instead."""
    alone = Scene([scene.bodies[int(scene.lowered.body_item[first["body"]])]])
    times = alone.crossings(origin, direction).t
    t = float(times[np.argmin(np.abs(times - first["t"]))])
    return alone.first_hit(origin, direction, math.nextafter(t, -math.inf), math.nextafter(t, math.inf))
