"""The commands that read and write files of others: import and export; and those in a browser: view and playground."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .options import GlassesOption, SceneFile
from .resources import (
    STDOUT,
    check_folder,
    load,
    name_of,
    prepare,
    refuse_stdin,
    report_refused_files,
    write_output,
)
from .terminal import Bar, show_message

IMPORT_EXAMPLES = (
    "Examples:\n\n  conicoid import geometry.xml -o scene.yaml\n\n"
    "  conicoid import model.xml -o scene.yaml --no-void\n\n"
    "docs/importing.md lists the formats, and how each part of a file is read."
)


def import_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="A file of another program; its content decides the format.", show_default=False
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", help="The scene file, .yaml or .json; - is YAML on standard output.", show_default=False
        ),
    ],
    void: Annotated[bool, typer.Option(help="Keep parts without material, as invisible bodies.")] = True,
    max_bodies: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Refuse a file that expands into more bodies.",
            show_default="4,000,000, of them 500,000 that are no moved copies",
        ),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse a file that cannot be read as it stands.")] = False,
    only: Annotated[
        str | None,
        typer.Option(help="Only volumes with this text, or pattern such as '*/fuel*'.", show_default=False),
    ] = None,
    depth: Annotated[
        int | None, typer.Option(min=0, help="How many levels of volumes are opened.", show_default="all")
    ] = None,
    smooth: Annotated[bool, typer.Option("--smooth", help="Circles are round, whatever $fn of OpenSCAD says.")] = False,
    entities: Annotated[bool, typer.Option("--entities", help="Read files that GDML includes by entities.")] = False,
    root: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="The folder within which a file may name others.", show_default="that of the file"
        ),
    ] = None,
    glasses: GlassesOption = None,
) -> None:
    """Turn a file of another program into a scene; print remarks on it, and its materials."""
    if output != STDOUT and output.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise ValueError(f"{output}: scenes are saved as .yaml or .json")
    check_folder(output)
    from .._util.files import open_regular
    from .._util.text import format_count
    from ..io.importers import IMPORT_FORMATS, ImportOptions, detect_format
    from ..io.scene_file import scene_file

    refuse_stdin(file, "files of other programs")
    with report_refused_files(), Bar("reading", "body") as bar:
        importer = detect_format(file)
        if importer is None:
            open_regular(file).close()  # raises OSError for a missing file
            raise ValueError(f"{file}: is of no known format: {', '.join(each.name for each in IMPORT_FORMATS)}")
        imported = importer.read(
            file,
            ImportOptions(
                void, max_bodies, strict, only, depth, smooth, entities, root, glasses, _import_parts(file, bar)
            ),
        )
    with write_output(output, ".yaml") as place, Bar("writing", "body") as bar:
        scene_file.write_scene(imported, place, imported.material_names, bar)
    for line in (*imported.notes, *imported.legend):
        typer.echo(line, err=output == STDOUT)  # stdout may hold the scene
    show_message(f"{name_of(output)}: {format_count(len(imported.bodies), 'body', 'bodies')}")


def _import_parts(file: Path, bar: Bar) -> Any:
    """Return progress that states the number of bodies before the first of them is made."""
    from .._util.text import format_count

    def progress(done: int, count: int) -> None:
        if done == 0:
            show_message(f"{file}: expands into {format_count(count, 'body', 'bodies')}")
        bar(done, count)

    return progress


# --- export: pages, and models of other programs

EXPORT_EXAMPLES = (
    "Examples:\n\n  conicoid export scene.yaml scene.html\n\n  conicoid export geometry.xml detector.gdml\n\n"
    "docs/exporting.md describes how GDML, OpenSCAD and OpenMC hold each part of a scene."
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
        bool, typer.Option("--strict", help="Refuse a model that does not hold all of the scene.")
    ] = False,
) -> None:
    """Write a scene as one page that any current browser shows from a disk, or as a model of another program."""
    from ..io.export.exporters import EXPORT_FORMATS, ExportOptions, find_export_format

    exporter = find_export_format(output)
    if exporter is None and output.suffix.lower() not in _PAGES:
        suffixes = ", ".join(suffix for each in EXPORT_FORMATS for suffix in each.suffixes)
        raise ValueError(f"{output}: pages are saved as .html, models as {suffixes}")
    if exporter is None and strict:
        raise ValueError("export: --strict goes with models; for a page it would be ignored")
    check_folder(output, scene)
    loaded = load(scene, None)
    if exporter is None:
        _page(loaded, output, scene.stem)
    else:
        with Bar("writing", "body") as bar:
            result = exporter.write(loaded, output, ExportOptions(strict, bar))
        for line in result.notes:
            typer.echo(line)
    show_message(f"{output}: {output.stat().st_size / 1024:,.0f} KiB")


def _page(scene: Any, output: Path, title: str) -> None:
    """Write a scene as a page."""
    from ..viewer import export as write_page

    prepare(scene)
    write_page(scene, output, title)


# --- view and playground: scenes in a browser

VIEW_EXAMPLES = (
    "Examples:\n\n  conicoid view scene.yaml\n\n  conicoid view --quadrics\n\n"
    "The page follows the file as it changes. docs/viewer.md describes the page."
)
PLAYGROUND_EXAMPLES = (
    "Examples:\n\n  conicoid playground\n\n  conicoid playground scene.yaml\n\n"
    "The file stays as it is. docs/playground.md describes the page."
)


def view(
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE]", help="A scene file, YAML or JSON.", show_default=False)
    ] = None,
    quadrics: Annotated[bool, typer.Option("--quadrics", help="The nine quadrics, with sliders.")] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page on this machine; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the browser.")] = True,
) -> None:
    """Walk around in a scene in the browser, until Ctrl-C."""
    if (scene is None) != quadrics:
        raise ValueError("view: give either a scene file or --quadrics")
    from ..viewer.playground import quadrics_scene
    from ..viewer.server import serve
    from ..viewer.session import Session, stamp_of

    if scene is None:
        session = Session(quadrics_scene(), "Nine quadrics", select=0)
    else:
        stamp = stamp_of(scene)  # before the file is read: a change meanwhile is then noticed
        loaded = load(scene, None)
        prepare(loaded)
        session = Session(loaded, scene.stem, scene, stamp=stamp)
    # Scenes that are too large for a browser fail here, not in the page
    session.scene()
    serve(session, port, browser, show_message)


def playground(
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE]", help="A scene file to begin with.", show_default=False)
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page on this machine; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the browser.")] = True,
) -> None:
    """Type a scene in the browser, and read the hits along a ray, until Ctrl-C."""
    from ..viewer.playground import Playground
    from ..viewer.server import serve

    if scene is not None:  # mistakes in the file are reported here
        load(scene, None)
    session = Playground(scene)
    serve(session, port, browser, show_message)
