"""What else is known of each pixel than its light: what is seen there, how far, how sure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..film.sums import COUNT, errors_of
from .picture import Exposed, Job, render


def layers_of(scene: Any, job: Job, names: tuple[str, ...], exposed: Exposed) -> dict[str, Any]:
    """Name -> array, of the layers of a picture."""
    found: dict[str, Any] = {}
    if "albedo" in names:
        found["albedo"] = render(
            scene, replace(job, integrator="albedo", noise=None, samples=min(job.samples, 64))
        ).film
    if exposed.sums is not None:
        found["samples"] = exposed.sums[..., COUNT].astype(np.int32)
        found["error"] = errors_of(exposed.sums).astype(np.float32)
    if {"normal", "depth", "position", "body"} & set(names):
        hits = scene.first_hit(job.view.rays(job.width, job.height))
        found["normal"] = np.nan_to_num(np.asarray(hits.normal)).astype(np.float32)
        found["depth"] = np.asarray(hits.t).astype(np.float32)
        found["position"] = np.asarray(hits.point).astype(np.float32)
        found["body"] = hits.body
    return {name: found[name] for name in names}
