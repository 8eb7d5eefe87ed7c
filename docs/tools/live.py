"""The gallery's scenes as pages to walk around in, and their programs: python -m docs.tools.live [folder]"""

from __future__ import annotations

import importlib
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
EXAMPLES = ROOT / "examples"
SCENES = {
    "glass_water_mirror": "Glass, mirror and water",
    "balls_and_barrel": "Balls and a barrel",
    "free_cylinder": "Cylinders",
    "sliding_planes": "Bow tie to truncated cone",
    "cylinder_patch": "A cylinder patch",
    "polygons": "Polygons and triangles",
    "bored_box": "A rounded box with three bores",
    "lenses": "Two lenses",
    "die": "Dice",
    "chess_pawn": "Chess pawns",
    "gear_plate": "A gear with 324 bores",
    "engine": "An engine, cut open",
    "steinmetz": "Steinmetz solids",
    "caffeine": "Caffeine",
    "salt": "Rock salt, benzene and water",
    "reactor_pin": "A fuel assembly",
}
"""Example programs with one scene, which the gallery shows alive, and their titles."""


def write(folder: Path) -> list[Path]:
    """Everything that the site has beside its pages: live/*.html and examples/*."""
    from conicoid.viewer.html import export

    shutil.rmtree(folder, ignore_errors=True)
    (folder / "live").mkdir(parents=True)
    sys.path.insert(0, str(EXAMPLES))
    made = []
    for name, title in SCENES.items():
        made.append(folder / "live" / f"{name}.html")
        export(importlib.import_module(name).scene(), made[-1], title)
    (folder / "examples").mkdir()
    for program in sorted([*EXAMPLES.glob("*.py"), *EXAMPLES.glob("*.ipynb")]):
        made.append(Path(shutil.copy(program, folder / "examples")))
    return made


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "extra"
    print(f"{len(write(target))} files in {target}")
