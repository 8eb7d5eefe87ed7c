"""A single-cylinder engine, cut open: what the cutter touches shows the cutter's colour.

The front half of the castings is taken away by one half-space, painted differently for each part; the piston
loses a quarter. Parts that abut share their walls exactly: coolant and liner, liner and piston, pin and rod.
"""

from __future__ import annotations

import math

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

BORE, LINER, JACKET, WALL = 0.8, 0.92, 1.16, 1.38  # radii about the cylinder's axis, x = y = 0
BASE, DECK, TOP = 2.8, 5.55, 6.85  # heights of the block's lower end, its upper end, and of the head's
PIPE = 6.27  # height of the inlet and the outlet
CRANK, THROW, ROD = 1.6, 0.75, 2.6  # height of the crankshaft, half the stroke, length of the rod
TURN = math.radians(52)  # of the crank, from top dead centre

PIN = (THROW * math.sin(TURN), 0.0, CRANK + THROW * math.cos(TURN))
WRIST = PIN[2] + math.sqrt(ROD**2 - PIN[0] ** 2)  # the height of the piston's pin

FRONT = co.HalfSpace((0, 1, 0), 0)
QUARTER = FRONT & co.HalfSpace((-1, 0, 0), 0)

CAST, DARK = co.blinn_phong("#7d8c99", 0.25, 40), co.blinn_phong("#4c545c", 0.3, 60)
STEEL = co.blinn_phong("#c3c9cf", 0.6, 120, reflectivity=0.12)
FORGED = co.blinn_phong("#8fa39a", 0.5, 60)
ALLOY = co.blinn_phong("#d9d6cf", 0.5, 80, reflectivity=0.06)


def upright(low: float, high: float, radius: float) -> co.Solid:
    """A cylinder about the axis of the bore."""
    return co.Cylinder((0, 0, low), (0, 0, high), radius)


def across(x: float, z: float, radius: float, back: float, front: float | None = None) -> co.Solid:
    """A cylinder along y, from `-front` to `back`."""
    return co.Cylinder((x, -(back if front is None else front), z), (x, back, z), radius)


def block() -> co.Solid:
    """The casting around the liner, with its water jacket and two flanges."""
    body = upright(BASE, DECK, WALL)
    for low, high in ((BASE, BASE + 0.22), (DECK - 0.22, DECK)):
        flange = co.Box((-1.6, -1.6, low), (1.6, 1.6, high)) & upright(low, high, 1.95)
        body = body | flange
    return body - upright(BASE, DECK, LINER) - jacket()


def jacket() -> co.Solid:
    """The room between block and liner."""
    return upright(BASE + 0.45, DECK - 0.3, JACKET) - upright(BASE, DECK, LINER)


def head() -> co.Solid:
    """Combustion chamber, two ports with their pipes, bores for valves and spark plug."""
    pipes = co.Cylinder((-1.75, 0, PIPE), (1.75, 0, PIPE), 0.42)
    flanges = co.Cylinder((-1.75, 0, PIPE), (-1.6, 0, PIPE), 0.55) | co.Cylinder((1.6, 0, PIPE), (1.75, 0, PIPE), 0.55)
    solid = upright(DECK, TOP, WALL) | pipes | flanges
    chamber = co.Ellipsoid((BORE, BORE, 0.36), (0, 0, DECK)).painted(co.matte("#6b625a"))
    inlet, outlet = port(-1).painted(co.matte("#3f7fb0")), port(1).painted(co.matte("#8d4a2a"))
    return solid - chamber - inlet - outlet - plug() - valve(-1) - valve(1) - water() - water().scale((-1, 1, 1))


def water() -> co.Solid:
    """Coolant over the left half of the chamber."""
    return co.Ellipsoid((0.2, 0.7, 0.2), (-1.1, 0, DECK + 0.25)) | co.Ellipsoid(
        (0.16, 0.6, 0.13), (-0.3, 0.35, DECK + 1)
    )


def port(side: int) -> co.Solid:
    """From the valve's seat up along its stem, and out to the side."""
    seat, bend = (0.4 * side, 0, DECK + 0.22), (0.56 * side, 0, PIPE)
    return (
        co.Cylinder(seat, bend, 0.23) | co.Sphere(0.23, bend) | co.Cylinder(bend, (1.75 * side, 0, PIPE), 0.23)
    ) - valve(side)


def valve(side: int) -> co.Solid:
    """A closed valve: its stem leans outward."""
    x, z = 0.16 * side, 0.5
    foot = (0.385 * side, 0, DECK + 0.17)

    def along(distance: float) -> tuple[float, float, float]:
        length = math.hypot(x, z)
        return foot[0] + distance * x / length, 0.0, foot[2] + distance * z / length

    plate = co.Cone(along(0), along(0.06), 0.25, 0.25) | co.Cone(along(0.06), along(0.22), 0.25, 0.05)
    return plate | co.Cylinder(along(0.1), along(1.75), 0.055) | co.Cylinder(along(1.6), along(1.7), 0.17)


def plug() -> co.Solid:
    """The spark plug."""
    hexagon = co.Polyhedron(
        [(math.cos(k * math.pi / 3), math.sin(k * math.pi / 3), 0) for k in range(6)] + [(0, 0, 1), (0, 0, -1)],
        [0.2] * 6 + [TOP + 0.22, -TOP],
    )
    return upright(DECK + 0.3, TOP, 0.11) | hexagon


def ceramic() -> co.Solid:
    """The visible part of the plug's insulator."""
    return (
        upright(TOP + 0.22, TOP + 0.75, 0.12)
        | upright(DECK + 0.22, DECK + 0.3, 0.05)
        | upright(TOP + 0.75, TOP + 0.9, 0.06)
    )


def crankcase() -> co.Solid:
    """A barrel about the crankshaft on a foot, with a bearing in the back wall."""
    barrel = across(0, CRANK, 1.5, 1.0) & co.Box((-3, -3, 0), (3, 3, BASE))
    outer = barrel | co.Box((-1.15, -1, 1.4), (1.15, 1, BASE)) | co.Box((-1.8, -1, 0), (1.8, 1, 0.25))
    room = (across(0, CRANK, 1.28, 0.78) | upright(CRANK, BASE, LINER)) & co.Box((-3, -3, 0), (3, 3, BASE))
    return outer - room - across(0, CRANK, 0.3, 2)


def crankshaft() -> co.Solid:
    """Journals, two webs with counterweights, and the pin."""
    solid = across(0, CRANK, 0.3, 1.35, -0.2) | across(0, CRANK, 0.3, -0.2, 0.75) | across(PIN[0], PIN[2], 0.25, 0.42)
    web = across(PIN[0], PIN[2], 0.36, 0.42) | across(0, CRANK, 0.42, 0.42)
    arm = co.Box((-0.36, -0.42, 0), (0.36, 0.42, THROW)).rotate((0, 1, 0), math.degrees(TURN)).translate((0, 0, CRANK))
    opposite = (-PIN[0], 0, 2 * CRANK - PIN[2])
    weight = co.Cylinder((0, -0.42, CRANK), (0, 0.42, CRANK), 1.1, -62, 62, reference=opposite)
    middle = co.Box((-3, -0.22, -3), (3, 0.22, 6))
    return solid | ((web | arm | weight) - middle)


def rod() -> co.Solid:
    """The connecting rod: two eyes and a shank of I section between them."""
    shank = co.Polyhedron(
        [(1, 0, 0.05), (-1, 0, 0.05), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], [0.28, 0.28, 0.12, 0.12, ROD, 0]
    )
    groove = co.Polyhedron(
        [(1, 0, 0.05), (-1, 0, 0.05), (0, 1, 0), (0, 0, 1), (0, 0, -1)], [0.19, 0.19, -0.05, ROD - 0.36, -0.55]
    ).painted(co.blinn_phong("#b3131b", 0.3))
    eyes = across(0, 0, 0.42, 0.18) | across(0, ROD, 0.29, 0.18)
    whole = (shank | eyes) - groove - groove.scale((1, -1, 1)) - across(0, 0, 0.25, 1) - across(0, ROD, 0.17, 1)
    lean = -math.degrees(math.asin(PIN[0] / ROD))
    return whole.rotate((0, 1, 0), lean).translate(PIN)


def piston() -> co.Solid:
    """Crown, skirt with grooves for three rings, bosses for the pin."""
    low, crown = WRIST - 0.5, WRIST + 0.55
    boss = across(0, WRIST, 0.3, BORE) - across(0, WRIST, 1, 0.26)
    hollow = upright(low - 1, crown - 0.2, 0.66) - boss
    solid = upright(low, crown, BORE) - hollow - across(0, WRIST, 0.17, 1)
    for z in grooves():
        solid = solid - (upright(z, z + 0.07, BORE) - upright(z, z + 0.07, 0.72))
    return solid


def grooves() -> list[float]:
    return [WRIST + 0.42 - 0.14 * k for k in range(3)]


def scene() -> co.Scene:
    """All parts, each cut open in a colour of its own."""
    rings = [upright(z, z + 0.07, BORE) - upright(z, z + 0.07, 0.72) for z in grooves()]
    red, amber, blue, grey = (co.matte(color) for color in ("#b3372e", "#e0a526", "#4f93c4", "#5b636b"))
    coolant = co.blinn_phong("#4f93c4", 0.5)
    heads = water() | water().scale((-1, 1, 1))
    parts = [
        (crankcase() - FRONT.painted(red), CAST),
        (block() - FRONT.painted(red), CAST),
        (head() - FRONT.painted(co.matte("#c96a2b")), CAST),
        (
            upright(BASE - 0.35, DECK, LINER) - upright(0, DECK, BORE) - FRONT.painted(amber),
            co.blinn_phong("#b9bfc4", 0.3, 40),
        ),
        ((jacket() | heads) - FRONT.painted(blue), coolant),
        (piston() - QUARTER.painted(co.matte("#e8cf8a")), ALLOY),
        *((ring - QUARTER.painted(grey), DARK) for ring in rings),
        (across(0, WRIST, 0.17, 0.72) - across(0, WRIST, 0.09, 0.72), STEEL),
        (rod(), STEEL),
        (crankshaft(), FORGED),
        (valve(-1) | valve(1) | plug(), STEEL),
        (ceramic(), co.lacquer("#f3efe4")),
    ]
    camera = co.Camera((5.4, -16, 8.4), (0.15, 0, 3.85), field_of_view=26.5)
    bodies = [co.Body(shape, finish) for shape, finish in parts]
    return co.Scene([*bodies, *backdrop(wall=12)], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(500 * scale), round(620 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("engine.png")
