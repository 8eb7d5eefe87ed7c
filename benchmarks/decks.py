"""Files as other programs write them, made by script: CAD cells, cut lattices, polycones. And bodies under motions.

python benchmarks/decks.py             # seconds to read and prepare each file, µs a ray
python benchmarks/decks.py --bodies    # µs a body: 200 alike and 200 all different, by the worst of four motions
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import textwrap
import time
from pathlib import Path
from typing import Any

import numpy as np

RAYS, BODIES, RUNS = 20_000, 200, 3


class Surfaces:
    """The planes and cylinders of a deck, each once."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def number(self, card: str) -> int:
        return self.numbers.setdefault(card, len(self.numbers) + 1)

    def below(self, normal: Any, offset: float) -> int:
        """The side normal·x <= offset, as a cell names it."""
        along = np.flatnonzero(np.abs(normal) > 1e-9)
        sign = 1 if normal[along[0]] > 0 else -1
        if len(along) == 1:
            return -sign * self.number(f"p{'xyz'[along[0]]} {offset / normal[along[0]]:.7f}")
        numbers = " ".join(f"{sign * x:.7f}" for x in (*normal, offset))
        return -sign * self.number(f"p {numbers}")

    def block(self, axes: Any, center: Any, low: Any, high: Any) -> list[int]:
        """The sides of a block along these axes, between two corners from its center."""
        pairs = zip(axes, low, high, strict=True)
        return [side for axis, a, b in pairs for side in (
            self.below(axis, axis @ center + b), self.below(-axis, -(axis @ center + a))
        )]  # fmt: skip


def part_of(surfaces: Surfaces, center: Any, rng: Any) -> list[list[int]]:
    """The convex pieces of a part: a curved wall of sectors, a plate with ribs, or a block of many facets."""
    axes = np.eye(3) if rng.random() < 0.3 else np.linalg.qr(rng.normal(size=(3, 3)))[0]
    kind = rng.integers(3)
    if kind == 0:
        angles = np.linspace(0, 4.4, int(rng.integers(7, 17)))
        pieces = []
        for a, b in itertools.pairwise(angles.tolist()):
            out, first, last = (
                np.cos(t) * axes[1] + np.sin(t) * axes[2] for t in ((a + b) / 2, a + 1.5708, b + 1.5708)
            )
            pieces.append([
                *surfaces.block((axes[0], out), center, (-3, 5.2), (3, 6)),
                surfaces.below(-first, -first @ center), surfaces.below(last, last @ center),
            ])  # fmt: skip
        return pieces
    if kind == 1:
        ribs = np.linspace(-6, 5, int(rng.integers(3, 12)))
        plate = surfaces.block(axes, center, (-6, -6, -1), (6, 6, 1))
        return [plate, *(surfaces.block(axes, center, (x, -6, 1), (x + 0.5, 6, 4)) for x in ribs.tolist())]
    normals = rng.normal(size=(int(rng.integers(8, 40)), 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    facets = [surfaces.below(n, n @ center + rng.uniform(4.5, 6)) for n in normals]
    return [facets + surfaces.block(axes, center, (-6, -6, -6), (6, 6, 6))]


def cad_deck(parts: int = 150, grid: int = 4, seed: int = 1) -> str:
    """An MCNP deck of parts, some bored, and of void in boxes of a grid, as converters from CAD write it."""
    rng, surfaces, count = np.random.default_rng(seed), Surfaces(), round(parts ** (1 / 3)) + 1
    solids = []
    for place in range(parts):
        spot = np.array(np.unravel_index(place, (count,) * 3))
        center = (spot - (count - 1) / 2) * 20 + rng.uniform(-1, 1, 3)
        pieces, bores = part_of(surfaces, center, rng), []
        if rng.random() < 0.4:
            bores = [surfaces.number(f"c/z {center[0]:.7f} {center[1]:.7f} 0.7")]
        solids.append((center, pieces, bores))
    cells = [
        " : ".join(f"({' '.join(map(str, piece))})" for piece in pieces).join(("(", ")"))
        + "".join(f" {b}" for b in bores)
        for _, pieces, bores in solids
    ]
    half, edges = count * 10.0 + 2, np.linspace(-count * 10.0 - 2, count * 10.0 + 2, grid + 1)
    for box in np.ndindex(grid, grid, grid):
        low, high = edges[list(box)], edges[[k + 1 for k in box]]
        words = list(map(str, surfaces.block(np.eye(3), np.zeros(3), low, high)))
        for center, pieces, bores in solids:
            if (center + 7.5 > low).all() and (center - 7.5 < high).all():
                words += [f"({' : '.join(str(-side) for side in (*piece, *bores))})" for piece in pieces]
        cells.append(" ".join(words))
    beyond = " : ".join(str(-side) for side in surfaces.block(np.eye(3), np.zeros(3), (-half,) * 3, (half,) * 3))
    cards = [f"{k} {'1 -2.0' if k <= parts else '0'} {cell} imp:n=1" for k, cell in enumerate(cells, start=1)]
    cards.append(f"{len(cells) + 1} 0 {beyond} imp:n=0")
    planes = [f"{number} {card}" for card, number in surfaces.numbers.items()]
    lines = ["cells from CAD", *cards, "", *planes, "", "m1 26056 1.0", ""]
    return "\n".join("\n".join(textwrap.wrap(line, 76, subsequent_indent=" " * 6)) for line in lines)


def cut_lattice(balls: int = 776, size: int = 6, seed: int = 3) -> str:
    """A lattice of OpenMC with coated particles, each in all elements that it reaches, in a cell of slanted planes."""
    rng = np.random.default_rng(seed)
    radii, spots = np.array([0.5, 0.74, 0.82, 0.91, 1.0]) * 0.2125, np.zeros((0, 3))
    while len(spots) < balls:
        spot = rng.uniform(-2.78, 2.78, 3)
        if (np.linalg.norm(spots - spot, axis=1) > 2 * radii[-1]).all():
            spots = np.vstack([spots, spot])
    text = [f'<surface id="{k}" type="sphere" coeffs="0 0 0 {r}"/>' for k, r in enumerate(radii.tolist(), start=1)]
    for k in range(1, 6):
        text.append(f'<cell id="{k}" universe="1" material="{k}" region="{k - 1 if k > 1 else ""} -{k}"/>')
    number, universes = 10, []
    for index in np.ndindex(size, size, size):
        z, y, x = index
        center = (np.array([x, size - 1 - y, z]) + 0.5) * 6 / size - 3
        aside = spots - center
        inside = aside[np.linalg.norm(np.maximum(np.abs(aside) - 3 / size, 0), axis=1) < radii[-1]]
        universes.append(1000 + len(universes))
        for spot in inside.tolist():
            place = " ".join(f"{x:.9f}" for x in spot)
            text.append(f'<surface id="{number}" type="sphere" coeffs="{place} {radii[-1]}"/>')
            cell = f'universe="{universes[-1]}" fill="1" translation="{place}" region="-{number}"'
            text.append(f'<cell id="{number}" {cell}/>')
            number += 1
        rest = " ".join(map(str, range(number - len(inside), number)))
        text.append(
            f'<cell id="{number + 100_000}" universe="{universes[-1]}" material="9" region="{rest}"/>'.replace(
                ' region=""', ""
            )
        )
        number += 1
    planes = []
    for angle in 0.2 + np.arange(6) * np.pi / 3:
        planes.append(number)
        normal = f"{np.cos(angle):.6f} {np.sin(angle):.6f} {0.15 * (-1) ** len(planes)} 2.9"
        text.append(f'<surface id="{number}" type="plane" coeffs="{normal}" boundary="vacuum"/>')
        number += 1
    for z in (-3, 3):
        text.append(f'<surface id="{200_000 + z}" type="z-plane" coeffs="{z}" boundary="vacuum"/>')
    sides = " ".join(f"-{plane}" for plane in planes) + " 199997 -200003"
    named = " ".join(map(str, universes))
    grid = f'dimension="{size} {size} {size}" pitch="{6 / size} {6 / size} {6 / size}" lower_left="-3 -3 -3"'
    text.append(f'<lattice id="90000" {grid} universes="{named}"/><cell id="90001" fill="90000" region="{sides}"/>')
    return "<geometry>" + "\n".join(text) + "</geometry>"


def hexagons(rings: int = 12) -> str:
    """A hexagonal lattice of OpenMC: a pin and water in each element."""
    named = "1 " * (1 + 3 * rings * (rings - 1))
    return f"""<geometry>
<surface id="1" type="z-cylinder" coeffs="0 0 0.45"/> <surface id="2" type="z-plane" coeffs="-50"/>
<surface id="3" type="z-plane" coeffs="50"/> <surface id="4" type="z-cylinder" coeffs="0 0 40" boundary="vacuum"/>
<cell id="1" universe="1" material="1" region="-1"/> <cell id="2" universe="1" material="2" region="1"/>
<cell id="3" universe="2" material="2"/> <cell id="20" fill="4" region="-4 2 -3"/>
<hex_lattice id="4" n_rings="{rings}" center="0 0" pitch="1.26" outer="2" universes="{named}"/></geometry>"""


def polycones(count: int = 400, seed: int = 1) -> str:
    """A GDML file of polycones, all different and turned: some hollow, some sectors."""
    rng = np.random.default_rng(seed)
    solids, volumes, places = ['<box name="W" x="200" y="200" z="200"/>'], [], []
    for k in range(count):
        size = int(rng.integers(3, 7))
        hollow, heights = rng.uniform(0, 1, size) * (rng.random() < 0.7), np.cumsum(rng.uniform(0.5, 1.5, size))
        rows = zip(hollow, hollow + rng.uniform(0.5, 2, size), heights, strict=True)
        planes = "".join(f'<zplane rmin="{a:.6f}" rmax="{b:.6f}" z="{z:.6f}"/>' for a, b, z in rows)
        start, turn = (0, 360) if rng.random() < 0.5 else (rng.uniform(0, 360), rng.uniform(30, 330))
        angles = f'startphi="{start:.5f}" deltaphi="{turn:.5f}" aunit="deg"'
        solids.append(f'<polycone name="P{k}" {angles}>{planes}</polycone>')
        volumes.append(f'<volume name="L{k}"><materialref ref="M"/><solidref ref="P{k}"/></volume>')
        spot = np.array([k % 8, k // 8 % 8, k // 64]) * 20.0 - 80 + rng.uniform(-2, 2, 3)
        at, by = (
            " ".join(f'{axis}="{x:.5f}"' for axis, x in zip("xyz", row, strict=True))
            for row in (spot, rng.uniform(-180, 180, 3))
        )
        placed = f'<position name="p{k}" {at}/><rotation name="r{k}" unit="deg" {by}/>'
        places.append(f'<physvol name="V{k}"><volumeref ref="L{k}"/>{placed}</physvol>')
    material = '<material name="M" Z="26"><D value="7.8"/><atom value="55.8"/></material>'
    world = f'<volume name="World"><materialref ref="M"/><solidref ref="W"/>{"".join(places)}</volume>'
    return f"""<gdml><define/><materials>{material}</materials><solids>{"".join(solids)}</solids>
<structure>{"".join(volumes)}{world}</structure><setup name="D" version="1"><world ref="World"/></setup></gdml>"""


FILES = {"polycones.gdml": polycones, "cad.mcnp": cad_deck, "cut_lattice.xml": cut_lattice, "hexagons.xml": hexagons}


def files(folder: Path) -> None:
    import conicoid as co

    co.Scene([co.Sphere()]).prepare()
    print("| a file | bodies | read, s | prepare, s | µs a ray |\n|---|---|---|---|---|")
    for name, make in FILES.items():
        (folder / name).write_text(make())
        begin = time.process_time()
        scene = co.load(folder / name)
        read = time.process_time()
        scene.prepare()
        ready = time.process_time()
        rng = np.random.default_rng(0)
        origins, directions = rng.uniform(-2, 2, (RAYS, 3)), rng.normal(size=(RAYS, 3))
        scene.first_hit(origins, directions)
        again = time.process_time()
        scene.first_hit(origins, directions)
        ray = 1e6 * (time.process_time() - again) / RAYS
        print(f"| {name} | {len(scene.bodies):,} | {read - begin:.2f} | {ready - read:.2f} | {ray:.1f} |", flush=True)


def bodies() -> dict[str, Any]:
    """Shapes of each kind, from a generator of random numbers."""
    import conicoid as co

    def sides(normals: Any, rng: Any) -> list[Any]:
        return [co.HalfSpace(tuple(n), float(rng.uniform(0.5, 1.5))) for n in np.asarray(normals, float).tolist()]

    def prism(rng: Any) -> Any:
        angles = rng.uniform() + np.arange(6) * np.pi / 3
        around = np.stack([np.cos(angles), np.sin(angles), 0.1 * rng.normal(size=6)], axis=1)
        return co.Intersection(tuple(sides([*around, (0.1, 0, 1), (0, 0.1, -1)], rng)))

    def polyhedron(rng: Any) -> Any:
        planes = sides([*np.eye(3), *-np.eye(3), *rng.normal(size=(4, 3))], rng)
        return co.Polyhedron([plane.normal for plane in planes], [plane.offset for plane in planes])

    def tetrahedron(rng: Any) -> Any:
        corners = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)])
        return co.Intersection(tuple(sides(corners + 0.2 * rng.normal(size=(4, 3)), rng)))

    def vessel(rng: Any) -> Any:
        tube = co.Cylinder((0, 0, -9), (0, 0, 9), 0.5) - co.Cylinder(
            (0, 0, -9), (0, 0, 9), float(rng.uniform(0.3, 0.4))
        )
        return tube & co.Sphere(8, (float(rng.uniform(5, 6)), 0, 0))

    def size(rng: Any) -> float:
        return float(rng.uniform(0.1, 1.0))

    def box(rng: Any) -> Any:
        return co.Box((-size(rng), -size(rng), -size(rng)), (size(rng), size(rng), size(rng)))

    def rod(x: float, y: float, radius: float, height: float) -> Any:
        return co.Cylinder((x, y, -height), (x, y, height), radius)

    def plate(rng: Any) -> Any:
        radius, at = 0.3 * size(rng), (-0.5, 0.5)
        return box(rng) | co.Box() - co.Union(tuple(rod(x, y, radius, 1) for x in at for y in at))

    def gear(rng: Any) -> Any:
        width = 0.1 + 0.05 * size(rng)
        teeth = [co.Box((0.8, -width, -0.2), (1.3, width, 0.2)).rotate("z", 30 * k) for k in range(12)]
        return co.Union((rod(0, 0, 1, 0.2), *teeth)) - rod(0, 0, width, 0.2)

    return {
        "plate with flush holes": plate,
        "gear of 12 teeth": gear,
        "half of a ball": lambda r: co.Sphere(size(r)) & co.HalfSpace((0, 0, 1), 0),
        "die": lambda r: (co.Box() & co.Sphere(1.4)) - co.Sphere(0.2 * size(r), (0, 0, 1)),
        "dish": lambda r: co.EllipticParaboloid(size(r), size(r)) & co.HalfSpace((0, 0, 1), size(r)),
        "flat lens": lambda r: co.Lens(7 + size(r), float("inf"), thickness=1 + size(r) / 9, diameter=2.0),
        "cup": lambda r: co.Cone((0, 0, 0), (0, 0, 2), size(r), 0) - co.Cone((0, 0, -0.2), (0, 0, 1.8), size(r), 0),
        "tile": lambda r: co.Polygon([(0, 0, 1), (size(r), 0, 1), (1, 1, 1), (0, 1 + size(r), 1)]),
        "tetrahedron of half-spaces": tetrahedron,
        "slanted prism of half-spaces": prism,
        "slanted prism - ball": lambda r: prism(r) - co.Sphere(float(r.uniform(0.2, 0.4))),
        "ball cut by two planes": lambda r: co.Intersection((co.Sphere(2), *sides(r.normal(size=(2, 3)), r))),
        "tube cut by a vessel": vessel,
        "hexagonal prism": lambda r: co.RegularPrism(6, size(r), start_angle=size(r)),
        "wedge": lambda r: co.Wedge(size(r), size(r), size(r)),
        "cut ellipsoid": lambda r: co.Ellipsoid((size(r), size(r), size(r)), z_range=(-0.05, size(r))),
        "elliptic cone": lambda r: co.EllipticCone(size(r), size(r), size(r), (-size(r), size(r))),
        "saddle in a box": lambda r: co.HyperbolicParaboloid(size(r), size(r), box(r)),
        "sector of a polycone": lambda r: co.Polycone(
            [(-1, 0.1, 1 + size(r)), (0, 0.3, 1 + size(r)), (1, 0, size(r))], 10, 20 + 300 * size(r)
        ),
        "general quadric": lambda r: co.Quadric(
            coefficients={"xx": size(r), "yy": size(r), "zz": size(r), "xy": 0.1 * size(r), "constant": -1.0}
        ),
        "lens": lambda r: co.Lens(7 + size(r), -7 - size(r), thickness=1 + size(r) / 9, diameter=2.0),
        "extrusion": lambda r: co.Extrusion([(0, 0), (1 + size(r), 0), (1, 1), (0, size(r))]),
        "polyhedron": polyhedron,
        "polyhedron - ball": lambda r: polyhedron(r) - co.Sphere(float(r.uniform(0.2, 0.4))),
    }


def placed(shape: Any, how: str, rng: Any) -> Any:
    to = tuple(rng.uniform(-5, 5, 3).tolist())
    if how == "rolled":
        shape = shape.rotate("z", float(rng.uniform(-180, 180)))
    elif how == "turned":
        shape = shape.rotate(tuple(rng.normal(size=3).tolist()), float(rng.uniform(-180, 180)))
    elif how == "scaled":
        shape = shape.scale(tuple(rng.uniform(0.5, 2, 3).tolist()))
    return shape.translate(to)


def moved_bodies() -> None:
    import conicoid as co

    print("| a body | alike | by | all different | by |\n|---|---|---|---|---|")
    for name, make in bodies().items():
        cells = []
        for alike in (True, False):
            worst = (0.0, "")
            for how in ("moved", "rolled", "turned", "scaled"):
                spent = []
                for run in range(RUNS):
                    rng = np.random.default_rng(run)
                    one = make(rng)
                    scene = co.Scene([placed(one if alike else make(rng), how, rng) for _ in range(BODIES)])
                    begin = time.process_time()
                    scene.prepare()
                    spent.append(time.process_time() - begin)
                worst = max(worst, (1e6 * min(spent[1:]) / BODIES, how))
            cells += [f"{worst[0]:.0f}", worst[1]]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", action="store_true", help="bodies under motions instead of files")
    if parser.parse_args().bodies:
        moved_bodies()
        return
    with tempfile.TemporaryDirectory() as folder:
        files(Path(folder))


if __name__ == "__main__":
    sys.exit(main())
