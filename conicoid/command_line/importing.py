"""The command that turns files of other programs into scene files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .terminal import Bar, say, user_mistakes
from .working import STDOUT, check_folder, name_of, refuse_stdin, refused_files, written

IMPORT_EXAMPLES = (
    "Examples:\n\n  conicoid import geometry.xml -o scene.yaml\n\n"
    "  conicoid import model.xml -o scene.yaml --no-void\n\n"
    "docs/importing.md says which formats there are, and what becomes of what."
)


def import_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="A file of another program, which is known by what is in it.", show_default=False
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
            help="Refuse what expands into more bodies.",
            show_default="4,000,000, of which 500,000 are no others moved",
        ),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse a file that is not read as it says.")] = False,
    only: Annotated[
        str | None, typer.Option(help="Only what this text, or a pattern such as '*/fuel*', names.", show_default=False)
    ] = None,
    depth: Annotated[
        int | None, typer.Option(min=0, help="How many levels of volumes are opened.", show_default="all")
    ] = None,
    smooth: Annotated[bool, typer.Option("--smooth", help="Circles are round, whatever $fn of OpenSCAD says.")] = False,
    entities: Annotated[
        bool, typer.Option("--entities", help="Read files in its folder that GDML takes in by entities.")
    ] = False,
) -> None:
    """Turn a file of another program into a scene; what there is to say of it, and its materials, are printed."""
    with user_mistakes():
        if output != STDOUT and output.suffix.lower() not in (".yaml", ".yml", ".json"):
            raise ValueError(f"{output}: scenes are saved as .yaml or .json")
        check_folder(output)
        from ..formats import scene_file
        from ..formats.imports import FORMATS, Options, format_of
        from ..shapes.labels import counted

        refuse_stdin(file, "files of other programs")
        with refused_files(), Bar("reading", "body") as bar:
            found = format_of(file)
            if found is None:
                file.open("rb").close()  # an error where there is none
                raise ValueError(f"{file}: is of no known format: {', '.join(each.name for each in FORMATS)}")
            imported = found.read(
                file,
                Options(void, max_bodies, strict, only, depth, smooth, entities, _told(file, bar)),
            )
        with written(output, ".yaml") as place, Bar("writing", "body") as bar:
            scene_file.write(imported, place, imported.material_names, bar)
        for line in (*imported.notes, *imported.legend):
            typer.echo(line, err=output == STDOUT)
        say(f"{name_of(output)}: {counted(len(imported.bodies), 'body', 'bodies')}")


def _told(file: Path, bar: Bar) -> Any:
    """Progress that states the number of bodies before the first of them is made."""
    from ..shapes.labels import counted

    def progress(done: int, count: int) -> None:
        if done == 0:
            say(f"{file}: expands into {counted(count, 'body', 'bodies')}")
        bar(done, count)

    return progress
