"""POV-Ray 3.7: pictures of spheres, clipped quadrics and Boolean solids, one shadowed light, no antialiasing.

Its axes are left-handed, so its picture is the mirror image of ours. The time is the trace time that it prints:
parsing is not in it.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
from PIL import Image

from ..engine.threads import thread_count
from .peer import Absent, Peer
from .scenes import Balls, Floats

HEADER = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 4 }
camera { location <0,0,-3> direction <0,0,1> right x up y }
light_source { <3,4,-5> rgb 1 }
#declare T = texture { pigment { rgb 0.8 } finish { ambient 0.1 diffuse 0.8 } };
"""
OBJECTS = {
    "spheres": "sphere {{ {c}, {r} texture {{ T }} }}",
    "quadrics": (
        "quadric {{ <1,1,1>,<0,0,0>,<0,0,0>,-1 clipped_by {{ box {{ -1.01, 1.01 }} }}"
        " bounded_by {{ clipped_by }} scale {r} translate {c} texture {{ T }} }}"
    ),
    "csg": (
        "difference {{ intersection {{ sphere {{ 0, 1 }} box {{ -0.75, 0.75 }} }}"
        " cylinder {{ -x, x, 0.4 }} cylinder {{ -y, y, 0.4 }} cylinder {{ -z, z, 0.4 }}"
        " scale {r} translate {c} texture {{ T }} }}"
    ),
}


def _version() -> str:
    program = shutil.which("povray")
    if program is None:
        raise Absent("not installed: apt-get install povray (Debian), brew install povray (macOS)")
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    found = re.search(r"POV-Ray ([\d.]*\d)", done.stderr + done.stdout)
    return f"POV-Ray {found.group(1) if found else 'of unknown version'}"


PEER = Peer("POV-Ray", "trace time", _version)


def write_scene(path: Path, kind: str, balls: Balls) -> None:
    """A scene file with an object of a kind in the place of each ball."""
    lines = [
        OBJECTS[kind].format(c=f"<{c[0]!r},{c[1]!r},{c[2]!r}>", r=repr(r))
        for c, r in zip(balls.centers.astype(float).tolist(), balls.radii.astype(float).tolist(), strict=True)
    ]
    path.write_text(HEADER + "\n".join(lines) + "\n")


def picture(scene: Path, width: int) -> tuple[float, Floats]:
    """(trace time in seconds, brightness (width, width) in [0, 1], mirrored to be like ours)."""
    target = scene.with_suffix(".png")
    options = [f"+W{width}", f"+H{width}", "-A", "-D", f"+WT{thread_count()}", f"+O{target}"]
    done = subprocess.run(["povray", f"+I{scene}", *options], capture_output=True, text=True, check=False)
    found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
    if done.returncode or found is None:
        lines = done.stderr.strip().splitlines()
        raise Absent(f"POV-Ray ended with {done.returncode}: {lines[-1] if lines else 'it said nothing'}")
    with Image.open(target) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)[:, ::-1]
    return float(found.group(1)), pixels.max(axis=-1) / 255
