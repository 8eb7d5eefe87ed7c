"""The command conicoid animate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .parts import ClusterOption, SceneFile, SlurmOption, Threads, WorkersOption
from .picture_options import Axes, Depth, Integrator, Labels, Normals, Outside, Pixels, Samples, Seed
from .pictures import check_light
from .terminal import Bar, compile_notes, say, user_mistakes
from .workers import executor_of
from .working import check_folder, in_rays, load, prepare, said_warnings

ANIMATE_EXAMPLES = (
    "Examples:\n\n  conicoid animate scene.yaml -o film.gif\n\n"
    "  conicoid animate scene.yaml -o film.mp4 --width 1280 --height 720 --shutter 0.5 --samples 64\n\n"
    "What moves stands in the section `animation` of the scene file (docs/film.md). Frames are kept beside the output "
    "and taken again, so what was interrupted goes on."
)


def animate(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The film: .gif, .webp or .mp4.", show_default=False)
    ],
    frames: Annotated[int | None, typer.Option(min=1, help="Pictures in all.", show_default="24 a second")] = None,
    seconds: Annotated[float | None, typer.Option(help="How long it is.", show_default="to the last key")] = None,
    start: Annotated[float, typer.Option(help="Where in the animation it begins, in seconds.")] = 0.0,
    shutter: Annotated[float, typer.Option(help="For which share of a frame the shutter is open.")] = 0.5,
    times: Annotated[
        int | None, typer.Option(min=1, help="In how many moments of that.", show_default="64 at most")
    ] = None,
    width: Pixels = 480,
    height: Pixels = 360,
    samples: Samples = 16,
    integrator: Integrator = "whitted",
    seed: Seed = 0,
    depth: Depth = 10,
    axes: Axes = False,
    labels: Labels = False,
    normals: Normals = False,
    folder: Annotated[
        Path | None, typer.Option(help="Where frames are kept.", show_default="OUTPUT-frames")
    ] = None,
    keep: Annotated[bool, typer.Option(help="Keep the frames in the end.")] = True,
    outside: Outside = False,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Make a film of a scene that moves by keyframes."""
    with user_mistakes():
        from ..turntables.animation import animate as film
        from ..turntables.animation import frame_count

        check_folder(output)
        check_light(context, samples, integrator, seed, depth)
        loaded = load(scene, threads, outside)
        count = frame_count(loaded, frames, seconds, start)
        prepare(loaded)
        where = executor_of("animate", workers, cluster, slurm)
        with compile_notes(), said_warnings(), Bar("filming", "ray") as bar, where as executor:
            rendered = film(
                loaded, output, frames=frames, seconds=seconds, start=start, shutter=shutter, times=times,
                width=width, height=height, samples=samples, integrator=integrator, seed=seed, depth=depth,
                axes=axes, labels=labels, normals=normals, folder=folder, keep=keep,
                progress=in_rays(bar, width * height * samples * count), executor=executor,
            )  # fmt: skip
        taken = f", {count - rendered} of them were there" if rendered < count else ""
        say(f"{output}: {count} frames of {width} x {height} pixels{taken}")
