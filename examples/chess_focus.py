"""Pawns in a row, seen through a wide open lens: one of them is sharp."""

from __future__ import annotations

import conicoid as co
from chess_pawn import THICK, pawn
from studio import ROOM, Progress, backdrop, lights

SIDE = 1.15


def scene() -> co.Scene:
    """A diagonal of ivory pawns, a black one in focus, on a board of wood."""
    ivory, ebony = co.lacquer("#e8d9b5", reflectivity=0.05), co.lacquer("#26201d", reflectivity=0.05)
    board = co.lacquer(co.Checker("#c9a06a", "#5a3a26", scale=SIDE, space=True), specular=0.3, reflectivity=0.05)
    shape = pawn()
    places = [((k + 0.5) * SIDE, (2 * k + 0.5) * SIDE) for k in range(-3, 4)]
    bodies = [
        co.Body(shape.translate((x, y, THICK)), ebony if k == 2 else ivory) for k, (x, y) in enumerate(places)
    ]  # fmt: skip
    top = co.Body(co.Box((-5 * SIDE, -7 * SIDE, 0), (5 * SIDE, 9 * SIDE, THICK)), board)
    x, y = places[2]
    focus = (x, y, THICK + 1.0)
    camera = co.Camera((x - 1.2, y - 7.5, 2.6), focus, field_of_view=26, aperture=0.45, blades=7)
    return co.Scene([*bodies, top, *backdrop(wall=18)], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    image = scene().render(round(600 * scale), round(440 * scale), samples=64, filter="mitchell", progress=progress)
    return image.developed(exposure=0.8, tone="filmic")


if __name__ == "__main__":
    picture().save("chess_focus.png")
