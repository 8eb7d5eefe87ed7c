"""The command line: the commands of conicoid; those that trace rays or list numbers are defined here."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

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
from .options import (
    ClusterOption,
    Command,
    Commands,
    GlassesOption,
    RayFile,
    Results,
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
from .resources import STDOUT, check_folder, executor_of, load, name_of, prepare, ray_file, write_output
from .terminal import EXIT_FINDINGS, Bar, show_message, user_mistakes

if TYPE_CHECKING:
    from ..apps.measures.measure import SceneMeasures
    from ..queries.rays import Rays
    from ..scene.scene import Scene

LENGTHS_EXAMPLES = (
    "Examples:\n\n  conicoid lengths scene.yaml rays.npy -o lengths.npz\n\n"
    "  conicoid lengths scene.yaml rays.npy -o lengths.csv --by material\n\n"
    "  conicoid lengths scene.yaml rays.npy -o doses.csv --value water=0.2 --value lead=1.1 --otherwise 0\n\n"
    "  conicoid lengths scene.yaml rays.npy -o mu.npz --property attenuation\n\n"
    "With --value or --property the results are line integrals: the sum of value times length."
)
MEASURE_EXAMPLES = (
    "Examples:\n\n  conicoid measure scene.yaml\n\n  conicoid measure scene.yaml -o volumes.csv\n\n"
    "Closed forms where they are known, else the chords of random rays, with standard errors: docs/booleans.md."
)


def lengths(
    context: typer.Context,
    scene: SceneFile,
    rays: RayFile,
    output: Results,
    by: Annotated[str, typer.Option(help="A column for each: body or material.")] = "body",
    value: Annotated[
        list[str] | None,
        typer.Option(
            "--value", metavar="MATERIAL=NUMBER", help="The line integral of it; may be repeated.", show_default=False
        ),
    ] = None,
    property_: Annotated[
        str | None,
        typer.Option("--property", metavar="NAME", help="The line integral of a property of the materials.",
                     show_default=False),
    ] = None,
    otherwise: Annotated[
        float | None, typer.Option(help="With --value or --property: for materials without one.", show_default=False)
    ] = None,
    overlaps: Annotated[
        str | None,
        typer.Option(help="Stretches in two bodies at once: both, to count them twice; or error.",
                     show_default="a note"),
    ] = None,
    t_min: TMin = None,
    t_max: TMax = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Measure how far rays go inside each body, or material; or sum up a value along them."""
    from .._util.text import check_choice
    from ..queries.weights import check_by

    integral = bool(value) or property_ is not None
    only_with(context, "--value or --property", integral, "otherwise")
    only_with(context, "lengths, not with --value or --property", not integral, "by")
    if value and property_ is not None:
        raise ValueError("lengths: give either --value or --property")
    by = check_by("lengths", by)
    if overlaps is not None:
        overlaps = check_choice("lengths", "--overlaps", overlaps, ("both", "error"))
    values = _values(value) if value else property_
    # Invalid rays are found before the preparation, which may take much longer
    table = ray_file(rays, scene, output, t_min, t_max, (".npz", ".csv")).read()
    loaded = load(scene, threads)
    from ..io.result_file import integral_columns, length_columns, write_values

    options: dict[str, Any] = dict(overlaps=overlaps, **table.limits(t_min, t_max))
    prepare(loaded)
    with Bar("measuring", "ray") as bar:
        if integral:
            results = _integrals(loaded, table.rays, values, dict(otherwise=otherwise, progress=bar) | options)
        else:
            results = loaded.lengths(table.rays, by=cast(Any, by), progress=bar, **options)
    energies = results.shape[len(table.rays.shape) :]  # the axes behind those of the rays
    columns = integral_columns(energies) if integral else length_columns(loaded, by)
    name = "line_integrals" if integral else "lengths"
    with write_output(output, ".csv") as file:
        write_values(file, name, results, columns, with_names=not integral)
    show_message(f"{name_of(output)}: {_summary(results, table.rays.shape, len(columns), integral, by)}")


def _integrals(scene: Scene, rays: Rays, values: Any, options: dict[str, Any]) -> Any:
    """Return line integrals; messages about the values name options of the command line."""
    try:
        return scene.line_integral(values, rays, **options)
    except ValueError as error:
        text = str(error).removeprefix("line_integral: ").removeprefix("values: ")
        option = text.replace("otherwise=0 (or another value) stands for it", "--otherwise 0 would stand for it")
        raise ValueError(f"lengths: {option}") from None


def _values(texts: list[str]) -> dict[str, float]:
    """Return MATERIAL=NUMBER texts as a mapping; names may contain = themselves."""
    values: dict[str, float] = {}
    for text in texts:
        name, _, number = text.rpartition("=")  # the last one: names may contain others
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not name or not math.isfinite(value):
            raise ValueError(f"lengths: --value must be MATERIAL=NUMBER, got {text[:80]!r}")
        if name in values:
            raise ValueError(f"lengths: --value is given twice for {name[:80]!r}")
        values[name] = value
    return values


def _summary(results: Any, rays: tuple[int, ...], columns: int, integral: bool, by: str) -> str:
    """Return one line on the results."""
    from .._util.text import format_count

    count = math.prod(rays)
    of_rays = format_count(count, "ray", "rays")
    if integral:
        return f"line integrals of {of_rays}"
    inside = int((results.reshape(count, columns) > 0).any(axis=1).sum())
    columns_text = format_count(columns, by, "bodies" if by == "body" else "materials")
    return f"lengths of {of_rays} inside {columns_text}; {inside:,} inside any"


def measure(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A table of all measures, .csv; - is standard output.", show_default=False),
    ] = None,
    rays: Annotated[
        int | None,
        typer.Option(min=60, help="Rays for all bodies; combinations are followed in any case.",
                     show_default="1000000, where no closed form is known"),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random rays.")] = 0,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Volume, area, centroid and inertia of every body, and the volumes of materials."""
    if output is not None:
        if output != STDOUT and output.suffix.lower() != ".csv":
            raise ValueError(f"{output}: measures are written as .csv")
        check_folder(output, scene)
    loaded = load(scene, threads)
    from ..apps.measures.measure import measure as measure_scene

    with Bar("measuring", "body") as bar:
        measures = measure_scene(loaded, rays, seed, bar)
    if output is None:
        typer.echo(_printable(str(measures)))
        return
    from ..io.array_file import write_columns

    with write_output(output, ".csv") as file:
        write_columns(file, _table(measures))
    show_message(f"{name_of(output)}: {len(measures):,} bodies")


def _printable(text: str) -> str:
    """Return text without characters that a terminal would obey."""
    from .._util.files import printable

    return "\n".join(printable(line) for line in text.split("\n"))


def _table(measures: SceneMeasures) -> dict[str, Any]:
    """Return the columns of the file of measures: a row for each body."""
    import numpy as np

    names = ["" if name is None else name for name in measures.names]
    material_names = ["" if material is None or not material.name else material.name for material in measures.materials]
    table: dict[str, Any] = {
        "body": np.arange(len(measures)),
        "name": np.array(names, object),
        "material": np.array([material_names[place] for place in measures.places], object),
    }
    for name in ("volume", "area"):
        table[name] = np.array([getattr(body, name) for body in measures])
        table[f"{name}_error"] = np.array([getattr(body, f"{name}_error") for body in measures])
    centroids = np.array([body.centroid for body in measures]).reshape(-1, 3)
    inertias = np.array([body.inertia for body in measures]).reshape(-1, 3, 3)
    table |= {f"centroid_{axis}": centroids[:, k] for k, axis in enumerate("xyz")}
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    return table | {f"inertia_{'xyz'[i]}{'xyz'[j]}": inertias[:, i, j] for i, j in pairs}


# --- explain

EXPLAIN_EXAMPLES = (
    "Examples:\n\n  conicoid explain scene.yaml --ray -3 0.6 0 1 0 0\n\n"
    "  conicoid explain scene.yaml --ray 0 0 9 0 0 -1 --body lens --html why.html\n\n"
    "docs/explain.md describes how to read it."
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
    """Explain one ray as on a blackboard: the steps by which every body is hit or missed."""
    if html is not None:
        if html.suffix.lower() not in (".html", ".svg"):
            raise ValueError(f"{html}: the page is written as .html, the figure as .svg")
        check_folder(html, scene)
    loaded = load(scene, None)
    prepare(loaded)
    limits = {name: value for name, value in (("t_min", t_min), ("t_max", t_max)) if value is not None}
    try:
        explanation = loaded.explain(ray[:3], ray[3:], body=_body_number(body, loaded), **limits)
    except LookupError as error:
        raise ValueError(f"explain: {error.args[0]}") from None
    if html is not None:
        explanation.save(html)
        show_message(f"{html}: {explanation!r}")
    typer.echo(explanation.text, nl=False)


def _body_number(body: str | None, scene: object) -> str | int | None:
    """Return the number of a body if the text is a number and no name."""
    # A name of digits alone wins over the number
    if body is None or body in scene or not body.isdecimal():  # type: ignore[operator]
        return body
    return int(body)


# The group of commands, and the commands info, trace and schema.

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
