"""A picture from a scene to its file, as `conicoid render` makes it, with previews while it improves.

`parse_plain_render` runs the plain command without Typer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from ..render.integrators import INTEGRATORS
from ..render.options import MOST_SAMPLES, Filter, Tone
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
from .terminal import EXIT_OK, Bar, show_message, user_mistakes

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene.scene import Scene


def previews(bar: Bar, path: Path | None, developed: Callable[[Any], Any]) -> Callable[[Any], None]:
    """Return a function that shows the noise of a picture as it improves, and writes the picture, whole, at `path`.

    path: STDOUT for a picture above the line of progress, in the terminal.
    """

    def show(image: Any) -> None:
        if image.noise < float("inf"):
            bar.note = f", noise {image.noise:.2g}"
        if path == STDOUT:
            if bar.console.is_terminal:
                from ..io.image_codecs import render_half_blocks

                bar.picture = render_half_blocks(
                    developed(image)._display_light, bar.console.width, max(1, bar.console.height - 3)
                )
        elif path is not None:
            developed(image).save(path)

    return show


# --- The picture

_ROWS = 16
"""Rows of pixels that are traced before all others."""
PROGRESSIVE = tuple(name for name, one in INTEGRATORS.items() if one.progressive)


class RenderRequest(NamedTuple):
    """The options of a picture; the defaults are those of the command."""

    output: Path
    width: int = 640
    height: int = 480
    samples: int | None = 4
    integrator: str = "whitted"
    seed: int = 0
    depth: int = 10
    axes: bool = False
    labels: bool = False
    normals: bool = False
    plane: tuple[str, float] | None = None
    """The axis and place of a section, in place of a view."""
    filter: str = "box"
    noise: float | None = None
    layers: tuple[str, ...] = ()
    exposure: float = 0.0
    tone: str = "srgb"
    bits: int | None = None
    resume: Path | None = None
    shutter: tuple[float, float] | None = None
    preview: Path | None = None
    executor: tuple[int | None, str | None, int | None] = (None, None, None)
    """Workers, the address of a cluster, jobs of Slurm."""
    device: str | None = None

    def check_output(self) -> None:
        """Refuse an output that cannot be written, before the work."""
        from ..io.image import SUFFIXES

        if self.output == STDOUT:
            check_stdout("a picture")
        elif self.output.suffix.lower() not in SUFFIXES:
            raise ValueError(f"{self.output}: pictures are saved as {', '.join(SUFFIXES)}")
        elif self.output.suffix.lower() == ".exr":
            from ..materials.image_file import import_openexr

            import_openexr()
        check_folder(self.output)

    def check_device(self) -> None:
        """Refuse a device that is not there, before the work."""
        if self.device is None:
            return
        from ..queries.device_choice import device_of

        try:
            device_of("render", self.device)
        except RuntimeError as error:
            raise ValueError(str(error)) from None

    def developed(self, image: Any) -> Any:
        """Return a picture as it is displayed."""
        plain = self.exposure == 0 and self.tone == "srgb"
        return image if plain else image.developed(self.exposure, cast(Tone, self.tone))


def draw(scene: Scene, camera: AnyCamera | None, request: RenderRequest) -> None:
    """Make a picture and write it.

    camera: None for that of the scene.
    """
    width, height = request.width, request.height
    prepare(scene)
    with (
        show_warnings(),
        Bar("rendering", "ray") as bar,
        executor_of("render", *request.executor) as executor,
    ):
        image = request.developed(
            scene.section(*request.plane, width, height, request.samples or MOST_SAMPLES)
            if request.plane
            else _view(scene, camera, request, bar, executor)
        )
    if request.plane is None and _sees_nothing(scene, camera, width, height):
        show_message("note: no body is in view; --fit takes a camera that sees all that is bounded")
    with write_output(request.output, ".png") as file:
        image.save(file, bits=request.bits)
    if request.resume is not None:
        request.resume.unlink(missing_ok=True)  # the picture is complete: its tiles have no further use
    show_message(f"{name_of(request.output)}: {width} x {height} pixels")


def _view(scene: Scene, camera: AnyCamera | None, request: RenderRequest, bar: Bar, executor: Any) -> Any:
    """Return the picture by the camera."""
    r = request
    return scene.render(
        r.width, r.height, r.samples, r.integrator, r.seed, depth=r.depth, camera=camera, filter=cast(Filter, r.filter),
        noise=r.noise, shutter=r.shutter, layers=r.layers, axes=r.axes, labels=r.labels, normals=r.normals,
        progress=count_rays(bar, r.width * r.height * (r.samples or MOST_SAMPLES)), executor=executor, resume=r.resume,
        device=cast(Any, r.device),
        preview=previews(bar, r.preview, r.developed) if r.integrator in PROGRESSIVE else None,
    )  # fmt: skip


def _sees_nothing(scene: Scene, camera: AnyCamera | None, width: int, height: int) -> bool:
    """Return whether no ray through the centre of a pixel hits; a few rows are traced first, from the middle on."""
    view = camera or scene.camera
    if view is None or not scene.bodies:
        return False
    rays = view.lazy_rays(width, height)
    step = max(1, height // _ROWS)
    # Bodies are most likely in the middle, so one of few rows usually decides
    for row in sorted(range(step // 2, height, step), key=lambda row: abs(2 * row - height)):
        if scene.occluded(rays.part(row * width, (row + 1) * width)).any():
            return False
    return not scene.occluded(rays).any()


# --- Plain commands

_NUMBERS = "--width", "--height", "--samples", "--threads"
_OUTPUT = "-o", "--output"
_DIGITS = 9
"""The longest number of a plain command."""


def parse_plain_render(arguments: Sequence[str]) -> Callable[[], int] | None:
    """Return a function that runs a plain command and returns its exit code.

    Plain commands are `conicoid render SCENE -o PICTURE` with options that are whole numbers. They need no Typer, with
    whose import a small picture takes 1.45 times as long (0.54 s in place of 0.38). None for other commands, and for
    any that may be a mistake: the command line proper handles these, with its messages.
    """
    if not arguments or arguments[0] != "render":
        return None
    numbers: dict[str, int] = {}
    outputs, scenes, rest = [], [], list(arguments[1:])
    while rest:
        word = rest.pop(0)
        if not word.startswith("-") and word:
            scenes.append(word)
            continue
        if word not in (*_NUMBERS, *_OUTPUT) or word in numbers or not rest:
            return None
        value = rest.pop(0)
        if word in _OUTPUT:
            outputs.append(value)
        elif value.isascii() and value.isdigit() and len(value) <= _DIGITS and int(value) > 0:
            numbers[word] = int(value)
        else:
            return None
    # Repeated and missing arguments get the messages of the command line proper
    if len(outputs) != 1 or len(scenes) != 1 or not outputs[0] or outputs[0].startswith("-"):
        return None
    return lambda: _render(Path(scenes[0]), Path(outputs[0]), {name[2:]: each for name, each in numbers.items()})


def _render(scene: Path, output: Path, numbers: dict[str, int]) -> int:
    """Make a picture with some options of `render`; return the exit code."""
    from .._util.environment import check_environment

    with user_mistakes():
        check_environment()
        from .._util.process import pause_gc
        from ..render.exposure import check_options

        threads = numbers.pop("threads", None)
        request = RenderRequest(output, **numbers)  # type: ignore[arg-type]
        request.check_output()
        check_options(request.samples, request.integrator, request.seed, request.depth)
        with pause_gc():  # the process ends after one scene and one picture
            draw(load(scene, threads), None, request)
    return EXIT_OK
