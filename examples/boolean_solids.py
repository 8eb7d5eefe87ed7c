"""A sheet of Boolean solids: the scenes of the other examples, side by side, with their operands."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import bored_box
import chess_pawn
import conicoid as co
import die
import engine
import gear_plate
import lenses
import reactor_pin
import steinmetz
from studio import Progress

PLATES = [
    ("rounded box, bored", "box & sphere - 3 cylinders", bored_box),
    ("lenses", "sphere & sphere, disc - 2 spheres", lenses),
    ("dice", "(boxes | cylinders | spheres) - 21 spheres", die),
    ("pawn", "cylinders | ellipsoids | hyperboloid | ...", chess_pawn),
    ("gear with 324 bores", "disc | hub - teeth - bores", gear_plate),
    ("engine, cut open", "part - half-space in red", engine),
    ("Steinmetz solids", "2 and 3 cylinders, a & b & c", steinmetz),
    ("fuel assembly", "from OpenMC XML, & half-space", reactor_pin),
]
COLUMNS, GAP = 4, 4
PAPER = 0.79  # of the margin, in linear light, like the studio's backdrop


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """Two rows of four pictures, each with its name and its formula."""
    width, height, margin = round(288 * scale), round(225 * scale), 46
    plates = []
    for k, (_, _, example) in enumerate(PLATES):
        plate = np.full((height + margin, width + GAP, 3), PAPER)
        plate[:height, :width] = example.scene().render(width, height, samples=4, depth=6).pixels
        plates.append(plate)
        if progress is not None:
            progress(k + 1, len(PLATES))
    rows = [np.concatenate(plates[k : k + COLUMNS], axis=1) for k in range(0, len(plates), COLUMNS)]
    return labelled(np.concatenate(rows)[:, :-GAP], width + GAP, height + margin)


def labelled(pixels: np.ndarray, width: int, height: int) -> co.Image:
    """Names and formulas, drawn by Pillow in a mask and laid over the picture."""
    mask = Image.new("L", (pixels.shape[1], pixels.shape[0]))
    pen = ImageDraw.Draw(mask)
    for k, (name, formula, _) in enumerate(PLATES):
        x, y = (k % COLUMNS + 0.5) * width, (k // COLUMNS + 1) * height
        pen.text((x, y - 31), name, 255, ImageFont.load_default(16), anchor="mm")
        pen.text((x, y - 13), formula, 255, ImageFont.load_default(12), anchor="mm")
    share = np.asarray(mask)[..., None] / 255
    return co.Image(pixels * (1 - share) + share * 0.035)


if __name__ == "__main__":
    picture().save("boolean_solids.png")
