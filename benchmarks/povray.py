"""One picture, by Conicoid and by POV-Ray 3.7: many solids, one shadowed light, no antialiasing.

    python benchmarks/povray.py [sphere|quadric|csg] [count] [width]

`csg` is (sphere & box) - three bores: five leaves each. POV-Ray must be on the path; its axes are
left-handed, so its picture is the mirror image. The two are run in turn, five times each; printed
are the medians of POV-Ray's own trace time and of the wall time of `scene.render`, and how the
pictures differ.
"""

from __future__ import annotations

import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import conicoid as co
from conicoid.trace.threads import thread_count

HEADER = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 4 }
camera { location <0,0,-3> direction <0,0,1> right x up y }
light_source { <3,4,-5> rgb 1 }
#declare T = texture { pigment { rgb 0.8 } finish { ambient 0.1 diffuse 0.8 } };
"""
OBJECTS = {
    "sphere": "sphere {{ {c}, {r} texture {{ T }} }}",
    "quadric": (
        "quadric {{ <1,1,1>,<0,0,0>,<0,0,0>,-1 clipped_by {{ box {{ -1.01, 1.01 }} }}"
        " bounded_by {{ clipped_by }} scale {r} translate {c} texture {{ T }} }}"
    ),
    "csg": (
        "difference {{ intersection {{ sphere {{ 0, 1 }} box {{ -0.75, 0.75 }} }}"
        " cylinder {{ -x, x, 0.4 }} cylinder {{ -y, y, 0.4 }} cylinder {{ -z, z, 0.4 }}"
        " scale {r} translate {c} texture {{ T }} }}"
    ),
}


def solids(kind: str, centers: np.ndarray, radii: np.ndarray) -> list[co.Solid]:
    if kind == "sphere":
        return [co.Sphere(r, c) for r, c in zip(radii, centers, strict=True)]
    if kind == "quadric":
        return [co.Ellipsoid((r, r, r), c, z_range=(-1.01 * r, 1.01 * r)) for r, c in zip(radii, centers, strict=True)]
    block = co.Sphere(1) & co.Box((-0.75, -0.75, -0.75), (0.75, 0.75, 0.75))
    for axis in np.eye(3):
        block = block - co.Cylinder(-axis, axis, 0.4)
    return [block.scale(r).translate(c) for r, c in zip(radii, centers, strict=True)]


def povray(kind: str, centers: np.ndarray, radii: np.ndarray, width: int, folder: Path) -> tuple[float, Path]:
    """(trace time in seconds, picture)"""
    lines = [
        OBJECTS[kind].format(c=f"<{c[0]!r},{c[1]!r},{c[2]!r}>", r=repr(r))
        for c, r in zip(centers.tolist(), radii.tolist(), strict=True)
    ]
    scene = folder / "scene.pov"
    scene.write_text(HEADER + "\n".join(lines) + "\n")
    picture = folder / "scene.png"
    done = subprocess.run(
        ["povray", f"+I{scene}", f"+W{width}", f"+H{width}", "-A", "-D", f"+WT{thread_count()}", f"+O{picture}"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
    return float(found.group(1)) if found else float("nan"), picture


def main() -> None:
    kind = sys.argv[1] if len(sys.argv) > 1 else "csg"
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    width = int(sys.argv[3]) if len(sys.argv) > 3 else 1024
    if shutil.which("povray") is None:
        sys.exit("povray is not installed (Debian: apt-get install povray)")
    rng = np.random.default_rng(0)
    centers = rng.random((count, 3)) * 2 - 1
    radii = (rng.random(count) * 0.5 + 0.5) * 0.6 / count ** (1 / 3)
    material = co.matte((0.8, 0.8, 0.8), ambient=1.0, diffuse=0.8)
    scene = co.Scene(
        [co.Body(solid, material) for solid in solids(kind, centers, radii)],
        lights=[co.PointLight((3, 4, -5)), co.AmbientLight(0.1)],
        # right-handed: x to the left, so that the picture is POV-Ray's mirrored
        camera=co.Camera((0, 0, -3), (0, 0, 0), up=(0, 1, 0), field_of_view=2 * np.degrees(np.arctan(0.5))),
        background=(0, 0, 0),
    )
    scene.render(32, 32, samples=1)
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as name:
        for _ in range(5):
            begin = time.perf_counter()
            image = scene.render(width, width, samples=1)
            ours.append(time.perf_counter() - begin)
            seconds, picture = povray(kind, centers, radii, width, Path(name))
            theirs.append(seconds)
        from PIL import Image

        reference = np.asarray(Image.open(picture).convert("RGB"), dtype=float)[:, ::-1]
    image.save(f"{kind}.png") if "--save" in sys.argv else None
    mine = image.pixels
    hit = (mine.max(axis=-1) > 0) == (reference.max(axis=-1) > 0)
    a, b = statistics.median(ours), statistics.median(theirs)
    print(f"{count} {kind}, {width} x {width}, {thread_count()} threads: Conicoid {a:.3f} s, POV-Ray {b:.3f} s, ")
    print(f"POV-Ray / Conicoid {b / a:.2f}; the same pixels are lit or dark: {hit.mean():.5f}")


if __name__ == "__main__":
    main()
