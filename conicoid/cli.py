"""The command line: conicoid render, view, export, info, trace, import, bench, schema."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .exit_codes import MISTAKE
from .terminal import Bar, compile_notes, say, show_table, user_mistakes

if TYPE_CHECKING:
    from .scene import Scene

app = typer.Typer(
    help="Exact ray tracing of quadric solids.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Scene files, ray files and results are described in docs/files.md. Exit codes: 0 done, "
    "2 a mistake in the input, 130 interrupted, 141 nobody reads the results, 1 anything else.",
)

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, YAML or JSON.", show_default=False)]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads to use.", show_default="all cores")]


def main() -> None:
    """The commands; the entry point is in `__main__`."""
    with user_mistakes():
        app(prog_name="conicoid")


def _version(wanted: bool) -> None:
    if wanted:
        from . import __version__

        typer.echo(f"conicoid {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Exact ray tracing of quadric solids."""


@app.command(
    epilog="Examples:\n\n  conicoid render scene.yaml -o picture.png\n\n"
    "  conicoid render scene.yaml -o large.exr --width 1920 --height 1080"
)
def render(
    scene: SceneFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The picture: .png, .exr, .jpg or .webp.", show_default=False)
    ],
    width: Annotated[int, typer.Option(min=1, help="Pixels.")] = 640,
    height: Annotated[int, typer.Option(min=1, help="Pixels.")] = 480,
    samples: Annotated[int, typer.Option(min=1, help="Rays for each pixel.")] = 4,
    integrator: Annotated[str, typer.Option(help="How light is gathered: whitted or normals.")] = "whitted",
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same picture, to the bit.")] = 0,
    depth: Annotated[int, typer.Option(min=0, max=10_000, help="Reflections and refractions of a ray, at most.")] = 10,
    threads: Threads = None,
) -> None:
    """Make a picture of a scene. A scene without a camera or lights gets some that fit."""
    with user_mistakes():
        from .image import SUFFIXES

        if output.suffix.lower() not in SUFFIXES:
            raise ValueError(f"{output}: pictures are saved as {', '.join(SUFFIXES)}")
        _check_folder(output)
        loaded = _load(scene, threads)
        with compile_notes(), Bar("rendering", "ray") as bar:
            image = loaded.render(
                width, height, samples, integrator, seed, depth=depth, progress=_rays(bar, width * height * samples)
            )
        image.save(output)
        say(f"{output}: {width} x {height} pixels")


@app.command(
    epilog="Examples:\n\n  conicoid view scene.yaml\n\n  conicoid view --quadrics\n\n"
    "The page follows the file as it changes. docs/viewer.md says what can be done on it."
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
        from .viewer.quadrics import quadrics_scene
        from .viewer.server import serve
        from .viewer.session import Session, stamp_of

        if scene is None:
            session = Session(quadrics_scene(), "Nine quadrics", select=0)
        else:
            stamp = stamp_of(scene)
            session = Session(_load(scene, None), scene.stem, scene, stamp=stamp)
        with compile_notes():
            session.scene()
        serve(session, port, browser, say)


@app.command(epilog="Example:\n\n  conicoid export scene.yaml scene.html")
def export(
    scene: SceneFile,
    output: Annotated[Path, typer.Argument(metavar="PAGE", help="The page, .html.", show_default=False)],
) -> None:
    """Write a scene as one page that any current browser shows, from a disk, with no server."""
    with user_mistakes():
        if output.suffix.lower() not in (".html", ".htm"):
            raise ValueError(f"{output}: pages are saved as .html")
        _check_folder(output)
        loaded = _load(scene, None)
        from .viewer import export as write_page

        with compile_notes():
            write_page(loaded, output, scene.stem)
        say(f"{output}: {output.stat().st_size / 1024:,.0f} KiB")


@app.command(
    epilog="Examples:\n\n  conicoid info scene.yaml\n\n  conicoid info scene.yaml --check\n\n"
    "Overlaps may be meant: the body listed first has them. docs/booleans.md says what the check finds."
)
def info(
    scene: SceneFile,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Look for overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits."
        ),
    ] = False,
    rays: Annotated[int, typer.Option(min=1, help="Rays for the check.")] = 200_000,
    seed: Annotated[int, typer.Option(min=0, help="Of the check's random rays.")] = 0,
) -> None:
    """List the bodies of a scene with their bounds, and what it takes in memory; check it."""
    with user_mistakes():
        loaded = _load(scene, None)
        from . import report

        with compile_notes():
            lines = [*report.listing(loaded), "", *report.totals(loaded)]
        for line in lines:
            typer.echo(line)
        if not check:
            return
        from .checks.check import check as find

        with compile_notes(), Bar("checking", "step") as bar:
            findings = find(loaded, rays, seed, bar)
        for line in report.findings(findings):
            typer.echo(line)


@app.command(
    epilog="Examples:\n\n  conicoid trace scene.yaml rays.npy -o hits.npz\n\n"
    "  conicoid trace scene.yaml rays.csv -o spans.csv --spans\n\n"
    "rays.npy has shape (N, 6): origin and direction. docs/files.md describes all files."
)
def trace(
    scene: SceneFile,
    rays: Annotated[Path, typer.Argument(metavar="RAYS", help="Rays: .npy, .npz or .csv.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="The results, .npz or .csv.", show_default=False)],
    spans: Annotated[bool, typer.Option("--spans", help="Every stretch inside a body, not the first hit.")] = False,
    threads: Threads = None,
) -> None:
    """Follow rays through a scene and write what they hit."""
    with user_mistakes():
        from .formats.ray_file import check_output, read_rays, write_hits, write_spans

        check_output(output)
        _check_folder(output)
        table = read_rays(rays)
        loaded = _load(scene, threads)
        from . import ray_tables

        with compile_notes(), Bar("tracing", "ray") as bar:
            arrays = (ray_tables.spans if spans else ray_tables.first_hits)(loaded, table, bar)
        (write_spans if spans else write_hits)(output, arrays)
        say(f"{output}: {ray_tables.summary(arrays)}")


@app.command(
    "import",
    epilog="Examples:\n\n  conicoid import geometry.xml -o scene.yaml\n\n"
    "  conicoid import model.xml -o scene.yaml --no-void\n\ndocs/openmc.md says what becomes of what.",
)
def import_(
    geometry: Annotated[
        Path, typer.Argument(metavar="GEOMETRY", help="OpenMC's geometry.xml or model.xml.", show_default=False)
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="The scene file, .yaml or .json.", show_default=False)],
    void: Annotated[bool, typer.Option(help="Keep cells without material, as invisible bodies.")] = True,
    max_bodies: Annotated[int, typer.Option(min=1, help="Refuse what expands into more bodies.")] = 50_000,
) -> None:
    """Turn an OpenMC geometry into a scene; cells are coloured by material, and the legend is printed."""
    with user_mistakes():
        if output.suffix.lower() not in (".yaml", ".yml", ".json"):
            raise ValueError(f"{output}: scenes are saved as .yaml or .json")
        _check_folder(output)
        from .formats import openmc, scene_file
        from .shapes.labels import counted

        with refused_files(), Bar("expanding", "body") as bar:
            imported = openmc.read(geometry, void=void, max_bodies=max_bodies, progress=_counted(geometry, bar))
        scene_file.write(imported, output, imported.material_names)
        for line in (*imported.notes, *imported.legend):
            typer.echo(line)
        say(f"{output}: {counted(len(imported.bodies), 'body', 'bodies')}")


@app.command(
    epilog="Examples:\n\n  conicoid bench\n\n  conicoid bench --rows camera-1000 --rows build\n\n"
    "  conicoid bench --accuracy --rows sphere --picture errors.png\n\n"
    "Rows: camera, random, picture, build, growth and more against peers; latency, import, command, compile, memory "
    "against what is asked of Conicoid itself, at most.\n\n"
    'The peers come with `pip install ".[bench]"` in the repository; docs/performance.md says how to read the table, '
    "docs/exactness-measured.md that of accuracy."
)
def bench(
    rows: Annotated[
        list[str] | None,
        typer.Option(
            "--rows",
            help="Only this row; may be repeated. With --accuracy: a shape, a family of rays, float32 or float64.",
            show_default=False,
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Small, to see that all works; the ratios mean nothing.")
    ] = False,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the table as Markdown, as in the documentation.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--json", help="Write the figures to a file as well.", show_default=False)
    ] = None,
    accuracy: Annotated[bool, typer.Option("--accuracy", help="Measure errors instead of times.")] = False,
    rays: Annotated[
        int | None, typer.Option(min=1, help="With --accuracy: rays of each row.", show_default="100000")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="With --accuracy: a picture of the errors, .png.", show_default=False)
    ] = None,
) -> None:
    """Time the same rays in Conicoid and in every peer that is installed, in turn; or measure how wrong each is."""
    with user_mistakes():
        from .bench import command as times
        from .bench.accuracy import command as errors

        for file in filter(None, (output, picture)):
            _check_folder(file)
        if accuracy:
            shown = errors.measure(rows or (), rays or (2000 if quick else 100_000), output, picture, say)
        elif rays is not None or picture is not None:
            raise ValueError("bench: --rays and --picture go with --accuracy")
        else:
            shown = times.measure(rows or (), quick, output, say)
        if markdown:
            typer.echo(shown.markdown)
        else:
            show_table(shown.table, shown.about)


@app.command(epilog="Example:\n\n  conicoid schema > scene.schema.json")
def schema() -> None:
    """Print the JSON Schema of scene files, with which editors complete and check them."""
    import json

    from .formats.schema import scene_schema

    with user_mistakes():
        typer.echo(json.dumps(scene_schema(), indent=2))


@contextlib.contextmanager
def refused_files() -> Iterator[None]:
    """List the mistakes in a file, and end with exit code 2."""
    from .formats.errors import SceneFileError

    try:
        yield
    except SceneFileError as error:
        say(f"error: {error}" if len(error.problems) == 1 else f"{len(error.problems)} errors:\n{error}")
        raise SystemExit(MISTAKE) from None


def _load(path: Path, threads: int | None) -> Scene:
    from .files import load

    with refused_files():
        scene = load(path)
    if threads is not None:
        from .trace.threads import set_threads

        set_threads(threads)
    return scene


def _check_folder(output: Path) -> None:
    """Refuse an output that cannot be written before the work, not after it."""
    if output.is_dir():
        raise IsADirectoryError(21, "is a directory", str(output))
    if output.exists() and not output.is_file():
        raise OSError(22, "is not a regular file", str(output))
    if not output.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(output.parent))


def _rays(bar: Bar, count: int) -> Any:
    """Progress that is counted in tiles, shown in rays."""

    def progress(done: int, tiles: int) -> None:
        bar.scale = count / tiles
        bar(done, tiles)

    return progress


def _counted(geometry: Path, bar: Bar) -> Any:
    """Progress that states the number of bodies before the first of them is made."""
    from .shapes.labels import counted

    def progress(done: int, count: int) -> None:
        if done == 0:
            say(f"{geometry}: expands into {counted(count, 'body', 'bodies')}")
        bar(done, count)

    return progress
