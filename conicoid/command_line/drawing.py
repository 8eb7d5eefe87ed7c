"""A picture from a scene to its file, as `conicoid render` makes it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..film.names import MOST_SAMPLES, Filter, Tone
from ..integrators import INTEGRATORS
from .previews import previews
from .terminal import Bar, compile_notes, say
from .workers import executor_of
from .working import STDOUT, check_folder, check_stdout, in_rays, name_of, prepare, said_warnings, written

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene

_ROWS = 16
"""Of pixels that are looked at before all."""
PROGRESSIVE = tuple(name for name, one in INTEGRATORS.items() if one.progressive)


@dataclass(frozen=True)
class Wanted:
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
        from ..image import SUFFIXES

        if self.output == STDOUT:
            check_stdout("a picture")
        elif self.output.suffix.lower() not in SUFFIXES:
            raise ValueError(f"{self.output}: pictures are saved as {', '.join(SUFFIXES)}")
        check_folder(self.output)

    def developed(self, image: Any) -> Any:
        """A picture as it is displayed."""
        plain = self.exposure == 0 and self.tone == "srgb"
        return image if plain else image.developed(self.exposure, cast(Tone, self.tone))


def draw(scene: Scene, camera: AnyCamera | None, wanted: Wanted, about_none: str) -> None:
    """Make a picture and write it. camera: None for the scene's; about_none: what to say where nothing is seen."""
    width, height = wanted.width, wanted.height
    prepare(scene)
    with (
        compile_notes(),
        said_warnings(),
        Bar("rendering", "ray") as bar,
        executor_of("render", *wanted.executor) as executor,
    ):
        image = wanted.developed(
            scene.section(*wanted.plane, width, height, wanted.samples or MOST_SAMPLES)
            if wanted.plane
            else _view(scene, camera, wanted, bar, executor)
        )
    if wanted.plane is None and _sees_nothing(scene, camera, width, height):
        say(f"note: no body is in view{about_none}")
    with written(wanted.output, ".png") as file:
        image.save(file, bits=wanted.bits)
    if wanted.resume is not None:
        wanted.resume.unlink(missing_ok=True)
    say(f"{name_of(wanted.output)}: {width} x {height} pixels")


def _view(scene: Scene, camera: AnyCamera | None, wanted: Wanted, bar: Bar, executor: Any) -> Any:
    """What the camera sees."""
    w = wanted
    return scene.render(
        w.width, w.height, w.samples, w.integrator, w.seed, depth=w.depth, camera=camera, filter=cast(Filter, w.filter),
        noise=w.noise, shutter=w.shutter, layers=w.layers, axes=w.axes, labels=w.labels, normals=w.normals,
        progress=in_rays(bar, w.width * w.height * (w.samples or MOST_SAMPLES)), executor=executor, resume=w.resume,
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
