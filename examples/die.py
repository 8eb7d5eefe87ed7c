"""Dice: cubes with round edges and corners, and pips that are bites of painted balls."""

from __future__ import annotations

from itertools import product

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

HALF, ROUND = 0.5, 0.13
PIP, DEPTH, STEP = 0.118, 0.062, 0.25  # radius of the balls, how deep they bite, from pip to pip

# The number on a face, as places on a grid of three by three
PLACES = {
    1: [(0, 0)],
    2: [(-1, -1), (1, 1)],
    3: [(-1, -1), (0, 0), (1, 1)],
    4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
    5: [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)],
    6: [(-1, -1), (-1, 0), (-1, 1), (1, -1), (1, 0), (1, 1)],
}
# Axis and degrees that turn the upper face to where its number is: opposite ones add up to seven
TURNS = {
    1: ((1, 0, 0), 0),
    6: ((1, 0, 0), 180),
    2: ((1, 0, 0), 90),
    5: ((1, 0, 0), -90),
    3: ((0, 1, 0), 90),
    4: ((0, 1, 0), -90),
}


def rounded_cube() -> co.Solid:
    """All points within ROUND of a smaller cube: three boxes, twelve cylinders, eight balls, without a seam."""
    inner = HALF - ROUND
    solid: co.Solid = co.Box((-HALF, -inner, -inner), (HALF, inner, inner))
    solid = solid | co.Box((-inner, -HALF, -inner), (inner, HALF, inner))
    solid = solid | co.Box((-inner, -inner, -HALF), (inner, inner, HALF))
    for a, b in product((-inner, inner), repeat=2):
        solid = solid | co.Cylinder((-inner, a, b), (inner, a, b), ROUND)
        solid = solid | co.Cylinder((a, -inner, b), (a, inner, b), ROUND)
        solid = solid | co.Cylinder((a, b, -inner), (a, b, inner), ROUND)
    for corner in product((-inner, inner), repeat=3):
        solid = solid | co.Sphere(ROUND, corner)
    return solid


def die(pips: co.Material, one: co.Material | None = None) -> co.Solid:
    """A die about the origin, 1 on top; the one may have a colour of its own."""
    solid = rounded_cube()
    for number, (axis, degrees) in TURNS.items():
        paint = one if number == 1 and one is not None else pips
        for x, y in PLACES[number]:
            size = 1.5 if number == 1 and one is not None else 1.0
            ball = co.Sphere(size * PIP, (STEP * x, STEP * y, HALF - DEPTH + size * PIP))
            solid = solid - ball.painted(paint).rotate(axis, degrees)
    return solid


def scene() -> co.Scene:
    """Three dice, thrown."""
    black, white, red = co.lacquer("#17181c"), co.lacquer("#f3efe4"), co.lacquer("#b3131b")
    bone = co.lacquer("#e9e1cd")
    throws = [
        (die(black, red).rotate((1, 0, 0), 90).rotate((0, 0, 1), 33).translate((-0.62, -0.1, HALF)), bone),
        (die(white).rotate((0, 1, 0), 90).rotate((0, 0, 1), 70).translate((0.72, 0.35, HALF)), red),
        (die(bone).rotate((0, 1, 0), -90).rotate((0, 0, 1), -22).translate((0.35, -1.15, HALF)), co.lacquer("#1b3a5c")),
    ]
    camera = co.Camera((-0.6, -6.2, 3.9), (0.1, -0.15, 0.36), field_of_view=21.5)
    bodies = [co.Body(shape, finish) for shape, finish in throws]
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("die.png")
