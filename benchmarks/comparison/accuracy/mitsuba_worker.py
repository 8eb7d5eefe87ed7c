"""Mitsuba's process: first hits of rays in scenes of one body each, from files of a folder to t.npy beside them."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np


def main(folder: Path) -> None:
    """scenes.json holds lists of shapes, rays.npz the float32 rays (N, 3) of all scenes and how many are of each."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    with np.load(folder / "rays.npz") as data:
        ends = np.cumsum(data["counts"])[:-1]
        origins, directions = (np.split(data[name], ends) for name in ("origins", "directions"))
    scenes = json.loads((folder / "scenes.json").read_text())
    found = []
    for shapes, o, d in zip(scenes, origins, directions, strict=True):
        listed: dict[str, Any] = {"type": "scene"}
        for k, shape in enumerate(shapes):
            if "to_world" in shape:
                shape["to_world"] = mi.ScalarTransform4f(shape["to_world"])
            listed[f"s{k}"] = shape
        scene: Any = mi.load_dict(listed)
        ray = mi.Ray3f(mi.Point3f(np.ascontiguousarray(o.T)), mi.Vector3f(np.ascontiguousarray(d.T)))
        found.append(np.array(scene.ray_intersect_preliminary(ray).t))
    np.save(folder / "t.npy", np.concatenate(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
