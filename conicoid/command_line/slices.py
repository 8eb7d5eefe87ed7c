"""The command conicoid slice."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .parts import SceneFile, Threads, only_with
from .terminal import Bar, compile_notes, say, user_mistakes
from .working import STDOUT, check_folder, check_stdout, load, name_of, prepare, written

SLICE_EXAMPLES = (
    "Examples:\n\n  conicoid slice scene.yaml -o slice.svg\n\n"
    "  conicoid slice scene.yaml -o slice.pdf --axis y --at 0.5 --by material\n\n"
    "  conicoid slice scene.yaml -o oblique.png --origin 0,0,0 --u 1,1,0 --v 0,0,1 --pixels 1200\n\n"
    "docs/slices.md says what is drawn."
)
_AXES = ("x", "y", "z")


def slice_scene(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", help="The slice: .svg, .pdf, .png, .exr, .jpg or .webp; - is .svg on standard output.",
            show_default=False,
        ),
    ],
    axis: Annotated[str, typer.Option(help="Across which the plane lies, in a window that fits: x, y or z.")] = "z",
    at: Annotated[float, typer.Option(help="Where on the axis.")] = 0.0,
    origin: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="A corner, with --u and --v, not --axis.", show_default=False)
    ] = None,
    u: Annotated[
        str | None, typer.Option("--u", metavar="X,Y,Z", help="From it, over the width.", show_default=False)
    ] = None,
    v: Annotated[
        str | None, typer.Option("--v", metavar="X,Y,Z", help="From it, over the height.", show_default=False)
    ] = None,
    pixels: Annotated[int, typer.Option(min=1, help="Along the longer side.")] = 640,
    by: Annotated[str, typer.Option(help="What is coloured apart: body or material.")] = "body",
    outlines: Annotated[bool, typer.Option(help="Draw the walls.")] = True,
    legend: Annotated[bool, typer.Option(help="Say what the colours are.")] = True,
    problems: Annotated[
        bool, typer.Option("--problems", help="Red where bodies overlap, magenta where a domain is undefined.")
    ] = False,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Draw a slice of a scene by a plane: bodies or materials in colours, walls as exact curves."""
    with user_mistakes():
        from ..shapes.suggestion import one_of
        from ..slices.names import BY, check_suffix

        if output == STDOUT:
            check_stdout("a slice")
        else:
            check_suffix(output.suffix.lower(), output)
        check_folder(output)
        one_of("slice", "--by", by, BY)
        one_of("slice", "--axis", axis, _AXES)
        corner = origin is not None
        only_with(context, "an axis, not with --origin", not corner, "axis", "at")
        only_with(context, "--origin", corner, "u", "v")
        if corner and (u is None or v is None):
            raise ValueError("slice: --origin goes with both --u and --v")
        loaded = load(scene, threads)
        prepare(loaded)
        with compile_notes(), Bar("slicing", "point") as bar:
            if origin is None or u is None or v is None:
                cut = loaded.slice(axis, pixels=pixels, at=at, progress=bar)
            else:
                corner_at, right, up = _vector("--origin", origin), _vector("--u", u), _vector("--v", v)
                cut = loaded.slice(corner_at, right, up, pixels, progress=bar)
        with written(output, ".svg") as file:
            cut.save(file, by, outlines=outlines, legend=legend, problems=problems)
        pieces = f", {len(cut.outlines)} outlines" if outlines else ""
        say(f"{name_of(output)}: {cut.body.shape[1]} x {cut.body.shape[0]} pixels{pieces}")


def _vector(option: str, text: str) -> tuple[float, ...]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"slice: {option} must be three numbers X,Y,Z, got {text[:80]!r}") from None
    return x, y, z
