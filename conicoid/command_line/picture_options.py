"""The options of commands that make pictures: what each is called, and its line of help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..film.names import FILTERS, LAYERS, TONES
from ..integrators import INTEGRATORS

Pixels = Annotated[int, typer.Option(min=1, help="Pixels.")]
Samples = Annotated[int, typer.Option(min=1, help="Rays for each pixel.")]
_NAMES = " or ".join(INTEGRATORS)
Integrator = Annotated[str, typer.Option(help=f"How light is gathered: {_NAMES}.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same picture, to the bit.")]
Depth = Annotated[int, typer.Option(min=0, max=10_000, help="Reflections and refractions of a ray, at most.")]
Axes = Annotated[bool, typer.Option("--axes", help="Draw the axes of the world, with their scale.")]
Labels = Annotated[bool, typer.Option("--labels", help="Write the names of bodies on them, or their numbers.")]
Normals = Annotated[bool, typer.Option("--normals", help="Draw arrows along the normals of what is seen.")]
Position = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="A camera here, not the scene's.", show_default=False)
]
LookAt = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="With --position: what it looks at.", show_default="the middle")
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
        metavar="FILE", help="Keep finished tiles in a file, and go on from those in it.", show_default=False
    ),
]  # fmt: skip
FilterOption = Annotated[str, typer.Option("--filter", help=f"How samples make a pixel: {', '.join(FILTERS)}.")]
Noise = Annotated[
    float | None,
    typer.Option(help="Go on until brightness is as sure as this, where 1 is white; --samples is a limit.",
                 show_default=False),
]  # fmt: skip
Exposure = Annotated[float, typer.Option(help="Stops; each makes all twice as bright.")]
ToneOption = Annotated[str, typer.Option("--tone", help=f"The curve from light to the display: {', '.join(TONES)}.")]
Layers = Annotated[
    str | None,
    typer.Option(metavar="NAMES", help=f"For an .exr: all, or some of {', '.join(LAYERS)}.", show_default=False),
]
Bits = Annotated[
    int | None, typer.Option(help="16 for a .png so deep, or an .exr of half floats.", show_default="8, or 32")
]
Outside = Annotated[
    bool, typer.Option("--outside", help="Pictures of textures may lie outside of the scene file's folder.")
]
Shutter = Annotated[
    str | None,
    typer.Option(metavar="OPENS,CLOSES", help="Seconds: what the scene's animation moves meanwhile is blurred.",
                 show_default=False),
]  # fmt: skip
Time = Annotated[
    float | None, typer.Option(help="Seconds: the scene as its animation has it then.", show_default=False)
]
Preview = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="A picture that is written again and again as it gets better; - draws it here.",
                 show_default=False),
]  # fmt: skip
Fit = Annotated[bool, typer.Option("--fit", help="The camera that fits, not the scene's.")]
