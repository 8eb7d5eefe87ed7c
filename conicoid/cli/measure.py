"""The commands conicoid lengths, measure and explain: lengths inside bodies, sizes of bodies, one ray explained."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from .options import RayFile, Results, SceneFile, Threads, TMax, TMin, only_with
from .resources import STDOUT, check_folder, load, name_of, prepare, ray_file, write_output
from .terminal import Bar, show_message

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
