"""Commands that show scenes in a browser: view and playground."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .terminal import compile_notes, say, user_mistakes
from .working import load, prepare

VIEW_EXAMPLES = (
    "Examples:\n\n  conicoid view scene.yaml\n\n  conicoid view --quadrics\n\n"
    "The page follows the file as it changes. docs/viewer.md says what can be done on it."
)
PLAYGROUND_EXAMPLES = (
    "Examples:\n\n  conicoid playground\n\n  conicoid playground scene.yaml\n\n"
    "The file stays as it is. docs/playground.md says what can be done there."
)


def view(
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE]", help="A scene file, YAML or JSON.", show_default=False)
    ] = None,
    quadrics: Annotated[bool, typer.Option("--quadrics", help="The nine quadrics, with sliders.")] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page on this machine; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the browser.")] = True,
) -> None:
    """Walk around in a scene in the browser, until Ctrl-C."""
    with user_mistakes():
        if (scene is None) != quadrics:
            raise ValueError("view: give either a scene file or --quadrics")
        from ..viewer.quadrics import quadrics_scene
        from ..viewer.server import serve
        from ..viewer.session import Session, stamp_of

        if scene is None:
            session = Session(quadrics_scene(), "Nine quadrics", select=0)
        else:
            stamp = stamp_of(scene)
            loaded = load(scene, None)
            prepare(loaded)
            session = Session(loaded, scene.stem, scene, stamp=stamp)
        with compile_notes():
            session.scene()
        serve(session, port, browser, say)


def playground(
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE]", help="A scene file to begin with.", show_default=False)
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page on this machine; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the browser.")] = True,
) -> None:
    """Type a scene in the browser, and read what is on a ray, until Ctrl-C."""
    with user_mistakes():
        from ..viewer.playground import Playground
        from ..viewer.server import serve

        if scene is not None:
            load(scene, None)
        with compile_notes():
            session = Playground(scene)
        serve(session, port, browser, say)
