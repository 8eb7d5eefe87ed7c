"""The command line: the commands of conicoid; `info`, `trace` and `schema` are defined here."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from .convert import (
    EXPORT_EXAMPLES,
    IMPORT_EXAMPLES,
    PLAYGROUND_EXAMPLES,
    VIEW_EXAMPLES,
    export,
    import_,
    playground,
    view,
)
from .measure import EXPLAIN_EXAMPLES, LENGTHS_EXAMPLES, MEASURE_EXAMPLES, explain, lengths, measure
from .options import (
    ClusterOption,
    Command,
    Commands,
    GlassesOption,
    RayFile,
    SceneFile,
    SlurmOption,
    Threads,
    TMax,
    TMin,
    WorkersOption,
    only_with,
)
from .pictures import (
    ANIMATE_EXAMPLES,
    RENDER_EXAMPLES,
    SLICE_EXAMPLES,
    TURNTABLE_EXAMPLES,
    animate,
    render,
    slice_scene,
    turntable,
)
from .resources import STDOUT, executor_of, load, name_of, prepare, ray_file, write_output
from .terminal import EXIT_FINDINGS, Bar, show_message, user_mistakes

app = typer.Typer(
    cls=Commands,
    help="Exact ray tracing of quadric solids.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Scene files, ray files and results are described in docs/files.md. Exit codes: 0 done, "
    "2 a mistake in the input, 3 a check with findings, 130 interrupted, 141 nobody reads the results, "
    "1 anything else.",
)


def main() -> None:
    """Run the command that the arguments name; the entry point is in `__main__`."""
    with user_mistakes():
        app(prog_name="conicoid")


def _version(is_set: bool) -> None:
    """Print the version and exit, for --version."""
    if is_set:
        from .._util.version import __version__

        typer.echo(f"conicoid {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Exact ray tracing of quadric solids."""
    from .._util.environment import check_environment

    with user_mistakes():
        check_environment()


# The order of registration is that of the help
app.command(cls=Command, epilog=RENDER_EXAMPLES)(render)
app.command(cls=Command, epilog=TURNTABLE_EXAMPLES)(turntable)
app.command("slice", cls=Command, epilog=SLICE_EXAMPLES)(slice_scene)
app.command(cls=Command, epilog=ANIMATE_EXAMPLES)(animate)
app.command(cls=Command, epilog=VIEW_EXAMPLES)(view)
app.command(cls=Command, epilog=PLAYGROUND_EXAMPLES)(playground)
app.command(cls=Command, epilog=EXPORT_EXAMPLES)(export)
app.command(cls=Command, epilog=EXPLAIN_EXAMPLES)(explain)


@app.command(
    cls=Command,
    epilog="Examples:\n\n  conicoid info scene.yaml\n\n  conicoid info scene.yaml --check\n\n"
    "  conicoid info --system\n\n"
    "Overlaps may be intended: the body listed first has them. docs/booleans.md lists the findings. "
    "With --check the exit code is 3 if there are findings.",
)
def info(
    context: typer.Context,
    scene: Annotated[
        Path | None, typer.Argument(metavar="[SCENE]", help="A scene file, YAML or JSON.", show_default=False)
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Look for overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits."
        ),
    ] = False,
    rays: Annotated[int, typer.Option(min=1, help="Rays for the check.")] = 200_000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random rays of the check.")] = 0,
    system: Annotated[bool, typer.Option("--system", help="Versions, processor, where kernels come from.")] = False,
    glasses: GlassesOption = None,
) -> None:
    """List the bodies of a scene with their bounds, and its memory; check it."""
    only_with(context, "--check", check, "rays", "seed")
    for name in [name for name, is_given in (("check", check), ("glasses", glasses)) if system and is_given]:
        raise ValueError(f"info: --{name} goes with a scene file; with --system it would be ignored")
    if (scene is None) != system:
        raise ValueError("info: give either a scene file or --system")
    if scene is None:
        from .report import system_report as lines_of_system

        for line in lines_of_system():
            typer.echo(line)
        return
    loaded = load(scene, None, glasses=glasses)
    from . import report

    prepare(loaded)

    lines = [*report.list_bodies(loaded), "", *report.totals(loaded)]
    for line in lines:
        typer.echo(line)
    if not check:
        return
    from ..apps.checks.check import check as find

    with Bar("checking", "step") as bar:
        findings = find(loaded, rays, seed, bar)
    for line in report.findings(findings):
        typer.echo(line)
    if findings:  # scripts see them by the exit code
        raise typer.Exit(EXIT_FINDINGS)


@app.command(
    cls=Command,
    epilog="Examples:\n\n  conicoid trace scene.yaml rays.npy -o hits.npz\n\n"
    "  conicoid trace scene.yaml rays.csv -o spans.csv --spans\n\n"
    "  conicoid trace scene.yaml many.npy -o hits.csv --chunk 1000000 --resume\n\n"
    "rays.npy has shape (N, 6): origin and direction. docs/files.md describes all files.",
)
def trace(
    context: typer.Context,
    scene: SceneFile,
    rays: RayFile,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            show_default=False,
            help="The results, .npz, .csv, .parquet or .zarr; - is .csv on standard output.",
        ),
    ],
    spans: Annotated[bool, typer.Option("--spans", help="Every stretch inside a body, not the first hit.")] = False,
    errors: Annotated[
        bool,
        typer.Option(
            "--errors", help="To .csv or .parquet, t_error or those of both ends as well; .npz has all fields."
        ),
    ] = False,
    t_min: TMin = None,
    t_max: TMax = None,
    chunk: Annotated[
        int | None,
        typer.Option(
            min=1, help="Read, trace and write so many rays at a time: memory holds no more.", show_default=False
        ),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="With --chunk: go on where an earlier run stopped.")] = False,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:
    """Follow rays through a scene and write what they hit."""
    from ..parallel.result_writer import SUFFIXES, file_state, parts_folder, result_writer, write_answers

    # Files of these kinds are read and written part by part in any case
    parts = chunk is not None or bool({rays.suffix.lower(), output.suffix.lower()} & {".parquet", ".zarr"})
    only_with(context, "--chunk", parts, "resume", "workers", "cluster", "slurm")
    if errors and output != STDOUT and output.suffix.lower() in (".npz", ".zarr"):
        raise ValueError(f"trace: --errors goes with .csv; a {output.suffix} file has all fields in any case")
    if parts and output == STDOUT:
        raise ValueError("trace: --chunk writes a file, with which it can continue: name one with -o")
    resumed = resume and parts_folder(output).is_dir()
    if resume and not resumed and output.is_dir():
        raise ValueError(f"{output}: is a folder without parts to go on with: it is complete, or of something else")
    file = ray_file(rays, scene, output, t_min, t_max, SUFFIXES, not parts, resumed)
    # Without parts invalid rays are found before the preparation, which may take much longer
    whole = None if parts else file.read()
    loaded = load(scene, threads)
    prepare(loaded)
    query, limits = "spans" if spans else "first_hit", dict(t_min=t_min, t_max=t_max)
    options: dict[str, Any] = {name: end for name, end in limits.items() if end is not None}
    with (
        Bar("tracing", "ray") as bar,
        executor_of("trace", workers, cluster, slurm) as executor,
        write_output(output, ".csv") as target,
    ):
        # The parts depend on this too, beside the scene
        key = f"{file_state(rays)} {t_min} {t_max}" if parts else None
        writer = result_writer(loaded, query, target, {}, errors=errors, key=key, resume=resume)
        size = (chunk or CHUNK) if parts else PIECE
        pieces = file.pieces(size, writer.parts.rays) if whole is None else [whole]
        answers = loaded.stream(pieces, query, chunk=size, executor=executor, **options)
        shape = None if spans else file.shape
        write_answers(writer, answers, shape, file.home, bar, math.prod(file.shape or (0,)))
    show_message(f"{name_of(output)}: {trace_summary(query, writer.parts.found, writer.parts.rays)}")


CHUNK = 1_000_000
"""Rays in a part, for files that are read or written part by part without --chunk."""
PIECE = 1 << 18
"""Rays that are traced at a time, if memory holds all rays of a file."""


def trace_summary(query: str, found: int, rays: int) -> str:
    """Return one line on the results."""
    from .._util.text import format_count

    of_rays = format_count(rays, "ray", "rays")
    return f"{format_count(found, 'span', 'spans')} of {of_rays}" if query == "spans" else f"{found:,} of {of_rays} hit"


app.command(cls=Command, epilog=LENGTHS_EXAMPLES)(lengths)
app.command(cls=Command, epilog=MEASURE_EXAMPLES)(measure)


app.command("import", cls=Command, epilog=IMPORT_EXAMPLES)(import_)


@app.command(cls=Command, epilog="Example:\n\n  conicoid schema > scene.schema.json")
def schema() -> None:
    """Print the JSON Schema of scene files, with which editors complete and check them."""
    import json

    from ..io.scene_file.schema import scene_schema

    typer.echo(json.dumps(scene_schema(), indent=2))
