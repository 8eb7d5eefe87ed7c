"""The commands conicoid render, turntable and animate."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..integrators import with_option
from .drawing import PROGRESSIVE, Wanted, draw
from .parts import ClusterOption, SceneFile, SlurmOption, Threads, WorkersOption, only_with
from .picture_options import (
    Axes,
    Bits,
    Depth,
    Exposure,
    FieldOfView,
    FilterOption,
    Fit,
    Integrator,
    Labels,
    Layers,
    LookAt,
    Noise,
    Normals,
    Orthographic,
    Outside,
    Pixels,
    Position,
    Preview,
    Resume,
    Samples,
    Section,
    Seed,
    Shutter,
    Time,
    ToneOption,
    Up,
)
from .plain import NOTHING_SEEN
from .terminal import Bar, compile_notes, say, user_mistakes
from .workers import executor_of
from .working import STDOUT, check_folder, in_rays, load, prepare, said_warnings

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene

RENDER_EXAMPLES = (
    "Examples:\n\n  conicoid render scene.yaml -o picture.png\n\n"
    "  conicoid render scene.yaml -o large.exr --width 1920 --height 1080\n\n"
    "  conicoid render scene.yaml -o side.png --position 9,0,1 --look-at 0,0,1 --axes --labels\n\n"
    "  conicoid render scene.yaml -o plan.png --position 0,0,9 --orthographic 4\n\n"
    "  conicoid render scene.yaml -o slice.png --section z=0"
)
TURNTABLE_EXAMPLES = (
    "Examples:\n\n  conicoid turntable scene.yaml -o spin.gif\n\n"
    "  conicoid turntable scene.yaml -o spin.mp4 --width 1280 --height 720 --frames 120 --workers 4\n\n"
    "Frames are kept beside the output and taken again, so what was interrupted goes on. "
    'A .mp4 needs `pip install ".\\[video]"` in the repository.'
)

_OF_VIEWS = (
    "integrator", "seed", "depth", "position", "look_at", "up", "field_of_view", "orthographic", "fit", "axes",
    "labels", "normals", "resume", "workers", "cluster", "slurm", "filter", "noise", "layers", "shutter", "preview",
)  # fmt: skip
AXES = ("x", "y", "z")


def render(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", help="The picture: .png, .exr, .jpg or .webp; - is .png on standard output.",
            show_default=False,
        ),
    ],
    width: Pixels = 640,
    height: Pixels = 480,
    samples: Samples = 4,
    integrator: Integrator = "whitted",
    seed: Seed = 0,
    depth: Depth = 10,
    position: Position = None,
    look_at: LookAt = None,
    up: Up = None,
    field_of_view: FieldOfView = None,
    orthographic: Orthographic = None,
    fit: Fit = False,
    axes: Axes = False,
    labels: Labels = False,
    normals: Normals = False,
    section: Section = None,
    filter: FilterOption = "box",  # noqa: A002
    noise: Noise = None,
    layers: Layers = None,
    exposure: Exposure = 0.0,
    tone: ToneOption = "srgb",
    bits: Bits = None,
    resume: Resume = None,
    shutter: Shutter = None,
    time: Time = None,
    preview: Preview = None,
    outside: Outside = False,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Make a picture of a scene. A scene without a camera or lights gets some that fit."""
    with user_mistakes():
        limit = None if noise is not None and not _is_given(context, "samples") else samples
        wanted = Wanted(
            output, width, height, limit, integrator, seed, depth, axes, labels, normals, filter=filter, noise=noise,
            exposure=exposure, tone=tone, bits=bits, resume=resume, preview=preview,
            executor=(workers, cluster, slurm),
        )  # fmt: skip
        wanted.check_output()
        _check(context, samples, integrator, seed, depth)
        only_with(context, "a view, not with --section", section is None, *_OF_VIEWS)
        names = _film(context, output, layers, bits, exposure, tone)
        plane = None if section is None else _plane(context, section)
        during = None if shutter is None else _interval(context, "--shutter", shutter)
        only_with(context, "a moment, not with --shutter", during is None, "time")
        if preview is not None:
            only_with(context, f"--integrator {' or '.join(PROGRESSIVE)}", integrator in PROGRESSIVE, "preview")
            check_folder(preview)
        wanted = replace(wanted, layers=names, plane=plane, shutter=during)
        loaded = load(scene, threads, outside)
        loaded = loaded if time is None else loaded.at(time)
        with said_warnings():
            camera = _camera(context, loaded, width / height, position, look_at, up, field_of_view, orthographic, fit)
        draw(loaded, camera, wanted, "" if fit else NOTHING_SEEN)


def turntable(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="What moves: .gif, .webp or .mp4.", show_default=False)
    ],
    frames: Annotated[int, typer.Option(min=1, help="Pictures of a whole turn.")] = 48,
    seconds: Annotated[float, typer.Option(help="That a turn takes.")] = 4.0,
    width: Pixels = 480,
    height: Pixels = 360,
    samples: Samples = 4,
    integrator: Integrator = "whitted",
    seed: Seed = 0,
    depth: Depth = 10,
    position: Position = None,
    look_at: LookAt = None,
    up: Up = None,
    field_of_view: FieldOfView = None,
    orthographic: Orthographic = None,
    fit: Fit = False,
    axes: Axes = False,
    labels: Labels = False,
    normals: Normals = False,
    folder: Annotated[
        Path | None, typer.Option(help="Where frames are kept.", show_default="OUTPUT-frames")
    ] = None,
    keep: Annotated[bool, typer.Option(help="Keep the frames in the end.")] = True,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Turn a scene about once: the camera goes around what it looks at."""
    with user_mistakes():
        from ..formats.movie import check_movie
        from ..shapes.validate import positive
        from ..turntables.turntable import turntable as turn

        check_movie(output, width, height, frames, positive("turntable", "seconds", seconds))
        check_folder(output)
        _check(context, samples, integrator, seed, depth)
        loaded = load(scene, threads)
        with said_warnings():
            camera = _camera(context, loaded, width / height, position, look_at, up, field_of_view, orthographic, False)
        if fit:
            loaded = loaded.replace(camera=None)
        prepare(loaded)
        where = executor_of("turntable", workers, cluster, slurm)
        with compile_notes(), Bar("turning", "ray") as bar, where as executor:
            rendered = turn(
                loaded, output, frames=frames, seconds=seconds, width=width, height=height, samples=samples,
                integrator=integrator, seed=seed, depth=depth, camera=camera, axes=axes, labels=labels,
                normals=normals, folder=folder, keep=keep, progress=in_rays(bar, width * height * samples * frames),
                executor=executor,
            )  # fmt: skip
        taken = f", {frames - rendered} of them were there" if rendered < frames else ""
        say(f"{output}: {frames} frames of {width} x {height} pixels{taken}")


def _film(
    context: typer.Context, output: Path, layers: str | None, bits: int | None, exposure: float, tone: str
) -> tuple[str, ...]:
    """The names of the layers; mistakes in what is saved are found before anything is rendered."""
    from ..film.layer_names import checked_layers
    from ..film.tone import checked_exposure, checked_tone

    suffix = ".png" if output == STDOUT else output.suffix.lower()
    only_with(context, "an .exr", suffix == ".exr", "layers")
    only_with(context, "a .png or an .exr", suffix in (".png", ".exr"), "bits")
    only_with(context, "what is displayed, not with an .exr of light", suffix != ".exr", "exposure", "tone")
    if bits is not None and bits != 16 and bits != (8 if suffix == ".png" else 32):
        raise ValueError(f"{context.info_name}: --bits must be 16, or {8 if suffix == '.png' else 32}, got {bits}")
    checked_exposure(str(context.info_name), exposure)
    checked_tone(str(context.info_name), tone)
    if layers is None:
        return ()
    return checked_layers(True if layers == "all" else [name.strip() for name in layers.split(",")])


def _is_given(context: typer.Context, name: str) -> bool:
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def _check(context: typer.Context, samples: int, integrator: str, seed: int, depth: int) -> None:
    check_light(context, samples, integrator, seed, depth)
    only_with(context, "--position", context.params["position"] is not None, "look_at", "up", "field_of_view",
              "orthographic")  # fmt: skip
    only_with(
        context, "a pinhole camera, not with --orthographic", context.params["orthographic"] is None, "field_of_view"
    )
    only_with(context, "the scene's camera, without --position", context.params["position"] is None, "fit")


def check_light(context: typer.Context, samples: int, integrator: str, seed: int, depth: int) -> None:
    """The options of how light is gathered, or an error."""
    from ..render.picture import check_options

    check_options(samples, integrator, seed, depth)
    deep = with_option("depth")
    only_with(context, f"--integrator {' or '.join(deep)}", integrator in deep, "depth")
    only_with(context, "--samples 2 or more", samples > 1, "seed")


def _camera(
    context: typer.Context, scene: Scene, aspect: float,
    position: str | None, look_at: str | None, up: str | None, field_of_view: float | None,
    orthographic: float | None, fit: bool,
) -> AnyCamera | None:  # fmt: skip
    """The camera that the options describe; None for the scene's."""
    if fit:
        return scene.fitting_camera(aspect)
    if position is None:
        return None
    from ..render.camera import Camera, OrthographicCamera

    low, high = scene.extent
    target = tuple((0.5 * low + 0.5 * high).tolist()) if look_at is None else _point(context, "--look-at", look_at)
    more: dict[str, Any] = {} if field_of_view is None else dict(field_of_view=field_of_view)
    if up is not None:
        more["up"] = _point(context, "--up", up)
    place = _point(context, "--position", position)
    if orthographic is not None:
        return OrthographicCamera(place, target, **more, height=orthographic)
    return Camera(place, target, **more)


def _interval(context: typer.Context, option: str, text: str) -> tuple[float, float]:
    try:
        first, last = (float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"{context.info_name}: {option} must be two numbers, 0,0.5 say, got {text[:80]!r}") from None
    return first, last


def _plane(context: typer.Context, text: str) -> tuple[str, float]:
    """z=0 as an axis and a number."""
    axis, _, value = text.partition("=")
    try:
        if axis.strip() in AXES:
            return axis.strip(), float(value)
    except ValueError:
        pass
    raise ValueError(f"{context.info_name}: --section must be x=NUMBER, y=NUMBER or z=NUMBER, got {text[:80]!r}")


def _point(context: typer.Context, option: str, text: str) -> tuple[float, ...]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"{context.info_name}: {option} must be three numbers X,Y,Z, got {text[:80]!r}") from None
    return x, y, z
