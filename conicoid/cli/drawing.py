"""Pictures that are shown while they become better."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..render.film.options import MOST_SAMPLES, Filter, Tone
from ..render.integrators import INTEGRATORS
from .resources import (
    STDOUT,
    check_folder,
    check_stdout,
    count_rays,
    executor_of,
    name_of,
    prepare,
    show_warnings,
    write_output,
)
from .terminal import EXIT_OK, Bar, compile_notes, show_message, user_mistakes

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene.scene import Scene


def previews(bar: Bar, path: Path | None, developed: Callable[[Any], Any]) -> Callable[[Any], None]:
    """What is done with a picture as it becomes better: its noise is told, and it is written, whole, at `path`.

    path: STDOUT for a picture above the line of progress, in the terminal.
    """

    def shown(image: Any) -> None:
        if image.noise < float("inf"):
            bar.note = f", noise {image.noise:.2g}"
        if path == STDOUT:
            if bar.console.is_terminal:
                from ..io.images.codecs import render_half_blocks

                bar.picture = render_half_blocks(
                    developed(image)._shown, bar.console.width, max(1, bar.console.height - 3)
                )
        elif path is not None:
            developed(image).save(path)

    return shown


# A picture from a scene to its file, as `conicoid render` makes it.

_ROWS = 16
"""Of pixels that are looked at before all."""
PROGRESSIVE = tuple(name for name, one in INTEGRATORS.items() if one.progressive)


@dataclass(frozen=True)
class RenderRequest:
    """What is wanted of a picture; the defaults are those of the command's options."""

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
    """A section, in place of a view."""
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

    def check_output(self) -> None:
        """Refuse an output that cannot be written before the work, not after it."""
        from ..io.images.image import SUFFIXES

        if self.output == STDOUT:
            check_stdout("a picture")
        elif self.output.suffix.lower() not in SUFFIXES:
            raise ValueError(f"{self.output}: pictures are saved as {', '.join(SUFFIXES)}")
        check_folder(self.output)

    def developed(self, image: Any) -> Any:
        """A picture as it is displayed."""
        plain = self.exposure == 0 and self.tone == "srgb"
        return image if plain else image.developed(self.exposure, cast(Tone, self.tone))


def draw(scene: Scene, camera: AnyCamera | None, wanted: RenderRequest, about_none: str) -> None:
    """Make a picture and write it. camera: None for the scene's; about_none: what to say where nothing is seen."""
    width, height = wanted.width, wanted.height
    prepare(scene)
    with (
        compile_notes(),
        show_warnings(),
        Bar("rendering", "ray") as bar,
        executor_of("render", *wanted.executor) as executor,
    ):
        image = wanted.developed(
            scene.section(*wanted.plane, width, height, wanted.samples or MOST_SAMPLES)
            if wanted.plane
            else _view(scene, camera, wanted, bar, executor)
        )
    if wanted.plane is None and _sees_nothing(scene, camera, width, height):
        show_message(f"note: no body is in view{about_none}")
    with write_output(wanted.output, ".png") as file:
        image.save(file, bits=wanted.bits)
    if wanted.resume is not None:
        wanted.resume.unlink(missing_ok=True)
    show_message(f"{name_of(wanted.output)}: {width} x {height} pixels")


def _view(scene: Scene, camera: AnyCamera | None, wanted: RenderRequest, bar: Bar, executor: Any) -> Any:
    """What the camera sees."""
    w = wanted
    return scene.render(
        w.width, w.height, w.samples, w.integrator, w.seed, depth=w.depth, camera=camera, filter=cast(Filter, w.filter),
        noise=w.noise, shutter=w.shutter, layers=w.layers, axes=w.axes, labels=w.labels, normals=w.normals,
        progress=count_rays(bar, w.width * w.height * (w.samples or MOST_SAMPLES)), executor=executor, resume=w.resume,
        preview=previews(bar, w.preview, w.developed) if w.integrator in PROGRESSIVE else None,
    )  # fmt: skip


def _sees_nothing(scene: Scene, camera: AnyCamera | None, width: int, height: int) -> bool:
    """Whether no ray through the centre of a pixel hits; those of a few rows are asked first, from the middle on."""
    seen_by = camera or scene.camera
    if seen_by is None or not scene.bodies:
        return False
    rays = seen_by.lazy_rays(width, height)
    few = max(1, height // _ROWS)
    for row in sorted(range(few // 2, height, few), key=lambda row: abs(2 * row - height)):
        if scene.occluded(rays.part(row * width, (row + 1) * width)).any():
            return False
    return not scene.occluded(rays).any()


# Plain commands, understood without Typer: to import that takes longer than many a picture.
#
# `conicoid render SCENE -o PICTURE`, with options that are whole numbers, is all of it. Whatever else is written, and
# whatever may be a mistake, is left to the command line proper, with its messages.

_NUMBERS = "--width", "--height", "--samples", "--threads"
_OUTPUT = "-o", "--output"
_DIGITS = 9
FIT_HINT = "; --fit takes a camera that sees all that is bounded"


def parse_plain_render(arguments: Sequence[str]) -> Callable[[], int] | None:
    """What does a command, and returns its exit code; None where the command line has to say what is meant."""
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
    if len(outputs) != 1 or len(scenes) != 1 or not outputs[0] or outputs[0].startswith("-"):
        return None
    return lambda: _render(Path(scenes[0]), Path(outputs[0]), {name[2:]: each for name, each in numbers.items()})


def _render(scene: Path, output: Path, numbers: dict[str, int]) -> int:
    """A picture with the options of `render` that are given."""
    from .._util.environment import check_environment

    with user_mistakes():
        check_environment()
        from .._util.gc_pause import pause_gc
        from ..render.job import check_options
        from .resources import load

        threads = numbers.pop("threads", None)
        wanted = RenderRequest(output, **numbers)  # type: ignore[arg-type]
        wanted.check_output()
        check_options(wanted.samples, wanted.integrator, wanted.seed, wanted.depth)
        with pause_gc():  # one scene is made and drawn, and then the process ends
            draw(load(scene, threads), None, wanted, FIT_HINT)
    return EXIT_OK
