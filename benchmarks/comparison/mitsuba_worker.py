"""Mitsuba's process: balls and rays from a file; for each line on its input one run, and its seconds as an answer."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np


def main(folder: Path) -> None:
    """Load scene.npz, answer; write t.npy after the first run."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    with np.load(folder / "scene.npz") as data:
        given = {name: data[name] for name in data.files}
    dr.set_thread_count(int(given["threads"]))
    listed: dict[str, Any] = {"type": "scene"}
    for i, (center, radius) in enumerate(zip(given["centers"].tolist(), given["radii"].tolist(), strict=True)):
        listed[f"s{i}"] = {"type": "sphere", "center": center, "radius": radius}
    scene: Any = mi.load_dict(listed)
    rows = [np.ascontiguousarray(given[name].T) for name in ("origins", "directions")]
    _say("ready")
    for run, _ in enumerate(sys.stdin):
        ray = mi.Ray3f(mi.Point3f(rows[0]) + run * 1e-9, mi.Vector3f(rows[1]))  # a new one: results are not remembered
        dr.eval(ray)
        dr.sync_thread()
        begin = time.perf_counter()
        t = np.array(scene.ray_intersect_preliminary(ray, coherent=bool(given["coherent"])).t)
        seconds = time.perf_counter() - begin
        if run == 0:
            np.save(folder / "t.npy", t)
        _say(str(seconds))


def _say(answer: str) -> None:
    sys.stdout.write(f"answer {answer}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
