"""The commands conicoid render, turntable, animate and slice."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..render.integrators import with_option
from .drawing import PROGRESSIVE, RenderRequest, draw
from .options import (
    Axes,
    Bits,
    ClusterOption,
    Depth,
    DeviceOption,
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
    SceneFile,
    Section,
    Seed,
    Shutter,
    SlurmOption,
    Threads,
    Time,
    ToneOption,
    Up,
    WorkersOption,
    is_given,
    only_with,
)
from .resources import (
    STDOUT,
    check_folder,
    check_stdout,
    count_rays,
    executor_of,
    load,
    name_of,
    prepare,
    show_warnings,
    write_output,
)
from .terminal import Bar, show_message

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene.scene import Scene


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
    "Frames are kept beside the output and used again, so an interrupted command continues. "
    "A .mp4 needs `pip install 'conicoid\\[video]'`."
)

_VIEW_OPTIONS = (
    "integrator", "seed", "depth", "position", "look_at", "up", "field_of_view", "orthographic", "fit", "axes",
    "labels", "normals", "resume", "workers", "cluster", "slurm", "filter", "noise", "layers", "shutter", "preview",
    "device",
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
    device: DeviceOption = None,
) -> None:  # fmt: skip
    """Make a picture of a scene. A scene without a camera or lights gets some that fit."""
    # With --noise the default of --samples is no limit
    limit = None if noise is not None and not is_given(context, "samples") else samples
    request = RenderRequest(
        output, width, height, limit, integrator, seed, depth, axes, labels, normals, filter=filter, noise=noise,
        exposure=exposure, tone=tone, bits=bits, resume=resume, preview=preview,
        executor=(workers, cluster, slurm), device=device,
    )  # fmt: skip
    request.check_output()
    _check(context, samples, integrator, seed, depth)
    only_with(context, "a view, not with --section", section is None, *_VIEW_OPTIONS)
    only_with(context, "this process, not with workers", not any(request.executor), "device")
    request.check_device()
    names = _film(context, output, layers, bits, exposure, tone)
    plane = None if section is None else _plane(context, section)
    interval = None if shutter is None else _numbers(context, "--shutter", shutter, 2, "two numbers, 0,0.5 say")
    only_with(context, "a moment, not with --shutter", interval is None, "time")
    if preview is not None:
        only_with(context, f"--integrator {' or '.join(PROGRESSIVE)}", integrator in PROGRESSIVE, "preview")
        check_folder(preview)
    request = request._replace(layers=names, plane=plane, shutter=interval)
    loaded = load(scene, threads, outside)
    loaded = loaded if time is None else loaded.at(time)
    with show_warnings():
        camera = _camera(context, loaded, width / height, position, look_at, up, field_of_view, orthographic, fit)
    draw(loaded, camera, request)


def turntable(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The film: .gif, .webp or .mp4.", show_default=False)
    ],
    frames: Annotated[int, typer.Option(min=1, help="Pictures of a whole turn.")] = 48,
    seconds: Annotated[float, typer.Option(help="Length of a turn.")] = 4.0,
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
        Path | None, typer.Option(help="The folder of the frames.", show_default="OUTPUT-frames")
    ] = None,
    keep: Annotated[bool, typer.Option(help="Keep the frames at the end.")] = True,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Turn a scene about once: the camera goes around the point that it looks at."""
    from .._util.validation import check_positive
    from ..io.image_codecs import check_movie
    from ..scene.movies import turntable as turn

    check_movie(output, width, height, frames, check_positive("turntable", "seconds", seconds))
    check_folder(output)
    _check(context, samples, integrator, seed, depth)
    loaded = load(scene, threads)
    with show_warnings():
        camera = _camera(context, loaded, width / height, position, look_at, up, field_of_view, orthographic, False)
    if fit:  # the turntable then fits a camera to the whole turn
        loaded = loaded.replace(camera=None)
    prepare(loaded)
    executor_context = executor_of("turntable", workers, cluster, slurm)
    with Bar("turning", "ray") as bar, executor_context as executor:
        rendered = turn(
            loaded, output, frames=frames, seconds=seconds, width=width, height=height, samples=samples,
            integrator=integrator, seed=seed, depth=depth, camera=camera, axes=axes, labels=labels,
            normals=normals, folder=folder, keep=keep, progress=count_rays(bar, width * height * samples * frames),
            executor=executor,
        )  # fmt: skip
    reused = f", {frames - rendered} of them were there" if rendered < frames else ""
    show_message(f"{output}: {frames} frames of {width} x {height} pixels{reused}")


def _film(
    context: typer.Context, output: Path, layers: str | None, bits: int | None, exposure: float, tone: str
) -> tuple[str, ...]:
    """Return the names of the layers; raise ValueError for options that the file cannot hold, before the work."""
    from ..render.color_mapping import check_exposure, check_tone
    from ..render.film import check_layers

    suffix = ".png" if output == STDOUT else output.suffix.lower()
    only_with(context, "an .exr", suffix == ".exr", "layers")
    only_with(context, "a .png or an .exr", suffix in (".png", ".exr"), "bits")
    only_with(context, "a displayed picture, not with an .exr of light", suffix != ".exr", "exposure", "tone")
    if bits is not None and bits != 16 and bits != (8 if suffix == ".png" else 32):
        raise ValueError(f"{context.info_name}: --bits must be 16, or {8 if suffix == '.png' else 32}, got {bits}")
    check_exposure(str(context.info_name), exposure)
    check_tone(str(context.info_name), tone)
    if layers is None:
        return ()
    return check_layers(True if layers == "all" else [name.strip() for name in layers.split(",")])


def _check(context: typer.Context, samples: int, integrator: str, seed: int, depth: int) -> None:
    """Raise ValueError for options of light or of the camera that do not go together."""
    check_light(context, samples, integrator, seed, depth)
    only_with(context, "--position", context.params["position"] is not None, "look_at", "up", "field_of_view",
              "orthographic")  # fmt: skip
    only_with(
        context, "a pinhole camera, not with --orthographic", context.params["orthographic"] is None, "field_of_view"
    )
    only_with(context, "the scene's camera, without --position", context.params["position"] is None, "fit")


def check_light(context: typer.Context, samples: int, integrator: str, seed: int, depth: int) -> None:
    """Raise ValueError for wrong options of light."""
    from ..render.exposure import check_options

    check_options(samples, integrator, seed, depth)
    deep = with_option("depth")
    only_with(context, f"--integrator {' or '.join(deep)}", integrator in deep, "depth")
    only_with(context, "--samples 2 or more", samples > 1, "seed")


def _camera(
    context: typer.Context, scene: Scene, aspect: float,
    position: str | None, look_at: str | None, up: str | None, field_of_view: float | None,
    orthographic: float | None, fit: bool,
) -> AnyCamera | None:  # fmt: skip
    """Return the camera that the options describe; None for that of the scene."""
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


def _plane(context: typer.Context, text: str) -> tuple[str, float]:
    """Return z=0 as an axis and a number."""
    axis, _, value = text.partition("=")
    try:
        if axis.strip() in AXES:
            return axis.strip(), float(value)
    except ValueError:
        pass  # the message below names the form for both mistakes
    raise ValueError(f"{context.info_name}: --section must be x=NUMBER, y=NUMBER or z=NUMBER, got {text[:80]!r}")


def _numbers(context: typer.Context, option: str, text: str, count: int, form: str) -> Any:
    """Return a tuple of numbers with commas between them; `form` describes them in the message for any other text."""
    try:
        numbers = tuple(map(float, text.split(",")))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        raise ValueError(f"{context.info_name}: {option} must be {form}, got {text[:80]!r}")
    return numbers


def _point(context: typer.Context, option: str, text: str) -> tuple[float, ...]:
    """Return X,Y,Z as three numbers."""
    return _numbers(context, option, text, 3, "three numbers X,Y,Z")


# --- animate

ANIMATE_EXAMPLES = (
    "Examples:\n\n  conicoid animate scene.yaml -o film.gif\n\n"
    "  conicoid animate scene.yaml -o film.mp4 --width 1280 --height 720 --shutter 0.5 --samples 64\n\n"
    "The section `animation` of the scene file has the motions (docs/cameras-and-film.md). Finished frames are kept "
    "beside the output, so an interrupted film goes on from there."
)


def animate(
    context: typer.Context,
    scene: SceneFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The film: .gif, .webp or .mp4.", show_default=False)
    ],
    frames: Annotated[int | None, typer.Option(min=1, help="Pictures in all.", show_default="24 a second")] = None,
    seconds: Annotated[float | None, typer.Option(help="Length of the film.", show_default="to the last key")] = None,
    start: Annotated[float, typer.Option(help="The time of the animation at which it begins, in seconds.")] = 0.0,
    shutter: Annotated[float, typer.Option(help="The share of a frame for which the shutter is open.")] = 0.5,
    times: Annotated[
        int | None, typer.Option(min=1, help="The number of moments of that share.", show_default="64 at most")
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
        Path | None, typer.Option(help="The folder of the frames.", show_default="OUTPUT-frames")
    ] = None,
    keep: Annotated[bool, typer.Option(help="Keep the frames at the end.")] = True,
    outside: Outside = False,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    slurm: SlurmOption = None,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Make a film of a scene that moves by keyframes."""
    from ..scene.movies import animate as film, frame_count

    check_folder(output)
    check_light(context, samples, integrator, seed, depth)
    loaded = load(scene, threads, outside)
    count = frame_count(loaded, frames, seconds, start)
    prepare(loaded)
    executor_context = executor_of("animate", workers, cluster, slurm)
    with show_warnings(), Bar("filming", "ray") as bar, executor_context as executor:
        rendered = film(
            loaded, output, frames=frames, seconds=seconds, start=start, shutter=shutter, times=times,
            width=width, height=height, samples=samples, integrator=integrator, seed=seed, depth=depth,
            axes=axes, labels=labels, normals=normals, folder=folder, keep=keep,
            progress=count_rays(bar, width * height * samples * count), executor=executor,
        )  # fmt: skip
    reused = f", {count - rendered} of them were there" if rendered < count else ""
    show_message(f"{output}: {count} frames of {width} x {height} pixels{reused}")


# --- slice

SLICE_EXAMPLES = (
    "Examples:\n\n  conicoid slice scene.yaml -o slice.svg\n\n"
    "  conicoid slice scene.yaml -o slice.pdf --axis y --at 0.5 --by material\n\n"
    "  conicoid slice scene.yaml -o oblique.png --origin 0,0,0 --u 1,1,0 --v 0,0,1 --pixels 1200\n\n"
    "docs/slices.md describes the picture."
)


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
    axis: Annotated[str, typer.Option(help="The axis across which the plane lies: x, y or z.")] = "z",
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
    by: Annotated[str, typer.Option(help="A colour for each: body or material.")] = "body",
    outlines: Annotated[bool, typer.Option(help="Draw the walls.")] = True,
    legend: Annotated[bool, typer.Option(help="Draw a legend of the colours.")] = True,
    problems: Annotated[
        bool, typer.Option("--problems", help="Red where bodies overlap, magenta where a domain is undefined.")
    ] = False,
    threads: Threads = None,
) -> None:  # fmt: skip
    """Draw a slice of a scene by a plane: bodies or materials in colours, walls as exact curves."""
    from .._util.text import check_choice
    from ..render.options import BY, check_suffix

    if output == STDOUT:
        check_stdout("a slice")
    else:
        check_suffix(output.suffix.lower(), output)
    check_folder(output)
    check_choice("slice", "--by", by, BY)
    check_choice("slice", "--axis", axis, AXES)
    corner = origin is not None
    only_with(context, "an axis, not with --origin", not corner, "axis", "at")
    only_with(context, "--origin", corner, "u", "v")
    if corner and (u is None or v is None):
        raise ValueError("slice: --origin goes with both --u and --v")
    loaded = load(scene, threads)
    prepare(loaded)
    with Bar("slicing", "point") as bar:
        if origin is None or u is None or v is None:
            cut = loaded.slice(axis, at, pixels=pixels, progress=bar)
        else:
            corner_at, right, up = (
                _point(context, f"--{name}", text) for name, text in (("origin", origin), ("u", u), ("v", v))
            )
            cut = loaded.slice(origin=corner_at, u=right, v=up, pixels=pixels, progress=bar)
    with write_output(output, ".svg") as file:
        cut.save(file, by, outlines=outlines, legend=legend, problems=problems)
    pieces = f", {len(cut.outlines)} outlines" if outlines else ""
    show_message(f"{name_of(output)}: {cut.body.shape[1]} x {cut.body.shape[0]} pixels{pieces}")
