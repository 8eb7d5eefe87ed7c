"""Files of other programs with 10^5 placed volumes: how long they take to open and to be prepared, and the memory.

    python benchmarks/imports.py [VOLUMES]

Seconds of the clock and GiB at most of a process of its own for each file, after a small scene that is not counted:

- nested: GDML of four volumes, rows of pads in modules in a hall, VOLUMES of them from few hundred lines;
- listed: GDML with an element for each of VOLUMES pads, a thousand in a plane;
- universes: an MCNP deck of rods in a lattice of lattices;
- a tenth of the first two, to be compared with them: what a file takes follows what is written in it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = """
import sys, time, resource
import conicoid as co
co.Scene([co.Sphere(1)]).first_hit((0, 0, -9), (0, 0, 1))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
begin = time.perf_counter()
scene = co.load(sys.argv[1])
read = time.perf_counter()
opened = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
scene._prepared
ready = time.perf_counter()
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(len(scene.bodies), read - begin, ready - read, (opened - before) / 2**10, peak / 2**20)
"""
HEAD = """<?xml version="1.0"?>
<gdml><materials>
<material name="air" state="gas"><D value="0.0012"/></material><material name="silicon"><D value="2.33"/></material>
<material name="tungsten"><D value="19.3"/></material></materials>
"""
END = '<setup name="Default" version="1.0"><world ref="world"/></setup></gdml>\n'


def placed(name: str, volume: str, axis: str, pitch: float, count: int, also: str = "") -> str:
    """A row of placements about the middle."""
    return "".join(
        f'<physvol name="{name}" copynumber="{k}"><volumeref ref="{volume}"/>'
        f'<position {axis}="{pitch * (k - (count - 1) / 2):.3f}"{also}/></physvol>\n'
        for k in range(count)
    )


def volume(name: str, material: str, solid: str, inside: str = "") -> str:
    """A volume's element."""
    return f'<volume name="{name}"><materialref ref="{material}"/><solidref ref="{solid}"/>\n{inside}</volume>\n'


def nested(count: int) -> str:
    """100 pads in a row, 100 rows in a module, as many modules as there must be."""
    modules = max(1, count // 10_100)
    solids = (
        '<box name="pad" x="4" y="4" z="4"/><box name="row" x="501" y="5" z="5"/>'
        f'<box name="module" x="502" y="602" z="6"/><box name="hall" x="600" y="700" z="{7 * modules + 9}"/>'
    )
    return HEAD + f"<solids>{solids}</solids><structure>" + (
        volume("pad", "silicon", "pad")
        + volume("row", "tungsten", "row", placed("pad", "pad", "x", 5, 100))
        + volume("module", "tungsten", "module", placed("row", "row", "y", 6, 100))
        + volume("world", "air", "hall", placed("module", "module", "z", 7, modules))
    ) + "</structure>" + END  # fmt: skip


def listed(count: int) -> str:
    """A thousand pads in each of some planes, every pad with an element of its own."""
    planes = max(1, count // 1000)
    solids = '<box name="pad" x="4" y="4" z="2"/><box name="plane" x="201" y="127" z="3"/>'
    solids += f'<box name="hall" x="300" y="300" z="{4 * planes + 4}"/>'
    text = volume("pad", "silicon", "pad")
    for k in range(planes):
        pads = "".join(placed("pad", "pad", "x", 5, 40, f' y="{5 * j - 60}"') for j in range(25))
        text += volume(f"plane{k}", "tungsten", "plane", pads)
    inside = "".join(
        f'<physvol copynumber="{k}"><volumeref ref="plane{k}"/><position z="{4 * k - 2 * planes}"/></physvol>'
        for k in range(planes)
    )
    return (
        HEAD + f"<solids>{solids}</solids><structure>" + text + volume("world", "air", "hall", inside)
        + "</structure>" + END
    )  # fmt: skip


def universes(count: int) -> str:
    """17 x 17 rods of three cells in an assembly, and as many assemblies in a square as there must be."""
    side = max(1, round((count / 867) ** 0.5))
    low, half = -(side // 2), 10.71
    return f"""rods in assemblies in a core
1 1 -10.4 -1 u=1 imp:n=1
2 2 -6.5 1 -2 u=1 imp:n=1
3 3 -0.7 2 u=1 imp:n=1
4 0 -4 u=2 lat=1 fill=-8:8 -8:8 0:0 1 288r imp:n=1
5 0 -5 u=3 lat=1 fill={low}:{low + side - 1} {low}:{low + side - 1} 0:0 2 {side * side - 1}r imp:n=1
6 0 -6 fill=3 imp:n=1
7 0 6 imp:n=0

1 cz 0.41
2 cz 0.475
4 rpp -0.63 0.63 -0.63 0.63 -180 180
5 rpp -{half} {half} -{half} {half} -180 180
6 rpp {(2 * low - 1) * half:.2f} {(2 * (low + side) - 1) * half:.2f} {(2 * low - 1) * half:.2f} """ + (
        f"{(2 * (low + side) - 1) * half:.2f} -180 180\n\nm1 92238 1 8016 2\nm2 40000 1\nm3 1001 2 8016 1\n"
    )


def main() -> None:
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000
    cases = {
        "nested.gdml": nested(count), "nested, a tenth.gdml": nested(count // 10), "listed.gdml": listed(count),
        "listed, a tenth.gdml": listed(count // 10), "universes.mcnp": universes(count),
    }  # fmt: skip
    print("                           KB   bodies     open  prepare   MiB to open   GiB at most")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in cases.items():
            path = Path(folder) / name
            path.write_text(text, encoding="utf-8")
            done = subprocess.run(
                [sys.executable, "-c", PROGRAM, str(path)], capture_output=True, text=True, check=True
            )
            bodies, opened, prepared, memory, peak = map(float, done.stdout.split())
            size = len(text) / 1000
            print(
                f"{name:<21}{size:8,.0f}{bodies:9,.0f}{opened:7.2f} s{prepared:7.2f} s{memory:14.0f}{peak:14.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
