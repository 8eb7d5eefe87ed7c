"""The command conicoid explain: one ray of a scene worked out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .parts import SceneFile, TMax, TMin
from .terminal import compile_notes, say, user_mistakes
from .working import check_folder, load, prepare, refuse_overwriting

EXPLAIN_EXAMPLES = (
    "Examples:\n\n  conicoid explain scene.yaml --ray -3 0.6 0 1 0 0\n\n"
    "  conicoid explain scene.yaml --ray 0 0 9 0 0 -1 --body lens --html why.html\n\n"
    "docs/explain.md says how to read it."
)


def explain(
    scene: SceneFile,
    ray: Annotated[
        tuple[float, float, float, float, float, float],
        typer.Option("--ray", metavar="OX OY OZ DX DY DZ", help="Origin and direction.", show_default=False),
    ],
    body: Annotated[
        str | None, typer.Option("--body", help="Only the body of this name or number.", show_default=False)
    ] = None,
    html: Annotated[
        Path | None, typer.Option("--html", help="Write a page with the figure, .html, or the figure alone, .svg.",
                                  show_default=False)
    ] = None,
    t_min: TMin = None,
    t_max: TMax = None,
) -> None:  # fmt: skip
    """Work one ray out as on a blackboard: what every body does with it, and why."""
    with user_mistakes():
        if html is not None:
            if html.suffix.lower() not in (".html", ".svg"):
                raise ValueError(f"{html}: the page is written as .html, the figure as .svg")
            check_folder(html)
            refuse_overwriting(html, scene)
        loaded = load(scene, None)
        prepare(loaded)
        limits = {name: value for name, value in (("t_min", t_min), ("t_max", t_max)) if value is not None}
        with compile_notes():
            try:
                found = loaded.explain(ray[:3], ray[3:], body=_which(body, loaded), **limits)
            except LookupError as error:
                raise ValueError(f"explain: {error.args[0]}") from None
            if html is not None:
                found.save(html)
                say(f"{html}: {found!r}")
        typer.echo(found.text, nl=False)


def _which(body: str | None, scene: object) -> str | int | None:
    """The number of a body where it is one and no name."""
    if body is None or body in scene or not body.isdecimal():  # type: ignore[operator]
        return body
    return int(body)
