"""Render the pictures of the gallery: python examples/gallery.py [folder] [scale] [demo | light] [denoised]

`demo` is eight of them, that of the README first. Those by light transport take minutes each, with `light`; without it
two of them are made small and with few samples. `denoised` takes what noise they have left out of them, by Open Image
Denoise (an extra).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

import angular_shapes
import balls_and_barrel
import boolean_solids
import bored_box
import caffeine
import camera_lens
import cask
import caustic
import chess_focus
import chess_pawn
import clay_assembly
import cylinder_patch
import detector
import die
import engine
import flange
import free_cylinder
import gear_plate
import glass_water_mirror
import globe
import lens_bench
import lenses
import mobile
import nine_quadrics
import phantom
import polygons
import rainbow
import reactor_pin
import rotunda
import salt
import shepp_logan
import sliding_planes
import steinmetz
import studio_light
import telescope

PICTURES = {
    "balls_and_barrel": balls_and_barrel.picture,
    "free_cylinder": free_cylinder.picture,
    "sliding_planes": sliding_planes.picture,
    "nine_quadrics": nine_quadrics.picture,
    "cylinder_patch": cylinder_patch.picture,
    "glass_water_mirror": glass_water_mirror.picture,
    "polygons": polygons.picture,
    "shepp_logan_x_ray": shepp_logan.x_ray,
    "shepp_logan_cut": shepp_logan.picture,
    "angular_shapes": angular_shapes.picture,
    "bored_box": bored_box.picture,
    "lenses": lenses.picture,
    "camera_lens": camera_lens.picture,
    "telescope": telescope.picture,
    "die": die.picture,
    "chess_pawn": chess_pawn.picture,
    "chess_focus": chess_focus.picture,
    "globe": globe.picture,
    "gear_plate": gear_plate.picture,
    "engine": engine.picture,
    "steinmetz": steinmetz.picture,
    "caffeine": caffeine.picture,
    "salt": salt.picture,
    "reactor_pin": reactor_pin.picture,
    "phantom": phantom.picture,
    "cask": cask.picture,
    "flange": flange.picture,
    "boolean_solids": boolean_solids.picture,
    "rainbow": lambda progress, scale: rainbow.picture(progress, scale, samples=4),
    "caustic": lambda progress, scale: caustic.picture(progress, 0.6 * scale, samples=64),
}

LIGHT = {
    "rainbow": rainbow.picture,
    "caustic": caustic.picture,
    "studio_light": studio_light.picture,
    "lens_bench": lens_bench.picture,
    "rotunda": rotunda.picture,
    "mobile": mobile.picture,
    "clay_assembly": clay_assembly.picture,
    "detector": detector.picture,
}
"""Pictures in full quality: all but the first are by light transport."""


DEMO = (
    "glass_water_mirror", "balls_and_barrel", "nine_quadrics", "bored_box", "telescope", "caffeine",
    "shepp_logan_x_ray", "steinmetz",
)  # fmt: skip
"""Quick ones for a first look; the first is that of the README."""


def render_all(pictures: dict[str, Any], folder: Path, scale: float, console: Console, cleans: bool) -> None:
    """One file for each picture; those that are finished stay if the rest is stopped."""
    folder.mkdir(parents=True, exist_ok=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bars:
        for name, picture in pictures.items():
            task = bars.add_task(f"{name} (compiling kernels, if this is the first time)", total=None)

            def show(done: int, count: int, task: TaskID = task, name: str = name) -> None:
                if done:
                    bars.update(task, description=name, completed=done, total=count)

            image = picture(show, scale)
            if cleans:
                image = image.denoised()
            image.save(folder / f"{name}.png")
            bars.update(task, description=str((folder / f"{name}.png").resolve()), completed=1, total=1)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    scale = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
    pictures = LIGHT if "light" in sys.argv[3:] else PICTURES
    if "demo" in sys.argv[3:]:
        pictures = {name: PICTURES[name] for name in DEMO}
    console = Console()
    start = time.perf_counter()
    render_all(pictures, folder, scale, console, "denoised" in sys.argv[3:])
    console.print(f"{len(pictures)} pictures in {folder.resolve()}, after {time.perf_counter() - start:.0f} seconds")


if __name__ == "__main__":
    main()
