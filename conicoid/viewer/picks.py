"""Answers of the exact engine about a ray of a page: the first hit, and all spans and crossings on the ray.

`pick` takes hidden bodies and a section plane into account; `explain_pick` explains the ray with one body.
"""

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
"""Errors that an invalid request raises, here and in edits of numbers."""


def pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """Answer {origin, direction, hidden, section} with {found: null}, or with the hit and everything on the ray.

    Floats are exact. Raises ValueError for an invalid request.

    hidden: entries of the scene that the ray ignores. section: {normal, offset}; only the parts of solids in the
    half-space normal·x <= offset count.
    """
    origin, direction = (np.array(_vector(request, name)) for name in ("origin", "direction"))
    hidden = {int(item) for item in request.get("hidden") or ()}
    interval = _interval(request.get("section"), origin, direction)
    crossings = _crossings(scene, origin, direction, hidden, interval)
    spans, cuts = _spans(scene, origin, direction, hidden, interval)
    # A cut is visible only if no crossing precedes it
    cuts = [cut for cut in cuts if not crossings or cut["t"] <= crossings[0]["t"]]
    rest = {"spans": spans, "crossings": crossings}
    if cuts:
        return {"found": _cut(cuts[0], request["section"], origin, direction) | rest}
    if not crossings:
        return {"found": None}
    return {
        "found": _hit(scene, origin, direction, crossings[0], bool(hidden) or interval != (-math.inf, math.inf)) | rest
    }


def explain_pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """Answer {origin, direction, body} with {text}: the explanation of a ray with a body. Nothing is hidden here."""
    body = request.get("body")
    explanation = scene.explain(*(_vector(request, name) for name in ("origin", "direction")), body=int(body))  # type: ignore[arg-type]
    return {"text": explanation.text}


def name_of(scene: Scene, item: int) -> str:
    """Return the name of a body, or its shape and number, as the page shows it."""
    body = scene.bodies[item]
    return body.name or f"{type(body.shape).__name__} {item}"


def _vector(request: dict[str, Any], name: str) -> Vector:
    """Return a checked vector of a request; a direction must not be zero."""
    return check_vector("pick", name, request.get(name), nonzero=name == "direction")


def _interval(section: Any, origin: FloatArray, direction: FloatArray) -> Interval:
    """Return the interval of a ray in the half-space of a section."""
    if section is None:
        return -math.inf, math.inf
    normal = np.array(check_vector("section", "normal", section.get("normal"), nonzero=True))
    height = float(dot_rows(normal, origin)) - check_number("section", "offset", section.get("offset"))
    rate = float(dot_rows(normal, direction))
    if rate == 0.0:  # parallel to the plane: all of the ray or nothing
        return (-math.inf, math.inf) if height <= 0.0 else (math.inf, -math.inf)
    return (-height / rate, math.inf) if rate < 0.0 else (-math.inf, -height / rate)


def _crossings(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], interval: Interval
) -> list[dict[str, Any]]:
    """Return a row for each crossing with a visible body: sheets everywhere, solids inside the section."""
    crossings = scene.crossings(origin, direction)
    items = scene._prepared.lowered.body_item
    rows: list[dict[str, Any]] = []
    columns = crossings.t, crossings.t_error, crossings.body, crossings.face, crossings.surface, crossings.entering
    for t, error, body, face, surface, entering in zip(*columns, strict=True):
        item = int(items[body])
        # Sheets are not cut: a section keeps parts of solids only
        if item in hidden or not (scene.bodies[item].shape.is_sheet or interval[0] < t < interval[1]):
            continue
        row = {"t": float(t), "body": int(body), "face": int(face), "surface": int(surface), "entering": bool(entering)}
        rows.append(row | {"t_error": _finite(error), "name": name_of(scene, item)})
    return rows


def _spans(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], interval: Interval
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return (spans, ends on the section plane in order along the ray)."""
    low, high = max(0.0, interval[0]), interval[1]
    if not low < high:
        return [], []
    result = scene.spans(origin, direction, t_min=low, t_max=high)
    spans: list[dict[str, Any]] = []
    cuts: list[dict[str, Any]] = []
    for enter, exit_, body, starts, ends in zip(
        result.t_enter, result.t_exit, result.body, result.enter_clipped, result.exit_clipped, strict=True
    ):
        item = int(scene._prepared.lowered.body_item[body])
        if item in hidden:
            continue
        name = name_of(scene, item)
        spans.append({"name": name, "body": int(body), "enter": _finite(enter), "exit": _finite(exit_)})
        if starts and enter == interval[0] > 0.0:
            cuts.append({"t": float(enter), "body": int(body), "name": name, "entering": True})
        if ends and exit_ == interval[1]:
            cuts.append({"t": float(exit_), "body": int(body), "name": name, "entering": False})
    return spans, sorted((cut for cut in cuts if math.isfinite(cut["t"])), key=lambda cut: cut["t"])


def _finite(t: float) -> float | None:
    """Return a float, or None for one that is not finite."""
    return float(t) if math.isfinite(t) else None


def _cut(cut: dict[str, Any], section: Any, origin: FloatArray, direction: FloatArray) -> dict[str, Any]:
    """Return the hit of a ray with the section plane."""
    normal = np.array(section["normal"], dtype=np.float64)
    point = origin + cut["t"] * direction
    return cut | {
        "face": None, "surface": None, "point": point.tolist(), "normal": (normal / row_lengths(normal)).tolist(),
        "uv": None,
    }  # fmt: skip


def _hit(
    scene: Scene, origin: FloatArray, direction: FloatArray, first: dict[str, Any], selected: bool
) -> dict[str, Any]:
    """Return the first hit; `selected`: `first` is the first visible crossing, which other crossings may precede."""
    t = first["t"]
    # Hidden crossings may come first, so the interval holds only the selected one
    limits = (math.nextafter(t, -math.inf), math.nextafter(t, math.inf)) if selected else (0.0, math.inf)
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
    """Return the hit of a crossing whose wall a hidden, earlier listed body shares: that body would win the tie."""
    one_body = Scene([scene.bodies[int(scene._prepared.lowered.body_item[first["body"]])]])
    times = one_body.crossings(origin, direction).t
    t = float(times[np.argmin(np.abs(times - first["t"]))])
    return one_body.first_hit(origin, direction, math.nextafter(t, -math.inf), math.nextafter(t, math.inf))
