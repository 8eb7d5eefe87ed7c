"""The command that writes scenes for others: pages, and models of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .parts import SceneFile
from .terminal import Bar, compile_notes, say, user_mistakes
from .working import check_folder, load, prepare, refuse_overwriting

EXPORT_EXAMPLES = (
    "Examples:\n\n  conicoid export scene.yaml scene.html\n\n  conicoid export geometry.xml detector.gdml\n\n"
    "docs/exporting.md says what becomes of what in GDML, OpenSCAD and OpenMC."
)
_PAGES = (".html", ".htm")


def export(
    scene: SceneFile,
    output: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A page, .html; or a model: .gdml, .scad of OpenSCAD, .xml of OpenMC.",
            show_default=False,
        ),
    ],
    strict: Annotated[
        bool, typer.Option("--strict", help="Refuse a model that does not say all of the scene.")
    ] = False,
) -> None:
    """Write a scene as one page that any current browser shows from a disk, or as a model of another program."""
    with user_mistakes():
        from ..formats.exports import FORMATS, Options, format_for

        found = format_for(output)
        if found is None and output.suffix.lower() not in _PAGES:
            known = ", ".join(suffix for each in FORMATS for suffix in each.suffixes)
            raise ValueError(f"{output}: pages are saved as .html, models as {known}")
        if found is None and strict:
            raise ValueError("export: --strict goes with models; of a page it would be ignored")
        check_folder(output)
        refuse_overwriting(output, scene)
        loaded = load(scene, None)
        if found is None:
            _page(loaded, output, scene.stem)
        else:
            with Bar("writing", "body") as bar:
                done = found.write(loaded, output, Options(strict, bar))
            for line in done.notes:
                typer.echo(line)
        say(f"{output}: {output.stat().st_size / 1024:,.0f} KiB")


def _page(scene: Any, output: Path, title: str) -> None:
    from ..viewer import export as write_page

    prepare(scene)
    with compile_notes():
        write_page(scene, output, title)
