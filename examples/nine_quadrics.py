"""The nine canonical quadrics on one sheet (ray tracing notes), with sections by x = 0, y = 0 and z = h painted on."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

ROOM_AROUND, ROOM_BESIDE = co.Box((-1, -1, -1), (1, 1, 1)), co.Box((-1, -0.1, -1), (1, 1.9, 1))
HERE, LOWER, NEARER = (0, 0, 0), (0, 0, -1), (0, -0.9, 0)

# name, equation, solid, where to put it, colour
PLATES = [
    ("ellipsoid", "Ax² + Ey² + Hz² = 1", co.Ellipsoid.from_coefficients(0.5, 1.2, 1.0), HERE, "#a62b2b"),
    ("elliptic paraboloid", "Ax² + Ey² - z = 0", co.EllipticParaboloid(1.5, 2.2, (0, 2)), LOWER, "#c2622d"),
    ("hyperbolic paraboloid", "Ax² - Ey² - z = 0", ROOM_AROUND - co.HyperbolicParaboloid(0.8, 0.8), HERE, "#d29a35"),
    ("hyperboloid of one sheet", "Ax² + Ey² - Hz² = 1", co.OneSheetHyperboloid(3.5, 5, 2.6, (-1, 1)), HERE, "#6b8f3e"),
    ("hyperboloid of two sheets", "Ax² + Ey² - Hz² = -1", co.TwoSheetHyperboloid(9, 13, 14, (-1, 1)), HERE, "#2f7d5b"),
    ("elliptic cone", "Ax² + Ey² - Hz² = 0", co.EllipticCone(1, 1.5, 1, (-1, 1)), HERE, "#2a7f8c"),
    ("elliptic cylinder", "Ax² + Ey² = 1", co.EllipticCylinder(0.9, 1.7, (-1, 1)), HERE, "#2b5f93"),
    ("hyperbolic cylinder", "Ax² - Ey² = 1", co.HyperbolicCylinder(6, 3, ROOM_AROUND), HERE, "#59468f"),
    ("parabolic cylinder", "x² - 2Gy = 0", co.ParabolicCylinder(0.3, ROOM_BESIDE), NEARER, "#8d3c78"),
]
LINE = 0.012
PAPER = "#e9e6e1"


def sections(solid: co.Solid) -> list[co.Body]:
    """Thin slices of the solid about planes: listed first, they paint its surface."""
    planes = [((1, 0, 0), 0.0), ((0, 0, 1), -0.5), ((0, 0, 1), 0.5), ((0, 0, 1), 1.5)]
    if not isinstance(solid, co.ParabolicCylinder):  # y = 0 only touches it
        planes.append(((0, 1, 0), 0.0))
    slices = []
    for normal, height in planes:
        back = tuple(-n for n in normal)
        slices.append(solid & co.Polyhedron([normal, back], [height + LINE, LINE - height]))
    return [co.Body(part, co.matte("#f6f1e4")) for part in slices]


def scene(solid: co.Solid, place: tuple[float, float, float], color: str) -> co.Scene:
    """One quadric on the studio's floor."""
    bodies = [*sections(solid), co.Body(solid, co.lacquer(color))]
    raised = [co.Body(body.shape.translate(place).translate((0, 0, 1.02)), body.material) for body in bodies]
    camera = co.Camera((3.4, -8.4, 4.1), (0.05, 0, 0.7), field_of_view=21.5)
    return co.Scene([*raised, *backdrop(PAPER, wall=14)], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """Nine pictures, three by three, each with its name and equation."""
    width, height = round(320 * scale), round(290 * scale)
    plates = []
    for k, (_, _, solid, place, color) in enumerate(PLATES):
        plates.append(scene(solid, place, color).render(width, height, samples=9).pixels)
        if progress is not None:
            progress(k + 1, len(PLATES))
    return labelled(np.concatenate([np.concatenate(plates[k : k + 3], axis=1) for k in (0, 3, 6)]), width, height)


def labelled(pixels: np.ndarray, width: int, height: int) -> co.Image:
    """Names and equations, drawn by Pillow in a mask and laid over the picture."""
    mask = Image.new("L", (3 * width, 3 * height))
    pen = ImageDraw.Draw(mask)
    for k, (name, equation, *_) in enumerate(PLATES):
        x, y = (k % 3 + 0.5) * width, (k // 3 + 1) * height
        pen.text((x, y - 36), name, 255, ImageFont.load_default(16), anchor="mm")
        write(pen, x, y - 17, equation)
    share = np.asarray(mask)[..., None] / 255
    return co.Image(pixels * (1 - share) + share * 0.035)


def write(pen: ImageDraw.ImageDraw, middle: float, y: float, equation: str) -> None:
    """An equation with raised twos, for the font has none of its own."""
    base, raised = ImageFont.load_default(14), ImageFont.load_default(10)
    parts = [(text, base) for text in equation.split("²")]
    parts = [part for pair in zip(parts, [("2", raised)] * len(parts), strict=True) for part in pair][:-1]
    x = middle - sum(font.getlength(text) for text, font in parts) / 2
    for text, font in parts:
        pen.text((x, y - (5 if font is raised else 0)), text, 255, font, anchor="lm")
        x += font.getlength(text)


if __name__ == "__main__":
    picture().save("nine_quadrics.png")
