"""Options and arguments that commands share, and rules on options that go together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from ..render.integrators import INTEGRATORS
from ..render.options import FILTERS, LAYERS, TONES
from .terminal import user_mistakes


class Commands(TyperGroup):
    """The group of commands. Its messages on arguments are never longer than a screen."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Resolve a command; `help` shows help."""
        if args and args[0] == "help":
            return super().resolve_command(ctx, [*args[1:2], "--help"]) if args[1:] else self._show_help(ctx)
        return super().resolve_command(ctx, args)

    def _show_help(self, ctx: Any) -> Any:
        """Print the help and exit."""
        typer.echo(ctx.get_help())
        ctx.exit()

    def invoke(self, ctx: Any) -> Any:
        """Run a command; shorten a message that is too long."""
        try:
            return super().invoke(ctx)
        except Exception as error:
            message = getattr(error, "message", None)
            if isinstance(message, str) and len(message) > _LONGEST:
                error.message = f"{message[: _LONGEST // 2]} ... {message[-_LONGEST // 2 :]}"  # type: ignore[attr-defined]
            raise


_LONGEST = 600
"""The largest number of characters of a message on arguments."""


class Command(TyperCommand):
    """A command that takes each option once: of two values, the first would be lost without a message."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command; mistakes of users become messages and exit codes."""
        with user_mistakes():
            return super().invoke(ctx)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments; refuse repeated options."""
        # A first pass finds options that are given twice: the result of the second has the last value alone
        _, _, parsed = self.make_parser(ctx).parse_args(args=list(args))
        for option in parsed:
            if option.param_type_name == "option" and not option.multiple and parsed.count(option) > 1:
                name = max(option.opts, key=len)
                ctx.fail(f"{name} is given {_times(parsed.count(option))}: only the last would count")
        return super().parse_args(ctx, list(args))  # a copy: parsing empties the list


def _times(count: int) -> str:
    """Return a number of times in words."""
    return "twice" if count == 2 else f"{count} times"


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, YAML or JSON.", show_default=False)]
GlassesOption = Annotated[
    Path | None, typer.Option("--glasses", help="A catalogue of glasses (.agf) for a lens file.", show_default=False)
]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads to use.", show_default="all cores")]
DeviceOption = Annotated[
    str | None, typer.Option("--device", help="Where rays are traced: cpu or cuda.", show_default="cpu")
]
RayFile = Annotated[
    Path,
    typer.Argument(metavar="RAYS", help="Rays: .npy, .npz, .csv, .parquet or .zarr.", show_default=False),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", min=1, help="Processes for the work, not threads.", show_default=False),
]
ClusterOption = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="Dask scheduler for the work, such as tcp://host:8786.", show_default=False
    ),
]  # fmt: skip
SlurmOption = Annotated[
    int | None,
    typer.Option(
        "--slurm", metavar="JOBS", min=1, show_default=False,
        help="Slurm jobs for the work, as dask-jobqueue starts them: docs/cluster.md.",
    ),
]  # fmt: skip
TMin = Annotated[float | None, typer.Option("--t-min", help="Where rays begin, in units of the direction's length.",
                                            show_default="0")]  # fmt: skip
TMax = Annotated[float | None, typer.Option("--t-max", help="Where rays end.", show_default="inf")]
Results = Annotated[
    Path,
    typer.Option("--output", "-o", help="The results, .npz or .csv; - is .csv on standard output.", show_default=False),
]


def is_given(context: typer.Context, name: str) -> bool:
    """Return whether an option is on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def only_with(context: typer.Context, other: str, is_set: bool, *names: str) -> None:
    """Raise ValueError for options that would be ignored, because they go with `other` alone."""
    for name in names:
        # An equal default is no mistake, so the source of the value decides
        if not is_set and is_given(context, name):
            option = "--" + name.replace("_", "-")
            raise ValueError(f"{context.info_name}: {option} goes with {other}; it would be ignored")


# --- Options of commands that make pictures

Pixels = Annotated[int, typer.Option(min=1, help="Pixels.")]
Samples = Annotated[int, typer.Option(min=1, help="Rays for each pixel.")]
_NAMES = " or ".join(INTEGRATORS)
Integrator = Annotated[str, typer.Option(help=f"How light is gathered: {_NAMES}.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same picture, to the bit.")]
Depth = Annotated[int, typer.Option(min=0, max=10_000, help="Reflections and refractions of a ray, at most.")]
Axes = Annotated[bool, typer.Option("--axes", help="Draw the axes of the world, with their scale.")]
Labels = Annotated[bool, typer.Option("--labels", help="Write the names of bodies on them, or their numbers.")]
Normals = Annotated[bool, typer.Option("--normals", help="Draw arrows along the normals of visible surfaces.")]
Position = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="A camera here, not that of the scene.", show_default=False)
]
LookAt = Annotated[
    str | None,
    typer.Option(metavar="X,Y,Z", help="With --position: the point in the middle.", show_default="the middle"),
]
Up = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="With --position.", show_default="0,0,1")]
FieldOfView = Annotated[float | None, typer.Option(help="With --position: degrees, vertical.", show_default="40")]
Orthographic = Annotated[
    float | None,
    typer.Option("--orthographic", metavar="HEIGHT", help="With --position: parallel rays, of a window so high.",
                 show_default=False),
]  # fmt: skip
Section = Annotated[
    str | None,
    typer.Option(
        "--section", "--slice", metavar="AXIS=VALUE", help="A section, or slice, such as z=0.", show_default=False
    ),
]  # fmt: skip
Resume = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Keep finished tiles in a file, and continue from those in it.", show_default=False
    ),
]  # fmt: skip
FilterOption = Annotated[str, typer.Option("--filter", help=f"How samples make a pixel: {', '.join(FILTERS)}.")]
Noise = Annotated[
    float | None,
    typer.Option(help="Add samples until brightness is as sure as this, where 1 is white; --samples is a limit.",
                 show_default=False),
]  # fmt: skip
Exposure = Annotated[float, typer.Option(help="Stops; each makes the picture twice as bright.")]
ToneOption = Annotated[str, typer.Option("--tone", help=f"The curve from light to the display: {', '.join(TONES)}.")]
Layers = Annotated[
    str | None,
    typer.Option(metavar="NAMES", help=f"For an .exr: all, or some of {', '.join(LAYERS)}.", show_default=False),
]
Bits = Annotated[
    int | None, typer.Option(help="16 for a .png of 16 bits, or an .exr of half floats.", show_default="8, or 32")
]
Outside = Annotated[
    bool, typer.Option("--outside", help="Pictures of textures may lie outside of the scene file's folder.")
]
Shutter = Annotated[
    str | None,
    typer.Option(metavar="OPENS,CLOSES", help="Seconds: the motion of the animation meanwhile is blurred.",
                 show_default=False),
]  # fmt: skip
Time = Annotated[
    float | None, typer.Option(help="Seconds: the scene at this time of its animation.", show_default=False)
]
Preview = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="A picture that is written again and again as it improves; - draws it here.",
                 show_default=False),
]  # fmt: skip
Fit = Annotated[bool, typer.Option("--fit", help="The camera that fits, not that of the scene.")]
